// Plots over time with a common cursor.
const PALETTE = ["#2f81d6", "#e06c1f", "#1f9d76", "#a45bd0", "#c9a227", "#d1495b", "#4aa3a2", "#8b6f5c"];

// The plots: title, unit, and lines (name, quantity, component).
function charts(runInfo) {
  const xyz = (name) => ["x", "y", "z"].map((axis, index) => [axis, name, index]);
  const joints = (name) => runInfo.joints.map((joint, index) => [joint, name, index]);
  const residuals = { title: "Contact residuals", unit: "", log: true, lines: [["natural map", "residual", 0], ["Signorini", "residual", 1]] };
  const charts = runInfo.driven ? [
    { title: "Centre of gravity, sideways", unit: "m", lines: [["y", "com", 1], ["ZMP y", "zmp", 1]] },
    { title: "Lateral energy E₂", unit: "m²/s²", lines: [["E₂", "energy", 1], ["reference", "reference", 1]] },
    { title: "Torques", unit: "N·m", lines: joints("torque") },
    residuals,
    { title: "Commands", unit: "ms", range: fromZero, lines: [["age", "age", 0], ["reply", "reply", 0], ["late", "late", 0]] },
  ] : [
    { title: "Centre of gravity", unit: "m", lines: xyz("com") },
    { title: "Its velocity", unit: "m/s", lines: xyz("velocity") },
    { title: "Force of the ground", unit: "N", lines: xyz("ground") },
    residuals,
    { title: "Joints", unit: "rad, m", lines: joints("angle") },
  ];
  return charts.filter((chart) => chart.lines.length > 0);
}

// Style of an axis.
const AXIS = { stroke: () => colour("soft"), grid: { stroke: () => colour("grid"), width: 1 }, ticks: { show: false }, font: "11px system-ui" };

// Labels with as many decimals as are necessary to distinguish the ticks.
function labels(_, ticks, axis, space, increment) {
  const isWhole = (number) => Math.abs(number - Math.round(number)) < 1e-6 * number;
  let decimals = 0;
  while (decimals < 12 && !isWhole(increment * 10 ** decimals)) decimals++;
  return ticks.map((tick) => (tick === null ? null : (tick || 0).toFixed(decimals)));
}

// Width of the labels of a vertical axis [px]. It changes in steps, because each change lays out the plot again.
const axisWidth = (_, labels) => Math.max(48, 16 * Math.ceil((12 + 6.5 * Math.max(...(labels ?? [""]).map((label) => (label ?? "").length))) / 16));

// A range that is at least `least` wide and wide compared with the resolution of 32-bit floats.
function range(least) {
  return (_, low, high) => {
    if (low === null) return [0, 1];
    const lack = Math.max(least, 1e-6 * Math.abs(low + high)) - (high - low), margin = Math.max(lack / 2, 0);
    return [low - margin, high + margin];
  };
}

// A range from zero to a little more than the greatest value, for times that are never negative.
const fromZero = (_, low, high) => [0, 1.1 * Math.max(high ?? 0, MIN_COMMAND_SPAN)];

const MIN_TIME_SPAN = .01; // shortest time axis [s]
const MIN_VALUE_SPAN = 1e-4; // shortest value axis [SI unit]
const MIN_COMMAND_SPAN = .1; // shortest axis of the times of commands [ms]
const INITIAL_SPAN = 20; // time axis at first, if the run is longer than `LONG_RUN` [s]
const LONG_RUN = 60; // [s]
const GAP = 20; // a line is interrupted where rows are farther apart than this many times their usual spacing
const CLICK_WIDTH = 3; // a wider selection is a drag and no click [px]

// A logarithmic axis with a tick at every third power of ten, or at every power on a short axis.
const POWERS = {
  scale: { distr: 3, range: (_, low, high) => [Math.max(1e-18, (low || 1e-16) / 4), Math.max((high || 1e-12) * 4, 1e-12)] },
  axis: {
    filter: (_, ticks) => ticks,
    splits: (_, axis, low, high) => {
      const decadesPerTick = high / low < 1e7 ? 1 : 3;
      return Array.from({ length: 36 / decadesPerTick }, (_, index) => 10 ** (decadesPerTick * index - 24)).filter((tick) => low <= tick && tick <= high);
    },
    values: (_, ticks) => ticks.map((tick) => `1e${Math.round(Math.log10(tick))}`),
  },
};

class Plots {
  constructor(container, runInfo, trajectory, player) {
    Object.assign(this, { trajectory, player });
    this.scale = { age: 1e3 * runInfo.period };
    this.panels = charts(runInfo).map((chart) => this.panel(container, chart));
    if (runInfo.feet.length === 2) this.portrait = new PhasePortrait(container, trajectory);
    this.fill(0);
    const { begin, end } = trajectory; // a long run is shown from its beginning; a double click shows all of it
    if (end - begin > LONG_RUN) this.panels.forEach(({ plot }) => plot.setScale("x", { min: begin, max: begin + INITIAL_SPAN }));
    whenThemed(() => this.panels.forEach(({ plot }) => plot.redraw(false)));
  }

  panel(container, { title, unit, lines, log, range: ownRange }) {
    const frame = container.appendChild(document.createElement("figure"));
    const caption = frame.appendChild(document.createElement("h3"));
    caption.appendChild(document.createElement("b")).textContent = unit ? `${title} [${unit}]` : title;
    const isMany = lines.length > 4;
    let row = caption, side;
    const values = lines.map(([name], index) => {
      const sideOfLine = isMany ? /^(left|right) /.exec(name)?.[1] : undefined;
      if (isMany && (index === 0 || sideOfLine !== side)) { // a row per side, which begins with its initial
        row = caption.appendChild(document.createElement("div"));
        if (sideOfLine) row.appendChild(document.createElement("em")).textContent = sideOfLine[0].toUpperCase();
      }
      side = sideOfLine;
      const key = row.appendChild(document.createElement("span"));
      key.style.color = PALETTE[index % PALETTE.length];
      key.title = name;
      return { key, name: side ? name.split(" ").at(-1) : name }; // "left ankle roll" is "roll" in the row of its side
    });
    const box = frame.appendChild(document.createElement("div"));
    const plot = new uPlot({
      width: 300, height: 120, legend: { show: false }, padding: [6, 22, 0, 0],
      cursor: { sync: { key: "time" }, points: { show: false }, drag: { x: true, y: false } },
      scales: { x: { time: false, range: range(MIN_TIME_SPAN) }, y: log ? POWERS.scale : { range: ownRange ?? ((plot, low, high) => uPlot.rangeNum(...range(MIN_VALUE_SPAN)(plot, low, high), .1, true)) } },
      axes: [{ ...AXIS, size: 22, values: labels, label: "t [s]", labelFont: AXIS.font, labelSize: 13, labelGap: 0 }, { ...AXIS, size: axisWidth, space: 24, values: labels, ...(log ? POWERS.axis : {}) }],
      series: [{}, ...lines.map(([name], index) => ({ label: name, stroke: PALETTE[index % PALETTE.length], width: 1.2, points: { show: false }, dash: name === "reference" ? [5, 4] : undefined }))],
      hooks: {
        setCursor: [({ cursor }) => this.hover?.(cursor.left < 0 ? undefined : plot?.posToVal(cursor.left, "x"))],
        setSelect: [({ select }) => { if (select.width > 0 && this.player.isFollowing) this.player.play(false); }], // a zoomed plot does not follow the session
        draw: [(drawn) => this.positionMarks(this.panels?.find(({ plot }) => plot === drawn))],
      },
    }, [[0, 1], ...lines.map(() => [1, 1])], box);
    const [head, fall] = ["head", "fall"].map((name) => {
      const mark = plot.over.appendChild(document.createElement("div"));
      mark.className = name;
      return mark;
    });
    plot.over.addEventListener("click", ({ detail }) => {
      if (plot.select.width >= CLICK_WIDTH) return;
      if (detail === 1) this.player.jump(plot.posToVal(plot.cursor.left, "x"));
      if (detail === 2) this.player.undoJump();
    });
    new ResizeObserver(() => plot.setSize({ width: box.clientWidth, height: box.clientHeight })).observe(box); // marks follow when it draws
    return { plot, lines, values, log, head, fall };
  }

  // Loads the rows from `from` on.
  fill(from) {
    if (this.trajectory.length === 0) { // uPlot needs data to lay out its axes
      this.panels.forEach(({ plot, lines }) => plot.setData([[0, 1], ...lines.map(() => [1, 1])]));
      return;
    }
    const times = this.trajectory.column("time", 0, from), step = times.at(-1) - times.at(-2);
    const isGap = (row) => times[row] - times[row - 1] > GAP * step; // a slow browser misses frames
    this.panels.forEach(({ plot, lines, log }) => {
      const columns = lines.map(([, name, index]) => {
        const scale = this.scale[name] ?? 1;
        return this.trajectory.column(name, index, from).map((value, row) => Number.isFinite(value) && !(log && value <= 0) && !isGap(row) ? scale * value : null);
      });
      plot.setData([times, ...columns]);
    });
    this.end = times.at(-1);
    this.portrait?.fill(from);
  }

  // Marks a time in every plot. A plot scrolls when the time leaves its visible range and there are data to show.
  show(time) {
    if (time === undefined || this.trajectory.length === 0) return;
    const before = this.time;
    this.time = time;
    this.panels.forEach((panel) => {
      const { plot } = panel, { min, max } = plot.scales.x;
      const leaves = (time < min || time > max && time <= this.end) && !(before < min || before > max);
      if (leaves) plot.setScale("x", { min: time - .1 * (max - min), max: time + .9 * (max - min) });
      this.positionMarks(panel);
    });
    this.showValues(time);
    this.portrait?.show(time);
  }

  // Positions the marks of the current time and of the fall in a plot.
  positionMarks(panel) {
    if (!panel) return;
    const { plot, head, fall } = panel, at = (time) => `translateX(${plot.valToPos(time, "x")}px)`;
    head.hidden = this.time === undefined;
    if (!head.hidden) head.style.transform = at(this.time);
    fall.hidden = this.trajectory.fall === undefined;
    if (!fall.hidden) fall.style.transform = at(this.trajectory.fall);
  }

  // Shows the values at a time beside the names of the lines.
  showValues(time) {
    const row = this.trajectory.row(time);
    this.panels.forEach(({ lines, values, log }) => lines.forEach(([, quantity, index], line) => {
      const value = (this.scale[quantity] ?? 1) * this.trajectory.get(row, quantity, index);
      const isTight = lines.length > 4;
      const number = !Number.isFinite(value) ? "–" : log ? value.toExponential(0) : value.toFixed(Math.abs(value) < 1 && !isTight ? 3 : 1);
      values[line].key.textContent = `${values[line].name} ${number}`;
    }));
  }
}
