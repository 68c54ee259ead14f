//! What `what-if` prints.

use crate::technique::campaign::failures_in_words;
use evidence::{EpisodeFailures, Interval, Subject, Technique};
use schemars::JsonSchema;
use serde::Serialize;
use std::fmt::Write;

/// All variants that were tried.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct WhatIfReport {
    /// Level of the intervals.
    pub confidence: f64,
    /// The variants.
    pub variants: Vec<VariantReport>,
}

/// One variant, in each technique.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct VariantReport {
    /// Its name.
    pub name: String,
    /// What would be different.
    pub meaning: String,
    /// What it means to each piece of evidence, and what that takes for granted.
    pub changes: Vec<ChangeReport>,
    /// What it would bring.
    pub rows: Vec<Row>,
    /// Where techniques predict gains that exclude each other.
    pub parted: Vec<String>,
    /// How many pairs of predictions on one subject under the same conditions were compared for that.
    pub pairs: u64,
    /// Episodes that the robot's program or the physics ended by failing; those are judged up to there.
    pub failures: Vec<VariantFailures>,
}

/// How often one kind of failure ended episodes of one piece of evidence.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct VariantFailures {
    /// The evidence.
    pub evidence: String,
    /// Whether the variant was in it.
    pub with_variant: bool,
    /// How often.
    pub failures: EpisodeFailures,
}

/// What a variant means to one piece of evidence.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct ChangeReport {
    /// The evidence.
    pub evidence: String,
    /// The changes, each as `key = value`; or why there are none.
    pub what: Vec<String>,
    /// What is taken for granted.
    pub assumes: Option<String>,
}

/// One subject in one piece of evidence.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Row {
    /// The requirement or failure mode.
    pub subject: Subject,
    /// The evidence.
    pub evidence: String,
    /// Its technique.
    pub technique: Technique,
    /// The conditions under which it holds.
    pub conditions: String,
    /// What it predicts.
    pub gain: Gain,
}

/// A predicted gain.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case", tag = "kind")]
pub enum Gain {
    /// It could be tried.
    Known {
        /// The rate or probability without the variant.
        before: f64,
        /// With it.
        after: f64,
        /// The difference.
        gain: f64,
        /// Its interval; none where nothing of the model is uncertain.
        interval: Option<Interval>,
        /// On what the two were compared.
        how: String,
        /// Of "it changes nothing", for paired episodes.
        p_value: Option<f64>,
    },
    /// This evidence cannot say.
    NotExpressible {
        /// Why.
        reason: String,
    },
}

/// Pairs of rows on one subject under the same conditions whose intervals do not overlap, and how many pairs there are. A
/// gain of a model in which nothing is uncertain is an interval of its own.
pub fn parted(rows: &[Row]) -> (Vec<String>, u64) {
    let known = |row: &Row| match &row.gain {
        Gain::Known { gain, interval, .. } => {
            let exact = Interval {
                low: *gain,
                high: *gain,
            };
            Some((*gain, interval.unwrap_or(exact)))
        }
        Gain::NotExpressible { .. } => None,
    };
    let (mut found, mut pairs) = (Vec::new(), 0);
    for (place, left) in rows.iter().enumerate() {
        for right in &rows[place + 1..] {
            if (&left.subject, &left.conditions) != (&right.subject, &right.conditions) {
                continue;
            }
            let (Some((a, first)), Some((b, second))) = (known(left), known(right)) else {
                continue;
            };
            pairs += 1;
            // Two exact gains differ in their last digits by how they were computed.
            if second.low - first.high > ROUNDING || first.low - second.high > ROUNDING {
                found.push(format!(
                    "{}: {} predicts a gain of {a:+.4}, {} of {b:+.4}; their intervals do not overlap, so one of the \
                     two does not have what decides it.",
                    name_of(&left.subject),
                    left.evidence,
                    right.evidence
                ));
            }
        }
    }
    (found, pairs)
}

/// By less than this gains do not exclude each other: it is beyond what solvers answer to.
const ROUNDING: f64 = 1e-6;

impl WhatIfReport {
    /// For people.
    pub fn text(&self) -> String {
        let mut text = String::new();
        // Writing to a string cannot fail.
        let _ = self.write(&mut text);
        text
    }

    fn write(&self, text: &mut String) -> std::fmt::Result {
        for variant in &self.variants {
            writeln!(text, "{}\n  {}", variant.name, variant.meaning)?;
            for change in &variant.changes {
                writeln!(text, "  {}: {}", change.evidence, change.what.join(", "))?;
                if let Some(assumes) = &change.assumes {
                    writeln!(text, "    taken for granted: {assumes}")?;
                }
            }
            writeln!(text)?;
            for row in &variant.rows {
                writeln!(text, "    {}", row_words(row, self.confidence))?;
            }
            for of in &variant.failures {
                let which = match of.with_variant {
                    true => "with the variant",
                    false => "as it is",
                };
                let words = failures_in_words(&of.failures);
                writeln!(text, "  {}, {which}: {words}", of.evidence)?;
            }
            writeln!(text)?;
            self.write_parted(variant, text)?;
            writeln!(text)?;
        }
        Ok(())
    }
}

impl WhatIfReport {
    /// Where predictions exclude each other, or that none do.
    fn write_parted(&self, variant: &VariantReport, text: &mut String) -> std::fmt::Result {
        let (parted, pairs) = (variant.parted.len(), variant.pairs);
        let level = format!("{:.0} % intervals", self.confidence * 100.0);
        match (parted, pairs) {
            (_, 0) => writeln!(
                text,
                "  No two techniques predict the same quantity, so none can exclude another."
            ),
            (0, _) => writeln!(
                text,
                "  No predictions exclude each other ({pairs} compared, by {level})."
            ),
            _ => {
                writeln!(
                    text,
                    "  Predictions exclude each other: {parted} of {pairs} compared, by {level}"
                )?;
                let mut all = variant.parted.iter();
                all.try_for_each(|it| writeln!(text, "    {it}"))
            }
        }
    }
}

fn row_words(row: &Row, confidence: f64) -> String {
    let (name, evidence) = (name_of(&row.subject), &row.evidence);
    match &row.gain {
        Gain::NotExpressible { reason } => format!("{name:<28} {evidence:<6} {reason}"),
        Gain::Known {
            before,
            after,
            gain,
            interval,
            how,
            p_value,
        } => {
            let interval = interval.map_or("nothing uncertain".to_owned(), |it| {
                format!(
                    "{:.0} % [{:+.4}, {:+.4}]",
                    confidence * 100.0,
                    it.low,
                    it.high
                )
            });
            let p = p_value.map_or(String::new(), |p| match p < 0.001 {
                true => ", p < 0.001".to_owned(),
                false => format!(", p {p:.3}"),
            });
            format!(
                "{name:<28} {evidence:<6} {before:.4} -> {after:.4}  {gain:+.4} {interval} ({how}{p})"
            )
        }
    }
}

fn name_of(subject: &Subject) -> String {
    subject.in_words()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(evidence: &str, low: f64, high: f64) -> Row {
        Row {
            subject: Subject::Requirement("1a".into()),
            evidence: evidence.into(),
            technique: Technique::Simulation,
            conditions: "typical".into(),
            gain: Gain::Known {
                before: 0.5,
                after: 0.5 + low,
                gain: low,
                interval: Some(Interval { low, high }),
                how: String::new(),
                p_value: None,
            },
        }
    }

    #[test]
    fn gains_part_where_their_intervals_do_not_overlap() {
        let count = |rows: &[Row]| {
            let (found, pairs) = parted(rows);
            (found.len(), pairs)
        };
        assert_eq!(count(&[row("A", 0.0, 0.1), row("B", 0.1, 0.2)]), (0, 1));
        assert_eq!(count(&[row("A", 0.0, 0.1), row("B", 0.11, 0.2)]), (1, 1));
        // Of a model in which nothing is uncertain the gain is a number.
        let exact = |gain: f64| {
            let mut row = row("M", gain, gain);
            if let Gain::Known { interval, .. } = &mut row.gain {
                *interval = None;
            }
            row
        };
        assert_eq!(count(&[exact(0.3), row("B", 0.1, 0.2)]), (1, 1));
        assert_eq!(count(&[exact(0.15), row("B", 0.1, 0.2)]), (0, 1));
        assert_eq!(count(&[exact(0.15), exact(0.15 + 1e-12)]), (0, 1));
        let elsewhere = Row {
            conditions: "crossing".into(),
            ..row("B", 0.11, 0.2)
        };
        assert_eq!(count(&[row("A", 0.0, 0.1), elsewhere]), (0, 0));
    }

    #[test]
    fn the_text_says_where_predictions_exclude_each_other_and_where_none_do() {
        let text = |rows: Vec<Row>| {
            let (parted, pairs) = parted(&rows);
            let variant = VariantReport {
                name: "slower".into(),
                meaning: "It drives slower.".into(),
                changes: vec![],
                rows,
                parted,
                pairs,
                failures: vec![],
            };
            let report = WhatIfReport {
                confidence: 0.95,
                variants: vec![variant],
            };
            report.text()
        };
        let told = text(vec![row("A", 0.0, 0.1), row("B", 0.11, 0.2)]);
        assert!(
            told.contains("exclude each other: 1 of 1 compared, by 95 % intervals"),
            "{told}"
        );
        assert!(
            told.contains("A predicts a gain of +0.0000, B of +0.1100"),
            "{told}"
        );
        let told = text(vec![row("A", 0.0, 0.1), row("B", 0.1, 0.2)]);
        assert!(
            told.contains("No predictions exclude each other (1 compared"),
            "{told}"
        );
        assert!(text(vec![row("A", 0.0, 0.1)]).contains("so none can exclude another"));
    }
}
