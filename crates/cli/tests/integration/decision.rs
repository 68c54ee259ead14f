//! Decision processes are evidence: uncertain constants are carried through both ends of their range, and what the worst
//! scheduler does is a test that a bench can try.
//!
//! Needs `python3`, in which the outside simulator is written.

use crate::support;

use serde_json::Value;
use stats::{BetaPosterior, Sample};
use std::path::Path;
use support::program::{contents, corroborate};
use tempfile::TempDir;

const STUDY: &str = "title = \"t\"\nsummary = \"s\"\nseed = 1\nconfidence = 0.95\nagreement = 0.95\n\
                     [conditions]\ntypical = \"any\"\n[model]\nstep = \"1 s\"\n";

/// A waiter carries a cup at once, or in two halves with another who carries it as well, or not at all twice as far: how
/// is left open. Spilling once spoils it.
const MODEL: &str = "mdp\nconst double pSpill = 0.1;\nmodule m\n  s : [0..3] init 0;\n\
                     [once] s=0 -> 1-pSpill:(s'=2) + pSpill:(s'=3);\n\
                     [twice] s=0 -> 1-pSpill:(s'=1) + pSpill:(s'=3);\n\
                     [again] s=1 -> 1-pSpill:(s'=2) + pSpill:(s'=3);\n  [] s>1 -> true;\nendmodule\n";

const REQUIREMENTS: &str = "[[requirement]]\nid = \"brought\"\ntext = \"It is brought.\"\nmargin = 0.1\n\
    threshold = \"at least 0.9\"\nproperty = 'P=? [ F \"there\" ]'\n\
    [[failure_mode]]\nid = \"spill\"\nname = \"Spill\"\nmeaning = \"it is spilt\"\nmargin = 0.1\noccurs = 'P=? [ F \"spilt\" ]'\n";

const VOCABULARY: &str = "there = { meaning = \"there\", model = \"s=2\" }\n\
                          spilt = { meaning = \"spilt\", model = \"s=3\" }\n";

const LEDGER: &str = "[[evidence]]\nid = \"X\"\ntitle = \"experiment\"\ntechnique = \"experiment\"\n\
    conditions = \"typical\"\ntables.failure_modes = \"modes.csv\"\nchanged = \"c\"\n\
    [[evidence]]\nid = \"Y\"\ntitle = \"whole errands\"\ntechnique = \"experiment\"\n\
    conditions = \"typical\"\ntables.requirements = \"r.csv\"\nchanged = \"c\"\n\
    [[evidence]]\nid = \"M\"\ntitle = \"model\"\ntechnique = \"model-checking\"\n\
    conditions = \"typical\"\nmodel = \"m.prism\"\nchanged = \"c\"\n\
    calibrated = [{ constant = \"pSpill\", from = \"X\", failure_mode = \"spill\" }]\n";

fn errand(passed: u64) -> TempDir {
    let folder = TempDir::new().expect("a folder");
    let table = format!(
        "requirement,covered,passed,failed\nbrought,200,{passed},{}\n",
        200 - passed
    );
    for (name, text) in [
        ("study.toml", STUDY),
        ("vocabulary.toml", VOCABULARY),
        ("requirements.toml", REQUIREMENTS),
        ("ledger.toml", LEDGER),
        ("m.prism", MODEL),
        (
            "modes.csv",
            "mode,occurrences,opportunities\nspill,20,200\n",
        ),
        ("r.csv", table.as_str()),
    ] {
        std::fs::write(folder.path().join(name), text).expect("written");
    }
    folder
}

fn result(folder: &Path, threads: &str) -> Value {
    let said = corroborate(folder, &["run", ".", "-j", threads, "--format", "json"]);
    serde_json::from_str(&said.out).unwrap_or_else(|error| panic!("{error}: {said:?}"))
}

fn finding<'r>(result: &'r Value, piece: &str, subject: &str) -> &'r Value {
    let pieces = result["evidence"].as_array().expect("evidence");
    let piece = pieces.iter().find(|it| it["id"] == piece).expect("a piece");
    let findings = piece["findings"].as_array().expect("findings");
    let mut own = findings.iter().filter(|it| it["subject"]["id"] == subject);
    own.next().expect("a finding")
}

fn number(value: &Value) -> f64 {
    value
        .as_f64()
        .unwrap_or_else(|| panic!("{value} is a number"))
}

/// Two constants that were set to one count, the second as its complement: the cup is brought with (1 - p)^2, and p is drawn
/// once. As independent draws the middle 95 % would reach about 0.7 times as far.
#[test]
fn constants_of_one_count_have_one_unknown_value() {
    let chain = "dtmc\nconst double pSpill = 0.1;\nconst double pCarry = 0.9;\nmodule m\n  s : [0..3] init 0;\n\
                 [] s=0 -> 1-pSpill:(s'=1) + pSpill:(s'=3);\n  [] s=1 -> pCarry:(s'=2) + 1-pCarry:(s'=3);\n\
                 [] s>1 -> true;\nendmodule\n";
    let second = "calibrated = [{ constant = \"pSpill\", from = \"X\", failure_mode = \"spill\" }, \
                  { constant = \"pCarry\", from = \"X\", failure_mode = \"spill\", complement = true }]\n";
    let first =
        "calibrated = [{ constant = \"pSpill\", from = \"X\", failure_mode = \"spill\" }]\n";
    let posterior = BetaPosterior::jeffreys(Sample {
        successes: 20,
        trials: 200,
    });
    // Of a chain functions are evaluated; of a decision process each point is solved.
    for model in [chain.to_owned(), chain.replace("dtmc", "mdp")] {
        let folder = errand(172);
        std::fs::write(folder.path().join("m.prism"), model).expect("written");
        let ledger = LEDGER.replace(first, second);
        assert_ne!(ledger, LEDGER);
        std::fs::write(folder.path().join("ledger.toml"), ledger).expect("written");
        let result = result(folder.path(), "2");
        let credible = &finding(&result, "M", "brought")["measure"]["credible"];
        for (limit, probability) in [("low", 0.975), ("high", 0.025)] {
            let expected = (1.0 - posterior.quantile(probability)).powi(2);
            let found = number(&credible["interval"][limit]);
            assert!(
                (found - expected).abs() < 1e-3,
                "{limit}: {found} {expected}"
            );
        }
        let spread = credible["spread"].as_array().map_or(0, Vec::len);
        assert!(spread <= 1, "one source of uncertainty: {credible}");
    }
}

/// The ends are `(1 - p)^2` and `1 - p`: exact functions of the constant, so that their quantiles are those of the
/// constant's posterior.
#[test]
fn counted_constants_are_carried_through_both_ends_of_the_range() {
    let folder = errand(172);
    let first = result(folder.path(), "1");
    let posterior = BetaPosterior::jeffreys(Sample {
        successes: 20,
        trials: 200,
    });
    let credible = &finding(&first, "M", "brought")["measure"]["credible"];
    let (least, greatest) = (&credible["ends"]["least"], &credible["ends"]["greatest"]);
    for (end, power) in [(least, 2), (greatest, 1)] {
        for (limit, probability) in [("low", 0.975), ("high", 0.025)] {
            let expected = (1.0 - posterior.quantile(probability)).powi(power);
            let found = number(&end["interval"][limit]);
            assert!(
                (found - expected).abs() < 1e-3,
                "{limit}: {found} {expected}"
            );
        }
    }
    assert_eq!(credible["interval"]["low"], least["interval"]["low"]);
    assert_eq!(credible["interval"]["high"], greatest["interval"]["high"]);
    // Of a requirement the worst is the least, of a failure mode the greatest probability.
    assert_eq!(credible["mean"], least["mean"]);
    let spill = &finding(&first, "M", "spill")["measure"]["credible"];
    assert_eq!(spill["mean"], spill["ends"]["greatest"]["mean"]);
    assert_eq!(spill["spread"][0]["constant"], "pSpill");
    // 86 % lies between the ends; 50 % is below what any scheduler gives.
    let compared = |result: &Value| {
        let all = result["comparisons"].as_array().expect("comparisons");
        let ours = |c: &&Value| c["subject"]["id"] == "brought" && !c["p_difference"].is_null();
        let pair = all.iter().find(ours).expect("a pair");
        (pair["outcome"].clone(), number(&pair["p_difference"]))
    };
    let (outcome, p) = compared(&first);
    assert!(outcome == "corroborates" && p == 1.0, "{outcome} {p}");
    let far = errand(100);
    let (outcome, p) = compared(&result(far.path(), "1"));
    assert!(outcome == "conflicts" && p < 1e-4, "{outcome} {p}");
    // The same at any number of threads, and what is kept is checked.
    let again = errand(172);
    let second = result(again.path(), "2");
    assert_eq!(first["evidence"], second["evidence"]);
    assert_eq!(first["comparisons"], second["comparisons"]);
    let verified = corroborate(folder.path(), &["verify", "results"]);
    assert_eq!(verified.code, 0, "{verified:?}");
}

/// A driver starts calmly or briskly, and the floor is wet at times.
const DRIVER: &str = "mdp\nmodule driver\n  s : [0..2] init 0;\n  brisk : bool init false;\n  touching : bool init false;\n\
    [calm] s=0 -> (s'=1);\n  [brisk] s=0 -> (s'=1) & (brisk'=true);\n\
    [brake] s=1 & brisk -> 0.3:(s'=2) & (touching'=true) + 0.7:(s'=2);\n\
    [brake] s=1 & !brisk -> 0.01:(s'=2) & (touching'=true) + 0.99:(s'=2);\n  [] s=2 -> true;\nendmodule\n";

const OF_DRIVER: &str = "\n[[evidence]]\nid = \"driver\"\ntitle = \"driver\"\ntechnique = \"model-checking\"\n\
    conditions = \"floor\"\nmodel = \"driver.prism\"\nchanged = \"c\"\n";

const STEPS: &str = "evidence = \"sim\"\nmodel = \"driver\"\n\
    [[step]]\naction = \"brisk\"\nset_param = { \"cart.speed_cm_per_s\" = 330 }\n";

/// The cart's study with a driver, whose simulator does what its test sets.
fn cart(exploration: Option<&str>) -> TempDir {
    let folder = TempDir::new().expect("a folder");
    let from = support::root().join("conformance/command");
    for (path, bytes) in contents(&from) {
        let name = path.strip_prefix(&from).expect("inside");
        if !name.starts_with("results") {
            std::fs::write(folder.path().join(name), bytes).expect("written");
        }
    }
    let change = |name: &str, old: &str, new: &str| {
        let path = folder.path().join(name);
        let text = std::fs::read_to_string(&path).expect("a text");
        assert!(text.contains(old), "{name} has no `{old}`");
        std::fs::write(&path, text.replacen(old, new, 1)).expect("written");
    };
    let settings = "settings = json.load(file)[\"settings\"]";
    let tested = "stimulus_read = json.load(file)\n        settings = dict(stimulus_read[\"settings\"])\n        \
                  for action in stimulus_read[\"test\"][\"actions\"]:\n            \
                  settings.update(action.get(\"set_param\", {}))";
    change("simulate.py", settings, tested);
    change(
        "vocabulary.toml",
        "trace = \"/cart.gap <= 0 m\"",
        "trace = \"/cart.gap <= 0 m\"\nmodel = \"touching\"",
    );
    change(
        "requirements.toml",
        "shall = \"The cart shall never satisfy touches.\"",
        "shall = \"The cart shall never satisfy touches.\"\nthreshold = \"at least 0.95\"",
    );
    change("ledger.toml", "episodes = 40", "episodes = 3");
    let ledger = std::fs::read_to_string(folder.path().join("ledger.toml")).expect("a ledger");
    std::fs::write(folder.path().join("ledger.toml"), ledger + OF_DRIVER).expect("written");
    std::fs::write(folder.path().join("driver.prism"), DRIVER).expect("written");
    if let Some(text) = exploration {
        std::fs::write(folder.path().join("exploration.toml"), text).expect("written");
    }
    folder
}

fn worst(result: &Value) -> &Value {
    &finding(result, "driver", "clear")["measure"]["answer"]["guarantee"]["worst"]
}

#[test]
fn what_the_worst_scheduler_does_is_tried_in_simulation() {
    let folder = cart(Some(STEPS));
    let found = result(folder.path(), "1");
    let case = worst(&found);
    assert!((number(&case["probability"]) - 0.3).abs() < 1e-12, "{case}");
    assert!(
        case["steps"][0]
            .as_str()
            .expect("a step")
            .starts_with("[brisk]"),
        "{case}"
    );
    let file = case["file"].as_str().expect("a file");
    assert_eq!(file, "results/worst/driver-clear.toml");
    let text = std::fs::read_to_string(folder.path().join(file)).expect("the file");
    assert_eq!(text, case["test"].as_str().expect("a test"));
    assert!(
        case["note"].as_str().expect("a note").contains(file),
        "{case}"
    );
    let replayed = corroborate(folder.path(), &["replay", ".", file, "--format", "json"]);
    let report: Value =
        serde_json::from_str(&replayed.out).unwrap_or_else(|error| panic!("{error}: {replayed:?}"));
    assert_eq!(report["shown"], true, "{report}");
    let page = std::fs::read_to_string(folder.path().join("results/report.html")).expect("a page");
    assert!(page.contains("Worst scheduler") && page.contains(file));
    let diagnosed = corroborate(folder.path(), &["diagnose", ".", "--paths", "50"]);
    assert!(diagnosed.talk.contains(file), "{diagnosed:?}");
}

#[test]
fn where_no_bench_knows_the_steps_that_is_said() {
    for (exploration, said) in [
        (None, "the study has no exploration.toml"),
        (
            Some(STEPS.replace("brisk", "reverse")),
            "no [[step]] table of exploration.toml knows a step of it (brisk, brake)",
        ),
    ] {
        let folder = cart(exploration.as_deref());
        let found = result(folder.path(), "1");
        let case = worst(&found);
        let note = case["note"].as_str().expect("a note");
        assert!(case["file"].is_null() && note.contains(said), "{note}");
        assert!(!folder.path().join("results/worst").exists());
    }
}
