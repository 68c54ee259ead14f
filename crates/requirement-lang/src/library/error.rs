//! Why a template cannot be instantiated.

use std::fmt;

use trace::units::{Dimension, UnitError};

use crate::diagnostic::Diagnostic;

/// Why a template cannot be instantiated with the values given.
#[derive(Clone, Debug, PartialEq)]
pub enum TemplateError {
    /// The template has no such parameter.
    Unknown {
        /// What was given.
        name: String,
        /// A parameter that is written alike.
        similar: Option<String>,
    },
    /// A parameter is given twice.
    Twice {
        /// Its name.
        name: String,
    },
    /// A parameter has no default and is not given.
    Missing {
        /// Its name.
        name: &'static str,
        /// What it is.
        meaning: &'static str,
    },
    /// A value is no number with a unit.
    Quantity {
        /// The parameter.
        name: &'static str,
        /// What is wrong.
        error: UnitError,
    },
    /// A value measures something else.
    Dimension {
        /// The parameter.
        name: &'static str,
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
        name: &'static str,
        /// The value.
        given: String,
        /// The least value allowed.
        least: &'static str,
        /// The greatest value allowed.
        most: &'static str,
    },
    /// The parameters do not go together.
    Parameters {
        /// What is wrong, each in one sentence.
        errors: Vec<String>,
    },
    /// The sentence cannot be read with these values.
    Sentence {
        /// What is wrong in it.
        diagnostics: Vec<Diagnostic>,
    },
}

impl fmt::Display for TemplateError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            TemplateError::Unknown {
                name,
                similar: Some(similar),
            } => write!(
                out,
                "the template has no parameter {name}; did you mean {similar}?"
            ),
            TemplateError::Unknown { name, .. } => {
                write!(out, "the template has no parameter {name}; remove it")
            }
            TemplateError::Twice { name } => {
                write!(
                    out,
                    "the parameter {name} is given twice; remove one of them"
                )
            }
            TemplateError::Missing { name, meaning } => {
                write!(
                    out,
                    "the parameter {name} has no default, give it a value: {meaning}"
                )
            }
            TemplateError::Quantity { name, error } => write!(out, "the parameter {name}: {error}"),
            TemplateError::Dimension {
                name,
                given,
                given_dimension,
                expected,
            } => write!(
                out,
                "the parameter {name} is a {expected}, but {given} is a {given_dimension}; give it in a \
                 unit of {expected}"
            ),
            TemplateError::Range {
                name,
                given,
                least,
                most,
            } => write!(
                out,
                "the parameter {name} cannot be {given}; give a value from {least} to {most}"
            ),
            TemplateError::Parameters { errors } => out.write_str(&errors.join("; ")),
            TemplateError::Sentence { diagnostics } => {
                let texts: Vec<String> = diagnostics.iter().map(ToString::to_string).collect();
                out.write_str(&texts.join(" "))
            }
        }
    }
}

impl std::error::Error for TemplateError {}
