//! The confidence argument: at each claim point of the safety argument, that
//! the evidence there can be relied on.

use super::node::{Argument, Builder, Kind};
use super::words::{
    among, citation, cited, claim_point, compared, has_known_error, quantity, rests_on,
};
use crate::view::View;
use crate::words::inaccuracy;
use evidence::{Comparison, Evidence, Finding, Outcome, Requirement, Subject, Suspect};

/// The argument.
pub fn argument(view: View) -> Argument {
    let study = view.study;
    let mut builder = Builder::new();
    let text = format!("{}: the evidence can be relied on", study.title);
    let top = builder.add(Kind::Goal, "confidence", text);
    if !study.requirements.is_empty() {
        let text = "Argument over each claim point of the safety argument";
        let strategy = builder.support(top, Kind::Strategy, "claim-points", text);
        for requirement in &study.requirements {
            rely(&mut builder, strategy, view, requirement);
        }
    }
    if !study.failure_modes.is_empty() {
        let text = "Argument over what can go wrong";
        let strategy = builder.support(top, Kind::Strategy, "failure-modes", text);
        for mode in &study.failure_modes {
            let subject = Subject::FailureMode(mode.id.clone());
            let ids = current(view);
            let text = format!("Techniques agree on how often there is: {}", mode.name);
            agree(&mut builder, strategy, view, &subject, &ids, text);
        }
    }
    let brief = format!("Why the evidence of \"{}\" can be relied on.", study.title);
    builder.finish("Confidence", brief)
}

/// Identifiers of the evidence on which any conclusion rests.
fn current(view: View<'_>) -> Vec<&str> {
    let study = view.study;
    let rests = |id: &String| study.conclusions.iter().any(|c| c.rests_on.contains(id));
    let ids = study.evidence.iter().map(|piece| &piece.id);
    ids.filter(|id| rests(id)).map(String::as_str).collect()
}

/// The claim at one claim point.
fn rely(builder: &mut Builder, parent: usize, view: View, requirement: &Requirement) {
    let id = &requirement.id;
    let point = claim_point(requirement);
    let text = format!("{point}: the evidence on requirement {id} can be relied on");
    let goal = builder.support(parent, Kind::Goal, id, text);
    builder.argue(goal, point);
    let pieces = rests_on(view, requirement);
    if pieces.is_empty() {
        return;
    }
    let subject = quantity(view.study, requirement);
    let ids: Vec<&str> = pieces.iter().map(|(piece, _)| piece.id.as_str()).collect();
    let text = "Techniques agree on it, independently".to_owned();
    agree(builder, goal, view, &subject, &ids, text);
    numbers(builder, goal, view, id, &pieces);
    let own = Subject::Requirement(id.clone());
    let touches = |s: &&Suspect| s.subjects.contains(&own) || s.subjects.contains(&subject);
    for suspect in view.study.suspected().iter().filter(touches) {
        doubt(builder, goal, id, suspect, &ids);
    }
}

/// That the pieces agree: shown pair by pair, open, or challenged.
fn agree(
    builder: &mut Builder,
    parent: usize,
    view: View,
    subject: &Subject,
    ids: &[&str],
    text: String,
) {
    let name = format!("{}-agreement", subject.id());
    let goal = builder.support(parent, Kind::Goal, &name, text);
    let pairs = among(view.study, subject, ids);
    for comparison in &pairs {
        pair(builder, goal, &name, comparison);
    }
    if pairs.is_empty() {
        let text = "Another technique covers it. Now: there is nothing to compare.";
        builder.support(goal, Kind::Goal, &format!("{name}-open"), text);
    }
    if let Subject::FailureMode(_) = subject {
        let of_it = |s: &&Suspect| s.subjects.contains(subject);
        for suspect in view.study.suspected().iter().filter(of_it) {
            doubt(builder, goal, &name, suspect, ids);
        }
    }
}

fn pair(builder: &mut Builder, goal: usize, name: &str, comparison: &Comparison) {
    let name = format!("{name}-{}-{}", comparison.left, comparison.right);
    let text = compared(comparison);
    match (comparison.outcome, comparison.independent) {
        (Outcome::Corroborates, true) => {
            builder.support(goal, Kind::Solution, &name, text);
        }
        (Outcome::Conflicts, _) => {
            builder.challenge(goal, &name, text, true);
        }
        _ => {
            let text = format!("Independent agreement is shown. Now: {text}");
            builder.support(goal, Kind::Goal, &name, text);
        }
    }
}

/// That every number comes with its error.
fn numbers(
    builder: &mut Builder,
    parent: usize,
    view: View,
    id: &str,
    pieces: &[(&Evidence, &Finding)],
) {
    let name = format!("{id}-numbers");
    let text = "Every number comes with an error that is known";
    let goal = builder.support(parent, Kind::Goal, &name, text);
    for (piece, finding) in pieces {
        let name = format!("{name}-{}", piece.id);
        let text = cited(view, piece, finding);
        if has_known_error(&finding.measure) {
            let place = builder.support(goal, Kind::Solution, &name, text);
            builder.cite(place, citation(piece));
        } else {
            builder.support(
                goal,
                Kind::Goal,
                &name,
                format!("Its error is known. Now: {text}"),
            );
        }
    }
}

/// A suspect on which evidence in use rests is a reason to doubt it, if what speaks against it is strong; one that later
/// evidence fixes is a doubt defeated.
fn doubt(builder: &mut Builder, goal: usize, name: &str, suspect: &Suspect, ids: &[&str]) {
    let mut resting = suspect.asset.evidence.iter();
    if !suspect.is_strong() || !resting.any(|e| ids.contains(&e.as_str())) {
        return;
    }
    let name = format!("{name}-doubt");
    let kind = inaccuracy(suspect.inaccuracy);
    let text = format!("{} ({kind})", suspect.title);
    let counter = builder.challenge(goal, &name, text, false);
    if let Some(resolved) = &suspect.resolved_by {
        let text = match suspect.differs_from_what_it_replaced() {
            true => format!("It differs only from evidence that {resolved} replaces"),
            false => format!("It is fixed in {resolved}"),
        };
        builder.challenge(counter, &format!("{name}-fixed"), text, true);
    }
}
