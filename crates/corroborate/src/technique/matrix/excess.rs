//! Tables that count more trials than there were attempts.
//!
//! # Definition
//! A property of a model asks in how many runs something comes, and an attempt is a run. A row that counts more trials of it than there
//! were attempts contradicts the table of attempts, so one of the two is wrong, or the property asks something else. Where such a row's
//! rate conflicts with others, it explains the conflict: it is as strong as the strongest of them.
//!
//! # Assumes
//! The model and the table count the same runs. A failure that may come several times a run is asked otherwise than by a property.
//!
//! # Guarantee
//! None is accused of whose subject nothing conflicts.

use super::{Diagnosing, Gathered};
use crate::technique::experiment::{Excess, Tables};
use evidence::{
    Clue, Inaccuracy, Outcome, Rate, Subject, SuspectAsset, SuspectKind, Symptom, strength,
};
use study::TableFiles;

impl Diagnosing<'_> {
    /// Looks for rows of an entry's tables with more trials than attempts of what is in conflict.
    pub(super) fn excesses(
        &self,
        (evidence, files): (&str, TableFiles<'_>),
        tables: &Tables,
        gathered: &mut Gathered,
    ) {
        for row in tables.more_than_attempts(self.study) {
            let file = match row.subject {
                Subject::Requirement(_) => files.requirements,
                Subject::FailureMode(_) => files.failure_modes,
            };
            let score = self.strongest_conflict(evidence, &row.subject);
            if let (Some(file), Some(score)) = (file, score) {
                let file = file.to_string_lossy().replace('\\', "/");
                gathered.clues.push(clue(evidence, file, row, score));
            }
        }
    }

    /// How strongly the strongest conflict of a piece on a subject contradicts it; `None` where it has none.
    fn strongest_conflict(&self, evidence: &str, subject: &Subject) -> Option<f64> {
        let known = |id: &str| self.result.evidence.iter().find(|it| it.id == id);
        let rate = |id: &str| Rate::on(known(id)?, subject);
        let own = rate(evidence)?;
        let pairs = self.result.comparisons.iter();
        let pairs = pairs.filter(|it| it.outcome == Outcome::Conflicts && &it.subject == subject);
        let strengths = pairs.filter_map(|it| {
            let other = match [it.left.as_str(), it.right.as_str()] {
                [one, other] | [other, one] if one == evidence => other,
                _ => return None,
            };
            Some(strength(own, rate(other)?, self.margin(subject)))
        });
        strengths.max_by(f64::total_cmp)
    }
}

fn clue(evidence: &str, file: String, row: Excess, score: f64) -> Clue {
    Clue {
        inaccuracy: Inaccuracy::SystemModel,
        asset: SuspectAsset {
            kind: SuspectKind::Data,
            file: Some(file),
            part: None,
            evidence: vec![evidence.to_owned()],
            together: Vec::new(),
            line: row.place.line().and_then(|line| u32::try_from(line).ok()),
        },
        score,
        title: format!(
            "{evidence} counts {} trials of {} in {} attempts",
            row.trials,
            row.subject.in_words(),
            row.attempts
        ),
        explanation: format!(
            "{}. What conflicts with it has another rate of the same runs: look at the original of the row, and at the attempts.",
            row.in_words()
        ),
        symptom: Symptom::MoreThanAttempts {
            subject: row.subject.clone(),
            evidence: evidence.to_owned(),
            trials: row.trials,
            attempts: row.attempts,
        },
        subject: row.subject,
        figures: Vec::new(),
        witnesses: Vec::new(),
        ruled_out: Vec::new(),
        resolved_by: None,
    }
}
