//! From a model to its reachable states and transitions.
//!
//! Definition: in a state, the choices are the enabled commands without action and, for each action, one
//! enabled command of every module that has commands with that action (in general: the events of `events`).
//! A choice's outcomes are the products of its commands' updates. In an `mdp` or `lts`, choices are what a
//! scheduler chooses from; in a `dtmc` with `k` choices each is taken with probability `1/k`; in a `ctmc` they
//! race: rates of synchronised commands are multiplied, rates of choices add up. Outcomes of probability 0 are
//! dropped, outcomes with the same target are merged (in a chain over all choices, else within a choice), a
//! state without choices gets a self-loop.
//!
//! Source: the semantics of the PRISM language (Kwiatkowska, Norman, Parker, "PRISM 4.0: Verification of
//! Probabilistic Real-time Systems", CAV 2011, and the tool's description of its language); uniform choice in
//! a `dtmc` and `fixdl` are the tool's.
//!
//! Deviation: the probabilities of a command must sum to 1 to within 1e-12 (exactly in an exact domain); the
//! tool allows 1e-5 and rescales. Cost: linear in states times commands, plus transitions; breadth first, so
//! that the numbering of states does not depend on the domain.
//!
//! Guarantee: in `f64`, each entry of the matrix is within the relative error
//! [`StateSpace::relative_error`] of the exact probability; none is lost to underflow.

mod assembly;
mod batch;
pub(crate) mod code;
mod command;
mod error;
mod events;
mod fault;
mod generator;
mod guards;
mod initial;
mod intern;
mod orbits;
mod pipeline;
mod plan;
mod quotient;
mod rewards;

use std::collections::BTreeSet;

use prism_lang::resolved::{Model, ModelType};
use prism_lang::{Arithmetic, Property};

use crate::state_space::{LabelStates, Layout, Represented, StateSpace};
use crate::symmetry::Symmetry;
use assembly::Assembly;
use batch::Batch;
use code::Compiler;
pub use error::ExploreError;
use generator::Generator;
use intern::Interner;

/// How far to explore.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExploreOptions {
    /// More reachable states than this are an error.
    pub max_states: usize,
    /// More bytes than this for states and transitions are an error.
    pub max_bytes: usize,
    /// The reward structures to evaluate, by their index in the model; `None` for all of them.
    pub rewards: Option<Vec<usize>>,
    /// What is done with a `dtmc` whose commands' probabilities do not sum to 1: by default that is an error;
    /// else they are weights, and each state's are divided by their sum (PRISM's switch `-noprobchecks`).
    pub probabilities_are_weights: bool,
    /// Symmetries up to which it is enough to explore: of states that they map to each other one is kept.
    pub symmetry: Symmetry,
    /// How many threads to use, at most two; the state space does not depend on it.
    pub threads: usize,
}

impl Default for ExploreOptions {
    /// At most 100 million states, in memory of any size, with all reward structures, on
    /// as many threads as are useful and there are.
    fn default() -> Self {
        Self {
            max_states: 100_000_000,
            max_bytes: usize::MAX,
            rewards: None,
            probabilities_are_weights: false,
            symmetry: Symmetry::default(),
            threads: rayon::current_num_threads(),
        }
    }
}

impl ExploreOptions {
    /// With the reward structures that these properties speak of.
    pub fn for_properties<'p>(properties: impl IntoIterator<Item = &'p Property>) -> Self {
        let structures = properties.into_iter().map(Property::reward_structures);
        let needed = structures.fold(BTreeSet::new(), |all, of_one| &all | &of_one);
        Self {
            rewards: Some(needed.into_iter().collect()),
            ..Self::default()
        }
    }

    /// Whether the rows of such a model are divided by their sums.
    fn weights(&self, kind: ModelType) -> bool {
        self.probabilities_are_weights && kind == ModelType::Dtmc
    }
}

/// Builds the reachable state space of a model.
///
/// # Errors
/// If the model leaves a variable's range, has probabilities that do not sum to 1, or too many states.
///
/// ```
/// use checker::explore::explore;
/// use prism_lang::{Constants, parse_model, resolve};
/// let text = "dtmc module die x : [0..6]; [] x=0 -> 1/2:(x'=1) + 1/2:(x'=2); endmodule";
/// let model = resolve(&parse_model(text).tree, &Constants::new()).unwrap();
/// let space = explore::<f64>(&model)?;
/// assert_eq!((space.num_states(), space.num_transitions()), (3, 4));
/// assert_eq!(space.deadlocks(), [1, 2]);
/// # Ok::<(), checker::explore::ExploreError>(())
/// ```
pub fn explore<N: Arithmetic>(model: &Model) -> Result<StateSpace<N>, ExploreError> {
    explore_with(model, ExploreOptions::default(), &|_| true)
}

/// Like [`explore`], with limits, and a function that is told the number of states found so far and stops the
/// search by returning `false`.
///
/// # Errors
/// As for [`explore`]; also if the search was stopped.
pub fn explore_with<N: Arithmetic>(
    model: &Model,
    options: ExploreOptions,
    progress: &dyn Fn(usize) -> bool,
) -> Result<StateSpace<N>, ExploreError> {
    if (0..model.parameters.len()).any(|index| N::parameter(index).is_none()) {
        return Err(ExploreError::UnsupportedConstruct(
            "a model with open constants has no numbers: give each constant a value, or explore it with \
             rational functions of at most 16 constants",
        ));
    }
    let layout = Layout::new(&model.variables);
    let compiler = Compiler {
        variables: &model.variables,
        layout: &layout,
    };
    let mut explorer = Explorer::new(model, compiler, options);
    let mut initial = initial::initial_states(&model.init, compiler, progress)?;
    explorer.represented.initial = (initial.len() / compiler.layout.words()) as u64;
    if let Some(orbits) = &mut explorer.generator.orbits {
        orbits.represent(&mut initial);
    }
    explorer.number(&initial, &mut Vec::new())?;
    let num_initial = explorer.interner.len();
    explorer.expand_all(progress)?;
    Ok(explorer.finish(num_initial))
}

struct Explorer<'m, N> {
    options: ExploreOptions,
    model: &'m Model,
    compiler: Compiler<'m>,
    generator: Generator<'m, N>,
    interner: Interner,
    assembly: Assembly<'m, N>,
    /// What the states so far stand for, if there are symmetries.
    represented: Represented,
}

impl<'m, N: Arithmetic> Explorer<'m, N> {
    fn new(model: &'m Model, compiler: Compiler<'m>, options: ExploreOptions) -> Self {
        Self {
            model,
            compiler,
            generator: Generator::new(model, compiler, &options),
            interner: Interner::new(compiler.layout.words()),
            assembly: Assembly::new(model, compiler, &options),
            represented: Represented::default(),
            options,
        }
    }

    /// Numbers the targets of a batch and appends its rows; expands what did not fit into it.
    fn take(&mut self, batch: &mut Batch<N>) -> Result<(), ExploreError> {
        let words = self.compiler.layout.words();
        loop {
            if let Some(error) = batch.error.take() {
                return Err(error);
            }
            let mut numbers = std::mem::take(&mut batch.numbers);
            self.number(&batch.targets, &mut numbers)?;
            batch.numbers = numbers;
            self.assembly.append(batch, words);
            self.represented.add(&batch.represented);
            let limit = self.options.max_bytes;
            if self.interner.bytes() + self.assembly.bytes() > limit {
                return Err(ExploreError::TooMuchMemory {
                    limit,
                    states: self.interner.len(),
                });
            }
            if !batch.keep_rest(words) {
                return Ok(());
            }
            self.generator.fill(batch);
        }
    }

    fn number(&mut self, states: &[u64], numbers: &mut Vec<u32>) -> Result<(), ExploreError> {
        let limit = self.options.max_states.min(u32::MAX as usize - 1);
        let done = self.interner.intern(states, limit, numbers);
        done.ok_or(ExploreError::TooManyStates { limit })
    }

    fn finish(self, num_initial: usize) -> StateSpace<N> {
        let model = self.model;
        let labels = model.labels.iter();
        let labels = labels.map(|(name, body)| (name.clone(), LabelStates::Defined(body.clone())));
        let roundings = self.assembly.roundings();
        let mut assembly = self.assembly;
        if model.model_type.has_choices() {
            assembly.choice_start.push(assembly.matrix.num_rows());
        }
        StateSpace {
            kind: model.model_type,
            matrix: assembly.matrix,
            choice_start: assembly.choice_start,
            choice_action: assembly.choice_action,
            actions: model.actions.clone(),
            rewards: assembly
                .rewards
                .finish(self.interner.len(), model.model_type.has_choices()),
            variables: model.variables.clone(),
            layout: self.compiler.layout.clone(),
            packed: self.interner.packed,
            initial: (0..num_initial).collect(),
            deadlocks: assembly.deadlocks,
            labelled_transitions: assembly.labelled_transitions,
            labels: labels.collect(),
            roundings,
            represented: (self.generator.orbits.is_some()).then_some(self.represented),
        }
    }
}
