//! Schedulers over the model's states, with the memory that they need, of every kind of question.
//!
//! *Definition.* A scheduler with finite memory takes in state `s` with memory `m` a choice, and has the memory
//! `m'(s, m, t)` after a step to `t`. What the memory says depends on the question:
//!
//! ```text
//! F, G, U, R[F], R[C], R[S]      nothing: the state is enough
//! X, bounds in steps, C<=k, I=k  how many steps were taken, as long as they count       [`countdown`]
//! other LTL, co-safe rewards,    where the automata are; in an accepting end component also which of the
//! conditional probabilities      transitions that must recur is taken next               [`tour`]
//! several objectives             which of the pure schedulers was drawn in the beginning, and its memory
//! ```
//!
//! A scheduler of a model is found on a product with the memory, and unfolded here from the initial states. Applied, it
//! gives a chain ([`Scheduler::induced`]) whose states have the model's variables and, last, the memory; checking the
//! same question there gives the value.
//!
//! Source: Puterman 1994 (bounded horizons, averages); Baier and Katoen 2008, section 10.6 (end components, LTL);
//! Etessami, Kwiatkowska, Vardi and Yannakakis 2008 (mixtures for several objectives). Cost: linear in the states that
//! are reached with their memories, after solving. Guarantee: a true scheduler of the model, whatever its
//! numbers: it attains the value up to the precision of the method (exactly in rational arithmetic).

use std::hash::Hash;

use prism_lang::{Property, Rational};
use rustc_hash::FxHashMap;

use crate::answer::{CheckError, Options};
use crate::choices::Choices;
use crate::engine::{Exact, Sound};
use crate::evaluate::Evaluator;
use crate::state_space::StateSpace;

pub(crate) mod countdown;
mod induced;
mod path;
pub(crate) mod stationary;
pub(crate) mod tour;

pub use path::ScheduledPath;

/// Most pairs of a state and a memory.
const MOST_NODES: usize = 20_000_000;

/// A way to resolve all choices of a model.
#[derive(Debug, Clone, PartialEq)]
pub enum Scheduler {
    /// By the state alone: a row of the matrix for each; none where the choice does not matter.
    ByState(Vec<Option<usize>>),
    /// By the state and a memory.
    WithMemory(FiniteMemory),
}

/// A scheduler with finite memory: the pairs of state and memory that are reached.
#[derive(Debug, Clone, PartialEq)]
pub struct FiniteMemory {
    /// The pairs; those in which the initial states start come first, in their order.
    pub nodes: Vec<Node>,
    /// What the memory says.
    pub meaning: Meaning,
}

/// What a memory says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Meaning {
    /// How many steps were taken; the greatest number also that no more count.
    Steps,
    /// Where the automaton of the formula is, and what must recur next.
    Automaton,
    /// Which pure scheduler was drawn, and its memory.
    Mixture,
}

/// A state with a memory, and what is done there.
#[derive(Debug, Clone, PartialEq)]
pub struct Node {
    /// The state.
    pub state: usize,
    /// The memory; no two nodes have the same state and memory.
    pub memory: u32,
    /// Whether it matters what is chosen.
    pub matters: bool,
    /// What is taken, with shares that sum to 1; more than one only where a mixture is drawn.
    pub moves: Vec<Move>,
}

/// A choice that is taken.
#[derive(Debug, Clone, PartialEq)]
pub struct Move {
    /// How likely it is taken.
    pub share: Rational,
    /// The row of the matrix.
    pub row: usize,
    /// The node after the step to each of the row's targets, in the order of the row's entries.
    pub next: Vec<u32>,
}

/// The scheduler that attains the value which [`check()`](crate::check()) gives, in floating point.
///
/// # Errors
/// See [`CheckError`]; [`CheckError::Unsupported`] where there is no such scheduler, with the reason.
///
/// ```
/// use checker::explore::explore;
/// use checker::{AnswerValue, Options, check_space};
/// use checker::scheduler::{Scheduler, scheduler};
/// use prism_lang::{Constants, parse_model, parse_properties, resolve, resolve_properties};
/// // Wait for one step with the risk, and never when it is too late.
/// let text = "mdp module m x : [0..2]; [risk] x=0 -> 0.4:(x'=1) + 0.6:(x'=2); [try] x=0 -> 0.3:(x'=1) + 0.7:(x'=0); endmodule";
/// let model = resolve(&parse_model(text).tree, &Constants::new()).unwrap();
/// let asked = parse_properties("Pmax=? [ F<=2 x=1 ]").tree;
/// let asked = resolve_properties(&asked, &model, &Constants::new()).unwrap();
/// let space = explore::<f64>(&model)?;
/// let found = scheduler(&space, &asked[0].property, &Options::default())?;
/// let Scheduler::WithMemory(memory) = &found else { unreachable!() };
/// let action = |node: usize| &space.actions()[space.action(memory.nodes[node].moves[0].row).unwrap()];
/// assert_eq!((action(0).as_str(), memory.nodes[0].memory), ("try", 0));
/// let answer = check_space(&found.induced(&space), &asked[0].property, &Options::default())?;
/// let AnswerValue::Number(value) = answer.value else { unreachable!() };
/// assert!((value - (0.3 + 0.7 * 0.4)).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn scheduler(
    space: &StateSpace<f64>,
    property: &Property,
    options: &Options<'_>,
) -> Result<Scheduler, CheckError> {
    Evaluator::<Sound>::new(space, options)?.scheduler_of(property)
}

/// The same in rational arithmetic.
///
/// # Errors
/// See [`scheduler`].
pub fn scheduler_exact(
    space: &StateSpace<Rational>,
    property: &Property,
    options: &Options<'_>,
) -> Result<Scheduler, CheckError> {
    let evaluator = Evaluator::<Exact>::new(space, options)?;
    match property {
        Property::Objectives(objectives) => evaluator.objectives_scheduler(objectives),
        _ => evaluator.scheduler_of(property),
    }
}

/// What a scheduler does and remembers, to be unfolded.
pub(crate) trait Policy {
    /// A memory.
    type Key: Copy + Eq + Hash;
    /// The memory in the beginning, in the initial state at this place.
    fn first(&mut self, place: usize, state: usize) -> Self::Key;
    /// The row of the model that is taken; none where it does not matter.
    fn row(&mut self, state: usize, key: Self::Key) -> Option<usize>;
    /// The memory after a step by this row.
    fn next(&mut self, state: usize, key: Self::Key, row: usize, target: usize) -> Self::Key;
    /// The memory as a number.
    fn number(&mut self, key: Self::Key) -> u32;
}

/// What is reached under a policy; one choice in each node.
pub(crate) fn unfold<N, P: Policy>(
    choices: Choices<'_, N>,
    initial: &[usize],
    policy: &mut P,
    meaning: Meaning,
    options: &Options<'_>,
) -> Result<FiniteMemory, CheckError> {
    let limit = options.product_limit.min(MOST_NODES);
    let mut index: FxHashMap<(usize, P::Key), u32> = FxHashMap::default();
    let mut keys: Vec<(usize, P::Key)> = Vec::new();
    let mut enter = |state: usize, key: P::Key, keys: &mut Vec<(usize, P::Key)>| {
        let new = keys.len() as u32;
        let number = *index.entry((state, key)).or_insert(new);
        if number == new {
            keys.push((state, key));
        }
        number
    };
    for (place, state) in initial.iter().enumerate() {
        let key = policy.first(place, *state);
        enter(*state, key, &mut keys);
    }
    let mut nodes = Vec::new();
    while nodes.len() < keys.len() {
        if nodes.len() % 4096 == 0 {
            options.check_cancelled()?;
        }
        if keys.len() > limit {
            return Err(CheckError::ProductTooLarge { limit });
        }
        let (state, key) = keys[nodes.len()];
        let chosen = policy.row(state, key);
        let row = chosen.unwrap_or_else(|| choices.rows(state).start);
        debug_assert!(choices.rows(state).contains(&row));
        let next = (choices.targets(row).iter())
            .map(|target| {
                let target = *target as usize;
                let key = policy.next(state, key, row, target);
                enter(target, key, &mut keys)
            })
            .collect();
        nodes.push(Node {
            state,
            memory: policy.number(key),
            matters: chosen.is_some(),
            moves: vec![Move {
                share: Rational::from_integer(1.into()),
                row,
                next,
            }],
        });
    }
    Ok(FiniteMemory { nodes, meaning })
}

/// Numbers for memories, in the order in which they are first met.
#[derive(Debug, Default)]
pub(crate) struct Numbered<K>(FxHashMap<K, u32>);

impl<K: Eq + Hash> Numbered<K> {
    pub fn new() -> Self {
        Self(FxHashMap::default())
    }

    pub fn of(&mut self, key: K) -> u32 {
        let next = self.0.len() as u32;
        *self.0.entry(key).or_insert(next)
    }
}
