// The robot: a group per body in the group of its parent body, so that a joint moves the whole subtree.
class Robot {
  constructor(runInfo) {
    this.runInfo = runInfo;
    this.bodies = runInfo.bodies.map(() => new THREE.Group());
    this.materials = runInfo.bodies.map((body) => new THREE.MeshStandardMaterial({ color: Robot.colour(body.name), roughness: .6 }));
    const number = new Map(runInfo.bodies.map((body, index) => [body.name, index]));
    this.joints = [];
    runInfo.bodies.forEach((body, index) => {
      const group = this.bodies[index], material = this.materials[index];
      this.meshesOf(body, material).forEach((mesh) => { mesh.castShadow = true; group.add(mesh); });
      if (!body.joint) { this.base = group; return; }
      const { parent, axis, at, kind } = body.joint;
      const joint = { group, axis: new THREE.Vector3(...axis).normalize(), at: new THREE.Vector3(...at), slides: kind === "prismatic" };
      this.joints.push(joint);
      this.bodies[number.get(parent)].add(group);
      if (!joint.slides) group.add(this.axleMesh(joint.axis));
    });
  }

  // Colours of left and right as in the figures.
  static colour(name) {
    return name.startsWith("left") ? "#3f8fdc" : name.startsWith("right") ? "#e07b35" : "#93a1b0";
  }

  meshesOf(body, material) {
    const meshes = body.spheres?.map((ball) => {
      const mesh = new THREE.Mesh(new THREE.SphereGeometry(ball.radius, 32, 16), material);
      mesh.position.set(...ball.at);
      return mesh;
    }) ?? [];
    if (body.size.some((side) => side > 0)) {
      const box = new THREE.BoxGeometry(...body.size.map((side) => Math.max(side, .004)));
      const mesh = new THREE.Mesh(box, material);
      mesh.position.set(...body.com);
      mesh.add(new THREE.LineSegments(new THREE.EdgesGeometry(box), new THREE.LineBasicMaterial({ color: "#1b222b", transparent: true, opacity: .35 })));
      meshes.push(mesh);
    }
    return meshes;
  }

  axleMesh(axis) {
    const mesh = new THREE.Mesh(new THREE.CylinderGeometry(.016, .016, .062, 20), new THREE.MeshStandardMaterial({ color: "#47515d", roughness: .4 }));
    mesh.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), axis);
    return mesh;
  }

  // Sets the pose, interpolated between a row and the next.
  pose(trajectory, row, fraction) {
    const next = Math.min(row + 1, trajectory.length - 1);
    const interpolated = (name, index) => (1 - fraction) * trajectory.get(row, name, index) + fraction * trajectory.get(next, name, index);
    this.base.position.set(...[0, 1, 2].map((index) => interpolated("position", index)));
    const orientation = (row) => { const [w, x, y, z] = trajectory.all(row, "orientation"); return new THREE.Quaternion(x, y, z, w); };
    this.base.quaternion.copy(orientation(row)).slerp(orientation(next), fraction);
    this.joints.forEach(({ group, axis, at, slides }, index) => {
      const position = index < trajectory.count("angle") ? interpolated("angle", index) : 0;
      group.position.copy(at);
      if (slides) group.position.addScaledVector(axis, position); else group.quaternion.setFromAxisAngle(axis, position);
    });
    this.base.updateMatrixWorld(true);
    const soles = trajectory.all(row, "soles");
    this.runInfo.feet.forEach((foot, side) => {
      const material = this.materials[foot.body];
      material.emissive.copy(material.color); // a loaded foot is brighter
      material.emissiveIntensity = soles[5 * side + 4] > 0 ? .6 : 0;
    });
  }

  // Centre of gravity of a body in W.
  centre(body) {
    return this.bodies[body].localToWorld(new THREE.Vector3(...this.runInfo.bodies[body].com));
  }

  // Contact points in W.
  contacts() {
    return this.runInfo.contacts.map(({ body, at, radius }) => {
      const point = this.bodies[body].localToWorld(new THREE.Vector3(...at));
      point.z -= radius;
      return point;
    });
  }
}

