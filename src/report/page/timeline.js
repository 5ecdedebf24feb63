// The world at any time of a plan: pure functions of the page's data, no drawing.

/**
 * Returns {duration, segments, changes, problems}: what moves when, and who takes or lets go of what when.
 * Sub-actions follow each other within their action; a trajectory's first time is the end of the one before.
 */
function buildTimeline(scene, plan) {
  const timeline = { duration: 0, segments: [], changes: [], problems: [] };
  for (const action of plan ? plan.actions : []) {
    timeline.duration = Math.max(timeline.duration, action.end);
    if (action.geometry) addGeometry(timeline, scene, action);
  }
  // The sort is stable: of two at the same time, the later in the plan comes last and wins.
  timeline.segments.sort((a, b) => a.start - b.start);
  timeline.changes.sort((a, b) => a.time - b.time);
  return timeline;
}

function addGeometry(timeline, scene, action) {
  const geometry = action.geometry;
  const agentIndex = scene.agents.findIndex((a) => a.id === geometry.agent);
  if (agentIndex < 0) {
    timeline.problems.push(`the plan moves ${geometry.agent}, who is not in this world`);
    return;
  }
  const agent = scene.agents[agentIndex];
  const armIndex = agent.arms.findIndex((a) => a.name === geometry.arm);
  let start = action.start;
  for (const sub of geometry.sub_actions) {
    const { joints, times, positions } = sub.trajectory;
    const isBase = sub.motion === "base";
    const dofs = isBase ? [0, 1, 2] : joints.map((name) => agent.dofs.indexOf(name));
    const unknown = joints.filter((_, j) => dofs[j] < 0);
    if (unknown.length > 0) timeline.problems.push(`the plan moves ${unknown.join(", ")}, which ${agent.id} does not have`);
    const end = start + (times.length > 0 ? times[times.length - 1] : 0);
    timeline.segments.push({ action: action.index, name: sub.name, agent: agentIndex, arm: armIndex, isBase, start, end, dofs, times, positions });
    if (sub.change) addChange(timeline, scene, sub.change, end, agentIndex, armIndex);
    start = end;
  }
  timeline.duration = Math.max(timeline.duration, start);
}

function addChange(timeline, scene, change, time, agent, arm) {
  const { object: id, object_in_tool: X_TO, object_in_world: X_WO } = change.attach ?? change.detach;
  const object = scene.objects.findIndex((o) => o.id === id);
  if (object < 0 || arm < 0) {
    timeline.problems.push(`the plan handles ${id} with a hand or a thing that is not in this world`);
    return;
  }
  timeline.changes.push(change.attach ? { time, object, held: { agent, arm, object_in_tool: X_TO } } : { time, object, held: null, pose: X_WO });
}

/** Writes the segment's configuration at time t into q; after its end it stays as it ended. */
function applySegment(segment, t, q) {
  const { times, positions, dofs } = segment;
  if (times.length === 0) return;
  const at = t - segment.start;
  // The first sample later than `at`, by bisection.
  let low = 0;
  let high = times.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle] > at) high = middle;
    else low = middle + 1;
  }
  const after = Math.min(low, times.length - 1);
  const before = Math.max(low - 1, 0);
  const span = times[after] - times[before];
  const share = span > 0 ? (at - times[before]) / span : 0;
  dofs.forEach((dof, j) => {
    if (dof >= 0) q[dof] = positions[before][j] + share * (positions[after][j] - positions[before][j]);
  });
}

/** Returns the configurations of all agents at time t [s]. */
function configurationsAt(start, timeline, t) {
  const configurations = start.agents.map((a) => a.q.slice());
  for (const segment of timeline.segments) {
    if (segment.start > t) break;
    if (!segment.isBase) applySegment(segment, t, configurations[segment.agent]);
  }
  return configurations;
}

/** Returns X_WB of all agents at time t [s]: a base goes on its floor, x, y and heading. */
function basesAt(start, timeline, t) {
  const bases = start.agents.map((a) => a.base);
  for (const segment of timeline.segments) {
    if (segment.start > t) break;
    if (!segment.isBase || segment.times.length === 0) continue;
    const pose = [0, 0, 0];
    applySegment(segment, t, pose);
    const [x, y, yaw] = pose;
    bases[segment.agent] = {
      position: [x, y, bases[segment.agent].position[2]],
      quaternion: [0, 0, Math.sin(yaw / 2), Math.cos(yaw / 2)],
    };
  }
  return bases;
}

/** Returns X_WT of an arm's tool, given X_WL of the agent's links. */
function toolPose(arm, X_WL) {
  return compose(X_WL[arm.link], arm.tool);
}

/** Returns {links: X_WL by agent and link, objects: X_WO by object} at time t [s]. */
function worldAt(scene, timeline, t) {
  const { start } = scene;
  const q = configurationsAt(start, timeline, t);
  const bases = basesAt(start, timeline, t);
  const links = scene.agents.map((agent, a) => linkPoses(agent, bases[a], q[a]));
  const stands = start.objects.map((object) => ({ pose: object.pose, held: object.held }));
  for (const change of timeline.changes) {
    if (change.time > t) break;
    stands[change.object] = change;
  }
  const objects = stands.map(({ pose, held }) => {
    if (!held) return pose;
    return compose(toolPose(scene.agents[held.agent].arms[held.arm], links[held.agent]), held.object_in_tool);
  });
  return { links, objects };
}

/** Returns whether an action is going on at time t; the last ones also at the very end. */
function isCurrent(action, timeline, t) {
  const last = timeline.duration - 1e-6; // Times in a plan document are rounded.
  return action.start <= t && (t < action.end || (t >= last && action.end >= last));
}

/** Returns the segment of the action at time t, if it moves. */
function segmentAt(timeline, action, t) {
  const own = timeline.segments.filter((s) => s.action === action.index && s.start <= t);
  return own[own.length - 1];
}

/** Returns the way of the tool during an action, or of the base, as points [x, y, z]; none where neither moves. */
function toolPath(scene, timeline, action) {
  const all = timeline.segments.filter((s) => s.action === action.index);
  const goes = all.some((s) => s.isBase);
  const own = all.filter((s) => (goes ? s.isBase : s.arm >= 0));
  if (own.length === 0) return [];
  const { agent, arm, start } = own[0];
  const { end } = own[own.length - 1];
  const steps = Math.min(400, Math.max(2, Math.ceil((end - start) / 0.03)));
  const path = [];
  for (let i = 0; i <= steps; i++) {
    const t = start + ((end - start) * i) / steps;
    const X_WB = basesAt(scene.start, timeline, t)[agent];
    if (goes) {
      // A little above the floor, where it can be seen.
      const [x, y, z] = X_WB.position;
      path.push([x, y, z + 0.01]);
      continue;
    }
    const q = configurationsAt(scene.start, timeline, t)[agent];
    const X_WL = linkPoses(scene.agents[agent], X_WB, q);
    path.push(toolPose(scene.agents[agent].arms[arm], X_WL).position);
  }
  return path;
}
