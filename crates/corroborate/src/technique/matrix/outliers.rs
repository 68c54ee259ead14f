//! One person, session or day that differs from all others of a cohort.
//!
//! # Definition
//! For each table of trials by subject, and each of its columns by which a requirement is counted (where none is, a failure
//! mode), the subject that differs most from all others ([`stats::outlier()`]). Its e-value is divided by the number of
//! subjects, there, and by the number of such columns, here: any of them may be the one. The score is the decimal logarithm
//! of that.
//!
//! # Assumes
//! As [`stats::outlier()`]: subjects are independent, and alike are those whose rates are draws of one beta distribution.
//! Nothing of how columns depend on each other.
//!
//! # Guarantee
//! In a study whose subjects are all alike, somebody is named with a score of `s` or more in at most `10^-s` of all cases for
//! each table (Markov's inequality for e-values), on average over the clustering that [`stats::outlier()`] takes for
//! probable, not for each degree of it. Nobody is taken out: what follows with and without the subject is told, and who
//! kept the table decides.

use super::{Diagnosing, Gathered};
use crate::technique::experiment::{SubjectCount, Tables};
use diagnostic::Problem;
use evidence::{Clue, Figure, Inaccuracy, STRONG, Subject, SuspectAsset, SuspectKind, Symptom};
use stats::Sample;
use std::path::Path;
use study::Work;

/// A cohort with what is counted in it.
struct Counted<'a> {
    evidence: &'a str,
    file: &'a Path,
    subject: Subject,
    rows: Vec<SubjectCount>,
}

impl Diagnosing<'_> {
    /// Looks for subjects of cohorts who differ from all others, and for rows that contradict the cohort's attempts.
    pub(super) fn outliers(&self, gathered: &mut Gathered) -> Result<(), Problem> {
        for entry in self.entries(Work::is_read) {
            let Some(files) = entry.work.tables() else {
                continue;
            };
            let tables = Tables::read(self.study, files)?;
            self.excesses((&entry.id, files), &tables, gathered);
            let Some(file) = files.cohort else {
                continue;
            };
            let counted = self.counted(&tables, &entry.id, file)?;
            let mut named = 0;
            for it in &counted {
                if let Some(clue) = it.clue(counted.len())? {
                    named += 1;
                    gathered.clues.push(clue);
                }
            }
            if let (0, Some(first)) = (named, counted.first()) {
                gathered.in_order.push(format!(
                    "{}: none of {} rows of {} differs from all others beyond chance",
                    entry.id,
                    first.rows.len(),
                    file.display()
                ));
            }
        }
        Ok(())
    }

    /// What is counted by subject: requirements, and where there is none failure modes; each column once.
    fn counted<'a>(
        &self,
        tables: &Tables,
        evidence: &'a str,
        file: &'a Path,
    ) -> Result<Vec<Counted<'a>>, Problem> {
        let mut all: Vec<Counted<'_>> = Vec::new();
        let forms = self.study.forms.subjects.iter();
        for form in forms.filter(|form| self.is_own(&form.subject)) {
            let rows = tables.by_subject(self.study, form.subject.id())?;
            let Some(rows) = rows else {
                continue;
            };
            if all.iter().all(|known| known.rows != rows) {
                all.push(Counted {
                    evidence,
                    file,
                    subject: form.subject.clone(),
                    rows,
                });
            }
        }
        let is_requirement = |it: &Counted<'_>| matches!(it.subject, Subject::Requirement(_));
        if all.iter().any(is_requirement) {
            all.retain(is_requirement);
        }
        Ok(all)
    }
}

impl Counted<'_> {
    fn clue(&self, columns: usize) -> Result<Option<Clue>, Problem> {
        let samples = self.rows.iter().map(|row| Sample {
            successes: row.occurrences,
            trials: row.attempts,
        });
        let samples: Vec<Sample> = samples.collect();
        // What is no count of trials was refused when the table was read.
        let Ok(Some(found)) = stats::outlier(&samples) else {
            return Ok(None);
        };
        let e_value = found.e_value / columns.max(1) as f64;
        let score = e_value.log10();
        let row = &self.rows[found.place];
        Ok((score >= STRONG).then(|| self.named(row, found.place, (score, e_value))))
    }

    fn named(&self, row: &SubjectCount, place: usize, (score, e_value): (f64, f64)) -> Clue {
        let sum = |of: fn(&SubjectCount) -> u64| self.rows.iter().map(of).sum::<u64>();
        let all = [sum(|it| it.occurrences), sum(|it| it.attempts)];
        let without = [all[0] - row.occurrences, all[1] - row.attempts];
        let what = match self.subject {
            Subject::Requirement(_) => "violations of",
            Subject::FailureMode(_) => "occurrences of",
        };
        let shown = |[count, trials]: [u64; 2]| {
            let share = 100.0 * count as f64 / trials.max(1) as f64;
            format!("{count} of {trials} ({share:.1} %)")
        };
        let own = shown([row.occurrences, row.attempts]);
        let file = self.file.to_string_lossy().replace('\\', "/");
        Clue {
            inaccuracy: Inaccuracy::SystemModel,
            asset: SuspectAsset {
                kind: SuspectKind::Data,
                file: Some(file),
                part: Some(format!("row `{}`", row.subject)),
                evidence: vec![self.evidence.to_owned()],
                together: Vec::new(),
                line: u32::try_from(place + 2).ok(),
            },
            subject: self.subject.clone(),
            score,
            title: format!(
                "`{}` of {} differs from all others",
                row.subject, self.evidence
            ),
            explanation: format!(
                "`{}` has {own} {what} {}, all {} others together {}: e-value {e_value:.0} (at most 1 in {e_value:.0} by chance), \
                 allowing for clustering and for the choice among {} rows. With this row {}, without it {}. Look at the \
                 original of the row and at what was otherwise then; leaving it out is a decision, which the report has to say.",
                row.subject,
                self.subject.in_words(),
                self.rows.len() - 1,
                shown(without),
                self.rows.len(),
                shown(all),
                shown(without),
            ),
            symptom: Symptom::RowDiffers {
                subject: self.subject.clone(),
                evidence: self.evidence.to_owned(),
                row: row.subject.clone(),
                own: [row.occurrences, row.attempts],
                others: without,
            },
            figures: vec![Figure {
                name: "e-value".into(),
                value: e_value,
                interval: None,
            }],
            witnesses: Vec::new(),
            ruled_out: Vec::new(),
            resolved_by: None,
        }
    }
}
