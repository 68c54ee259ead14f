//! What a study says of its verdicts, through its files: the step that a requirement needs, what carries over to it, and
//! for what error rates hold. Each in a small study of its own, with the verdict, its step and the exit code.

use crate::support;

use serde_json::Value;
use support::program::{Said, corroborate};
use tempfile::TempDir;

/// A study of these requirements: a model, if there is one, and a table of trials.
struct Study<'a> {
    verdicts: &'a str,
    requirements: String,
    vocabulary: &'a str,
    model: Option<&'a str>,
    /// Requirement, trials, passed.
    trials: &'a [(&'a str, u64, u64)],
}

/// What a run gave.
struct Judged {
    said: Said,
    conclusions: Vec<Value>,
}

impl Study<'_> {
    fn judged(&self) -> Judged {
        let folder = TempDir::new().expect("a folder");
        let mut ledger = String::new();
        if self.model.is_some() {
            ledger += "[[evidence]]\nid = \"M\"\ntitle = \"model\"\ntechnique = \"model-checking\"\n\
                       conditions = \"daytime\"\nmodel = \"m.prism\"\nchanged = \"c\"\n";
        }
        ledger += "[[evidence]]\nid = \"X\"\ntitle = \"trials\"\ntechnique = \"experiment\"\n\
                   conditions = \"daytime\"\ntables.requirements = \"r.csv\"\nchanged = \"c\"\n";
        let rows = self
            .trials
            .iter()
            .map(|(id, trials, passed)| format!("{id},{trials},{passed},{}\n", trials - passed));
        let table = format!(
            "requirement,covered,passed,failed\n{}",
            rows.collect::<String>()
        );
        let about = format!(
            "title = \"t\"\nsummary = \"s\"\nseed = 1\nconfidence = 0.95\nagreement = 0.95\n\
             [conditions]\ndaytime = \"any\"\n{}\n",
            self.verdicts
        );
        for (name, text) in [
            ("study.toml", about.as_str()),
            ("requirements.toml", &self.requirements),
            ("vocabulary.toml", self.vocabulary),
            ("ledger.toml", &ledger),
            ("m.prism", self.model.unwrap_or_default()),
            ("r.csv", &table),
        ] {
            std::fs::write(folder.path().join(name), text).expect("written");
        }
        let said = corroborate(folder.path(), &["run", ".", "--format", "json"]);
        let result: Option<Value> = serde_json::from_str(&said.out).ok();
        let conclusions = result.and_then(|it| it["conclusions"].as_array().cloned());
        Judged {
            conclusions: conclusions.unwrap_or_default(),
            said,
        }
    }
}

impl Judged {
    /// The verdict and the step of a requirement; `none` where it stands on none.
    fn verdict(&self, id: &str) -> (&str, &str) {
        let mut all = self.conclusions.iter();
        let own = all.find(|it| it["requirement"] == id);
        let own = own.unwrap_or_else(|| panic!("{id}: {:?}", self.said));
        let verdict = own["verdict"].as_str().expect("a verdict");
        (verdict, own["step"].as_str().unwrap_or("none"))
    }

    fn is_refused_with(&self, parts: &[&str]) {
        assert_eq!(self.said.code, 2, "{:?}", self.said);
        for part in parts {
            assert!(self.said.talk.contains(part), "{part}: {}", self.said.talk);
        }
    }
}

/// A gantry waters the beds of a greenhouse.
fn watering(verdicts: &str, own: &str, (trials, passed): (u64, u64)) -> Judged {
    Study {
        verdicts,
        requirements: format!(
            "[[requirement]]\nid = \"beds\"\ntext = \"Every bed shall be watered in 80 % of the rounds.\"\n\
             margin = 0.1\nthreshold = \"at least 0.8\"\nproperty = 'P=? [ F \"watered\" ]'\n{own}\n"
        ),
        vocabulary: "watered = { meaning = \"all beds are wet\", model = \"beds=3\" }\n",
        model: Some(
            "dtmc\nmodule gantry\n  beds : [0..4] init 0;\n\
             [] beds<3 -> 0.99:(beds'=beds+1) + 0.01:(beds'=4);\n  [] beds>=3 -> true;\nendmodule\n",
        ),
        trials: &[("beds", trials, passed)],
    }
    .judged()
}

#[test]
fn a_verdict_for_the_model_is_enough_only_where_the_study_says_so() {
    // 0.8^8 is 0.17: eight rounds decide nothing, and the model computes 0.97.
    let few = (8, 8);
    let model = ("satisfied", "model");
    for (verdicts, own, code) in [
        ("", "", 3),
        ("[verdicts]\nneeds = \"model\"", "", 0),
        ("", "needs = \"model\"", 0),
        // A requirement's own step counts, not the study's.
        ("[verdicts]\nneeds = \"model\"", "needs = \"system\"", 3),
        ("[verdicts]\nneeds = \"system\"", "needs = \"model\"", 0),
        ("", "needs = \"simulation\"", 3),
    ] {
        let found = watering(verdicts, own, few);
        assert_eq!(found.verdict("beds"), model, "{verdicts} {own}");
        assert_eq!(found.said.code, code, "{verdicts} {own}: {:?}", found.said);
    }
}

#[test]
fn trials_of_the_system_decide_on_whatever_step_is_needed() {
    for own in ["needs = \"model\"", "", "needs = \"system\""] {
        let found = watering("", own, (60, 58));
        assert_eq!(found.verdict("beds"), ("satisfied", "system"));
        assert_eq!(found.said.code, 0, "{own}: {:?}", found.said);
        let found = watering("", own, (60, 30));
        assert_eq!(found.verdict("beds"), ("violated", "system"));
        assert_eq!(found.said.code, 1, "{own}: {:?}", found.said);
    }
}

#[test]
fn a_step_that_does_not_exist_is_refused_with_those_that_do() {
    let parts = ["simulation", "corroborated", "system"];
    watering("", "needs = \"field\"", (8, 8))
        .is_refused_with(&[&parts[..], &["requirements.toml:"]].concat());
    watering("[verdicts]\nneeds = \"field\"", "", (8, 8))
        .is_refused_with(&[&parts[..], &["study.toml:"]].concat());
}

/// A ferry lowers its ramp; what ice does, only the model says.
fn ramp(carries_over: &str, passed_dry: u64) -> Judged {
    let property = |label: &str| format!("property = 'P=? [ F \"{label}\" ]'");
    Study {
        verdicts: "",
        requirements: format!(
            "[[requirement]]\nid = \"dry\"\ntext = \"The ramp shall lie flat on a dry quay.\"\nmargin = 0.1\n\
             threshold = \"at least 0.5\"\n{}\n\
             [[requirement]]\nid = \"ice\"\ntext = \"The ramp shall lie flat on ice.\"\nmargin = 0.1\n\
             threshold = \"at least 0.85\"\n{}\n{carries_over}\n",
            property("flat"),
            property("flat_on_ice")
        ),
        vocabulary: "flat = { meaning = \"on a dry quay\", model = \"dry=1\" }\n\
                     flat_on_ice = { meaning = \"on ice\", model = \"ice=1\" }\n",
        model: Some(
            "dtmc\nmodule quay\n  dry : [0..2] init 0;\n  [] dry=0 -> 0.9:(dry'=1) + 0.1:(dry'=2);\n\
             [] dry>0 -> true;\nendmodule\n\
             module frost\n  ice : [0..2] init 0;\n  [] ice=0 -> 0.99:(ice'=1) + 0.01:(ice'=2);\n\
             [] ice>0 -> true;\nendmodule\n",
        ),
        trials: &[("dry", 200, passed_dry)],
    }
    .judged()
}

const CARRIES: &str = "[[requirement.carries_over]]\nevidence = \"M\"\non = \"dry\"\nbecause = \"the same hydraulics\"\n";

#[test]
fn a_model_carries_over_where_it_is_declared_and_agrees_with_trials() {
    let satisfied = |step| ("satisfied", step);
    let found = ramp("", 180);
    assert_eq!(found.verdict("ice"), satisfied("model"));
    assert_eq!(found.said.code, 3, "{:?}", found.said);
    let found = ramp(CARRIES, 180);
    assert_eq!(found.verdict("dry"), satisfied("system"));
    assert_eq!(found.verdict("ice"), satisfied("corroborated"));
    assert_eq!(found.said.code, 0, "{:?}", found.said);
    // It is not enough for a requirement of the system.
    let system = format!("needs = \"system\"\n{CARRIES}");
    let found = ramp(&system, 180);
    assert_eq!(found.verdict("ice"), satisfied("corroborated"));
    assert_eq!(found.said.code, 3, "{:?}", found.said);
    // The model conflicts with the trials of what it is to carry over from: it carries nothing over.
    let found = ramp(CARRIES, 140);
    assert_eq!(found.verdict("ice"), satisfied("model"));
    assert_ne!(found.said.code, 0, "{:?}", found.said);
}

#[test]
fn what_cannot_carry_over_is_refused_at_its_place() {
    let of = |old: &str, new: &str| ramp(&CARRIES.replace(old, new), 180);
    of("\"M\"", "\"N\"").is_refused_with(&["`N`", "requirements.toml:"]);
    of("\"M\"", "\"X\"").is_refused_with(&["model or simulation", "`X`", "requirements.toml:"]);
    of("\"dry\"", "\"wet\"").is_refused_with(&["`wet`", "requirements.toml:"]);
    of("because = \"the same hydraulics\"\n", "")
        .is_refused_with(&["because", "requirements.toml:"]);
}

/// A machine sorts returned books; 96 of 100 have p = 0.024 against fewer than 90 %.
fn sorting(verdicts: &str, shelves: usize, passed: u64) -> Judged {
    let ids = ["a", "b", "c", "d"];
    let requirements = ids[..shelves].iter().map(|id| {
        format!(
            "[[requirement]]\nid = \"{id}\"\ntext = \"Books of shelf {id} shall come there.\"\nmargin = 0.1\n\
             threshold = \"at least 0.9\"\n"
        )
    });
    let trials: Vec<(&str, u64, u64)> =
        ids[..shelves].iter().map(|id| (*id, 100, passed)).collect();
    Study {
        verdicts,
        requirements: requirements.collect(),
        vocabulary: "",
        model: None,
        trials: &trials,
    }
    .judged()
}

#[test]
fn error_rates_hold_for_the_study_unless_they_are_asked_for_each_requirement() {
    let (satisfied, undecided) = (("satisfied", "system"), ("undecided", "none"));
    let each = "[verdicts]\nerror_rate = \"requirement\"";
    let study = "[verdicts]\nerror_rate = \"study\"";
    for (verdicts, shelves, passed, verdict, code) in [
        // One requirement is the study.
        ("", 1, 96, satisfied, 0),
        (each, 1, 96, satisfied, 0),
        // Of four each has a quarter of the level.
        ("", 4, 96, undecided, 3),
        (study, 4, 96, undecided, 3),
        (each, 4, 96, satisfied, 0),
        // What is shown at a quarter is shown either way.
        ("", 4, 99, satisfied, 0),
    ] {
        let found = sorting(verdicts, shelves, passed);
        assert_eq!(found.verdict("a"), verdict, "{verdicts} {shelves} {passed}");
        assert_eq!(
            found.said.code, code,
            "{verdicts} {shelves}: {:?}",
            found.said
        );
        let rate = &found.conclusions[0]["error_rate"];
        let family = if verdicts == each {
            "requirement"
        } else {
            "study"
        };
        assert_eq!(rate["holds_for"], family, "{rate}");
    }
    sorting("[verdicts]\nerror_rate = \"all\"", 1, 96)
        .is_refused_with(&["requirement", "study.toml:"]);
}
