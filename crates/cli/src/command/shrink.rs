//! `corroborate shrink`: the smallest scenario that still shows what an episode
//! showed, kept as a regression.
//!
//! First every number that the episode drew from its seed becomes a setting, so
//! that what is left afterwards names the cause and the seed does not hide it.
//! Then `campaign::shrink` makes the stimulus smaller: settings go back to their
//! nominal values, or as near to these as still shows it. Where the bench has a fast physics, that proposes a smaller
//! scenario first, and the full physics goes on from there (`trials`). At last the episode is
//! cut to the fewest whole seconds that still show it. A cut recording counts as
//! cut: what is violated only because nothing more comes is not decided by it,
//! so an end cannot become the reason.

mod pins;
mod report;
mod subject;
mod trials;

use super::replay::episode::{Episode, no_finding};
use super::{Done, Host, json};
use crate::args::{Format, Shrink};
use campaign::ShrinkOptions;
use corroborate::outcome::Outcome;
use corroborate::technique::exploration::{Plan, ShowsJudge};
use corroborate::technique::simulation::SearchPhysics;
use diagnostic::Problem;
use report::ShrinkReport;
use std::path::PathBuf;
use study::{Finding, Shows, Study};
use subject::Subject;
use trials::Shrunken;
pub use trials::Trials;

/// Shrinks.
pub fn shrink(arguments: &Shrink, setting: &Host) -> Result<Done, Problem> {
    let study = Study::load(&arguments.study)?;
    let subject = Subject::of(&study, arguments, setting)?;
    let target = target(&study, arguments, &subject)?;
    let Subject { finding, bench, .. } = &subject;
    let fast = SearchPhysics::choose(arguments.physics, || bench.in_fast_physics())
        .map_err(|message| Problem::new("bad-settings", message).remedy("leave out --physics"))?;
    let mut options = options(&study, arguments, finding, setting)?;
    let judge = ShowsJudge::new(&study, &finding.shows, &setting.cancel)?;
    let stage = setting
        .events
        .begin("shrinking: episodes", arguments.budget);
    let trials = Trials::new(
        (bench, fast.as_ref()),
        &judge,
        Episode::of_named(finding.clone(), &subject.name),
        (arguments.budget, arguments.seeds),
        (&setting.cancel, &stage),
    );
    let shrunk = trials.shrink(finding, &mut options)?;
    drop(stage);
    let report = keep(&shrunk, &subject, &target, &options)?;
    Ok(Done {
        output: match arguments.format {
            Format::Json => json(&report)?,
            Format::Text => report::as_text(&report, arguments, &shrunk.regression),
        },
        outcome: match setting.cancel.is_cancelled() {
            true => Outcome::Interrupted,
            false => Outcome::Holds,
        },
    })
}

/// The file of the regression, which must not be there yet.
fn target(study: &Study, arguments: &Shrink, subject: &Subject) -> Result<PathBuf, Problem> {
    let name = arguments.name.as_deref().unwrap_or(&subject.name);
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
    if name.is_empty() || name.starts_with('.') || !name.chars().all(is_plain) {
        return Err(
            Problem::new("bad-name", format!("`{name}` is no name of a regression"))
                .remedy("use letters, digits, `-` and `_`"),
        );
    }
    let target = study
        .folder
        .join("regressions")
        .join(format!("{name}.toml"));
    if target.exists() {
        let message = format!(
            "{} is there already and would be replaced",
            target.display()
        );
        return Err(Problem::new("already-there", message)
            .remedy("choose another name with --name, or remove the file"));
    }
    Ok(target)
}

/// What is possible and what needs no explanation: the parameters of an
/// exploration, if there is one of the same bench.
fn options(
    study: &Study,
    arguments: &Shrink,
    finding: &Finding,
    setting: &Host,
) -> Result<ShrinkOptions, Problem> {
    let budget = usize::try_from(arguments.budget).unwrap_or(usize::MAX);
    let of_finding = match &finding.shows {
        Shows::Unknown(step) => Some(PathBuf::from(&step.exploration)),
        _ => None,
    };
    let usual = PathBuf::from("exploration.toml");
    let is_asked = arguments.exploration.is_some();
    let named = arguments
        .exploration
        .clone()
        .or(of_finding)
        .or_else(|| study.folder.join(&usual).is_file().then_some(usual));
    let plan = match named {
        Some(file) => Some((Plan::load(&study.folder, &file)?, file)),
        None => None,
    };
    // Another bench has other keys.
    let fits = |plan: &Plan| is_asked || plan.data.evidence == finding.bench.evidence;
    let Some((plan, file)) = plan.filter(|(plan, _)| fits(plan)) else {
        setting
            .events
            .say("no exploration says what is possible: any value may be tried");
        return Ok(ShrinkOptions {
            budget,
            ..ShrinkOptions::default()
        });
    };
    setting.events.say(&format!(
        "ranges and nominal values are those of {}",
        file.display()
    ));
    ShrinkOptions::within(plan.space, budget)
        .map_err(|error| Problem::new("bad-exploration", error.to_string()))
}

/// Writes the regression and says what became of it.
fn keep(
    shrunk: &Shrunken,
    subject: &Subject,
    target: &std::path::Path,
    options: &ShrinkOptions,
) -> Result<ShrinkReport, Problem> {
    let mut kept = shrunk.regression.clone();
    kept.program = env!("CARGO_PKG_VERSION").into();
    let report = ShrinkReport::new(shrunk, &subject.finding, target, options);
    kept.write(target, &report::comment(&report, &subject.from))?;
    if Finding::read(target)? != kept {
        let message = format!("{} does not hold what was written", target.display());
        return Err(Problem::data_lost("cannot-write", message));
    }
    Ok(report)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_committed_schema_is_the_form_that_is_printed() {
        let schema: serde_json::Value = schemars::schema_for!(ShrinkReport).into();
        crate::command::tests::assert_schema_is_committed("shrink.schema.json", &schema);
    }
}
