//! A variant in a formal model.
//!
//! # Definition
//! The constants of a variant are expressions over the values that the model's
//! constants have. The model is solved with its own constants and with the
//! variant's, at the constants' values and at points of the posteriors of those
//! that were set to counts (Jeffreys), the same points for both. The gain's
//! interval is that of the differences at these points.

use super::file::{ChangeText, Read};
use super::report::Gain;
use crate::technique::model_checking::Compiled;
use diagnostic::Problem;
use evidence::{Interval, StudyResult, Subject};
use host::{Cancel, Stage};
use prism_lang::Constants;
use rayon::prelude::*;
use std::collections::BTreeMap;
use study::{Entry, Study};

/// Values of a model's constants.
type Point = Vec<(String, f64)>;

/// Answers by subject.
type Values = BTreeMap<Subject, Option<f64>>;

/// A model as it is, at its own constants and at points of their posteriors.
pub struct Base<'a> {
    compiled: Compiled<'a>,
    points: Vec<Point>,
    own: Values,
    at_points: Vec<Values>,
}

impl<'a> Base<'a> {
    /// Solves the model of an entry at `points` points.
    pub fn new(
        study: &'a Study,
        result: &StudyResult,
        entry: &Entry,
        compiled: Compiled<'a>,
        points: usize,
        interrupt: &Cancel,
        stage: &Stage,
    ) -> Result<Self, Problem> {
        let level = crate::technique::confidence(study.about.confidence)?;
        let (mut names, mut posteriors) = (Vec::new(), Vec::new());
        for calibrated in entry.calibrated.iter().filter(|it| !it.held) {
            let calibration = &calibrated.calibration;
            let piece = result.evidence.iter().find(|e| e.id == calibration.from);
            let finding = piece.and_then(|piece| piece.finding(&calibration.subject));
            if let (Some(name), Some(finding)) = (&calibrated.constant, finding)
                && let Some(posterior) = calibrated.posterior(finding, level)
            {
                names.push(name.clone());
                posteriors.push(posterior);
            }
        }
        let design = match names.is_empty() {
            true => Vec::new(),
            false => stats::posterior_design(&posteriors, points, study.about.seed),
        };
        let points: Vec<Point> = design
            .into_iter()
            .map(|row| names.iter().cloned().zip(row).collect())
            .collect();
        let own = compiled.values_at(&[], &|| interrupt.is_cancelled())?;
        let at_points = solved(&compiled, &points, interrupt, stage)?;
        Ok(Self {
            compiled,
            points,
            own,
            at_points,
        })
    }

    /// The gains of a variant.
    pub fn gains(
        &self,
        read: &Read,
        change: &ChangeText,
        subjects: &[Subject],
        level: stats::Confidence,
        interrupt: &Cancel,
        stage: &Stage,
    ) -> Result<Vec<(Subject, Gain)>, Problem> {
        let own = self.varied(read, change, &[])?;
        let own = self
            .compiled
            .values_at(&own, &|| interrupt.is_cancelled())?;
        let points: Vec<Point> = self
            .points
            .iter()
            .map(|point| self.varied(read, change, point))
            .collect::<Result<_, _>>()?;
        let varied = solved(&self.compiled, &points, interrupt, stage)?;
        let gains = subjects.iter().map(|subject| {
            let gain = self.gain(subject, &own, &varied, level)?;
            Ok((subject.clone(), gain))
        });
        gains.collect()
    }

    fn gain(
        &self,
        subject: &Subject,
        own: &Values,
        varied: &[Values],
        level: stats::Confidence,
    ) -> Result<Gain, Problem> {
        let value = |values: &Values| values.get(subject).copied().flatten();
        let (Some(before), Some(after)) = (value(&self.own), value(own)) else {
            return Ok(Gain::NotExpressible {
                reason: "The model does not express it.".into(),
            });
        };
        let column = |rows: &[Values]| -> Option<Vec<f64>> { rows.iter().map(&value).collect() };
        let interval = match (column(&self.at_points), column(varied)) {
            (Some(first), Some(second)) if !first.is_empty() => {
                let draws = stats::paired_difference(&first, &second)
                    .map_err(|error| Problem::new("cannot-carry-uncertainty", error.to_string()))?;
                let interval = draws.interval(level);
                Some(Interval {
                    low: interval.low,
                    high: interval.high,
                })
            }
            _ => None,
        };
        Ok(Gain::Known {
            before,
            after,
            gain: after - before,
            interval,
            how: match varied.len() {
                0 => "no constant is estimated from counts".to_owned(),
                points => format!("the same {points} points of the constants' posteriors"),
            },
            p_value: None,
        })
    }

    /// The constants of the variant at a point, with the point's others.
    fn varied(
        &self,
        read: &Read,
        change: &ChangeText,
        point: &[(String, f64)],
    ) -> Result<Point, Problem> {
        let mut varied: Point = point.to_vec();
        for (name, expression) in &change.constants {
            let wrong = |reason: String, remedy: &str| {
                Problem::new(super::file::CODE, reason)
                    .at(&read.source, expression.span())
                    .remedy(remedy)
            };
            if self.compiled.constant(name).is_none() {
                let reason = format!("the model has no number `{name}` among its constants");
                return Err(wrong(reason, "name a constant that the model defines"));
            }
            let value = self.value(expression.get_ref(), point).map_err(|reason| {
                wrong(reason, "write an expression over the model's constants")
            })?;
            if self.compiled.is_whole(name) && value.fract() != 0.0 {
                let reason = format!(
                    "`{name}` is a whole number in the model, and the variant gives it {value}"
                );
                return Err(wrong(reason, "round it: `floor(...)`, `ceil(...)`"));
            }
            varied.retain(|(other, _)| other != name);
            varied.push((name.clone(), value));
        }
        Ok(varied)
    }

    /// An expression over the model's constants, some of which have other values.
    fn value(&self, expression: &str, point: &[(String, f64)]) -> Result<f64, String> {
        const RESULT: &str = "what_if_result";
        let mut text = String::from("dtmc\n");
        for name in self.compiled.constants() {
            let moved = point.iter().find(|(other, _)| other == name);
            let value = moved.map(|(_, value)| *value);
            if let Some(value) = value.or_else(|| self.compiled.constant(name)) {
                text.push_str(&format!("const double {name} = {value:?};\n"));
            }
        }
        text.push_str(&format!(
            "const double {RESULT} = {expression};\nmodule m\n  m_ : bool init false;\nendmodule\n"
        ));
        let words = |found: prism_lang::Diagnostics| {
            let all: Vec<String> = found.into_iter().map(|d| d.message).collect();
            all.join("; ")
        };
        let tree = prism_lang::parse_model(&text)
            .into_result()
            .map_err(words)?;
        let model = prism_lang::resolve(&tree, &Constants::new()).map_err(words)?;
        match model.constant(RESULT) {
            Some(prism_lang::Value::Double(number)) => Ok(number.to_f64()),
            Some(prism_lang::Value::Int(value)) => Ok(*value as f64),
            _ => Err("its result is not a number".into()),
        }
    }
}

fn solved(
    compiled: &Compiled,
    points: &[Point],
    interrupt: &Cancel,
    stage: &Stage,
) -> Result<Vec<Values>, Problem> {
    points
        .par_iter()
        .map(|point| {
            if interrupt.is_cancelled() {
                return Err(Problem::interrupted());
            }
            let values = compiled.values_at(point, &|| interrupt.is_cancelled());
            stage.advance();
            values
        })
        .collect()
}
