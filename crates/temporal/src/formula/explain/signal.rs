//! The truth of every part of a formula along the line, as runs.

use super::line::{Line, Reach};
use crate::formula::ast::{Formula, Interval};
use crate::formula::dense::between::Between;
use crate::formula::dense::bounded::Bounded;
use crate::formula::positive::positive;
use crate::formula::report::RobustnessBounds;
use crate::formula::settings::{Ending, TimeModel};

type Truth = Option<bool>;

/// A part of a formula, its operands and its truth.
pub(super) struct Part<'f> {
    pub(super) formula: &'f Formula,
    pub(super) operands: Vec<Part<'f>>,
    /// Points up to which (and not including which) the truth holds, from 0 on.
    runs: Vec<(i64, Truth)>,
}

impl<'f> Part<'f> {
    /// Under an odd number of negations, what was not seen counts the other way round.
    pub(super) fn new(formula: &'f Formula, negated: bool, line: &Line<'_>) -> Option<Self> {
        let under = negated != matches!(formula, Formula::Not(_));
        // The operand of a rise stands for itself and its negation.
        let operands = formula
            .operands()
            .into_iter()
            .map(|operand| Part::new(operand, under, line));
        let operands: Vec<Part<'f>> = operands.collect::<Option<_>>()?;
        let runs = match line.time {
            TimeModel::Dense => dense_runs(formula, negated, line)?,
            TimeModel::Discrete => Discrete { line, negated }.runs(formula, &operands)?,
        };
        Some(Part {
            formula,
            operands,
            runs,
        })
    }

    fn run(&self, point: i64) -> usize {
        self.runs.partition_point(|run| run.0 <= point)
    }

    pub(super) fn truth(&self, point: i64) -> Truth {
        self.runs.get(self.run(point)).and_then(|run| run.1)
    }

    /// The last point of the run of a point.
    pub(super) fn run_last(&self, point: i64) -> i64 {
        self.runs
            .get(self.run(point))
            .map_or(point, |run| run.0 - 1)
    }

    /// The first point of the run of a point.
    pub(super) fn run_first(&self, point: i64) -> i64 {
        match self.run(point) {
            0 => 0,
            run => self.runs.get(run - 1).map_or(0, |before| before.0),
        }
    }

    /// The first point from `point` on with this truth.
    pub(super) fn next(&self, point: i64, truth: bool) -> Option<i64> {
        let from = self.run(point);
        let found = (from..self.runs.len()).find(|&run| self.runs[run].1 == Some(truth))?;
        let begins = if found == 0 {
            0
        } else {
            self.runs[found - 1].0
        };
        Some(begins.max(point))
    }

    /// The last point up to `point` with this truth.
    pub(super) fn previous(&self, point: i64, truth: bool) -> Option<i64> {
        let from = self.run(point).min(self.runs.len().checked_sub(1)?);
        let found = (0..=from)
            .rev()
            .find(|&run| self.runs[run].1 == Some(truth))?;
        Some((self.runs[found].0 - 1).min(point))
    }

    fn expanded(&self) -> Vec<Truth> {
        let mut all = Vec::new();
        for &(end, truth) in &self.runs {
            all.resize(usize::try_from(end).unwrap_or(0), truth);
        }
        all
    }
}

/// The truth in dense time, by the engine.
fn dense_runs(formula: &Formula, negated: bool, line: &Line<'_>) -> Option<Vec<(i64, Truth)>> {
    let judged = if negated {
        Formula::not(formula.clone())
    } else {
        formula.clone()
    };
    let mut work = Bounded::new(&positive(&judged, line.time).ok()?, false);
    let atoms = |sample: usize| -> Vec<RobustnessBounds> {
        let truth = |atom| RobustnessBounds::of_truth(line.record.atom(sample, atom));
        (0..line.record.atom_count).map(truth).collect()
    };
    let mut last: Vec<RobustnessBounds> = Vec::new();
    let mut step = |place: i64, atoms: Vec<RobustnessBounds>| {
        let between: Vec<Between> = last
            .iter()
            .map(|bounds| Between::held(*bounds, place))
            .collect();
        work.step(place, &between, &atoms);
        last = atoms;
    };
    if line.record.forgotten > 0 {
        step(0, vec![RobustnessBounds::UNKNOWN; line.record.atom_count]);
    }
    for (sample, place) in line.places.iter().enumerate() {
        step(*place, atoms(sample));
    }
    work.close(line.ending);
    let flip = |(end, truth): (i64, Truth)| (end, truth.map(|truth| truth != negated));
    Some(work.runs().into_iter().map(flip).collect())
}

/// The truth in discrete time, sample by sample.
struct Discrete<'l, 'r> {
    line: &'l Line<'r>,
    negated: bool,
}

impl Discrete<'_, '_> {
    fn runs(&self, formula: &Formula, operands: &[Part<'_>]) -> Option<Vec<(i64, Truth)>> {
        let mut runs: Vec<(i64, Truth)> = Vec::new();
        for (at, truth) in self.truth(formula, operands)?.into_iter().enumerate() {
            match runs.last_mut() {
                Some(last) if last.1 == truth => last.0 = at as i64 + 1,
                _ => runs.push((at as i64 + 1, truth)),
            }
        }
        Some(runs)
    }

    fn truth(&self, formula: &Formula, operands: &[Part<'_>]) -> Option<Vec<Truth>> {
        let count = self.line.record.times_secs.len();
        let operand = |number: usize| operands.get(number).map(Part::expanded);
        Some(match formula {
            Formula::True => vec![Some(true); count],
            Formula::False => vec![Some(false); count],
            Formula::Atom(atom) => (0..count)
                .map(|sample| self.line.record.atom(sample, atom.0))
                .collect(),
            Formula::Not(_) => operand(0)?
                .into_iter()
                .map(|truth| truth.map(|truth| !truth))
                .collect(),
            Formula::And(_) => join(count, operands, false),
            Formula::Or(_) => join(count, operands, true),
            Formula::Next(_) => {
                let mut next = operand(0)?;
                next.push(self.beyond().unwrap_or(Some(false)));
                next.split_off(1)
            }
            Formula::Previous(_) => shifted(operand(0)?, self.before().unwrap_or(Some(false))),
            Formula::Rise(_) => {
                let now = operand(0)?;
                let before = shifted(now.clone(), self.before().unwrap_or(Some(false)));
                let rises = |(now, before): (Truth, Truth)| match (now, before) {
                    (Some(false), _) | (_, Some(true)) => Some(false),
                    (Some(true), Some(false)) => Some(true),
                    _ => None,
                };
                now.into_iter().zip(before).map(rises).collect()
            }
            Formula::Until(interval, ..) => self.until(interval, &operand(0)?, &operand(1)?)?,
            Formula::Since(interval, ..) => self.since(interval, &operand(0)?, &operand(1)?)?,
            // The few operators are all.
            _ => return None,
        })
    }

    /// What is said of samples after the end; `None` if there are none.
    fn beyond(&self) -> Option<Truth> {
        match self.line.ending {
            Ending::Finite | Ending::LongEnough => None,
            Ending::Inconclusive => Some(None),
            Ending::Weak => Some(Some(!self.negated)),
            Ending::Strong => Some(Some(self.negated)),
        }
    }

    /// The same for samples before the first that was kept.
    fn before(&self) -> Option<Truth> {
        self.line.is_cut().then_some(None)
    }

    fn until(&self, interval: &Interval, left: &[Truth], right: &[Truth]) -> Option<Vec<Truth>> {
        let count = left.len() as i64;
        let reach: Option<Vec<Reach>> = (0..count)
            .map(|point| self.line.ahead(interval, point))
            .collect();
        let reach = reach?;
        // Once with what is unknown taken for false, once for true.
        let [least, greatest] = [false, true].map(|unknown| {
            let next_right = next(right, unknown, true);
            let left_ends = next(left, unknown, false);
            let beyond = self
                .beyond()
                .is_some_and(|beyond| beyond.unwrap_or(unknown));
            let holds = |(at, reach): (usize, &Reach)| {
                let begin = usize::try_from(reach.first).unwrap_or(0).min(left.len());
                let found = next_right[begin];
                found <= reach.last && found <= left_ends[at]
                    || reach.open && beyond && left_ends[at] == count
            };
            reach.iter().enumerate().map(holds).collect::<Vec<bool>>()
        });
        Some(both(&least, &greatest))
    }

    fn since(&self, interval: &Interval, left: &[Truth], right: &[Truth]) -> Option<Vec<Truth>> {
        let count = left.len() as i64;
        let reach: Option<Vec<Reach>> = (0..count)
            .map(|point| self.line.behind(interval, point))
            .collect();
        let reach = reach?;
        let [least, greatest] = [false, true].map(|unknown| {
            let last_right = last(right, unknown, true);
            let left_begins = last(left, unknown, false);
            let before = self
                .before()
                .is_some_and(|before| before.unwrap_or(unknown));
            let holds = |(at, reach): (usize, &Reach)| {
                let found = usize::try_from(reach.first).map_or(-1, |first| last_right[first]);
                found >= 0 && found >= reach.last && found >= left_begins[at]
                    || reach.open && before && left_begins[at] < 0
            };
            reach.iter().enumerate().map(holds).collect::<Vec<bool>>()
        });
        Some(both(&least, &greatest))
    }
}

fn both(least: &[bool], greatest: &[bool]) -> Vec<Truth> {
    let truth = |(least, greatest): (&bool, &bool)| (least == greatest).then_some(*least);
    least.iter().zip(greatest).map(truth).collect()
}

/// For each sample the first from there on with this truth; the number of samples if none, and once
/// more for the end.
fn next(values: &[Truth], unknown: bool, truth: bool) -> Vec<i64> {
    let mut found = values.len() as i64;
    let mut all = vec![found; values.len() + 1];
    for (at, value) in values.iter().enumerate().rev() {
        if value.unwrap_or(unknown) == truth {
            found = at as i64;
        }
        all[at] = found;
    }
    all
}

/// For each sample the last up to there with this truth; -1 if none.
fn last(values: &[Truth], unknown: bool, truth: bool) -> Vec<i64> {
    let mut found = -1;
    let of = |(at, value): (usize, &Truth)| {
        if value.unwrap_or(unknown) == truth {
            found = at as i64;
        }
        found
    };
    values.iter().enumerate().map(of).collect()
}

/// The disjunction if `deciding` is true, the conjunction if false.
fn join(count: usize, operands: &[Part<'_>], deciding: bool) -> Vec<Truth> {
    let mut all = vec![Some(!deciding); count];
    for operand in operands {
        for (sum, truth) in all.iter_mut().zip(operand.expanded()) {
            *sum = match (*sum, truth) {
                (Some(one), _) | (_, Some(one)) if one == deciding => Some(deciding),
                (Some(_), Some(_)) => Some(!deciding),
                _ if *sum == Some(deciding) || truth == Some(deciding) => Some(deciding),
                _ => None,
            };
        }
    }
    all
}

/// The truth one sample before.
fn shifted(values: Vec<Truth>, first: Truth) -> Vec<Truth> {
    let count = values.len();
    std::iter::once(first).chain(values).take(count).collect()
}
