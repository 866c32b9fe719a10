// A running session: fetches new frames and sends requests.
const POLL_INTERVAL = 40; // time between fetches [ms]
const RETRY_INTERVAL = 2000; // time until the next fetch after a failed one [ms]
const PLOT_SPAN = 20; // time that the plots show [s]
const PLOT_INTERVAL = 250; // time between updates of the plots [ms]
const MAX_ROWS = 60000; // number of rows that are stored: five minutes at 200 Hz
const HEAD_ON = .95; // cosine of the angle to the line of sight above which an arrow is drawn as ⊙ or ⊗

class Live {
  constructor(runInfo, trajectory, player, plots, markers) {
    Object.assign(this, { runInfo, trajectory, player, plots, markers, run: 0, next: 0, filled: 0 });
    player.isFollowing = true;
    this.headers = { Authorization: `Bearer ${token}` };
    this.answer = byId("answer");
    byId("controls").hidden = false;
    byId("now").hidden = false;
    [byId("pace").value, byId("period").value] = runInfo.gait[0] ?? ["", ""];
    byId("help").classList.add("live");
    byId("now").addEventListener("click", () => player.follow());
    const requests = {
      pause: () => ({ what: "pause" }), resume: () => ({ what: "resume" }), reset: () => ({ what: "reset" }),
      rearm: () => ({ what: "rearm" }), advance: () => ({ what: "step", periods: 10 }),
      set: () => ({ what: "set", speed: Number(byId("pace").value), period: Number(byId("period").value) }),
      halt: () => ({ what: "stop" }),
    };
    for (const [id, request] of Object.entries(requests)) byId(id).addEventListener("click", () => this.ask(request()));
    document.querySelectorAll("#controls [data-push]").forEach((button) => button.addEventListener("click", () => this.push(button.dataset.push)));
    this.fetch();
  }

  push(direction) {
    const strength = Number(byId("strength").value);
    this.ask({ what: "push", impulse: direction.split(",").map((component) => strength * Number(component)) });
  }

  // Shows the direction of each push in the picture on its button: ⊙ points out of the picture, ⊗ into it.
  showPushDirections(stage, from) {
    document.querySelectorAll("#controls [data-push]").forEach((button) => {
      const { angle, depth } = stage.screenDirection(from, new THREE.Vector3(...button.dataset.push.split(",").map(Number))), symbol = button.lastElementChild;
      symbol.textContent = depth > HEAD_ON ? "⊙" : depth < -HEAD_ON ? "⊗" : "→";
      symbol.style.transform = symbol.textContent === "→" ? `rotate(${angle}rad)` : "";
    });
  }

  async ask(request) {
    const answer = await fetch("ask", { method: "POST", headers: this.headers, body: JSON.stringify(request) }).catch(() => undefined);
    this.answer.textContent = answer ? `${request.what}: ${await answer.text()}` : "the session has ended";
  }

  async fetch() {
    try {
      const answer = await fetch(`frames?run=${this.run}&from=${this.next}`, { headers: this.headers });
      if (!answer.ok) { this.answer.textContent = await answer.text(); return; }
      const run = Number(answer.headers.get("Run")), rows = await answer.arrayBuffer();
      this.next = Number(answer.headers.get("Next"));
      if (run !== this.run) { this.trajectory.clear(); this.markers.clear(); }
      this.run = run;
      if (rows.byteLength > 0) this.append(rows);
    } catch {
      this.answer.textContent = "the session has ended";
      setTimeout(() => this.fetch(), RETRY_INTERVAL);
      return;
    }
    setTimeout(() => this.fetch(), POLL_INTERVAL);
  }

  append(rows) {
    this.trajectory.append(rows);
    if (this.trajectory.length > MAX_ROWS) { this.trajectory.dropOldest(MAX_ROWS / 2); this.markers.seen = Math.max(this.markers.seen - MAX_ROWS / 2, 0); }
    if (performance.now() - this.filled > PLOT_INTERVAL && this.player.isFollowing) {
      this.plots.fill(this.trajectory.row(this.trajectory.end - PLOT_SPAN));
      this.filled = performance.now();
    }
    if (this.player.isFollowing) this.player.seek(this.trajectory.end);
  }
}

