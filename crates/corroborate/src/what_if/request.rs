//! Tries a study's variants.

use super::file::{ChangeText, Read, is_simulated, subject_of, variants};
use super::formal::Base;
use super::report::{
    ChangeReport, Gain, Row, VariantFailures, VariantReport, WhatIfReport, parted,
};
use super::simulated::{Episodes, Verdicts, gain};
use crate::run::{RunRequest, run_with_page};
use crate::technique::confidence;
use crate::technique::model_checking::Compiled;
use diagnostic::{Problem, did_you_mean};
use evidence::{StudyResult, Subject};
use host::Host;
use std::collections::BTreeMap;
use std::path::PathBuf;
use study::{Entry, Study};

/// Points of a posterior, unless others are asked for.
const POINTS: usize = 200;

/// Episodes of a simulation, unless others are asked for.
const EPISODES: u64 = 100;

/// What [`what_if()`] needs to know.
#[derive(Clone, Debug)]
pub struct WhatIfRequest {
    /// The study's folder.
    pub study: PathBuf,
    /// Where the study's results are; in its folder `results` if `None`.
    pub out: Option<PathBuf>,
    /// The names of the variants to try; all if empty.
    pub variants: Vec<String>,
    /// Points of the posterior of a model's counted constants.
    pub points: usize,
    /// Episodes of each simulation, with and without the variant.
    pub episodes: u64,
}

impl WhatIfRequest {
    /// All variants of a study, at 200 points and with 100 episodes.
    pub fn new(study: impl Into<PathBuf>) -> Self {
        Self {
            study: study.into(),
            out: None,
            variants: Vec::new(),
            points: POINTS,
            episodes: EPISODES,
        }
    }
}

/// Runs a study as far as it is stale and tries its variants in each technique that can express them. `draw` draws the report's
/// page, as for [`run_with_page`].
///
/// # Errors
/// Those of [`run()`](crate::run()); `no-variants` without variants or for a name that none has; what a variant names and
/// the study has not, with its place.
pub fn what_if(
    request: &WhatIfRequest,
    host: &Host,
    draw: &dyn Fn(&StudyResult) -> String,
) -> Result<WhatIfReport, Problem> {
    let study = Study::load_for(&request.study, &host.trust)?;
    let mut all = variants(&study)?;
    if !request.variants.is_empty() {
        known(&all, &request.variants)?;
        all.retain(|read| request.variants.contains(&read.variant.name));
    }
    let run = RunRequest {
        out: request.out.clone(),
        ..RunRequest::new(&request.study)
    };
    let result = run_with_page(&run, host, draw)?.into_study()?;
    let trial = Trial {
        study: &study,
        result: &result,
        request,
        host,
        level: confidence(study.about.confidence)?,
        subjects: subjects(&study, &all)?,
    };
    Ok(WhatIfReport {
        confidence: study.about.confidence,
        variants: trial.variants(&all)?,
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
    request: &'a WhatIfRequest,
    host: &'a Host,
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
        let (parted, pairs) = parted(&rows);
        Ok(VariantReport {
            name: read.variant.name.clone(),
            meaning: read.variant.meaning.clone(),
            changes: read.variant.changes.iter().map(change_report).collect(),
            parted,
            pairs,
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
        let points = self.request.points;
        let interrupt = &self.host.cancel;
        let begin = |what: &str| {
            let title = format!("{}: {what}", entry.id);
            self.host.events.begin(&title, points as u64)
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
            count: self.request.episodes,
            host: self.host,
        };
        let begin = |what: &str| {
            let title = format!("{}: {what}", entry.id);
            self.host.events.begin(&title, self.request.episodes)
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
