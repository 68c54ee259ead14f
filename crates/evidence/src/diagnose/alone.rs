//! Clues that follow from one piece of evidence: failure modes that its model excludes although others show them; and
//! methods that stopped outside bounds that hold.
//!
//! A model *excludes* a failure mode that it has nothing for, or of which it computes exactly 0 ([`Rate::Never`]). Where one
//! voice alone shows it ([`mod@super::voices`]), that may be what is wrong: the disagreement of strength `T` with "never"
//! speaks against the model with `q T` and, if it is one piece, against that piece with `(1 - q) T`, `q` the probability
//! that the model is the odd one out ([`super::blame`]). Where several show it, they are not all wrong; `T` is then of the counts of
//! all of them that do not differ from the strongest.
//!
//! # Assumes
//! As [`super::blame`] and [`mod@super::strength`]: trials are independent, and pieces that share no assumption are wrong
//! independently of each other.

use super::matter::{Clue, Matter, name_of, rate_in_words};
use super::rates::{NAMED, counts_of, figure, rate_or_never, solver};
use super::strength::{Rate, STRONG, strength};
use super::suspect::Symptom;
use crate::{Evidence, Inaccuracy, Measure, MethodAnswer, Subject, is_of_another_part};

impl Matter<'_> {
    /// Clues against models that exclude a failure mode that others show.
    pub(super) fn of_missing_modes(&self) -> Vec<Clue> {
        let mut clues = Vec::new();
        let models = self
            .speaking()
            .filter(|piece| piece.technique.is_of_model());
        for piece in models {
            for finding in &piece.findings {
                let subject = &finding.subject;
                let excludes = rate_or_never(piece, subject) == Some(Rate::Never)
                    && !is_of_another_part(self.evidence, piece, subject);
                if let (Subject::FailureMode(mode), true) = (subject, excludes) {
                    let reason = match &finding.measure {
                        Measure::NotExpressible { reason } => reason,
                        _ => "None of its paths fails so.",
                    };
                    clues.extend(self.missing_mode(piece, mode, subject, reason));
                    clues.extend(self.shown_alone(piece, subject));
                }
            }
        }
        clues
    }

    /// What shows a failure mode that a model excludes: how strongly against never, the strongest first.
    fn shown(&self, piece: &Evidence, subject: &Subject) -> Vec<(f64, &Evidence)> {
        let margin = self.margin(subject);
        let others = self.speaking().filter(|e| e.conditions == piece.conditions);
        let mut shown: Vec<(f64, &Evidence)> = others
            .filter_map(|e| {
                let finding = e.finding(subject)?;
                let shows = matches!(finding.measure, Measure::Counts { count, .. } if count > 0);
                let apart = strength(Rate::Never, Rate::of(finding)?, margin);
                shows.then_some((apart, e))
            })
            .collect();
        shown.sort_by(|a, b| b.0.total_cmp(&a.0));
        shown
    }

    /// How strongly all that show a failure mode, and do not differ from the strongest of them, speak against never.
    fn against_never(&self, shown: &[(f64, &Evidence)], subject: &Subject) -> f64 {
        let margin = self.margin(subject);
        let Some((most, first)) = shown.first() else {
            return 0.0;
        };
        let strongest = Rate::on(first, subject);
        let mut alike = Vec::new();
        for (_, piece) in shown {
            let (Some(first), Some(rate)) = (strongest, Rate::on(piece, subject)) else {
                continue;
            };
            if strength(first, rate, margin) < STRONG {
                alike.push(rate);
            }
        }
        most.max(strength(Rate::Never, Rate::pooled(&alike), margin))
    }

    /// The probability that a model is the odd one out, and not what alone shows a failure mode that it excludes.
    fn is_odd(&self, model: &Evidence, shows: &[&Evidence], subject: &Subject) -> f64 {
        match shows.first() {
            Some(shows) => self.blame([model, shows], subject, None).pieces[0],
            None => 1.0,
        }
    }

    /// The clue against the only piece that shows a failure mode.
    fn shown_alone(&self, model: &Evidence, subject: &Subject) -> Option<Clue> {
        let shown = self.shown(model, subject);
        let [(whole, shows)] = shown[..] else {
            return None;
        };
        let share = 1.0 - self.is_odd(model, &[shows], subject);
        let mut clue =
            (share >= NAMED).then(|| self.of_system(shows, model, subject, (whole, share)))?;
        clue.title = format!("{} alone shows {}", shows.id, name_of(subject));
        clue.explanation = format!(
            "{}, and {} has no such failure: a disagreement on {} with a Bayes factor of 10^{whole:.1}, with probability {share:.2} \
             the odd one out.",
            rate_in_words(shows, subject),
            model.id,
            name_of(subject)
        );
        Some(clue)
    }

    fn missing_mode(
        &self,
        piece: &Evidence,
        mode: &str,
        subject: &Subject,
        reason: &str,
    ) -> Option<Clue> {
        let shown = self.shown(piece, subject);
        let (_, most) = *shown.first()?;
        let whole = self.against_never(&shown, subject);
        let show: Vec<&Evidence> = shown.iter().map(|(_, piece)| *piece).collect();
        // Pieces that share an assumption may be wrong together.
        let score = match super::voices::voices(&show, subject).len() {
            1 => whole * self.is_odd(piece, &show, subject),
            _ => whole,
        };
        let words: Vec<String> = shown
            .iter()
            .map(|(_, e)| rate_in_words(e, subject))
            .collect();
        let runs = most
            .finding(subject)
            .map_or_else(Vec::new, |f| f.witnesses.clone());
        let place = self.evidence.iter().position(|e| e.id == piece.id)?;
        let mut later = self
            .evidence
            .iter()
            .skip(place + 1)
            .filter(|e| e.technique == piece.technique && !e.intermediate);
        let mended =
            later.find(|e| rate_or_never(e, subject).is_some_and(|rate| rate != Rate::Never));
        Some(Clue {
            inaccuracy: Inaccuracy::SystemModel,
            asset: self.asset_of(piece, subject),
            subject: subject.clone(),
            score,
            title: format!("{} excludes {}", piece.id, name_of(subject)),
            explanation: format!(
                "Occurrences of {}: {}. {reason}",
                name_of(subject),
                words.join(", ")
            ),
            symptom: Symptom::MissingMode {
                mode: mode.to_owned(),
                shown: shown.iter().map(|(_, e)| counts_of(e, subject)).collect(),
            },
            figures: vec![figure("against never occurring, log10 Bayes factor", score)],
            witnesses: self.witnesses(most, &runs, &format!("{} occurs", name_of(subject))),
            ruled_out: Vec::new(),
            resolved_by: mended.map(|e| e.id.clone()),
        })
    }

    /// Clues against methods whose answer lies outside bounds that hold, although the evidence does not
    /// rest on it.
    pub(super) fn of_other_methods(&self) -> Vec<Clue> {
        let mut clues = Vec::new();
        for piece in self.speaking() {
            for finding in &piece.findings {
                let Measure::Probability { answer, others, .. } = &finding.measure else {
                    continue;
                };
                // Of two answers, the one with bounds judges the other, whichever of them counts.
                let holds = |a: &MethodAnswer| a.guarantee.is_certain();
                let is_sound = holds(answer);
                for other in others {
                    let (answer, other) = match (holds(answer), holds(other)) {
                        (false, true) => (other, answer),
                        _ => (answer, other),
                    };
                    if let Some(distance) = super::tool::distance_from_bounds(answer, other) {
                        let margin = self.margin(&finding.subject);
                        let values = [answer.value, other.value].map(Rate::Computed);
                        clues.push(Clue {
                            inaccuracy: Inaccuracy::Tool,
                            asset: solver(piece, &other.method),
                            subject: finding.subject.clone(),
                            score: strength(values[0], values[1], margin),
                            title: format!(
                                "{}'s {} is where `{}` stopped, not a probability",
                                piece.id, other.value, other.method
                            ),
                            explanation: format!(
                                "For {}, `{}` is at least {distance:.2e} from the bounds of `{}`.",
                                name_of(&finding.subject),
                                other.method,
                                answer.method
                            ),
                            symptom: Symptom::SolverStopped {
                                subject: finding.subject.clone(),
                                method: other.method.clone(),
                                value: other.value,
                                sound: answer.method.clone(),
                                sound_value: answer.value,
                            },
                            figures: vec![figure("distance from the bounds", distance)],
                            witnesses: Vec::new(),
                            ruled_out: Vec::new(),
                            resolved_by: is_sound.then(|| piece.id.clone()),
                        });
                    }
                }
            }
        }
        clues
    }
}
