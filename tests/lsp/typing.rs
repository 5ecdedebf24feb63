//! While somebody types: diagnostics, proposals, quick fixes.

use serde_json::{Value, json};

use super::client::{Client, URI, at, edited, nth, slice};
use super::{SMALL, THREE_OBJECTS};

/// A file with a mistake of each sort.
const BROKEN: &str = include_str!("broken.hatp");

fn with_code<'a>(diagnostics: &'a [Value], code: &str) -> Vec<&'a Value> {
    diagnostics.iter().filter(|d| d["code"] == code).collect()
}

#[test]
fn every_problem_has_its_place_and_its_remedy() {
    let mut client = Client::with(BROKEN);
    let found = client.diagnostics(1);
    let mut said: Vec<(String, &str, u64)> = Vec::new();
    for d in &found {
        let (code, severity) = (d["code"].as_str().unwrap(), d["severity"].as_u64().unwrap());
        said.push((code.to_owned(), slice(BROKEN, &d["range"]), severity));
        assert_eq!(d["source"], "sgap");
    }
    let said: Vec<(&str, &str, u64)> = said.iter().map(|(c, t, s)| (c.as_str(), *t, *s)).collect();
    assert_eq!(
        said,
        [
            ("hatp::unknown-type", "Objekt", 1),
            ("hatp::duplicate-name", "isOn", 1),
            ("hatp::unknown-attribute", "IsOn", 1),
            // A world may declare it: told once.
            ("hatp::unknown-name", "TABLE", 3),
            // Nearly a name that is known: told wherever it stands.
            ("hatp::unknown-name", "Toool", 2),
            ("hatp::unknown-name", "Toool", 2),
            ("hatp::unknown-task", "Pik", 1),
        ]
    );
    let twice = with_code(&found, "hatp::duplicate-name")[0];
    let related = &twice["relatedInformation"][0];
    assert_eq!(related["location"]["uri"], URI);
    assert_eq!(related["location"]["range"]["start"], at(BROKEN, "isOn;"));
    assert!(related["message"].as_str().unwrap().contains("first declared"));
    let message = with_code(&found, "hatp::unknown-task")[0]["message"].as_str().unwrap();
    assert!(message.ends_with("help: did you mean `Pick`?"), "{message}");
}

#[test]
fn a_variable_that_nothing_uses_is_marked_as_such() {
    let mut client = Client::with(&SMALL.replace("Pick(A, Where)", "Pick(A, O)"));
    let found = client.diagnostics(1);
    assert_eq!(found.len(), 1, "{found:?}");
    assert_eq!(found[0]["code"], "hatp::unused-variable");
    assert_eq!((&found[0]["severity"], &found[0]["tags"]), (&json!(2), &json!([1])));
}

#[test]
fn what_is_typed_arrives_in_utf16() {
    let mut client = Client::with(SMALL);
    assert_eq!(client.diagnostics(1), Vec::<Value>::new());
    // Behind `"é𝄞"`: one unit and two.
    let mug = at(SMALL, "MUG = new");
    let end = nth(SMALL, "MUG = new", 0, 3);
    let there = json!({ "start": mug, "end": end });
    client.change(2, json!([{ "range": there, "text": "𝄞" }]));
    let found = client.diagnostics(2);
    assert_eq!(found.len(), 1, "{found:?}");
    assert_eq!(found[0]["code"], "hatp::syntax");
    // Two changes in one message; the second counts in the text after the first.
    let here =
        json!({ "start": mug, "end": { "line": mug["line"], "character": mug["character"].as_u64().unwrap() + 2 } });
    let comment = json!({ "start": { "line": 0, "character": 0 }, "end": { "line": 1, "character": 0 } });
    client.change(
        3,
        json!([{ "range": here, "text": "MUG" }, { "range": comment, "text": "" }]),
    );
    assert_eq!(client.diagnostics(3), Vec::<Value>::new());
    let found = client
        .ask_at("textDocument/hover", &json!({ "line": 0, "character": 3 }))
        .unwrap();
    assert!(found["contents"]["value"].as_str().unwrap().contains("factdatabase"));
}

#[test]
fn beside_a_syntax_error_other_errors_are_told_and_names_are_known() {
    let text = THREE_OBJECTS.replace("A.hasInHand = O;", "A.hasInHand = ");
    let text = text.replace("2: PlaceR(A, O, S, AT) after 1;", "2: PlaceR(A, O, S) after 1;");
    let mut client = Client::with(&text);
    let found = client.diagnostics(1);
    let codes: Vec<&str> = found.iter().map(|d| d["code"].as_str().unwrap()).collect();
    assert_eq!(codes, ["hatp::syntax", "hatp::wrong-count"]);
    // The action with the error in it is known all the same.
    let hover = client
        .ask_at("textDocument/hover", &nth(&text, "1: Pick", 0, 3))
        .unwrap();
    assert!(
        hover["contents"]["value"]
            .as_str()
            .unwrap()
            .contains("action Pick(Agent A, Object O)")
    );
    let hover = client
        .ask_at("textDocument/hover", &nth(&text, "A >> O.isReachable", 0, 7))
        .unwrap();
    assert!(
        hover["contents"]["value"]
            .as_str()
            .unwrap()
            .contains("attribute of `Object`")
    );
}

/// Returns the proposals at `|` in the small domain, where `typed` stands in place of `old`.
fn proposals(old: &str, typed: &str) -> Vec<String> {
    let (before, after) = typed.split_once('|').unwrap();
    let place = SMALL.find(old).expect(old);
    let text = format!("{}{before}{after}{}", &SMALL[..place], &SMALL[place + old.len()..]);
    let whole = &text[..place + before.len()];
    let line = whole.matches('\n').count();
    let units = whole.rsplit('\n').next().unwrap().encode_utf16().count();
    let mut client = Client::with(&text);
    client.completion(&json!({ "line": line, "character": units }))
}

#[test]
fn proposals_are_those_of_the_place() {
    const TEST: &str = "A.holds == NULL; ";
    const LET: &str = "let Where = O.inside;";
    // What must be among them, and what must not.
    let cases: &[(&str, &str, &[&str], &[&str])] = &[
        (TEST, "A.|", &["holds", "kind"], &["weight", "inside", "A", "NULL"]),
        (TEST, "A.holds.|", &["inside", "weight"], &["holds"]),
        (TEST, "A.ho|", &["holds"], &["weight"]),
        (TEST, "O.inside.we| == 1;", &["weight"], &["holds"]),
        (TEST, "UNKNOWN.|", &["holds", "weight"], &["A"]),
        (TEST, "A.kind.|", &[], &["holds", "weight"]),
        (
            TEST,
            "|",
            &["A", "O", "ROB", "MUG", "FORALL", "NOT", "size", "effort"],
            &["Os", "Pick", "effects"],
        ),
        (TEST, "A.holds == |", &["O", "NULL", "MUG"], &["FORALL", "effects"]),
        (TEST, "FORALL(|", &["Agent", "Cup"], &["A", "number"]),
        (TEST, "FORALL(Cup C, {C.|", &["weight"], &["holds"]),
        (TEST, "// A.|", &[], &["holds"]),
        (TEST, "A.kind == \"A.|", &[], &["holds"]),
        ("A.holds = O;", "|", &["A", "O", "IF", "FORALL"], &["OR", "EXIST"]),
        ("{O.isReachable =>> B;}", "{O.isReachable =>> |", &["B", "A"], &["IF"]),
        ("A.holds = O;", "IF{A.|}{ }", &["holds"], &["weight"]),
        ("A.holds = O;", "IF{A.holds == O;}{ O.| }", &["weight"], &["holds"]),
        ("pick(A, O) };", "|", &["pick", "place"], &["Pick", "A"]),
        ("pick(A, O) };", "pick(|", &["A", "O"], &["pick"]),
        (
            "cost { effort(O) };",
            "|",
            &["cost", "duration", "effects"],
            &["goal", "A"],
        ),
        (
            "cost { effort(O) };",
            "cost { | };",
            &["effort", "GetGRPCost", "O"],
            &["FORALL"],
        ),
        ("goal { size(Os) == 0; };", "|", &["goal"], &["effects"]),
        (
            "preconditions { EXIST(Object O, {O >> Os;}); };",
            "|",
            &["preconditions", "subtasks"],
            &["goal"],
        ),
        (LET, "|", &["Pick", "Fetch", "let"], &["pick", "O"]),
        (LET, "4: |", &["Pick", "Fetch"], &["let"]),
        (LET, "X = |", &["SELECT", "SELECTONCE"], &["Pick"]),
        (LET, "X = SELECT(|", &["Object", "Agent"], &["number", "O"]),
        (LET, "X = SELECT(Cup, {X.|", &["weight"], &["holds"]),
        (LET, "let X = O.inside; 4: Pick(A, X.|", &["weight"], &["holds"]),
        (LET, "let X = |", &["O", "Os", "A"], &["SELECT"]),
        (
            "3: Fetch(A, Os - O) > 1, > 2;",
            "3: Fetch(A, Os) after |",
            &["1", "2"],
            &["3", "A"],
        ),
        ("3: Fetch(A, Os - O) > 1, > 2;", "3: Fetch(A, Os) |", &["after"], &["A"]),
        ("static atom string kind;", "|", &["static", "dynamic"], &["atom"]),
        ("static atom string kind;", "dynamic |", &["atom", "set"], &["static"]),
        (
            "static atom string kind;",
            "dynamic atom |",
            &["number", "Object"],
            &["set"],
        ),
        ("static atom string kind;", "dynamic set |", &["Object"], &["number"]),
        (
            "static atom string kind;",
            "dynamic atom Object x = fact |",
            &["hasInHand", "isOn"],
            &["pick"],
        ),
        ("ROB = new Agent;", "ROB = new |", &["Agent", "Cup"], &["number"]),
        (
            "ROB = new Agent;",
            "define |",
            &["entityType", "entityAttributes"],
            &["Agent"],
        ),
        ("ROB = new Agent;", "MUG.|", &["weight", "inside"], &["holds"]),
        (
            "(Agent A, set Object Os)",
            "(Agent A, |",
            &["set", "Object", "number"],
            &["A"],
        ),
        ("HTN {", "settings { | } HTN {", &["interleave"], &["true"]),
        ("HTN {", "settings { interleave = |", &["true", "false"], &["NULL"]),
        ("HTN {", "|", &["HTN", "action"], &["goal"]),
    ];
    for (old, typed, wanted, unwanted) in cases {
        let found = proposals(old, typed);
        for word in *wanted {
            assert!(found.iter().any(|f| f == word), "{typed}: `{word}` is not in {found:?}");
        }
        for word in *unwanted {
            assert!(!found.iter().any(|f| f == word), "{typed}: `{word}` is in {found:?}");
        }
        assert!(!wanted.is_empty() || found.is_empty(), "{typed}: {found:?}");
    }
}

#[test]
fn a_proposal_tells_what_it_is() {
    let mut client = Client::with(SMALL);
    let items = client
        .ask_at("textDocument/completion", &nth(SMALL, "1: Pick", 0, 3))
        .unwrap();
    let pick = items
        .as_array()
        .unwrap()
        .iter()
        .find(|i| i["label"] == "Fetch")
        .unwrap();
    assert_eq!(pick["detail"], "method Fetch(Agent A, set Object Os)");
    assert_eq!(pick["documentation"]["value"], "Brings them all.");
    assert_eq!(
        (pick["insertTextFormat"].as_u64(), pick["insertText"].as_str()),
        (Some(2), Some("Fetch(${1:A}, ${2:Os})"))
    );
}

/// What is typed while a large document is looked at costs one more look, and not one for each character.
#[test]
fn fast_typing_is_looked_at_once() {
    let boxes: String = (0..3000).map(|i| format!("B{i} = new Box;\n")).collect();
    let text = format!("factdatabase {{ define entityType Box;\n{boxes}}}\n");
    let mut client = Client::with(&text);
    client.diagnostics(1);
    client.forget();
    let start = json!({ "line": 1, "character": 0 });
    for version in 2..=200 {
        client.change(
            version,
            json!([{ "range": { "start": start, "end": start }, "text": "x" }]),
        );
    }
    client.diagnostics(200);
    let n = client.n_told("textDocument/publishDiagnostics");
    assert!(n < 100, "looked at {n} times");
}

#[test]
fn a_near_name_is_a_quick_fix() {
    let mut client = Client::with(BROKEN);
    let mut fix = |needle: &str| {
        let place = at(BROKEN, needle);
        let asked = json!({
            "textDocument": { "uri": URI },
            "range": { "start": place, "end": place },
            "context": { "diagnostics": [] },
        });
        client.ask("textDocument/codeAction", asked).unwrap()
    };
    let found = fix("Pik(");
    assert_eq!(found.as_array().unwrap().len(), 1, "{found}");
    assert_eq!(found[0]["title"], "change to `Pick`");
    assert_eq!(edited(BROKEN, &found[0]["edit"]), BROKEN.replace("Pik(", "Pick("));
    let found = fix("IsOn ==");
    assert_eq!(edited(BROKEN, &found[0]["edit"]), BROKEN.replace("IsOn", "isOn"));
    assert_eq!(fix("factdatabase"), json!([]));
}
