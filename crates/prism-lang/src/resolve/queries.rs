//! The operators `P`, `R`, `S`, `A` and `E`: their bounds, over which schedulers, and of which reward.

use super::checks::is_probability;
use super::formula::Formula;
use super::properties::PropertyResolver;
use super::scope::Renaming;
use crate::ast::{self, Comparison, ExprKind, Optimum, Quantifier, RewardIndex, Type};
use crate::diagnostic::{Diagnostic, Span};
use crate::number::{Number, Value};
use crate::property::{Path, Quantity, RewardObjective, RewardQuery, StateFormula};
use crate::suggest::suggest;

/// A comparison and a bound as written.
type WrittenBound = Option<(Comparison, Box<ast::Expr>)>;

impl<'a> PropertyResolver<'a> {
    /// `P`, `S` or `R`, with the old form of a filter if it has one.
    pub(super) fn query(&mut self, expr: &'a ast::Expr) -> Option<Formula> {
        let (formula, filter) = match &expr.kind {
            ExprKind::Probability {
                optimum,
                bound,
                path,
                condition,
                filter,
            } => {
                let formula = match condition {
                    Some(given) => self.conditional(*optimum, bound, (path, given), expr.span),
                    None => self.probability(*optimum, bound, path, expr.span),
                };
                (formula, filter.as_deref())
            }
            ExprKind::LongRun {
                bound,
                states,
                filter,
            } => (self.long_run(bound, states, expr.span), filter.as_deref()),
            ExprKind::Reward(reward) => (self.reward(reward, expr.span), reward.filter.as_ref()),
            _ => return None,
        };
        match filter {
            Some(filter) => self.old_filter(formula, filter),
            None => formula,
        }
    }

    fn probability(
        &mut self,
        optimum: Option<Optimum>,
        bound: &'a WrittenBound,
        path: &'a ast::Expr,
        span: Span,
    ) -> Option<Formula> {
        let bound = self.bound(bound, true);
        let optimum = self.optimum("P", optimum, matches!(bound, Some(None)), span);
        let path = Box::new(self.path(path)?);
        let optimum = optimum?;
        Some(match bound? {
            Some(bound) => Formula::State(StateFormula::Probability { bound, path }),
            None => Formula::Number(Quantity::Probability { optimum, path }),
        })
    }

    /// `P=? [ path || condition ]`; with a bound, a comparison of the worst case.
    fn conditional(
        &mut self,
        optimum: Option<Optimum>,
        bound: &'a WrittenBound,
        (path, condition): (&'a ast::Expr, &'a ast::Expr),
        span: Span,
    ) -> Option<Formula> {
        let limit = self.bound(bound, true);
        let optimum = self.optimum("P", optimum, matches!(limit, Some(None)), span);
        let path = self.path(path);
        let given = Box::new(self.path(condition)?);
        if matches!(*given, Path::State(_)) {
            let message = "what stands behind `||` is a condition on paths, but this has no temporal operator.";
            let error = Diagnostic::error("condition", condition.span, message);
            let remedy =
                "Write `|` if one of the two is to hold, or for example `P=? [ F a || G b ]`.";
            self.scope.report(error.remedy(remedy));
            return None;
        }
        let condition = given;
        let (path, optimum) = (Box::new(path?), optimum?);
        let Some((comparison, limit)) = limit? else {
            return Some(Formula::Number(Quantity::Conditional {
                optimum,
                path,
                condition,
            }));
        };
        let least = matches!(comparison, Comparison::Greater | Comparison::GreaterEqual);
        let worst = if least { Optimum::Min } else { Optimum::Max };
        let conditional = Quantity::Conditional {
            optimum: self.model.model_type.has_choices().then_some(worst),
            path,
            condition,
        };
        let limit = Quantity::Expr(crate::expr::Expr::double(limit, span));
        let operator = comparison.operator();
        let compared = StateFormula::Compare(operator, Box::new(conditional), Box::new(limit));
        Some(Formula::State(compared))
    }

    fn long_run(
        &mut self,
        bound: &'a WrittenBound,
        states: &'a ast::Expr,
        span: Span,
    ) -> Option<Formula> {
        let bound = self.bound(bound, true);
        let states = Box::new(self.state(states, "the contents of `S`")?);
        if self.model.model_type.has_choices() {
            let kind = self.model.model_type.keyword();
            let message = format!("`S` is not defined in an {kind}: it depends on the scheduler.");
            let error = Diagnostic::error("unsupported", span, message);
            let remedy =
                "Use a `dtmc` or `ctmc`, or a reward in the long run: `R{...}max=? [ S ]`.";
            self.scope.report(error.remedy(remedy));
            return None;
        }
        Some(match bound? {
            Some(bound) => Formula::State(StateFormula::LongRun { bound, states }),
            None => Formula::Number(Quantity::LongRun(states)),
        })
    }

    fn reward(&mut self, reward: &'a ast::Reward, span: Span) -> Option<Formula> {
        let bound = self.bound(&reward.bound, false);
        let optimum = self.optimum("R", reward.optimum, matches!(bound, Some(None)), span);
        let structure = self.reward_structure(reward.structure.as_ref(), span);
        let divisor = match &reward.divisor {
            Some(index) => self.reward_structure(Some(index), span).map(Some),
            None => Some(None),
        };
        let objective = self.reward_objective(&reward.objective);
        let reward = RewardQuery {
            structure: structure?,
            divisor: divisor?,
            objective: objective?,
        };
        let optimum = optimum?;
        Some(match bound? {
            Some(bound) => Formula::State(StateFormula::Reward { bound, reward }),
            None => Formula::Number(Quantity::Reward { optimum, reward }),
        })
    }

    /// The exact bound (`Some(None)`: there is none); of a probability, between 0 and 1.
    fn bound(
        &mut self,
        bound: &'a WrittenBound,
        of_probability: bool,
    ) -> Option<Option<(Comparison, Number)>> {
        let Some((comparison, bound)) = bound else {
            return Some(None);
        };
        let none = Renaming::default();
        let what = match of_probability {
            true => "the bound of a probability",
            false => "the bound of a reward",
        };
        let Some(Value::Double(number)) =
            self.scope.constant_value(bound, &none, Type::Double, what)
        else {
            return None;
        };
        if of_probability && !is_probability(&number) {
            let message = format!("the bound {number} is not between 0 and 1.");
            let error = Diagnostic::error("not-a-probability", bound.span, message);
            self.scope
                .report(error.remedy("Compare with a number between 0 and 1."));
            return None;
        }
        Some(Some((*comparison, number)))
    }

    /// Over which schedulers (`Some(None)`: there are none to choose from).
    fn optimum(
        &mut self,
        letter: &str,
        optimum: Option<Optimum>,
        is_query: bool,
        span: Span,
    ) -> Option<Option<Optimum>> {
        let kind = self.model.model_type;
        let (code, message, remedy) = match optimum {
            Some(Optimum::Min | Optimum::Max) if kind.has_choices() => return Some(optimum),
            // Least and greatest are the same where nothing is chosen.
            Some(Optimum::Min | Optimum::Max) => return Some(None),
            None if !kind.has_choices() || !is_query => return Some(None),
            None => (
                "no-optimum",
                format!(
                    "`{letter}=?` has no single value in an {}: it depends on the scheduler.",
                    kind.keyword()
                ),
                format!("Write `{letter}min=?` or `{letter}max=?`."),
            ),
            Some(of_intervals) => {
                let word = of_intervals.word();
                (
                    "unsupported",
                    format!(
                        "`{letter}{word}` belongs to models whose probabilities are intervals, which are not supported yet."
                    ),
                    format!("Write `{letter}min=?` or `{letter}max=?`."),
                )
            }
        };
        let error = Diagnostic::error(code, span, message);
        self.scope.report(error.remedy(remedy));
        None
    }

    /// The index of a reward structure, counted from 0.
    fn reward_structure(&mut self, index: Option<&'a RewardIndex>, span: Span) -> Option<usize> {
        let count = self.model.rewards.len();
        let (span, message) = match index {
            _ if count == 0 => (span, "the model has no reward structure.".to_owned()),
            None => return Some(0),
            Some(RewardIndex::Name(name)) => {
                if let Some(found) = self.model.reward(&name.text) {
                    return Some(found);
                }
                (
                    name.span,
                    format!("there is no reward structure \"{}\".", name.text),
                )
            }
            Some(RewardIndex::Index(index)) => {
                let (none, what) = (Renaming::default(), "the number of a reward structure");
                let Some(Value::Int(number)) =
                    self.scope.constant_value(index, &none, Type::Int, what)
                else {
                    return None;
                };
                let found = usize::try_from(number)
                    .ok()
                    .filter(|n| (1..=count).contains(n));
                if let Some(found) = found {
                    return Some(found - 1);
                }
                let message = format!(
                    "there is no reward structure {number}: they are counted from 1 to {count}."
                );
                (index.span, message)
            }
        };
        let remedy = self.known_rewards(index);
        let error = Diagnostic::error("unknown-reward", span, message);
        self.scope.report(error.remedy(remedy));
        None
    }

    fn known_rewards(&self, index: Option<&RewardIndex>) -> String {
        let known = || self.model.rewards.iter().filter_map(|r| r.name.as_deref());
        if let Some(RewardIndex::Name(name)) = index
            && let Some(near) = suggest(&name.text, known())
        {
            return format!("Did you mean \"{near}\"?");
        }
        let names: Vec<String> = known().map(|n| format!("\"{n}\"")).collect();
        match names.is_empty() {
            true => "Define one with `rewards \"name\" ... endrewards`.".to_owned(),
            false => format!("The model has {}.", names.join(", ")),
        }
    }

    fn reward_objective(&mut self, written: &'a ast::RewardObjective) -> Option<RewardObjective> {
        Some(match written {
            ast::RewardObjective::Total => RewardObjective::Total,
            ast::RewardObjective::LongRun => RewardObjective::LongRun,
            ast::RewardObjective::Cumulative(end) => {
                RewardObjective::Cumulative(self.horizon(end)?)
            }
            ast::RewardObjective::Instantaneous(at) => {
                RewardObjective::Instantaneous(self.horizon(at)?)
            }
            ast::RewardObjective::Path(path) => match self.path(path)? {
                Path::Finally { operand, bound } if bound.is_unbounded() => match *operand {
                    Path::State(target) => RewardObjective::Reach(target),
                    operand => self.co_safe(
                        Path::Finally {
                            operand: Box::new(operand),
                            bound,
                        },
                        path.span,
                    )?,
                },
                other => self.co_safe(other, path.span)?,
            },
        })
    }

    fn co_safe(&mut self, path: Path, span: Span) -> Option<RewardObjective> {
        if is_co_safe(&path, true) {
            return Some(RewardObjective::CoSafe(Box::new(path)));
        }
        let message =
            "the formula in `R` is not co-safe: no finite part of a path can show that it holds.";
        let error = Diagnostic::error("not-co-safe", span, message);
        let remedy = "Use `X`, `F` and `U` only (`G`, `W` and `R` under a negation).";
        self.scope.report(error.remedy(remedy));
        None
    }

    pub(super) fn path_quantifier(
        &mut self,
        quantifier: Quantifier,
        path: &'a ast::Expr,
        span: Span,
    ) -> Option<Formula> {
        let path = Box::new(self.path(path)?);
        if path.has_time_bound() {
            let letter = quantifier.symbol();
            let message = format!("bounds in time within `{letter}` are not supported.");
            let error = Diagnostic::error("unsupported", span, message);
            let remedy = "Write `P>=1 [ ... ]` for almost all paths, `P>0 [ ... ]` for some.";
            self.scope.report(error.remedy(remedy));
            return None;
        }
        Some(Formula::State(match quantifier {
            Quantifier::ForAll => StateFormula::ForAll(path),
            Quantifier::Exists => StateFormula::Exists(path),
        }))
    }
}

/// Whether a formula, or its negation if not `positive`, is syntactically co-safe: in positive normal form it has
/// the temporal operators `X`, `F` and `U` only (O. Kupferman and M. Y. Vardi, "Model checking of safety
/// properties", Formal Methods in System Design 19, 2001); a bound from above makes any operator finite.
fn is_co_safe(path: &Path, positive: bool) -> bool {
    let both = |a: &Path, b: &Path| is_co_safe(a, positive) && is_co_safe(b, positive);
    match path {
        Path::State(_) => true,
        Path::Not(operand) => is_co_safe(operand, !positive),
        Path::And(a, b) | Path::Or(a, b) => both(a, b),
        Path::Implies(a, b) => is_co_safe(a, !positive) && is_co_safe(b, positive),
        Path::Iff(a, b) => both(a, b) && is_co_safe(a, !positive) && is_co_safe(b, !positive),
        Path::Next(operand) => is_co_safe(operand, positive),
        Path::Finally { operand, bound } => {
            (positive || bound.upper.is_some()) && is_co_safe(operand, positive)
        }
        Path::Globally { operand, bound } => {
            (!positive || bound.upper.is_some()) && is_co_safe(operand, positive)
        }
        Path::Until { left, right, bound } => {
            (positive || bound.upper.is_some()) && both(left, right)
        }
        Path::WeakUntil { left, right, bound } | Path::Release { left, right, bound } => {
            (!positive || bound.upper.is_some()) && both(left, right)
        }
        Path::Timed { .. } => false,
    }
}
