//! What was counted in reality.

use super::file::{CODE, CalibrationText, HeldOutRuns};
use crate::technique::experiment::{SubjectCount, Tables};
use campaign::Random;
use campaign::calibration::{Counted, Observed};
use diagnostic::{Problem, Source, did_you_mean};
use evidence::{Measure, Subject};
use study::Study;
use study::placed::quoted;

/// The counts of the evidence, and which subjects' runs are to be predicted from the others.
pub struct Reality {
    /// For each requirement (as violations) and failure mode, fitted ones first: all runs.
    pub observed: Vec<Observed>,
    /// For each of them, what its opportunities are worth in independent ones.
    pub effective: Vec<f64>,
    /// For each of them, the difference that still counts as agreement.
    pub margins: Vec<f64>,
    /// The subjects, in the order of the clusters; none if nothing is counted by subject.
    pub subjects: Vec<String>,
    /// Groups of subjects, by place, that are predicted from the others.
    pub held_out: Vec<Vec<usize>>,
    /// Whether the one group is kept out of the fitted set, too.
    pub kept_out: bool,
}

impl Reality {
    /// Reads the counts that the file asks for.
    pub fn read(study: &Study, source: &Source, text: &CalibrationText) -> Result<Self, Problem> {
        let about = About {
            study,
            source,
            text,
        };
        let (tables, findings) = about.tables()?;
        let mut reality = Self {
            observed: Vec::new(),
            effective: Vec::new(),
            margins: Vec::new(),
            subjects: Vec::new(),
            held_out: Vec::new(),
            kept_out: !matches!(text.hold_out_runs, Some(HeldOutRuns::Folds(_)) | None),
        };
        let ids = text.fit.iter().map(|id| (id, false));
        for (id, held_out) in ids.chain(text.hold_out.iter().map(|id| (id, true))) {
            let (occurrences, opportunities) = about.counts(id, &findings)?;
            let effective = about.effective(id, &findings);
            reality
                .effective
                .push(effective.unwrap_or(opportunities as f64));
            let form = study.forms.by_id(id);
            let margin = form.map(|form| study.margin(&form.subject));
            reality
                .margins
                .push(margin.unwrap_or(evidence::DEFAULT_MARGIN));
            let mut observed = Observed::new(id, occurrences, opportunities);
            observed.held_out = held_out;
            if text.by_subject
                && let Some(by_subject) = about.clusters(&tables, id, opportunities)?
            {
                observed.clusters = by_subject.iter().map(|(_, counted)| *counted).collect();
                reality.subjects = by_subject.into_iter().map(|(name, _)| name).collect();
            }
            reality.observed.push(observed);
        }
        reality.held_out = about.groups(&reality)?;
        Ok(reality)
    }

    /// The counts without those of a group of subjects, which are to be predicted. What is held
    /// out wholly stays as it is.
    pub fn without(&self, group: &[usize]) -> Vec<Observed> {
        let split = |observed: &Observed| {
            let mut observed = observed.clone();
            if observed.held_out || observed.clusters.is_empty() {
                return observed;
            }
            let all = std::mem::take(&mut observed.clusters);
            for (place, counted) in all.into_iter().enumerate() {
                match group.contains(&place) {
                    true => observed.held_out_runs.push(counted),
                    false => observed.clusters.push(counted),
                }
            }
            let fitted = &observed.clusters;
            observed.occurrences = fitted.iter().map(|it| it.occurrences).sum();
            observed.opportunities = fitted.iter().map(|it| it.opportunities).sum();
            observed
        };
        self.observed.iter().map(split).collect()
    }

    /// What the fitted set is fitted to.
    pub fn fitted(&self) -> Vec<Observed> {
        match (self.kept_out, self.held_out.first()) {
            (true, Some(group)) => self.without(group),
            _ => self.observed.clone(),
        }
    }

    /// The names of a group's subjects.
    pub fn names(&self, group: &[usize]) -> Vec<String> {
        group
            .iter()
            .map(|place| self.subjects[*place].clone())
            .collect()
    }
}

struct About<'a> {
    study: &'a Study,
    source: &'a Source,
    text: &'a CalibrationText,
}

impl About<'_> {
    fn wrong(&self, word: &str, message: String, remedy: impl Into<String>) -> Problem {
        let span = quoted(self.source, word);
        Problem::new(CODE, message)
            .at(self.source, span)
            .remedy(remedy)
    }

    fn tables(&self) -> Result<(Tables, Vec<evidence::Finding>), Problem> {
        let id = &self.text.evidence;
        let known = self.study.ledger.iter().map(|entry| entry.id.as_str());
        let Some(entry) = self.study.ledger.iter().find(|entry| &entry.id == id) else {
            let message = format!("the ledger has no evidence `{id}`");
            let remedy = match did_you_mean(id, known.clone()) {
                Some(similar) => format!("did you mean `{similar}`?"),
                None => format!("it has: {}", known.collect::<Vec<_>>().join(", ")),
            };
            return Err(self.wrong(id, message, remedy));
        };
        let Some(files) = entry.work.tables() else {
            let message = format!("`{id}` has no tables of counts");
            let remedy = "name an entry of the ledger whose counts are read from tables";
            return Err(self.wrong(id, message, remedy));
        };
        let tables = Tables::read(self.study, files)?;
        let produced = tables.produce(self.study, id, entry.work.technique())?;
        Ok((tables, produced.findings))
    }

    /// What the opportunities are worth in independent ones, where trials are alike.
    fn effective(&self, id: &str, findings: &[evidence::Finding]) -> Option<f64> {
        let finding = findings.iter().find(|f| f.subject.id() == id)?;
        match finding.measure {
            Measure::Counts {
                effective_trials, ..
            } => effective_trials,
            _ => None,
        }
    }

    /// Occurrences and opportunities of a requirement (as violations) or failure mode.
    fn counts(&self, id: &str, findings: &[evidence::Finding]) -> Result<(u64, u64), Problem> {
        let Some(finding) = findings.iter().find(|f| f.subject.id() == id) else {
            let message = format!("this study has no requirement or failure mode `{id}`");
            let known = findings.iter().map(|f| f.subject.id());
            let remedy = match did_you_mean(id, known.clone()) {
                Some(similar) => format!("did you mean `{similar}`?"),
                None => format!("it has: {}", known.collect::<Vec<_>>().join(", ")),
            };
            return Err(self.wrong(id, message, remedy));
        };
        let Measure::Counts { count, trials, .. } = finding.measure else {
            let message = format!("`{id}` was not counted by {}", self.text.evidence);
            return Err(self.wrong(id, message, "leave it out of `fit` and `hold_out`"));
        };
        Ok(match finding.subject {
            Subject::Requirement(_) => (trials - count, trials),
            Subject::FailureMode(_) => (count, trials),
        })
    }

    /// Counts by subject, if the tables have them and it is known which trials were opportunities.
    fn clusters(
        &self,
        tables: &Tables,
        id: &str,
        opportunities: u64,
    ) -> Result<Option<Vec<(String, Counted)>>, Problem> {
        let Some(by_subject) = tables.by_subject(self.study, id)? else {
            return Ok(None);
        };
        let before = self.text.no_opportunity_after.get(id);
        let mut lost = vec![0; by_subject.len()];
        for other in before.into_iter().flatten() {
            let Some(counts) = tables.by_subject(self.study, other)? else {
                let message = format!("`{other}` is not counted by subject");
                let remedy = "name failure modes that the cohort counts";
                return Err(self.wrong(other, message, remedy));
            };
            let parts = lost.iter_mut().zip(counts);
            parts.for_each(|(lost, count)| *lost += count.occurrences);
        }
        let counted: Option<Vec<(String, Counted)>> = (by_subject.into_iter().zip(lost))
            .map(|(count, lost)| opportunities_of(count, lost))
            .collect();
        let sum =
            |all: &[(String, Counted)]| all.iter().map(|(_, it)| it.opportunities).sum::<u64>();
        match counted {
            Some(counted) if sum(&counted) == opportunities => Ok(Some(counted)),
            _ if before.is_none() => Ok(None),
            counted => {
                let found =
                    counted.map_or("a negative number of".into(), |it| sum(&it).to_string());
                let message = format!(
                    "by subject, `{id}` has {found} opportunities in all, the tables say {opportunities}"
                );
                Err(self.wrong(id, message, "correct [no_opportunity_after] or the tables"))
            }
        }
    }

    /// Which subjects are predicted from the others.
    fn groups(&self, reality: &Reality) -> Result<Vec<Vec<usize>>, Problem> {
        let Some(asked) = &self.text.hold_out_runs else {
            return Ok(Vec::new());
        };
        let whole = |it: &&Observed| !it.held_out && it.clusters.is_empty();
        if let Some(observed) = reality.observed.iter().find(whole) {
            let message = format!(
                "the counts of `{}` are not known by subject, so runs cannot be held out",
                observed.mode
            );
            let remedy = "add a cohort that counts it, say in [no_opportunity_after] which trials had no opportunity, or leave out `hold_out_runs`";
            return Err(self.wrong(&observed.mode, message, remedy));
        }
        let count = reality.subjects.len();
        let drawn = Random::new(self.study.about.seed, "runs held out").permutation(count);
        let groups = match asked {
            HeldOutRuns::Subjects(names) => {
                let place = |name: &String| {
                    let known = reality.subjects.iter().position(|subject| subject == name);
                    known.ok_or_else(|| {
                        let message = format!("there is no subject `{name}`");
                        let remedy = format!("the cohort has: {}", reality.subjects.join(", "));
                        self.wrong(name, message, remedy)
                    })
                };
                vec![names.iter().map(place).collect::<Result<Vec<_>, _>>()?]
            }
            HeldOutRuns::Share(share) => {
                let part = ((count as f64 * share).round() as usize).max(1);
                vec![drawn[..part.min(count)].to_vec()]
            }
            HeldOutRuns::Folds(folds) => {
                let of = |fold: usize| drawn.iter().skip(fold).step_by(*folds).copied().collect();
                (0..*folds).map(of).collect()
            }
        };
        if groups
            .iter()
            .any(|group| group.is_empty() || group.len() >= count)
        {
            let message = format!(
                "{count} subjects cannot be divided so: a part has none, or nothing is left to fit"
            );
            return Err(self.wrong(
                "hold_out_runs",
                message,
                "hold out fewer, or take fewer folds",
            ));
        }
        Ok(sorted(groups))
    }
}

fn sorted(mut groups: Vec<Vec<usize>>) -> Vec<Vec<usize>> {
    for group in &mut groups {
        group.sort_unstable();
        group.dedup();
    }
    groups
}

fn opportunities_of(count: SubjectCount, lost: u64) -> Option<(String, Counted)> {
    let opportunities = count.attempts.checked_sub(lost)?;
    let fits = count.occurrences <= opportunities;
    fits.then_some((
        count.subject,
        Counted {
            occurrences: count.occurrences,
            opportunities,
        },
    ))
}
