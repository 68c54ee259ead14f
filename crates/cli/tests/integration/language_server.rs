//! `corroborate language-server`, as an editor starts it.

use crate::support::program::{Study, command};
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Read, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Stdio};

/// An editor that has started the program.
struct Editor {
    program: Child,
    input: ChildStdin,
    output: BufReader<ChildStdout>,
    last: i64,
    /// What was told of each file, by its address.
    told: std::collections::BTreeMap<String, Vec<Value>>,
}

impl Editor {
    fn new(folder: &Path) -> Self {
        let mut command = command(folder, &["language-server", "--stdio"]);
        command.stdin(Stdio::piped()).stdout(Stdio::piped());
        let mut program = command.spawn().expect("the program starts");
        let input = program.stdin.take().expect("its input");
        let output = BufReader::new(program.stdout.take().expect("its output"));
        let mut editor = Self {
            program,
            input,
            output,
            last: 0,
            told: Default::default(),
        };
        editor.ask("initialize", json!({ "capabilities": {} }));
        editor.note("initialized", json!({}));
        editor
    }

    fn say(&mut self, message: Value) {
        let text = message.to_string();
        write!(self.input, "Content-Length: {}\r\n\r\n{text}", text.len()).expect("it listens");
    }

    fn note(&mut self, method: &str, params: Value) {
        self.say(json!({ "jsonrpc": "2.0", "method": method, "params": params }));
    }

    /// Asks, and takes over what is told until the answer comes.
    fn ask(&mut self, method: &str, params: Value) -> Value {
        self.last += 1;
        let id = self.last;
        self.say(json!({ "jsonrpc": "2.0", "id": id, "method": method, "params": params }));
        loop {
            let message = self.hear();
            if message["id"] == id {
                return message;
            }
            self.take(&message);
        }
    }

    fn take(&mut self, message: &Value) {
        if message["method"] == "textDocument/publishDiagnostics" {
            let params = &message["params"];
            let uri = params["uri"].as_str().expect("an address").to_owned();
            let found = params["diagnostics"].as_array().expect("a list").clone();
            self.told.insert(uri, found);
        }
    }

    fn hear(&mut self) -> Value {
        let mut length = 0;
        loop {
            let mut line = String::new();
            assert!(
                self.output.read_line(&mut line).expect("it talks") > 0,
                "it ended"
            );
            match line.trim_end().split_once(": ") {
                Some((_, value)) => length = value.parse().expect("a length"),
                None => break,
            }
        }
        let mut body = vec![0; length];
        self.output.read_exact(&mut body).expect("a message");
        serde_json::from_slice(&body).expect("JSON")
    }

    fn open(&mut self, uri: &str, text: &str) {
        let document = json!({ "uri": uri, "languageId": "toml", "version": 1, "text": text });
        self.note("textDocument/didOpen", json!({ "textDocument": document }));
    }

    /// What is told of a file once all that was said is taken over.
    fn told(&mut self, uri: &str) -> Vec<Value> {
        // They come once the editor is quiet.
        self.told.remove(uri);
        while !self.told.contains_key(uri) {
            let message = self.hear();
            self.take(&message);
        }
        self.told[uri].clone()
    }

    fn end(mut self) -> i32 {
        self.ask("shutdown", Value::Null);
        self.note("exit", Value::Null);
        drop(self.input);
        self.program.wait().expect("it ends").code().unwrap_or(-1)
    }
}

fn uri(path: &Path) -> String {
    format!("file://{}", path.canonicalize().expect("a path").display())
}

/// A misspelt variable and a misspelt value of the model, which none of the study's models has.
#[test]
fn an_editor_is_told_of_names_that_no_model_has() {
    let study = Study::new();
    let file = study.path("vocabulary.toml");
    let text = std::fs::read_to_string(&file).expect("a text");
    let (key, rest) = text.split_once("model = \"").expect("a binding");
    let (meaning, rest) = rest.split_once('"').expect("its end");
    let (variable, value) = meaning.split_once('=').expect("a comparison");
    let mut editor = Editor::new(study.beside());
    let name = uri(&file);
    editor.open(&name, &text);
    assert!(editor.told(&name).is_empty());
    for (version, wrong) in (2..).zip([
        format!("{variable}x={value}"),
        format!("{variable}={value}x"),
    ]) {
        let changed = format!("{key}model = \"{wrong}\"{rest}");
        let document = json!({ "uri": name, "version": version });
        let changes = json!([{ "text": changed }]);
        editor.note(
            "textDocument/didChange",
            json!({ "textDocument": document, "contentChanges": changes }),
        );
        let told = editor.told(&name);
        assert_eq!(told.len(), 1, "{told:?}");
        study.write("vocabulary.toml", &changed);
        let said = study.run(&["plan", "study"]);
        assert_eq!(said.code, 2, "{said:?}");
        let message = told[0]["message"].as_str().expect("a message");
        let (first, _) = message.split_once('\n').expect("a remedy");
        assert!(
            first.contains("is not declared") && said.talk.contains(first),
            "{message}\n{}",
            said.talk
        );
        assert_eq!(told[0]["severity"], 1);
        let begin = told[0]["range"]["start"]["line"].as_u64().expect("a line");
        assert!(
            said.talk
                .contains(&format!("vocabulary.toml:{}:", begin + 1)),
            "{}",
            said.talk
        );
    }
    assert_eq!(editor.end(), 0);
}

#[test]
fn an_editor_is_told_what_plan_tells() {
    let study = Study::new();
    let file = study.path("vocabulary.toml");
    let text = std::fs::read_to_string(&file).expect("a text");
    // Not a truth value in the model: found only where the vocabulary meets it.
    let (key, rest) = text.split_once("model = \"").expect("a binding");
    let (_, rest) = rest.split_once('"').expect("its end");
    let wrong = format!("{key}model = \"1 + 1\"{rest}");
    let mut editor = Editor::new(study.beside());
    let name = uri(&file);
    editor.open(&name, &wrong);
    let told = editor.told(&name);
    study.write("vocabulary.toml", &wrong);
    let said = study.run(&["plan", "study"]);
    assert_eq!(said.code, 2, "{said:?}");
    assert_eq!(told.len(), 1, "{told:?}");
    let message = told[0]["message"].as_str().expect("a message");
    let (first, remedy) = message.split_once('\n').expect("a remedy");
    assert!(
        said.talk.contains(first) && said.talk.contains(remedy),
        "{message}\n{}",
        said.talk
    );
    let code = told[0]["code"].as_str().expect("a code");
    assert!(said.talk.contains(&format!("[{code}]")), "{}", said.talk);
    let line = told[0]["range"]["start"]["line"].as_u64().expect("a line") + 1;
    assert!(
        said.talk.contains(&format!("vocabulary.toml:{line}:")),
        "{}",
        said.talk
    );
    let change = json!({ "textDocument": { "uri": name, "version": 2 }, "contentChanges": [{ "text": text }] });
    editor.note("textDocument/didChange", change);
    assert!(editor.told(&name).is_empty());
    let hover = json!({ "textDocument": { "uri": name }, "position": { "line": line - 1, "character": 1 } });
    let said = editor.ask("textDocument/hover", hover);
    let shown = said["result"]["contents"]["value"].as_str().expect("said");
    // The key `model`, from the schema that `corroborate schema` shows.
    assert!(
        shown.contains("An expression over the formal model's variables."),
        "{shown}"
    );
    let explained = editor.ask("corroborate/explain", json!({ "code": code }));
    let from_library = study.run(&["explain", code]).out;
    let explained = explained["result"].as_str().expect("a text");
    assert!(from_library.contains(explained), "{explained}");
    assert_eq!(editor.end(), 0);
}

/// Editors end what does not end by itself.
#[cfg(unix)]
#[test]
fn a_signal_ends_it_at_once() {
    use std::os::unix::process::ExitStatusExt;
    let study = Study::new();
    let mut editor = Editor::new(study.beside());
    let name = editor.program.id().to_string();
    let kill = std::process::Command::new("kill")
        .args(["-TERM", &name])
        .status();
    assert!(kill.expect("kill").success());
    assert_eq!(editor.program.wait().expect("it ends").signal(), Some(15));
}

#[test]
fn what_is_typed_at_a_terminal_is_refused_with_a_remedy() {
    let study = Study::new();
    let mut command = command(study.beside(), &["language-server"]);
    command
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    let mut program = command.spawn().expect("the program starts");
    let mut input = program.stdin.take().expect("its input");
    input.write_all(b"help\n\n").expect("it listens");
    drop(input);
    let output = program.wait_with_output().expect("it ends");
    assert_eq!(output.status.code(), Some(2));
    let said = String::from_utf8(output.stderr).expect("text");
    assert!(
        said.contains("editor-lost") && said.contains("let an editor start it"),
        "{said}"
    );
    assert!(output.stdout.is_empty());
}
