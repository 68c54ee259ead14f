//! Values a number of steps earlier, with bounds, in plain floating point.
//!
//! *Method.* `x'_i = opt over c of  r_c + sum_j p_cj x_j` on the active states, `k` times, rounded to nearest, within the cone of the
//! states asked for ([`crate::cone`]). Probabilities go side by side with those of the contrary, whose optimum is the other one.
//! Lower and upper bounds are two runs, or one if they are equal, or nearly so, at the start.
//!
//! *Guarantee.* All terms are positive, so each step multiplies the relative error by at most `1 + e + (r + 1) u`,
//! with `e` that of the transition probabilities and `r` the longest row; an optimum of numbers adds none. After `k` steps it is at
//! most `k (e + (r + 1) u)` to first order, which holds as long as no value becomes so small that digits are lost. That
//! is watched: nothing is returned then, and the caller allows for rounding at each step instead. States that are not asked for
//! get the bounds that always hold.
//!
//! Source: the matrix-vector iteration of Hansson and Jonsson 1994; error bound as in [`crate::rounding`].
//!
//! *Stopped* after `j` of `k` steps ([`crate::stop`]), `x_k` is `x_j` carried back over the `k - j` steps left, each of which
//! takes means and earns at least `r-` and at most `r+`: it is between the least and the greatest `x_j` of the states that still
//! matter, plus `k - j` times `r-` (0, where states keep their values) or `r+`. Where the active states began with the least of
//! all values (with 0; the contrary with 1, the greatest), values only grow with the steps (fall), so that the state's own
//! `x_j` bounds them, too.
//!
//! Cost: steps times transitions of the states within the cone. Ends early when nothing changes.

use crate::answer::CheckError;
use crate::choices::Choices;
use crate::cone::{Cone, Walk};
use crate::engine::Context;
use crate::optimum::sound::widened;
use crate::rounding::{Bounds, SMALL_SPREAD, SMALLEST_VALUE, UNIT, spread};
use crate::sound::Probability;

/// What is asked: values of the active states (others keep theirs) this many steps earlier.
#[derive(Debug)]
pub(crate) struct Back<'a, N> {
    pub choices: Choices<'a, N>,
    pub active: &'a [bool],
    pub steps: u64,
    /// The states whose values are asked for; all if not given.
    pub from: Option<&'a [usize]>,
    pub maximise: bool,
}

impl Back<'_, f64> {
    fn from(&self) -> Vec<usize> {
        match self.from {
            Some(from) => from.to_vec(),
            None => (0..self.active.len()).collect(),
        }
    }

    fn steps(&self) -> usize {
        // More are not taken before nothing changes any more, or ever.
        usize::try_from(self.steps).unwrap_or(usize::MAX)
    }

    fn entries(&self) -> impl Fn(usize, usize, &mut Vec<(u32, f64)>) {
        |_, row, entries| {
            let own = self.choices.matrix.row(row);
            entries.extend(own.map(|(target, p)| (target as u32, *p)));
        }
    }

    /// Probabilities; nothing on underflow.
    pub fn probabilities(
        &self,
        values: &[Probability],
        context: &Context<'_>,
    ) -> Result<Option<Vec<Probability>>, CheckError> {
        let from = self.from();
        let support: Vec<bool> = values.iter().map(|v| v.value.high > 0.0).collect();
        let walk = |value: &dyn Fn(usize) -> [f64; 2]| {
            let support = Some(&support[..]);
            let cone = Cone::new(self.choices, self.active, &from, support, self.steps());
            let maximise = [self.maximise, !self.maximise];
            let entries = self.entries();
            Walk::new(cone, self.steps(), self.choices, maximise, value, entries)
        };
        let low = |state: usize| [values[state].value.low, values[state].complement.low];
        let high = |state: usize| [values[state].value.high, values[state].complement.high];
        let Some(walked) = self.run(walk(&low), context)? else {
            return Ok(None);
        };
        let is_exact = |v: &Probability| v.value.is_exact() && v.complement.is_exact();
        let highs = match values.iter().all(is_exact) {
            true => None,
            false => match self.run(walk(&high), context)? {
                Some(highs) => Some(highs),
                None => return Ok(None),
            },
        };
        let error = self.error(&walked.walk, context);
        let none_yet = |lane: fn(&Probability) -> Bounds, end: f64| {
            let mut active = values
                .iter()
                .zip(self.active)
                .filter(|(_, active)| **active);
            active.all(|(value, _)| lane(value) == Bounds::exactly(end))
        };
        let grows = none_yet(|v| v.value, 0.0);
        let falls = none_yet(|v| v.complement, 1.0);
        let (least, greatest) = (walked.least(), highs.as_ref().unwrap_or(&walked).greatest());
        let unknown = Probability::from_value(Bounds {
            low: 0.0,
            high: 1.0,
        });
        let mut result: Vec<Probability> = (values.iter().zip(self.active))
            .map(|(value, active)| if *active { unknown } else { *value })
            .collect();
        for state in from {
            let lows = walked.walk.value(state).unwrap_or_else(|| low(state));
            let highs = match &highs {
                Some(highs) => highs.walk.value(state).unwrap_or_else(|| high(state)),
                None => lows,
            };
            let [mut value, mut complement] = [0, 1].map(|lane| Bounds {
                low: lows[lane],
                high: highs[lane],
            });
            let is_open = walked.walk.value(state).is_some();
            if let (true, Some(least)) = (is_open, least) {
                value.low = if grows { value.low } else { least[0] };
                complement.low = least[1];
            }
            if let (true, Some(greatest)) = (is_open, greatest) {
                value.high = greatest[0];
                complement.high = if falls { complement.high } else { greatest[1] };
            }
            result[state] = match self.active[state] {
                true => Probability::from_sums(value, complement, error),
                false => values[state],
            };
        }
        Ok(Some(result))
    }

    /// Numbers that are not negative and finite, with what each row earns; nothing on underflow, or if some are not.
    pub fn amounts(
        &self,
        rewards: Option<&[Bounds]>,
        values: &[Bounds],
        context: &Context<'_>,
    ) -> Result<Option<Vec<Bounds>>, CheckError> {
        let is_plain = |b: &Bounds| {
            let normal = |x: f64| x == 0.0 || (SMALLEST_VALUE..f64::INFINITY).contains(&x);
            normal(b.low) && normal(b.high)
        };
        let rewards = rewards.filter(|rewards| rewards.iter().any(|r| *r != Bounds::ZERO));
        let all = values.iter().chain(rewards.into_iter().flatten());
        if !all.clone().all(is_plain) {
            return Ok(None);
        }
        let spread = spread(all);
        let is_close = spread <= SMALL_SPREAD;
        let from = self.from();
        let support: Vec<bool> = values.iter().map(|v| v.high > 0.0).collect();
        let support = rewards.is_none().then_some(&support[..]);
        let run = |side: fn(&Bounds) -> f64| {
            let cone = Cone::new(self.choices, self.active, &from, support, self.steps());
            let value = |state: usize| [side(&values[state])];
            let walk = Walk::new(
                cone,
                self.steps(),
                self.choices,
                [self.maximise],
                value,
                self.entries(),
            );
            let walk = match rewards {
                Some(rewards) => walk.with_rewards(self.choices, |row| [side(&rewards[row])]),
                None => walk,
            };
            self.run(walk, context)
        };
        let Some(walked) = run(|b| b.low)? else {
            return Ok(None);
        };
        let highs = match is_close {
            true => None,
            false => match run(|b| b.high)? {
                Some(highs) => Some(highs),
                None => return Ok(None),
            },
        };
        let error = self.error(&walked.walk, context) + if is_close { spread } else { 0.0 };
        let grows = (values.iter().zip(self.active))
            .all(|(value, active)| !active || *value == Bounds::ZERO);
        let (least, greatest) = (walked.least(), highs.as_ref().unwrap_or(&walked).greatest());
        let unknown = Bounds {
            low: 0.0,
            high: f64::INFINITY,
        };
        let mut result: Vec<Bounds> = (values.iter().zip(self.active))
            .map(|(value, active)| if *active { unknown } else { *value })
            .collect();
        for state in from {
            let low = walked.walk.value(state);
            let mut low = low.map_or(values[state].low, |[low]| low);
            let mut high = match &highs {
                Some(highs) => highs
                    .walk
                    .value(state)
                    .map_or(values[state].high, |[high]| high),
                None => low,
            };
            let is_open = walked.walk.value(state).is_some();
            if let (true, Some([least])) = (is_open, least) {
                low = if grows { low } else { least };
            }
            if let (true, Some([greatest])) = (is_open, greatest) {
                high = greatest;
            }
            if self.active[state] {
                result[state] = widened(Bounds { low, high }, error, f64::INFINITY);
            }
        }
        Ok(Some(result))
    }

    /// The relative error, to first order.
    fn error<const W: usize>(&self, walk: &Walk<W>, context: &Context<'_>) -> f64 {
        self.steps as f64 * (context.entry_error + (walk.longest() + 1) as f64 * UNIT)
    }

    fn run<const W: usize>(
        &self,
        mut walk: Walk<W>,
        context: &Context<'_>,
    ) -> Result<Option<Walked<W>>, CheckError> {
        let (steps, mut left) = (self.steps(), 0);
        for step in 0..steps {
            if step % 16 == 0 && context.options.stops()? {
                left = steps - step;
                break;
            }
            let progress = walk.advance();
            if progress.underflow {
                return Ok(None);
            }
            if !progress.changed {
                break;
            }
        }
        Ok(Some(Walked { walk, left }))
    }
}

/// How far a walk came.
struct Walked<const W: usize> {
    walk: Walk<W>,
    /// Steps that were not taken, since the check is to stop.
    left: usize,
}

impl<const W: usize> Walked<W> {
    /// Lower bounds of what the steps left make of the values; nothing if there are none left.
    fn least(&self) -> Option<[f64; W]> {
        // What keeps its value earns nothing.
        let earned = if self.walk.keeps_some() {
            0.0
        } else {
            f64::INFINITY
        };
        self.after([f64::INFINITY, earned], f64::min)
    }

    /// Upper bounds.
    fn greatest(&self) -> Option<[f64; W]> {
        self.after([0.0; 2], f64::max)
    }

    /// The ends of the values and of what is earned, which begin with these.
    fn after(&self, start: [f64; 2], end: fn(f64, f64) -> f64) -> Option<[f64; W]> {
        if self.left == 0 {
            return None;
        }
        let earned = self.walk.earned();
        let mut ends = [0.0; W];
        for (lane, found) in ends.iter_mut().enumerate() {
            let values = self.walk.mattering().map(|values| values[lane]);
            *found = values.fold(start[0], end);
            if !earned.is_empty() {
                let each = earned.iter().map(|earned| earned[lane]);
                *found += self.left as f64 * each.fold(start[1], end);
            }
        }
        Some(ends)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::answer::Options;
    use crate::state_space::Csr;

    /// From each state to the next with probability `p`, else to the failure state at the end.
    fn line(states: usize, p: f64) -> Csr<f64> {
        let mut rows: Vec<Vec<(u32, f64)>> = (0..states - 2)
            .map(|state| vec![(state as u32 + 1, p), (states as u32 - 1, 1.0 - p)])
            .collect();
        rows.push(vec![(states as u32 - 2, 1.0)]);
        rows.push(vec![(states as u32 - 1, 1.0)]);
        Csr::from_rows(rows)
    }

    fn start(states: usize) -> Vec<Probability> {
        (0..states)
            .map(|state| Probability::indicator(state == states - 2))
            .collect()
    }

    fn on_the_line(p: f64, steps: u64, from: Option<&[usize]>) -> Option<Vec<Probability>> {
        let matrix = line(22, p);
        let active: Vec<bool> = (0..22).map(|state| state < 20).collect();
        let back = Back {
            choices: Choices::new(&matrix, &[]),
            active: &active,
            steps,
            from,
            maximise: true,
        };
        let options = Options::default();
        back.probabilities(&start(22), &Context::new(&options, 0.0))
            .unwrap()
    }

    #[test]
    fn bounds_contain_the_power_and_zeros_stay_exact() {
        for from in [None, Some(&[0][..]), Some(&[0, 7][..])] {
            let values = on_the_line(0.5, 20, from).unwrap();
            assert!(values[0].value.contains(0.5f64.powi(20)) && values[0].value.low > 0.0);
            assert!(values[0].value.relative_width() < 1e-13);
            assert!(values[7].value.contains(0.5f64.powi(13)));
            let fewer = on_the_line(0.5, 19, from).unwrap();
            assert_eq!(fewer[0], Probability::indicator(false));
        }
    }

    #[test]
    fn underflow_is_noticed() {
        assert_eq!(on_the_line(1e-20, 20, None), None);
    }

    #[test]
    fn tiny_values_have_bounds_when_stopped_too() {
        use crate::engine::{Engine, Sound};
        let matrix = line(22, 1e-20);
        let everywhere = vec![true; 22];
        let right: Vec<bool> = (0..22).map(|state| state == 20).collect();
        let found = |options: &Options<'_>| {
            let context = Context::new(options, 0.0);
            let steps = (0, Some(50));
            Sound::until(&matrix, &everywhere, &right, steps, None, &context)
                .unwrap()
                .0
        };
        let whole = found(&Options::default());
        assert!(whole[19].value.low > 0.0 && whole[18].value.low > 0.0);
        for asked in 0..4 {
            let count = std::sync::atomic::AtomicUsize::new(0);
            let is_asked = || count.fetch_add(1, std::sync::atomic::Ordering::Relaxed) >= asked;
            let stop = crate::Stop::new(&is_asked);
            let reached = found(&Options {
                stop: Some(&stop),
                ..Options::default()
            });
            for (reached, whole) in reached.iter().zip(&whole) {
                let (a, b) = (reached.value, whole.value);
                assert!(a.low <= b.low && b.high <= a.high, "{asked}: {a:?} {b:?}");
            }
            // What is known already is kept.
            assert!(asked < 2 || reached[18].value.low > 0.0, "{asked}");
        }
    }

    #[test]
    fn the_cone_leaves_out_nothing_that_matters() {
        let (matrix, choice_start) = circle();
        let active: Vec<bool> = (0..40).map(|at| at != 20).collect();
        let values: Vec<Bounds> = (0..40).map(|at| Bounds::indicator(at == 20)).collect();
        let rewards: Vec<Bounds> = (0..120)
            .map(|row| Bounds::exactly(f64::from(row % 4)))
            .collect();
        let options = Options::default();
        let context = Context::new(&options, 0.0);
        for (steps, maximise) in [(6, true), (7, true), (19, false), (60, true), (60, false)] {
            for rewards in [None, Some(&rewards[..])] {
                let found = |from: Option<&[usize]>| {
                    let back = Back {
                        choices: Choices::new(&matrix, &choice_start),
                        active: &active,
                        steps,
                        from,
                        maximise,
                    };
                    back.amounts(rewards, &values, &context).unwrap().unwrap()
                };
                let all = found(None);
                for from in 0..40 {
                    let one = found(Some(&[from]));
                    assert_eq!(one[from], all[from], "{steps} {maximise} {from}");
                }
            }
        }
    }

    /// A walk on a circle of 40 places with two directions to choose from.
    fn circle() -> (Csr<f64>, Vec<usize>) {
        let place = |place: usize, by: usize| ((place + by) % 40) as u32;
        let rows = (0..40).flat_map(|at| {
            let towards = |by: usize| vec![(place(at, by), 0.75), (place(at, 40 - by), 0.25)];
            [towards(1), towards(39), towards(3)]
        });
        let matrix = Csr::from_rows(rows.collect());
        (matrix, (0..=40).map(|at| 3 * at).collect())
    }

    #[test]
    fn bounds_when_stopped_contain_what_more_steps_find() {
        let (matrix, choice_start) = circle();
        let rewards: Vec<Bounds> = (0..120)
            .map(|row| Bounds::exactly(f64::from(row % 4) + 0.5))
            .collect();
        let stays = |at: usize| at == 20 || at == 30;
        let active: Vec<bool> = (0..40).map(|at| !stays(at)).collect();
        // What grows from nothing, what begins anywhere, and what is only known roughly.
        let starts: [fn(usize) -> Bounds; 3] = [
            |at| Bounds::indicator(at == 20),
            |at| Bounds::exactly((at % 7) as f64 / 8.0),
            |at| Bounds {
                low: (at % 7) as f64 / 8.0,
                high: (at % 7 + 1) as f64 / 8.0,
            },
        ];
        let whole = Options::default();
        for (start, steps, maximise) in
            (0..3).flat_map(|start| [(start, 60, true), (start, 60, false), (start, 20, true)])
        {
            let values: Vec<Bounds> = (0..40).map(starts[start]).collect();
            let probabilities: Vec<Probability> =
                values.iter().map(|v| Probability::from_value(*v)).collect();
            for from in [None, Some(&[3][..]), Some(&[11, 19, 20][..])] {
                let back = Back {
                    choices: Choices::new(&matrix, &choice_start),
                    active: &active,
                    steps,
                    from,
                    maximise,
                };
                let found = |options: &Options<'_>| {
                    let context = Context::new(options, 0.0);
                    let earned = |rewards| back.amounts(rewards, &values, &context).unwrap();
                    let plain = back
                        .probabilities(&probabilities, &context)
                        .unwrap()
                        .unwrap();
                    let all = [earned(None).unwrap(), earned(Some(&rewards)).unwrap()];
                    let lanes = plain.iter().map(|p| [p.value, p.complement]);
                    (lanes.flatten().collect::<Vec<_>>(), all)
                };
                let (expected, sums) = found(&whole);
                for asked in 0..8 {
                    let count = std::sync::atomic::AtomicUsize::new(0);
                    let is_asked =
                        || count.fetch_add(1, std::sync::atomic::Ordering::Relaxed) >= asked;
                    let stop = crate::Stop::new(&is_asked);
                    let (reached, reached_sums) = found(&Options {
                        stop: Some(&stop),
                        ..whole
                    });
                    let pairs = reached.iter().zip(&expected);
                    let sums = reached_sums.iter().flatten().zip(sums.iter().flatten());
                    for (at, (reached, whole)) in pairs.chain(sums).enumerate() {
                        assert!(
                            reached.low <= whole.low && whole.high <= reached.high,
                            "{start} {steps} {maximise} {asked} {at}: {reached:?} {whole:?}"
                        );
                    }
                }
            }
        }
    }
}
