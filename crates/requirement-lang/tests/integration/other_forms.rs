//! Dense time and staged monitors: they mean what the semantics says, too.

use crate::support;

use requirement_lang::compile::NotExpressible;
use requirement_lang::compile::monitor::monitor;
use requirement_lang::compile::staged::staged;
use requirement_lang::sentence::{Amount, ConditionKind, ScopeKind, Sentence, Timing};
use requirement_lang::{Context, parse};
use support::{
    NAMES, bits, holds_finite, letters, name, sentence, single_stage_sentences, triggers, words,
};
use temporal::formula::semantics::dense::{TickWord, value};
use temporal::formula::{Ending, FormulaMonitor, Settings, TimeModel};
use temporal::monitor::{Monitor, MonitorReport, Verdict};

/// The sentence with its steps read as seconds.
fn in_seconds(mut sentence: Sentence) -> Sentence {
    for stage in &mut sentence.stages {
        if let Timing::Within(duration) | Timing::For(duration) | Timing::After(duration) =
            &mut stage.timing
            && let Amount::Steps(steps) = duration.amount
        {
            duration.amount = Amount::Secs(f64::from(steps));
        }
    }
    sentence
}

#[test]
fn monitors_mean_their_sentences_in_dense_time() {
    // Signals that change at whole seconds only, so that nothing can happen between.
    let mut judged = 0;
    for sentence in single_stage_sentences() {
        let sentence = in_seconds(sentence);
        let form = monitor(&sentence).unwrap();
        if form.needs_discrete_time() {
            assert_eq!(sentence.stages[0].timing, Timing::Next, "{sentence}");
            continue;
        }
        let continual = sentence
            .condition
            .as_ref()
            .is_some_and(|c| c.kind == ConditionKind::Whenever);
        if continual && matches!(sentence.stages[0].timing, Timing::After(_)) {
            // A response exactly so long after each instant of an interval is another thing than one
            // so many samples after each sample in it; the parser warns of it.
            continue;
        }
        let atoms = bits(&form.requirement.atoms);
        let alphabet = letters(&sentence);
        let length = if alphabet.len() > 8 { 2 } else { 3 };
        words(&alphabet, length, &mut |word| {
            let row = |letter: &u64| {
                let of = |bit: &usize| {
                    if letter >> bit & 1 == 1 {
                        f64::INFINITY
                    } else {
                        f64::NEG_INFINITY
                    }
                };
                let bound = |bit: &usize| temporal::formula::RobustnessBounds {
                    low: of(bit),
                    high: of(bit),
                };
                atoms.iter().map(bound).collect()
            };
            let trace = TickWord {
                ticks: (0..word.len()).collect(),
                atoms: word.iter().map(row).collect(),
            };
            let found = value(&form.requirement.formula, &trace, Ending::Finite)
                .unwrap()
                .truth();
            assert_eq!(
                found,
                Some(holds_finite(&sentence, word)),
                "{sentence} as {form} on {word:?}"
            );
            judged += 1;
        });
    }
    assert!(judged > 50_000, "{judged} judgements");
}

/// How often a trigger counts, by the engine of one model of time.
fn counted(compiled: &FormulaMonitor, atoms: &[usize], word: &[u64]) -> u64 {
    let mut judge = compiled.start();
    for (second, letter) in word.iter().enumerate() {
        let row: Vec<Option<bool>> = (atoms.iter())
            .map(|bit| Some(letter >> bit & 1 == 1))
            .collect();
        judge.step_truth(second as f64, &row).unwrap();
    }
    judge.finish(true).triggered
}

#[test]
fn triggers_are_counted_alike_in_both_models_of_time() {
    let (mut triggered, mut continual) = (0, 0);
    for sentence in single_stage_sentences().into_iter().map(in_seconds) {
        let form = monitor(&sentence).unwrap();
        if form.needs_discrete_time() {
            continue;
        }
        let engines = [TimeModel::Discrete, TimeModel::Dense].map(|time| {
            let settings = Settings {
                explain_samples: 0,
                ..form.settings(time, Ending::Finite)
            };
            FormulaMonitor::compile(&form.requirement.formula, &settings).unwrap()
        });
        let atoms = bits(&form.requirement.atoms);
        let alphabet = letters(&sentence);
        let length = if alphabet.len() > 8 { 2 } else { 3 };
        words(&alphabet, length, &mut |word| {
            let counts = engines
                .each_ref()
                .map(|engine| counted(engine, &atoms, word));
            assert_eq!(counts[0], counts[1], "{sentence} on {word:?}");
            triggered += counts[0];
            let runs = sentence.condition.as_ref();
            if runs.is_some_and(|c| c.kind == ConditionKind::Whenever) {
                // Not the number of samples, let alone of instants: that of intervals.
                assert!(counts[0] as usize <= word.len().div_ceil(2));
                continual += counts[0];
            }
        });
    }
    assert!(
        triggered > 20_000 && continual > 5_000,
        "{triggered} {continual}"
    );
}

#[test]
fn only_what_speaks_of_steps_needs_discrete_time() {
    let needs = |timing: Timing| {
        let sentence = sentence(
            ScopeKind::In,
            Some(ConditionKind::Upon),
            vec![(timing, name(2))],
        );
        let form = monitor(&sentence).unwrap();
        let dense = form.settings(TimeModel::Dense, Ending::Inconclusive);
        let compiled =
            temporal::formula::FormulaMonitor::compile(&form.requirement.formula, &dense);
        assert_eq!(compiled.is_err(), form.needs_discrete_time(), "{sentence}");
        form.needs_discrete_time()
    };
    assert!(needs(Timing::Next));
    assert!(needs(Timing::Within(
        requirement_lang::sentence::Duration::steps(2)
    )));
    assert!(!needs(Timing::Within(
        requirement_lang::sentence::Duration::secs(2.0)
    )));
    assert!(!needs(Timing::Eventually));
}

/// The report of the staged monitor on a word with a sample each second.
fn staged_report(sentence: &Sentence, word: &[u64]) -> Result<MonitorReport, NotExpressible> {
    let spec = staged(sentence)?;
    let monitor = Monitor::compile(&spec).unwrap();
    let expression = |text: &String| {
        let sentence = format!("the robot shall always satisfy {text}");
        parse(&sentence, &Context::default())
            .into_result()
            .unwrap()
            .stages[0]
            .response
            .clone()
    };
    let propositions: Vec<_> = monitor.propositions().iter().map(expression).collect();
    let mut judge = monitor.start();
    for (second, letter) in word.iter().enumerate() {
        let truth = |text: &str| {
            let bit = NAMES.iter().position(|name| *name == text).unwrap();
            letter >> bit & 1 == 1
        };
        judge
            .step(second as f64, &|proposition| {
                Some(propositions[proposition].eval(&truth))
            })
            .unwrap();
    }
    Ok(judge.finish(true))
}

#[test]
fn staged_monitors_fail_where_the_sentence_is_missed() {
    let (mut expressible, mut refused) = (0, 0);
    for sentence in single_stage_sentences().into_iter().map(in_seconds) {
        let alphabet = letters(&sentence);
        if let Err(reason) = staged(&sentence) {
            assert!(
                matches!(reason, NotExpressible::Staged { .. }),
                "{sentence}"
            );
            refused += 1;
            continue;
        }
        expressible += 1;
        words(&alphabet, 3, &mut |word| {
            let report = staged_report(&sentence, word).unwrap();
            // What is pending at the end is missed in the finite reading, and a weak until is not.
            let pending =
                report.pending > 0 && !matches!(sentence.stages[0].timing, Timing::Until(_));
            let missed = report.failed > 0 || pending;
            assert_eq!(
                missed,
                !holds_finite(&sentence, word),
                "{sentence} on {word:?}: {report:?}"
            );
            let invariant = matches!(sentence.stages[0].timing, Timing::Always | Timing::Never);
            if !invariant {
                let counted = (report.triggered + report.overlapping) as usize;
                assert_eq!(
                    counted,
                    triggers(&sentence, word),
                    "{sentence} on {word:?}: {report:?}"
                );
            }
            assert_eq!(report.verdict == Verdict::Violated, report.failed > 0);
        });
    }
    // Everywhere: 6 timings after each of 3 conditions, 8 without; in two kinds of scope `immediately`
    // with each of 4 conditions, and 2 invariants.
    assert_eq!((expressible, refused), (3 * 6 + 8 + 2 * (4 + 2), 512 - 38));
}

#[test]
fn staged_monitors_of_several_stages_fail_where_the_sentence_is_missed() {
    let until = Timing::Until(name(3));
    let within = Timing::Within(requirement_lang::sentence::Duration::secs(1.0));
    let timings = [Timing::Immediately, Timing::Eventually, until, within];
    let mut compared = 0;
    for first in &timings {
        for second in &timings {
            let stages = vec![(first.clone(), name(2)), (second.clone(), name(4))];
            let sentence = sentence(ScopeKind::Global, Some(ConditionKind::Upon), stages);
            let alphabet = letters(&sentence);
            words(&alphabet, 3, &mut |word| {
                let report = staged_report(&sentence, word).unwrap();
                if report.overlapping == 0 && report.pending == 0 {
                    let missed = report.failed > 0;
                    assert_eq!(
                        missed,
                        !holds_finite(&sentence, word),
                        "{sentence} on {word:?}: {report:?}"
                    );
                    compared += 1;
                }
            });
        }
    }
    assert!(compared > 20_000, "{compared} compared");
}

#[test]
fn the_text_of_a_monitor_is_read_back_as_its_formula() {
    let mut sentences = single_stage_sentences();
    for text in [
        "While not /robot.speed < 3 mm/s, when (/a.x - /b.x)*2 > 3 cm, the robot shall within 2 s satisfy \
         norm(/a.x, /a.y) < near and not /robot.state = 'let go'",
        "Whenever a <=> b, the robot shall for 0.25 s satisfy c or not (d => e)",
    ] {
        sentences.push(parse(text, &Context::default()).into_result().unwrap());
    }
    for sentence in sentences {
        let form = monitor(&sentence).unwrap();
        let text = form.to_string();
        let read = temporal::formula::parse(&text, &|_| None)
            .unwrap_or_else(|error| panic!("{text}: {error}"));
        // Atoms are numbered in another order, so the formulas are compared as text with their atoms.
        assert_eq!(read.to_string(), text);
        let count = |atoms: &[temporal::formula::AtomText]| atoms.len();
        assert!(
            count(&read.atoms) <= count(&form.requirement.atoms),
            "{text}"
        );
    }
}
