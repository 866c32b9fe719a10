// Plots over time with one cursor, and the lateral plane as a phase portrait.
const PALETTE = ["#2f81d6", "#e06c1f", "#1f9d76", "#a45bd0", "#c9a227", "#d1495b", "#4aa3a2", "#8b6f5c"];

/// What is drawn: title, unit, and lines of name and quantity.
function charts(about) {
  const charts = [
    { title: "Centre of gravity, sideways", unit: "m", lines: [["y", "com", 1], ["ZMP y", "zmp", 1]] },
    { title: "Lateral energy E₂", unit: "m²/s²", lines: [["E₂", "energy", 1], ["reference", "reference", 1]] },
    { title: "Torques", unit: "N·m", lines: about.joints.map((joint, index) => [joint, "torque", index]) },
    { title: "Contact residuals", unit: "", log: true, lines: [["natural map", "residual", 0], ["Signorini", "residual", 1]] },
    { title: "Commands", unit: "ms", lines: [["age", "age", 0], ["reply", "reply", 0], ["late", "late", 0]] },
  ];
  return charts.filter((chart) => chart.lines.length > 0);
}

/// Looks of an axis.
const AXIS = { stroke: () => colour("soft"), grid: { stroke: () => colour("grid"), width: 1 }, ticks: { show: false }, font: "11px system-ui" };

/// A logarithmic axis, marked at every third power of ten.
const POWERS = {
  scale: { distr: 3, range: (_, low, high) => [Math.max(1e-18, (low || 1e-16) / 3), Math.max((high || 1e-12) * 3, 1e-12)] },
  axis: {
    filter: (_, ticks) => ticks,
    splits: (_, axis, low, high) => Array.from({ length: 12 }, (_, index) => 10 ** (3 * index - 24)).filter((tick) => low <= tick && tick <= high),
    values: (_, ticks) => ticks.map((tick) => `1e${Math.round(Math.log10(tick))}`),
  },
};

class Plots {
  constructor(place, about, film, seek) {
    this.film = film;
    this.scale = { age: 1e3 * about.period };
    this.panels = charts(about).map((chart) => this.panel(place, chart, seek));
    if (about.feet.length === 2) this.portrait = new Portrait(place, film);
    this.fill(0);
    const { begin, end } = film; // of a long run the beginning; a double click shows all
    if (end - begin > 60) this.panels.forEach(({ plot }) => plot.setScale("x", { min: begin, max: begin + 20 }));
    whenThemed(() => this.panels.forEach(({ plot }) => plot.redraw(false)));
  }

  panel(place, { title, unit, lines, log }, seek) {
    const frame = place.appendChild(document.createElement("figure"));
    const caption = frame.appendChild(document.createElement("h3"));
    caption.appendChild(document.createElement("b")).textContent = unit ? `${title} [${unit}]` : title;
    caption.className = lines.length > 4 ? "many" : "";
    const values = lines.map(([name], index) => {
      const key = caption.appendChild(document.createElement("span"));
      key.style.color = PALETTE[index];
      key.title = name;
      return key;
    });
    const box = frame.appendChild(document.createElement("div"));
    const plot = new uPlot({
      width: 300, height: 120, legend: { show: false }, padding: [6, 14, 0, 0],
      cursor: { sync: { key: "time" }, points: { show: false }, drag: { x: true, y: false } },
      scales: { x: { time: false }, y: log ? POWERS.scale : {} },
      axes: [{ ...AXIS, size: 22 }, { ...AXIS, size: 48, ...(log ? POWERS.axis : {}) }],
      series: [{}, ...lines.map(([name], index) => ({ label: name, stroke: PALETTE[index], width: 1.2, points: { show: false }, dash: name === "reference" ? [5, 4] : undefined }))],
      hooks: { setCursor: [({ cursor }) => this.hover?.(cursor.left < 0 ? undefined : plot?.posToVal(cursor.left, "x"))] },
    }, [[0, 1], ...lines.map(() => [1, 1])], box);
    const head = plot.over.appendChild(document.createElement("div"));
    head.className = "head";
    plot.over.addEventListener("click", () => { if (plot.select.width < 3) seek(plot.posToVal(plot.cursor.left, "x")); });
    new ResizeObserver(() => { plot.setSize({ width: box.clientWidth, height: box.clientHeight }); this.show(this.time); }).observe(box);
    return { plot, lines, values, log, head };
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

  /// Marks a time in every plot; what is zoomed in moves along, as far as there is anything to see.
  show(time) {
    if (time === undefined || this.film.length === 0) return;
    this.time = time;
    this.panels.forEach(({ plot, head }) => {
      const { min, max } = plot.scales.x;
      const isOut = time < min || time > max && time <= this.end;
      if (isOut) plot.setScale("x", { min: time - .1 * (max - min), max: time + .9 * (max - min) });
      head.style.transform = `translateX(${plot.valToPos(time, "x")}px)`;
    });
    this.tell(time);
    this.portrait?.show(time);
  }

  /// Writes the values at a time beside their names.
  tell(time) {
    const row = this.film.row(time);
    this.panels.forEach(({ lines, values, log }) => lines.forEach(([name, quantity, index], line) => {
      const value = (this.scale[quantity] ?? 1) * this.film.get(row, quantity, index);
      const isTight = lines.length > 4;
      const number = !Number.isFinite(value) ? "–" : log ? value.toExponential(0) : value.toFixed(Math.abs(value) < 1 && !isTight ? 3 : 1);
      values[line].textContent = isTight ? number : `${name} ${number}`;
    }));
  }
}

/// The lateral plane in the support frame: all orbits faintly, the last seconds strongly.
class Portrait {
  constructor(place, film) {
    this.film = film;
    const frame = place.appendChild(document.createElement("figure"));
    frame.appendChild(document.createElement("h3")).textContent = "Lateral phase portrait [m, m/s]";
    const box = frame.appendChild(document.createElement("div"));
    const range = (_, low, high) => [low - .06 * (high - low), high + .06 * (high - low)];
    const facets = [{ scale: "x", auto: true }, { scale: "y", auto: true }];
    this.plot = new uPlot({
      mode: 2, width: 300, height: 120, legend: { show: false }, padding: [6, 14, 0, 0], cursor: { show: false },
      scales: { x: { time: false, range }, y: { range } },
      axes: [{ ...AXIS, size: 22 }, { ...AXIS, size: 48 }],
      series: [{}, { facets, paths: (plot) => { this.orbits(plot); return null; } }],
    }, [null, [[0, .1], [-.1, .1]]], box);
    this.trail = this.plot.over.appendChild(document.createElement("canvas"));
    new ResizeObserver(() => { this.plot.setSize({ width: box.clientWidth, height: box.clientHeight }); this.show(this.time); }).observe(box);
    whenThemed(() => this.plot.redraw(false));
  }

  fill(from) {
    const whole = (name, index) => this.film.column(name, index, from).filter(Number.isFinite);
    const points = [whole("lateral", 0), whole("lateral", 1)];
    if (points[0].length > 1) this.plot.setData([null, points]);
  }

  /// A line through rows, broken where the support changes.
  line(context, from, to, place) {
    context.beginPath();
    let before;
    for (let row = from; row <= to; row++) {
      const [position, velocity, support] = this.film.all(row, "lateral"), [x, y] = place(position, velocity);
      if (support === before) context.lineTo(x, y); else context.moveTo(x, y);
      before = support;
    }
    context.stroke();
  }

  orbits(plot) {
    const { ctx } = plot;
    ctx.save();
    ctx.rect(plot.bbox.left, plot.bbox.top, plot.bbox.width, plot.bbox.height);
    ctx.clip();
    Object.assign(ctx, { strokeStyle: colour("grey"), lineWidth: .7 * devicePixelRatio, globalAlpha: .35 });
    const stride = this.film.length - 1;
    this.line(ctx, Math.max(0, stride - 6000), stride, (x, y) => [plot.valToPos(x, "x", true), plot.valToPos(y, "y", true)]);
    ctx.restore();
  }

  show(time) {
    if (time === undefined || this.film.length === 0) return;
    this.time = time;
    const { trail, plot } = this, { clientWidth, clientHeight } = plot.over;
    [trail.width, trail.height] = [clientWidth * devicePixelRatio, clientHeight * devicePixelRatio];
    const place = (x, y) => [plot.valToPos(x, "x") * devicePixelRatio, plot.valToPos(y, "y") * devicePixelRatio];
    const context = trail.getContext("2d"), row = this.film.row(time);
    Object.assign(context, { strokeStyle: "#a45bd0", fillStyle: "#a45bd0", lineWidth: 2 * devicePixelRatio });
    this.line(context, this.film.row(time - 1.2), row, place);
    context.beginPath();
    context.arc(...place(...this.film.all(row, "lateral")), 4 * devicePixelRatio, 0, 7);
    context.fill();
  }
}

