//! Traces that end before the windows of a formula: a verdict that is given is that of every continuation, as far as
//! bounded windows see it.

use crate::formulas as common_formulas;

use common_formulas::Numbers;
use temporal::formula::{
    AtomId, Ending, Formula, FormulaMonitor, FormulaReport, Horizon, Interval, Settings, TimeModel,
    Verdict, parse,
};

/// Times in seconds with the truth of atoms.
type Samples = Vec<(f64, Vec<Option<bool>>)>;

fn judged(formula: &Formula, samples: &Samples, settings: Settings) -> FormulaReport {
    let mut judge = FormulaMonitor::compile(formula, &settings).unwrap().start();
    let count = formula.atom_count();
    for (time_secs, atoms) in samples {
        judge.step_truth(*time_secs, &atoms[..count]).unwrap();
    }
    judge.finish(true)
}

fn settings(time: TimeModel, ending: Ending) -> Settings {
    match time {
        TimeModel::Discrete => Settings::discrete(ending),
        TimeModel::Dense => Settings::dense(ending),
    }
}

/// The formula whose windows without an end see only what lies inside the trace, where `inside` is true.
fn relative(formula: &Formula, inside: &Formula) -> Formula {
    let part = |it: &Formula| Box::new(relative(it, inside));
    let seen = |it: &Formula| Box::new(Formula::and(inside.clone(), relative(it, inside)));
    let unseen = |it: &Formula| Box::new(Formula::implies(inside.clone(), relative(it, inside)));
    match formula {
        Formula::True | Formula::False | Formula::Atom(_) => formula.clone(),
        Formula::Not(f) => Formula::Not(part(f)),
        Formula::And(all) => Formula::And(all.iter().map(|it| relative(it, inside)).collect()),
        Formula::Or(all) => Formula::Or(all.iter().map(|it| relative(it, inside)).collect()),
        Formula::Implies(f, g) => Formula::Implies(part(f), part(g)),
        Formula::Iff(f, g) => Formula::Iff(part(f), part(g)),
        Formula::Next(f) => Formula::Next(part(f)),
        Formula::Previous(f) => Formula::Previous(part(f)),
        Formula::Rise(f) => Formula::Rise(part(f)),
        Formula::Fall(f) => Formula::Fall(part(f)),
        Formula::Once(i, f) => Formula::Once(*i, part(f)),
        Formula::Historically(i, f) => Formula::Historically(*i, part(f)),
        Formula::Since(i, f, g) => Formula::Since(*i, part(f), part(g)),
        Formula::Eventually(i, f) if i.high.is_none() => Formula::Eventually(*i, seen(f)),
        Formula::Always(i, f) if i.high.is_none() => Formula::Always(*i, unseen(f)),
        Formula::Until(i, f, g) if i.high.is_none() => Formula::Until(*i, part(f), seen(g)),
        Formula::Release(i, f, g) if i.high.is_none() => Formula::Release(*i, part(f), unseen(g)),
        Formula::Eventually(i, f) => Formula::Eventually(*i, part(f)),
        Formula::Always(i, f) => Formula::Always(*i, part(f)),
        Formula::Until(i, f, g) => Formula::Until(*i, part(f), part(g)),
        Formula::Release(i, f, g) => Formula::Release(*i, part(f), part(g)),
        Formula::WeakUntil(i, f, g) => {
            let either = Formula::or(f.as_ref().clone(), g.as_ref().clone());
            relative(&Formula::Release(*i, g.clone(), Box::new(either)), inside)
        }
    }
}

/// Samples of two atoms and of `inside` behind them.
fn drawn(numbers: &mut Numbers, times_secs: &[f64], inside: bool) -> Samples {
    let sample = |time_secs: &f64| {
        let atoms = [numbers.below(2) == 1, numbers.below(3) > 0, inside];
        (*time_secs, atoms.map(Some).to_vec())
    };
    times_secs.iter().map(sample).collect()
}

/// How many of the verdicts of a model of time were open only because the trace ended early, and how many stood.
fn counted(time: TimeModel, windows: &[Interval], step: usize) -> (usize, usize) {
    let inside = Formula::Atom(AtomId(2));
    let mut numbers = Numbers(3);
    let (one, two) = common_formulas::small(windows, time == TimeModel::Discrete);
    let (mut open, mut stood) = (0, 0);
    for formula in one.iter().chain(two.iter().step_by(step)) {
        let horizon = Horizon::of(formula, time).unwrap();
        let samples = drawn(&mut numbers, &[0.0, 0.5, 1.0], true);
        let said = judged(formula, &samples, settings(time, Ending::LongEnough));
        let before = judged(formula, &samples, settings(time, Ending::Finite));
        if said.verdict == Verdict::Inconclusive {
            assert_ne!(before.verdict, Verdict::Inconclusive, "{formula}");
            assert_eq!(said.ends_before, Some(horizon), "{formula}");
            open += 1;
            continue;
        }
        if said.left_out.is_some() {
            let verdicts = (said.verdict, before.verdict);
            assert_eq!(
                verdicts,
                (Verdict::Satisfied, Verdict::Violated),
                "{formula}"
            );
            continue;
        }
        assert_eq!((said.verdict, said.ends_before), (before.verdict, None));
        // Three samples of a second are short of what reaches further.
        let is_short = horizon.secs > 1.0 || horizon.samples > 2;
        if said.verdict == Verdict::NotCovered || !is_short {
            continue;
        }
        stood += 1;
        for _ in 0..12 {
            let behind_secs = [1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 7.0];
            let first = numbers.below(2) as usize;
            let behind = drawn(&mut numbers, &behind_secs[first..], false);
            let continued = [&samples[..], &behind].concat();
            let meant = judged(
                &relative(formula, &inside),
                &continued,
                settings(time, Ending::Finite),
            );
            assert_eq!(said.verdict, meant.verdict, "{formula} on {continued:?}");
        }
    }
    (open, stood)
}

#[test]
fn a_verdict_on_a_short_trace_is_that_of_every_continuation() {
    let windows = [
        Interval::UNBOUNDED,
        Interval::secs(0.0, 2.0),
        Interval::secs(0.5, 1.0),
    ];
    let by_samples = [
        Interval::UNBOUNDED,
        Interval::samples(0, 4),
        Interval::samples(1, 3),
    ];
    for (time, windows) in [
        (TimeModel::Discrete, &windows[..]),
        (TimeModel::Discrete, &by_samples[..]),
        (TimeModel::Dense, &windows[..]),
    ] {
        let (open, stood) = counted(time, windows, 1);
        assert!(open > 50 && stood > 500, "{open} open, {stood} stood");
    }
}

/// What the engines say with three values of formulas whose windows are all bounded.
#[test]
fn of_bounded_windows_it_is_what_no_continuation_can_change() {
    let windows = [Interval::secs(0.0, 2.0), Interval::secs(0.5, 3.0)];
    let mut numbers = Numbers(11);
    let (mut same, mut open) = (0, 0);
    for inner in common_formulas::of_two(&Formula::atom(0), &Formula::atom(1), &windows) {
        for formula in common_formulas::of_one(&inner, &windows, false) {
            let samples = drawn(&mut numbers, &[0.0, 0.5, 1.0, 1.5], true);
            let said = judged(&formula, &samples, Settings::discrete(Ending::LongEnough)).verdict;
            let three = judged(&formula, &samples, Settings::discrete(Ending::Inconclusive));
            if three.verdict == said {
                same += 1;
            } else {
                open += 1;
                assert_eq!(said, Verdict::Inconclusive, "{formula} on {samples:?}");
            }
        }
    }
    assert!(
        same > 20 * open,
        "{same} the same, {open} open without need"
    );
}

#[test]
fn the_horizon_is_the_longest_way_through_bounded_windows() {
    let horizon = |text: &str| {
        let formula = parse(text, &|_| None).unwrap().formula;
        let found = Horizon::of(&formula, TimeModel::Discrete).unwrap();
        (found.secs, found.samples)
    };
    assert_eq!(horizon("always a"), (0.0, 0));
    assert_eq!(
        horizon("always[0, 10 s] (a => eventually[0, 4 s] b)"),
        (14.0, 0)
    );
    assert_eq!(
        horizon("always (a => eventually[0, 4 s] once[0, 9 s] b)"),
        (4.0, 0)
    );
    assert_eq!(horizon("next next eventually[0, 3] a"), (0.0, 5));
}

/// Ten seconds of samples each 10 ms have the last at 9.99 s, and a task that was done early is done.
#[test]
fn only_what_the_end_alone_decides_is_open() {
    let of = |text: &str, samples: Vec<(f64, bool)>| {
        let formula = parse(text, &|_| None).unwrap().formula;
        let samples = samples.into_iter().map(|(secs, it)| (secs, vec![Some(it)]));
        judged(
            &formula,
            &samples.collect(),
            Settings::discrete(Ending::LongEnough),
        )
        .verdict
    };
    let held = |count: u32| (0..count).map(|at| (f64::from(at) * 0.01, true)).collect();
    let always = "always[0, 10 s] a";
    assert_eq!(of(always, held(1000)), Verdict::Satisfied);
    assert_eq!(of(always, held(500)), Verdict::Inconclusive);
    assert_eq!(of("always a", held(500)), Verdict::Satisfied);
    assert_eq!(
        of(always, vec![(0.0, true), (1.0, false)]),
        Verdict::Violated
    );
    let within = "eventually[0, 10 s] !a";
    assert_eq!(
        of(within, vec![(0.0, true), (1.0, false)]),
        Verdict::Satisfied
    );
    assert_eq!(of(within, held(500)), Verdict::Inconclusive);
    assert_eq!(of(within, held(1001)), Verdict::Violated);
}

fn has_past(formula: &Formula) -> bool {
    use Formula::{Fall, Historically, Once, Previous, Rise, Since};
    matches!(
        formula,
        Previous(_) | Rise(_) | Fall(_) | Once(..) | Historically(..) | Since(..)
    ) || formula.operands().into_iter().any(has_past)
}

/// What `always f` or `always (a => f)` is on samples, by what the engine says of `f` at each of them if more may come:
/// the verdict, and whether windows are left out.
fn by_each_sample(body: &Formula, is_triggered: bool, samples: &Samples) -> (Verdict, bool) {
    let horizon = Horizon::of(body, TimeModel::Discrete).unwrap();
    let end_secs = samples.last().unwrap().0;
    let asked: Vec<usize> = (0..samples.len())
        .filter(|at| !is_triggered || samples[*at].1[0] == Some(true))
        .collect();
    let Some(first) = asked.first() else {
        return (Verdict::NotCovered, false);
    };
    let of = |at: &usize| {
        let rest = samples[*at..].to_vec();
        judged(body, &rest, Settings::discrete(Ending::Inconclusive)).verdict
    };
    let found: Vec<Verdict> = asked.iter().map(of).collect();
    if found.contains(&Verdict::Violated) {
        return (Verdict::Violated, false);
    }
    let pending = found.contains(&Verdict::Inconclusive);
    let was_whole = end_secs - samples[*first].0 >= 0.99 * horizon.secs;
    match pending && !was_whole {
        true => (Verdict::Inconclusive, false),
        false => (Verdict::Satisfied, pending),
    }
}

/// The same with so many samples at once, as numbers.
fn in_parts(formula: &Formula, samples: &Samples, at_once: usize) -> FormulaReport {
    let settings = Settings::discrete(Ending::LongEnough);
    let mut judge = FormulaMonitor::compile(formula, &settings).unwrap().start();
    for part in samples.chunks(at_once) {
        let times_secs: Vec<f64> = part.iter().map(|(secs, _)| *secs).collect();
        let column = |atom: usize| {
            let number = |(_, atoms): &(f64, Vec<Option<bool>>)| match atoms[atom] {
                Some(true) => f64::INFINITY,
                _ => f64::NEG_INFINITY,
            };
            part.iter().map(number).collect::<Vec<f64>>()
        };
        let columns: Vec<Vec<f64>> = (0..formula.atom_count()).map(column).collect();
        let columns: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
        judge.step_many(&times_secs, &columns).unwrap();
    }
    judge.finish(true)
}

#[test]
fn what_is_pending_at_the_end_violates_nothing_and_is_left_out_beside_what_was_seen_whole() {
    let windows = [Interval::secs(0.0, 1.0), Interval::secs(0.5, 2.0)];
    let bodies = common_formulas::of_one(&Formula::atom(1), &windows, false)
        .into_iter()
        .chain(common_formulas::of_two(
            &Formula::atom(1),
            &Formula::atom(2),
            &windows,
        ))
        .filter(|body| !has_past(body));
    let mut numbers = Numbers(29);
    let times_secs: Vec<f64> = (0..9).map(|at| f64::from(at) * 0.5).collect();
    let mut counts = std::collections::BTreeMap::new();
    for body in bodies {
        for (is_triggered, _) in [true, false]
            .iter()
            .flat_map(|it| (0..100).map(move |at| (*it, at)))
        {
            let samples: Samples = (times_secs.iter())
                .map(|secs| {
                    (
                        *secs,
                        [5, 2, 2].map(|of| Some(numbers.below(of) == 0)).to_vec(),
                    )
                })
                .collect();
            let formula = match is_triggered {
                true => Formula::always(
                    Interval::UNBOUNDED,
                    Formula::implies(Formula::atom(0), body.clone()),
                ),
                false => Formula::always(Interval::UNBOUNDED, body.clone()),
            };
            let said = judged(&formula, &samples, Settings::discrete(Ending::LongEnough));
            let finite = judged(&formula, &samples, Settings::discrete(Ending::Finite));
            let (meant, pending) = by_each_sample(&body, is_triggered, &samples);
            assert_eq!(said.verdict, meant, "{formula} on {samples:?}");
            for at_once in [1, 4, samples.len()] {
                assert_eq!(
                    in_parts(&formula, &samples, at_once),
                    said,
                    "{formula} on {samples:?}"
                );
            }
            let is_turned = finite.verdict == Verdict::Violated && meant == Verdict::Satisfied;
            assert_eq!(
                said.left_out.is_some(),
                is_turned,
                "{formula} on {samples:?}"
            );
            assert!(pending || !is_turned, "{formula} on {samples:?}");
            *counts.entry(format!("{meant:?} {is_turned}")).or_insert(0) += 1;
        }
    }
    assert!(
        counts.len() == 5 && counts.values().all(|it| *it > 20),
        "{counts:?}"
    );
}

/// Recordings of 10 s that ask for something late.
#[test]
fn a_late_trigger_alone_is_open() {
    let of = |text: &str, triggers_secs: &[f64], answers_secs: &[f64]| {
        let formula = parse(text, &|_| None).unwrap().formula;
        let shown =
            |at_secs: f64, of: &[f64]| Some(of.iter().any(|it| (it - at_secs).abs() < 0.05));
        let samples = (0..101).map(|at| f64::from(at) * 0.1);
        let samples = samples.map(|secs| {
            (
                secs,
                vec![shown(secs, triggers_secs), shown(secs, answers_secs)],
            )
        });
        let said = judged(
            &formula,
            &samples.collect(),
            Settings::discrete(Ending::LongEnough),
        );
        (
            said.verdict,
            said.left_out.is_some(),
            said.ends_before.is_some(),
        )
    };
    let within = "always (asked => eventually[0, 5 s] answered)";
    assert_eq!(
        of(within, &[9.0], &[]),
        (Verdict::Inconclusive, false, true)
    );
    assert_eq!(
        of(within, &[9.0], &[9.5]),
        (Verdict::Satisfied, false, false)
    );
    assert_eq!(
        of(within, &[2.0, 9.0], &[3.0]),
        (Verdict::Satisfied, true, false)
    );
    assert_eq!(of(within, &[2.0], &[]), (Verdict::Violated, false, false));
    assert_eq!(of(within, &[], &[]), (Verdict::NotCovered, false, false));
    let held = "always (asked => always[0, 3 s] !answered)";
    assert_eq!(of(held, &[9.0], &[]), (Verdict::Inconclusive, false, true));
    assert_eq!(of(held, &[9.0], &[9.5]), (Verdict::Violated, false, false));
    assert_eq!(
        of(held, &[1.0, 9.0], &[]),
        (Verdict::Satisfied, false, false)
    );
    // Each conjunct has its own.
    let two = "always (asked => eventually[0, 5 s] answered) & eventually (answered & asked)";
    assert_eq!(
        of(two, &[2.0, 9.0], &[3.0]),
        (Verdict::Violated, false, false)
    );
    assert_eq!(
        of(two, &[2.0, 3.0, 9.0], &[3.0]),
        (Verdict::Satisfied, true, false)
    );
    // What waits without an end is decided by the end as before, unless a window that it waits for is pending.
    let waits = "always (asked => eventually always[0, 1 s] answered)";
    assert_eq!(of(waits, &[2.0], &[3.0]), (Verdict::Violated, false, false));
    assert_eq!(
        of(waits, &[2.0], &[10.0]),
        (Verdict::Inconclusive, false, true)
    );
}

/// A trace that is a little shorter than a window shows what is held, and not that what was awaited came; what cannot be told from
/// the end, is open; and a violation that was seen stays one.
#[test]
fn nothing_is_satisfied_of_which_no_window_was_seen_whole() {
    let of = |text: &str, rows: &[(f64, &str)]| {
        let formula = parse(text, &|_| None).unwrap().formula;
        let names = ["a", "b", "c"];
        let atoms = parse(text, &|_| None).unwrap().atoms;
        let shown = |row: &str| -> Vec<Option<bool>> {
            let of = |name: &str| names.contains(&name) && row.contains(name);
            atoms.iter().map(|it| Some(of(it.text.as_str()))).collect()
        };
        let samples = rows.iter().map(|(secs, row)| (*secs, shown(row)));
        judged(
            &formula,
            &samples.collect(),
            Settings::discrete(Ending::LongEnough),
        )
        .verdict
    };
    let until = |end_secs: f64| {
        let rows = (1..).map(|at| (f64::from(at) * 0.05, ""));
        let mut rows: Vec<_> = [(0.0, "a")]
            .into_iter()
            .chain(rows.take_while(|it| it.0 < end_secs + 1e-9))
            .collect();
        rows.dedup_by(|one, other| one.0 == other.0);
        rows
    };
    // Ends at 9.95 s.
    for (bound, verdict) in [
        (9.8, Verdict::Violated),
        (10.0, Verdict::Inconclusive),
        (10.2, Verdict::Inconclusive),
    ] {
        let text = format!("always (a => eventually[0, {bound} s] b)");
        assert_eq!(of(&text, &until(9.95)), verdict, "{bound}");
    }
    assert_eq!(of("always[0, 10 s] !b", &until(9.95)), Verdict::Satisfied);
    assert_eq!(
        of("always[9.95 s, 10 s] b", &until(9.9)),
        Verdict::Inconclusive
    );
    // Over what the future holds there is the past.
    let seen = [(0.0, ""), (0.5, "a"), (1.0, ""), (1.5, "")];
    let past = "always (historically[0.5 s, 1.5 s] (eventually[0 s, 0.5 s] a))";
    assert_eq!(of(past, &seen), Verdict::Violated);
    assert_ne!(
        of("always (b => next (rise a))", &[(0.0, ""), (1.0, "ab")]),
        Verdict::Satisfied
    );
    // Seconds behind samples.
    let rows = [(0.0, ""), (3.0, ""), (4.5, "")];
    assert_eq!(
        of("next (eventually[0, 4 s] b)", &rows),
        Verdict::Inconclusive
    );
    // A trigger that the end cuts, in three ways to write it.
    let gate = [(0.0, ""), (0.5, "")];
    for text in [
        "always ((eventually[0, 3 s] a) => b)",
        "always ((eventually[0, 3 s] a) => b) & always (a => b)",
        "always (!(eventually[0, 3 s] a) | b)",
    ] {
        assert_eq!(of(text, &gate), Verdict::Inconclusive, "{text}");
    }
    let near = [(0.0, "ab"), (1.0, "ab")];
    assert_eq!(
        of("always ((always[0, 3 s] a) => b)", &near),
        Verdict::Inconclusive
    );
    // What asks for `b` only where `a` is not, in whatever order.
    let late: Vec<(f64, &str)> = (0..21)
        .map(|at| (f64::from(at), if at == 19 { "b" } else { "" }))
        .collect();
    for text in [
        "always (b => (!a => eventually[0, 4 s] c))",
        "always (!a => (b => eventually[0, 4 s] c))",
        "always (!b | a | eventually[0, 4 s] c)",
        "always (!a => always (b => eventually[0, 4 s] c))",
    ] {
        assert_eq!(of(text, &late), Verdict::Inconclusive, "{text}");
    }
}

/// What was never known is open beside windows that the end cuts: whoever fills it in must not find another verdict.
#[test]
fn unknown_samples_stay_open_beside_windows_that_the_end_cuts() {
    let texts = [
        "always (eventually[0, 1 samples] a)",
        "always (a => eventually[0, 2 samples] b)",
        "always (a => always[0, 2 samples] b)",
        "always (b until[0, 2 samples] a)",
        "always (a => next b)",
    ];
    let mut numbers = Numbers(41);
    let (mut open, mut told) = (0, 0);
    for text in texts {
        let formula = parse(text, &|_| None).unwrap().formula;
        let of = |samples: &Samples| {
            judged(&formula, samples, Settings::discrete(Ending::LongEnough)).verdict
        };
        for _ in 0..300 {
            let length = 4 + numbers.below(4) as usize;
            let times: Vec<f64> = (0..length).map(|at| at as f64).collect();
            let mut samples = drawn(&mut numbers, &times, false);
            let at = numbers.below(length as u64) as usize;
            let atom = numbers.below(formula.atom_count() as u64) as usize;
            samples[at].1[atom] = None;
            let said = of(&samples);
            let filled = [true, false].map(|value| {
                samples[at].1[atom] = Some(value);
                of(&samples)
            });
            match said {
                Verdict::Satisfied | Verdict::Violated => {
                    told += 1;
                    let contrary = match said {
                        Verdict::Satisfied => Verdict::Violated,
                        _ => Verdict::Satisfied,
                    };
                    assert!(!filled.contains(&contrary), "{text}: {said:?}, {filled:?}");
                }
                _ => open += 1,
            }
        }
    }
    assert!(open > 100 && told > 300, "{open} {told}");
}
