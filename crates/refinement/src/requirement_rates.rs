//! Numbers of a formal model with which its rate of a requirement is the counted one.
//!
//! # Definition
//! For each requirement on which the model disagrees strongly ([`evidence::STRONG`]) with the counts that it may be set to
//! ([`anchors`], the first of them), and which no change for a failure mode fixes: every number of the model that can be
//! moved ([`Number`]), but constants that the ledger says were set to counts, or that are computed from these, is solved for ([`crate::solve`]) so that the
//! model has the counted rate; not where the property judges some run otherwise than its sentence. Those that leave least disagreement with all evidence are offered, the smallest change first; where several
//! leave as much (to within [`AS_GOOD`] decades) each says so.
//!
//! # Assumes
//! One number is wrong, and all else of the model is right. The share that was counted is taken for the rate.
//!
//! # Source and guarantee
//! The method of difference (J. S. Mill, 1843), with one free number: that it makes one requirement agree says little, that
//! it makes the others agree, too, says which number it is. What is offered has been solved. A number that plays a part in
//! nothing that was counted is never offered; a wrong structure (a missing branch, a wrong guard) may be offered as a wrong
//! number, if some number makes up for it.
//!
//! # Cost
//! Some ten solutions of the model for each of at most [`MOST_NUMBERS`] numbers and each requirement; of a large model
//! fewer are tried, so that states times solutions stay below [`crate::model_offers::MOST_WORK`].

use crate::counts::{Counts, anchors};
use crate::draws::names_of;
use crate::model_change::{
    AS_GOOD, Alternative, Changed, FARTHEST, ModelChange, Read, Refusal, Solver, Values, solved,
    value_of, with_interval,
};
use crate::model_offers::{Ground, Model, ModelOffers};
use crate::named_numbers::{NamedNumber, named_numbers};
use crate::number::{Number, numbers};
use crate::solve::{Scale, crossing};
use evidence::{Evidence, Measure, Outcome, STRONG, Subject};

/// Numbers that are solved for, at most: those that come first in the text.
const MOST_NUMBERS: usize = 40;

/// Solutions for one number, about.
const SOLUTIONS: u64 = 12;

/// Offers for one requirement, at most.
const MOST_OFFERS: usize = 4;

/// A requirement on which a model disagrees with counts.
struct Wanted {
    subject: Subject,
    counts: Counts,
    /// How strongly.
    apart: f64,
}

/// A number of a text that is no formal model, with the value with which it agrees.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedOffer {
    /// The number.
    pub number: NamedNumber,
    /// The value.
    pub value: f64,
    /// The requirement whose rate then is the counted one.
    pub subject: Subject,
    /// The counts.
    pub counts: Counts,
    /// What the text then answers.
    pub values: Values,
}

impl Ground<'_> {
    /// The numbers of another text, such as a fault tree, each of which makes a requirement's rate the counted one and leaves
    /// least disagreement: as [`Number`]s are for a formal model. For the requirement that disagrees most; none where the
    /// text's values agree.
    #[must_use]
    pub fn of_named_numbers(
        &self,
        evidence: &str,
        text: &str,
        solver: &dyn Solver,
    ) -> Vec<NamedOffer> {
        let mut all = self.evidence.iter();
        let own = all.find(|piece| piece.id == evidence);
        let (Some(own), Ok(before)) = (own, solver.values(text)) else {
            return Vec::new();
        };
        let Some(wanted) = self.wanted_rates(own, &before).into_iter().next() else {
            return Vec::new();
        };
        let left = |values: &Values| self.disagreement(evidence, values);
        let mut made: Vec<(f64, f64, NamedOffer)> = Vec::new();
        let numbers = named_numbers(text).into_iter();
        let numbers = numbers
            .filter(|it| it.value > 0.0 && own.calibrated.iter().all(|of| of.parameter != it.name));
        for number in numbers.take(MOST_NUMBERS) {
            let scale = Scale::of(number.value, false);
            let solved = |value: f64| solver.values(&number.set(text, value)).ok();
            let mut rate = |value: f64| value_of(&solved(value)?, &wanted.subject);
            let start = (number.value, scale);
            let found = crossing(&mut rate, start, wanted.counts.rate(), FARTHEST);
            if let Some(value) = found
                && let Some(values) = solved(value)
                && left(&values) < left(&before) - STRONG
            {
                let size = scale.distance(value, number.value);
                let offer = NamedOffer {
                    number: number.clone(),
                    value,
                    subject: wanted.subject.clone(),
                    counts: wanted.counts.clone(),
                    values,
                };
                made.push((left(&offer.values), size, offer));
            }
        }
        let least = made.iter().map(|it| it.0).fold(f64::INFINITY, f64::min);
        made.retain(|it| it.0 <= least + AS_GOOD);
        made.sort_by(|a, b| a.1.total_cmp(&b.1));
        made.into_iter().map(|(.., offer)| offer).collect()
    }

    /// Adds what could be changed so that the model's rates of requirements are those that were counted.
    pub(crate) fn of_requirements(
        &self,
        model: &Model<'_>,
        before: &Values,
        found: &mut ModelOffers,
    ) {
        let mut all = self.evidence.iter();
        let Some(own) = all.find(|piece| piece.id == model.evidence) else {
            return;
        };
        for wanted in self.wanted_rates(own, before) {
            let is_mended = |changed: &Changed| {
                let value = value_of(changed.at_last(), &wanted.subject);
                self.strongest(own, &wanted.subject, value) <= STRONG
            };
            if found.changes.iter().any(|(_, changed)| is_mended(changed)) {
                continue;
            }
            match self.numbers_for(model, own, (&wanted, before)) {
                Ok(changes) => found.changes.extend(changes),
                Err(reason) => found.refused.push(format!(
                    "requirement {} of {}: {reason}.",
                    wanted.subject.id(),
                    model.evidence
                )),
            }
        }
    }

    /// The requirements on which a model disagrees strongly, the strongest first.
    fn wanted_rates(&self, own: &Evidence, before: &Values) -> Vec<Wanted> {
        let subjects = before.iter().filter(|(subject, _)| {
            matches!(subject, Subject::Requirement(_)) && self.is_own(subject)
        });
        let wanted = subjects.filter_map(|(subject, value)| {
            // What the model answers is asked again: a value of another method, or given its trigger, is not this one.
            let is_this = matches!(
                &own.finding(subject)?.measure,
                Measure::Probability { answer, .. } if (answer.value - (*value)?).abs() < SAME_ANSWER
            );
            let counts = anchors(self.evidence, own, subject).into_iter().next()?;
            let apart = self.strongest(own, subject, *value);
            let is_apart = apart > STRONG && !self.is_agreed(own, &counts, subject);
            (is_this && is_apart && !self.asks_for_something_else(subject)).then(|| Wanted {
                subject: subject.clone(),
                counts,
                apart,
            })
        });
        let mut wanted: Vec<Wanted> = wanted.collect();
        wanted.sort_by(|a, b| b.apart.total_cmp(&a.apart));
        wanted
    }

    /// Whether the model and what was counted agree by their comparison, which knows the whole range of a decision process.
    pub(crate) fn is_agreed(&self, own: &Evidence, counts: &Counts, subject: &Subject) -> bool {
        let pair = [&own.id, &counts.evidence];
        let mut all = self.comparisons.iter();
        all.any(|it| {
            &it.subject == subject
                && it.outcome == Outcome::Corroborates
                && pair.contains(&&it.left)
                && pair.contains(&&it.right)
        })
    }

    /// Whether its property judges some run otherwise than its sentence: no number of the model makes up for that.
    pub(crate) fn asks_for_something_else(&self, subject: &Subject) -> bool {
        let all = self.evidence.iter().flat_map(|it| &it.form_differences);
        let mut own = all.filter(|it| &it.subject == subject);
        own.any(|it| it.form == "property")
    }

    fn numbers_for(
        &self,
        model: &Model<'_>,
        own: &Evidence,
        (wanted, before): (&Wanted, &Values),
    ) -> Result<Vec<(ModelChange, Changed)>, Refusal> {
        let read = Read::new(model.text)?;
        let is_counted = |name: &str| own.calibrated.iter().any(|it| it.parameter == name);
        let mut names = numbers(&read);
        names.retain(|number| !rests_on(number, &read, &is_counted));
        let affordable = model.affordable(MOST_NUMBERS, SOLUTIONS);
        if affordable == 0 {
            return Err("the model has too many states for its numbers to be tried".into());
        }
        names.truncate(affordable);
        let left = |values: &Values| self.disagreement(model.evidence, values);
        let solved = solved(
            model.text,
            model.solver,
            &names,
            (&wanted.subject, &wanted.counts),
        )?;
        let made = solved
            .into_iter()
            .map(|it| (left(&it.changed.values), it.number, it.changed));
        // What makes as much disagree as it makes agree explains nothing.
        let mut made: Vec<(f64, Number, Changed)> = made
            .filter(|(left_over, ..)| *left_over < left(before) - STRONG)
            .collect();
        let least = made.iter().map(|it| it.0).fold(f64::INFINITY, f64::min);
        made.retain(|(left_over, ..)| *left_over <= least + AS_GOOD);
        if made.is_empty() {
            return Err(
                "no number, set so that its rate is the counted one, agrees better with all evidence"
                    .into(),
            );
        }
        let all: Vec<Number> = made.iter().map(|(_, name, _)| name.clone()).collect();
        made.truncate(MOST_OFFERS);
        let offer = |(_, number, mut changed): (f64, Number, Changed)| {
            changed.notes.clear();
            changed.alternatives = all
                .iter()
                .filter(|other| **other != number)
                .map(|other| Alternative::of_number(other, model.text))
                .collect();
            if !changed.alternatives.is_empty() {
                let others: Vec<&str> = changed
                    .alternatives
                    .iter()
                    .map(|it| it.name.as_str())
                    .collect();
                changed.notes.push(format!(
                    "The evidence does not tell it apart from another value of {}.",
                    others.join(" or of ")
                ));
            }
            let change = ModelChange::Solve {
                subject: wanted.subject.clone(),
                number,
                counts: wanted.counts.clone(),
            };
            with_interval(model.text, model.solver, (change, changed))
        };
        Ok(made.into_iter().map(offer).collect())
    }
}

/// Whether a constant, or what it is computed from, is one of these.
fn rests_on(number: &Number, read: &Read<'_>, is_one: &dyn Fn(&str) -> bool) -> bool {
    let Number::Constant(name) = number else {
        return false;
    };
    let mut waiting = vec![name.as_str()];
    let mut known: Vec<&str> = Vec::new();
    while let Some(name) = waiting.pop() {
        if is_one(name) {
            return true;
        }
        if known.contains(&name) {
            continue;
        }
        known.push(name);
        let declared = read.tree.constants.iter().find(|it| it.name.text == name);
        if let Some(value) = declared.and_then(|it| it.value.as_ref()) {
            names_of(value, &mut waiting);
        }
    }
    false
}

/// Answers of the solver that differ by less are the same.
const SAME_ANSWER: f64 = 1e-6;
