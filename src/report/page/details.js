// What there is to say about one action: who, with what, what it costs and changes, and what it waits for.

/** Returns [name, text] pairs about an action. */
function actionFacts(plan, action) {
  const number = (x) => String(Number(x.toPrecision(4)));
  const facts = [["who", action.agents.join(", ")]];
  facts.push(["when", `${action.start.toFixed(2)} – ${action.end.toFixed(2)} s, lasts ${action.duration.map(number).join(" to ")} s`]);
  const { geometry } = action;
  if (geometry) {
    if (geometry.arm) facts.push(["hand", `${geometry.arm}, grasp ${geometry.grasp}`]);
    if (geometry.stand) {
      const { x, y, yaw } = geometry.stand;
      facts.push(["stand", `at (${number(x)}, ${number(y)}) m, ${Math.round((yaw * 180) / Math.PI)}°`]);
    }
    if (geometry.placement) {
      const { on, support, stable, x, y } = geometry.placement;
      facts.push(["place", `${support} of ${on}, ${stable}, at (${number(x)}, ${number(y)}) m`]);
    }
    facts.push(["solution", geometry.alternative === 0 ? "the first" : `alternative ${geometry.alternative}`]);
  }
  const parts = Object.entries(geometry?.cost_parts ?? {}).map(([part, cost]) => `${part} ${number(cost)}`);
  facts.push(["cost", parts.length > 0 ? `${number(action.cost)} (${parts.join(", ")})` : number(action.cost)]);
  const changes = Object.entries(action.changes).map(([attribute, value]) => `${attribute} = ${value}`);
  if (changes.length > 0) facts.push(["changes", changes.join("\n")]);
  const after = plan.links.filter((link) => link.after === action.index);
  const waits = after.map((link) => `${call(plan.actions[link.before])}: ${reasonWords(link.reasons)}`);
  if (waits.length > 0) facts.push(["after", waits.join("\n")]);
  return facts;
}

/** Shows the action's facts, or none. */
function showDetails(plan, action) {
  const box = byId("details");
  box.hidden = !action;
  if (!action) return;
  byId("details-title").textContent = call(action);
  const rows = actionFacts(plan, action).flatMap(([name, text]) => [element("dt", "", name), element("dd", "", text)]);
  byId("facts").replaceChildren(...rows);
}

/** Shows what the plan's cost consists of, where it is more than its actions' costs. */
function showCosts(plan) {
  const parts = plan.cost_parts ?? [];
  byId("costs").hidden = parts.length === 0;
  const number = (x) => String(Number(x.toPrecision(6)));
  const row = (tag, cells) => {
    const line = element("tr", "", "");
    line.append(...cells.map((text) => element(tag, "", text)));
    return line;
  };
  const rows = parts.map(({ name, kind, amount, weight, cost }) =>
    row("td", [name === kind ? name : `${name} (${kind})`, number(amount), `× ${number(weight)}`, number(cost)]));
  byId("cost-parts").replaceChildren(row("th", ["part", "amount", "weight", "cost"]), ...rows);
}
