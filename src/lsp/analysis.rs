//! What is known of one open document: what it says, its names, what is wrong with it.

use super::comment::comment_of;
use super::index::{Index, PRELUDE};
use super::mend::mended;
use crate::check::{self, Given, PRELUDE_TEXT};
use crate::diag::levels::Levels;
use crate::diag::{Problems, Severity};
use crate::load::domain_files;
use crate::source::{FileId, Files, Sources, Span};
use crate::syntax::{self, ast};

/// All about a text and the files that it imports; made anew after each change.
#[derive(Debug)]
pub(super) struct Analysis {
    /// The document and what it imports.
    pub sources: Sources,
    /// The document.
    pub file: FileId,
    /// Of the document.
    pub ast: ast::File,
    /// Of all files.
    pub index: Index,
    /// Of all files, as `sgap check` says them; sorted by place.
    pub problems: Problems,
    /// Whether parts of the document are not in `ast`.
    pub has_syntax_errors: bool,
}

impl Analysis {
    /// Analyses the document at `path`; `files` gives its text for that path.
    pub(super) fn of(path: &str, files: &dyn Files) -> Self {
        let mut sources = Sources::default();
        let (read, mut problems) = domain_files(path, &[], &mut sources, files);
        let (mut asts, is_broken) = read.map_or((Vec::new(), true), |r| (r.asts, !r.unread.is_empty()));
        // The document itself comes last, after all that it imports.
        let mut own = asts.pop().unwrap_or_else(|| {
            let text = files.read(path).unwrap_or_default();
            let file = sources.add(path, text);
            syntax::parse(file, &sources.get(file).text).0
        });
        let file = own.span.file;
        let has_syntax_errors = problems.0.iter().any(|p| {
            let is_here = p.primary.as_ref().is_some_and(|l| l.span.file == file);
            is_here && ["hatp::syntax", "hatp::too-large"].contains(&p.code)
        });
        if has_syntax_errors {
            own = mended(file, &sources.get(file).text, own);
        }
        asts.push(own.clone());
        problems.extend(checked(&asts, is_broken));
        let problems = Levels::default().apply(problems, &sources);
        let (prelude, _) = syntax::parse(PRELUDE, PRELUDE_TEXT);
        let index = Index::of(&prelude, &asts);
        Analysis {
            sources,
            file,
            ast: own,
            index,
            problems,
            has_syntax_errors,
        }
    }

    /// Says whether other files are part of it.
    pub(super) fn has_imports(&self) -> bool {
        let imports = |item: &ast::Item| matches!(item, ast::Item::Import(_));
        self.sources.ids().count() > 1 || self.ast.items.iter().any(imports)
    }

    /// Returns the comment that stands with a declaration, be it in the document, in another file or in the prelude.
    pub(super) fn comment(&self, declaration: Span) -> Option<String> {
        let text = if declaration.file == PRELUDE {
            PRELUDE_TEXT
        } else {
            &self.sources.get(declaration.file).text
        };
        comment_of(text, declaration)
    }
}

/// Returns what the checker says. Where something could not be read only those errors count that do not come from that: no unknown
/// names, and no warnings.
fn checked(asts: &[ast::File], is_broken: bool) -> Problems {
    let (_, mut found) = check::compile(asts, &Given::default());
    if is_broken {
        let is_unknown = |code: &str| code.split("::").any(|name| name.starts_with("unknown"));
        found.0.retain(|p| p.severity == Severity::Error && !is_unknown(p.code));
    }
    found
}
