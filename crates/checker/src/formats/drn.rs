//! State spaces in the DRN format of the model checker Storm.
//!
//! A header (`@type`, `@reward_models`, `@nr_states`, `@nr_choices`), then for each state a line with its exit
//! rate (`ctmc`), its rewards and its labels, and for each choice its action, its rewards and its transitions
//! (rates in a `ctmc`). Source: C. Dehnert and others, "A Storm is coming: A modern probabilistic model checker",
//! CAV 2017, and the tool's own files. Deviation: the format has no reward of a single transition; a choice is
//! given the mean over its transitions, which keeps expected values. Parameters and placeholders are refused.
//!
//! Cost: linear in the file. Guarantee: what is written reads back to the same, but for those means.

use std::io::{Result, Write};

use prism_lang::Arithmetic;
use prism_lang::resolved::ModelType;

use super::read::{ExplicitError, Reader};
use super::{Explicit, Written};
use crate::state_space::{Csr, NO_ACTION, Rewards, StateSpace, TransitionRewards};

impl<N: Written + Arithmetic> Explicit<'_, N> {
    /// Writes the state space with these labels (one flag for each state) and its reward structures.
    ///
    /// # Errors
    /// Those of writing. Reward structures without value are left out.
    pub fn write_drn(&self, labels: &[(String, Vec<bool>)], out: &mut dyn Write) -> Result<()> {
        let space = self.space;
        let all = (0..space.num_rewards()).filter_map(|i| Some((i, space.rewards(i).ok()?)));
        let rewards: Vec<(usize, &Rewards<N>)> = all.collect();
        let names = rewards
            .iter()
            .map(|(index, _)| match &space.rewards[*index].0 {
                Some(name) => name.clone(),
                None => format!("rewards{}", index + 1),
            });
        let names: Vec<String> = names.collect();
        // Storm has no type of its own for systems without probabilities.
        let kind = match space.kind {
            ModelType::Dtmc => "DTMC",
            ModelType::Ctmc => "CTMC",
            ModelType::Mdp | ModelType::Lts => "MDP",
        };
        writeln!(
            out,
            "@type: {kind}\n@parameters\n\n@reward_models\n{}",
            names.join(" ")
        )?;
        let (states, choices) = (space.num_states(), space.num_choices());
        writeln!(out, "@nr_states\n{states}\n@nr_choices\n{choices}\n@model")?;
        let mut is_initial = vec![false; states];
        space
            .initial_states()
            .iter()
            .for_each(|s| is_initial[*s] = true);
        for (number, state) in self.order.iter().enumerate() {
            write!(out, "state {number}")?;
            if space.kind == ModelType::Ctmc {
                write!(out, " !{}", self.sum(*state).written())?;
            }
            write_list(out, rewards.iter().map(|(_, r)| r.state[*state].written()))?;
            if is_initial[*state] {
                write!(out, " init")?;
            }
            for (name, _) in labels.iter().filter(|(_, flags)| flags[*state]) {
                write!(out, " {name}")?;
            }
            writeln!(out)?;
            self.write_choices(*state, &rewards, out)?;
        }
        Ok(())
    }

    fn write_choices(
        &self,
        state: usize,
        rewards: &[(usize, &Rewards<N>)],
        out: &mut dyn Write,
    ) -> Result<()> {
        let space = self.space;
        for (choice, row) in space.choices(state).enumerate() {
            let action = space.action(row).map(|a| space.actions()[a].clone());
            write!(out, "\taction {}", action.unwrap_or(choice.to_string()))?;
            write_list(
                out,
                rewards.iter().map(|(_, r)| self.mean(r, row).written()),
            )?;
            writeln!(out)?;
            for (target, at) in self.row(row) {
                writeln!(out, "\t\t{target} : {}", space.matrix.value[at].written())?;
            }
        }
        Ok(())
    }

    /// The sum of a row.
    fn sum(&self, row: usize) -> N {
        let values = self.space.matrix.row(row).map(|(_, value)| value);
        values.fold(N::zero(), |sum, value| sum.add(value))
    }

    /// The mean reward of a row's transitions.
    fn mean(&self, rewards: &Rewards<N>, row: usize) -> N {
        match &rewards.transition {
            TransitionRewards::None => N::zero(),
            TransitionRewards::Row(each) => each[row].clone(),
            TransitionRewards::Entry(each) => {
                let matrix = &self.space.matrix;
                let entries = matrix.row_start[row]..matrix.row_start[row + 1];
                let parts = entries.map(|at| each[at].mul(&matrix.value[at]));
                let sum = parts.fold(N::zero(), |sum, part| sum.add(&part));
                sum.div(&self.sum(row)).unwrap_or_else(N::zero)
            }
        }
    }
}

fn write_list(out: &mut dyn Write, values: impl Iterator<Item = String>) -> Result<()> {
    let values: Vec<String> = values.collect();
    match values.is_empty() {
        true => Ok(()),
        false => write!(out, " [{}]", values.join(", ")),
    }
}

/// What has been read so far.
struct Drn<N> {
    kind: ModelType,
    reward_names: Vec<String>,
    state_rewards: Vec<Vec<N>>,
    choice_rewards: Vec<Vec<N>>,
    labels: std::collections::BTreeMap<String, Vec<bool>>,
    states: usize,
    rows: Vec<Vec<(u32, N)>>,
    starts: Vec<usize>,
    actions: Vec<String>,
    choice_action: Vec<u32>,
}

/// Reads a state space from a DRN file.
///
/// # Errors
/// The first line that is wrong, with its number.
///
/// ```
/// use checker::formats::read_drn;
/// let text = "@type: MDP\n@parameters\n\n@reward_models\ncost\n@nr_states\n2\n@nr_choices\n3\n@model
/// state 0 [1] init
///     action a [2]
///         0 : 0.5
///         1 : 0.5
///     action b [0]
///         1 : 1
/// state 1 [0] goal
///     action 0 [0]
///         1 : 1
/// ";
/// let space = read_drn::<f64>(text)?;
/// assert_eq!((space.num_states(), space.num_choices()), (2, 3));
/// assert_eq!(space.label("goal"), Ok(vec![false, true]));
/// assert_eq!(space.rewards(0).unwrap().state, [1.0, 0.0]);
/// # Ok::<(), checker::formats::ExplicitError>(())
/// ```
pub fn read_drn<N: Arithmetic>(text: &str) -> std::result::Result<StateSpace<N>, ExplicitError> {
    let mut drn = Drn::head(text)?;
    let reader = Reader { file: "drn" };
    let body = text
        .lines()
        .enumerate()
        .skip_while(|(_, l)| l.trim() != "@model");
    for (at, line) in body.skip(1) {
        let line = line.split("//").next().unwrap_or_default();
        let (before, rewards) = match line.split_once('[') {
            Some((before, rest)) => match rest.split_once(']') {
                Some((list, after)) => (format!("{before} {after}"), list),
                None => return Err(reader.error(at + 1, "`[` without `]`")),
            },
            None => (line.to_owned(), ""),
        };
        let words: Vec<&str> = before.split_whitespace().collect();
        let numbers = rewards.split(',').map(str::trim).filter(|w| !w.is_empty());
        let numbers = numbers.map(|w| reader.number::<N>(w, at + 1));
        let numbers = numbers.collect::<std::result::Result<Vec<N>, _>>()?;
        let wrong = |message: String| reader.error(at + 1, message);
        match words[..] {
            [] => {}
            ["state", number, ref rest @ ..] => drn.state(number, rest, numbers).map_err(wrong)?,
            ["action", name] => drn.action(name, numbers).map_err(wrong)?,
            [target, ":", value] => {
                let value = reader.number::<N>(value, at + 1)?;
                drn.transition(target, value).map_err(wrong)?;
            }
            _ => {
                return Err(wrong(format!(
                    "unknown line `{}`: expected `state N`, `action NAME` or `TARGET : VALUE`",
                    line.trim()
                )));
            }
        }
    }
    drn.finish()
        .map_err(|message| reader.error(text.lines().count(), message))
}

type Told<T> = std::result::Result<T, String>;

/// The kind of model that Storm's name says.
fn kind_of(name: &str) -> Told<ModelType> {
    match name.to_lowercase().as_str() {
        "dtmc" => Ok(ModelType::Dtmc),
        "ctmc" => Ok(ModelType::Ctmc),
        "mdp" => Ok(ModelType::Mdp),
        other => Err(format!("models of type `{other}` cannot be read yet")),
    }
}

impl<N: Arithmetic> Drn<N> {
    fn head(text: &str) -> std::result::Result<Self, ExplicitError> {
        let reader = Reader { file: "drn" };
        let (mut kind, mut names, mut states) = (None, Vec::new(), None);
        let mut lines = text.lines().map(str::trim).enumerate().peekable();
        while let Some((at, line)) = lines.next() {
            let wrong = |message: String| reader.error(at + 1, message);
            let below = lines.peek().map_or("", |(_, below)| *below);
            match line {
                "@model" => break,
                "@parameters" if !below.is_empty() && !below.starts_with('@') => {
                    return Err(wrong(
                        "parameters are not supported: give them values".to_owned(),
                    ));
                }
                "@placeholders" => {
                    return Err(wrong(
                        "placeholders are not supported: write numbers".to_owned(),
                    ));
                }
                "@reward_models" if !below.starts_with('@') => {
                    names = below.split_whitespace().map(str::to_owned).collect();
                }
                "@nr_states" => states = below.parse::<usize>().ok(),
                line => {
                    if let Some(name) = line.strip_prefix("@type:") {
                        kind = Some(kind_of(name.trim()).map_err(wrong)?);
                    }
                }
            }
        }
        let kind = kind.ok_or_else(|| reader.error(1, "`@type` is missing"))?;
        let states = states.filter(|s| *s <= text.len() && *s < u32::MAX as usize);
        let states = states.ok_or_else(|| reader.error(1, "`@nr_states` is missing or wrong"))?;
        Ok(Self::empty(kind, names, states))
    }

    fn empty(kind: ModelType, names: Vec<String>, states: usize) -> Self {
        let none: Vec<Vec<N>> = names.iter().map(|_| Vec::new()).collect();
        Self {
            kind,
            state_rewards: none.clone(),
            choice_rewards: none,
            reward_names: names,
            labels: std::collections::BTreeMap::new(),
            states,
            rows: Vec::new(),
            starts: Vec::new(),
            actions: Vec::new(),
            choice_action: Vec::new(),
        }
    }

    fn state(&mut self, number: &str, rest: &[&str], rewards: Vec<N>) -> Told<()> {
        if number.parse() != Ok(self.starts.len()) || self.starts.len() >= self.states {
            return Err(format!(
                "state `{number}` is not the next one of {}",
                self.states
            ));
        }
        let state = self.starts.len();
        self.starts.push(self.rows.len());
        push(&mut self.state_rewards, rewards)?;
        // The exit rate is the sum of the rates.
        for label in rest.iter().filter(|w| !w.starts_with('!')) {
            let name = label.trim_matches('"').to_owned();
            let states = self.states;
            let flags = self
                .labels
                .entry(name)
                .or_insert_with(|| vec![false; states]);
            flags[state] = true;
        }
        Ok(())
    }

    fn action(&mut self, name: &str, rewards: Vec<N>) -> Told<()> {
        let choice = self.rows.len() - self.starts.last().ok_or("an action before any state")?;
        if choice > 0 && !self.kind.has_choices() {
            return Err("a state of a chain has one action".to_owned());
        }
        push(&mut self.choice_rewards, rewards)?;
        let is_number = name.parse::<usize>().is_ok() || name == "__NOLABEL__";
        self.choice_action.push(match is_number {
            true => NO_ACTION,
            false => super::read::number_of(name, &mut self.actions),
        });
        self.rows.push(Vec::new());
        Ok(())
    }

    fn transition(&mut self, target: &str, value: N) -> Told<()> {
        let state = target.parse::<usize>().ok().filter(|t| *t < self.states);
        let state = state.ok_or_else(|| {
            format!(
                "expected the number of a state below {}, found `{target}`",
                self.states
            )
        })?;
        if !value.is_non_negative() {
            return Err("this is negative: give a probability or a rate".to_owned());
        }
        let row = self
            .rows
            .last_mut()
            .ok_or("a transition before any action")?;
        if !value.is_zero() {
            row.push((state as u32, value));
        }
        Ok(())
    }

    /// Whether all states and transitions are there.
    fn check(&self) -> Told<()> {
        if self.starts.len() != self.states + 1 {
            let missing = self.states + 1 - self.starts.len();
            return Err(format!("{missing} of {} states are missing", self.states));
        }
        if let Some(state) = (0..self.states).find(|s| self.starts[*s] == self.starts[s + 1]) {
            return Err(format!("state {state} has no action"));
        }
        let mut rows = self.rows.iter();
        rows.try_for_each(|row| super::read::check_row(self.kind, row))
    }

    fn finish(mut self) -> Told<StateSpace<N>> {
        self.starts.push(self.rows.len());
        self.check()?;
        let has_choices = self.kind.has_choices();
        let starts = if has_choices { self.starts } else { Vec::new() };
        let matrix = Csr::from_rows(self.rows);
        let flags = self.labels.remove("init");
        let flags = flags.ok_or("no state has the label `init`")?;
        let initial = (0..self.states).filter(|s| flags[*s]).collect();
        self.labels.remove("deadlock");
        let labels = self.labels.into_iter().collect();
        let mut space = StateSpace::from_parts(self.kind, matrix, starts, initial, labels);
        space.roundings = Some(super::read::roundings(space.kind, &space.matrix));
        if has_choices {
            (space.actions, space.choice_action) = (self.actions, self.choice_action);
        }
        let states = self.reward_names.into_iter().zip(self.state_rewards);
        for ((name, state), choice) in states.zip(self.choice_rewards) {
            let mut rewards = Rewards::of_states(state);
            if choice.iter().any(|r| !r.is_zero()) {
                rewards.transition = TransitionRewards::Row(choice);
            }
            space = space.with_rewards(Some(name), rewards);
        }
        Ok(space)
    }
}

/// Appends a number to each list; none are zeros.
fn push<N: Arithmetic>(lists: &mut [Vec<N>], numbers: Vec<N>) -> Told<()> {
    if !numbers.is_empty() && numbers.len() != lists.len() {
        return Err(format!("expected {} rewards", lists.len()));
    }
    let padded = numbers.into_iter().map(Some).chain(std::iter::repeat(None));
    for (list, number) in lists.iter_mut().zip(padded) {
        list.push(number.unwrap_or_else(N::zero));
    }
    Ok(())
}
