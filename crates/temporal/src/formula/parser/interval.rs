//! Intervals: `[0, 2 s]`, `[0.5 s, inf]`, `[0, release_time]`, `[0, 50 samples]`.

use std::ops::Range;

use super::{FormulaError, Parser};
use crate::formula::ast::{Bound, Interval, TimeUnit};
use crate::formula::lexer::Kind;
use crate::formula::settings::TimeModel;

impl Parser<'_> {
    /// `[low, high]` if it comes next.
    pub(super) fn interval(&mut self) -> Result<Interval, FormulaError> {
        let start = self.peek().span.start;
        if !self.take(Kind::OpenSquare) {
            return Ok(Interval::UNBOUNDED);
        }
        let low = self.bound()?;
        let remedy = "write it as [0, 2 s], [0.5 s, inf] or [0, 50 samples]";
        let Some(low) = low else {
            return Err(self.error("an interval cannot begin at infinity".to_owned(), remedy));
        };
        if !self.take(Kind::Comma) {
            return Err(self.error(
                format!("{} stands where the interval needs \",\"", self.found()),
                remedy,
            ));
        }
        let high = self.bound()?;
        let closed = self.take(Kind::CloseSquare) || high.is_none() && self.take(Kind::Close);
        if !closed {
            return Err(self.error(
                format!("{} stands where the interval needs \"]\"", self.found()),
                remedy,
            ));
        }
        let span = start..self.tokens[self.next - 1].span.end;
        self.settle(low, high, span)
    }

    /// Gives a bound without a unit that of the other, and checks the ends.
    fn settle(
        &self,
        (mut low, low_scale): (Bound, f64),
        high: Option<(Bound, f64)>,
        span: Range<usize>,
    ) -> Result<Interval, FormulaError> {
        let mut interval = Interval { low, high: None };
        if let Some((mut high, high_scale)) = high {
            match (low.unit, high.unit) {
                (TimeUnit::Unstated, unit) => low = in_unit(low, unit, high_scale),
                (unit, TimeUnit::Unstated) => high = in_unit(high, unit, low_scale),
                _ => {}
            }
            interval = Interval {
                low,
                high: Some(high),
            };
        }
        // Units that are not stated are settled later; here, only what is wrong in any case.
        match interval.window(TimeModel::Discrete) {
            Err(error) => {
                let message = error.to_string();
                let (message, remedy) =
                    message.split_once("; ").unwrap_or((&message, "correct it"));
                Err(FormulaError::new(
                    self.text,
                    span,
                    message.to_owned(),
                    remedy.to_owned(),
                ))
            }
            Ok(_) => Ok(interval),
        }
    }

    /// A bound with the factor of its unit to the unit of time or count; `None` for infinity.
    fn bound(&mut self) -> Result<Option<(Bound, f64)>, FormulaError> {
        let token = self.peek().clone();
        match token.kind {
            Kind::Number => {
                self.advance();
                let Ok(value) = token.text.parse::<f64>() else {
                    return Err(
                        self.error("this number cannot be read".to_owned(), "write it as 0.5")
                    );
                };
                let (unit, scale) = self.unit()?;
                let bound = in_unit(
                    Bound {
                        value,
                        unit: TimeUnit::Unstated,
                    },
                    unit,
                    scale,
                );
                Ok(Some((bound, scale)))
            }
            Kind::Word if matches!(token.text, "inf" | "infinity" | "∞") => {
                self.advance();
                Ok(None)
            }
            Kind::Word => match (self.parameters)(token.text) {
                Some(secs) => {
                    self.advance();
                    Ok(Some((Bound::secs(secs), 1.0)))
                }
                None => Err(self.error(
                    format!("{} is not the name of a duration", self.found()),
                    "declare it as a parameter with a unit of time, or write a number",
                )),
            },
            _ => Err(self.error(
                format!(
                    "{} stands where a bound of the interval is needed",
                    self.found()
                ),
                "write a number with a unit, as in [0, 2 s], a parameter's name or inf",
            )),
        }
    }

    /// A unit if one comes next, and how many seconds or samples it is.
    fn unit(&mut self) -> Result<(TimeUnit, f64), FormulaError> {
        if self.kind() != Kind::Word {
            return Ok((TimeUnit::Unstated, 1.0));
        }
        let found = UNITS.iter().find(|(name, ..)| *name == self.peek().text);
        let Some(&(_, unit, scale)) = found else {
            return Err(self.error(
                format!("{} is not a unit of time", self.found()),
                "use ns, us, ms, s, min, h or samples",
            ));
        };
        self.advance();
        Ok((unit, scale))
    }
}

const UNITS: [(&str, TimeUnit, f64); 15] = [
    ("ns", TimeUnit::Seconds, 1e-9),
    ("us", TimeUnit::Seconds, 1e-6),
    ("µs", TimeUnit::Seconds, 1e-6),
    ("ms", TimeUnit::Seconds, 1e-3),
    ("s", TimeUnit::Seconds, 1.0),
    ("sec", TimeUnit::Seconds, 1.0),
    ("secs", TimeUnit::Seconds, 1.0),
    ("second", TimeUnit::Seconds, 1.0),
    ("seconds", TimeUnit::Seconds, 1.0),
    ("min", TimeUnit::Seconds, 60.0),
    ("h", TimeUnit::Seconds, 3600.0),
    ("sample", TimeUnit::Samples, 1.0),
    ("samples", TimeUnit::Samples, 1.0),
    ("step", TimeUnit::Samples, 1.0),
    ("steps", TimeUnit::Samples, 1.0),
];

/// The bound, whose number counts units of `scale`.
fn in_unit(bound: Bound, unit: TimeUnit, scale: f64) -> Bound {
    // Dividing by a power of ten that a double holds exactly gives the double nearest to the
    // decimal that was written, which multiplying by its reciprocal may miss.
    let value = if scale < 1.0 {
        bound.value / (1.0 / scale).round()
    } else {
        bound.value * scale
    };
    Bound { value, unit }
}
