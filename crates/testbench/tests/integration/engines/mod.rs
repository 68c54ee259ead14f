//! What tests of physics share: small layouts, and both engines to build them in.
#![allow(dead_code, reason = "each test program uses a part")]

use testbench::Engine;
use testbench::geometry::{IDENTITY, Pose, Vector, sphere_inertia};
use testbench::physics::{
    BodyPlan, Form, Inertia, JointKind, JointPlan, Layout, Motion, MujocoPhysics, Physics,
    RapierPhysics, ShapePlan, Surface, Touch, Touches,
};

pub(crate) use crate::common;

/// Gravity in all tests, m/s².
pub const GRAVITY: f64 = 9.81;

/// Builds a layout in an engine.
pub type Build<'a> = &'a dyn Fn(&Layout) -> Box<dyn Physics>;

/// Runs a test on each engine that is there.
pub fn on_each(test: impl Fn(&str, Build<'_>)) {
    if let Some(engine) = common::engine() {
        test("MuJoCo", &|layout| in_mujoco(&engine, layout));
    }
    test("Rapier", &in_rapier);
}

/// The layout in MuJoCo.
pub fn in_mujoco(engine: &Engine, layout: &Layout) -> Box<dyn Physics> {
    Box::new(MujocoPhysics::new(engine, layout).expect("the test's layout is sound"))
}

/// The layout in Rapier.
pub fn in_rapier(layout: &Layout) -> Box<dyn Physics> {
    Box::new(RapierPhysics::new(layout).expect("the test's layout is sound"))
}

/// Nothing yet.
pub fn empty(time_step_secs: f64, gravity_m_s2: f64) -> Layout {
    Layout {
        time_step_secs,
        gravity_m_s2,
        ..Layout::default()
    }
}

/// A pose without a turn.
pub fn at(position_m: Vector) -> Pose {
    Pose {
        position_m,
        orientation: IDENTITY,
    }
}

/// Mass and moments about the centre, which is the frame's origin.
pub fn inertia(mass_kg: f64, moments_kg_m2: Vector) -> Inertia {
    let [x, y, z] = moments_kg_m2;
    Inertia {
        mass_kg,
        centre_m: [0.0; 3],
        moments_kg_m2: [x, y, z, 0.0, 0.0, 0.0],
    }
}

/// Adds a body and gives its place.
pub fn body(
    layout: &mut Layout,
    name: &str,
    pose: Pose,
    motion: Motion,
    inertia: Inertia,
) -> usize {
    layout.bodies.push(BodyPlan {
        name: name.to_owned(),
        parent: None,
        pose,
        motion,
        inertia: Some(inertia),
    });
    layout.bodies.len() - 1
}

/// Adds a shape and gives its place.
pub fn shape(
    layout: &mut Layout,
    body: Option<usize>,
    pose: Pose,
    form: Form,
    friction: f64,
) -> usize {
    let number = layout.shapes.len();
    layout.shapes.push(ShapePlan {
        name: format!("shape {number}"),
        body,
        pose,
        form,
        friction,
        touches: Touches::All,
        surface: Surface::default(),
    });
    number
}

/// Adds a joint without damping, friction, springs or limits and gives its place.
pub fn joint(layout: &mut Layout, body: usize, kind: JointKind, axis: Vector) -> usize {
    let number = layout.joints.len();
    layout.joints.push(JointPlan {
        name: format!("joint {number}"),
        body,
        kind,
        anchor_m: [0.0; 3],
        axis,
        reference: 0.0,
        range: None,
        damping: 0.0,
        friction_loss: 0.0,
        armature: 0.0,
        stiffness: 0.0,
        spring_reference: 0.0,
        stop: None,
    });
    number
}

/// Adds a ball that moves freely.
pub fn ball(
    layout: &mut Layout,
    name: &str,
    centre_m: Vector,
    mass_kg: f64,
    radius_m: f64,
) -> usize {
    let spread = inertia(mass_kg, sphere_inertia(mass_kg, radius_m));
    let ball = body(layout, name, at(centre_m), Motion::Free, spread);
    shape(
        layout,
        Some(ball),
        at([0.0; 3]),
        Form::Sphere { radius_m },
        0.0,
    );
    ball
}

/// Steps until `secs` have passed.
pub fn run(physics: &mut dyn Physics, secs: f64) {
    while physics.time_secs() + 1e-9 < secs {
        physics.step();
    }
}

/// Gives a body of `mass_kg` a velocity more, by a force during one step.
pub fn push(
    physics: &mut dyn Physics,
    body: usize,
    mass_kg: f64,
    velocity_m_s: Vector,
    step_secs: f64,
) {
    let force = velocity_m_s.map(|v| mass_kg * v / step_secs);
    physics.apply(body, force, [0.0; 3]);
    physics.step();
    physics.apply(body, [0.0; 3], [0.0; 3]);
}

/// Sums of the normal and of the friction forces of the last step.
pub fn forces(physics: &dyn Physics) -> [f64; 2] {
    let mut touches: Vec<Touch> = Vec::new();
    physics.touches(&mut touches);
    let sum = |of: fn(&Touch) -> f64| touches.iter().map(of).sum();
    [
        sum(|touch| touch.normal_newtons),
        sum(|touch| touch.tangential_newtons),
    ]
}
