//! The book's table of contents lists every page once: `docs/SUMMARY.md`, made from `docs/README.md` and the folders.

use std::path::Path;

use super::read;

/// Returns the page's first heading.
fn title(path: &Path) -> String {
    let text = read(path);
    let heading = text.lines().find_map(|l| l.strip_prefix("# "));
    heading
        .unwrap_or_else(|| panic!("{} has a heading", path.display()))
        .to_owned()
}

/// Returns the table of contents: the index's pages under its headings, and under an index of a folder the folder's pages.
fn summary() -> String {
    let mut out = String::from("# Summary\n\n[sgap](README.md)\n");
    for line in read(Path::new("docs/README.md")).lines() {
        if let Some(part) = line.strip_prefix("**").and_then(|l| l.strip_suffix("**")) {
            out += &format!("\n# {part}\n\n");
        }
        let Some((_, link)) = line.strip_prefix("- ").and_then(|l| l.split_once("](")) else {
            continue;
        };
        let (page, _) = link.split_once(')').unwrap();
        let path = Path::new("docs").join(page);
        out += &format!("- [{}]({page})\n", title(&path));
        if page.ends_with("/README.md") {
            let folder = path.parent().unwrap();
            let mut pages: Vec<_> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
            pages.retain(|p| p.extension().is_some_and(|e| e == "md") && !p.ends_with("README.md"));
            pages.sort();
            for path in pages {
                let page = path.strip_prefix("docs").unwrap().display().to_string();
                out += &format!("  - [{}]({page})\n", title(&path).replace(['[', ']'], ""));
            }
        }
    }
    out
}

#[test]
fn the_book_has_every_page() {
    let path = Path::new("docs/SUMMARY.md");
    let expected = summary();
    if std::env::var_os("UPDATE_DOCS").is_some() {
        std::fs::write(path, &expected).unwrap();
    }
    assert_eq!(read(path), expected, "UPDATE_DOCS=1 writes it anew");
    // What the index leaves out would be in no book.
    for page in super::pages().iter().filter_map(|p| p.strip_prefix("docs").ok()) {
        let page = page.display().to_string();
        assert!(
            page == "SUMMARY.md" || expected.contains(&format!("({page})")),
            "{page} is in no list of docs/README.md"
        );
    }
}
