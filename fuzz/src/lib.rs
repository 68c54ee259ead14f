//! What must hold of everything that reads foreign bytes, whatever the bytes: it does not panic, it ends, places lie in
//! the text, and what was read can be written and read again.
//!
//! Each function is a fuzzing target (`fuzz_targets/`); the ordinary tests call them too, on the inputs that are kept in
//! `inputs/` and on variations of them (`crates/cli/tests/integration/fuzz_inputs.rs`).

use checker::explore::{ExploreOptions, explore_with};
use language_server::{Alone, Workspace};
use prism_lang::names::Names;
use prism_lang::{
    Constants, Diagnostic, parse_model, parse_properties, resolve, resolve_properties,
};

/// States up to which a model that happens to have a meaning is explored.
const FEW_STATES: usize = 500;

/// Reads a model; if it has a meaning, explores its first states.
pub fn model(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else {
        return;
    };
    let parsed = parse_model(text);
    places_lie_in(text, &parsed.diagnostics);
    names_are_there(text, &Names::of_model(&parsed.tree, text));
    if parsed.has_errors() {
        return;
    }
    let printed = parsed.tree.to_string();
    let again = parse_model(&printed);
    assert!(
        !again.has_errors(),
        "printed, it has errors: {:?}\n{printed}",
        again.diagnostics
    );
    assert_eq!(printed, again.tree.to_string(), "printing twice differs");
    match resolve(&parsed.tree, &Constants::new()) {
        Ok(model) => {
            let limits = ExploreOptions {
                max_states: FEW_STATES,
                ..ExploreOptions::default()
            };
            // Both ends are fine: a state space, or an error that says why not.
            let _ = explore_with::<f64>(&model, limits, &|_| true);
        }
        Err(found) => places_lie_in(text, &found),
    }
}

/// Reads properties of a small model.
pub fn properties(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else {
        return;
    };
    let parsed = parse_properties(text);
    places_lie_in(text, &parsed.diagnostics);
    names_are_there(text, &Names::of_properties(&parsed.tree, text));
    if parsed.has_errors() {
        return;
    }
    let printed = parsed.tree.to_string();
    let again = parse_properties(&printed);
    assert!(
        !again.has_errors(),
        "printed, they have errors: {:?}\n{printed}",
        again.diagnostics
    );
    let small =
        "dtmc const int N; module m x : [0..3] init 0; b : bool; endmodule label \"done\" = x=3;";
    let given = Constants::parse("N=2").expect("constants");
    let model = resolve(&parse_model(small).tree, &given).expect("a model");
    if let Err(found) = resolve_properties(&parsed.tree, &model, &given) {
        places_lie_in(text, &found);
    }
}

/// What names stand where is what is written there.
fn names_are_there(text: &str, names: &Names) {
    for it in names.iter() {
        assert_eq!(it.span.of(text), it.name, "{it:?}");
    }
}

/// What an editor sends, if it begins as a message does; else a text that is opened, by its first byte as one kind of file, and
/// asked about everywhere.
pub fn editor(bytes: &[u8]) {
    if bytes.starts_with(b"Content-Length:") {
        let input = std::io::Cursor::new(bytes.to_vec());
        // Streams that cannot be read are an error, and all others an end.
        let _ = language_server::serve(input, std::io::sink(), Box::new(Alone));
        return;
    }
    let text = String::from_utf8_lossy(bytes);
    let names = [
        "m.prism",
        "m.props",
        "study.toml",
        "vocabulary.toml",
        "requirements.toml",
        "ledger.toml",
    ];
    let which = bytes
        .first()
        .map_or(0, |byte| usize::from(*byte) % names.len());
    let folder = std::path::Path::new("/no-such-folder");
    let mut workspace = Workspace::new(Box::new(Alone));
    workspace.open(&folder.join("study.toml"), "title = \"\"");
    let path = folder.join(names[which]);
    workspace.open(&path, text.clone());
    for offset in (0..=text.len()).step_by(text.len() / 5 + 1) {
        let _ = language_server::hover::at(&workspace, &path, offset);
        let _ = language_server::completion::at(&workspace, &path, offset);
        let _ = language_server::rename::rename(&workspace, &path, offset, "fresh_0");
    }
    let telling = language_server::diagnostics::Telling::default();
    let _ = language_server::diagnostics::of_file(&workspace, &path, &telling);
    let _ = language_server::symbols::of_file(&workspace, &path);
    let _ = language_server::format::edits(&workspace, &path);
}

fn places_lie_in(text: &str, found: &[Diagnostic]) {
    for diagnostic in found {
        let spans = diagnostic.related.iter().map(|(span, _)| *span);
        for span in spans.chain([diagnostic.span]) {
            assert!(span.start <= span.end, "{diagnostic:?}");
            assert!(
                text.get(span.start..span.end).is_some(),
                "not in the text: {diagnostic:?}"
            );
        }
        assert!(!diagnostic.message.is_empty(), "{diagnostic:?}");
    }
}

/// Reads a predicate and binds it to a small trace.
pub fn predicate(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else {
        return;
    };
    let fields = vec![
        trace::Field::enumeration("state", ["carry", "release"]),
        trace::Field::number("speed", "m/s"),
    ];
    let mut small = trace::Trace::new();
    let robot = small.add_channel("/robot", fields).expect("a topic");
    small.channels[robot].push(0.0, &[1.0, 0.5]).expect("a row");
    match trace::Predicate::parse(text) {
        Ok(predicate) => {
            if let Err(error) = predicate.bind(&small) {
                assert!(!error.to_string().is_empty());
            }
        }
        Err(error) => assert!(error.column() <= text.chars().count() + 1, "{error}"),
    }
}

/// Reads a recording; what could be read is written, and comes back the same.
pub fn mcap(bytes: &[u8]) {
    let Ok(outcome) = recording::from_mcap(bytes) else {
        return;
    };
    // What a foreign file holds may be more than we write (infinite numbers, names without a slash).
    let Ok(written) = recording::to_mcap(&outcome.trace) else {
        return;
    };
    let again = recording::from_mcap(&written).expect("what we write, we read");
    assert_eq!(
        again.complete, outcome.trace.complete,
        "whether it was cut short is kept"
    );
    let rewritten = recording::to_mcap(&again.trace).expect("what we read, we write");
    assert!(written == rewritten, "writing again gives other bytes");
}

/// Reads a table, and takes it as a trace.
pub fn csv(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else {
        return;
    };
    match trace::Table::parse("input.csv", text) {
        Ok(table) => {
            if let Err(error) = trace::trace_of_table(&table) {
                assert!(error.to_string().contains("input.csv"), "no place: {error}");
            }
        }
        Err(error) => assert!(error.to_string().contains("input.csv"), "no place: {error}"),
    }
}

/// Reads a recording in each format: it ends, and it counts as complete only if nothing is lost.
pub fn recording(bytes: &[u8]) {
    use recording::Format;
    let formats = [
        Format::Mcap,
        Format::Ros1Bag,
        Format::Rosbag2Database,
        Format::Compressed,
        Format::Csv,
        Format::JsonLines,
    ];
    // What is told to be larger is damage; so memory stays small.
    let options = recording::OpenOptions {
        record_bytes: 1 << 20,
        memory_bytes: 1 << 20,
        ..recording::OpenOptions::default()
    };
    for format in formats {
        match recording::open_bytes(bytes.to_vec(), format, &options) {
            Ok(mut reader) => read_all(&mut *reader),
            Err(error) => assert!(error.to_string().len() > 30, "no sentence: {error}"),
        }
    }
}

fn read_all(reader: &mut dyn recording::Reader) {
    let topics = reader.topics().len();
    loop {
        match reader.next() {
            Ok(Some(message)) => assert!(message.topic.index() < topics, "no such topic"),
            Ok(None) => break,
            Err(error) => {
                assert!(error.to_string().len() > 30, "no sentence: {error}");
                break;
            }
        }
    }
    assert!(
        matches!(reader.next(), Ok(None)),
        "it goes on behind its end"
    );
    assert!(
        !reader.complete() || reader.losses().is_empty(),
        "what is lost does not count"
    );
}

/// Reads a schema, and a message by it: the text of the schema, a zero byte, the bytes of the message.
pub fn message(bytes: &[u8]) {
    use recording::{Dialect, Encoding, Schema};
    let Some(end) = bytes.iter().position(|byte| *byte == 0) else {
        return;
    };
    let (schema, data) = (&bytes[..end], &bytes[end + 1..]);
    let text = String::from_utf8_lossy(schema);
    let structures = [
        (
            recording::parse_msg("p/T", &text, Dialect::Ros2),
            Encoding::Cdr,
        ),
        (
            recording::parse_msg("p/T", &text, Dialect::Ros1),
            Encoding::Ros1,
        ),
        (recording::parse_idl("p/msg/T", &text), Encoding::Cdr),
    ];
    for (read, encoding) in structures {
        if let Ok(structure) = read {
            let mut paths = vec![];
            leaves(&structure, "", &mut paths);
            extract(Schema::Struct(structure), encoding, &paths, data);
        }
    }
    let paths = ["a", "a.b", "a[1]", "length(a)", "a[b='x'].c", "c[a=1]"].map(str::to_owned);
    extract(Schema::Schemaless, Encoding::Json, &paths, data);
    if let Ok(schema) = recording::ProtobufSchema::parse("T", schema) {
        let fields = schema.messages[schema.root].fields.iter();
        let paths: Vec<String> = fields.map(|field| field.name.clone()).collect();
        extract(Schema::Protobuf(schema), Encoding::Protobuf, &paths, data);
    }
}

/// Paths to numbers of a type, arrays by their second element; not all, if there are very many.
fn leaves(message: &recording::MessageType, before: &str, found: &mut Vec<String>) {
    use recording::Type;
    for field in &message.fields {
        let mut path = format!("{before}{}", field.name);
        let mut kind = &field.kind;
        while let Type::Array(element, _) | Type::Sequence(element) = kind {
            path += "[1]";
            kind = element;
        }
        match kind {
            _ if found.len() > 50 => return,
            Type::Struct(inner) => leaves(inner, &format!("{path}."), found),
            _ => found.push(path),
        }
    }
}

fn extract(
    schema: recording::Schema,
    encoding: recording::Encoding,
    paths: &[String],
    data: &[u8],
) {
    let topic = recording::TopicInfo {
        id: recording::TopicId(0),
        name: "/topic".to_owned(),
        type_name: String::new(),
        encoding,
        schema: std::sync::Arc::new(schema),
        message_count: None,
    };
    for path in paths {
        // A name with other signs is no path as it stands.
        let Ok(path) = recording::FieldPath::parse(path) else {
            continue;
        };
        let Ok(mut extractor) = recording::Extractor::new(&topic, &[path]) else {
            continue;
        };
        let mut value = [0.0];
        if let Err(error) = extractor.extract(data, &mut value) {
            assert!(error.offset_in_message <= data.len(), "no place: {error}");
        }
        let _ = extractor.verify(data);
        let _ = extractor.extract_values(data);
    }
}

/// Reads a formula and prints it; then compiles it in both models of time and judges a few samples.
pub fn formula(bytes: &[u8]) {
    use temporal::formula::{FormulaMonitor, Settings, TimeModel, parse};
    let Ok(text) = std::str::from_utf8(bytes) else {
        return;
    };
    let parameters = |name: &str| (name == "release_time").then_some(2.0);
    let parsed = match parse(text, &parameters) {
        Ok(parsed) => parsed,
        Err(error) => {
            assert!(text.get(error.span.clone()).is_some(), "no place: {error}");
            assert!(!error.remedy.is_empty(), "no remedy: {error}");
            return;
        }
    };
    let printed = parsed.to_string();
    let again = parse(&printed, &parameters).expect("what we print, we read");
    assert_eq!(again.to_string(), printed, "printing twice differs");
    for time in [TimeModel::Discrete, TimeModel::Dense] {
        let settings = Settings {
            time,
            ..Settings::default()
        };
        // What would need too much memory is refused.
        let Ok(monitor) = FormulaMonitor::compile(&parsed.formula, &settings) else {
            continue;
        };
        let mut judge = monitor.start();
        for step in 0..5 {
            let atoms: Vec<Option<bool>> = (0..parsed.atoms.len())
                .map(|atom| Some((step + atom) % 3 == 0))
                .collect();
            if judge.step_truth(step as f64, &atoms).is_err() {
                break;
            }
        }
        let _ = judge.finish(true);
    }
}

/// Reads a requirement in structured English, explains and prints it.
pub fn sentence(bytes: &[u8]) {
    use requirement_lang::{Context, explain, parse};
    let Ok(text) = std::str::from_utf8(bytes) else {
        return;
    };
    let parsed = parse(text, &Context::default());
    for diagnostic in &parsed.diagnostics {
        let place = text.get(diagnostic.span.start..diagnostic.span.end);
        assert!(place.is_some(), "not in the text: {diagnostic:?}");
        assert!(!diagnostic.message.is_empty(), "{diagnostic:?}");
    }
    let printed = parsed.tree.to_string();
    let _ = explain(&parsed.tree);
    if parsed.has_errors() {
        return;
    }
    let again = parse(&printed, &Context::default());
    assert!(
        !again.has_errors(),
        "printed, it has errors: {:?}\n{printed}",
        again.diagnostics
    );
    assert_eq!(printed, again.tree.to_string(), "printing twice differs");
}

/// Reads the map from topics to signals; each signal that it names is found in it.
pub fn topic_map(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else {
        return;
    };
    match recording::TopicMap::parse("map.toml", text) {
        Ok(map) => {
            for name in map.signal_names() {
                assert!(map.find(&name).is_some(), "{name} is not found");
            }
        }
        Err(errors) => {
            assert!(!errors.is_empty(), "refused without a reason");
            for error in errors {
                assert!(text.get(error.span.clone()).is_some(), "no place: {error}");
                assert!(error.to_string().contains("map.toml"), "no file: {error}");
            }
        }
    }
}

/// Reads a behaviour tree and writes its model: mistakes have remedies, labels are unique, and the model is one.
pub fn behaviour_tree(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else {
        return;
    };
    let source = diagnostic::Source::new("tree.xml", text);
    let other = diagnostic::Source::new("other.xml", text);
    let read = behaviour_tree::read(&source, None, &mut |_: &str, _: &str| Ok(other.clone()));
    let reading = match read {
        Ok(reading) => reading,
        Err(problem) => {
            assert!(problem.what_to_do().is_some(), "no remedy: {problem:?}");
            return;
        }
    };
    for conditions in [
        behaviour_tree::Conditions::DrawnAgain,
        behaviour_tree::Conditions::Kept,
    ] {
        let options = behaviour_tree::Options {
            conditions,
            ..behaviour_tree::Options::default()
        };
        let model = behaviour_tree::to_prism(&reading.tree, &options);
        let parsed = prism_lang::parse_model(&model.text).into_result();
        let parsed = parsed.unwrap_or_else(|error| panic!("{error:?}\n{}", model.text));
        let names: Vec<&str> = model.constants.iter().map(|it| it.name.as_str()).collect();
        let none = prism_lang::Constants::new();
        prism_lang::resolve_open(&parsed, &none, &none, &names)
            .unwrap_or_else(|error| panic!("{error:?}\n{}", model.text));
    }
}

/// Reads a robot's or scene's description, whose every file is the description itself; what could be read can be posed,
/// written and read again.
pub fn robot(bytes: &[u8]) {
    let Ok(text) = std::str::from_utf8(bytes) else {
        return;
    };
    let mut resolve = |_: &str| Ok(bytes.to_vec());
    let loaded = match robot_model::parse("robot.xml", text, &mut resolve) {
        Ok(loaded) => loaded,
        Err(problems) => {
            assert!(!problems.0.is_empty(), "refused without a reason");
            for problem in &problems.0 {
                assert!(!problem.remedy.is_empty(), "no remedy: {problem}");
            }
            return;
        }
    };
    let model = &loaded.model;
    let poses = model
        .poses(&model.reference_positions())
        .expect("its own positions");
    assert_eq!(poses.len(), model.links.len());
    // Two things of one name cannot be written.
    let Ok(written) = robot_model::to_mjcf(model, &robot_model::MjcfOptions::default()) else {
        return;
    };
    let again = robot_model::parse(
        "again.xml",
        &written.text,
        &mut |_: &str| Err(String::new()),
    );
    let again = again.unwrap_or_else(|problems| panic!("what we write, we read: {problems}"));
    // A link called world without shapes is the world itself, which needs no element.
    let named = |model: &robot_model::Model| -> Vec<String> {
        let links = model.links.iter().filter(|link| link.name != "world");
        links.map(|link| link.name.clone()).collect()
    };
    assert_eq!(named(&again.model), named(model));
}

/// Longer sentences are not compared with their formulas, so that an input takes no longer than others.
const LONG_SENTENCE: usize = 300;

/// Reads requirements in every format; what is read can be changed, and what is written can be read again.
pub fn requirements(bytes: &[u8]) {
    use requirement_files::{Change, Columns, Document, Field, File, Format, Item, fret};
    let file = |name: &str, bytes: &[u8]| File {
        name: name.to_owned(),
        bytes: bytes.to_vec(),
    };
    let settings = file(
        ".doorstop.yml",
        b"settings:\n  digits: 3\n  prefix: REQ\n  sep: ''\n",
    );
    for format in Format::ALL {
        let files = match format {
            Format::Doorstop => vec![
                settings.clone(),
                file("REQ001.yml", bytes),
                file("REQ002.md", bytes),
            ],
            _ => vec![file("x", bytes)],
        };
        let document = match Document::read(format, &files, &Columns::default()) {
            Ok(document) => document,
            Err(problem) => {
                assert!(!problem.message().is_empty(), "refused without a reason");
                continue;
            }
        };
        for placed in &document.items {
            let text = &document.sources[placed.source].text;
            assert!(
                text.get(placed.span.clone()).is_some(),
                "a place lies outside: {format:?}"
            );
        }
        let Some(first) = document.items.first() else {
            continue;
        };
        let mut item = first.item.clone();
        item.text.push_str(" & <more>");
        let new = Item {
            id: "REQ999".to_owned(),
            text: "New".to_owned(),
            ..Item::default()
        };
        // What cannot be written is refused; `with` itself reads what it gives.
        let _ = document.with(&[Change::Set(item, vec![Field::Text]), Change::Add(new)]);
        if let (Ok(read), Some(formulas)) = (fret::translated(&first.item.text), &first.formulas)
            && first.item.text.len() < LONG_SENTENCE
        {
            let meaning = fret::compare(&read.sentence, formulas, Some(&read), None);
            if let fret::Comparison::Differs(trace) = meaning.runs {
                assert_ne!(trace.sentence, trace.formula, "a word that shows nothing");
            }
        }
    }
}

/// Checks an evidence pack: one that has no fault is the archive that its own parts give.
pub fn pack(bytes: &[u8]) {
    let found = pack::check(&mut &bytes[..], None);
    assert!(found.bytes <= bytes.len() as u64);
    if !found.faults.is_empty() {
        return;
    }
    assert_eq!(found.bytes, bytes.len() as u64, "bytes behind the archive");
    let manifest = found
        .manifest
        .expect("a pack without a fault has a manifest");
    let none = [pack::Signature::Absent, pack::Signature::NotRead];
    let envelope = u64::from(!none.contains(&found.signature));
    assert_eq!(found.parts, manifest.subject.len() as u64 + 1 + envelope);
}

/// Reads a table in Parquet, column by column.
pub fn parquet(bytes: &[u8]) {
    let Ok(table) = recording::ParquetTable::open(bytes) else {
        return;
    };
    for name in table.names() {
        let Ok(rows) = table.column(name) else {
            continue;
        };
        assert_eq!(rows.len(), table.rows());
        // One type at most, and a value or none in each row.
        let lengths = [
            rows.bools().map(|it| it.len()),
            rows.ints().map(|it| it.len()),
            rows.doubles().map(|it| it.len()),
        ];
        assert!(lengths.iter().flatten().count() <= 1);
        assert!(lengths.iter().flatten().all(|it| *it == table.rows()));
        assert!(rows.texts().is_none_or(|it| it.len() == table.rows()));
        assert!(rows.numbers().is_none_or(|it| it.len() == table.rows()));
    }
}
