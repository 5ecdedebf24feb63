//! Geometric actions of the language: names, kinds, and the sub-actions in ids; what one action takes over from another
//! is written out.
//!
//! What may stand in a sub-action is in the tables of [`words`]. Does not know whether an action can succeed.

use std::collections::BTreeSet;
use std::sync::Arc;

use indexmap::IndexMap;

use super::kinds::Kind;
use super::names::{Asks, Names, Question};
use super::words::{self, Argument, Thing, Word};
use super::{PRELUDE, problems};
use crate::diag::{Problems, Severity};
use crate::ir::geometric::{
    APPROACH, Change, Choice, ChoiceSet, Condition, FactOf, Geometric, GeometricParam, Place, Role, Space, SubAction,
    Target,
};
use crate::ir::{ChoiceId, NamedGeometric, ParamId};
use crate::syntax::ast::{self, ExprKind, GeometricPart, Item, Name};

/// Sub-actions of one action, those that it takes over included. HEURISTIC: far above real ones; without it twenty actions,
/// each doing the one before twice, would fill the memory.
const MAX_SUB_ACTIONS: usize = 200;

/// Compiles all geometric actions, those that others take over first.
pub(super) fn compile(items: &[&Item], names: &mut Names, problems: &mut Problems) {
    let mut declared: IndexMap<&str, &ast::Geometric> = IndexMap::new();
    for item in items {
        if let Item::Geometric(g) = item
            && names
                .geometrics
                .get(&g.name.text)
                .is_some_and(|s| s.span == g.name.span)
        {
            declared.insert(&g.name.text, g);
        }
    }
    let calls = |g: &&ast::Geometric| {
        let called: BTreeSet<usize> = g
            .body
            .iter()
            .flatten()
            .filter_map(|part| match part {
                GeometricPart::Call(call) => declared.get_index_of(call.call.name.text.as_str()),
                GeometricPart::Choices(_) | GeometricPart::SubAction(_) | GeometricPart::InTheEnd(_) => None,
            })
            .collect();
        called.into_iter().collect()
    };
    let after: Vec<Vec<usize>> = declared.values().map(calls).collect();
    let sorted = super::order::sort(&after);
    for (_, g) in sorted.circles.iter().flatten().filter_map(|i| declared.get_index(*i)) {
        problems.push(problems::endless_geometric(&g.name));
    }
    let mut known: IndexMap<&str, Arc<Geometric>> = IndexMap::new();
    for i in sorted.order {
        let Some((name, g)) = declared.get_index(i) else {
            continue;
        };
        let compiled = Compiler::new(g, names, &known, problems).compile();
        if let Some(action) = compiled {
            known.insert(*name, action);
        }
    }
    // In the order of the file.
    for (name, g) in &declared {
        if let Some(action) = known.get(name) {
            names.domain.geometrics.push(NamedGeometric {
                name: (*name).to_owned(),
                action: Arc::clone(action),
                is_built_in: g.span.file == PRELUDE,
            });
        }
    }
}

/// One action at work.
struct Compiler<'c> {
    source: &'c ast::Geometric,
    names: &'c Names,
    known: &'c IndexMap<&'c str, Arc<Geometric>>,
    problems: &'c mut Problems,
    out: Geometric,
    /// Names of the choices that this action makes itself; `None` for those it takes over.
    chosen: Vec<Option<&'c Name>>,
    used: BTreeSet<ChoiceId>,
    is_whole: bool,
}

impl<'c> Compiler<'c> {
    fn new(
        source: &'c ast::Geometric,
        names: &'c Names,
        known: &'c IndexMap<&'c str, Arc<Geometric>>,
        problems: &'c mut Problems,
    ) -> Self {
        let out = Geometric {
            name: source.name.text.clone(),
            params: Vec::new(),
            choices: Vec::new(),
            sub_actions: Vec::new(),
        };
        Compiler {
            source,
            names,
            known,
            problems,
            out,
            chosen: Vec::new(),
            used: BTreeSet::new(),
            is_whole: true,
        }
    }

    fn compile(mut self) -> Option<Arc<Geometric>> {
        let n_before = self.problems.0.len();
        self.params();
        let Some(body) = &self.source.body else {
            self.problems.push(problems::geometric_without_body(&self.source.name));
            return None;
        };
        // An action that is another one and nothing else is a name for it.
        if let [GeometricPart::Call(call)] = body.as_slice()
            && let Some(same) = self.renamed(call)
        {
            return Some(same);
        }
        for part in body {
            match part {
                GeometricPart::InTheEnd(facts) => self.in_the_end(facts),
                GeometricPart::Choices(choices) => choices.iter().for_each(|c| self.choice(c)),
                GeometricPart::SubAction(sub_action) => self.sub_action(sub_action),
                GeometricPart::Call(call) => self.taken_over(call),
            }
        }
        let has_errors = self.problems.0[n_before..]
            .iter()
            .any(|p| p.severity == Severity::Error);
        if has_errors || !self.is_whole {
            return None;
        }
        if self.out.sub_actions.is_empty() {
            let problem = problems::bad_sub_action(
                format!("geometric action `{}` has no sub-action", self.source.name.text),
                self.source.name.span,
                "moves nothing",
                "write one: `approach: moving arm(hand) until before(hand, grasp);`",
            );
            self.problems.push(problem);
            return None;
        }
        if let Some(message) = beyond(&self.out) {
            let message = format!("geometric action `{}` {message}", self.source.name.text);
            let help = "split it into actions with one arm, one object and one placement each, or one way of a base";
            let problem = problems::not_supported(message, self.source.name.span, help);
            self.problems.push(problem);
            return None;
        }
        for (i, name) in self.chosen.iter().enumerate() {
            if let Some(name) = name
                && !self.used.contains(&ChoiceId(i as u32))
            {
                self.problems.push(problems::unused_choice(name));
            }
        }
        Some(Arc::new(self.out))
    }

    fn params(&mut self) {
        for (param, (_, kind)) in self.source.params.iter().zip(self.signature()) {
            let role = match kind {
                Kind::Entity(ty) if self.names.domain.is_subtype(ty, self.names.agent()) => Role::Agent,
                Kind::Entity(_) => Role::Thing,
                Kind::Any | Kind::Unknown => Role::Entity,
                Kind::Number | Kind::Bool | Kind::String | Kind::Set(_) | Kind::Null | Kind::Duration => {
                    let found = kind.words(&self.names.domain);
                    let problem = problems::wrong_type(param.span, "an entity", &found)
                        .help("what a geometric action is done to are entities: an agent, an object, `any` of them");
                    self.problems.push(problem);
                    Role::Entity
                }
            };
            self.out.params.push(GeometricParam {
                name: param.name.text.clone(),
                role,
            });
        }
    }

    fn signature(&self) -> Vec<(String, Kind)> {
        let signature = self.names.geometrics.get(&self.source.name.text);
        signature.map_or_else(Vec::new, |s| s.params.clone())
    }

    /// Returns the other action if the call hands all parameters on as they are and makes no choice.
    fn renamed(&mut self, call: &ast::GeometricCall) -> Option<Arc<Geometric>> {
        let other = self.known.get(call.call.name.text.as_str())?;
        let as_they_are = call.call.args.len() == self.out.params.len()
            && other.params.len() == self.out.params.len()
            && call.given.is_empty()
            && call.call.args.iter().zip(&self.out.params).all(
                |(arg, param)| matches!(&arg.kind, ExprKind::Path(p) if p.steps.is_empty() && p.root.text == param.name),
            )
            && self.out.params.iter().zip(&other.params).all(|(own, theirs)| own.role == theirs.role || own.role == Role::Entity);
        as_they_are.then(|| Arc::clone(other))
    }

    // ---- Choices ----

    fn choice(&mut self, choice: &'c ast::Choice) {
        let n_args = choice.from.args.len();
        let Some((word, args)) = self.call(words::CHOICES, "set of choices", &choice.from) else {
            self.add_choice(choice, None);
            return;
        };
        debug_assert_eq!(word.args.len(), n_args);
        let from = match (word.name, args.as_slice()) {
            ("arms", [Argument::Param(agent)]) => ChoiceSet::Arms(*agent),
            ("grasps", [Argument::Param(object)]) => ChoiceSet::Grasps(*object),
            ("supports", [Argument::Param(object)]) => ChoiceSet::Supports(*object),
            ("stable", [Argument::Param(object)]) => ChoiceSet::Stable(*object),
            ("points", [Argument::Choice(face)]) => ChoiceSet::Points(*face),
            ("centre", [Argument::Choice(face)]) => ChoiceSet::Centre(*face),
            ("angles", []) => ChoiceSet::Angles,
            ("stands", [Argument::Param(agent), Argument::Param(entity)]) => ChoiceSet::Stands {
                agent: *agent,
                entity: *entity,
            },
            (name, _) => unreachable!("geometrics: `{name}` has no meaning as a set of choices"),
        };
        self.add_choice(choice, Some(from));
    }

    fn add_choice(&mut self, choice: &'c ast::Choice, from: Option<ChoiceSet>) {
        let name = &choice.name;
        let is_param = self.source.params.iter().find(|p| p.name.text == name.text);
        let first = self.chosen.iter().flatten().find(|c| c.text == name.text);
        let first = is_param.map(|p| p.name.span).or(first.map(|c| c.span));
        if let Some(first) = first {
            self.problems
                .push(problems::duplicate("choice", &name.text, name.span, Some(first)));
            return;
        }
        let Some(from) = from else {
            self.is_whole = false;
            // Known all the same, or every line that speaks of it would be an error.
            self.chosen.push(Some(name));
            let unknown = ChoiceSet::Angles;
            self.out.choices.push(Choice {
                name: name.text.clone(),
                from: unknown,
            });
            return;
        };
        self.chosen.push(Some(name));
        self.out.choices.push(Choice {
            name: name.text.clone(),
            from,
        });
    }

    // ---- Sub-actions ----

    fn sub_action(&mut self, source: &'c ast::SubAction) {
        let double = self.source.body.iter().flatten().find_map(|part| match part {
            GeometricPart::SubAction(s) if s.name.text == source.name.text => Some(s.name.span),
            _ => None,
        });
        if let Some(first) = double.filter(|first| *first != source.name.span) {
            let name = &source.name;
            self.problems
                .push(problems::duplicate("sub-action", &name.text, name.span, Some(first)));
        }
        let when: Vec<Condition> = source.when.iter().filter_map(|call| self.condition(call)).collect();
        let space = self.space(source);
        let carried = source.carrying.as_ref().map(|name| (name, self.carried(name)));
        let (mut target, mut facts) = (None, Vec::new());
        for call in &source.until {
            match self.until(call) {
                Some(Until::Target(t)) => self.set_target(&mut target, t, call),
                Some(Until::Fact(fact)) => facts.push(fact),
                None => self.is_whole = false,
            }
        }
        let change = source.change.as_ref().and_then(|call| self.change(call, space));
        let (Some(space), true) = (space, self.is_whole) else {
            self.is_whole = false;
            return;
        };
        let Some((target, arm, call)) = target else {
            self.problems.push(problems::bad_sub_action(
                format!("nothing says where sub-action `{}` ends", source.name.text),
                source.name.span,
                "no target",
                "write one behind `until`: `at(hand, grasp)`, `up(hand)`, `open(hand)` ...",
            ));
            return;
        };
        let mut when = when;
        if let Some((name, object)) = carried {
            match object {
                Some(object) => match space.arm() {
                    Some(arm) => when.push(Condition::Holds(arm, object)),
                    None => self.problems.push(problems::bad_sub_action(
                        "`with` is about what is in the hand of an arm".into(),
                        name.span,
                        "no arm moves",
                        "leave it out: what is held goes along",
                    )),
                },
                None => self.problems.push(problems::unknown_in_geometric(name, self.listed())),
            }
        }
        self.fits(source, space, target, arm, call, &when);
        self.add(
            SubAction {
                name: source.name.text.clone(),
                when,
                space,
                until: target,
                facts,
                change,
            },
            source.name.span,
        );
    }

    /// Adds facts to the last sub-action.
    fn in_the_end(&mut self, calls: &[ast::Call]) {
        for call in calls {
            let fact = match self.fact(call) {
                Some(fact) => fact,
                None => {
                    let known = self.names.facts.keys().map(String::as_str);
                    let (name, span) = (&call.name.text, call.name.span);
                    self.problems
                        .push(problems::unknown("hatp::unknown-fact", "fact", name, span, known));
                    None
                }
            };
            match (fact, self.out.sub_actions.last_mut()) {
                (Some(fact), Some(last)) => last.facts.push(fact),
                (Some(_), None) if self.is_whole => self.problems.push(problems::bad_sub_action(
                    "nothing is done before this holds".into(),
                    call.span,
                    "no sub-action stands above",
                    "write it behind the last sub-action",
                )),
                _ => self.is_whole = false,
            }
        }
    }

    fn add(&mut self, sub_action: SubAction, span: crate::source::Span) {
        if self.out.sub_actions.len() == MAX_SUB_ACTIONS {
            let message = format!(
                "geometric action `{}` has more than {MAX_SUB_ACTIONS} sub-actions",
                self.out.name
            );
            let problem = problems::bad_sub_action(message, span, "one too many", "make two actions of it");
            self.problems.push(problem);
        }
        if self.out.sub_actions.len() <= MAX_SUB_ACTIONS {
            self.out.sub_actions.push(sub_action);
        }
    }

    fn set_target(
        &mut self,
        target: &mut Option<(Target, Option<ChoiceId>, &'c ast::Call)>,
        new: (Target, Option<ChoiceId>),
        call: &'c ast::Call,
    ) {
        if let Some((_, _, first)) = target {
            let problem = problems::bad_sub_action(
                format!("`{}` is a second place to end at", call.name.text),
                call.span,
                "a second one",
                "make two sub-actions of it",
            );
            self.problems.push(problem.note(first.span, "the first one"));
            return;
        }
        *target = Some((new.0, new.1, call));
    }

    /// Says what is wrong with a target for what moves.
    fn fits(
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

    fn choice_name(&self, choice: ChoiceId) -> String {
        self.out
            .choices
            .get(choice.index())
            .map_or_else(String::new, |c| c.name.clone())
    }

    fn condition(&mut self, call: &'c ast::Call) -> Option<Condition> {
        if let Some(fact) = self.fact(call) {
            return fact.map(Condition::Fact);
        }
        let (word, args) = self.call(words::CONDITIONS, "pre-condition", call)?;
        Some(match (word.name, args.as_slice()) {
            ("free", [Argument::Choice(arm)]) => Condition::Free(*arm),
            ("holds", [Argument::Choice(arm), Argument::Param(object)]) => Condition::Holds(*arm, *object),
            (name, _) => unreachable!("geometrics: `{name}` has no meaning as a pre-condition"),
        })
    }

    fn space(&mut self, source: &'c ast::SubAction) -> Option<Space> {
        let (word, args) = self.call(words::SPACES, "search space", &source.moving)?;
        let space = match (word.name, args.as_slice()) {
            ("arm", [Argument::Choice(arm)]) if source.is_straight => Space::ArmStraight(*arm),
            ("arm", [Argument::Choice(arm)]) => Space::Arm(*arm),
            ("gripper", [Argument::Choice(arm)]) => Space::Gripper(*arm),
            ("body", [Argument::Param(agent)]) => Space::Body(*agent),
            ("base", [Argument::Param(agent)]) => Space::Base(*agent),
            (name, _) => unreachable!("geometrics: `{name}` has no meaning as a search space"),
        };
        if source.is_straight && !matches!(space, Space::ArmStraight(_)) {
            self.problems.push(problems::bad_sub_action(
                "only an arm moves its tool along a line".into(),
                source.moving.span,
                "not an arm",
                "remove `straight`",
            ));
        }
        Some(space)
    }

    fn carried(&mut self, name: &Name) -> Option<ParamId> {
        let at = self.out.params.iter().position(|p| p.name == name.text)?;
        if self.out.params.get(at).is_some_and(|p| p.role == Role::Agent) {
            let problem = problems::wrong_type(name.span, Thing::Object.words(), Thing::Agent.words());
            self.problems.push(problem);
        }
        Some(ParamId(at as u32))
    }

    fn until(&mut self, call: &'c ast::Call) -> Option<Until> {
        if let Some(fact) = self.fact(call) {
            return fact.map(Until::Fact);
        }
        let (word, args) = self.call(words::TARGETS, "final constraint", call)?;
        let length = |i: usize| match args.get(i) {
            Some(Argument::Number(d)) => *d,
            _ => APPROACH,
        };
        let (target, arm) = match (word.name, args.as_slice()) {
            ("open", [Argument::Choice(arm)]) => (Target::Open, Some(*arm)),
            ("closed", [Argument::Choice(arm)]) => (Target::Closed(None), Some(*arm)),
            ("closed", [Argument::Choice(arm), Argument::Choice(grasp)]) => (Target::Closed(Some(*grasp)), Some(*arm)),
            ("before", [Argument::Choice(arm), Argument::Choice(grasp), ..]) => {
                let before = length(2);
                (Target::Grasp { grasp: *grasp, before }, Some(*arm))
            }
            ("at", [Argument::Choice(arm), Argument::Choice(grasp)]) => (
                Target::Grasp {
                    grasp: *grasp,
                    before: 0.0,
                },
                Some(*arm),
            ),
            ("up", [Argument::Choice(arm), ..]) => (Target::Up(length(1)), Some(*arm)),
            ("back", [Argument::Choice(arm), ..]) => (Target::Back(length(1)), Some(*arm)),
            ("posture", [Argument::Param(_)]) => (Target::Posture, None),
            ("at", [Argument::Choice(stand)]) => (Target::Stand(*stand), None),
            ("at", [Argument::Param(_), ..]) => (
                Target::Placement {
                    place: self.place(call, &args)?,
                    above: 0.0,
                },
                None,
            ),
            ("above", [Argument::Param(_), ..]) => {
                let above = length(5);
                (
                    Target::Placement {
                        place: self.place(call, &args)?,
                        above,
                    },
                    None,
                )
            }
            (name, _) => unreachable!("geometrics: `{name}` has no meaning as a final constraint"),
        };
        Some(Until::Target((target, arm)))
    }

    /// Returns where an object is to stand, if its face, orientation and point belong together.
    fn place(&mut self, call: &ast::Call, args: &[Argument]) -> Option<Place> {
        let [
            Argument::Param(object),
            Argument::Choice(face),
            Argument::Choice(stable),
            Argument::Choice(point),
            Argument::Choice(yaw),
            ..,
        ] = args
        else {
            return None;
        };
        let from = |c: &ChoiceId| self.out.choices.get(c.index()).map(|c| c.from);
        let apart = |i: usize, what: &str, of: String| {
            let span = call.args.get(i).map_or(call.span, |a| a.span);
            let name = call
                .args
                .get(i)
                .map_or_else(String::new, |_| self.choice_name([*face, *stable, *point][i - 1]));
            problems::bad_sub_action(
                format!("`{name}` is {what} of something else"),
                span,
                format!("not of `{of}`"),
                "the face, the orientation and the point of a placement belong together",
            )
        };
        let problem = match (from(stable), from(point)) {
            (Some(ChoiceSet::Stable(of)), _) if of != *object => {
                let name = self.out.params.get(object.index()).map_or("?", |p| p.name.as_str());
                Some(apart(2, "an orientation", name.to_owned()))
            }
            (_, Some(ChoiceSet::Points(of) | ChoiceSet::Centre(of))) if of != *face => {
                Some(apart(3, "a point", self.choice_name(*face)))
            }
            _ => None,
        };
        if let Some(problem) = problem {
            self.problems.push(problem);
            return None;
        }
        Some(Place {
            object: *object,
            face: *face,
            stable: *stable,
            point: *point,
            yaw: *yaw,
        })
    }

    fn change(&mut self, call: &'c ast::Call, space: Option<Space>) -> Option<Change> {
        let Some((word, args)) = self.call(words::CHANGES, "change", call) else {
            self.is_whole = false;
            return None;
        };
        let (change, arm) = match (word.name, args.as_slice()) {
            ("attach", [Argument::Param(object), Argument::Choice(arm)]) => (Change::Attach(*object), *arm),
            ("detach", [Argument::Param(object), Argument::Choice(arm)]) => (Change::Detach(*object), *arm),
            (name, _) => unreachable!("geometrics: `{name}` has no meaning as a change"),
        };
        if let Some(moving) = space.and_then(Space::arm).filter(|moving| *moving != arm) {
            let (arm, moving) = (self.choice_name(arm), self.choice_name(moving));
            self.problems.push(problems::bad_sub_action(
                format!("`{}` is about `{arm}`, and `{moving}` moves", word.name),
                call.span,
                "of another arm",
                format!("write `{moving}` in both places"),
            ));
        }
        Some(change)
    }

    /// Returns a fact of the prelude, or `None` inside where it is called wrongly; `None` outside if it is no fact.
    fn fact(&mut self, call: &ast::Call) -> Option<Option<FactOf>> {
        let name = &call.name.text;
        let names = self.names;
        let question: &Question = names.facts.get(name).or_else(|| names.requests.get(name))?;
        let Asks::Geometry(request) = question.asks else {
            self.problems.push(problems::not_supported(
                format!("fact `{name}` is the domain's own, and a geometric action asks geometry alone"),
                call.name.span,
                "write what it means in `constraints` of the action that projects",
            ));
            return Some(None);
        };
        if question.result != Kind::Bool {
            let found = question.result.words(&names.domain);
            self.problems.push(problems::wrong_type(call.span, "a fact", &found));
            return Some(None);
        }
        let params = &question.signature.params;
        if params.len() != call.args.len() {
            let wanted: Vec<String> = params.iter().map(|p| p.0.clone()).collect();
            let declared = question.signature.span;
            let problem = problems::wrong_count("fact", &call.name, &wanted, call.args.len(), declared);
            self.problems.push(problem);
            return Some(None);
        }
        let mut args = Vec::new();
        for (arg, (_, kind)) in call.args.iter().zip(params) {
            let is_agent = matches!(kind, Kind::Entity(_));
            let wanted = if is_agent { Thing::Agent } else { Thing::Entity };
            match self.argument(arg, wanted) {
                Some(Argument::Param(param)) => args.push(param),
                _ => return Some(None),
            }
        }
        Some(Some(FactOf { request, args }))
    }

    // ---- Calls ----

    /// Returns the word that is called, of those in `table`, and its arguments; or says what is wrong with it.
    fn call(&mut self, table: &'static [Word], what: &str, call: &ast::Call) -> Option<(&'static Word, Vec<Argument>)> {
        let name = &call.name.text;
        let named: Vec<&'static Word> = table.iter().filter(|w| w.name == name).collect();
        if named.is_empty() {
            let known: BTreeSet<&str> = table.iter().map(|w| w.name).collect();
            let mut problem = problems::unknown("hatp::unknown-geometric-word", what, name, call.name.span, known);
            if let Some(other) = words::place_of(name).filter(|other| *other != what) {
                problem = problem.help(format!("`{name}` is a {other}"));
            }
            self.problems.push(problem);
            self.is_whole = false;
            return None;
        }
        // Words of two meanings differ in their first argument.
        let first = call.args.first().and_then(|a| self.kind_of(a));
        let word = named
            .iter()
            .find(|w| first.is_some_and(|f| w.args.first().is_some_and(|a| f.fits(*a))))
            .or(named.first())?;
        if call.args.len() < word.n_required || call.args.len() > word.args.len() {
            let wanted: Vec<String> = word.args.iter().map(|a| a.example().to_owned()).collect();
            self.problems.push(problems::wrong_words_count(
                what,
                &call.name,
                &wanted,
                word.n_required,
                call.args.len(),
            ));
            self.is_whole = false;
            return None;
        }
        let mut args = Vec::new();
        for (arg, wanted) in call.args.iter().zip(word.args) {
            args.push(self.argument(arg, *wanted));
        }
        let args: Option<Vec<Argument>> = args.into_iter().collect();
        self.is_whole &= args.is_some();
        args.map(|args| (*word, args))
    }

    /// Returns what kind of thing an argument is, without saying anything.
    fn kind_of(&self, arg: &ast::Expr) -> Option<Thing> {
        match &arg.kind {
            ExprKind::Number(_) => Some(Thing::Length),
            ExprKind::Path(path) if path.steps.is_empty() => self.named(&path.root.text).map(|(_, thing)| thing),
            _ => None,
        }
    }

    fn named(&self, name: &str) -> Option<(Argument, Thing)> {
        if let Some(i) = self.chosen.iter().position(|c| c.is_some_and(|c| c.text == name)) {
            let from = self.out.choices.get(i)?.from;
            return Some((Argument::Choice(ChoiceId(i as u32)), Thing::chosen(from)));
        }
        let i = self.out.params.iter().position(|p| p.name == name)?;
        let thing = match self.out.params.get(i)?.role {
            Role::Agent => Thing::Agent,
            Role::Thing => Thing::Object,
            Role::Entity => Thing::Entity,
        };
        Some((Argument::Param(ParamId(i as u32)), thing))
    }

    fn listed(&self) -> Vec<String> {
        let params = self.out.params.iter().map(|p| p.name.clone());
        params
            .chain(self.chosen.iter().flatten().map(|c| c.text.clone()))
            .collect()
    }

    fn argument(&mut self, arg: &ast::Expr, wanted: Thing) -> Option<Argument> {
        let found = match &arg.kind {
            ExprKind::Number(x) => Some((Argument::Number(*x), Thing::Length)),
            ExprKind::Path(path) if path.steps.is_empty() => {
                let found = self.named(&path.root.text);
                if found.is_none() {
                    self.problems
                        .push(problems::unknown_in_geometric(&path.root, self.listed()));
                    return None;
                }
                found
            }
            _ => None,
        };
        let Some((argument, thing)) = found else {
            let found = "an expression";
            let problem = problems::wrong_type(arg.span, wanted.words(), found);
            self.problems
                .push(problem.help("write a parameter, a choice or a number of metres"));
            return None;
        };
        if let Argument::Choice(choice) = argument {
            self.used.insert(choice);
            if !self.is_whole && thing == Thing::Angle {
                // A choice from something unknown may be of any kind.
                return Some(argument);
            }
        }
        if !thing.fits(wanted) {
            let problem = problems::wrong_type(arg.span, wanted.words(), thing.words());
            let help = (thing == Thing::Entity && wanted == Thing::Agent)
                .then(|| "declare the parameter as an `Agent`".to_owned());
            self.problems.push(problem.maybe_help(help));
            return None;
        }
        if let (Argument::Param(param), Thing::Object | Thing::Agent) = (argument, wanted)
            && let Some(param) = self.out.params.get_mut(param.index())
            && param.role == Role::Entity
        {
            // From now on it is known what it has to be.
            param.role = Role::Thing;
        }
        if let Argument::Number(x) = argument
            && !(x.is_finite() && (0.0..=10.0).contains(&x))
        {
            self.problems.push(problems::bad_sub_action(
                format!("{x} m is no distance of an approach"),
                arg.span,
                "from 0 to 10 m",
                "distances are in metres",
            ));
            return None;
        }
        Some(argument)
    }

    // ---- Other actions ----

    /// Writes out another action: its choices and sub-actions, with own parameters for its own.
    fn taken_over(&mut self, source: &'c ast::GeometricCall) {
        let call = &source.call;
        let Some(other) = self.known.get(call.name.text.as_str()).map(Arc::clone) else {
            self.is_whole = false;
            if !self.names.geometrics.contains_key(&call.name.text) {
                let known = self.names.geometrics.keys().map(String::as_str);
                let problem = problems::unknown(
                    "hatp::unknown-geometric",
                    "geometric action",
                    &call.name.text,
                    call.name.span,
                    known,
                );
                self.problems.push(problem);
            }
            return;
        };
        if other.params.len() != call.args.len() {
            let wanted: Vec<String> = other.params.iter().map(|p| p.name.clone()).collect();
            let declared = self.names.geometrics.get(&call.name.text).map_or(call.span, |s| s.span);
            let problem = problems::wrong_count("geometric action", &call.name, &wanted, call.args.len(), declared);
            self.problems.push(problem);
            self.is_whole = false;
            return;
        }
        let mut params = Vec::new();
        for (arg, param) in call.args.iter().zip(&other.params) {
            let wanted = match param.role {
                Role::Agent => Thing::Agent,
                Role::Thing => Thing::Object,
                Role::Entity => Thing::Entity,
            };
            match self.argument(arg, wanted) {
                Some(Argument::Param(p)) => params.push(p),
                _ => self.is_whole = false,
            }
        }
        let given = self.given(source, &other);
        if !self.is_whole {
            return;
        }
        let mut choices: Vec<ChoiceId> = Vec::new();
        for (i, choice) in other.choices.iter().enumerate() {
            if let Some((_, own)) = given.iter().find(|(theirs, _)| theirs.index() == i) {
                choices.push(*own);
                continue;
            }
            let id = ChoiceId(self.out.choices.len() as u32);
            let from = choice.from.renamed(&params, &choices);
            self.out.choices.push(Choice {
                name: choice.name.clone(),
                from,
            });
            self.chosen.push(None);
            choices.push(id);
        }
        for sub_action in &other.sub_actions {
            self.add(sub_action.renamed(&params, &choices), call.span);
        }
    }

    /// Returns which choices of another action are made by choices of this one.
    fn given(&mut self, source: &ast::GeometricCall, other: &Geometric) -> Vec<(ChoiceId, ChoiceId)> {
        let mut out = Vec::new();
        for binding in &source.given {
            let Some(theirs) = other.choices.iter().position(|c| c.name == binding.name.text) else {
                let known = other.choices.iter().map(|c| c.name.as_str());
                let name = &binding.name;
                self.problems.push(problems::unknown(
                    "hatp::unknown-choice",
                    "choice",
                    &name.text,
                    name.span,
                    known,
                ));
                self.is_whole = false;
                continue;
            };
            let wanted = Thing::chosen(other.choices[theirs].from);
            match self.argument(&binding.value, wanted) {
                Some(Argument::Choice(own)) => out.push((ChoiceId(theirs as u32), own)),
                _ => self.is_whole = false,
            }
        }
        out
    }
}

/// A final constraint.
enum Until {
    /// With the arm that it is about.
    Target((Target, Option<ChoiceId>)),
    Fact(FactOf),
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
    fn moved_by(space: Space) -> Part {
        match space {
            Space::Arm(_) | Space::ArmStraight(_) => Part::Arm,
            Space::Gripper(_) => Part::Fingers,
            Space::Body(_) => Part::Body,
            Space::Base(_) => Part::Base,
        }
    }

    fn ended_by(target: Target) -> Part {
        match target {
            Target::Open | Target::Closed(_) => Part::Fingers,
            Target::Grasp { .. } | Target::Up(_) | Target::Back(_) | Target::Placement { .. } => Part::Arm,
            Target::Posture => Part::Body,
            Target::Stand(_) => Part::Base,
        }
    }

    /// How it is called, and where it can end.
    fn words(self) -> (&'static str, &'static str) {
        match self {
            Part::Arm => ("an arm", "`at`, `above`, `up` ..."),
            Part::Fingers => ("the fingers", "`open` or `closed`"),
            Part::Body => ("a body", "`posture`"),
            Part::Base => ("a base", "`at(stand)`"),
        }
    }
}

/// Returns what an action that goes has besides.
fn beyond_going(action: &Geometric) -> Option<String> {
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
fn beyond(action: &Geometric) -> Option<String> {
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
