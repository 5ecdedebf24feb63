//! A pair of HDDL files in the place of a domain and a world: imported, then on the way of every domain.

use super::{Input, parse_goal};
use crate::check::{self, Given};
use crate::diag::{Problem, Problems};
use crate::hddl::{self, Imported, Names};
use crate::source::{FileId, Files, Sources};
use crate::syntax;
use crate::world::World;

/// Says whether a file is one of HDDL, by its name.
pub fn is_hddl(path: &str) -> bool {
    path.rsplit_once('.')
        .is_some_and(|(_, end)| end.eq_ignore_ascii_case("hddl"))
}

/// Reads and imports a pair; `None` with any error.
pub fn import_pair(
    domain: &str,
    problem: &str,
    sources: &mut Sources,
    files: &dyn Files,
) -> (Option<Imported>, Problems) {
    let mut problems = Problems::default();
    let read = [domain, problem].map(|path| match files.read(path) {
        Ok(text) => Some(sources.add(path, text)),
        Err(why) => {
            let message = format!("can't read `{path}`: {why}");
            problems.push(Problem::unplaced("hddl::unreadable", message));
            None
        }
    });
    match read {
        [Some(domain), Some(problem)] => hddl::import(domain, problem, sources),
        _ => (None, problems),
    }
}

/// Loads the pair that the paths name; `None` if they name none.
pub(super) fn load(
    paths: &super::Paths<'_>,
    sources: &mut Sources,
    files: &dyn Files,
) -> Option<(Option<Input>, Problems)> {
    let second = paths.world.filter(|world| is_hddl(world));
    if !is_hddl(paths.domain) && second.is_none() {
        return None;
    }
    let (true, Some(problem), []) = (is_hddl(paths.domain), second, paths.with) else {
        return Some((None, Problems(vec![half(paths)])));
    };
    let (imported, mut problems) = import_pair(paths.domain, problem, sources, files);
    let Some(Imported { hatp, names }) = imported else {
        return Some((None, problems));
    };
    let file = sources.add(format!("{} as HATP", paths.domain), hatp);
    let input = compile(file, names, paths.task, sources, &mut problems);
    Some((input.filter(|_| !problems.has_errors()), problems))
}

fn compile(
    file: FileId,
    names: Names,
    task: Option<&str>,
    sources: &mut Sources,
    problems: &mut Problems,
) -> Option<Input> {
    let (ast, found) = syntax::parse(file, &sources.get(file).text);
    problems.extend(found);
    let (domain, found) = check::compile(&[ast], &Given::default());
    problems.extend(found);
    let mut domain = domain?;
    let text = task.map_or_else(|| names.task(), str::to_owned);
    let file = sources.add("--task", format!("{text}\n"));
    let goal = parse_goal(&text, file, 0, &mut domain, problems)?;
    Some(Input {
        domain,
        world: World::empty(),
        goal: Some(goal),
        is_granted: false,
        names: Some(names),
    })
}

/// Says that a pair is not whole, or that something else stands beside it.
fn half(paths: &super::Paths<'_>) -> Problem {
    let message = match paths.world {
        _ if !paths.with.is_empty() => "a domain in HDDL takes no further files".to_owned(),
        None => format!("`{}` is a file of HDDL, and its problem is not named", paths.domain),
        Some(world) if is_hddl(paths.domain) => format!("`{world}` is no problem in HDDL"),
        Some(world) => format!("`{world}` is a file of HDDL, and `{}` is none", paths.domain),
    };
    Problem::unplaced("hddl::unreadable", message).help("name a domain and a problem: `DOMAIN.hddl PROBLEM.hddl`")
}
