// Time: play, pause, scrub, speed, step; by buttons and by keys.
class Player {
  constructor(film, show) {
    Object.assign(this, { film, show, time: film.begin, isPlaying: false, before: 0 });
    const part = (id) => document.getElementById(id);
    [this.button, this.bar, this.clock, this.speed] = ["play", "scrub", "clock", "speed"].map(part);
    this.button.addEventListener("click", () => this.play(!this.isPlaying));
    part("back").addEventListener("click", () => this.step(-1));
    part("forth").addEventListener("click", () => this.step(1));
    this.bar.addEventListener("input", () => { this.play(false); this.seek(Number(this.bar.value)); });
    addEventListener("keydown", (event) => {
      if (event.target.matches("input:not([type=range],[type=checkbox]), select, textarea")) return;
      const deed = { " ": () => this.play(!this.isPlaying), ArrowLeft: () => this.step(-1), ArrowRight: () => this.step(1) }[event.key];
      if (deed) { deed(); event.preventDefault(); }
    });
  }

  play(on) {
    if (on && this.time >= this.film.end) this.time = this.film.begin;
    this.isPlaying = on;
    this.button.textContent = on ? "❚❚" : "▶";
  }

  step(count) {
    this.play(false);
    const row = Math.min(Math.max(this.film.row(this.time) + count, 0), this.film.length - 1);
    this.seek(this.film.get(row, "time"));
  }

  seek(time) {
    this.time = Math.min(Math.max(time, this.film.begin), this.film.end);
    this.isStale = true;
  }

  /// Goes on by the clock of the screen [ms].
  tick(now) {
    const passed = Math.min(now - this.before, 100) * 1e-3 * Number(this.speed.value);
    this.before = now;
    if (this.isPlaying) {
      this.seek(this.time + passed);
      if (this.time >= this.film.end) this.play(false);
    }
    if (!this.isStale) return;
    this.isStale = false;
    [this.bar.min, this.bar.max, this.bar.value] = [this.film.begin, this.film.end, this.time];
    this.clock.textContent = `${this.time.toFixed(3)} / ${this.film.end.toFixed(1)} s`;
    this.show(this.time);
  }
}

