//! A new name for something, everywhere in the document.
//!
//! The new text is analysed before anything is changed: every name must mean what it meant, and the checker must find no more errors.
//! What a world file says about the name is not changed, since it is not read; nor are files that import this one.

use std::collections::BTreeMap;

use lsp_types::{Position, Range, TextEdit};

use super::analysis::Analysis;
use super::document::Document;
use super::index::{Index, Kind, Occurrence, SymbolId};
use crate::diag::{Problem, Severity};
use crate::source::Files;

/// Returns the place of the name at a position if it can get another, or why not.
pub(super) fn prepare(document: &Document, analysis: &Analysis, position: Position) -> Result<Range, String> {
    let found = renamable(document, analysis, position)?;
    Ok(document.lines.range(&document.text, found.span))
}

/// Returns the changes that give the name at a position another, or why that can't be done.
pub(super) fn rename(
    document: &Document,
    analysis: &Analysis,
    position: Position,
    new: &str,
    files: &dyn Files,
) -> Result<Vec<TextEdit>, String> {
    let found = renamable(document, analysis, position)?;
    let symbol = analysis.index.get(found.symbol);
    let is_label = symbol.kind == Kind::Label && new.chars().all(|c| c.is_ascii_digit());
    if !is_label && !is_word(new) || new.is_empty() {
        return Err(format!(
            "`{}` is no name: write letters, digits and `_`, and no digit first",
            shortened(new)
        ));
    }
    if let Some(step) = analysis
        .index
        .unresolved_steps
        .iter()
        .find(|s| symbol.kind == Kind::Attribute && s.text == symbol.name && s.span.file == analysis.file)
    {
        let line = document.lines.position(&document.text, step.span.start as usize).line;
        return Err(format!(
            "without the world file it is not known which attribute `.{}` in line {} is",
            step.text,
            line + 1
        ));
    }
    let places: Vec<&Occurrence> = analysis.index.places(found.symbol).collect();
    let mut text = document.text.clone();
    for place in places.iter().rev() {
        text.replace_range(place.span.range(), new);
    }
    let changed = Changed {
        path: &document.path,
        text: &text,
        files,
    };
    judge(analysis, &Analysis::of(&document.path, &changed), new)?;
    let edit = |o: &&Occurrence| TextEdit::new(document.lines.range(&document.text, o.span), new.to_owned());
    Ok(places.iter().map(edit).collect())
}

/// The files as they are, but for one.
struct Changed<'a> {
    path: &'a str,
    text: &'a str,
    files: &'a dyn Files,
}

impl Files for Changed<'_> {
    fn read(&self, path: &str) -> Result<String, String> {
        if path == self.path {
            return Ok(self.text.to_owned());
        }
        self.files.read(path)
    }

    fn list(&self, folder: &str) -> Vec<String> {
        self.files.list(folder)
    }
}

fn renamable(document: &Document, analysis: &Analysis, position: Position) -> Result<Occurrence, String> {
    if analysis.has_syntax_errors {
        return Err("the file has syntax errors: not every place of the name can be found".into());
    }
    let at = document.lines.offset(&document.text, position);
    let found = analysis
        .index
        .at(analysis.file, at)
        .ok_or("there is no name here that could be changed")?;
    let symbol = analysis.index.get(found.symbol);
    if symbol.is_builtin() {
        return Err(format!("{} `{}` is built in", symbol.kind.word(), symbol.name));
    }
    if symbol.declared.is_none() {
        return Err(format!("`{}` is not declared in this file", symbol.name));
    }
    let is_elsewhere = |o: &&Occurrence| o.span.file != analysis.file;
    if let Some(other) = analysis.index.places(found.symbol).find(is_elsewhere) {
        let path = &analysis.sources.get(other.span.file).path;
        return Err(format!(
            "`{}` stands in `{path}`, too, which is not changed from here",
            symbol.name
        ));
    }
    Ok(found)
}

/// Says why the text with the new name does not mean the same.
fn judge(before: &Analysis, after: &Analysis, new: &str) -> Result<(), String> {
    if after.has_syntax_errors {
        return Err(format!("`{new}` is a word of the language"));
    }
    if bindings(&before.index) != bindings(&after.index) {
        return Err(format!("`{new}` has another meaning where the name is used"));
    }
    let count = |a: &Analysis| a.problems.0.iter().filter(|p| is_error(p)).count();
    if count(after) > count(before) {
        let is_about_it = |p: &&Problem| is_error(p) && p.message.contains(&format!("`{new}`"));
        let why = after.problems.0.iter().find(is_about_it);
        let why = why.map_or("the file would have more errors", |p| p.message.as_str());
        return Err(format!("`{new}` can't be used here: {why}"));
    }
    Ok(())
}

fn is_error(problem: &Problem) -> bool {
    problem.severity == Severity::Error
}

/// Returns, for every place of a name in order, the number of the thing that it means, counted as they come.
fn bindings(index: &Index) -> Vec<usize> {
    let mut numbers: BTreeMap<SymbolId, usize> = BTreeMap::new();
    let number = |o: &Occurrence| {
        let next = numbers.len();
        *numbers.entry(o.symbol).or_insert(next)
    };
    index.occurrences().iter().map(number).collect()
}

fn is_word(text: &str) -> bool {
    let mut chars = text.chars();
    chars.next().is_some_and(|c| c.is_ascii_alphabetic() || c == '_')
        && chars.all(|c| c.is_ascii_alphanumeric() || c == '_')
}

fn shortened(text: &str) -> String {
    text.chars().take(40).collect()
}
