//! What goes together in a geometric action: where what moves can end, and what one action can do at all.

use super::*;

impl Compiler<'_> {
    /// Says what is wrong with a target for what moves.
    pub(super) fn fits(
        &mut self,
        source: &ast::SubAction,
        space: Space,
        target: Target,
        arm: Option<ChoiceId>,
        call: &ast::Call,
        when: &[Condition],
    ) {
        let moving = Part::moved_by(space);
        let ending = Part::ended_by(target);
        let what = &call.name.text;
        let problems = &mut *self.problems;
        let mut say = |message: String, label: &str, help: String| {
            let problem = problems::bad_sub_action(message, call.span, label, help);
            problems.push(problem.note(source.moving.span, "this moves"));
        };
        let out = &self.out;
        let choice_name = |choice: ChoiceId| out.choices.get(choice.index()).map_or("?", |c| c.name.as_str());
        if moving != ending {
            let (parts, other) = moving.words();
            say(
                format!("`{what}` is no place where {parts} can end"),
                "does not fit",
                format!("what moves can end at {other}"),
            );
            return;
        }
        if let (Some(arm), Some(moving)) = (arm, space.arm())
            && arm != moving
        {
            let (arm, moving) = (choice_name(arm), choice_name(moving));
            say(
                format!("`{what}` is about `{arm}`, and `{moving}` moves"),
                "of another arm",
                format!("write `{moving}` in both places"),
            );
            return;
        }
        if let (Target::Placement { place, .. }, Some(arm)) = (target, space.arm())
            && !when.contains(&Condition::Holds(arm, place.object))
        {
            let object = out.params.get(place.object.index()).map_or("?", |p| p.name.as_str());
            say(
                format!("`{what}` is about `{object}`, and nothing says that it is in the hand"),
                "moves what is held",
                format!("write `with {object}` behind `moving ...`"),
            );
        }
    }
}

/// What moves in a sub-action.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Part {
    Arm,
    Fingers,
    Body,
    Base,
}

impl Part {
    pub(super) fn moved_by(space: Space) -> Part {
        match space {
            Space::Arm(_) | Space::ArmStraight(_) => Part::Arm,
            Space::Gripper(_) => Part::Fingers,
            Space::Body(_) => Part::Body,
            Space::Base(_) => Part::Base,
        }
    }

    pub(super) fn ended_by(target: Target) -> Part {
        match target {
            Target::Open | Target::Closed(_) => Part::Fingers,
            Target::Grasp { .. } | Target::Up(_) | Target::Back(_) | Target::Placement { .. } => Part::Arm,
            Target::Posture => Part::Body,
            Target::Stand(_) => Part::Base,
        }
    }

    /// How it is called, and where it can end.
    pub(super) fn words(self) -> (&'static str, &'static str) {
        match self {
            Part::Arm => ("an arm", "`at`, `above`, `up` ..."),
            Part::Fingers => ("the fingers", "`open` or `closed`"),
            Part::Body => ("a body", "`posture`"),
            Part::Base => ("a base", "`at(stand)`"),
        }
    }
}

/// Returns what an action that goes has besides.
pub(super) fn beyond_going(action: &Geometric) -> Option<String> {
    let n_stands = action
        .choices
        .iter()
        .filter(|c| matches!(c.from, ChoiceSet::Stands { .. }))
        .count();
    let n_ways = action
        .sub_actions
        .iter()
        .filter(|s| matches!(s.space, Space::Base(_)))
        .count();
    let goer = action.goes().map(|(agent, _)| agent);
    let is_going = |s: &SubAction| match s.space {
        Space::Body(_) if !s.facts.is_empty() => false,
        Space::Body(agent) | Space::Base(agent) => s.when.is_empty() && s.change.is_none() && Some(agent) == goer,
        Space::Arm(_) | Space::ArmStraight(_) | Space::Gripper(_) => false,
    };
    let ends_with_it = action
        .sub_actions
        .last()
        .is_some_and(|s| matches!(s.space, Space::Base(_)));
    if !action.sub_actions.iter().all(is_going) {
        return Some("goes somewhere and does something else".into());
    }
    if (n_stands, n_ways) != (1, 1) || !ends_with_it {
        return Some(format!(
            "has {n_stands} stands and {n_ways} ways to them, where the last sub-action is to be the only one"
        ));
    }
    None
}

/// Returns what an action has that the solver can't do.
pub(super) fn beyond(action: &Geometric) -> Option<String> {
    if action.goes().is_some() {
        return beyond_going(action);
    }
    let arms = action.choices.iter().filter(|c| matches!(c.from, ChoiceSet::Arms(_)));
    let n_arms = arms.count();
    if n_arms > 1 {
        return Some(format!("chooses {n_arms} arms"));
    }
    let (mut objects, mut places) = (BTreeSet::new(), BTreeSet::new());
    for choice in &action.choices {
        if let ChoiceSet::Grasps(object) = choice.from {
            objects.insert(object);
        }
    }
    for sub_action in &action.sub_actions {
        objects.extend(sub_action.change.map(Change::object));
        objects.extend(sub_action.when.iter().filter_map(|c| match c {
            Condition::Holds(_, object) => Some(*object),
            Condition::Free(_) | Condition::Fact(_) => None,
        }));
        if let Target::Placement { place, .. } = sub_action.until {
            places.insert((place.face, place.stable, place.point, place.yaw));
        }
    }
    match (objects.len(), places.len()) {
        (0, _) => Some("handles no object".into()),
        (1, 0 | 1) => None,
        (1, n) => Some(format!("has {n} placements")),
        (n, _) => Some(format!("handles {n} objects")),
    }
}
