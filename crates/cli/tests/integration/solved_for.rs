//! What the counts leave open of a constant that was solved for is in what its model computes.

use crate::support;

use serde_json::Value;
use support::planted::{LEDGER, Planted};

/// A cup may break in each of three steps, and is then lifted and put down, each of which may fail.
const MODEL: &str = "dtmc\nconst double pBreaks = 0.1120960;\nconst double pWorks = 0.7559289;\nmodule cup\n  \
    step : [0..7] init 0;\n  [] step<3 -> 1-pBreaks : (step'=step+1) + pBreaks : (step'=6);\n  \
    [] step=3 -> pWorks : (step'=4) + 1-pWorks : (step'=7);\n  [] step=4 -> pWorks : (step'=5) + 1-pWorks : (step'=7);\n  \
    [] step>=5 -> true;\nendmodule\n";

const REQUIREMENTS: &str = "[[requirement]]\nid = \"whole\"\ntext = \"No cup breaks.\"\nproperty = 'P=? [ G !\"broken\" ]'\nmargin = 0.1\n\
    [[requirement]]\nid = \"placed\"\ntext = \"The cup stands.\"\nproperty = 'P=? [ F \"stands\" ]'\nmargin = 0.1\n\
    [[requirement]]\nid = \"begins\"\ntext = \"The first step is done.\"\nproperty = 'P=? [ F \"begun\" ]'\nmargin = 0.1\n\
    [[requirement]]\nid = \"lifts\"\ntext = \"What arrives is lifted.\"\nproperty = 'P=? [ F \"lifted\" || F \"arrived\" ]'\nmargin = 0.1\n";

const VOCABULARY: &str = "broken = { meaning = \"it is broken\", model = \"step=6\" }\n\
    stands = { meaning = \"it stands\", model = \"step=5\" }\nbegun = { meaning = \"it has begun\", model = \"step=1\" }\n\
    arrived = { meaning = \"it has arrived\", model = \"step=3\" }\nlifted = { meaning = \"it is lifted\", model = \"step=4\" }\n";

const COUNTS: &str = "requirement,covered,passed,failed\nwhole,100,70,30\nplaced,100,40,60\n";

/// The study, whose ledger says where the numbers of its model are from.
fn study(calibrated: &str, model: &str) -> Planted {
    of_files([REQUIREMENTS, VOCABULARY, model, COUNTS], calibrated)
}

fn of_files(files: [&str; 4], calibrated: &str) -> Planted {
    let study = Planted::of_model_and_counts(files);
    let entries: Vec<&str> = LEDGER.split("[[evidence]]").collect();
    // The trials first: what is set to counts comes after them.
    let ledger = format!(
        "[[evidence]]{}[[evidence]]{}calibrated = [{calibrated}]\n",
        entries[2], entries[1]
    );
    study.write("ledger.toml", &ledger);
    study.run();
    study
}

/// The distribution of what the model computes for a requirement.
fn credible(study: &Planted, requirement: &str) -> Value {
    let findings = study.findings("M");
    let mut findings = findings.iter();
    let finding = findings.find(|it| it["subject"]["id"] == requirement);
    finding.expect("the finding")["measure"]["credible"].clone()
}

fn is_near(found: &Value, [low, high]: [f64; 2], tolerance: f64) {
    let end = |name: &str| found["interval"][name].as_f64().unwrap_or(f64::NAN);
    let [of_low, of_high] = [(end("low"), low), (end("high"), high)];
    for (found, expected) in [of_low, of_high] {
        assert!(
            (found - expected).abs() < tolerance,
            "{found}, not {expected}"
        );
    }
}

const BREAKS: &str = "{ parameter = \"pBreaks\", from = \"T\", requirement = \"whole\" }";
const WORKS: &str = "{ parameter = \"pWorks\", from = \"T\", requirement = \"placed\" }";

/// The third root of the beta distribution of 70 of 100 (Jeffreys), by scipy's quantiles.
#[test]
fn a_constant_that_was_solved_for_is_as_uncertain_as_its_counts() {
    let study = study(BREAKS, MODEL);
    is_near(&credible(&study, "begins"), [0.845_98, 0.921_76], 0.003);
    let of_its_own = credible(&study, "whole");
    assert_eq!(
        of_its_own["spread"][0]["constant"], "pBreaks",
        "{of_its_own}"
    );
}

/// The root of the quotient of the beta distributions of 40 and of 70 of 100, by four million draws of numpy's.
#[test]
fn of_two_that_act_together_each_is_solved_for_at_the_others_value() {
    let study = study(&format!("{BREAKS}, {WORKS}"), MODEL);
    is_near(&credible(&study, "begins"), [0.845_98, 0.921_76], 0.003);
    is_near(&credible(&study, "lifts"), [0.656_04, 0.862_23], 0.004);
}

#[test]
fn a_number_that_does_not_give_the_rate_is_not_carried_and_the_verdict_says_so() {
    let other = MODEL.replace("0.1120960", "0.2");
    let study = study(BREAKS, &other);
    assert_eq!(credible(&study, "begins"), Value::Null);
    let words = said(&study);
    assert!(
        words.contains("In M `pBreaks` from the counts of T was set or solved for: how uncertain"),
        "{words}"
    );
}

/// What is said of the study, in one line.
fn said(study: &Planted) -> String {
    let said = support::program::corroborate(study.path(), &["run", ".", "--quiet"]);
    said.out.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// A quarter of the cups is held without the grip, half of them by it: with an even chance the model has half, which is no share of it.
/// The ends are those of twice the beta distribution of 50 of 100 less a quarter.
#[test]
fn a_constant_that_happens_to_be_the_rate_is_solved_for_all_the_same() {
    let model = "dtmc\nconst double pBreaks = 0.5;\nmodule cup\n  step : [0..6] init 0;\n  \
        [] step=0 -> 0.25 : (step'=3) + 0.5 : (step'=1) + 0.25 : (step'=6);\n  \
        [] step=1 -> pBreaks : (step'=3) + 1-pBreaks : (step'=6);\n  [] step>=3 -> true;\nendmodule\n";
    let requirements = REQUIREMENTS.replace("F \"begun\"", "F \"arrived\" || F \"begun\"");
    let counts = "requirement,covered,passed,failed\nwhole,100,50,50\n";
    let study = of_files([&requirements, VOCABULARY, model, counts], BREAKS);
    is_near(&credible(&study, "begins"), [0.307, 0.693], 0.006);
}

/// Of two constants that one count was to give neither is known.
#[test]
fn one_count_does_not_tell_two_constants() {
    let works = WORKS.replace("placed", "whole");
    let counts = COUNTS.replace("placed,100,40,60\n", "");
    let study = of_files(
        [REQUIREMENTS, VOCABULARY, MODEL, &counts],
        &format!("{BREAKS}, {works}"),
    );
    assert_eq!(credible(&study, "begins"), Value::Null);
    let words = said(&study);
    assert!(
        words.contains("were set or solved for: how uncertain"),
        "{words}"
    );
}

/// The model breaks more than a quarter of the cups, whatever the number is: what the counts leave beyond that is said. The share is
/// that of the beta distribution of 70 of 100 above 0.9^3, by scipy.
#[test]
fn what_a_model_cannot_have_is_said() {
    let model = MODEL
        .replace(
            "1-pBreaks : (step'=step+1) + pBreaks : (step'=6)",
            "0.9*(1-pBreaks) : (step'=step+1) + 1-0.9*(1-pBreaks) : (step'=6)",
        )
        .replace("0.1120960", "0.0134446");
    let study = of_files([REQUIREMENTS, VOCABULARY, &model, COUNTS], BREAKS);
    let found = credible(&study, "whole");
    let share = found["out_of_reach"].as_f64().expect("a share");
    assert!((share - 0.2540).abs() < 0.005, "{share}");
    let words = said(&study);
    assert!(words.contains("is beyond what M can have"), "{words}");
}
