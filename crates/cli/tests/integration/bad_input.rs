//! Whatever is wrong with an input: exit code 2, one clear message with its place and a remedy, and nothing written.

use crate::support;

use support::program::{Said, Study};

/// The message is about `code`, contains `place`, and says what to do.
#[track_caller]
pub fn assert_refused(said: &Said, code: &str, place: &str) {
    assert_eq!(said.code, 2, "exit code: {said:?}");
    assert!(said.out.is_empty(), "something was printed: {said:?}");
    // Missing fields are told all at once, each as a message.
    let missing = said.talk.matches("]: missing field `").count();
    // And all words that no model knows.
    let missing = missing
        + said
            .talk
            .matches("]: no model of the study expresses `")
            .count();
    let errors = said.talk.matches("error[").count();
    assert_eq!(errors, missing.max(1), "one message:\n{}", said.talk);
    assert!(
        said.talk.contains(&format!("error[{code}]")),
        "expected {code}:\n{}",
        said.talk
    );
    assert!(
        said.talk.contains(place),
        "expected the place {place}:\n{}",
        said.talk
    );
    // A remedy stands on a line of its own, or ends the message behind a semicolon or colon.
    let remedy =
        said.talk.contains("= help: ") || said.talk.contains("; ") || said.talk.contains(": guard");
    assert!(remedy, "no remedy:\n{}", said.talk);
    assert!(!said.talk.contains("panicked"), "{}", said.talk);
}

/// Spoils a fresh study, runs it, and expects a refusal that leaves nothing behind.
#[track_caller]
fn refuses(spoil: impl FnOnce(&Study), code: &str, place: &str) {
    let study = Study::new();
    spoil(&study);
    let before = study.contents();
    let said = study.run(&["run", "study"]);
    assert_refused(&said, code, place);
    assert_eq!(study.contents(), before, "files were written or changed");
    assert!(!study.path("results").exists(), "a folder was left behind");
}

#[test]
fn a_syntax_error_in_a_model() {
    refuses(
        |s| {
            s.edit("model.prism", "->", "-");
        },
        "syntax",
        "study/model.prism:1",
    );
}

#[test]
fn a_probability_above_one() {
    refuses(
        |s| {
            s.edit("model.prism", "0.95", "1.95");
        },
        "not-a-probability",
        "study/model.prism:19:23",
    );
}

#[test]
fn a_constant_without_value() {
    refuses(
        |s| {
            s.edit("model.prism", " = 0.95", "");
        },
        "undefined-constant",
        "study/model.prism:10",
    );
}

#[test]
fn an_unknown_name_in_a_binding() {
    refuses(
        |s| {
            s.edit("vocabulary.toml", "robot=approach", "robot=aproach");
        },
        "unknown-name",
        "study/vocabulary.toml:9:10",
    );
}

#[test]
fn a_property_over_an_unknown_label() {
    refuses(
        |s| {
            s.edit("requirements.toml", "F \"docked\"", "F \"dokced\"");
        },
        "unknown-proposition",
        "study/requirements.toml:16",
    );
}

#[test]
fn a_study_without_requirements() {
    refuses(
        |s| {
            s.write("requirements.toml", "# none\n");
        },
        "no-requirements",
        "study/requirements.toml",
    );
    refuses(
        |s| std::fs::remove_file(s.path("requirements.toml")).expect("removed"),
        "cannot-read",
        "study/requirements.toml",
    );
}

#[test]
fn a_missing_column() {
    refuses(
        |s| {
            s.edit("attempts.csv", "successes", "good");
        },
        "bad-table",
        "study/vocabulary.toml:",
    );
}

#[test]
fn counts_that_are_none() {
    for count in ["1e30", "-3", "many", "99999999999999999999"] {
        refuses(
            |s| {
                s.edit("attempts.csv", "\n1,4,", &format!("\n1,{count},"));
            },
            "bad-table",
            "study/attempts.csv:2:1",
        );
    }
    refuses(
        |s| {
            s.edit("attempts.csv", "\n1,4,", "\n1,9,");
        },
        "bad-counts",
        "study/attempts.csv:2:1",
    );
    refuses(
        |s| {
            s.edit("failure_modes.csv", ",4,100", ",400,100");
        },
        "bad-counts",
        "study/failure_modes.csv:2:1",
    );
}

#[test]
fn a_row_with_too_few_cells() {
    refuses(
        |s| {
            s.edit("attempts.csv", "1,4,5,M\n", "1,4,5\n");
        },
        "bad-table",
        "study/attempts.csv:2:1",
    );
}

/// Which of two rows counts must not depend on their order.
#[test]
fn a_row_that_stands_twice() {
    refuses(
        |s| {
            s.edit(
                "failure_modes.csv",
                ",4,100",
                ",4,100\nmissed_contact,8,200",
            );
        },
        "duplicate-row",
        "study/failure_modes.csv:3:1",
    );
    refuses(
        |s| {
            s.edit("attempts.csv", "\n2,5,5,", "\n1,5,5,");
        },
        "duplicate-row",
        "study/attempts.csv:3:1",
    );
}

/// A misspelt code would go uncounted.
#[test]
fn a_code_that_nothing_counts() {
    refuses(
        |s| {
            s.edit("attempts.csv", "\n2,5,5,", "\n2,5,5,Q");
        },
        "unknown-code",
        "study/attempts.csv:3:1",
    );
}

#[test]
fn a_cohort_without_attempts() {
    refuses(
        |s| {
            s.write(
                "attempts.csv",
                "session,successes,attempts,failure_modes\n1,0,0,\n",
            );
        },
        "bad-counts",
        "study/attempts.csv",
    );
}

#[test]
fn tables_that_contradict_each_other() {
    refuses(
        |s| {
            s.edit("attempts.csv", "1,4,5,M\n", "1,4,5,\n");
        },
        "tables-disagree",
        "study/attempts.csv",
    );
}

#[test]
fn empty_files() {
    for (file, code) in [
        ("study.toml", "bad-study-file"),
        ("ledger.toml", "empty-ledger"),
        ("attempts.csv", "bad-table"),
        ("model.prism", "unknown-name"),
    ] {
        refuses(
            |s| {
                s.write(file, "");
            },
            code,
            "study/",
        );
    }
}

/// A sentence tells all its unknown names at once.
#[test]
fn an_empty_vocabulary() {
    let study = Study::new();
    study.write("vocabulary.toml", "");
    let said = study.run(&["run", "study"]);
    assert_eq!(said.code, 2, "{said:?}");
    assert_eq!(
        said.talk.matches("error[unknown-name]").count(),
        2,
        "{}",
        said.talk
    );
    assert!(
        said.talk.contains("study/requirements.toml:14:15"),
        "{}",
        said.talk
    );
}

#[test]
fn a_file_that_is_no_text() {
    refuses(
        |s| {
            s.write("study.toml", [0xff, 0xfe, 0x00]);
        },
        "not-text",
        "study/study.toml",
    );
    refuses(
        |s| {
            s.write("model.prism", [b'd', 0xc3, 0x00]);
        },
        "not-text",
        "study/model.prism",
    );
}

#[test]
fn huge_numbers() {
    refuses(
        |s| {
            s.edit("study.toml", "confidence = 0.95", "confidence = 1e400");
        },
        "bad-study-file",
        "study/study.toml:10:14",
    );
    refuses(
        |s| {
            s.edit("study.toml", "seed = 1", "seed = 99999999999999999999");
        },
        "bad-study-file",
        "study/study.toml:7:8",
    );
    refuses(
        |s| {
            s.edit("model.prism", "[0..3]", "[0..99999999999999999999]");
        },
        "literal-too-large",
        "study/model.prism:14",
    );
}

#[test]
fn levels_margins_and_thresholds_that_are_none() {
    refuses(
        |s| {
            s.edit("study.toml", "confidence = 0.95", "confidence = 95");
        },
        "bad-level",
        "study/study.toml:10",
    );
    refuses(
        |s| {
            s.edit("requirements.toml", "margin = 0.10", "margin = -1");
        },
        "bad-margin",
        "study/requirements.toml:15:10",
    );
    refuses(
        |s| {
            s.edit("requirements.toml", "at least 0.9", "at least 7");
        },
        "probability",
        "study/requirements.toml:14:44",
    );
    refuses(
        |s| {
            let both = "threshold = \"at least 7\"\nmargin = 0.10";
            s.edit("requirements.toml", "margin = 0.10", both);
        },
        "bad-threshold",
        "study/requirements.toml:15:13",
    );
}

#[test]
fn wrong_names_in_the_ledger() {
    refuses(
        |s| {
            s.edit("ledger.toml", "id = \"E2\"", "id = \"E1\"");
        },
        "duplicate-id",
        "study/ledger.toml:13:6",
    );
    refuses(
        |s| {
            s.edit("ledger.toml", "model.prism", "modle.prism");
        },
        "missing-file",
        "study/ledger.toml:9:9",
    );
    refuses(
        |s| {
            s.edit("ledger.toml", "\"typical\"", "\"tipical\"");
        },
        "unknown-conditions",
        "study/ledger.toml:8:14",
    );
    refuses(
        |s| {
            s.edit("ledger.toml", "changed", "chnaged");
        },
        "bad-study-file",
        "study/ledger.toml:",
    );
    refuses(
        |s| {
            s.edit("ledger.toml", "model-checking", "guessing");
        },
        "bad-study-file",
        "study/ledger.toml:7:13",
    );
}

#[test]
fn an_update_that_leaves_its_range_in_a_state_that_is_reached_late() {
    let study = Study::new();
    study.edit("model.prism", "attempts<3", "attempts<=3");
    let said = study.run(&["run", "study"]);
    assert_refused(&said, "cannot-explore", "study/model.prism:17");
    assert!(
        !study.path("results/report.html").exists(),
        "a report was left behind"
    );
}

#[test]
fn a_folder_that_cannot_be_written() {
    let study = Study::new();
    // Below a file, and below a folder of the system: refused to everyone, also to root.
    let before = study.contents();
    let said = study.run(&["run", "study", "--out", "study/study.toml/results"]);
    assert_refused(&said, "cannot-write", "study/study.toml/results");
    let said = study.run(&["run", "study", "--out", "/proc/corroborate"]);
    assert_refused(&said, "cannot-write", "/proc/corroborate");
    let said = study.run(&["init", "study/model.prism/new"]);
    assert_refused(&said, "cannot-write", "study/model.prism/new");
    assert_eq!(study.contents(), before, "files were written or changed");
}

#[test]
fn a_results_folder_that_is_a_file() {
    let study = Study::new();
    study.write("results", "mine");
    let said = study.run(&["run", "study"]);
    assert_refused(&said, "cannot-write", "study/results");
    assert_eq!(
        std::fs::read(study.path("results")).expect("still there"),
        b"mine"
    );
}

#[test]
fn what_is_not_there() {
    let study = Study::new();
    assert_refused(&study.run(&["run", "nowhere"]), "no-study", "nowhere");
    assert_refused(
        &study.run(&["run", "study", "--only", "E9"]),
        "unknown-evidence",
        "E9",
    );
    assert_refused(&study.run(&["report", "study"]), "not-run", "study/results");
    assert_refused(
        &study.run(&["compare", "study"]),
        "not-run",
        "study/results",
    );
    assert_refused(
        &study.run(&["simulate", "study", "E1", "--out", "x"]),
        "not-a-simulation",
        "E1",
    );
    assert_refused(
        &study.run(&["explain", "nonsense"]),
        "unknown-topic",
        "nonsense",
    );
    assert_refused(&study.run(&["init", "study"]), "folder-not-empty", "study");
    assert_refused(
        &study.run(&["check", "nothing.prism"]),
        "cannot-read",
        "nothing.prism",
    );
    assert_refused(&study.run(&["check", "study"]), "cannot-read", "study");
}

#[test]
fn bad_recordings() {
    let study = Study::new();
    let file = |name: &str, content: &[u8]| {
        std::fs::write(study.beside().join(name), content).expect("written")
    };
    file("empty.mcap", b"");
    file("zeros.mcap", &[0; 300]);
    file("head.mcap", b"\x89MCAP0\r\n");
    file("table.csv", b"time_secs,/robot.x\n0,1\n");
    file(
        "untimed.csv",
        b"/robot.state,/battery.charging\napproach,false\n",
    );
    for (name, code, place) in [
        ("empty.mcap", "bad-recording", "empty.mcap"),
        ("zeros.mcap", "bad-recording", "zeros.mcap"),
        ("missing.mcap", "bad-recording", "missing.mcap"),
        ("untimed.csv", "bad-recording", "untimed.csv"),
        ("table.csv", "bad-predicate", "study/vocabulary.toml:10"),
    ] {
        let said = study.run(&["monitor", "study", name]);
        assert_refused(&said, code, place);
    }
    let said = study.run(&["monitor", "study", "head.mcap"]);
    assert!(matches!(said.code, 2 | 3), "{said:?}");
}

/// A speed is compared with a force: which units signals have is known with the recording, the place is in the study.
#[test]
fn predicates_whose_units_do_not_go_together() {
    let header = "time_secs,/robot.state,/battery.charging,/odometry.speed [m/s],/scanner.person_distance [m]";
    let rows = "0,approach,false,0.1,3\n1,docked,true,0.1,3\n";
    let wrong = "/odometry.speed > 1 N";
    let staged = format!("wait_for = \"{wrong}\"");
    let formula = format!("formula = \"G ({wrong})\"");
    let said = |spoil: &dyn Fn(&Study)| {
        let study = Study::new();
        spoil(&study);
        std::fs::write(study.beside().join("r.csv"), format!("{header}\n{rows}")).expect("written");
        study.run(&["monitor", "study", "r.csv"])
    };
    let in_stages = said(&|study| {
        study.edit("requirements.toml", "wait_for = \"docked\"", &staged);
    });
    assert_refused(&in_stages, "bad-predicate", "study/requirements.toml:18:31");
    let in_formula = said(&|study| {
        study.edit(
            "requirements.toml",
            "monitor.when = \"approaching\"",
            &formula,
        );
        let stages = "monitor.then = [{ wait_for = \"docked\", within_secs = 60 }]\nmonitor.at_end = \"fail_pending\"\n";
        study.edit("requirements.toml", stages, "");
    });
    assert_refused(
        &in_formula,
        "bad-predicate",
        "study/requirements.toml:17:15",
    );
    for said in [in_stages, in_formula] {
        assert!(
            said.talk.contains("`/odometry.speed > 1 N`"),
            "{}",
            said.talk
        );
    }
    let in_vocabulary = said(&|study| {
        let bound = "trace = \"/odometry.speed\"";
        study.edit(
            "vocabulary.toml",
            bound,
            "trace = \"/odometry.speed + 1 N\"",
        );
    });
    assert_refused(&in_vocabulary, "bad-predicate", "study/vocabulary.toml:");
}

/// Keys that a technique does not use are no decoration.
#[test]
fn keys_of_other_techniques_are_refused() {
    for key in [
        "scenario = \"model.prism\"",
        "recordings = \"runs\"",
        "episodes = 100",
    ] {
        refuses(
            |s| {
                s.edit(
                    "ledger.toml",
                    "model = \"model.prism\"",
                    &format!("model = \"model.prism\"\n{key}"),
                );
            },
            "bad-ledger",
            "study/ledger.toml:",
        );
    }
}
