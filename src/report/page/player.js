// The page: list, player, names and keys around the scene. Drawn only when something changes.

const byId = (id) => document.getElementById(id);
const seconds = (t) => `${t.toFixed(1)} s`;

/** Returns a new element with that text. */
function element(tag, className, text) {
  const node = document.createElement(tag);
  node.className = className;
  node.textContent = text;
  return node;
}

function showMessage(text) {
  const box = byId("message");
  box.textContent = text;
  box.hidden = false;
}

/** Unpacks the bundled three.js and returns its namespace. */
async function loadThree() {
  const bytes = Uint8Array.from(atob(byId("three-data").textContent), (c) => c.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  const script = document.createElement("script");
  script.textContent = await new Response(stream).text(); // Sets the global THREE.
  document.head.append(script);
  return globalThis.THREE;
}

/** Returns {draw, objectPose, linkPose, ...}: the 3D view, which draws nothing where there is no WebGL. */
function buildView(THREE, scene) {
  const scene3d = buildScene3d(THREE, scene);
  const canvas = byId("canvas");
  const context = canvas.getContext("webgl2", { antialias: true });
  if (!context) showMessage("This browser has no WebGL 2, so there is no picture.\nThe list and the times are as they should be.");
  const camera = new THREE.PerspectiveCamera(40, 1, 0.01, 100);
  camera.up.set(0, 0, 1);
  const controls = new THREE.OrbitControls(camera, canvas);
  const view = { THREE, scene, scene3d, camera, controls, renderer: null };
  if (context) {
    view.renderer = new THREE.WebGLRenderer({ canvas, context });
    view.renderer.shadowMap.enabled = true;
    view.renderer.shadowMap.type = THREE.PCFShadowMap;
  }
  view.names = [...scene.agents.map((agent, i) => [agent.id, scene3d.links[i]]), ...scene.objects.map((object, i) => [object.id, [scene3d.objects[i]]])].map(
    ([id, groups]) => {
      const label = element("span", "", id);
      byId("names").append(label);
      return { label, groups };
    },
  );
  return view;
}

/** Draws the scene and puts each name over its owner. */
function draw(view) {
  const { THREE, camera, renderer, scene3d } = view;
  if (!renderer) return;
  renderer.render(scene3d.root, camera);
  const shown = byId("show-names").checked;
  const { clientWidth: width, clientHeight: height } = renderer.domElement;
  for (const { label, groups } of view.names) {
    const box = new THREE.Box3();
    for (const group of groups) box.expandByObject(group);
    const top = box.getCenter(new THREE.Vector3()).setZ(box.max.z).project(camera);
    label.hidden = !shown || box.isEmpty() || Math.abs(top.z) > 1;
    label.style.transform = `translate(${((top.x + 1) * width) / 2}px, ${((1 - top.y) * height) / 2 - 4}px) translate(-50%, -100%)`;
  }
}

/** Fills the list with the plan's actions; returns their buttons. */
function listActions(plan, jump) {
  return plan.actions.map((action) => {
    const button = element("button", "", "");
    button.type = "button";
    const what = element("span", "what", `(${action.arguments.join(", ")})`);
    what.prepend(element("b", "", action.name));
    button.append(what, element("span", "when", `${action.start.toFixed(1)} – ${seconds(action.end)} · ${action.agents.join(", ")}`));
    button.addEventListener("click", () => jump(action.start));
    const item = document.createElement("li");
    item.append(button);
    byId("list").append(item);
    return button;
  });
}

/** Fills the list with what is there, for a world without a plan. */
function listEntities(scene) {
  byId("list").setAttribute("aria-label", "What is there");
  const kinds = { robot: "robot", human: "human" };
  const entries = [...scene.agents.map((a) => [a.id, kinds[a.kind]]), ...scene.objects.map((o) => [o.id, o.movable ? "movable" : "fixed"])];
  for (const [id, kind] of entries) {
    const item = element("li", "entity", "");
    item.append(element("span", "what", id), element("span", "when", kind));
    byId("list").append(item);
  }
}

async function main() {
  const scene = JSON.parse(byId("scene-data").textContent);
  const plan = JSON.parse(byId("plan-data").textContent);
  const timeline = buildTimeline(scene, plan);
  const view = buildView(await loadThree(), scene);
  const { scene3d, camera, controls } = view;

  let time = 0;
  let playing = false;
  let drawPending = false;
  const requestDraw = () => {
    if (drawPending) return;
    drawPending = true;
    requestAnimationFrame(() => {
      drawPending = false;
      draw(view);
    });
  };

  const buttons = plan ? listActions(plan, (t) => setTime(t)) : [];
  if (!plan) listEntities(scene);
  byId("summary").textContent = plan
    ? `${plan.task} · ${plan.actions.length} actions · ${seconds(timeline.duration)} · cost ${Number(plan.cost.toPrecision(4))}`
    : "The world at its start";
  byId("player").hidden = !plan;
  byId("time").max = timeline.duration;
  if (timeline.problems.length > 0) showMessage(`The plan does not fit this world:\n${[...new Set(timeline.problems)].join("\n")}`);

  let pathOf = null;
  const showActions = () => {
    if (!plan) return;
    const current = plan.actions.filter((action) => isCurrent(action, timeline, time));
    buttons.forEach((button, i) => {
      const on = current.includes(plan.actions[i]);
      if (on && !button.hasAttribute("aria-current")) button.scrollIntoView({ block: "nearest" });
      if (on) button.setAttribute("aria-current", "step");
      else button.removeAttribute("aria-current");
    });
    const now = current.map((action) => {
      const segment = segmentAt(timeline, action, time);
      return `${action.name}(${action.arguments.join(", ")})${segment ? ` · ${segment.name}` : ""}`;
    });
    byId("now").textContent = now.join("   |   ");
    byId("time").setAttribute("aria-valuetext", `${seconds(time)} ${now.join("; ")}`);
    const moving = current.find((action) => action.geometry) ?? null;
    if (moving !== pathOf) scene3d.setPath(moving ? toolPath(scene, timeline, moving) : []);
    pathOf = moving;
  };

  function setTime(t) {
    time = Math.min(Math.max(Number.isFinite(t) ? t : 0, 0), timeline.duration);
    scene3d.setWorld(worldAt(scene, timeline, time));
    byId("time").value = time;
    byId("clock").textContent = `${time.toFixed(2)} / ${seconds(timeline.duration)}`;
    showActions();
    requestDraw();
  }

  function setPlaying(on) {
    playing = on && timeline.duration > 0;
    byId("play").setAttribute("aria-pressed", String(playing));
    byId("play").setAttribute("aria-label", playing ? "Pause" : "Play");
    if (!playing) return;
    if (time >= timeline.duration) setTime(0);
    let last = performance.now();
    const step = (now) => {
      if (!playing) return;
      setTime(time + (Math.max(0, now - last) / 1000) * Number(byId("speed").value));
      last = now;
      if (time >= timeline.duration) setPlaying(false);
      else requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  }

  const seek = (t) => {
    setPlaying(false);
    setTime(t);
  };
  const fromAddress = () => {
    const match = /(?:^#|&)t=([\d.]+)/.exec(location.hash);
    if (match) seek(Number(match[1]));
  };

  scene3d.setWorld(worldAt(scene, timeline, 0));
  const paint = addStage(view.THREE, scene3d, scene3d.box());
  const fit = () => fitCamera(view.THREE, camera, controls, scene3d.box(), new view.THREE.Vector3(0.45, -1, 0.6));
  const repaint = () => {
    const style = getComputedStyle(document.documentElement);
    paint((name) => style.getPropertyValue(name).trim());
    requestDraw();
  };
  const resize = () => {
    const { clientWidth, clientHeight } = byId("view");
    camera.aspect = clientWidth / Math.max(1, clientHeight);
    camera.updateProjectionMatrix();
    view.renderer?.setPixelRatio(Math.min(devicePixelRatio, 2));
    view.renderer?.setSize(clientWidth, clientHeight, false);
    if (view.renderer) draw(view);
  };
  resize();
  fit();
  repaint();
  setTime(0);
  fromAddress();

  new ResizeObserver(resize).observe(byId("view"));
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", repaint);
  addEventListener("hashchange", fromAddress);
  controls.addEventListener("change", requestDraw);
  byId("fit").addEventListener("click", fit);
  byId("show-names").addEventListener("change", requestDraw);
  byId("play").addEventListener("click", () => setPlaying(!playing));
  byId("time").addEventListener("input", () => seek(Number(byId("time").value)));
  addEventListener("keydown", (event) => {
    const { key, target } = event;
    if (!plan || event.ctrlKey || event.metaKey || event.altKey || target.tagName === "SELECT") return;
    const moves = { ArrowLeft: time - 0.1, ArrowRight: time + 0.1, Home: 0, End: timeline.duration };
    if (key === " " && !["BUTTON", "INPUT"].includes(target.tagName)) setPlaying(!playing);
    else if (key === " " && target === byId("time")) setPlaying(!playing);
    else if (key in moves) seek(event.shiftKey && key.startsWith("Arrow") ? time + 10 * (moves[key] - time) : moves[key]);
    else return;
    event.preventDefault();
  });

  // For tests and for curious readers: what the scene graph shows, in the world frame.
  const worldPose = (node) => ({
    position: node.getWorldPosition(new view.THREE.Vector3()).toArray(),
    quaternion: node.getWorldQuaternion(new view.THREE.Quaternion()).toArray(),
  });
  globalThis.sgap = {
    ready: true,
    duration: timeline.duration,
    setTime: seek,
    objectPose: (id) => worldPose(scene3d.objects[scene.objects.findIndex((o) => o.id === id)]),
    linkPose: (agentId, link) => {
      const a = scene.agents.findIndex((agent) => agent.id === agentId);
      return worldPose(scene3d.links[a][scene.agents[a].links.indexOf(link)]);
    },
  };
  dispatchEvent(new Event("sgap-ready"));
}

main().catch((error) => {
  showMessage(`The scene can't be shown: ${error.message}`);
  throw error;
});
