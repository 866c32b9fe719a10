// Markers in the picture: contact forces, centre of gravity and its projection, zero-moment point, footprints.
const METRES_PER_NEWTON = 2e-3; // scale of the force arrows
const MIN_ARROW = 1e-3; // a shorter arrow is hidden [m]
const MIN_STANCE = .1; // a shorter ground contact leaves no footprint [s]
const PRINT_RANGE = 4; // footprints are shown up to this distance from the robot [m]

class Markers {
  constructor(runInfo) {
    this.group = new THREE.Group();
    this.runInfo = runInfo;
    this.arrows = runInfo.contacts.map(() => Markers.arrow("#d1242f"));
    this.forces = new THREE.Group().add(...this.arrows);
    this.com = Markers.dot(new THREE.SphereGeometry(.013, 24, 16), "#8e5bd6");
    this.projection = Markers.dot(new THREE.RingGeometry(.010, .016, 32), "#8e5bd6");
    this.zmp = Markers.dot(new THREE.CircleGeometry(.009, 24), "#d1242f");
    const line = new THREE.BufferGeometry().setAttribute("position", new THREE.Float32BufferAttribute(6, 3));
    this.plumb = new THREE.Line(line, new THREE.LineBasicMaterial({ color: "#8e5bd6" }));
    this.plumb.frustumCulled = false;
    [this.com, this.plumb].forEach((part) => { part.material.depthTest = false; part.renderOrder = 9; }); // visible through the body
    this.prints = new THREE.Group();
    this.soles = runInfo.feet.map(({ half, body }) => {
      const geometry = new THREE.PlaneGeometry(2 * half[0], 2 * half[1]), color = Robot.colour(runInfo.bodies[body].name);
      const material = new THREE.MeshBasicMaterial({ color, transparent: true, opacity: .13, depthWrite: false });
      return { geometry, material, outline: new THREE.EdgesGeometry(geometry), line: new THREE.LineBasicMaterial({ color }) };
    });
    [this.allPrints, this.seen] = [[], 0]; // all footprints (`this.prints` contains the visible ones), number of processed rows
    this.landingTimes = runInfo.feet.map(() => undefined);
    this.group.add(this.forces, this.com, this.projection, this.zmp, this.plumb, this.prints);
  }

  static dot(geometry, color) {
    return new THREE.Mesh(geometry, new THREE.MeshBasicMaterial({ color }));
  }

  // An arrow of one metre length along z.
  static arrow(color, width = 1) {
    const material = new THREE.MeshBasicMaterial({ color });
    const shaft = new THREE.Mesh(new THREE.CylinderGeometry(.0032 * width, .0032 * width, 1, 10).translate(0, .5, 0).rotateX(Math.PI / 2), material);
    const head = new THREE.Mesh(new THREE.ConeGeometry(.009 * width, .024 * width, 14).rotateX(Math.PI / 2), material);
    return Object.assign(new THREE.Group().add(shaft, head), { shaft, head });
  }

  // Places an arrow at a point, with a direction and a length.
  static point(arrow, from, direction, length) {
    arrow.position.copy(from);
    arrow.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), direction.clone().normalize());
    arrow.shaft.scale.z = length;
    arrow.head.position.z = length;
  }

  show(trajectory, row, fraction, robot) {
    const points = robot.contacts(), forces = trajectory.all(row, "force");
    this.arrows.forEach((arrow, index) => {
      const force = new THREE.Vector3(...forces.subarray(3 * index, 3 * index + 3)), length = force.length() * METRES_PER_NEWTON;
      arrow.visible = length > MIN_ARROW;
      if (arrow.visible) Markers.point(arrow, points[index], force, length);
    });
    const next = Math.min(row + 1, trajectory.length - 1);
    const com = [0, 1, 2].map((index) => (1 - fraction) * trajectory.get(row, "com", index) + fraction * trajectory.get(next, "com", index));
    this.com.position.set(...com);
    this.projection.position.set(com[0], com[1], .002);
    this.plumb.geometry.attributes.position.array.set([...com, com[0], com[1], 0]);
    this.plumb.geometry.attributes.position.needsUpdate = true;
    const [x, y] = trajectory.all(row, "zmp");
    this.zmp.visible = Number.isFinite(x);
    this.zmp.position.set(x, y, .003);
    this.addFootprints(trajectory);
    const time = trajectory.get(row, "time");
    this.prints.clear();
    this.allPrints.filter(({ since, position }) => since <= time && Math.abs(position.x - com[0]) < PRINT_RANGE).forEach((print) => this.prints.add(print));
  }

  // Adds a footprint for every stance that ended in the rows since the last call.
  addFootprints(trajectory) {
    for (; this.seen < trajectory.length; this.seen++) {
      const soles = trajectory.all(this.seen, "soles");
      for (let side = 0; 5 * side < soles.length; side++) {
        const [x, y, z, yaw, load] = soles.subarray(5 * side, 5 * side + 5);
        if (load > 0) this.landingTimes[side] ??= trajectory.get(this.seen, "time");
        if (load > 0) this.last = { ...this.last, [side]: [x, y, z, yaw] };
        if (load > 0 || this.landingTimes[side] === undefined) continue;
        this.print(side, this.last[side], this.landingTimes[side], trajectory.get(this.seen, "time"));
        this.landingTimes[side] = undefined;
      }
    }
  }

  print(side, [x, y, z, yaw], landed, since) {
    if (since - landed < MIN_STANCE) return;
    const { geometry, outline, material, line } = this.soles[side];
    const print = Object.assign(new THREE.Mesh(geometry, material), { since }).add(new THREE.LineSegments(outline, line));
    print.position.set(x, y, z + .0012);
    print.rotation.z = yaw;
    this.allPrints.push(print);
  }

  // Removes all footprints.
  clear() {
    [this.allPrints, this.seen] = [[], 0];
    this.landingTimes.fill(undefined);
  }
}

