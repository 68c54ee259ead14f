//! What a change explains that moves the values of a computed piece, such as a branch of a command or a gate of a fault tree
//! that becomes another.
//!
//! # Definition
//! On each subject the piece is held against every other one that speaks for itself, by the signed strength of disagreement
//! ([`evidence::signed_strength`]); the strongest counts. A change *explains* the subjects that disagreed strongly
//! ([`evidence::STRONG`]) and do not any more. Its *weight* is, in decades,
//!
//! * what goes away on them, less what comes up anywhere else; more than [`STRONG`] has to go away on the whole, and no more
//!   than that may come up;
//! * how well all agree on them then: of each the evidence for one rate of its weakest pair;
//! * less [`FREE_VALUE`] if the values are not near to what was counted: by [`NEARER`] of the margin the evidence on one of the
//!   subjects speaks for a difference, or the exact binomial tests of the counts reject the value at [`UNLIKELY`]. What has no free
//!   number has to give the rates as they are, not only within a margin;
//! * less [`FREE_VALUE`] if a number was solved for, which makes one rate agree whatever the truth is; less the decades of
//!   the number of kinds of changes, and of the changes of its own kind that move a value at all, if nothing was.
//!
//! Whatever else it explains, one without a free number explains nothing where a test of the counts rejects a value of it at [`REFUTED`].
//!
//! What makes a value 0 or 1 is weighed with [`NEARER`] of the margin, and explains nothing if counts show otherwise.
//!
//! A change without a free number is taken where its weight, after this correction, is still strong. Of changes that weigh as
//! much (to within [`AS_GOOD`]) the one comes first whose values are nearest to what was counted, and to what other models compute
//! that agree with the counts: the same strengths with [`NEARER`] of the margins, which tell values apart that the margins do not; of a
//! model at most [`OF_MODEL`].
//!
//! # Assumes
//! One change is enough, and changes of one kind are equally likely before. What a free number costs is a guess
//! ([`FREE_VALUE`]). The strengths take trials as independent, or at their effective size.
//!
//! # Source and guarantee
//! As for single edits of texts: the method of difference (J. S. Mill, 1843), and Bayes factors with the correction for the number
//! of hypotheses (H. Jeffreys, "Theory of Probability", 1961, section 5.04). What is offered was computed, and may still be
//! wrong: two changes of structure that lead to values within the margins of each other cannot be told apart by them.

use crate::counts::{Counts, anchors};
use crate::model_change::{AS_GOOD, Alternative, Changed, ModelChange, Values, value_of};
use crate::model_offers::{Ground, Model, ModelOffers};
use crate::trial::{SAME_VALUE, never_triggers};
use evidence::{Evidence, Guarantee, Measure, Outcome, Rate, STRONG, Subject, signed_strength};
use std::collections::BTreeMap;

/// Decades against a number that is solved for: it makes one rate agree whatever the truth is.
pub const FREE_VALUE: f64 = 3.0;

/// The part of the margins by which changes that explain as much are told apart, and that softens a certainty.
const NEARER: f64 = 0.1;

/// The p-value below which an exact test of a value says that a change without a free number does not give the counts.
const UNLIKELY: f64 = 0.05;

/// The p-value below which the counts refute the value that a change without a free number gives: it is not what was wrong.
const REFUTED: f64 = 0.002;

/// Decades of distance that tell nothing apart.
const SAME_DISTANCE: f64 = 1e-6;

/// The most that a model counts against a change that explains as much as another.
const OF_MODEL: f64 = 2.0;

/// What a piece that is asked again may differ by from what the run kept.
const SAME_ANSWER: f64 = 1e-6;

/// A change without a free number that was tried.
pub(crate) struct Tried<C> {
    /// The change.
    pub(crate) change: C,
    /// Which kind of change it is: kinds are as likely as each other, and so are the changes of one kind.
    pub(crate) kind: u8,
    /// What is answered with it.
    pub(crate) values: Values,
}

/// One that explains what disagrees.
pub(crate) struct Explaining<C> {
    pub(crate) change: C,
    pub(crate) values: Values,
    pub(crate) weight: f64,
    /// How many were tried that move a value.
    pub(crate) tried: usize,
    /// The subjects that it explains, the strongest disagreement first.
    pub(crate) subjects: Vec<Subject>,
}

/// What a change explains, before it is held against how many were tried.
struct Balance {
    weight: f64,
    subjects: Vec<(f64, Subject)>,
}

/// A change of a model's text without a free number.
pub(crate) trait Rewriting {
    /// What is done, in one clause.
    fn in_words(&self, text: &str) -> String;
    /// The line of the text that it changes, from 1.
    fn line(&self, text: &str) -> Option<u32>;
    /// Why no number was fitted, and how many others were tried that move a value.
    fn note(&self, others: usize) -> String;
    /// The change as it is offered for a subject, whose counts it explains.
    fn offered(self, subject: Subject, counts: Counts, tried: usize) -> ModelChange;
}

/// Changes of a kind that are offered, at most.
const MOST_OFFERS: usize = 3;

impl Ground<'_> {
    /// The subjects on which a computed piece disagrees strongly with counts, by what it answers now; without those that its
    /// property judges otherwise than the sentence.
    pub(crate) fn in_conflict(&self, own: &Evidence, before: &Values) -> Vec<Subject> {
        let is_in_conflict = |subject: &&Subject| {
            let value = value_of(before, subject);
            let is_kept = |value: f64| {
                let kept = own.finding(subject).map(|finding| &finding.measure);
                match kept {
                    Some(Measure::Probability { answer, .. }) => {
                        (answer.value - value).abs() < SAME_ANSWER
                    }
                    // What says nothing of the system as it is may say something with another beginning.
                    Some(Measure::NotCovered { constant, .. }) => constant.is_some(),
                    _ => false,
                }
            };
            let is_asked = match value {
                Some(value) => is_kept(value),
                None => never_triggers(own, subject),
            };
            is_asked
                && self.is_own(subject)
                && self.strongest(own, subject, value) > STRONG
                && !self.agrees(own, subject)
                && !self.asks_for_something_else(subject)
        };
        before.keys().filter(is_in_conflict).cloned().collect()
    }

    /// Whether all comparisons of a piece with others on a subject say that they agree: of a decision process the whole range counts,
    /// of which one end may be far from what was counted; one that is too wide to agree with anything contradicts nothing in it.
    fn agrees(&self, own: &Evidence, subject: &Subject) -> bool {
        let is_range = matches!(
            own.finding(subject).map(|finding| &finding.measure),
            Some(Measure::Probability { answer, .. })
                if matches!(answer.guarantee, Guarantee::Schedulers { .. })
        );
        let all = self.comparisons.iter();
        let mut own = all
            .filter(|it| &it.subject == subject && [&it.left, &it.right].contains(&&own.id))
            .filter(|it| it.outcome != Outcome::NotComparable)
            .peekable();
        own.peek().is_some()
            && own.all(|it| {
                it.outcome == Outcome::Corroborates || is_range && it.outcome != Outcome::Conflicts
            })
    }

    /// Whether counts leave room for a value: no exact test of one of them, nor of all together, rejects it at this level.
    fn gives_the_counts(
        &self,
        own: &Evidence,
        (subject, value): (&Subject, f64),
        level: f64,
    ) -> bool {
        let pieces = self.speaking(own, subject);
        // As they are written, so that what is said of them beside an offer is what decided its place.
        let counted = pieces.iter().filter_map(|piece| {
            let finding = piece.finding(subject)?;
            match &finding.measure {
                Measure::Counts { count, trials, .. } if finding.undecided == 0 => {
                    stats::Sample::new(*count, *trials).ok()
                }
                _ => None,
            }
        });
        let mut together = [0, 0];
        for sample in counted {
            let alone = stats::binomial_test_two_sided(sample, value.clamp(0.0, 1.0));
            if alone < level {
                return false;
            }
            together[0] += sample.successes;
            together[1] += sample.trials;
        }
        stats::Sample::new(together[0], together[1]).is_ok_and(|all| {
            all.trials == 0 || stats::binomial_test_two_sided(all, value.clamp(0.0, 1.0)) >= level
        })
    }

    /// How strongly a value disagrees with the piece that it disagrees most with, or, below 0, how well it agrees with the one
    /// that it agrees least with; none where nothing speaks on the subject.
    fn signed(&self, own: &Evidence, subject: &Subject, value: f64, part: f64) -> Option<f64> {
        let pieces = self.speaking(own, subject).into_iter();
        let margin = self.margin(subject) * part;
        let apart = pieces.filter_map(|piece| {
            let theirs = Rate::on(piece, subject)?;
            Some(signed_strength(
                Rate::claimed(value, subject),
                theirs,
                margin,
            ))
        });
        apart.max_by(f64::total_cmp)
    }

    /// How far values are from what was counted, and from what models compute that agree with it, where the margins do not tell.
    fn distance(&self, own: &Evidence, values: &Values) -> f64 {
        let of_subject = |(subject, value): (&Subject, &Option<f64>)| {
            let value = value.filter(|_| self.is_own(subject))?;
            let counted = self.signed(own, subject, value, NEARER);
            let models = self.evidence.iter().filter(|piece| {
                let is_one = piece.id != own.id
                    && piece.conditions == own.conditions
                    && piece.technique.is_of_model();
                is_one && !piece.intermediate
            });
            let computed = models.filter_map(|piece| {
                let theirs = Rate::on(piece, subject)?;
                let agrees = self.strongest(piece, subject, theirs.computed()) <= STRONG;
                let margin = self.margin(subject) * NEARER;
                let apart = signed_strength(Rate::claimed(value, subject), theirs, margin);
                agrees.then_some(apart.min(OF_MODEL))
            });
            Some(counted.unwrap_or_default() + computed.fold(0.0, f64::max))
        };
        values.iter().filter_map(of_subject).sum()
    }

    /// Whether a value gives the rates that were counted as they are, not only within the margin: what has no free number, and is
    /// right, does.
    #[must_use]
    pub fn is_near(&self, own: &Evidence, subject: &Subject, value: f64) -> bool {
        let nearer = self.signed(own, subject, value, NEARER);
        nearer.is_none_or(|it| it <= 0.0) && self.gives_the_counts(own, (subject, value), UNLIKELY)
    }

    fn balance(&self, own: &Evidence, before: &Values, after: &Values) -> Option<Balance> {
        let (mut gone, mut come, mut agreement) = (0.0, 0.0, 0.0);
        let mut is_near = true;
        let mut subjects = Vec::new();
        for (subject, was) in before.iter().filter(|(subject, _)| self.is_own(subject)) {
            if was.is_none() && !never_triggers(own, subject) {
                continue;
            }
            let value = match (*was, value_of(after, subject)) {
                (_, Some(value)) => value,
                // It still comes to no run that triggers it.
                (None, None) => continue,
                // A value that is lost explains nothing.
                (Some(_), None) => return None,
            };
            let is = value;
            // That something always or never happens is a claim of its own, which no margin for rates softens.
            let was_open = was.is_none_or(|was| was > 0.0 && was < 1.0);
            let is_certain = was_open && (is <= 0.0 || is >= 1.0);
            let part = if is_certain { NEARER } else { 1.0 };
            let both = (
                match was {
                    Some(was) => self.signed(own, subject, *was, 1.0),
                    None => Some(self.strongest(own, subject, None)),
                },
                self.signed(own, subject, is, part),
            );
            let (Some(was), Some(is)) = both else {
                continue;
            };
            if is_certain && is > STRONG {
                return None;
            }
            come += (is.max(0.0) - was.max(0.0)).max(0.0);
            if was > STRONG && is <= STRONG {
                gone += was - is.max(0.0);
                agreement += (-is).max(0.0);
                is_near &= self.is_near(own, subject, value);
                subjects.push((was, subject.clone()));
            }
        }
        subjects.sort_by(|a, b| b.0.total_cmp(&a.0));
        let off = if is_near { 0.0 } else { FREE_VALUE };
        (gone - come > STRONG && come <= STRONG).then_some(Balance {
            weight: gone - come + agreement - off,
            subjects,
        })
    }

    /// The weight of a change in which a number was solved for.
    pub(crate) fn weight_of_solved(
        &self,
        own: &Evidence,
        before: &Values,
        after: &Values,
    ) -> Option<f64> {
        Some(self.balance(own, before, after)?.weight - FREE_VALUE)
    }

    /// The weight of the change that explains most, of changes in which a number was solved for; below all where none does.
    pub(crate) fn heaviest<'c>(
        &self,
        own: &Evidence,
        before: &Values,
        changes: impl Iterator<Item = &'c Changed>,
    ) -> f64 {
        let weights = changes.filter_map(|it| self.weight_of_solved(own, before, it.at_last()));
        weights.fold(f64::NEG_INFINITY, f64::max)
    }

    /// Those of some changes that explain what disagrees and do no harm; the best first, and only what is as good.
    pub(crate) fn explaining<C>(
        &self,
        own: &Evidence,
        before: &Values,
        all: Vec<Tried<C>>,
    ) -> Vec<Explaining<C>> {
        self.explaining_above(STRONG, own, before, all)
    }

    /// The same of changes that something else speaks for, too: their weight, after the correction, need only be above `least`.
    pub(crate) fn explaining_above<C>(
        &self,
        least: f64,
        own: &Evidence,
        before: &Values,
        all: Vec<Tried<C>>,
    ) -> Vec<Explaining<C>> {
        self.explaining_where(|_| true, least, (own, before), all)
    }

    /// The same among those changes alone whose values are wanted; what was tried besides counts as tried.
    pub(crate) fn explaining_where<C>(
        &self,
        is_wanted: impl Fn(&Values) -> bool,
        least: f64,
        (own, before): (&Evidence, &Values),
        all: Vec<Tried<C>>,
    ) -> Vec<Explaining<C>> {
        let is_moved = |after: &Values| {
            before.iter().any(|(subject, was)| {
                let is = value_of(after, subject);
                match (was, is) {
                    (Some(was), Some(is)) => (was - is).abs() > SAME_VALUE,
                    (was, is) => was.is_some() != is.is_some(),
                }
            })
        };
        let all: Vec<Tried<C>> = all.into_iter().filter(|it| is_moved(&it.values)).collect();
        let mut of_kind: BTreeMap<u8, usize> = BTreeMap::new();
        for it in &all {
            *of_kind.entry(it.kind).or_default() += 1;
        }
        let tried = all.len();
        let mut found: Vec<(f64, Explaining<C>)> = Vec::new();
        for it in all {
            let Some(balance) = self.balance(own, before, &it.values) else {
                continue;
            };
            let equals = of_kind.len() * of_kind.get(&it.kind).copied().unwrap_or(1);
            let weight = balance.weight - (equals as f64).log10();
            let trial = self.tried(&own.id, before, &it.values);
            let mut explained = balance.subjects.iter();
            let is_refuted = explained.any(|(_, subject)| {
                let value = value_of(&it.values, subject);
                value.is_some_and(|it| !self.gives_the_counts(own, (subject, it), REFUTED))
            });
            if weight <= least || is_refuted || trial.is_harmful() || !is_wanted(&it.values) {
                continue;
            }
            let distance = self.distance(own, &it.values);
            let explaining = Explaining {
                change: it.change,
                weight,
                tried,
                subjects: balance.subjects.into_iter().map(|(_, it)| it).collect(),
                values: it.values.clone(),
            };
            found.push((distance, explaining));
        }
        let best = found.iter().map(|(_, it)| it.weight);
        let best = best.fold(f64::NEG_INFINITY, f64::max);
        found.retain(|(_, it)| it.weight >= best - AS_GOOD);
        // In the order in which they were tried where they are as near, whatever the last digits of a solution.
        let nearness = |distance: f64| (distance / SAME_DISTANCE).round();
        found.sort_by(|a, b| nearness(a.0).total_cmp(&nearness(b.0)));
        found.into_iter().map(|(_, it)| it).collect()
    }

    /// Puts what explains what disagrees before the other changes of a model, each with those that it is not told apart from, where
    /// nothing weighs more.
    pub(crate) fn put_first<R: Rewriting>(
        &self,
        (model, own): (&Model<'_>, &Evidence),
        before: &Values,
        explaining: Vec<Explaining<(R, String)>>,
        found: &mut ModelOffers,
    ) {
        let best = explaining.iter().map(|it| it.weight);
        let Some(best) = best.max_by(f64::total_cmp) else {
            return;
        };
        let others = found.changes.iter().map(|it| &it.1);
        if self.heaviest(own, before, others) > best + AS_GOOD {
            return;
        }
        let made = self.written((model, own), explaining);
        found.changes.splice(0..0, made);
    }

    /// Puts what explains what disagrees behind the other changes of a model.
    pub(crate) fn put_last<R: Rewriting>(
        &self,
        of: (&Model<'_>, &Evidence),
        explaining: Vec<Explaining<(R, String)>>,
        found: &mut ModelOffers,
    ) {
        found.changes.extend(self.written(of, explaining));
    }

    /// The first of some rewritings as changes, each with those that it is not told apart from.
    fn written<R: Rewriting>(
        &self,
        (model, own): (&Model<'_>, &Evidence),
        explaining: Vec<Explaining<(R, String)>>,
    ) -> Vec<(ModelChange, Changed)> {
        let named = explaining.iter().map(|it| Alternative {
            name: it.change.0.in_words(model.text),
            line: it.change.0.line(model.text),
        });
        let named: Vec<Alternative> = named.collect();
        let made = explaining.into_iter().take(MOST_OFFERS).enumerate();
        let made = made.filter_map(|(number, it)| {
            let (change, text) = it.change;
            let subject: Subject = it.subjects.into_iter().next()?;
            let counts = anchors(self.evidence, own, &subject).into_iter().next()?;
            let others = named.iter().enumerate().filter(|(at, _)| *at != number);
            let changed = Changed {
                text,
                what: change.in_words(model.text),
                constant: None,
                values: it.values,
                notes: vec![change.note(it.tried.saturating_sub(1))],
                alternatives: others.map(|(_, it)| it.clone()).collect(),
                settled: None,
            };
            Some((change.offered(subject, counts, it.tried), changed))
        });
        made.collect()
    }
}
