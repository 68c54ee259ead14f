//! Syntax trees back to text, with parentheses only where precedence needs them.
//!
//! Guarantee: the printed text parses to the same tree, places aside (tested on random trees).

mod property;
mod system;

use std::fmt::{self, Display, Formatter};

use crate::ast::{
    BinaryOp, Command, Constant, Expr, ExprKind, Formula, Label, Model, Module, ModuleBody,
    Property, PropertyFile, RewardItem, RewardKind, RewardStructure, StepBound, TemporalOp,
    UnaryOp, Update, Variable, VariableRange,
};
use crate::parser::operator::{level, level_of, operand_levels};

impl Display for Expr {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write_expr(f, self, level::TEMPORAL_BINARY)
    }
}

fn own_level(expr: &Expr) -> u8 {
    match &expr.kind {
        ExprKind::Unary(UnaryOp::Not, _) => level::NOT,
        ExprKind::Unary(UnaryOp::Minus, _) => level::MINUS,
        ExprKind::Binary(operator, ..) => level_of(*operator),
        ExprKind::IfThenElse(..) => level::IF_THEN_ELSE,
        ExprKind::Temporal { left: None, .. } => level::TEMPORAL_UNARY,
        ExprKind::Temporal { .. } => level::TEMPORAL_BINARY,
        _ => level::BASIC,
    }
}

/// Writes an expression where one of at least this level must stand.
fn write_expr(f: &mut Formatter<'_>, expr: &Expr, least: u8) -> fmt::Result {
    if own_level(expr) < least {
        f.write_str("(")?;
        write_bare(f, expr)?;
        return f.write_str(")");
    }
    write_bare(f, expr)
}

fn write_bare(f: &mut Formatter<'_>, expr: &Expr) -> fmt::Result {
    match &expr.kind {
        ExprKind::Bool(value) => write!(f, "{value}"),
        ExprKind::Int(value) => write!(f, "{value}"),
        ExprKind::Double(text) | ExprKind::Name(text) => f.write_str(text),
        ExprKind::Label(name) => write!(f, "\"{name}\""),
        ExprKind::Unary(operator, operand) => write_unary(f, *operator, operand),
        ExprKind::Binary(operator, a, b) => write_binary(f, *operator, a, b),
        ExprKind::IfThenElse(condition, then, otherwise) => {
            write_expr(f, condition, level::IMPLIES)?;
            f.write_str(" ? ")?;
            write_expr(f, then, level::IMPLIES)?;
            f.write_str(" : ")?;
            write_expr(f, otherwise, level::IF_THEN_ELSE)
        }
        ExprKind::Call(function, arguments) => {
            write!(f, "{}(", function.text)?;
            for (i, argument) in arguments.iter().enumerate() {
                f.write_str(if i == 0 { "" } else { ", " })?;
                write_expr(f, argument, level::TEMPORAL_BINARY)?;
            }
            f.write_str(")")
        }
        ExprKind::Interval(low, high) => write!(f, "[{low},{high}]"),
        ExprKind::Probability { .. }
        | ExprKind::Reward(_)
        | ExprKind::LongRun { .. }
        | ExprKind::Quantified(..)
        | ExprKind::Strategy(_)
        | ExprKind::Filter(_) => property::write_operator(f, &expr.kind),
        ExprKind::Temporal {
            operator,
            bound,
            left,
            right,
        } => write_temporal(f, *operator, bound.as_deref(), left.as_deref(), right),
        ExprKind::Error => f.write_str("?"),
    }
}

fn write_unary(f: &mut Formatter<'_>, operator: UnaryOp, operand: &Expr) -> fmt::Result {
    match operator {
        UnaryOp::Not => {
            f.write_str("!")?;
            // `!a=b` means `!(a=b)`: the parentheses are for the reader.
            let doubled = matches!(operand.kind, ExprKind::Unary(UnaryOp::Not, _));
            write_expr(f, operand, if doubled { level::NOT } else { level::BASIC })
        }
        UnaryOp::Minus => {
            f.write_str("-")?;
            write_expr(f, operand, level::MINUS)
        }
    }
}

fn write_binary(f: &mut Formatter<'_>, operator: BinaryOp, a: &Expr, b: &Expr) -> fmt::Result {
    let (left, right) = operand_levels(operator);
    write_expr(f, a, left)?;
    let spaced = level_of(operator) <= level::AND;
    let symbol = operator.symbol();
    if spaced {
        write!(f, " {symbol} ")?;
    } else {
        f.write_str(symbol)?;
        // `<` and `<<*>>` must not run together.
        f.write_str(if symbol == "<" && starts_with_strategy(b) {
            " "
        } else {
            ""
        })?;
    }
    write_expr(f, b, right)
}

fn starts_with_strategy(expr: &Expr) -> bool {
    match &expr.kind {
        ExprKind::Strategy(_) => true,
        ExprKind::Binary(_, first, _) | ExprKind::IfThenElse(first, ..) => {
            starts_with_strategy(first)
        }
        _ => false,
    }
}

fn write_temporal(
    f: &mut Formatter<'_>,
    operator: TemporalOp,
    bound: Option<&StepBound>,
    left: Option<&Expr>,
    right: &Expr,
) -> fmt::Result {
    if let Some(left) = left {
        write_expr(f, left, level::TEMPORAL_UNARY)?;
        f.write_str(" ")?;
    }
    f.write_str(operator.symbol())?;
    let open_ended = !matches!(bound, None | Some(StepBound::Between(..)));
    match bound {
        None => {}
        Some(StepBound::Compare(comparison, steps)) => {
            f.write_str(comparison.symbol())?;
            write_steps(f, steps)?;
        }
        Some(StepBound::Exactly(steps)) => {
            f.write_str("=")?;
            write_steps(f, steps)?;
        }
        Some(StepBound::Between(low, high)) => write!(f, "[{low},{high}]")?,
    }
    f.write_str(" ")?;
    // Nothing separates an open-ended bound from an operand such as `-1<x`.
    write_expr(
        f,
        right,
        if open_ended {
            level::BASIC
        } else {
            level::TEMPORAL_UNARY
        },
    )
}

/// Steps without a bracket behind them: anything but a literal or a name takes parentheses.
fn write_steps(f: &mut Formatter<'_>, steps: &Expr) -> fmt::Result {
    match steps.kind {
        ExprKind::Int(_) | ExprKind::Double(_) | ExprKind::Name(_) => write!(f, "{steps}"),
        _ => write!(f, "({steps})"),
    }
}

impl Display for Model {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        if let Some((model_type, _)) = self.model_type {
            writeln!(f, "{}", model_type.keyword())?;
        }
        write_lines(f, "", &self.constants)?;
        write_lines(f, "", &self.formulas)?;
        for variable in &self.globals {
            writeln!(f, "global {variable}")?;
        }
        write_lines(f, "", &self.observables)?;
        write_lines(f, "", &self.modules)?;
        write_lines(f, "", &self.systems)?;
        if let Some(init) = &self.init {
            writeln!(f, "init {init} endinit")?;
        }
        write_lines(f, "", &self.labels)?;
        write_lines(f, "", &self.rewards)
    }
}

impl Display for PropertyFile {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write_lines(f, "", &self.constants)?;
        write_lines(f, "", &self.formulas)?;
        write_lines(f, "", &self.labels)?;
        write_lines(f, "", &self.properties)
    }
}

fn write_lines<T: Display>(f: &mut Formatter<'_>, indent: &str, items: &[T]) -> fmt::Result {
    items
        .iter()
        .try_for_each(|item| writeln!(f, "{indent}{item}"))
}

impl Display for Property {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        if let Some(name) = &self.name {
            write!(f, "\"{}\": ", name.text)?;
        }
        write!(f, "{};", self.formula)
    }
}

impl Display for Constant {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "const {} {}", self.ty.keyword(), self.name.text)?;
        if let Some(value) = &self.value {
            write!(f, " = {value}")?;
        }
        f.write_str(";")
    }
}

impl Display for Formula {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "formula {} = {};", self.name.text, self.body)
    }
}

impl Display for Label {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "label \"{}\" = {};", self.name.text, self.body)
    }
}

impl Display for Variable {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "{} : ", self.name.text)?;
        match &self.range {
            VariableRange::Bool => f.write_str("bool")?,
            VariableRange::Int { low, high } => write!(f, "[{low}..{high}]")?,
            VariableRange::Unbounded => f.write_str("int")?,
            VariableRange::Clock => f.write_str("clock")?,
        }
        if let Some(init) = &self.init {
            write!(f, " init {init}")?;
        }
        f.write_str(";")
    }
}

impl Display for Module {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "module {}", self.name.text)?;
        match &self.body {
            ModuleBody::Renamed { base, renames } => {
                let pairs: Vec<String> = renames
                    .iter()
                    .map(|(old, new)| format!("{}={}", old.text, new.text))
                    .collect();
                write!(f, " = {} [{}] endmodule", base.text, pairs.join(", "))
            }
            ModuleBody::Written {
                variables,
                invariant,
                commands,
            } => {
                writeln!(f)?;
                write_lines(f, "  ", variables)?;
                if let Some(invariant) = invariant {
                    writeln!(f, "  invariant {invariant} endinvariant")?;
                }
                write_lines(f, "  ", commands)?;
                f.write_str("endmodule")
            }
        }
    }
}

impl Display for Command {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let action = self.action.as_ref().map_or("", |a| &a.text);
        write!(f, "[{action}] {} -> ", self.guard)?;
        for (i, update) in self.updates.iter().enumerate() {
            write!(f, "{}{update}", if i == 0 { "" } else { " + " })?;
        }
        f.write_str(";")
    }
}

impl Display for Update {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        if let Some(probability) = &self.probability {
            // `true` at the start would be read as an update.
            let text = probability.to_string();
            if text.starts_with("true") {
                write!(f, "({text}) : ")?;
            } else {
                write!(f, "{text} : ")?;
            }
        }
        if self.assignments.is_empty() {
            return f.write_str("true");
        }
        for (i, assignment) in self.assignments.iter().enumerate() {
            f.write_str(if i == 0 { "" } else { " & " })?;
            write!(f, "({}'={})", assignment.variable.text, assignment.value)?;
        }
        Ok(())
    }
}

impl Display for RewardStructure {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str("rewards")?;
        if let Some(name) = &self.name {
            write!(f, " \"{}\"", name.text)?;
        }
        writeln!(f)?;
        write_lines(f, "  ", &self.items)?;
        f.write_str("endrewards")
    }
}

impl Display for RewardItem {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match &self.kind {
            RewardKind::State => {}
            RewardKind::Transition(action) => {
                write!(f, "[{}] ", action.as_ref().map_or("", |a| &a.text))?;
            }
        }
        write!(f, "{} : {};", self.guard, self.value)
    }
}
