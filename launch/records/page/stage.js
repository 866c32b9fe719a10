// The 3-D scene: ground, light, and a camera that orbits, pans and follows.

// A grid on the ground. It consists of short lines, because some renderers omit long lines that begin behind the camera.
function gridGeometry(count, side) {
  const ends = [];
  for (let x = 0; x < count; x++) {
    for (let y = 0; y < count; y++) ends.push(x, y, 0, x + 1, y, 0, x, y, 0, x, y + 1, 0);
  }
  const positions = new THREE.Float32BufferAttribute(ends, 3);
  return new THREE.BufferGeometry().setAttribute("position", positions).translate(-count / 2, -count / 2, 0).scale(side, side, 1);
}

const TILE_THICKNESS = .2; // below the lower of the tile and the plane z = 0 [m]

// Boxes with their tops at the heights of the tiles. They are one object, because drawing thousands of objects is slow.
function tileGroup(tiles, material, edge) {
  const faces = { position: [], normal: [] }, edges = [];
  for (const { x, y, height } of tiles) {
    const bottom = Math.min(height, 0) - TILE_THICKNESS;
    const box = new THREE.BoxGeometry(x[1] - x[0], y[1] - y[0], height - bottom);
    box.translate((x[0] + x[1]) / 2, (y[0] + y[1]) / 2, (height + bottom) / 2);
    for (const [name, values] of Object.entries(faces)) values.push(...box.toNonIndexed().getAttribute(name).array);
    edges.push(...new THREE.EdgesGeometry(box).getAttribute("position").array);
  }
  const geometry = new THREE.BufferGeometry();
  for (const [name, values] of Object.entries(faces)) geometry.setAttribute(name, new THREE.Float32BufferAttribute(values, 3));
  const mesh = new THREE.Mesh(geometry, material);
  mesh.receiveShadow = true;
  const lines = new THREE.BufferGeometry().setAttribute("position", new THREE.Float32BufferAttribute(edges, 3));
  return new THREE.Group().add(mesh, new THREE.LineSegments(lines, edge));
}

const TOUCH_RADIUS = 14; // a touch selects a body within this distance [px]

class Stage {
  constructor(container, robot, markers, tiles) {
    this.robot = robot;
    this.renderer = new THREE.WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
    this.renderer.debug.checkShaderErrors = false; // the check waits for the compilation of every shader
    this.renderer.shadowMap.enabled = true;
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    container.prepend(this.renderer.domElement);
    this.scene = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(32, 1, .1, 40);
    this.camera.up.set(0, 0, 1);
    this.controls = new THREE.OrbitControls(this.camera, this.renderer.domElement);
    this.controls.maxPolarAngle = 1.55;
    this.controls.addEventListener("change", () => { this.isStale = true; });
    this.controls.target.set(0, 0, .26);
    this.ray = new THREE.Raycaster();
    this.sun = new THREE.DirectionalLight("#ffffff", 2.2);
    this.sun.castShadow = true;
    this.sun.shadow.mapSize.set(1024, 1024);
    Object.assign(this.sun.shadow.camera, { left: -.8, right: .8, top: .8, bottom: -.8, near: .5, far: 6 });
    this.sky = new THREE.HemisphereLight("#ffffff", "#8d98a5", 1.6);
    this.ground = new THREE.Mesh(new THREE.PlaneGeometry(40, 40), new THREE.MeshStandardMaterial({ roughness: 1, depthWrite: false }));
    this.ground.renderOrder = -2; // objects on the ground are drawn after it, in this order
    this.ground.receiveShadow = true;
    this.tile = new THREE.MeshStandardMaterial({ roughness: 1 });
    this.tileEdge = new THREE.LineBasicMaterial();
    this.scene.add(tileGroup(tiles, this.tile, this.tileEdge));
    this.scene.add(robot.base, markers.group, this.sun, this.sun.target, this.sky, this.ground);
    this.lookFrom(1, -2.2, .9);
    whenThemed(() => this.applyTheme());
    new ResizeObserver(() => this.resize(container.clientWidth, container.clientHeight)).observe(container);
  }

  applyTheme() {
    this.scene.background = new THREE.Color(isDark() ? "#12161b" : "#eef1f4");
    [this.ground.material, this.tile].forEach((material) => material.color.set(isDark() ? "#20262e" : "#ffffff"));
    this.tileEdge.color.set(isDark() ? "#5b6876" : "#a3adb8");
    if (this.grid) this.scene.remove(this.grid);
    const line = isDark() ? "#38424e" : "#ccd3da";
    this.grid = new THREE.LineSegments(gridGeometry(80, .1), new THREE.LineBasicMaterial({ color: line, depthWrite: false }));
    this.grid.renderOrder = -1;
    this.scene.add(this.grid);
    this.isStale = true;
  }

  // Moves the camera, so that it looks at the robot from a direction.
  lookFrom(x, y, z) {
    const far = Math.max(1, .75 / Math.max(this.camera.aspect, .4));
    this.camera.position.copy(this.controls.target).add(new THREE.Vector3(x, y, z).multiplyScalar(.72 * far));
    this.controls.update();
    this.isStale = true;
  }

  resize(width, height) {
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.isStale = true;
  }

  // Index of the body at a pointer. A touch need not hit it exactly.
  bodyAt({ clientX, clientY, pointerType }) {
    const { left, top, width, height } = this.renderer.domElement.getBoundingClientRect();
    const reach = pointerType === "touch" ? TOUCH_RADIUS : 0;
    for (const [dx, dy] of reach ? [[0, 0], [reach, 0], [-reach, 0], [0, reach], [0, -reach]] : [[0, 0]]) {
      this.ray.setFromCamera({ x: 2 * (clientX + dx - left) / width - 1, y: 1 - 2 * (clientY + dy - top) / height }, this.camera);
      let part = this.ray.intersectObject(this.robot.base).find(({ object }) => object.isMesh)?.object;
      while (part && !this.robot.bodies.includes(part)) part = part.parent;
      if (part) return this.robot.bodies.indexOf(part);
    }
    return undefined;
  }

  // Converts an offset on the screen [px] to an offset in W, in the plane parallel to the screen through a point.
  worldOffset(dx, dy, point) {
    const { camera } = this, { clientHeight } = this.renderer.domElement;
    const depth = -point.clone().applyMatrix4(camera.matrixWorldInverse).z;
    const metres = 2 * depth * Math.tan(camera.fov * Math.PI / 360) / clientHeight;
    const [right, up] = [0, 1].map((column) => new THREE.Vector3().setFromMatrixColumn(camera.matrixWorld, column));
    return right.multiplyScalar(dx * metres).addScaledVector(up, -dy * metres);
  }

  // Position of a point in W on the screen [px].
  onScreen(point) {
    const { clientWidth, clientHeight } = this.renderer.domElement, { x, y } = point.clone().project(this.camera);
    return [(1 + x) / 2 * clientWidth, (1 - y) / 2 * clientHeight];
  }

  // How a direction in W at a point appears on the screen: its angle, clockwise from the right [rad], and its component
  // towards the camera.
  screenDirection(from, direction) {
    const sight = this.camera.position.clone().sub(from).normalize(), depth = direction.clone().normalize().dot(sight);
    const [[x, y], [toX, toY]] = [from, from.clone().addScaledVector(direction, .1)].map((point) => this.onScreen(point));
    return { angle: Math.atan2(toY - y, toX - x), depth };
  }

  // Moves the camera with a point on the ground.
  follow(x, y) {
    const move = new THREE.Vector3(x - this.controls.target.x, y - this.controls.target.y, 0);
    this.camera.position.add(move);
    this.controls.target.add(move);
  }

  draw(com) {
    const [x, y] = com;
    this.sun.target.position.set(x, y, .2);
    this.sun.position.set(x + .9, y - 1.3, 2.2);
    [this.ground, this.grid].forEach((part) => { part.position.x = Math.round(x * 5) / 5; part.position.y = Math.round(y * 5) / 5; });
    this.renderer.render(this.scene, this.camera);
    this.shown ??= requestAnimationFrame(() => performance.mark("open")); // the first picture is visible
    this.isStale = false;
  }
}

