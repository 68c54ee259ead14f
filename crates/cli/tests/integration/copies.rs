//! What looks copied from other evidence is asked about, and a line of the ledger settles it.

use crate::support;

use serde_json::Value;
use support::planted::Planted;
use support::program::Study;

/// The study of the tests with further experiments of these tables, and its result.
fn ran(tables: &[(&str, &str, String)], settled: &str, model: Option<&str>) -> (Study, Value) {
    let study = Study::new();
    let mut ledger = support::read(&study.path("ledger.toml"));
    for (id, key, table) in tables {
        study.write(&format!("{id}.csv"), table.clone());
        let reason = if *id == "B" { settled } else { "" };
        ledger += &format!(
            "\n[[evidence]]\nid = \"{id}\"\ntitle = \"{id}\"\ntechnique = \"experiment\"\n\
             conditions = \"typical\"\n{key} = \"{id}.csv\"\nchanged = \"Sessions.\"\n{reason}\n"
        );
    }
    study.write("ledger.toml", ledger);
    if let Some(line) = model {
        let text = support::read(&study.path("model.prism"));
        study.write("model.prism", format!("{text}\n{line}\n"));
    }
    let said = study.run(&["run", "study", "--quiet"]);
    assert!([0, 1, 3].contains(&said.code), "{said:?}");
    let result = support::read(&study.path("results/study.json"));
    (study, serde_json::from_str(&result).expect("JSON"))
}

fn questions(result: &Value, id: &str) -> Vec<Value> {
    let pieces = result["evidence"].as_array().expect("evidence");
    let piece = pieces.iter().find(|it| it["id"] == id).expect("the piece");
    let all = piece["lineage_questions"].as_array().expect("questions");
    all.clone()
}

/// Pairs of the two that have figures.
fn pairs(result: &Value) -> Vec<Value> {
    let comparisons = result["comparisons"].as_array().expect("comparisons");
    let ours = |c: &&Value| c["left"] == "A" && c["right"] == "B" && !c["p_difference"].is_null();
    comparisons.iter().filter(ours).cloned().collect()
}

fn cohort(names: &str, counts: &[u64]) -> String {
    let row = |(i, count): (usize, &u64)| {
        let missed = "M ".repeat(30 - *count as usize);
        format!("{names}{i},{count},30,{missed}\n")
    };
    let rows: String = counts.iter().enumerate().map(row).collect();
    format!("session,successes,attempts,failure_modes\n{rows}")
}

const COUNTS: [u64; 12] = [27, 24, 30, 21, 25, 28, 19, 26, 23, 29, 22, 25];

#[test]
fn rows_under_other_names_are_asked_about_until_settled() {
    let other = [25, 27, 24, 22, 28, 29, 26, 24, 20, 27, 23, 30];
    for (counts, settled, is_open) in [
        (COUNTS, "", true),
        (
            COUNTS,
            "independent = { A = \"another robot, the same list\" }",
            false,
        ),
        (other, "", false),
    ] {
        let tables = [
            ("A", "tables.cohort", cohort("p", &COUNTS)),
            ("B", "tables.cohort", cohort("x", &counts)),
        ];
        let (study, result) = ran(&tables, settled, None);
        let asked = questions(&result, "B");
        assert_eq!(!asked.is_empty(), counts == COUNTS, "{asked:?}");
        if let Some(asked) = asked.first() {
            assert_eq!(asked["kind"], "rows");
            assert_eq!(asked["places"][0], "B.csv:2");
            assert_eq!(asked["settled"].is_null(), is_open);
        }
        let pairs = pairs(&result);
        assert!(!pairs.is_empty());
        for pair in pairs {
            assert_eq!(pair["possibly_copied"], is_open, "{pair}");
            assert_eq!(pair["independent"], !is_open, "{pair}");
            let reason = pair["reason"].as_str().expect("a reason");
            assert_eq!(reason.contains("copied"), is_open, "{reason}");
        }
        let verified = study.run(&["verify", "study/results"]);
        assert_eq!(verified.code, 0, "{verified:?}");
    }
}

#[test]
fn small_tables_that_always_succeed_are_no_copies() {
    let always = |names: &str| cohort(names, &[30, 30, 30, 30, 30]);
    let tables = [
        ("A", "tables.cohort", always("p")),
        ("B", "tables.cohort", always("x")),
    ];
    let (_, result) = ran(&tables, "", None);
    assert!(questions(&result, "B").is_empty());
    assert!(
        pairs(&result)
            .iter()
            .all(|pair| pair["independent"] == true)
    );
}

#[test]
fn a_number_of_the_model_that_is_a_rate_is_asked_about_with_its_line() {
    let tables = [("A", "tables.cohort", cohort("p", &COUNTS))];
    // 299 of 360.
    let study = Study::new();
    let lines = support::read(&study.path("model.prism")).lines().count();
    for (line, blocks) in [
        ("const double copied = 299/360;", Some(true)),
        ("const double copied = 0.8306;", Some(true)),
        ("const double copied = 0.83;", Some(false)),
        ("const double other = 0.8312;", None),
    ] {
        let (study, result) = ran(&tables, "", Some(line));
        let ledger = support::read(&study.path("ledger.toml"));
        let model = ledger.find("model.prism").expect("a model");
        let begin = ledger[..model].rfind("id = \"").expect("an entry") + 6;
        let id = &ledger[begin..begin + ledger[begin..].find('"').expect("an end")];
        let asked = questions(&result, id);
        let about = |it: &&Value| it["with"] == "A" && it["kind"] == "constant";
        let found = asked.iter().find(about);
        assert_eq!(
            found.map(|it| it["blocks"] == true),
            blocks,
            "{line} {asked:?}"
        );
        if let Some(found) = found {
            let place = found["places"][0].as_str().expect("a place");
            assert_eq!(place, format!("model.prism:{}", lines + 2));
            let remedy = found["remedy"].as_str().expect("a remedy");
            assert!(
                remedy.contains("constant = \"copied\", from = \"A\""),
                "{remedy}"
            );
        }
    }
}

#[test]
fn a_reason_is_asked_for_and_only_evidence_of_the_ledger_is_named() {
    let tables = |_: ()| [("A", "tables.cohort", cohort("p", &COUNTS))];
    for (line, code) in [
        ("independent = { nothing = \"x\" }", "unknown-evidence"),
        ("independent = \" \"", "no-reason"),
    ] {
        let (study, _) = ran(&tables(()), "", None);
        let ledger = support::read(&study.path("ledger.toml"));
        study.write("ledger.toml", format!("{ledger}\n{line}\n"));
        let said = study.run(&["run", "study", "--quiet"]);
        assert!(said.code == 2 && said.talk.contains(code), "{said:?}");
    }
}

/// Twenty rows, of which those of one operator succeed more often, in turn.
fn by_operator(better: u64, column: &str) -> String {
    let row = |i: u64| {
        let (operator, count) = match i % 2 {
            0 => ("kim", 20 + i * 7 % 5 + better),
            _ => ("lee", 20 + i * 3 % 5),
        };
        let missed = "M ".repeat(30 - count as usize);
        format!("p{i},{count},30,{missed},{operator}\n")
    };
    let rows: String = (0..20).map(row).collect();
    format!("session,successes,attempts,failure_modes,{column}\n{rows}")
}

#[test]
fn trials_that_a_column_makes_alike_are_asked_about_until_settled() {
    for (better, column, settled, open) in [
        (6, "operator", "", Some(true)),
        (
            6,
            "operator",
            "independent = { B = \"the operators took turns by lot\" }",
            Some(false),
        ),
        (6, "operator", "independent = \"another lab\"", Some(true)),
        (0, "operator", "", None),
    ] {
        let tables = [
            ("A", "tables.cohort", cohort("p", &COUNTS)),
            ("B", "tables.cohort", by_operator(better, column)),
        ];
        let (study, result) = ran(&tables, settled, None);
        let asked = questions(&result, "B");
        let found = asked.iter().find(|it| it["kind"] == "trials");
        assert_eq!(found.map(|it| it["settled"].is_null()), open, "{asked:?}");
        if let Some(found) = found {
            let finding = found["finding"].as_str().expect("a finding");
            assert!(finding.contains("the same `operator`"), "{finding}");
            let remedy = found["remedy"].as_str().expect("a remedy");
            assert!(remedy.contains("independent = { B = "), "{remedy}");
        }
        // Trials of the piece itself say nothing of the pair.
        assert!(
            pairs(&result)
                .iter()
                .all(|pair| pair["independent"] == true)
        );
        let verified = study.run(&["verify", "study/results"]);
        assert_eq!(verified.code, 0, "{verified:?}");
    }
}

#[test]
fn simulations_with_the_same_seeds_are_not_independent_until_settled() {
    let episodes = |first: u64, name: &str| {
        let row = |i: u64| {
            let count = if first == 1 {
                (1 + i * 7) % 10
            } else {
                5 + i % 3
            };
            format!(
                "{name}{i},{count},10,{},{}\n",
                "M ".repeat(10 - count as usize),
                first + i
            )
        };
        let rows: String = (1..=20).map(row).collect();
        format!("session,successes,attempts,failure_modes,seed\n{rows}")
    };
    for (first, settled, open) in [
        (1, "", Some(true)),
        (
            1,
            "independent = { A = \"the seeds number other generators\" }",
            Some(false),
        ),
        (1000, "", None),
    ] {
        let study = Study::new();
        let mut ledger = support::read(&study.path("ledger.toml"));
        for (id, table, line) in [
            ("A", episodes(1, "a"), ""),
            ("B", episodes(first, "b"), settled),
        ] {
            study.write(&format!("{id}.csv"), table);
            ledger += &format!(
                "\n[[evidence]]\nid = \"{id}\"\ntitle = \"{id}\"\ntechnique = \"simulation\"\n\
                 conditions = \"typical\"\ntables.cohort = \"{id}.csv\"\nchanged = \"Episodes.\"\n{line}\n"
            );
        }
        study.write("ledger.toml", ledger);
        let said = study.run(&["run", "study", "--quiet"]);
        assert!([0, 1, 3].contains(&said.code), "{said:?}");
        let result: Value =
            serde_json::from_str(&support::read(&study.path("results/study.json"))).expect("JSON");
        let asked = questions(&result, "B");
        let found = asked.iter().find(|it| it["kind"] == "seeds");
        assert_eq!(found.map(|it| it["settled"].is_null()), open, "{asked:?}");
        for pair in pairs(&result) {
            assert_eq!(pair["independent"], open != Some(true), "{pair}");
        }
    }
}

/// 26 of 211 and 187 of 223 have the product 4862/47053 = 0.103330.
#[test]
fn a_number_that_is_a_product_of_two_rates_is_asked_about() {
    let requirements = "[[failure_mode]]\nid = \"slips\"\nname = \"Slips\"\nmeaning = \"it slips\"\nmargin = 0.1\noccurs = 'P=? [ F \"out\" ]'\n\
                        [[failure_mode]]\nid = \"turns\"\nname = \"Turns\"\nmeaning = \"it turns\"\nmargin = 0.1\noccurs = 'P=? [ F \"out\" ]'\n\
                        [[requirement]]\nid = \"1\"\ntext = \"t\"\nmargin = 0.1\nproperty = 'P=? [ G !\"out\" ]'\n";
    let ledger = "[[evidence]]\nid = \"X\"\ntitle = \"x\"\ntechnique = \"experiment\"\nconditions = \"any\"\n\
                  tables.failure_modes = \"modes.csv\"\nchanged = \"c\"\n\
                  [[evidence]]\nid = \"M\"\ntitle = \"m\"\ntechnique = \"model-checking\"\nconditions = \"any\"\n\
                  model = \"m.prism\"\nchanged = \"c\"\n";
    for (number, is_asked) in [
        ("0.103330", true),
        ("0.896670", true),
        ("0.10", false),
        ("0.103913", false),
    ] {
        let folder = tempfile::TempDir::new().expect("a folder");
        let model = format!(
            "dtmc\nconst double both = {number};\nmodule m\n  s : [0..2] init 0;\n  \
             [] s=0 -> both:(s'=1) + 1-both:(s'=2);\n  [] s>0 -> true;\nendmodule\n"
        );
        for (name, text) in [
            (
                "study.toml",
                "title = \"t\"\nsummary = \"s\"\nseed = 1\nconfidence = 0.95\nagreement = 0.95\n\
                 [conditions]\nany = \"any\"\n",
            ),
            (
                "vocabulary.toml",
                "out = { meaning = \"out\", model = \"s=1\" }\n",
            ),
            ("requirements.toml", requirements),
            ("ledger.toml", ledger),
            (
                "modes.csv",
                "mode,occurrences,opportunities\nslips,26,211\nturns,187,223\n",
            ),
            ("m.prism", &model),
        ] {
            std::fs::write(folder.path().join(name), text).expect("written");
        }
        let said = support::program::corroborate(folder.path(), &["run", ".", "--format", "json"]);
        let result: Value =
            serde_json::from_str(&said.out).unwrap_or_else(|error| panic!("{error}: {said:?}"));
        let asked = questions(&result, "M");
        let about = |it: &&Value| it["kind"] == "product" && it["blocks"] == true;
        assert_eq!(
            asked.iter().any(|it| about(&it)),
            is_asked,
            "{number} {asked:?}"
        );
    }
}

/// Ten recordings of each of four days in a folder of its own; those of `failing` are not docked.
fn recorded(study: &Study, failing: impl Fn(usize, usize) -> bool) {
    for (day, folder) in ["mon", "tue", "wed", "thu"].iter().enumerate() {
        std::fs::create_dir_all(study.path(&format!("runs/{folder}"))).expect("a folder");
        for run in 0..10 {
            let begins = 1_700_000_000 + 86_400 * day + 300 * run;
            let rows: String = (0..13)
                .map(|at| {
                    let charging = at >= 3 && !failing(day, run);
                    format!("{},approach,{charging},5,0.2\n", begins + 10 * at)
                })
                .collect();
            let head = "time_secs,/robot.state,/battery.charging,/scanner.person_distance [m],/odometry.speed [m/s]";
            let text = format!("{head}\n{rows}");
            study.write(&format!("runs/{folder}/{run}.csv"), text);
        }
    }
}

#[test]
fn recordings_of_a_session_that_fail_together_are_asked_about_until_settled() {
    let by_day = |day: usize, run: usize| day == 1 && run != 4;
    let scattered = |day: usize, run: usize| [(0, 3), (1, 7), (2, 1), (3, 8)].contains(&(day, run));
    let settled = "independent = { R = \"another robot each time, in an order that was drawn\" }";
    let asked = |failing: &dyn Fn(usize, usize) -> bool, settled: &str| {
        let study = Study::new();
        recorded(&study, failing);
        let ledger = support::read(&study.path("ledger.toml"));
        let entry = format!(
            "\n[[evidence]]\nid = \"R\"\ntitle = \"R\"\ntechnique = \"operation\"\nconditions = \"typical\"\n\
             recordings = \"runs\"\nchanged = \"Recorded.\"\n{settled}\n"
        );
        study.write("ledger.toml", ledger + &entry);
        let said = study.run(&["run", "study", "--quiet"]);
        assert!([0, 1, 3].contains(&said.code), "{said:?}");
        let verified = study.run(&["verify", "study/results"]);
        assert_eq!(verified.code, 0, "{verified:?}");
        let result = support::read(&study.path("results/study.json"));
        questions(&serde_json::from_str(&result).expect("JSON"), "R")
    };
    let questions = asked(&by_day, "");
    let finding = questions[0]["finding"].as_str().expect("a finding");
    assert_eq!(questions[0]["kind"], "trials");
    assert!(finding.contains("recordings of one folder"), "{finding}");
    assert!(questions[0]["settled"].is_null());
    assert!(!asked(&by_day, settled)[0]["settled"].is_null());
    assert!(asked(&scattered, "").is_empty());
}

/// Two models of their own text that compute one number: against the trials they have one voice, so that the trials are not the
/// odd one out, and they do not agree independently.
#[test]
fn models_that_compute_the_same_number_have_one_voice_until_settled() {
    for (settled, other, open) in [
        ("", "0.05", Some(true)),
        (
            "independent = { E1 = \"counted at another site\" }",
            "0.05",
            Some(false),
        ),
        ("", "0.06", None),
    ] {
        let study = Planted::new();
        study.write(
            "study.toml",
            "title = \"t\"\nsummary = \"s\"\nseed = 1\nconfidence = 0.95\nagreement = 0.95\n[conditions]\nc = \"any\"\n",
        );
        study.write(
            "vocabulary.toml",
            "held = { meaning = \"held\", model = \"s=1\" }\n",
        );
        study.write(
            "requirements.toml",
            "[[requirement]]\nid = \"r\"\ntext = \"It is held.\"\nproperty = 'P=? [ F \"held\" ]'\nmargin = 0.1\n",
        );
        study.write(
            "one.prism",
            "dtmc\nconst double p = 0.95;\nmodule m\n  s : [0..2] init 0;\n  [] s=0 -> p:(s'=1) + 1-p:(s'=2);\n  [] s>0 -> true;\n\
             endmodule\n",
        );
        study.write(
            "two.prism",
            &format!(
                "dtmc\nconst double slips = {other};\nmodule q\n  s : [0..5] init 4;\n  [] s=4 -> (s'=3);\n  \
                 [] s=3 -> 1-slips:(s'=1) + slips:(s'=5);\n  [] s=1 | s=5 -> (s'=s);\nendmodule\n"
            ),
        );
        study.write("t.csv", "requirement,covered,passed,failed\nr,100,70,30\n");
        study.write(
            "ledger.toml",
            &format!(
                "[[evidence]]\nid = \"E1\"\ntitle = \"one\"\ntechnique = \"model-checking\"\nconditions = \"c\"\n\
                 model = \"one.prism\"\nchanged = \"c\"\n\
                 [[evidence]]\nid = \"E2\"\ntitle = \"trials\"\ntechnique = \"experiment\"\nconditions = \"c\"\n\
                 tables.requirements = \"t.csv\"\nchanged = \"c\"\n\
                 [[evidence]]\nid = \"E3\"\ntitle = \"two\"\ntechnique = \"model-checking\"\nconditions = \"c\"\n\
                 model = \"two.prism\"\nchanged = \"c\"\n{settled}\n"
            ),
        );
        study.run();
        let text = support::read(&study.path().join("results/study.json"));
        let result: Value = serde_json::from_str(&text).expect("JSON");
        let asked = questions(&result, "E3");
        let found = asked.iter().find(|it| it["kind"] == "answer");
        let is_open = found.map(|it| it["settled"].is_null());
        assert_eq!(is_open, open, "{settled} {other}: {asked:?}");
        let pairs = result["comparisons"].as_array().expect("comparisons");
        let models = pairs
            .iter()
            .find(|it| it["left"] == "E1" && it["right"] == "E3");
        let models = models.expect("the pair of models");
        assert_eq!(models["independent"], open != Some(true), "{models}");
        let first = &study.json("diagnose")["suspects"][0]["asset"]["file"];
        // Two models that have their numbers from sources of their own outvote the trials; one source does not.
        let of_trials = open != Some(true);
        assert_eq!(first == "t.csv", of_trials, "{settled} {other}: {first}");
    }
}
