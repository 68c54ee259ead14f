//! The numbers that an episode drew from its seed, as settings.
//!
//! A cause that is left to the seed is no explanation: "activate, with seed 17" says nothing of the
//! friction that this seed draws. So each number that is drawn once in the episode becomes a
//! setting of the same value, and counts as nominal only where it has its nominal value: what the
//! exploration declares, or the middle of what it is drawn from.

use crate::technique::exploration::OpenBench;
use campaign::ShrinkOptions;
use diagnostic::Problem;
use stimulus::{Setting, Settings, Stimulus};
use study::Finding;

/// What is set instead of drawn.
#[derive(Debug)]
pub struct Pins {
    /// The stimulus with its draws as settings.
    pub stimulus: Stimulus,
    /// The nominal values of all that the bench would draw.
    nominal: Settings,
}

impl Pins {
    /// Those of a finding's episode; `None` where the bench does not say what it draws.
    pub fn of(bench: &OpenBench, finding: &Finding) -> Result<Option<Self>, Problem> {
        let bare = Stimulus::of(finding.stimulus.test.clone());
        let (Some(all), Some(drawn)) = (
            bench.drawn(&bare, finding.seed)?,
            bench.drawn(&finding.stimulus, finding.seed)?,
        ) else {
            return Ok(None);
        };
        let mut stimulus = finding.stimulus.clone();
        for number in drawn {
            let value = Setting::Number(number.value);
            stimulus.settings.insert(number.key, value);
        }
        let nominal = all.into_iter();
        Ok(Some(Self {
            stimulus,
            nominal: nominal
                .map(|number| (number.key, Setting::Number(plain(number.middle))))
                .collect(),
        }))
    }

    /// How many numbers are set that the finding left to the seed.
    pub fn count(&self, finding: &Finding) -> usize {
        self.stimulus.settings.len() - finding.stimulus.settings.len()
    }

    /// What shrinking is allowed to do with them.
    pub fn into_options(self, options: &mut ShrinkOptions) {
        for (key, middle) in self.nominal {
            options.nominal.entry(key.clone()).or_insert(middle);
            options.drawn.insert(key);
        }
    }
}

/// A middle without the digits that only rounding gave it.
fn plain(middle: f64) -> f64 {
    format!("{middle:.5e}").parse().unwrap_or(middle)
}
