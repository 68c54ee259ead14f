//! One wrong number in a model whose failures nothing counts by themselves: a constant, a probability in a command, a rate of
//! a continuous-time chain, a basic event of a fault tree. Trials are right, so that `diagnose` names its line and `refine`
//! offers the value.

use crate::support;

use serde_json::Value;
use support::program::corroborate;
use tempfile::TempDir;

const STUDY: &str = r#"
title = "A lock on a canal"
summary = "The gate of a lock, by a model and counted locks."
seed = 1
confidence = 0.95
agreement = 0.95
sample_sizes = "fixed"
[conditions]
usual = "By day."
"#;

const REQUIREMENTS: &str = r#"
[[requirement]]
id = "opens"
text = "In at least 70 % of locks the gate opens in the end."
property = 'P=? [ F "opened" ]'
margin = 0.05
threshold = "at least 0.7"
experiment = "opens"
[[requirement]]
id = "prompt"
text = "In at least 40 % of locks the gate opens at the first try."
property = 'P=? [ F<=1 "opened" ]'
margin = 0.05
threshold = "at least 0.4"
experiment = "prompt"
"#;

const VOCABULARY: &str = r#"
[opened]
meaning = "the gate is open"
model = "s=1"
[opens]
meaning = "the gate opened"
column = "opens"
[prompt]
meaning = "the gate opened at once"
column = "prompt"
"#;

const TRIALS: &str = r#"
[[evidence]]
id = "T"
title = "Locks that were counted"
technique = "experiment"
conditions = "usual"
tables.requirements = "locks.csv"
changed = "Counted."
"#;

fn of_model(kind: &str) -> String {
    format!(
        "[[evidence]]\nid = \"M\"\ntitle = \"A model\"\ntechnique = {kind}\nconditions = \"usual\"\nchanged = \"The first.\"\n"
    )
}

/// A study with this model and these counts of 400 locks: those that opened in the end, and at the first try.
fn study(model: (&str, &str), ledger: &str, counts: [u32; 2]) -> TempDir {
    let folder = TempDir::new().expect("a folder");
    let write = |name: &str, text: &str| {
        std::fs::write(folder.path().join(name), text).expect("written");
    };
    write("study.toml", STUDY);
    write("requirements.toml", REQUIREMENTS);
    write("vocabulary.toml", VOCABULARY);
    write("ledger.toml", &format!("{}{TRIALS}", of_model(ledger)));
    write(model.0, model.1);
    let rows = ["opens", "prompt"].into_iter().zip(counts);
    let rows: String = rows
        .map(|(id, passed)| format!("{id},400,{passed},{}\n", 400 - passed))
        .collect();
    write(
        "locks.csv",
        &format!("requirement,covered,passed,failed\n{rows}"),
    );
    let said = corroborate(folder.path(), &["run", "."]);
    assert!(said.code < 2, "{said:?}");
    folder
}

fn first_suspect(folder: &TempDir) -> Value {
    let said = corroborate(folder.path(), &["diagnose", ".", "--format", "json"]);
    let report: Value = serde_json::from_str(&said.out).expect("a report");
    report["suspects"][0].clone()
}

/// The lines that the first harmless proposal takes out and puts in.
fn first_repair(folder: &TempDir) -> Vec<String> {
    let said = corroborate(folder.path(), &["refine", ".", "--format", "json"]);
    let report: Value = serde_json::from_str(&said.out).expect("a report");
    let first = &report["proposals"][0];
    let breaks = first["tried"]["breaks"].as_array().expect("breaks");
    assert!(breaks.is_empty(), "{first}");
    let diff = first["diff"].as_str().expect("a diff");
    let changed = diff.lines().filter(|line| {
        let is_change = line.starts_with('+') || line.starts_with('-');
        is_change && !line.starts_with("+++") && !line.starts_with("---")
    });
    changed.map(str::to_owned).collect()
}

/// The number behind a mark in the line that a repair puts in.
fn value_after(repair: &[String], mark: &str) -> f64 {
    let new = repair
        .iter()
        .find(|line| line.starts_with('+'))
        .expect("a line");
    let at = new.find(mark).expect("the mark") + mark.len();
    let digits: String = new[at..]
        .chars()
        .take_while(|c| c.is_ascii_digit() || *c == '.')
        .collect();
    digits.parse().expect("a number")
}

const BY_CONSTANT: &str = "dtmc\nconst double pOpens = 0.3;\nconst double pStuck = 0.2;\nmodule gate\n  s : [0..2] init 0;\n  \
    [] s=0 -> pOpens : (s'=1) + pStuck : (s'=2) + 1-pOpens-pStuck : true;\n  [] s>0 -> true;\nendmodule\n";

/// True is 0.5 and 0.2: 0.5/0.7 in the end, 0.5 at once; the model has 0.3, so 0.6 and 0.3.
#[test]
fn a_wrong_constant_has_its_line_and_its_value() {
    let folder = study(
        ("gate.prism", BY_CONSTANT),
        "\"model-checking\"\nmodel = \"gate.prism\"",
        [286, 200],
    );
    let suspect = first_suspect(&folder);
    assert_eq!(suspect["asset"]["file"], "gate.prism", "{suspect}");
    assert_eq!(suspect["asset"]["line"], 2, "{suspect}");
    assert_eq!(suspect["asset"]["part"], "`pOpens`", "{suspect}");
    let value = value_after(&first_repair(&folder), "pOpens = ");
    assert!((value - 0.5).abs() < 0.02, "{value}");
}

/// The same with the numbers in the command.
#[test]
fn a_wrong_probability_in_a_command_has_its_line_and_its_value() {
    let text = BY_CONSTANT
        .replace(
            "const double pOpens = 0.3;\nconst double pStuck = 0.2;\n",
            "",
        )
        .replace("1-pOpens-pStuck", "0.5")
        .replace("pOpens", "0.3")
        .replace("pStuck", "0.2");
    // 0.3, 0.2 and 0.5, of which the last two keep their proportion: with 0.5 it is 0.5, 1/7 and 5/14.
    let folder = study(
        ("gate.prism", &text),
        "\"model-checking\"\nmodel = \"gate.prism\"",
        [311, 200],
    );
    let suspect = first_suspect(&folder);
    assert_eq!(suspect["asset"]["line"], 4, "{suspect}");
    assert_eq!(suspect["asset"]["part"], "`0.3`", "{suspect}");
    let repair = first_repair(&folder);
    let value = value_after(&repair, "-> ");
    assert!((value - 0.5).abs() < 0.02, "{repair:?}");
    // The changed model is one that runs.
    let accepted = corroborate(folder.path(), &["refine", ".", "--accept", "1"]);
    assert!(accepted.code < 2, "{accepted:?}");
}

/// Open within 1: 1 - exp(-0.7) of those that are not stuck. True rate 0.7; the model has 0.2.
#[test]
fn a_wrong_rate_of_a_continuous_time_chain_has_its_line() {
    let model = "ctmc\nconst double opening = 0.2;\nconst double sticking = 0.1;\nmodule gate\n  s : [0..2] init 0;\n  \
        [] s=0 -> opening : (s'=1) + sticking : (s'=2);\n  [] s>0 -> 1 : true;\nendmodule\n";
    // 0.7/0.8 in the end, (0.7/0.8)(1 - exp(-0.8)) within 1.
    let folder = study(
        ("gate.prism", model),
        "\"model-checking\"\nmodel = \"gate.prism\"",
        [350, 193],
    );
    let suspect = first_suspect(&folder);
    assert_eq!(suspect["asset"]["line"], 2, "{suspect}");
    let value = value_after(&first_repair(&folder), "opening = ");
    assert!((value - 0.7).abs() < 0.1, "{value}");
}

/// What the counts do not tell apart is named together, and `--all` takes none of it.
#[test]
fn numbers_that_are_not_told_apart_are_named_together() {
    let folder = study(
        ("gate.prism", BY_CONSTANT),
        "\"model-checking\"\nmodel = \"gate.prism\"",
        [286, 200],
    );
    // Without the second requirement one number is as good as the other.
    let path = folder.path().join("requirements.toml");
    let text = std::fs::read_to_string(&path).expect("a text");
    let first = text.split("[[requirement]]").take(2).collect::<Vec<_>>();
    std::fs::write(&path, first.join("[[requirement]]")).expect("written");
    let table = folder.path().join("locks.csv");
    let rows = std::fs::read_to_string(&table).expect("rows");
    let rows: Vec<&str> = rows
        .lines()
        .filter(|row| !row.starts_with("prompt"))
        .collect();
    std::fs::write(&table, rows.join("\n") + "\n").expect("written");
    let said = corroborate(folder.path(), &["run", "."]);
    assert!(said.code < 2, "{said:?}");
    let suspect = first_suspect(&folder);
    let together = suspect["asset"]["together"].to_string();
    assert!(suspect["asset"]["line"].is_number(), "{suspect}");
    assert!(together.contains("gate.prism:"), "{suspect}");
    let said = corroborate(folder.path(), &["refine", ".", "--all", "--format", "json"]);
    let report: Value = serde_json::from_str(&said.out).expect("a report");
    assert_eq!(
        report["applied"].as_array().map(Vec::len),
        Some(0),
        "{report}"
    );
}

/// Both motors have to fail for the gate to stay shut: 0.3 * 0.5 as counted; the tree has 0.3 * 0.1.
#[test]
fn a_wrong_basic_event_of_a_fault_tree_has_its_line() {
    let tree = "toplevel \"opens\";\n\"opens\" or \"hand\" \"motor\";\n\"hand\" prob=0.1;\n\"motor\" prob=0.3;\n";
    let ledger = "\"fault-tree\"\ntree = \"gate.dft\"\nevents = { opens = \"opens\" }";
    // The hand opens in 0.1 of all locks, so that 0.75 needs 0.722 of the motor.
    let folder = study(("gate.dft", tree), ledger, [300, 200]);
    let suspect = first_suspect(&folder);
    assert_eq!(suspect["asset"]["file"], "gate.dft", "{suspect}");
    let line = suspect["asset"]["line"].as_u64();
    assert!(line == Some(3) || line == Some(4), "{suspect}");
    let words = suspect["explanation"].as_str().expect("words");
    assert!(
        words.contains("its rate is that of 300 of 400 in T"),
        "{words}"
    );
}
