//! A plan's decomposition tree and links as a graph in the language of Graphviz (DOT).

use crate::plan::{LinkReason, Plan};

/// Returns the graph: methods as boxes, actions as ellipses in the colour of who acts, links dashed with their reasons.
pub fn write(plan: &Plan) -> String {
    let mut out = String::from(
        "digraph plan {\n  node [shape=box, fontname=\"sans-serif\", fontsize=11];\n  edge [fontname=\"sans-serif\", fontsize=9];\n",
    );
    let colors = ["#fdd9b5", "#cfe3f7", "#d5efcf", "#eddcf5", "#f7f0c4", "#f5d0d6"];
    let mut drawn = vec![false; plan.actions.len()];
    for (i, node) in plan.decomposition.iter().enumerate() {
        match node.action.filter(|a| *a < plan.actions.len()) {
            Some(action) => drawn[action] = true,
            None => out += &format!("  n{i} [label={}];\n", quoted(&call(&node.task, &node.arguments))),
        }
    }
    for action in &plan.actions {
        let acts = action.agents.first().map(|a| a.as_str());
        let lane = acts.and_then(|a| plan.streams.get_index_of(a)).unwrap_or(0);
        let label = format!("{} {}", action.index, call(&action.name, &action.arguments));
        out += &format!(
            "  a{} [shape=ellipse, style=filled, fillcolor=\"{}\", label={}];\n",
            action.index,
            colors[lane % colors.len()],
            quoted(&label)
        );
    }
    for (i, node) in plan.decomposition.iter().enumerate() {
        let child = match node.action.filter(|a| drawn.get(*a) == Some(&true)) {
            Some(action) => format!("a{action}"),
            None => format!("n{i}"),
        };
        if let Some(parent) = node.parent {
            out += &format!("  n{parent} -> {child};\n");
        }
    }
    for link in &plan.links {
        let reasons: Vec<String> = link.reasons.iter().map(reason).collect();
        out += &format!(
            "  a{} -> a{} [style=dashed, color=\"#3366cc\", constraint=false, label={}];\n",
            link.before,
            link.after,
            quoted(&reasons.join("\n"))
        );
    }
    out + "}\n"
}

fn reason(reason: &LinkReason) -> String {
    match reason {
        LinkReason::Attribute(what) => what.to_string(),
        LinkReason::Order => "order".into(),
        LinkReason::Threat(what) => format!("keeps {what}"),
        LinkReason::Motion => "motion".into(),
    }
}

fn call(name: &str, arguments: &[crate::plan::Text]) -> String {
    format!("{name}({})", arguments.join(", "))
}

/// A string of DOT: only quotes and backslashes mean something in it.
fn quoted(text: &str) -> String {
    format!(
        "\"{}\"",
        text.replace('\\', "\\\\").replace('"', "\\\"").replace('\n', "\\n")
    )
}
