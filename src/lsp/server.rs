//! The loop: messages in, answers out; documents are looked at when the queue is empty or somebody asks.

use std::collections::{BTreeMap, BTreeSet};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::rc::Rc;
use std::str::FromStr;

use lsp_server::{Connection, ErrorCode, Message, Notification, Request, Response};
use lsp_types::notification::{
    DidChangeTextDocument, DidCloseTextDocument, DidOpenTextDocument, DidSaveTextDocument, Notification as Kind,
    PublishDiagnostics,
};
use lsp_types::request::{
    CodeActionRequest, Completion, DocumentHighlightRequest, DocumentSymbolRequest, Formatting, GotoDefinition,
    HoverRequest, Initialize, PrepareRenameRequest, References, Rename, Request as Method, Shutdown,
};
use lsp_types::{
    CodeActionOrCommand, CodeActionResponse, CompletionResponse, Diagnostic, DocumentSymbolResponse,
    GotoDefinitionResponse, InitializeParams, InitializeResult, PrepareRenameResponse, PublishDiagnosticsParams,
    ServerInfo, TextDocumentPositionParams, Uri,
};

use super::analysis::Analysis;
use super::completion::completion;
use super::diagnostics::diagnostics;
use super::document::{Document, LARGEST};
use super::editor::{Editor, capabilities};
use super::{fixes, formatting, hover, navigate, outline, rename};
use crate::source::Files;

/// Serves until `exit`, or until the other side is gone; says whether `shutdown` came before.
pub(super) fn serve(connection: &Connection, files: &dyn Files) -> bool {
    let mut server = Server::new(files);
    loop {
        // What was typed meanwhile is taken in first: only the last state of a document is worth looking at.
        let waiting = connection.receiver.try_recv();
        let message = match waiting {
            Ok(message) => message,
            Err(_) => {
                for message in guarded(|| server.publish()).unwrap_or_default() {
                    if connection.sender.send(message).is_err() {
                        return false;
                    }
                }
                match connection.receiver.recv() {
                    Ok(message) => message,
                    Err(_) => return false,
                }
            }
        };
        if matches!(&message, Message::Notification(n) if n.method == "exit") {
            return server.stage == Stage::ShutDown;
        }
        if let Some(answer) = server.message(message)
            && connection.sender.send(answer).is_err()
        {
            return false;
        }
    }
}

/// Runs what a fault of ours must not end the session with; the program's own hook has told of it.
fn guarded<T>(job: impl FnOnce() -> T) -> Option<T> {
    catch_unwind(AssertUnwindSafe(job)).ok()
}

/// How far the conversation is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Stage {
    Greeting,
    Running,
    ShutDown,
}

/// The open documents and what the editor can do.
pub(super) struct Server<'f> {
    /// The disk, for what documents import.
    files: &'f dyn Files,
    stage: Stage,
    /// By address.
    documents: BTreeMap<String, Document>,
    /// Documents whose diagnostics are to be sent.
    changed: BTreeSet<String>,
    editor: Editor,
}

/// Why a request has no result.
struct Refusal {
    code: ErrorCode,
    message: String,
}

/// The files as the editor has them: what is open hides what is on the disk.
struct Overlay<'a> {
    documents: &'a BTreeMap<String, Document>,
    files: &'a dyn Files,
}

impl Files for Overlay<'_> {
    fn read(&self, path: &str) -> Result<String, String> {
        match self.documents.values().find(|d| d.path == path) {
            // As if it were empty.
            Some(document) if document.is_too_large() => Ok(String::new()),
            Some(document) => Ok(document.text.clone()),
            None => self.files.read(path),
        }
    }

    fn list(&self, folder: &str) -> Vec<String> {
        self.files.list(folder)
    }
}

impl<'f> Server<'f> {
    pub(super) fn new(files: &'f dyn Files) -> Self {
        Server {
            files,
            stage: Stage::Greeting,
            documents: BTreeMap::new(),
            changed: BTreeSet::new(),
            editor: Editor::default(),
        }
    }

    /// Takes in one message, and answers if it is a request.
    pub(super) fn message(&mut self, message: Message) -> Option<Message> {
        match message {
            Message::Request(request) => {
                let id = request.id.clone();
                let answer = guarded(|| self.request(request)).unwrap_or_else(|| {
                    let message = "this is a bug of sgap; its standard error says more".to_owned();
                    Response::new_err(id, ErrorCode::InternalError as i32, message)
                });
                Some(Message::Response(answer))
            }
            Message::Notification(notification) => {
                let _ = guarded(|| self.notification(notification));
                None
            }
            // We ask nothing.
            Message::Response(_) => None,
        }
    }

    fn request(&mut self, request: Request) -> Response {
        let refuse = |code: ErrorCode, message: &str| {
            let id = request.id.clone();
            Response::new_err(id, code as i32, message.to_owned())
        };
        match (self.stage, request.method.as_str()) {
            (Stage::Greeting, Initialize::METHOD) => self.initialize(request),
            (Stage::Greeting, _) => refuse(ErrorCode::ServerNotInitialized, "the first request is `initialize`"),
            (Stage::Running, Initialize::METHOD) => refuse(ErrorCode::InvalidRequest, "`initialize` comes once"),
            (Stage::Running, Shutdown::METHOD) => {
                self.stage = Stage::ShutDown;
                Response::new_ok(request.id, ())
            }
            (Stage::Running, _) => self.question(request),
            (Stage::ShutDown, _) => refuse(ErrorCode::InvalidRequest, "after `shutdown` only `exit` may come"),
        }
    }

    fn initialize(&mut self, request: Request) -> Response {
        answered::<Initialize>(request, |params: InitializeParams| {
            self.stage = Stage::Running;
            self.editor = Editor::of(&params.capabilities);
            Ok(InitializeResult {
                capabilities: capabilities(),
                server_info: Some(ServerInfo {
                    name: "sgap".into(),
                    version: Some(env!("CARGO_PKG_VERSION").into()),
                }),
            })
        })
    }

    fn question(&self, request: Request) -> Response {
        let editor = self.editor;
        match request.method.as_str() {
            HoverRequest::METHOD => answered::<HoverRequest>(request, |p| {
                let at = p.text_document_position_params;
                self.at(&at, |document, analysis| hover::hover(document, analysis, at.position))
            }),
            GotoDefinition::METHOD => answered::<GotoDefinition>(request, |p| {
                let at = p.text_document_position_params;
                self.at(&at, |document, analysis| {
                    let found = navigate::definition(document, analysis, at.position);
                    found.map(GotoDefinitionResponse::Scalar)
                })
            }),
            References::METHOD => answered::<References>(request, |p| {
                let (at, with_declaration) = (p.text_document_position, p.context.include_declaration);
                self.at(&at, |document, analysis| {
                    navigate::references(document, analysis, at.position, with_declaration)
                })
            }),
            DocumentHighlightRequest::METHOD => answered::<DocumentHighlightRequest>(request, |p| {
                let at = p.text_document_position_params;
                self.at(&at, |document, analysis| {
                    navigate::highlights(document, analysis, at.position)
                })
            }),
            PrepareRenameRequest::METHOD => answered::<PrepareRenameRequest>(request, |at| {
                self.at(&at, |document, analysis| {
                    rename::prepare(document, analysis, at.position)
                })?
                .map(|range| Some(PrepareRenameResponse::Range(range)))
                .map_err(refused)
            }),
            Rename::METHOD => answered::<Rename>(request, |p| {
                let at = p.text_document_position;
                let files = self.overlay();
                self.at(&at, |document, analysis| {
                    let edits = rename::rename(document, analysis, at.position, &p.new_name, &files)?;
                    Ok(Some(editor.workspace_edit(document, edits)))
                })?
                .map_err(refused)
            }),
            Completion::METHOD => answered::<Completion>(request, |p| {
                let at = p.text_document_position;
                self.at(&at, |document, analysis| {
                    let items = completion(document, analysis, at.position, editor.has_snippets);
                    Some(CompletionResponse::Array(items))
                })
            }),
            Formatting::METHOD => answered::<Formatting>(request, |p| {
                self.document(&p.text_document.uri, |document, analysis| {
                    formatting::formatting(document, analysis)
                })
            }),
            DocumentSymbolRequest::METHOD => answered::<DocumentSymbolRequest>(request, |p| {
                self.document(&p.text_document.uri, |document, analysis| {
                    Some(DocumentSymbolResponse::Nested(outline::outline(document, analysis)))
                })
            }),
            CodeActionRequest::METHOD => answered::<CodeActionRequest>(request, |p| {
                self.document(&p.text_document.uri, |document, analysis| {
                    let wrap = |document: &Document, edits| editor.workspace_edit(document, edits);
                    let fixes = fixes::fixes(document, analysis, p.range, wrap);
                    let fixes = fixes.into_iter().map(CodeActionOrCommand::CodeAction);
                    Some(fixes.collect::<CodeActionResponse>())
                })
            }),
            other => {
                let message = format!("no method `{}`", other.chars().take(100).collect::<String>());
                Response::new_err(request.id, ErrorCode::MethodNotFound as i32, message)
            }
        }
    }

    fn overlay(&self) -> Overlay<'_> {
        Overlay {
            documents: &self.documents,
            files: self.files,
        }
    }

    fn analysis(&self, document: &Document) -> Rc<Analysis> {
        let analysis = || Rc::new(Analysis::of(&document.path, &self.overlay()));
        Rc::clone(document.analysis.get_or_init(analysis))
    }

    fn at<T>(&self, at: &TextDocumentPositionParams, f: impl FnOnce(&Document, &Analysis) -> T) -> Result<T, Refusal> {
        self.document(&at.text_document.uri, f)
    }

    /// Asks about an open document.
    fn document<T>(&self, uri: &Uri, f: impl FnOnce(&Document, &Analysis) -> T) -> Result<T, Refusal> {
        let document = self.documents.get(uri.as_str()).ok_or_else(|| Refusal {
            code: ErrorCode::InvalidParams,
            message: "the document is not open".into(),
        })?;
        Ok(f(document, &self.analysis(document)))
    }

    fn notification(&mut self, notification: Notification) {
        if self.stage != Stage::Running {
            return;
        }
        match notification.method.as_str() {
            DidOpenTextDocument::METHOD => {
                let Some(p) = read::<DidOpenTextDocument>(notification) else {
                    return;
                };
                let (uri, opened) = (p.text_document.uri, p.text_document.text);
                let address = uri.as_str().to_owned();
                let opened = Document::new(uri, opened, p.text_document.version);
                self.documents.insert(address.clone(), opened);
                self.has_changed(address);
            }
            DidChangeTextDocument::METHOD => {
                let Some(p) = read::<DidChangeTextDocument>(notification) else {
                    return;
                };
                if let Some(document) = self.documents.get_mut(p.text_document.uri.as_str()) {
                    document.change(p.content_changes, p.text_document.version);
                    self.has_changed(p.text_document.uri.as_str().to_owned());
                }
            }
            DidCloseTextDocument::METHOD => {
                let Some(p) = read::<DidCloseTextDocument>(notification) else {
                    return;
                };
                self.documents.remove(p.text_document.uri.as_str());
                self.has_changed(p.text_document.uri.as_str().to_owned());
            }
            DidSaveTextDocument::METHOD => {
                let Some(p) = read::<DidSaveTextDocument>(notification) else {
                    return;
                };
                self.has_changed(p.text_document.uri.as_str().to_owned());
            }
            // `initialized`, `$/cancelRequest`: nothing is to be done.
            _ => {}
        }
    }

    /// Forgets what is known of the document and of those that may import it.
    fn has_changed(&mut self, address: String) {
        for (other, document) in &mut self.documents {
            let depends = *other == address || document.analysis.get().is_some_and(|a| a.has_imports());
            if depends {
                document.analysis.take();
                self.changed.insert(other.clone());
            }
        }
        self.changed.insert(address);
    }

    /// Returns the diagnostics of all documents that have changed; none for those that were closed.
    pub(super) fn publish(&mut self) -> Vec<Message> {
        let changed = std::mem::take(&mut self.changed);
        let message = |address: String| {
            let document = self.documents.get(&address);
            let diagnostics = match document {
                Some(document) if document.is_too_large() => vec![too_large()],
                Some(document) => diagnostics(document, &self.analysis(document)),
                None => Vec::new(),
            };
            let version = document.map(|d| d.version).filter(|_| self.editor.has_versions);
            let uri = Uri::from_str(&address).ok()?;
            let params = PublishDiagnosticsParams::new(uri, diagnostics, version);
            let told = Notification::new(PublishDiagnostics::METHOD.into(), params);
            Some(Message::Notification(told))
        };
        changed.into_iter().filter_map(message).collect()
    }
}

/// Returns the parameters; a notification that can't be read has no answer, and is left out.
fn read<N: Kind>(notification: Notification) -> Option<N::Params> {
    serde_json::from_value(notification.params).ok()
}

fn refused(message: String) -> Refusal {
    Refusal {
        code: ErrorCode::RequestFailed,
        message,
    }
}

/// Answers a request whose parameters are read by its type.
fn answered<R: Method>(request: Request, f: impl FnOnce(R::Params) -> Result<R::Result, Refusal>) -> Response {
    let params = match serde_json::from_value(request.params) {
        Ok(params) => params,
        Err(e) => return Response::new_err(request.id, ErrorCode::InvalidParams as i32, e.to_string()),
    };
    match f(params) {
        Ok(result) => Response::new_ok(request.id, result),
        Err(refusal) => Response::new_err(request.id, refusal.code as i32, refusal.message),
    }
}

fn too_large() -> Diagnostic {
    let message = format!(
        "the file is larger than {} MB and is not looked into here",
        LARGEST >> 20
    );
    Diagnostic {
        source: Some("sgap".into()),
        message,
        ..Diagnostic::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lsp_types::{Position, Range};
    use proptest::prelude::*;
    use serde_json::{Value, json};

    const DOMAIN: &str = include_str!("../../tests/lsp/small.hatp");
    const URI: &str = "file:///a.hatp";

    fn ask(server: &mut Server<'_>, method: &str, params: Value) -> Response {
        let request = Request::new(1.into(), method.into(), params);
        match server.message(Message::Request(request)) {
            Some(Message::Response(response)) => response,
            other => panic!("{method}: {other:?}"),
        }
    }

    fn tell(server: &mut Server<'_>, method: &str, params: Value) {
        assert!(
            server
                .message(Message::Notification(Notification::new(method.into(), params)))
                .is_none()
        );
    }

    struct NoFiles;

    impl Files for NoFiles {
        fn read(&self, _: &str) -> Result<String, String> {
            Err("there is no such file".into())
        }
    }

    fn opened(text: &str) -> Server<'static> {
        let mut server = Server::new(&NoFiles);
        ask(&mut server, "initialize", json!({ "capabilities": {} }));
        let document = json!({ "uri": URI, "languageId": "hatp", "version": 1, "text": text });
        tell(&mut server, "textDocument/didOpen", json!({ "textDocument": document }));
        server
    }

    /// A place in the document or beside it.
    fn position() -> impl Strategy<Value = Position> {
        prop_oneof![
            9 => (0..50_u32, 0..60_u32).prop_map(|(line, character)| Position::new(line, character)),
            1 => Just(Position::new(u32::MAX, u32::MAX)),
        ]
    }

    /// What is put in place of a range: pieces of the language, marks of all sorts, nothing.
    fn piece() -> impl Strategy<Value = String> {
        let words: Vec<String> = DOMAIN
            .split_inclusive([' ', ';', '.', '(', '{'])
            .map(str::to_owned)
            .collect();
        let marks = "{ } ( ) [ ] ; . , : = == >> <<= =>> \" // /* */ 𝄞 é \r\n \r \u{FEFF} NULL SELECT(Cup,{ let 1: action method";
        let marks: Vec<String> = marks.split(' ').map(str::to_owned).collect();
        prop_oneof![
            prop::sample::select(words),
            prop::sample::select(marks),
            Just(String::new()),
            Just("\n".to_owned()),
        ]
    }

    const QUESTIONS: [&str; 10] = [
        "textDocument/formatting",
        "textDocument/hover",
        "textDocument/definition",
        "textDocument/references",
        "textDocument/documentHighlight",
        "textDocument/prepareRename",
        "textDocument/rename",
        "textDocument/completion",
        "textDocument/documentSymbol",
        "textDocument/codeAction",
    ];

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(40))]
        #[test]
        fn any_edits_leave_the_server_alive(
            edits in prop::collection::vec((position(), position(), piece(), position()), 1..10)
        ) {
            let mut server = opened(DOMAIN);
            for (i, (start, end, text, asked)) in edits.into_iter().enumerate() {
                // Most edits are as short as typing is; some begin behind their end.
                let end = if i % 4 == 3 { end } else { Position::new(start.line, start.character.saturating_add(i as u32)) };
                let document = json!({ "uri": URI, "version": i });
                let change = json!([{ "range": Range::new(start, end), "text": text }]);
                tell(&mut server, "textDocument/didChange", json!({ "textDocument": document, "contentChanges": change }));
                for message in server.publish() {
                    let Message::Notification(told) = message else { panic!("{message:?}") };
                    let params: PublishDiagnosticsParams = serde_json::from_value(told.params).expect("diagnostics");
                    for diagnostic in params.diagnostics {
                        prop_assert!(diagnostic.range.start <= diagnostic.range.end);
                    }
                }
                for method in QUESTIONS {
                    let answer = ask(&mut server, method, json!({
                        "textDocument": { "uri": URI },
                        "position": asked,
                        "range": Range::new(start, asked),
                        "newName": "X",
                        "options": { "tabSize": 2, "insertSpaces": true },
                        "context": { "includeDeclaration": true, "diagnostics": [], "triggerKind": 1 },
                    }));
                    let code = answer.error.map(|e| e.code);
                    prop_assert!([None, Some(ErrorCode::RequestFailed as i32)].contains(&code), "{method}: {code:?}");
                }
            }
        }
    }

    #[test]
    fn a_large_document_is_answered_and_not_looked_into() {
        let mut server = opened(&"/".repeat(LARGEST + 1));
        assert_eq!(server.publish().len(), 1);
        let place = json!({ "textDocument": { "uri": URI }, "position": { "line": 0, "character": 5 } });
        assert!(ask(&mut server, "textDocument/hover", place.clone()).error.is_none());
        assert!(ask(&mut server, "textDocument/completion", place).error.is_none());
    }
}
