//! Messages over two streams: a header with the length, then JSON.
//!
//! Not the connection that comes with `lsp-server`: that one hands over a message only when the one before has been dealt with, so
//! the server would never see that more has been typed meanwhile; and it ends the session at a body that is no message. Here messages
//! wait in a queue, and such a body is answered with an error. A broken header does end the session: nobody knows where the next
//! message begins.

use std::io::{BufRead, BufReader, Read, Write};
use std::sync::{Arc, Mutex};
use std::thread::{Builder, JoinHandle};

use lsp_server::{Connection, ErrorCode, Message};
use serde::de::IgnoredAny;
use serde_json::{Value, json};

/// Longest line of a header [bytes]. HEURISTIC: editors send lines of thirty.
const LONGEST_LINE: u64 = 4096;

/// Largest message [bytes]. HEURISTIC: the largest document that is looked into (8 MB), each byte written as `\u0000`, five times.
const LARGEST_BODY: u64 = 256_000_000;

/// The threads that read and write.
pub(super) struct Wire {
    reader: JoinHandle<Result<(), String>>,
    writer: JoinHandle<std::io::Result<()>>,
}

/// Starts to read and write messages. The error says that there are no threads.
pub(super) fn connect(
    input: impl Read + Send + 'static,
    output: impl Write + Send + 'static,
) -> std::io::Result<(Connection, Wire)> {
    let (ours, theirs) = Connection::memory();
    let Connection { sender, receiver } = theirs;
    let output = Arc::new(Mutex::new(output));
    let answers = Arc::clone(&output);
    let reader = Builder::new().name("lsp reader".into()).spawn(move || {
        let mut input = BufReader::new(input);
        while let Some(body) = body(&mut input)? {
            match serde_json::from_slice::<Message>(&body) {
                Ok(message) => {
                    let is_exit = matches!(&message, Message::Notification(n) if n.method == "exit");
                    if sender.send(message).is_err() || is_exit {
                        break;
                    }
                }
                // Where nothing can be written the other thread ends, and the session with it.
                Err(_) => drop(write(&answers, &refusal(&body))),
            }
        }
        Ok(())
    })?;
    let writer = Builder::new().name("lsp writer".into()).spawn(move || {
        for message in receiver {
            let mut value = serde_json::to_value(&message)?;
            if let Value::Object(object) = &mut value {
                object.insert("jsonrpc".into(), "2.0".into());
            }
            write(&output, &value)?;
        }
        Ok(())
    })?;
    Ok((ours, Wire { reader, writer }))
}

impl Wire {
    /// Waits until all is written; the connection must be dropped before. The error says why the input or the output broke.
    pub(super) fn close(self) -> Result<(), String> {
        let bug = |_| "a thread of the connection panicked".to_owned();
        // If nothing can be written the reader may wait for ever; the end of the program ends it.
        let written = self.writer.join().map_err(bug)?;
        written.map_err(|e| format!("can't write to the editor: {e}"))?;
        self.reader.join().map_err(bug)?
    }
}

/// Reads header and body; nothing at the end of the input, be it in the middle of a message.
fn body(input: &mut impl BufRead) -> Result<Option<Vec<u8>>, String> {
    let lost = |e: std::io::Error| format!("can't read from the editor: {e}");
    let mut length = None;
    loop {
        let mut line = Vec::new();
        let n = input.take(LONGEST_LINE).read_until(b'\n', &mut line).map_err(lost)?;
        if n == 0 {
            return Ok(None);
        }
        let line = String::from_utf8_lossy(&line);
        let Some(line) = line.strip_suffix('\n').map(str::trim_end) else {
            return Err(format!("a header line without an end: `{:.40}`", line.escape_debug()));
        };
        if line.is_empty() {
            break;
        }
        let Some((name, value)) = line.split_once(':') else {
            return Err(format!("no header: `{:.40}`", line.escape_debug()));
        };
        if name.eq_ignore_ascii_case("Content-Length") {
            let n = value.trim().parse().ok().filter(|n| *n <= LARGEST_BODY);
            length = Some(n.ok_or_else(|| format!("no length of a message: `{:.40}`", line.escape_debug()))?);
        }
    }
    let length = length.ok_or("a header without `Content-Length`")?;
    // Room grows with what comes, not with what the header promises.
    let mut body = Vec::new();
    let n = input.take(length).read_to_end(&mut body).map_err(lost)?;
    Ok((n as u64 == length).then_some(body))
}

/// Returns the answer to a body that is no message. An object with an `id` always is one, if only an answer to a question that was never asked.
fn refusal(body: &[u8]) -> Value {
    let (code, message) = match serde_json::from_slice::<IgnoredAny>(body) {
        Ok(_) => (ErrorCode::InvalidRequest, "no message of the protocol".to_owned()),
        Err(why) => (ErrorCode::ParseError, format!("not JSON: {why}")),
    };
    json!({ "jsonrpc": "2.0", "id": null, "error": { "code": code as i32, "message": message } })
}

fn write(output: &Mutex<impl Write>, message: &Value) -> std::io::Result<()> {
    let body = message.to_string();
    let mut output = output.lock().map_err(|_| std::io::Error::other("a thread panicked"))?;
    write!(output, "Content-Length: {}\r\n\r\n{body}", body.len())?;
    output.flush()
}
