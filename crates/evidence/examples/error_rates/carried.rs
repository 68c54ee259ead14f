//! Models that carry over: the declaration holds (the model is within the margin of the system on what is asked if it is on
//! the anchor), and the claim is false. The worst case of both halves: the system differs from the model by exactly the
//! margin, on the anchor as on what is asked, and what is asked lies at its threshold.

use super::several::{concluded, is_of_system};
use super::support::{Uniform, at_least, counts, exact, piece, requirement, subject};
use super::table::{Job, Row, all};
use evidence::*;

const MARGIN: f64 = 0.1;

/// What carries over.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// `None` for a model's exact value, else the runs of a simulator.
    pub runs: Option<u64>,
    /// Trials of each experiment on the anchor.
    pub trials: u64,
    pub experiments: usize,
    /// How many requirements the model carries over to.
    pub requirements: usize,
    /// Each by agreement on a quantity of its own, counted anew; else all by the same.
    pub own_anchors: bool,
    /// The model's rate less the system's, on the anchor and on what is asked.
    pub off: [f64; 2],
    /// Looks, with as many trials again at each.
    pub looks: usize,
}

const SYSTEM: f64 = 0.8;
/// Within the margin, by little: at the margin itself a known value decides by rounding.
const NEAR: f64 = 0.0999;

/// Whether a study calls any requirement satisfied (or violated) by what is carried over.
fn is_said(case: &Case, wanted: Verdict, uniform: &mut Uniform) -> bool {
    let anchors = match case.own_anchors {
        true => case.requirements,
        false => 1,
    };
    let places = anchors + case.requirements;
    let mut asked: Vec<_> = (0..anchors)
        .map(|anchor| requirement(anchor, at_least(0.1)))
        .collect();
    for index in 0..case.requirements {
        let mut one = requirement(anchors + index, at_least(SYSTEM));
        one.carries_over = vec![CarryOver {
            evidence: "M".into(),
            shown_by: "M".into(),
            on: subject(index.min(anchors - 1)),
            because: "the same mechanism".into(),
        }];
        asked.push(one);
    }
    let values = |place: usize| SYSTEM + case.off[usize::from(place >= anchors)];
    let mut passed = vec![vec![0; anchors]; case.experiments];
    let mut simulated = vec![0; places];
    let mut looks = Looks::default();
    for look in 1..=case.looks as u64 {
        let model = (0..places).map(|place| match case.runs {
            None => (place, exact(values(place))),
            Some(runs) => {
                simulated[place] += uniform.count(runs, values(place));
                (place, counts(simulated[place], look * runs))
            }
        });
        let technique = match case.runs {
            None => Technique::ModelChecking,
            Some(_) => Technique::Simulation,
        };
        let mut ledger = vec![piece("M", technique, model.collect())];
        for (place, passed) in passed.iter_mut().enumerate() {
            let counted = passed.iter_mut().enumerate().map(|(anchor, passed)| {
                *passed += uniform.count(case.trials, SYSTEM);
                (anchor, counts(*passed, look * case.trials))
            });
            ledger.push(piece(
                &format!("E{place}"),
                Technique::Experiment,
                counted.collect(),
            ));
        }
        looks = looks.with(Look::of(&ledger));
        let recorded = (case.looks > 1).then_some(&looks);
        let (_, found) = concluded(&ledger, &asked, recorded);
        if found[anchors..].iter().any(|it| is_of_system(it, wanted)) {
            return true;
        }
    }
    false
}

/// How often.
pub fn share(case: &Case, wanted: Verdict, studies: u64) -> (u64, u64) {
    let mut uniform = Uniform(case.trials + case.experiments as u64);
    let found = (0..studies).filter(|_| is_said(case, wanted, &mut uniform));
    (found.count() as u64, studies)
}

fn rows_of(case: &Case, studies: u64) -> Vec<Row> {
    let model = match case.runs {
        None => "a model".to_owned(),
        Some(runs) => format!("a simulator of {runs}"),
    };
    let [there, here] = case.off;
    let anchor = match case.own_anchors {
        true => "an anchor each",
        false => "anchor",
    };
    let name = format!(
        "{model}, {anchor} in {} x {} trials, {} to carry over to, {} looks; off by {there} there and {here} here",
        case.experiments, case.trials, case.requirements, case.looks
    );
    let (wanted, statement) = match here > 0.0 {
        true => (Verdict::Satisfied, "satisfied, corroborated"),
        false => (Verdict::Violated, "violated, corroborated"),
    };
    // Within the margin on the anchor and beyond it on what is asked, the declaration is false: nothing is promised.
    let holds = here.abs() <= MARGIN + 1e-9 || there.abs() >= MARGIN - 1e-9;
    let most = holds.then_some(0.05);
    vec![Row::counted(
        &name,
        statement,
        share(case, wanted, studies),
        most,
    )]
}

pub fn rows(studies: u64) -> Vec<Row> {
    let mut jobs: Vec<Job<'_>> = Vec::new();
    let mut add = |case: Case, studies: u64| {
        jobs.push(Box::new(move || rows_of(&case, studies)));
    };
    for runs in [None, Some(300)] {
        for trials in [50, 200] {
            for experiments in [1, 2] {
                for off in [[MARGIN, 0.19], [-MARGIN, -0.19], [0.0, NEAR], [0.0, -NEAR]] {
                    let case = Case {
                        runs,
                        trials,
                        experiments,
                        requirements: 1,
                        own_anchors: false,
                        off,
                        looks: 1,
                    };
                    add(case, studies);
                }
            }
        }
        for (requirements, looks) in [(4, 1), (1, 4)] {
            let case = Case {
                runs,
                trials: 100,
                experiments: 1,
                requirements,
                own_anchors: false,
                off: [MARGIN, 0.19],
                looks,
            };
            add(case, studies / 4);
            let near = Case {
                off: [0.0, NEAR],
                ..case
            };
            add(near, studies / 4);
        }
        for off in [[MARGIN, 0.19], [-MARGIN, -0.19]] {
            let case = Case {
                runs,
                trials: 100,
                experiments: 1,
                requirements: 6,
                own_anchors: true,
                off,
                looks: 1,
            };
            add(case, studies);
        }
        let undeclared = Case {
            runs,
            trials: 200,
            experiments: 1,
            requirements: 1,
            own_anchors: false,
            off: [0.0, 0.19],
            looks: 1,
        };
        add(undeclared, studies / 4);
    }
    all(&jobs)
}
