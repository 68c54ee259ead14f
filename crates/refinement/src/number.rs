//! Numbers of a formal model that can be moved: constants, and probabilities or rates written into commands.
//!
//! # Definition
//! A *constant* is one that the model declares as `double` with a value above 0. A *literal* is a decimal number in the
//! probabilities of a command that is no name. To set it writes the new value in all places of the command that have the same
//! digits; where all probabilities of the command are literals, in the one update, and the others share what is left of 1 in
//! their old proportions. Of two literals that make up 1 only the first counts: the other says the same.
//!
//! # Assumes
//! Nothing of the data.
//!
//! # Guarantee
//! All else of the text stays as it is written. Whether the model is valid with a value is found by solving it.

use crate::model_change::{Read, Refusal, digits};
use crate::solve::Scale;
use prism_lang::ast::{Command, Expr, ExprKind, Model, ModuleBody, Update};
use prism_lang::edit::{self, Edit};
use prism_lang::{Span, resolved};

/// A number of a model, whatever its text is by then.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Number {
    /// A constant, by its name.
    Constant(String),
    /// A number in the probabilities of a command.
    Literal {
        /// The command, counted from 0 over all modules.
        command: usize,
        /// The update, counted from 0.
        update: usize,
        /// Its digits as they are written.
        digits: String,
    },
}

impl Number {
    /// As people call it: the constant's name, or the digits.
    #[must_use]
    pub fn name(&self) -> &str {
        match self {
            Self::Constant(name) => name,
            Self::Literal { digits, .. } => digits,
        }
    }

    /// The line of a model's text that holds it, from 1.
    #[must_use]
    pub fn line(&self, text: &str) -> Option<u32> {
        let read = Read::new(text).ok()?;
        let place = match self {
            Self::Constant(name) => {
                let mut all = read.tree.constants.iter();
                all.find(|it| &it.name.text == name)?.name.span.start
            }
            Self::Literal { .. } => self.places(&read.tree).first()?.start,
        };
        let (line, _) = prism_lang::line_and_column(text, place);
        u32::try_from(line).ok()
    }

    /// Its value in a model, and how it is moved.
    pub(crate) fn value(&self, read: &Read<'_>) -> Option<(f64, Scale)> {
        let value = match self {
            Self::Constant(name) => read.constant(name)?,
            Self::Literal { digits, .. } => digits.parse().ok()?,
        };
        let is_rate = read.model.model_type == resolved::ModelType::Ctmc
            && !(value < 1.0 && has_complement(read.text, self.name()));
        (value > 0.0).then(|| (value, Scale::of(value, is_rate)))
    }

    /// The model's text with another value.
    pub(crate) fn set(&self, read: &Read<'_>, value: f64) -> Result<String, Refusal> {
        let edits = match self {
            Self::Constant(name) => {
                edit::set_constant(&read.tree, name, &digits(value)).map_err(|e| e.to_string())?
            }
            Self::Literal {
                command, update, ..
            } => {
                let all = commands(&read.tree);
                let command = all.get(*command).ok_or("the model has no such command")?;
                let is_rate = read.model.model_type == resolved::ModelType::Ctmc;
                match literals(command).filter(|_| !is_rate) {
                    Some(literals) => shared(&literals, *update, value),
                    None => {
                        let places = self.places(&read.tree).into_iter();
                        places
                            .map(|span| Edit::replace(span, digits(value)))
                            .collect()
                    }
                }
            }
        };
        if edits.is_empty() {
            return Err(format!("the model has no number {}", self.name()));
        }
        edit::apply(read.text, &edits).map_err(|e| e.to_string())
    }

    /// Where a literal stands; only in its own update if all of the command's probabilities are literals.
    fn places(&self, tree: &Model) -> Vec<Span> {
        let Self::Literal {
            command,
            update,
            digits,
        } = self
        else {
            return Vec::new();
        };
        let all = commands(tree);
        let Some(command) = all.get(*command) else {
            return Vec::new();
        };
        let is_plain = literals(command).is_some();
        let updates = command.updates.iter().enumerate();
        let updates = updates.filter(|(place, _)| !is_plain || place == update);
        let numbers = updates.flat_map(|(_, update)| numbers_of(update));
        let same = numbers.filter(|(text, _)| text == digits);
        same.map(|(_, span)| span).collect()
    }
}

/// The numbers of a model in the order of its text, constants first.
pub(crate) fn numbers(read: &Read<'_>) -> Vec<Number> {
    let names = read.tree.constants.iter().map(|it| it.name.text.clone());
    let is_double = |name: &String| {
        matches!(
            read.model.constant(name),
            Some(prism_lang::Value::Double(_))
        )
    };
    let mut found: Vec<Number> = names.filter(is_double).map(Number::Constant).collect();
    for (place, command) in commands(&read.tree).into_iter().enumerate() {
        // Of two that make up 1 the second says what the first does; rates make up nothing.
        let is_rate = read.model.model_type == resolved::ModelType::Ctmc;
        let is_pair = !is_rate && literals(command).is_some_and(|all| all.len() == 2);
        let updates = command.updates.iter().enumerate();
        for (update, own) in updates.take(if is_pair { 1 } else { usize::MAX }) {
            for (digits, _) in numbers_of(own) {
                let is_known = literals(command).is_none()
                    && found.iter().any(|it| {
                        matches!(it, Number::Literal { command, digits: known, .. }
                            if *command == place && known == &digits)
                    });
                if !is_known {
                    found.push(Number::Literal {
                        command: place,
                        update,
                        digits,
                    });
                }
            }
        }
    }
    found.retain(|it| it.value(read).is_some());
    found
}

/// The commands of all modules that are written out.
pub(crate) fn commands(tree: &Model) -> Vec<&Command> {
    let bodies = tree.modules.iter().map(|module| &module.body);
    let written = bodies.filter_map(|body| match body {
        ModuleBody::Written { commands, .. } => Some(commands),
        ModuleBody::Renamed { .. } => None,
    });
    written.flatten().collect()
}

/// Whether a text subtracts a name from 1: then it is a probability, in a model of rates, too.
fn has_complement(text: &str, name: &str) -> bool {
    let code = text
        .lines()
        .map(|line| line.split("//").next().unwrap_or_default());
    let code: String = code
        .flat_map(str::chars)
        .filter(|c| !c.is_whitespace())
        .collect();
    let is_part = |c: Option<char>| c.is_some_and(|c| c.is_ascii_alphanumeric() || c == '_');
    let wanted = format!("1-{name}");
    code.match_indices(&wanted).any(|(at, _)| {
        let before = code[..at].chars().next_back();
        !is_part(code[at + wanted.len()..].chars().next())
            && !is_part(before)
            && before != Some('.')
    })
}

/// The probabilities of a command, if there are several and each is a decimal number.
fn literals(command: &Command) -> Option<Vec<(String, Span)>> {
    let of = |update: &Update| {
        let probability = update.probability.as_ref()?;
        match &probability.kind {
            ExprKind::Double(digits) => Some((digits.clone(), probability.span)),
            _ => None,
        }
    };
    let all: Option<Vec<_>> = command.updates.iter().map(of).collect();
    all.filter(|all| all.len() > 1)
}

/// The decimal numbers in the probability of an update.
fn numbers_of(update: &Update) -> Vec<(String, Span)> {
    fn collect(expr: &Expr, into: &mut Vec<(String, Span)>) {
        match &expr.kind {
            ExprKind::Double(digits) => into.push((digits.clone(), expr.span)),
            ExprKind::Unary(_, inner) => collect(inner, into),
            ExprKind::Binary(_, left, right) => {
                collect(left, into);
                collect(right, into);
            }
            _ => {}
        }
    }
    let mut found = Vec::new();
    if let Some(probability) = &update.probability {
        collect(probability, &mut found);
    }
    found
}

/// One of several literals set, the others in their old proportions.
fn shared(literals: &[(String, Span)], update: usize, value: f64) -> Vec<Edit> {
    let new = digits(value);
    let others: Vec<&str> = literals
        .iter()
        .enumerate()
        .filter(|(place, _)| *place != update)
        .map(|(_, (old, _))| old.as_str())
        .collect();
    let sum = others.join("+");
    let edit = |(place, (old, span)): (usize, &(String, Span))| {
        let text = match (place == update, others.len()) {
            (true, _) => new.clone(),
            (false, 1) => format!("1-{new}"),
            (false, _) => format!("(1-{new})*{old}/({sum})"),
        };
        Edit::replace(*span, text)
    };
    literals.iter().enumerate().map(edit).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_subtracted_from_1_is_a_probability_in_continuous_time_too() {
        let model = "ctmc\nconst double rTry = 0.1;\nconst double pDock = 0.5;\nmodule m\n s : [0..2] init 0;\n\
                     [] s=0 -> rTry*pDock : (s'=1) + rTry*(1 - pDock) : (s'=2);\nendmodule\n";
        let read = Read::new(model).expect("a model");
        let scale = |name: &str| Number::Constant(name.into()).value(&read).map(|it| it.1);
        assert_eq!(
            (scale("pDock"), scale("rTry")),
            (Some(Scale::Odds), Some(Scale::Log))
        );
        assert!(!has_complement(
            "1-pDock2 11-pDock 0.1-pDock // 1-pDock",
            "pDock"
        ));
    }

    const MODEL: &str = "dtmc
const double p = 0.25;
const int n = 3;
module m
  s : [0..9] init 0;
  [] s=0 -> p : (s'=1) + 0.05 : (s'=2) + 1-p-0.05 : (s'=0);
  [] s=1 -> 0.2 : (s'=2) + 0.3 : (s'=3) + 0.5 : (s'=4);
  [] s=2 -> 0.1 : (s'=5) + 0.9 : (s'=6);
  [] s>2 -> true;
endmodule
";

    #[test]
    fn numbers_are_constants_and_what_commands_say() {
        let read = Read::new(MODEL).expect("a model");
        let found = numbers(&read);
        let names: Vec<(&str, Option<u32>)> =
            found.iter().map(|it| (it.name(), it.line(MODEL))).collect();
        let expected = [
            ("p", Some(2)),
            ("0.05", Some(6)),
            ("0.2", Some(7)),
            ("0.3", Some(7)),
            ("0.5", Some(7)),
            ("0.1", Some(8)),
        ];
        assert_eq!(names, expected);
    }

    #[test]
    fn a_model_is_valid_with_any_number_set() {
        let read = Read::new(MODEL).expect("a model");
        for number in numbers(&read) {
            let text = number.set(&read, 0.4).expect("a text");
            let new = Read::new(&text).expect("a model");
            let changed = text.lines().zip(MODEL.lines()).filter(|(a, b)| a != b);
            assert_eq!(changed.count(), 1, "{text}");
            assert!(
                new.model.variables.len() == 1 && text.contains("0.4"),
                "{text}"
            );
        }
        let text = numbers(&read)[3].set(&read, 0.4).expect("a text");
        assert!(
            text.contains("(1-0.4)*0.2/(0.2+0.5) : (s'=2) + 0.4 : (s'=3) + (1-0.4)*0.5/(0.2+0.5)"),
            "{text}"
        );
        let text = numbers(&read)[1].set(&read, 0.4).expect("a text");
        assert!(text.contains("0.4 : (s'=2) + 1-p-0.4 : (s'=0)"), "{text}");
        let text = numbers(&read)[5].set(&read, 0.4).expect("a text");
        assert!(text.contains("0.4 : (s'=5) + 1-0.4 : (s'=6)"), "{text}");
    }

    #[test]
    fn a_rate_beside_others_is_set_alone() {
        let text = "ctmc\nmodule m\n  s : [0..2] init 0;\n  [] s=0 -> 0.2 : (s'=1) + 0.05 : (s'=2);\nendmodule\n";
        let read = Read::new(text).expect("a model");
        let found = numbers(&read);
        assert_eq!(found.len(), 2);
        let changed = found[1].set(&read, 1.5).expect("a text");
        assert!(changed.contains("0.2 : (s'=1) + 1.5 : (s'=2)"), "{changed}");
    }
}
