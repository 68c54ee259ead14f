//! Constants of models, and basic events of trees, that were set to counts.
//!
//! # Definition
//! A *source of counts* is a rate that was counted: one subject of one piece of evidence. Constants that were set to one
//! source have one unknown value between them (or its complement), however often the source is named: as independent
//! draws they would average out, and the interval of what is computed from them would be too narrow.
//!
//! # Source
//! The state-of-knowledge correlation of probabilistic risk assessment (G. Apostolakis, S. Kaplan, "Pitfalls in risk
//! calculations", Reliability Engineering 2, 1981).
//!
//! # Assumes
//! Sources are independent of each other, and their trials are, or count at their effective size. The number of a model is
//! the rate that was counted, under the same conditions. Of the runs without a verdict nothing, unless the study declares
//! that they are missing at random: one beta distribution of the rate has the limits of all that they may have shown
//! (`stats::BetaPosterior::spanning`).
//!
//! # Guarantee
//! Sources are taken as independent of each other, also those of one piece of evidence.

use evidence::Subject;
use host::store::Inputs;

/// A constant of the model with the counts that it was set to.
#[derive(Clone, Debug)]
pub struct CountedConstant {
    /// Its name.
    pub name: String,
    /// What the counts say of it.
    pub posterior: stats::BetaPosterior,
    /// The evidence whose counts they are; a tree's own counts are the tree's.
    pub from: String,
    /// Whose rate the counts are.
    pub subject: Subject,
    /// Whether it is set to the complement of that rate; the posterior is the complement's, too.
    pub is_complement: bool,
    /// Whether it keeps its value; then only its bearing is found out.
    pub held: bool,
    /// The rate for which it was solved, where it is not the rate itself: the posterior is that of what the model computes for
    /// the subject, and the constant has the value with which the model does (`model_checking::solved`).
    pub solved_for: Option<f64>,
}

/// What results depend on by the counts of constants.
pub(crate) fn counts_as_inputs(counted: &[CountedConstant], inputs: &mut Inputs) {
    for constant in counted {
        let (alpha, beta) = constant.posterior.parameters();
        inputs.add_json(&constant.name, &(alpha, beta, constant.held));
        let source = (
            &constant.from,
            constant.subject.id(),
            constant.is_complement,
        );
        inputs.add_json(&format!("source of {}", constant.name), &source);
        if let Some(rate) = constant.solved_for {
            inputs.add_json(&format!("{} is solved for", constant.name), &rate);
        }
    }
}

/// The sources of some constants' counts.
pub(crate) struct Sources {
    /// One posterior for each source.
    pub posteriors: Vec<stats::BetaPosterior>,
    /// The names of each source's constants.
    pub names: Vec<String>,
    /// By constant: its source, and whether it is the complement of that source's value.
    of: Vec<(usize, bool)>,
}

impl Sources {
    /// The sources of these constants, in the order of the first of each.
    pub fn of(counted: &[CountedConstant]) -> Self {
        let mut first: Vec<&CountedConstant> = Vec::new();
        let mut names: Vec<String> = Vec::new();
        let mut of = Vec::new();
        for constant in counted {
            let known = first.iter().position(|it| it.is_of_the_source_of(constant));
            let source = known.unwrap_or(first.len());
            match known {
                Some(at) => names[at] = format!("{}, {}", names[at], constant.name),
                None => {
                    first.push(constant);
                    names.push(constant.name.clone());
                }
            }
            let is_mirrored = constant.is_complement != first[source].is_complement;
            of.push((source, is_mirrored));
        }
        Self {
            posteriors: first.iter().map(|it| it.posterior).collect(),
            names,
            of,
        }
    }

    /// The value of each constant where the sources have these values; of one that was solved for the rate that the model has
    /// with it.
    pub fn constants_at(&self, point: &[f64]) -> Vec<f64> {
        let value = |(source, is_mirrored): &(usize, bool)| match is_mirrored {
            true => 1.0 - point[*source],
            false => point[*source],
        };
        self.of.iter().map(value).collect()
    }
}

impl CountedConstant {
    pub(crate) fn is_of_the_source_of(&self, other: &Self) -> bool {
        self.from == other.from && self.subject == other.subject
    }
}
