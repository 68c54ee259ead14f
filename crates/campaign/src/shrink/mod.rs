//! Shrinking: the smallest stimulus that still shows what a large one showed.
//!
//! ```text
//! 1  delta debugging over the actions, over the values of `set` actions, and over the settings
//!    (a setting that goes is back at its nominal value, or left to the bench); of the settings
//!    each is tried alone first
//! 2  each number to fewer significant digits
//! 3  each setting that has a nominal value as near to that as possible, in numbers of two digits
//! 4  each delay to 0, or halved as often as possible, then to fewer digits
//! repeated until nothing changes
//! ```
//!
//! Source: A. Zeller and R. Hildebrandt, "Simplifying and isolating failure-inducing input" (2002),
//! the ddmin algorithm; J. Regehr et al., "Test-case reduction for C compiler bugs" (2012), for
//! passes repeated to a fixed point. Deviation: a stimulus is accepted only if its [`Size`] is
//! smaller, which makes the loop end. Cost: O(n^2) runs of the predicate at worst, O(n log n) where
//! its parts are independent; no content is run twice. Guarantee: the result shows what the start
//! showed, is never larger, and if the budget sufficed ([`Shrunk::is_minimal`]) no single action,
//! value or setting can be left out of it.

mod passes;
mod size;

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use serde::{Deserialize, Serialize};
use stimulus::{Settings, Space, Stimulus, StimulusError};

pub use size::Size;

/// What shrinking is allowed to do.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ShrinkOptions {
    /// Values that need no explanation, by dotted key: a setting with this value counts as absent.
    pub nominal: Settings,
    /// Settings without which the bench draws a number from the seed. They have nominal values and
    /// are brought back to these, never left out: the cause would move into the seed.
    pub drawn: BTreeSet<String>,
    /// The declared ranges: what lies outside is not tried, if the start lies within. A smaller
    /// scenario that nobody declared possible would explain nothing.
    pub space: Space,
    /// How many stimuli may be run.
    pub budget: usize,
}

impl Default for ShrinkOptions {
    /// No nominal values, no ranges, and 1000 runs.
    fn default() -> Self {
        Self {
            nominal: Settings::new(),
            drawn: BTreeSet::new(),
            space: Space::default(),
            budget: 1000,
        }
    }
}

impl ShrinkOptions {
    /// The nominal values and ranges of a space.
    ///
    /// # Errors
    /// [`StimulusError::Point`] if a nominal value is none of its parameter.
    pub fn within(space: Space, budget: usize) -> Result<Self, StimulusError> {
        let nominal = space.settings(&space.nominal())?;
        Ok(Self {
            nominal,
            drawn: BTreeSet::new(),
            space,
            budget,
        })
    }

    fn declares(&self, stimulus: &Stimulus) -> bool {
        let point = self.space.point_of(&stimulus.settings);
        point.is_some_and(|point| self.space.allows(&point))
    }
}

/// What became of a stimulus.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Shrunk {
    /// The smallest stimulus found that still shows it.
    pub stimulus: Stimulus,
    /// How many stimuli were run, the first one included.
    pub runs: usize,
    /// Whether every single action, value and setting was tried to be left out of the result.
    pub is_minimal: bool,
}

/// The stimulus did not show anything when it was run again: either the predicate asks for
/// something else than what was seen, or the bench is not deterministic.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NotShown;

impl fmt::Display for NotShown {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(
            "the stimulus did not show it when it was run again; run it with the seed of the \
             episode in which it was seen",
        )
    }
}

impl std::error::Error for NotShown {}

/// Shrinks a stimulus as far as `still_shows` holds. The predicate has to be deterministic (keep
/// the episode's seed), and to answer no for stimuli that the bench refuses.
///
/// ```
/// use campaign::{ShrinkOptions, shrink};
/// use stimulus::{AbstractTest, Action, Stimulus};
///
/// let noise = (0..20).map(|i| Action::send(&format!("noise {i}")));
/// let mut actions: Vec<Action> = noise.collect();
/// actions.insert(7, Action::set("gaze", false));
/// actions.insert(15, Action::send("ready"));
/// let mut start = Stimulus::of(AbstractTest::new("found", actions));
/// start.settings.insert("pull_newtons".into(), 3.141592.into());
/// start.settings.insert("mass_kg".into(), 0.35.into());
///
/// // It takes looking away, then being ready, and a pull of 2 to 5 N.
/// let result = shrink(&start, &ShrinkOptions::default(), &mut |s| {
///     let text = s.test.to_string();
///     let away = text.find("gaze=false");
///     let weak = s.settings.get("pull_newtons").is_some_and(|p| matches!(p, stimulus::Setting::Number(n) if (2.0..5.0).contains(n)));
///     weak && away.is_some() && away < text.find("send ready")
/// })?;
/// assert_eq!(result.stimulus.test.to_string(), "set gaze=false; send ready");
/// assert_eq!(result.stimulus.settings, [("pull_newtons".into(), 3.0.into())].into());
/// assert!(result.is_minimal);
/// # Ok::<(), campaign::NotShown>(())
/// ```
///
/// # Errors
/// [`NotShown`] if the stimulus itself does not show it.
pub fn shrink(
    start: &Stimulus,
    options: &ShrinkOptions,
    still_shows: &mut dyn FnMut(&Stimulus) -> bool,
) -> Result<Shrunk, NotShown> {
    let mut search = Shrinking {
        options,
        still_shows,
        known: BTreeMap::new(),
        runs: 0,
        exhausted: false,
        within: options.declares(start),
        size: Size::of(start, &options.nominal),
        best: start.clone(),
    };
    if !search.shows(start) {
        return Err(NotShown);
    }
    loop {
        let before = search.size;
        passes::all(&mut search);
        if search.size == before || search.exhausted {
            break;
        }
    }
    Ok(Shrunk {
        stimulus: search.best,
        runs: search.runs,
        is_minimal: !search.exhausted,
    })
}

/// The state of one shrinking.
struct Shrinking<'a> {
    options: &'a ShrinkOptions,
    still_shows: &'a mut dyn FnMut(&Stimulus) -> bool,
    /// Answers by content.
    known: BTreeMap<String, bool>,
    runs: usize,
    /// Only what the space declares possible is tried.
    within: bool,
    /// A run was wanted that the budget did not allow.
    exhausted: bool,
    best: Stimulus,
    size: Size,
}

impl Shrinking<'_> {
    /// Whether a stimulus shows it; no when the budget is used up.
    fn shows(&mut self, candidate: &Stimulus) -> bool {
        let content = candidate.content_hash();
        if let Some(answer) = self.known.get(&content) {
            return *answer;
        }
        if self.runs >= self.options.budget.max(1) {
            self.exhausted = true;
            return false;
        }
        self.runs += 1;
        let answer = (self.still_shows)(candidate);
        self.known.insert(content, answer);
        answer
    }

    /// Takes a candidate for the best if it is smaller and still shows it.
    fn accept(&mut self, candidate: Stimulus) -> bool {
        let size = Size::of(&candidate, &self.options.nominal);
        let possible = !self.within || self.options.declares(&candidate);
        if size >= self.size || !possible || !self.shows(&candidate) {
            return false;
        }
        self.best = candidate;
        self.size = size;
        true
    }
}

#[cfg(test)]
mod tests;
