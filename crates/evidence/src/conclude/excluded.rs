//! What a conclusion leaves out, with the reason.
//!
//! # Definition
//! Every piece of the ledger with a finding on a requirement either takes part in its conclusion or is listed here with the
//! reason. One that takes part below the step that the requirement needs, and does not carry over to it, is listed, too: it
//! is judged, and does not count there. Runs of a piece that reached no verdict are listed by
//! piece, with what they count for, and those whose verdict leaves out what was pending at their end. For trials of the system that the study marks as intermediate or as reproduced, and that are its own, the verdict
//! with them is found: they are not refined by what comes later, so leaving them out has to be seen.
//!
//! # Assumes
//! Nothing of the data.
//!
//! # Guarantee
//! Each piece with a finding on the requirement is in the conclusion or in the list, never in neither.

use super::judge::{Asked, Level};
use super::ladder::{self, Decided};
use super::{Piece, is_trial};
use crate::compare::Study;
use crate::compare::words::list;
use crate::{
    Denominator, Evidence, Excluded, ExcludedTrials, ExclusionReason, Finding, Measure, Standing,
    Step, Subject,
};

/// The pieces that are left out, in the ledger's order.
pub(super) fn excluded(
    study: &Study<'_>,
    asked: &Asked<'_>,
    level: &Level,
    decided: Decided,
) -> Vec<Excluded> {
    let judged = asked.judge(level);
    let takes_part = |id: &str| {
        judged.iter().any(|it| {
            it.standing.evidence == id
                && it.decides
                && (!it.standing.elsewhere || it.standing.standing == Standing::Denies)
        })
    };
    let left_out = study.evidence.iter().enumerate();
    left_out
        .filter_map(|(index, piece)| {
            let reason = match takes_part(&piece.id) {
                true => below(asked, piece)?,
                false => reason(study, asked, piece)?,
            };
            let is_left_out = matches!(
                reason,
                ExclusionReason::Intermediate | ExclusionReason::Reproduced(_)
            );
            let hidden = is_left_out && is_trial(piece) && !piece.published;
            let with_it = hidden.then(|| verdict_with(study, asked, level, index));
            let words = words(&piece.id, &reason, piece.one_subject())
                + unused_declaration(asked, piece, &reason);
            Some(Excluded {
                words,
                evidence: piece.id.clone(),
                reason,
                verdict_with_it: with_it.filter(|other| *other != decided),
            })
        })
        .collect()
}

/// Runs that reached no verdict, and trials in whose place others came, by piece in the ledger's order.
pub(super) fn excluded_trials(study: &Study<'_>, asked: &Asked<'_>) -> Vec<ExcludedTrials> {
    let pieces = study.evidence.iter();
    let undecided = pieces.filter_map(|piece| {
        let finding = found(asked, piece)?;
        let trials = finding.undecided;
        (trials > 0).then(|| ExcludedTrials {
            evidence: piece.id.clone(),
            trials,
            words: undecided_in_words(piece, finding, asked.requirement.asks_for.as_deref()),
        })
    });
    let left_out = study.evidence.iter().filter_map(|piece| {
        let trials = found(asked, piece)?.left_out;
        (trials > 0).then(|| ExcludedTrials {
            evidence: piece.id.clone(),
            trials,
            words: left_out_in_words(&piece.id, trials),
        })
    });
    let replaced = replaced_trials(study, asked);
    undecided.chain(left_out).chain(replaced).collect()
}

/// What of runs with a verdict was pending at their end.
fn left_out_in_words(id: &str, runs: u64) -> String {
    let runs = match runs {
        1 => "1 run".to_owned(),
        many => format!("{many} runs"),
    };
    format!(
        "In {runs} of {id} something that the requirement asks for was pending at the end: that is left out, and the verdict is of \
         what was seen whole (`corroborate explain finite-trace`)."
    )
}

/// What became of runs that reached no verdict.
fn undecided_in_words(piece: &Evidence, finding: &Finding, asks_for: Option<&str>) -> String {
    let (runs, they) = match finding.undecided {
        1 => ("1 run".to_owned(), "it is"),
        many => (format!("{many} runs"), "they are"),
    };
    let id = &piece.id;
    let became = match (&finding.completions, &piece.undecided_at_random) {
        (Some(_), _) => format!(
            "{runs} of {id} reached no verdict: {they} counted against and for, so that the limits hold whatever they would have \
             shown."
        ),
        (None, Some(reason)) => format!(
            "{runs} of {id} reached no verdict and {they} left out, declared to be missing at random (\"{reason}\")."
        ),
        (None, None) => format!("{runs} of {id} reached no verdict and {they} left out."),
    };
    match asks_for {
        Some(asked) => format!(
            "{became} A run that ends before the {asked} that the requirement asks for (from its first trigger on, if it has one) may \
             reach none (`corroborate explain finite-trace`)."
        ),
        None => became,
    }
}

/// Trials that earlier looks saw and the present counts do not contain: of several sequences the last is judged, and no error
/// rate holds for a sequence, or a requirement, that was chosen for its outcome. Counts do not tell which of both it was.
fn replaced_trials(study: &Study<'_>, asked: &Asked<'_>) -> Vec<ExcludedTrials> {
    let Some(looks) = study.looks else {
        return Vec::new();
    };
    let of = |piece: &Piece<'_>| {
        let sequences = looks.replaced(&piece.evidence.id, &piece.finding.subject, &piece.belief);
        let trials: u64 = sequences.iter().map(|it| it.trials).sum();
        (trials > 0).then(|| {
            let counts = sequences.iter().map(|it| format!("{}/{}", it.successes, it.trials));
            let counts: Vec<String> = counts.collect();
            ExcludedTrials {
                evidence: piece.evidence.id.clone(),
                trials,
                words: format!(
                    "{}: {} at earlier looks, which the present counts do not contain: trials were replaced, or are judged \
                     otherwise now; if for the outcome, no error rate holds.",
                    piece.evidence.id,
                    list(&counts)
                ),
            }
        })
    };
    asked.pieces.iter().filter_map(of).collect()
}

/// What a piece found on the requirement, or on the one with the same quantity.
fn found<'e>(asked: &Asked<'_>, piece: &'e Evidence) -> Option<&'e Finding> {
    let own = Subject::Requirement(asked.requirement.id.clone());
    piece
        .finding(&own)
        .or_else(|| piece.finding(&asked.quantity))
}

/// Why a piece that is judged does not count on the step that the requirement needs; `None` if it does.
fn below(asked: &Asked<'_>, piece: &Evidence) -> Option<ExclusionReason> {
    let step = Step::of(piece.technique);
    let needs = asked.requirement.needs;
    if step >= needs {
        return None;
    }
    let alone = format!(
        "its figure stands {}, and the requirement needs the step \"{}\"",
        step.words(),
        needs.name()
    );
    let mut carried = asked.transfers.iter();
    let carried = carried.find(|it| it.piece.evidence.id == piece.id);
    match carried.map(|it| &it.anchor) {
        Some(Ok(_)) if needs <= Step::Corroborated => None,
        Some(Err(why)) => Some(ExclusionReason::BelowNeededStep(format!(
            "{alone}; it is declared to carry over and does not, because {why}"
        ))),
        _ => Some(ExclusionReason::BelowNeededStep(alone)),
    }
}

/// Why a piece does not take part; `None` if it was not asked about it.
fn reason(study: &Study<'_>, asked: &Asked<'_>, piece: &Evidence) -> Option<ExclusionReason> {
    let finding = found(asked, piece)?;
    let Some(speaking) = Piece::of(piece, asked.requirement, &asked.quantity) else {
        return Some(silence(finding));
    };
    if !asked.may_decide(&speaking) {
        return Some(ExclusionReason::OneSubject);
    }
    if asked.pieces.iter().any(|it| it.evidence.id == piece.id) {
        let why = dependence(study, asked, piece);
        return Some(ExclusionReason::NotIndependent(why));
    }
    if piece.intermediate {
        return Some(ExclusionReason::Intermediate);
    }
    if let Some(by) = &piece.reproduced_by {
        return Some(ExclusionReason::Reproduced(by.clone()));
    }
    let mut here = asked.pieces.iter();
    let later = here.find(|it| {
        it.evidence.technique == piece.technique && it.evidence.conditions == piece.conditions
    });
    Some(match later {
        Some(later) => ExclusionReason::Superseded(later.evidence.id.clone()),
        None => ExclusionReason::OtherConditions(piece.conditions.clone()),
    })
}

/// Why a finding has nothing that can be judged.
fn silence(finding: &Finding) -> ExclusionReason {
    if let Denominator::OtherTrigger { trigger, monitor } = &finding.denominator {
        return ExclusionReason::NoNumber(format!(
            "it is over the runs with {trigger}, and the requirement's monitor is triggered by {monitor}, which are other \
             runs: write the same in both in requirements.toml"
        ));
    }
    if let Denominator::AllRuns { reason } = &finding.denominator
        && finding.counts_untriggered()
    {
        return ExclusionReason::NoNumber(format!(
            "it counts all attempts, whether or not they trigger the requirement ({}): count those that do, by a row of \
             `tables.requirements` or a column of what triggers it",
            reason.trim_end_matches('.')
        ));
    }
    match &finding.measure {
        Measure::NotExpressible { reason } => ExclusionReason::NotExpressible(reason.clone()),
        Measure::NotCovered { reason, .. } => ExclusionReason::NotCovered(reason.clone()),
        Measure::Counts { trials: 0, .. } => ExclusionReason::NotCovered(String::new()),
        Measure::Probability { .. } => ExclusionReason::NoNumber("its error is unknown".to_owned()),
        Measure::Counts { .. } => {
            ExclusionReason::NoNumber("its counts contradict each other".to_owned())
        }
    }
}

/// On which trials that take part a piece of trials rests.
fn dependence(study: &Study<'_>, asked: &Asked<'_>, piece: &Evidence) -> String {
    let lineage = study.lineage();
    let pairs = asked.pieces.iter().zip(&asked.decides);
    let mut others = pairs.filter(|(it, decides)| **decides && is_trial(it.evidence));
    let found =
        others.find_map(|(it, _)| lineage.dependence(&it.evidence.id, &piece.id, &asked.quantity));
    found.unwrap_or_else(|| "it rests on other trials".to_owned())
}

/// That what is declared to carry over does not, as the piece does not hold under the conditions of the verdict.
fn unused_declaration(
    asked: &Asked<'_>,
    piece: &Evidence,
    reason: &ExclusionReason,
) -> &'static str {
    let mut declared = asked.requirement.carries_over.iter();
    let is_declared = declared.any(|it| it.evidence == piece.id);
    match reason {
        ExclusionReason::OtherConditions(_) if is_declared => {
            " It is declared to carry over, which counts only under the conditions of the verdict: it is not used."
        }
        _ => "",
    }
}

/// The verdict if a piece took part that the study leaves out, at the same share of the level.
fn verdict_with(study: &Study<'_>, asked: &Asked<'_>, level: &Level, index: usize) -> Decided {
    let mut evidence = study.evidence.to_vec();
    evidence[index].intermediate = false;
    evidence[index].reproduced_by = None;
    let other = Study {
        evidence: &evidence,
        ..*study
    };
    let lineage = other.lineage();
    let with = Asked::on_other_evidence(&other, &lineage, asked);
    let level = level.shared_as(asked, &with);
    ladder::decide(&with.judge(&level), &with.apart())
}

fn words(id: &str, reason: &ExclusionReason, one: &str) -> String {
    match reason {
        ExclusionReason::Intermediate => format!("{id} is marked as intermediate."),
        ExclusionReason::Superseded(by) => {
            format!("{id} is superseded by {by}, a later piece of the same technique.")
        }
        ExclusionReason::Reproduced(by) => format!("{id} is reproduced by {by}."),
        ExclusionReason::OtherConditions(conditions) => {
            format!(
                "{id} holds under other conditions ({conditions}) and does not refute it there."
            )
        }
        ExclusionReason::NotIndependent(why) => {
            format!("{id} does not decide beside the other trials: {why}.")
        }
        ExclusionReason::OneSubject => format!(
            "{id} does not decide: all its trials are of {}, and nothing says that this one stands for all. \
             Add trials with others, or say why in ledger.toml: `tables.one_for_all = \"...\"`.",
            one
        ),
        ExclusionReason::NoNumber(why) => format!("{id} has a number, but {why}."),
        ExclusionReason::NotExpressible(why) => because(&format!("{id} cannot express it"), why),
        ExclusionReason::NotCovered(why) => because(&format!("{id} never covered it"), why),
        ExclusionReason::BelowNeededStep(why) => {
            format!("{id} does not count towards what the requirement needs: {why}.")
        }
    }
}

fn because(what: &str, why: &str) -> String {
    match why.trim().trim_end_matches('.') {
        "" => format!("{what}."),
        why => format!("{what}: {why}."),
    }
}
