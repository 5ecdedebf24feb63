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
    case "hull": {
      // Each triangle has corners of its own, so that the faces look flat.
      const corner = (i) => new THREE.Vector3().fromArray(shape.vertices[i]);
      const geometry = new THREE.BufferGeometry().setFromPoints(shape.triangles.flat().map(corner));
      geometry.computeVertexNormals();
      return geometry;
    }
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
 * Returns {root, links, objects, path, setWorld, setPath, boxes}: the scene graph, without light and floor.
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

  const path = new THREE.Mesh(new THREE.BufferGeometry(), new THREE.MeshBasicMaterial());
  root.add(path);

  const setWorld = (world) => {
    world.links.forEach((poses, a) => poses.forEach((pose, l) => setPose(links[a][l], pose)));
    world.objects.forEach((pose, o) => setPose(objects[o], pose));
    root.updateMatrixWorld(true);
  };
  const setPath = (points) => {
    path.geometry.dispose();
    path.visible = false;
    // A tube has no direction where points coincide: half a millimetre at least.
    const apart = [];
    for (const point of points.map((p) => new THREE.Vector3(...p))) {
      if (apart.length === 0 || point.distanceTo(apart[apart.length - 1]) > 5e-4) apart.push(point);
    }
    if (apart.length < 2) return;
    path.geometry = new THREE.TubeGeometry(new THREE.CatmullRomCurve3(apart, false, "centripetal"), 2 * apart.length, 0.003, 6);
    path.visible = true;
  };
  // One about each link and object that has a shape, in the world frame.
  const boxes = () => content.children.map((group) => new THREE.Box3().setFromObject(group)).filter((box) => !box.isEmpty());
  return { root, links, objects, path, setWorld, setPath, boxes };
}
