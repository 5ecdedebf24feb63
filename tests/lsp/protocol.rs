//! Beginning, end, and what the protocol says of messages that do not fit.

use serde_json::{Value, json};

use super::THREE_OBJECTS;
use super::client::{Client, URI, at};

#[test]
fn shutdown_and_exit_end_well_and_say_nothing() {
    let mut client = Client::with(THREE_OBJECTS);
    assert_eq!(client.diagnostics(1), Vec::<Value>::new());
    let (status, said) = client.leave();
    assert_eq!((status.code(), said.as_str()), (Some(0), ""));
}

#[test]
fn an_exit_without_shutdown_or_a_lost_editor_is_code_1() {
    let mut client = Client::new();
    client.tell("exit", Value::Null);
    assert_eq!(client.end().0.code(), Some(1));
    assert_eq!(Client::new().end().0.code(), Some(1));
    let mut client = Client::new();
    client.send_raw(b"this is no header\r\n\r\n");
    let (status, said) = client.end();
    assert_eq!(status.code(), Some(1));
    assert!(!said.contains("panicked"), "{said}");
}

#[test]
fn questions_come_after_the_greeting_and_before_the_shutdown() {
    let mut client = Client::silent();
    let early = client.ask_at("textDocument/hover", &json!({ "line": 0, "character": 0 }));
    assert_eq!(early.unwrap_err()["code"], -32002);
    client.ask("initialize", json!({ "capabilities": {} })).unwrap();
    let again = client.ask("initialize", json!({ "capabilities": {} }));
    assert_eq!(again.unwrap_err()["code"], -32600);
    client.ask("shutdown", Value::Null).unwrap();
    let late = client.ask_at("textDocument/hover", &json!({ "line": 0, "character": 0 }));
    assert_eq!(late.unwrap_err()["code"], -32600);
    client.tell("exit", Value::Null);
    assert_eq!(client.end().0.code(), Some(0));
}

#[test]
fn what_is_not_known_is_an_error_and_not_the_end() {
    let mut client = Client::with(THREE_OBJECTS);
    let unknown = client.ask("textDocument/poetry", json!({}));
    assert_eq!(unknown.unwrap_err()["code"], -32601);
    let wrong = client.ask("textDocument/hover", json!({ "position": "everywhere" }));
    assert_eq!(wrong.unwrap_err()["code"], -32602);
    let closed = client.ask(
        "textDocument/hover",
        json!({ "textDocument": { "uri": "file:///lab/other.hatp" }, "position": { "line": 0, "character": 0 } }),
    );
    assert_eq!(closed.unwrap_err()["code"], -32602);
    client.tell("textDocument/didChange", json!({ "nothing": true }));
    client.tell("$/cancelRequest", json!({ "id": 1 }));
    // Positions far outside of the text.
    let far = json!({ "line": 4_000_000_000_u32, "character": 4_000_000_000_u32 });
    assert_eq!(client.ask_at("textDocument/hover", &far), Ok(Value::Null));
    let found = client.ask_at("textDocument/hover", &at(THREE_OBJECTS, "action Pick"));
    assert!(found.unwrap().is_object());
    assert_eq!(client.leave().0.code(), Some(0));
}

#[test]
fn a_body_that_is_no_message_is_answered_and_not_the_end() {
    let mut client = Client::with(THREE_OBJECTS);
    for (body, code) in [
        (&b"{\"jsonrpc\": "[..], -32700),
        (b"\xff\xfe", -32700),
        (b"", -32700),
        (b"[]", -32600),
    ] {
        client.send_raw(format!("content-length:{}\r\n\r\n", body.len()).as_bytes());
        client.send_raw(body);
        let answer = client.error_without_question();
        assert_eq!(
            (&answer["error"]["code"], &answer["id"]),
            (&json!(code), &Value::Null),
            "{answer}"
        );
    }
    let found = client.ask_at("textDocument/hover", &at(THREE_OBJECTS, "action Pick"));
    assert!(found.unwrap().is_object());
    assert_eq!(client.leave().0.code(), Some(0));
}

#[test]
fn a_header_that_lies_ends_the_session() {
    for header in [
        "Content-Length: 18446744073709551615\r\n\r\n{}",
        "Content-Length: -1\r\n\r\n{}",
        "Content-Type: json\r\n\r\n{}",
        "Content-Length: 500\r\n\r\n{}",
    ] {
        let mut client = Client::new();
        client.send_raw(header.as_bytes());
        let (status, said) = client.end();
        assert_eq!(status.code(), Some(1), "{header}");
        assert!(!said.contains("panicked"), "{said}");
    }
    let mut client = Client::new();
    client.send_raw(&[b'x'; 10_000]);
    assert!(client.end().1.contains("a header line without an end"));
}

#[test]
fn a_closed_document_loses_its_diagnostics() {
    let mut client = Client::with("HTN { action A(");
    assert!(!client.diagnostics(1).is_empty());
    client.tell("textDocument/didClose", json!({ "textDocument": { "uri": URI } }));
    let hover = client.ask_at("textDocument/hover", &json!({ "line": 0, "character": 0 }));
    assert!(hover.is_err());
    // The message about the closed one has no version.
    client.open("");
    assert_eq!(client.diagnostics(1).len(), 1, "the first message of version 1 is kept");
}
