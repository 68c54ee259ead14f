//! Cells A and D: properties and monitors on paths of the formal models, and the sampled answers held
//! against the computed ones.

use super::cells::{Place, counts};
use super::paths::{ModelPaths, PathForm};
use super::{Diagnosing, Gathered};
use crate::corroboration::ANY_STUDY;
use crate::technique::confidence;
use crate::technique::simulation::Seeds;
use diagnostic::Problem;
use evidence::{
    Cell, Clue, Evidence, Figure, Guarantee, Inaccuracy, Interval, JudgedBy, Measure, Rate,
    SameTraces, Subject, SuspectAsset, SuspectKind, Symptom, Traces, Witness, strength,
};
use judging::Judges;
use rayon::prelude::*;
use std::ops::RangeInclusive;
use temporal::monitor::Verdict;

/// How much of a difference a sampled answer forgives: the width of the solver's own bounds.
const SOLVED: f64 = 1e-6;

/// A sampled answer that is farther off than would happen once in a thousand diagnoses is a clue: paths are
/// cheap, so a level that cries wolf in one of twenty is not needed.
const BY_CHANCE: f64 = 1e-3;

/// What differs is sampled again, by so many times as many fresh paths: nobody is accused by paths that were looked at to choose
/// whom to accuse.
const FRESH: u64 = 4;

/// A computed answer with what its model's paths show. Paths that were cut before a verdict may all count and may all
/// not: `nearest` are the counts that come closest to the answer, and nothing is said that they do not show.
struct Sampled {
    subject: Subject,
    computed: f64,
    method: String,
    estimated: bool,
    cell: Cell,
    /// The count and the paths of the completion that is nearest to the answer.
    nearest: (u64, u64),
    p_value: f64,
}

impl Diagnosing<'_> {
    /// Fills the cells of all formal models.
    pub(super) fn formal(&self, gathered: &mut Gathered) -> Result<(), Problem> {
        for entry in self.entries(|work| work.model().is_some()) {
            self.setting.go_on()?;
            let paths = match ModelPaths::of_entry(self.study, &entry.id, &self.setting.cancel) {
                Ok(paths) => paths,
                Err(problem) if self.setting.cancel.is_cancelled() => return Err(problem),
                Err(problem) => {
                    let said = format!("cells A and D of {}: {}", entry.id, problem.message());
                    gathered.not_done.push(said);
                    continue;
                }
            };
            self.of_model(&entry.id, &paths, gathered)?;
        }
        Ok(())
    }

    fn of_model(
        &self,
        id: &str,
        paths: &ModelPaths,
        gathered: &mut Gathered,
    ) -> Result<(), Problem> {
        let subjects = self.study.forms.subjects.iter();
        let own = subjects.filter(|form| self.is_own(&form.subject));
        let forms: Vec<PathForm<'_>> = own.flat_map(|form| paths.forms(form)).collect();
        let first = gathered.cells.len();
        let paths_of = |numbers: RangeInclusive<u64>, into: &mut Gathered| {
            let verdicts = self.judged(id, paths, &forms, numbers)?;
            let mut place = 0;
            for of_subject in forms.chunk_by(|a, b| a.subject == b.subject) {
                let range = place..place + of_subject.len();
                place = range.end;
                self.of_subject(id, of_subject, range.start, &verdicts, into)?;
            }
            Ok::<_, Problem>(())
        };
        paths_of(1..=self.effort.paths, gathered)?;
        let cells = gathered.cells[first..].to_vec();
        if let Some(piece) = self.result.evidence.iter().find(|e| e.id == id) {
            let again = || {
                let mut fresh = Gathered::default();
                let from = self.effort.paths + 1;
                paths_of(
                    from..=self.effort.paths.saturating_mul(1 + FRESH),
                    &mut fresh,
                )?;
                Ok(fresh.cells)
            };
            self.against_computed(piece, cells, &again, gathered)?;
        }
        Ok(())
    }

    /// Requirements that differ only in a threshold share their cells.
    pub(super) fn is_own(&self, subject: &Subject) -> bool {
        let mut all = self.study.requirements.iter();
        all.all(|r| r.id != subject.id() || r.same_quantity_as.is_none())
    }

    /// The verdicts of all forms on all paths; of a form that cannot judge, undecided ones.
    fn judged(
        &self,
        id: &str,
        paths: &ModelPaths,
        forms: &[PathForm<'_>],
        numbers: RangeInclusive<u64>,
    ) -> Result<Vec<Vec<Verdict>>, Problem> {
        let able = forms
            .iter()
            .filter_map(|f| Some((f.subject, f.judging.as_ref().ok()?)));
        let judges = Judges::without_study(paths.vocabulary(), able)?;
        let seeds = path_seeds(self.study.about.seed, id);
        let title = format!("{id}: paths");
        let many = numbers.end() + 1 - numbers.start();
        let stage = self.setting.events.begin(&title, many);
        let numbers = numbers.into_par_iter();
        numbers
            .map(|number| {
                self.setting.go_on()?;
                let trace = paths.trace(seeds.of(number))?;
                let mut judged = judges.judge_at_rest(&trace)?.into_iter();
                stage.advance();
                let verdict = |form: &PathForm<'_>| match form.judging {
                    Ok(_) => judged
                        .next()
                        .map_or(Verdict::Inconclusive, |j| j.findings.verdict),
                    Err(_) => Verdict::Inconclusive,
                };
                Ok(forms.iter().map(verdict).collect())
            })
            .collect()
    }

    /// The cells of one subject, whose forms begin at `first`.
    fn of_subject(
        &self,
        id: &str,
        forms: &[PathForm<'_>],
        first: usize,
        verdicts: &[Vec<Verdict>],
        gathered: &mut Gathered,
    ) -> Result<(), Problem> {
        let level = confidence(self.study.about.confidence)?;
        let find = |judged_by, opportunity| {
            forms
                .iter()
                .position(|f| f.judged_by == judged_by && f.opportunity == opportunity)
        };
        let opportunity = find(JudgedBy::Property, true);
        for (at, form) in forms
            .iter()
            .enumerate()
            .filter(|(_, form)| !form.opportunity)
        {
            let place = Place {
                traces: Traces::Model,
                judged_by: form.judged_by,
                evidence: id,
                subject: form.subject,
            };
            let of_other = opportunity.filter(|_| form.judged_by == JudgedBy::Property);
            let missing = of_other.and_then(|at| forms[at].judging.as_ref().err());
            gathered
                .cells
                .push(match (form.judging.as_ref().err().or(missing), of_other) {
                    (Some(why), _) => place.empty(why.clone()),
                    (None, None) => {
                        let own = verdicts.iter().map(|v| v[first + at]);
                        let sum = match (form.judged_by, form.subject) {
                            (JudgedBy::Property, Subject::FailureMode(_)) => {
                                counts(own.map(occurrence))
                            }
                            (JudgedBy::Property, Subject::Requirement(_))
                            | (JudgedBy::Monitor, _) => counts(own),
                        };
                        place.filled(sum, level)
                    }
                    (None, Some(other)) => {
                        let pairs = verdicts.iter().map(|v| (v[first + at], v[first + other]));
                        match form.subject {
                            // Paths without the trigger do not count, as in the computed answer.
                            Subject::FailureMode(_) => {
                                let sum = counts(pairs.map(given_trigger).map(occurrence));
                                place.counted((sum.violated, sum.kept + sum.violated), sum, level)
                            }
                            Subject::Requirement(_) => {
                                let sum = counts(pairs.map(given_trigger));
                                place.counted((sum.kept, sum.kept + sum.violated), sum, level)
                            }
                        }
                    }
                });
        }
        let both = find(JudgedBy::Property, false).zip(find(JudgedBy::Monitor, false));
        if let Some((property, monitor)) = both
            && forms[property].judging.is_ok()
            && forms[monitor].judging.is_ok()
        {
            // Runs that do not trigger the subject count for neither.
            let is_triggered = |v: &&Vec<Verdict>| {
                opportunity.is_none_or(|at| holds(v[first + at]) != Some(false))
            };
            let pairs = verdicts
                .iter()
                .filter(is_triggered)
                .map(|v| (v[first + property], v[first + monitor]));
            gathered.same.push(same_traces(id, forms[0].subject, pairs));
        }
        Ok(())
    }

    /// Holds the computed answers of a model against its paths, and those that differ against fresh ones, which `again` draws.
    fn against_computed(
        &self,
        piece: &Evidence,
        cells: Vec<Cell>,
        again: &dyn Fn() -> Result<Vec<Cell>, Problem>,
        gathered: &mut Gathered,
    ) -> Result<(), Problem> {
        let sampled = of_properties(piece, cells);
        if sampled.is_empty() {
            return Ok(());
        }
        let off = beyond_chance(&sampled);
        let fresh = match off.is_empty() {
            true => Vec::new(),
            false => of_properties(piece, again()?),
        };
        let is_off = |of: &Sampled| {
            off.iter()
                .any(|(it, _)| it.subject == of.subject && it.method == of.method)
        };
        let fresh: Vec<Sampled> = fresh.into_iter().filter(is_off).collect();
        let off = beyond_chance(&fresh);
        for cell in sampled.iter().map(|s| &s.cell).filter(|c| c.undecided > 0) {
            let (id, of) = (cell.subject.id(), cell.runs);
            let said = format!(
                "{} of {of} paths of {} for {id}: they have no verdict within the longest path, so the sampled rate is \
                 only known to lie between that with none and that with all of them",
                cell.undecided, piece.id
            );
            if !gathered.not_done.contains(&said) {
                gathered.not_done.push(said);
            }
        }
        let inside = sampled.iter().filter(|s| {
            let interval = interval_of(s.nearest, self.study.about.confidence);
            interval.is_some_and(|i| i.low <= s.computed && s.computed <= i.high)
        });
        let inside = inside.count();
        gathered.in_order.push(format!(
            "{}: {} of {} computed answers lie in the interval of {} sampled paths; {} differ beyond chance",
            piece.id,
            inside,
            sampled.len(),
            self.effort.paths,
            off.len()
        ));
        let clues = off
            .into_iter()
            .map(|(it, p)| self.sampled_otherwise(piece, it, p));
        gathered.clues.extend(clues);
        Ok(())
    }

    fn sampled_otherwise(&self, piece: &Evidence, it: &Sampled, p_value: f64) -> Clue {
        let (count, trials) = it.nearest;
        let subject = &it.subject;
        let cut = match it.cell.undecided {
            0 => String::new(),
            n => format!(" {n} paths without a verdict are counted in favour of the answer."),
        };
        let estimated = match it.estimated {
            true => " The answer has no bounds: the iteration only stopped changing.",
            false => "",
        };
        Clue {
            inaccuracy: Inaccuracy::Tool,
            asset: SuspectAsset {
                kind: SuspectKind::Solver,
                file: None,
                part: Some(format!("method `{}`", it.method)),
                evidence: vec![piece.id.clone()],
                together: Vec::new(),
                line: None,
            },
            subject: subject.clone(),
            score: strength(
                Rate::Computed(it.computed),
                Rate::counted(count, trials),
                SOLVED,
            ),
            title: format!(
                "`{}` answers otherwise than the paths of {}",
                it.method, piece.id
            ),
            explanation: format!(
                "For {}, it computes {}; {count} of {trials} sampled paths show it (exact binomial test, \
                 corrected p {p_value:.2e}).{cut}{estimated}",
                subject.in_words(),
                it.computed
            ),
            symptom: Symptom::SampledOtherwise {
                subject: subject.clone(),
                computed: it.computed,
                count,
                paths: trials,
            },
            figures: vec![Figure {
                name: "sampled share of paths".into(),
                value: count as f64 / trials as f64,
                interval: interval_of(it.nearest, self.study.about.confidence),
            }],
            witnesses: vec![Witness {
                name: format!("{} path 1", piece.id),
                shows: "a path of the model".into(),
                replay: format!("corroborate diagnose {ANY_STUDY} --show {}:1", piece.id),
            }],
            ruled_out: Vec::new(),
            resolved_by: None,
        }
    }
}

/// The answers of properties that paths were sampled for.
fn of_properties(piece: &Evidence, cells: Vec<Cell>) -> Vec<Sampled> {
    let properties = cells.into_iter();
    let properties = properties.filter(|c| c.judged_by == JudgedBy::Property && c.trials > 0);
    properties.flat_map(|cell| sampled(piece, &cell)).collect()
}

/// Those that differ from what was sampled beyond chance, with their corrected p-values.
fn beyond_chance(sampled: &[Sampled]) -> Vec<(&Sampled, f64)> {
    let p_values: Vec<f64> = sampled.iter().map(|s| s.p_value).collect();
    let corrected = stats::holm(&p_values);
    let pairs = sampled.iter().zip(corrected);
    pairs.filter(|(_, p)| *p < BY_CHANCE).collect()
}

/// The seeds of a model's paths.
pub fn path_seeds(study: u64, id: &str) -> Seeds {
    Seeds::new(study, &format!("paths of {id}"))
}

/// A property's verdict on a path, which counts if the path triggers its subject.
fn given_trigger((kept, triggered): (Verdict, Verdict)) -> Verdict {
    match (holds(kept), holds(triggered)) {
        (_, Some(false)) => Verdict::NotCovered,
        (Some(true), Some(true)) => Verdict::Satisfied,
        (Some(false), Some(true)) => Verdict::Violated,
        _ => Verdict::Inconclusive,
    }
}

/// A failure mode's verdict by the property that says that it occurs: violated where it does.
fn occurrence(says: Verdict) -> Verdict {
    match says {
        Verdict::Satisfied => Verdict::Violated,
        Verdict::Violated => Verdict::Satisfied,
        Verdict::NotCovered | Verdict::Inconclusive => says,
    }
}

/// Whether a formula holds; one that does not come up does.
fn holds(verdict: Verdict) -> Option<bool> {
    match verdict {
        Verdict::Satisfied | Verdict::NotCovered => Some(true),
        Verdict::Violated => Some(false),
        Verdict::Inconclusive => None,
    }
}

/// The paths on which property and monitor differ. A failure mode's property says that it occurs.
fn same_traces(
    id: &str,
    subject: &Subject,
    pairs: impl Iterator<Item = (Verdict, Verdict)>,
) -> SameTraces {
    let is_mode = matches!(subject, Subject::FailureMode(_));
    let mut differing = [0; 2];
    for (property, monitor) in pairs {
        let (Some(kept), Some(by_monitor)) = (holds(property), holds(monitor)) else {
            continue;
        };
        match (kept != is_mode, by_monitor) {
            (false, true) => differing[0] += 1,
            (true, false) => differing[1] += 1,
            _ => {}
        }
    }
    SameTraces {
        evidence: id.to_owned(),
        subject: subject.clone(),
        differing,
    }
}

/// Each method's answer to what a cell counts.
fn sampled(piece: &Evidence, cell: &Cell) -> Vec<Sampled> {
    let measure = piece.finding(&cell.subject).map(|f| &f.measure);
    let Some(Measure::Probability { answer, others, .. }) = measure else {
        return Vec::new();
    };
    let answers = std::iter::once(answer).chain(others);
    answers
        .map(|answer| {
            let nearest = nearest(cell, answer.value);
            let sample = stats::Sample::new(nearest.0, nearest.1);
            // Where some completion has the answer's share, the paths show nothing against it.
            let within = within_completions(cell, answer.value);
            let p_value = sample.ok().filter(|_| !within);
            Sampled {
                subject: cell.subject.clone(),
                computed: answer.value,
                method: answer.method.clone(),
                estimated: matches!(answer.guarantee, Guarantee::Estimated { .. }),
                cell: cell.clone(),
                nearest,
                p_value: p_value.map_or(1.0, |s| stats::binomial_test_two_sided(s, answer.value)),
            }
        })
        .collect()
}

/// Whether undecided paths can be completed so that the share lies on either side of a value, or at it.
fn within_completions(cell: &Cell, value: f64) -> bool {
    let [low, high] = cell.shares();
    cell.undecided > 0 && (low..=high).contains(&value)
}

/// The completion of a cell whose share is nearest to a value: the count, and the paths.
fn nearest(cell: &Cell, value: f64) -> (u64, u64) {
    let [low, high] = cell.shares();
    let all = cell.trials + cell.undecided;
    if value <= low {
        (cell.count, all)
    } else if value >= high {
        (cell.count + cell.undecided, all)
    } else {
        // Within reach: so many of the undecided ones as come nearest.
        let wanted = (value * all as f64).round() as u64;
        (wanted.clamp(cell.count, cell.count + cell.undecided), all)
    }
}

/// Wilson's interval of counts at a level.
fn interval_of((count, trials): (u64, u64), level: f64) -> Option<Interval> {
    let sample = stats::Sample::new(count, trials).ok();
    let sample = sample.filter(|s| s.trials > 0)?;
    let wilson = stats::wilson(sample, confidence(level).ok()?);
    Some(Interval {
        low: wilson.low,
        high: wilson.high,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cell(count: u64, trials: u64, undecided: u64) -> Cell {
        let subject = Subject::FailureMode("drop".into());
        let place = Place {
            traces: Traces::Model,
            judged_by: JudgedBy::Property,
            evidence: "E1",
            subject: &subject,
        };
        let verdicts = evidence::VerdictCounts {
            violated: count,
            kept: trials - count,
            undecided,
            ..Default::default()
        };
        place.counted((count, trials), verdicts, stats::Confidence::P95)
    }

    /// Against every completion: the p-value that is kept is the greatest of the one-sided ones on that side.
    #[test]
    fn undecided_paths_count_for_the_answer() {
        for (count, trials, undecided) in [(55, 55, 945), (3, 10, 5), (0, 4, 3), (7, 7, 1)] {
            for value in [0.01, 0.055, 0.2, 0.5, 0.97] {
                let (k, n) = nearest(&cell(count, trials, undecided), value);
                let far = |k: u64, n: u64| (k as f64 / n as f64 - value).abs();
                let least = (0..=undecided).map(|more| far(count + more, trials + undecided));
                let least = least.fold(f64::INFINITY, f64::min);
                assert!(
                    (far(k, n) - least).abs() < 1e-12,
                    "{count} {trials} {value}"
                );
            }
        }
        // The failure on all 55 paths that have a verdict says nothing against an answer of 5.5 %.
        assert!(within_completions(&cell(55, 55, 945), 0.06));
        assert!(!within_completions(&cell(55, 55, 945), 0.01));
        assert!(!within_completions(&cell(55, 55, 0), 0.99));
    }
}
