//! Counts of a cohort, subject by subject.

use super::Tables;
use diagnostic::Problem;
use evidence::Subject;
use study::Study;

/// What one subject (person, session) did.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SubjectCount {
    /// As the cohort's first column names it.
    pub subject: String,
    /// Violations of the requirement, or occurrences of the way to fail.
    pub occurrences: u64,
    /// Trials, whether or not each was an opportunity.
    pub attempts: u64,
}

impl Tables {
    /// Counts of a requirement (as violations) or failure mode by subject; `None` if the tables
    /// have no cohort that counts it.
    pub fn by_subject(
        &self,
        study: &Study,
        id: &str,
    ) -> Result<Option<Vec<SubjectCount>>, Problem> {
        let mut forms = study.forms.subjects.iter();
        let (Some(cohort), Some(form)) = (&self.cohort, forms.find(|f| f.subject.id() == id))
        else {
            return Ok(None);
        };
        let Some(samples) = self.cohort_counts(study, form)? else {
            return Ok(None);
        };
        let names = cohort.table.columns().next();
        let names = names.map(|column| column.as_texts()).unwrap_or_default();
        let counts = names
            .iter()
            .zip(samples)
            .map(|(name, sample)| SubjectCount {
                subject: (*name).to_owned(),
                occurrences: match form.subject {
                    Subject::Requirement(_) => sample.trials - sample.successes,
                    Subject::FailureMode(_) => sample.successes,
                },
                attempts: sample.trials,
            });
        Ok(Some(counts.collect()))
    }
}
