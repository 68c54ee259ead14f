//! `corroborate diagnose`: the matrix of a study, and who is named for planted faults.

use crate::support;

use serde_json::Value;
use support::program::{Said, Study};
use support::schema::violations;

fn diagnosed(study: &Study) -> (Said, Value) {
    let said = study.run(&["run", "study", "--quiet"]);
    assert!([0, 1, 3].contains(&said.code), "{said:?}");
    let said = study.run(&["diagnose", "study", "--format", "json", "--quiet"]);
    let diagnosis = serde_json::from_str(&said.out).unwrap_or_else(|e| panic!("{e}: {said:?}"));
    (said, diagnosis)
}

fn cell<'v>(diagnosis: &'v Value, letter: &str, subject: &str) -> &'v Value {
    let cells = diagnosis["cells"].as_array().expect("cells");
    let wanted = |c: &&Value| c["cell"] == letter && c["subject"]["id"] == subject;
    cells.iter().find(wanted).expect("the cell is there")
}

fn first(diagnosis: &Value) -> &Value {
    &diagnosis["suspects"][0]
}

#[test]
fn a_study_in_order_has_no_strong_suspect_and_its_matrix_is_kept() {
    let study = Study::new();
    let (_, diagnosis) = diagnosed(&study);
    let schema = support::read(&support::root().join("schemas/diagnose.schema.json"));
    let schema: Value = serde_json::from_str(&schema).expect("a schema");
    assert_eq!(violations(&schema, &diagnosis), Vec::<String>::new());
    // The property is judged on paths, and the computed answer lies in what they show.
    let a = cell(&diagnosis, "A", "1");
    assert_eq!(
        (a["runs"].as_u64(), a["undecided"].as_u64()),
        (Some(1000), Some(0))
    );
    // The monitor limits seconds, and a step of the model has no duration.
    let d = cell(&diagnosis, "D", "1");
    let why = d["not_judged"].as_str().expect("a reason");
    assert!(why.contains("seconds"), "{why}");
    let in_order = diagnosis["in_order"][0].as_str().expect("a sentence");
    assert!(in_order.contains("0 differ beyond chance"), "{in_order}");
    let suspects = diagnosis["suspects"].as_array().expect("suspects");
    assert!(
        suspects.iter().all(|s| s["score"].as_f64() < Some(1.0)),
        "{suspects:?}"
    );
    // It is in the result and on the page, stays there, and is verified.
    let result: Value =
        serde_json::from_str(&support::read(&study.path("results/study.json"))).expect("JSON");
    assert_eq!(result["diagnosis"], diagnosis);
    assert!(support::read(&study.path("results/report.html")).contains("id=\"suspects\""));
    let verified = study.run(&["verify", "study/results"]);
    assert_eq!(verified.code, 0, "{verified:?}");
    let deep = study.run(&["verify", "study/results", "--deep"]);
    assert_eq!(deep.code, 0, "{deep:?}");
    let said = "values of the diagnosis follow from making it again";
    assert!(deep.out.contains(said), "{deep:?}");
    study.run(&["run", "study", "--quiet"]);
    let again: Value =
        serde_json::from_str(&support::read(&study.path("results/study.json"))).expect("JSON");
    assert_eq!(again["diagnosis"], diagnosis);
    // The same at any number of threads.
    let (one, two) = (["-j", "1"], ["-j", "2"]);
    let run = |threads: [&str; 2]| {
        study
            .run(&[&["diagnose", "study", "--quiet"], &threads[..]].concat())
            .out
    };
    assert_eq!(run(one), run(two));
}

#[test]
fn a_wrong_rate_in_the_model_is_named_first_by_its_file() {
    let study = Study::new();
    study.edit("model.prism", "pTouches = 0.95", "pTouches = 0.5");
    let (said, diagnosis) = diagnosed(&study);
    assert_eq!(said.code, 1, "{said:?}");
    let suspect = first(&diagnosis);
    assert_eq!(suspect["asset"]["file"], "model.prism", "{suspect}");
    assert_eq!(suspect["inaccuracy"], "system-model");
    assert!(suspect["score"].as_f64() > Some(2.0), "{suspect}");
}

#[test]
fn a_failure_mode_that_the_model_lacks_is_named_first_by_its_file() {
    let study = Study::new();
    // The model's word for it is another one: no constant of that name, so it cannot express it.
    study.edit("vocabulary.toml", "model = \"robot=missed\"\n", "");
    study.edit("requirements.toml", "occurs = 'P=? [ F \"missed\" ]'\n", "");
    study.edit(
        "requirements.toml",
        "opportunity = 'P=? [ F \"arrived\" ]'\n",
        "",
    );
    let (said, diagnosis) = diagnosed(&study);
    let suspect = first(&diagnosis);
    assert_eq!(suspect["asset"]["file"], "model.prism", "{said:?}");
    assert_eq!(suspect["symptoms"][0]["kind"], "missing-mode");
    assert_eq!(suspect["symptoms"][0]["mode"], "missed_contact");
}

#[test]
fn a_path_is_shown_and_what_is_no_path_is_said() {
    let study = Study::new();
    let said = study.run(&["diagnose", "study", "--show", "E1:3"]);
    assert_eq!(said.code, 0, "{said:?}");
    assert!(said.out.contains("approaching"), "{}", said.out);
    assert_eq!(
        said.out,
        study.run(&["diagnose", "study", "--show", "E1:3"]).out
    );
    for wrong in ["E2:1", "E1:0", "E1", "E1:x"] {
        let said = study.run(&["diagnose", "study", "--show", wrong]);
        assert_eq!(said.code, 2, "{wrong}: {said:?}");
        assert!(said.talk.contains("bad-path"), "{wrong}: {}", said.talk);
    }
    let said = study.run(&["diagnose", "study"]);
    assert!(said.code == 2 && said.talk.contains("not-run"), "{said:?}");
}

#[test]
fn results_of_other_files_are_not_diagnosed() {
    let study = Study::new();
    study.run(&["run", "study", "--quiet"]);
    let text = support::read(&study.path("model.prism"));
    study.write("model.prism", format!("{text}\n// another file\n"));
    let said = study.run(&["diagnose", "study"]);
    assert!(
        said.code == 2 && said.talk.contains("stale-result"),
        "{said:?}"
    );
}

/// Two experiments, told in tables of which the second has ten rows of the first among its own.
fn told_twice(repeated: bool) -> (Said, Value) {
    let study = Study::new();
    let row = |session: u64, salt: u64| {
        let successes = 20 + (session * 7 + salt * session * session) % 11;
        let missed = "M ".repeat(30 - successes as usize);
        format!(
            "{session},{},{successes},30,{missed}\n",
            20 + (session * salt) % 9
        )
    };
    let table = |rows: String| format!("session,age,successes,attempts,failure_modes\n{rows}");
    let first: String = (1..=11).map(|session| row(session, 1)).collect();
    let second: String = (1..=13)
        .map(|session| match repeated && session <= 10 {
            true => row(session, 1),
            false => row(session, 4),
        })
        .collect();
    study.write("first.csv", table(first));
    study.write("second.csv", table(second));
    let entry = |id: &str, file: &str| {
        format!(
            "\n[[evidence]]\nid = \"{id}\"\ntitle = \"{id}\"\ntechnique = \"experiment\"\n\
             conditions = \"typical\"\ntables.cohort = \"{file}\"\nchanged = \"Sessions.\"\n"
        )
    };
    let ledger = support::read(&study.path("ledger.toml"));
    let ledger = ledger + &entry("A", "first.csv") + &entry("B", "second.csv");
    study.write("ledger.toml", ledger);
    let said = study.run(&["run", "study", "--quiet"]);
    assert!([0, 1, 3].contains(&said.code), "{said:?}");
    let verified = study.run(&["verify", "study/results"]);
    assert_eq!(verified.code, 0, "{verified:?}");
    let result = support::read(&study.path("results/study.json"));
    (said, serde_json::from_str(&result).expect("JSON"))
}

#[test]
fn rows_that_two_tables_share_are_no_two_experiments() {
    for repeated in [true, false] {
        let (_, result) = told_twice(repeated);
        let comparisons = result["comparisons"].as_array().expect("comparisons");
        let ours = |c: &&Value| c["left"] == "A" && c["right"] == "B";
        let pairs: Vec<&Value> = comparisons.iter().filter(ours).collect();
        let is_counted = |c: &&Value| !c["p_difference"].is_null();
        let pairs: Vec<&Value> = pairs.into_iter().filter(is_counted).collect();
        assert!(!pairs.is_empty());
        for pair in pairs {
            assert_eq!(pair["independent"], !repeated, "{pair}");
            let reason = pair["reason"].as_str().expect("a reason");
            let said = "10 of the 11 rows that `first.csv` and `second.csv` both have are the same";
            assert_eq!(reason.contains(said), repeated, "{reason}");
        }
    }
}

/// A robot finds a seam with 35 % in each step, in half a second; trials count what is found within 3 s, and what is lost.
fn seam(step: &str, tables: &str) -> tempfile::TempDir {
    let folder = tempfile::TempDir::new().expect("a folder");
    let about = format!(
        "title = \"Seams\"\nsummary = \"s\"\nseed = 1\nconfidence = 0.95\nagreement = 0.95\n[model]\nstep = \"{step}\"\n\
         [conditions]\nlab = \"any\"\n"
    );
    let requirements = "[[requirement]]\nid = \"1\"\ntext = \"The seam is found in 3 s.\"\nmargin = 0.04\n\
         shall = \"When seek, the robot shall with probability at least 0.8 within 3 s satisfy found.\"\n\
         [[failure_mode]]\nid = \"lost\"\nname = \"Lost\"\nmeaning = \"It loses the seam.\"\nmargin = 0.04\n\
         occurs = 'P=? [ F \"lost\" ]'\nopportunity = 'P=? [ F \"found\" ]'\n\
         [[failure_mode]]\nid = \"spill\"\nname = \"Spill\"\nmeaning = \"It spills.\"\nmargin = 0.04\n\
         occurs = 'P=? [ F \"spill\" ]'\nopportunity = 'P=? [ F \"found\" ]'\n";
    let vocabulary = "[seek]\nmeaning = \"m\"\nmodel = \"s=0\"\n[found]\nmeaning = \"m\"\nmodel = \"s>0\"\n\
         [lost]\nmeaning = \"m\"\nmodel = \"s=2\"\n[spill]\nmeaning = \"m\"\nmodel = \"s=3\"\n";
    let model = "dtmc\nmodule m\n s : [0..4] init 0;\n [] s=0 -> 0.35:(s'=1) + 0.65:(s'=0);\n\
         [] s=1 -> 0.05:(s'=2) + 0.25:(s'=3) + 0.7:(s'=4);\n [] s>1 -> true;\nendmodule\n";
    let ledger = "[[evidence]]\nid = \"E1\"\ntitle = \"model\"\ntechnique = \"model-checking\"\nconditions = \"lab\"\n\
         model = \"m.prism\"\nchanged = \"c\"\n\
         [[evidence]]\nid = \"E2\"\ntitle = \"trials\"\ntechnique = \"experiment\"\nconditions = \"lab\"\n\
         tables.requirements = \"r.csv\"\ntables.failure_modes = \"f.csv\"\nchanged = \"c\"\n";
    for (name, text) in [
        ("study.toml", about.as_str()),
        ("requirements.toml", requirements),
        ("vocabulary.toml", vocabulary),
        ("m.prism", model),
        ("ledger.toml", ledger),
        ("r.csv", "requirement,covered,passed,failed\n1,400,370,30\n"),
        ("f.csv", tables),
    ] {
        std::fs::write(folder.path().join(name), text).expect("written");
    }
    folder
}

fn suspects_of(folder: &tempfile::TempDir) -> Vec<Value> {
    let call = |arguments: &[&str]| support::program::corroborate(folder.path(), arguments);
    let said = call(&["run", ".", "--quiet"]);
    assert!([0, 1, 3].contains(&said.code), "{said:?}");
    let said = call(&["diagnose", ".", "--format", "json"]);
    let diagnosis: Value = serde_json::from_str(&said.out).expect("JSON");
    diagnosis["suspects"].as_array().expect("suspects").clone()
}

const RIGHT_TABLE: &str = "mode,occurrences,opportunities\nlost,20,400\nspill,100,400\n";

#[test]
fn a_step_of_another_duration_is_named_by_its_line() {
    let suspects = suspects_of(&seam("1 s", RIGHT_TABLE));
    let asset = &suspects[0]["asset"];
    assert_eq!(asset["file"], "study.toml", "{suspects:?}");
    assert_eq!(
        (&asset["kind"], asset["line"].as_u64()),
        (&"time-scale".into(), Some(7))
    );
    assert_eq!(suspects[0]["symptoms"][0]["instead"], "0.5 s");
    let in_order = suspects_of(&seam("0.5 s", RIGHT_TABLE));
    assert!(
        in_order.iter().all(|it| it["score"].as_f64() < Some(1.0)),
        "{in_order:?}"
    );
}

/// An edit of one word would explain part of what an exchange explains: it is named only where it explains as much.
#[test]
fn an_exchange_that_explains_more_leaves_no_edit_beside_it() {
    let exchanged = "mode,occurrences,opportunities\nlost,100,400\nspill,20,400\n";
    let suspects = suspects_of(&seam("0.5 s", exchanged));
    assert_eq!(suspects[0]["asset"]["file"], "f.csv", "{suspects:?}");
    let title = suspects[0]["title"].as_str().expect("a title");
    assert!(title.contains("the wrong way round"), "{title}");
    let others: Vec<&Value> = suspects.iter().skip(1).collect();
    assert!(others.is_empty(), "{others:?}");
}
