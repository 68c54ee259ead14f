//! Generated tests keep their rules, come again from their seed, and differ.

use std::collections::BTreeSet;

use proptest::prelude::*;
use stimulus::{AbstractTest, Action, Stimulus};

use super::*;
use crate::error::CampaignError;
use crate::random::Random;

const GRAMMAR: &str = r#"
name = "handover"
length = [2, 7]
begins = ["send activate"]

[[action]]
send_signal = "activate"
most = 1
after_secs = { uniform = [0.5, 6.0] }

[[action]]
receive_signal = "announcement"
most = 1

[[action]]
send_signal = "ready"
most = 2

[[action]]
set_param = { gaze = [true, false], pull = { uniform = [1.0, 15.0] }, hand = ["near", "far"] }
weight = 2

[[rule]]
action = "send ready"
needs_before = "receive announcement"
never_after = "set hand=far"

[[rule]]
action = "set gaze=false"
needs_after = "send ready"
"#;

fn grammar() -> Grammar {
    Grammar::from_toml(GRAMMAR).unwrap()
}

fn place(test: &AbstractTest, pattern: &str) -> Option<usize> {
    let pattern = ActionPattern::try_from(pattern.to_owned()).unwrap();
    test.actions
        .iter()
        .position(|action| pattern.matches(action))
}

/// The rules of the grammar, told once more.
fn keeps_rules(test: &AbstractTest) -> bool {
    let last_of = |wanted: &str| {
        let pattern = ActionPattern::try_from(wanted.to_owned()).unwrap();
        test.actions
            .iter()
            .rposition(|action| pattern.matches(action))
    };
    let before = |a: Option<usize>, b: Option<usize>| b.is_none() || a.is_some_and(|a| Some(a) < b);
    let ready = place(test, "send ready");
    let far = place(test, "set hand=far");
    let ready_after_far = far.is_some() && last_of("send ready") > far;
    let looks_away = last_of("set gaze=false");
    (2..=7).contains(&test.actions.len())
        && place(test, "send activate") == Some(0)
        && before(place(test, "receive announcement"), ready)
        && !ready_after_far
        && (looks_away.is_none() || last_of("send ready") > looks_away)
}

proptest! {
    #[test]
    fn generated_tests_and_mutants_keep_the_rules(seed in any::<u64>()) {
        let grammar = grammar();
        let mut random = Random::new(seed, "tests");
        let test = grammar.generate(&mut random).unwrap();
        prop_assert!(keeps_rules(&test), "{test}");
        test.check().unwrap();
        let other = grammar.generate(&mut random).unwrap();
        let mutant = grammar.mutate(&test, &[other], &mut random).unwrap();
        prop_assert!(keeps_rules(&mutant), "{mutant}");
        let content = |test: &AbstractTest| Stimulus::of(test.clone()).content_hash();
        prop_assert_ne!(content(&mutant), content(&test));
        let again = grammar.generate(&mut Random::new(seed, "tests")).unwrap();
        prop_assert_eq!(again, test);
    }

    #[test]
    fn goals_are_met(seed in any::<u64>()) {
        let goals = ["set gaze=false", "send ready", "set hand=far"].map(|goal| {
            ActionPattern::try_from(goal.to_owned()).unwrap()
        });
        let test = grammar().generate_for(&goals, &mut Random::new(seed, "tests")).unwrap();
        prop_assert!(keeps_rules(&test) && goals.iter().all(|goal| goal.is_in(&test)), "{test}");
    }
}

#[test]
fn tests_differ() {
    let grammar = grammar();
    let mut random = Random::new(1, "tests");
    let tests: Vec<AbstractTest> = (0..300)
        .map(|_| grammar.generate(&mut random).unwrap())
        .collect();
    let forms: BTreeSet<String> = tests.iter().map(|test| test.to_string()).collect();
    assert!(forms.len() > 150, "{}", forms.len());
    let lengths: BTreeSet<usize> = tests.iter().map(|test| test.actions.len()).collect();
    assert_eq!(lengths, (2..=7).collect());
    let mut known = Known::default();
    let new = tests.iter().filter(|test| known.is_new(test)).count();
    assert_eq!(new, known.len());
    assert!(tests.iter().all(|test| !known.is_new(test)));
}

#[test]
fn each_kind_of_mutation_happens() {
    let grammar = grammar();
    let mut random = Random::new(1, "tests");
    let start = grammar
        .generate_for(&[ActionPattern::Send("ready".into())], &mut random)
        .unwrap();
    let others = [grammar.generate(&mut random).unwrap()];
    let lengths: BTreeSet<usize> = (0..200)
        .map(|_| {
            grammar
                .mutate(&start, &others, &mut random)
                .unwrap()
                .actions
                .len()
        })
        .collect();
    assert!(lengths.iter().any(|n| *n < start.actions.len()));
    let delayed = (0..200)
        .map(|_| grammar.mutate(&start, &others, &mut random).unwrap())
        .filter(|test| test.actions[0] != start.actions[0])
        .count();
    assert!(delayed > 5, "{delayed}");
}

#[test]
fn impossible_wishes_are_said() {
    let never = GRAMMAR.replace("length = [2, 7]", "length = [2, 2]");
    let never = Grammar::from_toml(&never).unwrap();
    let ready = ActionPattern::Send("ready".into());
    let mut random = Random::new(1, "tests");
    assert_eq!(
        never.generate_for(&[ready], &mut random),
        Err(CampaignError::TooTight { tried: 2000 })
    );
    let unknown = ActionPattern::Send("redy".into());
    let error = grammar().generate_for(&[unknown], &mut random).unwrap_err();
    assert_eq!(error.to_string(), "there is no action `send redy`");
}

#[test]
fn mistakes_in_a_grammar_are_named() {
    for (from, to, expected) in [
        ("length = [2, 7]", "length = [7, 2]", "the fewest first"),
        (
            "most = 2",
            "most = 2\nreceive_signal = \"x\"",
            "`action 2`: give exactly one",
        ),
        (
            "weight = 2",
            "weight = -2",
            "weight must be a number from 0",
        ),
        ("[true, false]", "[]", "no value to take"),
        ("uniform = [0.5", "uniform = [-0.5", "a delay starts at 0"),
        (
            "\"set hand=far\"",
            "\"set hand=further\"",
            "no action `set hand=\"further\"`",
        ),
        ("\"send ready\"\nneeds", "\"say ready\"\nneeds", "; write"),
        ("begins =", "begin =", "unknown field `begin`"),
    ] {
        assert!(GRAMMAR.contains(from), "{from}");
        let error = Grammar::from_toml(&GRAMMAR.replacen(from, to, 1)).unwrap_err();
        assert!(error.to_string().contains(expected), "{to}: {error}");
    }
}

#[test]
fn data_is_written_as_it_is_read() {
    let text = toml::to_string(&grammar()).unwrap();
    assert_eq!(Grammar::from_toml(&text).unwrap(), grammar());
    let text = toml::to_string(&agent(AGENT)).unwrap();
    assert_eq!(Agent::from_toml(&text).unwrap(), agent(AGENT));
}

const AGENT: &str = r#"
name = "person"
longest = 50
beliefs = { at = "a" }
[[plan]]
name = "stay"
when = { at = "a" }
weight = 3
actions = [{ send_signal = "stay" }]
[[plan]]
name = "go"
when = { at = "a" }
weight = 1
actions = [{ send_signal = "go" }, { receive_signal = "gone" }]
believe = { at = "b" }
[[plan]]
name = "end"
when = { at = "b" }
ends = true
"#;

fn agent(text: &str) -> Agent {
    Agent::from_toml(text).unwrap()
}

#[test]
fn agents_do_things_as_often_as_their_weights_say() {
    let agent = agent(AGENT);
    let mut random = Random::new(1, "agent");
    let count = 4000;
    let mut stays = 0;
    for _ in 0..count {
        let test = agent.generate(&mut random).unwrap();
        assert!(test.to_string().ends_with("send go; receive gone") || test.actions.len() == 50);
        stays += test
            .actions
            .iter()
            .filter(|a| **a == Action::send("stay"))
            .count();
    }
    // Geometric with success 1/4: mean 3, deviation sqrt(12); five standard errors are 0.27.
    let mean = stays as f64 / f64::from(count);
    assert!((mean - 3.0).abs() < 0.27, "{mean}");
}

#[test]
fn mistakes_in_an_agent_are_named() {
    for (from, to, expected) in [
        ("weight = 3", "weight = -1", "`stay`: its weight"),
        (
            "believe = { at",
            "believe = { on",
            "no belief `on (of plan go)`",
        ),
        (
            "beliefs = { at = \"a\" }",
            "beliefs = { at = \"c\" }",
            "no plan applies",
        ),
        ("longest = 50", "longest = 0", "`longest` is 0"),
    ] {
        assert!(AGENT.contains(from), "{from}");
        let error = Agent::from_toml(&AGENT.replacen(from, to, 1)).unwrap_err();
        assert!(error.to_string().contains(expected), "{to}: {error}");
    }
    let idle = "name = \"x\"\nlongest = 1\n[[plan]]\nname = \"nothing\"";
    let error = agent(idle)
        .generate(&mut Random::new(1, "agent"))
        .unwrap_err();
    assert!(error.to_string().contains("that do nothing"));
}

#[test]
fn paths_become_tests() {
    let mapping = PathMapping::from_toml(
        r#"
        [[step]]
        changes = { gaze = 1 }
        set_param = { gaze = true }
        [[step]]
        changes = { hand = 2 }
        set_param = { hand = "near" }
        [[step]]
        module = "human"
        action = "ready"
        send_signal = "ready"
        after_secs = 2
        "#,
    )
    .unwrap();
    let changes = |pairs: &[(&str, f64)]| {
        pairs
            .iter()
            .map(|(name, value)| ((*name).to_owned(), (*value).into()))
            .collect()
    };
    let steps = [
        PathStep {
            changes: changes(&[("gaze", 1.0), ("hand", 2.0)]),
            ..PathStep::default()
        },
        PathStep {
            changes: changes(&[("gaze", 0.0)]),
            ..PathStep::default()
        },
        PathStep {
            modules: vec!["robot".into(), "human".into()],
            action: Some("ready".into()),
            ..PathStep::default()
        },
        PathStep {
            action: Some("ready".into()),
            ..PathStep::default()
        },
    ];
    let made = mapping.test("t", &steps);
    assert_eq!(
        made.test.to_string(),
        "set gaze=true hand=\"near\"; send ready"
    );
    assert_eq!(made.unmapped, [1, 3]);
    for (text, expected) in [
        ("[[step]]\nsend_signal = \"a\"", "say which steps"),
        ("[[step]]\nmodule = \"a\"", "exactly one"),
        ("[[step]]\nmodule = \"a\"\nset_param = {}", "no parameter"),
        ("[[step]]\nmodul = \"a\"", "unknown field `modul`"),
    ] {
        let error = PathMapping::from_toml(text).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
}

#[test]
fn a_cover_reaches_what_all_tests_reach() {
    let cover = smallest_cover(&[1, 2, 3, 4], &[vec![1], vec![1, 2], vec![2, 3], vec![9]]);
    assert_eq!(cover.chosen, [(1, vec![1, 2]), (2, vec![3])]);
    assert_eq!(cover.unreached, [4]);
    assert!(smallest_cover::<u8>(&[], &[vec![1]]).chosen.is_empty());
}
