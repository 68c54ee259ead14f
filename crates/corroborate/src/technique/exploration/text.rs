//! The result of an exploration for people.

use super::form::{ExplorationReport, FindingReport, SetReport};
use diagnostic::counted;
use evidence::{CauseFound, Stopped};
use std::fmt::Write;

/// Members of a list that are written out, at most.
const LISTED: usize = 8;

/// The result as text.
pub fn as_text(report: &ExplorationReport) -> String {
    let mut text = String::new();
    let stopped = match report.found.stopped {
        Stopped::Budget => "the budget",
        Stopped::NothingNew => "more of this kind have stopped paying",
        Stopped::Interrupted => "interrupted",
    };
    let _ = writeln!(
        text,
        "{} of {} ({}), {:.0} s simulated; ended by: {stopped}",
        counted(report.found.episodes, "episode"),
        report.found.evidence,
        report.found.engine,
        report.found.simulated_secs
    );
    findings(&mut text, report);
    not_confirmed(&mut text, report);
    coverage(&mut text, report);
    sources(&mut text, report);
    let _ = writeln!(text, "\n{}", report.found.statement);
    text
}

fn findings(text: &mut String, report: &ExplorationReport) {
    if report.found.findings.is_empty() {
        let _ = writeln!(text, "\nNothing was found.");
    }
    let mut heading = "";
    for finding in &report.found.findings {
        let of = match finding.found.is_after_task() {
            false => "Found",
            true => "Found only after the task was over",
        };
        if of != heading {
            let _ = writeln!(text, "\n{of}");
            heading = of;
        }
        one_finding(text, finding, report.found.episodes);
    }
    if !report.found.broken.is_empty() {
        let _ = writeln!(
            text,
            "\nNot simulated to the end: the physics gave no numbers in {} of {}, which is not evidence about the robot",
            report.found.broken.len(),
            counted(report.found.episodes, "episode")
        );
    }
    for broken in report.found.broken.iter().take(LISTED) {
        let _ = writeln!(text, "  episode {}: {}", broken.episode, broken.reason);
    }
    if let Some(more) = report
        .found
        .broken
        .len()
        .checked_sub(LISTED)
        .filter(|n| *n > 0)
    {
        let _ = writeln!(text, "  and {more} more in the JSON");
    }
}

/// A finding, what the robot did in it, and what was done to it.
fn one_finding(text: &mut String, finding: &FindingReport, episodes: u64) {
    let found = &finding.found;
    let replayed = if found.replayed {
        ""
    } else {
        "  NOT SHOWN AGAIN"
    };
    let after = match found.after_task {
        Some(after) if after > 0 && after < found.episodes => {
            format!(" ({after} of them only after the task was over)")
        }
        _ => String::new(),
    };
    let _ = writeln!(
        text,
        "  {}{replayed}\n      first in episode {}, in {} of {episodes}{after}; by {}\n      {}",
        found.in_words, found.first_episode, found.episodes, found.found_by, found.file
    );
    if let Some(told) = &found.told_apart {
        let _ = writeln!(text, "      what is recorded: {}", told.in_words());
    }
    if let Some(reason) = &found.not_told_apart {
        let _ = writeln!(text, "      what is recorded: {reason}");
    }
    causes(text, finding);
}

/// What only the fast physics showed.
fn not_confirmed(text: &mut String, report: &ExplorationReport) {
    let found = &report.found;
    let Some(confirmation) = &found.confirmation else {
        return;
    };
    if !found.findings.is_empty() {
        let _ = writeln!(
            text,
            "  the full physics ({}) shows each of them, too; episodes are counted in the fast physics of the search",
            confirmation.engine
        );
    }
    let others = &confirmation.not_confirmed;
    if !others.is_empty() {
        let _ = writeln!(
            text,
            "\nNot confirmed: {} shown by the fast physics only",
            others.len()
        );
    }
    for FindingReport { found: one, .. } in others {
        let _ = writeln!(
            text,
            "  {}: in {} of {} of the search\n      {}",
            one.in_words,
            one.episodes,
            counted(found.episodes, "episode"),
            one.file
        );
    }
}

/// What brought a finding about, the most frequent first.
fn causes(text: &mut String, finding: &FindingReport) {
    let mut causes: Vec<&CauseFound> = finding.found.causes.iter().collect();
    causes.sort_by_key(|cause| std::cmp::Reverse(cause.episodes));
    for cause in causes {
        let (settings, test) = (cause.settings_in_words(), cause.test_in_words());
        let early = if cause.is_minimal {
            ""
        } else {
            " (perhaps not minimal)"
        };
        let _ = writeln!(
            text,
            "      cause, met in {} of {}: {settings}; {test}{early}\n          {}",
            cause.episodes, finding.found.episodes, cause.file
        );
    }
    if let Some(others) = finding.found.without_cause.filter(|others| *others > 0) {
        let _ = writeln!(
            text,
            "      without these causes: {}",
            counted(others, "episode")
        );
    }
}

fn coverage(text: &mut String, report: &ExplorationReport) {
    let coverage = &report.coverage;
    let _ = writeln!(text, "\nCovered");
    set(
        text,
        "requirements and failure modes triggered",
        &coverage.triggers,
    );
    if let Some(states) = &coverage.states {
        set(text, "abstract states of the model", states);
    }
    if let Some(transitions) = &coverage.transitions {
        set(text, "abstract transitions of the model", transitions);
    }
    for (name, reason) in &coverage.not_expressed {
        let _ = writeln!(text, "  the model does not express `{name}`: {reason}");
    }
    for cross in &coverage.crosses {
        let _ = writeln!(
            text,
            "  situations `{}`: {} of {}",
            cross.name, cross.covered, cross.total
        );
        list(text, "never seen", &cross.holes);
    }
    if let Some(code) = &coverage.code {
        let _ = writeln!(
            text,
            "  code: {} of {} lines, {} of {} functions, {} of {} branches",
            code.lines[0],
            code.lines[1],
            code.functions[0],
            code.functions[1],
            code.branches[0],
            code.branches[1]
        );
        list(text, "lines that never ran", &code.never_run);
    }
    let saturation = &coverage.saturation;
    let _ = writeln!(
        text,
        "  {} different things seen, {} of them in one episode only; about {:.0} more can be seen, \
         {:.1} of them in 100 more episodes;\n  the next episode shows something new with a chance of \
         at most {:.3}",
        saturation.seen,
        saturation.seen_once,
        saturation.unseen,
        saturation.news_in_100_more,
        saturation.chance_of_news_at_most
    );
}

fn set(text: &mut String, name: &str, set: &SetReport) {
    let _ = writeln!(text, "  {name}: {} of {}", set.covered, set.total);
    list(text, "never", &set.missing);
    list(text, "unknown to it", &set.unknown);
}

fn list(text: &mut String, title: &str, members: &[String]) {
    list_of(text, title, members, LISTED);
}

fn list_of(text: &mut String, title: &str, members: &[String], listed: usize) {
    for member in members.iter().take(listed) {
        let _ = writeln!(text, "      {title}: {member}");
    }
    if members.len() > listed {
        let _ = writeln!(
            text,
            "      and {} more in the JSON",
            members.len() - listed
        );
    }
}

fn sources(text: &mut String, report: &ExplorationReport) {
    let _ = writeln!(text, "\nSources");
    for source in &report.sources {
        let _ = writeln!(
            text,
            "  {}: {}, {} with something new",
            source.source,
            counted(source.episodes, "episode"),
            source.with_news
        );
    }
    for search in &report.searches {
        let found = match search.violated_after {
            Some(after) => format!(
                "violated in its episode {after}, {} in all",
                counted(search.violated, "time")
            ),
            None => "not violated".to_owned(),
        };
        let least = search.least_robustness.map_or_else(String::new, |least| {
            format!("; least space-time robustness {least:.3}")
        });
        let _ = writeln!(
            text,
            "  {} against requirement {}: {}, {found}{least}",
            search.method,
            search.requirement,
            counted(search.episodes, "episode")
        );
        if let Some(blind) = &search.blind {
            let _ = writeln!(text, "      warning: {blind}");
        }
    }
    let tests = &report.model_tests;
    if let Some(cover) = &tests.transition_cover {
        let _ = writeln!(
            text,
            "  the model: {} of transitions taken by {} with {}",
            counted(cover.classes, "kind"),
            counted(cover.paths, "path"),
            counted(cover.transitions, "transition")
        );
    }
    for test in &tests.tests {
        let _ = writeln!(
            text,
            "      test: {}\n          leads to: {}",
            test.test,
            test.goals.join("; ")
        );
    }
    let without: Vec<String> = tests
        .without
        .iter()
        .map(|(g, r)| format!("{g}: {r}"))
        .collect();
    list_of(text, "no test from the model", &without, without.len());
}
