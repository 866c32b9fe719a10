// A push by dragging: from the body that was grabbed, an arrow as long as the impulse.
const METRES_PER_NEWTON_SECOND = .1;
const STRONGEST = 20; // [N·s]
const CLICK = 4; // no farther than this is no push [px]

class Drag {
  constructor(place, stage, robot, send) {
    Object.assign(this, { stage, robot, send, canvas: stage.renderer.domElement, hold: undefined });
    this.arrow = Marks.arrow("#e3a008", 2);
    this.arrow.visible = false;
    stage.scene.add(this.arrow);
    this.label = place.appendChild(document.createElement("output"));
    this.label.id = "impulse";
    this.label.hidden = true;
    // On the way down to the canvas, before the camera's controls hear of it.
    place.addEventListener("pointerdown", (event) => this.grab(event), true);
    this.canvas.addEventListener("pointermove", (event) => this.move(event));
    this.canvas.addEventListener("pointerup", (event) => this.release(event, true));
    this.canvas.addEventListener("pointercancel", (event) => this.release(event, false));
    addEventListener("keydown", ({ key }) => { if (key === "Escape") this.end(); });
  }

  grab(event) {
    if (event.target !== this.canvas) return;
    const body = this.hold ? undefined : event.button === 0 ? this.stage.bodyAt(event) : undefined;
    if (!this.hold && body === undefined) return;
    event.stopPropagation();
    if (this.hold) { this.end(); return; } // a second finger means something else
    this.hold = { pointer: event.pointerId, body, x: event.clientX, y: event.clientY, impulse: undefined };
    this.canvas.setPointerCapture(event.pointerId);
    this.canvas.style.cursor = "grabbing";
  }

  move(event) {
    if (!this.hold) {
      if (event.pointerType === "mouse" && event.buttons === 0) this.canvas.style.cursor = this.stage.bodyAt(event) === undefined ? "" : "grab";
      return;
    }
    const { hold } = this, dx = event.clientX - hold.x, dy = event.clientY - hold.y;
    if (event.pointerId !== hold.pointer) return;
    const way = this.stage.across(dx, dy, this.robot.centre(hold.body));
    hold.impulse = Math.hypot(dx, dy) < CLICK ? undefined : way.divideScalar(METRES_PER_NEWTON_SECOND).clampLength(0, STRONGEST);
    this.show();
  }

  release(event, isMeant) {
    if (event.pointerId !== this.hold?.pointer) return;
    const { body, impulse } = this.hold;
    this.end();
    if (isMeant && impulse) this.send({ body, impulse: impulse.toArray() });
  }

  end() {
    this.hold = undefined;
    this.canvas.style.cursor = "";
    this.show();
  }

  /// Draws the arrow where the body is now.
  show() {
    const impulse = this.hold?.impulse;
    this.arrow.visible = Boolean(impulse);
    this.label.hidden = !impulse;
    this.stage.isStale = true;
    if (!impulse) return;
    const from = this.robot.centre(this.hold.body), length = impulse.length();
    Marks.point(this.arrow, from, impulse, length * METRES_PER_NEWTON_SECOND);
    const [x, y] = this.stage.onScreen(from.addScaledVector(impulse, METRES_PER_NEWTON_SECOND));
    this.label.textContent = `${length.toFixed(1)} N·s`;
    this.label.style.transform = `translate(${x}px, ${y}px)`;
  }
}

