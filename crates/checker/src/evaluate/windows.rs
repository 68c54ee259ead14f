//! Path formulas of several operators, some of them with bounds in continuous time.
//!
//! The probability of acceptance of the joint chain of [`crate::windows`], backward: after the last end of a window that of
//! reaching a bottom component that accepts; in each segment before, the mean of what comes after it, by uniformisation. Where
//! only acceptance, or only the contrary, can be reached, the probability is known without rounding. Guarantee: that of
//! [`crate::transient`] and of the engine's unbounded reachability.

use prism_lang::Number;
use prism_lang::property::Path;
use temporal::automaton::{Automaton, DEFAULT_STATE_LIMIT};
use temporal::ltl::Ltl;

use super::timed::{NESTED, Timed, transient_failed};
use super::{Evaluator, embedded};
use crate::amount::Amount;
use crate::answer::CheckError;
use crate::choices::Choices;
use crate::engine::{Context, Numbers};
use crate::graph::Backward;
use crate::rounding::{Bounds, UNIT};
use crate::shape::{letters, read_path};
use crate::state_space::Csr;
use crate::transient::{Sum, Transient};
use crate::windows::{Condition, MOST_WINDOWS, Process, Segment, Window};

/// What a formula is made of.
#[derive(Default)]
struct Parts {
    windows: Vec<Window>,
    untimed: Vec<Ltl>,
    /// The sets of states that the formulas without bounds speak of.
    sets: Vec<Vec<bool>>,
}

impl<E: Numbers> Evaluator<'_, E> {
    /// The probabilities of a formula of which some operators have bounds in time, in the states `from`.
    pub(super) fn in_windows(
        &mut self,
        path: &Path,
        from: &[usize],
    ) -> Result<Vec<E::Value>, CheckError> {
        // The contrary of what is computed has its digits, too.
        if let Path::Not(inner) = path {
            let values = self.in_windows(inner, from)?;
            return Ok(values.iter().map(E::contrary).collect());
        }
        let mut parts = Parts::default();
        let condition = self.condition(path, &mut parts)?;
        if parts.windows.len() > MOST_WINDOWS {
            return Err(CheckError::Unsupported(format!(
                "a formula has {} operators with bounds in time, more than {MOST_WINDOWS}",
                parts.windows.len()
            )));
        }
        let options = self.context.options;
        let limit = options.product_limit.min(DEFAULT_STATE_LIMIT);
        let automata = (parts.untimed.iter())
            .map(|formula| Automaton::with_state_limit(formula, limit))
            .collect::<Result<Vec<_>, _>>()?;
        let letters = letters(&parts.sets, self.space.num_states());
        let rates = &self.space.matrix;
        let mut process = Process::new(rates, &parts.windows, &condition, automata, &letters);
        let (segments, accepting) = process.unfold(from, options)?;
        let largest = segments.iter().map(|s| s.rates.num_rows()).max();
        self.product_states = self.product_states.max(largest);
        self.accepted(&segments, &accepting)
    }

    fn condition(&mut self, path: &Path, parts: &mut Parts) -> Result<Condition, CheckError> {
        if !path.has_time_bound() {
            let formula = read_path(path, &mut parts.sets, &mut |f| self.set(f))?.simplify();
            return Ok(Condition::Untimed(place(&mut parts.untimed, formula)));
        }
        if let Path::Timed { .. } = path
            && let Some(timed) = self.read_timed(path)?
        {
            let contrary = timed.contrary;
            let window = Condition::Window(place(&mut parts.windows, window(timed)));
            return Ok(if contrary { not(window) } else { window });
        }
        let and = |a, b| Condition::And(Box::new(a), Box::new(b));
        let or = |a, b| Condition::Or(Box::new(a), Box::new(b));
        let mut read = |path: &Path| self.condition(path, parts);
        Ok(match path {
            Path::Not(inner) => not(read(inner)?),
            Path::And(a, b) => and(read(a)?, read(b)?),
            Path::Or(a, b) => or(read(a)?, read(b)?),
            Path::Implies(a, b) => or(not(read(a)?), read(b)?),
            Path::Iff(a, b) => {
                let (a, b) = (read(a)?, read(b)?);
                or(and(a.clone(), b.clone()), and(not(a), not(b)))
            }
            _ => return Err(CheckError::Unsupported(NESTED.to_owned())),
        })
    }

    /// The probabilities of acceptance in the states in which the first segment is entered.
    fn accepted(
        &mut self,
        segments: &[Segment<E::Entry>],
        accepting: &[bool],
    ) -> Result<Vec<E::Value>, CheckError> {
        let longest = segments.iter().flat_map(|s| s.rates.row_start.windows(2));
        let longest = longest.map(|ends| ends[1] - ends[0]).max().unwrap_or(0);
        // Rates of which the automata see no difference were added.
        let context = Context {
            entry_error: self.context.entry_error + (longest + 2) as f64 * UNIT,
            ..self.context
        };
        let Some((last, before)) = segments.split_last() else {
            return Ok(Vec::new());
        };
        let everywhere = vec![true; accepting.len()];
        let steps = (0, None);
        let chain = embedded(&last.rates);
        let (settled, rounds) = E::until(&chain, &everywhere, accepting, steps, None, &context)?;
        self.iterations += rounds;
        if before.is_empty() {
            let entered = last.entered.iter();
            return Ok(entered
                .map(|state| settled[*state as usize].clone())
                .collect());
        }
        let mut values: Vec<Bounds> = (settled.iter())
            .map(|value| E::amount(value).bounds())
            .collect();
        let mut next = last;
        for segment in before.iter().rev() {
            let rates = E::floats(&segment.rates).ok_or_else(transient_failed)?;
            let after: Vec<Bounds> = (next.entered.iter())
                .map(|state| values[*state as usize])
                .collect();
            let mut asked: Vec<usize> = segment.entered.iter().map(|s| *s as usize).collect();
            asked.sort_unstable();
            asked.dedup();
            let length = segment.length.unwrap_or(Bounds::ZERO);
            values = carried_back(rates, &after, &length, &asked, &context)?;
            next = segment;
        }
        let value = |state: &u32| E::probability(&E::from_bounds(values[*state as usize]));
        Ok(next.entered.iter().map(value).collect())
    }
}

/// Probabilities a time earlier, in the states asked for; the first two states keep theirs.
fn carried_back(
    rates: &Csr<f64>,
    after: &[Bounds],
    length: &Bounds,
    asked: &[usize],
    context: &Context<'_>,
) -> Result<Vec<Bounds>, CheckError> {
    let backward = Backward::new(Choices::new(rates, &[]));
    let leads_to = |set: &dyn Fn(&Bounds) -> bool| {
        let set: Vec<bool> = after.iter().map(set).collect();
        backward.reaching(&set, |_| true, |_| true).0
    };
    let may_hold = leads_to(&|value| value.high > 0.0);
    let may_fail = leads_to(&|value| value.low < 1.0);
    let is_open = |state: usize| may_hold[state] && may_fail[state];
    let mut start = after.to_vec();
    for (state, value) in start.iter_mut().enumerate() {
        if !is_open(state) {
            *value = Bounds::indicator(may_hold[state]);
        }
    }
    let asked: Vec<usize> = asked.iter().copied().filter(|s| is_open(*s)).collect();
    let transient = Transient {
        rates,
        active: (0..after.len()).map(is_open).collect(),
        context,
        from: &asked,
        keys: &|| None,
    };
    let values = transient.solve(&start, length, Sum::Final)?;
    let capped = |value: &Bounds| Bounds {
        low: value.low.min(1.0),
        high: value.high.min(1.0),
    };
    Ok(values.iter().map(capped).collect())
}

fn window(timed: Timed) -> Window {
    let begin = timed.interval.lower.map(|(time, _)| time);
    Window {
        left: timed.left,
        right: timed.right,
        begin: begin.unwrap_or_else(|| Number::from_i64(0)),
        end: timed.interval.upper.map(|(time, _)| time),
    }
}

fn not(condition: Condition) -> Condition {
    Condition::Not(Box::new(condition))
}

/// The place of something in a list that has each but once.
fn place<T: PartialEq>(list: &mut Vec<T>, new: T) -> usize {
    list.iter()
        .position(|known| *known == new)
        .unwrap_or_else(|| {
            list.push(new);
            list.len() - 1
        })
}
