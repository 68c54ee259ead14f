//! What a limit of time says of what it limits: that it comes by then, lasts until then, or does not come before.
//!
//! # Definition
//! Of an operator with the window from `a` to `b`, `b` is the *latest* time of what is waited for (`F`, `U`), or how long
//! something is *lasting* (`G`), and `a`, where it is above 0, is the *earliest* time, or *from* when on. Under a negation, and
//! before an implication, an operator is its dual. In an equivalence, under a bound of a probability, and of the weak operators
//! (`W`, `R`) it may be either. Of a sentence, "within" is the latest time, "for" is lasting, "after" is the earliest time.
//!
//! Limits of operators that stand within each other add up: the second of two equal ones is *behind* the first.

/// What a limit of time says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// It comes by then.
    Latest,
    /// It lasts until then.
    Lasting,
    /// It does not come before.
    Earliest,
    /// It lasts from then on.
    From,
    /// Not known, or no limit of time.
    Unknown,
}

impl Role {
    fn dual(self) -> Self {
        match self {
            Self::Latest => Self::Lasting,
            Self::Lasting => Self::Latest,
            Self::Earliest => Self::From,
            Self::From => Self::Earliest,
            Self::Unknown => Self::Unknown,
        }
    }

    /// Before a duration, in words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Latest => "within ",
            Self::Lasting => "for ",
            Self::Earliest => "not before ",
            Self::From => "from the end of ",
            Self::Unknown => "",
        }
    }

    /// Whether a form that has limits of the same size in these roles says what a declared limit in this role does by one in
    /// the role `found`.
    pub fn is_said_by(self, found: Self, all: &[Self]) -> bool {
        match (self, found) {
            (Self::Unknown, _) | (_, Self::Unknown) => true,
            // "After 3 s": not before, which may be written as what lasts until then, and then.
            (Self::Earliest, Self::Latest) => {
                all.contains(&Self::Earliest) || all.contains(&Self::Lasting)
            }
            (Self::Earliest, Self::Lasting) => true,
            (declared, found) => declared == found,
        }
    }
}

/// Where an operator stands: under how many negations, and behind which limits.
#[derive(Clone, Debug, Default)]
pub struct Standing {
    is_negated: bool,
    is_unknown: bool,
    behind: Vec<(Role, f64)>,
}

impl Standing {
    /// Of an operand that is negated here.
    #[must_use]
    pub fn negated(&self) -> Self {
        Self {
            is_negated: !self.is_negated,
            ..self.clone()
        }
    }

    /// Of an operand of which it is not known whether it is negated.
    #[must_use]
    pub fn either(&self) -> Self {
        Self {
            is_unknown: true,
            ..self.clone()
        }
    }

    /// Of an operand behind a limit.
    pub fn is_behind(&mut self, role: Role, secs: f64) {
        self.behind.push((role, secs));
    }

    /// What a limit says here that says this where nothing is negated.
    pub fn role(&self, plain: Role) -> Role {
        match (self.is_unknown, self.is_negated) {
            (true, _) => Role::Unknown,
            (false, true) => plain.dual(),
            (false, false) => plain,
        }
    }

    /// How many limits as this one it is behind.
    pub fn count(&self, role: Role, secs: f64) -> usize {
        let is_same = |(other, known): &&(Role, f64)| {
            *other == role && (known - secs).abs() <= 1e-9 * secs.abs().max(known.abs())
        };
        self.behind.iter().filter(is_same).count()
    }
}
