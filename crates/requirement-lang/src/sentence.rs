//! The tree of a requirement's sentence: scope, condition, component, probability and stages.

use crate::diagnostic::Span;
use crate::expression::Expression;

/// A requirement in structured English, read.
///
/// What it means is defined in [`crate::semantics`].
#[derive(Clone, Debug, PartialEq)]
pub struct Sentence {
    /// Where the requirement applies.
    pub scope: Scope,
    /// What triggers it; without, each interval of the scope does, once, at its beginning.
    pub condition: Option<Condition>,
    /// Who has to meet it, for example `robot`. It has no formal meaning.
    pub component: String,
    /// The probability with which a run has to meet it; without, every run has to.
    pub probability: Option<Probability>,
    /// What has to happen: one stage, or several in order.
    pub stages: Vec<Stage>,
}

/// The intervals of a run in which a requirement applies.
#[derive(Clone, Debug, PartialEq)]
pub struct Scope {
    /// How the intervals follow from the mode.
    pub kind: ScopeKind,
    /// The mode; [`Expression::True`] for [`ScopeKind::Global`].
    pub mode: Expression,
    /// Where it is written; empty at the start of the sentence if it is not.
    pub span: Span,
}

/// How the intervals of a scope follow from a mode `M`. A *run* of `M` is a maximal interval in
/// which `M` holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum ScopeKind {
    /// Everything.
    Global,
    /// Each run of `M`.
    In,
    /// Each run of `not M`.
    NotIn,
    /// From the beginning to just before `M` first holds; everything if it never does.
    Before,
    /// From just after the first run of `M`; nothing if that never comes or never ends.
    After,
    /// The requirement's timing is *negated* in [`ScopeKind::NotIn`].
    OnlyIn,
    /// The timing is negated from where `M` first holds.
    OnlyBefore,
    /// The timing is negated from the beginning to the end of the first run of `M`.
    OnlyAfter,
}

impl ScopeKind {
    /// All kinds.
    pub const ALL: [Self; 8] = [
        Self::Global,
        Self::In,
        Self::NotIn,
        Self::Before,
        Self::After,
        Self::OnlyIn,
        Self::OnlyBefore,
        Self::OnlyAfter,
    ];

    /// Whether the timing is negated.
    #[must_use]
    pub fn is_only(self) -> bool {
        matches!(self, Self::OnlyIn | Self::OnlyBefore | Self::OnlyAfter)
    }
}

/// What triggers a requirement within its scope.
#[derive(Clone, Debug, PartialEq)]
pub struct Condition {
    /// Whether it triggers on becoming true or all the time.
    pub kind: ConditionKind,
    /// The expression as written, thus without the negation in `unless`.
    pub expression: Expression,
    /// Where it is written.
    pub span: Span,
}

/// When a condition triggers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum ConditionKind {
    /// Where it becomes true in the scope, and at the beginning of a scope interval if it is true
    /// there (`when`, `upon`, `if`, `where`).
    Upon,
    /// Wherever it is true in the scope (`whenever`).
    Whenever,
    /// As [`ConditionKind::Upon`], of the negation (`unless`).
    Unless,
}

impl Condition {
    /// The expression whose truth triggers, thus with the negation in `unless`.
    #[must_use]
    pub fn triggering(&self) -> Expression {
        match self.kind {
            ConditionKind::Unless => self.expression.clone().negation(),
            _ => self.expression.clone(),
        }
    }
}

/// Something that has to happen, and when.
#[derive(Clone, Debug, PartialEq)]
pub struct Stage {
    /// When, counted from the trigger or from where the stage before was completed.
    pub timing: Timing,
    /// What.
    pub response: Expression,
    /// Where it is written.
    pub span: Span,
}

/// When a response has to hold, relative to a trigger `t` in a scope interval that ends at `e`.
#[derive(Clone, Debug, PartialEq)]
pub enum Timing {
    /// At `t`.
    Immediately,
    /// At the step after `t`, if the interval has one.
    Next,
    /// Somewhere from `t` to `e`.
    Eventually,
    /// Everywhere from `t` to `e`.
    Always,
    /// Nowhere from `t` to `e`.
    Never,
    /// Somewhere from `t` to `t + d`; excused if the interval ends before `t + d`.
    Within(Duration),
    /// Everywhere from `t` to the earlier of `t + d` and `e`.
    For(Duration),
    /// Nowhere before `t + d`, and at `t + d`; excused from the latter if the interval ends before.
    After(Duration),
    /// Everywhere from `t` to just before the stop condition first holds, or to `e` if it does not.
    Until(Expression),
    /// Somewhere from `t` to just before the stop condition first holds; excused if it does not.
    Before(Expression),
}

impl Timing {
    /// Its duration, if it has one.
    #[must_use]
    pub fn duration(&self) -> Option<&Duration> {
        match self {
            Timing::Within(duration) | Timing::For(duration) | Timing::After(duration) => {
                Some(duration)
            }
            _ => None,
        }
    }

    /// Its stop condition, if it has one.
    #[must_use]
    pub fn stop(&self) -> Option<&Expression> {
        match self {
            Timing::Until(stop) | Timing::Before(stop) => Some(stop),
            _ => None,
        }
    }

    /// Whether a stage with this timing is completed at some point, so that another can follow.
    #[must_use]
    pub fn completes(&self) -> bool {
        !matches!(self, Timing::Always | Timing::Never)
    }
}

/// A length of time.
#[derive(Clone, Debug, PartialEq)]
pub struct Duration {
    /// As it was written: `2 s`, `5 steps` or the name of a parameter.
    pub text: String,
    /// How long it is.
    pub amount: Amount,
    /// Where it is written.
    pub span: Span,
}

impl Duration {
    /// A number of steps.
    #[must_use]
    pub fn steps(count: u32) -> Self {
        Duration {
            text: format!("{count} steps"),
            amount: Amount::Steps(count),
            span: Span::default(),
        }
    }

    /// A number of seconds.
    #[must_use]
    pub fn secs(secs: f64) -> Self {
        Duration {
            text: format!("{secs} s"),
            amount: Amount::Secs(secs),
            span: Span::default(),
        }
    }
}

/// The measure of a [`Duration`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Amount {
    /// Seconds, finite and not negative.
    Secs(f64),
    /// Steps of a model, or samples of a trace.
    Steps(u32),
    /// It could not be read; a diagnostic says why.
    Missing,
}

/// The probability with which a run of the system has to meet the requirement.
#[derive(Clone, Debug, PartialEq)]
pub struct Probability {
    /// Which side of the value is required.
    pub comparison: Comparison,
    /// The value, 0 to 1.
    pub value: f64,
    /// The value as an exact decimal number, for example `0.95` for `95 %`.
    pub decimal: String,
    /// Where it is written.
    pub span: Span,
}

/// A comparison with a probability.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Comparison {
    /// `>=`
    AtLeast,
    /// `<=`
    AtMost,
    /// `>`
    MoreThan,
    /// `<`
    LessThan,
}

impl Comparison {
    /// As a sign.
    #[must_use]
    pub fn sign(self) -> &'static str {
        match self {
            Comparison::AtLeast => ">=",
            Comparison::AtMost => "<=",
            Comparison::MoreThan => ">",
            Comparison::LessThan => "<",
        }
    }

    /// In words.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Comparison::AtLeast => "at least",
            Comparison::AtMost => "at most",
            Comparison::MoreThan => "more than",
            Comparison::LessThan => "less than",
        }
    }
}

impl Sentence {
    /// All its expressions, in the order of the sentence; a stop condition before its response.
    #[must_use]
    pub fn expressions(&self) -> Vec<&Expression> {
        let mut all = Vec::new();
        if self.scope.kind != ScopeKind::Global {
            all.push(&self.scope.mode);
        }
        all.extend(self.condition.iter().map(|condition| &condition.expression));
        for stage in &self.stages {
            all.extend(stage.timing.stop());
            all.push(&stage.response);
        }
        all
    }

    /// The texts of its atoms in order of appearance, each once.
    #[must_use]
    pub fn propositions(&self) -> Vec<&str> {
        let mut texts: Vec<&str> = Vec::new();
        for atom in self.expressions().into_iter().flat_map(Expression::atoms) {
            if !texts.contains(&atom.text.as_str()) {
                texts.push(&atom.text);
            }
        }
        texts
    }

    /// Whether some part could not be read, so that it has no meaning.
    #[must_use]
    pub fn is_incomplete(&self) -> bool {
        self.stages.is_empty()
            || self
                .expressions()
                .into_iter()
                .any(Expression::is_incomplete)
            || (self.stages.iter())
                .filter_map(|stage| stage.timing.duration())
                .any(|duration| duration.amount == Amount::Missing)
    }
}
