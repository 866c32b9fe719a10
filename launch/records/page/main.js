// Creates all parts of the page and connects them.
performance.mark("parsed");
const byId = (id) => document.getElementById(id);
// Removes the token from the address and the history, where others could read it. The tab keeps it for a reload (`reload.js`).
const token = new URLSearchParams(location.search).get("token");
if (token) {
  sessionStorage.setItem("token", token);
  history.replaceState(null, "", location.pathname);
}
const runInfo = JSON.parse(byId("run-info").textContent);
const trajectory = new Trajectory(runInfo.layout);
trajectory.append(decodeBase64(byId("trajectory").textContent));
performance.mark("trajectory");

const robot = new Robot(runInfo), markers = new Markers(runInfo);
let stage, drag;

const INTERPOLATION_LIMIT = .1; // no interpolation between frames that are farther apart [s]

// Shows a time in all parts of the page.
function show(time) {
  if (trajectory.length === 0) return;
  const row = trajectory.row(time), next = Math.min(row + 1, trajectory.length - 1);
  const gap = trajectory.get(next, "time") - trajectory.get(row, "time");
  const fraction = gap > 0 && gap < INTERPOLATION_LIMIT ? Math.min((time - trajectory.get(row, "time")) / gap, 1) : 0;
  robot.pose(trajectory, row, fraction);
  markers.show(trajectory, row, fraction, robot);
  if (drag?.hold) drag.show();
  plots.show(time);
  showStatus(row);
  if (!stage) return;
  if (byId("follow").checked) stage.follow(markers.com.position.x, markers.com.position.y);
  stage.isStale = true;
}

// Shows the state of the robot at a row as text.
function showStatus(row) {
  const get = (name, index) => trajectory.get(row, name, index);
  const side = runInfo.feet.length < 2 ? "" : `, ${["left", "right"][get("support")]} foot supports`;
  const motion = `${Math.hypot(get("velocity", 0), get("velocity", 1)).toFixed(2)} m/s, x ${get("com", 0).toFixed(2)} m`;
  const lines = runInfo.driven ? [
    `${runInfo.phases[get("phase")] ?? "?"}${side}`,
    `step ${get("steps")}, ${motion}`,
    `drives: ${runInfo.states[get("state")] ?? "?"}, ${get("refused")} commands refused, ${get("lost")} lost`,
  ] : ["no controller", motion];
  const hasFallen = get("fallen") > 0;
  if (hasFallen) lines[0] = `fell at ${trajectory.fall.toFixed(2)} s`;
  byId("facts").textContent = lines.join("\n");
  byId("facts").classList.toggle("fell", hasFallen);
}

const player = new Player(trajectory, show);
const plots = new Plots(byId("plots"), runInfo, trajectory, player);
plots.hover = (time) => plots.showValues(time ?? player.time);
document.querySelectorAll("#cameras button").forEach((button) => button.addEventListener("click", () => stage?.lookFrom(...button.dataset.from.split(",").map(Number))));
byId("ask-help").addEventListener("click", () => byId("help").showModal());
byId("forces").addEventListener("change", (event) => { markers.forces.visible = event.target.checked; player.isStale = true; });
byId("prints").addEventListener("change", (event) => { markers.prints.visible = event.target.checked; player.isStale = true; });
byId("follow").addEventListener("change", () => { player.isStale = true; });

const live = runInfo.live && new Live(runInfo, trajectory, player, plots, markers);
player.isStale = true;
if (!live) player.play(!matchMedia("(prefers-reduced-motion)").matches);

// Creates the picture last, because WebGL may take a second to start.
function createPicture() {
  try {
    stage = new Stage(byId("picture"), robot, markers, runInfo.tiles);
    if (live) drag = new Drag(byId("picture"), stage, robot, (push) => live.ask({ what: "push", ...push }));
  } catch (error) {
    byId("picture").textContent = `No 3-D picture: this browser does not support WebGL (${error.message}).`;
  }
  player.isStale = true;
}

performance.mark("built");
requestAnimationFrame(function frame(now) {
  player.tick(now);
  if (stage?.isStale) {
    stage.draw(markers.com.position.toArray());
    if (live) live.showPushDirections(stage, markers.com.position);
  }
  requestAnimationFrame(frame);
});
requestAnimationFrame(() => setTimeout(createPicture));
