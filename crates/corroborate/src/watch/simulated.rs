//! What can be the simulated rest of a robot, the handover or a scene: what it
//! reads from outside, and its episode in step with somebody who keeps time.

use super::link::{Input, Link, SharedReadings};
use super::scene_rest::{SensorInput, SensorLink, SharedMeasurements};
use crate::technique::simulation::Campaign;
use diagnostic::Problem;
use handover::{Outside, OutsideReadings, World, run_episode_with};
use recording::TopicMap;
use rig::SceneCampaign;
use std::ops::ControlFlow;
use std::sync::Arc;
use testbench::{Cancel, Savable, SimError, Status, Unwatched};
use trace::{SignalValues, Trace};

/// Who keeps an episode in step.
pub trait Pace {
    /// Everything is ready, the robot's code too; time begins.
    fn start(&mut self);

    /// The episode has come to `now_secs`; `recorded` is everything that was
    /// recorded so far. It goes on when this returns; `Break` ends it.
    fn step(&mut self, now_secs: f64, recorded: &Trace) -> ControlFlow<()>;
}

/// The simulated rest of a robot.
#[derive(Clone)]
pub struct Simulated {
    campaign: Arc<Campaign>,
    rest: Rest,
}

#[derive(Clone)]
enum Rest {
    Handover {
        world: World,
        inputs: Vec<Input>,
        readings: SharedReadings,
    },
    Scene {
        inputs: Vec<SensorInput>,
        measurements: SharedMeasurements,
    },
}

impl Simulated {
    /// A campaign's episodes, in which the topics named in `outside` are not simulated.
    pub fn new(campaign: Campaign, outside: &[String], map: &TopicMap) -> Result<Self, Problem> {
        let rest = match campaign.scene() {
            Some(scene) => {
                let inputs = SensorInput::from_outside(outside, map, scene.bench().data());
                Rest::Scene {
                    measurements: SharedMeasurements::new(&inputs),
                    inputs,
                }
            }
            None => {
                let inputs = Input::from_outside(outside, map);
                Rest::Handover {
                    world: campaign.world()?,
                    readings: SharedReadings::new(&inputs),
                    inputs,
                }
            }
        };
        Ok(Self {
            campaign: Arc::new(campaign),
            rest,
        })
    }

    /// The signals that are read from outside.
    pub fn signals(&self) -> Vec<String> {
        match &self.rest {
            Rest::Handover { inputs, .. } => inputs.iter().flat_map(|it| it.signals()).collect(),
            Rest::Scene { inputs, .. } => inputs.iter().flat_map(SensorInput::signals).collect(),
        }
    }

    /// The way of these signals to the episode.
    pub fn link(&self, layout: &Trace) -> Result<AnyLink, Problem> {
        Ok(match &self.rest {
            Rest::Handover {
                inputs, readings, ..
            } => AnyLink::Handover(Link::new(inputs, layout, readings.clone())?),
            Rest::Scene {
                inputs,
                measurements,
            } => AnyLink::Scene(SensorLink::new(inputs, layout, measurements.clone())?),
        })
    }

    /// The channels of an episode's trace.
    pub fn layout(&self) -> Result<Trace, Problem> {
        self.campaign.layout()
    }

    /// Simulated time from step to step: that of the robot's code, or of the
    /// recording where there is none.
    pub fn period_secs(&self) -> f64 {
        match self.campaign.scene() {
            Some(scene) => period_of(scene),
            None => {
                let hz = self.campaign.controller_hz().unwrap_or(1);
                1.0 / f64::from(hz.max(1))
            }
        }
    }

    /// An episode: its trace and how long it took.
    pub fn run(&self, seed: u64, pace: &mut dyn Pace) -> Result<(Trace, f64), SimError> {
        match (&self.rest, self.campaign.scene()) {
            (Rest::Scene { measurements, .. }, Some(scene)) => {
                run_scene(scene, seed, measurements, pace)
            }
            (
                Rest::Handover {
                    world, readings, ..
                },
                _,
            ) => {
                pace.start();
                let mut outside = Paced { readings, pace };
                let episode = run_episode_with(world, seed, &Cancel::default(), &mut outside)?;
                Ok((episode.trace, episode.sim_secs))
            }
            // A scene's rest is made of a scene.
            (Rest::Scene { .. }, None) => Err(SimError::Cancelled),
        }
    }
}

fn period_of(scene: &SceneCampaign) -> f64 {
    let data = scene.bench().data();
    let periods = data.controllers.iter().map(|it| it.period_secs);
    let shortest = periods.fold(f64::INFINITY, f64::min);
    if shortest.is_finite() {
        shortest
    } else {
        1.0 / data.simulation.record_hz
    }
}

fn run_scene(
    scene: &SceneCampaign,
    seed: u64,
    measurements: &SharedMeasurements,
    pace: &mut dyn Pace,
) -> Result<(Trace, f64), SimError> {
    let bench = scene.bench();
    let period_secs = period_of(scene);
    let mut running = bench.start(scene.stimulus(), seed)?;
    pace.start();
    let mut steps: u64 = 0;
    loop {
        for (sensor, values) in measurements.now() {
            running.measure_outside(&sensor, values)?;
        }
        let now_secs = bench.now_secs(&running);
        if pace.step(now_secs, bench.so_far(&running)).is_break() {
            return Err(SimError::Cancelled);
        }
        steps += 1;
        let until_secs = steps as f64 * period_secs;
        let status = bench.advance(&mut running, until_secs, &mut Unwatched, &Cancel::default())?;
        if status != Status::Running {
            let recorded = bench.finish(running)?;
            return Ok((recorded.trace, recorded.sim_secs));
        }
    }
}

/// Somebody who keeps time, as the handover's world knows it.
struct Paced<'p> {
    readings: &'p SharedReadings,
    pace: &'p mut dyn Pace,
}

impl Outside for Paced<'_> {
    fn step(&mut self, now_secs: f64, recorded: &Trace) -> ControlFlow<()> {
        self.pace.step(now_secs, recorded)
    }

    fn readings(&self) -> OutsideReadings {
        self.readings.now()
    }
}

/// Passes the values of signals on to the episode under way.
pub enum AnyLink {
    /// To the handover's robot.
    Handover(Link),
    /// To a scene's sensors.
    Scene(SensorLink),
}

impl AnyLink {
    /// Passes on what the signals are at this instant.
    pub fn pass(&self, values: &impl SignalValues) {
        match self {
            Self::Handover(link) => link.pass(values),
            Self::Scene(link) => link.pass(values),
        }
    }
}
