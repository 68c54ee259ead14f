//! Episodes that are run to see what can be left out.
//!
//! Where the bench has a fast physics, that proposes: the finding is shrunk in it, by at most half of the episodes, and the
//! full physics goes on from there if it shows what is proposed, else from the finding. So the fast physics decides how
//! soon the search ends, and nothing else: that the regression shows it, and that nothing can be left out, is of the full
//! physics.

use super::clarity::{Clarity, Margin};
use super::pins::Pins;
use crate::replay::{Episode, hash_of_trace};
use crate::technique::exploration::{OpenBench, ShowsJudge, failed};
use crate::technique::simulation::Seeds;
use campaign::{NotShown, ShrinkOptions, Shrunk};
use diagnostic::Problem;
use host::{Cancel, Stage};
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, OnceLock};
use stimulus::Stimulus;
use study::Finding;
use testbench::{Recorded, SimError};

/// Runs candidates.
pub struct Trials<'a> {
    bench: &'a OpenBench,
    /// That to search in, if it is another.
    fast: Option<&'a OpenBench>,
    judge: &'a ShowsJudge<'a>,
    clarity: &'a Clarity<'a>,
    /// What is demanded of all scenarios, once the finding's own episode was run; none where no number grades it.
    margin: OnceLock<Margin>,
    episode: Episode,
    seeds: (u32, u32),
    /// Episodes that may be run.
    budget: u64,
    interrupt: &'a Cancel,
    stage: &'a Stage,
    /// Episodes that were run.
    runs: AtomicU64,
    /// Those of them that were run in the fast physics.
    fast_runs: AtomicU64,
    /// An episode was wanted that the budget did not allow.
    exhausted: AtomicBool,
    /// What kept a candidate from being judged.
    failure: Mutex<Option<Problem>>,
    /// The recordings that show it under the finding's own seed.
    shown: Mutex<BTreeMap<String, Known>>,
}

/// A recording that shows it.
#[derive(Clone)]
struct Known {
    hash: String,
    simulated_secs: f64,
    /// By how much it is violated, if a number says so.
    violated_by: Option<f64>,
}

/// What became of an episode.
pub struct Shrunken {
    /// The smallest that was found.
    pub regression: Finding,
    /// Episodes that were run.
    pub episodes: u64,
    /// Those of them in the fast physics, which only proposes.
    pub fast_episodes: u64,
    /// Whether everything was tried to be left out.
    pub is_minimal: bool,
    /// In how many seeds it must show, and of how many.
    pub seeds: (u32, u32),
    /// Numbers that are set and that the finding left to the seed.
    pub pinned: usize,
    /// Why none are, if that is so.
    pub not_pinned: Option<String>,
    /// Simulated time of the finding and of the regression.
    pub simulated_secs: [f64; 2],
    /// By how much the finding is violated and what was demanded; none where no number grades it.
    pub margin: Option<Margin>,
    /// By how much the regression is violated.
    pub violated_by: Option<f64>,
}

impl<'a> Trials<'a> {
    /// None yet, on the bench of the full physics and that to search in, if it is another: how many episodes may be run, and in how many of how many seeds it must show.
    pub fn new(
        (bench, fast): (&'a OpenBench, Option<&'a OpenBench>),
        (judge, clarity): (&'a ShowsJudge<'a>, &'a Clarity<'a>),
        episode: Episode,
        (budget, seeds): (u64, (u32, u32)),
        (interrupt, stage): (&'a Cancel, &'a Stage),
    ) -> Self {
        Self {
            bench,
            fast,
            judge,
            clarity,
            margin: OnceLock::new(),
            episode,
            seeds,
            budget,
            interrupt,
            stage,
            runs: AtomicU64::new(0),
            fast_runs: AtomicU64::new(0),
            exhausted: AtomicBool::new(false),
            failure: Mutex::new(None),
            shown: Mutex::new(BTreeMap::new()),
        }
    }

    /// Makes a finding as small as it goes.
    pub fn shrink(
        &self,
        finding: &Finding,
        options: &mut ShrinkOptions,
    ) -> Result<Shrunken, Problem> {
        let first = self.first(finding)?;
        let (pins, not_pinned) = self.pins(finding, &first)?;
        let mut regression = finding.clone();
        let mut pinned = 0;
        if let Some(pins) = pins {
            pinned = pins.count(finding);
            regression.stimulus = pins.stimulus.clone();
            pins.into_options(options);
        }
        let shrunk = self.smallest(&mut regression, options)?;
        regression.stimulus = shrunk.stimulus;
        regression.bench.until_secs = self.shorten(&regression, first.sim_secs);
        let known = self.known(&regression)?;
        regression.recording = Some(known.hash);
        let is_cut_off = self.interrupt.is_cancelled() || self.exhausted.load(Ordering::Relaxed);
        Ok(Shrunken {
            regression,
            episodes: self.runs.load(Ordering::Relaxed),
            fast_episodes: self.fast_runs.load(Ordering::Relaxed),
            is_minimal: shrunk.is_minimal && !is_cut_off,
            seeds: self.seeds,
            pinned,
            not_pinned,
            simulated_secs: [first.sim_secs, known.simulated_secs],
            margin: self.margin.get().copied(),
            violated_by: known.violated_by,
        })
    }

    /// The finding's own episode, run by itself, so that what keeps it from running is told as it is.
    fn first(&self, finding: &Finding) -> Result<Recorded, Problem> {
        let until_secs = finding.bench.until_secs;
        let first = self
            .run(&finding.stimulus, finding.seed, until_secs)
            .map_err(|error| failed(&error))?;
        if !self.judge.shows(&first)? {
            return Err(self.not_shown(&NotShown));
        }
        if let Some(margin) = self.clarity.margin(self.clarity.violated_by(&first)?)? {
            let _ = self.margin.set(margin);
        }
        self.know(&finding.stimulus, until_secs, &first)?;
        Ok(first)
    }

    /// The smallest stimulus that still shows it, from what the fast physics proposes, if that is shown.
    fn smallest(
        &self,
        regression: &mut Finding,
        options: &ShrinkOptions,
    ) -> Result<Shrunk, Problem> {
        if let Some(proposed) = self.proposed(regression, options) {
            regression.stimulus = proposed;
        }
        let until_secs = regression.bench.until_secs;
        let shrunk = campaign::shrink(&regression.stimulus, options, &mut |candidate| {
            self.shows(candidate, until_secs)
        });
        if let Ok(mut failure) = self.failure.lock()
            && let Some(problem) = failure.take()
        {
            return Err(problem);
        }
        shrunk.map_err(|error| self.not_shrunk(&error))
    }

    /// Why a finding that was shown once was not found to be shown when it was to be made smaller.
    fn not_shrunk(&self, error: &NotShown) -> Problem {
        if self.interrupt.is_cancelled() {
            return Problem::interrupted();
        }
        if !self.exhausted.load(Ordering::Relaxed) {
            return self.not_shown(error);
        }
        let (least, all) = self.seeds;
        let message = format!(
            "{} episodes cannot tell whether it shows in {least} of {all} seeds",
            self.budget
        );
        Problem::new("small-budget", message).remedy(format!(
            "allow for more, for example {} (--budget on the command line)",
            100 * u64::from(all)
        ))
    }

    /// What the fast physics makes of it, if the full one shows that, too.
    fn proposed(&self, regression: &Finding, options: &ShrinkOptions) -> Option<Stimulus> {
        let bench = self.fast?;
        let until_secs = regression.bench.until_secs;
        let most = self
            .budget
            .saturating_sub(self.runs.load(Ordering::Relaxed))
            / 2;
        let shrunk = campaign::shrink(&regression.stimulus, options, &mut |candidate| {
            self.in_seeds(|seed| {
                if self.interrupt.is_cancelled() || self.fast_runs.load(Ordering::Relaxed) >= most {
                    return false;
                }
                self.fast_runs.fetch_add(1, Ordering::Relaxed);
                let run = self.run_in(bench, candidate, seed, until_secs);
                // What cannot be judged is told by the full physics.
                run.is_ok_and(|recorded| self.shows_clearly(&recorded).unwrap_or(false))
            })
        });
        let proposed = shrunk.ok()?.stimulus;
        let is_shown = proposed != regression.stimulus && self.shows(&proposed, until_secs);
        is_shown.then_some(proposed)
    }

    /// Whether draws can be set without using up what it takes to see in how many seeds it shows.
    fn allows_pins(&self) -> bool {
        self.budget > u64::from(self.seeds.0)
    }

    fn not_shown(&self, error: &NotShown) -> Problem {
        Problem::data_lost("not-shown", error.to_string()).remedy(
            "the study or the program has changed since; or ask for fewer seeds (--seeds on the command line)",
        )
    }

    /// The draws of the episode as settings, if with them it is the same episode; or why not.
    fn pins(
        &self,
        finding: &Finding,
        first: &Recorded,
    ) -> Result<(Option<Pins>, Option<String>), Problem> {
        let Some(pins) = Pins::of(self.bench, finding)? else {
            let reason = "another simulator does not say which numbers it draws from a seed";
            return Ok((None, Some(reason.to_owned())));
        };
        if pins.count(finding) == 0 {
            return Ok((Some(pins), None));
        }
        if !self.allows_pins() {
            self.exhausted.store(true, Ordering::Relaxed);
            let reason = "the budget does not allow it".to_owned();
            return Ok((None, Some(reason)));
        }
        let again = self.run(&pins.stimulus, finding.seed, finding.bench.until_secs);
        let again = again.map_err(|error| failed(&error))?;
        if content(first)? != content(&again)? {
            let reason = "with its draws as settings it is another episode".to_owned();
            return Ok((None, Some(reason)));
        }
        self.know(&pins.stimulus, finding.bench.until_secs, &again)?;
        Ok((Some(pins), None))
    }

    /// The fewest whole seconds after which the episode may end, by bisection.
    fn shorten(&self, regression: &Finding, longest_secs: f64) -> Option<u32> {
        let stimulus = &regression.stimulus;
        let before = regression.bench.until_secs;
        let mut shown = before.unwrap_or_else(|| longest_secs.clamp(1.0, 1e6).ceil() as u32);
        let (mut not_shown, mut found) = (0, before);
        while shown - not_shown > 1 && !self.interrupt.is_cancelled() {
            let middle = not_shown + (shown - not_shown) / 2;
            match self.shows(stimulus, Some(middle)) {
                true => (shown, found) = (middle, Some(middle)),
                false => not_shown = middle,
            }
        }
        found
    }

    fn run(
        &self,
        stimulus: &Stimulus,
        seed: u64,
        until_secs: Option<u32>,
    ) -> Result<Recorded, SimError> {
        self.run_in(self.bench, stimulus, seed, until_secs)
    }

    fn run_in(
        &self,
        bench: &OpenBench,
        stimulus: &Stimulus,
        seed: u64,
        until_secs: Option<u32>,
    ) -> Result<Recorded, SimError> {
        let mut episode = self.episode.clone();
        episode.stimulus = stimulus.clone();
        episode.seed = seed;
        episode.bench.until_secs = until_secs;
        let recorded = episode.run(bench, None, self.interrupt);
        self.stage.advance();
        self.runs.fetch_add(1, Ordering::Relaxed);
        recorded
    }

    /// What an episode gives, if the budget allows one more.
    fn allowed<T>(&self, run: impl FnOnce() -> T) -> Option<T> {
        let is_allowed = self.runs.load(Ordering::Relaxed) < self.budget;
        if !is_allowed {
            self.exhausted.store(true, Ordering::Relaxed);
        }
        is_allowed.then(run)
    }

    /// Whether it shows in enough seeds, the finding's own among them.
    fn shows(&self, stimulus: &Stimulus, until_secs: Option<u32>) -> bool {
        self.in_seeds(|seed| self.shows_in(stimulus, seed, until_secs))
    }

    /// Whether it shows in enough seeds, the finding's own among them.
    fn in_seeds(&self, shows: impl Fn(u64) -> bool) -> bool {
        let (least, all) = self.seeds;
        let more = Seeds::new(self.episode.seed, "shrink");
        let (mut shown, mut left) = (0, all);
        for number in 0..all {
            let seed = match number {
                0 => self.episode.seed,
                _ => more.of(u64::from(number)),
            };
            left -= 1;
            let does = shows(seed);
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
        if self.interrupt.is_cancelled() {
            return false;
        }
        let is_own = seed == self.episode.seed;
        if is_own && self.is_known(stimulus, until_secs) {
            return true;
        }
        let Some(Ok(recorded)) = self.allowed(|| self.run(stimulus, seed, until_secs)) else {
            return false;
        };
        let shows = self.shows_clearly(&recorded).and_then(|shows| {
            if shows && is_own {
                self.know(stimulus, until_secs, &recorded)?;
            }
            Ok(shows)
        });
        shows.unwrap_or_else(|problem| {
            if let Ok(mut failure) = self.failure.lock() {
                failure.get_or_insert(problem);
            }
            false
        })
    }

    /// Whether a recording shows it, by at least the margin.
    fn shows_clearly(&self, recorded: &Recorded) -> Result<bool, Problem> {
        if !self.judge.shows(recorded)? {
            return Ok(false);
        }
        let Some(margin) = self.margin.get() else {
            return Ok(true);
        };
        let violated_by = self.clarity.violated_by(recorded)?;
        Ok(violated_by.is_some_and(|it| it >= margin.least))
    }

    /// An episode shows it: it need not be run again.
    fn know(
        &self,
        stimulus: &Stimulus,
        until_secs: Option<u32>,
        recorded: &Recorded,
    ) -> Result<(), Problem> {
        let known = Known {
            hash: hash_of_trace(&recorded.trace)?.0,
            simulated_secs: recorded.sim_secs,
            violated_by: self.clarity.violated_by(recorded)?,
        };
        if let Ok(mut shown) = self.shown.lock() {
            shown.insert(key(stimulus, until_secs), known);
        }
        Ok(())
    }

    fn is_known(&self, stimulus: &Stimulus, until_secs: Option<u32>) -> bool {
        let shown = self.shown.lock();
        shown.is_ok_and(|shown| shown.contains_key(&key(stimulus, until_secs)))
    }

    /// The recording of an episode that was run.
    fn known(&self, finding: &Finding) -> Result<Known, Problem> {
        let key = key(&finding.stimulus, finding.bench.until_secs);
        let shown = self.shown.lock().ok();
        let known = shown.and_then(|shown| shown.get(&key).cloned());
        known.ok_or_else(|| self.not_shown(&NotShown))
    }
}

fn key(stimulus: &Stimulus, until_secs: Option<u32>) -> String {
    format!("{} {until_secs:?}", stimulus.content_hash())
}

/// What an episode recorded, without what its recording says of its settings.
fn content(recorded: &Recorded) -> Result<String, Problem> {
    let mut trace = recorded.trace.clone();
    trace.metadata.clear();
    Ok(hash_of_trace(&trace)?.0)
}
