// What stands around the scene: list, names, player and keys. The picture is drawn only when something changes.

const byId = (id) => document.getElementById(id);
const seconds = (t) => `${t.toFixed(1)} s`;
const call = (action) => `${action.name}(${action.arguments.join(", ")})`;

/** Returns a new element with that text. */
function element(tag, className, text) {
  const node = document.createElement(tag);
  node.className = className;
  node.textContent = text;
  return node;
}

/** Shows the text over the picture, below what is shown already. */
function showMessage(text) {
  const box = byId("message");
  box.append(element("p", "", text));
  box.hidden = false;
}

/** Unpacks the bundled three.js and returns its namespace. */
async function loadThree() {
  const bytes = Uint8Array.from(atob(byId("three-data").textContent), (c) => c.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  const script = document.createElement("script");
  script.textContent = await new Response(stream).text(); // It sets the global THREE.
  document.head.append(script);
  return globalThis.THREE;
}

/** Returns {scene3d, requestDraw}: the picture. There is no renderer where there is no WebGL. */
function buildView(THREE, scene) {
  const scene3d = buildScene3d(THREE, scene);
  scene3d.setWorld(worldAt(scene, buildTimeline(scene, null), 0));
  const canvas = byId("canvas");
  const context = canvas.getContext("webgl2", { antialias: true });
  const camera = new THREE.PerspectiveCamera(40, 1, 0.01, 100);
  camera.up.set(0, 0, 1);
  const controls = new THREE.OrbitControls(camera, canvas);
  const renderer = context && new THREE.WebGLRenderer({ canvas, context });
  if (renderer) {
    renderer.shadowMap.enabled = true;
    renderer.shadowMap.type = THREE.PCFShadowMap;
  } else {
    byId("names").hidden = byId("tools").hidden = true;
    showMessage("This browser has no WebGL 2, so there is no picture.\nThe list and the times are as they should be.");
  }

  const names = addNames(scene, scene3d);
  const draw = () => {
    if (!renderer) return;
    renderer.render(scene3d.root, camera);
    placeNames(THREE, names, camera, canvas);
  };
  let pending = false;
  const requestDraw = () => {
    if (!pending) requestAnimationFrame(() => ((pending = false), draw()));
    pending = true;
  };

  const paint = addStage(THREE, scene3d, scene3d.boxes());
  const repaint = () => {
    const style = getComputedStyle(document.documentElement);
    paint((name) => style.getPropertyValue(name).trim());
    requestDraw();
  };
  // Until someone turns the scene, it fills the picture, whatever the window's size.
  let turned = false;
  const fit = () => {
    turned = false;
    fitCamera(THREE, camera, controls, scene3d.boxes(), new THREE.Vector3(0.45, -1, 0.6));
  };
  const resize = () => {
    const { clientWidth, clientHeight } = byId("view");
    camera.aspect = clientWidth / Math.max(1, clientHeight);
    camera.updateProjectionMatrix();
    renderer?.setPixelRatio(Math.min(devicePixelRatio, 2));
    renderer?.setSize(clientWidth, clientHeight, false);
    if (!turned) fit();
    draw();
  };
  repaint();
  resize();

  new ResizeObserver(resize).observe(byId("view"));
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", repaint);
  controls.addEventListener("start", () => (turned = true));
  controls.addEventListener("change", requestDraw);
  byId("fit").addEventListener("click", fit);
  byId("show-names").addEventListener("change", requestDraw);
  return { scene3d, requestDraw };
}

/** Adds a name for each agent and object; returns [{label, groups, below}]. */
function addNames(scene, scene3d) {
  const owners = [
    ...scene.agents.map((agent, i) => ({ id: agent.id, groups: scene3d.links[i], below: false })),
    // Furniture has its name at its foot, where it hides nothing that stands on it.
    ...scene.objects.map((object, i) => ({ id: object.id, groups: [scene3d.objects[i]], below: !object.movable })),
  ];
  return owners.map(({ id, groups, below }) => {
    const label = element("span", "", id);
    byId("names").append(label);
    return { label, groups, below };
  });
}

/** Puts each name over (or below) its owner in the picture; of two that would overlap, the later goes higher. */
function placeNames(THREE, names, camera, canvas) {
  const shown = byId("show-names").checked;
  const placed = [];
  for (const { label, groups, below } of names) {
    // Over the highest part: a head, not the middle between two stretched arms.
    const boxes = groups.map((group) => new THREE.Box3().setFromObject(group));
    const box = boxes.reduce((highest, other) => (other.max.z > highest.max.z ? other : highest));
    const at = box.getCenter(new THREE.Vector3()).setZ(below ? box.min.z : box.max.z).project(camera);
    label.hidden = !shown || box.isEmpty() || Math.abs(at.z) > 1;
    if (label.hidden) continue;
    const { offsetWidth: width, offsetHeight: height } = label;
    const x = ((at.x + 1) * canvas.clientWidth) / 2 - width / 2;
    let y = ((1 - at.y) * canvas.clientHeight) / 2 - height - 4;
    const covers = (other) => x < other.x + other.width && other.x < x + width && y < other.y + height && other.y < y + height;
    for (let other = placed.find(covers); other; other = placed.find(covers)) y = other.y - height - 1;
    placed.push({ x, y, width });
    label.style.transform = `translate(${x}px, ${y}px)`;
  }
}

/** Fills the list with the plan's actions, as far as a page can hold them; returns their buttons. */
function listActions(plan, jump) {
  const buttons = plan.actions.slice(0, MAX_ROWS).map((action) => {
    const button = element("button", "", "");
    button.type = "button";
    const what = element("span", "what", call(action).slice(action.name.length));
    what.prepend(element("b", "", action.name));
    button.append(what, element("span", "when", `${action.start.toFixed(1)} – ${seconds(action.end)} · ${action.agents.join(", ")}`));
    button.addEventListener("click", () => jump(action.index));
    const item = document.createElement("li");
    item.append(button);
    byId("list").append(item);
    return button;
  });
  const more = plan.actions.length - buttons.length;
  if (more > 0) byId("list").append(element("li", "when", `… ${more} more actions`));
  return buttons;
}

/** Gives the tree the room that a scene would have. */
function spreadTree() {
  document.querySelector("main").append(byId("tree"));
  byId("tree").hidden = false;
}

/** Lets the two tabs choose between the list and the tree. */
function connectTabs() {
  const names = ["list", "tree"];
  const choose = (chosen) => {
    for (const name of names) {
      byId(name).hidden = name !== chosen;
      byId(`tab-${name}`).setAttribute("aria-selected", String(name === chosen));
      byId(`tab-${name}`).tabIndex = name === chosen ? 0 : -1;
    }
  };
  for (const [i, name] of names.entries()) {
    const tab = byId(`tab-${name}`);
    tab.addEventListener("click", () => choose(name));
    tab.addEventListener("keydown", (event) => {
      if (!["ArrowLeft", "ArrowRight"].includes(event.key)) return;
      const other = names[1 - i];
      choose(other);
      byId(`tab-${other}`).focus();
      event.stopPropagation(); // The player's arrows move the time.
      event.preventDefault();
    });
  }
  choose("list");
  byId("tabs").hidden = false;
}

/** Fills the list with what is there, for a world without a plan. */
function listEntities(scene) {
  byId("list").setAttribute("aria-label", "What is there");
  byId("summary").textContent = "The world at its start";
  const entries = [...scene.agents.map((a) => [a.id, a.kind]), ...scene.objects.map((o) => [o.id, o.movable ? "movable" : "fixed"])];
  for (const [id, kind] of entries) {
    const item = element("li", "entity", "");
    item.append(element("span", "what", id), element("span", "when", kind));
    byId("list").append(item);
  }
}

/** Returns {time, setTime, setPlaying, isPlaying}: the clock. `show(t)` is called for each new time. */
function buildClock(duration, show) {
  let time = 0;
  let playing = false;
  const setTime = (t) => {
    time = Math.min(Math.max(Number.isFinite(t) ? t : 0, 0), duration);
    byId("time").value = time;
    byId("clock").textContent = `${time.toFixed(2)} / ${seconds(duration)}`;
    show(time);
  };
  const setPlaying = (on) => {
    const begins = on && !playing && duration > 0;
    playing = on && duration > 0;
    byId("play").setAttribute("aria-pressed", String(playing));
    byId("play").setAttribute("aria-label", playing ? "Pause" : "Play");
    if (!begins) return;
    if (time >= duration) setTime(0);
    let last = performance.now();
    const step = (now) => {
      if (!playing) return;
      setTime(time + (Math.max(0, now - last) / 1000) * Number(byId("speed").value));
      last = now;
      if (time < duration) requestAnimationFrame(step);
      else setPlaying(false);
    };
    requestAnimationFrame(step);
  };
  return { time: () => time, setTime, setPlaying, isPlaying: () => playing };
}

/** Connects slider, buttons, keys and address with the clock; `seek` stops and goes to a time. */
function connectPlayer(clock, duration, seek) {
  const toggle = () => clock.setPlaying(!clock.isPlaying());
  byId("time").max = duration;
  byId("time").addEventListener("input", () => seek(Number(byId("time").value)));
  byId("play").addEventListener("click", toggle);
  addEventListener("keydown", (event) => {
    const { key, target } = event;
    if (event.ctrlKey || event.metaKey || event.altKey || target.tagName === "SELECT") return;
    const step = event.shiftKey ? 1 : 0.1;
    const goals = { ArrowLeft: clock.time() - step, ArrowRight: clock.time() + step, Home: 0, End: duration };
    // A button or a box that has the focus keeps its own space.
    if (key === " " && (target === byId("time") || !["BUTTON", "INPUT"].includes(target.tagName))) toggle();
    else if (Object.hasOwn(goals, key)) seek(goals[key]);
    else return;
    event.preventDefault();
  });
  const followAddress = () => {
    const match = /[#&]t=([\d.]+)/.exec(location.hash);
    if (match) seek(Number(match[1]));
  };
  addEventListener("hashchange", followAddress);
  followAddress();
}

/** Marks the buttons as those of an action that goes on, or not. */
function markCurrent(buttons, on) {
  for (const button of buttons) {
    if (on === button.hasAttribute("aria-current")) continue;
    if (!on) {
      button.removeAttribute("aria-current");
      continue;
    }
    button.setAttribute("aria-current", "step");
    // On a narrow screen it is the page that scrolls, and it stays where it is.
    const scrolled = button.closest("#list, #tree, #streams");
    if (scrolled.scrollHeight > scrolled.clientHeight) button.scrollIntoView({ block: "nearest" });
  }
}

/** Shows which actions go on at time t: wherever they have a button, below the slider, and the tool's way of the first that moves. */
function showActions(plan, timeline, t, buttonsOf, showPath) {
  const current = plan.actions.filter((action) => isCurrent(action, timeline, t));
  const isOn = new Set(current.map((action) => action.index));
  buttonsOf.forEach((buttons, i) => markCurrent(buttons, isOn.has(i)));
  const now = current.map((action) => [call(action), segmentAt(timeline, action, t)?.name].filter(Boolean).join(" · "));
  byId("now").textContent = now.join(" | ");
  byId("time").setAttribute("aria-valuetext", [seconds(t), ...now].join(", "));
  showPath(current.find((action) => action.geometry) ?? null);
  return current;
}

/** Returns what tests and curious readers may ask: poses as the scene graph has them, in the world frame. */
function inspector(THREE, scene, scene3d, duration, setTime) {
  const worldPose = (node) => ({
    position: node.getWorldPosition(new THREE.Vector3()).toArray(),
    quaternion: node.getWorldQuaternion(new THREE.Quaternion()).toArray(),
  });
  const objectPose = (id) => worldPose(scene3d.objects[scene.objects.findIndex((o) => o.id === id)]);
  const linkPose = (id, link) => {
    const agent = scene.agents.findIndex((a) => a.id === id);
    return worldPose(scene3d.links[agent][scene.agents[agent].links.indexOf(link)]);
  };
  return { ready: true, duration, setTime, objectPose, linkPose };
}

async function main() {
  const scene = JSON.parse(byId("scene-data").textContent);
  const plan = JSON.parse(byId("plan-data").textContent);
  const timeline = buildTimeline(scene, plan);
  const { duration } = timeline;
  // A plan on symbols alone has no scene: then the lanes are the picture.
  const isFlat = scene.agents.length + scene.objects.length === 0;
  document.body.classList.toggle("flat", isFlat);
  byId("view").hidden = isFlat;
  const THREE = isFlat ? null : await loadThree();
  const view = isFlat ? null : buildView(THREE, scene);

  // The buttons of each action: in the list, in the tree, in the lanes.
  let buttonsOf = [];
  let streams = null;
  let chosen = null;
  let pathOf = null;
  const showPath = (action) => {
    if (action !== pathOf) view?.scene3d.setPath(action ? toolPath(scene, timeline, action) : []);
    pathOf = action;
  };
  const clock = buildClock(duration, (t) => {
    view?.scene3d.setWorld(worldAt(scene, timeline, t));
    if (plan) {
      const current = showActions(plan, timeline, t, buttonsOf, showPath);
      streams?.setTime(t);
      // What was clicked last stays in sight while it goes on; then what goes on does.
      const begun = () => plan.actions.findLast((action) => action.start <= t);
      if (!current.includes(chosen)) chosen = current[0] ?? begun() ?? chosen;
      showDetails(plan, chosen);
    }
    view?.requestDraw();
  });
  const seek = (t) => {
    clock.setPlaying(false);
    clock.setTime(t);
  };

  byId("player").hidden = !plan;
  if (plan) {
    const count = plan.actions.length === 1 ? "1 action" : `${plan.actions.length} actions`;
    byId("summary").textContent = `${plan.task} · ${count} · ${seconds(duration)} · cost ${Number(plan.cost.toPrecision(4))}`;
    showCosts(plan);
    if (timeline.problems.length > 0) showMessage(`The plan does not fit this world:\n${[...new Set(timeline.problems)].join("\n")}`);
    const jump = (i) => {
      chosen = plan.actions[i];
      seek(chosen.start);
    };
    const [listed, planted] = [listActions(plan, jump), buildTree(plan, jump)];
    streams = buildStreams(plan, duration, jump);
    buttonsOf = plan.actions.map((_, i) => [listed[i], planted[i], ...streams.bars[i]].filter(Boolean));
    if (isFlat) spreadTree();
    else connectTabs();
    clock.setTime(0);
    connectPlayer(clock, duration, seek);
  } else {
    listEntities(scene);
    view?.requestDraw();
  }
  globalThis.sgap = inspector(THREE, scene, view?.scene3d, duration, seek);
  dispatchEvent(new Event("sgap-ready"));
}

main().catch((error) => {
  showMessage(`The scene can't be shown: ${error.message}`);
  throw error;
});
