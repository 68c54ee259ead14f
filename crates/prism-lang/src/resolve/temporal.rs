//! Temporal operators and their bounds: whole steps, or times where time is continuous.

use super::checks::is_negative;
use super::formula::Formula;
use super::properties::PropertyResolver;
use super::scope::Renaming;
use crate::ast::{self, Comparison, StepBound, TemporalOp, Type};
use crate::diagnostic::{Diagnostic, Span};
use crate::number::{Number, Value};
use crate::property::{Horizon, Path, TimeBound, TimeInterval, TimedOperator};

/// When an operand counts.
enum When {
    Steps(TimeBound),
    Time(TimeInterval),
}

impl<'a> PropertyResolver<'a> {
    pub(super) fn temporal(
        &mut self,
        operator: TemporalOp,
        bound: Option<&'a StepBound>,
        left: Option<&'a ast::Expr>,
        right: &'a ast::Expr,
        span: Span,
    ) -> Option<Formula> {
        let when = match bound {
            None => Some(When::Steps(TimeBound::default())),
            Some(_) if operator == TemporalOp::Next => {
                let message = "`X` cannot have a bound.";
                let error = Diagnostic::error("bounded-next", span, message);
                self.scope
                    .report(error.remedy("Write `F=k` for a formula at exactly step k."));
                None
            }
            Some(bound) if self.model.model_type.has_continuous_time() => {
                self.time_interval(bound, span).map(When::Time)
            }
            Some(bound) => self.step_bound(bound, span).map(When::Steps),
        };
        let left = left.map(|l| self.path(l).map(Box::new));
        let right = self.path(right).map(Box::new);
        let left = match left {
            Some(left) => Some(left?),
            None => None,
        };
        let right = right?;
        let path = match when? {
            When::Steps(bound) => in_steps(operator, left, right, bound)?,
            When::Time(interval) => Path::Timed {
                operator: timed(operator)?,
                left,
                right,
                interval,
            },
        };
        Some(Formula::Path(path))
    }

    fn step_bound(&mut self, bound: &'a StepBound, span: Span) -> Option<TimeBound> {
        let mut time = TimeBound::default();
        match bound {
            StepBound::Compare(comparison, steps) => {
                let steps = self.steps(steps)?;
                match comparison {
                    Comparison::Less => time.upper = Some((steps, true)),
                    Comparison::LessEqual => time.upper = Some((steps, false)),
                    Comparison::Greater => time.lower = Some((steps, true)),
                    Comparison::GreaterEqual => time.lower = Some((steps, false)),
                }
            }
            StepBound::Exactly(steps) => {
                let steps = self.steps(steps)?;
                time.lower = Some((steps, false));
                time.upper = Some((steps, false));
            }
            StepBound::Between(low, high) => {
                let (low, high) = (self.steps(low), self.steps(high));
                time.lower = Some((low?, false));
                time.upper = Some((high?, false));
            }
        }
        let empty = match time.upper {
            Some((0, true)) => true,
            Some(_) => time
                .last_step()
                .is_some_and(|last| last < time.first_step()),
            None => false,
        };
        if empty {
            self.empty_bound("no step satisfies this bound.", span);
            return None;
        }
        Some(time)
    }

    fn time_interval(&mut self, bound: &'a StepBound, span: Span) -> Option<TimeInterval> {
        let mut time = TimeInterval::default();
        match bound {
            StepBound::Compare(comparison, end) => {
                let end = self.time(end)?;
                match comparison {
                    Comparison::Less => time.upper = Some((end, true)),
                    Comparison::LessEqual => time.upper = Some((end, false)),
                    Comparison::Greater => time.lower = Some((end, true)),
                    Comparison::GreaterEqual => time.lower = Some((end, false)),
                }
            }
            StepBound::Exactly(at) => {
                let at = self.time(at)?;
                time.lower = Some((at.clone(), false));
                time.upper = Some((at, false));
            }
            StepBound::Between(low, high) => {
                let (low, high) = (self.time(low), self.time(high));
                time.lower = Some((low?, false));
                time.upper = Some((high?, false));
            }
        }
        let empty = match (&time.lower, &time.upper) {
            (Some((low, _)), Some((high, _))) => high < low,
            (None, Some((high, true))) => *high == Number::from_i64(0),
            _ => false,
        };
        if empty {
            self.empty_bound("no time satisfies this bound.", span);
            return None;
        }
        Some(time)
    }

    fn empty_bound(&mut self, message: &str, span: Span) {
        let error = Diagnostic::error("empty-bound", span, message);
        self.scope
            .report(error.remedy("Write the smaller number of steps first."));
    }

    /// Steps, or a time where that is continuous.
    pub(super) fn horizon(&mut self, expr: &'a ast::Expr) -> Option<Horizon> {
        if self.model.model_type.has_continuous_time() {
            return self.time(expr).map(Horizon::Time);
        }
        let steps = self.steps(expr)?;
        Some(Horizon::Steps(u64::try_from(steps).unwrap_or(0)))
    }

    fn steps(&mut self, steps: &'a ast::Expr) -> Option<i64> {
        let none = Renaming::default();
        let Some(Value::Int(value)) =
            self.scope
                .constant_value(steps, &none, Type::Int, "a number of steps")
        else {
            return None;
        };
        if value < 0 {
            let message = format!("a number of steps cannot be negative, but this is {value}.");
            let error = Diagnostic::error("negative-steps", steps.span, message);
            self.scope.report(error.remedy("Use 0 or more."));
            return None;
        }
        Some(value)
    }

    fn time(&mut self, time: &'a ast::Expr) -> Option<Number> {
        let none = Renaming::default();
        let Some(Value::Double(value)) =
            self.scope
                .constant_value(time, &none, Type::Double, "a time")
        else {
            return None;
        };
        if is_negative(&value) {
            let message = format!("a time cannot be negative, but this is {value}.");
            let error = Diagnostic::error("negative-steps", time.span, message);
            self.scope.report(error.remedy("Use 0 or more."));
            return None;
        }
        Some(value)
    }
}

/// The path formula of an operator with a bound in steps, or without one.
fn in_steps(
    operator: TemporalOp,
    left: Option<Box<Path>>,
    right: Box<Path>,
    bound: TimeBound,
) -> Option<Path> {
    Some(match (operator, left) {
        (TemporalOp::Next, _) => Path::Next(right),
        (TemporalOp::Finally, _) => Path::Finally {
            operand: right,
            bound,
        },
        (TemporalOp::Globally, _) => Path::Globally {
            operand: right,
            bound,
        },
        (TemporalOp::Until, Some(left)) => Path::Until { left, right, bound },
        (TemporalOp::WeakUntil, Some(left)) => Path::WeakUntil { left, right, bound },
        (TemporalOp::Release, Some(left)) => Path::Release { left, right, bound },
        (_, None) => return None,
    })
}

fn timed(operator: TemporalOp) -> Option<TimedOperator> {
    Some(match operator {
        TemporalOp::Next => return None,
        TemporalOp::Finally => TimedOperator::Finally,
        TemporalOp::Globally => TimedOperator::Globally,
        TemporalOp::Until => TimedOperator::Until,
        TemporalOp::WeakUntil => TimedOperator::WeakUntil,
        TemporalOp::Release => TimedOperator::Release,
    })
}
