//! Why a question has its answer, in words and numbers, for people (`sgap facts WORLD 'isReachable(CUP, PR2)'`).
//!
//! Computes the question again with everything in view, where the fact itself stops as soon as it is certain.
#![expect(non_snake_case, reason = "frame notation, docs/notation.md")]

use std::collections::BTreeMap;

use super::super::free_place;
use super::super::prepared::{Owner, Prepared, link_poses, place_all};
use super::super::relations;
use super::super::requests::{Fact, Question};
use super::reach::{Obstacle, Reach, reach};
use super::sight::{Eye, Surface, VISIBLE_SHARE, look};
use super::standing::{Bottom, CONTACT, OVERHANG, is_level};
use super::{has_in_hand, is_full};
use crate::world::{EntityRef, Scene, State};

/// Returns the reason, a clause without a period; empty where there is nothing to add to the answer.
pub(in crate::grp) fn why(scene: &Scene, prepared: &Prepared, state: &State, seed: u64, question: Question) -> String {
    let apart = |a: EntityRef, b: EntityRef| {
        let apart = relations::apart(scene, prepared, state, a.min(b), a.max(b));
        apart.map_or("one of them is nowhere".to_owned(), |d| {
            format!("they are {d:.3} m apart")
        })
    };
    match question {
        Question::Fact(fact) => match fact {
            Fact::IsOn { a, b } => standing(scene, state, a, b),
            Fact::IsIn { a, b } => match relations::sticks_out(scene, state, a, b) {
                Some((name, out)) if out <= 0.0 => format!("in `{name}` with {:.4} m to spare", -out),
                Some((name, out)) => format!("sticks {out:.4} m out of `{name}`"),
                None => format!("{} has no container", scene.objects[b].id),
            },
            Fact::IsNextTo { a, b } => format!("{}, {:.2} m is near", apart(a, b), relations::NEXT_TO),
            Fact::IsBigger { a, b } => {
                let litres = |e| 1000.0 * relations::volume(scene, e);
                let (a_id, b_id) = (scene.id(a), scene.id(b));
                format!("{a_id} has {:.3} l, {b_id} {:.3} l", litres(a), litres(b))
            }
            Fact::HasInHand { object, .. } => holder(scene, state, object).unwrap_or("nobody holds it".to_owned()),
            Fact::IsReachable { object, agent } => reachable(scene, prepared, state, seed, object, agent),
            Fact::IsVisible { object, agent } => visible(scene, prepared, state, object, agent),
        },
        Question::VirtualPlace { thing, on } => match free_place::find(scene, prepared, state, thing, on) {
            Some(X_WO) => {
                let p = X_WO.translation;
                format!("there is room at x {:.3}, y {:.3}, z {:.3}", p.x, p.y, p.z)
            }
            None => "no place was found".to_owned(),
        },
        Question::EnoughRoom { .. } | Question::PathExists { .. } => String::new(),
        Question::Distance { .. } => String::new(),
    }
}

fn holder(scene: &Scene, state: &State, object: usize) -> Option<String> {
    let held = state.objects[object].held.as_ref()?;
    let agent = &scene.agents[held.agent];
    Some(format!(
        "{} holds it in the {} hand",
        agent.id, agent.arms[held.arm].name
    ))
}

fn standing(scene: &Scene, state: &State, a: usize, b: usize) -> String {
    if let Some(holder) = holder(scene, state, a) {
        return holder;
    }
    let (above, below) = (&scene.objects[a], &scene.objects[b]);
    if above.stable.is_empty() {
        return format!("{} has no orientation in which it stands", above.id);
    }
    let (X_WA, X_WB) = (&state.objects[a].X_WO, &state.objects[b].X_WO);
    let faces = below.supports.iter().filter(|s| is_level(X_WB, s));
    let ways = faces.flat_map(|face| {
        let stable = above.stable.iter();
        stable.map(move |stable| (face, stable, Bottom::new(&(X_WB * face.X_OF), X_WA, stable, face)))
    });
    let upright = ways.filter(|(.., bottom)| bottom.is_upright());
    let off = |bottom: &Bottom| (bottom.gap.abs() - CONTACT).max(bottom.sticks_out - OVERHANG);
    let Some((face, stable, best)) = upright.min_by(|x, y| off(&x.2).total_cmp(&off(&y.2))) else {
        return format!("{} has no level face with an upright bottom above it", below.id);
    };
    let over = if best.sticks_out > OVERHANG {
        format!(", {:.4} m over its edge", best.sticks_out)
    } else {
        String::new()
    };
    format!(
        "its bottom `{}` is {:.4} m above `{}`{over}",
        stable.name, best.gap, face.name
    )
}

fn reachable(scene: &Scene, prepared: &Prepared, state: &State, seed: u64, object: usize, agent: usize) -> String {
    let body = &scene.agents[agent];
    if has_in_hand(state, agent, object) {
        return "it holds it".to_owned();
    }
    let mut whys = Vec::new();
    for (arm, of) in body.arms.iter().enumerate() {
        let name = &of.name;
        if is_full(state, agent, arm) {
            whys.push(format!("{name} hand: full"));
            continue;
        }
        match reach(scene, prepared, state, object, agent, arm, seed) {
            Reach::Free { grasp: Some(grasp), .. } => {
                return format!(
                    "with the {name} arm at grasp `{}`",
                    scene.objects[object].grasps[grasp].name
                );
            }
            Reach::Free { grasp: None, .. } => return format!("with the {name} hand"),
            Reach::Blocked(why) => whys.push(format!("{name} arm: {}", blocked(scene, &why, of.gripper.is_some()))),
        }
    }
    whys.join("; ")
}

fn blocked(scene: &Scene, why: &[Obstacle], has_grasps: bool) -> String {
    let (mut wide, mut far, mut unsolved) = (0, Vec::new(), Vec::new());
    let (mut hand, mut arm): (BTreeMap<String, u32>, BTreeMap<String, u32>) = Default::default();
    let pair = |(a, b): &(Owner, Owner)| format!("{} hits {}", a.name(scene), b.name(scene));
    for obstacle in why {
        match obstacle {
            Obstacle::Wide => wide += 1,
            Obstacle::Far(by) => far.push(*by),
            Obstacle::Unsolved(by) => unsolved.push(*by),
            Obstacle::Hand(a, b) => *hand.entry(pair(&(*a, *b))).or_default() += 1,
            Obstacle::Arm(hits) => {
                for hit in hits {
                    *arm.entry(pair(hit)).or_default() += 1;
                }
            }
        }
    }
    let least = |all: &[f64]| all.iter().copied().fold(f64::INFINITY, f64::min);
    let mut parts = Vec::new();
    if wide > 0 {
        parts.push(format!("{wide} too wide for the gripper"));
    }
    if !far.is_empty() {
        let n = if has_grasps {
            format!("{} ", far.len())
        } else {
            String::new()
        };
        parts.push(format!("{n}out of reach by {:.3} m or more", least(&far)));
    }
    for (what, n) in hand {
        parts.push(format!("at {n} the hand is in the way of something: {what}"));
    }
    if !unsolved.is_empty() {
        let n = if has_grasps {
            format!("{} ", unsolved.len())
        } else {
            String::new()
        };
        parts.push(format!(
            "{n}without a configuration, nearest {:.3} m off",
            least(&unsolved)
        ));
    }
    for (what, n) in arm {
        parts.push(if has_grasps { format!("at {n} {what}") } else { what });
    }
    match (has_grasps, parts.is_empty()) {
        (true, true) => "it has no grasps".to_owned(),
        (true, false) => format!("of {} grasps {}", why.len(), parts.join(", ")),
        (false, _) => parts.join(", "),
    }
}

fn visible(scene: &Scene, prepared: &Prepared, state: &State, object: usize, agent: usize) -> String {
    let Some(camera) = &scene.agents[agent].camera else {
        return format!("{} has no eyes", scene.agents[agent].id);
    };
    let X_WL = link_poses(scene, state);
    let X_WC = X_WL[agent][camera.link] * camera.X_LC;
    let others = place_all(prepared, state, &X_WL, &|owner| match owner {
        Owner::Link { agent: a, link } => a == agent && link == camera.link,
        Owner::Object(o) => o == object,
    });
    let bodies = others.iter().enumerate().map(|(i, b)| (i, b.solid, b.X_WS));
    let surface = Surface::of(&scene.objects[object]);
    let X_WO = &state.objects[object].X_WO;
    let view = look(&Eye { camera, X_WC }, &surface, X_WO, bodies, true);
    let percent = |area: f64| 100.0 * area / view.area;
    let mut hidden: BTreeMap<String, f64> = BTreeMap::new();
    for (i, area) in &view.hidden_by {
        *hidden.entry(others[*i].owner.name(scene)).or_default() += area;
    }
    let mut hidden: Vec<(String, f64)> = hidden.into_iter().collect();
    hidden.sort_by(|a, b| b.1.total_cmp(&a.1));
    let mut text = format!(
        "{:.0} % of its surface is seen, {:.0} % is enough",
        percent(view.seen),
        100.0 * VISIBLE_SHARE
    );
    if view.outside > 0.0 {
        text += &format!("; {:.0} % is outside of the field of view", percent(view.outside));
    }
    for (name, area) in hidden {
        text += &format!("; {:.0} % hidden by {name}", percent(area));
    }
    text
}
