//! What each word of the language means, for hover and completion.

use crate::syntax::keywords;

/// What is built in without being a word of the grammar.
const OTHERS: [(&str, &str); 1] = [(
    "interleave",
    "Whether subtasks without an order may mix; without it each is done as one block.",
)];

/// Returns a sentence about a word; `None` for names.
pub(super) fn meaning(word: &str) -> Option<&'static str> {
    let of_grammar = keywords().iter().find(|k| k.word == word).map(|k| k.doc);
    of_grammar.or_else(|| OTHERS.iter().find(|(other, _)| *other == word).map(|(_, doc)| *doc))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_word_is_explained_twice() {
        for (word, doc) in OTHERS {
            assert!(keywords().iter().all(|k| k.word != word), "{word}");
            assert_eq!(meaning(word), Some(doc));
        }
        assert_eq!(meaning("RED_CUBE"), None);
    }
}
