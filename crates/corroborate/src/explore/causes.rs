//! What brings findings about: all episodes that showed one, grouped by cause.
//!
//! # Definition
//! The first episode of a finding is shrunk ([`shrink()`](crate::shrink())), to what still shows it clearly, with the margin that
//! shrinking has by default. What is left is a *cause*: the settings that are not
//! nominal, numbers that the seed had drawn among them, and the actions. An episode that showed the same finding *met* the
//! cause if it did these actions in this order and had each of these settings: a number at least as far from nominal and on
//! the same side, anything else the same value. The first episode that met no cause is shrunk next, until all have met one,
//! there are [`MOST`] causes, or the finding's share of episodes is used up. Causes with the same actions and the same
//! settings on the same sides are one; of each number the one nearer to nominal stands for both.
//!
//! # Deviation
//! An episode may have met several causes, and counts for the first of them. That it met a cause does not show that it
//! would not have failed without: that is shown of the shrunk episodes alone.
//!
//! # Cost
//! At most the given number of episodes for each finding. Findings are looked into beside each other; the result does not
//! depend on the number of threads.

use crate::replay::Episode;
use crate::shrink::{Clarity, Trials};
use crate::technique::exploration::{FindingReport, Met, OpenBench, Plan, ShowsJudge};
use campaign::ShrinkOptions;
use diagnostic::Problem;
use evidence::{CauseFound, CauseSetting, Discovery};
use host::{Host, Stage};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use stimulus::{AbstractTest, Setting, Settings, Stimulus, Verb};
use study::{Finding, Study};

/// Causes of one finding, at most.
const MOST: usize = 6;

/// A scenario that still shows a finding, as small as it went.
struct Cause {
    regression: Finding,
    /// Its settings that are not nominal, each with the nominal value if there is one.
    settings: BTreeMap<String, (Setting, Option<Setting>)>,
    is_minimal: bool,
    /// The episode that was shrunk.
    of: u64,
}

/// An episode that showed a finding, with all that is known to have been set or drawn in it.
struct Known<'m> {
    met: &'m Met,
    values: Settings,
}

/// What findings are looked into with.
pub struct Causes<'a> {
    pub study: &'a Study,
    pub plan: &'a Plan,
    /// The bench of the full physics, and that to search in, if it is another.
    pub benches: (&'a OpenBench, Option<&'a OpenBench>),
    /// Episodes for each finding.
    pub budget: u64,
    pub folder: &'a Path,
    pub host: &'a Host,
    pub stage: &'a Stage,
}

impl Causes<'_> {
    /// Adds to each finding what brought it about, and writes the scenarios beside it.
    pub fn find(
        &self,
        findings: &[Finding],
        met: &[Vec<Met>],
        reports: &mut [FindingReport],
    ) -> Result<(), Problem> {
        let work = findings.par_iter().zip(met).zip(&*reports);
        let found: Result<Vec<Option<Vec<Cause>>>, Problem> = work
            .map(|((finding, met), report)| {
                if !report.found.replayed || self.host.cancel.is_cancelled() {
                    return Ok(None);
                }
                match self.causes(finding, &self.known(met)?) {
                    // Without this finding's causes the result is what it was.
                    Err(_) if self.host.cancel.is_cancelled() => Ok(None),
                    causes => causes.map(Some),
                }
            })
            .collect();
        let mut numbered: Vec<Cause> = Vec::new();
        for ((causes, met), report) in found?.into_iter().zip(met).zip(reports) {
            if let Some(causes) = causes {
                self.report(causes, &self.known(met)?, &mut numbered, &mut report.found)?;
            }
        }
        Ok(())
    }

    /// What was set and drawn in episodes.
    fn known<'m>(&self, met: &'m [Met]) -> Result<Vec<Known<'m>>, Problem> {
        met.iter()
            .map(|met| {
                let mut values = met.stimulus.settings.clone();
                let drawn = self.benches.0.drawn(&met.stimulus, met.seed)?;
                for number in drawn.into_iter().flatten() {
                    values
                        .entry(number.key)
                        .or_insert(Setting::Number(number.value));
                }
                Ok(Known { met, values })
            })
            .collect()
    }

    fn causes(&self, finding: &Finding, episodes: &[Known<'_>]) -> Result<Vec<Cause>, Problem> {
        let judge = ShowsJudge::new(self.study, &finding.shows, &self.host.cancel)?;
        let clarity = Clarity::new(self.study, &finding.shows, None)?;
        let mut causes: Vec<Cause> = Vec::new();
        let mut left = self.budget;
        let mut tried: Vec<u64> = Vec::new();
        while left > 0 && tried.len() < MOST && !self.host.cancel.is_cancelled() {
            let is_new = |it: &&Known<'_>| {
                !tried.contains(&it.met.episode) && !causes.iter().any(|cause| cause.is_met_in(it))
            };
            let Some(next) = episodes.iter().find(is_new) else {
                break;
            };
            let of = next.met.episode;
            tried.push(of);
            let finding = Finding {
                seed: next.met.seed,
                stimulus: next.met.stimulus.clone(),
                ..finding.clone()
            };
            let (cause, spent) = match self.shrunk(finding, of, (&judge, &clarity), left) {
                Ok(shrunk) => shrunk,
                // By itself it goes on to another end than where its requirement was decided.
                Err(problem) if problem.code == "not-shown" => {
                    left -= 1;
                    continue;
                }
                Err(problem) => return Err(problem),
            };
            left = left.saturating_sub(spent);
            match causes.iter_mut().find(|it| it.is_like(&cause)) {
                Some(same) => same.widen(&cause),
                None => causes.push(cause),
            }
        }
        Ok(causes)
    }

    /// One episode as small as it goes, and how many episodes that took.
    fn shrunk(
        &self,
        finding: Finding,
        of: u64,
        judges: (&ShowsJudge<'_>, &Clarity<'_>),
        budget: u64,
    ) -> Result<(Cause, u64), Problem> {
        let most = usize::try_from(budget).unwrap_or(usize::MAX);
        let mut options = ShrinkOptions::within(self.plan.space.clone(), most)
            .map_err(|error| Problem::new("bad-exploration", error.to_string()))?;
        let trials = Trials::new(
            self.benches,
            judges,
            Episode::of_named(finding.clone(), ""),
            (budget, (1, 1)),
            (&self.host.cancel, self.stage),
        );
        let shrunk = trials.shrink(&finding, &mut options)?;
        let kept = &shrunk.regression.stimulus.settings;
        let others = kept
            .iter()
            .filter(|(key, value)| options.nominal.get(*key) != Some(*value));
        let nominal = |key: &str| {
            options
                .nominal
                .get(key)
                .cloned()
                .or_else(|| self.of_bench(key))
        };
        let settings = others.map(|(key, value)| (key.clone(), (value.clone(), nominal(key))));
        Ok((
            Cause {
                settings: settings.collect(),
                is_minimal: shrunk.is_minimal,
                of,
                regression: shrunk.regression,
            },
            shrunk.episodes,
        ))
    }

    /// The number or other value that the bench's own data have for a key.
    fn of_bench(&self, key: &str) -> Option<Setting> {
        let mut parts = key.split('.');
        let first = self.benches.0.data().get(parts.next()?)?;
        let value = parts.try_fold(first, |value, part| value.get(part))?;
        value.clone().try_into().ok()
    }

    fn report(
        &self,
        causes: Vec<Cause>,
        episodes: &[Known<'_>],
        numbered: &mut Vec<Cause>,
        report: &mut Discovery,
    ) -> Result<(), Problem> {
        let mut counts = vec![0_u64; causes.len()];
        for episode in episodes {
            let place = causes
                .iter()
                .position(|cause| cause.of == episode.met.episode || cause.is_met_in(episode));
            if let Some(place) = place {
                counts[place] += 1;
            }
        }
        report.without_cause = Some(episodes.len() as u64 - counts.iter().sum::<u64>());
        let stem = report.file.trim_end_matches(".toml").to_owned();
        for (number, (cause, count)) in (1..).zip(causes.into_iter().zip(counts)) {
            let file = PathBuf::from(format!("{stem}-cause-{number}.toml"));
            let comment = format!(
                "{}\nEpisode {} of an exploration as small as it went. To look at it: corroborate replay STUDY THIS-FILE",
                report.in_words, cause.of
            );
            cause.regression.write(&self.folder.join(&file), &comment)?;
            let alike = numbered.iter().position(|it| it.is_like(&cause));
            report.causes.push(CauseFound {
                number: alike.unwrap_or(numbered.len()) as u64 + 1,
                settings: cause.in_words(),
                test: cause.regression.stimulus.test.to_string(),
                episodes: count,
                shrunk_episode: cause.of,
                is_minimal: cause.is_minimal,
                file: file.display().to_string(),
            });
            if alike.is_none() {
                numbered.push(cause);
            }
        }
        Ok(())
    }
}

impl Cause {
    fn is_met_in(&self, episode: &Known<'_>) -> bool {
        let has = |(key, (value, nominal)): (&String, &(Setting, Option<Setting>))| {
            let found = episode.values.get(key);
            found.is_some_and(|found| is_as_far(found, value, nominal.as_ref()))
        };
        self.settings.iter().all(has) && does(&episode.met.stimulus, &self.regression.stimulus.test)
    }

    /// Whether it is the same but for how far its numbers are from nominal.
    fn is_like(&self, other: &Self) -> bool {
        let verbs = |cause: &Self| -> Vec<Verb> {
            let actions = cause.regression.stimulus.test.actions.iter();
            actions.map(|action| action.verb.clone()).collect()
        };
        let same = |(key, (value, nominal)): (&String, &(Setting, Option<Setting>))| {
            let of_other = other.settings.get(key).map(|(value, _)| value);
            of_other.is_some_and(|it| side(it, nominal.as_ref()) == side(value, nominal.as_ref()))
        };
        verbs(self) == verbs(other)
            && self.settings.len() == other.settings.len()
            && self.settings.iter().all(same)
    }

    /// Takes from one that is like it what is nearer to nominal.
    fn widen(&mut self, other: &Self) {
        for (key, (value, nominal)) in &mut self.settings {
            if let Some((of_other, _)) = other.settings.get(key)
                && is_as_far(value, of_other, nominal.as_ref())
            {
                *value = of_other.clone();
            }
        }
    }

    fn in_words(&self) -> Vec<CauseSetting> {
        let settings = self.settings.iter();
        let report = settings.map(|(key, (value, nominal))| CauseSetting {
            key: key.clone(),
            value: value.to_string(),
            nominal: nominal.as_ref().map(ToString::to_string),
        });
        report.collect()
    }
}

/// On which side of nominal a number is; what is no number is its own side.
fn side(value: &Setting, nominal: Option<&Setting>) -> (i8, Option<Setting>) {
    match (value, nominal) {
        (Setting::Number(value), Some(Setting::Number(nominal))) => {
            (i8::from(value > nominal) - i8::from(value < nominal), None)
        }
        _ => (0, Some(value.clone())),
    }
}

/// Whether `found` is at least as far from nominal as `value`, on the same side.
fn is_as_far(found: &Setting, value: &Setting, nominal: Option<&Setting>) -> bool {
    match (found, value, nominal) {
        (Setting::Number(found), Setting::Number(value), Some(Setting::Number(nominal))) => {
            let (found, value) = (found - nominal, value - nominal);
            found.signum() == value.signum() && found.abs() >= value.abs()
        }
        _ => found == value,
    }
}

/// Whether a stimulus has all actions of a test in their order, whatever else it does and when.
fn does(stimulus: &Stimulus, test: &AbstractTest) -> bool {
    let mut done = stimulus.test.actions.iter();
    test.actions
        .iter()
        .all(|wanted| done.any(|action| covers(&action.verb, &wanted.verb)))
}

/// Whether one verb does all that another does.
fn covers(verb: &Verb, wanted: &Verb) -> bool {
    match (verb, wanted) {
        (Verb::Set(values), Verb::Set(wanted)) => wanted
            .iter()
            .all(|(name, value)| values.get(name) == Some(value)),
        _ => verb == wanted,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use stimulus::Action;

    #[test]
    fn what_is_as_far_from_nominal_on_the_same_side_has_met_it() {
        let number = Setting::Number;
        let nominal = number(0.6);
        for (found, value, expected) in [
            (0.3, 0.37, true),
            (0.37, 0.37, true),
            (0.4, 0.37, false),
            (0.9, 0.37, false),
            (0.9, 0.8, true),
            (0.6, 0.8, false),
        ] {
            let far = is_as_far(&number(found), &number(value), Some(&nominal));
            assert_eq!(far, expected, "{found} {value}");
        }
        assert!(is_as_far(&number(1.0), &number(1.0), None));
        assert!(!is_as_far(&number(2.0), &number(1.0), None));
        assert_eq!(
            side(&number(0.3), Some(&nominal)),
            side(&number(0.5), Some(&nominal))
        );
        assert_ne!(
            side(&number(0.3), Some(&nominal)),
            side(&number(0.7), Some(&nominal))
        );
        assert_ne!(
            side(&Setting::Bool(true), None),
            side(&Setting::Bool(false), None)
        );
    }

    #[test]
    fn a_test_does_another_if_it_has_its_actions_in_order() {
        let of = |actions: Vec<Action>| AbstractTest::new("t", actions);
        let away = || Action::set("gaze", false);
        let long = Stimulus::of(of(vec![
            Action::send("activate"),
            away(),
            Action::send("ready"),
        ]));
        assert!(does(&long, &of(vec![away(), Action::send("ready")])));
        assert!(!does(&long, &of(vec![Action::send("ready"), away()])));
        assert!(!does(&long, &of(vec![Action::set("gaze", true)])));
        assert!(does(&long, &of(Vec::new())));
    }
}
