//! Recordings that end before what a requirement asks for: they do not show that it was kept, nor that it was not.

use crate::lacking_signals::finding;
use crate::support::program::{Said, corroborate};
use tempfile::TempDir;

const STUDY: &str = r#"
title = "A gripper that has to hold for ten seconds"
summary = "Some trials were stopped early."
seed = 1
confidence = 0.95
agreement = 0.95
[conditions]
typical = "As usual."
"#;

const VOCABULARY: &str = r#"
[held]
meaning = "the gripper presses with more than 2 N"
trace = "/gripper.force > 2 N"
"#;

const LEDGER: &str = r#"
[[evidence]]
id = "O"
title = "Trials"
technique = "operation"
conditions = "typical"
recordings = "recordings"
changed = "The first."
"#;

const TOPICS: &str = "[\"/gripper.force\"]\nfrom = \"/gripper.force\"\nunit = \"N\"\n";

/// A gripper that holds until the recording ends, after so many seconds.
fn holding(secs: u32) -> String {
    let rows = (0..=secs * 10).map(|tenth| format!("{},{}\n", f64::from(tenth) / 10.0, 5));
    format!("time_secs,/gripper.force [N]\n{}", rows.collect::<String>())
}

fn run(judging: &str, recordings: &[String]) -> (TempDir, Said) {
    let folder = TempDir::new().expect("a folder");
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().expect("a folder")).expect("made");
        std::fs::write(path, text).expect("written");
    };
    write("study.toml", STUDY);
    let requirement = format!(
        "[[requirement]]\nid = \"hold\"\ntext = \"The gripper holds for 10 s.\"\n{judging}\n"
    );
    write("requirements.toml", &requirement);
    write("vocabulary.toml", VOCABULARY);
    write("ledger.toml", LEDGER);
    write("topics.toml", TOPICS);
    for (number, text) in recordings.iter().enumerate() {
        write(&format!("recordings/{number:02}.csv"), text);
    }
    let said = corroborate(folder.path(), &["run", "."]);
    (folder, said)
}

#[test]
fn recordings_that_end_too_early_are_counted_against_and_for() {
    let all = [holding(12), holding(5), holding(12), holding(5)];
    for judging in [
        "formula = \"always[0, 10 s] held\"",
        "shall = \"The gripper shall for 10 seconds satisfy held.\"",
    ] {
        let (folder, said) = run(judging, &all);
        let told = "O: 2 of 4 recordings end before the 10 s that requirement hold asks for, and reach no verdict on it";
        assert!(said.talk.contains(told), "{said:?}");
        let hold = finding(folder.path(), "hold");
        assert_eq!(
            (&hold["measure"]["count"], &hold["measure"]["trials"]),
            (&2.into(), &2.into()),
            "{judging}: {hold}"
        );
        assert_eq!(hold["undecided"], 2, "{judging}");
        let why = "A run that ends before the 10 s that the requirement asks for (from its first trigger on, if it has one) may reach none";
        let words: Vec<&str> = said.out.split_whitespace().collect();
        assert!(words.join(" ").contains(why), "{said:?}");
    }
}

#[test]
fn where_all_end_too_early_nothing_is_covered_and_the_finding_says_why() {
    let (folder, said) = run(
        "formula = \"always[0, 10 s] held\"",
        &[holding(5), holding(5)],
    );
    assert_eq!(said.code, 3, "{said:?}");
    let hold = finding(folder.path(), "hold");
    let reason = hold["measure"]["reason"].as_str().expect("a reason");
    assert!(reason.ends_with("it asks for 10 s of a run."), "{reason}");
}

/// Who says that the recording is all there is, is taken at the word.
#[test]
fn a_study_may_say_that_nothing_comes_behind_the_end() {
    let judging = "formula = \"always[0, 10 s] held\"\nending = \"finite\"";
    let (folder, _) = run(judging, &[holding(5), holding(5)]);
    let hold = finding(folder.path(), "hold");
    assert_eq!(hold["measure"]["count"], 2, "{hold}");
    assert_eq!(hold["undecided"], 0);
}

#[test]
fn a_formula_alone_says_what_it_asks_for() {
    let folder = TempDir::new().expect("a folder");
    std::fs::write(folder.path().join("run.csv"), holding(5)).expect("written");
    let monitor = |more: &[&str]| {
        let formula = "always[0, 10 s] (/gripper.force > 2 N)";
        let arguments = [&["monitor", "--formula", formula, "run.csv"], more].concat();
        corroborate(folder.path(), &arguments)
    };
    let said = monitor(&[]);
    assert_eq!(said.code, 3, "{said:?}");
    let told = "is inconclusive: it asks for 10 s, and the recording ends before";
    assert!(said.out.contains(told), "{said:?}");
    assert_eq!(monitor(&["--ending", "finite"]).code, 0);
}

/// Ten seconds in which the force drops for a second at these times, and is regained where `regained` says so.
fn dropping(drops_secs: &[u32], regained: bool) -> String {
    let force = |tenth: u32| match drops_secs.contains(&(tenth / 10)) {
        true => 0,
        false if regained || drops_secs.iter().all(|at| tenth / 10 < *at) => 5,
        false => 1,
    };
    let rows = (0..=100).map(|tenth| format!("{},{}\n", f64::from(tenth) / 10.0, force(tenth)));
    format!("time_secs,/gripper.force [N]\n{}", rows.collect::<String>())
}

/// What is asked for in the last second of a recording is no violation, and nothing that was kept.
#[test]
fn what_is_pending_at_the_end_is_open_or_left_out_with_its_number() {
    let asked = "formula = \"always (/gripper.force < 0.5 N => eventually[0, 5 s] held)\"";
    let late = || dropping(&[9], false);
    let (folder, said) = run(asked, &[late(), late(), late()]);
    assert_eq!(said.code, 3, "{said:?}");
    let hold = finding(folder.path(), "hold");
    let pending = (&hold["undecided"], &hold["measure"]["kind"]);
    assert_eq!(pending, (&3.into(), &"not-covered".into()), "{hold}");

    let again = dropping(&[2, 10], true);
    let never = dropping(&[2], false);
    let (folder, said) = run(asked, &[again.clone(), again, never]);
    let hold = finding(folder.path(), "hold");
    let counts = (&hold["measure"]["count"], &hold["measure"]["trials"]);
    assert_eq!(counts, (&2.into(), &3.into()), "{hold}");
    assert_eq!(hold["left_out"], 2, "{hold}");
    let told =
        "in 2 of 3 recordings something of requirement hold began in the last 5 s and is pending";
    assert!(said.talk.contains(told), "{said:?}");
    let words: Vec<&str> = said.out.split_whitespace().collect();
    let why = "In 2 runs of O something that the requirement asks for was pending at the end";
    assert!(words.join(" ").contains(why), "{said:?}");
}
