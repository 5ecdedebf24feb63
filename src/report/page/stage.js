// Light, floor and camera around the scene. Metres, z up.

/** Adds light and floor for a scene that fills `boxes`; returns the function that gives them the page's colours. */
function addStage(THREE, scene3d, boxes) {
  const { root } = scene3d;
  const box = boxes.reduce((all, one) => all.union(one), new THREE.Box3());
  const centre = box.getCenter(new THREE.Vector3());
  const radius = Math.max(0.5, box.getSize(new THREE.Vector3()).length() / 2);

  const sky = new THREE.HemisphereLight(0xffffff, 0xb0b4ba, 1.7);
  sky.position.set(0, 0, 1);
  root.add(sky);
  const sun = new THREE.DirectionalLight(0xffffff, 1.9);
  sun.position.copy(centre).add(new THREE.Vector3(-0.5, -0.7, 1.6).multiplyScalar(radius));
  sun.target.position.copy(centre);
  sun.castShadow = true;
  sun.shadow.mapSize.set(2048, 2048);
  sun.shadow.normalBias = 0.004 * radius;
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

/** Puts the camera in that direction from the content's centre, as near as all of `boxes` is in the picture. */
function fitCamera(THREE, camera, controls, boxes, direction) {
  const whole = boxes.reduce((all, box) => all.union(box), new THREE.Box3());
  const centre = whole.getCenter(new THREE.Vector3());
  camera.position.copy(centre).add(direction);
  camera.lookAt(centre);
  const tanY = Math.tan((camera.fov * Math.PI) / 360);
  const tanX = tanY * camera.aspect;
  const turn = camera.quaternion.clone().invert();
  let distance = 0.3;
  for (const { min, max } of boxes) {
    for (let corner = 0; corner < 8; corner++) {
      const p = new THREE.Vector3(corner & 1 ? min.x : max.x, corner & 2 ? min.y : max.y, corner & 4 ? min.z : max.z);
      p.sub(centre).applyQuaternion(turn);
      distance = Math.max(distance, p.z + Math.abs(p.x) / tanX, p.z + Math.abs(p.y) / tanY);
    }
  }
  camera.position.copy(centre).addScaledVector(direction, (1.08 * distance) / direction.length());
  camera.near = distance / 200;
  camera.far = distance * 20;
  camera.updateProjectionMatrix();
  controls.target.copy(centre);
  controls.update();
}
