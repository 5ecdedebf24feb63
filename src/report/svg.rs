//! A world, or a plan in its world, as one picture (SVG 1.1) for papers: the scene from above with the ways of the tools, the schedule,
//! and the decomposition tree.
//!
//! Does NOT show heights (`html` does), nor more than the first rows of a long plan: a picture of a thousand rows is no picture.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use std::collections::BTreeMap;

use nalgebra::Point3;

use super::playback::{Playback, Segment};
use super::surface::Surface;
use crate::geom::Pose;
use crate::geom::shape::Shape;
use crate::plan::Plan;
use crate::world::{Scene, State};

/// Width of the picture, and of its margins [px].
const WIDTH: f64 = 1000.0;
const MARGIN: f64 = 24.0;
/// The top view is at most so high [px].
const HIGHEST_VIEW: f64 = 620.0;
/// A row of text, a row of the schedule [px].
const ROW: f64 = 18.0;
const LANE: f64 = 34.0;
/// Rows of the tree, and bars of a lane, that are drawn.
const MOST_ROWS: usize = 60;
const MOST_BARS: usize = 2_000;
/// Samples of a tool's way [s], and how many at most.
const STEP: f64 = 0.05;
const MOST_STEPS: f64 = 20_000.0;
/// Colours of actions' ways, in turn: those of Okabe and Ito, which the colour-blind tell apart.
const COLORS: [&str; 7] = [
    "#e69f00", "#56b4e9", "#009e73", "#0072b2", "#d55e00", "#cc79a7", "#999999",
];

/// Returns the picture: the scene as it stands at the end of the plan, or at the start without one. `title` is plain text.
pub fn write(scene: &Scene, start: &State, plan: Option<&Plan>, title: &str) -> String {
    let playback = Playback::new(scene, start, plan);
    let n = (playback.duration / STEP).ceil().min(MOST_STEPS) as u32;
    let times: Vec<f64> = (0..=n)
        .map(|i| playback.duration * f64::from(i) / f64::from(n.max(1)))
        .collect();
    let mut end = start.clone();
    let mut ways: BTreeMap<usize, Vec<[f64; 2]>> = BTreeMap::new();
    playback.visit(&times, &mut |state, segments| {
        for (action, p) in segments.iter().map(|s| tool(scene, state, &playback.segments[*s])) {
            ways.entry(action).or_default().push(p);
        }
        end.clone_from(state);
    });
    let mut svg = Picture::default();
    svg.text(MARGIN, MARGIN, 16.0, "bold", title);
    let mut y = MARGIN + 16.0;
    if !scene.agents.is_empty() || !scene.objects.is_empty() {
        y = svg.top_view(scene, &end, &ways, y);
    }
    if let Some(plan) = plan {
        y = svg.schedule(plan, y + MARGIN);
        y = svg.tree(plan, y + MARGIN);
    }
    svg.finish(y + MARGIN)
}

/// Returns the action of a motion, and where its tool is (x, y) [m]; its base, where no arm handles anything.
fn tool(scene: &Scene, state: &State, segment: &Segment<'_>) -> (usize, [f64; 2]) {
    let (body, at) = (&scene.agents[segment.agent], &state.agents[segment.agent]);
    let Some(arm) = segment.arm.map(|arm| &body.arms[arm]) else {
        let p = at.X_WB.translation;
        return (segment.action, [p.x, p.y]);
    };
    let X_WT = body.tree.link_poses(&at.X_WB, &at.q)[arm.tip_link] * arm.X_LT;
    (segment.action, [X_WT.translation.x, X_WT.translation.y])
}

/// What is seen of a body from above: its outline and how high it is.
struct Outline {
    /// Top [m].
    top: f64,
    /// Counter-clockwise, in the world [m].
    corners: Vec<[f64; 2]>,
    color: [f32; 4],
}

fn outline(shape: &Shape, X_WS: &Pose, color: [f32; 4]) -> Outline {
    let points: Vec<_> = Surface::of(shape)
        .positions
        .iter()
        .map(|p| X_WS * Point3::from(*p))
        .collect();
    Outline {
        top: points.iter().map(|p| p.z).fold(f64::NEG_INFINITY, f64::max),
        corners: around(points.iter().map(|p| [p.x, p.y]).collect()),
        color,
    }
}

/// Returns the convex hull of points, counter-clockwise (Andrew's monotone chain, doi:10.1016/0020-0190(79)90072-3).
fn around(mut points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    points.dedup();
    let half = |points: &mut dyn Iterator<Item = [f64; 2]>| {
        let mut chain: Vec<[f64; 2]> = Vec::new();
        for p in points {
            while let [.., a, b] = chain[..] {
                if (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]) > 0.0 {
                    break;
                }
                chain.pop();
            }
            chain.push(p);
        }
        chain.pop();
        chain
    };
    let mut chain = half(&mut points.iter().copied());
    chain.extend(half(&mut points.iter().rev().copied()));
    chain
}

/// The picture's elements.
#[derive(Default)]
struct Picture(String);

impl Picture {
    fn text(&mut self, x: f64, y: f64, size: f64, weight: &str, text: &str) {
        let text = escape(text);
        self.0 +=
            &format!("<text x=\"{x:.1}\" y=\"{y:.1}\" font-size=\"{size}\" font-weight=\"{weight}\">{text}</text>\n");
    }

    /// Draws the scene from above; returns where it ends.
    fn top_view(&mut self, scene: &Scene, state: &State, ways: &BTreeMap<usize, Vec<[f64; 2]>>, top: f64) -> f64 {
        let mut bodies: Vec<Outline> = Vec::new();
        let mut names: Vec<([f64; 2], &str)> = Vec::new();
        for (thing, at) in scene.objects.iter().zip(&state.objects) {
            let parts = thing.parts.iter();
            bodies.extend(parts.map(|p| outline(&p.shape, &(at.X_WO * p.X_OS), thing.color)));
            names.push(([at.X_WO.translation.x, at.X_WO.translation.y], &thing.id));
        }
        for (body, at) in scene.agents.iter().zip(&state.agents) {
            let X_WL = body.tree.link_poses(&at.X_WB, &at.q);
            let parts = body.bodies.iter();
            bodies.extend(parts.map(|p| outline(&p.shape, &(X_WL[p.link] * p.X_LS), p.color)));
            names.push(([at.X_WB.translation.x, at.X_WB.translation.y], &body.id));
        }
        bodies.sort_by(|a, b| a.top.total_cmp(&b.top));
        let all = bodies.iter().flat_map(|b| &b.corners).chain(ways.values().flatten());
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for p in all {
            for i in 0..2 {
                (low[i], high[i]) = (low[i].min(p[i]), high[i].max(p[i]));
            }
        }
        if bodies.is_empty() {
            return top;
        }
        let (wide, deep) = ((high[0] - low[0]).max(1e-3), (high[1] - low[1]).max(1e-3));
        let scale = ((WIDTH - 2.0 * MARGIN) / wide).min(HIGHEST_VIEW / deep);
        let left = (WIDTH - wide * scale) / 2.0;
        // y of the world points up in the picture.
        let place = |p: &[f64; 2]| (left + (p[0] - low[0]) * scale, top + (high[1] - p[1]) * scale);
        let list = |points: &[[f64; 2]]| {
            let points = points.iter().map(|p| {
                let (x, y) = place(p);
                format!("{x:.1},{y:.1}")
            });
            points.collect::<Vec<_>>().join(" ")
        };
        self.0 += "<g stroke=\"#333\" stroke-width=\"0.5\" stroke-linejoin=\"round\">\n";
        for body in &bodies {
            let [r, g, b, a] = body.color;
            let [r, g, b] = [r, g, b].map(|c| (c * 255.0).round() as u8);
            self.0 += &format!(
                "<polygon points=\"{}\" fill=\"#{r:02x}{g:02x}{b:02x}\" fill-opacity=\"{:.2}\"/>\n",
                list(&body.corners),
                0.85 * a
            );
        }
        self.0 += "</g>\n<g fill=\"none\" stroke-width=\"2\">\n";
        for (action, way) in ways {
            let color = COLORS[action % COLORS.len()];
            self.0 += &format!("<polyline points=\"{}\" stroke=\"{color}\"/>\n", list(way));
        }
        self.0 += "</g>\n";
        for (action, way) in ways {
            let Some(end) = way.last() else { continue };
            let (x, y) = place(end);
            let color = COLORS[action % COLORS.len()];
            self.0 += &format!("<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"7\" fill=\"{color}\"/>\n");
            self.0 += &format!(
                "<text x=\"{x:.1}\" y=\"{:.1}\" font-size=\"10\" text-anchor=\"middle\" fill=\"#fff\">{action}</text>\n",
                y + 3.5
            );
        }
        self.0 +=
            "<g font-size=\"11\" text-anchor=\"middle\" stroke=\"#fff\" stroke-width=\"3\" paint-order=\"stroke\">\n";
        for (p, name) in names {
            let (x, y) = place(&p);
            self.0 += &format!("<text x=\"{x:.1}\" y=\"{y:.1}\">{}</text>\n", escape(name));
        }
        self.0 += "</g>\n";
        let y = top + deep * scale + MARGIN;
        // A ruler as long as it says.
        let metre = scale;
        self.0 += &format!("<path d=\"M{MARGIN} {y:.1}h{metre:.1}\" stroke=\"#333\" stroke-width=\"2\"/>\n");
        self.text(MARGIN + metre + 6.0, y + 4.0, 11.0, "normal", "1 m");
        y
    }

    /// Draws a lane for each agent; returns where it ends.
    fn schedule(&mut self, plan: &Plan, top: f64) -> f64 {
        let head = format!("{}: cost {:.4}, {:.2} s", plan.task, plan.cost, plan.makespan);
        self.text(MARGIN, top, 12.0, "bold", &head);
        let left = MARGIN + 90.0;
        let scale = (WIDTH - MARGIN - left) / plan.makespan.max(1e-3);
        let mut y = top + 10.0;
        for (agent, stream) in &plan.streams {
            self.text(MARGIN, y + LANE / 2.0 + 4.0, 12.0, "normal", agent);
            for action in stream.iter().take(MOST_BARS).filter_map(|i| plan.actions.get(*i)) {
                let (x, width) = (
                    left + action.start * scale,
                    ((action.end - action.start) * scale).max(1.0),
                );
                let color = COLORS[action.index % COLORS.len()];
                let name = escape(&format!("{} {}", action.index, action.name));
                let whole = escape(&format!("{}({})", action.name, action.arguments.join(", ")));
                self.0 += &format!(
                    "<g><title>{whole}, cost {:.4}</title><rect x=\"{x:.1}\" y=\"{:.1}\" width=\"{width:.1}\" height=\"{:.1}\" fill=\"{color}\" \
                     fill-opacity=\"0.5\" stroke=\"{color}\"/>",
                    action.cost,
                    y + 3.0,
                    LANE - 6.0
                );
                // As much of the name as fits, at 6 px a letter.
                if name.len() as f64 * 6.0 < width {
                    self.0 += &format!(
                        "<text x=\"{:.1}\" y=\"{:.1}\" font-size=\"11\">{name}</text>",
                        x + 4.0,
                        y + LANE / 2.0 + 4.0
                    );
                }
                self.0 += "</g>\n";
            }
            y += LANE;
        }
        y
    }

    /// Draws the decomposition as an indented list, with the costs of actions; returns where it ends.
    fn tree(&mut self, plan: &Plan, top: f64) -> f64 {
        let mut depths: Vec<usize> = Vec::with_capacity(MOST_ROWS);
        let mut y = top;
        for node in plan.decomposition.iter().take(MOST_ROWS) {
            // A node stands after its parent.
            let depth = node.parent.and_then(|p| depths.get(p)).map_or(0, |d| d + 1);
            depths.push(depth);
            let x = MARGIN + 20.0 * depth.min(20) as f64;
            let call = format!("{}({})", node.task, node.arguments.join(", "));
            match node.action.and_then(|a| plan.actions.get(a)) {
                Some(action) => {
                    let color = COLORS[action.index % COLORS.len()];
                    self.0 += &format!(
                        "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"4\" fill=\"{color}\"/>\n",
                        x + 4.0,
                        y - 4.0
                    );
                    let text = format!("{} {call}  {:.4}", action.index, action.cost);
                    self.text(x + 12.0, y, 11.0, "normal", &text);
                }
                None => self.text(x, y, 11.0, "bold", &call),
            }
            y += ROW;
        }
        if let Some(rest @ 1..) = plan.decomposition.len().checked_sub(MOST_ROWS) {
            self.text(MARGIN, y, 11.0, "normal", &format!("and {rest} more"));
            y += ROW;
        }
        y
    }

    fn finish(self, height: f64) -> String {
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH}\" height=\"{height:.0}\" viewBox=\"0 0 {WIDTH} {height:.0}\" \
             font-family=\"sans-serif\">\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n{}</svg>\n",
            self.0
        )
    }
}

fn escape(text: &str) -> String {
    // What XML has no way to write is left out.
    let text: String = text.chars().filter(|c| !c.is_control()).collect();
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}
