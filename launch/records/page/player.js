// Time: play, pause, scrub, speed, step; by buttons and by keys.
class Player {
  constructor(film, show) {
    Object.assign(this, { film, show, time: film.begin, isPlaying: false, isFollowing: false, before: 0 });
    const part = (id) => document.getElementById(id);
    [this.button, this.bar, this.clock, this.speed, this.marks] = ["play", "scrub", "clock", "speed", "falls"].map(part);
    this.button.addEventListener("click", () => this.play(!this.isPlaying));
    part("back").addEventListener("click", () => this.step(-1));
    part("forth").addEventListener("click", () => this.step(1));
    this.bar.addEventListener("input", () => { this.play(false); this.seek(Number(this.bar.value)); });
    addEventListener("keydown", (event) => {
      const isTaken = event.target.matches("input:not([type=range],[type=checkbox]), select, textarea, dialog, dialog *");
      if (isTaken || event.ctrlKey || event.altKey || event.metaKey) return;
      if (event.key === " " && event.target.matches("button, summary, [type=checkbox]")) return; // it presses those
      const deed = {
        " ": () => this.play(!this.isPlaying), ArrowLeft: () => this.step(-1), ArrowRight: () => this.step(1),
        Home: () => { this.play(false); this.seek(film.begin); }, End: () => this.follow(),
        "?": () => part("help").showModal(),
      }[event.key];
      if (deed) { deed(); event.preventDefault(); }
    });
  }

  /// Goes to the end, and along with it where it moves.
  follow() {
    this.play(false);
    this.isFollowing = true;
    this.seek(this.film.end);
  }

  /// Goes where somebody pointed.
  point(time) {
    this.pointed = [this.time, this.isPlaying, this.isFollowing];
    this.play(false);
    this.seek(time);
  }

  /// That was the first half of a double click, which means something else.
  unpoint() {
    if (!this.pointed) return; // that half went beside
    const [time, isPlaying, isFollowing] = this.pointed;
    this.pointed = undefined;
    this.play(isPlaying);
    this.isFollowing = isFollowing;
    this.seek(time);
  }

  play(on) {
    this.isFollowing = false;
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
    if (this.film.fall !== this.fall) this.marks.replaceChildren(...(this.film.fall === undefined ? [] : [new Option("fall", this.film.fall)]));
    this.fall = this.film.fall;
    this.show(this.time);
  }
}

