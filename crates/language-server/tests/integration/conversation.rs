//! The protocol, over streams in memory.

use language_server::{Alone, Ended, Engine, Mistakes, serve};
use serde_json::{Value, json};
use std::io::{BufReader, Read};
use std::sync::mpsc::{Receiver, Sender, channel};
use study::Study;

/// What a client writes, as a stream that ends when the client does.
struct Pipe {
    receiver: Receiver<Vec<u8>>,
    rest: Vec<u8>,
}

impl Read for Pipe {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        if self.rest.is_empty() {
            match self.receiver.recv() {
                Ok(bytes) => self.rest = bytes,
                Err(_) => return Ok(0),
            }
        }
        let count = buffer.len().min(self.rest.len());
        buffer[..count].copy_from_slice(&self.rest[..count]);
        self.rest.drain(..count);
        Ok(count)
    }
}

/// Says all messages at once, and gives how the server ended and all that it said.
fn talk(messages: &[Value]) -> (Ended, Vec<Value>) {
    talk_to(messages, || Box::new(Alone))
}

fn talk_to(messages: &[Value], engine: fn() -> Box<dyn Engine>) -> (Ended, Vec<Value>) {
    let (sender, receiver): (Sender<Vec<u8>>, _) = channel();
    for message in messages {
        let text = message.to_string();
        let framed = format!("Content-Length: {}\r\n\r\n{text}", text.len());
        sender.send(framed.into_bytes()).expect("taken");
    }
    drop(sender);
    let input = BufReader::new(Pipe {
        receiver,
        rest: Vec::new(),
    });
    let mut output = Vec::new();
    let ended = serve(input, &mut output, engine()).expect("an end");
    (ended, unframed(&output))
}

fn unframed(bytes: &[u8]) -> Vec<Value> {
    let text = std::str::from_utf8(bytes).expect("UTF-8");
    let mut found = Vec::new();
    let mut rest = text;
    while let Some((head, body)) = rest.split_once("\r\n\r\n") {
        let length = head
            .trim_start_matches("Content-Length: ")
            .parse::<usize>()
            .expect("a length");
        found.push(serde_json::from_str(&body[..length]).expect("JSON"));
        rest = &body[length..];
    }
    found
}

fn request(id: i32, method: &str, params: Value) -> Value {
    json!({ "jsonrpc": "2.0", "id": id, "method": method, "params": params })
}

fn note(method: &str, params: Value) -> Value {
    json!({ "jsonrpc": "2.0", "method": method, "params": params })
}

fn begin() -> Vec<Value> {
    vec![
        request(1, "initialize", json!({ "capabilities": {} })),
        note("initialized", json!({})),
    ]
}

fn opened(text: &str) -> Value {
    note(
        "textDocument/didOpen",
        json!({ "textDocument": { "uri": "file:///m/m.prism", "languageId": "prism", "version": 1, "text": text } }),
    )
}

fn at(line: u32, character: u32) -> Value {
    json!({ "textDocument": { "uri": "file:///m/m.prism" }, "position": { "line": line, "character": character } })
}

fn end() -> [Value; 2] {
    [
        request(99, "shutdown", Value::Null),
        note("exit", Value::Null),
    ]
}

fn answer(said: &[Value], id: i32) -> &Value {
    let found = said
        .iter()
        .find(|it| it["id"] == id && it.get("method").is_none());
    found.unwrap_or_else(|| panic!("no answer {id} in {said:#?}"))
}

#[test]
fn a_model_is_opened_changed_asked_and_closed() {
    let mut messages = begin();
    messages.extend([
        opened("dtmc // é𝄞\nmodule m x : bool; [] z -> true; endmodule"),
        note("textDocument/didChange", json!({
            "textDocument": { "uri": "file:///m/m.prism", "version": 2 },
            "contentChanges": [{ "range": { "start": { "line": 1, "character": 22 }, "end": { "line": 1, "character": 23 } }, "text": "x" }],
        })),
        request(2, "textDocument/hover", at(1, 9)),
        request(3, "textDocument/rename", { let mut it = at(1, 9); it["newName"] = json!("up"); it }),
        request(4, "textDocument/formatting", json!({ "textDocument": { "uri": "file:///m/m.prism" }, "options": { "tabSize": 2, "insertSpaces": true } })),
        request(5, "textDocument/documentSymbol", json!({ "textDocument": { "uri": "file:///m/m.prism" } })),
        request(6, "textDocument/documentHighlight", at(1, 9)),
        note("textDocument/didClose", json!({ "textDocument": { "uri": "file:///m/m.prism" } })),
    ]);
    messages.extend(end());
    let (ended, said) = talk(&messages);
    assert_eq!(ended, Ended::AsAsked);
    assert_eq!(
        answer(&said, 1)["result"]["capabilities"]["renameProvider"]["prepareProvider"],
        true
    );
    let hover = answer(&said, 2)["result"]["contents"]["value"]
        .as_str()
        .expect("said");
    assert!(hover.contains("of module `m`"), "{hover}");
    let edits = answer(&said, 3)["result"]["changes"]["file:///m/m.prism"]
        .as_array()
        .expect("edits");
    assert_eq!(edits.len(), 2);
    let formatted = answer(&said, 4)["result"][0]["newText"]
        .as_str()
        .expect("a text");
    assert!(formatted.starts_with("dtmc // é𝄞\n"), "{formatted}");
    assert_eq!(answer(&said, 5)["result"][0]["name"], "m");
    assert_eq!(answer(&said, 6)["result"].as_array().map(Vec::len), Some(2));
    assert!(answer(&said, 99)["result"].is_null());
    // All came at once: the mistake of the first version was gone before anything was said of it.
    let told = said
        .iter()
        .filter(|it| it["method"] == "textDocument/publishDiagnostics");
    assert!(
        told.clone()
            .all(|it| it["params"]["diagnostics"] == json!([])),
        "{said:#?}"
    );
}

#[test]
fn what_is_not_understood_is_answered_and_the_server_goes_on() {
    let mut messages = vec![request(7, "textDocument/hover", at(0, 0))];
    messages.extend(begin());
    messages.extend([
        request(2, "no/such", Value::Null),
        request(3, "textDocument/hover", json!({ "nothing": 1 })),
        request(4, "textDocument/hover", at(0, 0)),
        note("textDocument/didChange", json!(7)),
        note("no/such", json!(7)),
        json!({ "jsonrpc": "2.0", "id": 5, "result": null }),
        request(6, "textDocument/rename", {
            let mut it = at(0, 0);
            it["newName"] = json!("x");
            it
        }),
    ]);
    messages.extend(end());
    let (ended, said) = talk(&messages);
    assert_eq!(ended, Ended::AsAsked);
    let code = |id: i32| answer(&said, id)["error"]["code"].as_i64();
    assert_eq!(
        (code(7), code(2), code(3), code(4), code(6)),
        (
            Some(-32002),
            Some(-32601),
            Some(-32602),
            Some(-32602),
            Some(-32602)
        )
    );
}

#[test]
fn a_cancelled_request_is_answered_as_cancelled() {
    let mut messages = begin();
    messages.push(opened("dtmc"));
    messages.push(request(2, "textDocument/hover", at(0, 0)));
    messages.push(note("$/cancelRequest", json!({ "id": 2 })));
    messages.extend(end());
    let (_, said) = talk(&messages);
    // Whether the cancellation was read in time is a race, which either answer ends.
    let hover = answer(&said, 2);
    assert!(
        hover["error"]["code"] == -32800 || hover.get("result").is_some(),
        "{hover}"
    );
}

#[test]
fn the_server_ends_with_its_stream_and_says_how() {
    let (ended, _) = talk(&begin());
    assert_eq!(ended, Ended::Abruptly);
    let mut messages = begin();
    messages.push(note("exit", Value::Null));
    assert_eq!(talk(&messages).0, Ended::Abruptly);
    assert_eq!(talk(&[]).0, Ended::Abruptly);
    let (ended, said) = talk(&[
        begin()[0].clone(),
        end()[0].clone(),
        request(3, "textDocument/hover", at(0, 0)),
        end()[1].clone(),
    ]);
    assert_eq!(ended, Ended::AsAsked);
    assert_eq!(answer(&said, 3)["error"]["code"], -32600);
}

/// An engine that fails.
struct Panics;

impl Engine for Panics {
    fn mistakes(&self, _: &Study, _: Vec<diagnostic::Source>, _: bool) -> Mistakes {
        Mistakes::default()
    }

    fn schemas(&self) -> Vec<(&'static str, Value)> {
        Vec::new()
    }

    fn explanation(&self, _: &str) -> Option<String> {
        panic!("a bug")
    }
}

#[test]
fn a_request_that_panics_is_an_internal_error_and_the_next_is_answered() {
    let mut messages = begin();
    messages.push(opened("dtmc const int n = 1;"));
    messages.push(request(
        2,
        "corroborate/explain",
        json!({ "code": "syntax" }),
    ));
    messages.push(request(3, "textDocument/hover", at(0, 15)));
    messages.extend(end());
    let (ended, said) = talk_to(&messages, || Box::new(Panics));
    assert_eq!(ended, Ended::AsAsked);
    assert_eq!(answer(&said, 2)["error"]["code"], -32603);
    let hover = answer(&said, 3)["result"]["contents"]["value"]
        .as_str()
        .expect("said");
    assert!(hover.contains("value: 1"), "{hover}");
}
