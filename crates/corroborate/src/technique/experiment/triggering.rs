//! In which trials of a cohort a subject is triggered, where its tables tell it without a row of the subject's own.
//!
//! # Definition
//! A requirement that is triggered when a proposition comes to hold, or a failure mode whose opportunity that is, is covered in the
//! attempts in which it did:
//!
//! * by subject, where the proposition has a column of the cohort and no subject has more successes (or failures) than that:
//!   then the one was counted among the other. A row of the failure mode's own with the same opportunities in all says nothing else;
//! * in all, where a failure mode of the same opportunity has a row with its opportunities, and no more successes are counted.
//!
//! Where more are counted than triggered it, they were not counted among these, or a row is wrong: how many of those that triggered it
//! succeeded is not known, and the counts are over all attempts.
//!
//! A row of the subject's own says in how many it was. Where the cohort has a column of the proposition, too, both must fit: a
//! requirement is covered, with or without a verdict, in just the attempts in which the proposition came to hold, and a failure mode has an
//! opportunity or more in each of them. A row that says otherwise counts something else than what the study asks of its models, and is
//! refused.
//!
//! # Why
//! Attempts count as trials of a requirement, as people arrange them to trigger it. Where the tables say in how many of them it
//! was, that is not so: of 600 attempts 88 stumble, and 86 that are caught are 86 of 88, not a rate of 14 %.
//!
//! # Assumes
//! An attempt triggers it at most once.
//!
//! # Guarantee
//! Counts are those of the tables. A success column that counts more attempts than the trigger's in any row is not taken for one among the
//! trigger's, and then decides nothing ([`Triggering::Unknown`]).

use super::Tables;
use super::placed::RowPlace;
use diagnostic::Problem;
use evidence::Subject;
use stats::Sample;
use study::{FormText, Study, SubjectForm, TriggerForm, quoted_names};

/// The trials in which a subject was triggered.
pub(super) enum Triggering {
    /// What was counted of each subject among its trials.
    BySubject(Vec<Sample>),
    /// Trials in all.
    Total(u64),
    /// Which of the attempts did is not known, though so many came: why.
    Unknown { came: u64, reason: String },
}

impl Triggering {
    /// How many trials there are.
    pub fn trials(&self) -> u64 {
        match self {
            Self::BySubject(found) => found.iter().map(|it| it.trials).sum(),
            Self::Total(trials) => *trials,
            Self::Unknown { came, .. } => *came,
        }
    }
}

/// A row of a subject's own.
struct OwnRow<'t> {
    /// Covered trials, with or without a verdict, or opportunities.
    trials: u64,
    /// Whether an attempt may have several.
    several: bool,
    place: &'t RowPlace,
}

impl Tables {
    /// That rows of subjects and the columns of what triggers them fit each other.
    ///
    /// # Errors
    /// `tables-disagree` at a row which says of more or fewer trials that they were covered.
    pub(super) fn check_triggers(&self, study: &Study) -> Result<(), Problem> {
        for form in &study.forms.subjects {
            let (Some(row), Some((word, exact))) =
                (self.own_row(&form.subject), known_word(study, form))
            else {
                continue;
            };
            let Some(triggers) = self.came(study, &word)? else {
                continue;
            };
            let counted = self.cohort_counts(study, form)?.unwrap_or_default();
            let more = counted.iter().zip(&triggers);
            let more = more.filter(|(one, trigger)| one.successes > trigger.successes);
            // A column that counts other attempts, too, is none of the trigger's.
            if 2 * more.count() >= counted.len().max(1) {
                continue;
            }
            let came: u64 = triggers.iter().map(|it| it.successes).sum();
            let fits = match (row.several, exact) {
                (true, true) => row.trials >= came,
                (false, true) => row.trials == came,
                // Of the attempts in which it came only those in time count; of opportunities each may have several.
                (true, false) => true,
                (false, false) => row.trials <= came,
            };
            if !fits {
                return Err(row.misfit(form, &word, (came, exact)));
            }
        }
        Ok(())
    }

    /// The row of a subject's own in a table.
    fn own_row(&self, subject: &Subject) -> Option<OwnRow<'_>> {
        match subject {
            Subject::Requirement(_) => {
                let row = self.row(subject)?;
                Some(OwnRow {
                    trials: row.covered.saturating_add(row.undecided),
                    several: false,
                    place: row.place.as_ref()?,
                })
            }
            Subject::FailureMode(id) => {
                let row = self.failure_modes.iter().find(|row| &row.mode == id)?;
                Some(OwnRow {
                    trials: row.opportunities,
                    several: true,
                    place: &row.place,
                })
            }
        }
    }

    /// In how many attempts of each subject a proposition came to hold, where the cohort counts it.
    fn came(&self, study: &Study, word: &str) -> Result<Option<Vec<Sample>>, Problem> {
        let known = study.vocabulary.propositions.get(word);
        let binding = known.and_then(|it| it.column.as_ref());
        let (Some(cohort), Some(binding)) = (&self.cohort, binding) else {
            return Ok(None);
        };
        match cohort.has_column(study, binding) {
            Ok(()) => cohort.counts(&binding.text).map(Some),
            Err(_) => Ok(None),
        }
    }

    /// In which trials of the cohort it was triggered; `None` where the tables have a row of its own that says otherwise, or do not say it.
    ///
    /// # Errors
    /// Columns that are none of counts.
    pub(super) fn triggering(
        &self,
        study: &Study,
        form: &SubjectForm,
    ) -> Result<Option<Triggering>, Problem> {
        let own = match &form.subject {
            Subject::Requirement(_) if self.covered(&form.subject).is_some() => return Ok(None),
            _ => self.covered(&form.subject),
        };
        let Some(cohort) = &self.cohort else {
            return Ok(None);
        };
        let (condition, word) = (condition(form), word(study, form));
        if condition.is_none() && word.is_none() {
            return Ok(None);
        }
        let Some(counted) = self.cohort_counts(study, form)? else {
            return Ok(None);
        };
        let triggers = word.as_ref().map(|word| self.came(study, word));
        if let Some(triggers) = triggers.transpose()?.flatten() {
            let more = counted.iter().zip(&triggers);
            let more = more.filter(|(one, trigger)| one.successes > trigger.successes);
            match (more.count(), own) {
                (0, own) => {
                    let among = among(&counted, &triggers);
                    let trials = among.iter().map(|it| it.trials).sum::<u64>();
                    if own.is_none_or(|own| own == trials) {
                        return Ok(Some(Triggering::BySubject(among)));
                    }
                }
                (more, None) => {
                    return Ok(Some(Triggering::Unknown {
                        came: triggers.iter().map(|it| it.successes).sum(),
                        reason: format!(
                            "in {more} of the {} rows of {} more are counted than triggered it, so that they are not counted among those",
                            counted.len(),
                            cohort.table.name()
                        ),
                    }));
                }
                (_, Some(_)) => {}
            }
        }
        match own {
            Some(_) => Ok(None),
            None => Ok(self.in_all(study, condition, &counted)),
        }
    }

    /// By the opportunities of a failure mode that are the same.
    fn in_all(
        &self,
        study: &Study,
        condition: Option<&FormText>,
        counted: &[Sample],
    ) -> Option<Triggering> {
        let condition = condition?;
        let count: u64 = counted.iter().map(|it| it.successes).sum();
        let attempts = self.attempts()?;
        let row = self.failure_modes.iter().find(|row| {
            let mode = study.forms.of(&Subject::FailureMode(row.mode.clone()));
            let opportunity = mode.and_then(|it| it.opportunity.as_ref());
            opportunity.is_some_and(|it| is_same(it, condition))
        })?;
        let came = row.opportunities;
        // A trial may have several opportunities, which say nothing of how many trials have one.
        match (count..attempts).contains(&came) {
            true => Some(Triggering::Total(came)),
            false if came < count => Some(Triggering::Unknown {
                came,
                reason: format!(
                    "{came} triggered it by the opportunities of {}, and {count} are counted, so that they are not counted among those",
                    row.mode
                ),
            }),
            false => None,
        }
    }
}

impl OwnRow<'_> {
    fn misfit(&self, form: &SubjectForm, word: &str, (came, exact): (u64, bool)) -> Problem {
        let (trials, id) = (self.trials, form.subject.id());
        let (what, rule) = match self.several {
            true => (
                "opportunities are",
                "each of these is an opportunity at least",
            ),
            false if exact => (
                "trials are",
                "these are the trials that trigger it, with a verdict or without",
            ),
            false => ("trials are", "no others can trigger it"),
        };
        let message = format!(
            "{trials} {what} counted for `{id}` here, and the cohort counts {came} attempts in which \"{word}\" came: {rule}"
        );
        self.place.of(Problem::new("tables-disagree", message)).remedy(format!(
            "correct the table that is wrong; or, if the row counts something else than \"{word}\", name that as what triggers `{id}` in \
             requirements.toml"
        ))
    }
}

/// The proposition without which a subject is not triggered, and whether it is triggered by that alone: `F<=3 "w"` is by `w` within a bound.
fn known_word(study: &Study, form: &SubjectForm) -> Option<(String, bool)> {
    let exact = word(study, form).map(|word| (word, true));
    exact.or_else(|| {
        let text = &condition(form)?.text;
        let path = bare(text);
        let path = path.strip_prefix("P=?[F<=")?;
        let (bound, rest) = path.split_once('"')?;
        let is_number = bound.parse::<f64>().is_ok();
        let name = rest.strip_suffix("\"]")?;
        (is_number && !name.contains('"')).then(|| (name.to_owned(), false))
    })
}

/// What was counted of each subject among the attempts that triggered it.
fn among(counted: &[Sample], triggers: &[Sample]) -> Vec<Sample> {
    let pairs = counted.iter().zip(triggers);
    let among = pairs.map(|(counted, trigger)| Sample {
        successes: counted.successes,
        trials: trigger.successes,
    });
    among.collect()
}

/// The proposition that has to come to hold for a trial to count, where it is one alone; a model need not have it.
fn word(study: &Study, form: &SubjectForm) -> Option<String> {
    if let Some(condition) = condition(form) {
        return reached(condition);
    }
    let (Subject::Requirement(id), TriggerForm::Unknown(_)) = (&form.subject, &form.trigger) else {
        return None;
    };
    let mut requirements = study.requirements.iter();
    let own = requirements.find(|it| &it.id == id)?;
    let words = own.trigger.as_deref()?.trim();
    let word = words.strip_prefix("rise ").unwrap_or(words).trim();
    let is_known = study.vocabulary.propositions.contains_key(word);
    is_known.then(|| word.to_owned())
}

/// What has to come for a trial to count, as a question to a model.
fn condition(form: &SubjectForm) -> Option<&FormText> {
    match (&form.subject, &form.trigger) {
        (Subject::FailureMode(_), _) => form.opportunity.as_ref(),
        (Subject::Requirement(_), TriggerForm::Runs(trigger)) => Some(trigger),
        (Subject::Requirement(_), _) => None,
    }
}

/// The proposition of which a property asks whether it ever comes to hold; `None` of another property.
fn reached(property: &FormText) -> Option<String> {
    let names = quoted_names(&property.text);
    let [(name, span)] = names.as_slice() else {
        return None;
    };
    let mut rest = property.text.clone();
    rest.replace_range(span.clone(), "");
    (bare(&rest) == "P=?[F\"\"]").then(|| name.clone())
}

fn is_same(one: &FormText, other: &FormText) -> bool {
    bare(&one.text) == bare(&other.text)
}

/// A property without blanks and parentheses.
fn bare(text: &str) -> String {
    text.chars()
        .filter(|c| !c.is_whitespace() && !"()".contains(*c))
        .collect()
}
