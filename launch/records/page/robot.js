// The robot: a group for each body, hung into that of its parent, so that turning joints moves all that hangs from them.
class Robot {
  constructor(about) {
    this.about = about;
    this.bodies = about.bodies.map(() => new THREE.Group());
    this.skins = about.bodies.map((body) => new THREE.MeshStandardMaterial({ color: Robot.colour(body.name), roughness: .6 }));
    const number = new Map(about.bodies.map((body, index) => [body.name, index]));
    this.joints = [];
    about.bodies.forEach((body, index) => {
      const group = this.bodies[index], skin = this.skins[index];
      this.shape(body, skin).forEach((mesh) => { mesh.castShadow = true; group.add(mesh); });
      if (!body.joint) { this.base = group; return; }
      const { parent, axis, at, kind } = body.joint;
      const joint = { group, axis: new THREE.Vector3(...axis).normalize(), at: new THREE.Vector3(...at), slides: kind === "prismatic" };
      this.joints.push(joint);
      this.bodies[number.get(parent)].add(group);
      if (!joint.slides) group.add(this.axle(joint.axis));
    });
  }

  /// Left and right as in the figures.
  static colour(name) {
    return name.startsWith("left") ? "#3f8fdc" : name.startsWith("right") ? "#e07b35" : "#93a1b0";
  }

  shape(body, skin) {
    const meshes = body.spheres?.map((ball) => {
      const mesh = new THREE.Mesh(new THREE.SphereGeometry(ball.radius, 32, 16), skin);
      mesh.position.set(...ball.at);
      return mesh;
    }) ?? [];
    if (body.size.some((side) => side > 0)) {
      const box = new THREE.BoxGeometry(...body.size.map((side) => Math.max(side, .004)));
      const mesh = new THREE.Mesh(box, skin);
      mesh.position.set(...body.com);
      mesh.add(new THREE.LineSegments(new THREE.EdgesGeometry(box), new THREE.LineBasicMaterial({ color: "#1b222b", transparent: true, opacity: .35 })));
      meshes.push(mesh);
    }
    return meshes;
  }

  axle(axis) {
    const mesh = new THREE.Mesh(new THREE.CylinderGeometry(.016, .016, .062, 20), new THREE.MeshStandardMaterial({ color: "#47515d", roughness: .4 }));
    mesh.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), axis);
    return mesh;
  }

  /// Takes the pose between two rows.
  pose(film, row, share) {
    const next = Math.min(row + 1, film.length - 1);
    const between = (name, index) => (1 - share) * film.get(row, name, index) + share * film.get(next, name, index);
    this.base.position.set(...[0, 1, 2].map((index) => between("position", index)));
    const turn = (row) => { const [w, x, y, z] = film.all(row, "orientation"); return new THREE.Quaternion(x, y, z, w); };
    this.base.quaternion.copy(turn(row)).slerp(turn(next), share);
    this.joints.forEach(({ group, axis, at, slides }, index) => {
      const travel = index < film.count("angle") ? between("angle", index) : 0;
      group.position.copy(at);
      if (slides) group.position.addScaledVector(axis, travel); else group.quaternion.setFromAxisAngle(axis, travel);
    });
    this.base.updateMatrixWorld(true);
    const soles = film.all(row, "soles");
    this.about.feet.forEach((foot, side) => {
      const skin = this.skins[foot.body];
      skin.emissive.copy(skin.color); // what carries shines
      skin.emissiveIntensity = soles[5 * side + 4] > 0 ? .6 : 0;
    });
  }

  /// The centre of gravity of a body, in W.
  centre(body) {
    return this.bodies[body].localToWorld(new THREE.Vector3(...this.about.bodies[body].com));
  }

  /// Where contact points touch, in W.
  contacts() {
    return this.about.contacts.map(({ body, at, radius }) => {
      const place = this.bodies[body].localToWorld(new THREE.Vector3(...at));
      place.z -= radius;
      return place;
    });
  }
}

