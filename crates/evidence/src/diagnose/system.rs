//! System models to blame: failure modes whose rates conflict, or that an asset cannot express
//! although others show them; and conflicts on requirements, which are the sum of what the modes do.

use super::{Ledger, OddOneOut, name_of, pieces, reasons};
use crate::{Discrepancy, Evidence, Inaccuracy, Measure, Subject};

impl Ledger<'_> {
    pub(super) fn differing_rates(&self) -> Vec<Discrepancy> {
        self.odd_ones_out(|c| matches!(c.subject, Subject::FailureMode(_)))
            .iter()
            .map(|odd| Discrepancy {
                inaccuracy: Inaccuracy::SystemModel,
                title: format!("{} differs in {}", odd.id, name_of(odd.subject)),
                explanation: format!("{} {}", self.rates(odd), reasons(odd)),
                subjects: vec![odd.subject.clone()],
                evidence: pieces(odd),
                witnesses: self.witnesses(odd),
                resolved_by: self.mended_by(odd),
                proposal: Some(format!(
                    "Look at what decides {} in the system model of {}.",
                    name_of(odd.subject),
                    odd.id
                )),
            })
            .collect()
    }

    /// Failure modes that occur in some evidence and that a model of the
    /// ledger cannot express.
    pub(super) fn missing_behaviour(&self) -> Vec<Discrepancy> {
        let mut found = Vec::new();
        for piece in self.evidence.iter().filter(|e| !e.intermediate) {
            for finding in &piece.findings {
                let (Subject::FailureMode(_), Measure::NotExpressible { reason }) =
                    (&finding.subject, &finding.measure)
                else {
                    continue;
                };
                let shown = self.shown_by(&finding.subject);
                if !shown.is_empty() {
                    found.push(self.missing(piece, &finding.subject, &shown, reason));
                }
            }
        }
        found
    }

    fn missing(
        &self,
        piece: &Evidence,
        subject: &Subject,
        shown: &[String],
        reason: &str,
    ) -> Discrepancy {
        let resolved = self
            .evidence
            .iter()
            .skip(self.place(&piece.id) + 1)
            .filter(|e| e.technique == piece.technique && !e.intermediate)
            .find(|e| {
                e.finding(subject)
                    .is_some_and(|f| f.measure.estimate().is_some())
            });
        Discrepancy {
            inaccuracy: Inaccuracy::SystemModel,
            title: format!("{} does not know {}", piece.id, name_of(subject)),
            explanation: format!("It occurs: {}. {reason}", shown.join(", ")),
            subjects: vec![subject.clone()],
            evidence: vec![piece.id.clone()],
            witnesses: Vec::new(),
            resolved_by: resolved.map(|e| e.id.clone()),
            proposal: Some(format!("Add {} to the system model.", name_of(subject))),
        }
    }

    fn shown_by(&self, subject: &Subject) -> Vec<String> {
        self.evidence
            .iter()
            .filter_map(|e| match e.finding(subject)?.measure {
                Measure::Counts { count, trials, .. } if count > 0 => {
                    Some(format!("{count} of {trials} in {}", e.id))
                }
                _ => None,
            })
            .collect()
    }

    /// Conflicts on requirements, but for those that a reading explains.
    pub(super) fn conflicting_requirements(&self, found: &[Discrepancy]) -> Vec<Discrepancy> {
        self.odd_ones_out(|c| {
            matches!(c.subject, Subject::Requirement(_)) && !self.is_explained_by_reading(c)
        })
        .iter()
        .map(|odd| self.conflicting_requirement(odd, found))
        .collect()
    }

    fn conflicting_requirement(&self, odd: &OddOneOut, found: &[Discrepancy]) -> Discrepancy {
        // A conflict on a rate of success is the sum of what the failure modes do.
        let causes: Vec<&str> = found
            .iter()
            .filter(|d| d.inaccuracy == Inaccuracy::SystemModel)
            .filter(|d| d.evidence.first().is_some_and(|id| id == odd.id))
            .map(|d| d.title.as_str())
            .collect();
        let (inaccuracy, cause) = if causes.is_empty() {
            let unknown = "No other method, reading or failure mode at hand separates the cause.";
            (Inaccuracy::Undetermined, unknown.to_owned())
        } else {
            (
                Inaccuracy::SystemModel,
                format!("One level down: {}.", causes.join("; ")),
            )
        };
        Discrepancy {
            inaccuracy,
            title: format!(
                "{} conflicts with {} on {}",
                odd.id,
                odd.others.join(", "),
                name_of(odd.subject)
            ),
            explanation: format!("{} {} {cause}", self.rates(odd), reasons(odd)),
            subjects: vec![odd.subject.clone()],
            evidence: pieces(odd),
            witnesses: self.witnesses(odd),
            resolved_by: self.mended_by(odd),
            proposal: None,
        }
    }
}
