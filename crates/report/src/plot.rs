//! Strips: one line of a plot, as wide as its place.
//!
//! Every plot here is rows of text with a strip of SVG in each. Positions
//! along a strip are percentages of its width and everything else is in
//! pixels, so a strip is crisp at any width, on paper and on a phone, and the
//! labels beside it stay text of the reader's size.

use evidence::{CredibleInterval, Interval, Mark, Measure, Technique};
use maud::{Markup, html};

use crate::number;

/// Margin at either end of a strip, in per cent, so that marks are not cut.
const MARGIN: f64 = 3.0;
/// Height of a strip in pixels; its middle is where marks sit.
const HEIGHT: u32 = 28;
const MIDDLE: u32 = HEIGHT / 2;
/// Quantiles drawn of a distribution: enough to show its shape.
const QUANTILES_DRAWN: usize = 40;

/// The range of values that a strip shows, with its ticks.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    low: f64,
    high: f64,
    step: f64,
}

impl Axis {
    /// An axis of probabilities that shows all the values and ends at round
    /// numbers within 0 and 1.
    pub fn of_rates(values: impl IntoIterator<Item = f64>) -> Axis {
        let axis = Axis::round(values, 0.02);
        Axis {
            low: axis.low.clamp(0.0, 1.0),
            high: axis.high.clamp(0.0, 1.0),
            ..axis
        }
    }

    /// An axis of differences, symmetric about zero.
    pub fn of_differences(values: impl IntoIterator<Item = f64>) -> Axis {
        let largest = values
            .into_iter()
            .filter(|v| v.is_finite())
            .fold(0.01f64, |most, v| most.max(v.abs()));
        Axis::round([-largest, largest], 0.02)
    }

    fn round(values: impl IntoIterator<Item = f64>, least_range: f64) -> Axis {
        let finite = values.into_iter().filter(|v| v.is_finite());
        let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
            (low.min(v), high.max(v))
        });
        if low > high {
            return Axis {
                low: 0.0,
                high: 1.0,
                step: 0.25,
            };
        }
        // A single value gets room below it, or above it where there is none.
        let (low, high) = match high - low {
            range if range >= least_range => (low, high),
            _ if high >= least_range => (high - least_range, high),
            _ => (low, low + least_range),
        };
        let step = nice_step((high - low) / 5.0);
        let low = (low / step).floor() * step;
        let high = (high / step).ceil() * step;
        Axis { low, high, step }
    }

    /// Where a value sits, in per cent of the width.
    fn at(&self, value: f64) -> f64 {
        let inside = value.clamp(self.low, self.high);
        MARGIN + (100.0 - 2.0 * MARGIN) * (inside - self.low) / (self.high - self.low)
    }

    fn x(&self, value: f64) -> String {
        format!("{:.2}%", self.at(value))
    }

    fn ticks(&self) -> Vec<f64> {
        let steps = ((self.high - self.low) / self.step).round() as usize;
        (0..=steps)
            .map(|i| self.low + i as f64 * self.step)
            .collect()
    }

    /// The row that names the ticks; `unit` is appended to the last one.
    pub fn labels(&self, unit: &str) -> Markup {
        let ticks = self.ticks();
        let decimals = if self.step < 0.01 { 1 } else { 0 };
        html! {
            svg class="scale" width="100%" height="20" aria-hidden="true" {
                @for (i, tick) in ticks.iter().enumerate() {
                    text x=(self.x(*tick)) y="14" text-anchor="middle" {
                        (format!("{:.decimals$}", tick * 100.0 + 0.0).replace('-', "−"))
                        @if i + 1 == ticks.len() { (unit) }
                    }
                }
            }
        }
    }

    /// The row that names values along the axis, such as thresholds.
    pub fn names(&self, names: &[(f64, String)]) -> Markup {
        html! {
            svg class="scale names" width="100%" height="18" aria-hidden="true" {
                @for (value, name) in names {
                    text x=(self.x(*value)) y="13" text-anchor="middle" { (name) }
                }
            }
        }
    }

    fn grid(&self) -> Markup {
        html! {
            g class="grid" {
                @for tick in self.ticks() { line x1=(self.x(tick)) x2=(self.x(tick)) y2="100%" {} }
            }
        }
    }
}

/// The smallest of 1, 2, 5 times a power of ten that is not below `rough`.
fn nice_step(rough: f64) -> f64 {
    let power = 10f64.powf(rough.log10().floor());
    [1.0, 2.0, 5.0]
        .into_iter()
        .map(|m| m * power)
        .find(|step| *step >= rough * 0.9999)
        .unwrap_or(10.0 * power)
}

/// One strip of a forest plot: a finding, its uncertainty, the thresholds.
pub struct Strip<'a> {
    /// Common to all strips of the plot.
    pub axis: &'a Axis,
    /// What was found.
    pub measure: &'a Measure,
    /// Decides the shape of the mark.
    pub technique: Technique,
    /// Hollow: read from a publication, and reproduced by other evidence.
    pub hollow: bool,
    /// Drawn as lines through all strips.
    pub thresholds: &'a [f64],
    /// What a screen reader says.
    pub label: String,
}

impl Strip<'_> {
    /// The strip as SVG.
    pub fn draw(&self) -> Markup {
        html! {
            svg class="strip" width="100%" height=(HEIGHT) role="img" aria-label=(self.label) {
                (self.axis.grid())
                @for threshold in self.thresholds {
                    @let x = self.axis.x(*threshold);
                    line class="threshold" x1=(x) x2=(x) y1="0" y2="100%" {}
                }
                @match self.measure {
                    Measure::Probability { credible: Some(credible), .. } if drawable(&credible.interval) => {
                        (self.distribution(credible))
                    },
                    measure => @if let Some(interval) = measure.interval().filter(drawable) { (self.whisker(interval)) },
                }
                @if let Some(value) = self.measure.estimate().filter(|v| v.is_finite()) {
                    (glyph_at(&self.axis.x(value), self.technique, self.hollow))
                }
            }
        }
    }

    fn whisker(&self, interval: Interval) -> Markup {
        let (low, high) = (self.axis.x(interval.low), self.axis.x(interval.high));
        html! {
            @if low != high {
                line class="whisker" x1=(low) x2=(high) y1=(MIDDLE) y2=(MIDDLE) {}
                line class="whisker" x1=(low) x2=(low) y1=(MIDDLE - 4) y2=(MIDDLE + 4) {}
                line class="whisker" x1=(high) x2=(high) y1=(MIDDLE - 4) y2=(MIDDLE + 4) {}
            }
        }
    }

    fn distribution(&self, credible: &CredibleInterval) -> Markup {
        let (low, high) = (
            self.axis.at(credible.interval.low),
            self.axis.at(credible.interval.high),
        );
        html! {
            rect class="credible" x=(format!("{low:.2}%")) width=(format!("{:.2}%", high - low))
                y=(MIDDLE - 6) height="12" rx="3" {}
            svg viewBox="0 0 1000 10" preserveAspectRatio="none" width="100%" height="12" y=(MIDDLE - 6) {
                path class="quantiles" d=(self.quantile_path(&credible.quantiles)) {}
            }
        }
    }

    fn quantile_path(&self, quantiles: &[f64]) -> String {
        let every = quantiles.len().div_ceil(QUANTILES_DRAWN).max(1);
        quantiles
            .iter()
            .skip(every / 2)
            .step_by(every)
            .filter(|q| q.is_finite())
            .map(|q| format!("M{:.0} 0V10", self.axis.at(*q) * 10.0))
            .collect()
    }
}

/// Whether both ends can be placed on an axis.
fn drawable(interval: &Interval) -> bool {
    interval.low.is_finite() && interval.high.is_finite()
}

/// One strip of a plot of differences: zero, the band of the margin, the
/// difference with its interval. The figures stand beside it as text.
pub fn difference_strip(
    axis: &Axis,
    margin: f64,
    difference: f64,
    interval: Option<Interval>,
) -> Markup {
    let (low, high) = (axis.at(-margin), axis.at(margin));
    let zero = axis.x(0.0);
    html! {
        svg class="strip difference" width="100%" height=(HEIGHT) aria-hidden="true" {
            rect class="margin" x=(format!("{low:.2}%")) width=(format!("{:.2}%", high - low)) y="0" height="100%" {}
            line class="zero" x1=(zero) x2=(zero) y1="0" y2="100%" {}
            @if let Some(interval) = interval.filter(drawable) {
                line class="whisker" x1=(axis.x(interval.low)) x2=(axis.x(interval.high))
                    y1=(MIDDLE) y2=(MIDDLE) {}
            }
            @if difference.is_finite() { circle cx=(axis.x(difference)) cy=(MIDDLE) r="3.5" {} }
        }
    }
}

/// A technique's mark, by itself, for keys and labels.
pub fn glyph(technique: Technique, hollow: bool) -> Markup {
    html! {
        svg class="glyph" width="14" height="14" viewBox="-7 -7 14 14" aria-hidden="true" {
            (shape(technique, hollow))
        }
    }
}

fn glyph_at(x: &str, technique: Technique, hollow: bool) -> Markup {
    html! {
        svg x=(x) y=(MIDDLE) width="1" height="1" overflow="visible" { (shape(technique, hollow)) }
    }
}

fn shape(technique: Technique, hollow: bool) -> Markup {
    let class = if hollow { "mark hollow" } else { "mark" };
    html! {
        @match technique.traits().mark {
            Mark::Diamond => path class=(class) d="M0-6L6 0L0 6L-6 0Z" {},
            Mark::Wedge => path class=(class) d="M0 5.6L5.6-4.4L-5.6-4.4Z" {},
            Mark::Circle => circle class=(class) r="4.5" {},
            Mark::Square => rect class=(class) x="-4.2" y="-4.2" width="8.4" height="8.4" {},
            Mark::Triangle => path class=(class) d="M0-5.6L5.6 4.4L-5.6 4.4Z" {},
        }
    }
}

/// The finding in one line of text, for screen readers.
pub fn spoken(evidence: &str, measure: &Measure) -> String {
    match measure {
        Measure::Counts {
            count,
            trials,
            interval,
            ..
        } => format!(
            "{evidence}: {count} of {trials}, interval {}",
            number::interval(*interval)
        ),
        Measure::Probability {
            answer, credible, ..
        } => {
            let spread = credible.as_ref().map_or(String::new(), |c| {
                format!(", credible interval {}", number::interval(c.interval))
            });
            format!(
                "{evidence}: computed probability {}{spread}",
                number::answer(answer)
            )
        }
        Measure::NotExpressible { reason } => format!("{evidence}: not expressible, {reason}"),
        Measure::NotCovered { reason, .. } => format!("{evidence}: not covered, {reason}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_axis_holds_its_values_and_stays_within_probabilities() {
        let values = [0.71, 0.88, 0.95, 1.0];
        let axis = Axis::of_rates(values);
        for value in values {
            let at = axis.at(value);
            assert!(
                (MARGIN - 1e-9..=100.0 - MARGIN + 1e-9).contains(&at),
                "{value} at {at}"
            );
        }
        assert!(axis.low >= 0.0 && axis.high <= 1.0);
        assert!((3..=10).contains(&axis.ticks().len()), "{:?}", axis.ticks());
    }

    #[test]
    fn positions_keep_the_order_of_values() {
        let axis = Axis::of_rates([0.6, 0.95]);
        assert!(axis.at(0.6) < axis.at(0.8) && axis.at(0.8) < axis.at(0.95));
    }

    #[test]
    fn an_axis_exists_for_one_value_and_for_none() {
        for values in [vec![1.0], vec![0.0], vec![], vec![f64::NAN]] {
            let axis = Axis::of_rates(values.clone());
            assert!(axis.high > axis.low, "{values:?}: {axis:?}");
            assert!(axis.at(0.5).is_finite());
        }
    }

    #[test]
    fn differences_are_symmetric_about_zero() {
        let axis = Axis::of_differences([-0.12, 0.05]);
        assert!((axis.at(0.0) - 50.0).abs() < 1e-9);
    }

    #[test]
    fn steps_are_round() {
        assert!((nice_step(0.03) - 0.05).abs() < 1e-12);
        assert!((nice_step(0.2) - 0.2).abs() < 1e-12);
        assert!((nice_step(0.0051) - 0.01).abs() < 1e-12);
    }
}
