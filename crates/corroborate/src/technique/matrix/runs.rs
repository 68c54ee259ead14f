//! Cells B, E, C and F: properties and monitors on the runs that `run` has judged.
//!
//! Episodes are not judged again: their journals have the verdict of each form on each. Evidence has the
//! counts of its monitors. The verdicts on recordings are kept beside their evidence.

use super::cells::{Place, counts};
use super::{Diagnosing, Gathered};
use crate::technique::campaign::form_verdicts;
use crate::technique::confidence;
use crate::technique::operation::{Recordings, verdicts_name};
use diagnostic::Problem;
use evidence::{Cell, JudgedBy, Measure, SameTraces, Subject, Traces, VerdictCounts};
use host::store::fresh_in;
use judging::Judges;
use judging::forms::differences::{OCCURS, PROPERTY, forms_of, judges};
use judging::verdicts::RunVerdicts;
use study::{Entry, Study, SubjectForm, TriggerForm};
use temporal::monitor::Verdict;

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
        for entry in self.entries(|work| work.model().is_none()) {
            let parts = entry.work.parts();
            let (traces, episodes) = match (parts.recordings, parts.simulated) {
                (Some(recordings), _) => {
                    let kept = self.kept_verdicts(entry);
                    let verdicts = match kept {
                        Some(verdicts) => verdicts,
                        None => {
                            let recordings = Recordings::find(self.study, recordings)?;
                            recordings.all_verdicts(self.study, &self.setting.cancel)?
                        }
                    };
                    (Traces::Recordings, Some(verdicts))
                }
                (None, Some(_)) => (Traces::Simulator, self.episodes(entry, parts.episodes)?),
                (None, None) => {
                    let said = match parts.tables {
                        Some(_) => "it is read from tables: no run can be judged again",
                        None => "it has no runs that could be judged again",
                    };
                    let said = format!("cells C and F of {}: {said}", entry.id);
                    gathered.not_done.push(said);
                    continue;
                }
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
                let runs = (episodes.as_ref(), is_triggered(form));
                self.of_runs(&places, runs, &monitors, gathered)?;
            }
        }
        Ok(())
    }

    /// The two cells of one subject on the runs of one entry, and whether its property counts only runs that trigger it.
    fn of_runs(
        &self,
        [property, monitor]: &[Place<'_>; 2],
        (episodes, is_triggered): (Option<&RunVerdicts>, bool),
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
                let places = |main| ((form, main), is_triggered);
                let pair = main.map(|main| differing(property, episodes, places(main)));
                gathered.same.extend(pair);
                match main.filter(|_| is_triggered) {
                    Some(main) => {
                        let sum = counts(triggered(episodes, (form, main)));
                        let count = match property.subject {
                            Subject::Requirement(_) => sum.kept,
                            Subject::FailureMode(_) => sum.violated,
                        };
                        property.counted((count, sum.kept + sum.violated), sum, level)
                    }
                    None => property.filled(sum(&episodes.forms, form), level),
                }
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
            Measure::NotExpressible { reason } | Measure::NotCovered { reason, .. } => {
                Ok(place.empty(reason.clone()))
            }
            Measure::Probability { .. } => Ok(place.empty("it was computed".into())),
        }
    }

    /// The verdicts on an entry's recordings, as `run` kept them with the evidence that is diagnosed.
    fn kept_verdicts(&self, entry: &Entry) -> Option<RunVerdicts> {
        let piece = self.result.evidence.iter().find(|e| e.id == entry.id)?;
        fresh_in(self.folder, &verdicts_name(&entry.id), &piece.inputs)
    }

    /// The verdicts of a campaign's episodes; `None` without a journal.
    fn episodes(&self, entry: &Entry, count: u64) -> Result<Option<RunVerdicts>, Problem> {
        let folder = self.folder.join("episodes").join(&entry.id);
        form_verdicts(&folder, count)
    }
}

/// Whether the computed value is given a trigger, or a failure mode's opportunity, so that other runs do not count for it.
fn is_triggered(form: &SubjectForm) -> bool {
    form.opportunity.is_some() || matches!(form.trigger, TriggerForm::Runs(_))
}

/// What the property says of the runs on which the monitor is triggered.
fn triggered(
    episodes: &RunVerdicts,
    (form, main): (usize, usize),
) -> impl Iterator<Item = Verdict> {
    let runs = episodes.main.iter().zip(&episodes.forms);
    runs.filter_map(move |(of_main, of_forms)| {
        let (monitor, property) = (of_main.get(main)?, of_forms.get(form)?);
        Some(match (monitor, property) {
            (Verdict::NotCovered, _) => Verdict::NotCovered,
            // A property that does not come up is kept.
            (_, Verdict::NotCovered) => Verdict::Satisfied,
            (_, property) => *property,
        })
    })
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

/// On how many runs property and monitor differ, each way; where the property counts only runs that trigger it, of these.
fn differing(
    place: &Place<'_>,
    episodes: &RunVerdicts,
    ((form, main), is_triggered): ((usize, usize), bool),
) -> SameTraces {
    let mut differing = [0; 2];
    for (of_main, of_forms) in episodes.main.iter().zip(&episodes.forms) {
        let (Some(monitor), Some(property)) = (of_main.get(main), of_forms.get(form)) else {
            continue;
        };
        let is_left_out = is_triggered && *monitor == Verdict::NotCovered;
        if is_left_out || [monitor, property].contains(&&Verdict::Inconclusive) {
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
