//! What is known of a computed number: one type for all that compute, so that nothing is lost on the way to who concludes.

/// How far a computed number can be trusted.
#[derive(Clone, Debug, PartialEq)]
pub enum Guarantee {
    /// It is exact.
    Exact,
    /// The exact value lies between these, both included.
    Bounded {
        /// Lower bound.
        low: f64,
        /// Upper bound.
        high: f64,
    },
    /// The exact value lies between these with this confidence.
    Statistical {
        /// Probability with which such intervals contain the exact value.
        confidence: f64,
        /// Lower end.
        low: f64,
        /// Upper end.
        high: f64,
    },
    /// Nothing is known for certain.
    Estimated {
        /// Why not.
        reason: String,
    },
}

impl Guarantee {
    /// The bounds between which the value lies, if it is bounded; what is exact, statistical or estimated has none.
    #[must_use]
    pub fn bounds(&self) -> Option<(f64, f64)> {
        match self {
            Guarantee::Bounded { low, high } => Some((*low, *high)),
            Guarantee::Exact | Guarantee::Statistical { .. } | Guarantee::Estimated { .. } => None,
        }
    }
}
