// The plan beside the scene's time: a lane for each agent with a bar for each of its actions, dashes where it waits, and an
// arrow for each link from one lane to another.

const LANE = 26; // Height of a lane [px]; style.css has the same.

/** Returns where each action stands in [0, 1]. A plan that takes no time has its actions one after the other. */
function actionSpans(plan, duration) {
  const { length } = plan.actions;
  if (duration > 0) return plan.actions.map((a) => [a.start / duration, a.end / duration]);
  return plan.actions.map((_, i) => [i / length, (i + 1) / length]);
}

/** Returns the words for a link's reasons. */
function reasonWords(reasons) {
  const named = (key) => reasons.map((reason) => reason[key]).filter(Boolean);
  const words = [];
  if (named("attribute").length > 0) words.push(`needs ${named("attribute").join(", ")}`);
  if (named("threat").length > 0) words.push(`overwrites ${named("threat").join(", ")}`);
  if (reasons.includes("motion")) words.push("moves on from there");
  if (reasons.includes("order")) words.push("the method orders them");
  return words.join("; ");
}

/** Fills the lanes; `jump(i)` is called when a bar is clicked. Returns {bars: bars of each action, setTime}. */
function buildStreams(plan, duration, jump) {
  const spans = actionSpans(plan, duration);
  const percent = (share) => `${100 * share}%`;
  const bars = plan.actions.map(() => []);
  const agents = Object.keys(plan.streams);
  const lanes = byId("lanes");
  agents.forEach((agent) => {
    byId("lane-names").append(element("li", "", agent));
    const lane = element("div", "lane", "");
    lane.setAttribute("role", "group");
    lane.setAttribute("aria-label", `Stream of ${agent}`);
    let free = 0;
    for (const i of plan.streams[agent]) {
      const [start, end] = spans[i];
      if (start > free) {
        const wait = element("div", "wait", "");
        wait.title = `${agent} waits ${seconds((start - free) * duration)}`;
        Object.assign(wait.style, { left: percent(free), width: percent(start - free) });
        lane.append(wait);
      }
      const bar = element("button", "bar", plan.actions[i].name);
      bar.type = "button";
      bar.title = `${call(plan.actions[i])} · ${plan.actions[i].start.toFixed(1)} – ${seconds(plan.actions[i].end)}`;
      Object.assign(bar.style, { left: percent(start), width: percent(end - start) });
      bar.addEventListener("click", () => jump(i));
      bars[i].push(bar);
      lane.append(bar);
      free = Math.max(free, end);
    }
    lanes.append(lane);
  });
  lanes.append(drawLinks(plan, agents, spans));
  const head = element("div", "head", "");
  lanes.append(head);
  return { bars, setTime: (t) => (head.style.left = percent(duration > 0 ? t / duration : 0)) };
}

/** Returns the arrows between lanes; within a lane the order says it already. */
function drawLinks(plan, agents, spans) {
  const frame = element("div", "", "");
  frame.innerHTML = "<svg></svg>"; // The parser knows the namespace, so that no address stands in the page.
  const svg = frame.firstChild;
  const create = (tag) => document.createElementNS(svg.namespaceURI, tag);
  const height = LANE * agents.length;
  svg.setAttribute("viewBox", `0 0 1000 ${height}`);
  svg.setAttribute("preserveAspectRatio", "none");
  svg.setAttribute("aria-hidden", "true");
  const middle = (i) => (agents.indexOf(plan.actions[i].agents[0]) + 0.5) * LANE;
  for (const { before, after, reasons } of plan.links) {
    if (plan.actions[before].agents.some((agent) => plan.actions[after].agents.includes(agent))) continue;
    const [x1, x2, y1, y2] = [1000 * spans[before][1], 1000 * spans[after][0], middle(before), middle(after)];
    const path = create("path");
    path.setAttribute("d", `M ${x1 - 3} ${y1} C ${x1 + 12} ${y1} ${x2 - 12} ${y2} ${x2 + 3} ${y2}`);
    const title = create("title");
    title.textContent = `${call(plan.actions[after])} after ${call(plan.actions[before])}: ${reasonWords(reasons)}`;
    path.append(title);
    svg.append(path);
  }
  return svg;
}
