//! The operators of properties: `P`, `R`, `S`, `A`, `E`, strategies and filters.

use std::fmt::{self, Formatter};

use super::write_expr;
use crate::ast::{
    Coalition, Comparison, Expr, ExprKind, Filter, Optimum, Quantifier, Reward, RewardIndex,
    RewardObjective, StateFilter, Strategy,
};
use crate::parser::operator::level;

/// Writes an operator that only properties contain.
pub(super) fn write_operator(f: &mut Formatter<'_>, kind: &ExprKind) -> fmt::Result {
    match kind {
        ExprKind::Probability {
            optimum,
            bound,
            path,
            condition,
            filter,
        } => {
            write_query(f, "P", *optimum, bound.as_ref())?;
            write!(f, " [ {path}")?;
            if let Some(condition) = condition {
                write!(f, " || {condition}")?;
            }
            write_state_filter(f, filter.as_deref())?;
            f.write_str(" ]")
        }
        ExprKind::LongRun {
            bound,
            states,
            filter,
        } => {
            write_query(f, "S", None, bound.as_ref())?;
            write!(f, " [ {states}")?;
            write_state_filter(f, filter.as_deref())?;
            f.write_str(" ]")
        }
        ExprKind::Reward(reward) => write_reward(f, reward),
        ExprKind::Quantified(quantifier, path) => write!(f, "{} [ {path} ]", quantifier.symbol()),
        ExprKind::Strategy(strategy) => write_strategy(f, strategy),
        ExprKind::Filter(filter) => write_filter(f, filter),
        _ => Ok(()),
    }
}

fn write_query(
    f: &mut Formatter<'_>,
    letter: &str,
    optimum: Option<Optimum>,
    bound: Option<&(Comparison, Box<Expr>)>,
) -> fmt::Result {
    write!(f, "{letter}{}", optimum.map_or("", Optimum::word))?;
    match bound {
        None => f.write_str("=?"),
        Some((comparison, bound)) => {
            f.write_str(comparison.symbol())?;
            write_expr(f, bound, level::BASIC)
        }
    }
}

fn write_state_filter(f: &mut Formatter<'_>, filter: Option<&StateFilter>) -> fmt::Result {
    let Some(filter) = filter else { return Ok(()) };
    write!(f, " {{{}}}", filter.states)?;
    f.write_str(if filter.min { "{min}" } else { "" })?;
    f.write_str(if filter.max { "{max}" } else { "" })
}

fn write_reward(f: &mut Formatter<'_>, reward: &Reward) -> fmt::Result {
    f.write_str("R")?;
    write_index(f, reward.structure.as_ref())?;
    if reward.divisor.is_some() {
        f.write_str("/")?;
        write_index(f, reward.divisor.as_ref())?;
    }
    write_query(f, "", reward.optimum, reward.bound.as_ref())?;
    f.write_str(" [ ")?;
    match &reward.objective {
        RewardObjective::Total => f.write_str("C")?,
        RewardObjective::Cumulative(bound) => write!(f, "C<={bound}")?,
        RewardObjective::Instantaneous(time) => write!(f, "I={time}")?,
        RewardObjective::LongRun => f.write_str("S")?,
        RewardObjective::Path(path) => write!(f, "{path}")?,
    }
    write_state_filter(f, reward.filter.as_ref())?;
    f.write_str(" ]")
}

fn write_index(f: &mut Formatter<'_>, index: Option<&RewardIndex>) -> fmt::Result {
    match index {
        None => Ok(()),
        Some(RewardIndex::Name(name)) => write!(f, "{{\"{}\"}}", name.text),
        Some(RewardIndex::Index(index)) => write!(f, "{{{index}}}"),
    }
}

fn write_strategy(f: &mut Formatter<'_>, strategy: &Strategy) -> fmt::Result {
    let (open, close) = match strategy.quantifier {
        Quantifier::Exists => ("<<", ">>"),
        Quantifier::ForAll => ("[[", "]]"),
    };
    f.write_str(open)?;
    match &strategy.coalition {
        Coalition::All => f.write_str("*")?,
        Coalition::Players(players) => {
            for (i, player) in players.iter().enumerate() {
                write!(f, "{}{}", if i == 0 { "" } else { "," }, player.text)?;
            }
        }
    }
    write!(f, "{close} ")?;
    match strategy.operand.kind {
        ExprKind::Probability { .. } | ExprKind::Reward(_) => write!(f, "{}", strategy.operand),
        _ => write!(f, "({})", strategy.operand),
    }
}

fn write_filter(f: &mut Formatter<'_>, filter: &Filter) -> fmt::Result {
    write!(f, "filter({}, {}", filter.operator.text, filter.operand)?;
    if let Some(states) = &filter.states {
        write!(f, ", {states}")?;
    }
    f.write_str(")")
}
