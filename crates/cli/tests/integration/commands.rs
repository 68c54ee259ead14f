//! The commands as their users see them: results, exit codes, forms, and what is done again and what is not.

use crate::support;

use serde_json::Value;
use std::path::Path;
use support::program::{Study, command, contents, corroborate};
use support::schema::violations;
use support::{read, root};

fn schema(name: &str) -> Value {
    serde_json::from_str(&read(&root().join("schemas").join(name))).expect("a schema is JSON")
}

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|error| panic!("{error}:\n{text}"))
}

#[track_caller]
fn assert_conforms(name: &str, text: &str) {
    let found = violations(&schema(name), &json(text));
    assert!(
        found.is_empty(),
        "not as {name} says:\n{}",
        found.join("\n")
    );
}

#[test]
fn the_help_of_every_command_shows_examples() {
    let folder = std::env::temp_dir();
    let commands = [
        "run", "plan", "check", "simulate", "monitor", "compare", "report", "init", "explain",
    ];
    for name in commands {
        let said = corroborate(&folder, &[name, "--help"]);
        assert_eq!(said.code, 0, "{said:?}");
        assert!(said.out.contains("Example"), "{}", said.out);
        assert!(
            said.out.contains(&format!("corroborate {name} ")),
            "{}",
            said.out
        );
    }
    let said = corroborate(&folder, &["--help"]);
    assert!(
        commands.iter().all(|name| said.out.contains(name)),
        "{}",
        said.out
    );
    assert!(said.out.contains("Exit codes"), "{}", said.out);
}

#[test]
fn format_lays_out_files_and_only_says_so_when_asked_to_check() {
    let folder = tempfile::TempDir::new().expect("a temporary folder");
    let path = |name: &str| folder.path().join(name);
    let model = "dtmc // of two\nmodule m x:[0..1]; [] x=0->(x'=1); [] x=1->true;endmodule\n";
    std::fs::write(path("m.prism"), model).expect("written");
    std::fs::write(path("p.props"), "// Soon.\nP=?[F x=1];").expect("written");
    let answer = |run: &str| {
        let said = corroborate(folder.path(), &["check", "m.prism", "p.props"]);
        assert_eq!(said.code, 0, "{run}: {said:?}");
        let result = said.out.lines().find(|line| line.starts_with("Result: "));
        result
            .expect("a result")
            .split(';')
            .next()
            .map(str::to_owned)
    };
    let before = answer("before");

    let checked = corroborate(folder.path(), &["format", "--check", "m.prism", "p.props"]);
    assert_eq!(checked.code, 1, "{checked:?}");
    assert_eq!(checked.out.lines().count(), 2, "{checked:?}");
    assert_eq!(read(&path("m.prism")), model);

    let done = corroborate(folder.path(), &["format", "m.prism", "p.props"]);
    assert_eq!(done.code, 0, "{done:?}");
    let formatted = read(&path("m.prism"));
    assert!(
        formatted.starts_with("dtmc // of two\n\nmodule m\n  x : [0..1];\n"),
        "{formatted}"
    );
    assert_eq!(read(&path("p.props")), "// Soon.\nP=? [ F x=1 ];\n");
    assert_eq!(answer("after"), before);
    let again = corroborate(folder.path(), &["format", "--check", "m.prism", "p.props"]);
    assert_eq!((again.code, again.out.as_str()), (0, ""), "{again:?}");

    // One file with a mistake keeps all as they are.
    std::fs::write(path("m.prism"), model).expect("written");
    std::fs::write(path("bad.prism"), "dtmc modul m endmodule").expect("written");
    let refused = corroborate(
        folder.path(),
        &["format", "m.prism", "bad.prism", "none.prism"],
    );
    assert_eq!(refused.code, 2, "{refused:?}");
    assert!(
        refused.talk.contains("Did you mean `module`?"),
        "{refused:?}"
    );
    assert!(refused.talk.contains("none.prism"), "{refused:?}");
    assert_eq!(read(&path("m.prism")), model);
}

#[test]
fn a_formatted_model_is_the_same_model() {
    let folder = tempfile::TempDir::new().expect("a temporary folder");
    for model in [
        "case-studies/corridor/models/corridor.prism",
        "case-studies/handover/models/handover_v5.prism",
        "crates/corroborate/templates/docking/model.prism",
    ] {
        let text = read(&root().join(model));
        std::fs::write(folder.path().join("m.prism"), &text).expect("written");
        let exported = |to: &str| {
            let said = corroborate(folder.path(), &["check", "m.prism", "--export-model", to]);
            assert_eq!(said.code, 0, "{said:?}");
            read(&folder.path().join(to))
        };
        let before = exported("before.tra");
        let said = corroborate(folder.path(), &["format", "m.prism"]);
        assert_eq!(said.code, 0, "{said:?}");
        let formatted = read(&folder.path().join("m.prism"));
        // The template is laid out so; the handover's and the corridor's authors broke lines elsewhere.
        assert_eq!(formatted == text, model.contains("template"), "{model}");
        assert_eq!(formatted.matches("//").count(), text.matches("//").count());
        assert!(exported("after.tra") == before, "{model}");
    }
}

#[test]
fn explain_explains_every_topic_that_it_lists() {
    let folder = std::env::temp_dir();
    let listed = corroborate(&folder, &["explain"]);
    assert_eq!(listed.code, 0, "{listed:?}");
    let topics: Vec<&str> = listed
        .out
        .lines()
        .filter_map(|line| line.strip_prefix("  ")?.split_whitespace().next())
        .collect();
    assert!(
        topics.len() > 30,
        "only {} topics:\n{}",
        topics.len(),
        listed.out
    );
    for topic in topics {
        let said = corroborate(&folder, &["explain", topic]);
        assert_eq!(said.code, 0, "{topic}: {said:?}");
        assert!(said.out.len() > 80, "{topic}: {}", said.out);
    }
}

#[test]
fn check_answers_with_a_guarantee_and_the_exit_code_says_whether_it_holds() {
    let models = root().join("conformance/models");
    let check = |property, more: &[&str]| {
        corroborate(
            &models,
            &[&["check", "knuth_die.prism", property], more].concat(),
        )
    };
    let said = check("P=? [ F d=1 ]", &[]);
    assert_eq!(said.code, 0, "{said:?}");
    assert!(said.out.contains("0.1666666666666"), "{}", said.out);
    assert_eq!(check("P>=0.16 [ F d=1 ]", &[]).code, 0);
    assert_eq!(check("P>=0.17 [ F d=1 ]", &[]).code, 1);
    let exact = check("P=? [ F d=1 ]", &["--method", "exact"]);
    assert!(exact.out.contains("1/6"), "{}", exact.out);
}

#[test]
fn check_prints_json_of_the_committed_form() {
    let models = root().join("conformance/models");
    for method in ["sound", "exact", "prism-default"] {
        let arguments = [
            "check",
            "knuth_die.prism",
            "knuth_die.props",
            "--format",
            "json",
            "--method",
            method,
        ];
        let said = corroborate(&models, &arguments);
        assert_eq!(
            said.code, 1,
            "one of its properties does not hold: {}",
            said.talk
        );
        assert_conforms("check.schema.json", &said.out);
        let report = json(&said.out);
        assert_eq!(report["states"], 13);
        assert_eq!(report["properties"].as_array().map(Vec::len), Some(10));
    }
}

/// Each valuation has a state space of its own, and its size stands with its answers.
#[test]
fn check_says_how_large_the_model_is_for_each_value_of_a_range() {
    let folder = tempfile::tempdir().expect("a folder");
    let model =
        "mdp const int N; module m x : [0..N]; [] x<N -> (x'=x+1); [] x=N -> true; endmodule";
    std::fs::write(folder.path().join("m.prism"), model).expect("written");
    let call = ["check", "m.prism", "Pmin=? [ F x=N ]", "--const", "N=2:3:8"];
    let said = corroborate(folder.path(), &call);
    for size in [
        "with N=2: 3 states",
        "with N=5: 6 states",
        "with N=8: 9 states",
    ] {
        assert_eq!(said.out.matches(size).count(), 1, "{size} in {}", said.out);
    }
    let said = corroborate(folder.path(), &[&call[..], &["--format", "json"]].concat());
    assert_conforms("check.schema.json", &said.out);
    let report = json(&said.out);
    assert_eq!(
        (&report["states"], &report["further"][1]["states"]),
        (&3.into(), &9.into())
    );
    assert_eq!(report["properties"][2]["value"], 1.0);
}

/// A model that was written as files of states and transitions has the same answers when it is read again.
#[test]
fn check_reads_explicit_models() {
    let folder = tempfile::tempdir().expect("a folder");
    let models = root().join("conformance/models");
    let files = folder.path().join("die");
    let files = files.display();
    for form in ["all", "drn"] {
        let export = format!("{files}.{form}");
        let call = ["check", "knuth_die.prism", "--method", "exact"];
        let said = corroborate(&models, &[&call[..], &["--export-model", &export]].concat());
        assert_eq!(said.code, 0, "{said:?}");
    }
    let own = ["P=? [ F s=7 & d=1 ]", "P>=1/6 [ F d=1 ]"];
    let labelled = "P=? [ F \"deadlock\" ]";
    for (model, properties) in [
        ("die.all", &own[..]),
        ("die.tra,sta", &own[..]),
        ("die.drn", &[labelled][..]),
    ] {
        for property in properties {
            for method in ["sound", "exact"] {
                let call = |model| {
                    let call = ["check", model, property, "--method", method];
                    corroborate(folder.path(), &[&call[..], &["--format", "jsonl"]].concat())
                };
                let named = models.join("knuth_die.prism").display().to_string();
                let (read, original) = (call(model), call(&named));
                assert_eq!(read.code, original.code, "{read:?}");
                let [read, original] =
                    [&read.out, &original.out].map(|out| json(out)["result"].clone());
                assert_eq!(read, original, "{model}, {property}, {method}");
            }
        }
    }
    // Only what is asked for is read, and what is left out is said.
    let said = corroborate(folder.path(), &["check", "die.tra"]);
    assert!(said.talk.contains("die.sta"), "{said:?}");
    for (call, code) in [
        (&["check", "die.sta"][..], "no-transitions"),
        (&["check", "die.all", "--import", "xyz=f"][..], "bad-form"),
        (
            &["check", "die.all", own[0], "--certify"][..],
            "unsupported",
        ),
    ] {
        let said = corroborate(folder.path(), call);
        assert_eq!(said.code, 2, "{said:?}");
        assert!(said.talk.contains(code), "{said:?}");
    }
    std::fs::write(folder.path().join("die.tra"), "2 2\n0 1 0.5\n1 1 1\n").expect("written");
    let said = corroborate(folder.path(), &["check", "die.tra"]);
    assert!(said.talk.contains("bad-model-file"), "{said:?}");
}

/// At a time, and in the long run; what is written can be the start of what comes after it.
#[test]
fn check_shows_the_probabilities_of_all_states() {
    let folder = tempfile::tempdir().expect("a folder");
    let model = "ctmc module s on : [0..1]; [] on=0 -> 2:(on'=1); [] on=1 -> 3:(on'=0); endmodule";
    std::fs::write(folder.path().join("m.sm"), model).expect("written");
    let call = |more: &[&str]| corroborate(folder.path(), &[&["check", "m.sm"], more].concat());
    let said = call(&["-tr", "0.5", "-exporttr", "half.txt", "--format", "json"]);
    assert_conforms("check.schema.json", &said.out);
    assert_eq!(json(&said.out)["distributions"][0]["file"], "half.txt");
    let later = ["-importinitdist", "half.txt", "-tr", "0.5", "-ss"];
    let said = call(&[&later[..], &["--format", "json"]].concat());
    assert_conforms("check.schema.json", &said.out);
    let found = &json(&said.out)["distributions"];
    for (place, expected) in [(0, 0.4), (1, 0.4 * (1.0 - (-5.0f64).exp()))] {
        let on = &found[place]["states"][1];
        assert_eq!(on["values"], "(1)");
        let off = on["value"].as_f64().expect("a number") - expected;
        assert!(off.abs() < 1e-9, "{said:?}");
    }
    let said = call(&["-tr", "0:2"]);
    assert!(
        said.out
            .contains("(time = 0): (each within 0e0)\n0:(0)=1\n"),
        "{said:?}"
    );
    assert_eq!(said.out.matches("Transient").count(), 3, "{said:?}");
    std::fs::write(folder.path().join("half.txt"), "0.5\n").expect("written");
    let said = call(&later);
    assert_eq!(said.code, 2, "{said:?}");
    assert!(
        said.talk.contains("there are 1 probabilities for 2 states"),
        "{said:?}"
    );
}

/// Over fair schedulers only.
#[test]
fn check_leaves_out_unfair_schedulers() {
    let folder = tempfile::tempdir().expect("a folder");
    let model = "mdp module m x : [0..1]; [] x=0 -> true; [] true -> (x'=1); endmodule";
    std::fs::write(folder.path().join("m.prism"), model).expect("written");
    for (flag, value) in [("-nofair", 0.0), ("-fair", 1.0), ("--fair", 1.0)] {
        let call = ["check", "m.prism", "Pmin=? [ F x=1 ]", flag];
        let said = corroborate(folder.path(), &[&call[..], &["--format", "jsonl"]].concat());
        assert_eq!(json(&said.out)["value"], value, "{said:?}");
    }
}

/// A bound that the computed bounds leave open is decided by exact arithmetic, or is said to be open; never guessed.
#[test]
fn check_does_not_guess_about_a_value_on_the_bound() {
    let models = root().join("conformance/models");
    let said = corroborate(
        &models,
        &[
            "check",
            "nested.prism",
            "P=? [ X P>=0.5 [ F \"goal\" ] ]",
            "--method",
            "exact",
        ],
    );
    assert!(said.out.contains("2/3"), "{said:?}");
    let said = corroborate(
        &models,
        &["check", "nested.prism", "P=? [ X P>=0.5 [ F \"goal\" ] ]"],
    );
    let value = ["0.6666666666666", "2/3"]
        .iter()
        .any(|v| said.out.contains(v));
    let right = said.code == 0 && value;
    let open = said.code == 3 && said.out.contains("exact")
        || said.code == 2 && said.talk.contains("exact");
    assert!(right || open, "{said:?}");
}

#[test]
fn a_new_study_runs_and_ends_well() {
    let study = Study::new();
    let said = study.run(&["run", "study"]);
    assert_eq!(said.code, 0, "{said:?}");
    assert!(
        said.out.contains("study/results/report.html"),
        "{}",
        said.out
    );
    let page = read(&study.path("results/report.html"));
    assert!(page.starts_with("<!DOCTYPE html>"), "{}", &page[..80]);
    assert!(page.contains("A robot docks at its charger"));
    let result = read(&study.path("results/study.json"));
    assert_conforms("study.schema.json", &result);
    let printed = study.run(&["run", "study", "--format", "json"]);
    assert_eq!(printed.code, 0, "{printed:?}");
    assert_conforms("study.schema.json", &printed.out);
    for command in ["compare", "report"] {
        let said = study.run(&[command, "study"]);
        assert_eq!(said.code, 0, "{command}: {said:?}");
    }
}

#[test]
fn a_plan_says_what_a_run_would_do() {
    let study = Study::new();
    let plan = |arguments: &[&str]| {
        let said = study.run(&[&["plan", "study"], arguments].concat());
        assert_eq!(said.code, 0, "{said:?}");
        said.out
    };
    let before = plan(&[]);
    assert!(before.contains("E1          not produced yet"), "{before}");
    assert!(before.contains("comparison  waits for E1, E2"), "{before}");
    assert!(before.contains("would produce 2 of 2"), "{before}");
    assert!(!study.path("results").exists());
    study.run(&["run", "study"]);
    assert!(plan(&[]).ends_with("A run would produce nothing.\n"));
    study.edit("model.prism", "module", "// Changed.\nmodule");
    let after = plan(&[]);
    assert!(after.contains("stale: model.prism changed"), "{after}");
    assert!(after.contains("would produce 1 of 2"), "{after}");
    let printed = plan(&["--only", "E1", "--format", "json"]);
    assert_conforms("plan.schema.json", &printed);
    assert!(!printed.contains("E2"), "{printed}");
    let unknown = study.run(&["plan", "study", "--only", "E9"]);
    assert_eq!(unknown.code, 2, "{unknown:?}");
    let nowhere = study.run(&["plan", "nowhere"]);
    assert_eq!(nowhere.code, 2, "{nowhere:?}");
}

#[test]
fn a_violated_requirement_is_exit_code_1() {
    let study = Study::new();
    // The experiments' 96 of 100 are far below 99.9 %, and so is the model's 0.95.
    study.edit("requirements.toml", "at least 0.9", "at least 0.999");
    let said = study.run(&["run", "study"]);
    assert_eq!(said.code, 1, "{said:?}");
    assert!(
        said.out.contains("is refuted by trials of the system"),
        "{}",
        said.out
    );
}

#[test]
fn evidence_that_conflicts_is_exit_code_1() {
    let study = Study::new();
    study.edit("model.prism", "pTouches = 0.95", "pTouches = 0.3");
    let said = study.run(&["run", "study"]);
    assert_eq!(said.code, 1, "{said:?}");
    assert!(said.out.to_lowercase().contains("conflict"), "{}", said.out);
}

/// What a run keeps of each piece of evidence.
fn kept(
    study: &Study,
) -> std::collections::BTreeMap<std::path::PathBuf, (Vec<u8>, std::time::SystemTime)> {
    let modified = |path: &Path| {
        std::fs::metadata(path)
            .and_then(|m| m.modified())
            .expect("a time")
    };
    contents(&study.path("results/evidence"))
        .into_iter()
        .map(|(path, content)| {
            let time = modified(&path);
            (path, (content, time))
        })
        .collect()
}

#[test]
fn a_second_run_does_no_work_and_a_change_redoes_what_depends_on_it() {
    let study = Study::new();
    assert_eq!(study.run(&["run", "study"]).code, 0);
    let first = kept(&study);
    assert_eq!(first.len(), 2, "{:?}", first.keys());
    assert_eq!(study.run(&["run", "study"]).code, 0);
    assert!(
        kept(&study) == first,
        "evidence was produced again without a change"
    );
    study.edit("model.prism", "0.95", "0.96");
    assert_eq!(study.run(&["run", "study"]).code, 0);
    let changed = kept(&study);
    for (path, before) in &first {
        let redone = changed.get(path) != Some(before);
        let is_model_checking = path.ends_with("E1.json");
        assert_eq!(redone, is_model_checking, "{}", path.display());
    }
    // Something that no evidence depends on: nothing is done again.
    study.edit("study.toml", "A robot docks", "The robot docks");
    assert_eq!(study.run(&["run", "study"]).code, 0);
    assert!(kept(&study) == changed, "a title is no input of evidence");
}

/// Results are fresh for the same sources, whatever the file of the program looks like.
#[test]
fn another_build_of_the_same_sources_leaves_results_fresh() {
    let study = Study::new();
    let first = study.run(&["run", "study"]);
    assert!(!first.talk.contains("nothing has changed"), "{first:?}");
    let other = study.beside().join("other-build");
    let mut program =
        std::fs::read(env!("CARGO_BIN_EXE_corroborate")).expect("the program's own file");
    program.extend_from_slice(b"built elsewhere");
    std::fs::write(&other, program).expect("written");
    let readable = std::fs::metadata(env!("CARGO_BIN_EXE_corroborate")).expect("it is there");
    std::fs::set_permissions(&other, readable.permissions()).expect("allowed");
    let again = std::process::Command::new(&other)
        .args(["run", "study"])
        .current_dir(study.beside())
        .output()
        .expect("it starts");
    let talk = String::from_utf8(again.stderr).expect("text");
    assert!(talk.contains("nothing has changed"), "{talk}");
}

#[test]
fn a_damaged_result_is_made_again() {
    let study = Study::new();
    assert_eq!(study.run(&["run", "study"]).code, 0);
    let whole = read(&study.path("results/evidence/E1.json"));
    study.write("results/evidence/E1.json", &whole[..whole.len() / 2]);
    assert_eq!(study.run(&["run", "study"]).code, 0);
    let again: Value = json(&read(&study.path("results/evidence/E1.json")));
    assert_eq!(again["inputs"], json(&whole)["inputs"]);
}

/// Costs vary from run to run; everything else is the same bytes, at any number of threads.
#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let study = Study::new();
    let result = |threads, out| {
        let said = study.run(&["run", "study", "-j", threads, "--out", out]);
        assert_eq!(said.code, 0, "{said:?}");
        let mut result = json(&read(&study.beside().join(out).join("study.json")));
        result.as_object_mut().expect("an object").remove("costs");
        result.to_string()
    };
    assert_eq!(result("1", "one"), result("4", "four"));
}

/// The first evidence is there, the second takes long: an interruption ends the run, keeps the first, leaves no half
/// file, and the next run goes on.
#[cfg(unix)]
#[test]
fn an_interrupted_run_goes_on_where_it_stopped() {
    let study = Study::new();
    let long = "dtmc\nmodule m\n  x : [0..100000000] init 0;\n  robot : [0..3] init 0;\n  [] x<100000000 -> (x'=x+1);\nendmodule\n\
                const int approach = 0; const int contact = 1; const int docked = 2; const int missed = 3;\n";
    study.write("long.prism", long);
    let entry = "\n[[evidence]]\nid = \"E3\"\ntitle = \"Long\"\ntechnique = \"model-checking\"\n\
                 conditions = \"typical\"\nmodel = \"long.prism\"\nchanged = \"Takes long.\"\n";
    let ledger = read(&study.path("ledger.toml"));
    study.write("ledger.toml", ledger.clone() + entry);
    let mut child = command(study.beside(), &["run", "study"])
        .stdout(std::process::Stdio::null())
        .stderr(std::process::Stdio::null())
        .spawn()
        .expect("the program starts");
    while !study.path("results/evidence/E2.json").exists() {
        assert!(
            child.try_wait().expect("a state").is_none(),
            "it ended too early"
        );
        std::thread::yield_now();
    }
    let before = kept(&study);
    let signalled = std::process::Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status();
    assert!(signalled.expect("kill runs").success());
    assert_eq!(child.wait().expect("it ends").code(), Some(130));
    let files = contents(&study.path("results"));
    assert!(
        files
            .keys()
            .all(|path| !path.display().to_string().contains("partial")),
        "{:?}",
        files.keys()
    );
    assert!(
        !study.path("results/report.html").exists(),
        "a report of half a study"
    );
    study.write("ledger.toml", ledger);
    assert_eq!(study.run(&["run", "study"]).code, 0);
    assert!(kept(&study) == before, "what was done was done again");
}

#[test]
fn recordings_are_judged_on_their_own_clock() {
    let study = Study::new();
    let table = |arrives: &str| {
        format!(
            "time_secs,/robot.state,/battery.charging\n0,approach,false\n1,approach,false\n{arrives},contact,true\n"
        )
    };
    let file =
        |name: &str, text: &str| std::fs::write(study.beside().join(name), text).expect("written");
    // Propositions are conditions: the column of true and false is one, the state is compared.
    file("quick.csv", &table("59"));
    file("late.csv", &table("70"));
    let quick = study.run(&[
        "monitor",
        "study",
        "quick.csv",
        "--only",
        "1",
        "--format",
        "json",
    ]);
    assert_eq!(quick.code, 0, "{quick:?}");
    assert_conforms("monitor.schema.json", &quick.out);
    assert_eq!(json(&quick.out)["totals"][0]["passed"], 1, "{}", quick.out);
    let late = study.run(&[
        "monitor", "study", "late.csv", "--only", "1", "--format", "json",
    ]);
    assert_eq!(late.code, 1, "{late:?}");
    assert_eq!(json(&late.out)["totals"][0]["failed"], 1, "{}", late.out);
}

#[test]
fn without_the_physics_library_simulation_says_how_to_get_it_and_all_else_works() {
    let study = root().join("case-studies/handover");
    let folder = tempfile::TempDir::new().expect("a folder");
    let study = study.display().to_string();
    let said = corroborate(
        folder.path(),
        &["simulate", &study, "E2", "-n", "1", "--out", "out"],
    );
    assert_eq!(said.code, 2, "{said:?}");
    assert!(said.talk.contains("CORROBORATE_MUJOCO"), "{}", said.talk);
    let said = corroborate(
        folder.path(),
        &[
            "run", &study, "--out", "results", "--only", "rig", "--only", "E3",
        ],
    );
    assert_eq!(said.code, 0, "{said:?}");
    assert!(folder.path().join("results/evidence/rig.json").exists());
    totals_of_the_same_people_are_no_independent_trials(folder.path());
}

/// Of E3 the tables have success and three ways to fail by person, all else as totals of the same ten people.
fn totals_of_the_same_people_are_no_independent_trials(folder: &Path) {
    let text = std::fs::read_to_string(folder.join("results/evidence/E3.json")).expect("written");
    let content = &json(&text)["content"];
    let interval = |id: &str| {
        let all = content["findings"].as_array().expect("a list");
        let found = all.iter().find(|finding| finding["subject"]["id"] == id);
        let measure = &found.expect("a finding")["measure"];
        ["effective_trials", "interval"].map(|key| measure[key].clone())
    };
    let close = |found: &Value, expected: f64| {
        let found = found.as_f64().expect("a number");
        assert!((found - expected).abs() < 1e-4, "{found} {expected}");
    };
    // Independent trials would give 82.2 to 94.4 % for requirement 3, and people of whom nothing else is known up to
    // 28.2 % for the mode that was never seen.
    let [worth, of_requirement] = interval("3");
    close(&worth, 47.480_23);
    close(&of_requirement["low"], 0.788_172);
    close(&of_requirement["high"], 0.964_192);
    let [worth, of_mode] = interval("false_negative_gaze");
    close(&worth, 53.210_36);
    close(&of_mode["high"], 0.067_333);
    let common = &content["clusters"]["common"];
    close(&common["estimate"], 0.037_037);
    close(&common["interval"]["high"], 0.274_625);
    let taken_for = common["taken_for"].as_array().expect("a list").len();
    assert_eq!(
        (taken_for, common["columns"].as_array().map(Vec::len)),
        (8, Some(4))
    );
}

/// Where nobody can be told, the work is done all the same.
#[cfg(target_os = "linux")]
#[test]
fn a_full_standard_error_is_no_bug() {
    let study = Study::new();
    let full = std::fs::File::options().write(true).open("/dev/full");
    let status = command(study.beside(), &["run", "study"])
        .stdout(std::process::Stdio::null())
        .stderr(full.expect("it is there"))
        .status();
    assert_eq!(status.expect("it ends").code(), Some(0));
    assert!(study.path("results/report.html").exists());
}

#[test]
fn results_do_not_depend_on_where_the_study_lies_or_how_it_is_named() {
    let (one, other) = (Study::new(), Study::new());
    assert_eq!(one.run(&["run", "study"]).code, 0);
    assert_eq!(other.run(&["run", "./study/../study"]).code, 0);
    let result = |study: &Study| {
        let mut result = json(&read(&study.path("results/study.json")));
        result.as_object_mut().expect("an object").remove("costs");
        result
    };
    assert!(result(&one) == result(&other));
}
