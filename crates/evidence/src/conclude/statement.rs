//! The statement of a verdict: claim, figures, what speaks against it, and why it is not more.
//!
//! All of it is made from the standings, so that no sentence can contradict a figure beside it.

use super::judge::{Asked, Level};
use super::ladder::{Judged, is_denial, lean_apart, left_open};
use super::words;
use crate::compare::Belief;
use crate::compare::words::{list, percent, points};
use crate::{
    Calibration, Direction, Evidence, Excluded, ExclusionReason, Measure, Outcome, Relation,
    Standing, Step, Subject, Verdict,
};
use std::collections::BTreeSet;

/// What a statement is made from.
pub(super) struct Statement<'s> {
    pub asked: &'s Asked<'s>,
    pub level: &'s Level,
    pub judged: &'s [Judged],
    pub verdict: Verdict,
    pub step: Option<Step>,
    pub excluded: &'s [Excluded],
    /// Whether trials may be added and judged again.
    pub is_looked_at_again: bool,
}

/// More of the points of its constants than this lie beyond what a model can have before it is said: half of what a limit leaves.
const MOST_OUT_OF_REACH: f64 = 0.0125;

impl Statement<'_> {
    /// All sentences.
    pub fn words(&self) -> String {
        let mut sentences = vec![self.claim()];
        sentences.extend(self.figures());
        sentences.extend(self.set_to_counts());
        sentences.extend(self.not_carried_over());
        sentences.extend(self.elsewhere());
        sentences.extend(self.open_elsewhere());
        sentences.extend(self.conflicts());
        sentences.extend(self.contrary_models());
        sentences.extend(self.contrary_trials());
        sentences.extend(self.why_not_more());
        sentences.extend(self.left_out());
        sentences.join(" ")
    }

    fn claim(&self) -> String {
        let asked = capital(&words::asked(self.asked.threshold));
        let by = |step: Option<Step>| match step {
            Some(Step::System) => "by trials of the system",
            Some(Step::Corroborated) => {
                "for the system by a model whose agreement with it carries over"
            }
            Some(Step::Simulation) => "in simulation",
            Some(Step::Model) => "for the model",
            None => "by no evidence",
        };
        match self.verdict {
            Verdict::NotCovered if self.excluded.iter().all(|it| it.reason.is_silence()) => {
                "Not covered by any evidence.".to_owned()
            }
            Verdict::NotCovered => "Not covered by any evidence that takes part.".to_owned(),
            Verdict::Satisfied if self.step < Some(Step::Corroborated) => {
                format!("{asked} is supported {} only.", by(self.step))
            }
            Verdict::Satisfied => format!("{asked} is supported {}.", by(self.step)),
            Verdict::Violated => format!("{asked} is refuted {}.", by(self.step)),
            Verdict::Undecided => format!("{asked} is neither supported nor refuted."),
            Verdict::Conflicting if self.is_left_open_without_conflict() => format!(
                "{asked} is decided neither by trials of the system, which leave it open, nor by what stands for it, because \
                 pieces of evidence conflict."
            ),
            Verdict::Conflicting => {
                format!("{asked} is not decided, because pieces of evidence conflict.")
            }
        }
    }

    /// Whether no conflict is with trials of the system, and these by themselves decide nothing.
    fn is_left_open_without_conflict(&self) -> bool {
        let of_system = |it: &&Judged| it.standing.step == Step::System && !it.standing.elsewhere;
        let trials: Vec<&Judged> = self.judged.iter().filter(of_system).collect();
        let is_trial = |id: &String| trials.iter().any(|it| &it.standing.evidence == id);
        let mut conflicts = self.asked.among.iter();
        !trials.is_empty()
            && trials
                .iter()
                .all(|it| it.standing.standing == Standing::Neither)
            && !conflicts.any(|it| {
                it.outcome == Outcome::Conflicts && (is_trial(&it.left) || is_trial(&it.right))
            })
    }

    /// The figures of all current pieces by step, the strongest first.
    fn figures(&self) -> Vec<String> {
        let steps = Step::ALL.iter().rev();
        steps
            .filter_map(|step| {
                let of_step = self
                    .judged
                    .iter()
                    .filter(|it| it.standing.step == *step && !it.standing.elsewhere)
                    .filter(|it| !self.has_failed(it));
                let figures: Vec<&str> = of_step.map(|it| it.standing.words.as_str()).collect();
                let head = capital(step.words());
                (!figures.is_empty()).then(|| format!("{head}: {}.", figures.join("; ")))
            })
            .collect()
    }

    /// What the figures of models and simulators rest on that were set to counts, or solved for so that they come out.
    fn set_to_counts(&self) -> Vec<String> {
        // Only of what has a figure beside the verdict.
        let has_figure = |it: &&Evidence| {
            let mut judged = self.judged.iter();
            judged.any(|one| one.standing.evidence == it.id)
        };
        let pieces = || self.asked.pieces.iter().map(|it| it.evidence);
        let chosen = pieces().filter(has_figure).filter_map(|it| self.chosen(it));
        let made =
            pieces().filter(|it| it.technique.is_of_model() || it.technique.is_of_simulator());
        let sentences = made.filter(has_figure).map(set_to_counts);
        chosen.chain(sentences.flatten()).collect()
    }

    /// What of a piece's texts, by which it is judged here, was chosen because then other evidence agrees.
    fn chosen(&self, piece: &Evidence) -> Option<String> {
        let own = Subject::Requirement(self.asked.requirement.id.clone());
        let is_here = |it: &&Calibration| {
            it.chosen && (it.subject == own || it.subject == self.asked.quantity)
        };
        let chosen: Vec<&Calibration> = piece.calibrated.iter().filter(is_here).collect();
        if chosen.is_empty() {
            return None;
        }
        let from: BTreeSet<&str> = chosen.iter().map(|one| one.from.as_str()).collect();
        let from: Vec<String> = from.into_iter().map(str::to_owned).collect();
        let what: BTreeSet<&str> = chosen.iter().map(|one| one.parameter.as_str()).collect();
        let what: Vec<String> = what.into_iter().map(|it| format!("\"{it}\"")).collect();
        Some(format!(
            "In {} {} was chosen because it agrees with {}: that other choices would fit, too, is not in its figure.",
            piece.id,
            list(&what),
            list(&from)
        ))
    }

    /// Models that are declared to carry over and do not, unless what is left out says it.
    fn not_carried_over(&self) -> Vec<String> {
        let is_listed = |id: &str| {
            let mut excluded = self.excluded.iter();
            excluded.any(|it| {
                it.evidence == id && matches!(it.reason, ExclusionReason::BelowNeededStep(_))
            })
        };
        let failed = self.judged.iter().filter(|it| self.has_failed(it));
        failed
            .filter(|it| !is_listed(&it.standing.evidence))
            .map(|it| format!("{}.", it.standing.words))
            .collect()
    }

    /// Whether it is a model's declared carrying over, which was not shown.
    fn has_failed(&self, judged: &Judged) -> bool {
        let standing = &judged.standing;
        let mut transfers = self.asked.transfers.iter();
        standing.step == Step::Corroborated
            && transfers.any(|it| it.piece.evidence.id == standing.evidence && it.anchor.is_err())
    }

    /// What refutes it under other conditions.
    fn elsewhere(&self) -> Option<String> {
        let denials = self.judged.iter();
        let denials = denials.filter(|it| it.standing.elsewhere && is_denial(it, self.judged));
        let figures: Vec<String> = denials
            .map(|it| format!("{} ({})", it.standing.words, it.standing.step.words()))
            .collect();
        (!figures.is_empty())
            .then(|| format!("Refuted under other conditions: {}.", figures.join("; ")))
    }

    /// What is shown under some conditions and left open under others.
    fn open_elsewhere(&self) -> Option<String> {
        let supporting = self.judged.iter().find(|it| {
            let standing = &it.standing;
            it.decides
                && !standing.elsewhere
                && (standing.step, standing.standing) == (Step::System, Standing::Supports)
        })?;
        let open = left_open(self.judged);
        let figures: Vec<&str> = open.iter().map(|it| it.standing.words.as_str()).collect();
        (self.verdict == Verdict::Undecided && !open.is_empty()).then(|| {
            format!(
                "{} supports it under its conditions ({}); under others, under which the system was tried, too, it is open: {}.",
                supporting.standing.evidence,
                supporting.conditions,
                figures.join("; ")
            )
        })
    }

    /// Differences beyond the margin that are shown: conflicts, and such as are of one person, session or other cluster alone.
    fn conflicts(&self) -> Vec<String> {
        let different = self.asked.among.iter();
        different
            .filter(|it| it.relation == Some(Relation::Different))
            .map(|it| {
                let size = points(it.difference.unwrap_or(0.0).abs());
                let (left, right) = (&it.left, &it.right);
                match it.outcome {
                    Outcome::Conflicts => {
                        format!("{left} and {right} conflict: they differ by {size}.")
                    }
                    _ => format!(
                        "{left} and {right} differ by {size}, beyond chance, which is said of one alone and is not a conflict."
                    ),
                }
            })
            .collect()
    }

    /// Models that say the contrary of a verdict that stands above them.
    fn contrary_models(&self) -> Option<String> {
        let (shown, contrary) = match self.verdict {
            Verdict::Satisfied => (Standing::Supports, Standing::Denies),
            Verdict::Violated => (Standing::Denies, Standing::Supports),
            _ => return None,
        };
        // What is decided under other conditions is not contradicted under these.
        self.judged.iter().find(|it| {
            let standing = &it.standing;
            !standing.elsewhere && Some(standing.step) == self.step && standing.standing == shown
        })?;
        let below = self.judged.iter().filter(|it| {
            let standing = &it.standing;
            !standing.elsewhere && Some(standing.step) < self.step && standing.standing == contrary
        });
        let ids: Vec<String> = below
            .map(|it| format!("{} ({})", it.standing.evidence, it.standing.step.words()))
            .collect();
        let claim = match contrary {
            Standing::Denies => "refuted",
            _ => "supported",
        };
        let asked = words::asked(self.asked.threshold);
        (!ids.is_empty()).then(|| {
            format!(
                "By {} alone {asked} would be {claim}; evidence of a higher step decides.",
                list(&ids)
            )
        })
    }

    /// Trials of the system that differ, on both sides of the threshold.
    fn trials_that_lean_apart(&self) -> Option<String> {
        let trials = self.judged.iter().filter(|it| {
            let standing = &it.standing;
            !standing.elsewhere && standing.step == Step::System
        });
        let trials: Vec<&Judged> = trials.collect();
        let (one, other) = lean_apart(&trials, &self.asked.apart().within_margin)?;
        Some(format!(
            "{} by itself would support it, and {} lies on the other side of the threshold; they differ beyond chance, so that they are \
             not of one rate, and one of them decides nothing of it.",
            one.standing.evidence, other.standing.evidence
        ))
    }

    /// Trials of the system that support what other trials of it refute, without a difference that is a conflict.
    fn contrary_trials(&self) -> Option<String> {
        if self.verdict == Verdict::Undecided {
            return self.trials_that_lean_apart();
        }
        if (self.verdict, self.step) != (Verdict::Violated, Some(Step::System)) {
            return None;
        }
        let ids = |wanted: Standing| -> Vec<String> {
            let all = self.judged.iter().filter(|it| {
                let standing = &it.standing;
                let is_here = !standing.elsewhere && standing.step == Step::System;
                it.decides && is_here && standing.standing == wanted
            });
            all.map(|it| it.standing.evidence.clone()).collect()
        };
        let (denying, supporting) = (ids(Standing::Denies), ids(Standing::Supports));
        (!denying.is_empty() && !supporting.is_empty()).then(|| {
            format!(
                "{} by itself would support it: trials of the system lie on both sides of the threshold, and no difference \
                 beyond the margin is shown between them and {}. What refutes counts; find out what was otherwise.",
                list(&supporting),
                list(&denying)
            )
        })
    }

    /// What is missing for the requirement to be decided on the step that it needs.
    fn why_not_more(&self) -> Vec<String> {
        let needs = self.asked.requirement.needs;
        let is_below = self.verdict == Verdict::Satisfied && self.step < Some(needs);
        if !is_below && self.verdict != Verdict::Undecided {
            return Vec::new();
        }
        let mut sentences = Vec::new();
        if is_below {
            sentences.push(format!(
                "This is not enough: the requirement needs the step \"{}\".",
                needs.name()
            ));
        }
        let threshold = self.asked.threshold;
        let trials = self.asked.pieces.iter();
        let has_counts = trials
            .clone()
            .any(|piece| matches!(piece.belief, Belief::Counts { .. }));
        let has_trials = trials
            .clone()
            .any(|piece| Step::of(piece.evidence.technique) == Step::System);
        if words::is_certainty(threshold) {
            if has_counts || is_below {
                sentences.push(
                    "No number of trials shows certainty; a threshold below 100 % could be shown."
                        .replace(
                            "below 100 %",
                            match threshold.direction {
                                Direction::AtLeast => "below 100 %",
                                Direction::AtMost => "above 0 %",
                            },
                        ),
                );
            }
        } else if !has_trials && needs >= Step::Corroborated {
            sentences.push(self.trials_without_violation());
        }
        sentences
    }

    /// How many trials of the system without a violation would show the threshold to be met.
    fn trials_without_violation(&self) -> String {
        let threshold = self.asked.threshold;
        let share = match threshold.direction {
            Direction::AtLeast => threshold.value,
            Direction::AtMost => 1.0 - threshold.value,
        };
        // A first look after which more may come has its share of the level, and one quantity more that is tested its share of the
        // study's.
        let share_of_look = match self.is_looked_at_again {
            true => stats::SHARE_OF_A_LOOK,
            false => 1.0,
        };
        let sharing = self.level.with_one_more as f64;
        let level = self.level.of_trials().met * share_of_look / sharing;
        let trials = (level.ln() / share.ln()).ceil().max(1.0);
        let counting = match self.excluded.iter().any(|it| it.verdict_with_it.is_some()) {
            true => "No trials of the system that count",
            false => "No trials of the system",
        };
        format!("{counting} cover it; {trials:.0} without a violation would show it.")
    }

    /// Trials that the study leaves out although they would change the verdict.
    fn left_out(&self) -> Vec<String> {
        let hidden = self.excluded.iter();
        hidden
            .filter_map(|it| {
                let (verdict, step) = it.verdict_with_it?;
                let step = step.map_or(String::new(), |step| format!(" ({})", step.words()));
                let why = match &it.reason {
                    ExclusionReason::Reproduced(by) => format!("as reproduced by {by}"),
                    _ => "as intermediate".to_owned(),
                };
                Some(format!(
                    "{} is left out {why}; with it the verdict would be {}{step}.",
                    it.evidence,
                    verdict.words()
                ))
            })
            .collect()
    }
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    let first = letters.next().map(|first| first.to_uppercase().to_string());
    first.unwrap_or_default() + letters.as_str()
}

/// What a piece's figures leave out of the counts that its numbers were set to or solved for, and how they take these counts: a
/// count of episodes is as uncertain as they are many, and no more.
fn set_to_counts(piece: &Evidence) -> Vec<String> {
    let credible = || {
        let measures = piece.findings.iter().map(|it| &it.measure);
        measures.filter_map(|it| match it {
            Measure::Probability { credible, .. } => credible.as_ref(),
            _ => None,
        })
    };
    let is_in_a_figure = |parameter: &str| {
        let spreads = credible().flat_map(|it| &it.spread);
        let mut sources = spreads.flat_map(|it| it.constant.split(", "));
        sources.any(|name| name == parameter)
    };
    let numbers = piece.calibrated.iter().filter(|one| !one.chosen);
    let (carried, left): (Vec<&Calibration>, Vec<&Calibration>) =
        numbers.partition(|one| is_in_a_figure(&one.parameter));
    let mut sentences = Vec::new();
    if !left.is_empty() {
        let (were, they) = match left.len() {
            1 => ("was", "it"),
            _ => ("were", "them"),
        };
        let left = left.iter();
        let left: Vec<String> = left
            .map(|one| format!("`{}` from the counts of {}", one.parameter, one.from))
            .collect();
        sentences.push(format!(
            "In {} {} {were} set or solved for: how uncertain these counts leave {they} is not in its figure.",
            piece.id,
            list(&left)
        ));
    }
    let same: BTreeSet<&str> = carried
        .iter()
        .filter(|one| {
            let mut others = carried.iter();
            others.any(|it| it.from == one.from && it.subject != one.subject)
        })
        .map(|one| one.from.as_str())
        .collect();
    if !same.is_empty() {
        let same: Vec<String> = same.into_iter().map(str::to_owned).collect();
        sentences.push(format!(
            "{} takes what {} counts of different things as independent of each other.",
            piece.id,
            list(&same)
        ));
    }
    let out_of_reach = credible().map(|it| it.out_of_reach).fold(0.0, f64::max);
    if out_of_reach > MOST_OUT_OF_REACH {
        sentences.push(format!(
            "Of what the counts leave possible {} is beyond what {} can have with any value of what was solved for; there it has the \
             nearest that it can.",
            percent(out_of_reach),
            piece.id
        ));
    }
    sentences
}
