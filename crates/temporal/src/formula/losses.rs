//! What a formula says of a trace from which samples are missing.
//!
//! # Definition
//! A *loss* is a span of time in which samples may have been taken that are not in the trace: any
//! number of them, at any times of the span, with any values. A *completion* is a trace in which some
//! such samples are put in. A verdict is sound if it is the verdict of every completion.
//!
//! # Dense time
//! All atoms are unknown from the beginning of the loss until they are sampled again. Values between
//! samples are held, so this stands for every completion.
//!
//! # Discrete time
//! Samples are what operators speak of, so it matters that some may be there. Into the loss go
//! *stand-ins*, samples that are marked by an atom m of their own; w is an atom that is always
//! unknown. At a stand-in a subformula with a temporal operator is unknown, and others have the value
//! of their atoms (unknown where signals were lost). What an operator is made of a stand-in must not
//! depend on whether there is one:
//!
//! * where one sample suffices (eventually, the right of until, the past likewise), a stand-in can
//!   only leave the truth open: f becomes f & (!m | w);
//! * where all samples count (always, the left of until), likewise: f becomes f | (m & w);
//! * `next`, `previous`, `rise` and `fall` look at exactly one sample: f becomes (!m & f) | (m & w).
//!
//! Stand-ins are put at the beginning and the end of the loss and at distances of at most the shortest
//! interval in seconds, so each interval that meets the loss holds one; and at least as many as the
//! largest bound in samples, so none reaches across. Where that cannot be had (an exact instant, "at
//! least n samples" without an end, too many stand-ins), the trace counts as cut short at the loss.
//!
//! # Guarantee
//! Sound, not complete: a verdict may stay open though all completions agree. Held against all
//! completions with up to two lost samples in `tests/integration/formula_losses.rs`.

use super::ast::{AtomId, Formula, Interval, Window};
use super::settings::{CompileError, TimeModel};

/// The most stand-ins for one loss.
const MAX_STAND_INS: f64 = 200_000.0;

/// How a formula is brought across a loss.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Across {
    /// One sample at which all is unknown.
    Unknown,
    /// At least so many stand-ins, at distances of at most so many seconds.
    StandIns { count: u64, spacing_secs: f64 },
    /// Not at all.
    Cut,
}

/// How `formula` is brought across losses.
pub(super) fn across(formula: &Formula, time: TimeModel) -> Result<Across, CompileError> {
    if time == TimeModel::Dense {
        return Ok(Across::Unknown);
    }
    let (mut count, mut spacing_secs) = (1_u64, f64::INFINITY);
    let mut all = vec![formula];
    while let Some(part) = all.pop() {
        all.extend(part.operands());
        let Some(interval) = part.interval() else {
            continue;
        };
        match interval.window(time)? {
            Window::Samples { low, high: None } if low > 0 => return Ok(Across::Cut),
            Window::Samples { high, .. } => count = count.max(high.unwrap_or(0).saturating_add(1)),
            Window::Seconds {
                low_secs,
                high_secs,
            } => spacing_secs = spacing_secs.min(high_secs - low_secs),
        }
    }
    if spacing_secs < 1e-8 {
        return Ok(Across::Cut);
    }
    Ok(Across::StandIns {
        count,
        spacing_secs,
    })
}

/// The times of the stand-ins between two samples, of which the earlier may be minus infinity, for a
/// loss that meets what is between them; `None` if there would be too many.
pub(super) fn stand_ins(
    (count, spacing_secs): (u64, f64),
    (from_secs, to_secs): (f64, f64),
    (before_secs, after_secs): (f64, f64),
) -> Option<Vec<f64>> {
    const NEXT_SECS: f64 = 1e-9;
    let after = |secs: f64| (secs + NEXT_SECS).max(secs.next_up());
    let before = |secs: f64| (secs - NEXT_SECS).min(secs.next_down());
    let to_secs = to_secs.min(before(after_secs));
    let mut from_secs = from_secs.max(after(before_secs));
    if from_secs > to_secs || !from_secs.is_finite() {
        // Two samples next to each other, or a loss without a beginning: one is all that fits.
        from_secs = to_secs;
    }
    if from_secs <= before_secs {
        return Some(Vec::new());
    }
    let length_secs = to_secs - from_secs;
    let needed = (length_secs / spacing_secs).ceil().max(count as f64) + 1.0;
    if needed > MAX_STAND_INS {
        return None;
    }
    let steps = needed.max(1.0);
    let mut times_secs: Vec<f64> = (0..=steps as u64)
        .map(|step| from_secs + length_secs * (step as f64 / steps))
        .collect();
    if length_secs <= 0.0 {
        // They share one instant, as they may.
        times_secs.fill(to_secs);
    }
    Some(times_secs)
}

/// A formula with what it needs at stand-ins.
pub(super) struct Marked {
    mark: Formula,
    open: Formula,
}

impl Marked {
    /// The mark and the unknown atom are the two behind `atom_count` others.
    pub(super) fn new(atom_count: usize) -> Self {
        Marked {
            mark: Formula::Atom(AtomId(atom_count)),
            open: Formula::Atom(AtomId(atom_count + 1)),
        }
    }

    /// The formula, whose first sample may be a stand-in: only what holds of all or of some samples of
    /// the trace is then said of it.
    pub(super) fn root(&self, formula: &Formula) -> Formula {
        match formula {
            Formula::Always(interval, _) | Formula::Eventually(interval, _)
                if *interval == Interval::UNBOUNDED =>
            {
                self.inside(formula)
            }
            Formula::True
            | Formula::False
            | Formula::Not(_)
            | Formula::And(_)
            | Formula::Or(_)
            | Formula::Implies(..)
            | Formula::Iff(..) => mapped(formula, &|part| self.root(part)),
            _ => self.exactly(self.inside(formula)),
        }
    }

    /// What triggers, unknown at stand-ins.
    pub(super) fn trigger(&self, formula: &Formula) -> Formula {
        self.exactly(self.inside(formula))
    }

    /// The formula where it is not a stand-in's.
    fn inside(&self, formula: &Formula) -> Formula {
        let boxed = Box::new;
        match formula {
            Formula::Next(f) => Formula::Next(boxed(self.exactly(self.inside(f)))),
            Formula::Previous(f) => Formula::Previous(boxed(self.exactly(self.inside(f)))),
            Formula::Rise(f) => Formula::Rise(boxed(self.exactly(self.inside(f)))),
            Formula::Fall(f) => Formula::Fall(boxed(self.exactly(self.inside(f)))),
            Formula::Eventually(i, f) => Formula::Eventually(*i, boxed(self.some(f))),
            Formula::Once(i, f) => Formula::Once(*i, boxed(self.some(f))),
            Formula::Always(i, f) => Formula::Always(*i, boxed(self.every(f))),
            Formula::Historically(i, f) => Formula::Historically(*i, boxed(self.every(f))),
            Formula::Until(i, f, g) => {
                Formula::Until(*i, boxed(self.every(f)), boxed(self.some(g)))
            }
            Formula::Since(i, f, g) => {
                Formula::Since(*i, boxed(self.every(f)), boxed(self.some(g)))
            }
            Formula::Release(i, f, g) => {
                Formula::Release(*i, boxed(self.some(f)), boxed(self.every(g)))
            }
            // By its definition.
            Formula::WeakUntil(i, f, g) => {
                let either = Formula::or(f.as_ref().clone(), g.as_ref().clone());
                Formula::Release(*i, boxed(self.some(g)), boxed(self.every(&either)))
            }
            _ => mapped(formula, &|part| self.inside(part)),
        }
    }

    /// An operand: its temporal parts are unknown at stand-ins.
    fn operand(&self, formula: &Formula) -> Formula {
        match formula {
            Formula::True
            | Formula::False
            | Formula::Atom(_)
            | Formula::Not(_)
            | Formula::And(_)
            | Formula::Or(_)
            | Formula::Implies(..)
            | Formula::Iff(..) => mapped(formula, &|part| self.operand(part)),
            _ => self.exactly(self.inside(formula)),
        }
    }

    fn some(&self, formula: &Formula) -> Formula {
        let no_stand_in = Formula::or(Formula::not(self.mark.clone()), self.open.clone());
        Formula::and(self.operand(formula), no_stand_in)
    }

    fn every(&self, formula: &Formula) -> Formula {
        let stand_in = Formula::and(self.mark.clone(), self.open.clone());
        Formula::or(self.operand(formula), stand_in)
    }

    fn exactly(&self, formula: Formula) -> Formula {
        let seen = Formula::and(Formula::not(self.mark.clone()), formula);
        Formula::or(seen, Formula::and(self.mark.clone(), self.open.clone()))
    }
}

/// A propositional operator over what becomes of its operands; others as they are.
fn mapped(formula: &Formula, become_: &dyn Fn(&Formula) -> Formula) -> Formula {
    let boxed = |part: &Formula| Box::new(become_(part));
    match formula {
        Formula::Not(f) => Formula::Not(boxed(f)),
        Formula::And(all) => Formula::And(all.iter().map(become_).collect()),
        Formula::Or(all) => Formula::Or(all.iter().map(become_).collect()),
        Formula::Implies(f, g) => Formula::Implies(boxed(f), boxed(g)),
        Formula::Iff(f, g) => Formula::Iff(boxed(f), boxed(g)),
        other => other.clone(),
    }
}
