//! Monitors against a second reading of their definition, on every short word.
//!
//! The machine under test goes through a word once, sample by sample. The reading here looks at
//! the whole word, with quantifiers over sample positions as in the definition.

use temporal::monitor::{
    AtEnd, Monitor, MonitorReport, MonitorSpec, Repeat, Stage, Trigger, Verdict,
};

type Value = Option<bool>;

/// A word: times, and for each sample the value of each proposition.
struct Word<'w> {
    times_secs: &'w [f64],
    values: &'w [Vec<Value>],
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Outcome {
    Pass,
    /// At a sample and stage.
    Fail(usize, usize),
    Unclear,
    Pending,
}

/// What becomes of the instance whose stage `stage` is entered at sample `entered`, and the
/// sample at which that is known.
fn outcome(
    spec: &MonitorSpec,
    word: &Word<'_>,
    stage: usize,
    entered: usize,
    doubtful: bool,
) -> (Outcome, usize) {
    let Some(kind) = spec.then.get(stage) else {
        return (
            if doubtful {
                Outcome::Unclear
            } else {
                Outcome::Pass
            },
            entered,
        );
    };
    let names = spec.propositions();
    let value = |name: &str, sample: usize| {
        word.values[sample][names.iter().position(|other| *other == name).unwrap()]
    };
    let length = word.times_secs.len();
    let deadline = |within: &Option<f64>| {
        within.map_or(f64::INFINITY, |within| word.times_secs[entered] + within)
    };
    match kind {
        Stage::Assert { proposition } => match value(proposition, entered) {
            Some(true) => outcome(spec, word, stage + 1, entered, doubtful),
            Some(false) => (Outcome::Fail(entered, stage), entered),
            None => outcome(spec, word, stage + 1, entered, true),
        },
        Stage::WaitFor {
            proposition,
            within_secs,
        } => {
            let deadline = deadline(within_secs);
            let in_time = |sample: &usize| word.times_secs[*sample] <= deadline;
            let end = (entered..length)
                .filter(in_time)
                .find(|&sample| value(proposition, sample) == Some(true));
            if let Some(end) = end {
                return outcome(spec, word, stage + 1, end, doubtful);
            }
            let seen = (entered..length)
                .filter(in_time)
                .all(|sample| value(proposition, sample).is_some());
            match (entered..length).find(|&sample| is_last_chance(word, sample, deadline)) {
                Some(sample) if seen => (Outcome::Fail(sample, stage), sample),
                Some(sample) => (Outcome::Unclear, sample),
                None if seen => (Outcome::Pending, length),
                // Not even the end of the trace makes it fail.
                None => (Outcome::Unclear, length),
            }
        }
        Stage::Hold {
            proposition,
            until,
            within_secs,
        } => {
            let deadline = deadline(within_secs);
            let in_time = |sample: &usize| word.times_secs[*sample] <= deadline;
            let end = (entered..length)
                .filter(in_time)
                .find(|&sample| value(until, sample) == Some(true));
            let late = (entered..length).find(|&sample| is_last_chance(word, sample, deadline));
            // The samples at which the proposition is asked.
            let asked = (entered..end.unwrap_or(length)).filter(in_time);
            let broken = asked
                .clone()
                .find(|&sample| value(proposition, sample) == Some(false));
            let seen_until = |last: usize| {
                (entered..=last.min(length - 1))
                    .filter(in_time)
                    .all(|sample| value(until, sample).is_some())
            };
            if let Some(sample) = broken {
                return if seen_until(sample) {
                    (Outcome::Fail(sample, stage), sample)
                } else {
                    (Outcome::Unclear, sample)
                };
            }
            let doubtful = doubtful
                || asked
                    .clone()
                    .any(|sample| value(proposition, sample).is_none());
            match (end, late) {
                (Some(end), _) => outcome(spec, word, stage + 1, end, doubtful),
                (None, Some(sample)) if seen_until(length) => {
                    (Outcome::Fail(sample, stage), sample)
                }
                (None, Some(sample)) => (Outcome::Unclear, sample),
                (None, None) if seen_until(length) => (Outcome::Pending, length),
                (None, None) => (Outcome::Unclear, length),
            }
        }
    }
}

/// Whether nothing after `sample` can still be in time.
fn is_last_chance(word: &Word<'_>, sample: usize, deadline: f64) -> bool {
    word.times_secs[sample] >= deadline
}

/// The whole report, by the definition.
fn read(spec: &MonitorSpec, word: &Word<'_>, complete: bool) -> MonitorReport {
    let length = word.times_secs.len();
    let mut report = Monitor::compile(spec).unwrap().start().finish(true);
    let mut free_from = 0;
    for sample in 0..length {
        let when = word.values[sample][0];
        report.when_unknown += u64::from(when.is_none());
        let before = word.values[..sample]
            .iter()
            .rev()
            .find_map(|values| values[0]);
        let triggers = match spec.trigger {
            Trigger::EachSample => when == Some(true),
            Trigger::BecomesTrue => when == Some(true) && before != Some(true),
        };
        if !triggers {
            continue;
        }
        // An instance that ends at this sample makes room at it, but not before it began.
        if sample < free_from {
            report.overlapping += 1;
            continue;
        }
        if spec.repeat == Repeat::Once && report.triggered > 0 {
            continue;
        }
        report.triggered += 1;
        let (result, known_at) = outcome(spec, word, 0, sample, false);
        free_from = known_at;
        match result {
            Outcome::Pass => report.passed += 1,
            Outcome::Fail(..) => report.failed += 1,
            Outcome::Unclear if known_at == length => report.pending += 1,
            Outcome::Unclear => report.inconclusive += 1,
            Outcome::Pending if complete && spec.at_end == AtEnd::FailPending => report.failed += 1,
            Outcome::Pending => report.pending += 1,
        }
    }
    report.verdict = if report.failed > 0 {
        Verdict::Violated
    } else if report.triggered == 0 {
        Verdict::NotCovered
    } else if report.passed == report.triggered && (complete || spec.repeat == Repeat::Once) {
        Verdict::Satisfied
    } else {
        Verdict::Inconclusive
    };
    report
}

fn assert_p(proposition: &str) -> Stage {
    Stage::Assert {
        proposition: proposition.into(),
    }
}

fn wait_for(proposition: &str, within_secs: Option<f64>) -> Stage {
    Stage::WaitFor {
        proposition: proposition.into(),
        within_secs,
    }
}

fn hold(proposition: &str, until: &str, within_secs: Option<f64>) -> Stage {
    Stage::Hold {
        proposition: proposition.into(),
        until: until.into(),
        within_secs,
    }
}

fn specs() -> Vec<MonitorSpec> {
    let thens = [
        vec![assert_p("p")],
        vec![wait_for("p", None)],
        vec![wait_for("p", Some(1.0))],
        vec![wait_for("p", Some(0.0)), assert_p("q")],
        vec![wait_for("p", Some(1.5)), wait_for("q", None)],
        vec![hold("p", "q", None)],
        vec![hold("p", "q", Some(1.0))],
        vec![hold("p", "q", Some(1.5)), assert_p("p")],
        vec![
            hold("p", "q", None),
            assert_p("p"),
            wait_for("p", Some(2.0)),
            assert_p("q"),
        ],
        vec![
            assert_p("p"),
            wait_for("q", Some(1.0)),
            hold("when", "p", None),
        ],
        vec![wait_for("when", None), hold("q", "p", Some(0.5))],
    ];
    let mut specs = Vec::new();
    for then in thens {
        for trigger in [Trigger::BecomesTrue, Trigger::EachSample] {
            for repeat in [Repeat::EveryTrigger, Repeat::Once] {
                for at_end in [AtEnd::InconclusivePending, AtEnd::FailPending] {
                    let then = then.clone();
                    specs.push(MonitorSpec {
                        when: "when".into(),
                        trigger,
                        then,
                        repeat,
                        at_end,
                    });
                }
            }
        }
    }
    specs
}

/// Compares machine and reading on every word over `letters` of up to the given length.
fn compare(letters: &[Value], times_secs: &[f64]) -> u64 {
    let monitors: Vec<(MonitorSpec, Monitor)> = specs()
        .into_iter()
        .map(|spec| {
            let monitor = Monitor::compile(&spec).unwrap();
            (spec, monitor)
        })
        .collect();
    let mut compared = 0;
    for length in 0..=times_secs.len() {
        let cells = 3 * length as u32;
        for number in 0..letters.len().pow(cells) {
            let letter = |cell: u32| letters[number / letters.len().pow(cell) % letters.len()];
            let values: Vec<Vec<Value>> = (0..length as u32)
                .map(|sample| {
                    (0..3)
                        .map(|proposition| letter(3 * sample + proposition))
                        .collect()
                })
                .collect();
            let word = Word {
                times_secs: &times_secs[..length],
                values: &values,
            };
            for (spec, monitor) in &monitors {
                compared += compare_one(spec, monitor, &word, number % 2 == 0);
            }
        }
    }
    compared
}

fn compare_one(spec: &MonitorSpec, monitor: &Monitor, word: &Word<'_>, complete: bool) -> u64 {
    // The proposition `when` comes first; a specification that lacks p or q numbers the others on.
    let names = ["when", "p", "q"];
    let columns: Vec<usize> = monitor
        .propositions()
        .iter()
        .map(|name| names.iter().position(|other| other == name).unwrap())
        .collect();
    let values: Vec<Vec<Value>> = word
        .values
        .iter()
        .map(|row| columns.iter().map(|&column| row[column]).collect())
        .collect();
    let samples = word.times_secs.iter().zip(&values);
    let samples =
        samples.map(|(&time_secs, row)| (time_secs, move |proposition: usize| row[proposition]));
    let found = monitor.judge(samples, complete).unwrap();
    let word = Word {
        times_secs: word.times_secs,
        values: &values,
    };
    let mut expected = read(spec, &word, complete);
    assert_eq!(found.first_failure.is_some(), found.failed > 0);
    assert_eq!(
        found.triggered,
        found.passed + found.failed + found.pending + found.inconclusive
    );
    expected.first_failure.clone_from(&found.first_failure);
    assert_eq!(
        found, expected,
        "{spec:?} on {:?} {values:?}",
        word.times_secs
    );
    1
}

#[test]
fn every_word_of_two_values_up_to_five_samples() {
    let letters = [Some(false), Some(true)];
    // Deadlines of 0.5, 1, 1.5 and 2 s fall on samples, and between them.
    let compared = compare(&letters, &[0.0, 0.5, 1.5, 1.75, 3.0]);
    assert_eq!(compared, 88 * (1 + 8 + 64 + 512 + 4096 + 32768));
}

#[test]
fn every_word_with_unknowns_up_to_three_samples() {
    let letters = [Some(false), Some(true), None];
    for times_secs in [[0.0, 1.0, 2.0], [7.0, 7.5, 8.5]] {
        let compared = compare(&letters, &times_secs);
        assert_eq!(compared, 88 * (1 + 27 + 729 + 19683));
    }
}
