//! What is read, what is printed, and what is said about mistakes.

use crate::support;

use requirement_lang::compile::NotExpressible;
use requirement_lang::compile::goal::model_goal;
use requirement_lang::compile::monitor::monitor;
use requirement_lang::compile::property::{Model, label_of_name, property};
use requirement_lang::sentence::{Amount, ScopeKind, Sentence, Timing};
use requirement_lang::{Context, explain, parse};
use trace::Parameters;

fn read(text: &str) -> Sentence {
    let parsed = parse(text, &Context::default());
    assert!(!parsed.has_errors(), "{text}: {:?}", parsed.diagnostics);
    parsed.tree
}

#[test]
fn sentences_are_read_and_printed_canonically() {
    let cases = [
        (
            "In lifting mode, upon near & !seen the robot arm shall, within 500ms, satisfy slow.",
            "While lifting, when near and not seen, the robot arm shall within 500 ms satisfy slow",
        ),
        (
            "The robot shall always satisfy a => b => c",
            "The robot shall always satisfy a => b => c",
        ),
        (
            "Only after mode arming shall the robot eventually satisfy fired",
            "Only after arming, the robot shall eventually satisfy fired",
        ),
        (
            "When not in start mode the system shall never satisfy (a or b) and c",
            "When not in start, the system shall never satisfy (a or b) and c",
        ),
        (
            "While (m | n) and whenever the person is near the robot shall immediately stop moving",
            "While m or n, whenever person_is_near, the robot shall immediately satisfy stop_moving",
        ),
        (
            "If a is false, the robot's hand shall in at least 99.5 % of all runs at the next step satisfy b is true",
            "When not a, the robot's hand shall with probability at least 0.995 at the next step satisfy b",
        ),
        (
            "Robot shall satisfy /robot.hand_speed <= 250 mm/s until (/a.x - /b.x)*2 > 3 cm",
            "The Robot shall until (/a.x - /b.x)*2 > 3 cm satisfy /robot.hand_speed <= 250 mm/s",
        ),
        (
            "Unless off, the robot shall before q satisfy r, then for 3 ticks s, then eventually satisfy norm(/a.x, /a.y) < 1 m",
            "Unless off, the robot shall before q satisfy r, then for 3 ticks satisfy s, then eventually satisfy \
             norm(/a.x, /a.y) < 1 m",
        ),
        (
            "The robot shall not collide",
            "The robot shall never satisfy collide",
        ),
        (
            "The robot shall always not satisfy a or b",
            "The robot shall always satisfy not (a or b)",
        ),
        (
            "When /robot.state != 'let go, then', the robot shall repeatedly until done satisfy held",
            "When /robot.state != 'let go, then', the robot shall until done satisfy held",
        ),
        (
            "In at least 60 % of attempts, when activated, the robot shall eventually satisfy handed_over",
            "When activated, the robot shall with probability at least 0.6 eventually satisfy handed_over",
        ),
        (
            "Before /robot.hand_speed > 0 m/s, the robot shall with probability > 0.5 always satisfy !(a <=> b xor c)",
            "Before /robot.hand_speed > 0 m/s, the robot shall with probability more than 0.5 always satisfy \
             (a <=> b) <=> c",
        ),
    ];
    for (text, canonical) in cases {
        let sentence = read(text);
        assert_eq!(sentence.to_string(), canonical, "{text}");
        assert_eq!(read(canonical).to_string(), canonical);
        assert_eq!(
            monitor(&read(canonical)).unwrap().to_string(),
            monitor(&sentence).unwrap().to_string()
        );
    }
}

#[test]
fn every_combination_prints_as_text_that_reads_back() {
    let mut sentences = support::single_stage_sentences();
    let stages = vec![
        (Timing::Until(support::name(3)), support::name(2)),
        (Timing::Immediately, support::name(4)),
    ];
    sentences.push(support::sentence(
        ScopeKind::In,
        support::CONDITIONS[1],
        stages,
    ));
    for sentence in sentences {
        let text = sentence.to_string();
        let again = read(&text);
        assert_eq!(again.to_string(), text);
        assert_eq!(
            (again.scope.kind, again.stages.len()),
            (sentence.scope.kind, sentence.stages.len()),
            "{text}"
        );
        assert_eq!(
            monitor(&again).unwrap(),
            respanned(&sentence, &again),
            "{text}"
        );
    }
}

/// The monitor of `sentence` with the places of the atoms of `like`.
fn respanned(sentence: &Sentence, like: &Sentence) -> requirement_lang::compile::monitor::Monitor {
    let mut form = monitor(sentence).unwrap();
    form.requirement.atoms = monitor(like).unwrap().requirement.atoms;
    form
}

/// The code, the text at the place, and the remedy of the first diagnostic.
fn first_mistake<'t>(text: &'t str, context: &Context<'_>) -> (&'static str, &'t str, String) {
    let parsed = parse(text, context);
    let first = parsed
        .diagnostics
        .first()
        .unwrap_or_else(|| panic!("no mistake in: {text}"));
    (
        first.code,
        first.span.of(text),
        first.remedy.clone().unwrap_or_default(),
    )
}

#[test]
fn mistakes_have_places_and_remedies() {
    let parameters = Parameters::new([("release_time", "2 s"), ("near", "10 cm")]).unwrap();
    let context = Context {
        parameters: Some(&parameters),
        vocabulary: Some(&["grasped", "hand_open"]),
    };
    let cases = [
        (
            "When grasped the robot should always satisfy hand_open",
            "no-shall",
            "should",
            "Did you mean `shall`",
        ),
        (
            "the robot shall within release_tim satisfy hand_open",
            "unknown-parameter",
            "release_tim",
            "`release_time`?",
        ),
        (
            "the robot shall within near satisfy hand_open",
            "duration",
            "near",
            "Where it is declared",
        ),
        (
            "the robot shall within 2 satisfy hand_open",
            "duration",
            "2",
            "unit of time",
        ),
        (
            "the robot shall within 2 m satisfy hand_open",
            "duration",
            "2 m",
            "unit of time",
        ),
        (
            "the robot shall within -1 s satisfy hand_open",
            "duration",
            "-1 s",
            "unit of time",
        ),
        (
            "the robot shall within satisfy hand_open",
            "duration",
            "",
            "unit of time",
        ),
        (
            "the robot shall always satisfy hand_opn",
            "unknown-name",
            "hand_opn",
            "Did you mean `hand_open`?",
        ),
        (
            "the robot shall always satisfy grasped and",
            "missing-proposition",
            "",
            "vocabulary",
        ),
        (
            "the robot shall always satisfy grasped and or hand_open",
            "missing-proposition",
            "or",
            "vocabulary",
        ),
        (
            "the robot shall always satisfy (grasped",
            "parentheses",
            "(",
            "Add the missing one",
        ),
        (
            "when grasped, shall always satisfy hand_open",
            "no-component",
            "",
            "the COMPONENT",
        ),
        (
            "the robot shall satisfy hand_open",
            "no-timing",
            "satisfy hand_open",
            "immediately",
        ),
        (
            "the robot shall eventualy satisfy hand_open",
            "timing",
            "eventualy",
            "Did you mean `eventually`?",
        ),
        (
            "the robot shall finally satisfy hand_open",
            "last-point",
            "finally",
            "where the scope ends",
        ),
        (
            "the robot shall not grasped and hand_open",
            "ambiguous-not",
            "not grasped and hand_open",
            "never satisfy",
        ),
        (
            "the robot shall not hand_open within 2 s",
            "ambiguous-not",
            "within 2 s",
            "timing first",
        ),
        (
            "the robot shall always satisfy grasped within 2 s",
            "second-timing",
            "within 2 s",
            "then",
        ),
        (
            "the robot shall always satisfy grasped, then eventually satisfy hand_open",
            "endless-stage",
            "always satisfy grasped",
            "until",
        ),
        (
            "only in grasped the robot shall eventually satisfy hand_open, then immediately satisfy grasped",
            "only-stages",
            "immediately satisfy grasped",
            "one requirement",
        ),
        (
            "the robot shall with probability 0.9 always satisfy grasped",
            "probability",
            "with probability",
            "at least",
        ),
        (
            "the robot shall with probability at least 1.5 always satisfy grasped",
            "probability",
            "with probability at least 1.5",
            "from 0 to 1",
        ),
        (
            "when grasped, if hand_open, the robot shall always satisfy grasped",
            "second-condition",
            "if",
            "one keyword",
        ),
        (
            "when grasped for 2 s, the robot shall always satisfy hand_open",
            "phrase",
            "grasped for 2 s",
            "plain words",
        ),
        (
            "in at least 9 % of runs, the robot shall with probability > 0.5 always satisfy hand_open",
            "second-probability",
            "with probability > 0.5",
            "Keep one",
        ),
        (
            "the robot shall always satisfy grasped. or hand_open",
            "phrase",
            "grasped.",
            "plain words",
        ),
        (
            "the robot shall . before hand_open",
            "phrase",
            ".",
            "plain words",
        ),
        (
            "the robot shall always satisfy grasped when hand_open",
            "misplaced",
            "grasped when hand_open",
            "before the component",
        ),
        (
            "when grasped the robot in mode lifting shall always satisfy hand_open",
            "component",
            "in",
            "before `the COMPONENT`",
        ),
        (
            "while grasped while hand_open, the robot shall always satisfy hand_open",
            "misplaced",
            "grasped while hand_open",
            "before the component",
        ),
        (
            "whenever grasped, the robot shall after 2 s satisfy hand_open",
            "continual-after",
            "2 s",
            "Use `when`",
        ),
        (
            "when grasped, the robot shall after 2 s satisfy hand_open",
            "exact-instant",
            "2 s",
            "Write `within`",
        ),
        (
            "sometimes grasped, the robot shall always satisfy grasped",
            "unexpected",
            "sometimes grasped",
            "Begin a scope",
        ),
    ];
    for (text, code, place, remedy) in cases {
        let (found_code, found_place, found_remedy) = first_mistake(text, &context);
        assert_eq!((found_code, found_place), (code, place), "{text}");
        assert!(found_remedy.contains(remedy), "{text}: {found_remedy}");
    }
}

#[test]
fn all_mistakes_of_a_sentence_are_reported_in_order() {
    let context = Context {
        parameters: None,
        vocabulary: Some(&["a"]),
    };
    let parsed = parse("When b, the robot shall within 2 kg satisfy c", &context);
    let codes: Vec<&str> = parsed
        .diagnostics
        .iter()
        .map(|diagnostic| diagnostic.code)
        .collect();
    assert_eq!(codes, ["unknown-name", "duration", "unknown-name"]);
    assert_eq!(monitor(&parsed.tree), Err(NotExpressible::Incomplete));
}

#[test]
fn durations_are_in_seconds_or_steps_and_parameters_have_their_value() {
    let parameters = Parameters::new([("release_time", "250 ms")]).unwrap();
    let context = Context {
        parameters: Some(&parameters),
        vocabulary: None,
    };
    let amount = |text: &str| {
        let sentence = parse(text, &context).into_result().unwrap();
        sentence.stages[0].timing.duration().unwrap().amount
    };
    assert_eq!(
        amount("the robot shall within 1.5 min satisfy a"),
        Amount::Secs(90.0)
    );
    assert_eq!(
        amount("the robot shall for 7 steps satisfy a"),
        Amount::Steps(7)
    );
    assert_eq!(
        amount("the robot shall after release_time satisfy a"),
        Amount::Secs(0.25)
    );
    assert_eq!(
        amount("the robot shall satisfy a within release_time"),
        Amount::Secs(0.25)
    );
}

#[test]
fn a_time_needs_a_step_that_divides_it() {
    let sentence = read("Whenever c, the robot shall within 0.3 s satisfy r");
    let path = |step_secs| {
        let model = Model {
            step_secs,
            proposition: &label_of_name,
        };
        property(&sentence, &model).map(|property| property.path)
    };
    assert_eq!(path(Some(0.1)).unwrap(), "G (\"c\" => (F<=3 \"r\"))");
    assert!(matches!(
        path(None),
        Err(NotExpressible::NoStepDuration { .. })
    ));
    assert!(matches!(
        path(Some(0.2)),
        Err(NotExpressible::NotWholeSteps { .. })
    ));
    for step_secs in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(
            path(Some(step_secs)),
            Err(NotExpressible::BadStepDuration { .. })
        ));
    }
    let comparison = read("The robot shall always satisfy /hand.speed < 1 m/s");
    let model = Model {
        step_secs: None,
        proposition: &label_of_name,
    };
    let refused = property(&comparison, &model).unwrap_err();
    assert_eq!(
        refused,
        NotExpressible::Proposition {
            text: "/hand.speed < 1 m/s".to_owned()
        }
    );
}

#[test]
fn test_goals_ask_for_a_witness_and_for_a_counterexample() {
    let sentence = read("In m, when c, the robot shall within 2 steps satisfy r");
    let model = Model {
        step_secs: None,
        proposition: &label_of_name,
    };
    let goal = model_goal(&sentence, &model).unwrap();
    assert_eq!(goal.trigger_probability, "P=? [ F (\"m\" & \"c\") ]");
    assert_eq!(goal.witness, "P>0 [ F (\"m\" & \"c\") ]");
    let path = property(&sentence, &model).unwrap().path;
    assert_eq!(goal.falsify, format!("P=? [ !({path}) ]"));
}

#[test]
fn the_diagram_shows_scope_trigger_and_response() {
    let explanation = explain(&read(
        "While lifting, when near, the robot shall within 2 s satisfy slow",
    ));
    let expected = "\
scope           [----------------------------------)       lifting
trigger               T                                    near becomes true
response              ????????????                         slow, at some time (?), up to 2 s";
    let trimmed: Vec<&str> = explanation.diagram.lines().map(str::trim_end).collect();
    assert_eq!(trimmed, expected.lines().collect::<Vec<_>>());
}

#[test]
fn every_combination_is_explained_in_words_of_its_own() {
    let mut seen = std::collections::BTreeSet::new();
    for sentence in support::single_stage_sentences() {
        let explanation = explain(&sentence);
        assert!(
            explanation.diagram.lines().count() == 3,
            "{}",
            explanation.diagram
        );
        assert!(seen.insert(explanation.words.join(" ")), "{sentence}");
    }
}
