//! The five questions that people ask of a study, answered from its result before anything else.
//!
//! # Definition
//! 1. *Does it meet its requirements?* By the verdicts, and the step on which they stand.
//! 2. *Which are not met, and why?* What refutes each, and which failures were counted in the same runs; of conflicts, the first suspect.
//! 3. *How sure is that?* The figures that decided, the study's error rates, and how much of the agreement is independent.
//! 4. *What was not tested?* Requirements without trials of the system that count, and the gaps of coverage.
//! 5. *What is to be done next?* The first open suspects, and the cheapest plan that would decide each open requirement.
//!
//! # Guarantee
//! Nothing is computed here: every figure and every verdict is one that stands elsewhere on the page, where the answer leads.

use crate::number;
use crate::plan;
use crate::view::View;
use crate::words;
use diagnostic::counted;
use evidence::{
    Comparison, Conclusion, Evidence, Measure, Standing, Step, StudyResult, Subject, Verdict,
};

/// Causes that are named of one requirement.
const CAUSES: usize = 3;
/// Lines of one answer; the rest are counted.
const LINES: usize = 6;
/// Letters of a requirement's text that are shown.
const ASKED: usize = 90;

/// A part of a sentence: text, or text that leads to an anchor of the page.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Part {
    /// Text.
    Text(String),
    /// An anchor without `#`, and its text.
    Link(String, String),
}

/// One question with its answer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Answer {
    /// The question.
    pub question: &'static str,
    /// The answer in a word or a short sentence.
    pub short: String,
    /// What it rests on, a sentence each.
    pub lines: Vec<Vec<Part>>,
}

fn text(words: impl Into<String>) -> Part {
    Part::Text(words.into())
}

/// The answers, in the order of the questions.
pub fn answers(view: View) -> [Answer; 5] {
    [
        met(view),
        not_met(view),
        sure(view),
        untested(view),
        next(view),
    ]
}

fn requirement(view: View, id: &str) -> Part {
    match view.requirement_anchor(id) {
        Some(anchor) => Part::Link(anchor, id.to_owned()),
        None => text(id),
    }
}

fn piece(view: View, id: &str) -> Part {
    match view.anchor(id) {
        Some(anchor) => Part::Link(anchor, id.to_owned()),
        None => text(id),
    }
}

/// The conclusions with one of these verdicts.
fn with<'a>(study: &'a StudyResult, wanted: &'a [Verdict]) -> impl Iterator<Item = &'a Conclusion> {
    let all = study.conclusions.iter();
    all.filter(|it| wanted.contains(&it.verdict))
}

/// Identifiers in a sentence: `1, 2 and 7`.
fn ids<'a>(all: impl Iterator<Item = &'a Conclusion>) -> String {
    let all: Vec<&str> = all.map(|it| it.requirement.as_str()).collect();
    match all.as_slice() {
        [rest @ .., last] if !rest.is_empty() => format!("{} and {last}", rest.join(", ")),
        _ => all.concat(),
    }
}

fn met(view: View) -> Answer {
    let study = view.study;
    let count = study.conclusions.len();
    let of = |wanted: &'static [Verdict]| with(study, wanted);
    let is_of_system = |it: &&Conclusion| it.step.is_none_or(|step| step >= Step::Corroborated);
    let refuted = ids(of(&[Verdict::Violated]).filter(is_of_system));
    let by_models = ids(of(&[Verdict::Violated]).filter(|it| !is_of_system(it)));
    let conflicting = ids(of(&[Verdict::Conflicting]));
    let all = match count {
        1 => "its requirement".to_owned(),
        count => format!("all {count} requirements"),
    };
    let is_enough = study.conclusions.iter().all(Conclusion::is_enough);
    let short = match (refuted.is_empty(), conflicting.is_empty()) {
        _ if count == 0 => "Nothing is required, or nothing has run yet.".to_owned(),
        (false, _) if by_models.is_empty() => format!("No: {refuted} not satisfied."),
        (false, _) => {
            format!("No: {refuted} not satisfied; nor, by models or simulators alone, {by_models}.")
        }
        (true, _) if !by_models.is_empty() => format!(
            "Not by its models: {by_models} not satisfied, which no trials of the system decide."
        ),
        (true, false) => format!("Not known: evidence conflicts on {conflicting}."),
        _ if is_enough && !study.open_conflicts().is_empty() => {
            format!("Yes by its verdicts, {all}, but pieces of evidence conflict.")
        }
        _ if is_enough && !study.differences_of_one().is_empty() => format!(
            "Yes by its verdicts, {all}, but one person, session or cluster differs from the other evidence."
        ),
        _ if is_enough => format!("Yes, {all}, on the step that each needs."),
        _ => {
            let open = study.conclusions.iter().filter(|it| !it.is_enough());
            format!("Not shown yet: {} left open.", ids(open))
        }
    };
    let lines = words::tally(study).into_iter().map(|(mark, own)| {
        let mut line = vec![text(format!("{} {}: ", mark.symbol, capital(&mark.word)))];
        for (place, id) in own.iter().enumerate() {
            if place > 0 {
                line.push(text(", "));
            }
            line.push(requirement(view, id));
        }
        line.push(text("."));
        line
    });
    Answer {
        question: "Does it meet its requirements?",
        short,
        lines: lines.collect(),
    }
}

fn capital(words: &str) -> String {
    let mut letters = words.chars();
    let first = letters.next().map(|it| it.to_uppercase().to_string());
    first.unwrap_or_default() + letters.as_str()
}

fn not_met(view: View) -> Answer {
    let study = view.study;
    let mut lines = Vec::new();
    let mut beside: Vec<Vec<Part>> = Vec::new();
    for conclusion in with(study, &[Verdict::Violated]) {
        let denying = || {
            let all = conclusion.standings.iter();
            all.filter(|it| it.standing == Standing::Denies)
        };
        let figures: Vec<&str> = denying().map(|it| it.words.as_str()).collect();
        let words = match figures.as_slice() {
            [] => conclusion.statement.clone(),
            all => format!("{}.", all.join("; ")),
        };
        lines.push(vec![
            requirement(view, &conclusion.requirement),
            text(format!("{}: {words}", asked(view, &conclusion.requirement))),
        ]);
        // Of the strongest step, the last counted.
        let most = denying().max_by_key(|it| it.step);
        let refuting =
            most.and_then(|most| study.evidence.iter().find(|it| it.id == most.evidence));
        if let Some(evidence) = refuting {
            // Of one piece the same for each that it refutes.
            let causes = causes(view, evidence);
            beside.extend(causes.filter(|it| !beside.contains(it)));
        }
    }
    lines.extend(beside);
    for conflict in study.open_conflicts() {
        let mut line = match conflict.is_with_the_impossible() {
            true => vec![text(format!(
                "On {}: {}",
                view.short_title(&conflict.subject),
                conflict.reason
            ))],
            false => of_pair(view, conflict, |on, points| {
                format!("conflict on {on}: they differ by {points} points.")
            }),
        };
        let mut suspects = study.suspected().iter();
        let suspect = suspects.find(|it| it.is_open() && it.subjects.contains(&conflict.subject));
        if let Some(suspect) = suspect {
            line.push(text(" Suspected first: "));
            let anchor = format!("suspect-{}", suspect.rank);
            line.push(Part::Link(anchor, suspect.title.clone()));
            line.push(text("."));
        }
        lines.push(line);
    }
    let of_one = study.differences_of_one();
    lines.extend(of_one.into_iter().map(|pair| {
        of_pair(view, pair, |on, points| {
            format!("differ on {on} by {points} points, which is said of one alone.")
        })
    }));
    let refuted = with(study, &[Verdict::Violated]).count();
    Answer {
        question: "Which are not met, and why?",
        short: match (refuted, lines.is_empty()) {
            (0, true) => "None is shown not to be met, and nothing conflicts.".to_owned(),
            (0, false) if study.open_conflicts().is_empty() => {
                "None is shown not to be met, but one person, session or cluster differs."
                    .to_owned()
            }
            (0, false) => "None is shown not to be met, but evidence conflicts.".to_owned(),
            (1, _) => "One is shown not to be met.".to_owned(),
            (many, _) => format!("{many} are shown not to be met."),
        },
        lines: shortened(lines, "verdict"),
    }
}

/// Both sides of a pair, and what is said of them with the subject and the difference in points.
fn of_pair(view: View, pair: &Comparison, say: impl Fn(&str, &str) -> String) -> Vec<Part> {
    let on = view.short_title(&pair.subject);
    let points = number::decimal(100.0 * pair.difference.unwrap_or(0.0).abs(), 1);
    vec![
        piece(view, &pair.left),
        text(" and "),
        piece(view, &pair.right),
        text(format!(" {}", say(&on, &points))),
    ]
}

/// What is asked for, as far as a line has room for it.
fn asked(view: View, id: &str) -> String {
    let Some(requirement) = view.requirement(id) else {
        return String::new();
    };
    let mut words = String::new();
    for word in requirement.text.split_whitespace() {
        if !words.is_empty() {
            words.push(' ');
        }
        let room = ASKED.saturating_sub(words.chars().count());
        if word.chars().count() > room {
            // A long word alone is cut.
            words.extend(word.chars().take(if words.is_empty() { room } else { 0 }));
            words.push('…');
            break;
        }
        words.push_str(word);
    }
    format!(" (\"{words}\")")
}

/// Which failures a piece of evidence has, the most frequent first: they stand beside a violation, and are not shown to be its cause.
fn causes(view: View, evidence: &Evidence) -> Option<Vec<Part>> {
    let mut rates: Vec<(f64, String)> = evidence
        .findings
        .iter()
        .filter(|it| matches!(it.subject, Subject::FailureMode(_)))
        .filter_map(|it| {
            let rate = it.measure.estimate().filter(|rate| *rate > 0.0)?;
            let figure = match &it.measure {
                Measure::Counts { count, trials, .. } => {
                    format!("{} of {}", number::count(*count), number::count(*trials))
                }
                _ => number::percent(rate),
            };
            Some((rate, format!("{} {figure}", view.short_title(&it.subject))))
        })
        .collect();
    rates.sort_by(|one, other| other.0.total_cmp(&one.0));
    let all = rates.len();
    let words: Vec<String> = rates
        .into_iter()
        .take(CAUSES)
        .map(|(_, words)| words)
        .collect();
    if words.is_empty() {
        return None;
    }
    let more = match all - words.len() {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    Some(vec![
        text("In "),
        piece(view, &evidence.id),
        text(format!(
            " these failures occur: {}{more}; what stands beside a violation is not shown to cause it.",
            words.join(", ")
        )),
    ])
}

fn sure(view: View) -> Answer {
    let study = view.study;
    let mut lines = Vec::new();
    for conclusion in with(study, &[Verdict::Satisfied, Verdict::Violated]) {
        let shown = match conclusion.verdict {
            Verdict::Satisfied => Standing::Supports,
            _ => Standing::Denies,
        };
        let mut standings = conclusion.standings.iter();
        let deciding = standings
            .find(|it| it.standing == shown && Some(it.step) == conclusion.step && !it.elsewhere);
        if let Some(standing) = deciding {
            lines.push(vec![
                requirement(view, &conclusion.requirement),
                text(format!(": {}.", standing.words)),
            ]);
        }
    }
    let of_system = |it: &&Conclusion| it.step >= Some(Step::Corroborated);
    let decided = with(study, &[Verdict::Satisfied, Verdict::Violated]).count();
    let by_system = with(study, &[Verdict::Satisfied, Verdict::Violated])
        .filter(of_system)
        .count();
    let carried = with(study, &[Verdict::Satisfied, Verdict::Violated]);
    let carried = carried
        .filter(|it| it.step == Some(Step::Corroborated))
        .count();
    let all = study.conclusions.len();
    let short = match (decided, by_system) {
        (0, _) => "Nothing is decided.".to_owned(),
        (decided, 0) => format!(
            "{decided} of {all} decided, for models and simulators alone: nothing is decided of the system."
        ),
        (decided, by_system) => {
            let trials = by_system - carried;
            let by = match (trials, carried) {
                (trials, 0) => format!("{trials} by trials of the system"),
                (0, carried) => format!("{carried} by models that carry over to the system"),
                _ => format!(
                    "{trials} by trials of the system, {carried} by models that carry over to it"
                ),
            };
            match decided == by_system {
                true => format!("{decided} of {all} decided, {by}."),
                false => format!(
                    "{decided} of {all} decided, {by}, the others for models and simulators alone."
                ),
            }
        }
    };
    let mut lines = shortened(lines, "verdict");
    lines.extend(words::error_rates(study).map(|words| vec![text(words)]));
    Answer {
        question: "How sure is that?",
        short,
        lines,
    }
}

fn untested(view: View) -> Answer {
    let study = view.study;
    let mut lines = Vec::new();
    let uncovered = ids(with(study, &[Verdict::NotCovered]));
    if !uncovered.is_empty() {
        lines.push(vec![text(format!(
            "No evidence that takes part covers {uncovered}."
        ))]);
    }
    let has_trials = |it: &&Conclusion| {
        let mut standings = it.standings.iter();
        standings.any(|one| one.step == Step::System && !one.elsewhere)
    };
    let covered = study
        .conclusions
        .iter()
        .filter(|it| it.verdict != Verdict::NotCovered);
    let untried = ids(covered.filter(|it| !has_trials(it)));
    if !untried.is_empty() {
        lines.push(vec![text(format!(
            "No trials of the system speak of {untried}."
        ))]);
    }
    let gaps = study.gaps.iter().map(|gap| {
        let whose = match gap.evidence.as_slice() {
            [] => "in any evidence".to_owned(),
            all => format!("in {}", all.join(", ")),
        };
        vec![text(format!(
            "{}, {whose}: {}",
            view.title(&gap.subject),
            gap.reason
        ))]
    });
    lines.extend(gaps);
    Answer {
        question: "What was not tested?",
        short: match (uncovered.is_empty() && untried.is_empty(), study.gaps.len()) {
            (true, 0) => "No gap was found in what was asked for.".to_owned(),
            (true, 1) => "One gap was found.".to_owned(),
            (true, many) => format!("{many} gaps were found."),
            (false, 0) => "Not every requirement, on the system.".to_owned(),
            (false, many) => format!(
                "Not every requirement, on the system; {} found.",
                counted(many, "gap")
            ),
        },
        lines: shortened(lines, "coverage"),
    }
}

fn next(view: View) -> Answer {
    let study = view.study;
    let synthesis = &study.synthesis;
    let mut lines = Vec::new();
    let open = study
        .suspected()
        .iter()
        .filter(|it| it.is_open() && it.is_strong());
    for suspect in open.take(CAUSES) {
        let place = suspect.asset.place_in_words();
        let at = match place.is_empty() {
            true => String::new(),
            false => format!(" ({place})"),
        };
        lines.push(vec![
            text("Look at "),
            Part::Link(format!("suspect-{}", suspect.rank), suspect.title.clone()),
            text(format!(
                "{at}. `corroborate refine` shows what is offered against it."
            )),
        ]);
    }
    let suspects = lines.len();
    for conclusion in study.conclusions.iter().filter(|it| it.is_open()) {
        let mut plans = synthesis.deciding.iter();
        let plan = plans.find(|it| it.requirement == conclusion.requirement && it.trials.is_some());
        let mut reasons = synthesis.not_planned.iter();
        let reason = reasons.find(|it| it.requirement == conclusion.requirement);
        let words = match (plan, reason) {
            (Some(plan), _) => format!(": {}.", plan::deciding(plan, &synthesis.costs)),
            (None, Some(reason)) => format!(": {}", reason.reason),
            (None, None) => continue,
        };
        lines.push(vec![
            requirement(view, &conclusion.requirement),
            text(words),
        ]);
    }
    let plans = lines.len() - suspects;
    let refuted = ids(with(study, &[Verdict::Violated]));
    if !refuted.is_empty() {
        lines.push(vec![text(format!(
            "Of {refuted}: mend what makes it fail, or what is asked of it."
        ))]);
    }
    let uncovered = ids(with(study, &[Verdict::NotCovered]));
    if !uncovered.is_empty() {
        lines.push(vec![text(format!(
            "Gather evidence that covers {uncovered}."
        ))]);
    }
    if !study.differences_of_one().is_empty() {
        lines.push(vec![text(
            "Try more people or sessions: whether the one that differs is one of a kind is not known.",
        )]);
    }
    let pairs = synthesis.programme.as_ref();
    let pairs = pairs.map(|it| plan::programme(it, &synthesis.costs));
    if let Some(words) = pairs.filter(|it| !it.is_empty()) {
        lines.push(vec![text(format!("Whether techniques agree: {words}"))]);
    }
    Answer {
        question: "What is to be done next?",
        short: match (suspects, plans) {
            (0, 0) if lines.is_empty() => "Nothing is open.".to_owned(),
            (0, 0) => "What follows is open.".to_owned(),
            (0, _) => "Gather what decides the open requirements.".to_owned(),
            (_, 0) => "Find out why evidence differs.".to_owned(),
            _ => "Find out why evidence differs, then decide what is open.".to_owned(),
        },
        lines: shortened(lines, if suspects > 0 { "suspects" } else { "further" }),
    }
}

/// The first lines, and how many more there are where.
fn shortened(mut lines: Vec<Vec<Part>>, anchor: &str) -> Vec<Vec<Part>> {
    if lines.len() > LINES + 1 {
        let more = lines.len() - LINES;
        lines.truncate(LINES);
        lines.push(vec![Part::Link(
            anchor.to_owned(),
            format!("and {more} more"),
        )]);
    }
    lines
}
