//! What a scheduler does along the most probable path that shows, or fails, what a property asks for.
//!
//! *Definition.* In the chain that the scheduler induces, and for a formula `left U right` (within steps, or negated, and
//! so `F`, `G`, `W` and `R`):
//!
//! ```text
//! shown by the until   the most probable path through states of `left` to one of `right`
//! failed               the most probable path through states of `left & !right` to one from which `right` is no longer
//!                      reached through `left`; only without a bound in steps
//! ```
//!
//! Almost every run of a finite chain ends in one of the two sorts of states, so that a formula which fails with some
//! probability has such a path. Other formulas have none here.
//!
//! Method and source: [`crate::paths`] (Dijkstra; Han, Katoen and Damman 2009). Cost: linear, and Dijkstra's search.
//! Guarantee: that of [`most_probable_path`] in the chain that is induced.

use prism_lang::property::Property;

use super::Scheduler;
use crate::answer::{CheckError, Options};
use crate::engine::Sound;
use crate::evaluate::Evaluator;
use crate::paths::{Path, most_probable_path};
use crate::shape::{Shape, read_path, shape};
use crate::state_space::StateSpace;
use crate::witness::{only_through, path_of};

/// A path under a scheduler.
#[derive(Debug, Clone, PartialEq)]
pub struct ScheduledPath {
    /// The states, by their numbers in the model's state space.
    pub states: Vec<usize>,
    /// The row of the matrix that is taken in each state but the last.
    pub rows: Vec<usize>,
    /// The probability of the path under the scheduler.
    pub probability: f64,
}

impl Scheduler {
    /// The most probable path that satisfies what `property` asks (if `satisfies`), or violates it; `None` if there is none
    /// or the formula has no such path (see the module).
    ///
    /// # Errors
    /// See [`CheckError`].
    ///
    /// ```
    /// use checker::explore::explore;
    /// use checker::Options;
    /// use checker::scheduler::scheduler;
    /// use prism_lang::{Constants, parse_model, parse_properties, resolve, resolve_properties};
    /// // Hurrying may spill, and then the cup is never brought.
    /// let text = "mdp module m x : [0..2];
    ///   [hurry] x=0 -> 0.3:(x'=1) + 0.7:(x'=2); [walk] x=0 -> 0.1:(x'=1) + 0.9:(x'=2); [] x>0 -> true; endmodule";
    /// let model = resolve(&parse_model(text).tree, &Constants::new()).unwrap();
    /// let asked = parse_properties("Pmin=? [ F x=2 ]").tree;
    /// let asked = &resolve_properties(&asked, &model, &Constants::new()).unwrap()[0].property;
    /// let space = explore::<f64>(&model)?;
    /// let options = Options::default();
    /// let worst = scheduler(&space, asked, &options)?;
    /// let path = worst.path(&space, asked, false, &options)?.expect("it fails");
    /// let action = space.action(path.rows[0]).map(|action| space.actions()[action].as_str());
    /// assert_eq!((action, path.probability), (Some("hurry"), 0.3));
    /// assert_eq!(space.value(path.states[1], 0), 1);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn path(
        &self,
        space: &StateSpace<f64>,
        property: &Property,
        satisfies: bool,
        options: &Options<'_>,
    ) -> Result<Option<ScheduledPath>, CheckError> {
        let Some(formula) = path_of(property) else {
            return Ok(None);
        };
        let chain = self.induced(space);
        let mut sets = Vec::new();
        let mut evaluator = Evaluator::<Sound>::new(&chain, options)?;
        let Ok(formula) = read_path(formula, &mut sets, &mut |f| evaluator.set(f)) else {
            return Ok(None);
        };
        let states = chain.num_states();
        let Some(Shape::Until {
            left,
            right,
            steps,
            contrary,
        }) = shape(&formula.simplify(), &sets, states)
        else {
            return Ok(None);
        };
        let passable: Vec<bool> = (0..states).map(|s| left[s] && !right[s]).collect();
        let through = only_through(&chain, &passable);
        let goal = match contrary != satisfies {
            true => right,
            false if steps != (0, None) => return Ok(None),
            false => lost(&through, right),
        };
        let Some(path) = most_probable_path(&through, &goal) else {
            return Ok(None);
        };
        let length = path.states.len() as u64 - 1;
        if steps.0 > length || steps.1.is_some_and(|last| length > last) {
            return Ok(None);
        }
        Ok(Some(self.of_model(space, &path)))
    }

    /// A path of the induced chain as one of the model.
    fn of_model(&self, space: &StateSpace<f64>, path: &Path<f64>) -> ScheduledPath {
        let steps = path.states.windows(2);
        let (states, rows) = match self {
            Self::ByState(chosen) => {
                let reached = space.reached_by(chosen);
                let states: Vec<usize> = path.states.iter().map(|state| reached[*state]).collect();
                let rows = steps.map(|step| space.row_of(chosen, reached[step[0]]));
                let rows = rows.collect();
                (states, rows)
            }
            Self::WithMemory(memory) => {
                let row = |step: &[usize]| {
                    let moves = &memory.nodes[step[0]].moves;
                    let leads = moves
                        .iter()
                        .find(|taken| taken.next.contains(&(step[1] as u32)));
                    leads.unwrap_or(&moves[0]).row
                };
                let states = path.states.iter().map(|node| memory.nodes[*node].state);
                (states.collect(), steps.map(row).collect())
            }
        };
        ScheduledPath {
            states,
            rows,
            probability: path.probability,
        }
    }
}

/// The states from which none of `right` is reached.
fn lost(chain: &StateSpace<f64>, right: Vec<bool>) -> Vec<bool> {
    let states = chain.num_states();
    let mut before: Vec<Vec<usize>> = vec![Vec::new(); states];
    for state in 0..states {
        for (target, probability) in chain.matrix.row(state) {
            if *probability > 0.0 {
                before[target].push(state);
            }
        }
    }
    let mut open: Vec<usize> = (0..states).filter(|state| right[*state]).collect();
    let mut reaches = right;
    while let Some(state) = open.pop() {
        for from in &before[state] {
            if !std::mem::replace(&mut reaches[*from], true) {
                open.push(*from);
            }
        }
    }
    reaches.iter().map(|reaches| !reaches).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::explore::explore;
    use crate::scheduler::scheduler;
    use prism_lang::{Constants, parse_model, parse_properties, resolve, resolve_properties};

    /// The actions and the probability of the worst path.
    fn worst(text: &str, asked: &str, satisfies: bool) -> Option<(Vec<String>, f64)> {
        let model = resolve(&parse_model(text).tree, &Constants::new()).expect("a model");
        let asked = parse_properties(asked).tree;
        let asked = resolve_properties(&asked, &model, &Constants::new()).expect("properties");
        let space = explore::<f64>(&model).expect("states");
        let options = Options::default();
        let found = scheduler(&space, &asked[0].property, &options).expect("a scheduler");
        let of = &asked.last().expect("a property").property;
        let path = found
            .path(&space, of, satisfies, &options)
            .expect("no error")?;
        let actions = path.rows.iter().map(|row| {
            let action = space.action(*row).map(|action| &space.actions()[action]);
            action.cloned().unwrap_or_default()
        });
        Some((actions.collect(), path.probability))
    }

    const ERRAND: &str = "mdp module m x : [0..4];
        [look] x=0 -> (x'=1); [go] x=0 -> 0.5:(x'=2) + 0.5:(x'=3);
        [go] x=1 -> 0.1:(x'=2) + 0.9:(x'=3); [rest] x=3 -> (x'=3); [] x=2 -> true; endmodule";

    #[test]
    fn a_goal_fails_where_it_is_reached_no_more_and_safety_where_it_breaks() {
        // Going without a look.
        let (actions, probability) = worst(ERRAND, "Pmin=? [ G x!=2 ]", false).expect("a path");
        assert_eq!((actions, probability), (vec!["go".to_owned()], 0.5));
        // Looking and then resting for ever fails to reach 2.
        let (actions, probability) = worst(ERRAND, "Pmin=? [ F x=2 ]", false).expect("a path");
        assert_eq!(actions, ["look", "go"]);
        assert!((probability - 0.9).abs() < 1e-12);
        let (actions, _) = worst(ERRAND, "Pmax=? [ F x=2 ]", true).expect("a path");
        assert_eq!(actions, ["go"]);
    }

    #[test]
    fn schedulers_with_memory_have_paths_and_bounded_goals_none_that_fails() {
        let within = "Pmax=? [ F<=3 x=2 ]";
        let (actions, probability) = worst(ERRAND, within, true).expect("a path");
        assert_eq!((actions, probability), (vec!["go".to_owned()], 0.5));
        assert_eq!(worst(ERRAND, "Pmin=? [ F<=3 x=2 ]", false), None);
        // Given that the robot looks: the scheduler of the conditional probability.
        let given = "Pmin=? [ (G x!=2) || (F x=1) ]; Pmin=? [ G x!=2 ]";
        let (actions, _) = worst(ERRAND, given, false).expect("a path");
        assert!(actions.contains(&"look".to_owned()), "{actions:?}");
    }
}
