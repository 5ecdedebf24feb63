// The decomposition tree as a list with indents: a recursive method may go thousands of levels down, where nested elements
// would end the browser.

/** Rows shown at most; a page with more would not scroll. */
const MAX_ROWS = 2000;

/** Fills the tree; `jump(i)` is called when an action's row is clicked. Returns the row of each action, as far as shown. */
function buildTree(plan, jump) {
  const nodes = plan.decomposition;
  const depths = [];
  for (const [i, node] of nodes.entries()) depths[i] = node.parent === undefined ? 0 : depths[node.parent] + 1;
  const rows = [];
  const rowOf = plan.actions.map(() => null);
  // A node is hidden while one of its ancestors is closed; a parent stands before its children.
  const closed = nodes.map(() => false);
  const refresh = () => {
    const hidden = [];
    rows.forEach((row, i) => {
      const { parent } = nodes[i];
      hidden[i] = parent !== undefined && (hidden[parent] || closed[parent]);
      row.hidden = hidden[i];
    });
  };
  const hasChildren = new Set(nodes.map((node) => node.parent));
  nodes.slice(0, MAX_ROWS).forEach((node, i) => {
    const row = element("li", "", "");
    row.style.setProperty("--depth", Math.min(depths[i], 30));
    const button = element("button", "", "");
    button.type = "button";
    // A task network is named by its text, which is the plan's task.
    const isNetwork = node.parent === undefined && node.task === plan.task;
    const what = element("span", "what", isNetwork ? "" : `(${node.arguments.join(", ")})`);
    what.prepend(element("b", "", node.task));
    button.append(what);
    if (node.action !== undefined) {
      button.addEventListener("click", () => jump(node.action));
      rowOf[node.action] = button;
    } else if (hasChildren.has(i)) {
      what.append(element("span", "way", ` way ${node.decomposition + 1}`));
      button.setAttribute("aria-expanded", "true");
      button.addEventListener("click", () => {
        closed[i] = !closed[i];
        button.setAttribute("aria-expanded", String(!closed[i]));
        refresh();
      });
    } else {
      what.append(element("span", "way", node.decomposition === undefined ? " its goal holds" : " nothing to do"));
      button.disabled = true;
    }
    row.append(button);
    rows.push(row);
    byId("tree").append(row);
  });
  if (nodes.length > MAX_ROWS) byId("tree").append(element("li", "when", `… ${nodes.length - MAX_ROWS} more tasks`));
  return rowOf;
}
