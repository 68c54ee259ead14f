//! What a pack does not show, made of the study's own verdicts and of what the pack lacks.
//!
//! # Definition
//! For each requirement: that it is open, conflicting, covered by no evidence, or satisfied on a step below the system; what of
//! its evidence was left out, with the reason. For the study: open conflicts, declared conditions without evidence, what evidence does not cover,
//! runs without a verdict, open questions of lineage, evidence that was only read. Of the pack: what it lacks, what was not derived
//! again, and what no pack of this kind can show.
//!
//! Guarantee: every requirement whose verdict is not "satisfied, of the system" or "violated" is named. The list is not
//! complete in any other sense: nobody can list what was not thought of.
//!
//! # Assumes
//! The verdicts follow from the evidence, which is verified before.

use super::parts::Gathering;
use super::renewed::listed;
use ::pack::{NotShown, Recording};
use diagnostic::counted;
use evidence::{Conclusion, Step, StudyResult, Verdict};
use study::Study;

/// What the pack does not show: of requirements first, then of evidence, then of the pack.
pub(super) fn of(
    from: &Gathering<'_>,
    recordings: &[Recording],
    lacks: Vec<NotShown>,
) -> Vec<NotShown> {
    let mut all: Vec<NotShown> = from
        .result
        .conclusions
        .iter()
        .flat_map(requirement)
        .collect();
    all.extend(conflicts(from.result));
    all.extend(conditions(from.study, from.result));
    all.extend(gaps(from.result));
    all.extend(from.result.evidence.iter().flat_map(evidence));
    all.extend(lacks);
    all.extend(of_recordings(recordings));
    let say = |words: String| says("the pack", words);
    if !from.is_signed {
        all.push(say(
            "Who made it: the pack is not signed (`--key FILE`).".into()
        ));
    }
    let again = from.verified.not_checked.iter();
    all.extend(again.map(|what| say(format!("Not derived again before packing: {what}."))));
    all.push(say(BEYOND.into()));
    all
}

/// What no pack shows.
const BEYOND: &str = "That the requirements are the right ones and all that are needed, that the strategy is sufficient, and that \
     the system is safe: these are judgements of people. Of SACE's artefacts the pack has those of verification that are named in it, and no \
     operational domain model, safe operating concept or design.";

fn says(of: impl Into<String>, words: impl Into<String>) -> NotShown {
    NotShown {
        of: of.into(),
        words: words.into(),
    }
}

fn requirement(conclusion: &Conclusion) -> Vec<NotShown> {
    let of = format!("requirement {}", conclusion.requirement);
    let statement = &conclusion.statement;
    let verdict = match (conclusion.verdict, conclusion.step) {
        (Verdict::NotCovered, _) => Some("Whether it holds: no evidence covers it.".to_owned()),
        (Verdict::Undecided, _) => Some(format!("Whether it holds: undecided. {statement}")),
        (Verdict::Conflicting, _) => {
            Some(format!("Whether it holds: evidence conflicts. {statement}"))
        }
        (Verdict::Satisfied, step) if !conclusion.is_enough() => Some(format!(
            "That it holds of what it has to: it is satisfied {}, and needs to be {}.",
            step.map_or("on no step", Step::words),
            conclusion.needs.words()
        )),
        (Verdict::Satisfied | Verdict::Violated, Some(step)) if step < Step::System => {
            Some(format!(
                "What trials of the system would show: it is {} {}.",
                conclusion.verdict.words(),
                step.words()
            ))
        }
        (Verdict::Satisfied | Verdict::Violated, _) => None,
    };
    let left_out = conclusion
        .left_out()
        .map(|words| format!("Left out of the verdict: {words}"));
    let fitted = conclusion.fitted_agreement.iter();
    let fitted =
        fitted.map(|words| format!("Independent agreement: this one is a fit only. {words}"));
    let words = verdict.into_iter().chain(left_out).chain(fitted);
    words.map(|words| says(&of, words)).collect()
}

/// Conflicts that are open, whatever the verdict says.
fn conflicts(result: &StudyResult) -> Vec<NotShown> {
    let open = result.open_conflicts().into_iter();
    open.map(|it| {
        let words = format!(
            "Which of two pieces of evidence is right: {}",
            it.conflict_in_words()
        );
        says(it.subject.in_words(), words)
    })
    .collect()
}

/// Conditions that the study declares, and under which nothing was done.
fn conditions(study: &Study, result: &StudyResult) -> Vec<NotShown> {
    let is_met = |name: &String| {
        let mut entries = study.ledger.iter().filter(|it| it.conditions == *name);
        entries.any(|entry| result.evidence.iter().any(|it| it.id == entry.id))
    };
    let declared = study.about.conditions.iter();
    let untested = declared.filter(|(name, _)| !is_met(name));
    untested
        .map(|(name, meaning)| {
            says(
                format!("conditions `{name}`"),
                format!("Anything: no evidence is of these conditions ({meaning})."),
            )
        })
        .collect()
}

fn gaps(result: &StudyResult) -> Vec<NotShown> {
    let gaps = result.gaps.iter();
    gaps.map(|gap| {
        let by = match gap.evidence.is_empty() {
            true => String::new(),
            false => format!(" ({})", gap.evidence.join(", ")),
        };
        says(
            gap.subject.in_words(),
            format!("Not covered: {}{by}", gap.reason),
        )
    })
    .collect()
}

fn evidence(piece: &evidence::Evidence) -> Vec<NotShown> {
    let mut words = Vec::new();
    for finding in piece.findings.iter().filter(|it| it.undecided > 0) {
        words.push(format!(
            "What became of {} without a verdict on {}.",
            counted(finding.undecided as usize, "run"),
            finding.subject.in_words()
        ));
    }
    let open = piece.lineage_questions.iter().filter(|it| it.is_open());
    words.extend(open.map(|it| format!("That it is independent of {}: {}", it.with, it.finding)));
    if piece.published {
        words.push(
            "How its numbers came about: they were published by others, and only read.".into(),
        );
    }
    if piece.is_of_one_subject() {
        words.push("How other people or sessions would fare: all its trials are of one.".into());
    }
    words.extend(piece.failures.iter().filter_map(|it| {
        let share = it.measure.estimate().filter(|it| *it > 0.0)?;
        Some(format!(
            "How its episodes would have gone on that ended early ({}): {share} of them.",
            it.kind
        ))
    }));
    if !piece.description_gaps.is_empty() {
        words.push(format!(
            "What was not simulated as it is described: {}, listed in the report.",
            counted(piece.description_gaps.len(), "part of a description")
        ));
    }
    words
        .into_iter()
        .map(|it| says(format!("evidence {}", piece.id), it))
        .collect()
}

fn of_recordings(recordings: &[Recording]) -> Option<NotShown> {
    let left_out: Vec<&Recording> = recordings.iter().filter(|it| it.part.is_none()).collect();
    let (count, bytes) = (
        left_out.len(),
        left_out.iter().map(|it| it.bytes).sum::<u64>(),
    );
    let names: Vec<&str> = left_out.iter().map(|it| it.path.as_str()).collect();
    let words = format!(
        "The recordings themselves: {} of {bytes} bytes in all {} named by SHA-256 and not in the pack (`--with-recordings` puts them in). \
         What rests on them is derived again only where they are put back at their paths; without them `corroborate verify` of study/results \
         ends with faults. They are: {}.",
        counted(count, "file"),
        if count == 1 { "is" } else { "are" },
        listed(&names)
    );
    (count > 0).then(|| says("the pack", words))
}
