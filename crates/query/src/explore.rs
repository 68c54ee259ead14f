//! The state space of a model, with mistakes at their places.

use checker::explore::{ExploreError, ExploreOptions, explore_with};
use checker::state_space::StateSpace;
use diagnostic::{Problem, Source};
use prism_lang::resolved;

/// Builds the state space of a model whose text is in `source`.
pub fn explore<N: prism_lang::Arithmetic>(
    source: &Source,
    model: &resolved::Model,
    max_states: usize,
    cancel: &dyn Fn() -> bool,
) -> Result<StateSpace<N>, Problem> {
    let limits = ExploreOptions {
        max_states,
        ..ExploreOptions::default()
    };
    explore_within(source, model, limits, &|_| !cancel())
}

/// The same with all limits, and a choice of reward structures; `go_on` is told how many states there are so far.
pub fn explore_within<N: prism_lang::Arithmetic>(
    source: &Source,
    model: &resolved::Model,
    limits: ExploreOptions,
    go_on: &dyn Fn(usize) -> bool,
) -> Result<StateSpace<N>, Problem> {
    explore_with(model, limits, go_on).map_err(|error| {
        if error == ExploreError::Cancelled {
            return Problem::interrupted();
        }
        let problem = Problem::new("cannot-explore", error.to_string());
        let problem = match error {
            ExploreError::TooManyStates { .. } => problem.remedy(
                "make the model smaller, for example by its constants; `check` takes more with --max-states",
            ),
            _ => problem,
        };
        match error.span() {
            Some(span) => problem.at(source, span.start..span.end),
            None => problem,
        }
    })
}
