//! What happens in each step of a path: which commands of the model are taken, and what they change.
//!
//! A transition of the state space may have several causes (choices of commands with outcomes that lead to
//! the same state); its probability is their sum. Definition and weights as in [`crate::explore`]: with `k`
//! choices each is taken with probability `1/k`. Cost: the products of the enabled commands' updates in each
//! state. Guarantee: every cause is found; probabilities are rounded in `f64`.

use prism_lang::resolved::{Command, Model};
use prism_lang::{EvalError, Span, VarIndex};

use super::{Arithmetic, Path, probability};
use crate::state_space::StateSpace;

/// The steps of a path, each explained.
#[derive(Clone, Debug, PartialEq)]
pub struct PathSteps {
    /// One for each transition, in order.
    pub steps: Vec<Step>,
}

/// One transition.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    /// Its probability, over all causes.
    pub probability: f64,
    /// What changed; nothing if the state stays.
    pub changes: Vec<Change>,
    /// How it can come about, the most probable first; none where a deadlocked state stays.
    pub causes: Vec<Cause>,
}

/// One way in which a transition comes about.
#[derive(Clone, Debug, PartialEq)]
pub struct Cause {
    /// The action on which the commands synchronise, if they have one.
    pub action: Option<String>,
    /// The modules that take part, in the order of the model.
    pub modules: Vec<String>,
    /// Their commands' places in the model's text.
    pub commands: Vec<Span>,
    /// The probability that the transition comes about in this way.
    pub probability: f64,
}

/// A variable that changed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Change {
    /// Its name.
    pub variable: String,
    /// Its value before; truth values are 0 and 1.
    pub from: i64,
    /// Its value after.
    pub to: i64,
}

/// A command of a module, enabled.
type Enabled<'m> = (&'m str, &'m Command);

impl PathSteps {
    /// Explains a path through the state space of `model`.
    ///
    /// # Errors
    /// If a guard, a probability or an assignment has no value in a state of the path.
    ///
    /// ```
    /// use checker::explore::explore;
    /// use checker::paths::{PathSteps, most_probable_path};
    /// use prism_lang::{Constants, parse_model, resolve};
    /// let text = "dtmc module coin x : [0..2]; [toss] x=0 -> 1/2:(x'=1) + 1/2:(x'=2); endmodule";
    /// let model = resolve(&parse_model(text).tree, &Constants::new()).unwrap();
    /// let space = explore::<f64>(&model).unwrap();
    /// let goal: Vec<bool> = (0..3).map(|s| space.value(s, 0) == 2).collect();
    /// let path = most_probable_path(&space, &goal).unwrap();
    /// let steps = PathSteps::new(&model, &space, &path)?.steps;
    /// assert_eq!(steps[0].causes[0].action.as_deref(), Some("toss"));
    /// assert_eq!(steps[0].causes[0].modules, ["coin"]);
    /// assert_eq!((steps[0].changes[0].from, steps[0].changes[0].to), (0, 2));
    /// # Ok::<(), prism_lang::EvalError>(())
    /// ```
    pub fn new<N: Arithmetic>(
        model: &Model,
        space: &StateSpace<N>,
        path: &Path<N>,
    ) -> Result<Self, EvalError> {
        let steps = path.states.windows(2).map(|pair| {
            let (from, to) = (space.state(pair[0]), space.state(pair[1]));
            Ok(Step {
                probability: probability(space, pair[0], pair[1]).map_or(0.0, N::to_f64),
                changes: changes(model, &from, &to),
                causes: causes(model, &from, &to)?,
            })
        });
        Ok(Self {
            steps: steps.collect::<Result<_, _>>()?,
        })
    }
}

fn changes(model: &Model, from: &[i64], to: &[i64]) -> Vec<Change> {
    let values = model.variables.iter().zip(from.iter().zip(to));
    let changed = values.filter(|(_, (before, after))| before != after);
    changed
        .map(|(variable, (before, after))| Change {
            variable: variable.name.clone(),
            from: *before,
            to: *after,
        })
        .collect()
}

/// All causes of the transition between two states, the most probable first.
fn causes(model: &Model, from: &[i64], to: &[i64]) -> Result<Vec<Cause>, EvalError> {
    let mut choices: Vec<(Option<usize>, Vec<Enabled<'_>>)> = Vec::new();
    for module in &model.modules {
        for command in &module.commands {
            if command.action.is_none() && command.guard.eval_bool(from)? {
                choices.push((None, vec![(&module.name, command)]));
            }
        }
    }
    for action in 0..model.actions.len() {
        let together = combinations(model, action, from)?;
        choices.extend(together.into_iter().map(|choice| (Some(action), choice)));
    }
    let weight = 1.0 / choices.len() as f64;
    let mut causes = Vec::new();
    for (action, choice) in &choices {
        let chance = chance_of(choice, from, to)?;
        if chance > 0.0 {
            causes.push(Cause {
                action: action.and_then(|a| model.actions.get(a).cloned()),
                modules: choice.iter().map(|(name, _)| (*name).to_owned()).collect(),
                commands: choice.iter().map(|(_, command)| command.span).collect(),
                probability: weight * chance,
            });
        }
    }
    // A stable sort: of equally probable causes the first in the model comes first.
    causes.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    Ok(causes)
}

/// One enabled command of every module that knows the action, in all combinations.
fn combinations<'m>(
    model: &'m Model,
    action: usize,
    state: &[i64],
) -> Result<Vec<Vec<Enabled<'m>>>, EvalError> {
    let mut combined: Vec<Vec<Enabled<'m>>> = vec![Vec::new()];
    let mut known = false;
    for module in &model.modules {
        let mut commands = module
            .commands
            .iter()
            .filter(|c| c.action == Some(action))
            .peekable();
        if commands.peek().is_none() {
            continue;
        }
        known = true;
        let mut enabled = Vec::new();
        for command in commands {
            if command.guard.eval_bool(state)? {
                enabled.push((module.name.as_str(), command));
            }
        }
        let with = |choice: &Vec<Enabled<'m>>| {
            let choice = choice.clone();
            let extended = enabled.iter().map(move |one| {
                let mut longer = choice.clone();
                longer.push(*one);
                longer
            });
            extended.collect::<Vec<_>>()
        };
        combined = combined.iter().flat_map(with).collect();
    }
    Ok(if known { combined } else { Vec::new() })
}

/// The probability that the chosen commands lead from one state to the other.
fn chance_of(choice: &[Enabled<'_>], from: &[i64], to: &[i64]) -> Result<f64, EvalError> {
    let mut outcomes: Vec<(f64, Vec<(VarIndex, i64)>)> = vec![(1.0, Vec::new())];
    for (_, command) in choice {
        let mut next = Vec::new();
        for update in &command.updates {
            let probability: f64 = update.probability.eval_number(from)?;
            if probability == 0.0 {
                continue;
            }
            let mut writes = Vec::new();
            for (variable, value) in &update.assignments {
                writes.push((*variable, assigned(value, from)?));
            }
            // What is written differs from the goal: no product with it leads there.
            if writes
                .iter()
                .any(|(variable, value)| to[*variable] != *value)
            {
                continue;
            }
            for (joint, before) in &outcomes {
                let written = before.iter().chain(&writes).copied().collect();
                next.push((joint * probability, written));
            }
        }
        outcomes = next;
    }
    let leads_there = |writes: &Vec<(VarIndex, i64)>| {
        let mut state = from.to_vec();
        writes
            .iter()
            .for_each(|(variable, value)| state[*variable] = *value);
        state == to
    };
    let chances = outcomes.iter().filter(|(_, writes)| leads_there(writes));
    Ok(chances.map(|(chance, _)| chance).sum())
}

/// The value of an assignment; truth values are 0 and 1.
fn assigned(value: &prism_lang::Expr, state: &[i64]) -> Result<i64, EvalError> {
    match value.ty {
        prism_lang::ast::Type::Bool => value.eval_bool(state).map(i64::from),
        _ => value.eval_int(state),
    }
}
