//! What a change of a model repairs and what it breaks, tried on all evidence before it is offered.
//!
//! # Definition
//! The changed model is solved. On each subject whose value moved it is held against every other piece of evidence under
//! the same conditions that speaks for itself, before and after, by the strength of disagreement
//! ([`evidence::strength`]). The change *repairs* a pair whose disagreement was strong (more than [`evidence::STRONG`], which a
//! difference within the margin never is) and is not any more, and *breaks* one that was not and is. Of simulations that share an assumption only the latest speaks: those
//! before it were replaced.
//!
//! Where evidence of the real system contradicts a simulation already, no model agrees with both: a change that does not
//! move away from the former is not held to break the latter. It takes a side, which is said.
//!
//! Independent voices ([`evidence::voices`]) vote on each subject that moved by the strongest disagreement within the voice:
//! those with whom it shrinks by at least [`MOVED`] against those with whom it grows. Where all that a change repairs on a subject
//! is with simulations, evidence of the real system that agrees as it is has the last word: the change moves away from the majority
//! if that agrees less afterwards by at least [`LESS`], since the simulation may be what is wrong. A change is *harmful* if it breaks a
//! pair, or if on some subject more voices are moved away from than towards.
//!
//! # Assumes
//! Pieces with voices of their own are independent of each other. The strengths take trials as independent, or at their
//! effective size. From where on a vote counts is chosen, not derived.
//!
//! # Source and guarantee
//! What is predicted is the figures that the next run computes, as far as the evidence that is there allows: nothing is
//! sampled. The votes are those of independent pieces (as in a sign test), so that a number that was copied does not
//! count twice.

use crate::model_change::Values;
use crate::model_offers::Ground;
use evidence::{
    Evidence, Measure, Rate, STRONG, Subject, share_assumption, signed_strength, strength, voices,
};
use schemars::JsonSchema;
use serde::Serialize;

/// Decades by which a disagreement has to change to count as a vote.
const MOVED: f64 = 0.1;

/// Decades of agreement that evidence of the real system has to lose to be moved away from.
const LESS: f64 = 0.3;

/// Values that differ by less are the same.
pub(crate) const SAME_VALUE: f64 = 1e-9;

/// A pair of the changed model and another piece.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Touch {
    /// The other evidence.
    pub evidence: String,
    /// On what.
    pub subject: Subject,
    /// How strongly they disagree now, in decades.
    pub before: f64,
    /// How strongly after the change.
    pub after: f64,
}

/// What a change does to the agreement with all other evidence.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct Trial {
    /// Pairs that disagree strongly now and do not after it.
    pub repairs: Vec<Touch>,
    /// Pairs that do not disagree strongly now and do after it.
    pub breaks: Vec<Touch>,
    /// The same with simulations that evidence of the real system contradicts already, and to which the model does not
    /// come nearer than to that: it takes the side of the real system.
    pub sides: Vec<Touch>,
    /// Subjects on which it moves away from the majority of independent evidence.
    pub against_majority: Vec<Subject>,
}

impl Trial {
    /// Whether it makes other evidence conflict, or moves away from the majority of it.
    #[must_use]
    pub fn is_harmful(&self) -> bool {
        !(self.breaks.is_empty() && self.against_majority.is_empty())
    }

    /// Takes a pair as repaired or broken, if it is.
    pub fn weigh(&mut self, touch: Touch) {
        match (touch.before > STRONG, touch.after > STRONG) {
            (true, false) => self.repairs.push(touch),
            (false, true) => self.breaks.push(touch),
            _ => {}
        }
    }
}

impl Ground<'_> {
    /// What a change of the model that gives `target` does, from its values before and after.
    #[must_use]
    pub fn tried(&self, target: &str, before: &Values, after: &Values) -> Trial {
        let mut trial = Trial::default();
        let Some(own) = self.evidence.iter().find(|piece| piece.id == target) else {
            return trial;
        };
        for (subject, value) in before {
            let new = after.get(subject).copied().flatten();
            let is_moved = match (value, new) {
                (Some(old), Some(new)) => (old - new).abs() > SAME_VALUE,
                (old, new) => old.is_some() != new.is_some(),
            };
            if is_moved && self.is_own(subject) {
                self.on_subject(own, subject, [*value, new], &mut trial);
            }
        }
        trial
    }

    /// How strongly a model with these values disagrees with all other evidence: the sum over subjects of the strongest.
    #[must_use]
    pub fn disagreement(&self, target: &str, values: &Values) -> f64 {
        let Some(own) = self.evidence.iter().find(|piece| piece.id == target) else {
            return 0.0;
        };
        let of_subject =
            |(subject, value): (&Subject, &Option<f64>)| self.strongest(own, subject, *value);
        let own = values.iter().filter(|(subject, _)| self.is_own(subject));
        own.map(of_subject).sum()
    }

    /// The subject on which a model with these values disagrees most with other evidence, and how strongly.
    #[must_use]
    pub fn most_disagreement<'v>(
        &self,
        target: &str,
        values: &'v Values,
    ) -> Option<(&'v Subject, f64)> {
        let own = self.evidence.iter().find(|piece| piece.id == target)?;
        let subjects = values.iter().filter(|(subject, _)| self.is_own(subject));
        let apart = subjects.map(|(subject, value)| {
            let apart = self.strongest(own, subject, *value);
            (subject, apart)
        });
        apart.max_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// Requirements that differ only in a threshold count once.
    pub(crate) fn is_own(&self, subject: &Subject) -> bool {
        let mut all = self.requirements.iter();
        !all.any(|r| {
            matches!(subject, Subject::Requirement(id) if id == &r.id)
                && r.same_quantity_as.is_some()
        })
    }

    fn on_subject(
        &self,
        own: &Evidence,
        subject: &Subject,
        values: [Option<f64>; 2],
        trial: &mut Trial,
    ) {
        let pieces = self.speaking(own, subject);
        let known = trial.repairs.len();
        let [mut toward, mut away] = [0, 0];
        for voice in voices(&pieces, subject) {
            let mut most = [0.0_f64; 2];
            let contradicted = voice
                .iter()
                .all(|piece| self.is_contradicted(own, piece, &pieces, (subject, values)));
            for piece in voice {
                let Some([was, is]) = self.apart(own, piece, subject, values) else {
                    continue;
                };
                most = [most[0].max(was), most[1].max(is)];
                let touch = || Touch {
                    evidence: piece.id.clone(),
                    subject: subject.clone(),
                    before: was,
                    after: is,
                };
                match (was > STRONG, is > STRONG) {
                    (true, false) => trial.repairs.push(touch()),
                    (false, true) if contradicted => trial.sides.push(touch()),
                    (false, true) => trial.breaks.push(touch()),
                    _ => {}
                }
            }
            let [was, is] = most;
            toward += usize::from(was - is >= MOVED);
            away += usize::from(is - was >= MOVED && !contradicted);
        }
        let is_made = |touch: &Touch| {
            let mut all = pieces.iter();
            all.any(|it| it.id == touch.evidence && it.technique.is_of_simulator())
        };
        let repaired = &trial.repairs[known..];
        let is_for_simulations = !repaired.is_empty() && repaired.iter().all(is_made);
        let leaves_system = is_for_simulations && self.leaves_system(&pieces, subject, values);
        if away > toward || leaves_system {
            trial.against_majority.push(subject.clone());
        }
    }

    /// Whether evidence of the real system agrees with the first value, and less with the second.
    fn leaves_system(
        &self,
        pieces: &[&Evidence],
        subject: &Subject,
        values: [Option<f64>; 2],
    ) -> bool {
        let real = pieces.iter().filter(|it| it.technique.is_of_system());
        let agreement = real.filter_map(|piece| {
            let theirs = Rate::on(piece, subject)?;
            let [was, is] = values.map(|value| {
                let claimed = Rate::claimed(value?, subject);
                Some(signed_strength(claimed, theirs, self.margin(subject)))
            });
            Some([was?, is?])
        });
        let all: Vec<[f64; 2]> = agreement.collect();
        !all.is_empty() && all.iter().all(|[was, is]| *was < 0.0 && is - was >= LESS)
    }

    /// Whether a simulation disagrees strongly with evidence of the real system from which the change does not move away.
    fn is_contradicted(
        &self,
        own: &Evidence,
        piece: &Evidence,
        pieces: &[&Evidence],
        (subject, values): (&Subject, [Option<f64>; 2]),
    ) -> bool {
        let rate = |piece: &Evidence| Rate::on(piece, subject);
        let is_real = |it: &&&Evidence| it.technique.is_of_system();
        piece.technique.is_of_simulator()
            && pieces.iter().filter(is_real).any(|real| {
                let apart = rate(piece)
                    .zip(rate(real))
                    .map_or(0.0, |(a, b)| strength(a, b, self.margin(subject)));
                let toward = self.apart(own, real, subject, values);
                apart > STRONG && toward.is_some_and(|[was, is]| is <= was)
            })
    }

    /// How strongly a model with this value disagrees with the piece that it disagrees most with.
    pub(crate) fn strongest(&self, own: &Evidence, subject: &Subject, value: Option<f64>) -> f64 {
        let pieces = self.speaking(own, subject).into_iter();
        let apart = pieces.filter_map(|piece| self.apart(own, piece, subject, [value, value]));
        apart.map(|[apart, _]| apart).fold(0.0, f64::max)
    }

    /// How strongly a piece disagrees with two values; a failure mode that a model cannot express never occurs there, unless the model
    /// is one of another part. Where it never triggers the subject, no value is what was refuted.
    fn apart(
        &self,
        own: &Evidence,
        piece: &Evidence,
        subject: &Subject,
        values: [Option<f64>; 2],
    ) -> Option<[f64; 2]> {
        let theirs = Rate::on(piece, subject)?;
        let margin = self.margin(subject);
        let is_mode = matches!(subject, Subject::FailureMode(_))
            && !evidence::is_of_another_part(self.evidence, own, subject);
        let never = against_never_triggering(own, piece, subject, margin);
        Some(values.map(|value| match (value, never) {
            (None, Some(apart)) => apart,
            (value, _) => match value.or(is_mode.then_some(0.0)) {
                Some(value) => strength(Rate::claimed(value, subject), theirs, margin),
                None => 0.0,
            },
        }))
    }

    /// The other pieces that speak for themselves on a subject.
    pub(crate) fn speaking(&self, own: &Evidence, subject: &Subject) -> Vec<&Evidence> {
        let counts = |piece: &&Evidence| {
            piece.id != own.id
                && piece.conditions == own.conditions
                && !piece.intermediate
                && !(piece.published && piece.reproduced_by.is_some())
                && matches!(
                    piece.finding(subject).map(|f| &f.measure),
                    Some(Measure::Counts { trials, .. }) if *trials > 0
                )
        };
        let all: Vec<&Evidence> = self.evidence.iter().filter(counts).collect();
        let is_replaced = |(place, piece): (usize, &&Evidence)| {
            piece.technique.is_of_simulator()
                && all[place + 1..].iter().any(|later| {
                    later.technique == piece.technique && share_assumption(piece, later, subject)
                })
        };
        let kept = all
            .iter()
            .enumerate()
            .filter(|(place, piece)| !is_replaced((*place, piece)));
        kept.map(|(_, piece)| *piece).collect()
    }
}

/// How strongly it speaks against a model that never triggers a subject that another piece has triggered: that something cannot come is
/// refuted by its coming. None if the model may trigger it, or the piece has no run that does.
pub(crate) fn against_never_triggering(
    own: &Evidence,
    piece: &Evidence,
    subject: &Subject,
    margin: f64,
) -> Option<f64> {
    if !never_triggers(own, subject) {
        return None;
    }
    let finding = piece.finding(subject)?;
    let rate = match (finding.trigger.as_deref(), &finding.measure) {
        (Some(Measure::Counts { count, trials, .. }), _) if *count > 0 => {
            Rate::counted(*count, *trials)
        }
        // How many runs there were is not known, and that there was one is enough.
        (None, Measure::Counts { trials, .. }) if *trials > 0 => Rate::counted(*trials, *trials),
        _ => return None,
    };
    Some(strength(Rate::Never, rate, margin))
}

/// Whether a model triggers a subject in no run, for certain.
pub(crate) fn never_triggers(own: &Evidence, subject: &Subject) -> bool {
    let trigger = own
        .finding(subject)
        .and_then(|finding| finding.trigger.as_deref());
    matches!(trigger, Some(Measure::Probability { answer, .. })
        if answer.value == 0.0 && answer.guarantee.is_certain())
}
