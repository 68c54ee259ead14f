//! What is answered to which request.

use super::{Answer, read};
use crate::cursor;
use crate::mentions::Mention;
use crate::workspace::Workspace;
use crate::{completion, format, hover, rename, symbols};
use ls_types::{
    CompletionList, CompletionParams, DocumentFormattingParams, DocumentSymbolParams,
    GotoDefinitionParams, Hover, HoverContents, HoverParams, Location, MarkupContent, MarkupKind,
    ReferenceParams, RenameParams, TextDocumentPositionParams, TextEdit, Uri,
};
use lsp_server::ErrorCode;
use prism_lang::names::Role;
use serde::Serialize;
use serde_json::{Map, Value, json};
use std::path::PathBuf;

/// What the server can do, as it is told at the beginning.
pub fn capabilities() -> Value {
    json!({
        "capabilities": {
            "positionEncoding": "utf-16",
            "textDocumentSync": { "openClose": true, "change": 2, "save": true },
            "hoverProvider": true,
            "definitionProvider": true,
            "referencesProvider": true,
            "documentHighlightProvider": true,
            "documentSymbolProvider": true,
            "documentFormattingProvider": true,
            "renameProvider": { "prepareProvider": true },
            "completionProvider": { "triggerCharacters": ["\"", "[", "{", "."] },
        },
        "serverInfo": { "name": "corroborate", "version": env!("CARGO_PKG_VERSION") },
    })
}

/// Answers a request.
pub fn answer(
    workspace: &Workspace,
    document_changes: bool,
    method: &str,
    params: Value,
) -> Answer {
    match method {
        "textDocument/hover" => {
            let params: HoverParams = read(params)?;
            let at = Place::of(workspace, &params.text_document_position_params)?;
            give(hover(workspace, &at))
        }
        "textDocument/definition" => {
            let params: GotoDefinitionParams = read(params)?;
            let at = Place::of(workspace, &params.text_document_position_params)?;
            give(definition(workspace, &at))
        }
        "textDocument/references" => {
            let params: ReferenceParams = read(params)?;
            let at = Place::of(workspace, &params.text_document_position)?;
            let with_definitions = params.context.include_declaration;
            give(references(workspace, &at, with_definitions))
        }
        "textDocument/documentHighlight" => {
            let params: TextDocumentPositionParams = read(params)?;
            let at = Place::of(workspace, &params)?;
            give(highlights(workspace, &at))
        }
        "textDocument/documentSymbol" => {
            let params: DocumentSymbolParams = read(params)?;
            let path = Workspace::path(&params.text_document.uri);
            give(symbols::of_file(workspace, &path))
        }
        "textDocument/completion" => {
            let params: CompletionParams = read(params)?;
            let at = Place::of(workspace, &params.text_document_position)?;
            give(CompletionList {
                items: completion::at(workspace, &at.path, at.offset),
                ..CompletionList::default()
            })
        }
        "textDocument/formatting" => {
            let params: DocumentFormattingParams = read(params)?;
            let path = Workspace::path(&params.text_document.uri);
            give(format::edits(workspace, &path).map_err(refused)?)
        }
        "textDocument/prepareRename" => {
            let params: TextDocumentPositionParams = read(params)?;
            let at = Place::of(workspace, &params)?;
            let found = rename::what(workspace, &at.path, at.offset).map_err(refused)?;
            let text = workspace.read(&at.path);
            let range = text.map(|it| it.range(found.span.clone()));
            Ok(json!({ "range": range, "placeholder": found.thing.name() }))
        }
        "textDocument/rename" => {
            let params: RenameParams = read(params)?;
            let at = Place::of(workspace, &params.text_document_position)?;
            renamed(workspace, &at, &params.new_name, document_changes)
        }
        "corroborate/explain" => {
            let code = params.get("code").and_then(Value::as_str).unwrap_or("");
            give(workspace.engine.explanation(code))
        }
        _ => Err((
            ErrorCode::MethodNotFound,
            format!("`{method}` is not known here"),
        )),
    }
}

fn give(result: impl Serialize) -> Answer {
    serde_json::to_value(result).map_err(|error| (ErrorCode::InternalError, error.to_string()))
}

fn refused(reason: String) -> (ErrorCode, String) {
    (ErrorCode::RequestFailed, reason)
}

/// A place in a document.
struct Place {
    path: PathBuf,
    offset: usize,
}

impl Place {
    fn of(
        workspace: &Workspace,
        at: &TextDocumentPositionParams,
    ) -> Result<Self, (ErrorCode, String)> {
        let path = Workspace::path(&at.text_document.uri);
        let missing = || {
            let name = at.text_document.uri.as_str();
            (
                ErrorCode::InvalidParams,
                format!("{name} is not open and cannot be read"),
            )
        };
        let text = workspace.read(&path).ok_or_else(missing)?;
        let offset = text.offset(at.position);
        Ok(Self { path, offset })
    }
}

fn hover(workspace: &Workspace, at: &Place) -> Option<Hover> {
    let shown = hover::at(workspace, &at.path, at.offset)?;
    let text = workspace.read(&at.path)?;
    Some(Hover {
        contents: HoverContents::Markup(MarkupContent {
            kind: MarkupKind::Markdown,
            value: shown.text,
        }),
        range: Some(text.range(shown.span)),
    })
}

fn location(workspace: &Workspace, it: &Mention) -> Option<Location> {
    let uri: Uri = workspace.uri(&it.path)?;
    let text = workspace.read(&it.path)?;
    Some(Location::new(uri, text.range(it.span.clone())))
}

fn locations(workspace: &Workspace, mentions: &[Mention]) -> Vec<Location> {
    let all = mentions.iter().filter_map(|it| location(workspace, it));
    all.collect()
}

fn definition(workspace: &Workspace, at: &Place) -> Vec<Location> {
    let here = cursor::at(workspace, &at.path, at.offset);
    let found = here
        .iter()
        .flat_map(|it| cursor::definitions(workspace, &it.thing, &at.path));
    let mut found: Vec<Mention> = found.collect();
    found.dedup();
    locations(workspace, &found)
}

fn references(workspace: &Workspace, at: &Place, with_definitions: bool) -> Vec<Location> {
    let here = cursor::at(workspace, &at.path, at.offset);
    let found = here
        .iter()
        .flat_map(|it| cursor::places(workspace, &it.thing, &at.path));
    let found = found.filter(|it| with_definitions || it.role != Role::Definition);
    let mut found: Vec<Mention> = found.collect();
    found.dedup_by(|a, b| a.path == b.path && a.span == b.span);
    locations(workspace, &found)
}

fn highlights(workspace: &Workspace, at: &Place) -> Vec<Value> {
    let here = cursor::at(workspace, &at.path, at.offset);
    let Some(text) = workspace.read(&at.path) else {
        return Vec::new();
    };
    let all = cursor::in_file(workspace, &at.path).into_iter();
    let same = all.filter(|it| here.iter().any(|wanted| wanted.thing == it.thing));
    same.map(|it| {
        let kind = if it.role == Role::Assignment { 3 } else { 2 };
        json!({ "range": text.range(it.span), "kind": kind })
    })
    .collect()
}

fn renamed(workspace: &Workspace, at: &Place, new: &str, document_changes: bool) -> Answer {
    let replaced = rename::rename(workspace, &at.path, at.offset, new).map_err(refused)?;
    let (mut changes, mut documents) = (Map::new(), Vec::new());
    for (path, places) in replaced {
        let (Some(uri), Some(text)) = (workspace.uri(&path), workspace.read(&path)) else {
            return Err(refused(format!(
                "{} cannot be named to the editor",
                path.display()
            )));
        };
        let mut places = places;
        places.sort_by_key(|it| it.start);
        places.dedup();
        let edits = places.into_iter();
        let edits: Vec<TextEdit> = edits
            .map(|it| TextEdit::new(text.range(it), new.to_owned()))
            .collect();
        let version = workspace.document(&path).map(|it| it.version);
        documents
            .push(json!({ "textDocument": { "uri": uri, "version": version }, "edits": edits }));
        changes.insert(uri.as_str().to_owned(), json!(edits));
    }
    Ok(match document_changes {
        true => json!({ "documentChanges": documents }),
        false => json!({ "changes": changes }),
    })
}
