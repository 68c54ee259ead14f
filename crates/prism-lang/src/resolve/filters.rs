//! Filters, strategies of players, and queries with several objectives.

use super::formula::Formula;
use super::properties::PropertyResolver;
use crate::ast::{self, Coalition, Optimum, Quantifier};
use crate::diagnostic::{Diagnostic, Span};
use crate::property::{Filter, FilterOperand, FilterOperator, Objective, Quantity, StateFormula};
use crate::suggest::suggest;

impl<'a> PropertyResolver<'a> {
    pub(super) fn filter(&mut self, filter: &'a ast::Filter, span: Span) -> Option<Formula> {
        let operator = FilterOperator::from_word(&filter.operator.text);
        if operator.is_none() {
            self.unknown_filter(&filter.operator);
        }
        let operand = self.formula(&filter.operand);
        let states = match &filter.states {
            Some(states) => Some(self.state(states, "the states of a filter")?),
            None => None,
        };
        self.filtered(operator?, operand?, states, filter.operand.span.to(span))
    }

    fn unknown_filter(&mut self, name: &ast::Name) {
        let known = FilterOperator::ALL.map(FilterOperator::word);
        let remedy = match suggest(&name.text, known) {
            Some(near) => format!("Did you mean `{near}`?"),
            None => format!("The filters are {}.", known.join(", ")),
        };
        let message = format!("there is no filter `{}`.", name.text);
        let error = Diagnostic::error("unknown-function", name.span, message);
        self.scope.report(error.remedy(remedy));
    }

    /// The filter over an operand, if it is of the kind that the filter needs.
    fn filtered(
        &mut self,
        operator: FilterOperator,
        operand: Formula,
        states: Option<StateFormula>,
        span: Span,
    ) -> Option<Formula> {
        let operand = match operand {
            Formula::State(truth) if !operator.needs_numbers() => FilterOperand::Truth(truth),
            Formula::Number(number) if !operator.needs_truth() => FilterOperand::Number(number),
            _ => {
                let needed = if operator.needs_numbers() {
                    "a number in each state"
                } else if operator.needs_truth() {
                    "something true or false in each state"
                } else {
                    "a number or something true or false in each state"
                };
                let message = format!("filter `{}` needs {needed}.", operator.word());
                let error = Diagnostic::error("type", span, message);
                let remedy = "Numbers have the filters min, max, sum, avg and range; truth values forall, exists and count.";
                self.scope.report(error.remedy(remedy));
                return None;
            }
        };
        let is_truth = match operator {
            FilterOperator::ArgMin | FilterOperator::ArgMax => true,
            FilterOperator::Count => false,
            _ => matches!(operand, FilterOperand::Truth(_)),
        };
        let filter = Filter {
            operator,
            operand,
            states,
        };
        Some(match operator {
            FilterOperator::Range => Formula::Range(filter),
            _ if is_truth => Formula::State(StateFormula::Filter(Box::new(filter))),
            _ => Formula::Number(Quantity::Filter(Box::new(filter))),
        })
    }

    /// `{states}{min}` within an operator: what has a bound must hold in all of the states, a number is asked for
    /// in the only one of them, or its least or greatest value.
    pub(super) fn old_filter(
        &mut self,
        formula: Option<Formula>,
        filter: &'a ast::StateFilter,
    ) -> Option<Formula> {
        let states = self.state(&filter.states, "the states of a filter")?;
        let formula = formula?;
        let operator = match (&formula, filter.min, filter.max) {
            (Formula::State(_), ..) => FilterOperator::ForAll,
            (_, true, true) => FilterOperator::Range,
            (_, true, false) => FilterOperator::Min,
            (_, false, true) => FilterOperator::Max,
            (_, false, false) => FilterOperator::State,
        };
        self.filtered(operator, formula, Some(states), filter.states.span)
    }

    /// `<<...>>` (some choice of the players) and `[[...]]` (every choice): here there is one player or none.
    pub(super) fn strategy(&mut self, strategy: &'a ast::Strategy, span: Span) -> Option<Formula> {
        let operand = self.formula(&strategy.operand);
        let problem = match &strategy.coalition {
            _ if !self.model.model_type.has_choices() => Some((
                "the model has no choices, so there is no strategy.".to_owned(),
                "Ask for the probability itself, or use an `mdp`.",
            )),
            Coalition::Players(players) if !players.is_empty() => Some((
                format!(
                    "player `{}` belongs to games of several players, which are not supported yet.",
                    players[0].text
                ),
                "Write `<<*>>` for the scheduler, `<<>>` for no player.",
            )),
            _ => None,
        };
        if let Some((message, remedy)) = problem {
            let error = Diagnostic::error("unsupported", span, message);
            self.scope.report(error.remedy(remedy));
            return None;
        }
        // Nobody can choose to reach what everybody must avoid, and the other way round.
        let all = strategy.coalition == Coalition::All;
        let by_some = (strategy.quantifier == Quantifier::Exists) == all;
        match operand? {
            number @ Formula::Number(Quantity::Probability { .. } | Quantity::Reward { .. }) => {
                Some(number)
            }
            Formula::State(
                bounded @ (StateFormula::Probability { .. } | StateFormula::Reward { .. }),
            ) => Some(Formula::State(match by_some {
                true => StateFormula::SomeScheduler(Box::new(bounded)),
                false => bounded,
            })),
            _ => {
                let message = "a strategy can be asked for one `P` or `R` only.";
                let error = Diagnostic::error("unsupported", span, message);
                self.scope
                    .report(error.remedy("Write the operator directly behind the players."));
                None
            }
        }
    }

    /// `multi(...)`: values first, then what must hold.
    pub(super) fn objectives(&mut self, arguments: &'a [ast::Expr], span: Span) -> Option<Formula> {
        if !self.model.model_type.has_choices() {
            let message = "`multi` asks for one scheduler, but the model has no choices.";
            let error = Diagnostic::error("unsupported", span, message);
            self.scope
                .report(error.remedy("Ask for each probability on its own, or use an `mdp`."));
            return None;
        }
        let mut objectives = Some(Vec::new());
        let mut bounded = None;
        for argument in arguments {
            let Some(objective) = self.objective(argument) else {
                objectives = None;
                continue;
            };
            match (&objective, bounded) {
                (Objective::Require(_), _) => bounded = Some(argument.span),
                (Objective::Optimise(..), Some(first)) => {
                    let message =
                        "in `multi`, what asks for a value comes before what has a bound.";
                    let error = Diagnostic::error("type", argument.span, message)
                        .related(first, "this has a bound");
                    self.scope.report(error.remedy("Change the order."));
                }
                _ => {}
            }
            if let Some(known) = &mut objectives {
                known.push(objective);
            }
        }
        objectives.map(Formula::Objectives)
    }

    fn objective(&mut self, argument: &'a ast::Expr) -> Option<Objective> {
        match self.formula(argument)? {
            Formula::Number(
                number @ (Quantity::Probability {
                    optimum: Some(optimum @ (Optimum::Min | Optimum::Max)),
                    ..
                }
                | Quantity::Reward {
                    optimum: Some(optimum @ (Optimum::Min | Optimum::Max)),
                    ..
                }),
            ) => Some(Objective::Optimise(optimum, number)),
            Formula::State(
                bounded @ (StateFormula::Probability { .. } | StateFormula::Reward { .. }),
            ) => Some(Objective::Require(bounded)),
            _ => {
                let message = "an objective of `multi` must be one `P` or `R`.";
                let error = Diagnostic::error("type", argument.span, message);
                let remedy = "Write objectives such as `Pmax=? [ ... ]` or `R>=5 [ C ]`.";
                self.scope.report(error.remedy(remedy));
                None
            }
        }
    }
}
