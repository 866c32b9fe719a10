// The lateral plane in the support frame: all orbits faintly, the last seconds strongly.
class Portrait {
  constructor(place, film) {
    this.film = film;
    const frame = place.appendChild(document.createElement("figure"));
    frame.appendChild(document.createElement("h3")).textContent = "Lateral phase portrait [m, m/s]";
    const box = frame.appendChild(document.createElement("div"));
    const range = (_, low, high) => [low - .06 * (high - low), high + .06 * (high - low)];
    const facets = [{ scale: "x", auto: true }, { scale: "y", auto: true }];
    this.plot = new uPlot({
      mode: 2, width: 300, height: 120, legend: { show: false }, padding: [6, 22, 0, 0], cursor: { show: false },
      scales: { x: { time: false, range }, y: { range } },
      axes: [{ ...AXIS, size: 22, values: labels }, { ...AXIS, size: room, space: 24, values: labels }],
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

