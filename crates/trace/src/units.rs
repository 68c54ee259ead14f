//! Units of measurement at run time: `250 mm/s`, `10 N/cm^2`, `40 deg`, with exact conversion.
//!
//! # Definition
//! A unit is a dimension (integral exponents of the seven base quantities of the SI, and of plane
//! angle) and a factor to the coherent unit of that dimension. Factors are rational numbers times
//! a power of pi, and held exactly. Source of the factors: "The International System of Units
//! (SI)", 9th edition, BIPM 2019, chapters 2 to 4; for inch, foot, mile, pound and the standard
//! acceleration of free fall, NIST Special Publication 811, 2008, appendix B.8.
//!
//! Deviation from the SI: a plane angle has a dimension of its own, so that `deg` and `rad` are
//! told from each other and from plain numbers. Where an angle is to be taken as a number, divide
//! it by `1 rad`.
//!
//! # Language
//! | form | examples |
//! |---|---|
//! | symbols | `m`, `kg`, `s`, `min`, `h`, `N`, `Pa`, `J`, `W`, `Hz`, `rad`, `deg`, `rev`, `rpm`, `%`, `in` |
//! | with SI prefixes, from `p` to `T` | `mm`, `us`, `kN`, `MPa`, `mrad` |
//! | written out | `meters`, `seconds`, `degrees` |
//! | products and quotients | `N*m`, `N m`, `m/s`, `J/(kg*K)`, `1/s` |
//! | powers | `m/s^2`, `s^-1`, `mm²`, `N/cm2` |
//!
//! Quotients group to the left; a product right behind a quotient (`m/s*kg`) is refused as
//! ambiguous. Scales with an offset (degrees Celsius) are refused, since a factor cannot convert
//! them.
//!
//! # Guarantee
//! A written number is converted exactly and rounded once, as long as its digits and the factor
//! fit into 2^53, or the factor is a power of ten: `250 mm/s` is the same double as `0.25 m/s`.
//! Other conversions round at most three times, each by at most half a unit in the last place;
//! with pi in the factor, pi itself is rounded too.
//!
//! Why no library: those for Rust that are kept well (`uom`) know units at compile time only,
//! while here they come from files; and the conversion is to be exact.
//!
//! ```
//! use trace::units::{QuantityValue, Unit};
//! let limit: QuantityValue = "250 mm/s".parse()?;
//! assert_eq!(limit.si_value(), 0.25);
//! assert_eq!(limit.dimension().to_string(), "speed");
//! assert_eq!(limit.value_in(&"km/h".parse::<Unit>()?), Some(0.9));
//! assert_eq!(limit.value_in(&"m".parse::<Unit>()?), None); // a speed is no length
//!
//! let error = "250 mms".parse::<QuantityValue>().unwrap_err();
//! assert!(error.to_string().contains("there is no unit mms; did you mean mm?"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod decimal;
mod dimension;
mod factor;
mod parse;
mod symbols;

use std::fmt;
use std::ops::Range;
use std::str::FromStr;

pub(crate) use decimal::Decimal;
pub use dimension::Dimension;
pub use factor::{Conversion, Factor};
pub(crate) use parse::{Prefix, prefix};

/// A unit: a dimension, a factor to the coherent SI unit of that dimension, and how it is written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Unit {
    text: String,
    dimension: Dimension,
    factor: Factor,
}

impl Unit {
    /// The unit of plain numbers.
    #[must_use]
    pub fn one() -> Self {
        Unit::coherent(Dimension::NONE)
    }

    /// The coherent SI unit of `dimension`, for example m/s.
    #[must_use]
    pub fn coherent(dimension: Dimension) -> Self {
        Unit {
            text: dimension.si_unit(),
            dimension,
            factor: Factor::ONE,
        }
    }

    /// The unit as it was written.
    #[must_use]
    pub fn text(&self) -> &str {
        &self.text
    }

    /// What is measured in it.
    #[must_use]
    pub fn dimension(&self) -> Dimension {
        self.dimension
    }

    /// How many coherent SI units it is, exactly.
    #[must_use]
    pub fn factor(&self) -> Factor {
        self.factor
    }

    /// Whether numbers in this unit mean the same in `other`, however the two are written.
    #[must_use]
    pub fn same_as(&self, other: &Unit) -> bool {
        self.dimension == other.dimension && self.factor == other.factor
    }

    /// How numbers in this unit become numbers in `other`; `None` if the dimensions differ or the
    /// factor is out of range.
    #[must_use]
    pub fn conversion_to(&self, other: &Unit) -> Option<Conversion> {
        if self.dimension != other.dimension {
            return None;
        }
        Some(self.factor.divided_by(other.factor)?.conversion())
    }

    /// The unit of a product; `None` if exponents or factor are out of range.
    #[must_use]
    pub fn times(&self, other: &Unit) -> Option<Unit> {
        Some(Unit {
            text: joined(&self.text, "*", &other.text),
            dimension: self.dimension.times(other.dimension)?,
            factor: self.factor.times(other.factor)?,
        })
    }

    /// The unit of a quotient; `None` if exponents or factor are out of range.
    #[must_use]
    pub fn divided_by(&self, other: &Unit) -> Option<Unit> {
        Some(Unit {
            text: joined(&self.text, "/", &other.text),
            dimension: self.dimension.divided_by(other.dimension)?,
            factor: self.factor.divided_by(other.factor)?,
        })
    }
}

/// The text of a product or quotient, with brackets where they are needed.
fn joined(left: &str, operator: &str, right: &str) -> String {
    let compound = |text: &str| text.contains(['*', '/', ' ', '·', '⋅']);
    if right == "1" {
        return left.to_owned();
    }
    if left == "1" && operator == "*" {
        return right.to_owned();
    }
    let left = if operator == "*" && left.contains('/') {
        format!("({left})")
    } else {
        left.to_owned()
    };
    if compound(right) {
        format!("{left}{operator}({right})")
    } else {
        format!("{left}{operator}{right}")
    }
}

impl fmt::Display for Unit {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(&self.text)
    }
}

impl FromStr for Unit {
    type Err = UnitError;

    /// Parses the whole of `text` as a unit, for example `m/s^2`, or `1` for plain numbers.
    fn from_str(text: &str) -> Result<Self, UnitError> {
        parse::whole(text)
    }
}

/// A number with or without a unit, as it was written: `250 mm/s`, `0.1`.
#[derive(Debug, Clone, PartialEq)]
pub struct QuantityValue {
    number: Decimal,
    unit: Option<Unit>,
}

impl QuantityValue {
    pub(crate) fn new(number: Decimal, unit: Option<Unit>) -> Self {
        QuantityValue { number, unit }
    }

    /// The number as it was written, in its own unit.
    #[must_use]
    pub fn number(&self) -> f64 {
        self.number.value()
    }

    /// The unit, if one was written.
    #[must_use]
    pub fn unit(&self) -> Option<&Unit> {
        self.unit.as_ref()
    }

    /// What it measures; without a unit, a plain number.
    #[must_use]
    pub fn dimension(&self) -> Dimension {
        self.unit.as_ref().map_or(Dimension::NONE, Unit::dimension)
    }

    /// The value in the coherent SI unit of its dimension.
    #[must_use]
    pub fn si_value(&self) -> f64 {
        let factor = self.unit.as_ref().map_or(Factor::ONE, Unit::factor);
        self.number.scaled(factor)
    }

    /// The number, taken in `unit` whatever its own, in the coherent SI unit.
    pub(crate) fn number_in_si(&self, unit: &Unit) -> f64 {
        self.number.scaled(unit.factor)
    }

    /// The value in `unit`; `None` if the dimensions differ or the factor is out of range. A
    /// number without a unit is a plain number.
    #[must_use]
    pub fn value_in(&self, unit: &Unit) -> Option<f64> {
        if self.dimension() != unit.dimension {
            return None;
        }
        let own = self.unit.as_ref().map_or(Factor::ONE, Unit::factor);
        Some(self.number.scaled(own.divided_by(unit.factor)?))
    }
}

impl fmt::Display for QuantityValue {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.unit {
            Some(unit) => write!(out, "{} {unit}", self.number),
            None => write!(out, "{}", self.number),
        }
    }
}

impl FromStr for QuantityValue {
    type Err = UnitError;

    /// Parses the whole of `text` as a number, possibly with a sign, and possibly a unit.
    fn from_str(text: &str) -> Result<Self, UnitError> {
        let start = text.len() - text.trim_start().len();
        let sign = usize::from(text[start..].starts_with(['-', '+']));
        let digits = start + sign;
        let length = Decimal::length(&text[digits..]);
        let number = Decimal::parse(&text[start..digits + length]);
        let Some(number) = number else {
            return Err(UnitError::new(
                text,
                start..text.len(),
                UnitErrorKind::Number,
            ));
        };
        let rest = digits + length;
        if text[rest..].trim().is_empty() {
            return Ok(QuantityValue::new(number, None));
        }
        let unit = parse::whole(&text[rest..]).map_err(|error| UnitError {
            text: text.to_owned(),
            span: error.span.start + rest..error.span.end + rest,
            kind: error.kind,
        })?;
        Ok(QuantityValue::new(number, Some(unit)))
    }
}

/// Something wrong with the text of a unit or of a number with a unit.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UnitError {
    /// The text.
    pub text: String,
    /// The place in `text`: byte offsets, half open.
    pub span: Range<usize>,
    /// What is wrong.
    pub kind: UnitErrorKind,
}

/// What is wrong with a unit.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum UnitErrorKind {
    /// There is no finite number at the beginning.
    Number,
    /// There is no such unit.
    Unknown {
        /// What stands there.
        name: String,
        /// A unit that is written alike.
        similar: Option<String>,
    },
    /// The scale has an offset, as degrees Celsius have.
    Offset {
        /// The scale.
        name: String,
    },
    /// A product follows a quotient without brackets.
    Ambiguous,
    /// Something that is no unit stands there.
    Unexpected,
    /// An exponent or a factor is out of range.
    TooLarge,
}

impl UnitError {
    pub(crate) fn new(text: &str, span: Range<usize>, kind: UnitErrorKind) -> Self {
        UnitError {
            text: text.to_owned(),
            span,
            kind,
        }
    }
}

impl fmt::Display for UnitError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "in \"{}\": {}", self.text, self.kind)
    }
}

impl std::error::Error for UnitError {}

impl fmt::Display for UnitErrorKind {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            UnitErrorKind::Number => out.write_str(
                "there is no finite number at the beginning; write a number with a unit, as in \
                 250 mm/s",
            ),
            UnitErrorKind::Unknown {
                name,
                similar: Some(similar),
            } => write!(out, "there is no unit {name}; did you mean {similar}?"),
            UnitErrorKind::Unknown { name, .. } => write!(
                out,
                "there is no unit {name}; write SI units, as in mm/s, N/cm^2, deg or kPa"
            ),
            UnitErrorKind::Offset { name } => write!(
                out,
                "{name} is a scale with an offset, which no factor converts; give kelvin (K)"
            ),
            UnitErrorKind::Ambiguous => out.write_str(
                "a product behind a quotient can be read in two ways; write brackets, as in \
                 J/(kg*K)",
            ),
            UnitErrorKind::Unexpected => out.write_str(
                "this is not a unit; write symbols joined by * and /, with powers as in m/s^2",
            ),
            UnitErrorKind::TooLarge => {
                out.write_str("the unit's exponents or factor are too large; write a simpler unit")
            }
        }
    }
}
