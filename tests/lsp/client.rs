//! An editor that starts the real program and follows a script.

use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Child, ChildStdin, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

use serde_json::{Value, json};

/// No answer takes this long; the machine may be busy.
const PATIENCE: Duration = Duration::from_secs(60);

/// The one document of most scripts.
pub const URI: &str = "file:///lab/a.hatp";

pub struct Client {
    program: Child,
    input: Option<ChildStdin>,
    output: Receiver<Value>,
    next_id: i64,
    /// Notifications that came while an answer was awaited.
    told: Vec<Value>,
}

impl Client {
    /// Starts the program, not yet greeted.
    pub fn silent() -> Self {
        let mut program = Command::new(env!("CARGO_BIN_EXE_sgap"))
            .args(["lsp", "--stdio"])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let input = program.stdin.take();
        let mut lines = BufReader::new(program.stdout.take().unwrap());
        let (sender, output) = channel();
        std::thread::spawn(move || {
            while let Some(message) = read_message(&mut lines) {
                if sender.send(message).is_err() {
                    return;
                }
            }
        });
        Client {
            program,
            input,
            output,
            next_id: 0,
            told: Vec::new(),
        }
    }

    /// Starts and greets the program, as an editor that can do everything.
    pub fn new() -> Self {
        let mut client = Client::silent();
        let capabilities = json!({
            "textDocument": {
                "completion": { "completionItem": { "snippetSupport": true } },
                "publishDiagnostics": { "versionSupport": true },
            },
            "workspace": { "workspaceEdit": { "documentChanges": true } },
        });
        let greeting = client
            .ask("initialize", json!({ "capabilities": capabilities }))
            .unwrap();
        assert_eq!(greeting["capabilities"]["positionEncoding"], "utf-16");
        client.tell("initialized", json!({}));
        client
    }

    /// Starts, greets, and opens a document.
    pub fn with(text: &str) -> Self {
        let mut client = Client::new();
        client.open(text);
        client
    }

    pub fn send_raw(&mut self, bytes: &[u8]) {
        let input = self.input.as_mut().unwrap();
        input.write_all(bytes).unwrap();
        input.flush().unwrap();
    }

    fn send(&mut self, message: &Value) {
        let body = message.to_string();
        self.send_raw(format!("Content-Length: {}\r\n\r\n{body}", body.len()).as_bytes());
    }

    /// Sends a notification.
    pub fn tell(&mut self, method: &str, params: Value) {
        self.send(&json!({ "jsonrpc": "2.0", "method": method, "params": params }));
    }

    /// Sends a request, and returns its result or its error.
    pub fn ask(&mut self, method: &str, params: Value) -> Result<Value, Value> {
        self.next_id += 1;
        let id = self.next_id;
        self.send(&json!({ "jsonrpc": "2.0", "id": id, "method": method, "params": params }));
        loop {
            let message = self.output.recv_timeout(PATIENCE).expect("an answer");
            if message["id"] != id {
                self.told.push(message);
                continue;
            }
            return match message.get("error") {
                Some(error) => Err(error.clone()),
                None => Ok(message["result"].clone()),
            };
        }
    }

    pub fn open(&mut self, text: &str) {
        let document = json!({ "uri": URI, "languageId": "hatp", "version": 1, "text": text });
        self.tell("textDocument/didOpen", json!({ "textDocument": document }));
    }

    /// Changes the document: each a range and its new text, or the whole text.
    pub fn change(&mut self, version: i32, changes: Value) {
        let document = json!({ "uri": URI, "version": version });
        self.tell(
            "textDocument/didChange",
            json!({ "textDocument": document, "contentChanges": changes }),
        );
    }

    /// Asks about a place of the document.
    pub fn ask_at(&mut self, method: &str, position: &Value) -> Result<Value, Value> {
        self.ask(
            method,
            json!({
                "textDocument": { "uri": URI },
                "position": position,
                "context": { "includeDeclaration": true, "triggerKind": 1 },
            }),
        )
    }

    /// Waits for the diagnostics of a version of the document.
    pub fn diagnostics(&mut self, version: i32) -> Vec<Value> {
        let is_it = |m: &Value| m["method"] == "textDocument/publishDiagnostics" && m["params"]["version"] == version;
        loop {
            let found = self.told.iter().find(|m| is_it(m)).cloned();
            if let Some(found) = found {
                return found["params"]["diagnostics"].as_array().unwrap().clone();
            }
            let message = self.output.recv_timeout(PATIENCE).expect("diagnostics");
            self.told.push(message);
        }
    }

    /// Waits for an error that answers no question of ours.
    pub fn error_without_question(&mut self) -> Value {
        loop {
            let message = self.output.recv_timeout(PATIENCE).expect("an error");
            if message.get("error").is_some() {
                return message;
            }
            self.told.push(message);
        }
    }

    /// How many notifications of this kind came and were not forgotten.
    pub fn n_told(&self, method: &str) -> usize {
        self.told.iter().filter(|m| m["method"] == method).count()
    }

    /// Forgets what was told so far.
    pub fn forget(&mut self) {
        self.told.clear();
    }

    /// Labels of the completion at a place.
    pub fn completion(&mut self, position: &Value) -> Vec<String> {
        let items = self.ask_at("textDocument/completion", position).unwrap();
        let items = items.as_array().unwrap().iter();
        items.map(|i| i["label"].as_str().unwrap().to_owned()).collect()
    }

    /// Says goodbye as the protocol asks, and returns how the program ended and what it said to its standard error.
    pub fn leave(mut self) -> (ExitStatus, String) {
        assert_eq!(self.ask("shutdown", Value::Null), Ok(Value::Null));
        self.tell("exit", Value::Null);
        self.end()
    }

    /// Closes the program's input and waits for its end.
    pub fn end(mut self) -> (ExitStatus, String) {
        drop(self.input.take());
        let status = self.program.wait().unwrap();
        let mut said = String::new();
        self.program.stderr.take().unwrap().read_to_string(&mut said).unwrap();
        (status, said)
    }
}

impl Drop for Client {
    fn drop(&mut self) {
        // A script that failed leaves no program behind.
        let _ = self.program.kill();
        let _ = self.program.wait();
    }
}

fn read_message(lines: &mut impl BufRead) -> Option<Value> {
    let mut length = 0;
    loop {
        let mut line = String::new();
        if lines.read_line(&mut line).ok()? == 0 {
            return None;
        }
        let line = line.trim_end();
        if line.is_empty() {
            break;
        }
        if let Some(n) = line.strip_prefix("Content-Length: ") {
            length = n.parse().ok()?;
        }
    }
    let mut body = vec![0; length];
    lines.read_exact(&mut body).ok()?;
    serde_json::from_slice(&body).ok()
}

/// Returns the position `ahead` bytes into the `n`th (from 0) place of `needle`; counts UTF-16 units its own way.
pub fn nth(text: &str, needle: &str, n: usize, ahead: usize) -> Value {
    let (at, _) = text.match_indices(needle).nth(n).expect(needle);
    let before = &text[..at + ahead];
    let line = before.matches('\n').count();
    let units = before.rsplit('\n').next().unwrap().encode_utf16().count();
    json!({ "line": line, "character": units })
}

/// Returns the position of the first place of `needle`.
pub fn at(text: &str, needle: &str) -> Value {
    nth(text, needle, 0, 0)
}

/// Returns the text between two positions of an answer's range.
pub fn slice<'a>(text: &'a str, range: &Value) -> &'a str {
    let byte = |p: &Value| {
        let line = p["line"].as_u64().unwrap() as usize;
        let start: usize = text.split_inclusive('\n').take(line).map(str::len).sum();
        let mut units = p["character"].as_u64().unwrap() as usize;
        let mut at = start;
        for c in text[start..].chars().take_while(|c| *c != '\n') {
            if units == 0 {
                break;
            }
            units -= c.len_utf16();
            at += c.len_utf8();
        }
        at
    };
    &text[byte(&range["start"])..byte(&range["end"])]
}

/// Applies the edits of an answer to the document.
pub fn edited(text: &str, edit: &Value) -> String {
    let edits = match edit["documentChanges"].as_array() {
        Some(changes) => changes[0]["edits"].as_array().unwrap(),
        None => edit["changes"][URI].as_array().unwrap(),
    };
    let mut out = text.to_owned();
    let mut places: Vec<(usize, usize, &str)> = edits
        .iter()
        .map(|e| {
            let part = slice(text, &e["range"]);
            let start = part.as_ptr() as usize - text.as_ptr() as usize;
            (start, start + part.len(), e["newText"].as_str().unwrap())
        })
        .collect();
    places.sort();
    for (start, end, new) in places.into_iter().rev() {
        out.replace_range(start..end, new);
    }
    out
}
