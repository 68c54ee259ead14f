//! Of which runs a figure speaks, and how often these come: the condition of every figure.
//!
//! # Definition
//! A figure is taken over some runs ([`Denominator`]). Where these are the runs that trigger its subject, the share of all
//! runs that do is a quantity of its own ([`Finding::trigger`]). The condition of a figure names both, with their counts or
//! probabilities. It is made here once, so that a page, a summary and a verdict say the same of one figure.
//!
//! # Assumes
//! Nothing of the data.
//!
//! # Guarantee
//! One figure has one condition, wherever it is shown.

use crate::compare::words::percent;
use crate::{Denominator, Evidence, Finding, Measure, Requirement, Subject};

/// Counts of all attempts of a table that does not say which of them triggered a requirement are over all runs where other evidence under the
/// same conditions has runs that do not trigger it. Without such evidence each attempt is taken to
/// ([`Finding::takes_each_run_to_trigger`]).
pub fn doubt_triggers(evidence: &mut [Evidence], requirements: &[Requirement]) {
    for requirement in requirements {
        let subject = Subject::Requirement(requirement.id.clone());
        let trigger = requirement.trigger.as_deref();
        let is_taken = |piece: &Evidence| {
            let finding = piece.finding(&subject);
            finding.is_some_and(|it| it.takes_each_run_to_trigger(trigger))
        };
        let taken: Vec<usize> = (0..evidence.len())
            .filter(|it| is_taken(&evidence[*it]))
            .collect();
        for index in taken {
            let others = evidence
                .iter()
                .filter(|it| it.conditions == evidence[index].conditions && !it.intermediate);
            let doubt = others.filter_map(|other| doubt(other, &subject)).next();
            let findings = evidence[index].findings.iter_mut();
            let own = findings.filter(|it| it.subject == subject);
            for (finding, reason) in own.zip(doubt) {
                finding.denominator = Denominator::AllRuns { reason };
            }
        }
    }
}

/// That some runs of a piece do not trigger the subject, in words.
fn doubt(piece: &Evidence, subject: &Subject) -> Option<String> {
    let trigger = piece.finding(subject)?.trigger.as_deref()?;
    let most = match trigger {
        Measure::Counts { count, trials, .. } if *trials > 0 => *count as f64 / *trials as f64,
        Measure::Probability { answer, .. } => match answer.guarantee.over_schedulers() {
            Some((_, high)) => high,
            None => answer.value,
        },
        _ => return None,
    };
    (most < 1.0 - NEARLY_ALL).then(|| {
        format!(
            "its tables do not say which of them did, and {} of the runs of {} do",
            share(trigger).unwrap_or_default(),
            piece.id
        )
    })
}

/// A share of runs that is nearer to 1 may be rounding.
const NEARLY_ALL: f64 = 1e-6;

/// How people call what triggers a subject.
struct Words {
    /// A run of which the subject speaks, as a noun with its relative clause: `runs that trigger it (near)`.
    runs: String,
    /// That runs do so: `trigger it (near)`.
    many: String,
    /// That one run does so: `triggers it (near)`.
    one: String,
    /// The same behind "to": `trigger it (near)`.
    infinitive: String,
}

impl Finding {
    /// Over which runs its figure is taken, and how often these come; `None` where there is no figure and nothing is known of
    /// its trigger.
    ///
    /// `trigger` is what triggers the subject in the words of the study ([`crate::Requirement::trigger`]).
    ///
    /// ```
    /// use evidence::{Denominator, Finding, Measure, Subject};
    /// use stats::{Confidence, Sample};
    /// let counts = |count, trials| Measure::of_counts(Sample { successes: count, trials }, None, Confidence::P95);
    /// let finding = Finding {
    ///     subject: Subject::Requirement("1".into()),
    ///     measure: counts(174, 200)?,
    ///     denominator: Denominator::Triggered,
    ///     trigger: Some(Box::new(counts(200, 960)?)),
    ///     undecided: 0,
    ///     left_out: 0,
    ///     completions: None,
    ///     witnesses: vec![],
    ///     readings: vec![],
    /// };
    /// let condition = finding.condition(Some("near"));
    /// assert_eq!(condition.as_deref(), Some(
    ///     "174 of the 200 runs that trigger it (near); 200 of 960 runs trigger it (20.8 %)"
    /// ));
    /// # Ok::<(), stats::StatsError>(())
    /// ```
    #[must_use]
    pub fn condition(&self, trigger: Option<&str>) -> Option<String> {
        let words = self.words(trigger);
        match &self.measure {
            Measure::Counts { count, trials, .. } if *trials > 0 => {
                let is_taken = self.takes_each_run_to_trigger(trigger);
                Some(self.of_counts((*count, *trials), &words, is_taken))
            }
            Measure::Probability { .. } => Some(self.of_probability(&words)),
            _ => self.how_often(&words),
        }
    }

    /// Whether its figure is over other runs than all, or leaves some out.
    #[must_use]
    pub fn is_conditional(&self) -> bool {
        let over_all = matches!(
            self.denominator,
            Denominator::EveryRun | Denominator::NoTrigger
        );
        !over_all || self.undecided > 0
    }

    /// Whether its counts are over all runs though only those that trigger its subject count, and nothing says that all of these did:
    /// a table of attempts without a column or a row for the trigger.
    #[must_use]
    pub fn takes_each_run_to_trigger(&self, trigger: Option<&str>) -> bool {
        trigger.is_some()
            && self.trigger.is_none()
            && self.undecided == 0
            && self.denominator == Denominator::EveryRun
            && matches!(self.measure, Measure::Counts { .. })
    }

    /// Whether it counts runs of a requirement that did not trigger it, and are no trials of it, among those that did.
    pub(crate) fn counts_untriggered(&self) -> bool {
        matches!(self.subject, Subject::Requirement(_))
            && matches!(self.measure, Measure::Counts { .. })
            && matches!(self.denominator, Denominator::AllRuns { .. })
    }

    /// The condition in the words that stand behind a figure within a sentence; empty where every run counts.
    pub(crate) fn given(&self) -> &'static str {
        match (&self.denominator, &self.measure) {
            (Denominator::EveryRun | Denominator::NoTrigger, _) => "",
            (Denominator::Triggered | Denominator::Covered, Measure::Probability { .. }) => {
                " given its trigger"
            }
            (Denominator::Triggered | Denominator::Covered, _) => " of the runs that trigger it",
            (Denominator::OtherTrigger { .. }, _) => " given the model's trigger",
            (Denominator::AllRuns { .. }, _) => " over all runs, triggered or not",
        }
    }

    fn words(&self, trigger: Option<&str>) -> Words {
        let name = trigger.map_or(String::new(), |name| format!(" ({name})"));
        match &self.subject {
            Subject::Requirement(_) => Words {
                runs: format!("runs that trigger it{name}"),
                many: "trigger it".to_owned(),
                one: format!("triggers it{name}"),
                infinitive: format!("trigger it{name}"),
            },
            Subject::FailureMode(_) => Words {
                runs: format!("opportunities{name}"),
                many: "give an opportunity".to_owned(),
                one: format!("gives an opportunity{name}"),
                infinitive: format!("give an opportunity{name}"),
            },
        }
    }

    fn of_counts(&self, (count, trials): (u64, u64), words: &Words, is_taken: bool) -> String {
        let ended = match self.undecided {
            0 => String::new(),
            _ => format!("; {}", self.undecided_in_words()),
        };
        match &self.denominator {
            Denominator::EveryRun | Denominator::NoTrigger => {
                let every = match (self.trigger.is_some(), is_taken) {
                    (true, _) => format!(", each of which {}", words.one),
                    (false, true) => format!(", each of which is taken to {}", words.infinitive),
                    (false, false) => String::new(),
                };
                let (all, judged) = match self.undecided {
                    0 => ("of all", ""),
                    _ => ("of the", " with a verdict"),
                };
                format!("{count} {all} {trials} runs{judged}{every}{ended}")
            }
            Denominator::Triggered | Denominator::Covered => {
                let unknown = || "how many runs there were in all is not known".to_owned();
                let share = self.how_often(words).unwrap_or_else(unknown);
                format!("{count} of the {trials} {}{ended}; {share}", words.runs)
            }
            Denominator::OtherTrigger { trigger, .. } => {
                format!("{count} of the {trials} runs with {trigger}{ended}")
            }
            Denominator::AllRuns { reason } => {
                format!(
                    "{count} of all {trials} runs, whether or not they {}{}{ended}",
                    words.many,
                    because(reason)
                )
            }
        }
    }

    fn of_probability(&self, words: &Words) -> String {
        match &self.denominator {
            Denominator::EveryRun if self.trigger.is_some() => {
                format!("over all runs: every run {}", words.one)
            }
            Denominator::EveryRun | Denominator::NoTrigger => "over all runs".to_owned(),
            Denominator::Triggered | Denominator::Covered => {
                let share = match self.trigger.as_deref().and_then(probability) {
                    Some(share) => format!("the probability of that is {share}"),
                    None => "the probability of that is not known".to_owned(),
                };
                format!("given that a run {}; {share}", words.one)
            }
            Denominator::OtherTrigger { trigger, monitor } => {
                let share = match self.trigger.as_deref().and_then(probability) {
                    Some(share) => format!("; the probability of that is {share}"),
                    None => String::new(),
                };
                format!(
                    "given {trigger}{share}; its monitor is triggered by {monitor}, which are other runs"
                )
            }
            Denominator::AllRuns { reason } => {
                let share = self.how_often(words);
                let share = share.map_or(String::new(), |share| format!("; {share}"));
                let (many, because) = (&words.many, because(reason));
                format!("over all runs, whether or not they {many}{because}{share}")
            }
        }
    }

    /// The share of all runs that trigger the subject, as a sentence.
    fn how_often(&self, words: &Words) -> Option<String> {
        let trigger = self.trigger.as_deref()?;
        match trigger {
            Measure::Counts { count, trials, .. } if *trials > 0 => Some(format!(
                "{count} of {trials} runs {} ({})",
                words.many,
                percent(*count as f64 / *trials as f64)
            )),
            _ => Some(format!(
                "a run {} with probability {}",
                words.one,
                probability(trigger)?
            )),
        }
    }
}

fn because(reason: &str) -> String {
    match reason.trim_end_matches('.') {
        "" => String::new(),
        reason => format!(" ({reason})"),
    }
}

/// A computed probability; over all schedulers its range.
fn probability(measure: &Measure) -> Option<String> {
    match measure {
        Measure::Probability { .. } => share(measure),
        _ => None,
    }
}

/// A share of runs: counts, or a probability, over all schedulers its range.
pub(crate) fn share(measure: &Measure) -> Option<String> {
    match measure {
        Measure::Counts { count, trials, .. } => Some(format!("{count} of {trials}")),
        Measure::Probability { answer, .. } => Some(match answer.guarantee.over_schedulers() {
            Some((low, high)) => format!("{} to {}", percent(low), percent(high)),
            None => percent(answer.value),
        }),
        Measure::NotExpressible { .. } | Measure::NotCovered { .. } => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Guarantee;
    use crate::MethodAnswer;
    use stats::{Confidence, Sample};

    fn counts(successes: u64, trials: u64) -> Measure {
        let sample = Sample { successes, trials };
        Measure::of_counts(sample, None, Confidence::P95).expect("counts")
    }

    fn computed(value: f64, guarantee: Guarantee) -> Measure {
        Measure::Probability {
            answer: MethodAnswer {
                method: "sound".into(),
                value,
                complement: None,
                guarantee,
                iterations: None,
            },
            others: vec![],
            credible: None,
        }
    }

    fn finding(measure: Measure, denominator: Denominator, trigger: Option<Measure>) -> Finding {
        Finding {
            subject: Subject::Requirement("1".into()),
            measure,
            denominator,
            trigger: trigger.map(Box::new),
            undecided: 0,
            left_out: 0,
            completions: None,
            witnesses: vec![],
            readings: vec![],
        }
    }

    #[test]
    fn a_model_names_the_probability_of_its_trigger() {
        let exact = || Guarantee::Exact { rational: None };
        let schedulers = Guarantee::Schedulers {
            low: 0.1,
            high: 0.2,
            worst: None,
        };
        let given = |trigger| {
            let measure = computed(0.9, exact());
            finding(measure, Denominator::Triggered, trigger).condition(Some("near"))
        };
        assert_eq!(
            given(Some(computed(0.2, exact()))).as_deref(),
            Some("given that a run triggers it (near); the probability of that is 20 %")
        );
        assert_eq!(
            given(Some(computed(0.1, schedulers))).as_deref(),
            Some("given that a run triggers it (near); the probability of that is 10 % to 20 %")
        );
        assert_eq!(
            given(None).as_deref(),
            Some("given that a run triggers it (near); the probability of that is not known")
        );
    }

    #[test]
    fn a_number_over_all_runs_says_so_and_why() {
        let all = Denominator::AllRuns {
            reason: "unknown to the model.".into(),
        };
        let exact = Guarantee::Exact { rational: None };
        let found = finding(computed(0.9, exact), all, None).condition(None);
        assert_eq!(
            found.as_deref(),
            Some("over all runs, whether or not they trigger it (unknown to the model)")
        );
    }

    #[test]
    fn runs_without_a_verdict_are_counted_apart() {
        let of = |denominator, trigger| Finding {
            undecided: 3,
            ..finding(counts(7, 9), denominator, trigger)
        };
        assert_eq!(
            of(Denominator::Triggered, None).condition(None).as_deref(),
            Some(
                "7 of the 9 runs that trigger it; 3 more runs reached no verdict; how many runs there were in all is not known"
            )
        );
        assert_eq!(
            of(Denominator::EveryRun, None).condition(None).as_deref(),
            Some("7 of the 9 runs with a verdict; 3 more runs reached no verdict")
        );
    }

    /// A table that does not count its trigger, where the study names one.
    #[test]
    fn attempts_that_are_only_taken_to_trigger_it_are_said_to_be() {
        let found = finding(counts(7, 9), Denominator::EveryRun, None);
        assert_eq!(
            found.condition(Some("near")).as_deref(),
            Some("7 of all 9 runs, each of which is taken to trigger it (near)")
        );
        assert!(!found.takes_each_run_to_trigger(None));
        let known = finding(counts(7, 9), Denominator::EveryRun, Some(counts(9, 9)));
        assert!(!known.takes_each_run_to_trigger(Some("near")));
        let computed = computed(0.9, Guarantee::Exact { rational: None });
        let computed = finding(computed, Denominator::EveryRun, None);
        assert!(!computed.takes_each_run_to_trigger(Some("near")));
    }

    #[test]
    fn what_never_came_names_how_often_it_could_have() {
        let never = Measure::NotCovered {
            reason: String::new(),
            constant: None,
        };
        let found = finding(never, Denominator::Triggered, Some(counts(0, 960)));
        assert_eq!(
            found.condition(None).as_deref(),
            Some("0 of 960 runs trigger it (0 %)")
        );
    }
}
