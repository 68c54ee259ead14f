//! What became of an episode that was made small.

use super::trials::Shrunken;
use campaign::{ShrinkOptions, Size};
use diagnostic::counted;
use evidence::CauseSetting;
use schemars::JsonSchema;
use serde::Serialize;
use std::path::Path;
use stimulus::{AbstractTest, Distribution, Stimulus};
use study::Finding;

/// A scenario that was made small.
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
    /// Those of them in the fast physics, which proposes smaller scenarios; all else is of the full physics.
    pub fast_episodes: u64,
    /// Whether every single action, value and setting was tried to be left
    /// out, and every number to come nearer to its nominal value.
    pub is_minimal: bool,
    /// In how many seeds it must show, and of how many.
    pub seeds: [u32; 2],
    /// By how much what is kept had to violate its requirement, as a share of what is allowed. Absent where no number says by how
    /// much it is violated.
    pub margin: Option<f64>,
    /// By how much the finding and the regression do.
    pub violated_by: Option<[f64; 2]>,
    /// Numbers that the seed drew and that are settings now.
    pub pinned: u64,
    /// Why none are, if that is so: then what is left can owe to what the seed draws.
    pub not_pinned: Option<String>,
    /// What is set otherwise than nominal.
    pub causes: Vec<CauseSetting>,
    /// The finding.
    pub before: ExtentReport,
    /// The regression.
    pub after: ExtentReport,
    /// What is done in the regression; the file has all of it.
    #[serde(skip)]
    #[schemars(skip)]
    pub test: AbstractTest,
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
            // A sum of nothing is -0.
            delay_secs: delays.fold(0.0, |sum, secs| sum + secs),
            simulated_secs,
        }
    }
}

impl ShrinkReport {
    /// What became of a finding.
    pub(super) fn new(
        shrunk: &Shrunken,
        finding: &Finding,
        target: &Path,
        options: &ShrinkOptions,
    ) -> Self {
        let [before_secs, after_secs] = shrunk.simulated_secs;
        let kept = &shrunk.regression.stimulus;
        let others = kept.settings.iter();
        let others = others.filter(|(key, value)| options.nominal.get(*key) != Some(*value));
        Self {
            format: "1.3".into(),
            shows: finding.shows.to_string(),
            file: target.display().to_string(),
            episodes: shrunk.episodes,
            fast_episodes: shrunk.fast_episodes,
            is_minimal: shrunk.is_minimal,
            seeds: shrunk.seeds.into(),
            margin: shrunk.margin.map(|it| it.least),
            violated_by: shrunk
                .margin
                .zip(shrunk.violated_by)
                .map(|(it, kept)| [it.own, kept]),
            pinned: shrunk.pinned as u64,
            not_pinned: shrunk.not_pinned.clone(),
            causes: others
                .map(|(key, value)| CauseSetting {
                    key: key.clone(),
                    value: value.to_string(),
                    nominal: options.nominal.get(key).map(ToString::to_string),
                })
                .collect(),
            before: ExtentReport::new(&finding.stimulus, options, before_secs),
            after: ExtentReport::new(kept, options, after_secs),
            test: kept.test.clone(),
        }
    }

    /// The episodes that were run, and which of them were of the fast physics.
    pub fn episodes_in_words(&self) -> String {
        match self.fast_episodes {
            0 => counted(self.episodes, "episode"),
            fast => format!(
                "{}, {fast} of them in the fast physics, whose proposals the full physics has to show",
                counted(self.episodes, "episode")
            ),
        }
    }

    /// How clearly it is violated.
    pub fn clarity_in_words(&self) -> String {
        match (self.margin, self.violated_by) {
            (Some(margin), Some([own, kept])) => format!(
                "violated by {kept:.3} of what is allowed (the finding by {own:.3}; at least {margin:.3} was asked for)"
            ),
            _ => "no number says how clearly it is shown".to_owned(),
        }
    }

    /// What it takes, as far as it is set.
    pub fn causes_in_words(&self) -> String {
        let causes: Vec<String> = self.causes.iter().map(ToString::to_string).collect();
        let with = match causes.is_empty() {
            true => String::new(),
            false => format!("With {}", causes.join(", ")),
        };
        match (&self.not_pinned, with.is_empty()) {
            (None, true) => "All parameters are at their nominal values.".to_owned(),
            (None, false) => format!("{with}; all other parameters are at their nominal values."),
            (Some(reason), true) => {
                format!("What its seed draws is not set and may be the cause: {reason}.")
            }
            (Some(reason), false) => {
                format!("{with}. What its seed draws is not set and may matter: {reason}.")
            }
        }
    }

    /// What stands above the regression.
    pub(super) fn comment(&self, from: &str) -> String {
        let ExtentReport {
            actions,
            settings,
            simulated_secs,
            ..
        } = self.after;
        let before = &self.before;
        let [least, all] = self.seeds;
        let in_seeds = match all {
            1 => "with this seed".to_owned(),
            _ => format!("in at least {least} of {all} seeds, this one among them"),
        };
        let file = Path::new(&self.file).file_name().unwrap_or_default();
        let minimal = match self.is_minimal {
            true => "No single action, value or setting can be left out.",
            false => "Perhaps it can be made smaller still: the search ended early.",
        };
        format!(
            "Shows: {}, {in_seeds}: {}.\n{}\nMade of {from}: {} to {actions}, {} not nominal to {settings}, {:.1} s to {simulated_secs:.1} s, in\n{}.\n{minimal}\n\
             Once it is fixed, write `expected = \"passes\"` below (or: corroborate replay STUDY --check --update).\n\
             To look at it: corroborate replay STUDY regressions/{}",
            self.shows,
            self.clarity_in_words(),
            self.causes_in_words(),
            counted(before.actions, "action"),
            counted(before.settings, "setting"),
            before.simulated_secs,
            self.episodes_in_words(),
            file.to_string_lossy()
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_at_all_takes_no_time_and_is_said_in_words() {
        let stimulus = Stimulus::of(AbstractTest::new("nothing", Vec::new()));
        let extent = ExtentReport::new(&stimulus, &ShrinkOptions::default(), 1.0);
        assert_eq!(format!("{:.2}", extent.delay_secs), "0.00");
    }

    #[test]
    fn the_cause_is_named_with_its_nominal_value() {
        let extent = ExtentReport {
            actions: 1,
            values: 0,
            settings: 1,
            delay_secs: 0.0,
            simulated_secs: 1.0,
        };
        let cause = CauseSetting {
            key: "hand.friction".into(),
            value: "0.32".into(),
            nominal: Some("0.6".into()),
        };
        let mut report = ShrinkReport {
            format: "1.3".into(),
            shows: "it".into(),
            file: "f.toml".into(),
            episodes: 1,
            fast_episodes: 0,
            is_minimal: true,
            seeds: [1, 1],
            margin: Some(0.1),
            violated_by: Some([0.4, 0.11]),
            pinned: 3,
            not_pinned: None,
            causes: vec![cause],
            before: extent,
            after: extent,
            test: AbstractTest::new("nothing", Vec::new()),
        };
        let expected = "With hand.friction = 0.32 (nominal 0.6); all other";
        assert!(
            report.causes_in_words().starts_with(expected),
            "{}",
            report.causes_in_words()
        );
        report.not_pinned = Some("no budget".into());
        report.causes.clear();
        assert!(
            report
                .causes_in_words()
                .contains("may be the cause: no budget")
        );
    }
}
