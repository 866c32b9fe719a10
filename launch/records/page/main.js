// All of it together.
performance.mark("parsed");
const part = (id) => document.getElementById(id);
// Out of the address and its history, where others would read it; a reload finds it in this tab (`reload.js`).
const token = new URLSearchParams(location.search).get("token");
if (token) {
  sessionStorage.setItem("token", token);
  history.replaceState(null, "", location.pathname);
}
const about = JSON.parse(part("about").textContent);
const film = new Film(about.layout);
film.append(bytesOf(part("film").textContent));
performance.mark("film");

const robot = new Robot(about), marks = new Marks(about);
let stage, drag;

/// Draws an instant everywhere.
function show(time) {
  if (film.length === 0) return;
  const row = film.row(time), next = Math.min(row + 1, film.length - 1);
  const gap = film.get(next, "time") - film.get(row, "time");
  const share = gap > 0 && gap < .1 ? Math.min((time - film.get(row, "time")) / gap, 1) : 0;
  robot.pose(film, row, share);
  marks.show(film, row, share, robot);
  if (drag?.hold) drag.show();
  plots.show(time);
  tell(row);
  if (!stage) return;
  if (part("follow").checked) stage.follow(marks.com.position.x, marks.com.position.y);
  stage.isStale = true;
}

/// The instant in words.
function tell(row) {
  const get = (name, index) => film.get(row, name, index);
  const side = about.feet.length < 2 ? "" : `, ${["left", "right"][get("support")]} foot supports`;
  const moves = `${Math.hypot(get("velocity", 0), get("velocity", 1)).toFixed(2)} m/s, x ${get("com", 0).toFixed(2)} m`;
  const words = about.driven ? [
    `${about.phases[get("phase")] ?? "?"}${side}`,
    `step ${get("steps")}, ${moves}`,
    `drives: ${about.states[get("state")] ?? "?"}, ${get("refused")} commands refused, ${get("lost")} lost`,
  ] : ["no controller", moves];
  const hasFallen = get("fallen") > 0;
  if (hasFallen) words[0] = `fell at ${film.fall.toFixed(2)} s`;
  part("facts").textContent = words.join("\n");
  part("facts").classList.toggle("fell", hasFallen);
}

const player = new Player(film, show);
const plots = new Plots(part("plots"), about, film, player);
plots.hover = (time) => plots.tell(time ?? player.time);
document.querySelectorAll("#cameras button").forEach((button) => button.addEventListener("click", () => stage?.look(...button.dataset.from.split(",").map(Number))));
part("ask-help").addEventListener("click", () => part("help").showModal());
part("forces").addEventListener("change", (event) => { marks.forces.visible = event.target.checked; player.isStale = true; });
part("prints").addEventListener("change", (event) => { marks.prints.visible = event.target.checked; player.isStale = true; });
part("follow").addEventListener("change", () => { player.isStale = true; });

const live = about.live && new Live(about, film, player, plots, marks);
player.isStale = true;
if (!live) player.play(!matchMedia("(prefers-reduced-motion)").matches);

/// Where a picture may take a second to begin, all else is there before it.
function raise() {
  try {
    stage = new Stage(part("picture"), robot, marks);
    if (live) drag = new Drag(part("picture"), stage, robot, (push) => live.ask({ what: "push", ...push }));
  } catch (error) {
    part("picture").textContent = `No 3-D picture: this browser gives no WebGL (${error.message}).`;
  }
  player.isStale = true;
}

performance.mark("built");
requestAnimationFrame(function frame(now) {
  player.tick(now);
  if (stage?.isStale) {
    stage.draw(marks.com.position.toArray());
    if (live) live.point(stage, marks.com.position);
  }
  requestAnimationFrame(frame);
});
requestAnimationFrame(() => setTimeout(raise));
