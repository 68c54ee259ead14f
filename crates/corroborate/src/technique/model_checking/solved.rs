//! Constants that were solved for so that a model has a counted rate: their values where the rate is another one.
//!
//! # Definition
//! `f(c)` is what the model computes for a subject with the constant at `c`, and the constant was given the value with which `f` is
//! the counted rate. The rate is uncertain, and so is `c`: at a rate `r` of the counts' posterior `c` solves `f(c) = r`, from the
//! written value on, where the rate rises or falls without a turn (`refinement::nearest_crossing`). Several constants are solved for
//! in turn, the others as they are, until all rates are right. Two that were solved for from one count are not carried: one rate
//! does not tell two constants.
//!
//! # Why
//! A constant that is the counted rate itself is carried with its posterior. One that was solved for was taken as known, so that
//! what its counts leave open was lost, and a model fitted to thirty trials decided a requirement as one without doubt.
//!
//! # Assumes
//! As [`super::uncertainty`]. Of several solutions the one on the stretch of the written value is meant. The constant has the
//! value with which the model has the counted rate: one that has not is no solution, and is not carried.
//!
//! # Guarantee
//! At each point the model has the rate within 1e-4 of the smaller of both outcomes. A rate that it has with no value of the constant
//! counts as the nearest that it has on that stretch: what is computed is under the assumption that the model is right but for its
//! constants. Of how many points that is so is in the evidence, and said with the verdict. Where solving in turn does not settle,
//! nothing that was solved for is carried, and the verdict says so (`evidence`).

use super::Compiled;
use super::functions::Rate;
use crate::technique::counted::CountedConstant;
use diagnostic::Problem;
use evidence::RobustBounds;
use refinement::{Moved, nearest_crossing};

/// How far what the model computes may be from the counted rate, in parts of the smaller of both outcomes: constants are rounded.
const AS_SOLVED: f64 = 1e-2;

/// Or in parts of the rate: three times as far as where a proposal's search ends.
const AS_PROPOSED: f64 = 3e-4;

/// Rounds in which several constants are solved for in turn.
const MOST_ROUNDS: usize = 60;

/// Where a round moves no constant by more than this part of itself, they have settled.
const SETTLED: f64 = 1e-7;

/// The counted constants of a model, and which of them are solved for.
pub(super) struct SolvedFor {
    /// Those whose uncertainty can be carried.
    pub counted: Vec<CountedConstant>,
    solved: Vec<One>,
}

/// The answers of all questions at a point of the counted constants.
type Answers<'f> = dyn Fn(&[f64]) -> Result<Vec<Rate>, Problem> + 'f;

/// A constant that is solved for.
struct One {
    /// Its place among the counted constants.
    place: usize,
    /// The question with the counted rate.
    question: usize,
    /// How it is written.
    written: Moved,
}

impl Compiled<'_> {
    /// The constants whose uncertainty can be carried: those that are a counted rate, and those with which the model has one.
    pub(super) fn solved_for(
        &self,
        counted: &[CountedConstant],
        cancel: &(dyn Fn() -> bool + Sync),
    ) -> Result<SolvedFor, Problem> {
        let mut found = SolvedFor {
            counted: Vec::new(),
            solved: Vec::new(),
        };
        let is_any = counted.iter().any(|it| it.solved_for.is_some());
        let as_written = match is_any && !self.model.model_type.has_choices() {
            true => self.solve_at(&[], &[], cancel)?,
            false => Vec::new(),
        };
        let is_of_another = |constant: &CountedConstant| {
            let solved = counted.iter().filter(|it| it.solved_for.is_some());
            let mut others = solved.filter(|it| it.name != constant.name);
            others.any(|it| it.is_of_the_source_of(constant))
        };
        for constant in counted {
            if let Some(rate) = constant.solved_for {
                if is_of_another(constant) {
                    continue;
                }
                let mut questions = self.questions.iter();
                let question = questions.position(|it| it.subject == &constant.subject);
                let computed = question.and_then(|place| as_written.get(place)?.value);
                let written = Moved::of_model(&self.source.text, &constant.name);
                let (Some(question), Some(computed), Some(written)) = (question, computed, written)
                else {
                    continue;
                };
                let near = f64::max(AS_SOLVED * rate.min(1.0 - rate), AS_PROPOSED * rate);
                if (computed.least - rate).abs() > near {
                    continue;
                }
                found.solved.push(One {
                    place: found.counted.len(),
                    question,
                    written,
                });
            }
            found.counted.push(constant.clone());
        }
        Ok(found)
    }
}

impl SolvedFor {
    /// Whether any constant is solved for.
    pub fn is_any(&self) -> bool {
        !self.solved.is_empty()
    }

    /// A point of the constants with the written value of those that are solved for.
    pub fn as_written(&self, mut point: Vec<f64>) -> Vec<f64> {
        for one in &self.solved {
            point[one.place] = one.written.value;
        }
        point
    }

    /// The answers at a point, which has for a constant that is solved for the rate that the model is to have, and whether the
    /// model has all these rates; `None` where several constants do not settle.
    pub fn row(
        &self,
        point: Vec<f64>,
        at: &Answers<'_>,
        cancel: &dyn Fn() -> bool,
    ) -> Result<Option<(Vec<Rate>, bool)>, Problem> {
        if !self.is_any() {
            return Ok(Some((at(&point)?, true)));
        }
        let targets: Vec<f64> = self.solved.iter().map(|one| point[one.place]).collect();
        let mut point = self.as_written(point);
        for _ in 0..MOST_ROUNDS {
            let (mut is_settled, mut is_reached) = (true, true);
            for (one, target) in self.solved.iter().zip(&targets) {
                let before = point[one.place];
                let mut rate = |value: f64| {
                    point[one.place] = value;
                    // A value with which the model is not valid is none.
                    let row = at(&point).ok()?;
                    row[one.question].value.map(|ends| ends.least)
                };
                let found = nearest_crossing(&mut rate, one.written.at(before), *target);
                if cancel() {
                    return Err(Problem::interrupted());
                }
                let Some((value, reaches)) = found else {
                    return Ok(None);
                };
                point[one.place] = value;
                is_reached &= reaches;
                is_settled &= (value - before).abs() <= SETTLED * before;
            }
            if is_settled || self.solved.len() == 1 {
                return Ok(Some((at(&point)?, is_reached)));
            }
        }
        Ok(None)
    }

    /// For each question that there are no robust bounds.
    pub fn without_bounds(&self, questions: usize) -> Vec<RobustBounds> {
        let names = self.solved.iter();
        let names: Vec<String> = names
            .map(|one| format!("`{}`", self.counted[one.place].name))
            .collect();
        let none = RobustBounds {
            constants: Vec::new(),
            interval: None,
            reason: Some(format!(
                "what was solved for ({}) has no interval that the counts give by themselves",
                names.join(", ")
            )),
        };
        vec![none; questions]
    }
}
