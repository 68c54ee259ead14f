//! Probabilities of path formulas.

use prism_lang::property::Path;
use temporal::automaton::{Automaton, DEFAULT_STATE_LIMIT};
use temporal::ltl::Ltl;

use super::Evaluator;
use crate::answer::CheckError;
use crate::choices::Choices;
use crate::engine::{Context, Engine, Numbers};
use crate::fragment::Fragment;
use crate::graph::NO_ROW;
use crate::limit;
use crate::product::{Product, product};
use crate::reachability::{self, Found};
use crate::shape::{Shape, letters, read_path, shape};

impl<E: Numbers> Evaluator<'_, E> {
    /// The greatest (or least) probability of a path formula in the states `from`.
    pub(super) fn probability(
        &mut self,
        path: &Path,
        maximise: bool,
        from: &[usize],
    ) -> Result<Vec<E::Value>, CheckError> {
        if let Some(values) = self.timed(path, from)? {
            return Ok(values);
        }
        if path.has_time_bound() {
            return self.in_windows(path, from);
        }
        let mut sets = Vec::new();
        let formula = read_path(path, &mut sets, &mut |f| self.set(f))?.simplify();
        // An inner operator's is not that of this one.
        self.scheduler = None;
        let states = self.space.num_states();
        let (values, contrary) = match shape(&formula, &sets, states) {
            None => return self.on_product(&formula, &sets, maximise, from),
            Some(Shape::Set(holds)) => {
                return Ok(from.iter().map(|s| E::indicator(holds[*s])).collect());
            }
            Some(Shape::Next { operand, contrary }) => {
                let values = self.next(&operand, maximise != contrary)?;
                let asked = from.iter().map(|state| values[*state].clone());
                (asked.collect::<Vec<_>>(), contrary)
            }
            Some(Shape::Until {
                left,
                right,
                steps,
                contrary,
            }) => (
                self.until_from(&left, &right, steps, from, maximise != contrary)?,
                contrary,
            ),
        };
        let value = |value: &E::Value| match contrary {
            true => E::contrary(value),
            false => value.clone(),
        };
        Ok(values.iter().map(value).collect())
    }

    /// The probability of `left U right` in the states `from`, on that part of the model which matters there.
    fn until_from(
        &mut self,
        left: &[bool],
        right: &[bool],
        steps: (u64, Option<u64>),
        from: &[usize],
        maximise: bool,
    ) -> Result<Vec<E::Value>, CheckError> {
        let may_cut = steps.0 == 0 && !self.context.options.fair;
        let part = match may_cut {
            true => Fragment::new(self.choices(), left, right, from),
            false => None,
        };
        let Some(part) = part else {
            let values = self.until(left, right, steps, Some(from), maximise)?;
            return Ok(from.iter().map(|state| values[*state].clone()).collect());
        };
        let (left, right) = (part.set(left), part.set(right));
        let places: Vec<usize> = from.iter().map(|state| part.place(*state)).collect();
        let from = Some(&places[..]);
        let choices = part.choices();
        let (values, scheduler, rounds) =
            until_on::<E>(choices, &left, &right, steps, from, maximise, &self.context)?;
        self.iterations += rounds;
        self.scheduler = scheduler.map(|own| part.scheduler(&own, self.space.num_states()));
        Ok(places.iter().map(|place| values[*place].clone()).collect())
    }

    fn next(&mut self, operand: &[bool], maximise: bool) -> Result<Vec<E::Value>, CheckError> {
        let choices = self.choices();
        match choices.is_chain() {
            true => Ok(E::next(self.matrix(), operand, &self.context)),
            false => reachability::next::<E>(choices, operand, maximise, &self.context),
        }
    }

    pub(super) fn until(
        &mut self,
        left: &[bool],
        right: &[bool],
        steps: (u64, Option<u64>),
        from: Option<&[usize]>,
        maximise: bool,
    ) -> Result<Vec<E::Value>, CheckError> {
        let choices = self.choices();
        let (values, scheduler, rounds) =
            until_on::<E>(choices, left, right, steps, from, maximise, &self.context)?;
        self.iterations += rounds;
        if !self.choices().is_chain() {
            self.scheduler = scheduler;
        }
        Ok(values)
    }

    fn on_product(
        &mut self,
        formula: &Ltl,
        sets: &[Vec<bool>],
        maximise: bool,
        from: &[usize],
    ) -> Result<Vec<E::Value>, CheckError> {
        // The least probability is that of the contrary's greatest.
        let contrary = !maximise && !self.choices().is_chain();
        let formula = match contrary {
            true => Ltl::negate(formula.clone()).simplify(),
            false => formula.clone(),
        };
        let values = match self.for_ever(&formula, sets, from)? {
            Some(values) => values,
            None => {
                let product = self.product(&formula, sets, from)?;
                let values = self.accepting_values(&product)?;
                let start = product.start.iter();
                start.map(|state| values[*state].clone()).collect()
            }
        };
        let value = |value: &E::Value| match contrary {
            true => E::contrary(value),
            false => value.clone(),
        };
        Ok(values.iter().map(value).collect())
    }

    /// The greatest probability of a formula that speaks only of what happens for ever.
    fn for_ever(
        &mut self,
        formula: &Ltl,
        sets: &[Vec<bool>],
        from: &[usize],
    ) -> Result<Option<Vec<E::Value>>, CheckError> {
        if self.context.options.fair {
            return Ok(None);
        }
        let Some(accepting) = limit::accepting(self.choices(), formula, sets) else {
            return Ok(None);
        };
        let everywhere = vec![true; accepting.len()];
        let values = self.until_from(&everywhere, &accepting, (0, None), from, true)?;
        // What is done in an end component, a choice for each state cannot say.
        self.scheduler = None;
        Ok(Some(values))
    }

    /// The product with the automaton of a formula over sets of states.
    pub(super) fn product(
        &mut self,
        formula: &Ltl,
        sets: &[Vec<bool>],
        from: &[usize],
    ) -> Result<Product<E::Entry>, CheckError> {
        let limit = self.context.options.product_limit.min(DEFAULT_STATE_LIMIT);
        let mut automaton = Automaton::with_state_limit(formula, limit)?;
        let letters = letters(sets, self.space.num_states());
        let options = self.context.options;
        let product = product(self.choices(), &mut automaton, &letters, from, options)?;
        self.product_states = self.product_states.max(Some(product.accepting.len()));
        Ok(product)
    }

    fn accepting_values(
        &mut self,
        product: &Product<E::Entry>,
    ) -> Result<Vec<<E as Engine>::Value>, CheckError> {
        let everywhere = vec![true; product.accepting.len()];
        let choices = product.choices();
        let steps = (0, None);
        if choices.is_chain() {
            let (matrix, target) = (&product.matrix, &product.accepting);
            let (values, rounds) =
                E::until(matrix, &everywhere, target, steps, None, &self.context)?;
            self.iterations += rounds;
            return Ok(values);
        }
        let (values, _, rounds) = reachability::until::<E>(
            choices,
            &everywhere,
            &product.accepting,
            steps,
            None,
            true,
            &self.context,
        )?;
        self.iterations += rounds;
        // A scheduler of the product remembers the automaton's state, which a choice for each state cannot say.
        self.scheduler = None;
        Ok(values)
    }

    /// The scheduler that was found, with no entry where nothing is chosen.
    pub(super) fn found_scheduler(&mut self) -> Option<Vec<Option<usize>>> {
        let scheduler = self.scheduler.take()?;
        let choice = |row: usize| (row != NO_ROW).then_some(row);
        Some(scheduler.into_iter().map(choice).collect())
    }
}

/// `left U right` with the method for chains where there are no choices.
fn until_on<E: Numbers>(
    choices: Choices<'_, E::Entry>,
    left: &[bool],
    right: &[bool],
    steps: (u64, Option<u64>),
    from: Option<&[usize]>,
    maximise: bool,
    context: &Context<'_>,
) -> Result<Found<E::Value>, CheckError> {
    if choices.is_chain() {
        let (values, rounds) = E::until(choices.matrix, left, right, steps, from, context)?;
        return Ok((values, None, rounds));
    }
    reachability::until::<E>(choices, left, right, steps, from, maximise, context)
}
