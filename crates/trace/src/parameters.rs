//! Parameters: distances, speeds, times that requirements share, declared once with their units.

use std::collections::BTreeMap;
use std::fmt;

use crate::predicate::is_name;
use crate::suggest::nearest;
use crate::units::{Dimension, QuantityValue, UnitError};

/// Named values with units, which predicates refer to by name (see
/// [`Vocabulary::with_parameters`](crate::Vocabulary::with_parameters)).
///
/// ```
/// use trace::{Parameters, Vocabulary};
/// let parameters = Parameters::new([("near", "10 cm"), ("release_time", "2 s")])
///     .map_err(|errors| errors[0].clone())?;
/// assert_eq!(parameters.get("near").map(|near| near.si_value()), Some(0.1));
/// assert_eq!(parameters.secs("release_time"), Some(2.0));
/// assert_eq!(parameters.secs("near"), None); // not a time
///
/// let vocabulary = Vocabulary::with_parameters(
///     [("close", "distance(/human.hand, /robot.hand) < near")],
///     parameters,
/// ).map_err(|errors| errors[0].clone())?;
/// assert!(vocabulary.predicate("close").is_ok());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Parameters {
    values: BTreeMap<String, QuantityValue>,
}

/// Something wrong with a parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct ParameterError {
    /// The parameter's name.
    pub name: String,
    /// What is wrong.
    pub kind: ParameterErrorKind,
}

/// What is wrong with a parameter.
#[derive(Debug, Clone, PartialEq)]
pub enum ParameterErrorKind {
    /// It has a name that predicates cannot refer to.
    Name,
    /// There are two of the name.
    Duplicate,
    /// Its value is no number with or without a unit.
    Value(UnitError),
}

impl fmt::Display for ParameterError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = &self.name;
        match &self.kind {
            ParameterErrorKind::Name => write!(
                out,
                "\"{name}\" cannot be the name of a parameter; use letters, digits and \
                 underscores, not beginning with a digit, and no word of the language"
            ),
            ParameterErrorKind::Duplicate => write!(
                out,
                "the parameter {name} is declared twice; rename or remove one of them"
            ),
            ParameterErrorKind::Value(error) => write!(out, "the parameter {name}: {error}"),
        }
    }
}

impl std::error::Error for ParameterError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match &self.kind {
            ParameterErrorKind::Value(error) => Some(error),
            _ => None,
        }
    }
}

impl Parameters {
    /// Parses all values, given as name and text, for example `250 mm/s` or, for a plain number,
    /// `0.95`.
    ///
    /// # Errors
    /// Every [`ParameterError`] there is.
    pub fn new<N: Into<String>, T: AsRef<str>>(
        entries: impl IntoIterator<Item = (N, T)>,
    ) -> Result<Self, Vec<ParameterError>> {
        let mut values = BTreeMap::new();
        let mut errors = Vec::new();
        for (name, text) in entries {
            let name = name.into();
            match parameter(&values, &name, text.as_ref()) {
                Ok(value) => {
                    values.insert(name, value);
                }
                Err(kind) => errors.push(ParameterError { name, kind }),
            }
        }
        if errors.is_empty() {
            Ok(Parameters { values })
        } else {
            Err(errors)
        }
    }

    /// The value of the parameter `name`.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<&QuantityValue> {
        self.values.get(name)
    }

    /// The value in seconds of the parameter `name`; `None` if there is none, or it is no time.
    #[must_use]
    pub fn secs(&self, name: &str) -> Option<f64> {
        let value = self.get(name)?;
        (value.dimension() == Dimension::TIME).then(|| value.si_value())
    }

    /// The name of a parameter that is written like `name`, for "did you mean".
    #[must_use]
    pub fn similar(&self, name: &str) -> Option<String> {
        nearest(name, self.names())
    }

    /// The names in alphabetical order.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.values.keys().map(String::as_str)
    }

    /// Names and values, in alphabetical order of the names.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &QuantityValue)> {
        self.values
            .iter()
            .map(|(name, value)| (name.as_str(), value))
    }
}

fn parameter(
    others: &BTreeMap<String, QuantityValue>,
    name: &str,
    text: &str,
) -> Result<QuantityValue, ParameterErrorKind> {
    if !is_name(name) {
        return Err(ParameterErrorKind::Name);
    }
    if others.contains_key(name) {
        return Err(ParameterErrorKind::Duplicate);
    }
    text.parse().map_err(ParameterErrorKind::Value)
}
