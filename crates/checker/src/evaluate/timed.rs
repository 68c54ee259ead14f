//! Path formulas with bounds in continuous time.
//!
//! `left U[a,b] right` in a `ctmc`: from time `a` on, `right` within `b - a` while states that end it are left
//! no more; before, for a time `a`, only states of `left` are passed. With `b` infinite the second part is the
//! unbounded probability. Source: Baier, Haverkort, Hermanns and Katoen 2003, section 4. Guarantee: that of
//! [`crate::transient`].

use prism_lang::Number;
use prism_lang::property::{Path, TimeInterval, TimedOperator};

use super::Evaluator;
use crate::amount::Amount;
use crate::answer::CheckError;
use crate::choices::Choices;
use crate::engine::Numbers;
use crate::graph::Backward;
use crate::rounding::Bounds;
use crate::shape::{holds, negation, read_path, weak};
use crate::transient::{Sum, Transient};
use crate::windows::difference;

/// An until formula within an interval of time, or its contrary.
pub(super) struct Timed {
    pub left: Vec<bool>,
    pub right: Vec<bool>,
    pub interval: TimeInterval,
    pub contrary: bool,
}

/// What to do about temporal operators within each other, of which one has a bound in time.
pub(crate) const NESTED: &str = "a temporal operator with a bound in continuous time can neither stand within \
     another one nor contain one (unlike `(F<=5 a) & (G<=7 b)`, which can be computed): write `P` around the inner \
     one if its probability is meant, as in `P>=0.9 [ G P>=0.9 [ F<=5 a ] ]`";

pub(super) fn transient_failed() -> CheckError {
    CheckError::Unsupported(
        "what happens within a time is not a rational number: use the sound method, whose bounds hold".to_owned(),
    )
}

impl<E: Numbers> Evaluator<'_, E> {
    /// The probabilities of a formula with a bound in time, if it is one.
    pub(super) fn timed(
        &mut self,
        path: &Path,
        from: &[usize],
    ) -> Result<Option<Vec<E::Value>>, CheckError> {
        let Some(timed) = self.read_timed(path)? else {
            return Ok(None);
        };
        let rates = E::floats(&self.space.matrix).ok_or_else(transient_failed)?;
        let lower = timed
            .interval
            .lower
            .as_ref()
            .map(|(time, _)| Bounds::literal(time));
        let upper = timed.interval.upper.as_ref().map(|(time, _)| time);
        let start = lower.filter(|time| *time != Bounds::ZERO);
        let backward = Backward::new(Choices::new(rates, &[]));
        let mut values = match upper {
            None => {
                let values = self.until(&timed.left, &timed.right, (0, None), None, true)?;
                values
                    .iter()
                    .map(|value| E::amount(value).bounds())
                    .collect()
            }
            Some(end) => {
                let length = length(&timed.interval, end);
                let asked = if start.is_some() {
                    self.everywhere()
                } else {
                    from.to_vec()
                };
                self.within(&backward, rates, &timed, &length, &asked)?
            }
        };
        if let Some(time) = start {
            for (value, left) in values.iter_mut().zip(&timed.left) {
                if !left {
                    *value = Bounds::ZERO;
                }
            }
            let possible: Vec<bool> = values.iter().map(|value| value.high > 0.0).collect();
            let left = timed.left.clone();
            values = self.pass(&backward, rates, (left, possible), &values, &time, from)?;
        }
        let value = |state: &usize| {
            let Bounds { low, high } = values[*state];
            let value = Bounds {
                low: low.min(1.0),
                high: high.min(1.0),
            };
            let value = E::probability(&E::from_bounds(value));
            if timed.contrary {
                E::contrary(&value)
            } else {
                value
            }
        };
        Ok(Some(from.iter().map(value).collect()))
    }

    /// `left U[0,length] right`.
    fn within(
        &self,
        backward: &Backward,
        rates: &crate::state_space::Csr<f64>,
        timed: &Timed,
        length: &Bounds,
        from: &[usize],
    ) -> Result<Vec<Bounds>, CheckError> {
        let target: Vec<Bounds> = timed.right.iter().map(|r| Bounds::indicator(*r)).collect();
        let pairs = timed.left.iter().zip(&timed.right);
        let active = pairs.map(|(left, right)| *left && !right).collect();
        self.pass(
            backward,
            rates,
            (active, timed.right.clone()),
            &target,
            length,
            from,
        )
    }

    /// The mean of `values` after a time in which only the active states are left; exactly 0 where `possible`
    /// states cannot be reached through them.
    fn pass(
        &self,
        backward: &Backward,
        rates: &crate::state_space::Csr<f64>,
        (active, possible): (Vec<bool>, Vec<bool>),
        values: &[Bounds],
        time: &Bounds,
        from: &[usize],
    ) -> Result<Vec<Bounds>, CheckError> {
        let (reaches, _) = backward.reaching(&possible, |s| active[s], |_| true);
        let asked: Vec<usize> = from.iter().copied().filter(|s| reaches[*s]).collect();
        // The mean of ones is one.
        let may_fail = active
            .iter()
            .zip(values)
            .any(|(a, v)| *a && *v == Bounds::ONE)
            .then(|| {
                let fails: Vec<bool> = values.iter().map(|value| value.low < 1.0).collect();
                backward.reaching(&fails, |s| active[s], |_| true).0
            });
        let is_sure = |s: usize| may_fail.as_ref().is_some_and(|may_fail| !may_fail[s]);
        let asked: Vec<usize> = asked.into_iter().filter(|s| !is_sure(*s)).collect();
        let active: Vec<bool> = (0..active.len())
            .map(|s| active[s] && reaches[s] && !is_sure(s))
            .collect();
        let transient = Transient {
            rates,
            active,
            context: &self.context,
            from: &asked,
            keys: &|| self.space.keys(),
        };
        let mut found = transient.solve(values, time, Sum::Final)?;
        for (state, value) in found.iter_mut().enumerate() {
            if !reaches[state] {
                *value = Bounds::ZERO;
            } else if is_sure(state) {
                *value = Bounds::ONE;
            } else if !transient.active[state] {
                *value = values[state];
            }
        }
        Ok(found)
    }

    /// One operator with a bound in time, between state formulas, or its negation.
    pub(super) fn read_timed(&mut self, path: &Path) -> Result<Option<Timed>, CheckError> {
        if let Path::Not(inner) = path {
            let timed = self.read_timed(inner)?;
            return Ok(timed.map(|timed| Timed {
                contrary: !timed.contrary,
                ..timed
            }));
        }
        let Path::Timed {
            operator,
            left,
            right,
            interval,
        } = path
        else {
            return Ok(None);
        };
        let states = self.space.num_states();
        let right = self.operand(right)?;
        let left = match left {
            Some(left) => self.operand(left)?,
            None => vec![true; states],
        };
        let (left, right, contrary) = match operator {
            TimedOperator::Until | TimedOperator::Finally => (left, right, false),
            TimedOperator::Globally => (left, negation(right), true),
            TimedOperator::Release => (negation(left), negation(right), true),
            TimedOperator::WeakUntil => {
                let (waiting, given_up) = weak(&left, &right);
                (waiting, given_up, true)
            }
        };
        let interval = interval.clone();
        Ok(Some(Timed {
            left,
            right,
            interval,
            contrary,
        }))
    }

    /// The states of an operand without temporal operators.
    fn operand(&mut self, path: &Path) -> Result<Vec<bool>, CheckError> {
        let mut sets = Vec::new();
        let formula = read_path(path, &mut sets, &mut |f| self.set(f))?.simplify();
        if !formula.is_propositional() {
            return Err(CheckError::Unsupported(NESTED.to_owned()));
        }
        Ok(holds(&formula, &sets, self.space.num_states()))
    }
}

/// The length of an interval with an end.
fn length(interval: &TimeInterval, end: &Number) -> Bounds {
    let Some((start, _)) = &interval.lower else {
        return Bounds::literal(end);
    };
    difference(start, end)
}
