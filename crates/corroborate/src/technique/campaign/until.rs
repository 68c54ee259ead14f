//! "Until requirement R is decided": when a campaign may end without spoiling what it says.
//!
//! After each episode of the prefix 1..=n the counts of R are looked at by a test that holds at
//! every n at once (`stats::SequentialTest`). The first n at which it decides whether the rate
//! reaches the requirement's threshold ends the campaign, so n is a function of the episodes alone.
//!
//! Where the threshold is the requirement's own, the counts have to show the same at the level that the study's conclusion
//! asks of them, too: its level, less what looking again may cost, divided among all requirements and all pieces of the same
//! kind, as if none of the others showed anything. A campaign that ended before would leave its requirement undecided for
//! good. It is a condition more for ending, and the intervals hold whatever ends it.

use super::anytime;
use diagnostic::Problem;
use evidence::{Direction, ErrorFamily, Requirement, Subject, Threshold, WitnessOf};
use host::store::Inputs;
use stats::{Confidence, Decision, SHARE_OF_A_LOOK, Sample, SequentialTest};
use study::{Entry, SampleSizes, Study, UntilText};

/// A stopping rule of a study's requirement.
#[derive(Clone, Debug)]
pub struct Until {
    subject: Subject,
    test: SequentialTest,
    confidence: f64,
    direction: Direction,
    verdict: Option<LevelOfVerdict>,
}

/// At which level the study's conclusion takes the counts as showing the requirement's threshold met or missed.
#[derive(Clone, Copy, Debug)]
struct LevelOfVerdict {
    threshold: Threshold,
    /// Of the intervals, to which the counts' effective size belongs.
    intervals: Confidence,
    claim: Confidence,
}

impl LevelOfVerdict {
    /// The least level of all that the conclusion may come to.
    fn new(study: &Study, entry: &Entry, requirement: &Requirement) -> Option<Self> {
        let threshold = requirement.threshold?;
        let intervals = Confidence::new(study.about.confidence).ok()?;
        let looks = match study.about.sample_sizes {
            SampleSizes::Growing => SHARE_OF_A_LOOK,
            SampleSizes::Fixed => 1.0,
        };
        let requirements = match study.about.verdicts.error_rate {
            ErrorFamily::Requirement => 1,
            ErrorFamily::Study => {
                let with_threshold = study
                    .requirements
                    .iter()
                    .filter(|it| it.threshold.is_some());
                with_threshold.count()
            }
        };
        let of_system = |it: &Entry| it.work.parts().technique.witness_of() == WitnessOf::System;
        let pieces = study
            .ledger
            .iter()
            .filter(|it| of_system(it) == of_system(entry));
        let sharing = (requirements.max(1) * pieces.count().max(1)) as f64;
        let claim = Confidence::new(1.0 - intervals.alpha() * looks / sharing).ok()?;
        Some(Self {
            threshold,
            intervals,
            claim,
        })
    }

    /// Whether each of these counts shows it met, or each shows it missed.
    fn is_reached(&self, ends: [Sample; 2]) -> bool {
        let [one, other] = ends
            .map(|end| evidence::shown(&anytime(end, self.intervals), self.threshold, self.claim));
        one.is_some() && one == other
    }
}

/// A rule as the command line has it: `requirement 1a is decided at 99 %`, or `requirement 3 is
/// decided against 0.9 at 99 %`.
pub fn parse(text: &str) -> Result<UntilText, Problem> {
    let spaced = text.replace('%', " % ");
    let words: Vec<&str> = spaced.split_whitespace().collect();
    let parsed = match words.as_slice() {
        ["requirement", id, "is", "decided", "at", percent, "%"] => Some((id, None, percent)),
        [
            "requirement",
            id,
            "is",
            "decided",
            "against",
            threshold,
            "at",
            percent,
            "%",
        ] => Some((id, Some(threshold), percent)),
        _ => None,
    };
    let number = |text: &str| text.parse::<f64>().ok();
    let rule = parsed.and_then(|(id, threshold, percent)| {
        Some(UntilText {
            requirement: (*id).to_owned(),
            // Nearer to what is meant than a division by 100 would be.
            confidence: number(&format!("{percent}e-2"))?,
            threshold: match threshold {
                Some(threshold) => Some(number(threshold)?),
                None => None,
            },
        })
    });
    rule.ok_or_else(|| {
        Problem::new("bad-until", format!("`{text}` is not a valid rule for when to end"))
            .remedy("say for example `requirement 1a is decided at 99 %`, or `requirement 3 is decided against 0.9 at 99 %`")
    })
}

impl Until {
    /// The rule of an entry as written, held against the study.
    pub fn new(study: &Study, entry: &Entry, text: &UntilText) -> Result<Self, Problem> {
        let problem = |message: String| Problem::new("bad-until", message);
        let wanted = &text.requirement;
        let Some(requirement) = study.requirements.iter().find(|r| &r.id == wanted) else {
            let known: Vec<&str> = study.requirements.iter().map(|r| r.id.as_str()).collect();
            return Err(problem(format!("the study has no requirement `{wanted}`"))
                .remedy(format!("name one of {}", known.join(", "))));
        };
        let subject = Subject::Requirement(requirement.id.clone());
        if study
            .forms
            .of(&subject)
            .is_none_or(|form| form.monitor.is_none())
        {
            return Err(problem(format!(
                "requirement {wanted} has no monitor, so no episode decides it"
            ))
            .remedy("name a requirement that is judged on traces"));
        }
        let threshold = text.threshold.or(requirement.threshold.map(|it| it.value));
        let Some(threshold) = threshold else {
            return Err(problem(format!(
                "requirement {wanted} has no threshold, so nothing tells when it is decided"
            ))
            .remedy("say against which rate, for example `decided against 0.95 at 99 %`, or `threshold = 0.95` in the ledger"));
        };
        let bad = |error: stats::StatsError| problem(error.to_string());
        let confidence = stats::Confidence::new(text.confidence).map_err(bad)?;
        Ok(Self {
            subject,
            test: SequentialTest::new(threshold, confidence).map_err(bad)?,
            confidence: text.confidence,
            direction: requirement
                .threshold
                .map_or(Direction::AtLeast, |it| it.direction),
            verdict: match requirement.threshold.map(|it| it.value) == Some(threshold) {
                true => LevelOfVerdict::new(study, entry, requirement),
                false => None,
            },
        })
    }

    /// When it ends a campaign depends on the threshold, and on what shares the level.
    pub fn inputs(&self, inputs: &mut Inputs) {
        inputs.add_json("decided_against", &self.test.threshold());
        if let Some(verdict) = &self.verdict {
            inputs.add_json("decided_at", &verdict.claim.level());
        }
    }

    /// Whose counts decide.
    pub fn subject(&self) -> &Subject {
        &self.subject
    }

    /// Whether these counts show that the requirement is met, whatever runs without a verdict would have shown
    /// (`Tally::completions`); `None` if they do not decide it.
    pub fn is_met(&self, ends: [stats::Sample; 2]) -> Option<bool> {
        match (self.decide(ends), self.direction) {
            (Decision::Open, _) => None,
            (Decision::AtLeast, direction) => Some(direction == Direction::AtLeast),
            (Decision::Below, direction) => Some(direction == Direction::AtMost),
        }
    }

    /// What these counts decide.
    pub fn decide(&self, ends: [stats::Sample; 2]) -> Decision {
        let [lowest, highest] = ends.map(|end| self.test.decide(end));
        let is_enough = |verdict: &LevelOfVerdict| verdict.is_reached(ends);
        match lowest == highest && self.verdict.as_ref().is_none_or(is_enough) {
            true => lowest,
            false => Decision::Open,
        }
    }

    /// What came of it, for the evidence.
    pub fn outcome_in_words(&self, ends: [stats::Sample; 2], episodes: u64, most: u64) -> String {
        let about = format!("requirement {}", self.subject.id());
        let percent = self.confidence * 100.0;
        let threshold = self.test.threshold();
        let side = match self.decide(ends) {
            Decision::AtLeast => format!("its rate is at least {threshold}"),
            Decision::Below => format!("its rate is below {threshold}"),
            Decision::Open => {
                let verdict = match self.verdict {
                    Some(_) => ", so that its verdict is, too,",
                    None => "",
                };
                return format!(
                    "{about} was not decided against {threshold} at {percent} %{verdict} within {episodes} episodes; intervals hold at every number of episodes"
                );
            }
        };
        format!(
            "ended after {episodes} of at most {most} episodes, when {about} was decided at {percent} % ({side}), by a test that holds at every number of episodes, as the intervals do"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_without_a_verdict_end_no_campaign_that_they_could_turn() {
        let sample = |successes, trials| stats::Sample { successes, trials };
        let until = Until {
            subject: Subject::Requirement("1".into()),
            test: SequentialTest::new(0.5, stats::Confidence::P95).expect("a test"),
            confidence: 0.95,
            direction: Direction::AtLeast,
            verdict: None,
        };
        let (all, most) = (sample(40, 40), sample(40, 44));
        assert_eq!(until.is_met([all, all]), Some(true));
        assert_eq!(until.is_met([most, sample(44, 44)]), Some(true));
        assert_eq!(until.is_met([sample(40, 80), sample(80, 80)]), None);
        assert_eq!(
            until.decide([sample(0, 80), sample(80, 80)]),
            Decision::Open
        );
    }

    #[test]
    fn rules_are_read_from_words() {
        let rule = parse("requirement 1a is decided at 99 %").expect("a rule");
        assert_eq!((rule.requirement.as_str(), rule.confidence), ("1a", 0.99));
        assert_eq!(rule.threshold, None);
        let rule = parse("requirement 3 is decided against 0.9 at 99.9%").expect("a rule");
        assert_eq!((rule.threshold, rule.confidence), (Some(0.9), 0.999));
        for bad in [
            "",
            "requirement 1 is decided",
            "requirement 1 is decided at 99",
            "requirement 1 is decided at nine %",
            "requirement 1 is decided against x at 99 %",
            "requirement  is decided at 99 %",
        ] {
            let problem = parse(bad).expect_err(bad);
            assert_eq!(problem.code, "bad-until");
        }
    }
}
