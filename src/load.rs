//! Joins the two halves of the input: a domain with all its files, and the world that it is planned in.

mod domain;
mod pair;

pub use domain::{DomainFiles, read as domain_files};
pub use pair::{import_pair, is_hddl};

use crate::check::{self, Given, GivenEntity, GivenLiteral, GivenValue};
use crate::diag::{Problem, Problems, Severity};
use crate::hddl::Names;
use crate::ir::{self, Domain, Goal};
use crate::source::{FileId, Files, Sources};
use crate::syntax::{ast::Unread, parse_network};
use crate::world::{self, Literal, World};

/// Which files and which task, as the user names them.
#[derive(Debug, Clone, Copy, Default)]
pub struct Paths<'a> {
    pub domain: &'a str,
    /// Further files of the domain: functions that it leaves outside.
    pub with: &'a [&'a str],
    /// `None` plans on the symbols alone. Of a pair of HDDL files, the problem.
    pub world: Option<&'a str>,
    /// Overrides the world file's task.
    pub task: Option<&'a str>,
}

/// A domain compiled against a world, with the task to plan if one is named.
#[derive(Debug)]
pub struct Input {
    /// Without a world: [`ir::without_geometry`].
    pub domain: Domain,
    /// Empty if none is named.
    pub world: World,
    pub goal: Option<Goal>,
    /// Whether there is no world, and the domain asks geometry all the same: what it asks is taken as granted.
    pub is_granted: bool,
    /// Of a pair of HDDL files: what they call what.
    pub names: Option<Names>,
}

/// Loads a domain and a world; `task` overrides the world file's. All problems of both come at once; `None` with any error.
pub fn load(
    domain: &str,
    world: &str,
    task: Option<&str>,
    sources: &mut Sources,
    files: &dyn Files,
) -> (Option<Input>, Problems) {
    let paths = Paths {
        domain,
        world: Some(world),
        task,
        with: &[],
    };
    load_paths(&paths, sources, files)
}

/// Loads what the paths name. All problems come at once; `None` with any error.
pub fn load_paths(paths: &Paths<'_>, sources: &mut Sources, files: &dyn Files) -> (Option<Input>, Problems) {
    let (input, problems) = load_to_ask(paths, sources, files);
    let granted = input.map(|input| match paths.world {
        Some(_) => input,
        None => Input {
            domain: ir::without_geometry(&input.domain),
            ..input
        },
    });
    (granted, problems)
}

/// As [`load_paths`], for a reasoner that answers without a world file: the domain keeps its geometry in any case.
pub fn load_to_ask(paths: &Paths<'_>, sources: &mut Sources, files: &dyn Files) -> (Option<Input>, Problems) {
    if let Some(loaded) = pair::load(paths, sources, files) {
        return loaded;
    }
    if let Some(problem) = confused(paths) {
        return (None, Problems(vec![problem]));
    }
    let (world, mut problems) = match paths.world {
        Some(path) => world::load(path, sources, files),
        None => (Some(World::empty()), Problems::default()),
    };
    let (read, found) = domain::read(paths.domain, paths.with, sources, files);
    problems.extend(found);
    let Some(read) = read else { return (None, problems) };
    let Some(world) = world else {
        problems.0.extend(sure(&read, None));
        return (None, problems);
    };
    let named = paths.task.or(world.task.as_ref().map(|(text, _)| text.as_str()));
    let given = given(&world, named);
    if !read.unread.is_empty() {
        problems.0.extend(sure(&read, Some(&given)));
        return (None, problems);
    }
    let (domain, mut check_problems) = check::compile(&read.asts, &given);
    if paths.world.is_none() {
        // Then nothing overrules the domain's own values.
        check_problems.0.retain(|p| p.code != "hatp::overruled");
    }
    problems.extend(check_problems);
    let Some(mut domain) = domain else {
        return (None, problems);
    };
    let goal = match (paths.task, &world.task) {
        (Some(text), _) => {
            // Like a line of a file: a mark at its end is drawn below it.
            let file = sources.add("--task", format!("{text}\n"));
            parse_goal(text, file, 0, &mut domain, &mut problems)
        }
        (None, Some((text, span))) => parse_goal(text, span.file, span.start as usize, &mut domain, &mut problems),
        (None, None) => None,
    };
    if problems.has_errors() {
        return (None, problems);
    }
    let is_granted = paths.world.is_none() && ir::asks_geometry(&domain);
    let input = Input {
        domain,
        world,
        goal,
        is_granted,
        names: None,
    };
    (Some(input), problems)
}

/// Says that a world stands where a domain is wanted.
fn confused(paths: &Paths<'_>) -> Option<Problem> {
    let is_world = |path: &str| path.ends_with(".toml");
    let domain = paths.domain;
    if !is_world(domain) || paths.world.is_some_and(is_world) {
        return None;
    }
    let message = format!("`{domain}` is a world file, and a domain is wanted first");
    let help = match paths.world {
        Some(world) => format!("the domain comes before the world: `{world} {domain}`"),
        None => format!("name the domain before the world: `DOMAIN {domain}`"),
    };
    Some(Problem::unplaced("hatp::unreadable", message).help(help))
}

/// Reads and checks a domain alone, with its geometry; `paths` has no world and no task.
pub fn check_domain(paths: &Paths<'_>, sources: &mut Sources, files: &dyn Files) -> (Option<Domain>, Problems) {
    if let Some((input, problems)) = pair::load(paths, sources, files) {
        return (input.map(|i| i.domain), problems);
    }
    let (read, mut problems) = domain::read(paths.domain, paths.with, sources, files);
    let Some(read) = read else { return (None, problems) };
    if !read.unread.is_empty() {
        problems.0.extend(sure(&read, Some(&Given::default())));
        return (None, problems);
    }
    let (domain, mut found) = check::compile(&read.asts, &Given::default());
    // Without a world the domain's own values may be planned with.
    found.0.retain(|p| p.code != "hatp::overruled");
    problems.extend(found);
    (domain.filter(|_| !problems.has_errors()), problems)
}

/// Returns the errors of a domain that stand whatever its unread parts would have declared; `given` is `None` if the world can't be
/// read either.
///
/// Names that only those would have declared are not worth an error each, and warnings can wait.
fn sure(read: &DomainFiles, given: Option<&Given>) -> Vec<Problem> {
    let (_, problems) = check::compile(&read.asts, given.unwrap_or(&Given::default()));
    let mut sure = problems.0;
    sure.retain(|p| {
        let is_elsewhere = match p.code {
            // A world declares entities only.
            "hatp::unknown-name" => given.is_none(),
            _ => false,
        };
        p.severity == Severity::Error && !is_elsewhere && !may_declare(&read.unread, p.code)
    });
    sure
}

/// Says whether what a problem with this code misses may stand in an unread part. Of attributes the checker knows more.
fn may_declare(unread: &Unread, code: &str) -> bool {
    match code {
        "hatp::unknown-task" => unread.tasks || unread.anything,
        "hatp::unknown-function" | "hatp::unknown-fact" | "hatp::unknown-geometric" => {
            unread.functions || unread.anything
        }
        _ => unread.anything && code.split("::").any(|name| name.starts_with("unknown")),
    }
}

/// Returns what the world declares, in the checker's terms; `task` is the text of the task or task network to plan.
fn given(world: &World, task: Option<&str>) -> Given {
    let agents = world.scene.agents.iter().map(|a| (&a.id, &a.ty, true));
    let objects = world.scene.objects.iter().map(|o| (&o.id, &o.ty, false));
    let virtuals = world.scene.virtuals.iter().map(|v| (&v.id, &v.ty, false));
    let entities = agents
        .chain(objects)
        .chain(virtuals)
        .zip(&world.spans)
        .map(|((name, ty, is_agent), span)| GivenEntity {
            name: name.clone(),
            ty: ty.clone(),
            is_agent,
            span: *span,
        })
        .collect();
    let literal = |l: &Literal| match l {
        Literal::Bool(b) => GivenLiteral::Bool(*b),
        Literal::Number(x) => GivenLiteral::Number(*x),
        Literal::Text(text) => GivenLiteral::Text(text.clone()),
    };
    let values = world
        .values
        .iter()
        .map(|v| GivenValue {
            entity: v.entity.clone(),
            attribute: v.attribute.clone(),
            values: v.values.iter().map(literal).collect(),
            is_list: v.is_list,
            is_implied: v.is_implied,
            span: v.span,
        })
        .collect();
    // Whether the text is right is looked at when the domain is known.
    let tasks = task.and_then(|text| parse_network(FileId(0), 0, text).0);
    let tasks = tasks.into_iter().flatten().map(|task| task.call.name.text);
    Given {
        entities,
        shared: world.shared.clone(),
        values,
        tasks: tasks.collect(),
    }
}

fn parse_goal(text: &str, file: FileId, offset: usize, domain: &mut Domain, problems: &mut Problems) -> Option<Goal> {
    let (goal, found) = check::parse_goal(text, file, offset, domain);
    problems.extend(found);
    goal
}
