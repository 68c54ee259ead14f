//! A value that a model declares or asks for, and never comes to: what leads there was written otherwise.
//!
//! # Definition
//! Three things in a text say a value that the model never has:
//!
//! * a *counter* (a variable with declared bounds that an update counts up or down) whose guards name one number and neither end of
//!   its range: the number is written where the end was meant (`tries : [0..3]` with `tries<2`). In all comparisons of the guards
//!   it becomes one end;
//! * a counter that begins between the ends of its range: it begins at one of them;
//! * a guard that asks for a value that no update gives and that does not hold at the beginning (`cuts=1`): one update of the module
//!   does that, in place of what it does or with it; or it holds at the beginning;
//! * a variable that stands nowhere else: it counts how often something is tried again. Of one command one update leads, as often as
//!   its range allows, to where another update of the module leads.
//!
//! Each such change is solved and tried on all evidence ([`crate::structure`]) where the model disagrees strongly with counts. No
//! number is fitted: the text says it.
//!
//! # Assumes
//! That one place is wrong, and that what is declared was meant to be used.
//!
//! # Source and guarantee
//! The method of difference (J. S. Mill, 1843). What is offered was solved. Several places may give the same rates; each says so.
//! Which values are never reached is read off the text, not off the states: a change that leads nowhere moves no value, and is
//! dropped for that.
//!
//! # Cost
//! One solution for each; at most [`MOST_CHANGES`] in all, of a large model fewer, so that states times solutions stay below
//! [`MOST_WORK`].

use crate::counts::anchors;
use crate::draws;
use crate::model_change::{
    AS_GOOD, Alternative, Changed, ModelChange, Read, Refusal, Solver, Values,
};
use crate::model_offers::{Ground, Model, ModelOffers};
use crate::number::commands;
use crate::structure::{Explaining, Tried};
use crate::unreached::{Lacking, of_guards};
use crate::unused::is_used;
use evidence::Subject;
use prism_lang::ast::{BinaryOp, Command, Expr, ExprKind, ModuleBody, Variable, VariableRange};
use prism_lang::edit::{self, Edit};

/// Changes that are tried, at most.
const MOST_CHANGES: usize = 400;

/// States times solutions, at most.
const MOST_WORK: u64 = 20_000_000;

/// Those that are offered, at most.
const MOST_OFFERS: usize = 3;

/// What makes a model come to a value that it declares or asks for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Idle {
    /// Another number in the guards of a counter.
    Limit {
        /// The counter.
        variable: String,
        /// The number that its guards name.
        old: i64,
        /// The end of its range, as it is written.
        new: String,
    },
    /// Another value at the beginning.
    Begin {
        /// The counter.
        variable: String,
        /// The end of its range, as it is written.
        new: String,
    },
    /// Another outcome of an update.
    Outcome {
        /// The command, counted from 0 over all modules.
        command: usize,
        /// Its update, counted from 0.
        update: usize,
        /// What a guard asks for.
        asked: String,
        /// What the update does then.
        to: String,
    },
    /// Another outcome of an update, as often as a variable's range allows.
    Again {
        /// The command, counted from 0 over all modules.
        command: usize,
        /// Its update, counted from 0.
        update: usize,
        /// The variable that counts.
        variable: String,
        /// The end of its range, as it is written; none for `bool`.
        most: Option<String>,
        /// What the update does as long as the end is not reached.
        to: String,
    },
}

impl Idle {
    /// The first line of a model's text that it changes, from 1.
    #[must_use]
    pub fn line(&self, text: &str) -> Option<u32> {
        let read = Read::new(text).ok()?;
        let first = self
            .edits(&read)
            .ok()?
            .iter()
            .map(|it| it.span.start)
            .min()?;
        let (line, _) = prism_lang::line_and_column(text, first);
        u32::try_from(line).ok()
    }

    /// What of the text is changed, in few words.
    #[must_use]
    pub fn part(&self) -> String {
        match self {
            Self::Limit { variable, old, .. } => format!("{old} of {variable}"),
            Self::Begin { variable, .. } => format!("init of {variable}"),
            Self::Again { variable, .. } => format!("a command that counts {variable}"),
            Self::Outcome { asked, .. } => format!("an update to {asked}"),
        }
    }

    /// What in the text speaks for it, as a clause.
    #[must_use]
    pub fn hint(&self) -> String {
        match self {
            Self::Limit { variable, old, new } => {
                format!("the range of `{variable}` ends at {new}, and its guards name {old} alone")
            }
            Self::Begin { variable, new } => {
                format!("`{variable}` may be {new}, and never is")
            }
            Self::Again { variable, .. } => {
                format!("`{variable}` is declared, and nothing uses it")
            }
            Self::Outcome { asked, .. } => {
                format!("a guard asks for `{asked}`, and no update leads there")
            }
        }
    }

    fn in_words(&self, text: &str) -> String {
        let line = self.line(text).unwrap_or_default();
        match self {
            Self::Limit { variable, old, new } => {
                format!(
                    "{new} in place of {old} in the guards of `{variable}`, from line {line} on"
                )
            }
            Self::Begin { variable, new } => {
                format!("`{variable}` begins with {new}, in line {line}")
            }
            Self::Again { to, variable, .. } => {
                format!(
                    "`{to}` as what an update of line {line} does, as often as `{variable}` counts"
                )
            }
            Self::Outcome { to, .. } => format!("`{to}` as what an update of line {line} does"),
        }
    }

    fn edits(&self, read: &Read<'_>) -> Result<Vec<Edit>, Refusal> {
        match self {
            Self::Limit { variable, old, new } => {
                let all = limits(read, variable).into_iter();
                let edits: Vec<Edit> = all
                    .filter(|(_, value)| value == old)
                    .map(|(expr, _)| Edit::replace(expr.span, new.clone()))
                    .collect();
                match edits.is_empty() {
                    true => Err(format!("no guard compares `{variable}` with {old}")),
                    false => Ok(edits),
                }
            }
            Self::Begin { variable, new } => {
                let mut all = declared(read);
                let init = all
                    .find(|it| it.name.text == *variable)
                    .and_then(|it| it.init.as_ref());
                let init = init.ok_or("the model says no beginning of it")?;
                Ok(vec![Edit::replace(init.span, new.clone())])
            }
            Self::Outcome {
                command,
                update,
                to,
                ..
            } => {
                let all = commands(&read.tree);
                let command = all.get(*command).ok_or("the model has no such command")?;
                let update = command
                    .updates
                    .get(*update)
                    .ok_or("the command has no such update")?;
                Ok(vec![edit::with_outcome(read.text, update, to)])
            }
            Self::Again { .. } => self.again(read),
        }
    }

    /// The command as it is where the end is reached, and before it one that counts.
    fn again(&self, read: &Read<'_>) -> Result<Vec<Edit>, Refusal> {
        let Self::Again {
            command,
            update,
            variable,
            most,
            to,
        } = self
        else {
            return Err("it counts nothing".into());
        };
        let all = commands(&read.tree);
        let command = all.get(*command).ok_or("the model has no such command")?;
        let update = command
            .updates
            .get(*update)
            .ok_or("the command has no such update")?;
        let guard = &read.text[command.guard.span.start..command.guard.span.end];
        let (before, at_end, counted) = match most {
            Some(most) => (
                format!("({guard}) & {variable}<{most}"),
                format!("({guard}) & {variable}={most}"),
                format!("({variable}'={variable}+1)"),
            ),
            None => (
                format!("({guard}) & !{variable}"),
                format!("({guard}) & {variable}"),
                format!("({variable}'=true)"),
            ),
        };
        let does = match to.as_str() {
            "true" => counted,
            to => format!("{to} & {counted}"),
        };
        let counting = [
            Edit::replace(command.guard.span, before),
            edit::with_outcome(read.text, update, &does),
        ];
        let ending = [Edit::replace(command.guard.span, at_end)];
        let span = command.span;
        let written = |edits: &[Edit]| {
            let mut text = String::new();
            let mut at = span.start;
            for edit in edits {
                text.push_str(&read.text[at..edit.span.start]);
                text.push_str(&edit.text);
                at = edit.span.end;
            }
            text.push_str(&read.text[at..span.end]);
            text.trim_end_matches(';').to_owned()
        };
        let end = if read.text[..span.end].ends_with(';') {
            ";"
        } else {
            ""
        };
        let both = format!("{};\n  {}{end}", written(&counting), written(&ending));
        Ok(vec![Edit::replace(span, both)])
    }

    fn make(&self, read: &Read<'_>) -> Result<String, Refusal> {
        edit::apply(read.text, &self.edits(read)?).map_err(|e| e.to_string())
    }
}

impl Ground<'_> {
    /// Puts changes that lead to values which a model declares or asks for before the other ones, where nothing weighs more.
    pub(crate) fn of_idle(&self, model: &Model<'_>, before: &Values, found: &mut ModelOffers) {
        let mut all = self.evidence.iter();
        let Some(own) = all.find(|piece| piece.id == model.evidence) else {
            return;
        };
        let Ok(read) = Read::new(model.text) else {
            return;
        };
        if self.in_conflict(own, before).is_empty() {
            return;
        }
        let affordable = MOST_WORK / model.states.unwrap_or(1).max(1);
        let most = MOST_CHANGES.min(usize::try_from(affordable).unwrap_or(MOST_CHANGES));
        let tried = changes(&read)
            .into_iter()
            .take(most)
            .filter_map(|(kind, change)| {
                let text = change.make(&read).ok()?;
                let values = model.solver.values(&text).ok()?;
                Some(Tried {
                    change: (change, text),
                    kind,
                    values,
                })
            });
        // That the text says the value speaks for it, whatever the number of places.
        let explaining = self.explaining_above(f64::NEG_INFINITY, own, before, tried.collect());
        let Some(best) = explaining.iter().map(|it| it.weight).max_by(f64::total_cmp) else {
            return;
        };
        let others = found.changes.iter().map(|it| &it.1);
        if self.heaviest(own, before, others) > best + AS_GOOD {
            return;
        }
        let named: Vec<Alternative> = explaining
            .iter()
            .map(|it| Alternative {
                name: it.change.0.in_words(model.text),
                line: it.change.0.line(model.text),
            })
            .collect();
        let made = explaining.into_iter().take(MOST_OFFERS).enumerate();
        let made: Vec<(ModelChange, Changed)> = made
            .filter_map(|(number, it)| {
                let Explaining { change: (change, text), values, tried, subjects, .. } = it;
                let subject: Subject = subjects.into_iter().next()?;
                let counts = anchors(self.evidence, own, &subject).into_iter().next()?;
                let others = named.iter().enumerate().filter(|(at, _)| *at != number);
                let changed = Changed {
                    text,
                    what: change.in_words(model.text),
                    constant: None,
                    values,
                    notes: vec![format!(
                        "No number was fitted for it: {}. {} other changes of the kind were tried that change what is answered.",
                        change.hint(),
                        tried.saturating_sub(1)
                    )],
                    alternatives: others.map(|(_, it)| it.clone()).collect(),
                    settled: None,
                };
                Some((ModelChange::Idle { subject, change, counts, tried }, changed))
            })
            .collect();
        found.changes.splice(0..0, made);
    }
}

/// The model with the change, solved.
pub(crate) fn with(text: &str, solver: &dyn Solver, change: &Idle) -> Result<Changed, Refusal> {
    let read = Read::new(text)?;
    let new = change.make(&read)?;
    Ok(Changed {
        what: change.in_words(text),
        values: solver.values(&new)?,
        text: new,
        constant: None,
        notes: Vec::new(),
        alternatives: Vec::new(),
        settled: None,
    })
}

/// What a guard of the model asks for that no update leads to, with the guard's line, from 1: what is never taken.
#[must_use]
pub fn never_taken(text: &str) -> Option<(String, u32)> {
    let read = Read::new(text).ok()?;
    let asked = asked_in_vain(&read).into_iter().next()?;
    let all = commands(&read.tree);
    let named = |command: &&&Command| {
        let all = draws::named_in_guard(command, &read.tree.formulas);
        all.iter()
            .any(|(variable, expr)| *variable == asked.variable && expr.to_string() == asked.value)
    };
    let command = all.iter().find(named)?;
    let (line, _) = prism_lang::line_and_column(text, command.span.start);
    Some((asked.meaning, u32::try_from(line).ok()?))
}

/// All changes with their kinds.
fn changes(read: &Read<'_>) -> Vec<(u8, Idle)> {
    let mut found = Vec::new();
    for variable in declared(read).filter(|it| is_counter(read, it)) {
        let VariableRange::Int { low, high } = &variable.range else {
            continue;
        };
        let name = &variable.name.text;
        let ends: Vec<(i64, String)> = [low, high]
            .into_iter()
            .filter_map(|end| Some((draws::value_of(end, None, &read.model)?, end.to_string())))
            .collect();
        let mut named: Vec<i64> = limits(read, name)
            .into_iter()
            .map(|(_, value)| value)
            .collect();
        named.sort_unstable();
        named.dedup();
        let between = |value: i64| ends.iter().all(|(end, _)| *end != value);
        if let [old] = named[..]
            && between(old)
        {
            found.extend(ends.iter().map(|(_, new)| {
                let new = new.clone();
                (
                    0,
                    Idle::Limit {
                        variable: name.clone(),
                        old,
                        new,
                    },
                )
            }));
        }
        let begins = variable
            .init
            .as_ref()
            .and_then(|it| draws::value_of(it, None, &read.model));
        if begins.is_some_and(between) {
            found.extend(ends.iter().map(|(_, new)| {
                (
                    1,
                    Idle::Begin {
                        variable: name.clone(),
                        new: new.clone(),
                    },
                )
            }));
        }
    }
    for asked in asked_in_vain(read) {
        let new = asked.value;
        let begins = Idle::Begin {
            variable: asked.variable,
            new,
        };
        if !found.contains(&(1, begins.clone())) {
            found.push((1, begins));
        }
    }
    found.extend(outcomes(read).into_iter().map(|it| (2, it)));
    found.extend(repetitions(read).into_iter().map(|it| (3, it)));
    found
}

/// Updates that lead elsewhere, as often as a variable counts that stands nowhere else.
fn repetitions(read: &Read<'_>) -> Vec<Idle> {
    let mut found = Vec::new();
    let mut first = 0;
    for module in &read.tree.modules {
        let ModuleBody::Written {
            commands: own,
            variables,
            ..
        } = &module.body
        else {
            continue;
        };
        let mut outcomes: Vec<String> = Vec::new();
        for update in own.iter().flat_map(|it| &it.updates) {
            let outcome = edit::outcome(read.text, update);
            if !outcomes.contains(&outcome) {
                outcomes.push(outcome);
            }
        }
        let unused = variables
            .iter()
            .filter(|it| !is_used(read.text, &it.name.text));
        for variable in unused {
            let most = match &variable.range {
                VariableRange::Bool => None,
                VariableRange::Int { high, .. } => Some(high.to_string()),
                VariableRange::Unbounded | VariableRange::Clock => continue,
            };
            for (place, command) in own.iter().enumerate() {
                for (number, update) in command.updates.iter().enumerate() {
                    let own = edit::outcome(read.text, update);
                    let others = outcomes.iter().filter(|it| **it != own);
                    found.extend(others.map(|to| Idle::Again {
                        command: first + place,
                        update: number,
                        variable: variable.name.text.clone(),
                        most: most.clone(),
                        to: to.clone(),
                    }));
                }
            }
        }
        first += own.len();
    }
    found
}

/// The variables that are declared in modules which are written out.
fn declared<'r>(read: &'r Read<'_>) -> impl Iterator<Item = &'r Variable> {
    let of_modules = read
        .tree
        .modules
        .iter()
        .filter_map(|module| match &module.body {
            ModuleBody::Written { variables, .. } => Some(variables),
            ModuleBody::Renamed { .. } => None,
        });
    of_modules.flatten()
}

/// Whether an update counts a variable up or down.
fn is_counter(read: &Read<'_>, variable: &Variable) -> bool {
    let name = variable.name.text.as_str();
    let is_name = |expr: &Expr| matches!(&expr.kind, ExprKind::Name(it) if it == name);
    let counts = |expr: &Expr| match &expr.kind {
        ExprKind::Binary(BinaryOp::Plus, left, right) => is_name(left) || is_name(right),
        ExprKind::Binary(BinaryOp::Minus, left, _) => is_name(left),
        _ => false,
    };
    let all = commands(&read.tree);
    let mut assignments = all
        .iter()
        .flat_map(|it| &it.updates)
        .flat_map(|it| &it.assignments);
    assignments.any(|it| it.variable.text == name && counts(&it.value))
}

/// What guards compare a variable with, where that is a number or a constant.
fn limits<'r>(read: &'r Read<'_>, variable: &str) -> Vec<(&'r Expr, i64)> {
    fn collect<'e>(expr: &'e Expr, variable: &str, into: &mut Vec<&'e Expr>) {
        let is_own = |it: &Expr| matches!(&it.kind, ExprKind::Name(name) if name == variable);
        match &expr.kind {
            ExprKind::Binary(
                BinaryOp::Equal
                | BinaryOp::NotEqual
                | BinaryOp::Less
                | BinaryOp::LessEqual
                | BinaryOp::Greater
                | BinaryOp::GreaterEqual,
                left,
                right,
            ) => {
                if is_own(left) {
                    into.push(right);
                } else if is_own(right) {
                    into.push(left);
                }
            }
            ExprKind::Binary(_, left, right) => {
                collect(left, variable, into);
                collect(right, variable, into);
            }
            ExprKind::Unary(_, inner) => collect(inner, variable, into),
            _ => {}
        }
    }
    let mut found = Vec::new();
    for command in commands(&read.tree) {
        collect(&command.guard, variable, &mut found);
    }
    let with_value = |expr: &'r Expr| Some((expr, draws::value_of(expr, None, &read.model)?));
    found.into_iter().filter_map(with_value).collect()
}

/// What guards ask for and no update leads to. What a variable comes to by counting or computing is not read off the text.
fn asked_in_vain(read: &Read<'_>) -> Vec<Lacking> {
    let all = commands(&read.tree);
    let is_computed = |name: &str| {
        let mut assignments = all
            .iter()
            .flat_map(|it| &it.updates)
            .flat_map(|it| &it.assignments);
        assignments.any(|it| {
            it.variable.text == name && draws::value_of(&it.value, None, &read.model).is_none()
        })
    };
    let asked = of_guards(read).into_iter();
    asked.filter(|it| !is_computed(&it.variable)).collect()
}

/// The updates of the module that owns what a guard asks for, which lead there in place of what they do, or with it.
fn outcomes(read: &Read<'_>) -> Vec<Idle> {
    let lacking = asked_in_vain(read);
    let mut found = Vec::new();
    let mut first = 0;
    for module in &read.tree.modules {
        let ModuleBody::Written {
            commands: own,
            variables,
            ..
        } = &module.body
        else {
            continue;
        };
        let is_own = |name: &str| variables.iter().any(|own| own.name.text == name);
        for asked in lacking.iter().filter(|it| is_own(&it.variable)) {
            let alone = format!("({}'={})", asked.variable, asked.value);
            for (place, command) in own.iter().enumerate() {
                for (number, update) in command.updates.iter().enumerate() {
                    let with = edit::with_value(read.text, update, &asked.variable, &asked.value);
                    let mut all = vec![alone.clone(), with];
                    all.dedup();
                    found.extend(all.into_iter().map(|to| Idle::Outcome {
                        command: first + place,
                        update: number,
                        asked: asked.meaning.clone(),
                        to,
                    }));
                }
            }
        }
        first += own.len();
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    const MODEL: &str = "dtmc
module tries
  s : [0..3] init 0;
  tries : [0..4] init 1;
  cuts : [0..1] init 0;
  [] s=0 & tries<2 -> 0.5 : (s'=1) + 0.5 : (tries'=tries+1);
  [] s=0 & tries=2 -> (s'=2);
  [] s=1 & cuts=0 -> 0.5 : (s'=2) + 0.5 : (s'=3);
  [] s=1 & cuts=1 -> 0.5 : (s'=2) + 0.5 : (s'=3);
  [] s>1 -> true;
endmodule
";

    fn made(change: &Idle) -> String {
        let read = Read::new(MODEL).expect("a model");
        change.make(&read).expect("it can be made")
    }

    #[test]
    fn ends_of_ranges_beginnings_and_what_guards_ask_for_are_tried() {
        let read = Read::new(MODEL).expect("a model");
        let all = changes(&read);
        let of = |wanted: u8| {
            all.iter()
                .filter(move |(kind, _)| *kind == wanted)
                .map(|(_, it)| it)
        };
        let limits: Vec<String> = of(0).map(made).collect();
        assert_eq!(limits.len(), 2, "{all:?}");
        assert!(
            limits[1].contains("tries<4") && limits[1].contains("tries=4"),
            "{}",
            limits[1]
        );
        assert!(limits[1].contains("tries : [0..4] init 1"));
        let begins: Vec<String> = of(1).map(made).collect();
        assert!(begins[0].contains("tries : [0..4] init 0;"), "{begins:?}");
        let outcomes: Vec<String> = of(2).map(made).collect();
        let wanted = "[] s=1 & cuts=0 -> 0.5 : (s'=2) + 0.5 : (cuts'=1);";
        assert!(
            outcomes.iter().any(|it| it.contains(wanted)),
            "{outcomes:#?}"
        );
        assert_eq!(never_taken(MODEL), Some(("cuts=1".into(), 9)));
    }

    #[test]
    fn a_model_that_uses_what_it_declares_has_none() {
        let right = MODEL
            .replace("tries<2", "tries<4")
            .replace("tries=2", "tries=4")
            .replace("init 1", "init 0")
            .replacen("0.5 : (s'=3)", "0.5 : (cuts'=1)", 1);
        let read = Read::new(&right).expect("a model");
        assert_eq!(changes(&read), []);
        assert_eq!(never_taken(&right), None);
    }

    #[test]
    fn what_nothing_uses_counts_how_often_it_is_tried_again() {
        let model = "dtmc
module door
  s : [0..2] init 0;
  tries : [0..1] init 0;
  [] s=0 -> 0.5 : (s'=1) + 0.5 : (s'=2);
  [] s>0 -> true;
endmodule
";
        let read = Read::new(model).expect("a model");
        let all = changes(&read);
        assert!(all.iter().all(|(kind, _)| *kind == 3), "{all:?}");
        let made: Vec<String> = all
            .iter()
            .filter_map(|(_, it)| it.make(&read).ok())
            .collect();
        let wanted = "  [] (s=0) & tries<1 -> 0.5 : (s'=1) + 0.5 : (s'=1) & (tries'=tries+1);
  [] (s=0) & tries=1 -> 0.5 : (s'=1) + 0.5 : (s'=2);
";
        assert!(made.iter().any(|it| it.contains(wanted)), "{made:#?}");
        assert!(made.iter().all(|text| Read::new(text).is_ok()));
    }

    #[test]
    fn a_value_that_a_guard_asks_for_may_hold_at_the_beginning() {
        let model = MODEL.replace("cuts : [0..1] init 0", "cuts : [0..1] init 1");
        let model = model.replace(
            "(s'=3);\n  [] s=1 & cuts=1",
            "(cuts'=1);\n  [] s=1 & cuts=1",
        );
        let read = Read::new(&model).expect("a model");
        let begins = Idle::Begin {
            variable: "cuts".into(),
            new: "0".into(),
        };
        assert!(changes(&read).contains(&(1, begins)));
    }
}
