//! `corroborate shrink`: the smallest scenario that still shows what a finding
//! showed, kept as a regression.
//!
//! `campaign::shrink` makes the stimulus smaller; then the episode is cut to
//! the fewest whole seconds that still show it. A cut recording counts as cut:
//! what is violated only because nothing more comes is not decided by it, so an
//! end cannot become the reason.

use super::replay::episode::{Episode, failed, finding_file, hash_of_trace, no_finding};
use super::{Done, Setting, json};
use crate::args::{Format, Shrink};
use crate::outcome::Outcome;
use crate::problem::Problem;
use crate::study::{Finding, Shows, Study};
use crate::talk::{Interrupt, Stage};
use crate::technique::exploration::{OpenBench, Plan, ShowsJudge};
use crate::technique::simulation::Seeds;
use campaign::{ShrinkOptions, Size};
use schemars::JsonSchema;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use stimulus::{Distribution, Stimulus};
use testbench::{Recorded, SimError};

/// What `shrink --format json` prints.
#[derive(Debug, Serialize, JsonSchema)]
pub struct ShrinkReport {
    /// Version of this form.
    pub format: String,
    /// What is shown, in words.
    pub shows: String,
    /// The regression's file.
    pub file: String,
    /// Episodes that were run.
    pub episodes: u64,
    /// Whether every single action, value and setting was tried to be left
    /// out.
    pub is_minimal: bool,
    /// In how many seeds it must show, and of how many.
    pub seeds: [u32; 2],
    /// The finding.
    pub before: ExtentReport,
    /// The regression.
    pub after: ExtentReport,
}

/// How much there is to a scenario.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct ExtentReport {
    /// Actions.
    pub actions: u64,
    /// Values in actions that set something.
    pub values: u64,
    /// Settings that are not nominal.
    pub settings: u64,
    /// Sum of the delays, or of their middles where they are random.
    pub delay_secs: f64,
    /// Simulated time of the episode.
    pub simulated_secs: f64,
}

impl ExtentReport {
    fn new(stimulus: &Stimulus, options: &ShrinkOptions, simulated_secs: f64) -> Self {
        let size = Size::of(stimulus, &options.nominal);
        let delays = stimulus
            .test
            .actions
            .iter()
            .map(|action| match action.after_secs {
                Distribution::Constant(secs) => secs,
                ref other => other.quantile(0.5),
            });
        Self {
            actions: size.actions as u64,
            values: size.values as u64,
            settings: size.settings as u64,
            delay_secs: delays.sum(),
            simulated_secs,
        }
    }
}

/// Shrinks.
pub fn shrink(arguments: &Shrink, setting: &Setting) -> Result<Done, Problem> {
    let study = Study::load(&arguments.study)?;
    let file = finding_file(&study, &arguments.finding)
        .ok_or_else(|| no_finding(&study, &arguments.finding))?;
    let finding = Finding::read(&file)?;
    let target = target(&study, arguments, &file)?;
    let budget = usize::try_from(arguments.budget).unwrap_or(usize::MAX);
    let options = options(&study, arguments, &finding, budget, setting)?;
    let bench = OpenBench::of_files(&study, &finding.bench, setting.physics_library.as_deref())?;
    let judge = ShowsJudge::new(&study, &finding.shows, &setting.interrupt)?;
    let episodes = arguments
        .budget
        .saturating_mul(u64::from(arguments.seeds.1));
    let stage = setting.talk.begin("shrinking: episodes", episodes);
    let trials = Trials {
        bench: &bench,
        judge: &judge,
        episode: Episode::of_finding(finding.clone(), &file),
        seeds: arguments.seeds,
        interrupt: &setting.interrupt,
        stage: &stage,
        runs: AtomicU64::new(0),
        failure: Mutex::new(None),
    };
    let shrunk = trials.shrink(&finding, &options)?;
    drop(stage);
    let report = shrunk.keep(&finding, &file, &target, &options)?;
    Ok(Done {
        output: match arguments.format {
            Format::Json => json(&report)?,
            Format::Text => as_text(&report, arguments, &shrunk.regression),
        },
        outcome: match setting.interrupt.is_set() {
            true => Outcome::Interrupted,
            false => Outcome::Holds,
        },
    })
}

/// The file of the regression, which must not be there yet.
fn target(study: &Study, arguments: &Shrink, file: &Path) -> Result<PathBuf, Problem> {
    let stem = file.file_stem().unwrap_or_default().to_string_lossy();
    let name = arguments.name.as_deref().unwrap_or(&stem);
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
    budget: usize,
    setting: &Setting,
) -> Result<ShrinkOptions, Problem> {
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
            .talk
            .say("no exploration says what is possible: any value may be tried");
        return Ok(ShrinkOptions {
            budget,
            ..ShrinkOptions::default()
        });
    };
    setting.talk.say(&format!(
        "ranges and nominal values are those of {}",
        file.display()
    ));
    ShrinkOptions::within(plan.space, budget)
        .map_err(|error| Problem::new("bad-exploration", error.to_string()))
}

/// Runs candidates.
struct Trials<'a> {
    bench: &'a OpenBench,
    judge: &'a ShowsJudge<'a>,
    episode: Episode,
    seeds: (u32, u32),
    interrupt: &'a Interrupt,
    stage: &'a Stage,
    /// Episodes that were run.
    runs: AtomicU64,
    /// What kept a candidate from being judged.
    failure: Mutex<Option<Problem>>,
}

/// What became of a finding.
struct Shrunken {
    regression: Finding,
    episodes: u64,
    is_minimal: bool,
    seeds: (u32, u32),
    /// Simulated time of the finding and of the regression.
    simulated_secs: [f64; 2],
}

impl Trials<'_> {
    fn shrink(&self, finding: &Finding, options: &ShrinkOptions) -> Result<Shrunken, Problem> {
        // Run by itself, so that what keeps it from running is told as it is.
        let first = self
            .run(&finding.stimulus, finding.seed, finding.bench.until_secs)
            .map_err(|error| failed(&error))?;
        let shrunk = campaign::shrink(&finding.stimulus, options, &mut |candidate| {
            self.shows(candidate, finding.bench.until_secs)
        });
        if let Ok(mut failure) = self.failure.lock()
            && let Some(problem) = failure.take()
        {
            return Err(problem);
        }
        let shrunk = match shrunk {
            Ok(shrunk) => shrunk,
            Err(_) if self.interrupt.is_set() => return Err(Problem::interrupted()),
            Err(error) => {
                return Err(Problem::data_lost("not-shown", error.to_string()).remedy(
                    "the study or the program has changed since; or ask for fewer seeds with --seeds",
                ));
            }
        };
        let mut regression = finding.clone();
        regression.stimulus = shrunk.stimulus;
        regression.bench.until_secs = self.shorten(&regression, first.sim_secs);
        // Not to be interrupted: it is what is kept.
        let last = self.finally(&regression)?;
        regression.recording = Some(hash_of_trace(&last.trace)?.0);
        Ok(Shrunken {
            regression,
            // The last one is not counted where the others are.
            episodes: self.runs.load(Ordering::Relaxed) + 1,
            is_minimal: shrunk.is_minimal && !self.interrupt.is_set(),
            seeds: self.seeds,
            simulated_secs: [first.sim_secs, last.sim_secs],
        })
    }

    /// The regression once more, as it is stored.
    fn finally(&self, regression: &Finding) -> Result<Recorded, Problem> {
        let episode = self.episode_of(
            &regression.stimulus,
            regression.seed,
            regression.bench.until_secs,
        );
        episode
            .run(self.bench, None, &Interrupt::default())
            .map_err(|error| failed(&error))
    }

    /// The fewest whole seconds after which the episode may end, by bisection.
    fn shorten(&self, regression: &Finding, longest_secs: f64) -> Option<u32> {
        let stimulus = &regression.stimulus;
        let before = regression.bench.until_secs;
        let mut shown = before.unwrap_or_else(|| longest_secs.clamp(1.0, 1e6).ceil() as u32);
        let (mut not_shown, mut found) = (0, before);
        while shown - not_shown > 1 && !self.interrupt.is_set() {
            let middle = not_shown + (shown - not_shown) / 2;
            match self.shows(stimulus, Some(middle)) {
                true => (shown, found) = (middle, Some(middle)),
                false => not_shown = middle,
            }
        }
        found
    }

    fn episode_of(&self, stimulus: &Stimulus, seed: u64, until_secs: Option<u32>) -> Episode {
        let mut episode = self.episode.clone();
        episode.stimulus = stimulus.clone();
        episode.seed = seed;
        episode.bench.until_secs = until_secs;
        episode
    }

    fn run(
        &self,
        stimulus: &Stimulus,
        seed: u64,
        until_secs: Option<u32>,
    ) -> Result<Recorded, SimError> {
        let episode = self.episode_of(stimulus, seed, until_secs);
        let recorded = episode.run(self.bench, None, self.interrupt);
        self.stage.advance();
        self.runs.fetch_add(1, Ordering::Relaxed);
        recorded
    }

    /// Whether it shows in enough seeds, the finding's own among them.
    fn shows(&self, stimulus: &Stimulus, until_secs: Option<u32>) -> bool {
        let (least, all) = self.seeds;
        let more = Seeds::new(self.episode.seed, "shrink");
        let (mut shown, mut left) = (0, all);
        for number in 0..all {
            let seed = match number {
                0 => self.episode.seed,
                _ => more.of(u64::from(number)),
            };
            left -= 1;
            let does = self.shows_in(stimulus, seed, until_secs);
            shown += u32::from(does);
            if (number == 0 && !does) || shown + left < least {
                return false;
            }
            if shown >= least {
                return true;
            }
        }
        false
    }

    /// Whether it shows in one seed. What the bench refuses, or what the
    /// physics does not survive, does not show it.
    fn shows_in(&self, stimulus: &Stimulus, seed: u64, until_secs: Option<u32>) -> bool {
        if self.interrupt.is_set() {
            return false;
        }
        let Ok(recorded) = self.run(stimulus, seed, until_secs) else {
            return false;
        };
        match self.judge.shows(&recorded) {
            Ok(shows) => shows,
            Err(problem) => {
                if let Ok(mut failure) = self.failure.lock() {
                    failure.get_or_insert(problem);
                }
                false
            }
        }
    }
}

impl Shrunken {
    /// Writes the regression and says what became of it.
    fn keep(
        &self,
        finding: &Finding,
        file: &Path,
        target: &Path,
        options: &ShrinkOptions,
    ) -> Result<ShrinkReport, Problem> {
        let [before_secs, after_secs] = self.simulated_secs;
        let mut kept = self.regression.clone();
        kept.program = env!("CARGO_PKG_VERSION").into();
        let report = ShrinkReport {
            format: "1.0".into(),
            shows: finding.shows.to_string(),
            file: target.display().to_string(),
            episodes: self.episodes,
            is_minimal: self.is_minimal,
            seeds: self.seeds.into(),
            before: ExtentReport::new(&finding.stimulus, options, before_secs),
            after: ExtentReport::new(&kept.stimulus, options, after_secs),
        };
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        kept.write(target, &comment(&report, &name))?;
        if Finding::read(target)? != kept {
            let message = format!("{} does not hold what was written", target.display());
            return Err(Problem::data_lost("cannot-write", message));
        }
        Ok(report)
    }
}

/// What stands above the regression.
fn comment(report: &ShrinkReport, from: &str) -> String {
    let ExtentReport {
        actions,
        settings,
        simulated_secs,
        ..
    } = report.after;
    let before = &report.before;
    let [least, all] = report.seeds;
    let in_seeds = match all {
        1 => "with this seed".to_owned(),
        _ => format!("in at least {least} of {all} seeds, this one among them"),
    };
    let file = Path::new(&report.file).file_name().unwrap_or_default();
    let minimal = match report.is_minimal {
        true => "No single action, value or setting can be left out.",
        false => "Perhaps it can be made smaller still: the search ended early.",
    };
    format!(
        "Shows: {}, {in_seeds}.\nMade of {from}: {} actions to {actions}, {} settings to \
         {settings}, {:.1} s to {simulated_secs:.1} s, in {} episodes.\n{minimal}\nTo look at it: \
         corroborate replay STUDY regressions/{}",
        report.shows,
        before.actions,
        before.settings,
        before.simulated_secs,
        report.episodes,
        file.to_string_lossy()
    )
}

fn as_text(report: &ShrinkReport, arguments: &Shrink, regression: &Finding) -> String {
    let (before, after) = (&report.before, &report.after);
    let mut text = format!("{}\n", report.shows);
    let mut row = |name: &str, before: String, after: String| {
        text.push_str(&format!("{name:<28} {before:>8} -> {after}\n"));
    };
    row(
        "actions",
        before.actions.to_string(),
        after.actions.to_string(),
    );
    row(
        "values set",
        before.values.to_string(),
        after.values.to_string(),
    );
    row(
        "settings",
        before.settings.to_string(),
        after.settings.to_string(),
    );
    let secs = |value: f64| format!("{value:.2} s");
    row(
        "delays together",
        secs(before.delay_secs),
        secs(after.delay_secs),
    );
    row(
        "simulated time",
        secs(before.simulated_secs),
        secs(after.simulated_secs),
    );
    let test = &regression.stimulus.test;
    text.push_str(&format!("what is left: {test}\n"));
    for (key, value) in &regression.stimulus.settings {
        text.push_str(&format!("  with {key} = {value}\n"));
    }
    text.push_str(match report.is_minimal {
        true => "no single action, value or setting can be left out\n",
        false => "the search ended early: perhaps it can be made smaller still\n",
    });
    let study = arguments.study.display();
    text + &format!(
        "{} episodes; kept in {}\nNext: corroborate replay {study} {}\n",
        report.episodes, report.file, report.file
    )
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
