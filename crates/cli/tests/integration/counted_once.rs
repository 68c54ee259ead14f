//! The same trial told twice counts once: a recording under another name, a simulation that is run again from the same seeds.

use crate::support;

use serde_json::Value;
use support::command_study;
use support::program::{Study, corroborate};

/// The study of recordings, with more of them.
fn recordings(more: &[(&str, &str)], declared: &str) -> (Study, Value) {
    let study = Study::of_template("recordings");
    let first = support::read(&study.path("recordings/2024-05-13_shift2.csv"));
    for (name, change) in more {
        let text = match *change {
            "" => first.clone(),
            // The same rows, written by other software.
            "line ends" => first.replace('\n', "\r\n"),
            line => format!("{first}{line}\n"),
        };
        study.write(&format!("recordings/{name}"), text);
    }
    study.edit(
        "ledger.toml",
        "recordings = \"recordings\"",
        &format!("recordings = \"recordings\"\n{declared}"),
    );
    let said = study.run(&["run", "study", "--quiet"]);
    assert!([0, 1, 3].contains(&said.code), "{said:?}");
    let result = support::read(&study.path("results/study.json"));
    (study, serde_json::from_str(&result).expect("JSON"))
}

fn piece<'r>(result: &'r Value, id: &str) -> &'r Value {
    let pieces = result["evidence"].as_array().expect("evidence");
    pieces.iter().find(|it| it["id"] == id).expect("the piece")
}

fn trials(result: &Value) -> u64 {
    let findings = piece(result, "O1")["findings"]
        .as_array()
        .expect("findings");
    let of = findings.iter().find(|it| it["subject"]["id"] == "journey");
    of.expect("a finding")["measure"]["trials"]
        .as_u64()
        .expect("counts")
}

/// What is asked about copies of recordings.
fn asked(result: &Value) -> Vec<Value> {
    let all = piece(result, "O1")["lineage_questions"].as_array();
    let all = all.expect("questions").iter();
    all.filter(|it| it["kind"] == "recordings")
        .cloned()
        .collect()
}

#[test]
fn a_recording_under_another_name_is_no_second_trial() {
    let (_, before) = recordings(&[], "");
    let many = trials(&before);
    assert!(asked(&before).is_empty());
    let copies = [("a-copy.csv", ""), ("other/again.csv", "line ends")];
    let (study, result) = recordings(&copies, "");
    assert_eq!(trials(&result), many + 2);
    // Nothing is said that does not hold without the copies.
    let standing = |result: &Value| {
        let all = result["conclusions"].as_array().expect("conclusions");
        let of = all.iter().find(|it| it["requirement"] == "journey");
        let standings = of.expect("a conclusion")["standings"].as_array();
        let mut standings = standings.expect("standings").iter();
        let own = standings
            .find(|it| it["evidence"] == "O1")
            .expect("its standing");
        ["p_not_met", "p_met"].map(|key| own[key].as_f64().expect("a p-value"))
    };
    for (with, without) in standing(&result).into_iter().zip(standing(&before)) {
        assert!(with >= without - 1e-12, "{with} {without}");
    }
    let question = &asked(&result)[0];
    assert!(question["settled"].is_null(), "{question}");
    let finding = question["finding"].as_str().expect("a sentence");
    assert!(
        finding.contains("count once and each") && finding.contains("1 more"),
        "{finding}"
    );
    let report = study.run(&["report", "study"]);
    assert!(
        report.out.contains("has the same messages as"),
        "{report:?}"
    );
    // What was recorded counts as often as it was recorded: by what it says, not by its name.
    let verified = study.run(&["verify", "study/results", "--deep"]);
    assert_eq!(verified.code, 0, "{verified:?}");
    // A recording that goes on is another one.
    let (_, longer) = recordings(&[("longer.csv", "29000,docked,0,494,87.3")], "");
    assert!(asked(&longer).is_empty());
}

#[test]
fn the_ledger_may_say_that_the_same_was_recorded_twice() {
    let (_, before) = recordings(&[], "");
    let declared = "repeated_recordings = \"two shifts in which the robot stood still\"";
    let (_, result) = recordings(&[("a-copy.csv", "")], declared);
    assert_eq!(trials(&result), trials(&before) + 1);
    let question = &asked(&result)[0];
    assert!(
        question["settled"]
            .as_str()
            .expect("a reason")
            .contains("stood still")
    );
    // Without a reason it declares nothing.
    let study = Study::of_template("recordings");
    let named = "recordings = \"recordings\"";
    study.edit(
        "ledger.toml",
        named,
        &format!("{named}\nrepeated_recordings = \" \""),
    );
    let said = study.run(&["run", "study", "--quiet"]);
    assert_eq!(said.code, 2, "{said:?}");
}

/// The command's study with the same simulator once more, by this program.
fn again(program: &str, keys: &str) -> Value {
    let folder = command_study(&[]);
    let path = |name: &str| folder.path().join(name);
    let text = support::read(&path("simulate.py"));
    std::fs::write(path("copy.py"), &text).expect("written");
    std::fs::write(path("other.py"), format!("{text}\n# Of somebody else.\n")).expect("written");
    // Each episode starts an interpreter.
    let ledger = support::read(&path("ledger.toml")).replace("episodes = 60", "episodes = 20")
        + &format!(
            "[[evidence]]\nid = \"again\"\ntitle = \"Again\"\ntechnique = \"simulation\"\nconditions = \"floor\"\n\
         command = [\"python3\", \"{program}\", \"{{stimulus}}\", \"{{seed}}\", \"{{recording}}\"]\n\
         stimulus = \"stimulus.toml\"\nleaves = \"csv\"\nepisodes = 20\nchanged = \"Nothing.\"\n{keys}\n"
        );
    std::fs::write(path("ledger.toml"), ledger).expect("written");
    let said = corroborate(folder.path(), &["run", ".", "--quiet"]);
    assert!([0, 1, 3].contains(&said.code), "{said:?}");
    serde_json::from_str(&support::read(&path("results/study.json"))).expect("JSON")
}

#[test]
fn runs_from_the_same_seeds_are_not_two_samples() {
    for (program, keys, independent, paired) in [
        ("simulate.py", "seeds = \"sim\"", false, false),
        ("copy.py", "seeds = \"sim\"", false, false),
        ("other.py", "seeds = \"sim\"", false, true),
        ("simulate.py", "", true, false),
    ] {
        let result = again(program, keys);
        let pairs = result["comparisons"].as_array().expect("comparisons");
        assert!(!pairs.is_empty());
        for pair in pairs {
            assert_eq!(pair["independent"], independent, "{program} {keys}: {pair}");
            assert_eq!(pair["paired"] == true, paired, "{program} {keys}: {pair}");
            let same_runs = !independent && !paired;
            assert_eq!(pair["outcome"] == "not-comparable", same_runs, "{pair}");
            let reason = pair["reason"].as_str().expect("a reason");
            assert_eq!(reason.contains("are the same runs"), same_runs, "{reason}");
        }
        let piece = piece(&result, "again");
        assert_eq!(piece["shared_seeds"].is_null(), independent, "{piece}");
    }
}

#[test]
fn seeds_that_mean_something_else_are_settled_by_a_reason() {
    let keys = "seeds = \"sim\"\nindependent = { sim = \"it draws by another generator\" }";
    let result = again("other.py", keys);
    for pair in result["comparisons"].as_array().expect("comparisons") {
        assert_eq!(pair["independent"], true, "{pair}");
    }
    let question = &piece(&result, "again")["lineage_questions"][0];
    assert_eq!(question["settled"], "it draws by another generator");
    // No reason makes the same runs two.
    for pair in again("simulate.py", keys)["comparisons"]
        .as_array()
        .expect("comparisons")
    {
        assert_eq!(pair["outcome"], "not-comparable", "{pair}");
    }
}
