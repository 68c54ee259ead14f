//! Of a requirement that is triggered in some attempts of a cohort, these are its trials where the tables say which they are.

use crate::support;

use serde_json::Value;
use support::planted::Planted;

const STUDY: &str = "title = \"A suit\"\nsummary = \"It helps to stand up.\"\nseed = 1\nconfidence = 0.95\nagreement = 0.95\n\
    [conditions]\nlab = \"In the lab.\"\n";

const REQUIREMENTS: &str = "[[requirement]]\nid = \"caught\"\ntext = \"Who stumbles is caught.\"\n\
    shall = \"When stumbled, the suit shall with probability at least 0.8 eventually satisfy caught.\"\nmargin = 0.1\n\
    experiment = \"caught\"\n\
    [[failure_mode]]\nid = \"fall\"\nname = \"Fall\"\nmeaning = \"A stumble is not caught.\"\nmargin = 0.1\n\
    occurs = 'P=? [ F \"fallen\" ]'\nopportunity = 'P=? [ F \"stumbled\" ]'\nexperiment = \"fallen\"\n";

const VOCABULARY: &str = "stumbled = { meaning = \"they stumble\", model = \"s=1\", column = \"STUMBLED\" }\n\
    caught = { meaning = \"it catches them\", model = \"s=2\", column = \"caught\" }\n\
    fallen = { meaning = \"they fall\", model = \"s=3\", column = \"fallen\" }\n";

const LEDGER: &str = "[[evidence]]\nid = \"T\"\ntitle = \"Visits\"\ntechnique = \"experiment\"\nconditions = \"lab\"\n\
    tables.cohort = \"cohort.csv\"\nchanged = \"Counted by hand.\"\n";

/// Ten people of twenty attempts each, of which so many stumble and are caught.
fn cohort(column: &str, uncaught: u64) -> String {
    let row = |i: u64| {
        let stumbled = 6 + i % 3;
        let fallen = if i < uncaught { 1 } else { 0 };
        format!("p{i},20,{stumbled},{},{fallen}\n", stumbled - fallen)
    };
    let rows: String = (0..10).map(row).collect();
    format!("session,attempts,{column},caught,fallen\n{rows}")
}

fn findings(vocabulary: &str, ledger: &str, cohort: &str) -> (Planted, Vec<Value>) {
    let study = Planted::new();
    study.write("study.toml", STUDY);
    study.write("requirements.toml", REQUIREMENTS);
    study.write("vocabulary.toml", vocabulary);
    study.write("ledger.toml", ledger);
    study.write("cohort.csv", cohort);
    study.write("modes.csv", "mode,occurrences,opportunities\nfall,2,69\n");
    study.run();
    let findings = study.findings("T");
    (study, findings)
}

fn counts(finding: &Value) -> (u64, u64) {
    let number = |key: &str| finding["measure"][key].as_u64().unwrap_or(u64::MAX);
    (number("count"), number("trials"))
}

#[test]
fn the_column_of_what_triggers_it_says_which_attempts_count() {
    let vocabulary = VOCABULARY.replace("STUMBLED", "stumbled");
    let (study, found) = findings(&vocabulary, LEDGER, &cohort("stumbled", 2));
    assert_eq!(counts(&found[0]), (67, 69), "{found:?}");
    assert_eq!(counts(&found[1]), (2, 69), "{found:?}");
    assert_eq!(found[0]["measure"]["subjects"], 10, "{found:?}");
    assert_eq!(found[0]["trigger"]["count"], 69, "{found:?}");
    let said = support::program::corroborate(study.path(), &["run", ".", "--quiet"]);
    assert_eq!(said.code, 0, "{said:?}");
}

/// A row of the failure mode's own that says the same as the cohort does not take away who did what.
#[test]
fn a_row_that_repeats_the_cohort_leaves_its_people() {
    let vocabulary = VOCABULARY.replace("STUMBLED", "stumbled");
    let ledger = format!("{LEDGER}tables.failure_modes = \"modes.csv\"\n");
    let (_, alone) = findings(&vocabulary, LEDGER, &cohort("stumbled", 2));
    let (_, repeated) = findings(&vocabulary, &ledger, &cohort("stumbled", 2));
    assert!(!alone[1]["measure"]["by_subject"].is_null(), "{alone:?}");
    assert_eq!(alone[1]["measure"], repeated[1]["measure"]);
}

/// One who is caught more often than they stumble: whether the row is wrong, or catches of others are counted, too, nothing is known of those
/// who stumble.
#[test]
fn successes_that_are_not_counted_among_the_triggers_decide_nothing() {
    let vocabulary = VOCABULARY.replace("STUMBLED", "stumbled");
    let one = cohort("stumbled", 2).replace("p4,20,7,7,0", "p4,20,7,8,0");
    let most: String = (0..10).map(|i| format!("p{i},20,6,18,0\n")).collect();
    let none: String = (0..10).map(|i| format!("p{i},20,0,18,0\n")).collect();
    let head = "session,attempts,stumbled,caught,fallen\n";
    for (table, rows, count) in [
        (one, 1, 68),
        (format!("{head}{most}"), 10, 180),
        (format!("{head}{none}"), 10, 180),
    ] {
        let (study, found) = findings(&vocabulary, LEDGER, &table);
        assert_eq!(counts(&found[0]), (count, 200), "{found:?}");
        let said = found[0]["denominator"].to_string();
        assert!(
            said.contains(&format!("in {rows} of the 10 rows of")),
            "{said}"
        );
        let run = support::program::corroborate(study.path(), &["run", ".", "--format", "json"]);
        assert_eq!(run.code, 3, "{run:?}");
        let conclusion = study.json("run")["conclusions"][0].clone();
        assert_eq!(conclusion["verdict"], "not-covered", "{conclusion}");
        let left_out = conclusion["excluded"].to_string();
        assert!(
            left_out.contains("it counts all attempts, whether or not they trigger"),
            "{left_out}"
        );
    }
}

#[test]
fn the_opportunities_of_a_failure_mode_that_is_triggered_alike_do_it_in_all() {
    let vocabulary = VOCABULARY.replace(", column = \"STUMBLED\"", "");
    let ledger = format!("{LEDGER}tables.failure_modes = \"modes.csv\"\n");
    let (_, found) = findings(&vocabulary, &ledger, &cohort("other", 2));
    assert_eq!(counts(&found[0]), (67, 69), "{found:?}");
}

/// Where the tables do not say it every attempt counts.
#[test]
fn what_the_tables_do_not_say_is_not_guessed() {
    let vocabulary = VOCABULARY.replace(", column = \"STUMBLED\"", "");
    let (_, found) = findings(&vocabulary, LEDGER, &cohort("other", 2));
    assert_eq!(counts(&found[0]), (67, 200), "{found:?}");
}

/// That every attempt triggers it is said where nothing counts it, beside the figure and in what is concluded of it.
#[test]
fn attempts_that_are_taken_to_trigger_it_are_said_to_be() {
    let vocabulary = VOCABULARY.replace(", column = \"STUMBLED\"", "");
    let (study, _) = findings(&vocabulary, LEDGER, &cohort("other", 2));
    let conclusion = study.json("run")["conclusions"][0].clone();
    assert_eq!(conclusion["verdict"], "violated", "{conclusion}");
    let statement = conclusion["statement"].as_str().unwrap_or_default();
    let said =
        "it supposes that every attempt triggers it (stumbled), which its tables do not count";
    assert!(statement.contains(said), "{statement}");
    let condition = conclusion["standings"][0]["condition"].as_str();
    assert_eq!(
        condition,
        Some("67 of all 200 runs, each of which is taken to trigger it (stumbled)")
    );
    // Where it is counted nothing is supposed.
    let vocabulary = VOCABULARY.replace("STUMBLED", "stumbled");
    let (study, _) = findings(&vocabulary, LEDGER, &cohort("stumbled", 2));
    let statement = study.json("run")["conclusions"][0]["statement"].to_string();
    assert!(
        !statement.contains("it supposes that every attempt"),
        "{statement}"
    );
}

/// The study with a table of rows beside its cohort.
fn with_row(vocabulary: &str, (name, key, row): (&str, &str, &str)) -> Planted {
    let study = Planted::new();
    for (file, text) in [
        ("study.toml", STUDY),
        ("requirements.toml", REQUIREMENTS),
        ("vocabulary.toml", vocabulary),
        (
            "ledger.toml",
            &format!("{LEDGER}tables.{key} = \"{name}\"\n"),
        ),
        ("cohort.csv", &cohort("stumbled", 2)),
        (name, row),
    ] {
        study.write(file, text);
    }
    study
}

/// A row that says of another number of attempts that they triggered it than the column of what triggers it does.
#[test]
fn a_row_that_counts_other_trials_than_the_trigger_is_refused() {
    let vocabulary = VOCABULARY.replace("STUMBLED", "stumbled");
    for (name, key, row, line) in [
        (
            "modes.csv",
            "failure_modes",
            "mode,occurrences,opportunities\nfall,2,45\n",
            2,
        ),
        (
            "all.csv",
            "requirements",
            "requirement,covered,passed,failed\ncaught,70,67,3\n",
            2,
        ),
        (
            "all.csv",
            "requirements",
            "requirement,covered,passed,failed\ncaught,200,67,133\n",
            2,
        ),
    ] {
        let study = with_row(&vocabulary, (name, key, row));
        let said = support::program::corroborate(study.path(), &["run", ".", "--quiet"]);
        assert_eq!(said.code, 2, "{said:?}");
        assert!(said.talk.contains("error[tables-disagree]"), "{said:?}");
        assert!(said.talk.contains(&format!("{name}:{line}")), "{said:?}");
        assert!(
            said.talk.contains("69 attempts in which \"stumbled\" came"),
            "{said:?}"
        );
    }
}

/// Within a bound fewer of the attempts in which it came trigger it, and never more.
#[test]
fn a_row_of_a_bounded_trigger_has_at_most_the_trials_in_which_its_word_came() {
    let vocabulary = VOCABULARY.replace("STUMBLED", "stumbled");
    let bounded = "trigger = 'P=? [ F<=3 \"stumbled\" ]'\nexperiment = \"caught\"";
    let requirements = REQUIREMENTS.replacen("experiment = \"caught\"", bounded, 1);
    for (covered, passed, code) in [(70, 67, 2), (68, 67, 0)] {
        let study = Planted::new();
        let row = format!(
            "requirement,covered,passed,failed\ncaught,{covered},{passed},{}\n",
            covered - passed
        );
        for (file, text) in [
            ("study.toml", STUDY),
            ("requirements.toml", &requirements),
            ("vocabulary.toml", &vocabulary),
            (
                "ledger.toml",
                &format!("{LEDGER}tables.requirements = \"all.csv\"\n"),
            ),
            ("cohort.csv", &cohort("stumbled", 2)),
            ("all.csv", &row),
        ] {
            study.write(file, text);
        }
        let said = support::program::corroborate(study.path(), &["run", ".", "--quiet"]);
        assert_eq!(said.code, code, "{said:?}");
        assert_eq!(
            said.talk.contains("no others can trigger it"),
            code == 2,
            "{said:?}"
        );
    }
}

/// Several stumbles of one attempt, and trials whose verdict is not known, are no contradiction.
#[test]
fn rows_that_fit_the_trigger_are_taken() {
    let vocabulary = VOCABULARY.replace("STUMBLED", "stumbled");
    for (name, key, row) in [
        (
            "modes.csv",
            "failure_modes",
            "mode,occurrences,opportunities\nfall,2,90\n",
        ),
        (
            "all.csv",
            "requirements",
            "requirement,covered,passed,failed,undecided\ncaught,68,67,1,1\n",
        ),
    ] {
        let study = with_row(&vocabulary, (name, key, row));
        study.run();
    }
}

const MODEL: &str = "dtmc\nmodule suit\n s : [0..4] init 0;\n [] s=0 -> STUMBLES : (s'=1) + 1-STUMBLES : (s'=4);\n\
    [] s=1 -> 0.97 : (s'=2) + 0.03 : (s'=3);\n [] s>1 -> true;\nendmodule\n";

/// Where a model has runs that do not trigger it, attempts of which nothing says that they do are no trials of it, whatever form the trigger has.
#[test]
fn attempts_count_only_where_nothing_says_that_some_do_not_trigger_it() {
    let ledger = "[[evidence]]\nid = \"M\"\ntitle = \"A model\"\ntechnique = \"model-checking\"\nconditions = \"lab\"\n\
        model = \"model.prism\"\nchanged = \"The first.\"\n";
    let vocabulary = VOCABULARY.replace(", column = \"STUMBLED\"", "");
    for (stumbles, trigger, is_asked) in [
        ("0.4", "", false),
        ("0.4", "F<=1 \"stumbled\"", false),
        ("0.4", "G !\"fallen\"", false),
        ("1", "", true),
        ("1", "F<=1 \"stumbled\"", true),
    ] {
        let study = Planted::new();
        let requirements = match trigger {
            "" => REQUIREMENTS.to_owned(),
            path => REQUIREMENTS.replacen(
                "experiment = \"caught\"",
                &format!("trigger = 'P=? [ {path} ]'\nexperiment = \"caught\""),
                1,
            ),
        };
        for (name, text) in [
            ("study.toml", STUDY),
            ("requirements.toml", &requirements),
            ("vocabulary.toml", &vocabulary),
            ("ledger.toml", &format!("{ledger}{LEDGER}")),
            ("model.prism", &MODEL.replace("STUMBLES", stumbles)),
            ("cohort.csv", &cohort("other", 2)),
        ] {
            study.write(name, text);
        }
        study.run();
        let conclusion = study.json("run")["conclusions"][0].clone();
        let standings = conclusion["standings"].to_string();
        assert_eq!(
            standings.contains("\"T\""),
            is_asked,
            "{stumbles} {trigger}: {conclusion}"
        );
        let pairs = study.json("compare")["comparisons"].clone();
        let own = pairs
            .as_array()
            .expect("a list")
            .iter()
            .find(|it| it["subject"]["id"] == "caught");
        let outcome = &own.expect("the pair")["outcome"];
        assert_eq!(
            outcome != "not-comparable",
            is_asked,
            "{stumbles} {trigger}: {pairs}"
        );
    }
}
