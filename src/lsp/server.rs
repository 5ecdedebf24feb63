//! The loop: messages in, answers out; documents are looked at when the queue is empty or somebody asks.

use std::collections::{BTreeMap, BTreeSet};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::rc::Rc;

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
    ClientCapabilities, CodeActionKind, CodeActionOptions, CodeActionOrCommand, CodeActionProviderCapability,
    CodeActionResponse, CompletionOptions, CompletionResponse, Diagnostic, DocumentSymbolResponse,
    GotoDefinitionResponse, HoverProviderCapability, InitializeParams, InitializeResult, OneOf,
    OptionalVersionedTextDocumentIdentifier, PositionEncodingKind, PrepareRenameResponse, PublishDiagnosticsParams,
    RenameOptions, ServerCapabilities, ServerInfo, TextDocumentEdit, TextDocumentPositionParams,
    TextDocumentSyncCapability, TextDocumentSyncKind, TextDocumentSyncOptions, TextDocumentSyncSaveOptions, TextEdit,
    Uri, WorkDoneProgressOptions, WorkspaceEdit,
};

use super::analysis::Analysis;
use super::completion::completion;
use super::diagnostics::diagnostics;
use super::document::{Document, LARGEST};
use super::place::path_of;
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
    documents: BTreeMap<Uri, Document>,
    /// Documents whose diagnostics are to be sent.
    changed: BTreeSet<Uri>,
    editor: Editor,
}

/// What the editor can do.
#[derive(Debug, Clone, Copy, Default)]
struct Editor {
    has_snippets: bool,
    has_document_changes: bool,
    has_versions: bool,
}

/// Why a request has no result.
struct Refusal {
    code: ErrorCode,
    message: String,
}

/// The files as the editor has them: what is open hides what is on the disk.
struct Overlay<'a> {
    documents: &'a BTreeMap<Uri, Document>,
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
                self.at(&at, |_, document, analysis| {
                    hover::hover(document, analysis, at.position)
                })
            }),
            GotoDefinition::METHOD => answered::<GotoDefinition>(request, |p| {
                let at = p.text_document_position_params;
                self.at(&at, |uri, document, analysis| {
                    let found = navigate::definition(uri, document, analysis, at.position);
                    found.map(GotoDefinitionResponse::Scalar)
                })
            }),
            References::METHOD => answered::<References>(request, |p| {
                let (at, with_declaration) = (p.text_document_position, p.context.include_declaration);
                self.at(&at, |uri, document, analysis| {
                    navigate::references(uri, document, analysis, at.position, with_declaration)
                })
            }),
            DocumentHighlightRequest::METHOD => answered::<DocumentHighlightRequest>(request, |p| {
                let at = p.text_document_position_params;
                self.at(&at, |_, document, analysis| {
                    navigate::highlights(document, analysis, at.position)
                })
            }),
            PrepareRenameRequest::METHOD => answered::<PrepareRenameRequest>(request, |at| {
                self.at(&at, |_, document, analysis| {
                    rename::prepare(document, analysis, at.position)
                })?
                .map(|range| Some(PrepareRenameResponse::Range(range)))
                .map_err(refused)
            }),
            Rename::METHOD => answered::<Rename>(request, |p| {
                let at = p.text_document_position;
                let files = self.overlay();
                self.at(&at, |uri, document, analysis| {
                    let edits = rename::rename(document, analysis, at.position, &p.new_name, &files)?;
                    Ok(Some(editor.workspace_edit(uri, document, edits)))
                })?
                .map_err(refused)
            }),
            Completion::METHOD => answered::<Completion>(request, |p| {
                let at = p.text_document_position;
                self.at(&at, |_, document, analysis| {
                    let items = completion(document, analysis, at.position, editor.has_snippets);
                    Some(CompletionResponse::Array(items))
                })
            }),
            Formatting::METHOD => answered::<Formatting>(request, |p| {
                self.document(&p.text_document.uri, |_, document, analysis| {
                    formatting::formatting(document, analysis)
                })
            }),
            DocumentSymbolRequest::METHOD => answered::<DocumentSymbolRequest>(request, |p| {
                self.document(&p.text_document.uri, |_, document, analysis| {
                    Some(DocumentSymbolResponse::Nested(outline::outline(document, analysis)))
                })
            }),
            CodeActionRequest::METHOD => answered::<CodeActionRequest>(request, |p| {
                self.document(&p.text_document.uri, |uri, document, analysis| {
                    let wrap = |uri: &Uri, document: &Document, edits| editor.workspace_edit(uri, document, edits);
                    let fixes = fixes::fixes(uri, document, analysis, p.range, wrap);
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

    fn at<T>(
        &self,
        at: &TextDocumentPositionParams,
        f: impl FnOnce(&Uri, &Document, &Analysis) -> T,
    ) -> Result<T, Refusal> {
        self.document(&at.text_document.uri, f)
    }

    /// Asks about an open document.
    fn document<T>(&self, uri: &Uri, f: impl FnOnce(&Uri, &Document, &Analysis) -> T) -> Result<T, Refusal> {
        let document = self.documents.get(uri).ok_or_else(|| Refusal {
            code: ErrorCode::InvalidParams,
            message: "the document is not open".into(),
        })?;
        Ok(f(uri, document, &self.analysis(document)))
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
                let uri = p.text_document.uri;
                let path = path_of(&uri).unwrap_or_else(|| uri.as_str().to_owned());
                let opened = Document::new(path, p.text_document.text, p.text_document.version);
                self.documents.insert(uri.clone(), opened);
                self.has_changed(uri);
            }
            DidChangeTextDocument::METHOD => {
                let Some(p) = read::<DidChangeTextDocument>(notification) else {
                    return;
                };
                if let Some(document) = self.documents.get_mut(&p.text_document.uri) {
                    document.change(p.content_changes, p.text_document.version);
                    self.has_changed(p.text_document.uri);
                }
            }
            DidCloseTextDocument::METHOD => {
                let Some(p) = read::<DidCloseTextDocument>(notification) else {
                    return;
                };
                self.documents.remove(&p.text_document.uri);
                self.has_changed(p.text_document.uri);
            }
            DidSaveTextDocument::METHOD => {
                let Some(p) = read::<DidSaveTextDocument>(notification) else {
                    return;
                };
                self.has_changed(p.text_document.uri);
            }
            // `initialized`, `$/cancelRequest`: nothing is to be done.
            _ => {}
        }
    }

    /// Forgets what is known of the document and of those that may import it.
    fn has_changed(&mut self, uri: Uri) {
        for (other, document) in &mut self.documents {
            let depends = *other == uri || document.analysis.get().is_some_and(|a| a.has_imports());
            if depends {
                document.analysis.take();
                self.changed.insert(other.clone());
            }
        }
        self.changed.insert(uri);
    }

    /// Returns the diagnostics of all documents that have changed; none for those that were closed.
    pub(super) fn publish(&mut self) -> Vec<Message> {
        let changed = std::mem::take(&mut self.changed);
        let message = |uri: Uri| {
            let version = self.documents.get(&uri).map(|d| d.version);
            let diagnostics = match self.documents.get(&uri) {
                Some(document) if document.is_too_large() => vec![too_large()],
                Some(document) => diagnostics(&uri, document, &self.analysis(document)),
                None => Vec::new(),
            };
            let version = version.filter(|_| self.editor.has_versions);
            let params = PublishDiagnosticsParams::new(uri, diagnostics, version);
            Message::Notification(Notification::new(PublishDiagnostics::METHOD.into(), params))
        };
        changed.into_iter().map(message).collect()
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

impl Editor {
    fn of(capabilities: &ClientCapabilities) -> Self {
        let text = capabilities.text_document.as_ref();
        let completion = text.and_then(|t| t.completion.as_ref());
        let item = completion.and_then(|c| c.completion_item.as_ref());
        let diagnostics = text.and_then(|t| t.publish_diagnostics.as_ref());
        let workspace = capabilities.workspace.as_ref();
        let edit = workspace.and_then(|w| w.workspace_edit.as_ref());
        Editor {
            has_snippets: item.and_then(|i| i.snippet_support) == Some(true),
            has_document_changes: edit.and_then(|e| e.document_changes) == Some(true),
            has_versions: diagnostics.and_then(|d| d.version_support) == Some(true),
        }
    }

    /// Returns changes of one document: with its version for editors that look at it.
    #[expect(
        clippy::mutable_key_type,
        reason = "the protocol's own map; its key caches what it was parsed to"
    )]
    fn workspace_edit(self, uri: &Uri, document: &Document, edits: Vec<TextEdit>) -> WorkspaceEdit {
        if !self.has_document_changes {
            return WorkspaceEdit::new([(uri.clone(), edits)].into());
        }
        let change = TextDocumentEdit {
            text_document: OptionalVersionedTextDocumentIdentifier {
                uri: uri.clone(),
                version: Some(document.version),
            },
            edits: edits.into_iter().map(OneOf::Left).collect(),
        };
        WorkspaceEdit {
            document_changes: Some(lsp_types::DocumentChanges::Edits(vec![change])),
            ..WorkspaceEdit::default()
        }
    }
}

fn capabilities() -> ServerCapabilities {
    ServerCapabilities {
        position_encoding: Some(PositionEncodingKind::UTF16),
        text_document_sync: Some(TextDocumentSyncCapability::Options(TextDocumentSyncOptions {
            open_close: Some(true),
            change: Some(TextDocumentSyncKind::INCREMENTAL),
            save: Some(TextDocumentSyncSaveOptions::Supported(true)),
            ..TextDocumentSyncOptions::default()
        })),
        document_formatting_provider: Some(OneOf::Left(true)),
        hover_provider: Some(HoverProviderCapability::Simple(true)),
        definition_provider: Some(OneOf::Left(true)),
        references_provider: Some(OneOf::Left(true)),
        document_highlight_provider: Some(OneOf::Left(true)),
        document_symbol_provider: Some(OneOf::Left(true)),
        rename_provider: Some(OneOf::Right(RenameOptions {
            prepare_provider: Some(true),
            work_done_progress_options: WorkDoneProgressOptions::default(),
        })),
        completion_provider: Some(CompletionOptions {
            trigger_characters: Some(vec![".".into()]),
            ..CompletionOptions::default()
        }),
        code_action_provider: Some(CodeActionProviderCapability::Options(CodeActionOptions {
            code_action_kinds: Some(vec![CodeActionKind::QUICKFIX]),
            ..CodeActionOptions::default()
        })),
        ..ServerCapabilities::default()
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
