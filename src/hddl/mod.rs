//! HDDL: domains and problems of the hierarchical planning competition, told in HATP.
//!
//! The language is that of Höller et al., AAAI 2020 (doi:10.1609/aaai.v34i06.6542): typed objects, predicates of any arity,
//! actions with the conditions and effects of PDDL's ADL part, methods, an initial task network, a goal, action costs. What it
//! does *not* read is a located error that says so: time, numbers other than costs, axioms, preferences.
//!
//! [`import`] reads a pair of files and writes one text in HATP; it goes through the ordinary parser and checker, so that a pair
//! that is imported and one that is planned are the same thing. *Invariant:* a pair without errors gives a text without any.
//! Where we differ from the paper: a domain may name an object that its problem declares, and a predicate may be given a
//! variable of a supertype of what it asks for.
//!
//! ```text
//! text --tree--> lists --read--> ast::Pair --bodies, binding--> methods over their tasks --write--> HATP + Names
//!                                                          plan::Plan + Names --ipc--> the competition's plan format
//! ```

mod ast;
mod binding;
mod bodies;
mod formulas;
mod ipc;
mod late;
mod names;
mod problems;
mod read;
mod tree;
mod write;

use crate::diag::Problems;
use crate::source::{FileId, Sources};

pub use ipc::ipc;
pub use names::Names;

/// A pair told in HATP.
#[derive(Debug)]
pub struct Imported {
    /// A domain with its entities; correct, not formatted.
    pub hatp: String,
    /// The way back to the names of the files.
    pub names: Names,
}

/// Imports a domain and a problem. All problems of both files come at once; `None` with any error.
pub fn import(domain: FileId, problem: FileId, sources: &Sources) -> (Option<Imported>, Problems) {
    let mut problems = Problems::default();
    let [domain, problem] = [domain, problem].map(|file| {
        let trees = tree::read(file, &sources.get(file).text, &mut problems);
        (file, trees)
    });
    // A file that is cut off somewhere would only be misunderstood.
    if problems.has_errors() {
        return (None, problems.sorted());
    }
    let pair = read::read((domain.0, &domain.1), (problem.0, &problem.1), &mut problems);
    let imported = pair.filter(|_| !problems.has_errors()).map(|pair| {
        let (hatp, names) = write::write(&pair, &mut problems);
        Imported { hatp, names }
    });
    let problems = problems.sorted();
    (imported.filter(|_| !problems.has_errors()), problems)
}
