// Playback control: play, pause, seek, speed, single steps; with buttons and keys.
const MAX_TICK = 100; // longest time that one tick plays, after the tab was hidden [ms]

class Player {
  constructor(trajectory, show) {
    Object.assign(this, { trajectory, show, time: trajectory.begin, isPlaying: false, isFollowing: false, before: 0 });
    [this.button, this.bar, this.clock, this.speed, this.fallMarks] = ["play", "scrub", "clock", "speed", "falls"].map(byId);
    this.button.addEventListener("click", () => this.play(!this.isPlaying));
    byId("back").addEventListener("click", () => this.step(-1));
    byId("forth").addEventListener("click", () => this.step(1));
    this.bar.addEventListener("input", () => { this.play(false); this.seek(Number(this.bar.value)); });
    addEventListener("keydown", (event) => {
      const isForElement = event.target.matches("input:not([type=range],[type=checkbox]), select, textarea, dialog, dialog *");
      if (isForElement || event.ctrlKey || event.altKey || event.metaKey) return;
      if (event.key === " " && event.target.matches("button, summary, [type=checkbox]")) return; // the space bar activates these elements
      const action = {
        " ": () => this.play(!this.isPlaying), ArrowLeft: () => this.step(-1), ArrowRight: () => this.step(1),
        Home: () => { this.play(false); this.seek(trajectory.begin); }, End: () => this.follow(),
        "?": () => byId("help").showModal(),
      }[event.key];
      if (action) { action(); event.preventDefault(); }
    });
  }

  // Jumps to the end and follows it.
  follow() {
    this.play(false);
    this.isFollowing = true;
    this.seek(this.trajectory.end);
  }

  // Jumps to a time that was clicked.
  jump(time) {
    this.stateBeforeJump = [this.time, this.isPlaying, this.isFollowing];
    this.play(false);
    this.seek(time);
  }

  // Undoes the jump of a click that was the first half of a double click.
  undoJump() {
    if (!this.stateBeforeJump) return; // the first half did not hit the plot
    const [time, isPlaying, isFollowing] = this.stateBeforeJump;
    this.stateBeforeJump = undefined;
    this.play(isPlaying);
    this.isFollowing = isFollowing;
    this.seek(time);
  }

  play(on) {
    this.isFollowing = false;
    if (on && this.time >= this.trajectory.end) this.time = this.trajectory.begin;
    this.isPlaying = on;
    this.button.textContent = on ? "❚❚" : "▶";
  }

  step(count) {
    this.play(false);
    const row = Math.min(Math.max(this.trajectory.row(this.time) + count, 0), this.trajectory.length - 1);
    this.seek(this.trajectory.get(row, "time"));
  }

  seek(time) {
    this.time = Math.min(Math.max(time, this.trajectory.begin), this.trajectory.end);
    this.isStale = true;
  }

  // Advances the time by the clock of the display [ms].
  tick(now) {
    const passed = Math.min(now - this.before, MAX_TICK) * 1e-3 * Number(this.speed.value);
    this.before = now;
    if (this.isPlaying) {
      this.seek(this.time + passed);
      if (this.time >= this.trajectory.end) this.play(false);
    }
    if (!this.isStale) return;
    this.isStale = false;
    [this.bar.min, this.bar.max, this.bar.value] = [this.trajectory.begin, this.trajectory.end, this.time];
    this.clock.textContent = `${this.time.toFixed(3)} / ${this.trajectory.end.toFixed(1)} s`;
    if (this.trajectory.fall !== this.fall) this.fallMarks.replaceChildren(...(this.trajectory.fall === undefined ? [] : [new Option("fall", this.trajectory.fall)]));
    this.fall = this.trajectory.fall;
    this.show(this.time);
  }
}

