//! What a model lacks: the branch to a state that a requirement names and nothing leads to, the branch that an unused constant was
//! written for, a further word in a reading; and that what is accepted is a study that runs.

use crate::support;

use serde_json::Value;
use support::planted::Planted;
use support::program::{Study, corroborate};

const STUDY: &str = "title = \"A waiter\"\nsummary = \"A robot carries cups.\"\nseed = 1\nconfidence = 0.95\nagreement = 0.95\n\
                     sample_sizes = \"fixed\"\n[conditions]\nusual = \"In the evening.\"\n";

const REQUIREMENTS: &str = "[[requirement]]\nid = \"whole\"\ntext = \"No cup breaks.\"\nproperty = 'P=? [ G !\"broken\" ]'\nmargin = 0.04\n\
                            [[requirement]]\nid = \"served\"\ntext = \"Cups are served.\"\nproperty = 'P=? [ F \"served\" ]'\n\
                            margin = 0.04\n";

const VOCABULARY: &str = "broken = { meaning = \"it is broken\", model = \"cup=broken\" }\n\
                          served = { meaning = \"it is served\", model = \"cup=served\" }\n";

const LEDGER: &str = "[[evidence]]\nid = \"M\"\ntitle = \"model\"\ntechnique = \"model-checking\"\nconditions = \"usual\"\n\
    model = \"waiter.prism\"\nchanged = \"c\"\n\
    [[evidence]]\nid = \"T\"\ntitle = \"evenings\"\ntechnique = \"experiment\"\nconditions = \"usual\"\n\
    tables.requirements = \"evenings.csv\"\nchanged = \"c\"\n";

/// Of ten cups one breaks on the way, and of the others three in ten are refused.
fn model(carry: &str) -> String {
    format!(
        "dtmc\nconst int kitchen = 0;\nconst int table = 1;\nconst int served = 2;\nconst int broken = 3;\nconst int refused = 4;\n\
         const double pHolds = 0.9;\nconst double pTakes = 0.7;\nmodule waiter\n  cup : [kitchen..refused] init kitchen;\n  \
         [] cup=kitchen -> {carry};\n  [] cup=table -> pTakes : (cup'=served) + 1-pTakes : (cup'=refused);\n  [] cup>table -> true;\n\
         endmodule\n"
    )
}

const SOUND: &str = "pHolds : (cup'=table) + 1-pHolds : (cup'=broken)";
const LACKING: &str = "(cup'=table)";

fn study(model: &str) -> Planted {
    let study = Planted::new();
    study.write("study.toml", STUDY);
    study.write("requirements.toml", REQUIREMENTS);
    study.write("vocabulary.toml", VOCABULARY);
    study.write("ledger.toml", LEDGER);
    study.write("waiter.prism", model);
    study.write(
        "evenings.csv",
        "requirement,covered,passed,failed\nwhole,1000,903,97\nserved,1000,634,366\n",
    );
    study.run();
    study
}

fn first<'v>(found: &'v Value, list: &str) -> &'v Value {
    &found[list][0]
}

#[test]
fn a_constant_that_nothing_uses_is_put_where_it_belongs_and_the_study_runs_on() {
    let sound = study(&model(SOUND));
    assert_eq!(sound.json("diagnose")["suspects"], Value::Array(vec![]));
    let study = study(&model(LACKING));
    let found = study.json("diagnose");
    let suspect = first(&found, "suspects");
    assert_eq!(suspect["asset"]["file"], "waiter.prism", "{suspect}");
    assert_eq!(suspect["asset"]["line"], 11, "{suspect}");
    let offered = study.json("refine");
    let proposal = first(&offered, "proposals");
    assert_eq!(proposal["needs_decision"], true, "{proposal}");
    let diff = proposal["diff"].as_str().expect("a diff");
    let line = "+  [] cup=kitchen -> pHolds : (cup'=table) + 1-pHolds : (cup'=broken);";
    assert!(diff.contains(line), "{diff}");
    let accepted = corroborate(study.path(), &["refine", ".", "--accept", "1", "--quiet"]);
    assert!(accepted.code < 2, "{accepted:?}");
    study.run();
    let found = study.json("diagnose");
    let mut left = found["suspects"].as_array().expect("a list").iter();
    assert!(left.all(|it| it["resolved_by"] == "M-r1"), "{found}");
}

#[test]
fn a_state_that_nothing_leads_to_gets_a_branch_whose_probability_is_solved_for() {
    let text = model(LACKING).replace("const double pHolds = 0.9;\n", "");
    let study = study(&text);
    let found = study.json("diagnose");
    let suspect = first(&found, "suspects");
    assert_eq!(suspect["asset"]["file"], "waiter.prism", "{suspect}");
    let offered = study.json("refine");
    let all = offered["proposals"].as_array().expect("a list");
    let diff = all[0]["diff"].as_str().expect("a diff");
    assert!(diff.contains("(cup'=broken)"), "{diff}");
    assert_eq!(all[0]["needs_decision"], true);
    let accepted = corroborate(study.path(), &["refine", ".", "--accept", "1", "--quiet"]);
    assert!(accepted.code < 2, "{accepted:?}");
    study.run();
}

/// Neither proposition names that a cup breaks; one case of a guard does.
#[test]
fn a_state_that_one_case_of_a_guard_names_is_where_an_unused_constant_leads() {
    let text = model(LACKING).replace("cup>table", "cup=served | cup=broken | cup=refused");
    let study = Planted::new();
    let served = REQUIREMENTS.find("[[requirement]]\nid = \"served\"");
    study.write("study.toml", STUDY);
    study.write(
        "requirements.toml",
        &REQUIREMENTS[served.expect("a requirement")..],
    );
    study.write(
        "vocabulary.toml",
        VOCABULARY.lines().last().expect("a line"),
    );
    study.write("ledger.toml", LEDGER);
    study.write("waiter.prism", &text);
    study.write(
        "evenings.csv",
        "requirement,covered,passed,failed\nserved,1000,634,366\n",
    );
    study.run();
    let offered = study.json("refine");
    let proposal = first(&offered, "proposals");
    let diff = proposal["diff"].as_str().expect("a diff");
    let line = "+  [] cup=kitchen -> pHolds : (cup'=table) + 1-pHolds : (cup'=broken);";
    assert!(diff.contains(line), "{diff}");
}

/// The camera is blind in 12 % of the encounters, for five steps; else it sees in the first step (60 %) or in the second.
const CAMERA: &str = "dtmc\nconst int looks = 0;\nconst int dark = 1;\nconst int brakes = 2;\nconst int stands = 3;\n\
    const double pGlare = 0.12;\nconst double pSoon = 0.6;\nconst int nDark = 5;\nconst int nBrake = 3;\nmodule camera\n  \
    m : [looks..stands] init looks;\n  left : [0..9] init 0;\n  \
    [] m=looks & left=0 -> pSoon : (m'=brakes) & (left'=nBrake) + 1-pSoon : (left'=1);\n  \
    [] m=looks & left=1 -> (m'=brakes) & (left'=nBrake);\n  [] m=dark & left>0 -> (left'=left-1);\n  \
    [] m=dark & left=0 -> (m'=brakes) & (left'=nBrake);\n  [] m=brakes & left>1 -> (left'=left-1);\n  \
    [] m=brakes & left=1 -> (m'=stands) & (left'=0);\n  [] m=stands -> true;\nendmodule\n";

/// A branch beside all that a command does: its constant, its number of steps and its state stand nowhere else.
#[test]
fn a_branch_beside_all_updates_of_a_command_leads_where_nothing_else_does() {
    let requirements = "[[requirement]]\nid = \"soon\"\ntext = \"It stands at once.\"\nproperty = 'P=? [ F<=4 \"still\" ]'\n\
                        margin = 0.03\n[[requirement]]\nid = \"stops\"\ntext = \"It stands in time.\"\n\
                        property = 'P=? [ F<=6 \"still\" ]'\nmargin = 0.03\n";
    let vocabulary = "still = { meaning = \"it stands\", model = \"m=stands\" }\n";
    let counts = "requirement,covered,passed,failed\nsoon,2000,1056,944\nstops,2000,1760,240\n";
    let (line, diff) =
        Planted::of_model_and_counts([requirements, vocabulary, CAMERA, counts]).first_of_model();
    assert_eq!(line, 13, "{diff}");
    assert!(diff.contains("(1-pGlare)*pSoon : (m'=brakes)"), "{diff}");
    assert!(
        diff.contains("+ pGlare : (m'=dark) & (left'=nDark);"),
        "{diff}"
    );
}

#[test]
fn a_number_that_was_solved_for_is_a_number_of_the_study_from_then_on() {
    let study = Study::of_template("formal");
    let text = support::read(&study.path("model.prism"));
    study.write("model.prism", text.replace("pOpens = 0.6", "pOpens = 0.15"));
    for call in [["run", "study"], ["diagnose", "study"]] {
        let said = study.run(&[call[0], call[1], "--quiet"]);
        assert!(said.code < 4 && said.code != 2, "{said:?}");
    }
    // What the counts leave open leaves a requirement of the model undecided.
    let said = study.run(&["refine", "study", "--accept", "1", "--quiet"]);
    assert_eq!(said.code, 3, "{said:?}");
    let ledger = support::read(&study.path("ledger.toml"));
    assert!(ledger.contains("parameter = \"pOpens\""), "{ledger}");
    let said = study.run(&["run", "study", "--quiet"]);
    assert!(said.code < 4 && said.code != 2, "{said:?}");
    // What the counts leave open of it is in the model's figures, which cannot be as high as some of that.
    assert!(!said.out.contains("was set or solved for"), "{said:?}");
    assert!(said.out.contains("Of what the counts leave"), "{said:?}");
    // A name that the model does not have is told.
    study.write(
        "ledger.toml",
        ledger.replace("parameter = \"pOpens\"", "parameter = \"pOpen\""),
    );
    let said = study.run(&["run", "study", "--quiet"]);
    assert_eq!(said.code, 2, "{said:?}");
    assert!(said.talk.contains("did you mean `pOpens`?"), "{said:?}");
}
