// What is drawn beside the robot: forces of the ground, centre of gravity and its projection, zero-moment point, footprints.
const METRES_PER_NEWTON = 2e-3;

class Marks {
  constructor(about) {
    this.group = new THREE.Group();
    this.about = about;
    this.arrows = about.contacts.map(() => Marks.arrow("#d1242f"));
    this.forces = new THREE.Group().add(...this.arrows);
    this.com = Marks.dot(new THREE.SphereGeometry(.013, 24, 16), "#8e5bd6");
    this.shadow = Marks.dot(new THREE.RingGeometry(.010, .016, 32), "#8e5bd6");
    this.zmp = Marks.dot(new THREE.CircleGeometry(.009, 24), "#d1242f");
    const line = new THREE.BufferGeometry().setAttribute("position", new THREE.Float32BufferAttribute(6, 3));
    this.plumb = new THREE.Line(line, new THREE.LineBasicMaterial({ color: "#8e5bd6" }));
    this.plumb.frustumCulled = false;
    [this.com, this.plumb].forEach((part) => { part.material.depthTest = false; part.renderOrder = 9; }); // seen through the body
    this.prints = new THREE.Group();
    this.soles = about.feet.map(({ half, body }) => {
      const geometry = new THREE.PlaneGeometry(2 * half[0], 2 * half[1]), color = Robot.colour(about.bodies[body].name);
      const skin = new THREE.MeshBasicMaterial({ color, transparent: true, opacity: .13, depthWrite: false });
      return { geometry, skin, outline: new THREE.EdgesGeometry(geometry), line: new THREE.LineBasicMaterial({ color }) };
    });
    [this.printed, this.seen] = [[], 0]; // of all prints the group has those to be seen
    this.landed = about.feet.map(() => undefined);
    this.group.add(this.forces, this.com, this.shadow, this.zmp, this.plumb, this.prints);
  }

  static dot(geometry, color) {
    return new THREE.Mesh(geometry, new THREE.MeshBasicMaterial({ color }));
  }

  /// One metre long along z.
  static arrow(color, width = 1) {
    const skin = new THREE.MeshBasicMaterial({ color });
    const shaft = new THREE.Mesh(new THREE.CylinderGeometry(.0032 * width, .0032 * width, 1, 10).translate(0, .5, 0).rotateX(Math.PI / 2), skin);
    const head = new THREE.Mesh(new THREE.ConeGeometry(.009 * width, .024 * width, 14).rotateX(Math.PI / 2), skin);
    return Object.assign(new THREE.Group().add(shaft, head), { shaft, head });
  }

  /// Puts an arrow from a place along a way.
  static point(arrow, from, way, length) {
    arrow.position.copy(from);
    arrow.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), way.clone().normalize());
    arrow.shaft.scale.z = length;
    arrow.head.position.z = length;
  }

  show(film, row, share, robot) {
    const places = robot.contacts(), force = film.all(row, "force");
    this.arrows.forEach((arrow, index) => {
      const along = new THREE.Vector3(...force.subarray(3 * index, 3 * index + 3)), length = along.length() * METRES_PER_NEWTON;
      arrow.visible = length > 1e-3;
      if (arrow.visible) Marks.point(arrow, places[index], along, length);
    });
    const next = Math.min(row + 1, film.length - 1);
    const com = [0, 1, 2].map((index) => (1 - share) * film.get(row, "com", index) + share * film.get(next, "com", index));
    this.com.position.set(...com);
    this.shadow.position.set(com[0], com[1], .002);
    this.plumb.geometry.attributes.position.array.set([...com, com[0], com[1], 0]);
    this.plumb.geometry.attributes.position.needsUpdate = true;
    const [x, y] = film.all(row, "zmp");
    this.zmp.visible = Number.isFinite(x);
    this.zmp.position.set(x, y, .003);
    this.walk(film);
    const time = film.get(row, "time");
    this.prints.clear();
    this.printed.filter(({ since, position }) => since <= time && Math.abs(position.x - com[0]) < 4).forEach((print) => this.prints.add(print));
  }

  /// Leaves a print wherever a foot stood that has been lifted, as far as the film goes.
  walk(film) {
    for (; this.seen < film.length; this.seen++) {
      const soles = film.all(this.seen, "soles");
      for (let side = 0; 5 * side < soles.length; side++) {
        const [x, y, , yaw, load] = soles.subarray(5 * side, 5 * side + 5);
        if (load > 0) this.landed[side] ??= film.get(this.seen, "time");
        if (load > 0) this.last = { ...this.last, [side]: [x, y, yaw] };
        if (load > 0 || this.landed[side] === undefined) continue;
        this.print(side, this.last[side], this.landed[side], film.get(this.seen, "time"));
        this.landed[side] = undefined;
      }
    }
  }

  print(side, [x, y, yaw], landed, since) {
    if (since - landed < .1) return; // it only brushed the ground
    const { geometry, outline, skin, line } = this.soles[side];
    const print = Object.assign(new THREE.Mesh(geometry, skin), { since }).add(new THREE.LineSegments(outline, line));
    print.position.set(x, y, .0012);
    print.rotation.z = yaw;
    this.printed.push(print);
  }

  /// Forgets what was.
  clear() {
    [this.printed, this.seen] = [[], 0];
    this.landed.fill(undefined);
  }
}

