//! What the runs of a simulator and recordings are read through: as suspect as what they show.
//!
//! # Definition
//! A simulator's episodes and recordings are judged by the words of vocabulary.toml on the signals of topics.toml, with the
//! limits of parameters.toml. Where such a piece is suspected because its rate differs from that of another, and no other
//! piece that is read so agrees with that other one, these files are named with the suspect: a wrong word would show the
//! same.
//!
//! # Guarantee
//! None: that a file is named says that what was shown does not tell it apart.

use super::Diagnosing;
use evidence::{Evidence, Rate, STRONG, Subject, Suspect, SuspectKind, Symptom, signed_strength};

impl Diagnosing<'_> {
    /// Names the words that a suspect is read through where nothing else confirms them.
    pub(super) fn words(&self, suspects: &mut [Suspect]) {
        for suspect in suspects {
            if !suspect.is_open()
                || !matches!(
                    suspect.asset.kind,
                    SuspectKind::Simulation | SuspectKind::Data
                )
            {
                continue;
            }
            let mut files: Vec<String> = Vec::new();
            for symptom in &suspect.symptoms {
                if let Symptom::RateDiffers {
                    subject,
                    evidence,
                    others,
                    ..
                } = symptom
                    && others
                        .iter()
                        .any(|(other, ..)| !self.is_confirmed(evidence, other, subject))
                {
                    files.extend(self.read_through(evidence, subject));
                }
            }
            for file in files {
                if !suspect.asset.together.contains(&file) {
                    suspect.asset.together.push(file);
                }
            }
        }
    }

    /// Whether another piece that is read as this one agrees with the one that this one differs from.
    fn is_confirmed(&self, evidence: &str, against: &str, subject: &Subject) -> bool {
        let piece = |id: &str| self.result.evidence.iter().find(|it| it.id == id);
        let Some(against) = piece(against) else {
            return true;
        };
        let agrees = |other: &Evidence| {
            let rates = (Rate::on(other, subject), Rate::on(against, subject));
            match rates {
                (Some(a), Some(b)) => signed_strength(a, b, self.margin(subject)) <= STRONG,
                _ => false,
            }
        };
        let mut others = self.result.evidence.iter();
        // The other piece itself may be read so, too.
        others.any(|other| other.id != evidence && self.is_read(&other.id) && agrees(other))
    }

    /// Whether the runs of a piece are judged by the vocabulary's predicates on traces.
    fn is_read(&self, evidence: &str) -> bool {
        let entry = self.study.entry(evidence);
        entry.is_ok_and(|it| it.work.simulated().is_some() || it.work.recordings().is_some())
    }

    /// The files of words that a piece is read through.
    fn read_through(&self, evidence: &str, subject: &Subject) -> Vec<String> {
        let Ok(entry) = self.study.entry(evidence) else {
            return Vec::new();
        };
        if !self.is_read(evidence) {
            return Vec::new();
        }
        let has_topics =
            entry.work.parts().uses_topics && self.study.folder.join("topics.toml").exists();
        let form = self.study.forms.of(subject);
        let has_limits =
            form.is_some_and(|form| super::candidates::reads_parameters(self.study, form));
        let files = [
            Some("vocabulary.toml"),
            has_topics.then_some("topics.toml"),
            has_limits.then_some("parameters.toml"),
        ];
        files.into_iter().flatten().map(str::to_owned).collect()
    }
}
