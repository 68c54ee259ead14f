//! The conversation with an editor: requests answered in their order, one after another.
//!
//! What the editor sends is read by a thread of its own into a queue, so that a request that is cancelled while it waits is
//! answered as cancelled, and that texts are judged once for several changes. A request that panics is answered as an internal
//! error, and the server goes on.

mod answers;

use crate::diagnostics::{self, Telling};
use crate::frame::{self, Frame};
use crate::text::Text;
use crate::workspace::{Document, Engine, Workspace};
use ls_types::{
    Diagnostic, DidChangeTextDocumentParams, DidCloseTextDocumentParams, DidOpenTextDocumentParams,
    InitializeParams, PublishDiagnosticsParams,
};
use lsp_server::{ErrorCode, Message, Notification, Request, RequestId, Response};
use serde::de::DeserializeOwned;
use serde_json::{Value, json};
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::io::{self, BufRead, Write};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::rc::Rc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::Duration;

/// How the conversation ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// The editor asked for it: `shutdown`, then `exit`.
    AsAsked,
    /// The editor said `exit` without `shutdown`, or its stream ended.
    Abruptly,
}

/// Answers an editor until it says `exit` or its stream ends.
///
/// # Errors
/// Those of the streams, and a header without a length.
pub fn serve(
    input: impl BufRead + Send + 'static,
    output: impl Write,
    engine: Box<dyn Engine>,
) -> io::Result<Ended> {
    let (sender, receiver) = channel();
    // It ends with the stream, or with the process: reading cannot be interrupted.
    std::thread::spawn(move || read_all(input, &sender));
    Server::new(output, engine, receiver).run()
}

/// Reads messages until there are none, or nobody takes them.
fn read_all(mut input: impl BufRead, queue: &Sender<io::Result<Frame>>) {
    loop {
        let (read, is_last) = match frame::read(&mut input) {
            Ok(Some(frame)) => (Ok(frame), false),
            Ok(None) => return,
            Err(error) => (Err(error), true),
        };
        if queue.send(read).is_err() || is_last {
            return;
        }
    }
}

/// One conversation.
struct Server<W> {
    output: W,
    incoming: Receiver<io::Result<Frame>>,
    waiting: VecDeque<Message>,
    workspace: Workspace,
    telling: Telling,
    /// Open files whose diagnostics are to be told anew.
    changed: BTreeSet<PathBuf>,
    /// Files of which something was told that may have to be taken back.
    told: BTreeSet<PathBuf>,
    is_initialized: bool,
    is_shut_down: bool,
    next_request: i32,
    /// Messages that came before what has changed was judged.
    put_off: u32,
    can_watch: bool,
    takes_document_changes: bool,
}

/// How long nothing has to come for what has changed to be judged.
const QUIET: Duration = Duration::from_millis(20);
/// After so many messages it is judged all the same.
const MOST_PUT_OFF: u32 = 50;

type Answer = Result<Value, (ErrorCode, String)>;

impl<W: Write> Server<W> {
    fn new(output: W, engine: Box<dyn Engine>, incoming: Receiver<io::Result<Frame>>) -> Self {
        Self {
            output,
            incoming,
            waiting: VecDeque::new(),
            workspace: Workspace::new(engine),
            telling: Telling::default(),
            changed: BTreeSet::new(),
            told: BTreeSet::new(),
            is_initialized: false,
            is_shut_down: false,
            next_request: 1,
            put_off: 0,
            can_watch: false,
            takes_document_changes: false,
        }
    }

    fn run(mut self) -> io::Result<Ended> {
        while let Some(message) = self.next()? {
            match message {
                Message::Request(request) => self.request(request)?,
                Message::Notification(it) if it.method == "exit" => {
                    return Ok(match self.is_shut_down {
                        true => Ended::AsAsked,
                        false => Ended::Abruptly,
                    });
                }
                Message::Notification(it) => self.notification(it)?,
                // Answers to what was registered.
                Message::Response(_) => {}
            }
            self.put_off += u32::from(!self.changed.is_empty());
            if self.put_off > MOST_PUT_OFF {
                self.tell_changed()?;
            }
        }
        Ok(Ended::Abruptly)
    }

    /// The next message; waits for it. `None` at the stream's end. What has changed is judged once the editor is quiet: what it
    /// asks behind a keystroke is answered first.
    fn next(&mut self) -> io::Result<Option<Message>> {
        while self.waiting.is_empty() {
            let frame = match self.changed.is_empty() {
                true => self.incoming.recv().map_err(RecvTimeoutError::from),
                false => self.incoming.recv_timeout(QUIET),
            };
            match frame {
                Ok(frame) => self.take(frame)?,
                Err(RecvTimeoutError::Timeout) => self.tell_changed()?,
                Err(RecvTimeoutError::Disconnected) => {
                    self.tell_changed()?;
                    return Ok(None);
                }
            }
        }
        Ok(self.waiting.pop_front())
    }

    fn take_what_waits(&mut self) -> io::Result<()> {
        while let Ok(frame) = self.incoming.try_recv() {
            self.take(frame)?;
        }
        Ok(())
    }

    fn take(&mut self, frame: io::Result<Frame>) -> io::Result<()> {
        match frame? {
            Frame::Message(message) => self.waiting.push_back(*message),
            Frame::Unreadable(reason) => {
                let code = ErrorCode::ParseError as i32;
                let error = json!({ "jsonrpc": "2.0", "id": null, "error": { "code": code, "message": reason } });
                let text = error.to_string();
                write!(self.output, "Content-Length: {}\r\n\r\n{text}", text.len())?;
                self.output.flush()?;
            }
        }
        Ok(())
    }

    fn send(&mut self, message: impl Into<Message>) -> io::Result<()> {
        frame::write(&mut self.output, &message.into())
    }

    fn request(&mut self, request: Request) -> io::Result<()> {
        let Request { id, method, params } = request;
        self.take_what_waits()?;
        let answer = if self.is_cancelled(&id) {
            Err((ErrorCode::RequestCanceled, "cancelled".to_owned()))
        } else if self.is_shut_down {
            Err((
                ErrorCode::InvalidRequest,
                "the server was shut down".to_owned(),
            ))
        } else if method == "initialize" {
            self.initialize(params)
        } else if !self.is_initialized {
            Err((
                ErrorCode::ServerNotInitialized,
                "`initialize` comes first".to_owned(),
            ))
        } else if method == "shutdown" {
            self.is_shut_down = true;
            Ok(Value::Null)
        } else {
            self.guarded(&method, params)
        };
        let response = match answer {
            Ok(result) => Response::new_ok(id, result),
            Err((code, message)) => Response::new_err(id, code as i32, message),
        };
        self.send(response)
    }

    /// Whether the editor has taken a request back while it waited.
    fn is_cancelled(&self, id: &RequestId) -> bool {
        self.waiting.iter().any(|message| match message {
            Message::Notification(it) if it.method == "$/cancelRequest" => {
                let cancelled = it.params.get("id").cloned();
                let cancelled = cancelled.and_then(|it| serde_json::from_value(it).ok());
                cancelled.is_some_and(|it: RequestId| it == *id)
            }
            _ => false,
        })
    }

    fn guarded(&mut self, method: &str, params: Value) -> Answer {
        let (workspace, way) = (&self.workspace, self.takes_document_changes);
        let answered = catch_unwind(AssertUnwindSafe(|| {
            answers::answer(workspace, way, method, params)
        }));
        answered.unwrap_or_else(|_| {
            let message = format!("a bug of the server: `{method}` failed");
            Err((ErrorCode::InternalError, message))
        })
    }

    fn initialize(&mut self, params: Value) -> Answer {
        if self.is_initialized {
            return Err((ErrorCode::InvalidRequest, "initialized already".to_owned()));
        }
        let params: InitializeParams = read(params)?;
        self.is_initialized = true;
        let scheme = params.initialization_options.as_ref();
        let scheme = scheme.and_then(|it| it.get("explainScheme")?.as_str());
        self.telling.explain_scheme = scheme.map(str::to_owned);
        let workspace = params.capabilities.workspace.as_ref();
        let edit = workspace.and_then(|it| it.workspace_edit.as_ref());
        self.takes_document_changes = edit.and_then(|it| it.document_changes) == Some(true);
        let watching = workspace.and_then(|it| it.did_change_watched_files.as_ref());
        self.can_watch = watching.and_then(|it| it.dynamic_registration) == Some(true);
        Ok(answers::capabilities())
    }

    fn notification(&mut self, it: Notification) -> io::Result<()> {
        if !self.is_initialized {
            return Ok(());
        }
        if it.method == "initialized" {
            return self.watch();
        }
        // A change that cannot be read is lost, and so would be all that builds on it: the editor's mistake, which nobody sees.
        let _ = catch_unwind(AssertUnwindSafe(|| self.take_over(&it)));
        Ok(())
    }

    /// Asks to be told of changes outside of the editor.
    fn watch(&mut self) -> io::Result<()> {
        if !self.can_watch {
            return Ok(());
        }
        let patterns = ["**/*.toml", "**/*.{prism,pm,nm,sm,props,prop,pctl,csl,ltl}"];
        let watchers = patterns.map(|it| json!({ "globPattern": it }));
        let params = json!({ "registrations": [{
            "id": "files",
            "method": "workspace/didChangeWatchedFiles",
            "registerOptions": { "watchers": watchers },
        }]});
        let id = RequestId::from(self.next_request);
        self.next_request += 1;
        self.send(Request::new(id, "client/registerCapability".into(), params))
    }

    fn take_over(&mut self, it: &Notification) -> Option<()> {
        let params = it.params.clone();
        match it.method.as_str() {
            "textDocument/didOpen" => {
                let opened: DidOpenTextDocumentParams = serde_json::from_value(params).ok()?;
                let document = opened.text_document;
                let path = Workspace::path(&document.uri);
                let text = Rc::new(Text::new(document.text));
                let document = Document {
                    uri: document.uri,
                    version: document.version,
                    language: document.language_id,
                    text,
                };
                self.set(path, document);
            }
            "textDocument/didChange" => {
                let changed: DidChangeTextDocumentParams = serde_json::from_value(params).ok()?;
                let path = Workspace::path(&changed.text_document.uri);
                let mut document = self.workspace.document(&path)?.clone();
                let mut text = (*document.text).clone();
                changed
                    .content_changes
                    .into_iter()
                    .for_each(|it| text.change(it));
                document.text = Rc::new(text);
                document.version = changed.text_document.version;
                self.set(path, document);
            }
            "textDocument/didClose" => {
                let closed: DidCloseTextDocumentParams = serde_json::from_value(params).ok()?;
                let path = Workspace::path(&closed.text_document.uri);
                self.workspace.close(&path);
                self.all_open_are_changed();
                // What was told of it is taken back.
                self.changed.insert(path);
            }
            "textDocument/didSave" | "workspace/didChangeWatchedFiles" => {
                self.workspace.forget_studies();
                self.all_open_are_changed();
            }
            _ => {}
        }
        Some(())
    }

    fn set(&mut self, path: PathBuf, document: Document) {
        self.workspace.set(path.clone(), document);
        if self.workspace.concerns_a_study(&path) {
            self.all_open_are_changed();
        }
        self.changed.insert(path);
    }

    /// What one file says may be about another.
    fn all_open_are_changed(&mut self) {
        let open = self.workspace.documents().map(|(path, _)| path.clone());
        self.changed.extend(open);
    }

    /// Tells what is wrong with the files that have changed.
    fn tell_changed(&mut self) -> io::Result<()> {
        if self.changed.is_empty() {
            return Ok(());
        }
        self.put_off = 0;
        let changed = std::mem::take(&mut self.changed);
        let mut all = self.judged(&changed);
        let before = std::mem::take(&mut self.told);
        // What was told of files of which nothing is to be said any more is taken back.
        for path in &before {
            let is_open = self.workspace.document(path).is_some();
            if all.contains_key(path) {
                continue;
            }
            if is_open && !changed.contains(path) {
                self.told.insert(path.clone());
            } else {
                all.insert(path.clone(), Vec::new());
            }
        }
        for (path, found) in all {
            let document = self.workspace.document(&path);
            let version = document.map(|it| it.version);
            let is_news = !found.is_empty() || document.is_some() || before.contains(&path);
            let Some(uri) = self.workspace.uri(&path).filter(|_| is_news) else {
                continue;
            };
            if !found.is_empty() || document.is_some() {
                self.told.insert(path);
            }
            let params = PublishDiagnosticsParams::new(uri, found, version);
            let method = "textDocument/publishDiagnostics".to_owned();
            self.send(Notification::new(method, params))?;
        }
        Ok(())
    }

    /// What is wrong with these files, and with those that are judged with them. What comes by two ways is said once.
    fn judged(&self, changed: &BTreeSet<PathBuf>) -> BTreeMap<PathBuf, Vec<Diagnostic>> {
        let mut all: BTreeMap<PathBuf, Vec<Diagnostic>> = BTreeMap::new();
        let is_open = |path: &&PathBuf| self.workspace.document(path).is_some();
        for path in changed.iter().filter(is_open) {
            let judged = catch_unwind(AssertUnwindSafe(|| {
                diagnostics::of_file(&self.workspace, path, &self.telling)
            }));
            for (file, found) in judged.unwrap_or_default() {
                let known = all.entry(file).or_default();
                for it in found {
                    if !known.contains(&it) {
                        known.push(it);
                    }
                }
            }
        }
        all
    }
}

/// Reads parameters.
fn read<T: DeserializeOwned>(params: Value) -> Result<T, (ErrorCode, String)> {
    serde_json::from_value(params).map_err(|error| (ErrorCode::InvalidParams, error.to_string()))
}
