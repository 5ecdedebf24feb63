//! The files for editors: they parse, agree with each other, and know every word of the grammar.

use std::collections::BTreeSet;

use serde_json::Value;

fn json(path: &str) -> Value {
    let text = std::fs::read_to_string(format!("editors/vscode/{path}")).unwrap();
    serde_json::from_str(&text).unwrap_or_else(|e| panic!("{path}: {e}"))
}

/// The words of the grammar's `kw_*` rules, and its constants.
fn words_of_the_grammar() -> BTreeSet<String> {
    let grammar = include_str!("../../grammar/hatp.pest");
    let is_word = |rule: &&str| ["kw_", "boolean", "null "].iter().any(|p| rule.starts_with(p));
    let rules = grammar.lines().filter(is_word);
    rules
        .flat_map(|rule| rule.split('"').skip(1).step_by(2).map(str::to_owned))
        .collect()
}

/// All `match` patterns of the TextMate grammar.
fn patterns(value: &Value, found: &mut Vec<String>) {
    match value {
        Value::Object(fields) => {
            for (key, inner) in fields {
                match inner
                    .as_str()
                    .filter(|_| ["match", "begin", "end"].contains(&key.as_str()))
                {
                    Some(pattern) => found.push(pattern.to_owned()),
                    None => patterns(inner, found),
                }
            }
        }
        Value::Array(values) => values.iter().for_each(|v| patterns(v, found)),
        _ => {}
    }
}

#[test]
fn the_colours_know_every_word_of_the_grammar_and_no_other() {
    let mut found = Vec::new();
    patterns(&json("syntaxes/hatp.tmLanguage.json"), &mut found);
    // Lists of words stand as `\b(one|two)\b`.
    let lists = found
        .iter()
        .filter_map(|p| p.strip_prefix("\\b(")?.strip_suffix(")\\b"));
    let listed: BTreeSet<String> = lists.flat_map(|l| l.split('|').map(str::to_owned)).collect();
    let grammar = words_of_the_grammar();
    assert!(grammar.len() > 45, "{grammar:?}");
    // Basic types and the one built-in function are names to the grammar.
    let names: BTreeSet<String> = ["number", "int", "float", "bool", "string", "any", "size", "Agent"]
        .map(str::to_owned)
        .into();
    assert!(grammar.is_disjoint(&names));
    let wanted: BTreeSet<String> = grammar.union(&names).cloned().collect();
    assert_eq!(listed, wanted);
}

#[test]
fn the_extension_is_of_one_piece() {
    let package = json("package.json");
    assert_eq!(package["version"], env!("CARGO_PKG_VERSION"));
    assert_eq!(package["name"], "sgap-hatp");
    let language = &package["contributes"]["languages"][0];
    let grammar = &package["contributes"]["grammars"][0];
    assert_eq!(language["id"], grammar["language"]);
    assert_eq!(json("syntaxes/hatp.tmLanguage.json")["scopeName"], grammar["scopeName"]);
    for path in [&package["main"], &language["configuration"], &grammar["path"]] {
        let path = std::path::Path::new("editors/vscode").join(path.as_str().unwrap());
        assert!(path.is_file(), "{}", path.display());
    }
    assert_eq!(language["extensions"], serde_json::json!([".hatp", ".dom"]));
    let configuration = json("language-configuration.json");
    assert_eq!(configuration["comments"]["lineComment"], "//");
    let script = include_str!("../../editors/vscode/extension.js");
    assert!(script.contains("args: ['lsp', '--stdio']"), "starts the server");
    for setting in package["contributes"]["configuration"]["properties"]
        .as_object()
        .unwrap()
        .keys()
    {
        let (section, name) = setting.split_once('.').unwrap();
        assert!(
            script.contains(&format!("getConfiguration('{section}').get('{name}'")),
            "{setting}"
        );
    }
}
