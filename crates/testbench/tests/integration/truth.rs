//! Truth signals against closed forms, on both engines: motion, distances, tilt, regions, energy, joints.

use crate::truths::{Scene, at, engines, ever, signal};

const GRAVITY: f64 = 9.81;

/// A fixed post with a rod that swings about y without friction, its centre 0.4 m below the hinge.
const SWING: &str = r#"<robot name="swing">
  <link name="post"/>
  <link name="rod">
    <inertial><origin xyz="0 0 -0.4"/><mass value="2"/>
      <inertia ixx="0.05" iyy="0.05" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><origin xyz="0 0 -0.4"/><geometry><sphere radius="0.05"/></geometry></collision>
  </link>
  <joint name="hinge" type="revolute"><parent link="post"/><child link="rod"/><axis xyz="0 1 0"/>
    <limit lower="-2" upper="2.5" effort="1000" velocity="100"/></joint>
</robot>"#;

const SWINGING: &str = r#"
    name = "swing"
    simulation = { duration_secs = 3.0, record_hz = 100, time_step_secs = 0.0005 }
    abstract_test = [{ name = "nothing", actions = [] }]
    [[robot]]
    name = "arm"
    file = "swing.urdf"
    fixed = true
    z_m = 1.0
    joints = { hinge = 1.2 }
    [[tool_point]]
    name = "tip"
    robot = "arm"
    link = "rod"
    z_m = -0.8
"#;

fn scene(more: &str) -> String {
    format!(
        r#"
        name = "things"
        simulation = {{ duration_secs = 1.0, record_hz = 100, time_step_secs = 0.001 }}
        abstract_test = [{{ name = "nothing", actions = [] }}]
        {more}"#
    )
}

#[test]
fn a_dropped_object_falls_at_g_t_and_its_velocity_points_down() {
    let text = scene(
        "object = [{ name = \"ball\", radius_m = 0.1, mass_kg = 2.0, z_m = 20.0, yaw_rad = 0.7 }]",
    );
    let names = [
        "speed",
        "horizontal_speed",
        "velocity.z",
        "body_velocity.z",
        "velocity.x",
        "z",
    ];
    let names = names.map(|name| format!("/truth/ball.{name}"));
    let read: Vec<&str> = names.iter().map(String::as_str).collect();
    Scene::new(&text, &[]).in_each(&read, |engine, trace| {
        for (secs, speed) in signal(trace, "/truth/ball.speed") {
            assert!(
                (speed - GRAVITY * secs).abs() < 1e-6,
                "{engine} at {secs}: {speed}"
            );
        }
        assert!((at(trace, "/truth/ball.velocity.z", 1.0) + GRAVITY).abs() < 1e-6);
        assert!((at(trace, "/truth/ball.body_velocity.z", 1.0) + GRAVITY).abs() < 1e-6);
        assert!(
            at(trace, "/truth/ball.horizontal_speed", 1.0) < 1e-9,
            "{engine}"
        );
        let fallen_m = 20.0 - at(trace, "/truth/ball.z", 1.0);
        // A step too early or late makes g t dt of difference.
        assert!(
            (fallen_m - GRAVITY / 2.0).abs() < 0.02,
            "{engine}: {fallen_m}"
        );
    });
}

#[test]
fn a_body_s_velocity_is_told_in_its_own_frame() {
    // The rod starts level, forwards: its tip falls, which is along its own x axis.
    let text = SWINGING.replace("hinge = 1.2", "hinge = 1.5707963267948966");
    let read = [
        "/truth/arm/rod.body_angular_velocity.y",
        "/truth/arm/tip.body_velocity.x",
        "/truth/arm/tip.velocity.z",
        "/truth/arm/tip.speed",
        "/truth/arm/rod.speed",
        "/truth/arm.hinge.velocity",
    ];
    Scene::new(&text, &[("swing.urdf", SWING)]).in_each(&read, |engine, trace| {
        for (secs, rate) in signal(trace, "/truth/arm.hinge.velocity") {
            let tip = at(trace, "/truth/arm/tip.body_velocity.x", secs);
            // Rapier's links lag behind its joints by a part of a time step; the rod turns faster by at most 22 rad/s^2.
            let lag = if engine == "Rapier" {
                22.0 * 0.0005
            } else {
                1e-6
            };
            assert!(
                (tip + 0.8 * rate).abs() < lag,
                "{engine} at {secs}: {tip}, {rate}"
            );
            let speed = at(trace, "/truth/arm/tip.speed", secs);
            assert!((speed - 0.8 * rate.abs()).abs() < lag, "{engine} at {secs}");
            assert!(
                at(trace, "/truth/arm/rod.speed", secs) < lag,
                "{engine}: it turns about its origin"
            );
            let turn = at(trace, "/truth/arm/rod.body_angular_velocity.y", secs);
            assert!(
                (turn - rate).abs() < lag,
                "{engine} at {secs}: {turn}, {rate}"
            );
        }
        assert!(
            at(trace, "/truth/arm/tip.velocity.z", 0.1) < -0.5,
            "{engine}"
        );
    });
}

#[test]
fn a_pendulum_without_friction_keeps_its_energy() {
    let read = [
        "/truth/arm.kinetic_energy",
        "/truth/arm.potential_energy",
        "/truth/arm.mechanical_energy",
        "/truth/arm/rod.centre_height",
        "/truth/arm.hinge.velocity",
    ];
    Scene::new(SWINGING, &[("swing.urdf", SWING)]).in_each(&read, |engine, trace| {
        let energies = signal(trace, "/truth/arm.mechanical_energy");
        let first = energies[0].1;
        // m g (1 - 0.4 cos 1.2), at rest.
        let expected = 2.0 * GRAVITY * (1.0 - 0.4 * 1.2_f64.cos());
        assert!(
            (first - expected).abs() < 1e-6,
            "{engine}: {first}, {expected}"
        );
        let swing = 2.0 * GRAVITY * 0.4 * (1.0 - 1.2_f64.cos());
        for (secs, energy) in energies {
            // Integrators of first order lose or gain g dt in the velocity: 0.2 % of the swing here.
            assert!(
                (energy - first).abs() < 5e-3 * swing,
                "{engine} at {secs}: {energy}, {first}"
            );
        }
        for (secs, kinetic) in signal(trace, "/truth/arm.kinetic_energy") {
            let rate = at(trace, "/truth/arm.hinge.velocity", secs);
            // About the hinge: J + m l².
            let about = (0.05 + 2.0 * 0.4 * 0.4) * rate * rate / 2.0;
            // The change within a time step: J w dw, with dw of at most 22 rad/s^2.
            let lag = if engine == "Rapier" {
                0.37 * rate.abs() * 22.0 * 0.0005
            } else {
                0.0
            };
            assert!(
                (kinetic - about).abs() < lag + 1e-6,
                "{engine} at {secs}: {kinetic}, {about}"
            );
        }
        let deep = at(trace, "/truth/arm/rod.centre_height", 0.0);
        assert!(
            (deep - (1.0 - 0.4 * 1.2_f64.cos())).abs() < 1e-6,
            "{engine}"
        );
    });
}

#[test]
fn distances_of_spheres_are_those_of_their_surfaces_and_of_their_centres() {
    let text = scene(
        r#"object = [
        { name = "a", radius_m = 0.1, mass_kg = 1.0, z_m = 5.0 },
        { name = "b", radius_m = 0.25, x_m = 3.0, y_m = 4.0, z_m = 5.0 },
        { name = "c", radius_m = 0.5, x_m = -2.0, z_m = 5.0 },
        { name = "far", radius_m = 0.5, x_m = 40.0 },
    ]"#,
    );
    let read = [
        "/truth/a.distance_to.b",
        "/truth/a.origin_distance_to.b",
        "/truth/a.distance_to.objects",
        "/truth/a.origin_distance_to.objects",
        "/truth/b.distance_to.far",
    ];
    Scene::new(&text, &[]).in_each(&read, |engine, trace| {
        let near = |name: &str, expected: f64| {
            let found = at(trace, name, 0.0);
            assert!(
                (found - expected).abs() < 1e-6,
                "{engine}: {name} is {found}, not {expected}"
            );
        };
        near("/truth/a.distance_to.b", 5.0 - 0.35);
        near("/truth/a.origin_distance_to.b", 5.0);
        near("/truth/a.distance_to.objects", 2.0 - 0.6);
        near("/truth/a.origin_distance_to.objects", 2.0);
        // As far as `longest_distance_m`.
        near("/truth/b.distance_to.far", 10.0);
    });
}

/// A box that lies turned about x and z in the world, from a description.
const TURNED: &str = r#"<mujoco model="turned"><worldbody>
  <body name="crate" euler="0.5 0 0"><freejoint/><geom type="box" size="0.1 0.1 0.1" mass="1"/></body>
</worldbody><compiler angle="radian"/></mujoco>"#;

#[test]
fn a_turned_box_is_tilted_by_the_angle_of_its_axis() {
    let text = scene(
        "object = [{ name = \"box\", file = \"turned.xml\", z_m = 9.0, yaw_rad = 0.8 }, { name = \"level\", box_m = [0.1, 0.1, 0.1], mass_kg = 1.0, x_m = 2.0, z_m = 9.0, yaw_rad = 1.0 }]",
    );
    let read = [
        "/truth/box.tilt",
        "/truth/box.upright",
        "/truth/box.yaw",
        "/truth/box.roll",
        "/truth/level.tilt",
        "/truth/level.upright",
        "/truth/level.yaw",
        "/truth/box/crate.tilt",
    ];
    Scene::new(&text, &[("turned.xml", TURNED)]).in_each(&read, |engine, trace| {
        let is = |name: &str, expected: f64| {
            let found = at(trace, name, 0.0);
            assert!(
                (found - expected).abs() < 1e-6,
                "{engine}: {name} is {found}, not {expected}"
            );
        };
        is("/truth/box.tilt", 0.5);
        is("/truth/box/crate.tilt", 0.5);
        is("/truth/box.roll", 0.5);
        is("/truth/box.yaw", 0.8);
        is("/truth/box.upright", 0.0);
        is("/truth/level.tilt", 0.0);
        is("/truth/level.yaw", 1.0);
        is("/truth/level.upright", 1.0);
    });
}

#[test]
fn a_falling_box_is_in_a_region_as_long_as_it_is_there() {
    // From z = 3 through a region between 0.5 and 2.5 that a fixed table carries at its height of 0.5.
    let text = scene(
        r#"
        object = [{ name = "box", box_m = [0.2, 0.2, 0.2], mass_kg = 1.0, z_m = 3.0 }, { name = "table", box_m = [0.1, 0.1, 0.1], x_m = 5.0, z_m = 0.5 }]
        region = [{ name = "gate", box_m = [1.0, 1.0, 2.0], on = "table", x_m = -5.0, z_m = 1.0 }]"#,
    );
    let read = [
        "/truth/box.in.gate",
        "/truth/box.wholly_in.gate",
        "/truth/box.depth_in.gate",
        "/truth/box.z",
    ];
    Scene::new(&text, &[]).in_each(&read, |engine, trace| {
        assert!(ever(trace, "/truth/box.in.gate"), "{engine}");
        for (secs, z) in signal(trace, "/truth/box.z") {
            let found = ["in", "wholly_in", "depth_in"]
                .map(|name| at(trace, &format!("/truth/box.{name}.gate"), secs));
            let depth = (2.5 - z).min(z - 0.5).min(0.5);
            let flag = |is: bool| f64::from(u8::from(is));
            assert_eq!(found[0], flag(depth >= 0.0), "{engine} at {secs}, z = {z}");
            assert_eq!(found[1], flag(depth >= 0.1), "{engine} at {secs}, z = {z}");
            assert!(
                (found[2] - depth).abs() < 1e-9,
                "{engine} at {secs}: {}",
                found[2]
            );
        }
    });
}

#[test]
fn joints_have_positions_limits_and_what_drives_exert() {
    let text = format!(
        "{SWINGING}
        [[actuator]]
        name = \"servo\"
        robot = \"arm\"
        kind = \"position\"
        joint = \"hinge\"
        stiffness = 40.0
        damping = 1.0
        limit = 5.0
    "
    );
    let read = [
        "/truth/arm.hinge.position",
        "/truth/arm.hinge.velocity",
        "/truth/arm.hinge.drive_torque",
        "/truth/arm.hinge.limit_distance",
    ];
    Scene::new(&text, &[("swing.urdf", SWING)]).in_each(&read, |engine, trace| {
        for (secs, position) in signal(trace, "/truth/arm.hinge.position") {
            let rate = at(trace, "/truth/arm.hinge.velocity", secs);
            let found = at(trace, "/truth/arm.hinge.drive_torque", secs);
            // Without a command a servo holds where the joint began.
            let law = (40.0 * (1.2 - position) - rate).clamp(-5.0, 5.0);
            assert!(
                (found - law).abs() < 1e-9,
                "{engine} at {secs}: {found}, {law}"
            );
            let limit = at(trace, "/truth/arm.hinge.limit_distance", secs);
            assert!(
                (limit - (position + 2.0).min(2.5 - position)).abs() < 1e-9,
                "{engine}"
            );
        }
    });
}

#[test]
fn the_torque_of_a_joint_is_what_it_bears() {
    // A limp rod of which the hinge has no friction passes on no torque; a stiff one bears m g l sin.
    let text = format!(
        "{SWINGING}
        [[actuator]]
        name = \"servo\"
        robot = \"arm\"
        kind = \"position\"
        joint = \"hinge\"
        stiffness = 400.0
        damping = 60.0
        limit = 500.0
    "
    );
    let files = [("swing.urdf", SWING)];
    let scene = Scene::new(&text, &files);
    let read = [
        "/truth/arm.hinge.torque",
        "/truth/arm.hinge.position",
        "/truth/arm.hinge.drive_torque",
    ];
    for (engine, physics) in engines() {
        let trace = scene.run(physics, &read).trace;
        let angle = at(&trace, "/truth/arm.hinge.position", 3.0);
        let borne = at(&trace, "/truth/arm.hinge.torque", 3.0);
        let weight = 2.0 * GRAVITY * 0.4 * angle.sin();
        assert!((borne - weight).abs() < 1e-3, "{engine}: {borne}, {weight}");
        let driven = at(&trace, "/truth/arm.hinge.drive_torque", 3.0);
        assert!((borne - driven).abs() < 1e-2, "{engine}: {borne}, {driven}");
    }
}
