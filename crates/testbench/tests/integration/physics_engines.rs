//! The same layout in both engines: articulated bodies with all that joints can have, what rays and
//! distances find, who touches whom; and that the second engine repeats itself bit for bit.

use crate::engines;

use std::f64::consts::PI;

use engines::*;
use testbench::SimError;
use testbench::geometry::{Vector, about, norm, subtract};
use testbench::physics::{
    BodyPlan, CouplingPlan, DriveKind, DrivePlan, Form, JointKind, Layout, Motion, Physics,
    RapierPhysics, Softness, Spring, Touches,
};

/// Adds a body that hangs on another.
fn hung(
    layout: &mut Layout,
    name: &str,
    parent: Option<usize>,
    position_m: Vector,
    motion: Motion,
) -> usize {
    let mut spread = inertia(0.8, [0.01, 0.02, 0.025]);
    spread.centre_m = [0.2, 0.03, -0.02];
    spread.moments_kg_m2[3] = 0.002;
    let mut pose = at(position_m);
    pose.orientation = about([0.3, 1.0, 0.2], 0.2);
    layout.bodies.push(BodyPlan {
        name: name.to_owned(),
        parent,
        pose,
        motion,
        inertia: Some(spread),
    });
    layout.bodies.len() - 1
}

/// An arm whose joints have every property, with something fixed at its end and a free root beside
/// it that carries a wheel, and a body with three joints of its own.
fn machine(step_secs: f64) -> Layout {
    let mut layout = empty(step_secs, GRAVITY);
    let base = hung(&mut layout, "base", None, [0.0, 0.0, 1.0], Motion::Fixed);
    let upper = hung(
        &mut layout,
        "upper",
        Some(base),
        [0.1, 0.0, 0.2],
        Motion::Jointed,
    );
    let fore = hung(
        &mut layout,
        "fore",
        Some(upper),
        [0.4, 0.0, 0.0],
        Motion::Jointed,
    );
    let hand = hung(
        &mut layout,
        "hand",
        Some(fore),
        [0.3, 0.1, 0.0],
        Motion::Jointed,
    );
    hung(
        &mut layout,
        "tool",
        Some(hand),
        [0.2, 0.0, 0.1],
        Motion::Fixed,
    );
    let shoulder = joint(&mut layout, upper, JointKind::Hinge, [0.2, 1.0, 0.0]);
    let elbow = joint(&mut layout, fore, JointKind::Hinge, [0.0, 1.0, 0.5]);
    let wrist = joint(&mut layout, hand, JointKind::Slide, [1.0, 0.2, 0.0]);
    layout.joints[shoulder].armature = 0.05;
    layout.joints[shoulder].damping = 0.3;
    layout.joints[elbow].reference = 0.4;
    layout.joints[elbow].anchor_m = [0.02, 0.0, 0.01];
    layout.joints[elbow].stiffness = 4.0;
    layout.joints[elbow].spring_reference = 0.7;
    layout.joints[wrist].damping = 2.0;
    let cart = hung(&mut layout, "cart", None, [3.0, 0.0, 50.0], Motion::Free);
    let wheel = hung(
        &mut layout,
        "wheel",
        Some(cart),
        [0.3, 0.2, 0.0],
        Motion::Jointed,
    );
    let axle = joint(&mut layout, wheel, JointKind::Hinge, [0.0, 1.0, 0.0]);
    let sled = hung(&mut layout, "sled", None, [0.0, 5.0, 0.0], Motion::Jointed);
    joint(&mut layout, sled, JointKind::Slide, [1.0, 0.0, 0.0]);
    let across = joint(&mut layout, sled, JointKind::Slide, [0.0, 1.0, 0.0]);
    let turn = joint(&mut layout, sled, JointKind::Hinge, [0.0, 0.0, 1.0]);
    for (joint, kind, limit) in [
        (
            shoulder,
            DriveKind::Position {
                stiffness: 60.0,
                damping: 5.0,
            },
            25.0,
        ),
        (
            wrist,
            DriveKind::Position {
                stiffness: 80.0,
                damping: 3.0,
            },
            100.0,
        ),
        (axle, DriveKind::Velocity { gain: 0.2 }, 3.0),
        (across, DriveKind::Effort, 2.0),
        (turn, DriveKind::Effort, 1.0),
    ] {
        layout.drives.push(DrivePlan { joint, kind, limit });
    }
    layout
}

/// Joints' positions and the hand's, the tool's and the cart's places after 0.6 s.
fn moved(layout: &Layout, build: Build<'_>) -> Vec<f64> {
    let mut physics = build(layout);
    physics.set_joint(0, 0.3);
    physics.set_joint(1, 0.6);
    physics.refresh();
    for (drive, target) in [0.5, 0.1, 6.0, 1.5, 5.0].into_iter().enumerate() {
        physics.set_drive(drive, target);
    }
    physics.apply(4, [1.0, 2.0, 3.0], [0.1, 0.2, -0.1]);
    run(physics.as_mut(), 0.6);
    let joints = (0..layout.joints.len()).map(|joint| physics.joint(joint).position);
    let places = [3, 4, 5].map(|body| physics.body_pose(body).position_m);
    joints.chain(places.into_iter().flatten()).collect()
}

#[test]
fn an_articulated_machine_moves_the_same_in_both_engines() {
    let Some(engine) = common::engine() else {
        return;
    };
    let of = |step_secs: f64| {
        let layout = machine(step_secs);
        let first = moved(&layout, &|layout| in_mujoco(&engine, layout));
        let second = moved(&layout, &in_rapier);
        let apart = first.iter().zip(&second).map(|(a, b)| (a - b).abs());
        apart.fold(0.0, f64::max)
    };
    // Both are of first order, with different errors: what is between them shrinks with the step.
    // Measured: 0.0166 and 0.0042 of a turn by 6.1 rad, less of everything else.
    let (coarse, fine) = (of(0.002), of(0.0005));
    assert!(fine < 0.27 * coarse && fine < 5e-3, "{coarse} {fine}");
}

#[test]
fn dry_friction_holds_a_joint_below_its_size_and_brakes_above() {
    on_each(|name, build| {
        let mut layout = empty(0.002, 0.0);
        let disc = body(
            &mut layout,
            "disc",
            at([0.0; 3]),
            Motion::Jointed,
            inertia(1.0, [0.1; 3]),
        );
        let axle = joint(&mut layout, disc, JointKind::Hinge, [0.0, 0.0, 1.0]);
        layout.joints[axle].friction_loss = 0.5;
        layout.drives.push(DrivePlan {
            joint: axle,
            kind: DriveKind::Effort,
            limit: 10.0,
        });
        let mut physics = build(&layout);
        physics.set_drive(0, 0.45);
        run(physics.as_mut(), 0.5);
        // Soft in MuJoCo: 2.3e-3 rad, and 4.7e-3 rad/s.
        assert!(
            physics.joint(0).position.abs() < 5e-3,
            "{name}: {:?}",
            physics.joint(0)
        );
        physics.set_drive(0, 1.0);
        let start = physics.joint(0).velocity;
        run(physics.as_mut(), 1.5);
        // (1 - 0.5) N m on 0.1 kg m² for 1 s.
        let gained = physics.joint(0).velocity - start;
        assert!((gained / 5.0 - 1.0).abs() < 0.01, "{name}: {gained} rad/s");
    });
}

#[test]
fn a_coupled_joint_follows_and_a_limited_one_stops() {
    on_each(|name, build| {
        let mut layout = empty(0.002, 0.0);
        let base = body(
            &mut layout,
            "base",
            at([0.0; 3]),
            Motion::Fixed,
            inertia(1.0, [0.1; 3]),
        );
        for (finger, y) in [("left", 0.1), ("right", -0.1)] {
            let finger = body(
                &mut layout,
                finger,
                at([0.0, y, 0.0]),
                Motion::Jointed,
                inertia(1.0, [0.1; 3]),
            );
            layout.bodies[finger].parent = Some(base);
            joint(&mut layout, finger, JointKind::Hinge, [1.0, 0.0, 0.0]);
        }
        layout.joints[0].range = Some([-0.2, 0.5]);
        layout.drives.push(DrivePlan {
            joint: 0,
            kind: DriveKind::Effort,
            limit: 10.0,
        });
        layout.joints[0].damping = 1.0;
        layout.couplings.push(CouplingPlan {
            joint: 1,
            leader: Some(0),
            coefficients: [0.0, -0.5, 0.0, 0.0, 0.0],
            carries: false,
        });
        let mut physics = build(&layout);
        physics.set_drive(0, 0.3);
        run(physics.as_mut(), 4.0);
        let [leads, follows] = [0, 1].map(|joint| physics.joint(joint).position);
        assert!((leads - 0.5).abs() < 0.01, "{name}: {leads}");
        assert!(
            (follows + 0.5 * leads).abs() < 0.01,
            "{name}: {follows} {leads}"
        );
    });
}

/// A shape of each form, apart from each other.
fn forms() -> Layout {
    let mut layout = empty(0.002, 0.0);
    shape(&mut layout, None, at([0.0, 0.0, -2.0]), Form::Ground, 1.0);
    let corners = |x: f64| [[0.0; 3], [x, 0.0, 0.0], [0.0, 0.3, 0.0], [0.0, 0.0, 0.4]];
    let forms = [
        Form::Box {
            edges_m: [0.4, 0.2, 0.6],
        },
        Form::Sphere { radius_m: 0.3 },
        Form::Capsule {
            radius_m: 0.1,
            length_m: 0.5,
        },
        Form::Cylinder {
            radius_m: 0.2,
            length_m: 0.5,
        },
        Form::Hull {
            points_m: corners(0.5).to_vec(),
        },
        Form::Ellipsoid {
            radii_m: [0.1, 0.2, 0.3],
        },
    ];
    for (index, form) in forms.into_iter().enumerate() {
        let mut pose = at([
            index as f64 - 2.5,
            0.3 * (index % 2) as f64,
            0.1 * index as f64,
        ]);
        pose.orientation = about([1.0, 0.4, 0.2], 0.5 * index as f64);
        let fixed = layout.bodies.len();
        layout.bodies.push(BodyPlan {
            name: format!("body {index}"),
            parent: None,
            pose,
            motion: Motion::Fixed,
            inertia: None,
        });
        shape(&mut layout, Some(fixed), at([0.0, 0.05, 0.0]), form, 1.0);
    }
    layout
}

#[test]
fn rays_and_distances_find_the_same_in_both_engines() {
    let Some(engine) = common::engine() else {
        return;
    };
    let layout = forms();
    let (mut a, mut b) = (in_mujoco(&engine, &layout), in_rapier(&layout));
    let mut hits = 0;
    for ray in 0..400 {
        let turn = f64::from(ray) * 0.7;
        let from_m = [
            -3.5 + 0.0175 * f64::from(ray),
            4.0 * turn.cos(),
            3.0 * turn.sin(),
        ];
        let towards = subtract([from_m[0] + 0.3 * (3.0 * turn).sin(), 0.15, 0.2], from_m);
        let direction = towards.map(|component| component / norm(towards));
        let [first, second] =
            [&a, &b].map(|physics| physics.ray(from_m, direction, 8.0, &|shape| shape > 0));
        match (first, second) {
            (Some(x), Some(y)) => {
                assert_eq!(x.shape, y.shape, "ray {ray}");
                // The ellipsoid is a polyhedron in Rapier.
                let bound = if x.shape == 6 { 5e-3 } else { 1e-7 };
                assert!(
                    (x.distance_m - y.distance_m).abs() < bound,
                    "ray {ray}: {x:?} {y:?}"
                );
                hits += 1;
            }
            (None, None) => {}
            // A ray that grazes the ellipsoid may pass the polyhedron.
            (Some(x), None) if x.shape == 6 => {}
            other => panic!("ray {ray}: {other:?}"),
        }
    }
    assert!(hits > 100, "{hits}");
    for first in 0..layout.shapes.len() {
        for second in first + 1..layout.shapes.len() {
            let [x, y] = [&mut a, &mut b].map(|physics| physics.distance_m(first, second, 10.0));
            let bound = if second == 6 { 3e-3 } else { 1e-5 };
            assert!(
                (x - y).abs() < bound,
                "shapes {first} and {second}: {x} m, {y} m"
            );
        }
    }
}

#[test]
fn who_touches_whom_is_the_same_in_both_engines() {
    on_each(|name, build| {
        let mut layout = empty(0.002, 0.0);
        for (index, touches) in [
            Touches::All,
            Touches::AllButGroup(3),
            Touches::AllButGroup(3),
            Touches::Nothing,
        ]
        .into_iter()
        .enumerate()
        {
            let overlapping = [0.05 * index as f64, 0.0, 0.0];
            ball(&mut layout, &format!("ball {index}"), overlapping, 1.0, 0.1);
            layout.shapes[index].touches = touches;
        }
        ball(&mut layout, "kept apart", [0.0, 0.05, 0.0], 1.0, 0.1);
        layout.no_contact.push([0, 4]);
        let mut physics = build(&layout);
        physics.step();
        let mut touches = Vec::new();
        physics.touches(&mut touches);
        let mut pairs: Vec<[usize; 2]> = touches
            .iter()
            .map(|t| [t.shapes[0].min(t.shapes[1]), t.shapes[0].max(t.shapes[1])])
            .collect();
        pairs.sort_unstable();
        assert_eq!(pairs, [[0, 1], [0, 2], [1, 4], [2, 4]], "{name}");
    });
}

#[test]
fn kinds_touch_those_that_they_name_and_no_others_in_both_engines() {
    on_each(|name, build| {
        let mut layout = empty(0.002, 0.0);
        // A finger, two parts of an object at the same place, and what the object stands on.
        for (index, (is, touches)) in [(1, 2), (2, 1), (4, 8), (8, 4), (1, 2)]
            .into_iter()
            .enumerate()
        {
            ball(
                &mut layout,
                &format!("ball {index}"),
                [0.02 * index as f64, 0.0, 0.0],
                1.0,
                0.1,
            );
            layout.shapes[index].touches = Touches::Kinds { is, touches };
        }
        let mut physics = build(&layout);
        physics.step();
        let mut touches = Vec::new();
        physics.touches(&mut touches);
        let mut pairs: Vec<[usize; 2]> = touches
            .iter()
            .map(|t| [t.shapes[0].min(t.shapes[1]), t.shapes[0].max(t.shapes[1])])
            .collect();
        pairs.sort_unstable();
        assert_eq!(pairs, [[0, 1], [1, 4], [2, 3]], "{name}");
    });
}

/// A softness, and the spring that stands for it in an engine that has springs.
fn soft() -> (Softness, Spring) {
    let softness = Softness {
        time_constant_secs: 0.02,
        damping_ratio: 1.0,
        impedance: None,
    };
    (softness, softness.spring())
}

#[test]
fn what_lies_on_a_soft_floor_sinks_in_as_far_in_both_engines() {
    let (softness, spring) = soft();
    // By hand: a spring of m (2 pi f)^2 under m g. MuJoCo's is stiffer where it is pressed more: `spring` is right within 1.6.
    let expected_m = GRAVITY / (2.0 * PI * spring.frequency_hz).powi(2);
    assert!((1e-4..1e-2).contains(&expected_m), "{expected_m} m");
    on_each(|name, build| {
        let mut layout = empty(0.002, GRAVITY);
        layout.solver.rapier.fixed_contact = Some(spring);
        let floor = shape(&mut layout, None, at([0.0; 3]), Form::Ground, 0.0);
        if name == "MuJoCo" {
            layout.shapes[floor].surface.softness = Some(softness);
        }
        let stone = ball(&mut layout, "stone", [0.0, 0.0, 0.1], 2.0, 0.1);
        let mut physics = build(&layout);
        run(physics.as_mut(), 2.0);
        let sunk_m = 0.1 - physics.body_pose(stone).position_m[2];
        let ratio = sunk_m / expected_m;
        let within = if name == "Rapier" { 1.01 } else { 1.6 };
        assert!(
            (1.0 / within..within).contains(&ratio),
            "{name}: {sunk_m} m, {expected_m} m"
        );
    });
}

#[test]
fn a_soft_stop_gives_way_as_far_and_dry_friction_bears_what_it_is_said_to_in_both_engines() {
    let (softness, spring) = soft();
    let expected_m = GRAVITY / (2.0 * PI * spring.frequency_hz).powi(2);
    on_each(|name, build| {
        // A block on a vertical slide with a stop below it.
        let mut layout = empty(0.002, GRAVITY);
        let block = body(
            &mut layout,
            "block",
            at([0.0; 3]),
            Motion::Jointed,
            inertia(2.0, [0.01; 3]),
        );
        let slide = joint(&mut layout, block, JointKind::Slide, [0.0, 0.0, 1.0]);
        layout.joints[slide].range = Some([0.0, 1.0]);
        layout.joints[slide].stop = Some(softness);
        let mut physics = build(&layout);
        run(physics.as_mut(), 2.0);
        let ratio = -physics.joint(slide).position / expected_m;
        let within = if name == "Rapier" { 1.05 } else { 1.6 };
        assert!((1.0 / within..within).contains(&ratio), "{name}: {ratio}");
        // Without the stop, and with dry friction: more than the weight holds it, but for a creep; less lets it fall with the rest.
        layout.joints[slide].range = None;
        let weight = 2.0 * GRAVITY;
        for (friction, acceleration) in [(1.5 * weight, 0.0), (0.25 * weight, 0.75 * GRAVITY)] {
            layout.joints[slide].friction_loss = friction;
            let mut physics = build(&layout);
            run(physics.as_mut(), 0.5);
            let fallen = -physics.joint(slide).velocity / 0.5;
            assert!(
                (fallen - acceleration).abs() < 0.05 * GRAVITY,
                "{name}: {fallen} m/s2, {acceleration} m/s2"
            );
        }
    });
}

#[test]
fn what_the_second_engine_does_not_do_is_refused_with_its_name() {
    let refused = |change: &dyn Fn(&mut Layout)| {
        let mut layout = machine(0.002);
        change(&mut layout);
        match RapierPhysics::new(&layout) {
            Err(SimError::Engine(error)) => error.to_string(),
            Err(other) => panic!("{other}"),
            Ok(_) => panic!("it was taken"),
        }
    };
    let said = refused(&|layout| {
        layout.couplings.push(CouplingPlan {
            joint: 0,
            leader: Some(3),
            coefficients: [0.0, 1.0, 0.0, 0.0, 0.0],
            carries: false,
        })
    });
    assert!(
        said.contains("`joint 0`") && said.contains("two trees"),
        "{said}"
    );
    let said = refused(&|layout| {
        layout.couplings.push(CouplingPlan {
            joint: 1,
            leader: Some(0),
            coefficients: [0.0, 1.0, 2.0, 0.0, 0.0],
            carries: false,
        })
    });
    assert!(said.contains("not linear"), "{said}");
    let said = refused(&|layout| layout.joints[0].axis = [0.0; 3]);
    assert!(said.contains("no direction"), "{said}");
    let said = refused(&|layout| layout.bodies[1].inertia = None);
    assert!(
        said.contains("`upper`") && said.contains("weighs nothing"),
        "{said}"
    );
    let said = refused(&|layout| {
        let twice = layout.drives[0].clone();
        layout.drives.push(twice);
    });
    assert!(said.contains("second servo"), "{said}");
    let said = refused(&|layout| {
        shape(
            layout,
            None,
            at([0.0; 3]),
            Form::Sphere { radius_m: 0.0 },
            1.0,
        );
    });
    assert!(said.contains("no volume"), "{said}");
}

/// Everything that can be asked, as bits.
fn bits(physics: &dyn Physics, layout: &Layout) -> Vec<u64> {
    let mut numbers: Vec<f64> = (0..layout.joints.len())
        .flat_map(|joint| [physics.joint(joint).position, physics.joint(joint).velocity])
        .collect();
    for body in 0..layout.bodies.len() {
        let (pose, twist) = (physics.body_pose(body), physics.body_twist(body));
        numbers.extend(pose.position_m.iter().chain(&pose.orientation));
        numbers.extend(twist.linear_m_s.iter().chain(&twist.angular_rad_s));
    }
    numbers.extend(forces(physics));
    numbers.into_iter().map(f64::to_bits).collect()
}

/// The machine on the ground among balls, so that there are contacts.
fn busy() -> Layout {
    let mut layout = machine(0.002);
    shape(&mut layout, None, at([0.0; 3]), Form::Ground, 0.6);
    layout.bodies[5].pose.position_m[2] = 0.3;
    for body in [3, 5] {
        shape(
            &mut layout,
            Some(body),
            at([0.1, 0.0, 0.0]),
            Form::Box {
                edges_m: [0.3, 0.2, 0.2],
            },
            0.6,
        );
    }
    for index in 0..4 {
        ball(
            &mut layout,
            &format!("ball {index}"),
            [3.1, 0.05 * f64::from(index), 0.8 + 0.25 * f64::from(index)],
            0.5,
            0.1,
        );
    }
    layout
}

#[test]
fn a_saved_state_goes_on_bit_for_bit_in_a_fresh_and_in_a_used_world() {
    let layout = busy();
    on_each(|name, build| {
        let mut physics = build(&layout);
        physics.set_drive(0, 0.4);
        run(physics.as_mut(), 0.5);
        let saved = physics.save();
        run(physics.as_mut(), 1.0);
        let end = bits(physics.as_ref(), &layout);
        assert!(forces(physics.as_ref())[0] > 0.0, "{name}: nothing touches");
        let mut fresh = build(&layout);
        assert!(fresh.restore(&saved));
        run(fresh.as_mut(), 1.0);
        assert_eq!(bits(fresh.as_ref(), &layout), end, "{name}: fresh");
        assert!(physics.restore(&saved));
        run(physics.as_mut(), 1.0);
        assert_eq!(bits(physics.as_ref(), &layout), end, "{name}: used");
        let mut other = build(&machine(0.001));
        assert!(
            !other.restore(&saved),
            "{name}: a state of another layout is refused"
        );
    });
}

#[test]
fn threads_beside_each_other_give_the_same_bits() {
    let layout = busy();
    let end = || {
        let mut physics = in_rapier(&layout);
        run(physics.as_mut(), 0.6);
        bits(physics.as_ref(), &layout)
    };
    let alone = end();
    let beside: Vec<Vec<u64>> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..3).map(|_| scope.spawn(end)).collect();
        threads
            .into_iter()
            .map(|thread| thread.join().unwrap())
            .collect()
    });
    assert!(beside.iter().all(|bits| *bits == alone));
}
