//! The safety argument: every requirement, supported by the evidence on which
//! its conclusion rests, and challenged by the evidence that denies it.

use super::node::{Argument, Builder, Kind};
use super::words::{among, citation, cited, claim, claim_point, compared, quantity, rests_on};
use crate::plan;
use crate::view::View;
use crate::words;
use evidence::{
    Conclusion, Evidence, Finding, Measure, Outcome, Requirement, Standing, Step, Verdict,
};

/// The argument.
pub fn argument(view: View) -> Argument {
    let study = view.study;
    let mut builder = Builder::new();
    let top = builder.add(
        Kind::Goal,
        "study",
        format!("{}: every requirement holds", study.title),
    );
    surroundings(&mut builder, top, view);
    if !study.requirements.is_empty() {
        let text = "Argument over each requirement".to_owned();
        let strategy = builder.support(top, Kind::Strategy, "requirements", text);
        for requirement in &study.requirements {
            let goal = builder.support(strategy, Kind::Goal, &requirement.id, claim(requirement));
            develop(&mut builder, goal, view, requirement);
        }
    }
    defeat(&mut builder, top, view);
    let brief = format!("Whether the requirements of \"{}\" hold.", study.title);
    builder.finish("Requirements", brief)
}

/// Under which conditions and at which level all of it is said.
fn surroundings(builder: &mut Builder, top: usize, view: View) {
    let study = view.study;
    let level = format!("Intervals are {}", words::intervals(study));
    builder.context(top, Kind::Context, "level", level);
    let mut conditions: Vec<&str> = Vec::new();
    let current = |piece: &&Evidence| {
        let mut conclusions = study.conclusions.iter();
        conclusions.any(|c| c.rests_on.contains(&piece.id))
    };
    for piece in study.evidence.iter().filter(current) {
        if !conditions.contains(&piece.conditions.as_str()) {
            conditions.push(&piece.conditions);
        }
    }
    for text in conditions {
        builder.context(top, Kind::Context, "conditions", text);
    }
}

/// What becomes of the whole claim where requirements are not shown.
fn defeat(builder: &mut Builder, top: usize, view: View) {
    let ids = |wanted: &[Verdict]| -> Vec<&str> {
        let conclusions = view.study.conclusions.iter();
        conclusions
            .filter(|c| wanted.contains(&c.verdict))
            .map(|c| c.requirement.as_str())
            .collect()
    };
    let violated = ids(&[Verdict::Violated]);
    if !violated.is_empty() {
        let text = format!("Shown not to hold: requirement {}", violated.join(", "));
        builder.challenge(top, "violated", text, true);
    }
    let mut open = ids(&[
        Verdict::Conflicting,
        Verdict::Undecided,
        Verdict::NotCovered,
    ]);
    let conclusions = view.study.conclusions.iter();
    let below = conclusions.filter(|c| c.verdict == Verdict::Satisfied && is_below(c));
    open.extend(below.map(|c| c.requirement.as_str()));
    if !open.is_empty() {
        let text = format!("Not shown to hold: requirement {}", open.join(", "));
        builder.challenge(top, "not-shown", text, false);
    }
}

/// What stands below a requirement's goal.
fn develop(builder: &mut Builder, goal: usize, view: View, requirement: &Requirement) {
    let mut conclusions = view.study.conclusions.iter();
    let conclusion = conclusions.find(|c| c.requirement == requirement.id);
    let name = &requirement.id;
    if let Some(conclusion) = conclusion {
        let text = format!("Concluded: {}", conclusion.statement);
        builder.context(goal, Kind::Context, name, text);
        left_out(builder, goal, conclusion);
    }
    together(builder, goal, view, name);
    let pieces = rests_on(view, requirement);
    let verdict = conclusion.map_or(Verdict::NotCovered, |c| c.verdict);
    let (against, supporting): (Vec<_>, Vec<_>) = pieces
        .iter()
        .copied()
        .partition(|(piece, finding)| speaks_against(view, requirement, piece, &finding.measure));
    let holes = holes(view, requirement, conclusion);
    let is_bare = supporting.is_empty() && holes.is_empty();
    if !is_bare {
        let text = "Argument over the latest evidence of each technique";
        let strategy = builder.support(goal, Kind::Strategy, name, text);
        builder.claim_point(goal, strategy, claim_point(requirement));
        for of in supporting {
            solution(builder, strategy, Kind::Solution, name, view, of);
        }
        for hole in holes {
            builder.support(strategy, Kind::Goal, &format!("{name}-open"), hole);
        }
    }
    if is_bare && !against.is_empty() {
        // Nothing supports the claim, but what denies it is to be relied on, too.
        builder.claim_point(goal, goal, claim_point(requirement));
    }
    deny(builder, goal, view, requirement, (verdict, &against));
    conflicts(builder, goal, view, requirement, &pieces);
}

/// What has a number on the requirement and takes no part in what is concluded of it, each with its reason: trials under other conditions, above
/// all. Who reads the argument alone would not know of them.
fn left_out(builder: &mut Builder, goal: usize, conclusion: &Conclusion) {
    let excluded = conclusion.excluded.iter();
    let spoken = excluded.filter(|it| !it.reason.is_silence());
    let words: Vec<&str> = spoken.map(|it| it.words.as_str()).collect();
    if !words.is_empty() {
        let name = format!("{}-left-out", conclusion.requirement);
        let text = format!("Left out: {}", words.join(" "));
        builder.context(goal, Kind::Context, &name, text);
    }
}

/// What the evidence supports together: combined, and all of it at once.
fn together(builder: &mut Builder, goal: usize, view: View, name: &str) {
    let Some(combined) = view.combined(name) else {
        return;
    };
    if combined.interval.is_some() {
        let text = format!("Combined: {}", combined.statement);
        builder.context(goal, Kind::Context, &format!("{name}-combined"), text);
    }
    if let Some(common) = combined.common.as_ref().filter(|c| c.pieces.len() > 1) {
        let text = format!("Common ground: {}", common.statement);
        builder.context(goal, Kind::Context, &format!("{name}-common"), text);
    }
}

/// Whether a finding is evidence against the requirement: the conclusion's test denies it, or decides nothing and leans
/// against it. What no conclusion judged is read as in the forest plot.
fn speaks_against(
    view: View,
    requirement: &Requirement,
    piece: &Evidence,
    measure: &Measure,
) -> bool {
    match view.standing(requirement, &piece.id) {
        Some(it) => match it.standing {
            Standing::Denies => true,
            Standing::Supports => false,
            Standing::Neither => it.p_met < it.p_not_met,
        },
        None => {
            let satisfied = view.conclusion(&requirement.id);
            let satisfied = satisfied.is_some_and(|c| c.verdict == Verdict::Satisfied);
            !satisfied && words::reading(requirement, measure).tone == "bad"
        }
    }
}

/// Whether a requirement is satisfied on a step that is not enough for it.
fn is_below(conclusion: &Conclusion) -> bool {
    conclusion.step.is_some() && !conclusion.is_enough()
}

fn solution(
    builder: &mut Builder,
    parent: usize,
    kind: Kind,
    name: &str,
    view: View,
    (piece, finding): (&Evidence, &Finding),
) {
    let name = format!("{name}-{}", piece.id);
    let place = builder.support(parent, kind, &name, cited(view, piece, finding));
    builder.cite(place, citation(piece));
}

/// The counter goal that the requirement does not hold.
fn deny(
    builder: &mut Builder,
    goal: usize,
    view: View,
    requirement: &Requirement,
    (verdict, against): (Verdict, &[(&Evidence, &Finding)]),
) {
    if against.is_empty() && verdict != Verdict::Violated {
        return;
    }
    let id = &requirement.id;
    let text = match verdict {
        Verdict::Violated => format!("Requirement {id} does not hold"),
        _ => format!("Evidence speaks against requirement {id}, without deciding it"),
    };
    let counter = builder.challenge(goal, id, text, verdict == Verdict::Violated);
    for of in against {
        solution(builder, counter, Kind::CounterSolution, id, view, *of);
    }
}

/// A counter goal for each conflict among the evidence that counts.
fn conflicts(
    builder: &mut Builder,
    goal: usize,
    view: View,
    requirement: &Requirement,
    pieces: &[(&Evidence, &Finding)],
) {
    let subject = quantity(view.study, requirement);
    let ids: Vec<&str> = pieces.iter().map(|(piece, _)| piece.id.as_str()).collect();
    for comparison in among(view.study, &subject, &ids) {
        if comparison.outcome == Outcome::Conflicts {
            let name = format!("{}-conflict", requirement.id);
            let text = format!("The evidence conflicts. {}", compared(comparison));
            builder.challenge(goal, &name, text, false);
        }
    }
}

/// What is missing: gaps of coverage, and a decision where there is none.
fn holes(view: View, requirement: &Requirement, conclusion: Option<&Conclusion>) -> Vec<String> {
    let study = view.study;
    let subject = quantity(study, requirement);
    let gaps = study.gaps.iter().filter(|gap| gap.subject == subject);
    let mut holes: Vec<String> = gaps
        .map(|gap| match gap.evidence.as_slice() {
            [] => format!("Some evidence covers it. Now: {}", gap.reason),
            ids => format!("{} covers it. Now: {}", ids.join(", "), gap.reason),
        })
        .collect();
    match conclusion.map(|c| c.verdict) {
        None => holes.push("A conclusion is drawn about it. Now: there is none.".to_owned()),
        Some(Verdict::Satisfied) if conclusion.is_some_and(is_below) => {
            let step = conclusion.and_then(|c| c.step).map_or("", Step::words);
            let needs = conclusion.map_or("", |c| c.needs.words());
            holes.push(format!(
                "It is shown {needs}. Now: it is shown {step} only."
            ));
        }
        Some(Verdict::Undecided) => {
            let synthesis = &study.synthesis;
            let mut plans = synthesis.deciding.iter();
            let cheapest = plans.find(|one| one.requirement == requirement.id);
            let what = cheapest.map_or(String::new(), |one| {
                format!(" Would: {}.", plan::deciding(one, &synthesis.costs))
            });
            holes.push(format!("The evidence decides. Now: it does not.{what}"));
        }
        _ => {}
    }
    holes
}
