//! The engines' settings and the materials of a scene's file.

use schemars::JsonSchema;
use serde::Deserialize;
use stimulus::Distribution;

use super::{key_of, number_within, within};
use crate::bench::ScenarioError;
use crate::physics::{Cone, MujocoSolver, RapierSolver, Softness, Surface};

/// How MuJoCo solves contacts; what is left out is as it was.
#[derive(Debug, Clone, Copy, Default, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MujocoKeys {
    /// Most iterations of the solver in a step; MuJoCo's own number if left out.
    pub iterations: Option<u32>,
    /// Improvement below which iterations end; MuJoCo's own if left out.
    pub tolerance: Option<f64>,
    /// The cone of friction; elliptic if left out.
    pub cone: Option<ConeKind>,
    /// How much harder friction is held than the normal direction; 10 if left out. More of it makes held things creep less.
    pub impratio: Option<f64>,
    /// Iterations after the solver that hold friction hard, so that held things do not creep; none if left out.
    #[serde(default)]
    pub no_slip_iterations: u32,
}

/// The form of the cone of friction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, JsonSchema, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ConeKind {
    /// Coulomb's law.
    Elliptic,
    /// A pyramid in it: faster, and friction depends on its direction.
    Pyramidal,
}

/// How Rapier solves contacts; what is left out is as it was.
#[derive(Debug, Clone, Copy, Default, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RapierKeys {
    /// Substeps of the solver in a time step; 4 if left out.
    pub substeps: Option<usize>,
    /// How stiff contacts are: the natural frequency of their springs; Rapier's own if left out.
    pub contact_frequency_hz: Option<f64>,
    /// How damped they are, with 1 for critical damping; Rapier's own if left out.
    pub contact_damping_ratio: Option<f64>,
}

impl MujocoKeys {
    pub(in crate::scene) fn solver(&self) -> MujocoSolver {
        let own = MujocoSolver::default();
        MujocoSolver {
            iterations: self.iterations,
            tolerance: self.tolerance,
            cone: match self.cone {
                Some(ConeKind::Pyramidal) => Cone::Pyramidal,
                Some(ConeKind::Elliptic) | None => Cone::Elliptic,
            },
            impratio: self.impratio.unwrap_or(own.impratio),
            no_slip_iterations: self.no_slip_iterations,
        }
    }

    pub(super) fn check(&self) -> Result<(), ScenarioError> {
        let key = |field: &str| format!("simulation.mujoco.{field}");
        let iterations = f64::from(self.iterations.unwrap_or(1));
        number_within(&key("iterations"), iterations, 1.0, 1e5)?;
        number_within(&key("tolerance"), self.tolerance.unwrap_or(0.0), 0.0, 1.0)?;
        number_within(&key("impratio"), self.impratio.unwrap_or(1.0), 1e-3, 1e6)?;
        let iterations = f64::from(self.no_slip_iterations);
        number_within(&key("no_slip_iterations"), iterations, 0.0, 1e5)
    }
}

impl RapierKeys {
    pub(in crate::scene) fn solver(&self) -> RapierSolver {
        RapierSolver {
            substeps: self.substeps.unwrap_or(RapierSolver::default().substeps),
            contact_frequency_hz: self.contact_frequency_hz,
            contact_damping_ratio: self.contact_damping_ratio,
            ..RapierSolver::default()
        }
    }

    pub(super) fn check(&self) -> Result<(), ScenarioError> {
        let key = |field: &str| format!("simulation.rapier.{field}");
        let substeps = self.substeps.unwrap_or(1) as f64;
        number_within(&key("substeps"), substeps, 1.0, 1000.0)?;
        let hz = self.contact_frequency_hz.unwrap_or(1.0);
        number_within(&key("contact_frequency_hz"), hz, 1e-2, 1e6)?;
        let ratio = self.contact_damping_ratio.unwrap_or(1.0);
        number_within(&key("contact_damping_ratio"), ratio, 1e-3, 1e3)
    }
}

/// What a surface is made of. What it gives takes the place of what the thing or its description says; of two surfaces that of
/// the smaller friction holds.
#[derive(Debug, Clone, JsonSchema, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Material {
    /// Its name, which `material` of robots, objects, people and the ground refers to.
    pub name: String,
    /// Coulomb friction.
    pub friction: Option<Distribution>,
    /// Friction against turning about the normal: torque over normal force. MuJoCo alone.
    pub torsional_friction_m: Option<f64>,
    /// Friction against rolling: torque over normal force. MuJoCo alone.
    pub rolling_friction_m: Option<f64>,
    /// Within which time a penetration goes back (the first of MuJoCo's `solref`): the shorter, the harder; at least two time
    /// steps. MuJoCo alone.
    pub contact_time_secs: Option<f64>,
    /// How that is damped, with 1 for critical damping (the second of `solref`); 1 if left out.
    pub contact_damping_ratio: Option<f64>,
    /// MuJoCo's `solimp`: least and greatest impedance (0 to 1), the penetration in metres at which the greatest is reached,
    /// the midpoint and the power of the curve between them.
    pub contact_impedance: Option<[f64; 5]>,
}

impl Material {
    /// Its surface besides its friction.
    pub(in crate::scene) fn surface(&self) -> Surface {
        let is_soft = self.contact_time_secs.is_some()
            || self.contact_damping_ratio.is_some()
            || self.contact_impedance.is_some();
        Surface {
            torsional_m: self.torsional_friction_m,
            rolling_m: self.rolling_friction_m,
            // What is left out is MuJoCo's own.
            softness: is_soft.then(|| Softness {
                time_constant_secs: self.contact_time_secs.unwrap_or(0.02),
                damping_ratio: self.contact_damping_ratio.unwrap_or(1.0),
                impedance: self.contact_impedance,
            }),
        }
    }

    pub(super) fn check(&self, time_step_secs: f64) -> Result<(), ScenarioError> {
        let key = |field: &str| key_of("material", &self.name, field);
        if let Some(friction) = &self.friction {
            within(&key("friction"), friction, 0.0, 10.0)?;
        }
        for (field, value) in [
            ("torsional_friction_m", self.torsional_friction_m),
            ("rolling_friction_m", self.rolling_friction_m),
        ] {
            number_within(&key(field), value.unwrap_or(0.0), 0.0, 10.0)?;
        }
        if let Some(secs) = self.contact_time_secs {
            // Shorter ones MuJoCo lengthens without a word.
            number_within(&key("contact_time_secs"), secs, 2.0 * time_step_secs, 10.0)?;
        }
        let ratio = self.contact_damping_ratio.unwrap_or(1.0);
        number_within(&key("contact_damping_ratio"), ratio, 1e-3, 1e3)?;
        // The spring's frequency is their product's inverse: a stiffer one gains energy in each contact.
        let secs = ratio.min(1.0) * self.contact_time_secs.unwrap_or(0.02);
        if secs < 2.0 * time_step_secs {
            let problem = format!(
                "times `contact_time_secs` is {secs} s and must be at least two time steps of {time_step_secs} s, or contacts gain energy"
            );
            return Err(ScenarioError::value(
                &key("contact_damping_ratio"),
                &problem,
            ));
        }
        let Some([least, greatest, width_m, midpoint, power]) = self.contact_impedance else {
            return Ok(());
        };
        for (value, [low, high]) in [
            (least, [1e-4, 0.9999]),
            (greatest, [least, 0.9999]),
            (width_m, [0.0, 1.0]),
            (midpoint, [1e-4, 0.9999]),
            (power, [1.0, 100.0]),
        ] {
            number_within(&key("contact_impedance"), value, low, high)?;
        }
        Ok(())
    }
}
