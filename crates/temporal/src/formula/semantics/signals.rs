//! Which samples a formula has: from signals that come at their own times to one word.
//!
//! # Definition
//! A *signal* is a sequence of samples (time, value), the times ascending, a value possibly missing. A
//! formula reads some signals and nothing else, so its verdict does not depend on what else was
//! recorded, or judged in the same call.
//!
//! * **Instants.** The instants of a formula are the times at which a signal that it reads has a
//!   sample. At an instant each of them has the value of its latest sample (zero-order hold), and none
//!   before its first.
//! * **Several samples at one instant.** The i-th samples of all signals are taken together; a signal
//!   with fewer keeps its last value. So an instant has as many samples as the signal with most.
//!   `always` and `eventually` see each of them, an interval in seconds holds all or none, `next` and
//!   bounds in samples count each, and what holds afterwards is the last. In dense time, and for stages,
//!   each lasts for a nanosecond (the resolution of times), and the last until the next instant.
//! * **The beginning.** A formula is judged at its first sample. If it is open there, and not all
//!   signals that it reads had a value yet, it is judged from the first sample on at which all have had
//!   one, if that comes within the *start-up limit* of the first.
//!
//! Cost: O(s n) for s signals with n samples in all. This is the oracle for what judges recordings.

use super::{CompileError, Ending, Formula, Verdict, Word, value};

/// One signal: its samples as time in seconds and value, NaN where that is missing.
pub type Signal = Vec<(f64, f64)>;

/// The samples of a formula that reads these signals: time, and the value of each signal.
#[must_use]
pub fn samples(signals: &[Signal]) -> Vec<(f64, Vec<f64>)> {
    let mut times_secs: Vec<f64> = (signals.iter().flatten()).map(|sample| sample.0).collect();
    times_secs.sort_by(f64::total_cmp);
    times_secs.dedup();
    let mut all = Vec::new();
    for time_secs in times_secs {
        let at = |signal: &Signal| -> Vec<f64> {
            let here = signal.iter().filter(|sample| sample.0 == time_secs);
            here.map(|sample| sample.1).collect()
        };
        let here: Vec<Vec<f64>> = signals.iter().map(at).collect();
        let most = here.iter().map(Vec::len).max().unwrap_or(0);
        for place in 0..most {
            let value = |(signal, here): (&Signal, &Vec<f64>)| {
                let before = signal.iter().rfind(|sample| sample.0 < time_secs);
                let held = before.map_or(f64::NAN, |sample| sample.1);
                let last = here.get(place).or(here.last());
                last.copied().unwrap_or(held)
            };
            all.push((time_secs, signals.iter().zip(&here).map(value).collect()));
        }
    }
    all
}

/// From which sample on a formula is judged if it is open at the first one; `None` if from no other.
#[must_use]
pub fn start(samples: &[(f64, Vec<f64>)], start_within_secs: f64) -> Option<usize> {
    let (first_secs, values) = samples.first()?;
    if !values.iter().any(|value| value.is_nan()) {
        return None;
    }
    let mut had = vec![false; values.len()];
    let place = samples.iter().position(|(_, values)| {
        for (had, value) in had.iter_mut().zip(values) {
            *had |= !value.is_nan();
        }
        had.iter().all(|had| *had)
    })?;
    (samples[place].0 - first_secs <= start_within_secs).then_some(place)
}

/// The verdict on signals in discrete time; `atoms` gives the truth of each atom for values of the
/// signals.
///
/// # Errors
/// [`CompileError`] if an interval makes no sense.
pub fn verdict(
    formula: &Formula,
    signals: &[Signal],
    atoms: &dyn Fn(&[f64]) -> Vec<Option<bool>>,
    ending: Ending,
    start_within_secs: f64,
) -> Result<Verdict, CompileError> {
    let samples = samples(signals);
    let judged = |from: usize| {
        let mut word = Word::default();
        for (time_secs, values) in &samples[from..] {
            word.push_truth(*time_secs, &atoms(values));
        }
        Ok(value(formula, &word, ending)?.verdict())
    };
    match (judged(0)?, start(&samples, start_within_secs)) {
        (Verdict::Inconclusive, Some(from)) => judged(from),
        (verdict, _) => Ok(verdict),
    }
}
