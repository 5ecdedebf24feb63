//! Geometric actions of the language: names, kinds, and the sub-actions in ids; what one action takes over from another
//! is written out.
//!
//! What may stand in a sub-action is in the tables of [`words`]. Does not know whether an action can succeed.

mod arguments;
mod fits;
mod taken_over;

use std::collections::BTreeSet;
use std::sync::Arc;

use indexmap::IndexMap;

use fits::beyond;

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
}

/// A final constraint.
enum Until {
    /// With the arm that it is about.
    Target((Target, Option<ChoiceId>)),
    Fact(FactOf),
}
