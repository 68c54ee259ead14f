//! Programs that a study names, which run only once the user has allowed them: the program as a stranger's study meets it, with a
//! folder of records of its own. Needs `python3`.

use crate::support;

use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::{Path, PathBuf};
use support::program::{Said, Study, command, said};
use tempfile::TempDir;

/// A study of somebody else on the machine of somebody who has allowed nothing.
struct Strangers {
    study: Study,
    state: TempDir,
}

/// What a program of the study leaves beside it once it runs.
const RAN: &str = "ran";

impl Strangers {
    /// The template with an outside simulator, which says that it ran.
    fn new() -> Self {
        let strangers = Self {
            study: Study::of_template("command"),
            state: TempDir::new().expect("a folder"),
        };
        let says = format!("import json\nopen({:?}, 'w').close()\n", strangers.mark());
        strangers.study.edit("simulate.py", "import json\n", &says);
        strangers
            .study
            .edit("ledger.toml", "episodes = 60", "episodes = 3");
        strangers
    }

    /// The template with a robot whose program drives it in a scene, in the physics that is built in.
    fn with_scene() -> Self {
        let strangers = Self {
            study: Study::of_template("mobile"),
            state: TempDir::new().expect("a folder"),
        };
        let mark = strangers.mark();
        let driver = std::fs::read_to_string(strangers.study.path(DRIVER)).expect("read");
        let says = format!("open({mark:?}, 'w').close()\n");
        // Behind the text that describes it and what it imports from the future, if any.
        let driver = driver.replacen("import ", &format!("{says}import "), 1);
        assert!(driver.contains(&says));
        strangers.study.write(DRIVER, driver);
        let in_rapier = "engine = \"rapier\"\nepisodes = 2";
        strangers
            .study
            .edit("ledger.toml", "episodes = 30", in_rapier);
        strangers
    }

    fn mark(&self) -> PathBuf {
        self.study.beside().join(RAN)
    }

    /// Whether one of its programs ran; then it is forgotten.
    fn ran(&self) -> bool {
        std::fs::remove_file(self.mark()).is_ok()
    }

    fn run(&self, arguments: &[&str]) -> Said {
        self.with("CORROBORATE_TRUST", "", arguments)
    }

    fn with(&self, variable: &str, value: &str, arguments: &[&str]) -> Said {
        let mut call = command(self.study.beside(), arguments);
        call.env("CORROBORATE_TRUST", "")
            .env("XDG_STATE_HOME", self.state.path())
            .env(variable, value);
        said(&mut call)
    }

    /// Fails if the call was not refused before a program ran. What was said.
    fn refused(&self, arguments: &[&str]) -> String {
        let said = self.run(arguments);
        assert_eq!(said.code, 2, "{arguments:?}: {said:?}");
        assert!(
            said.talk.contains("error[not-trusted]"),
            "{arguments:?}: {said:?}"
        );
        assert!(
            said.talk.contains("corroborate trust"),
            "{arguments:?}: {said:?}"
        );
        assert!(!self.ran(), "{arguments:?}: a program ran");
        said.talk
    }

    /// Fails if no program ran, or the call ended with a mistake.
    fn runs(&self, arguments: &[&str]) -> Said {
        let said = self.run(arguments);
        assert_ne!(said.code, 2, "{arguments:?}: {said:?}");
        assert!(self.ran(), "{arguments:?}: no program ran: {said:?}");
        said
    }
}

const DRIVER: &str = "controller/driver.py";

/// Runs an episode, unless it is there.
const SIMULATE: [&str; 7] = ["simulate", "study", "S1", "--episodes", "1", "--out", "o"];

#[test]
fn no_command_runs_a_strangers_program() {
    let strangers = Strangers::new();
    for arguments in [
        &["run", "study"][..],
        &["run", "study", "--only", "S1"],
        &["simulate", "study", "S1", "--episodes", "1", "--out", "out"],
        &["engines", "study", "S1", "--against", "S1"],
        &["engines", "study", "S1", "--determinism"],
        &["replay", "study", "S1:1"],
    ] {
        let talk = strangers.refused(arguments);
        assert!(talk.contains("ledger.toml:25:11"), "{arguments:?}: {talk}");
    }
}

#[test]
fn a_scenes_programs_are_asked_for_before_one_is_started() {
    let strangers = Strangers::with_scene();
    for arguments in [
        &["run", "study"][..],
        &["simulate", "study", "S1", "--episodes", "1", "--out", "out"],
        &["engines", "study", "S1", "-n", "1", "--determinism"],
        &["inspect", "study"],
        &["watch", "study", "--rest", "S1", "--dds", "77"],
    ] {
        let said = strangers.run(arguments);
        assert!(!strangers.ran(), "{arguments:?}: {said:?}");
        assert_eq!(said.code, 2, "{arguments:?}: {said:?}");
    }
    let talk = strangers.refused(&["run", "study"]);
    assert!(talk.contains("simulation/scene.toml:117:11"), "{talk}");
    strangers.runs(&["inspect", "study", "--trust"]);
    strangers.runs(&["run", "study", "--trust"]);
    // What is fresh cannot be told without its controllers, so it is asked for all the same.
    strangers.refused(&["run", "study"]);
    assert_eq!(strangers.run(&["compare", "study"]).code, 0);
}

#[test]
fn what_runs_no_program_works() {
    let strangers = Strangers::new();
    let model = strangers.run(&["run", "study", "--only", "M1", "--only", "T1"]);
    assert_ne!(model.code, 2, "{model:?}");
    assert!(strangers.study.path("results/evidence/M1.json").exists());
    let planned = strangers.run(&["plan", "study"]);
    assert_eq!(planned.code, 0, "{planned:?}");
    assert!(planned.out.contains("was not allowed"), "{planned:?}");
    assert_eq!(strangers.run(&["requirements", "study"]).code, 0);
    assert!(!strangers.ran());
    // What was produced once is compared, reported and verified without being produced.
    let whole = strangers.runs(&["run", "study", "--trust"]);
    for arguments in [
        &["run", "study"][..],
        &["compare", "study"],
        &["report", "study"],
        &["verify", "study/results"],
        &["diagnose", "study"],
    ] {
        let said = strangers.run(arguments);
        assert_ne!(said.code, 2, "{arguments:?}: {said:?}");
        assert!(!strangers.ran(), "{arguments:?}");
    }
    assert_eq!(strangers.run(&["run", "study"]).code, whole.code);
}

#[test]
fn a_study_is_allowed_as_it_is_and_asked_for_when_it_changes() {
    let strangers = Strangers::new();
    let shown = strangers.run(&["trust", "study", "--show"]);
    let line = "ledger.toml:25: S1: python3 simulate.py {stimulus} {seed} {recording}";
    assert!(shown.out.contains(line), "{shown:?}");
    strangers.refused(&["run", "study"]);
    let allowed = strangers.run(&["trust", "study"]);
    assert!(
        allowed.out.contains(line) && allowed.code == 0,
        "{allowed:?}"
    );
    strangers.runs(&["run", "study"]);
    // Neither what the run left nor a trial more is a program.
    let trials = std::fs::read_to_string(strangers.study.path("trials.csv")).expect("read");
    strangers.study.write("trials.csv", trials + "\n");
    strangers.runs(&["simulate", "study", "S1", "--episodes", "1", "--out", "out"]);

    strangers
        .study
        .edit("simulate.py", "LONGEST_MS = 10_000", "LONGEST_MS = 10_001");
    let talk = strangers.refused(&["run", "study"]);
    assert!(
        talk.contains("has changed") && talk.contains("simulate.py was changed"),
        "{talk}"
    );
    strangers
        .study
        .edit("simulate.py", "LONGEST_MS = 10_001", "LONGEST_MS = 10_000");
    strangers.runs(&[
        "simulate",
        "study",
        "S1",
        "--episodes",
        "1",
        "--out",
        "out2",
    ]);

    strangers.study.write("json.py", "open('../stolen', 'w')\n");
    let talk = strangers.refused(&SIMULATE);
    assert!(talk.contains("json.py is new"), "{talk}");
    // What runs no program, since nothing is stale, is not asked for.
    assert_ne!(strangers.run(&["run", "study"]).code, 2);
    assert!(!strangers.ran());
    std::fs::remove_file(strangers.study.path("json.py")).expect("removed");
    strangers
        .study
        .edit("ledger.toml", "\"simulate.py\"", "\"-B\", \"simulate.py\"");
    let talk = strangers.refused(&["run", "study"]);
    assert!(talk.contains("ledger.toml was changed"), "{talk}");
    strangers.run(&["trust", "study"]);
    strangers.runs(&["run", "study"]);

    assert!(
        strangers
            .run(&["trust", "--list"])
            .out
            .contains("study: with the content")
    );
    strangers.run(&["trust", "study", "--revoke"]);
    strangers
        .study
        .edit("ledger.toml", "episodes = 3", "episodes = 4");
    let talk = strangers.refused(&["run", "study"]);
    assert!(talk.contains("was not allowed"), "{talk}");
    let none = strangers.run(&["trust", "--list"]);
    assert!(none.out.contains("No study is allowed"), "{none:?}");
}

/// What is done to a study.
type Change<'c> = &'c dyn Fn(&Strangers);

/// Programs that change without the study's texts: each has to be asked for anew.
#[test]
fn a_program_that_is_swapped_is_seen() {
    let swaps: [(&str, Change); 6] = [
        ("simulate.py was changed", &|it| {
            let other = it.study.beside().join("other.py");
            std::fs::copy(it.study.path("simulate.py"), &other).expect("copied");
            std::fs::remove_file(it.study.path("simulate.py")).expect("removed");
            symlink(other, it.study.path("simulate.py")).expect("linked");
        }),
        ("linked.py was changed", &|it| {
            // What a link leads to lies elsewhere, and changes there.
            std::fs::write(it.study.beside().join("away.py"), "evil").expect("written");
        }),
        ("beside.py was changed", &|it| {
            std::fs::write(it.study.beside().join("beside.py"), "evil").expect("written");
        }),
        ("results/step.py was changed", &|it| {
            it.study.write("results/step.py", "evil");
        }),
        ("step.csv was changed", &|it| {
            it.study.write("step.csv", "evil");
        }),
        ("__pycache__/simulate.cpython-311.pyc is new", &|it| {
            it.study
                .write("__pycache__/simulate.cpython-311.pyc", "evil");
        }),
    ];
    for (expected, swap) in swaps {
        let strangers = Strangers::new();
        std::fs::write(strangers.study.beside().join("away.py"), "1").expect("written");
        std::fs::write(strangers.study.beside().join("beside.py"), "1").expect("written");
        symlink("../away.py", strangers.study.path("linked.py")).expect("linked");
        strangers
            .study
            .write("results/step.py", "1")
            .write("step.csv", "1");
        let assets = "assets = [\"results/step.py\", \"step.csv\"]\nleaves = \"csv\"";
        strangers
            .study
            .edit("ledger.toml", "leaves = \"csv\"", assets);
        // A word that names a file beside the study.
        let own = "\"{recording}\"]";
        strangers
            .study
            .edit("ledger.toml", own, "\"{recording}\", \"../beside.py\"]");
        let allowed = strangers.run(&["trust", "study"]);
        assert_eq!(allowed.code, 0, "{allowed:?}");
        strangers.refused_after(swap, expected);
    }
}

impl Strangers {
    fn refused_after(&self, swap: &dyn Fn(&Strangers), expected: &str) {
        swap(self);
        let arguments = ["trust", "study", "--show"];
        assert_eq!(self.run(&arguments).code, 0);
        let talk = self.refused(&["simulate", "study", "S1", "--episodes", "1", "--out", "o"]);
        assert!(talk.contains(expected), "{expected}: {talk}");
    }
}

#[test]
fn content_that_could_change_unseen_is_not_allowed() {
    let strangers = Strangers::new();
    symlink("/usr/share", strangers.study.path("modules")).expect("linked");
    let said = strangers.run(&["trust", "study"]);
    assert!(
        said.code == 2 && said.talk.contains("error[link-leads-out]"),
        "{said:?}"
    );
    std::fs::remove_file(strangers.study.path("modules")).expect("removed");
    // Results are not part of it, so what leads into them is not either.
    std::fs::create_dir_all(strangers.study.path("results/inner")).expect("made");
    symlink("results/inner", strangers.study.path("modules")).expect("linked");
    let said = strangers.run(&["trust", "study"]);
    assert!(
        said.code == 2 && said.talk.contains("error[link-leads-out]"),
        "{said:?}"
    );
}

#[test]
fn ones_own_study_is_allowed_whatever_it_contains() {
    let strangers = Strangers::new();
    let said = strangers.run(&["trust", "study", "--always"]);
    assert!(
        said.out.contains("whatever its folder will contain"),
        "{said:?}"
    );
    strangers.runs(&["run", "study"]);
    strangers
        .study
        .edit("simulate.py", "LONGEST_MS = 10_000", "LONGEST_MS = 10_001");
    strangers.runs(&["run", "study"]);
    // It is this folder that is allowed, not one of its name, nor one below it.
    let moved = strangers.study.beside().join("moved");
    std::fs::rename(strangers.study.path(""), &moved).expect("moved");
    strangers.refused(&["simulate", "moved", "S1", "--episodes", "1", "--out", "o"]);
    let below = strangers.study.path("inner");
    std::fs::create_dir_all(strangers.study.path("")).expect("made");
    std::fs::rename(&moved, &below).expect("moved");
    strangers.refused(&[
        "simulate",
        "study/inner",
        "S1",
        "--episodes",
        "1",
        "--out",
        "o",
    ]);
}

#[test]
fn who_makes_a_study_may_run_it() {
    let strangers = Strangers::new();
    let made = strangers.run(&["init", "own", "--template", "command"]);
    assert_eq!(made.code, 0, "{made:?}");
    let run = strangers.run(&["simulate", "own", "S1", "--episodes", "1", "--out", "o"]);
    assert_ne!(run.code, 2, "{run:?}");
    let listed = strangers.run(&["trust", "--list"]);
    assert!(
        listed.out.contains("own: whatever it contains"),
        "{listed:?}"
    );
}

#[test]
fn a_call_and_the_environment_allow_what_they_name() {
    let strangers = Strangers::new();
    let beside = std::fs::canonicalize(strangers.study.beside()).expect("there");
    let beside = beside.to_str().expect("UTF-8");
    for (value, allows) in [
        (beside.to_owned(), true),
        (format!("/nowhere:{beside}/study"), true),
        (format!("{beside}/stud"), false),
        ("study".to_owned(), false),
        (".".to_owned(), false),
        ("1".to_owned(), false),
    ] {
        let said = strangers.with("CORROBORATE_TRUST", &value, &SIMULATE);
        let _ = std::fs::remove_dir_all(strangers.study.beside().join("o"));
        assert_eq!(strangers.ran(), allows, "{value}: {said:?}");
        assert_eq!(said.code == 2, !allows, "{value}: {said:?}");
    }
    strangers.runs(&[&SIMULATE[..], &["--trust"]].concat());
    std::fs::remove_dir_all(strangers.study.beside().join("o")).expect("removed");
    strangers.refused(&SIMULATE);
}

#[test]
fn records_are_the_users_alone() {
    let strangers = Strangers::new();
    let simulate = SIMULATE;
    strangers.run(&["trust", "study", "--always"]);
    let records = strangers.state.path().join("corroborate/trust");
    let mut files = std::fs::read_dir(&records).expect("records").flatten();
    let record = files.next().expect("one").path();
    let mode = |path: &Path| std::fs::metadata(path).expect("there").permissions().mode() & 0o777;
    assert_eq!((mode(&record), mode(&records)), (0o600, 0o700));
    strangers.runs(&simulate);
    // Who else may write it may be the stranger.
    let open = std::fs::Permissions::from_mode(0o666);
    std::fs::set_permissions(&record, open).expect("changed");
    let talk = strangers.refused(&simulate);
    assert!(talk.contains("written by others"), "{talk}");
    // A study that brings its records, and one around them.
    let brought = strangers.study.path("state/corroborate/trust");
    std::fs::create_dir_all(&brought).expect("made");
    let shut = std::fs::Permissions::from_mode(0o600);
    std::fs::set_permissions(&record, shut).expect("changed");
    std::fs::rename(&record, brought.join(record.file_name().expect("a name"))).expect("moved");
    let state = strangers.study.path("state");
    let state = state.to_str().expect("UTF-8");
    let said = strangers.with("XDG_STATE_HOME", state, &simulate);
    assert!(said.code == 2 && !strangers.ran(), "{said:?}");
    let said = strangers.with("XDG_STATE_HOME", state, &["trust", "study"]);
    assert!(said.talk.contains("error[records-in-study]"), "{said:?}");
    let mut nowhere = command(strangers.study.beside(), &["trust", "study"]);
    let nowhere = said_of(nowhere.env("XDG_STATE_HOME", "").env("HOME", ""));
    assert!(
        nowhere.talk.contains("error[no-records-of-trust]"),
        "{nowhere:?}"
    );
}

fn said_of(command: &mut std::process::Command) -> Said {
    said(command)
}

/// A program may not be named where content is not looked at.
#[test]
fn a_scene_among_results_is_not_part_of_what_was_allowed() {
    let strangers = Strangers::with_scene();
    let from = strangers.study.path("simulation");
    std::fs::rename(from, strangers.study.path("results")).expect("moved");
    strangers
        .study
        .edit("ledger.toml", "simulation/scene.toml", "results/scene.toml");
    let said = strangers.run(&["trust", "study"]);
    assert_eq!(said.code, 0, "{said:?}");
    let talk = strangers.refused(&["run", "study"]);
    assert!(talk.contains("not part of what was allowed"), "{talk}");
}

/// What the user types is the user's.
#[test]
fn a_test_that_is_typed_is_not_asked_for() {
    let strangers = Strangers::new();
    let said = strangers.run(&[
        "decide",
        "--at-least",
        "0.5",
        "--out",
        "d",
        "--",
        "sh",
        "-c",
        "true {seed}",
    ]);
    assert!(!said.talk.contains("not-trusted"), "{said:?}");
    assert_eq!(said.code, 0, "{said:?}");
}
