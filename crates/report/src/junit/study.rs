//! A study as test cases: one for each requirement.

use super::{Case, End, Said, Suite};
use crate::view::View;
use crate::{number, words};
use evidence::{
    Comparison, Conclusion, Direction, Evidence, Interval, Measure, Requirement, StudyResult,
    Subject, Verdict,
};

/// A suite with a case for each requirement, and one for each failure mode of which evidence conflicts.
///
/// A requirement that is satisfied on a step that is not enough for it is skipped, like one that is undecided or not covered; one that is
/// violated, or of which current evidence conflicts (whatever its verdict is), failed, as the exit code has it. The properties `rate`, `interval` and `guarantee` are those of the piece of
/// evidence on the highest step; each piece has its own beside them, under its identifier.
#[must_use]
pub fn of_study(study: &StudyResult) -> Vec<Suite> {
    let view = View { study };
    let cases = study.requirements.iter().map(|it| case(&view, it));
    let modes = failure_modes(study);
    vec![Suite {
        name: study.title.clone(),
        cases: cases.chain(modes).collect(),
    }]
}

fn case(view: &View<'_>, requirement: &Requirement) -> Case {
    let conclusion = view.conclusion(&requirement.id);
    let mut properties = vec![
        ("verifies".to_owned(), requirement.id.clone()),
        ("text".to_owned(), requirement.text.clone()),
        ("required".to_owned(), required(requirement)),
    ];
    if let Some(conclusion) = conclusion {
        properties.extend(concluded(view, requirement, conclusion));
    }
    Case {
        class: view.study.title.clone(),
        name: requirement.id.clone(),
        file: None,
        secs: None,
        properties,
        end: end(
            conclusion,
            &conflicts(view.study, &Subject::Requirement(requirement.id.clone())),
        ),
    }
}

/// The open conflicts of a requirement or failure mode, in words.
fn conflicts(study: &StudyResult, subject: &Subject) -> Vec<String> {
    let open = study.open_conflicts().into_iter();
    let own = open.filter(|it| it.subject == *subject);
    own.map(Comparison::conflict_in_words).collect()
}

/// No requirement says that evidence conflicts on a failure mode.
fn failure_modes(study: &StudyResult) -> Vec<Case> {
    let mut subjects: Vec<&Subject> = Vec::new();
    for open in study.open_conflicts() {
        let is_mode = matches!(open.subject, Subject::FailureMode(_));
        if is_mode && !subjects.contains(&&open.subject) {
            subjects.push(&open.subject);
        }
    }
    let cases = subjects.into_iter().map(|subject| Case {
        class: study.title.clone(),
        name: format!("failure mode: {}", subject.in_words()),
        file: None,
        secs: None,
        properties: Vec::new(),
        end: End::Failed(conflict(&conflicts(study, subject), String::new())),
    });
    cases.collect()
}

fn conflict(conflicts: &[String], text: String) -> Said {
    Said {
        kind: "evidence conflicts".to_owned(),
        message: conflicts.join(" "),
        text,
    }
}

fn required(requirement: &Requirement) -> String {
    match requirement.threshold {
        None => "certainty".to_owned(),
        Some(threshold) => {
            let side = match threshold.direction {
                Direction::AtLeast => "at least",
                Direction::AtMost => "at most",
            };
            format!("{side} {}", number::level(threshold.value))
        }
    }
}

fn concluded(
    view: &View<'_>,
    requirement: &Requirement,
    conclusion: &Conclusion,
) -> Vec<(String, String)> {
    let subject = view.quantity(requirement);
    let mut pieces: Vec<(&Evidence, &Measure)> = Vec::new();
    let mut standings: Vec<_> = conclusion.standings.iter().collect();
    standings.sort_by_key(|it| std::cmp::Reverse(it.step));
    for standing in standings {
        let piece = view.study.evidence.iter();
        let piece = piece.filter(|it| it.id == standing.evidence);
        for piece in piece {
            let is_new = pieces.iter().all(|(known, _)| known.id != piece.id);
            if let Some(finding) = piece.finding(&subject).filter(|_| is_new) {
                pieces.push((piece, &finding.measure));
            }
        }
    }
    let mut properties = vec![
        ("outcome".to_owned(), words::concluded(conclusion).word),
        ("statement".to_owned(), conclusion.statement.clone()),
        (
            "error-rate".to_owned(),
            format!("{}", conclusion.error_rate.level),
        ),
    ];
    let first = pieces
        .first()
        .map(|(_, measure)| figures("", measure, view.study.confidence));
    properties.extend(first.into_iter().flatten());
    for (piece, measure) in &pieces {
        properties.extend(figures(
            &format!(" {}", piece.id),
            measure,
            view.study.confidence,
        ));
    }
    properties
}

/// Rate, interval and guarantee of a number.
fn figures(of: &str, measure: &Measure, confidence: f64) -> Vec<(String, String)> {
    let mut figures = Vec::new();
    let mut push = |name: &str, value: String| figures.push((format!("{name}{of}"), value));
    if let Some(rate) = measure.estimate() {
        push("rate", format!("{rate}"));
    }
    if let Measure::Counts { count, trials, .. } = measure {
        push("trials", format!("{count}/{trials}"));
    }
    if let Some(Interval { low, high }) = measure.interval() {
        push("interval", format!("{low} to {high}"));
    }
    push("guarantee", guarantee(measure, confidence));
    figures
}

fn guarantee(measure: &Measure, confidence: f64) -> String {
    match measure {
        Measure::Counts { .. } => {
            format!("statistical: two-sided at {}", number::level(confidence))
        }
        Measure::Probability { answer, .. } => number::guarantee(&answer.guarantee),
        Measure::NotExpressible { reason } | Measure::NotCovered { reason, .. } => reason.clone(),
    }
}

fn end(conclusion: Option<&Conclusion>, conflicts: &[String]) -> End {
    let Some(conclusion) = conclusion else {
        return End::Skipped("not covered by any evidence".to_owned());
    };
    let word = words::concluded(conclusion).word;
    let said = || Said {
        kind: word.clone(),
        message: conclusion.statement.clone(),
        text: standings(conclusion),
    };
    match conclusion.verdict {
        Verdict::Violated | Verdict::Conflicting => End::Failed(said()),
        _ if !conflicts.is_empty() => {
            let text = [conclusion.statement.clone(), standings(conclusion)].join("\n");
            End::Failed(conflict(conflicts, text))
        }
        Verdict::Satisfied if conclusion.is_enough() => End::Passed,
        Verdict::Satisfied | Verdict::Undecided | Verdict::NotCovered => {
            End::Skipped(format!("{word}: {}", conclusion.statement))
        }
    }
}

fn standings(conclusion: &Conclusion) -> String {
    let lines = conclusion.standings.iter().map(|it| it.words.as_str());
    lines.collect::<Vec<_>>().join("\n")
}
