//! A property of the model checker as a formula for traces.
//!
//! Labels become propositions, and steps become time by the declared duration
//! of a step. The trace is taken as all there is: a path formula is judged by
//! LTL on finite traces (G. De Giacomo and M. Y. Vardi, "Linear temporal logic
//! and linear dynamic logic on finite traces", IJCAI 2013).

use prism_lang::ast::{BinaryOp, Comparison, Expr, ExprKind, StepBound, TemporalOp, UnaryOp};
use study::{FormulaRule, JudgingForm, Rule, Study, Vocabulary};
use temporal::formula::{AtomId, AtomText, Bound, Ending, Formula, Interval, Parsed, TimeModel};

/// The form in which traces are judged by the property `text`.
///
/// # Errors
/// Why traces cannot be judged by it, as a clause.
pub fn judged_on_traces(study: &Study, text: &str) -> Result<JudgingForm, String> {
    judged_on_paths(&study.vocabulary, study.about.model.step_secs(), text)
}

/// The same, with propositions that mean to traces what `vocabulary` says, such
/// as paths of a model.
///
/// # Errors
/// Why traces cannot be judged by it, as a clause.
pub fn judged_on_paths(
    vocabulary: &Vocabulary,
    step_secs: Option<f64>,
    text: &str,
) -> Result<JudgingForm, String> {
    let file = prism_lang::parse_properties(text).tree;
    let property = file.properties.first().ok_or("there is no property")?;
    let ExprKind::Probability {
        path,
        condition: None,
        ..
    } = &property.formula.kind
    else {
        return Err("it asks for no probability of paths".into());
    };
    let mut reader = Reader {
        vocabulary,
        step_secs,
        atoms: Vec::new(),
    };
    let formula = reader.formula(path)?;
    let parsed = Parsed {
        formula,
        atoms: reader.atoms,
    };
    let text = parsed.to_string();
    Ok(JudgingForm {
        rule: Rule::Formula(FormulaRule {
            resolved: text.clone(),
            text,
            trigger_text: None,
            parsed,
            trigger: None,
            time: TimeModel::Discrete,
            ending: Ending::Finite,
            place: None,
        }),
        clock: None,
        start_within_secs: study::START_WITHIN_SECS,
        from_sentence: false,
    })
}

struct Reader<'a> {
    vocabulary: &'a Vocabulary,
    step_secs: Option<f64>,
    atoms: Vec<AtomText>,
}

impl Reader<'_> {
    fn formula(&mut self, expr: &Expr) -> Result<Formula, String> {
        match &expr.kind {
            ExprKind::Bool(true) => Ok(Formula::True),
            ExprKind::Bool(false) => Ok(Formula::False),
            ExprKind::Label(name) => self.atom(name),
            ExprKind::Unary(UnaryOp::Not, inner) => Ok(Formula::not(self.formula(inner)?)),
            ExprKind::Binary(operator, left, right) => self.connective(*operator, left, right),
            ExprKind::Temporal {
                operator,
                bound,
                left,
                right,
            } => self.temporal(*operator, bound.as_deref(), left.as_deref(), right),
            _ => Err("it uses the model's variables, not propositions".into()),
        }
    }

    fn atom(&mut self, name: &str) -> Result<Formula, String> {
        let proposition = self.vocabulary.propositions.get(name);
        if proposition.is_none_or(|p| p.trace.is_none()) {
            return Err(format!("`{name}` is not bound to traces"));
        }
        let known = self.atoms.iter().position(|atom| atom.text == name);
        let place = known.unwrap_or_else(|| {
            self.atoms.push(AtomText {
                text: name.to_owned(),
                span: 0..0,
            });
            self.atoms.len() - 1
        });
        Ok(Formula::Atom(AtomId(place)))
    }

    fn connective(
        &mut self,
        operator: BinaryOp,
        left: &Expr,
        right: &Expr,
    ) -> Result<Formula, String> {
        let combine = match operator {
            BinaryOp::And => Formula::and,
            BinaryOp::Or => Formula::or,
            BinaryOp::Implies => Formula::implies,
            BinaryOp::Iff => |left, right| Formula::Iff(Box::new(left), Box::new(right)),
            _ => return Err("it compares the model's variables".into()),
        };
        Ok(combine(self.formula(left)?, self.formula(right)?))
    }

    fn temporal(
        &mut self,
        operator: TemporalOp,
        bound: Option<&StepBound>,
        left: Option<&Expr>,
        right: &Expr,
    ) -> Result<Formula, String> {
        if operator == TemporalOp::Next {
            return Err("`X` needs steps of the model, which a trace does not have".into());
        }
        let interval = self.interval(bound)?;
        let right = Box::new(self.formula(right)?);
        let left = match left {
            Some(left) => Box::new(self.formula(left)?),
            None => Box::new(Formula::True),
        };
        Ok(match operator {
            TemporalOp::Finally => Formula::Eventually(interval, right),
            TemporalOp::Globally => Formula::Always(interval, right),
            TemporalOp::Until => Formula::Until(interval, left, right),
            TemporalOp::WeakUntil => Formula::WeakUntil(interval, left, right),
            TemporalOp::Release => Formula::Release(interval, left, right),
            TemporalOp::Next => Formula::Next(right),
        })
    }

    fn interval(&self, bound: Option<&StepBound>) -> Result<Interval, String> {
        let Some(bound) = bound else {
            return Ok(Interval::UNBOUNDED);
        };
        let step_secs = self
            .step_secs
            .ok_or("its limit is in steps, or in units of the model's time, whose duration study.toml does not declare")?;
        let secs = |steps: f64| Bound::secs(steps * step_secs);
        let (low, high) = steps_of(bound).ok_or("its step bound is not a number of steps")?;
        Ok(Interval {
            low: secs(low),
            high: high.map(secs),
        })
    }
}

/// The least and the greatest number of steps of a bound written in numbers;
/// `None` also if there is no such number of steps, as for `<0`.
pub fn steps_of(bound: &StepBound) -> Option<(f64, Option<f64>)> {
    match bound {
        StepBound::Compare(comparison, expr) => {
            let steps = number_of(expr)?;
            Some(match comparison {
                Comparison::LessEqual => (0.0, Some(steps)),
                // Steps are whole, so below 2.5 the last one is 2.
                Comparison::Less if steps > 0.0 => (0.0, Some(steps.ceil() - 1.0)),
                Comparison::Less => return None,
                Comparison::GreaterEqual => (steps, None),
                Comparison::Greater => (steps + 1.0, None),
            })
        }
        StepBound::Exactly(expr) => number_of(expr).map(|steps| (steps, Some(steps))),
        StepBound::Between(low, high) => Some((number_of(low)?, Some(number_of(high)?))),
    }
}

/// A number that is written as one.
pub fn number_of(expr: &Expr) -> Option<f64> {
    match &expr.kind {
        ExprKind::Int(value) => Some(*value as f64),
        ExprKind::Double(text) => text.parse().ok(),
        _ => None,
    }
}
