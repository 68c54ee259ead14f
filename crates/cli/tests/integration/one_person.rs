//! A cohort of one person: four hundred trials of it decide nothing of others, in the words and marks of all faces, and do
//! where the study says why this one stands for all. And what a text states is held against the threshold
//! and the sentence.

use crate::support;

use support::program::corroborate;
use tempfile::TempDir;

const STUDY: &str = "title = \"t\"\nsummary = \"s\"\nseed = 1\nconfidence = 0.95\nagreement = 0.95\n\
                     [conditions]\ntypical = \"any\"\n";

const VOCABULARY: &str = "kept = { meaning = \"kept\", model = \"true\", column = \"kept\" }\n";

fn study(text: &str, rows: &str, declared: &str) -> TempDir {
    let folder = TempDir::new().expect("a folder");
    let requirements = format!(
        "[[requirement]]\nid = \"1\"\ntext = \"{text}\"\nthreshold = \"at least 0.9\"\nmargin = 0.1\n\
         property = 'P=? [ F \"kept\" ]'\nexperiment = \"kept\"\n"
    );
    let ledger = format!(
        "[[evidence]]\nid = \"X\"\ntitle = \"experiment\"\ntechnique = \"experiment\"\nconditions = \"typical\"\n\
         tables.cohort = \"c.csv\"\n{declared}\nchanged = \"c\"\n"
    );
    let table = format!("person,kept,attempts\n{rows}\n");
    for (name, text) in [
        ("study.toml", STUDY),
        ("vocabulary.toml", VOCABULARY),
        ("requirements.toml", requirements.as_str()),
        ("ledger.toml", ledger.as_str()),
        ("c.csv", table.as_str()),
    ] {
        std::fs::write(folder.path().join(name), text).expect("written");
    }
    folder
}

/// All that is printed, without line breaks, and the exit code.
fn run(folder: &TempDir) -> (String, String, i32) {
    let said = corroborate(folder.path(), &["run", "."]);
    let words = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    (words(&said.out), words(&said.talk), said.code)
}

const DECLARED: &str = "tables.one_for_all = \"the arm works alone\"";

#[test]
fn one_person_decides_nothing_unless_the_study_declares_that_it_stands_for_all() {
    let (out, _, code) = run(&study("t", "P1,398,400", ""));
    assert_eq!(code, 3, "{out}");
    assert!(out.contains("is neither supported nor refuted"), "{out}");
    assert!(out.contains("of one person or session alone"), "{out}");
    assert!(out.contains("X does not decide"), "{out}");
    assert!(out.contains("· 99.5 %"), "{out}");
    assert!(!out.contains("as independent: it holds"), "{out}");

    let (out, _, code) = run(&study("t", "P1,398,400", DECLARED));
    assert_eq!(code, 0, "{out}");
    assert!(out.contains("✓ 99.5 %"), "{out}");
    assert!(
        out.contains("declared to stand for all (\"the arm works alone\")"),
        "{out}"
    );
}

/// What is declared is part of what a result depends on.
#[test]
fn a_changed_declaration_is_no_kept_result() {
    let folder = study("t", "P1,398,400", "");
    run(&folder);
    let ledger = folder.path().join("ledger.toml");
    let text = std::fs::read_to_string(&ledger).expect("the ledger");
    std::fs::write(
        &ledger,
        text.replace("tables.cohort", &format!("{DECLARED}\ntables.cohort")),
    )
    .expect("written");
    let (out, _, code) = run(&folder);
    assert_eq!(code, 0, "{out}");
}

#[test]
fn a_declaration_that_does_not_fit_the_table_is_refused_with_what_to_do() {
    for (rows, declared, part) in [
        ("P1,198,200\nP2,200,200", DECLARED, "which has trials of 2"),
        (
            "P1,398,400",
            "tables.one_for_all = \" \"",
            "gives no reason",
        ),
    ] {
        let (_, err, code) = run(&study("t", rows, declared));
        assert_eq!(code, 2, "{err}");
        assert!(
            err.contains("error[one-for-all]") && err.contains(part),
            "{err}"
        );
    }
}

#[test]
fn a_text_that_states_another_rate_than_the_threshold_is_said_once_with_its_place() {
    let (out, err, _) = run(&study(
        "It is kept in at least 95 % of attempts.",
        "P1,398,400",
        "",
    ));
    assert_eq!(err.matches("text-threshold").count(), 1, "{err}");
    // Beside the verdict, too, which whoever reads the page alone sees.
    assert!(
        out.contains(
            "Of its wording: the text states at least 95 %, and the threshold is at least 90 %."
        ),
        "{out}"
    );
    assert!(
        err.contains("the text states at least 95 %, and the threshold is at least 90 %"),
        "{err}"
    );
    assert!(err.contains("requirements.toml:3:"), "{err}");
    let (out, err, _) = run(&study(
        "It is kept in at least 90 % of attempts.",
        "P1,398,400",
        "",
    ));
    assert!(!err.contains("text-threshold"), "{err}");
    assert!(!out.contains("Of its wording"), "{out}");
}

/// A parameter that was changed without its text; and a text that says more, or the same in another unit.
#[test]
fn a_text_that_states_another_time_than_its_sentence_is_said_once_with_its_place() {
    let said_of = |text: &str| {
        let folder = study(text, "P1,398,400", "");
        let file = folder.path().join("requirements.toml");
        let shall =
            "shall = \"The arm shall with probability at least 0.9 within 60 s satisfy kept.\"";
        let asked = std::fs::read_to_string(&file).expect("the requirements");
        let written = asked.replace("property = 'P=? [ F \"kept\" ]'", shall);
        let written = written.replace("threshold = \"at least 0.9\"\n", "");
        std::fs::write(&file, written).expect("written");
        run(&folder).1
    };
    let err = said_of("It is kept within 40 s.");
    assert_eq!(err.matches("text-duration").count(), 1, "{err}");
    assert!(
        err.contains("the text states 40 s, and the sentence asks for 60 s"),
        "{err}"
    );
    assert!(err.contains("requirements.toml:3:"), "{err}");
    for text in [
        "It is kept within a minute.",
        "It is kept within 1 min.",
        "After a pause of 5 s it is kept within 60 s.",
    ] {
        let err = said_of(text);
        assert!(!err.contains("text-duration"), "{text}: {err}");
    }
}

/// Two statements of one count, each with its guarantee: an interval of one look, and a limit that holds at every look.
#[test]
fn no_interval_stands_without_its_guarantee() {
    let (out, _, _) = run(&study("t", "P1,46,50\nP2,44,50\nP3,45,50\nP4,50,50", ""));
    assert!(out.contains("limit at every look"), "{out}");
    assert!(
        out.contains("Intervals are two-sided at 95 % and of one look"),
        "{out}"
    );
    assert!(
        out.contains("(two-sided 95 % interval of one look)"),
        "{out}"
    );
    assert!(!out.contains("(95 % interval)"), "{out}");
}

/// A fourth person who never fails shows that people differ.
#[test]
fn a_limit_that_would_be_better_with_a_person_less_says_so() {
    let alike = "P1,45,50\nP2,45,50\nP3,45,50";
    let words = "without the subject all of whose 50 trials count";
    let (out, _, _) = run(&study("t", &format!("{alike}\nP4,50,50"), ""));
    assert!(out.contains(words), "{out}");
    let (out, _, _) = run(&study("t", alike, ""));
    assert!(!out.contains(words), "{out}");
}
