//! A scenario, a parameter set and an abstract test: everything an episode needs but its seed.

use std::sync::Arc;

use testbench::{Distribution, Drawn, SimError, Stream};

use super::plant::{Plant, arm_joint_names};
use crate::model::{Contacts, PhysicalDraws, standing_pose};
use crate::physics::Physics;
use crate::purpose::Purpose;
use crate::robot::ResetPose;
use crate::scenario::{AbstractTest, Parameters, Scenario};

/// A scenario with a parameter set and a test, ready to run episodes. Cloning it is cheap.
#[derive(Debug, Clone)]
pub struct World(Arc<Setup>);

/// What a world is made of.
#[derive(Debug, Clone)]
pub(crate) struct Setup {
    pub(crate) physics: Physics,
    pub(crate) scenario: Scenario,
    pub(crate) parameters: Parameters,
    pub(crate) test: AbstractTest,
    pub(crate) arm_joints: Vec<String>,
    /// How pairs that can touch are found.
    pub(crate) contacts: Contacts,
}

impl World {
    /// A world whose human enacts the scenario's first abstract test.
    ///
    /// # Errors
    /// When the physics engine refuses the scenario's model.
    pub fn new(
        physics: impl Into<Physics>,
        scenario: &Scenario,
        parameters: &Parameters,
    ) -> Result<Self, SimError> {
        let physics = physics.into();
        let world = Self::unchecked(&physics, scenario.clone(), parameters.clone())?;
        // A model that cannot be built is found here rather than in the first episode.
        let draws = world.physical_draws(0);
        Plant::new(
            &physics,
            scenario,
            parameters,
            &draws,
            world.setup().contacts,
        )?;
        Ok(world)
    }

    /// As [`World::new`], but a model that the engine refuses is found in the first episode.
    pub(crate) fn unchecked(
        physics: &Physics,
        scenario: Scenario,
        parameters: Parameters,
    ) -> Result<Self, SimError> {
        let Some(test) = scenario.abstract_tests.first().cloned() else {
            return Err(SimError::UnknownTest {
                name: String::new(),
            });
        };
        Ok(Self(Arc::new(Setup {
            physics: physics.clone(),
            arm_joints: arm_joint_names(&scenario),
            scenario,
            parameters,
            test,
            contacts: Contacts::default(),
        })))
    }

    /// The same world with the human enacting another abstract test of the scenario.
    ///
    /// # Errors
    /// [`SimError::UnknownTest`].
    pub fn with_test(self, name: &str) -> Result<Self, SimError> {
        let test = self.0.scenario.abstract_test(name).cloned();
        let unknown = || SimError::UnknownTest {
            name: name.to_owned(),
        };
        Ok(self.enacting(test.ok_or_else(unknown)?))
    }

    /// The same world, whose engine finds contacts as it does by itself.
    #[cfg(test)]
    pub(crate) fn finding_contacts(mut self) -> Self {
        Arc::make_mut(&mut self.0).contacts = Contacts::Found;
        self
    }

    /// The same world in the fast physics.
    pub(crate) fn in_fast_physics(mut self) -> Self {
        Arc::make_mut(&mut self.0).scenario.simulation.fast = true;
        self
    }

    /// The same world with the human enacting this test.
    #[must_use]
    pub fn enacting(mut self, test: AbstractTest) -> Self {
        Arc::make_mut(&mut self.0).test = test;
        self
    }

    /// What the world is made of.
    pub(crate) fn setup(&self) -> &Setup {
        &self.0
    }

    /// The physical draws of the episode with `seed`.
    #[must_use]
    pub fn physical_draws(&self, seed: u64) -> PhysicalDraws {
        let Setup {
            scenario,
            parameters,
            ..
        } = self.setup();
        let mut stream = Stream::new(seed, Purpose::Object);
        let object = &parameters.object;
        let object_mass_kg = object.mass_kg.draw(&mut stream);
        let friction = parameters.hand.friction.draw(&mut stream);
        let [x_m, y_m] = scenario.object.position_m;
        let x_m = x_m + object.x_error_m.draw(&mut stream);
        let y_m = y_m + object.y_error_m.draw(&mut stream);
        let yaw_rad = object.yaw_rad.draw(&mut stream);
        PhysicalDraws {
            object_mass_kg,
            friction,
            object_pose: standing_pose(scenario, x_m, y_m, yaw_rad),
        }
    }

    /// The numbers that the episode with `seed` draws once, and what each of them is. What is drawn
    /// several times in an episode (the reset's angles, the planner's answers) is none of them.
    pub(crate) fn drawn(&self, seed: u64) -> Vec<Drawn> {
        let parameters = &self.setup().parameters;
        let (object, human) = (&parameters.object, &parameters.human);
        // Each stream in the order in which the episode draws from it.
        let of_object = [
            ("object.mass_kg", &object.mass_kg),
            ("hand.friction", &parameters.hand.friction),
            ("object.x_error_m", &object.x_error_m),
            ("object.y_error_m", &object.y_error_m),
            ("object.yaw_rad", &object.yaw_rad),
        ];
        let of_human = [
            ("human.head_height_offset_m", &human.head_height_offset_m),
            ("human.yaw_error_rad", &human.yaw_error_rad),
            (
                "human.yaw_error_when_away_rad",
                &human.yaw_error_when_away_rad,
            ),
            ("human.pull_forward_newtons", &human.pull_forward_newtons),
            ("human.pull_up_newtons", &human.pull_up_newtons),
        ];
        let mut drawn = Vec::new();
        for (purpose, keys) in [(Purpose::Object, of_object), (Purpose::Human, of_human)] {
            let mut stream = Stream::new(seed, purpose);
            for (key, distribution) in keys {
                let value = distribution.draw(&mut stream);
                if !matches!(distribution, Distribution::Constant(_)) {
                    drawn.push(Drawn {
                        key: format!("parameters.{key}"),
                        value,
                        middle: distribution.middle(),
                    });
                }
            }
        }
        drawn
    }

    /// The pose the robot resets to in the episode with `seed`.
    pub(crate) fn reset_pose(&self, seed: u64) -> ResetPose {
        let scenario = &self.setup().scenario;
        let mut stream = Stream::new(seed, Purpose::RobotPose);
        let mut angles = scenario.robot.poses.neutral.clone();
        for joint in &scenario.programme.reset_joints {
            let offset_rad = scenario.programme.reset_spread_rad.draw(&mut stream);
            *angles.entry(joint.clone()).or_insert(0.0) += offset_rad;
        }
        ResetPose(angles)
    }
}
