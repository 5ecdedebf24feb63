//! Domains of several files, and the one layout.

use serde_json::{Value, json};

use super::client::{Client, at, edited};
use super::{SMALL, THREE_OBJECTS};

const TYPES: &str =
    "// é\nfactdatabase {\n  define entityType Cup;\n  define entityAttributes Cup { dynamic atom bool full; }\n}\n";
const MAIN: &str = "import \"types.hatp\";\nHTN {\n  action Fill(Agent A, Cup C) {\n    effects { C.full = true; };\n    cost { effort(C) };\n  }\n}\n";
const FUNCTIONS: &str = "function number effort(Cup C) { 1 }\n";

/// A folder with a domain, what it imports, and its functions.
struct Lab(tempfile::TempDir);

impl Lab {
    fn new() -> Self {
        let lab = Lab(tempfile::tempdir().unwrap());
        for (name, text) in [
            ("types.hatp", TYPES),
            ("main.hatp", MAIN),
            ("main.functions.hatp", FUNCTIONS),
        ] {
            std::fs::write(lab.0.path().join(name), text).unwrap();
        }
        lab
    }

    fn uri(&self, name: &str) -> String {
        format!("file://{}", self.0.path().join(name).to_str().unwrap())
    }

    fn open(&self, client: &mut Client, name: &str, version: i32, text: &str) {
        let document = json!({ "uri": self.uri(name), "languageId": "hatp", "version": version, "text": text });
        client.tell("textDocument/didOpen", json!({ "textDocument": document }));
    }

    fn ask(&self, client: &mut Client, method: &str, needle: &str) -> Result<Value, Value> {
        client.ask(
            method,
            json!({
                "textDocument": { "uri": self.uri("main.hatp") },
                "position": at(MAIN, needle),
                "context": { "includeDeclaration": true },
                "newName": "Mug",
            }),
        )
    }
}

#[test]
fn what_is_imported_is_known() {
    let (lab, mut client) = (Lab::new(), Client::new());
    lab.open(&mut client, "main.hatp", 1, MAIN);
    assert_eq!(client.diagnostics(1), Vec::<Value>::new());
    let hover = lab.ask(&mut client, "textDocument/hover", "full = true").unwrap();
    assert!(
        hover["contents"]["value"]
            .as_str()
            .unwrap()
            .contains("attribute of `Cup`")
    );
    let found = lab.ask(&mut client, "textDocument/definition", "Cup C").unwrap();
    assert_eq!(found["uri"], lab.uri("types.hatp"));
    assert_eq!(found["range"]["start"], at(TYPES, "Cup;"));
    let found = lab.ask(&mut client, "textDocument/references", "Cup C").unwrap();
    let files: Vec<&str> = found
        .as_array()
        .unwrap()
        .iter()
        .map(|l| l["uri"].as_str().unwrap())
        .collect();
    let count = |name: &str| files.iter().filter(|f| **f == lab.uri(name)).count();
    let counts = ["types.hatp", "main.hatp", "main.functions.hatp"].map(count);
    assert_eq!(counts, [2, 1, 1]);
    let refused = lab.ask(&mut client, "textDocument/rename", "Cup C").unwrap_err();
    assert!(
        refused["message"].as_str().unwrap().contains(".hatp`, too"),
        "{refused}"
    );
    // What belongs to this file alone can be renamed.
    assert!(lab.ask(&mut client, "textDocument/rename", "A, Cup C").is_ok());
}

#[test]
fn what_is_open_counts_and_not_what_is_on_the_disk() {
    let (lab, mut client) = (Lab::new(), Client::new());
    lab.open(&mut client, "types.hatp", 10, TYPES);
    lab.open(&mut client, "main.hatp", 1, MAIN);
    assert_eq!(client.diagnostics(1), Vec::<Value>::new());
    client.forget();
    let document = json!({ "uri": lab.uri("types.hatp"), "version": 11 });
    let changed = TYPES.replace("full", "empty_");
    client.tell(
        "textDocument/didChange",
        json!({ "textDocument": document, "contentChanges": [{ "text": changed }] }),
    );
    // The document that imports it is looked at again, though nobody touched it.
    let found = client.diagnostics(1);
    assert_eq!(found.len(), 1, "{found:?}");
    assert_eq!(found[0]["code"], "hatp::unknown-attribute");
}

#[test]
fn a_file_that_is_not_there_is_told_where_it_is_imported() {
    let (lab, mut client) = (Lab::new(), Client::new());
    lab.open(&mut client, "main.hatp", 1, &MAIN.replace("types.hatp", "tipes.hatp"));
    let found = client.diagnostics(1);
    assert_eq!(found.len(), 1, "{found:?}");
    assert_eq!(
        (&found[0]["code"], &found[0]["range"]["start"]["line"]),
        (&json!("hatp::unreadable"), &json!(0))
    );
    assert!(
        found[0]["message"]
            .as_str()
            .unwrap()
            .contains("did you mean `types.hatp`?")
    );
}

#[test]
fn formatting_changes_the_lines_that_differ() {
    let mut client = Client::with(THREE_OBJECTS);
    let options = json!({ "tabSize": 2, "insertSpaces": true });
    let format = |client: &mut Client| {
        let document = json!({ "uri": super::client::URI });
        client
            .ask(
                "textDocument/formatting",
                json!({ "textDocument": document, "options": options }),
            )
            .unwrap()
    };
    assert_eq!(format(&mut client), json!([]), "it is laid out already");
    let messy = THREE_OBJECTS.replace("    projects { pick(A, O) };", "projects{pick( A,O )};");
    assert_ne!(messy, THREE_OBJECTS);
    client.change(2, json!([{ "text": messy }]));
    let edits = format(&mut client);
    assert_eq!(edits.as_array().unwrap().len(), 1);
    let range = &edits[0]["range"];
    assert_eq!(
        range["end"]["line"].as_u64().unwrap() - range["start"]["line"].as_u64().unwrap(),
        1,
        "one line"
    );
    let edit = json!({ "changes": { super::client::URI: edits } });
    assert_eq!(edited(&messy, &edit), THREE_OBJECTS);
    // With wide characters, other marks of line ends, and nothing at the end.
    let messy = SMALL.replace('\n', "\r\n").trim_end().to_owned();
    client.change(3, json!([{ "text": messy }]));
    let edit = json!({ "changes": { super::client::URI: format(&mut client) } });
    let laid_out = sgap::syntax::format(sgap::source::FileId(0), SMALL).unwrap();
    assert_eq!(edited(&messy, &edit), laid_out);
    client.change(4, json!([{ "text": "HTN { action" }]));
    assert_eq!(format(&mut client), Value::Null, "not with syntax errors");
}
