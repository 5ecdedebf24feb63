//! The door of the room: a world file's path to a world, or to all that is wrong with it.
//!
//! Files are read through [`Files`] alone; a path in a file is relative to that file's folder.

use indexmap::IndexMap;

use super::agents::{self, Agents};
use super::contact::{Contact, contacts};
use super::mesh::Meshes;
use super::model;
use super::objects::{self, Written};
use super::table::{self, Table};
use super::{EntityRef, ObjectState, Scene, State, VirtualObject, World, navigation, values};
use crate::diag::{Problem, Problems};
use crate::source::{Files, Sources, Span};

const KEYS: [&str; 9] = [
    "task",
    "packages",
    "robots",
    "humans",
    "objects",
    "virtual",
    "facts",
    "state",
    "human_aware",
];
/// At the start, an overlap up to this depth is a touch [m].
const TOUCH: f64 = 1e-3;

/// Loads the world file at `path` and every file that it names; `None` when there is an error.
///
/// Texts are added to `sources`, so that problems can be shown; they come sorted by file and place.
pub fn load(path: &str, sources: &mut Sources, files: &dyn Files) -> (Option<World>, Problems) {
    let mut problems = Problems::default();
    if [".hatp", ".dom"].iter().any(|end| path.ends_with(end)) {
        let message = format!("`{path}` is a domain, and a world file is wanted");
        problems.push(Problem::unplaced("world::unreadable-file", message).help("world files end with `.toml`"));
        return (None, problems);
    }
    let text = match files.read(path) {
        Ok(text) => text,
        Err(reason) => {
            let message = format!("can't read the world file `{path}`: {reason}");
            problems.push(Problem::unplaced("world::unreadable-file", message));
            return (None, problems);
        }
    };
    let file = sources.add(path, text.clone());
    let Some(toml) = table::parse(&text, file, &mut problems) else {
        return (None, problems.sorted());
    };
    let root = Table::root(&toml, file, "the world file");
    root.only(&KEYS, &mut problems);
    let task = root
        .text("task", &mut problems)
        .map(|t| (t.text.to_string(), inside_quotes(&text, t.span)));
    let shared = values::facts(&root, &mut problems);
    let mut agents = agents::read(&root, path, sources, files, &mut problems);
    // What `[state]` says counts more.
    let mut values = std::mem::take(&mut agents.values);
    values.extend(values::state(&root, &mut problems));
    let human_aware = navigation::human_aware(&root, &mut problems);
    let mut meshes = Meshes::new(files, model::packages(&root, path, &mut problems), true);
    let mut solids = objects::Solids {
        meshes: &mut meshes,
        path,
    };
    let written = objects::read(&root, &mut solids, &mut problems);
    let virtuals = objects::read_virtual(&root, &mut solids, &mut problems);
    let objects = objects::placement::place(&written, &objects::ids(&root), &mut agents, &mut problems);
    unique_ids(&agents, &written, &virtuals, &mut problems);
    if problems.has_errors() {
        return (None, problems.sorted());
    }
    let mut spans: Vec<Span> = agents.spans.clone();
    spans.extend(written.iter().map(|w| w.name.span));
    spans.extend(virtuals.iter().map(|(_, span)| *span));
    let objects: Vec<ObjectState> = objects.into_iter().flatten().collect();
    let scene = Scene {
        agents: agents.agents,
        objects: written.into_iter().map(|w| w.object).collect(),
        virtuals: virtuals.into_iter().map(|(v, _)| v).collect(),
        human_aware,
    };
    let start = State {
        agents: agents.states,
        objects,
    };
    // One problem for two entities, however many of their parts overlap.
    let mut pairs: IndexMap<(EntityRef, EntityRef), Vec<Contact>> = IndexMap::new();
    for contact in contacts(&scene, &start, TOUCH) {
        let pair = (contact.a.entity, contact.b.entity);
        pairs.entry(pair).or_default().push(contact);
    }
    for contacts in pairs.values() {
        problems.0.extend(start_in_collision(&scene, contacts, &spans));
    }
    let world = World {
        scene,
        start,
        task,
        shared,
        values,
        spans,
    };
    let ok = !problems.has_errors();
    (ok.then_some(world), problems.sorted())
}

/// Returns the place of a text without its quotes, so that places within the text can be counted from its start.
fn inside_quotes(text: &str, span: Span) -> Span {
    let raw = text.get(span.range()).unwrap_or_default();
    let quote = if raw.starts_with("\"\"\"") || raw.starts_with("'''") {
        3
    } else {
        usize::from(raw.starts_with(['"', '\'']))
    };
    let range = span.range();
    let end = range.end.saturating_sub(quote).max(range.start);
    // The line end right after three quotes is no part of the text.
    let opening = raw.get(quote..).filter(|_| quote == 3).unwrap_or_default();
    let newline = ["\r\n", "\n"]
        .iter()
        .find(|n| opening.starts_with(**n))
        .map_or(0, |n| n.len());
    Span::new(span.file, (range.start + quote + newline).min(end), end)
}

/// An id names one entity: robots, humans and objects share their names.
fn unique_ids(agents: &Agents, written: &[Written<'_>], virtuals: &[(VirtualObject, Span)], problems: &mut Problems) {
    let mut first: IndexMap<&str, Span> = IndexMap::new();
    let agents = agents
        .agents
        .iter()
        .zip(&agents.spans)
        .map(|(a, s)| (a.id.as_str(), *s));
    let objects = written.iter().map(|w| (w.name.text, w.name.span));
    let virtuals = virtuals.iter().map(|(v, span)| (v.id.as_str(), *span));
    for (id, span) in agents.chain(objects).chain(virtuals) {
        match first.get(id) {
            Some(known) => problems.push(
                Problem::error(
                    "world::duplicate-id",
                    format!("two entities are named `{id}`"),
                    span,
                    "again here",
                )
                .note(*known, "first here")
                .help("robots, humans and objects share their names: rename one"),
            ),
            None => {
                first.insert(id, span);
            }
        }
    }
}

fn start_in_collision(scene: &Scene, contacts: &[Contact], spans: &[Span]) -> Option<Problem> {
    let deepest = contacts.iter().max_by(|x, y| x.depth.total_cmp(&y.depth))?;
    let span = |entity: EntityRef| match entity {
        EntityRef::Agent(a) => spans.get(a).copied(),
        EntityRef::Object(o) => spans.get(scene.agents.len() + o).copied(),
        EntityRef::Virtual(v) => spans.get(scene.agents.len() + scene.objects.len() + v).copied(),
    };
    let depth = deepest.depth * 1000.0;
    let more = match contacts.len() {
        1 => String::new(),
        n => format!("; {} more of their parts overlap", n - 1),
    };
    let (a, b) = (&deepest.a, &deepest.b);
    if a.entity == b.entity {
        let id = scene.id(a.entity);
        let message = format!(
            "`{id}` starts in collision with itself: `{}` is {depth:.1} mm deep in `{}`",
            b.part, a.part
        );
        let more = more.replace("of their parts overlap", "pairs of links overlap");
        return Some(
            Problem::error("world::start-in-collision", message, span(a.entity)?, "").help(format!(
                "change its posture or joints, or list the pair in `may_touch` of its model{more}"
            )),
        );
    }
    let named = |part: &str, entity| {
        if part.is_empty() {
            format!("`{}`", scene.id(entity))
        } else {
            format!("`{}` (`{part}`)", scene.id(entity))
        }
    };
    let message = format!(
        "{} starts in collision: it is {depth:.1} mm deep in {}",
        named(&b.part, b.entity),
        named(&a.part, a.entity)
    );
    Some(
        Problem::error("world::start-in-collision", message, span(b.entity)?, "this")
            .note(span(a.entity)?, "and this")
            .help(format!("move one of them by {depth:.1} mm or more{more}")),
    )
}
