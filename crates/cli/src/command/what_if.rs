//! `corroborate what-if`: variants of the assets, side by side.

use super::{Done, Host, json, run, use_threads};
use crate::args::{Format, WhatIf};
use corroborate::outcome::Outcome;
use corroborate::technique::confidence;
use corroborate::technique::model_checking::Compiled;
use corroborate::what_if::file::{ChangeText, Read, is_simulated, subject_of, variants};
use corroborate::what_if::formal::Base;
use corroborate::what_if::report::{
    ChangeReport, Gain, Row, VariantFailures, VariantReport, WhatIfReport, parted,
};
use corroborate::what_if::simulated::{Episodes, Verdicts, gain};
use diagnostic::{Problem, did_you_mean};
use evidence::{StudyResult, Subject};
use std::collections::BTreeMap;
use study::{Entry, Study};

/// Tries the variants.
pub fn what_if(arguments: &WhatIf, setting: &Host) -> Result<Done, Problem> {
    use_threads(arguments.threads)?;
    let study = Study::load(&arguments.study)?;
    let mut all = variants(&study)?;
    if !arguments.variant.is_empty() {
        known(&all, &arguments.variant)?;
        all.retain(|read| arguments.variant.contains(&read.variant.name));
    }
    let result = run::result(&arguments.study, setting)?;
    let trial = Trial {
        study: &study,
        result: &result,
        arguments,
        setting,
        level: confidence(study.about.confidence)?,
        subjects: subjects(&study, &all)?,
    };
    let report = WhatIfReport {
        confidence: study.about.confidence,
        variants: trial.variants(&all)?,
    };
    Ok(Done {
        outcome: Outcome::Holds,
        output: match arguments.format {
            Format::Json => json(&report)?,
            Format::Text => report.text(),
        },
    })
}

fn known(all: &[Read], wanted: &[String]) -> Result<(), Problem> {
    for name in wanted {
        if all.iter().any(|read| &read.variant.name == name) {
            continue;
        }
        let names: Vec<&str> = all.iter().map(|read| read.variant.name.as_str()).collect();
        let problem = Problem::new("no-variants", format!("the study has no variant `{name}`"));
        return Err(
            problem.remedy(match did_you_mean(name, names.iter().copied()) {
                Some(similar) => format!("did you mean `{similar}`?"),
                None => format!("it has {}", names.join(", ")),
            }),
        );
    }
    Ok(())
}

/// All that some variant looks at.
fn subjects(study: &Study, all: &[Read]) -> Result<Vec<Subject>, Problem> {
    let mut found: Vec<Subject> = Vec::new();
    for read in all {
        for id in &read.variant.subjects {
            let subject = subject_of(study, &read.source, id)?;
            if !found.contains(&subject) {
                found.push(subject);
            }
        }
    }
    Ok(found)
}

struct Trial<'a> {
    study: &'a Study,
    result: &'a StudyResult,
    arguments: &'a WhatIf,
    setting: &'a Host,
    level: stats::Confidence,
    /// What any of the variants looks at.
    subjects: Vec<Subject>,
}

/// What is known of the evidence as it is, so that it is produced once.
#[derive(Default)]
struct Bases<'a> {
    formal: BTreeMap<String, Base<'a>>,
    simulated: BTreeMap<String, Verdicts>,
}

impl<'a> Trial<'a> {
    fn variants(&self, all: &[Read]) -> Result<Vec<VariantReport>, Problem> {
        let mut bases = Bases::default();
        all.iter()
            .map(|read| self.variant(read, &mut bases))
            .collect()
    }

    fn variant(&self, read: &Read, bases: &mut Bases<'a>) -> Result<VariantReport, Problem> {
        let wanted = read.variant.subjects.iter();
        let wanted: Vec<Subject> = wanted
            .map(|id| subject_of(self.study, &read.source, id))
            .collect::<Result<_, _>>()?;
        let (mut rows, mut failures) = (Vec::new(), Vec::new());
        for change in &read.variant.changes {
            let entry = self.study.entry(change.evidence.get_ref())?;
            for (subject, gain) in self.gains(read, change, entry, &wanted, bases, &mut failures)? {
                rows.push(Row {
                    subject,
                    evidence: entry.id.clone(),
                    technique: entry.work.technique(),
                    conditions: entry.conditions.clone(),
                    gain,
                });
            }
        }
        let place = |subject: &Subject| wanted.iter().position(|other| other == subject);
        rows.sort_by_key(|row| place(&row.subject));
        Ok(VariantReport {
            name: read.variant.name.clone(),
            meaning: read.variant.meaning.clone(),
            changes: read.variant.changes.iter().map(change_report).collect(),
            parted: parted(&rows),
            rows,
            failures,
        })
    }

    fn gains(
        &self,
        read: &Read,
        change: &ChangeText,
        entry: &'a Entry,
        wanted: &[Subject],
        bases: &mut Bases<'a>,
        failures: &mut Vec<VariantFailures>,
    ) -> Result<Vec<(Subject, Gain)>, Problem> {
        let reason = change.cannot.clone();
        let is_tried = reason.is_none();
        if is_tried && entry.work.model().is_some() {
            return self.formal(read, change, entry, wanted, bases);
        }
        if is_tried && is_simulated(&entry.work) {
            return self.simulated(read, change, entry, wanted, bases, failures);
        }
        let reason = reason.unwrap_or_else(|| "It is not tried there.".into());
        let gain = Gain::NotExpressible { reason };
        Ok(wanted.iter().map(|s| (s.clone(), gain.clone())).collect())
    }

    fn formal(
        &self,
        read: &Read,
        change: &ChangeText,
        entry: &'a Entry,
        wanted: &[Subject],
        bases: &mut Bases<'a>,
    ) -> Result<Vec<(Subject, Gain)>, Problem> {
        let Some(model) = entry.work.model() else {
            return Ok(Vec::new());
        };
        let points = usize::from(self.arguments.points);
        let interrupt = &self.setting.cancel;
        let begin = |what: &str| {
            let title = format!("{}: {what}", entry.id);
            self.setting.events.begin(&title, points as u64)
        };
        if !bases.formal.contains_key(&entry.id) {
            let compiled = Compiled::new(self.study, model)?;
            let stage = begin("as it is");
            let base = Base::new(
                self.study,
                self.result,
                entry,
                compiled,
                points,
                interrupt,
                &stage,
            )?;
            bases.formal.insert(entry.id.clone(), base);
        }
        let stage = begin(&read.variant.name);
        match bases.formal.get(&entry.id) {
            Some(base) => base.gains(read, change, wanted, self.level, interrupt, &stage),
            None => Ok(Vec::new()),
        }
    }

    fn simulated(
        &self,
        read: &Read,
        change: &ChangeText,
        entry: &'a Entry,
        wanted: &[Subject],
        bases: &mut Bases<'a>,
        failures: &mut Vec<VariantFailures>,
    ) -> Result<Vec<(Subject, Gain)>, Problem> {
        let episodes = Episodes {
            study: self.study,
            entry,
            count: self.arguments.episodes,
            host: self.setting,
        };
        let begin = |what: &str| {
            let title = format!("{}: {what}", entry.id);
            self.setting.events.begin(&title, self.arguments.episodes)
        };
        if !bases.simulated.contains_key(&entry.id) {
            let verdicts = episodes.as_it_is(&self.subjects, &begin("as it is"))?;
            bases.simulated.insert(entry.id.clone(), verdicts);
        }
        let stage = begin(&read.variant.name);
        let after = episodes.varied(read, change, &self.subjects, &stage)?;
        let before = bases.simulated.get(&entry.id);
        for (with_variant, verdicts) in [(false, before), (true, Some(&after))] {
            let shares = verdicts.map(|it| it.failures.shares(self.level));
            let shares = shares.transpose()?.unwrap_or_default();
            failures.extend(shares.into_iter().map(|failures| VariantFailures {
                evidence: entry.id.clone(),
                with_variant,
                failures,
            }));
        }
        let gains = wanted.iter().filter_map(|subject| {
            let place = self.subjects.iter().position(|other| other == subject)?;
            let (before, after) = (before?.of.get(place)?, after.of.get(place)?);
            let gain = gain(subject, before, after, self.level);
            Some((subject.clone(), gain))
        });
        Ok(gains.collect())
    }
}

fn change_report(change: &ChangeText) -> ChangeReport {
    let constants = change.constants.iter();
    let constants = constants.map(|(name, it)| format!("{name} = {}", it.get_ref()));
    let settings = change.settings.iter();
    let settings = settings.map(|(key, value)| format!("{key} = {}", value.to_toml()));
    let cannot = change.cannot.iter().cloned();
    ChangeReport {
        evidence: change.evidence.get_ref().clone(),
        what: constants.chain(settings).chain(cannot).collect(),
        assumes: change.assumes.clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::WhatIfReport;

    #[test]
    fn the_committed_schema_is_the_form_that_is_printed() {
        let schema: serde_json::Value = schemars::schema_for!(WhatIfReport).into();
        crate::command::tests::assert_schema_is_committed("what-if.schema.json", &schema);
    }
}
