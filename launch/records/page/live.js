// A running session: frames are fetched as they come, wishes are sent to its desks.
const LOOK = 40; // between two fetches [ms]
const AGAIN = 2000; // after nobody was there [ms]
const SPAN = 20; // that the plots show [s]
const MOST = 60000; // rows that are kept
const HEAD_ON = .95; // cosine to the line of sight from which on a way has no direction in the picture

class Live {
  constructor(about, film, player, plots, marks) {
    Object.assign(this, { about, film, player, plots, marks, run: 0, next: 0, filled: 0 });
    player.isFollowing = true;
    this.headers = { Authorization: `Bearer ${token}` };
    this.answer = part("answer");
    part("desk").hidden = false;
    part("now").hidden = false;
    [part("pace").value, part("period").value] = about.gait[0] ?? ["", ""];
    part("help").classList.add("live");
    part("now").addEventListener("click", () => player.follow());
    const wishes = {
      pause: () => ({ what: "pause" }), resume: () => ({ what: "resume" }), reset: () => ({ what: "reset" }),
      rearm: () => ({ what: "rearm" }), advance: () => ({ what: "step", periods: 10 }),
      set: () => ({ what: "set", speed: Number(part("pace").value), period: Number(part("period").value) }),
    };
    for (const [id, wish] of Object.entries(wishes)) part(id).addEventListener("click", () => this.ask(wish()));
    document.querySelectorAll("#desk [data-push]").forEach((button) => button.addEventListener("click", () => this.push(button.dataset.push)));
    this.fetch();
  }

  push(direction) {
    const strength = Number(part("strength").value);
    this.ask({ what: "push", impulse: direction.split(",").map((along) => strength * Number(along)) });
  }

  /// Shows on each button for pushes which way that is in the picture: ⊙ comes out of it, ⊗ goes into it.
  point(stage, from) {
    document.querySelectorAll("#desk [data-push]").forEach((button) => {
      const { angle, depth } = stage.way(from, new THREE.Vector3(...button.dataset.push.split(",").map(Number))), mark = button.lastElementChild;
      mark.textContent = depth > HEAD_ON ? "⊙" : depth < -HEAD_ON ? "⊗" : "→";
      mark.style.transform = mark.textContent === "→" ? `rotate(${angle}rad)` : "";
    });
  }

  async ask(wish) {
    const answer = await fetch("ask", { method: "POST", headers: this.headers, body: JSON.stringify(wish) }).catch(() => undefined);
    this.answer.textContent = answer ? `${wish.what}: ${await answer.text()}` : "the session has ended";
  }

  async fetch() {
    try {
      const answer = await fetch(`frames?run=${this.run}&from=${this.next}`, { headers: this.headers });
      if (!answer.ok) { this.answer.textContent = await answer.text(); return; }
      const run = Number(answer.headers.get("Run")), rows = await answer.arrayBuffer();
      this.next = Number(answer.headers.get("Next"));
      if (run !== this.run) { this.film.clear(); this.marks.clear(); }
      this.run = run;
      if (rows.byteLength > 0) this.take(rows);
    } catch {
      this.answer.textContent = "the session has ended";
      setTimeout(() => this.fetch(), AGAIN);
      return;
    }
    setTimeout(() => this.fetch(), LOOK);
  }

  take(rows) {
    this.film.append(rows);
    if (this.film.length > MOST) { this.film.forget(MOST / 2); this.marks.seen = Math.max(this.marks.seen - MOST / 2, 0); }
    if (performance.now() - this.filled > 250 && this.player.isFollowing) {
      this.plots.fill(this.film.row(this.film.end - SPAN));
      this.filled = performance.now();
    }
    if (this.player.isFollowing) this.player.seek(this.film.end);
  }
}

