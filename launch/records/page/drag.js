// Pushes a body by dragging it. An arrow from the body shows the impulse.
const METRES_PER_NEWTON_SECOND = .1; // scale of the arrow
const MAX_IMPULSE = 20; // [N·s]
const MIN_DRAG = 4; // a shorter drag is a click and no push [px]

class Drag {
  constructor(container, stage, robot, send) {
    Object.assign(this, { stage, robot, send, canvas: stage.renderer.domElement, hold: undefined });
    this.arrow = Markers.arrow("#e3a008", 2);
    this.arrow.visible = false;
    stage.scene.add(this.arrow);
    this.label = container.appendChild(document.createElement("output"));
    this.label.id = "impulse";
    this.label.hidden = true;
    // In the capture phase, so that the camera controls do not receive the event of a drag.
    container.addEventListener("pointerdown", (event) => this.grab(event), true);
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
    if (this.hold) { this.end(); return; } // a second finger cancels the push
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
    const offset = this.stage.worldOffset(dx, dy, this.robot.centre(hold.body));
    hold.impulse = Math.hypot(dx, dy) < MIN_DRAG ? undefined : offset.divideScalar(METRES_PER_NEWTON_SECOND).clampLength(0, MAX_IMPULSE);
    this.show();
  }

  release(event, isConfirmed) {
    if (event.pointerId !== this.hold?.pointer) return;
    const { body, impulse } = this.hold;
    this.end();
    if (isConfirmed && impulse) this.send({ body, impulse: impulse.toArray() });
  }

  end() {
    this.hold = undefined;
    this.canvas.style.cursor = "";
    this.show();
  }

  // Draws the arrow at the current position of the body.
  show() {
    const impulse = this.hold?.impulse;
    this.arrow.visible = Boolean(impulse);
    this.label.hidden = !impulse;
    this.stage.isStale = true;
    if (!impulse) return;
    const from = this.robot.centre(this.hold.body), length = impulse.length();
    Markers.point(this.arrow, from, impulse, length * METRES_PER_NEWTON_SECOND);
    const [x, y] = this.stage.onScreen(from.addScaledVector(impulse, METRES_PER_NEWTON_SECOND));
    this.label.textContent = `${length.toFixed(1)} N·s`;
    this.label.style.transform = `translate(${x}px, ${y}px)`;
  }
}

