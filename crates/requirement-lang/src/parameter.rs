//! Parameters: quantities that requirements use by name, each declared once with its unit.

use std::collections::BTreeMap;
use std::fmt;

use trace::units::{Dimension, QuantityValue, UnitError};

use crate::expression::is_name;

/// A quantity with a name, a unit, and perhaps the range it may be set to.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    name: String,
    meaning: String,
    value: QuantityValue,
    least: Option<QuantityValue>,
    most: Option<QuantityValue>,
}

impl Parameter {
    /// Declares a parameter, its value given as text such as `250 mm/s`.
    ///
    /// # Errors
    /// [`ParameterError`] if `name` is no name or `value` no quantity.
    pub fn new(name: &str, value: &str, meaning: &str) -> Result<Self, ParameterError> {
        if !is_name(name) {
            return Err(ParameterError::Name {
                name: name.to_owned(),
            });
        }
        Ok(Parameter {
            name: name.to_owned(),
            meaning: meaning.to_owned(),
            value: quantity(name, value)?,
            least: None,
            most: None,
        })
    }

    /// The same parameter, allowed from `least` to `most`.
    ///
    /// # Errors
    /// [`ParameterError`] if these are no quantities of the same dimension, or exclude the value.
    pub fn range(mut self, least: &str, most: &str) -> Result<Self, ParameterError> {
        self.least = Some(self.alike(quantity(&self.name, least)?)?);
        self.most = Some(self.alike(quantity(&self.name, most)?)?);
        self.check(&self.value)?;
        Ok(self)
    }

    /// The same parameter with another value.
    ///
    /// # Errors
    /// [`ParameterError`] if this is no quantity of the same dimension or outside the range.
    pub fn with_value(mut self, value: &str) -> Result<Self, ParameterError> {
        let value = self.alike(quantity(&self.name, value)?)?;
        self.check(&value)?;
        self.value = value;
        Ok(self)
    }

    fn alike(&self, other: QuantityValue) -> Result<QuantityValue, ParameterError> {
        if other.dimension() == self.dimension() {
            return Ok(other);
        }
        Err(ParameterError::Dimension {
            name: self.name.clone(),
            given: other.to_string(),
            given_dimension: other.dimension(),
            expected: self.dimension(),
        })
    }

    fn check(&self, value: &QuantityValue) -> Result<(), ParameterError> {
        let below = (self.least.as_ref()).is_some_and(|least| value.si_value() < least.si_value());
        let above = (self.most.as_ref()).is_some_and(|most| value.si_value() > most.si_value());
        if !below && !above {
            return Ok(());
        }
        let shown = |end: &Option<QuantityValue>| {
            end.as_ref().map_or_else(String::new, ToString::to_string)
        };
        Err(ParameterError::Range {
            name: self.name.clone(),
            given: value.to_string(),
            least: shown(&self.least),
            most: shown(&self.most),
        })
    }

    /// The name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What it is, in words.
    #[must_use]
    pub fn meaning(&self) -> &str {
        &self.meaning
    }

    /// The value with its unit.
    #[must_use]
    pub fn value(&self) -> &QuantityValue {
        &self.value
    }

    /// What it measures.
    #[must_use]
    pub fn dimension(&self) -> Dimension {
        self.value.dimension()
    }

    /// The least and the greatest value it may have, if these were declared.
    #[must_use]
    pub fn allowed(&self) -> Option<(&QuantityValue, &QuantityValue)> {
        self.least.as_ref().zip(self.most.as_ref())
    }
}

fn quantity(name: &str, text: &str) -> Result<QuantityValue, ParameterError> {
    text.parse().map_err(|error| ParameterError::Quantity {
        name: name.to_owned(),
        error,
    })
}

/// Declared parameters, each name once.
///
/// ```
/// use requirement_lang::{Parameter, Parameters};
/// let parameters = Parameters::new([Parameter::new("release_time", "2 s", "time to open the hand")?])?;
/// assert_eq!(parameters.get("release_time").map(|p| p.value().si_value()), Some(2.0));
/// # Ok::<(), requirement_lang::ParameterError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Parameters {
    by_name: BTreeMap<String, Parameter>,
}

impl Parameters {
    /// These parameters.
    ///
    /// # Errors
    /// [`ParameterError::Twice`] if a name is declared twice.
    pub fn new(all: impl IntoIterator<Item = Parameter>) -> Result<Self, ParameterError> {
        let mut by_name = BTreeMap::new();
        for parameter in all {
            if by_name.contains_key(&parameter.name) {
                return Err(ParameterError::Twice {
                    name: parameter.name,
                });
            }
            by_name.insert(parameter.name.clone(), parameter);
        }
        Ok(Parameters { by_name })
    }

    /// The parameter of this name.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<&Parameter> {
        self.by_name.get(name)
    }

    /// The names in alphabetical order.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.by_name.keys().map(String::as_str)
    }

    /// The parameters in alphabetical order of their names.
    pub fn iter(&self) -> impl Iterator<Item = &Parameter> {
        self.by_name.values()
    }
}

/// Why a parameter cannot be declared, or not have a value.
#[derive(Clone, Debug, PartialEq)]
pub enum ParameterError {
    /// The name is no name.
    Name {
        /// What was given.
        name: String,
    },
    /// The name is declared twice.
    Twice {
        /// The name.
        name: String,
    },
    /// A value is no quantity.
    Quantity {
        /// The parameter.
        name: String,
        /// What is wrong with it.
        error: UnitError,
    },
    /// A value measures something else.
    Dimension {
        /// The parameter.
        name: String,
        /// The value.
        given: String,
        /// What the value measures.
        given_dimension: Dimension,
        /// What the parameter measures.
        expected: Dimension,
    },
    /// A value is outside the range.
    Range {
        /// The parameter.
        name: String,
        /// The value.
        given: String,
        /// The least value allowed.
        least: String,
        /// The greatest value allowed.
        most: String,
    },
    /// There is no such parameter.
    Unknown {
        /// What was asked for.
        name: String,
        /// A parameter that is written alike.
        similar: Option<String>,
    },
}

impl fmt::Display for ParameterError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ParameterError::Name { name } => write!(
                out,
                "`{name}` cannot be the name of a parameter; use letters, digits and underscores"
            ),
            ParameterError::Twice { name } => {
                write!(
                    out,
                    "the parameter `{name}` is declared twice; remove one declaration"
                )
            }
            ParameterError::Quantity { name, error } => {
                write!(out, "the parameter `{name}` has no proper value: {error}")
            }
            ParameterError::Dimension {
                name,
                given,
                given_dimension,
                expected,
            } => write!(
                out,
                "the parameter `{name}` is a {expected}, but {given} is a {given_dimension}; give it in \
                 a unit of the former"
            ),
            ParameterError::Range {
                name,
                given,
                least,
                most,
            } => write!(
                out,
                "the parameter `{name}` cannot be {given}; give a value from {least} to {most}"
            ),
            ParameterError::Unknown {
                name,
                similar: Some(similar),
            } => write!(
                out,
                "there is no parameter `{name}`; did you mean `{similar}`?"
            ),
            ParameterError::Unknown { name, .. } => {
                write!(out, "there is no parameter `{name}`; remove its value")
            }
        }
    }
}

impl std::error::Error for ParameterError {}
