// Plots over time with one cursor.
const PALETTE = ["#2f81d6", "#e06c1f", "#1f9d76", "#a45bd0", "#c9a227", "#d1495b", "#4aa3a2", "#8b6f5c"];

/// What is drawn: title, unit, and lines of name and quantity.
function charts(about) {
  const xyz = (name) => ["x", "y", "z"].map((axis, index) => [axis, name, index]);
  const joints = (name) => about.joints.map((joint, index) => [joint, name, index]);
  const residuals = { title: "Contact residuals", unit: "", log: true, lines: [["natural map", "residual", 0], ["Signorini", "residual", 1]] };
  const charts = about.driven ? [
    { title: "Centre of gravity, sideways", unit: "m", lines: [["y", "com", 1], ["ZMP y", "zmp", 1]] },
    { title: "Lateral energy E₂", unit: "m²/s²", lines: [["E₂", "energy", 1], ["reference", "reference", 1]] },
    { title: "Torques", unit: "N·m", lines: joints("torque") },
    residuals,
    { title: "Commands", unit: "ms", lines: [["age", "age", 0], ["reply", "reply", 0], ["late", "late", 0]] },
  ] : [
    { title: "Centre of gravity", unit: "m", lines: xyz("com") },
    { title: "Its velocity", unit: "m/s", lines: xyz("velocity") },
    { title: "Force of the ground", unit: "N", lines: xyz("ground") },
    residuals,
    { title: "Joints", unit: "rad, m", lines: joints("angle") },
  ];
  return charts.filter((chart) => chart.lines.length > 0);
}

/// Looks of an axis.
const AXIS = { stroke: () => colour("soft"), grid: { stroke: () => colour("grid"), width: 1 }, ticks: { show: false }, font: "11px system-ui" };

/// Labels with as many decimals as tell ticks apart.
function labels(_, ticks, axis, space, increment) {
  const isWhole = (number) => Math.abs(number - Math.round(number)) < 1e-6 * number;
  let decimals = 0;
  while (decimals < 12 && !isWhole(increment * 10 ** decimals)) decimals++;
  return ticks.map((tick) => (tick === null ? null : (tick || 0).toFixed(decimals)));
}

/// Room for the labels of an axis across [px], in strides: what changes it lays out the plot anew.
const room = (_, labels) => Math.max(48, 16 * Math.ceil((12 + 6.5 * Math.max(...(labels ?? [""]).map((label) => (label ?? "").length))) / 16));

/// A range no narrower than rounding, or than a part of what it is around.
function range(least) {
  return (_, low, high) => {
    if (low === null) return [0, 1];
    const lack = Math.max(least, 1e-6 * Math.abs(low + high)) - (high - low), margin = Math.max(lack / 2, 0);
    return [low - margin, high + margin];
  };
}

const MOMENT = .01; // the shortest time that fills a plot [s]
const FINEST = 1e-4; // the smallest difference that does [SI]

/// A logarithmic axis, marked at every third power of ten, or at every one if there are few.
const POWERS = {
  scale: { distr: 3, range: (_, low, high) => [Math.max(1e-18, (low || 1e-16) / 4), Math.max((high || 1e-12) * 4, 1e-12)] },
  axis: {
    filter: (_, ticks) => ticks,
    splits: (_, axis, low, high) => {
      const few = high / low < 1e7 ? 1 : 3;
      return Array.from({ length: 36 / few }, (_, index) => 10 ** (few * index - 24)).filter((tick) => low <= tick && tick <= high);
    },
    values: (_, ticks) => ticks.map((tick) => `1e${Math.round(Math.log10(tick))}`),
  },
};

class Plots {
  constructor(place, about, film, player) {
    Object.assign(this, { film, player });
    this.scale = { age: 1e3 * about.period };
    this.panels = charts(about).map((chart) => this.panel(place, chart));
    if (about.feet.length === 2) this.portrait = new Portrait(place, film);
    this.fill(0);
    const { begin, end } = film; // of a long run the beginning; a double click shows all
    if (end - begin > 60) this.panels.forEach(({ plot }) => plot.setScale("x", { min: begin, max: begin + 20 }));
    whenThemed(() => this.panels.forEach(({ plot }) => plot.redraw(false)));
  }

  panel(place, { title, unit, lines, log }) {
    const frame = place.appendChild(document.createElement("figure"));
    const caption = frame.appendChild(document.createElement("h3"));
    caption.appendChild(document.createElement("b")).textContent = unit ? `${title} [${unit}]` : title;
    const isMany = lines.length > 4;
    let row = caption, side;
    const values = lines.map(([name], index) => {
      const its = isMany ? /^(left|right) /.exec(name)?.[1] : undefined;
      if (isMany && (index === 0 || its !== side)) { // a row for each side, which it begins with
        row = caption.appendChild(document.createElement("div"));
        if (its) row.appendChild(document.createElement("em")).textContent = its[0].toUpperCase();
      }
      side = its;
      const key = row.appendChild(document.createElement("span"));
      key.style.color = PALETTE[index % PALETTE.length];
      key.title = name;
      return { key, name: side ? name.slice(side.length + 1) : name };
    });
    const box = frame.appendChild(document.createElement("div"));
    const plot = new uPlot({
      width: 300, height: 120, legend: { show: false }, padding: [6, 22, 0, 0],
      cursor: { sync: { key: "time" }, points: { show: false }, drag: { x: true, y: false } },
      scales: { x: { time: false, range: range(MOMENT) }, y: log ? POWERS.scale : { range: (plot, low, high) => uPlot.rangeNum(...range(FINEST)(plot, low, high), .1, true) } },
      axes: [{ ...AXIS, size: 22, values: labels }, { ...AXIS, size: room, space: 24, values: labels, ...(log ? POWERS.axis : {}) }],
      series: [{}, ...lines.map(([name], index) => ({ label: name, stroke: PALETTE[index % PALETTE.length], width: 1.2, points: { show: false }, dash: name === "reference" ? [5, 4] : undefined }))],
      hooks: {
        setCursor: [({ cursor }) => this.hover?.(cursor.left < 0 ? undefined : plot?.posToVal(cursor.left, "x"))],
        setSelect: [({ select }) => { if (select.width > 0 && this.player.isFollowing) this.player.play(false); }], // it stays where it is looked at
        draw: [(drawn) => this.place(this.panels?.find(({ plot }) => plot === drawn))],
      },
    }, [[0, 1], ...lines.map(() => [1, 1])], box);
    const [head, fall] = ["head", "fall"].map((name) => {
      const mark = plot.over.appendChild(document.createElement("div"));
      mark.className = name;
      return mark;
    });
    plot.over.addEventListener("click", ({ detail }) => {
      if (plot.select.width >= 3) return; // a drag
      if (detail === 1) this.player.point(plot.posToVal(plot.cursor.left, "x"));
      if (detail === 2) this.player.unpoint();
    });
    new ResizeObserver(() => { plot.setSize({ width: box.clientWidth, height: box.clientHeight }); this.show(this.time); }).observe(box);
    return { plot, lines, values, log, head, fall };
  }

  /// Takes what the film has from a row on.
  fill(from) {
    if (this.film.length === 0) { // uPlot wants something to measure its axes by
      this.panels.forEach(({ plot, lines }) => plot.setData([[0, 1], ...lines.map(() => [1, 1])]));
      return;
    }
    const times = this.film.column("time", 0, from), step = times.at(-1) - times.at(-2);
    const isGap = (row) => times[row] - times[row - 1] > 20 * step; // frames that a slow browser missed
    this.panels.forEach(({ plot, lines, log }) => {
      const columns = lines.map(([, name, index]) => {
        const scale = this.scale[name] ?? 1;
        return this.film.column(name, index, from).map((value, row) => Number.isFinite(value) && !(log && value <= 0) && !isGap(row) ? scale * value : null);
      });
      plot.setData([times, ...columns]);
    });
    this.end = times.at(-1);
    this.portrait?.fill(from);
  }

  /// Marks a time in every plot; a plot moves along once the time leaves what it shows, as far as there is anything to see.
  show(time) {
    if (time === undefined || this.film.length === 0) return;
    const before = this.time;
    this.time = time;
    this.panels.forEach((panel) => {
      const { plot } = panel, { min, max } = plot.scales.x;
      const leaves = (time < min || time > max && time <= this.end) && !(before < min || before > max);
      if (leaves) plot.setScale("x", { min: time - .1 * (max - min), max: time + .9 * (max - min) });
      this.place(panel);
    });
    this.tell(time);
    this.portrait?.show(time);
  }

  /// Puts the marks of a plot where its scale has their times.
  place(panel) {
    if (!panel) return;
    const { plot, head, fall } = panel, at = (time) => `translateX(${plot.valToPos(time, "x")}px)`;
    head.hidden = this.time === undefined;
    if (!head.hidden) head.style.transform = at(this.time);
    fall.hidden = this.film.fall === undefined;
    if (!fall.hidden) fall.style.transform = at(this.film.fall);
  }

  /// Writes the values at a time beside their names.
  tell(time) {
    const row = this.film.row(time);
    this.panels.forEach(({ lines, values, log }) => lines.forEach(([, quantity, index], line) => {
      const value = (this.scale[quantity] ?? 1) * this.film.get(row, quantity, index);
      const isTight = lines.length > 4;
      const number = !Number.isFinite(value) ? "–" : log ? value.toExponential(0) : value.toFixed(Math.abs(value) < 1 && !isTight ? 3 : 1);
      values[line].key.textContent = `${values[line].name} ${number}`;
    }));
  }
}
