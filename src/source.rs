//! Where text lives and how it is pointed at.
//!
//! No room touches the disk: it reads through [`Files`], which `planner::Disk` is for whoever has one.

use std::collections::BTreeMap;

/// A file known to [`Sources`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct FileId(pub u32);

/// A range of bytes in one file: `start` included, `end` not.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Span {
    pub file: FileId,
    pub start: u32,
    pub end: u32,
}

impl Span {
    /// Returns the span of `start..end` in `file`.
    pub fn new(file: FileId, start: usize, end: usize) -> Self {
        let cap = |n: usize| u32::try_from(n).unwrap_or(u32::MAX);
        Span {
            file,
            start: cap(start),
            end: cap(end),
        }
    }

    /// Returns the smallest span that covers both; `other` must be of the same file.
    pub fn to(self, other: Span) -> Self {
        Span {
            file: self.file,
            start: self.start.min(other.start),
            end: self.end.max(other.end),
        }
    }

    /// Returns the byte range, for slicing the file's text.
    pub fn range(self) -> std::ops::Range<usize> {
        self.start as usize..self.end as usize
    }
}

/// One file's path as the user wrote it, and its text.
#[derive(Debug, Clone)]
pub struct SourceFile {
    pub path: String,
    pub text: String,
}

/// All files read so far; a [`FileId`] indexes it.
#[derive(Debug, Clone, Default)]
pub struct Sources {
    files: Vec<SourceFile>,
}

impl Sources {
    /// Adds a file and returns its id.
    pub fn add(&mut self, path: impl Into<String>, text: impl Into<String>) -> FileId {
        let id = FileId(u32::try_from(self.files.len()).unwrap_or(u32::MAX));
        self.files.push(SourceFile {
            path: path.into(),
            text: text.into(),
        });
        id
    }

    /// Returns the ids of all files, in the order in which they were added.
    pub fn ids(&self) -> impl Iterator<Item = FileId> + use<> {
        (0..self.files.len()).map(|i| FileId(u32::try_from(i).unwrap_or(u32::MAX)))
    }

    /// Returns the file; `id` must come from this value's [`Sources::add`].
    pub fn get(&self, id: FileId) -> &SourceFile {
        &self.files[id.0 as usize]
    }
}

/// Where the lines of a text begin: finds many places in one pass over it.
#[derive(Debug, Clone)]
pub struct Lines {
    starts: Vec<usize>,
}

impl Lines {
    /// Returns the lines of `text`.
    pub fn new(text: &str) -> Self {
        let ends = text.bytes().enumerate().filter(|(_, b)| *b == b'\n');
        Lines {
            starts: std::iter::once(0).chain(ends.map(|(i, _)| i + 1)).collect(),
        }
    }

    /// Returns the line of a byte position, from 0.
    pub fn line(&self, at: usize) -> usize {
        self.starts.partition_point(|start| *start <= at).saturating_sub(1)
    }

    /// Returns line and column of a byte position of the same text, both from 1; columns count characters.
    pub fn line_column(&self, text: &str, at: usize) -> (usize, usize) {
        let mut at = at.min(text.len());
        while !text.is_char_boundary(at) {
            at -= 1;
        }
        let line = self.line(at);
        let start = self.starts.get(line).copied().unwrap_or(0);
        let before = text.get(start..at).unwrap_or_default();
        (line + 1, before.trim_start_matches('\u{FEFF}').chars().count() + 1)
    }
}

/// Returns the doc comment of the item that starts at byte `start`: the run of `///` lines directly before its line,
/// without the marks, joined by line ends.
///
/// An empty line, another comment or anything before the item on its own line ends the run: a declaration that does not
/// begin its line has no doc comment.
pub fn doc_comment(text: &str, start: usize) -> Option<String> {
    let before = text.get(..start)?;
    let (above, indent) = before.rsplit_once('\n').unwrap_or(("", before));
    if !indent.trim_start_matches('\u{FEFF}').trim().is_empty() {
        return None;
    }
    let marked = |line: &'_ str| {
        let rest = line.trim().trim_start_matches('\u{FEFF}').strip_prefix("///")?;
        // Four strokes draw a line across the page.
        let is_doc = !rest.starts_with('/');
        is_doc.then(|| rest.strip_prefix(' ').unwrap_or(rest).trim_end().to_owned())
    };
    let mut lines: Vec<String> = above.lines().rev().map_while(marked).collect();
    lines.reverse();
    (!lines.is_empty()).then(|| lines.join("\n"))
}

/// Reads files for the library.
pub trait Files {
    /// Returns the file's text, or a sentence saying why it can't be read
    /// (missing, a directory, not UTF-8, larger than the limit).
    fn read(&self, path: &str) -> Result<String, String>;

    /// Returns the file's bytes, or why it can't be read (missing, a directory, larger than the limit).
    fn read_bytes(&self, path: &str) -> Result<Vec<u8>, String> {
        self.read(path).map(String::into_bytes)
    }

    /// Returns the folders in which the user keeps packages, for names such as `package://robot/arm.stl`.
    fn packages(&self) -> Vec<String> {
        Vec::new()
    }

    /// Returns what was kept under `key`, if anything was.
    fn cached(&self, key: &str) -> Option<Vec<u8>> {
        let _ = key;
        None
    }

    /// Keeps bytes for another run, if it can.
    fn keep(&self, key: &str, bytes: &[u8]) {
        let _ = (key, bytes);
    }

    /// Returns the names of the files in `folder` (the empty text is the folder in which the program runs), for "did you
    /// mean" and for files that belong to another by their name. Nothing where that can't be told.
    fn list(&self, folder: &str) -> Vec<String> {
        let _ = folder;
        Vec::new()
    }
}

/// Files that are not on a disk: their texts by path.
#[derive(Debug, Clone, Default)]
pub struct Texts(pub BTreeMap<String, String>);

impl Texts {
    /// Returns the files with these paths and texts.
    pub fn new<P: Into<String>, T: Into<String>>(files: impl IntoIterator<Item = (P, T)>) -> Self {
        let files = files.into_iter();
        Texts(files.map(|(path, text)| (path.into(), text.into())).collect())
    }
}

impl Files for Texts {
    fn read(&self, path: &str) -> Result<String, String> {
        self.0.get(path).cloned().ok_or_else(|| "there is no such file".into())
    }

    fn list(&self, folder: &str) -> Vec<String> {
        let name = |path: &String| {
            let (of, name) = path.rsplit_once('/').unwrap_or(("", path));
            (of == folder).then(|| name.to_owned())
        };
        self.0.keys().filter_map(name).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_doc_comment_is_the_run_of_marked_lines_directly_above() {
        let text = "/// Not of B.\n\n  /// What B is,\n  ///   and more [m].\n  B; C;\n//// A line.\nD;\n// E's.\nE;";
        let of = |item: &str| doc_comment(text, text.find(item).unwrap_or_default());
        assert_eq!(of("B;").as_deref(), Some("What B is,\n  and more [m]."));
        for item in ["C;", "D;", "E;"] {
            assert_eq!(of(item), None, "{item}");
        }
        assert_eq!(doc_comment("/// A.\r\nA;", 8).as_deref(), Some("A."));
        assert_eq!(doc_comment("A;", 0), None);
        assert_eq!(doc_comment("A;", 99), None);
    }
}
