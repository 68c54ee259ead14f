//! The study with its names looked up, and the small pieces of page that
//! every section uses.

use evidence::{
    Combined, Conclusion, Evidence, Excluded, ExclusionReason, Finding, Interval, Measure,
    PieceStanding, Requirement, Step, StudyResult, Subject, Technique, Together,
};
use maud::{Markup, html};

use crate::number;
use crate::words::{self, Mark};

/// A study being shown.
#[derive(Clone, Copy)]
pub struct View<'a> {
    /// What is shown.
    pub study: &'a StudyResult,
}

impl<'a> View<'a> {
    /// The requirement with this identifier.
    pub fn requirement(&self, id: &str) -> Option<&'a Requirement> {
        self.study.requirements.iter().find(|r| r.id == id)
    }

    /// What the independent evidence on a requirement supports together.
    pub fn combined(&self, requirement: &str) -> Option<&'a Combined> {
        let mut combined = self.study.synthesis.combined.iter();
        combined.find(|one| one.requirement == requirement)
    }

    /// All pieces of evidence on a subject, compared at once, where there are three or more.
    pub fn together(&self, subject: &Subject) -> Option<&'a Together> {
        let mut together = self.study.synthesis.together.iter();
        together.find(|one| &one.subject == subject && one.evidence.len() > 2)
    }

    /// Every requirement, then every failure mode.
    pub fn subjects(&self) -> Vec<Subject> {
        let requirements = self.study.requirements.iter();
        let modes = self.study.failure_modes.iter();
        requirements
            .map(|r| Subject::Requirement(r.id.clone()))
            .chain(modes.map(|m| Subject::FailureMode(m.id.clone())))
            .collect()
    }

    /// The requirement that supplies the finding: itself, or the one with the
    /// same quantity.
    pub fn quantity(&self, requirement: &Requirement) -> Subject {
        let own = Subject::Requirement(requirement.id.clone());
        let has_own = self
            .study
            .evidence
            .iter()
            .any(|e| e.finding(&own).is_some());
        match &requirement.same_quantity_as {
            Some(first) if !has_own => Subject::Requirement(first.clone()),
            _ => own,
        }
    }

    /// The evidence of a technique on which the conclusion rests or, where it
    /// rests on none, the latest of our own that speaks of the requirement.
    pub fn current(&self, requirement: &Requirement, technique: Technique) -> Vec<&'a Evidence> {
        let conclusions = &self.study.conclusions;
        let conclusion = conclusions.iter().find(|c| c.requirement == requirement.id);
        let rests_on = conclusion.map_or(&[][..], |c| &c.rests_on);
        let ledger = self.study.evidence.iter();
        let of_technique = ledger.filter(|e| e.technique == technique);
        let named: Vec<_> = of_technique
            .clone()
            .filter(|e| rests_on.contains(&e.id))
            .collect();
        if !named.is_empty() {
            return named;
        }
        let subject = self.quantity(requirement);
        of_technique
            .filter(|e| e.reproduced_by.is_none() && !e.intermediate)
            .rfind(|e| e.finding(&subject).is_some())
            .into_iter()
            .collect()
    }

    /// The conclusion on a requirement.
    pub fn conclusion(&self, requirement: &str) -> Option<&'a Conclusion> {
        let mut conclusions = self.study.conclusions.iter();
        conclusions.find(|one| one.requirement == requirement)
    }

    /// How a piece of evidence stands by itself to what a requirement asks for, where the conclusion judged it.
    pub fn standing(&self, requirement: &Requirement, evidence: &str) -> Option<&'a PieceStanding> {
        let mut standings = self.conclusion(&requirement.id)?.standings.iter();
        standings.find(|it| it.evidence == evidence && it.step != Step::Corroborated)
    }

    /// Why a piece of evidence with a number takes no part in the conclusion on a requirement.
    pub fn apart(&self, requirement: &Requirement, evidence: &str) -> Option<&'a Excluded> {
        let conclusion = self.conclusion(&requirement.id)?;
        let takes_part = conclusion.rests_on.iter().any(|id| id == evidence);
        let mut excluded = conclusion.excluded.iter();
        // Trials of one person are current, and decide nothing of others.
        let apart = |it: &Excluded| {
            !takes_part && !it.reason.is_silence() || it.reason == ExclusionReason::OneSubject
        };
        excluded.find(|it| it.evidence == evidence && apart(it))
    }

    /// The mark of a piece of evidence on a requirement: as the conclusion judged it, else as its interval lies. What takes
    /// no part has no mark for or against.
    pub fn mark(&self, requirement: &Requirement, evidence: &str, measure: &Measure) -> Mark {
        if self.apart(requirement, evidence).is_some() {
            return words::apart();
        }
        match self.standing(requirement, evidence) {
            Some(standing) => words::standing(requirement, standing.standing, measure),
            None => words::reading(requirement, measure),
        }
    }

    /// Over which runs a finding is taken, and how often these come.
    pub fn condition(&self, finding: &Finding) -> Option<String> {
        let trigger = match &finding.subject {
            Subject::Requirement(id) => self.requirement(id).and_then(|it| it.trigger.as_deref()),
            Subject::FailureMode(_) => None,
        };
        finding.condition(trigger).map(|words| unbroken(&words))
    }

    /// Anchor of the evidence's entry in the ledger.
    pub fn anchor(&self, id: &str) -> Option<String> {
        let place = self.study.evidence.iter().position(|e| e.id == id)?;
        Some(format!("evidence-{}", place + 1))
    }

    /// Anchor of the requirement's plot.
    pub fn requirement_anchor(&self, id: &str) -> Option<String> {
        let place = self.study.requirements.iter().position(|r| r.id == id)?;
        Some(format!("requirement-{}", place + 1))
    }

    /// The requirement's identifier, leading to its plot.
    pub fn requirement_link(&self, id: &str) -> Markup {
        html! {
            @match self.requirement_anchor(id) {
                Some(anchor) => a class="req" href={ "#" (anchor) } { (id) },
                None => span class="req" { (id) },
            }
        }
    }

    /// The evidence's identifier, leading to its entry in the ledger.
    pub fn link(&self, id: &str) -> Markup {
        html! {
            @match self.anchor(id) {
                Some(anchor) => a class="id" href={ "#" (anchor) } { (id) },
                None => span class="id" { (id) },
            }
        }
    }

    /// Several identifiers, separated by commas.
    pub fn links(&self, ids: &[String]) -> Markup {
        html! {
            @for (i, id) in ids.iter().enumerate() {
                @if i > 0 { ", " }
                (self.link(id))
            }
        }
    }

    /// The subject as people call it: `Requirement 1a`, `Grip failure`.
    pub fn title(&self, subject: &Subject) -> String {
        match subject {
            Subject::Requirement(id) => format!("Requirement {id}"),
            Subject::FailureMode(id) => self
                .study
                .failure_modes
                .iter()
                .find(|m| &m.id == id)
                .map_or_else(|| id.clone(), |m| m.name.clone()),
        }
    }

    /// The subject in a phrase: `requirement 1a`, `grip failure`.
    pub fn short_title(&self, subject: &Subject) -> String {
        match subject {
            Subject::Requirement(id) => format!("requirement {id}"),
            Subject::FailureMode(_) => uncapitalised(&self.title(subject)),
        }
    }

    /// Several subjects, separated by commas.
    pub fn titles(&self, subjects: &[Subject]) -> String {
        let names: Vec<String> = subjects.iter().map(|s| self.short_title(s)).collect();
        names.join(", ")
    }
}

/// With a small first letter, unless the first word is an abbreviation.
fn uncapitalised(text: &str) -> String {
    let mut chars = text.chars();
    match (chars.next(), chars.next()) {
        (Some(first), Some(second)) if !second.is_uppercase() => {
            let rest = chars.as_str();
            first.to_lowercase().chain([second]).collect::<String>() + rest
        }
        _ => text.to_owned(),
    }
}

/// A section with its heading and a lead sentence.
pub fn section(id: &str, heading: &str, lead: Markup, body: Markup) -> Markup {
    html! {
        section id=(id) aria-labelledby={ (id) "-heading" } {
            h2 id={ (id) "-heading" } { (heading) }
            p class="lead" { (lead) }
            (body)
        }
    }
}

/// A mark with its word.
pub fn chip(mark: &Mark) -> Markup {
    html! {
        span class={ "chip " (mark.tone) } {
            span class="symbol" aria-hidden="true" { (mark.symbol) }
            " " (mark.word)
        }
    }
}

/// What was found, in one line: counts and rate, or probability and guarantee.
pub fn figures(measure: &Measure) -> Markup {
    html! {
        @match measure {
            Measure::Counts { trials: 0, .. } => span class="absent" { "○ not covered" },
            Measure::Counts { count, trials, interval, .. } => {
                b { (number::percent(*count as f64 / *trials as f64)) }
                " " (range(*interval))
                " " span class="counts" { (number::count(*count)) "/" (number::count(*trials)) }
            },
            Measure::Probability { answer, credible, .. } => {
                b { (number::answer(answer)) }
                @match credible.as_ref().filter(|c| c.interval.low < c.interval.high) {
                    Some(credible) => {
                        " " (range(credible.interval))
                        " " span class="counts" {
                            @if credible.ends.is_some() { "credible, over all schedulers" } @else { "credible" }
                        }
                    },
                    None => { " " span class="counts" { (number::guarantee(&answer.guarantee)) } },
                }
            },
            Measure::NotExpressible { .. } => span class="absent" { "⊘ not expressible" },
            Measure::NotCovered { .. } => span class="absent" { "○ not covered" },
        }
    }
}

/// An interval in running text.
pub fn range(interval: Interval) -> Markup {
    html! { span class="range" { (number::interval(interval)) } }
}

/// A hash short enough for a line; the whole is in its title.
pub fn short_hash(hash: &str) -> Markup {
    let short: String = hash.chars().take(10).collect();
    html! { code class="hash" title=(hash) { (short) } }
}

/// The text with its per cent signs kept on the line of their numbers.
pub fn unbroken(text: &str) -> String {
    text.replace(" %", "\u{a0}%")
}

/// Text with its line breaks kept as paragraphs.
pub fn prose(text: &str) -> Markup {
    html! {
        @for paragraph in text.split("\n\n").filter(|p| !p.trim().is_empty()) {
            p { (paragraph) }
        }
    }
}

/// What every one of several conclusions leaves out, each sentence once: it is said once.
pub fn left_out_of_all(study: &StudyResult) -> Vec<&str> {
    let [first, others @ ..] = study.conclusions.as_slice() else {
        return Vec::new();
    };
    if others.is_empty() {
        return Vec::new();
    }
    let is_common = |words: &&str| {
        others
            .iter()
            .all(|it| it.left_out().any(|own| own == *words))
    };
    first.left_out().filter(is_common).collect()
}

/// Lines of all conclusions, each once, with the requirements that share it.
pub fn merged<'a>(
    conclusions: &'a [Conclusion],
    lines: impl Fn(&'a Conclusion) -> &'a [String],
) -> Vec<(&'a str, Vec<&'a str>)> {
    let mut merged: Vec<(&str, Vec<&str>)> = Vec::new();
    for conclusion in conclusions {
        for line in lines(conclusion) {
            match merged.iter_mut().find(|(text, _)| text == line) {
                Some((_, ids)) => ids.push(&conclusion.requirement),
                None => merged.push((line, vec![&conclusion.requirement])),
            }
        }
    }
    merged
}
