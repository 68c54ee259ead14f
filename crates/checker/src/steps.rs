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
        let Some(lows) = self.run(walk(&low), context)? else {
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
        let error = self.error(&lows, context);
        let unknown = Probability::from_value(Bounds {
            low: 0.0,
            high: 1.0,
        });
        let mut result: Vec<Probability> = (values.iter().zip(self.active))
            .map(|(value, active)| if *active { unknown } else { *value })
            .collect();
        for state in from {
            let lows = lows.value(state).unwrap_or_else(|| low(state));
            let highs = match &highs {
                Some(highs) => highs.value(state).unwrap_or_else(|| high(state)),
                None => lows,
            };
            let [value, complement] = [0, 1].map(|lane| Bounds {
                low: lows[lane],
                high: highs[lane],
            });
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
        let Some(lows) = run(|b| b.low)? else {
            return Ok(None);
        };
        let highs = match is_close {
            true => None,
            false => match run(|b| b.high)? {
                Some(highs) => Some(highs),
                None => return Ok(None),
            },
        };
        let error = self.error(&lows, context) + if is_close { spread } else { 0.0 };
        let unknown = Bounds {
            low: 0.0,
            high: f64::INFINITY,
        };
        let mut result: Vec<Bounds> = (values.iter().zip(self.active))
            .map(|(value, active)| if *active { unknown } else { *value })
            .collect();
        for state in from {
            let low = lows.value(state).map_or(values[state].low, |[low]| low);
            let high = match &highs {
                Some(highs) => highs.value(state).map_or(values[state].high, |[high]| high),
                None => low,
            };
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
    ) -> Result<Option<Walk<W>>, CheckError> {
        for step in 0..self.steps {
            if step % 16 == 0 {
                context.options.check_cancelled()?;
            }
            let progress = walk.advance();
            if progress.underflow {
                return Ok(None);
            }
            if !progress.changed {
                break;
            }
        }
        Ok(Some(walk))
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
    fn the_cone_leaves_out_nothing_that_matters() {
        // A walk on a circle of 40 places with two directions to choose from, and a target opposite.
        let place = |place: usize, by: usize| ((place + by) % 40) as u32;
        let rows = (0..40).flat_map(|at| {
            let towards = |by: usize| vec![(place(at, by), 0.75), (place(at, 40 - by), 0.25)];
            [towards(1), towards(39), towards(3)]
        });
        let matrix = Csr::from_rows(rows.collect());
        let choice_start: Vec<usize> = (0..=40).map(|at| 3 * at).collect();
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
}
