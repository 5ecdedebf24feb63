//! The files of a domain: the one named, those it imports, those that hold its functions.
//!
//! `import "file.hatp";` is relative to the importing file. `NAME.functions.hatp` beside `NAME.dom` or `NAME.hatp` belongs to
//! it without being named: LAAS's files leave their functions to C++, and need no edit here. Every file is read once,
//! however often it is imported, so files may import each other.

use indexmap::IndexMap;

use crate::diag::suggest::nearest;
use crate::diag::{Problem, Problems};
use crate::source::{FileId, Files, Sources, Span};
use crate::syntax::{
    self,
    ast::{File, Import, Item, Unread},
};

/// Files of one domain. HEURISTIC: far above real domains; a folder of files that import each other ends here.
const MAX_FILES: usize = 1_000;

/// What was read.
#[derive(Debug)]
pub struct DomainFiles {
    /// Imported files come before those that import them; what is imported or named first comes first.
    pub asts: Vec<File>,
    /// What is not in `asts`: files that can't be read, and lines that don't parse.
    pub unread: Unread,
}

/// A file that is being read, and its imports that are still to be read, the last first.
struct Open {
    ast: File,
    path: String,
    imports: Vec<Import>,
}

struct Reader<'a> {
    sources: &'a mut Sources,
    files: &'a dyn Files,
    /// By path without `.` and `..`.
    seen: IndexMap<String, ()>,
    /// What is in each folder that was looked into: it is asked for with every file.
    folders: IndexMap<String, Vec<String>>,
    asts: Vec<File>,
    unread: Unread,
    problems: Problems,
}

/// Reads the domain file `path` with all that belongs to it, and the files `with`. Without the file itself there is nothing.
pub fn read(path: &str, with: &[&str], sources: &mut Sources, files: &dyn Files) -> (Option<DomainFiles>, Problems) {
    let mut reader = Reader {
        sources,
        files,
        seen: IndexMap::new(),
        folders: IndexMap::new(),
        asts: Vec::new(),
        unread: Unread::default(),
        problems: Problems::default(),
    };
    for with in with {
        reader.tree(with);
    }
    let n_before = reader.asts.len();
    reader.tree(path);
    // The file itself comes after all that it imports; it is not there if it was named in `with`, too, or can't be read.
    let is_read = reader.asts.len() > n_before || with.iter().any(|w| flat(w) == flat(path));
    if let Some(main) = reader.asts.last().filter(|_| is_read)
        && main.items.is_empty()
        && reader.unread.is_empty()
    {
        let message = format!("`{path}` declares nothing");
        let help =
            "a domain has a `factdatabase { }` with types and attributes, and an `HTN { }` with actions and methods";
        reader
            .problems
            .push(Problem::unplaced("hatp::empty", message).help(help));
    }
    let read = DomainFiles {
        asts: reader.asts,
        unread: reader.unread,
    };
    (is_read.then_some(read), reader.problems)
}

impl Reader<'_> {
    /// Reads a file and all that it imports, unless it has been read.
    fn tree(&mut self, path: &str) {
        let mut open: Vec<Open> = self.open(path, None).into_iter().collect();
        while let Some(mut top) = open.pop() {
            let Some(import) = top.imports.pop() else {
                self.asts.push(top.ast);
                continue;
            };
            let path = beside(&top.path, &import.path);
            open.push(top);
            open.extend(self.open(&path, Some(&import)));
        }
    }

    /// Reads one file, with its functions if they are beside it; `None` if it was read before, or can't be.
    fn open(&mut self, path: &str, import: Option<&Import>) -> Option<Open> {
        if self.seen.insert(flat(path), ()).is_some() {
            return None;
        }
        if self.seen.len() > MAX_FILES {
            if self.seen.len() > MAX_FILES + 1 {
                // Said once is enough.
                return None;
            }
            let message = format!("more than {MAX_FILES} files are imported");
            let problem = match import {
                Some(import) => Problem::error("hatp::too-large", message, import.path_span, "one file too many"),
                None => Problem::unplaced("hatp::too-large", message),
            };
            self.problems.push(problem.help("join some of them"));
            self.unread.anything = true;
            return None;
        }
        let file = match self.files.read(path) {
            Ok(text) => self.sources.add(path, text),
            Err(why) => {
                let problem = self.unreadable(path, &why, import.map(|i| i.path_span));
                self.problems.push(problem);
                self.unread.anything = true;
                return None;
            }
        };
        if let Some(functions) = self.functions_beside(path) {
            // A file of functions has none of its own beside it, so this goes one level deep.
            self.tree(&functions);
        }
        let ast = self.parse(file);
        let mut imports: Vec<Import> = ast.items.iter().filter_map(imported).cloned().collect();
        imports.reverse();
        Some(Open {
            ast,
            path: path.to_owned(),
            imports,
        })
    }

    fn parse(&mut self, file: FileId) -> File {
        let (ast, found) = syntax::parse(file, &self.sources.get(file).text);
        self.unread.extend(&ast.unread);
        self.problems.extend(found);
        ast
    }

    /// Returns `NAME.functions.hatp` if there is one beside `NAME.dom` or `NAME.hatp`.
    fn functions_beside(&mut self, path: &str) -> Option<String> {
        let stem = path.strip_suffix(".hatp").or_else(|| path.strip_suffix(".dom"))?;
        let functions = format!("{stem}.functions.hatp");
        let (folder, name) = split(&functions);
        let is_there = !stem.ends_with(".functions") && self.names_in(folder).iter().any(|n| n == name);
        is_there.then_some(functions)
    }

    fn names_in(&mut self, folder: &str) -> &[String] {
        let files = self.files;
        self.folders
            .entry(folder.to_owned())
            .or_insert_with(|| files.list(folder))
    }

    fn unreadable(&mut self, path: &str, why: &str, span: Option<Span>) -> Problem {
        let message = format!("can't read `{path}`: {why}");
        let Some(span) = span else {
            return Problem::unplaced("hatp::unreadable", message);
        };
        let problem = Problem::error("hatp::unreadable", message, span, "imported here");
        let (folder, name) = split(path);
        let there = self.names_in(folder);
        match nearest(name, there.iter().map(String::as_str)) {
            Some(near) => problem.help(format!("did you mean `{near}`?")),
            None => problem.help("the path is relative to the folder of the importing file"),
        }
    }
}

fn imported(item: &Item) -> Option<&Import> {
    match item {
        Item::Import(import) => Some(import),
        _ => None,
    }
}

/// Returns folder and name; the folder of `a.hatp` is the empty text.
fn split(path: &str) -> (&str, &str) {
    path.rsplit_once('/').unwrap_or(("", path))
}

/// Returns the path that `import` means in the file `of`.
fn beside(of: &str, import: &str) -> String {
    match of.rsplit_once('/') {
        Some((folder, _)) if !import.starts_with('/') => flat(&format!("{folder}/{import}")),
        _ => flat(import),
    }
}

/// Returns the path without `.` and, as far as that is possible, without `..`.
fn flat(path: &str) -> String {
    let mut parts: Vec<&str> = Vec::new();
    for part in path.split('/') {
        match (part, parts.last()) {
            (".", _) => {}
            ("", Some(_)) => {}
            ("..", Some(last)) if !matches!(*last, ".." | "") => {
                parts.pop();
            }
            _ => parts.push(part),
        }
    }
    parts.join("/")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_file_has_one_path() {
        assert_eq!(beside("a/b.hatp", "../c.hatp"), "c.hatp");
        assert_eq!(beside("a/b.hatp", "./d//c.hatp"), "a/d/c.hatp");
        assert_eq!(beside("b.hatp", "../../c.hatp"), "../../c.hatp");
        assert_eq!(beside("/x/b.hatp", "/y/../c.hatp"), "/c.hatp");
    }
}
