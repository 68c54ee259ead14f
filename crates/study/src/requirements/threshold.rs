//! What rate a requirement asks for: its threshold, written or in its sentence, and its margin.

use super::read::Reader;
use crate::sentence_form::SentenceForm;
use diagnostic::Problem;
use evidence::{DEFAULT_MARGIN, Direction, Threshold};
use requirement_lang::sentence::Comparison;
use toml::Spanned;

/// A margin from which on more than half of what a rate can be agrees with the other side, whatever that is.
const WIDE: f64 = 0.5;

impl Reader<'_> {
    /// That a margin is so wide that hardly any two figures differ by more.
    pub(super) fn wide_margin(&self, margin: Option<&Spanned<f64>>) -> Option<Problem> {
        let margin = margin?;
        let value = *margin.get_ref();
        (WIDE..1.0).contains(&value).then(|| {
            let points = (1000.0 * value).round() / 10.0;
            let message = format!(
                "a margin of {points} points: a rate of 50 % agrees with every other, so that agreement says next to nothing"
            );
            Problem::new("wide-margin", message)
                .at(self.source, margin.span())
                .remedy("write the largest difference of two rates that does not matter to you, for example 0.05 for 5 points")
        })
    }

    pub(super) fn margin(&self, margin: Option<Spanned<f64>>) -> Result<f64, Problem> {
        let Some(margin) = margin else {
            return Ok(DEFAULT_MARGIN);
        };
        let value = *margin.get_ref();
        if value > 0.0 && value < 1.0 {
            return Ok(value);
        }
        Err(Problem::new(
            "bad-margin",
            format!("`margin` must be between 0 and 1 (got {value})"),
        )
        .at(self.source, margin.span())
        .remedy("write the difference of two rates that still counts as agreement, for example 0.05 for 5 points"))
    }

    fn threshold(&self, text: &Spanned<String>) -> Result<Threshold, Problem> {
        parse_threshold(text.get_ref()).ok_or_else(|| {
            Problem::new(
                "bad-threshold",
                format!(
                    "`threshold` must be `at least` or `at most` a probability (got `{}`)",
                    text.get_ref()
                ),
            )
            .at(self.source, text.span())
            .remedy("write for example \"at least 0.95\", \"at least 95 %\" or \"at most 0.01\", between 0 and 1")
        })
    }

    /// The threshold that is written, or the one of the sentence; both must
    /// be the same.
    pub(super) fn required(
        &self,
        written: Option<Spanned<String>>,
        sentence: Option<&SentenceForm>,
    ) -> Result<Option<Threshold>, Problem> {
        let of_sentence = match sentence {
            Some(sentence) => self.threshold_of(sentence)?,
            None => None,
        };
        let Some(text) = written else {
            return Ok(of_sentence);
        };
        let threshold = self.threshold(&text)?;
        match of_sentence {
            Some(other) if other != threshold => Err(Problem::new(
                "two-thresholds",
                "the threshold is not the probability that the sentence asks for",
            )
            .at(self.source, text.span())
            .remedy("remove it, or write the same probability in both")),
            _ => Ok(Some(threshold)),
        }
    }

    fn threshold_of(&self, sentence: &SentenceForm) -> Result<Option<Threshold>, Problem> {
        let Some(probability) = &sentence.tree.probability else {
            return Ok(None);
        };
        let direction = match probability.comparison {
            Comparison::AtLeast => Direction::AtLeast,
            Comparison::AtMost => Direction::AtMost,
            Comparison::MoreThan | Comparison::LessThan => {
                let start = sentence.span.start;
                let place = start + probability.span.start..start + probability.span.end;
                return Err(Problem::new(
                    "strict-threshold",
                    "a study's thresholds are `at least` or `at most`: no sample can tell more",
                )
                .at(self.source, place)
                .remedy("write `at least` for `more than`, `at most` for `less than`"));
            }
        };
        Ok(Some(Threshold {
            direction,
            value: probability.value,
        }))
    }
}

fn parse_threshold(text: &str) -> Option<Threshold> {
    let (direction, number) = if let Some(number) = text.strip_prefix("at least ") {
        (Direction::AtLeast, number)
    } else {
        (Direction::AtMost, text.strip_prefix("at most ")?)
    };
    let number = number.trim();
    // In percent by its digits: a quotient would round once more.
    let value: f64 = match number.strip_suffix('%') {
        Some(percent) => format!("{}e-2", percent.trim_end()).parse().ok()?,
        None => number.parse().ok()?,
    };
    (0.0..=1.0)
        .contains(&value)
        .then_some(Threshold { direction, value })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thresholds_are_read_from_words() {
        let read = parse_threshold("at least 0.95").expect("a threshold");
        assert_eq!((read.direction, read.value), (Direction::AtLeast, 0.95));
        assert_eq!(
            parse_threshold("at most 0.1").map(|t| t.direction),
            Some(Direction::AtMost)
        );
        for (text, value) in [("at least 84.95 %", 0.8495), ("at least 7%", 0.07)] {
            assert_eq!(parse_threshold(text).map(|it| it.value), Some(value));
        }
        for bad in [
            "0.95",
            "at least 1.5",
            "at least x",
            "at least -0.1",
            "at least NaN",
            "at least 101 %",
            "at least %",
            "at least 9e1 %",
        ] {
            assert!(parse_threshold(bad).is_none(), "{bad}");
        }
    }
}
