//! Values of constants over ranges: PRISM's experiments.

use crate::arithmetic::Arithmetic;
use crate::number::{Constants, ConstantsError, Number, Value, is_identifier, parse_value};

/// Values for constants, of which some run over ranges: `n=1:2:9` is 1, 3, 5, 7, 9; `p=0:0.1:1` eleven values.
///
/// A range is `first:step:last`, or `first:last` with the step 1. Its values are `first + k * step`, computed
/// exactly, as long as they are not beyond the last.
///
/// ```
/// use prism_lang::{Experiment, Value};
/// let experiment = Experiment::parse("n=1:2:5, p=0.1:0.1:0.2, b=true")?;
/// assert_eq!(experiment.len(), 6);
/// let second = experiment.valuations().nth(1).unwrap();
/// // The last range runs fastest.
/// assert_eq!(second.get("n"), Some(&Value::Int(1)));
/// assert_eq!(second.get("p").unwrap().to_string(), "0.2");
/// # Ok::<(), prism_lang::ConstantsError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Experiment {
    axes: Vec<Axis>,
}

/// The values of one constant.
#[derive(Clone, Debug, PartialEq)]
struct Axis {
    name: String,
    first: Value,
    step: Value,
    count: u64,
}

impl Axis {
    fn value(&self, place: u64) -> Value {
        let k = i64::try_from(place).unwrap_or(i64::MAX);
        match (&self.first, &self.step) {
            (Value::Int(first), Value::Int(step)) => {
                Value::Int(first.saturating_add(step.saturating_mul(k)))
            }
            (Value::Double(first), Value::Double(step)) => {
                Value::Double(first.add(&step.mul(&Number::from_i64(k))))
            }
            (first, _) => first.clone(),
        }
    }
}

impl Experiment {
    /// Reads what PRISM's switch `-const` takes: `a=1,b=0:0.1:1,c=true`.
    ///
    /// # Errors
    /// A sentence that names the part that is not `name=value` or `name=range`, or the name given twice.
    pub fn parse(text: &str) -> Result<Self, ConstantsError> {
        let mut axes: Vec<Axis> = Vec::new();
        for part in text.split(',').map(str::trim).filter(|p| !p.is_empty()) {
            let (name, value) = part
                .split_once('=')
                .ok_or_else(|| ConstantsError::NoEquals(part.to_owned()))?;
            let name = name.trim();
            if !is_identifier(name) {
                return Err(ConstantsError::NotAName(name.to_owned()));
            }
            if axes.iter().any(|a| a.name == name) {
                return Err(ConstantsError::Twice(name.to_owned()));
            }
            axes.push(axis(name, value.trim())?);
        }
        Ok(Self { axes })
    }

    /// How many valuations there are (at most 2^64 - 1).
    pub fn len(&self) -> u64 {
        let counts = self.axes.iter().map(|a| a.count);
        counts.fold(1, u64::saturating_mul)
    }

    /// Whether there is no valuation; never, for ranges are not empty.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The constants that run over a range.
    pub fn ranges(&self) -> Vec<&str> {
        let running = self.axes.iter().filter(|a| a.count > 1);
        running.map(|a| a.name.as_str()).collect()
    }

    /// The same with these constants first, in this order: the last one runs fastest.
    #[must_use]
    pub fn ordered(mut self, names: &[&str]) -> Self {
        let place = |axis: &Axis| names.iter().position(|name| *name == axis.name);
        // Stable: the others stay behind, in their order.
        self.axes
            .sort_by_key(|axis| place(axis).unwrap_or(names.len()));
        self
    }

    /// All valuations; the last range runs fastest.
    pub fn valuations(&self) -> impl Iterator<Item = Constants> + '_ {
        (0..self.len()).map(|number| self.valuation(number))
    }

    fn valuation(&self, number: u64) -> Constants {
        let (mut constants, mut rest) = (Constants::new(), number);
        for axis in self.axes.iter().rev() {
            constants.set(axis.name.clone(), axis.value(rest % axis.count));
            rest /= axis.count;
        }
        constants
    }
}

fn axis(name: &str, text: &str) -> Result<Axis, ConstantsError> {
    let parts: Vec<&str> = text.split(':').map(str::trim).collect();
    let read = |part: &str| {
        parse_value(part).ok_or_else(|| ConstantsError::NotAValue {
            name: name.to_owned(),
            value: part.to_owned(),
        })
    };
    let (first, step, last) = match parts[..] {
        [value] => {
            let first = read(value)?;
            let name = name.to_owned();
            let step = Value::Int(0);
            return Ok(Axis {
                name,
                first,
                step,
                count: 1,
            });
        }
        [first, last] => (read(first)?, Value::Int(1), read(last)?),
        [first, step, last] => (read(first)?, read(step)?, read(last)?),
        _ => return Err(bad_range(name, text, "it has more than three parts")),
    };
    let (Some(low), Some(by), Some(high)) = (number(&first), number(&step), number(&last)) else {
        return Err(bad_range(name, text, "truth values have no range"));
    };
    let zero = Number::from_i64(0);
    if by <= zero {
        return Err(bad_range(name, text, "the step is not positive"));
    }
    if high < low {
        return Err(bad_range(name, text, "the last value is below the first"));
    }
    let steps = high.sub(&low).div(&by).and_then(|n| Arithmetic::floor(&n));
    let Some(count) = steps
        .and_then(|n| u64::try_from(n).ok())
        .and_then(|n| n.checked_add(1))
    else {
        return Err(bad_range(name, text, "it has too many values"));
    };
    let are_ints = matches!((&first, &step), (Value::Int(_), Value::Int(_)));
    let (first, step) = match are_ints {
        true => (first, step),
        false => (Value::Double(low), Value::Double(by)),
    };
    let name = name.to_owned();
    Ok(Axis {
        name,
        first,
        step,
        count,
    })
}

fn bad_range(name: &str, range: &str, why: &'static str) -> ConstantsError {
    ConstantsError::BadRange {
        name: name.to_owned(),
        range: range.to_owned(),
        why,
    }
}

fn number(value: &Value) -> Option<Number> {
    match value {
        Value::Int(value) => Some(Number::from_i64(*value)),
        Value::Double(value) => Some(value.clone()),
        Value::Bool(_) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(text: &str) -> Vec<String> {
        let experiment = Experiment::parse(text).unwrap();
        let name = experiment.axes[0].name.clone();
        let of = |c: Constants| c.get(&name).unwrap().to_string();
        experiment.valuations().map(of).collect()
    }

    #[test]
    fn ranges_have_their_ends_exactly() {
        assert_eq!(values("x=1:2:9"), ["1", "3", "5", "7", "9"]);
        assert_eq!(values("x=1:2:8"), ["1", "3", "5", "7"]);
        assert_eq!(values("x=2:4"), ["2", "3", "4"]);
        // 0.1 added ten times is not 1 in floating point.
        let tenths = values("p=0:0.1:1");
        assert_eq!(
            (tenths.len(), tenths[3].as_str(), tenths[10].as_str()),
            (11, "0.3", "1")
        );
        assert_eq!(values("p=0.5"), ["0.5"]);
        assert_eq!(values("p=-1:1/2:0"), ["-1", "-0.5", "0"]);
    }

    #[test]
    fn bad_ranges_are_refused_with_their_reason() {
        for (text, why) in [
            ("x=1:0:3", "step"),
            ("x=3:1", "below"),
            ("x=1:2:3:4", "three parts"),
            ("x=true:false", "truth values"),
            ("x=1:1:y", "not a valid value"),
            ("x=0:1e-30:1", "too many"),
        ] {
            let message = Experiment::parse(text).unwrap_err().to_string();
            assert!(message.contains(why), "{text}: {message}");
        }
        let huge = Experiment::parse("x=0:1000000000000,y=0:1000000000000").unwrap();
        assert_eq!(huge.len(), u64::MAX);
        assert_eq!(
            huge.valuations().next(),
            Some(Constants::parse("x=0,y=0").unwrap())
        );
    }
}
