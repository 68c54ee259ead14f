//! A study with many mistakes: all are told at once, each with its place and what to do about it, in the order of files and
//! lines. What only follows from another mistake is not told.

use crate::support::{Copy, host};
use corroborate::{Problem, RunRequest};

/// File, line and message of each problem, with the remedy.
fn told(study: &Copy) -> Vec<(String, usize, String)> {
    let request = RunRequest::new(study.path(""));
    let planned = corroborate::plan(&request, &host(|_| false).0);
    let problem = planned.expect_err("it has mistakes");
    let run = corroborate::run(&request, &host(|_| false).0).expect_err("it has mistakes");
    assert_eq!(problem, run);
    let all = std::iter::once(&problem).chain(problem.others());
    all.map(placed).collect()
}

fn placed(problem: &Problem) -> (String, usize, String) {
    let place = problem
        .place()
        .unwrap_or_else(|| panic!("no place: {problem}"));
    let remedy = problem.what_to_do();
    let remedy = remedy.unwrap_or_else(|| panic!("no remedy: {problem}"));
    assert!(problem.message().len() < 1_200, "{problem}");
    let file = place.name.rsplit('/').next().expect("a name");
    (
        file.to_owned(),
        place.line,
        format!("{} {remedy}", problem.message()),
    )
}

/// Makes the changes, and expects what is said of each, in the order in which it is told.
fn expect(changes: &[(&str, &str, &str, &str)]) {
    expect_in(&Copy::of_template("Formal model"), changes);
}

fn expect_in(study: &Copy, changes: &[(&str, &str, &str, &str)]) {
    for (file, old, new, _) in changes {
        study.edit(file, old, new);
    }
    let found = told(study);
    let line = |file: &str, new: &str| {
        let text = std::fs::read_to_string(study.path(file)).expect("a text");
        let at = text.find(new).expect("it was changed");
        text[..at].matches('\n').count() + 1
    };
    let expected: Vec<(String, usize)> = changes
        .iter()
        .map(|(file, _, new, _)| (file.to_string(), line(file, new)))
        .collect();
    let places: Vec<(String, usize)> = found
        .iter()
        .map(|(file, line, _)| (file.clone(), *line))
        .collect();
    assert_eq!(places, expected, "{found:#?}");
    for ((.., message), (file, _, _, said)) in found.iter().zip(changes) {
        assert!(message.contains(said), "{file}: no `{said}` in: {message}");
    }
}

#[test]
fn one_mistake_in_each_of_six_files() {
    expect(&[
        (
            "study.toml",
            "confidence = 0.95",
            "confidence = 95",
            "`confidence` must be between",
        ),
        ("parameters.toml", "\"0.3 m/s\"", "\"0.3 zorks/s\"", "zorks"),
        (
            "vocabulary.toml",
            "column = \"successes\"",
            "colum = \"successes\"",
            "did you mean `column`?",
        ),
        (
            "requirements.toml",
            "margin = 0.10",
            "margin = 2",
            "`margin` must be between 0 and 1 (got 2)",
        ),
        (
            "ledger.toml",
            "conditions = \"typical\"",
            "conditions = \"tipical\"",
            "did you mean `typical`?",
        ),
        ("model.prism", "init approach", "init arrived", "arrived"),
    ]);
}

#[test]
fn several_mistakes_in_one_ledger() {
    expect(&[
        (
            "ledger.toml",
            "conditions = \"typical\"",
            "conditions = \"tipical\"",
            "did you mean `typical`?",
        ),
        (
            "ledger.toml",
            "\"model.prism\"",
            "\"modell.prism\"",
            "did you mean `model.prism`?",
        ),
        (
            "ledger.toml",
            "id = \"E2\"",
            "id =  \"E1\"",
            "two entries `E1`",
        ),
        (
            "ledger.toml",
            "\"attempts.csv\"",
            "\"attempt.csv\"",
            "did you mean `attempts.csv`?",
        ),
    ]);
}

#[test]
fn all_keys_that_are_not_used_are_told_where_they_are() {
    let model = "model = \"model.prism\"";
    let more = "model = \"model.prism\"\nepisodes = 100\nscenario = \"x\"\nrecordings = \"y\"";
    let study = Copy::of_template("Formal model");
    study.edit("ledger.toml", model, more);
    expect_in(
        &study,
        &[
            (
                "ledger.toml",
                "episodes = 100",
                "episodes =  100",
                "does not use `episodes`",
            ),
            (
                "ledger.toml",
                "scenario = \"x\"",
                "scenario =  \"x\"",
                "does not use `scenario`",
            ),
            (
                "ledger.toml",
                "recordings = \"y\"",
                "recordings =  \"y\"",
                "does not use `recordings`",
            ),
        ],
    );
}

#[test]
fn several_mistakes_in_requirements_each_at_its_value() {
    expect(&[
        (
            "requirements.toml",
            "margin = 0.10",
            "margin = 2",
            "(got 2)",
        ),
        (
            "requirements.toml",
            "monitor.when = \"approaching\"",
            "monitor.when = \"aproaching\"",
            "did you mean `approaching`?",
        ),
        (
            "requirements.toml",
            "within_secs = 60",
            "within_secs = -60",
            "within_secs",
        ),
        (
            "requirements.toml",
            "threshold = \"at least 0.95\"",
            "threshold = \"high\"",
            "`threshold` must be",
        ),
        (
            "requirements.toml",
            "margin = 0.05",
            "margin = -1",
            "(got -1)",
        ),
        (
            "requirements.toml",
            "experiment = \"missed\"",
            "experiment = \"mised\"",
            "did you mean `missed`?",
        ),
    ]);
}

#[test]
fn wrong_types_unknown_fields_and_missing_ones_in_one_file() {
    expect(&[
        (
            "study.toml",
            "seed = 1",
            "seed = \"a\"",
            "`seed` must be a whole number",
        ),
        (
            "study.toml",
            "confidence = 0.95",
            "confidence = \"high\"",
            "`confidence` must be a number",
        ),
        (
            "study.toml",
            "agreement = 0.95",
            "agrement = 0.95",
            "did you mean `agreement`?",
        ),
    ]);
    let study = Copy::of_template("Formal model");
    study.edit("ledger.toml", "title = \"Experiments\"\n", "");
    expect_in(
        &study,
        &[
            (
                "ledger.toml",
                "model-checking",
                "modelchecking",
                "did you mean `model-checking`?",
            ),
            (
                "ledger.toml",
                "[[evidence]]\nid = \"E2\"",
                "[[evidence]] \nid = \"E2\"",
                "missing field `title`",
            ),
            (
                "ledger.toml",
                "tables.cohort",
                "tables.cohorts",
                "did you mean `cohort`?",
            ),
        ],
    );
}

#[test]
fn what_follows_from_a_mistake_is_not_told() {
    // The sentence of requirement 2 uses the parameter; a calibration would name the entry that is left out.
    let changes = [
        (
            "parameters.toml",
            "value = \"0.3 m/s\"",
            "value = \"fast\"",
            "near_speed",
        ),
        (
            "ledger.toml",
            "model = \"model.prism\"",
            "model = \"nowhere.prism\"",
            "no file nowhere.prism",
        ),
    ];
    let study = Copy::of_template("Formal model");
    study.edit(
        "ledger.toml",
        "changed = \"Twenty",
        "calibrated = [{ parameter = \"p\", from = \"E1\", requirement = \"1\" }]\nchanged = \"Twenty",
    );
    expect_in(&study, &changes);
}

#[test]
fn ever_so_many_mistakes_are_bounded_in_number() {
    let study = Copy::of_template("Formal model");
    let entry = |place: usize| {
        format!(
            "\n[[evidence]]\nid = \"X{place}\"\ntitle = \"{}\"\ntechnique = \"model-checking\"\nconditions = \"nowhere\"\n\
             model = \"model.prism\"\nchanged = \"all\"\n",
            "long ".repeat(1_000)
        )
    };
    let path = study.path("ledger.toml");
    let text = std::fs::read_to_string(&path).expect("a text");
    let more: String = (0..70).map(entry).collect();
    std::fs::write(&path, text + &more).expect("it is written");
    let request = RunRequest::new(study.path(""));
    let problem = corroborate::plan(&request, &host(|_| false).0).expect_err("mistakes");
    assert_eq!(problem.others().len(), 49);
    assert_eq!(
        problem.rest().as_deref(),
        Some("20 more mistakes are not shown: correct these 50 first")
    );
}
