//! What a formula means on a finite trace: the definition, executed as it stands.
//!
//! # Values
//! A *value* is a robustness: how far, in the units of the atoms, the signals are from changing the
//! truth. Positive is true, negative is false, and a value of exactly 0 is compatible with both, so
//! truth is judged from truth values: an atom that is true has the value +inf, one that is false
//! -inf, and the same definition then gives the truth. Of an atom that was not recorded, and of all
//! that was not seen, only bounds are known, [-inf, +inf]. All operators are monotone in their
//! operands or, for negation, antitone, so bounds are computed from bounds (interval arithmetic;
//! J. V. Deshmukh et al., "Robust online monitoring of signal temporal logic", Formal Methods in
//! System Design 51, 2017).
//!
//! # Discrete time
//! A trace has samples 0 ... n at times t_0 <= ... <= t_n. v(f, i) is the value of f at sample i.
//! Samples of equal times are samples in their own right, in their order: `next` goes from one to the
//! following one, a bound in samples counts each, and an interval in seconds holds either all or none
//! of them. Where the samples come from is defined in [`signals`].
//!
//! * v(true, i) = +inf, v(false, i) = -inf, v(!f, i) = -v(f, i);
//! * v(f & g, i) = min(v(f, i), v(g, i)); v(f | g, i) = max; f => g is !f | g; f <=> g is
//!   (f & g) | (!f & !g);
//! * v(next f, i) = v(f, i + 1); v(previous f, i) = v(f, i - 1), and -inf at i = 0;
//! * v(f until_I g, i) = max over all j >= i in I of min(v(g, j), min over i <= k < j of v(f, k));
//! * v(f since_I g, i) = max over all j <= i in I of min(v(g, j), min over j < k <= i of v(f, k));
//! * eventually_I f = true until_I f; always_I f = !eventually_I !f; once and historically likewise;
//! * f release_I g = !(!f until_I !g); f weak_until_I g = g release_I (f | g);
//! * v(rise f, i) = min(v(f, i), -v(f, i - 1)), and v(f, 0) at i = 0; fall f = rise !f.
//!
//! j is in I = [l, h], seen from i, if l <= |j - i| <= h for an interval in samples, and
//! l <= |t_j - t_i| <= h for one in seconds. Times are compared with a tolerance of 1 ns, the
//! resolution of recorded times, or of four units in the last place of the later time where that is
//! coarser. (A window of the future ends with the first instant that is not clearly before its end, and
//! holds all samples of that instant.)
//!
//! A formula is judged at the first sample. Of a trace without samples nothing is known.
//!
//! # The end of the trace
//! What was not seen are the samples n + 1, n + 2, ...; a window that is not over at sample n
//! reaches there, whether or not a sample will come in time. There, every formula has the value
//!
//! * [`Ending::Inconclusive`]: [-inf, +inf]. Satisfied, or violated, then means that every
//!   continuation has this verdict (as in RV-LTL; A. Bauer, M. Leucker and C. Schallhart, "Comparing
//!   LTL semantics for runtime verification", J. Logic and Computation 20(3), 2010). The converse
//!   is not claimed: what could only be known by comparing formulas is not found out, so
//!   `eventually a or always not a` is inconclusive before a is seen, and so is `next true`.
//! * [`Ending::Weak`]: +inf, and -inf under an odd number of negations; [`Ending::Strong`]: the
//!   opposite (the weak and strong views of truncated paths; C. Eisner et al., "Reasoning with
//!   temporal logic on truncated paths", CAV 2003).
//! * [`Ending::Finite`]: there are no such samples. `next f` is false at the last one, and windows
//!   end with the trace (LTLf; G. De Giacomo and M. Y. Vardi, "Linear temporal logic and linear
//!   dynamic logic on finite traces", IJCAI 2013). A trace that was cut short is not finite in
//!   this sense; it is judged as with `Inconclusive`.
//!
//! Dense time is defined in [`dense`].
//!
//! Cost: O(|f| n^3). This is the oracle that the engines are tested against, and shares only the
//! tree of the formula with them.

pub mod dense;
pub mod signals;

use super::ast::{Formula, Window};
use super::report::RobustnessBounds;
use super::settings::{CompileError, Ending, TimeModel};
use crate::monitor::Verdict;

/// A trace: the time of each sample, and bounds on the value of each atom there.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Word {
    /// Times in seconds, ascending; samples of one instant have equal ones.
    pub times_secs: Vec<f64>,
    /// For each sample the bounds of each atom.
    pub atoms: Vec<Vec<RobustnessBounds>>,
}

impl Word {
    /// Adds a sample of truth values, `None` for unknown.
    pub fn push_truth(&mut self, time_secs: f64, atoms: &[Option<bool>]) {
        self.times_secs.push(time_secs);
        self.atoms.push(
            atoms
                .iter()
                .map(|&truth| RobustnessBounds::of_truth(truth))
                .collect(),
        );
    }

    /// Adds a sample of values, NaN for unknown.
    pub fn push_values(&mut self, time_secs: f64, atoms: &[f64]) {
        self.times_secs.push(time_secs);
        self.atoms.push(
            atoms
                .iter()
                .map(|&value| RobustnessBounds::of_value(value))
                .collect(),
        );
    }
}

impl RobustnessBounds {
    /// The value of an atom with this truth value.
    #[must_use]
    pub fn of_truth(truth: Option<bool>) -> Self {
        match truth {
            Some(true) => Self::exactly(f64::INFINITY),
            Some(false) => Self::exactly(f64::NEG_INFINITY),
            None => Self::UNKNOWN,
        }
    }

    /// This value; unknown if it is NaN.
    #[must_use]
    pub fn of_value(value: f64) -> Self {
        if value.is_nan() {
            Self::UNKNOWN
        } else {
            Self::exactly(value)
        }
    }

    /// This value and no other.
    #[must_use]
    pub const fn exactly(value: f64) -> Self {
        RobustnessBounds {
            low: value,
            high: value,
        }
    }

    /// The truth value, if all values within the bounds have the same.
    #[must_use]
    pub fn truth(self) -> Option<bool> {
        if self.low > 0.0 {
            Some(true)
        } else if self.high < 0.0 {
            Some(false)
        } else {
            None
        }
    }

    /// The verdict for a formula with these bounds.
    #[must_use]
    pub fn verdict(self) -> Verdict {
        match self.truth() {
            Some(true) => Verdict::Satisfied,
            Some(false) => Verdict::Violated,
            None => Verdict::Inconclusive,
        }
    }

    fn negated(self) -> Self {
        RobustnessBounds {
            low: -self.high,
            high: -self.low,
        }
    }

    fn min(self, other: Self) -> Self {
        RobustnessBounds {
            low: self.low.min(other.low),
            high: self.high.min(other.high),
        }
    }

    fn max(self, other: Self) -> Self {
        RobustnessBounds {
            low: self.low.max(other.low),
            high: self.high.max(other.high),
        }
    }
}

/// The value of a formula in discrete time at the first sample.
///
/// # Errors
/// [`CompileError`] if an interval makes no sense.
pub fn value(
    formula: &Formula,
    word: &Word,
    ending: Ending,
) -> Result<RobustnessBounds, CompileError> {
    let all = values(formula, word, ending)?;
    Ok(all.first().copied().unwrap_or(RobustnessBounds::UNKNOWN))
}

/// The value of a formula in discrete time at each sample.
///
/// # Errors
/// [`CompileError`] if an interval makes no sense.
pub fn values(
    formula: &Formula,
    word: &Word,
    ending: Ending,
) -> Result<Vec<RobustnessBounds>, CompileError> {
    at_all(formula, word, beyond(ending))
}

/// The value of every formula at the samples that were not seen; `None` if there are none.
fn beyond(ending: Ending) -> Option<RobustnessBounds> {
    match ending {
        Ending::Inconclusive => Some(RobustnessBounds::UNKNOWN),
        Ending::Weak => Some(RobustnessBounds::of_truth(Some(true))),
        Ending::Strong => Some(RobustnessBounds::of_truth(Some(false))),
        Ending::Finite | Ending::LongEnough => None,
    }
}

type Values = Vec<RobustnessBounds>;
type Beyond = Option<RobustnessBounds>;

const TRUE: RobustnessBounds = RobustnessBounds::exactly(f64::INFINITY);
const FALSE: RobustnessBounds = RobustnessBounds::exactly(f64::NEG_INFINITY);

/// The value at each sample, where `beyond` is that at the samples that were not seen.
fn at_all(formula: &Formula, word: &Word, beyond: Beyond) -> Result<Values, CompileError> {
    let count = word.times_secs.len();
    let plain = |formula: &Formula| at_all(formula, word, beyond);
    // The operand of a negation is under one more of them.
    let opposite = |formula: &Formula| -> Result<Values, CompileError> {
        let inner = at_all(formula, word, beyond.map(RobustnessBounds::negated))?;
        Ok(inner.into_iter().map(RobustnessBounds::negated).collect())
    };
    let constant = |value| vec![value; count];
    Ok(match formula {
        Formula::True => constant(TRUE),
        Formula::False => constant(FALSE),
        Formula::Atom(atom) => (word.atoms.iter())
            .map(|values| {
                values
                    .get(atom.0)
                    .copied()
                    .unwrap_or(RobustnessBounds::UNKNOWN)
            })
            .collect(),
        Formula::Not(inner) => opposite(inner)?,
        Formula::And(operands) => fold(operands, TRUE, RobustnessBounds::min, count, plain)?,
        Formula::Or(operands) => fold(operands, FALSE, RobustnessBounds::max, count, plain)?,
        Formula::Implies(left, right) => zip(opposite(left)?, plain(right)?, RobustnessBounds::max),
        Formula::Iff(left, right) => {
            let both = zip(plain(left)?, plain(right)?, RobustnessBounds::min);
            let neither = zip(opposite(left)?, opposite(right)?, RobustnessBounds::min);
            zip(both, neither, RobustnessBounds::max)
        }
        Formula::Next(inner) => {
            let inner = plain(inner)?;
            (1..=count)
                .map(|at| inner.get(at).copied().unwrap_or(beyond.unwrap_or(FALSE)))
                .collect()
        }
        Formula::Previous(inner) => shifted(plain(inner)?, FALSE),
        Formula::Rise(inner) => zip(
            plain(inner)?,
            shifted(opposite(inner)?, TRUE),
            RobustnessBounds::min,
        ),
        Formula::Fall(inner) => zip(
            opposite(inner)?,
            shifted(plain(inner)?, TRUE),
            RobustnessBounds::min,
        ),
        Formula::Eventually(interval, inner) => until(
            word,
            interval.window(TimeModel::Discrete)?,
            &constant(TRUE),
            &plain(inner)?,
            beyond,
        ),
        Formula::Until(interval, left, right) => until(
            word,
            interval.window(TimeModel::Discrete)?,
            &plain(left)?,
            &plain(right)?,
            beyond,
        ),
        Formula::Once(interval, inner) => since(
            word,
            interval.window(TimeModel::Discrete)?,
            &constant(TRUE),
            &plain(inner)?,
        ),
        Formula::Since(interval, left, right) => since(
            word,
            interval.window(TimeModel::Discrete)?,
            &plain(left)?,
            &plain(right)?,
        ),
        Formula::Always(..)
        | Formula::Historically(..)
        | Formula::Release(..)
        | Formula::WeakUntil(..) => at_all(&by_definition(formula), word, beyond)?,
    })
}

/// The operators that are defined by others, in terms of those.
fn by_definition(formula: &Formula) -> Formula {
    let not = |inner: &Formula| Box::new(Formula::not(inner.clone()));
    match formula {
        Formula::Always(interval, inner) => {
            Formula::not(Formula::Eventually(*interval, not(inner)))
        }
        Formula::Historically(interval, inner) => {
            Formula::not(Formula::Once(*interval, not(inner)))
        }
        Formula::Release(interval, left, right) => {
            Formula::not(Formula::Until(*interval, not(left), not(right)))
        }
        Formula::WeakUntil(interval, left, right) => {
            let either = Formula::or(left.as_ref().clone(), right.as_ref().clone());
            Formula::Release(*interval, right.clone(), Box::new(either))
        }
        other => other.clone(),
    }
}

fn zip(
    left: Values,
    right: Values,
    combine: fn(RobustnessBounds, RobustnessBounds) -> RobustnessBounds,
) -> Values {
    left.into_iter()
        .zip(right)
        .map(|(left, right)| combine(left, right))
        .collect()
}

fn fold(
    operands: &[Formula],
    neutral: RobustnessBounds,
    combine: fn(RobustnessBounds, RobustnessBounds) -> RobustnessBounds,
    count: usize,
    values: impl Fn(&Formula) -> Result<Values, CompileError>,
) -> Result<Values, CompileError> {
    operands
        .iter()
        .try_fold(vec![neutral; count], |sum, operand| {
            Ok(zip(sum, values(operand)?, combine))
        })
}

/// The value one sample before, and `first` at the first sample.
fn shifted(values: Values, first: RobustnessBounds) -> Values {
    let count = values.len();
    std::iter::once(first).chain(values).take(count).collect()
}

fn until(
    word: &Word,
    window: Window,
    left: &[RobustnessBounds],
    right: &[RobustnessBounds],
    beyond: Beyond,
) -> Values {
    let count = word.times_secs.len();
    let at = |at: usize| {
        let mut best = FALSE;
        for end in (at..count).filter(|&end| contains(word, window, at, end)) {
            let held = left[at..end]
                .iter()
                .copied()
                .fold(TRUE, RobustnessBounds::min);
            best = best.max(held.min(right[end]));
        }
        match beyond {
            Some(beyond) if !is_over(word, window, at, count) => {
                let held = left[at..].iter().copied().fold(TRUE, RobustnessBounds::min);
                best.max(held.min(beyond))
            }
            _ => best,
        }
    };
    (0..count).map(at).collect()
}

fn since(
    word: &Word,
    window: Window,
    left: &[RobustnessBounds],
    right: &[RobustnessBounds],
) -> Values {
    let at = |at: usize| {
        let mut best = FALSE;
        for end in (0..=at).filter(|&end| contains(word, window, end, at)) {
            let held = left[end + 1..=at]
                .iter()
                .copied()
                .fold(TRUE, RobustnessBounds::min);
            best = best.max(held.min(right[end]));
        }
        best
    };
    (0..word.times_secs.len()).map(at).collect()
}

/// Whether two samples are as far apart as `window` says.
fn contains(word: &Word, window: Window, earlier: usize, later: usize) -> bool {
    let at_least = match window {
        Window::Samples { low, .. } => (later - earlier) as u64 >= low,
        Window::Seconds { low_secs, .. } => {
            let distance_secs = word.times_secs[later] - word.times_secs[earlier];
            distance_secs >= low_secs - tolerance_secs(word.times_secs[later])
        }
    };
    let at_most = match window {
        Window::Samples { high, .. } => high.is_none_or(|high| (later - earlier) as u64 <= high),
        Window::Seconds { high_secs, .. } => {
            let distance_secs = word.times_secs[later] - word.times_secs[earlier];
            distance_secs <= high_secs + tolerance_secs(word.times_secs[later])
        }
    };
    at_least && at_most && !is_over(word, window, earlier, later)
}

/// Whether the window seen from `at` has ended at one of the samples before `end`, and in seconds at
/// one of an earlier instant.
fn is_over(word: &Word, window: Window, at: usize, end: usize) -> bool {
    let end_secs = word.times_secs.get(end).copied().unwrap_or(f64::INFINITY);
    (at..end).any(|sample| match window {
        Window::Samples { high, .. } => high.is_some_and(|high| (sample - at) as u64 >= high),
        Window::Seconds { high_secs, .. } => {
            let time_secs = word.times_secs[sample];
            let distance_secs = time_secs - word.times_secs[at];
            time_secs < end_secs && distance_secs >= high_secs - tolerance_secs(time_secs)
        }
    })
}

/// How exactly a time is known, in seconds.
fn tolerance_secs(time_secs: f64) -> f64 {
    1e-9_f64.max(4.0 * f64::EPSILON * time_secs.abs())
}
