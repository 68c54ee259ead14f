//! The rate over the runs that trigger a requirement, and the share of these runs, computed and counted: paths of random
//! chains are judged by the monitors of all kinds of sentences, and held against what the model checker computes.

use super::Over;
use crate::technique::matrix::ModelPaths;
use crate::technique::model_checking::{Compiled, MAX_STATES};
use host::Cancel;
use judging::Judges;
use prism_lang::Property;
use query::explore;
use std::path::Path;
use study::Study;
use temporal::monitor::Verdict;

const SCOPES: [&str; 8] = [
    "",
    "While m, ",
    "When not in m, ",
    "Before m, ",
    "After m, ",
    "Only in m, ",
    "Only before m, ",
    "Only after m, ",
];
const CONDITIONS: [&str; 4] = ["", "when c, ", "whenever c, ", "unless c, "];
const RESPONSES: [&str; 8] = [
    "immediately satisfy r",
    "eventually satisfy r",
    "always satisfy r",
    "never satisfy r",
    "until q satisfy r",
    "before q satisfy r",
    "within 2 steps satisfy r",
    "for 2 steps satisfy r",
];

const STUDY: &str = "title = \"t\"\nsummary = \"s\"\nseed = 1\nconfidence = 0.95\nagreement = 0.95\n\
                     [conditions]\ntypical = \"any\"\n[model]\nstep = \"1 s\"\n";
const LEDGER: &str = "[[evidence]]\nid = \"E1\"\ntitle = \"t\"\ntechnique = \"model-checking\"\n\
                      conditions = \"typical\"\nmodel = \"m.prism\"\nchanged = \"c\"\n";

/// States of a chain before its end.
const STATES: u64 = 7;

/// Numbers that look random (splitmix64).
struct Random(u64);

impl Random {
    fn below(&mut self, end: u64) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z ^ (z >> 31)) % end
    }
}

/// A chain that ends with probability 0.1 in each step, where no proposition holds.
fn chain(random: &mut Random) -> String {
    let mut text = format!("dtmc\nmodule m\n  s : [0..{STATES}] init 0;\n");
    for state in 0..STATES {
        let first = 1 + random.below(8);
        let (to, other) = (random.below(STATES), random.below(STATES));
        text.push_str(&format!(
            "  [] s={state} -> 0.1:(s'={STATES}) + 0.{first}:(s'={to}) + 0.{}:(s'={other});\n",
            9 - first
        ));
    }
    text + &format!("  [] s={STATES} -> (s'={STATES});\nendmodule\n")
}

/// Each proposition in each state but the last with probability 1/3.
fn vocabulary(random: &mut Random) -> String {
    let binding = |name: &str, random: &mut Random| {
        let of = (0..STATES).filter(|_| random.below(3) == 0);
        let states: Vec<String> = of.map(|state| format!("s={state}")).collect();
        let model = match states.is_empty() {
            true => "false".to_owned(),
            false => states.join(" | "),
        };
        format!("{name} = {{ meaning = \"{name}\", model = \"{model}\", trace = \"/t.{name}\" }}\n")
    };
    ["m", "c", "r", "q"]
        .map(|name| binding(name, random))
        .concat()
}

/// Sentences of every kind, and handwritten properties with the trigger of a handwritten monitor or formula.
fn requirements() -> String {
    let mut text = String::new();
    let mut add = |forms: &str| {
        let id = text.matches("[[requirement]]").count();
        text.push_str(&format!(
            "[[requirement]]\nid = \"r{id}\"\ntext = \"t\"\n{forms}\n"
        ));
    };
    for scope in SCOPES {
        for condition in CONDITIONS {
            for response in RESPONSES {
                let sentence = format!("{scope}{condition}the robot shall {response}.");
                add(&format!("shall = \"{sentence}\""));
            }
        }
    }
    add(
        "property = 'P=? [ G (\"c\" => \"r\") ]'\nmonitor.when = \"c\"\nmonitor.trigger = \"each_sample\"\n\
         monitor.then = [{ assert = \"r\" }]",
    );
    add("property = 'P=? [ G (\"c\" => (F \"r\")) ]'\nformula = \"always (c => eventually r)\"");
    add("property = 'P=? [ G !(\"m\" & \"q\") ]'\nformula = \"always !(m & q)\"");
    text
}

fn held_against_paths(seed: u64, paths: u64) -> usize {
    let mut random = Random(seed);
    let folder = tempfile::tempdir().expect("a folder");
    for (name, text) in [
        ("study.toml", STUDY.to_owned()),
        ("ledger.toml", LEDGER.to_owned()),
        ("m.prism", chain(&mut random)),
        ("vocabulary.toml", vocabulary(&mut random)),
        ("requirements.toml", requirements()),
    ] {
        std::fs::write(folder.path().join(name), text).expect("written");
    }
    let study = Study::load(folder.path()).unwrap_or_else(|it| panic!("{}", it.warning_line()));
    let compiled = Compiled::new(&study, Path::new("m.prism")).expect("a model");
    let interrupt = Cancel::default();
    let sampled = ModelPaths::of_entry(&study, "E1", &interrupt).expect("paths");
    let forms = study.forms.subjects.iter();
    let forms = forms.filter_map(|form| Some((&form.subject, form.monitor.as_ref()?)));
    let judges = Judges::without_study(sampled.vocabulary(), forms).expect("judges");
    let mut counts = vec![[0_u64; 3]; compiled.questions.len()];
    for number in 0..paths {
        let trace = sampled
            .trace(seed.wrapping_mul(1_000_003) + number)
            .expect("a path");
        for (count, judged) in counts
            .iter_mut()
            .zip(judges.judge_at_rest(&trace).expect("verdicts"))
        {
            count[match judged.findings.verdict {
                Verdict::Satisfied => 0,
                Verdict::Violated => 1,
                Verdict::NotCovered => 2,
                Verdict::Inconclusive => panic!("{:?} reached no verdict", judged.subject),
            }] += 1;
        }
    }
    let space = explore::<f64>(&compiled.source, &compiled.model, MAX_STATES, &|| false);
    let space = space.expect("states");
    let options = checker::Options::default();
    let mut conditional = 0;
    for (question, [kept, violated, untriggered]) in compiled.questions.iter().zip(counts) {
        let (rate, trigger) = question
            .rate_at(&mut |text| {
                let property: Property = compiled.property(&compiled.model, text)?;
                let answer = checker::check_space(&space, &property, &options).expect("an answer");
                match answer.value {
                    checker::AnswerValue::Number(value) => Ok(value),
                    other => panic!("{other:?}"),
                }
            })
            .expect("a rate");
        let said = format!(
            "seed {seed}, {:?}: {kept} {violated} {untriggered}",
            question.over
        );
        assert!(!matches!(question.over, Over::Unknown(_)), "{said}");
        let covered = kept + violated;
        close(covered, paths, trigger.unwrap_or(1.0), &said);
        match rate {
            Some(rate) => close(kept, covered, rate, &said),
            None => assert_eq!(covered, 0, "{said}"),
        }
        conditional += usize::from(trigger.is_some_and(|it| it > 0.01 && it < 0.99));
    }
    conditional
}

/// Whether a count is likely at a probability: chance alone would fail this once in a thousand runs of all these tests.
fn close(count: u64, trials: u64, probability: f64, said: &str) {
    let probability = match probability {
        p if p < 1e-9 => 0.0,
        p if p > 1.0 - 1e-9 => 1.0,
        p => p,
    };
    let sample = stats::Sample::new(count, trials).expect("counts");
    let p = match trials {
        0 => 1.0,
        _ => stats::binomial_test_two_sided(sample, probability),
    };
    assert!(
        p > 1e-7,
        "{count} of {trials} at {probability}: p {p:.1e}; {said}"
    );
}

#[test]
fn rates_over_the_triggering_paths_of_random_chains_are_those_that_are_computed() {
    let conditional: usize = (1..=4).map(|seed| held_against_paths(seed, 250)).sum();
    // Many triggers are neither certain nor impossible.
    assert!(conditional > 150, "{conditional}");
}
