//! Looks: which counts a study was judged by before, so that adding trials and judging again keeps its error rates.
//!
//! # Definition
//! A *look* is a run of the study at which some count was another than at the look before. The trials between two looks
//! on the same evidence are a stage of one sequence of trials, as long as the later counts contain the earlier ones (no
//! fewer successes, no fewer failures); counts that do not contain them begin a new sequence. Tests of counts with looks
//! before them are those of `stats::continuation`: the first look costs a fifth of the level, and each later one gives the
//! p-value of all stages.
//!
//! Nothing is charged where no trials can be added (published and reproduced evidence, computed values), and nowhere if
//! a study declares that its sample sizes were fixed in advance.
//!
//! # Assumes
//! Every run of the study at which counts were new is recorded, and no look is taken out. Later counts that are no less in
//! successes and failures are of the same trials and more, which counts cannot show. What is computed was the same at all
//! looks. No piece was begun anew for its outcome.
//!
//! # Guarantee
//! That of `stats::continuation`: with the looks recorded, whoever goes on until something is shown errs no more often
//! than the declared level: exactly for independent counts, approximately for correlated ones (`ERROR_RATES.md`). Of correlated ones a look keeps the counts by subject, so that it
//! says later what it said then. Looks that were not recorded are not known.

pub(crate) mod over_looks;

use crate::compare::words::{percent, points};
use crate::compare::{Belief, ByCluster, CountsAtLook};
use crate::conclude::{at_one_look, of_tests};
use crate::{Evidence, Interval, Measure, Subject};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use stats::{Confidence, Sample};
use std::rc::Rc;

/// The looks at a study's counts, oldest first.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Looks {
    /// The looks; the last may be the present one.
    #[serde(default)]
    pub looks: Vec<Look>,
}

/// All counts at one look.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Look {
    /// The counts, in the order of the ledger.
    #[serde(default)]
    pub counts: Vec<LookedAt>,
}

/// One count at a look.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LookedAt {
    /// The evidence.
    pub evidence: String,
    /// What was counted.
    pub subject: Subject,
    /// Runs that passed, or occurrences of the failure mode.
    pub count: u64,
    /// Runs that were covered, or opportunities.
    pub trials: u64,
    /// Independent trials that say as much; `None` if all are independent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub effective_trials: Option<f64>,
    /// Runs without a verdict that were counted both ways.
    #[serde(default, skip_serializing_if = "is_none")]
    pub undecided: u64,
    /// `[count, trials]` of each subject or session, where one has several trials and it is known whose. Files of older
    /// versions call it `clusters`, and have none of people whose trials all came out alike.
    #[serde(default, skip_serializing_if = "Option::is_none", alias = "clusters")]
    pub by_subject: Option<Vec<[u64; 2]>>,
}

/// What it costs that trials may be added and judged again.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Looking {
    /// The evidence whose counts were looked at.
    pub evidence: Vec<String>,
    /// The number of this look, from 1.
    pub look: u64,
    /// Where the rate lies at the study's level, valid at all looks together; none for a pair.
    pub interval: Option<Interval>,
    /// The same if this was the only look.
    pub single_look_interval: Option<Interval>,
    /// The cost in one sentence.
    pub statement: String,
}

impl Look {
    /// The counts of all evidence to which trials can be added.
    #[must_use]
    pub fn of(evidence: &[Evidence]) -> Self {
        let open = evidence.iter().filter(|piece| is_open(piece));
        let counts = open.flat_map(|piece| {
            piece
                .findings
                .iter()
                .filter_map(|finding| match &finding.measure {
                    Measure::Counts {
                        count,
                        trials,
                        effective_trials,
                        by_subject,
                        ..
                    } if *trials > 0 => Some(LookedAt {
                        evidence: piece.id.clone(),
                        subject: finding.subject.clone(),
                        count: *count,
                        trials: *trials,
                        effective_trials: *effective_trials,
                        undecided: match finding.completions {
                            Some(_) => finding.undecided,
                            None => 0,
                        },
                        by_subject: by_subject.clone(),
                    }),
                    _ => None,
                })
        });
        Self {
            counts: counts.collect(),
        }
    }

    fn of_piece(&self, id: &str, subject: &Subject) -> Option<&LookedAt> {
        let mut all = self.counts.iter();
        all.find(|one| one.evidence == id && &one.subject == subject)
    }
}

/// What looking costs at one piece's counts; `None` if this is the only look at them.
pub(crate) fn looking(id: &str, belief: &Belief, level: Confidence) -> Option<Looking> {
    if !matches!(
        belief,
        Belief::Counts {
            before: Some(_),
            ..
        }
    ) {
        return None;
    }
    let look = over_looks::number(belief);
    let error = 0.5 * level.alpha();
    let estimate = belief.estimate();
    let at_all = |rate| worst(belief, |end| over_looks::doubts(end, rate));
    let all = of_tests(at_all, estimate, (error, error));
    let at_one = |end: &Belief, rate| end.counts().map_or((1.0, 1.0), |it| at_one_look(&it, rate));
    let once = |rate| worst(belief, |end| at_one(end, rate));
    let once = of_tests(once, estimate, (error, error));
    let in_words =
        |interval: Interval| format!("{} to {}", percent(interval.low), percent(interval.high));
    Some(Looking {
        evidence: vec![id.to_owned()],
        look,
        interval: Some(all),
        single_look_interval: Some(once),
        statement: format!(
            "{id}: look {look}. Trials may be added and judged again; the limits of the verdict's tests that allow for it, \
             two-sided at {}, are {} at every look, where those of a single look would be {}: looking costs {} of the lower limit \
             and {} of the upper one. The interval beside the rate is of one look.",
            percent(level.level()),
            in_words(all),
            in_words(once),
            points((once.low - all.low).max(0.0)),
            points((all.high - once.high).max(0.0)),
        ),
    })
}

/// The greatest p-values over all that runs without a verdict may have been.
fn worst(belief: &Belief, doubts: impl Fn(&Belief) -> (f64, f64)) -> (f64, f64) {
    let all = belief.ends().iter().map(doubts);
    all.fold((0.0, 0.0), |all, one| (all.0.max(one.0), all.1.max(one.1)))
}

/// Whether a count is left out where it is written.
fn is_none(count: &u64) -> bool {
    *count == 0
}

/// Whether trials can be added: not to what others published.
pub(crate) fn is_open(piece: &Evidence) -> bool {
    !piece.published && piece.reproduced_by.is_none()
}

impl Looks {
    /// The same with a further look, if any of its counts is new.
    #[must_use]
    pub fn with(mut self, look: Look) -> Self {
        if self.looks.last() != Some(&look) && !look.counts.is_empty() {
            self.looks.push(look);
        }
        self
    }

    /// The last counts of each sequence of trials that came before the present one, oldest first: no later counts contain them.
    pub(crate) fn replaced(&self, id: &str, subject: &Subject, now: &Belief) -> Vec<Sample> {
        let Belief::Counts { sample: now, .. } = now else {
            return Vec::new();
        };
        let seen = self
            .looks
            .iter()
            .filter_map(|look| look.of_piece(id, subject));
        let seen = seen.filter_map(|it| Sample::new(it.count, it.trials).ok());
        let seen: Vec<Sample> = seen.chain([*now]).collect();
        let pairs = seen.windows(2).filter(|pair| !contains(&pair[1], &pair[0]));
        pairs.map(|pair| pair[0]).collect()
    }

    /// What was known of one count at each look before the present one; `None` where it was not of the same sequence of
    /// trials. What is not counted was the same at all looks.
    pub(crate) fn before(&self, id: &str, subject: &Subject, now: &Belief) -> Vec<Option<Belief>> {
        let Belief::Counts { sample, .. } = now else {
            return vec![Some(now.clone()); self.looks.len()];
        };
        let mut next = *sample;
        let mut is_same = true;
        let mut found: Vec<Option<Belief>> = Vec::new();
        for look in self.looks.iter().rev() {
            let belief = look.of_piece(id, subject).and_then(LookedAt::belief);
            let held = belief.filter(|belief| match belief {
                Belief::Counts { sample, .. } => {
                    is_same &= contains(&next, sample);
                    next = if is_same { *sample } else { next };
                    is_same
                }
                _ => false,
            });
            found.push(held);
        }
        found.reverse();
        found
    }
}

/// Whether later counts can be those of the same trials and more.
fn contains(later: &Sample, earlier: &Sample) -> bool {
    earlier.successes <= later.successes && earlier.failures() <= later.failures()
}

impl Belief {
    /// The same counts after looks at some of the trials before.
    pub(crate) fn looked_at(self, earlier: &[Option<Belief>]) -> Self {
        let undecided = self.undecided();
        let Belief::Counts {
            sample,
            effective,
            clusters,
            completions,
            ..
        } = self
        else {
            return self;
        };
        let mut looks: Vec<CountsAtLook> = Vec::new();
        for one in earlier.iter().flatten().filter_map(Belief::counts) {
            if one.sample != sample && looks.last().is_none_or(|last| last.sample != one.sample) {
                looks.push(one);
            }
        }
        let completions = completions.map(|ends| -> Rc<[Belief]> {
            let of = |(place, end): (usize, &Belief)| {
                let then = completed(earlier, (place, undecided), end);
                end.clone().looked_at(&then)
            };
            ends.iter().enumerate().map(of).collect()
        });
        Belief::Counts {
            sample,
            effective,
            clusters,
            before: Some(looks.into()),
            completions,
        }
    }
}

/// What was known at earlier looks if each run without a verdict counts as at one end (its place, and how many there are now).
///
/// A look that tells of none, as those of older versions, is taken to have had as many as there are now. A run that was
/// undecided then and has a verdict now counts as it was decided, so that later counts always contain earlier ones.
pub(crate) fn completed(
    earlier: &[Option<Belief>],
    (place, undecided): (usize, u64),
    now: &Belief,
) -> Vec<Option<Belief>> {
    let Belief::Counts { sample, .. } = now else {
        return earlier.to_vec();
    };
    let mut next = *sample;
    let mut found: Vec<Option<Belief>> = Vec::new();
    for look in earlier.iter().rev() {
        let end = look.as_ref().and_then(|it| it.end(place, undecided));
        let end = end.and_then(|it| it.within(&next));
        if let Some(Belief::Counts { sample, .. }) = &end {
            next = *sample;
        }
        found.push(end);
    }
    found.reverse();
    found
}

impl Belief {
    /// The end at a place; of counts that tell of no runs without a verdict, as if there had been so many.
    fn end(&self, place: usize, undecided: u64) -> Option<Belief> {
        let (
            Belief::Counts {
                sample, effective, ..
            },
            false,
        ) = (self, self.has_undecided())
        else {
            // Of what may be told twice a look kept the counts with all.
            return self.ends().get(place % self.ends().len()).cloned();
        };
        // The lowest stands at even places, the highest at odd ones.
        let more = if place.is_multiple_of(2) {
            0
        } else {
            undecided
        };
        let trials = sample.trials.checked_add(undecided)?;
        let worth = effective.trials * trials as f64 / sample.trials as f64;
        Belief::of_counts(sample.successes + more, trials, Some(worth)).ok()
    }

    /// The same with no more successes and failures than later counts have; `None` where nothing is left.
    fn within(&self, later: &Sample) -> Option<Belief> {
        let Belief::Counts {
            sample, effective, ..
        } = self
        else {
            return Some(self.clone());
        };
        if contains(later, sample) {
            return Some(self.clone());
        }
        let successes = sample.successes.min(later.successes);
        let trials = successes + sample.failures().min(later.failures());
        let effect = effective.trials / sample.trials as f64;
        Belief::of_counts(successes, trials, Some(effect * trials as f64)).ok()
    }
}

impl LookedAt {
    fn belief(&self) -> Option<Belief> {
        let belief = Belief::of_counts(self.count, self.trials, self.effective_trials).ok()?;
        let belief = match &self.by_subject {
            Some(by_subject) => belief.by_cluster(ByCluster::new(by_subject)),
            None => belief,
        };
        if self.undecided == 0 {
            return Some(belief);
        }
        let all = self.trials.checked_add(self.undecided)?;
        // At the design effect of the runs with a verdict.
        let worth = self
            .effective_trials
            .map(|it| it * all as f64 / self.trials as f64);
        let end = |count: u64| Belief::of_counts(count, all, worth).ok();
        Some(belief.completed_by(vec![end(self.count)?, end(self.count + self.undecided)?]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn look(counts: &[(&str, u64, u64)]) -> Look {
        let counts = counts.iter().map(|(evidence, count, trials)| LookedAt {
            evidence: (*evidence).into(),
            subject: Subject::Requirement("1".into()),
            count: *count,
            trials: *trials,
            effective_trials: None,
            undecided: 0,
            by_subject: None,
        });
        Look {
            counts: counts.collect(),
        }
    }

    #[test]
    fn a_look_is_one_if_a_count_is_new() {
        let first = look(&[("a", 1, 2)]);
        let looks = Looks::default().with(first.clone()).with(first.clone());
        assert_eq!(looks.looks.len(), 1);
        assert_eq!(looks.with(look(&[("a", 1, 3)])).looks.len(), 2);
    }

    #[test]
    fn counts_that_do_not_contain_the_earlier_ones_are_another_sequence() {
        let looks = Looks {
            looks: vec![
                look(&[("a", 9, 10)]),
                look(&[("a", 3, 10), ("b", 1, 1)]),
                look(&[("b", 1, 4)]),
                look(&[("a", 5, 12)]),
            ],
        };
        let now = Belief::of_counts(8, 20, None).expect("counts");
        let before = looks.before("a", &Subject::Requirement("1".into()), &now);
        let trials: Vec<Option<f64>> = before
            .iter()
            .map(|one| Some(one.as_ref()?.worth_in_counts()?.trials))
            .collect();
        assert_eq!(trials, [None, Some(10.0), None, Some(12.0)]);
    }
}
