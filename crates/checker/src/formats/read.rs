//! State spaces from PRISM's explicit files.
//!
//! Lines that start with `#` are comments, but two are heeded: `# Transitions (DTMC)` names the kind of the model,
//! `# Reward structure "name"` a reward structure. Without the first, a file with choices is an `mdp`, one
//! without a `dtmc`. A state without transitions gets a self-loop and is a deadlock.
//!
//! Deviation from PRISM: the probabilities of a row must sum to 1 to within 1e-9 (PRISM: 1e-5), for what is
//! missing would be lost. What is missing is taken for an error of the entries, so that bounds allow for it; in an
//! exact domain nothing may be missing. Cost: linear in the files, plus sorting of rows.

use std::collections::BTreeMap;
use std::fmt;

use prism_lang::resolved::{ModelType, Variable, VariableKind};
use prism_lang::{Arithmetic, Number, Span};

use crate::rounding::UNIT;
use crate::state_space::{
    Csr, Layout, NO_ACTION, Rewards, RewardsOf, StateSpace, TransitionRewards,
};

/// How far from 1 the probabilities of a row may sum up.
const SUM_TOLERANCE: f64 = 1e-9;

/// The texts of explicit files.
#[derive(Clone, Debug, Default)]
pub struct ExplicitFiles<'t> {
    /// The kind of the model; `None`: as the file says.
    pub kind: Option<ModelType>,
    /// Transitions (`.tra`).
    pub transitions: &'t str,
    /// Values of the variables (`.sta`), if known.
    pub states: Option<&'t str>,
    /// Labels (`.lab`); without them, state 0 is the initial one.
    pub labels: Option<&'t str>,
    /// State and transition rewards (`.srew`, `.trew`), a pair for each structure; either may be empty.
    pub rewards: Vec<(&'t str, &'t str)>,
}

/// Why explicit files could not be read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExplicitError {
    /// The kind of file: `tra`, `sta`, `lab`, `srew` or `trew`.
    pub file: &'static str,
    /// The line, from 1.
    pub line: usize,
    /// What is wrong, and what to do.
    pub message: String,
}

impl fmt::Display for ExplicitError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            ".{} file, line {}: {}",
            self.file, self.line, self.message
        )
    }
}

impl std::error::Error for ExplicitError {}

type Read<T> = Result<T, ExplicitError>;

/// A kind of file, for messages.
pub(super) struct Reader {
    pub(super) file: &'static str,
}

impl Reader {
    pub(super) fn error(&self, line: usize, message: impl Into<String>) -> ExplicitError {
        ExplicitError {
            file: self.file,
            line,
            message: message.into(),
        }
    }

    pub(super) fn number<N: Arithmetic>(&self, text: &str, line: usize) -> Read<N> {
        let no_number = || {
            self.error(
                line,
                format!("expected a number such as 0.25 or 1/4, found `{text}`"),
            )
        };
        parse::<N>(text).ok_or_else(no_number)
    }
}

/// A line that is no comment, split at blanks.
struct Line<'t> {
    file: &'static str,
    number: usize,
    words: Vec<&'t str>,
}

impl Line<'_> {
    fn error(&self, message: impl Into<String>) -> ExplicitError {
        ExplicitError {
            file: self.file,
            line: self.number,
            message: message.into(),
        }
    }

    fn index(&self, word: usize, limit: usize, what: &str) -> Read<usize> {
        let text = self.words.get(word).copied().unwrap_or("nothing");
        let value: Option<usize> = text.parse().ok();
        value.filter(|v| *v < limit).ok_or_else(|| {
            self.error(format!(
                "{what} must be a number below {limit}, as the first line says (got `{text}`)"
            ))
        })
    }

    fn number<N: Arithmetic>(&self, word: usize) -> Read<N> {
        let text = self.words.get(word).copied().unwrap_or("nothing");
        let value = parse::<N>(text);
        value.ok_or_else(|| {
            self.error(format!(
                "expected a number such as 0.25 or 1/4, found `{text}`"
            ))
        })
    }
}

fn parse<N: Arithmetic>(text: &str) -> Option<N> {
    let (negative, digits) = match text.strip_prefix('-') {
        Some(rest) => (true, rest),
        None => (false, text),
    };
    let (above, below) = match digits.split_once('/') {
        Some((above, below)) => (Number::parse(above)?, Number::parse(below)?),
        None => (Number::parse(digits)?, Number::from_i64(1)),
    };
    let value = above.div(&below)?;
    let value = if negative {
        Number::zero().sub(&value)
    } else {
        value
    };
    N::from_literal(&value)
}

fn lines<'t>(file: &'static str, text: &'t str) -> impl Iterator<Item = Line<'t>> {
    let each = text.lines().enumerate().map(|(at, line)| (at, line.trim()));
    let some = each.filter(|(_, line)| !line.is_empty() && !line.starts_with('#'));
    some.map(move |(at, line)| Line {
        file,
        number: at + 1,
        words: line.split_whitespace().collect(),
    })
}

fn empty(file: &'static str) -> ExplicitError {
    ExplicitError {
        file,
        line: 1,
        message: "the file has no first line with the numbers of states and transitions".to_owned(),
    }
}

/// Reads a state space.
///
/// # Errors
/// The first line that is wrong, with its number.
///
/// ```
/// use checker::formats::{ExplicitFiles, read_explicit};
/// let files = ExplicitFiles {
///     transitions: "2 3\n0 0 0.25\n0 1 0.75\n1 1 1\n",
///     labels: Some("0=\"init\" 1=\"done\"\n0: 0\n1: 1\n"),
///     ..ExplicitFiles::default()
/// };
/// let space = read_explicit::<f64>(&files)?;
/// assert_eq!((space.num_states(), space.num_transitions()), (2, 3));
/// assert_eq!(space.label("done"), Ok(vec![false, true]));
/// # Ok::<(), checker::formats::ExplicitError>(())
/// ```
pub fn read_explicit<N: Arithmetic>(files: &ExplicitFiles<'_>) -> Read<StateSpace<N>> {
    let (mut space, deadlocks) = transitions(files)?;
    space.deadlocks = deadlocks;
    space.roundings = Some(roundings(space.kind, &space.matrix));
    let states = space.num_states();
    if let Some(text) = files.states {
        (space.variables, space.layout, space.packed) = values(text, states)?;
    }
    if let Some(text) = files.labels {
        let mut labels = labels(text, states)?;
        if let Some(flags) = labels.remove("init") {
            space.initial = (0..states).filter(|s| flags[*s]).collect();
        }
        labels.remove("deadlock");
        space.list_labels(labels);
    }
    for (of_states, of_transitions) in &files.rewards {
        let rewards = rewards(of_states, of_transitions, &space)?;
        space.rewards.push(rewards);
    }
    Ok(space)
}

/// The kind that a comment names.
fn named_kind(text: &str) -> Option<ModelType> {
    let head = text.lines().find(|l| l.starts_with("# Transitions"))?;
    let kinds = [
        ModelType::Dtmc,
        ModelType::Ctmc,
        ModelType::Mdp,
        ModelType::Lts,
    ];
    let named = |k: &ModelType| head.contains(&format!("({})", k.keyword().to_uppercase()));
    kinds.into_iter().find(named)
}

/// A transition: target, value, action.
type Entry<'t, N> = (u32, N, Option<&'t str>);

fn transitions<N: Arithmetic>(files: &ExplicitFiles<'_>) -> Read<(StateSpace<N>, Vec<usize>)> {
    let mut lines = lines("tra", files.transitions);
    let head = lines.next().ok_or_else(|| empty("tra"))?;
    let (kind, states, choices) = counts(&head, files)?;
    let at = usize::from(kind.has_choices());
    let mut rows: Vec<BTreeMap<usize, Vec<Entry<'_, N>>>> = vec![BTreeMap::new(); states];
    for line in lines {
        let from = line.index(0, states, "state")?;
        let choice = match choices {
            Some(choices) => line.index(1, choices, "choice")?,
            None => 0,
        };
        let target = line.index(at + 1, states, "state")?;
        let (value, action) = match kind {
            ModelType::Lts => (N::one(), at + 2),
            _ => (line.number::<N>(at + 2)?, at + 3),
        };
        if !value.is_non_negative() {
            return Err(line.error("this is negative: give a probability or a rate"));
        }
        if !value.is_zero() {
            let action = line.words.get(action).copied();
            let row = rows[from].entry(choice).or_default();
            row.push((target as u32, value, action));
        }
    }
    assemble(kind, rows, &head)
}

/// The kind of model, and its numbers of states and choices (none in a chain), from the first line.
fn counts(head: &Line<'_>, files: &ExplicitFiles<'_>) -> Read<(ModelType, usize, Option<usize>)> {
    let counts = head.words.iter().map(|w| w.parse::<usize>().ok());
    let (states, choices) = match counts.collect::<Option<Vec<usize>>>().as_deref() {
        Some([states, _]) => (*states, None),
        Some([states, choices, _]) => (*states, Some(*choices)),
        _ => {
            let message = "expected the numbers of states, (of choices,) and of transitions";
            return Err(head.error(message));
        }
    };
    // Each state has a transition; this also keeps a wrong number from taking all memory.
    if states > files.transitions.len() || states >= u32::MAX as usize {
        return Err(head.error(format!("there are not enough lines for {states} states")));
    }
    let guess = match choices {
        Some(_) => ModelType::Mdp,
        None => ModelType::Dtmc,
    };
    let kind = files
        .kind
        .or(named_kind(files.transitions))
        .unwrap_or(guess);
    if kind.has_choices() != choices.is_some() {
        let message = format!(
            "a `{}` does not have a first line like this",
            kind.keyword()
        );
        return Err(head.error(message));
    }
    Ok((kind, states, choices))
}

fn assemble<N: Arithmetic>(
    kind: ModelType,
    rows: Vec<BTreeMap<usize, Vec<Entry<'_, N>>>>,
    head: &Line<'_>,
) -> Read<(StateSpace<N>, Vec<usize>)> {
    let mut matrix = Csr::with_capacity(rows.len());
    let (mut starts, mut choice_action, mut deadlocks) = (vec![0], Vec::new(), Vec::new());
    let mut actions: Vec<String> = Vec::new();
    for (state, choices) in rows.into_iter().enumerate() {
        if choices.is_empty() {
            deadlocks.push(state);
            matrix.push_row([(state as u32, N::one())]);
            choice_action.push(NO_ACTION);
        }
        for (choice, mut row) in choices {
            row.sort_by_key(|(target, ..)| *target);
            let numbers: Vec<(u32, N)> = row.iter().map(|(t, p, _)| (*t, p.clone())).collect();
            check_row(kind, &numbers)
                .map_err(|what| head.error(format!("state {state}, choice {choice}: {what}")))?;
            choice_action.push(match row[0].2 {
                None => NO_ACTION,
                Some(name) => number_of(name, &mut actions),
            });
            matrix.push_row(numbers);
        }
        starts.push(matrix.num_rows());
    }
    let chain = !kind.has_choices();
    let initial = vec![0];
    let starts = if chain { Vec::new() } else { starts };
    let mut space = StateSpace::from_parts(kind, matrix, starts, initial, Vec::new());
    if !chain {
        (space.choice_action, space.actions) = (choice_action, actions);
    }
    Ok((space, deadlocks))
}

/// Whether a row's targets are different and its probabilities sum to 1.
pub(super) fn check_row<N: Arithmetic>(kind: ModelType, row: &[(u32, N)]) -> Result<(), String> {
    let mut targets: Vec<u32> = row.iter().map(|(target, _)| *target).collect();
    targets.sort_unstable();
    if let Some(twice) = targets.windows(2).find(|w| w[0] == w[1]) {
        let target = twice[0];
        return Err(format!(
            "there are two transitions to {target}: add them up"
        ));
    }
    if N::EXACT && kind != ModelType::Ctmc {
        let sum = row.iter().fold(N::zero(), |sum, (_, p)| sum.add(p));
        return match sum == N::one() {
            true => Ok(()),
            false => Err("the probabilities do not sum to 1 exactly, so that there is no exact value: write \
                 fractions such as 1/3, as they are exported with the exact method"
                .to_owned()),
        };
    }
    let sum = row.iter().map(|(_, p)| p.to_f64()).sum::<f64>();
    if kind != ModelType::Ctmc && (sum - 1.0).abs() > SUM_TOLERANCE {
        return Err(format!(
            "the probabilities sum to {sum}, not to 1: give more digits"
        ));
    }
    Ok(())
}

/// How many roundings bring the written numbers to probabilities that sum to 1; one for a rate.
pub(super) fn roundings<N: Arithmetic>(kind: ModelType, matrix: &Csr<N>) -> u32 {
    if N::EXACT {
        return 0;
    }
    if kind == ModelType::Ctmc {
        return 1;
    }
    let of_row = |row: usize| {
        let (sum, terms) = matrix
            .row(row)
            .fold((0.0, 0), |(sum, n), (_, p)| (sum + p.to_f64(), n + 1));
        // The sum itself is rounded. At most SUM_TOLERANCE / UNIT, some ten million.
        ((sum - 1.0).abs() / UNIT).ceil() as u32 + terms + 1
    };
    (0..matrix.num_rows()).map(of_row).max().unwrap_or(0)
}

/// The number of a name, which is added if it is new.
pub(super) fn number_of(name: &str, names: &mut Vec<String>) -> u32 {
    let known = names.iter().position(|n| n == name);
    known.unwrap_or_else(|| {
        names.push(name.to_owned());
        names.len() - 1
    }) as u32
}

/// The parts of `(a,b)`.
fn tuple(text: &str) -> Vec<&str> {
    let inner = text.trim().trim_start_matches('(').trim_end_matches(')');
    let parts = inner.split(',').map(str::trim);
    parts.filter(|w| !w.is_empty()).collect()
}

/// Variables, their layout, and the packed states.
fn values(text: &str, states: usize) -> Read<(Vec<Variable>, Layout, Vec<u64>)> {
    let mut lines = lines("sta", text);
    let head = lines.next().ok_or_else(|| empty("sta"))?;
    let whole = head.words.concat();
    let names = tuple(&whole);
    let mut rows: Vec<Option<Vec<i64>>> = vec![None; states];
    let mut are_bools = vec![true; names.len()];
    for line in lines {
        let whole = line.words.concat();
        let (number, list) = whole.split_once(':').unwrap_or(("", &whole));
        let number: Option<usize> = number.parse().ok();
        let Some(place) = number.and_then(|n| rows.get_mut(n)) else {
            return Err(line.error(format!("expected `state:(values)`, a state below {states}")));
        };
        let words = tuple(list);
        if words.len() != names.len() {
            return Err(line.error(format!("expected {} values", names.len())));
        }
        let value = |(word, is_bool): (&&str, &mut bool)| {
            *is_bool &= matches!(*word, "true" | "false");
            match *word {
                "true" => Ok(1),
                "false" => Ok(0),
                word => (word.parse()).map_err(|_| {
                    line.error(format!(
                        "expected an integer, true or false, found `{word}`"
                    ))
                }),
            }
        };
        let values = words.iter().zip(&mut are_bools).map(value);
        *place = Some(values.collect::<Read<Vec<i64>>>()?);
    }
    let rows: Option<Vec<Vec<i64>>> = rows.into_iter().collect();
    let rows = rows.ok_or_else(|| head.error("some state has no line: add it"))?;
    Ok(packed(&names, &are_bools, &rows))
}

/// Variables with the ranges that occur, their layout, and the packed states.
fn packed(
    names: &[&str],
    are_bools: &[bool],
    rows: &[Vec<i64>],
) -> (Vec<Variable>, Layout, Vec<u64>) {
    let variables = names.iter().enumerate().map(|(v, name)| {
        let each = || rows.iter().map(|r| r[v]);
        let (low, high) = (each().min().unwrap_or(0), each().max().unwrap_or(0));
        Variable {
            name: (*name).to_owned(),
            module: None,
            kind: match are_bools[v] {
                true => VariableKind::Bool,
                false => VariableKind::Int { low, high },
            },
            init: low,
            span: Span::default(),
        }
    });
    let variables: Vec<Variable> = variables.collect();
    let layout = Layout::new(&variables);
    let words = layout.words();
    let mut packed = vec![0; rows.len() * words];
    for (row, place) in rows.iter().zip(packed.chunks_exact_mut(words)) {
        layout.pack(row, place);
    }
    (variables, layout, packed)
}

fn labels(text: &str, states: usize) -> Read<BTreeMap<String, Vec<bool>>> {
    let mut lines = lines("lab", text);
    let head = lines.next().ok_or_else(|| empty("lab"))?;
    let mut names: BTreeMap<usize, &str> = BTreeMap::new();
    for word in &head.words {
        let parts = word.split_once('=').and_then(|(number, name)| {
            let name = name.strip_prefix('"')?.strip_suffix('"')?;
            Some((number.parse().ok()?, name))
        });
        let (number, name) =
            parts.ok_or_else(|| head.error(format!("`{word}` is not like 0=\"init\"")))?;
        names.insert(number, name);
    }
    let mut found: BTreeMap<String, Vec<bool>> = BTreeMap::new();
    for name in names.values() {
        found.insert((*name).to_owned(), vec![false; states]);
    }
    for line in lines {
        let text = line.words[0].trim_end_matches(':');
        let state: Option<usize> = text.parse().ok().filter(|s| *s < states);
        let state = state.ok_or_else(|| {
            line.error(format!(
                "expected the number of a state below {states}, found `{text}`"
            ))
        })?;
        for word in &line.words[1..] {
            let name = word.parse().ok().and_then(|n: usize| names.get(&n));
            let name =
                name.ok_or_else(|| line.error(format!("the first line has no label `{word}`")))?;
            if let Some(flags) = found.get_mut(*name) {
                flags[state] = true;
            }
        }
    }
    Ok(found)
}

/// The name in a comment such as `# Reward structure "time"`.
fn reward_name(text: &str) -> Option<String> {
    let head = text.lines().find(|l| l.starts_with("# Reward structure"))?;
    head.split('"').nth(1).map(str::to_owned)
}

fn rewards<N: Arithmetic>(
    of_states: &str,
    of_transitions: &str,
    space: &StateSpace<N>,
) -> Read<RewardsOf<N>> {
    let states = space.num_states();
    let mut rewards = Rewards::of_states(vec![N::zero(); states]);
    // An unwritten reward may be rounded, as may the matrix.
    for line in lines("srew", of_states).skip(1) {
        let state = line.index(0, states, "state")?;
        rewards.state[state] = line.number(1)?;
    }
    let has_choices = space.kind.has_choices();
    let mut each: Vec<N> = Vec::new();
    let at = usize::from(has_choices);
    for line in lines("trew", of_transitions).skip(1) {
        each.resize(space.num_transitions(), N::zero());
        let rows = space.choices(line.index(0, states, "state")?);
        let choice = if has_choices {
            line.index(1, rows.len(), "choice")?
        } else {
            0
        };
        let target = line.index(at + 1, states, "state")?;
        let row = rows.start + choice;
        let entries = space.matrix.row_start[row]..space.matrix.row_start[row + 1];
        let found = space.matrix.column[entries.clone()].binary_search(&(target as u32));
        let found = found.map_err(|_| line.error("there is no such transition"))?;
        each[entries.start + found] = line.number(at + 2)?;
    }
    if !each.is_empty() {
        rewards.transition = TransitionRewards::Entry(each);
    }
    let name = reward_name(of_states).or_else(|| reward_name(of_transitions));
    Ok((name, Ok(rewards)))
}
