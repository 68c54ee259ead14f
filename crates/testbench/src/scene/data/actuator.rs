//! Errors and faults of drives in a scene's file.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;
use stimulus::Distribution;

use super::body::Actuator;
use super::sensor::key_with_unit;
use super::{key_of, whole_steps, within};
use crate::bench::ScenarioError;
use crate::controller::PortField;

/// A fault of a drive.
#[derive(Debug, Clone, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ActuatorFault {
    /// What happens.
    pub kind: ActuatorFaultKind,
    /// Probability that it occurs in an episode.
    #[serde(default = "one")]
    pub probability: Distribution,
    /// When it begins.
    pub from_secs: Distribution,
    /// When it ends; never if left out.
    pub until_secs: Option<Distribution>,
    /// The share of its gain and of its limit that is left, for the kind `weak`.
    pub strength: Option<Distribution>,
    /// How much later than commanded it acts, for the kind `delayed`.
    pub delay_secs: Option<Distribution>,
    /// Half the width of the dead band, by field with its unit, for the kind `dead_band`.
    #[serde(default)]
    pub dead_band: BTreeMap<String, Distribution>,
    /// Standard deviation of more noise, by field with its unit, for the kind `noisy`.
    #[serde(default)]
    pub noise: BTreeMap<String, Distribution>,
    /// What is added to commands, by field with its unit, for the kind `offset`.
    #[serde(default)]
    pub offset: BTreeMap<String, Distribution>,
}

/// Kinds of fault of a drive.
#[derive(Debug, Clone, Copy, PartialEq, Eq, JsonSchema, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ActuatorFaultKind {
    /// It goes on with what it was doing, whatever it is told.
    Stuck,
    /// It has a share of its gain and of its limit; with none it is limp.
    Weak,
    /// It does what it is told, but later.
    Delayed,
    /// Small commands do nothing.
    DeadBand,
    /// It adds noise to commands.
    Noisy,
    /// It adds a constant to commands.
    Offset,
}

fn one() -> Distribution {
    Distribution::Constant(1.0)
}

/// Noise is drawn anew so often, if a drive does not say it.
pub(super) fn hundred() -> f64 {
    100.0
}

impl Actuator {
    /// Checks the keys and ranges of noise, bias and faults.
    pub(super) fn check_errors(&self, time_step_secs: f64) -> Result<(), ScenarioError> {
        let key = |field: &str| key_of(self.list, &self.name, field);
        whole_steps(&key("noise_hz"), 1.0 / self.noise_hz, time_step_secs)?;
        let fields = self.fields();
        let check = |list: &str, errors: &BTreeMap<String, Distribution>, low: f64| {
            check_by_field(&key(list), errors, &fields, low)
        };
        check("noise", &self.noise, 0.0)?;
        check("bias", &self.bias, -1e6)?;
        for (index, fault) in self.faults.iter().enumerate() {
            let name = |name: &str| format!("fault.{index}.{name}");
            within(&key(&name("probability")), &fault.probability, 0.0, 1.0)?;
            within(&key(&name("from_secs")), &fault.from_secs, 0.0, 1e6)?;
            if let Some(until_secs) = &fault.until_secs {
                within(&key(&name("until_secs")), until_secs, 0.0, 1e6)?;
            }
            check(&name("dead_band"), &fault.dead_band, 0.0)?;
            check(&name("noise"), &fault.noise, 0.0)?;
            check(&name("offset"), &fault.offset, -1e6)?;
            if let Some(strength) = &fault.strength {
                within(&key(&name("strength")), strength, 0.0, 1.0)?;
            }
            if let Some(delay_secs) = &fault.delay_secs {
                within(&key(&name("delay_secs")), delay_secs, 0.0, 60.0)?;
            }
            fault.check_kind(&key(&name("kind")))?;
        }
        Ok(())
    }
}

impl ActuatorFault {
    /// A fault has the numbers of its kind, and those of no other.
    fn check_kind(&self, key: &str) -> Result<(), ScenarioError> {
        let given = [
            ("strength", self.strength.is_some()),
            ("delay_secs", self.delay_secs.is_some()),
            ("dead_band", !self.dead_band.is_empty()),
            ("noise", !self.noise.is_empty()),
            ("offset", !self.offset.is_empty()),
        ];
        let wanted = match self.kind {
            ActuatorFaultKind::Stuck => "",
            ActuatorFaultKind::Weak => "strength",
            ActuatorFaultKind::Delayed => "delay_secs",
            ActuatorFaultKind::DeadBand => "dead_band",
            ActuatorFaultKind::Noisy => "noise",
            ActuatorFaultKind::Offset => "offset",
        };
        for (name, is_given) in given {
            if is_given != (name == wanted) {
                let problem = match is_given {
                    true => format!("has no `{name}`, which stands beside it"),
                    false => format!("needs `{name}`, which says how much"),
                };
                return Err(ScenarioError::value(key, &problem));
            }
        }
        Ok(())
    }
}

/// Errors belong to fields, with the field's unit in the key.
fn check_by_field(
    list: &str,
    errors: &BTreeMap<String, Distribution>,
    fields: &[PortField],
    low: f64,
) -> Result<(), ScenarioError> {
    let keys: Vec<String> = fields.iter().map(key_with_unit).collect();
    for (name, distribution) in errors {
        let key = format!("{list}.{name}");
        if !keys.contains(name) {
            let problem = format!("is unknown; it may be one of {}", keys.join(", "));
            return Err(ScenarioError::value(&key, &problem));
        }
        within(&key, distribution, low, 1e6)?;
    }
    Ok(())
}
