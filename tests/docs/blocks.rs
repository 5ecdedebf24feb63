//! Fenced blocks of a page. Does not read Markdown otherwise.

/// A fenced block and the words of its first line.
pub(crate) struct Block<'a> {
    /// `hatp` of "```hatp tests error=hatp::wrong-type".
    pub language: &'a str,
    /// The word after it, if it is no `key=value`.
    pub kind: &'a str,
    words: Vec<&'a str>,
    /// What is between the fences.
    pub text: &'a str,
    /// Line of the opening fence, from 1.
    pub line: usize,
    /// Where `text` starts in the page [bytes].
    pub start: usize,
}

impl<'a> Block<'a> {
    /// Says whether the first line has the word.
    pub(crate) fn has(&self, word: &str) -> bool {
        self.words.contains(&word)
    }

    /// Returns the values of `key=value`.
    pub(crate) fn values(&self, key: &str) -> impl Iterator<Item = &'a str> {
        let pairs = self.words.iter().filter_map(|w| w.split_once('='));
        pairs.filter(move |(k, _)| *k == key).map(|(_, v)| v)
    }

    /// Returns the first value of `key=value`.
    pub(crate) fn value(&self, key: &str) -> Option<&'a str> {
        self.values(key).next()
    }
}

/// Returns the fenced blocks of a page.
pub(crate) fn blocks(page: &str) -> Vec<Block<'_>> {
    let mut out = Vec::new();
    // First line, its number, and where the text starts, of the block at hand.
    let mut open: Option<(&str, usize, usize)> = None;
    let mut at = 0;
    for (i, line) in page.split_inclusive('\n').enumerate() {
        let begin = at;
        at += line.len();
        let Some(rest) = line.strip_prefix("```") else { continue };
        match open.take() {
            None => open = Some((rest, i + 1, at)),
            Some((first, line, start)) => {
                let words: Vec<&str> = first.split_whitespace().collect();
                let kind = words.get(1).filter(|w| !w.contains('='));
                out.push(Block {
                    language: words.first().unwrap_or(&""),
                    kind: kind.unwrap_or(&""),
                    words,
                    text: &page[start..begin],
                    line,
                    start,
                });
            }
        }
    }
    assert!(open.is_none(), "a block is not closed");
    out
}
