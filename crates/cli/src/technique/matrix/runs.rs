//! Cells B, E, C and F: properties and monitors on the runs that `run` has judged.
//!
//! Episodes are not judged again: their journals have the verdict of each form on each. Evidence has the
//! counts of its monitors. Recordings are read again.

use super::cells::{Place, counts};
use super::{Diagnosing, Gathered};
use crate::forms::differences::{OCCURS, PROPERTY, forms_of, judges};
use crate::problem::Problem;
use crate::study::{Entry, Study, Work};
use crate::technique::campaign::form_verdicts;
use crate::technique::confidence;
use crate::technique::judging::Judges;
use crate::technique::operation::Recordings;
use evidence::{Cell, JudgedBy, Measure, SameTraces, Subject, Traces, VerdictCounts};
use temporal::monitor::Verdict;

/// The verdicts of one campaign's episodes.
struct Episodes {
    /// By episode, one for each main monitor and reading.
    main: Vec<Vec<Verdict>>,
    /// By episode, one for each form that is held against another.
    forms: Vec<Vec<Verdict>>,
}

/// Where the verdicts of a subject stand among those of an episode.
struct Monitors {
    /// By form: the subject and the form's name.
    forms: Vec<(Subject, String)>,
    /// By monitor: the subject, and whether it is the main reading.
    main: Vec<(Subject, bool)>,
}

impl Monitors {
    /// The place of the property among the forms, and of the monitor.
    fn places(&self, subject: &Subject) -> (Option<usize>, Option<usize>) {
        let is_property = |name: &str| name == PROPERTY || name == OCCURS;
        let mut forms = self.forms.iter();
        let form = forms.position(|(other, name)| other == subject && is_property(name));
        let mut main = self.main.iter();
        let main = main.position(|(other, is_main)| other == subject && *is_main);
        (form, main)
    }
}

impl Diagnosing<'_> {
    /// Fills the cells of simulations and recordings.
    pub(super) fn runs(&self, gathered: &mut Gathered) -> Result<(), Problem> {
        let forms = forms_of(self.study);
        let of_forms = judges(self.study, &forms)?;
        let main = Judges::new(self.study, |_| true)?;
        let monitors = Monitors {
            forms: of_forms
                .monitors()
                .map(|(subject, name)| (subject.clone(), name.unwrap_or_default().to_owned()))
                .collect(),
            main: main
                .monitors()
                .map(|(subject, reading)| (subject.clone(), reading.is_none()))
                .collect(),
        };
        for entry in self.entries(|work| !matches!(work, Work::Check { .. })) {
            let (traces, episodes) = match &entry.work {
                Work::Read { .. } => {
                    let said = "it is read from tables: no run can be judged again";
                    let said = format!("cells C and F of {}: {said}", entry.id);
                    gathered.not_done.push(said);
                    continue;
                }
                Work::Judge { recordings, .. } => {
                    let recordings = Recordings::find(self.study, recordings)?;
                    let interrupt = &self.setting.interrupt;
                    let episodes = Episodes {
                        main: recordings.verdicts(&main, interrupt)?,
                        forms: recordings.verdicts(&of_forms, interrupt)?,
                    };
                    (Traces::Recordings, Some(episodes))
                }
                _ => (Traces::Simulator, self.episodes(entry)?),
            };
            let own = self.study.forms.subjects.iter();
            for form in own.filter(|form| self.is_own(&form.subject)) {
                let place = |judged_by| Place {
                    traces,
                    judged_by,
                    evidence: &entry.id,
                    subject: &form.subject,
                };
                let places = [place(JudgedBy::Property), place(JudgedBy::Monitor)];
                self.of_runs(&places, episodes.as_ref(), &monitors, gathered)?;
            }
        }
        Ok(())
    }

    /// The two cells of one subject on the runs of one entry.
    fn of_runs(
        &self,
        [property, monitor]: &[Place<'_>; 2],
        episodes: Option<&Episodes>,
        monitors: &Monitors,
        gathered: &mut Gathered,
    ) -> Result<(), Problem> {
        let level = confidence(self.study.about.confidence)?;
        let (form, main) = monitors.places(property.subject);
        let own = self.by_monitor(monitor)?;
        let again = match (episodes, main) {
            (Some(episodes), Some(main)) => Some(monitor.filled(sum(&episodes.main, main), level)),
            _ => None,
        };
        // A journal that does not give the evidence's own counts is of other episodes.
        let same = again.filter(|again| (again.count, again.trials) == (own.count, own.trials));
        let cell = match (episodes, form) {
            (Some(episodes), Some(form)) if same.is_some() => {
                let pair = main.map(|main| differing(property, episodes, (form, main)));
                gathered.same.extend(pair);
                property.filled(sum(&episodes.forms, form), level)
            }
            (_, Some(_)) => property
                .empty("no journal of these runs says what the property says of each".into()),
            (_, None) => property.empty(no_property(self.study, property.subject)),
        };
        gathered.cells.push(cell);
        gathered.cells.push(match (same, &own.not_judged) {
            (Some(same), None) => same,
            _ => own,
        });
        Ok(())
    }

    /// The monitor's cell, which is the evidence's own finding.
    fn by_monitor(&self, place: &Place<'_>) -> Result<Cell, Problem> {
        let piece = self.result.evidence.iter().find(|e| e.id == place.evidence);
        let Some(finding) = piece.and_then(|piece| piece.finding(place.subject)) else {
            return Ok(place.empty("it was not judged".into()));
        };
        match &finding.measure {
            Measure::Counts { count, trials, .. } => {
                let verdicts = VerdictCounts {
                    kept: *trials,
                    undecided: finding.undecided,
                    ..VerdictCounts::default()
                };
                let level = confidence(self.study.about.confidence)?;
                Ok(place.counted((*count, *trials), verdicts, level))
            }
            Measure::NotExpressible { reason } | Measure::NotCovered { reason } => {
                Ok(place.empty(reason.clone()))
            }
            Measure::Probability { .. } => Ok(place.empty("it was computed".into())),
        }
    }

    /// The verdicts of a campaign's episodes; `None` without a journal.
    fn episodes(&self, entry: &Entry) -> Result<Option<Episodes>, Problem> {
        let count = match &entry.work {
            Work::Simulate { episodes, .. }
            | Work::SimulateScene { episodes, .. }
            | Work::Command { episodes, .. } => *episodes,
            _ => return Ok(None),
        };
        let folder = self.folder.join("episodes").join(&entry.id);
        let verdicts = form_verdicts(&folder, count)?;
        Ok(verdicts.map(|(main, forms)| Episodes { main, forms }))
    }
}

fn sum(verdicts: &[Vec<Verdict>], at: usize) -> VerdictCounts {
    counts(verdicts.iter().filter_map(|of_run| of_run.get(at).copied()))
}

/// Why there is no property to judge runs by.
fn no_property(study: &Study, subject: &Subject) -> String {
    let all = forms_of(study);
    let named = all
        .iter()
        .find(|f| f.subject == subject && (f.name == PROPERTY || f.name == OCCURS));
    match named.map(|form| &form.judging) {
        Some(Err(reason)) => reason.clone(),
        _ => "it has no property that was written by hand".into(),
    }
}

/// On how many runs property and monitor differ, each way.
fn differing(place: &Place<'_>, episodes: &Episodes, (form, main): (usize, usize)) -> SameTraces {
    let mut differing = [0; 2];
    for (of_main, of_forms) in episodes.main.iter().zip(&episodes.forms) {
        let (Some(monitor), Some(property)) = (of_main.get(main), of_forms.get(form)) else {
            continue;
        };
        if [monitor, property].contains(&&Verdict::Inconclusive) {
            continue;
        }
        match (
            *property == Verdict::Violated,
            *monitor == Verdict::Violated,
        ) {
            (true, false) => differing[0] += 1,
            (false, true) => differing[1] += 1,
            _ => {}
        }
    }
    SameTraces {
        evidence: place.evidence.to_owned(),
        subject: place.subject.clone(),
        differing,
    }
}
