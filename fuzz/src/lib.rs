//! What must hold of everything that reads foreign bytes, whatever the bytes: it does not panic, it ends, places lie in
//! the text, and what was read can be written and read again.
//!
//! Each function is a fuzzing target (`fuzz_targets/`); the ordinary tests call them too, on the inputs that are kept in
//! `inputs/` and on variations of them (`crates/cli/tests/fuzz_inputs.rs`).

use checker::explore::{ExploreOptions, explore_with};
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
