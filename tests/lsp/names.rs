//! Names: what they mean, where they are declared and used, and how they get another.

use serde_json::{Value, json};

use super::client::{Client, URI, at, edited, nth, slice};
use super::{SMALL, THREE_OBJECTS};

fn hover(client: &mut Client, position: &Value) -> String {
    let found = client.ask_at("textDocument/hover", position).unwrap();
    found["contents"]["value"].as_str().unwrap_or("").to_owned()
}

#[test]
fn the_small_domain_has_no_problems() {
    let mut client = Client::with(SMALL);
    assert_eq!(client.diagnostics(1), Vec::<Value>::new());
}

#[test]
fn hover_tells_declaration_type_and_comment() {
    let mut client = Client::with(SMALL);
    let cases: &[(Value, &[&str])] = &[
        (
            nth(SMALL, "O.weight", 0, 2),
            &["dynamic atom number weight", "attribute of `Object`"],
        ),
        (
            nth(SMALL, "O.inside.weight", 0, 9),
            &["dynamic atom number weight", "attribute of `Object`"],
        ),
        (nth(SMALL, "MUG.weight", 0, 5), &["attribute of `Object`"]),
        (
            nth(SMALL, "O.inside ==", 0, 2),
            &["dynamic atom Cup inside", "é: what holds it"],
        ),
        (nth(SMALL, "new Cup", 0, 4), &["define entityType Cup : Object", "type"]),
        (
            nth(SMALL, "entityType Object", 0, 11),
            &["define entityType Object", "what can be carried"],
        ),
        (
            nth(SMALL, "Agent A, Object O", 0, 0),
            &["Agent", "built in", "Robots and humans"],
        ),
        (
            nth(SMALL, "effort(O) }", 0, 0),
            &["function number effort(Object O)", "Twice the weight."],
        ),
        (nth(SMALL, "1: Pick", 0, 3), &["action Pick(Agent A, Object O)"]),
        (
            nth(SMALL, "3: Fetch", 0, 3),
            &["method Fetch(Agent A, set Object Os)", "Brings them all."],
        ),
        (
            nth(SMALL, "Os - O", 0, 0),
            &["set Object Os", "parameter of method `Fetch`"],
        ),
        (nth(SMALL, "Pick(A, Where)", 0, 8), &["Cup Where", "variable"]),
        (nth(SMALL, "B != A", 0, 0), &["Agent B", "variable"]),
        (nth(SMALL, "O != MUG", 0, 5), &["MUG = new Cup", "entity"]),
        (
            nth(SMALL, "pick(A, O)", 0, 0),
            &["geometric pick(Agent A, any O)", "built in", "closes and lifts"],
        ),
        (
            nth(SMALL, "fact isReachable", 0, 6),
            &["fact isReachable(any O, Agent A)", "without moving its base"],
        ),
        (nth(SMALL, "after 1", 0, 6), &["1: Pick", "label"]),
        (nth(SMALL, "SELECT", 0, 2), &["SELECT", "choice among all entities"]),
        (nth(SMALL, "size(Os)", 0, 0), &["How many members a set has"]),
    ];
    for (position, parts) in cases {
        let said = hover(&mut client, position);
        for part in *parts {
            assert!(said.contains(part), "{position}: `{part}` is not in\n{said}");
        }
    }
    assert_eq!(hover(&mut client, &at(SMALL, "kleiner")), "");
}

#[test]
fn hover_marks_the_name_where_characters_have_two_units() {
    let mut client = Client::with(SMALL);
    for (needle, word) in [
        ("Object;  // what", "Object"),
        ("MUG = new", "MUG"),
        ("MUG.weight", "MUG"),
    ] {
        let found = client.ask_at("textDocument/hover", &at(SMALL, needle)).unwrap();
        assert_eq!(slice(SMALL, &found["range"]), word);
    }
}

#[test]
fn a_declaration_is_found() {
    let mut client = Client::with(SMALL);
    for (use_at, declared_at) in [
        (nth(SMALL, "O.inside.weight", 0, 9), nth(SMALL, "number weight", 0, 7)),
        (nth(SMALL, "B != A", 0, 0), nth(SMALL, "Agent B", 0, 6)),
        (nth(SMALL, "O >> Os;});", 0, 0), nth(SMALL, "Object O, {", 0, 7)),
        (nth(SMALL, "1: Pick(A, O)", 0, 11), nth(SMALL, "O = SELECT", 0, 0)),
        (nth(SMALL, "1: Pick(A, O)", 0, 3), nth(SMALL, "action Pick", 0, 7)),
        (nth(SMALL, "> 2", 0, 2), nth(SMALL, "2: Pick", 0, 0)),
        (nth(SMALL, "ROB.kind", 0, 0), nth(SMALL, "ROB = new", 0, 0)),
    ] {
        let found = client.ask_at("textDocument/definition", &use_at).unwrap();
        assert_eq!(found["uri"], URI);
        assert_eq!(found["range"]["start"], declared_at, "{use_at}");
    }
    // What is built in stands in no file.
    let builtin = client.ask_at("textDocument/definition", &at(SMALL, "pick(A, O)"));
    assert_eq!(builtin, Ok(Value::Null));
}

/// Returns the lines of all references, as `line:word`.
fn references(client: &mut Client, text: &str, position: &Value) -> Vec<u64> {
    let found = client.ask_at("textDocument/references", position).unwrap();
    let found = found.as_array().unwrap().iter();
    let first = slice(text, &client_range(client, text, position)).to_owned();
    found
        .map(|l| {
            assert_eq!(slice(text, &l["range"]), first);
            l["range"]["start"]["line"].as_u64().unwrap()
        })
        .collect()
}

fn client_range(client: &mut Client, _: &str, position: &Value) -> Value {
    client.ask_at("textDocument/hover", position).unwrap()["range"].clone()
}

#[test]
fn references_are_those_of_one_meaning() {
    let mut client = Client::with(THREE_OBJECTS);
    let line = |needle: &str, n: usize| nth(THREE_OBJECTS, needle, n, 0)["line"].as_u64().unwrap();
    // `isOn` of objects: declared once, set twice, tested once.
    let places = references(&mut client, THREE_OBJECTS, &nth(THREE_OBJECTS, "O.isOn = NULL", 0, 2));
    assert_eq!(
        places,
        [
            line("Support isOn", 0),
            line("O.isOn = NULL", 0),
            line("O.isOn = S", 0),
            line("O.isOn == From", 0),
        ]
    );
    // The parameter of one action is not that of another.
    let places = references(&mut client, THREE_OBJECTS, &nth(THREE_OBJECTS, "AT)", 0, 0));
    let last = line("isReachable <<= AT", 0);
    assert_eq!(places.len(), 3, "{places:?}");
    assert!(places.iter().all(|l| *l >= line("action PlaceR", 0) && *l <= last));
    let highlights = client.ask_at(
        "textDocument/documentHighlight",
        &nth(THREE_OBJECTS, "O.isOn = NULL", 0, 2),
    );
    let kinds: Vec<u64> = highlights
        .unwrap()
        .as_array()
        .unwrap()
        .iter()
        .map(|h| h["kind"].as_u64().unwrap())
        .collect();
    assert_eq!(kinds, [3, 3, 3, 2], "declared, set, set, read");
}

fn rename(client: &mut Client, position: &Value, new: &str) -> Result<Value, String> {
    let asked = client.ask(
        "textDocument/rename",
        json!({ "textDocument": { "uri": URI }, "position": position, "newName": new }),
    );
    asked.map_err(|e| e["message"].as_str().unwrap().to_owned())
}

#[test]
fn a_name_is_changed_everywhere_it_has_this_meaning() {
    let mut client = Client::with(SMALL);
    let edit = rename(&mut client, &nth(SMALL, "O.inside.weight", 0, 2), "within").unwrap();
    assert_eq!(edit["documentChanges"][0]["textDocument"]["version"], 1);
    assert_eq!(edited(SMALL, &edit), SMALL.replace("inside", "within"));
    let edit = rename(&mut client, &at(SMALL, "ROB.kind"), "HELPER").unwrap();
    assert_eq!(edited(SMALL, &edit), SMALL.replace("ROB", "HELPER"));
    // The variable of SELECT, not the parameters and variables of that name elsewhere.
    let edit = rename(&mut client, &nth(SMALL, "1: Pick(A, O)", 0, 11), "Thing").unwrap();
    let changed = edited(SMALL, &edit);
    for part in [
        "Thing = SELECT(Object, {Thing >> Os; Thing != MUG;});",
        "let Where = Thing.inside;",
        "1: Pick(A, Thing);",
        "Os - Thing",
        "EXIST(Object O, {O >> Os;})",
        "action Pick(Agent A, Object O)",
    ] {
        assert!(changed.contains(part), "{part} is not in\n{changed}");
    }
    let edit = rename(&mut client, &nth(SMALL, "1: Pick", 0, 0), "first").unwrap();
    assert!(edited(SMALL, &edit).contains("3: Fetch(A, Os - O) > first, > 2;"));
}

#[test]
fn a_rename_that_would_change_the_meaning_is_refused_with_its_reason() {
    let mut client = Client::with(SMALL);
    let pick_a = nth(SMALL, "A.holds == NULL", 0, 0);
    let cases = [
        (pick_a.clone(), "2nd", "is no name"),
        (pick_a.clone(), "", "is no name"),
        (pick_a.clone(), "with space", "is no name"),
        (pick_a.clone(), "SELECT", "is a word of the language"),
        (pick_a.clone(), "O", "has another meaning"),
        (pick_a, "ROB", ""),
        (nth(SMALL, "O.inside ==", 0, 2), "weight", "has another meaning"),
        (nth(SMALL, "effort(O) }", 0, 0), "GetGRPCost", "is built in"),
        (nth(SMALL, "Agent A", 0, 0), "Person", "type `Agent` is built in"),
        (nth(SMALL, "pick(A, O)", 0, 0), "grab", "`pick` is built in"),
        (at(SMALL, "NULL"), "NIL", "no name here"),
    ];
    for (position, new, why) in cases {
        match rename(&mut client, &position, new) {
            Err(said) => assert!(!why.is_empty() && said.contains(why), "{new}: {said}"),
            // A parameter may hide an entity that it is not mixed up with.
            Ok(_) => assert!(why.is_empty(), "{position} to {new}"),
        }
    }
    let refused = client.ask_at("textDocument/prepareRename", &at(SMALL, "pick(A, O)"));
    assert_eq!(refused.unwrap_err()["code"], -32803);
    let place = client
        .ask_at("textDocument/prepareRename", &nth(SMALL, "effort(O) }", 0, 3))
        .unwrap();
    assert_eq!(slice(SMALL, &place), "effort");
    client.change(2, json!([{ "text": SMALL.replace("A.holds = O;", "A.holds = ") }]));
    let said = rename(&mut client, &at(SMALL, "ROB = new"), "HELPER").unwrap_err();
    assert!(said.contains("syntax errors"), "{said}");
}

#[test]
fn an_editor_without_document_changes_gets_plain_ones() {
    let mut client = Client::silent();
    client.ask("initialize", json!({ "capabilities": {} })).unwrap();
    client.open(SMALL);
    let edit = rename(&mut client, &at(SMALL, "ROB = new"), "HELPER").unwrap();
    assert!(edit.get("documentChanges").is_none());
    assert_eq!(edited(SMALL, &edit), SMALL.replace("ROB", "HELPER"));
}

#[test]
fn the_outline_is_a_tree() {
    let mut client = Client::with(THREE_OBJECTS);
    let found = client.ask_at("textDocument/documentSymbol", &json!(null)).unwrap();
    let mut lines = Vec::new();
    tree(&found, 0, &mut lines);
    assert_eq!(
        lines,
        [
            "Object",
            "Support (: Object)",
            "Agent (attributes)",
            "  type (string)",
            "  hasInHand (Object)",
            "Object (attributes)",
            "  isOn (Support)",
            "  isReachable (set Agent)",
            "  isVisible (set Agent)",
            "Pick (action(A, O))",
            "PlaceR (action(A, O, S, AT))",
            "MoveObj (method(A, O, From, S, AT))",
            "  decomposition 1",
            "    Pick (1)",
            "    PlaceR (2)",
            "MoveObjs (method(R, Os, From, S, AT))",
            "  decomposition 1",
            "    MoveObj (1)",
            "    MoveObjs (2)",
        ]
    );
}

fn tree(symbols: &Value, depth: usize, lines: &mut Vec<String>) {
    for symbol in symbols.as_array().into_iter().flatten() {
        let detail = symbol["detail"].as_str().map_or(String::new(), |d| format!(" ({d})"));
        lines.push(format!(
            "{}{}{detail}",
            "  ".repeat(depth),
            symbol["name"].as_str().unwrap()
        ));
        let (whole, place) = (&symbol["range"], &symbol["selectionRange"]);
        assert!(slice(THREE_OBJECTS, whole).contains(slice(THREE_OBJECTS, place)));
        tree(&symbol["children"], depth + 1, lines);
    }
}
