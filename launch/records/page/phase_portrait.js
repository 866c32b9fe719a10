// Phase portrait of the lateral plane in the support frame: the latest orbits in grey, the last second highlighted.
const ORBIT_ROWS = 6000; // number of rows of the grey orbits
const TRAIL = 1.2; // duration of the highlighted part: two periods of two steps [s]
const MARGIN = .06; // of the axes, relative to the range

class PhasePortrait {
  constructor(container, trajectory) {
    this.trajectory = trajectory;
    const frame = container.appendChild(document.createElement("figure"));
    frame.appendChild(document.createElement("h3")).textContent = "Lateral phase portrait [m, m/s]";
    const box = frame.appendChild(document.createElement("div"));
    const range = (_, low, high) => [low - MARGIN * (high - low), high + MARGIN * (high - low)];
    const facets = [{ scale: "x", auto: true }, { scale: "y", auto: true }];
    this.plot = new uPlot({
      mode: 2, width: 300, height: 120, legend: { show: false }, padding: [6, 22, 0, 0], cursor: { show: false },
      scales: { x: { time: false, range }, y: { range } },
      axes: [{ ...AXIS, size: 22, values: labels }, { ...AXIS, size: axisWidth, space: 24, values: labels }],
      series: [{}, { facets, paths: (plot) => { this.orbits(plot); return null; } }],
      hooks: { draw: [() => this.show(this.time)] }, // the plot takes a new size and new ranges only when it draws
    }, [null, [[0, .1], [-.1, .1]]], box);
    this.trail = this.plot.over.appendChild(document.createElement("canvas"));
    new ResizeObserver(() => this.plot.setSize({ width: box.clientWidth, height: box.clientHeight })).observe(box);
    whenThemed(() => this.plot.redraw(false));
  }

  fill(from) {
    const finite = (name, index) => this.trajectory.column(name, index, from).filter(Number.isFinite);
    const points = [finite("lateral", 0), finite("lateral", 1)];
    if (points[0].length > 1) this.plot.setData([null, points]);
  }

  // Draws a line through rows, interrupted where the support foot changes.
  line(context, from, to, toPixels) {
    context.beginPath();
    let before;
    for (let row = from; row <= to; row++) {
      const [position, velocity, support] = this.trajectory.all(row, "lateral"), [x, y] = toPixels(position, velocity);
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
    const last = this.trajectory.length - 1;
    this.line(ctx, Math.max(0, last - ORBIT_ROWS), last, (x, y) => [plot.valToPos(x, "x", true), plot.valToPos(y, "y", true)]);
    ctx.restore();
  }

  show(time) {
    if (time === undefined || this.trajectory.length === 0) return;
    this.time = time;
    const { trail, plot } = this, { clientWidth, clientHeight } = plot.over;
    [trail.width, trail.height] = [clientWidth * devicePixelRatio, clientHeight * devicePixelRatio];
    const toPixels = (x, y) => [plot.valToPos(x, "x") * devicePixelRatio, plot.valToPos(y, "y") * devicePixelRatio];
    const context = trail.getContext("2d"), row = this.trajectory.row(time);
    Object.assign(context, { strokeStyle: "#a45bd0", fillStyle: "#a45bd0", lineWidth: 2 * devicePixelRatio });
    this.line(context, this.trajectory.row(time - TRAIL), row, toPixels);
    context.beginPath();
    context.arc(...toPixels(...this.trajectory.all(row, "lateral")), 4 * devicePixelRatio, 0, 7);
    context.fill();
  }
}

