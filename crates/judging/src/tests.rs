//! What monitors are given, against the definition; and that it depends on nothing else.

use super::{Judges, News};
use diagnostic::Source;
use evidence::Subject;
use std::collections::BTreeMap;
use study::{FormulaRule, JudgingForm, Rule, Vocabulary};
use temporal::formula::semantics::signals::{self, Signal};
use temporal::formula::{Ending, TimeModel};
use temporal::monitor::{AtEnd, MonitorSpec, Repeat, Stage, Trigger, Verdict};
use trace::{Field, Replay, Trace};

/// A fixed sequence that looks random.
struct Numbers(u64);

impl Numbers {
    fn below(&mut self, limit: u64) -> u64 {
        self.0 = (self.0)
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % limit
    }

    fn of<'t>(&mut self, texts: &[&'t str]) -> &'t str {
        texts[self.below(texts.len() as u64) as usize]
    }
}

const TOPICS: [&str; 3] = ["/a", "/b", "/c"];
const ATOMS: [&str; 5] = [
    "(/a.x > 0)",
    "(/b.x > 0)",
    "(/c.x > 0)",
    "(/a.x + /b.x > 0)",
    "(/b.x < /c.x)",
];
const START_WITHIN_SECS: f64 = 0.75;

fn formula(numbers: &mut Numbers, depth: u64, dense: bool) -> String {
    if depth == 0 {
        return numbers.of(&ATOMS).to_owned();
    }
    let windows = match dense {
        true => ["", "[0, 0.5 s]", "[0.5 s, 1 s]", "[1 s, inf]"],
        false => ["", "[0, 0.5 s]", "[0.5 s, 1 s]", "[0, 1 samples]"],
    };
    let window = numbers.of(&windows);
    let inner = |numbers: &mut Numbers| {
        let depth = numbers.below(depth);
        formula(numbers, depth, dense)
    };
    let (left, right) = (inner(numbers), inner(numbers));
    match numbers.below(if dense { 9 } else { 11 }) {
        0 => format!("(always{window} {left})"),
        1 => format!("(eventually{window} {left})"),
        2 => format!("({left} until{window} {right})"),
        3 => format!("(once{window} {left})"),
        4 => format!("(historically{window} {left})"),
        5 => format!("({left} since{window} {right})"),
        6 => format!("({left} and {right})"),
        7 => format!("(not {left} or {right})"),
        8 => format!("rise({left})"),
        9 => format!("(next {left})"),
        _ => format!("(previous {left})"),
    }
}

/// One signal: up to five samples at halves of seconds, several of which may be of one time.
fn signal(numbers: &mut Numbers) -> Signal {
    let mut samples: Signal = (0..numbers.below(6))
        .map(|_| {
            let value = [-1.0, 1.0, 1.0, f64::NAN][numbers.below(4) as usize];
            (numbers.below(5) as f64 / 2.0, value)
        })
        .collect();
    samples.sort_by(|one, other| one.0.total_cmp(&other.0));
    samples
}

fn trace_of(all: &[Signal], wanted: &[usize]) -> Trace {
    let mut trace = Trace::new();
    for topic in wanted {
        let channel = trace
            .add_channel(TOPICS[*topic], vec![Field::number("x", "")])
            .expect("a channel");
        for (time_secs, value) in &all[*topic] {
            trace.channels[channel]
                .push(*time_secs, &[*value])
                .expect("a row");
        }
    }
    trace
}

fn form(text: &str, time: TimeModel, ending: Ending) -> JudgingForm {
    let parsed = temporal::formula::parse(text, &|_| None).expect("a formula");
    let rule = FormulaRule {
        text: text.to_owned(),
        resolved: parsed.to_string(),
        trigger: None,
        trigger_text: None,
        parsed,
        time,
        ending,
        place: None,
    };
    JudgingForm {
        rule: Rule::Formula(rule),
        clock: None,
        start_within_secs: START_WITHIN_SECS,
        from_sentence: false,
    }
}

fn vocabulary() -> Vocabulary {
    Vocabulary {
        source: Source {
            name: "test".into(),
            text: String::new(),
        },
        propositions: BTreeMap::new(),
        signals: trace::Vocabulary::default(),
    }
}

/// What all forms say together of a trace of all signals, and each of a trace of those that it reads; with
/// which those are.
fn together_and_alone(forms: &[JudgingForm], all: &[Signal]) -> Vec<(String, String, Vec<usize>)> {
    let vocabulary = vocabulary();
    let subjects: Vec<Subject> = (0..forms.len())
        .map(|place| Subject::Requirement(place.to_string()))
        .collect();
    let judges = Judges::without_study(&vocabulary, subjects.iter().zip(forms)).expect("judges");
    let whole = trace_of(all, &[0, 1, 2]);
    let together = judges.judge(&whole).expect("judged");
    let alone = forms.iter().zip(&subjects).map(|(form, subject)| {
        let judges = Judges::without_study(&vocabulary, [(subject, form)]).expect("judges");
        let read = judges.signals();
        let is_read = |topic: &usize| read.contains(&format!("{}.x", TOPICS[*topic]));
        let read: Vec<usize> = (0..TOPICS.len()).filter(is_read).collect();
        let trace = trace_of(all, &read);
        let judged = judges.judge(&trace).expect("judged");
        (format!("{:?}", judged[0].findings), read)
    });
    let together = together.iter().map(|it| format!("{:?}", it.findings));
    let pairs = together.zip(alone);
    pairs
        .map(|(one, (other, read))| (one, other, read))
        .collect()
}

#[test]
fn judging_together_is_judging_alone_and_as_the_definition_says() {
    let mut numbers = Numbers(7);
    let mut decided = 0;
    for _ in 0..1500 {
        let all: Vec<Signal> = (0..3).map(|_| signal(&mut numbers)).collect();
        for (time, ending) in [
            (TimeModel::Discrete, Ending::Finite),
            (TimeModel::Discrete, Ending::Inconclusive),
            (TimeModel::Dense, Ending::Finite),
        ] {
            let dense = time == TimeModel::Dense;
            let texts: Vec<String> = (0..3).map(|_| formula(&mut numbers, 3, dense)).collect();
            let forms: Vec<JudgingForm> = texts.iter().map(|it| form(it, time, ending)).collect();
            let said = together_and_alone(&forms, &all);
            for ((text, form), (together, alone, read)) in texts.iter().zip(&forms).zip(said) {
                assert_eq!(together, alone, "{text} ({time:?}) on {all:?}");
                // Of what looks back on the future the engine does not find out all that is known before
                // the end.
                let looks_back = ["once", "historically", "since"]
                    .iter()
                    .any(|it| text.contains(it));
                let is_open = ending == Ending::Inconclusive && looks_back;
                if dense || is_open || together.contains("NotCovered") {
                    continue;
                }
                let meant = by_definition(form, ending, &all, &read);
                let word = format!("verdict: {meant:?},");
                assert!(
                    together.contains(&word),
                    "{text} on {all:?}: {together}, not {meant:?}"
                );
                decided += u64::from(meant != Verdict::Inconclusive);
            }
        }
    }
    assert!(decided > 1000, "{decided}");
}

fn by_definition(form: &JudgingForm, ending: Ending, all: &[Signal], read: &[usize]) -> Verdict {
    let Rule::Formula(rule) = &form.rule else {
        return Verdict::Inconclusive;
    };
    let texts: Vec<&str> = rule
        .parsed
        .atoms
        .iter()
        .map(|atom| atom.text.as_str())
        .collect();
    let signals: Vec<Signal> = read.iter().map(|topic| all[*topic].clone()).collect();
    let atoms = |values: &[f64]| -> Vec<Option<bool>> {
        let value = |topic: usize| {
            let place = read.iter().position(|it| *it == topic);
            place.map(|place| values[place]).filter(|it| !it.is_nan())
        };
        let (a, b, c) = (value(0), value(1), value(2));
        let truth = |text: &&str| match text.trim_matches(['(', ')']) {
            "/a.x > 0" => Some(a? > 0.0),
            "/b.x > 0" => Some(b? > 0.0),
            "/c.x > 0" => Some(c? > 0.0),
            "/a.x + /b.x > 0" => Some(a? + b? > 0.0),
            "/b.x < /c.x" => Some(b? < c?),
            other => panic!("what is {other}?"),
        };
        texts.iter().map(truth).collect()
    };
    let formula = &rule.parsed.formula;
    signals::verdict(formula, &signals, &atoms, ending, START_WITHIN_SECS).expect("a verdict")
}

#[test]
fn stages_depend_on_nothing_but_what_they_read() {
    let mut numbers = Numbers(11);
    for _ in 0..1500 {
        let all: Vec<Signal> = (0..3).map(|_| signal(&mut numbers)).collect();
        // That the run went on is known of a trace as a whole.
        let all: Vec<Signal> = all
            .into_iter()
            .map(|it| [it, vec![(2.5, 1.0)]].concat())
            .collect();
        let stage = |numbers: &mut Numbers| match numbers.below(3) {
            0 => Stage::Assert {
                proposition: numbers.of(&ATOMS).to_owned(),
            },
            1 => Stage::WaitFor {
                proposition: numbers.of(&ATOMS).to_owned(),
                within_secs: Some(0.75),
            },
            _ => Stage::Hold {
                proposition: numbers.of(&ATOMS).to_owned(),
                until: numbers.of(&ATOMS).to_owned(),
                within_secs: None,
            },
        };
        let forms: Vec<JudgingForm> = (0..3)
            .map(|_| JudgingForm {
                rule: Rule::Staged(MonitorSpec {
                    when: numbers.of(&ATOMS).to_owned(),
                    trigger: Trigger::BecomesTrue,
                    then: (0..=numbers.below(2))
                        .map(|_| stage(&mut numbers))
                        .collect(),
                    repeat: Repeat::EveryTrigger,
                    at_end: AtEnd::InconclusivePending,
                }),
                clock: None,
                start_within_secs: START_WITHIN_SECS,
                from_sentence: false,
            })
            .collect();
        for (together, alone, _) in together_and_alone(&forms, &all) {
            assert_eq!(together, alone, "on {all:?}");
        }
    }
}

#[test]
fn every_message_of_an_instant_counts_and_the_start_has_a_limit() {
    let judged = |text: &str, all: [Signal; 3]| {
        let form = form(text, TimeModel::Discrete, Ending::Finite);
        let found = together_and_alone(&[form], &all).remove(0).0;
        let verdict = found
            .split("verdict: ")
            .nth(1)
            .and_then(|it| it.split(',').next());
        verdict.expect("a verdict").to_owned()
    };
    let same = vec![(0.0, 1.0), (1.0, -3.0), (1.0, 2.0), (2.0, 1.0)];
    assert_eq!(
        judged("always (/a.x > 0)", [same, vec![], vec![]]),
        "Violated"
    );
    let late = |secs: f64| {
        [
            vec![(0.0, 1.0), (2.0, 2.0)],
            vec![(secs, 1.0), (2.0, 1.0)],
            vec![],
        ]
    };
    assert_eq!(judged("always (/a.x - /b.x < 5)", late(0.001)), "Satisfied");
    assert_eq!(
        judged("always (/a.x - /b.x < 5)", late(1.5)),
        "Inconclusive"
    );
    // What was violated before the second one came stays so.
    let before = [vec![(0.0, -1.0), (1.0, 1.0)], vec![(0.5, 1.0)], vec![]];
    assert_eq!(judged("always (/a.x > 0 and /b.x > 0)", before), "Violated");
}

#[test]
fn samples_of_a_replay_are_those_of_the_definition() {
    let mut numbers = Numbers(3);
    for _ in 0..500 {
        let all: Vec<Signal> = (0..3).map(|_| signal(&mut numbers)).collect();
        let trace = trace_of(&all, &[0, 1, 2]);
        let mut replay = Replay::new(&trace);
        let mut seen = Vec::new();
        while let Some(sample) = replay.advance() {
            let value = |channel| {
                let signal = trace::SignalIndex { channel, field: 0 };
                trace::SignalValues::raw(&replay, signal)
            };
            let news = News {
                changed: replay.changed(),
                sampled: None,
                dropped: None,
                more: sample.more,
            };
            assert!(news.changed.contains(&true));
            seen.push((sample.time_secs, (0..3).map(value).collect::<Vec<f64>>()));
        }
        assert_eq!(format!("{seen:?}"), format!("{:?}", signals::samples(&all)));
    }
}
