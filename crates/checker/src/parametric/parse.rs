//! Regions as text: what PRISM's switch `-param` takes.

use std::fmt;

use num_traits::{One, Zero};
use prism_lang::resolved::Parameter;
use prism_lang::{Constants, Rational, Value};

use super::region::Region;

/// Why a region could not be read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RegionError {
    /// What stands before `=` is none of the model's parameters.
    Unknown(String),
    /// A constant was given two ranges.
    Twice(String),
    /// What stands behind `=` is not `low:high` with numbers.
    NotARange {
        /// The constant.
        name: String,
        /// What was given.
        text: String,
    },
    /// The least value is not less than the greatest.
    Empty {
        /// The constant.
        name: String,
        /// What was given.
        text: String,
    },
}

impl fmt::Display for RegionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown(name) => write!(f, "the model leaves no constant `{name}` open"),
            Self::Twice(name) => write!(f, "`{name}` has two ranges"),
            Self::NotARange { name, text } => write!(
                f,
                "`{name}={text}` gives no range: write `{name}=0.1:0.4`, or only `{name}` for 0:1"
            ),
            Self::Empty { name, text } => write!(
                f,
                "the range `{name}={text}` is empty: its first number must be less than its second"
            ),
        }
    }
}

impl std::error::Error for RegionError {}

impl Region {
    /// The names in a text such as `x=0:1,y`.
    pub fn names(text: &str) -> Vec<&str> {
        let parts = text.split(',').map(str::trim).filter(|p| !p.is_empty());
        parts
            .map(|part| part.split_once('=').map_or(part, |(name, _)| name.trim()))
            .collect()
    }

    /// Reads `x=0:1,y=1/5:0.4,z`; what has no range is between 0 and 1.
    ///
    /// # Errors
    /// The part that is wrong.
    pub fn parse(text: &str, parameters: &[Parameter]) -> Result<Self, RegionError> {
        let mut ranges: Vec<Option<(Rational, Rational)>> = vec![None; parameters.len()];
        for part in text.split(',').map(str::trim).filter(|p| !p.is_empty()) {
            let (name, range) = match part.split_once('=') {
                Some((name, range)) => (name.trim(), range.trim()),
                None => (part, "0:1"),
            };
            let place = parameters.iter().position(|p| p.name == name);
            let place = place.ok_or_else(|| RegionError::Unknown(name.to_owned()))?;
            if ranges[place].replace(parse_range(name, range)?).is_some() {
                return Err(RegionError::Twice(name.to_owned()));
            }
        }
        let unit = || (Rational::zero(), Rational::one());
        let ranges = ranges.into_iter().map(|r| r.unwrap_or_else(unit));
        Ok(Self {
            ranges: ranges.collect(),
        })
    }
}

fn parse_range(name: &str, text: &str) -> Result<(Rational, Rational), RegionError> {
    let (name, text) = (name.to_owned(), text.to_owned());
    let ends = text.split_once(':');
    let ends = ends.and_then(|(low, high)| Some((number(low)?, number(high)?)));
    match ends {
        None => Err(RegionError::NotARange { name, text }),
        Some((low, high)) if low >= high => Err(RegionError::Empty { name, text }),
        Some(ends) => Ok(ends),
    }
}

fn number(text: &str) -> Option<Rational> {
    let read = Constants::parse(&format!("x={}", text.trim())).ok()?;
    match read.get("x")? {
        Value::Int(value) => Some(Rational::from_integer((*value).into())),
        Value::Double(value) => value.exact().cloned(),
        Value::Bool(_) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_read_exactly_and_mistakes_are_named() {
        let text = "dtmc const double x; const double y; const double z;
            module m s : [0..1]; [] true -> x*y*z/8 : true + 1-x*y*z/8 : (s'=1); endmodule";
        let none = Constants::new();
        let tree = prism_lang::parse_model(text).tree;
        let model = prism_lang::resolve_open(&tree, &none, &none, &["x", "y", "z"]).unwrap();
        let parse = |text: &str| Region::parse(text, &model.parameters);
        let region = parse("z, y=1/5:0.4").unwrap();
        assert_eq!(region.to_string(), "([0,1],[1/5,2/5],[0,1])");
        assert_eq!(Region::names("x=0:1, y"), ["x", "y"]);
        assert_eq!(parse("w"), Err(RegionError::Unknown("w".to_owned())));
        assert_eq!(parse("x,x=0:1"), Err(RegionError::Twice("x".to_owned())));
        for (text, wrong) in [
            ("x=3", "gives no range"),
            ("x=1:1", "is empty"),
            ("x=a:b", "gives no"),
        ] {
            assert!(
                parse(text).unwrap_err().to_string().contains(wrong),
                "{text}"
            );
        }
    }
}
