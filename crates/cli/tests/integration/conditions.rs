//! Numbers that are taken over different runs are not put side by side, and a constant is what its lineage says.

use crate::support;

use serde_json::Value;
use support::program::corroborate;
use tempfile::TempDir;

const STUDY: &str = "title = \"t\"\nsummary = \"s\"\nseed = 1\nconfidence = 0.95\nagreement = 0.95\n\
                     [conditions]\ntypical = \"any\"\n[model]\nstep = \"1 s\"\n";

/// A person is near in 15 % of the runs, and the robot then too fast in 35 %.
const MODEL: &str = "dtmc\nconst double pFast = 0.35;\nmodule m\n  s : [0..3] init 0;\n\
                     [] s=0 -> 0.15*pFast:(s'=1) + 0.15*(1-pFast):(s'=2) + 0.85:(s'=3);\n  [] s>0 -> true;\nendmodule\n";

const VOCABULARY: &str = "near = { meaning = \"near\", model = \"s=1 | s=2\", trace = \"/r.near\" }\n\
                          slow = { meaning = \"slow\", model = \"s!=1\", trace = \"/r.slow\" }\n\
                          kept = { meaning = \"kept\", column = \"kept\" }\n";

const SENTENCE: &str = "shall = \"Whenever near, the robot shall immediately satisfy slow.\"";

const LEDGER: &str = "[[evidence]]\nid = \"M\"\ntitle = \"model\"\ntechnique = \"model-checking\"\n\
    conditions = \"typical\"\nmodel = \"m.prism\"\nchanged = \"c\"\n\
    [[evidence]]\nid = \"X\"\ntitle = \"experiment\"\ntechnique = \"experiment\"\n\
    conditions = \"typical\"\ntables.requirements = \"r.csv\"\nchanged = \"c\"\n";

fn study(requirement: &str, table: &str) -> TempDir {
    let folder = TempDir::new().expect("a folder");
    let requirements =
        format!("[[requirement]]\nid = \"1\"\ntext = \"t\"\nmargin = 0.1\n{requirement}\n");
    for (name, text) in [
        ("study.toml", STUDY),
        ("vocabulary.toml", VOCABULARY),
        ("requirements.toml", requirements.as_str()),
        ("ledger.toml", LEDGER),
        ("m.prism", MODEL),
        ("r.csv", table),
    ] {
        std::fs::write(folder.path().join(name), text).expect("written");
    }
    folder
}

fn result(folder: &TempDir) -> Value {
    let said = corroborate(folder.path(), &["run", ".", "--format", "json"]);
    serde_json::from_str(&said.out).unwrap_or_else(|error| panic!("{error}: {said:?}"))
}

fn finding<'r>(result: &'r Value, id: &str) -> &'r Value {
    let all = result["evidence"].as_array().expect("evidence");
    let piece = all.iter().find(|it| it["id"] == id).expect("a piece");
    &piece["findings"][0]
}

#[test]
fn a_triggered_requirement_is_computed_given_its_trigger_and_conflicts_with_sixty_of_sixty() {
    // By a sentence, or by the premise of a property alone.
    for requirement in [SENTENCE, "property = 'P=? [ G (\"near\" => \"slow\") ]'"] {
        let folder = study(
            requirement,
            "requirement,covered,passed,failed\n1,60,60,0\n",
        );
        let result = result(&folder);
        let model = finding(&result, "M");
        let value = model["measure"]["answer"]["value"]
            .as_f64()
            .expect("a value");
        let trigger = model["trigger"]["answer"]["value"].as_f64();
        let trigger = trigger.expect("a trigger");
        assert!((value - 0.65).abs() < 1e-6, "{requirement}: {value}");
        assert!((trigger - 0.15).abs() < 1e-6, "{requirement}: {trigger}");
        assert_eq!(model["denominator"]["kind"], "triggered", "{requirement}");
        assert_eq!(
            result["comparisons"][0]["outcome"], "conflicts",
            "{requirement}: {}",
            result["comparisons"]
        );
    }
}

/// How a person behaves is left open: coming quickly or slowly, or not at all.
#[test]
fn a_decision_process_gives_a_range_over_all_schedulers_given_the_trigger() {
    let model = "mdp\nmodule m\n  s : [0..3] init 0;\n\
                 [quickly] s=0 -> 0.35:(s'=1) + 0.65:(s'=2);\n\
                 [slowly] s=0 -> 0.1:(s'=1) + 0.9:(s'=2);\n\
                 [away] s=0 -> (s'=3);\n  [] s>0 -> true;\nendmodule\n";
    let compared = |forms: &str, passed: u64| {
        let failed = 60 - passed;
        let folder = study(
            forms,
            &format!("requirement,covered,passed,failed\n1,60,{passed},{failed}\n"),
        );
        std::fs::write(folder.path().join("m.prism"), model).expect("written");
        result(&folder)
    };
    let handwritten = |query: &str| {
        format!("property = '{query} [ G (\"near\" => \"slow\") ]'\ntrigger = 'P=? [ F \"near\" ]'")
    };
    for forms in [
        SENTENCE.to_owned(),
        handwritten("P=?"),
        handwritten("Pmin=?"),
    ] {
        let result = compared(&forms, 48);
        let answer = &finding(&result, "M")["measure"]["answer"];
        let guarantee = &answer["guarantee"];
        assert_eq!(guarantee["kind"], "schedulers", "{answer}");
        let end = |name: &str| guarantee[name].as_f64().expect("an end");
        assert!((end("low") - 0.65).abs() < 1e-5, "{answer}");
        assert!((end("high") - 0.9).abs() < 1e-5, "{answer}");
        assert!((answer["value"].as_f64().expect("a value") - 0.65).abs() < 1e-5);
        let trigger = &finding(&result, "M")["trigger"]["answer"]["guarantee"];
        assert_eq!(
            (trigger["low"].as_f64(), trigger["high"].as_f64()),
            (Some(0.0), Some(1.0))
        );
        let comparison = &result["comparisons"][0];
        // From 65 to 90 %: that some scheduler comes near does not make the model agree.
        assert_eq!(comparison["outcome"], "inconclusive", "{comparison}");
        let reason = comparison["reason"].as_str().expect("a reason");
        assert!(reason.contains("does not make the model agree"), "{reason}");
    }
    // Beyond the best scheduler, and below the worst one.
    for passed in [60, 12] {
        let comparison = &compared(SENTENCE, passed)["comparisons"][0];
        assert_eq!(comparison["outcome"], "conflicts", "{comparison}");
    }
}

#[test]
fn where_the_trigger_is_unknown_to_the_model_numbers_over_different_runs_are_not_compared() {
    let unknown = "property = 'P=? [ G (\"near\" => \"slow\") ]'\nmonitor.when = \"/r.close\"\n\
                   monitor.then = [{ assert = \"slow\" }]";
    let table = "requirement,covered,passed,failed\n1,60,60,0\n";
    let compared = |forms: &str| {
        let result = result(&study(forms, table));
        let comparison = &result["comparisons"][0];
        let (outcome, reason) = (comparison["outcome"].clone(), comparison["reason"].clone());
        (outcome, reason.as_str().expect("a reason").to_owned())
    };
    let (outcome, reason) = compared(unknown);
    assert_eq!(outcome, "not-comparable", "{reason}");
    assert!(
        reason.contains("different runs") && reason.contains("trigger ="),
        "{reason}"
    );
    // What is written decides it.
    let written = format!("{unknown}\ntrigger = 'P=? [ F \"near\" ]'");
    let (outcome, reason) = compared(&written);
    assert_eq!(outcome, "conflicts", "{reason}");
}

/// Of an experiment with 300 trials; the study's one requirement was covered in `covered`.
fn with_attempts(requirement: &str, covered: u64) -> Value {
    let passed = covered * 65 / 100;
    let table = format!(
        "requirement,covered,passed,failed\n1,{covered},{passed},{}\n",
        covered - passed
    );
    let folder = study(requirement, &table);
    let ledger = LEDGER.replace(
        "tables.requirements = \"r.csv\"",
        "tables.requirements = \"r.csv\"\ntables.cohort = \"a.csv\"",
    );
    std::fs::write(folder.path().join("ledger.toml"), ledger).expect("written");
    let people: String = (1..=30).map(|it| format!("p{it},10\n")).collect();
    let attempts = format!("session,attempts\n{people}");
    std::fs::write(folder.path().join("a.csv"), attempts).expect("written");
    result(&folder)
}

#[test]
fn a_property_without_a_trigger_is_not_compared_with_trials_of_which_some_do_not_trigger_it() {
    let unconditional = "property = 'P=? [ G \"slow\" ]'";
    let result = with_attempts(unconditional, 60);
    let model = finding(&result, "M");
    assert_eq!(model["denominator"]["kind"], "no-trigger", "{model}");
    let comparison = &result["comparisons"][0];
    assert_eq!(comparison["outcome"], "not-comparable", "{comparison}");
    let reason = comparison["reason"].as_str().expect("a reason");
    assert!(
        reason.contains("does not say which trigger it") && reason.contains("trigger ="),
        "{reason}"
    );
    assert_eq!(comparison["difference"], Value::Null);
    // Where all trials do, there is no other meaning of the number.
    let result = with_attempts(unconditional, 300);
    assert_eq!(result["comparisons"][0]["outcome"], "conflicts");
}

#[test]
fn a_conditional_probability_that_is_written_by_hand_is_over_the_runs_that_it_names() {
    for given in [
        "property = 'P=? [ G \"slow\" || F \"near\" ]'",
        "property = 'P=? [ G \"slow\" ]'\ntrigger = 'P=? [ F \"near\" ]'",
    ] {
        let result = with_attempts(given, 60);
        let model = finding(&result, "M");
        assert_eq!(model["denominator"]["kind"], "triggered", "{model}");
        let value = model["measure"]["answer"]["value"].as_f64();
        assert!((value.expect("a value") - 0.65).abs() < 1e-6, "{model}");
        let trigger = model["trigger"]["answer"]["value"].as_f64();
        assert!((trigger.expect("a value") - 0.15).abs() < 1e-6, "{model}");
        let comparison = &result["comparisons"][0];
        assert_ne!(comparison["outcome"], "not-comparable", "{comparison}");
        assert_ne!(comparison["outcome"], "conflicts", "{comparison}");
    }
}

/// What was written by hand is asked of the model; whether it names the monitor's runs, the model itself says.
#[test]
fn a_trigger_that_is_not_what_the_monitor_waits_for_names_other_runs() {
    let compared = |trigger: &str, when: &str| {
        let forms = format!(
            "property = 'P=? [ G (\"near\" => \"slow\") ]'\ntrigger = 'P=? [ {trigger} ]'\nmonitor.when = \"{when}\"\n\
             monitor.then = [{{ assert = \"slow\" }}]"
        );
        let folder = study(&forms, "requirement,covered,passed,failed\n1,60,60,0\n");
        let late = "late = { meaning = \"late\", model = \"s=3\", trace = \"/r.late\" }\n";
        std::fs::write(
            folder.path().join("vocabulary.toml"),
            format!("{VOCABULARY}{late}"),
        )
        .expect("written");
        let result = result(&folder);
        let model = finding(&result, "M")["denominator"].clone();
        let decides = result["conclusions"][0]["rests_on"].to_string();
        assert_eq!(
            decides.contains("\"M\""),
            model["kind"] == "triggered",
            "{decides}"
        );
        (model, result["comparisons"][0].clone())
    };
    for (trigger, when) in [
        (r#"F "near""#, "near"),
        (r#"F ("near" & !"late")"#, "near"),
        (r#"(F !"late") & (F "near")"#, "near"),
    ] {
        let (denominator, comparison) = compared(trigger, when);
        assert_eq!(denominator["kind"], "triggered", "{trigger} {when}");
        assert_eq!(comparison["outcome"], "conflicts", "{comparison}");
    }
    for (trigger, when) in [
        (r#"F "near""#, "late"),
        (r#"(X (!"late" & !"near")) | (F "near")"#, "late"),
    ] {
        let (denominator, comparison) = compared(trigger, when);
        assert_eq!(denominator["kind"], "other-trigger", "{trigger} {when}");
        assert_eq!(denominator["monitor"], when);
        assert_eq!(comparison["outcome"], "not-comparable", "{comparison}");
        let reason = comparison["reason"].as_str().expect("a reason");
        assert!(reason.contains("triggered by late"), "{reason}");
    }
}

#[test]
fn a_condition_that_is_written_twice_is_refused_at_its_place() {
    let forms = "property = 'P=? [ G \"slow\" || F \"near\" ]'\ntrigger = 'P=? [ F \"near\" ]'";
    let folder = study(forms, "requirement,covered,passed,failed\n1,60,60,0\n");
    let said = corroborate(folder.path(), &["run", "."]);
    assert_eq!(said.code, 2, "{said:?}");
    for words in [
        "error[trigger-twice]",
        "requirements.toml:6",
        "`P=? [ X || C ]`",
    ] {
        assert!(said.talk.contains(words), "{words}: {}", said.talk);
    }
}

#[test]
fn a_property_that_no_model_can_violate_covers_nothing() {
    let folder = study(
        "property = 'P=? [ G !(s=0 & s=2) ]'\nthreshold = \"at least 0.9\"",
        "requirement,covered,passed,failed\n1,0,0,0\n",
    );
    // It is said when it is found, not in the table of what is not covered alone.
    let said = corroborate(folder.path(), &["run", "."]);
    let words = "M: requirement 1: Its property is true of each run that counts";
    assert!(said.talk.contains(words), "{}", said.talk);
    let result = result(&folder);
    let measure = &finding(&result, "M")["measure"];
    assert_eq!(measure["kind"], "not-covered", "{measure}");
    let reason = measure["reason"].as_str().expect("a reason");
    assert!(reason.contains("true of each run that counts"), "{reason}");
    assert_eq!(result["conclusions"][0]["verdict"], "not-covered");
}

/// A failure mode of the model, and what a table counts of it.
fn with_failure_mode(forms: &str, occurrences: u64, opportunities: u64) -> TempDir {
    let requirement = format!(
        "property = 'P=? [ G \"slow\" ]'\n[[failure_mode]]\nid = \"f\"\nname = \"f\"\nmeaning = \"f\"\nmargin = 0.1\n{forms}"
    );
    let folder = study(
        &requirement,
        "requirement,covered,passed,failed\n1,1000,948,52\n",
    );
    let table = format!("mode,occurrences,opportunities\nf,{occurrences},{opportunities}\n");
    std::fs::write(folder.path().join("f.csv"), table).expect("written");
    let ledger = LEDGER.replace(
        "tables.requirements = \"r.csv\"",
        "tables.requirements = \"r.csv\"\ntables.failure_modes = \"f.csv\"",
    );
    std::fs::write(folder.path().join("ledger.toml"), ledger).expect("written");
    folder
}

fn of_mode(result: &Value) -> &Value {
    let all = result["evidence"][0]["findings"]
        .as_array()
        .expect("findings");
    let found = all.iter().find(|it| it["subject"]["id"] == "f");
    found.expect("the failure mode")
}

/// It occurs in 5.25 % of the runs after its opportunity, which 15 % have, and in 85 % without it.
#[test]
fn a_failure_mode_that_also_occurs_without_its_opportunity_is_counted_with_it_alone() {
    let forms = "occurs = 'P=? [ F (s=1 | s=3) ]'\nopportunity = 'P=? [ F \"near\" ]'";
    let folder = with_failure_mode(forms, 35, 100);
    let result = result(&folder);
    let mode = of_mode(&result);
    let answer = &mode["measure"]["answer"];
    let value = answer["value"].as_f64().expect("a value");
    assert!((value - 0.35).abs() < 1e-6, "{mode}");
    let end = |name: &str| answer["guarantee"][name].as_f64().expect("an end");
    assert!(end("low") <= value && value <= end("high"), "{mode}");
    assert_eq!(mode["denominator"]["kind"], "triggered");
    let comparisons = result["comparisons"].as_array().expect("pairs");
    let pair = comparisons
        .iter()
        .find(|it| it["subject"]["id"] == "f")
        .expect("a pair");
    let difference = pair["difference"].as_f64();
    assert!(difference.is_some_and(|it| it.abs() < 1e-6), "{pair}");

    // Choices give it a range, as they give a requirement one.
    let model = "mdp\nmodule m\n  s : [0..3] init 0;\n  [a] s=0 -> 0.05:(s'=1) + 0.1:(s'=2) + 0.85:(s'=3);\n  \
                 [b] s=0 -> 0.5:(s'=1) + 0.5:(s'=2);\n  [] s>0 -> true;\nendmodule\n";
    std::fs::write(folder.path().join("m.prism"), model).expect("written");
    let said = corroborate(folder.path(), &["run", ".", "--format", "json"]);
    let again: Value = serde_json::from_str(&said.out).expect("JSON");
    let guarantee = &of_mode(&again)["measure"]["answer"]["guarantee"];
    assert_eq!(guarantee["kind"], "schedulers", "{guarantee}");
    let end = |name: &str| guarantee[name].as_f64().expect("an end");
    assert!(
        (end("low") - 1.0 / 3.0).abs() < 1e-5 && (end("high") - 0.5).abs() < 1e-5,
        "{guarantee}"
    );
}

/// All is as the model computes it, so neither the model nor its solver is a suspect.
#[test]
fn paths_that_show_a_failure_without_an_opportunity_count_for_it() {
    let folder = with_failure_mode("occurs = 'P=? [ F !\"slow\" ]'", 52, 1000);
    let run = corroborate(folder.path(), &["run", ".", "--quiet"]);
    assert!([0, 1, 3].contains(&run.code), "{run:?}");
    let said = corroborate(folder.path(), &["diagnose", ".", "--format", "json"]);
    let diagnosis: Value =
        serde_json::from_str(&said.out).unwrap_or_else(|it| panic!("{it}: {said:?}"));
    assert_eq!(
        diagnosis["suspects"],
        Value::Array(vec![]),
        "{}",
        diagnosis["suspects"]
    );
    let cells = diagnosis["cells"].as_array().expect("cells");
    let of_paths =
        |it: &&Value| it["subject"]["id"] == "f" && it["traces"] == "model" && it["trials"] != 0;
    let cell = cells.iter().find(of_paths).expect("its cell");
    let share = cell["count"].as_f64().expect("a count") / cell["trials"].as_f64().expect("paths");
    assert!((0.02..0.1).contains(&share), "{cell}");
}

#[test]
fn looks_that_show_the_contrary_of_each_other_decide_nothing() {
    let folder = study(
        "threshold = \"at least 0.8\"",
        "requirement,covered,passed,failed\n1,20,11,9\n",
    );
    let first = &result(&folder)["conclusions"][0];
    assert_eq!(first["verdict"], "violated", "{first}");
    let table = "requirement,covered,passed,failed\n1,1020,990,30\n";
    std::fs::write(folder.path().join("r.csv"), table).expect("written");
    let then = &result(&folder)["conclusions"][0];
    assert_eq!(then["verdict"], "undecided", "{then}");
    let statement = then["statement"].as_str().expect("a statement");
    assert!(
        statement.contains("an earlier look showed the contrary"),
        "{statement}"
    );
    assert_eq!(corroborate(folder.path(), &["run", "."]).code, 3);
}

/// The model meets the threshold, too, so that the word "satisfied" stays when the trials no longer show it.
#[test]
fn a_verdict_holds_up_to_a_clustering_although_a_model_says_the_same() {
    let folder = study(
        "property = 'P=? [ G \"slow\" ]'\nthreshold = \"at least 0.8\"",
        "requirement,covered,passed,failed\n1,1960,1639,321\n",
    );
    let conclusion = &result(&folder)["conclusions"][0];
    assert_eq!(
        (&conclusion["verdict"], &conclusion["step"]),
        (&"satisfied".into(), &"system".into())
    );
    let clustering = &conclusion["clustering"][0];
    assert!(
        clustering["holds_up_to"]
            .as_f64()
            .is_some_and(|it| it < 1.0),
        "{clustering}"
    );
}

#[test]
fn so_many_trials_without_a_violation_show_what_is_said() {
    let forms = "property = 'P=? [ G \"slow\" ]'\nthreshold = \"at least 0.85\"";
    let folder = study(forms, "requirement,covered,passed,failed\n1,0,0,0\n");
    let statement = result(&folder)["conclusions"][0]["statement"].to_string();
    let told = statement
        .split(" without a violation")
        .next()
        .expect("a text");
    let trials: u64 = told
        .rsplit(' ')
        .next()
        .expect("a word")
        .parse()
        .expect("a number");
    for (passed, verdict) in [(trials - 1, "model"), (trials, "system")] {
        let table = format!("requirement,covered,passed,failed\n1,{passed},{passed},0\n");
        let folder = study(forms, &table);
        let conclusion = &result(&folder)["conclusions"][0];
        assert_eq!(conclusion["step"], verdict, "{passed}: {conclusion}");
    }
}

#[test]
fn a_constant_that_is_not_the_rate_it_is_said_to_be_set_to_is_refused_with_both_numbers() {
    let calibrated = |passed: u64| {
        let folder = study(
            SENTENCE,
            &format!(
                "requirement,covered,passed,failed\n1,200,{passed},{}\n",
                200 - passed
            ),
        );
        // The model rests on the experiment, which so comes first.
        let (model, experiment) =
            LEDGER.split_at(LEDGER.find("[[evidence]]\nid = \"X\"").expect("X"));
        let line = "calibrated = [{ constant = \"pFast\", from = \"X\", requirement = \"1\", held = true }]\n";
        let ledger = format!("{experiment}{model}{line}");
        std::fs::write(folder.path().join("ledger.toml"), ledger).expect("written");
        corroborate(folder.path(), &["run", "."])
    };
    let refused = calibrated(174);
    assert_eq!(refused.code, 2, "{refused:?}");
    for part in ["0.35", "174/200", "0.87", "ledger.toml:", "pFast = 174/200"] {
        assert!(refused.talk.contains(part), "{part}: {}", refused.talk);
    }
    let taken = calibrated(70);
    assert_ne!(taken.code, 2, "{taken:?}");
}

/// A comment, or one number revised, makes no second witness of a model: against the trials both have one voice.
#[test]
fn a_revision_of_a_model_agrees_with_it_and_is_no_independent_witness() {
    let revised = |text: &str, settled: &str| {
        let folder = study(SENTENCE, "requirement,covered,passed,failed\n1,60,60,0\n");
        let second = LEDGER
            .split_once("[[evidence]]\nid = \"X\"")
            .expect("two entries")
            .0;
        let second = second
            .replace("\"M\"", "\"N\"")
            .replace("m.prism", "n.prism");
        let ledger = format!("{LEDGER}\n{second}{settled}\n");
        std::fs::write(folder.path().join("ledger.toml"), ledger).expect("written");
        std::fs::write(folder.path().join("n.prism"), text).expect("written");
        let all = result(&folder)["comparisons"]
            .as_array()
            .expect("pairs")
            .clone();
        let models = |c: &&Value| c["left"] == "M" && c["right"] == "N";
        let pair = all.iter().find(models).expect("the pair of models").clone();
        let said = corroborate(folder.path(), &["diagnose", ".", "--format", "json"]);
        let diagnosis: Value = serde_json::from_str(&said.out).expect("JSON");
        (
            pair,
            diagnosis["suspects"][0]["assets"].to_string() + &diagnosis["suspects"][0].to_string(),
        )
    };
    let commented = format!("// A person comes.\n{MODEL}");
    let other_number = MODEL.replace("0.85:(s'=3)", "0.850:(s'=3)");
    for text in [&commented, &other_number] {
        let (pair, first) = revised(text, "");
        assert_eq!(pair["independent"], false, "{pair}");
        let reason = pair["reason"].as_str().expect("a reason");
        assert!(reason.contains("stand in both"), "{reason}");
        assert!(
            first.contains(".prism") && !first.contains("r.csv"),
            "{first}"
        );
    }
    let settled = "independent = { M = \"written by another team\" }";
    assert_eq!(revised(&commented, settled).0["independent"], true);
    let other = "dtmc\nmodule other\n  p : [0..2] init 0;\n  [] p=0 -> 0.0525:(p'=1) + 0.9475:(p'=2);\n\
                 [] p>0 -> true;\nendmodule\nmodule s_\n  s : [0..3] init 0;\n  [] s=0 & p=1 -> (s'=1);\n\
                 [] s=0 & p=2 -> 0.1:(s'=2) + 0.9:(s'=3);\n  [] s>0 -> true;\nendmodule\n";
    assert_eq!(revised(other, "").0["independent"], true);
}

/// A sequence of trials that was chosen among several has no error rate.
#[test]
fn counts_that_take_the_place_of_others_are_named_with_these() {
    let folder = study(
        "threshold = \"at least 0.9\"",
        "requirement,covered,passed,failed\n1,100,88,12\n",
    );
    result(&folder);
    let replaced = |table: &str| {
        std::fs::write(folder.path().join("r.csv"), table).expect("written");
        result(&folder)["conclusions"][0]["excluded_trials"].clone()
    };
    let longer = replaced("requirement,covered,passed,failed\n1,110,97,13\n");
    assert!(longer.is_null(), "{longer}");
    let without_failures = replaced("requirement,covered,passed,failed\n1,100,97,3\n");
    assert_eq!(without_failures[0]["trials"], 110, "{without_failures}");
    let words = without_failures[0]["words"].as_str().expect("words");
    assert!(words.contains("97/110 at earlier looks"), "{words}");
}

/// How the failure mode compares.
fn compared(result: &Value) -> &Value {
    let all = result["comparisons"].as_array().expect("comparisons");
    let found = all.iter().find(|it| it["subject"]["id"] == "f");
    found.expect("the failure mode is compared")
}

/// A piece that speaks of failure modes alone is current, though no conclusion rests on it.
#[test]
fn a_conflict_on_a_failure_mode_fails_whatever_else_the_piece_speaks_of() {
    let mode = "experiment = \"kept\"\noccurs = 'P=? [ F s=1 ]'";
    let ends = |occurrences: u64| {
        let folder = with_failure_mode(mode, occurrences, 1000);
        let ledger = LEDGER.replace(
            "tables.requirements = \"r.csv\"",
            "tables.failure_modes = \"f.csv\"",
        );
        std::fs::write(folder.path().join("ledger.toml"), ledger).expect("written");
        let requirements = folder.path().join("requirements.toml");
        let text = std::fs::read_to_string(&requirements).expect("read");
        let text = text.replacen(
            "margin = 0.1\n",
            "margin = 0.1\nthreshold = \"at least 0.9\"\nneeds = \"model\"\n",
            1,
        );
        std::fs::write(&requirements, text).expect("written");
        let outcome = compared(&result(&folder))["outcome"].clone();
        (outcome, corroborate(folder.path(), &["run", "."]).code)
    };
    assert_eq!(ends(52), ("corroborates".into(), 0));
    assert_eq!(ends(300), ("conflicts".into(), 1));
}

/// A cohort says how often it happened in all attempts, the model how often where it could.
#[test]
fn attempts_of_which_nobody_says_whether_it_could_happen_are_not_its_opportunities() {
    let folder = with_failure_mode(
        "experiment = \"kept\"\noccurs = 'P=? [ F s=1 ]'\nopportunity = 'P=? [ F (s=1 | s=2) ]'",
        0,
        1,
    );
    let cohort = "session,kept,attempts\na,5,50\nb,4,50\nc,6,50\n";
    std::fs::write(folder.path().join("c.csv"), cohort).expect("written");
    let ledger = LEDGER.replace(
        "tables.requirements = \"r.csv\"",
        "tables.cohort = \"c.csv\"",
    );
    std::fs::write(folder.path().join("ledger.toml"), ledger).expect("written");
    let result = result(&folder);
    let of_mode = compared(&result);
    assert_eq!(of_mode["outcome"], "not-comparable", "{of_mode}");
    let reason = of_mode["reason"].as_str().expect("a reason");
    assert!(
        reason.contains("which attempts gave it an opportunity"),
        "{reason}"
    );
}

/// A requirement is asked under every condition that the study declares.
#[test]
fn a_condition_under_which_nothing_looked_is_a_gap() {
    let folder = study(
        "threshold = \"at least 0.9\"",
        "requirement,covered,passed,failed\n1,400,398,2\n",
    );
    let none = &result(&folder)["gaps"];
    let speaks_of_it = |gaps: &Value| gaps.to_string().contains("the condition `wet`");
    assert!(!none.to_string().contains("the condition"), "{none}");
    let declared = STUDY.replace("[conditions]\n", "[conditions]\nwet = \"on wet ground\"\n");
    std::fs::write(folder.path().join("study.toml"), declared).expect("written");
    let gaps = &result(&folder)["gaps"];
    assert!(speaks_of_it(gaps), "{gaps}");
    assert!(
        gaps.to_string()
            .contains("X has a number on it under `typical`"),
        "{gaps}"
    );
    let said = corroborate(folder.path(), &["run", "."]);
    assert!(said.out.contains("wet"), "{said:?}");
}
