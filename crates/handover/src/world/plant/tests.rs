//! What holds the object, against physics by hand, in each engine.

use std::path::Path;

use testbench::{Distribution, Engine, Unwatched};

use super::{Plant, Wrench};
use crate::model::Contacts;
use crate::physics::Physics;
use crate::scenario::{Parameters, Scenario};
use crate::world::World;
use crate::world::run::Run;

const GRAVITY: f64 = 9.81;
const MASS_KG: f64 = 0.35;
const FRICTION: f64 = 0.5;

/// Each engine that is there. Under `CI` both must be.
fn engines() -> Vec<Physics> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let library = root.join(".tools/mujoco-3.17.0/libmujoco.so.3.17.0");
    let mut engines = vec![Physics::Rapier];
    if library.exists() || std::env::var_os("CI").is_some() {
        let engine = Engine::load(&library).expect("the pinned library loads");
        engines.push(engine.into());
    } else {
        println!("in Rapier alone: libmujoco not found (run tools/mujoco)");
    }
    engines
}

/// The case study with an object of known mass and friction.
fn files() -> (Scenario, Parameters) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let read = |name: &str| {
        let path = root.join("case-studies/handover/simulation").join(name);
        std::fs::read_to_string(path).expect("the case study's file is there")
    };
    let scenario = Scenario::parse(&read("scenario.toml")).expect("sound");
    let mut parameters = Parameters::parse(&read("tuned.toml")).expect("sound");
    parameters.object.mass_kg = Distribution::Constant(MASS_KG);
    parameters.hand.friction = Distribution::Constant(FRICTION);
    parameters.planner.failure_rate_per_run = 0.0;
    (scenario, parameters)
}

/// By hand: pushed with a force `F`, the object on the pedestal stays where it stands while `F < mu m g`, and slides with
/// `F / m - mu g` otherwise.
#[test]
fn the_object_on_the_pedestal_slides_with_what_exceeds_its_friction() {
    let (scenario, parameters) = files();
    let mu = scenario.object.pedestal_friction;
    for physics in engines() {
        for share in [0.8, 1.5] {
            let world = World::new(&physics, &scenario, &parameters).expect("sound");
            let draws = world.physical_draws(1);
            let plant = Plant::new(&physics, &scenario, &parameters, &draws, Contacts::Listed);
            let mut plant = plant.expect("sound");
            for _ in 0..100 {
                plant.step(None).expect("it runs");
            }
            let from = plant.object().pose.position_m;
            let newtons = share * mu * MASS_KG * GRAVITY;
            // With the torque of friction at the foot undone, so that nothing tips over.
            let borne = newtons.min(mu * MASS_KG * GRAVITY);
            let wrench = Wrench {
                force_newtons: [newtons, 0.0, 0.0],
                torque_nm: [0.0, -borne * scenario.object.length_m / 2.0, 0.0],
            };
            for _ in 0..100 {
                plant.step(Some(&wrench)).expect("it runs");
            }
            let moved_m = plant.object().pose.position_m[0] - from[0];
            let step_secs = scenario.simulation.time_step_secs;
            let secs = 99.0 * step_secs;
            let exceeds_m_s2 = (newtons / MASS_KG - mu * GRAVITY).max(0.0);
            // Velocities are stepped first.
            let by_hand_m = exceeds_m_s2 * secs * (secs + step_secs) / 2.0;
            assert!(
                (moved_m - by_hand_m).abs() < 5e-4 + 0.03 * by_hand_m,
                "{}, {share}: {moved_m} m, {by_hand_m} m",
                physics.name()
            );
        }
    }
}

/// By hand, of the object at rest in the hand: each contact's friction is within its cone, `F <= mu N`; and what the normal forces
/// do not carry of the weight, friction does, so that it is no more than the sum of all friction.
#[test]
fn the_grip_s_forces_are_within_their_cones_and_carry_the_weight() {
    let (scenario, parameters) = files();
    for physics in engines() {
        let name = physics.name();
        let world = World::new(&physics, &scenario, &parameters).expect("sound");
        let mut run = Run::new(&world, 1).expect("sound");
        while run.now_secs() < 20.0 {
            run.advance(&mut Unwatched).expect("it runs");
        }
        let contacts = run.plant().grip_contacts();
        let object = run.plant().object();
        assert!(object.pose.position_m[2] > 1.03, "{name}: it is lifted");
        assert!(contacts.len() >= 4, "{name}: {contacts:?}");
        for contact in &contacts {
            let most = FRICTION * contact.normal_newtons;
            assert!(
                contact.friction_newtons <= 1.001 * most + 1e-6,
                "{name}: {contact:?}"
            );
        }
        let carried: f64 = contacts
            .iter()
            .map(|it| it.normal_newtons * it.pushes[2])
            .sum();
        let friction: f64 = contacts.iter().map(|it| it.friction_newtons).sum();
        let rest = (MASS_KG * GRAVITY - carried).abs();
        assert!(rest <= 1.05 * friction, "{name}: {rest} N of {friction} N");
    }
}
