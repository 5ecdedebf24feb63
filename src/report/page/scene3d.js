// The scene in three.js: one group for each link and object, whose poses setWorld() writes. Metres, z up.

/** Returns the geometry of a shape; three's long axes lie along y, ours along z. */
function shapeGeometry(THREE, shape) {
  switch (shape.kind) {
    case "box":
      return new THREE.BoxGeometry(...shape.half.map((h) => 2 * h));
    case "cylinder":
      return new THREE.CylinderGeometry(shape.radius, shape.radius, 2 * shape.half_length, 40).rotateX(Math.PI / 2);
    case "capsule":
      return new THREE.CapsuleGeometry(shape.radius, 2 * shape.half_length, 10, 28).rotateX(Math.PI / 2);
    default:
      return new THREE.SphereGeometry(shape.radius, 32, 20);
  }
}

function shapeMesh(THREE, shape, pose, [r, g, b, alpha]) {
  const material = new THREE.MeshStandardMaterial({ roughness: 0.75, transparent: alpha < 1, opacity: alpha });
  material.color.setRGB(r, g, b, THREE.SRGBColorSpace);
  const mesh = new THREE.Mesh(shapeGeometry(THREE, shape), material);
  mesh.castShadow = alpha === 1;
  mesh.receiveShadow = true;
  setPose(mesh, pose);
  return mesh;
}

function setPose(node, pose) {
  node.position.fromArray(pose.position);
  node.quaternion.fromArray(pose.quaternion);
}

/**
 * Returns {root, links, objects, setWorld, setPath, setColours, box}: the scene graph, to which the caller gives a camera.
 * `links[a][l]` and `objects[o]` are three's groups in the world frame.
 */
function buildScene3d(THREE, data) {
  const root = new THREE.Scene();
  const content = new THREE.Group();
  root.add(content);
  const newGroup = () => {
    const group = new THREE.Group();
    content.add(group);
    return group;
  };
  const links = data.agents.map((agent) => {
    const groups = agent.links.map(newGroup);
    for (const body of agent.bodies) groups[body.link].add(shapeMesh(THREE, body.shape, body.pose, body.color));
    return groups;
  });
  const objects = data.objects.map((object) => {
    const group = newGroup();
    for (const part of object.parts) group.add(shapeMesh(THREE, part.shape, part.pose, object.color));
    return group;
  });

  const path = new THREE.Line(new THREE.BufferGeometry(), new THREE.LineBasicMaterial());
  path.frustumCulled = false;
  root.add(path);

  const setWorld = (world) => {
    world.links.forEach((poses, a) => poses.forEach((pose, l) => setPose(links[a][l], pose)));
    world.objects.forEach((pose, o) => setPose(objects[o], pose));
    root.updateMatrixWorld(true);
  };
  const setPath = (points) => {
    path.geometry.dispose();
    path.geometry = new THREE.BufferGeometry();
    path.geometry.setAttribute("position", new THREE.Float32BufferAttribute(points.flat(), 3));
    path.visible = points.length > 1;
  };
  return { root, links, objects, path, setWorld, setPath, box: () => new THREE.Box3().setFromObject(content) };
}

/** Adds light and floor for a scene that fills `box`; returns the function that gives them the page's colours. */
function addStage(THREE, scene3d, box) {
  const { root } = scene3d;
  const centre = box.getCenter(new THREE.Vector3());
  const radius = Math.max(0.5, box.getSize(new THREE.Vector3()).length() / 2);

  root.add(new THREE.HemisphereLight(0xffffff, 0x8a8f98, 1.7));
  root.children[root.children.length - 1].position.set(0, 0, 1);
  const sun = new THREE.DirectionalLight(0xffffff, 1.9);
  sun.position.copy(centre).add(new THREE.Vector3(-0.5, -0.7, 1.6).multiplyScalar(radius));
  sun.target.position.copy(centre);
  sun.castShadow = true;
  sun.shadow.mapSize.set(2048, 2048);
  sun.shadow.normalBias = 0.01 * radius;
  const reach = sun.shadow.camera;
  reach.left = reach.bottom = -1.2 * radius;
  reach.right = reach.top = 1.2 * radius;
  reach.near = 0.05 * radius;
  reach.far = 4 * radius;
  root.add(sun, sun.target);

  // A floor of whole metres about the scene; squares of half a metre.
  const metres = 2 * Math.ceil(radius * 1.4 + 0.5);
  const floor = new THREE.Mesh(new THREE.PlaneGeometry(metres, metres), new THREE.ShadowMaterial({ opacity: 0.25 }));
  floor.receiveShadow = true;
  let grid = null;
  const place = (node, z) => node.position.set(Math.round(centre.x), Math.round(centre.y), z);
  place(floor, -0.002);
  root.add(floor);

  return (colour) => {
    root.background = new THREE.Color(colour("--scene"));
    scene3d.path.material.color.set(colour("--trace"));
    if (grid) {
      root.remove(grid);
      grid.geometry.dispose();
      grid.material.dispose();
    }
    grid = new THREE.GridHelper(metres, 2 * metres, colour("--axis"), colour("--grid"));
    grid.rotateX(Math.PI / 2);
    place(grid, -0.001);
    root.add(grid);
  };
}

/** Moves the camera back along its own direction until the whole box is in the picture. */
function fitCamera(THREE, camera, controls, box, direction) {
  const centre = box.getCenter(new THREE.Vector3());
  const half = box.getSize(new THREE.Vector3()).multiplyScalar(0.5);
  camera.position.copy(centre).add(direction);
  camera.lookAt(centre);
  const tanY = Math.tan((camera.fov * Math.PI) / 360);
  const tanX = tanY * camera.aspect;
  const turn = camera.quaternion.clone().invert();
  let distance = 0.3;
  for (let corner = 0; corner < 8; corner++) {
    const p = new THREE.Vector3(corner & 1 ? half.x : -half.x, corner & 2 ? half.y : -half.y, corner & 4 ? half.z : -half.z);
    p.applyQuaternion(turn);
    distance = Math.max(distance, p.z + Math.abs(p.x) / tanX, p.z + Math.abs(p.y) / tanY);
  }
  camera.position.copy(centre).addScaledVector(direction, (1.05 * distance) / direction.length());
  camera.near = distance / 200;
  camera.far = distance * 20;
  camera.updateProjectionMatrix();
  controls.target.copy(centre);
  controls.update();
}
