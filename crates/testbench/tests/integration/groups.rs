//! Groups of joints: what their modes do by mechanics, trajectories within their limits, Cartesian goals, bad scenes.

use crate::truths::{Scene, at, engines, most, planned, signal};
use trace::Trace;

/// Two links of 0.4 m that turn about y, with their masses at their ends, and a slide that carries them.
const ARM: &str = r#"<robot name="arm">
  <link name="frame"/>
  <link name="car"><inertial><mass value="2"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="upper"><inertial><origin xyz="0.2 0 0"/><mass value="1.5"/><inertia ixx="0.002" iyy="0.02" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="fore"><inertial><origin xyz="0.2 0 0"/><mass value="1"/><inertia ixx="0.001" iyy="0.015" izz="0.015" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="along" type="prismatic"><parent link="frame"/><child link="car"/><axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="500" velocity="1"/></joint>
  <joint name="shoulder" type="revolute"><parent link="car"/><child link="upper"/><axis xyz="0 1 0"/><limit lower="-3" upper="3" effort="80" velocity="2"/></joint>
  <joint name="elbow" type="revolute"><parent link="upper"/><child link="fore"/><origin xyz="0.4 0 0"/><axis xyz="0 1 0"/><limit lower="-2.8" upper="2.8" effort="50" velocity="3"/></joint>
</robot>"#;

const FILES: [(&str, &str); 1] = [("arm.urdf", ARM)];

const CELL: &str = r#"
    name = "cell"
    abstract_test = [{ name = "go", actions = [ACTIONS] }]
    [simulation]
    duration_secs = SECS
    time_step_secs = 0.001
    record_hz = 200
    [[robot]]
    name = "arm"
    file = "arm.urdf"
    fixed = true
    z_m = 1.0
    joints = { shoulder = 0.3, elbow = -0.9 }
    [[sensor]]
    name = "way"
    robot = "arm"
    kind = "goal"
    group = "joints"
    rate_hz = 100
    [[tool_point]]
    name = "tip"
    robot = "arm"
    link = "fore"
    x_m = 0.4
    [[group]]
    name = "joints"
    robot = "arm"
    joints = ["along", "shoulder", "elbow"]
"#;

fn cell(secs: f64, actions: &str, group: &str) -> String {
    let cell = CELL.replace("SECS", &format!("{secs:?}"));
    format!("{}\n{group}", cell.replace("ACTIONS", actions))
}

const SERVO: &str = r#"
    mode = "position"
    stiffness = [20000.0, 4000.0, 2000.0]
    damping = [800.0, 100.0, 40.0]
    acceleration_limit = [2.0, 4.0, 6.0]
"#;

const NAMES: [&str; 3] = ["along", "shoulder", "elbow"];

/// What holds a joint against gravity: of the shoulder with both links, of the elbow with the last. The URDF's axes point along
/// y, about which a positive turn lowers what lies along x.
fn weights_nm(shoulder: f64, elbow: f64) -> [f64; 2] {
    let fore = 9.81 * 0.2 * (shoulder + elbow).cos();
    let upper = 9.81 * (1.5 * 0.2 + 0.4) * shoulder.cos();
    [-(upper + fore), -fore]
}

#[test]
fn impedance_bears_its_own_weight_and_gives_way_to_a_load_as_its_springs_do() {
    // Soft springs, at rest where they are told to be: what is left of gravity would show at once.
    let group = r#"
        mode = "impedance"
        stiffness = [500.0, 60.0, 30.0]
        damping = [60.0, 15.0, 8.0]
    "#;
    let text = cell(3.0, "", group);
    Scene::new(&text, &FILES).in_each(&["/truth/arm.shoulder.drive_torque"], |engine, trace| {
        for (name, wanted) in [("shoulder", 0.3), ("elbow", -0.9), ("along", 0.0)] {
            let stands = at(trace, &format!("/group/joints.{name}.position"), 3.0);
            assert!(
                (stands - wanted).abs() < 2e-4,
                "{engine}: {name} at {stands}"
            );
        }
        let torque = at(trace, "/truth/arm.shoulder.drive_torque", 3.0);
        let [weight, _] = weights_nm(0.3, -0.9);
        assert!(
            (torque - weight).abs() < 0.05,
            "{engine}: {torque} for {weight}"
        );
    });
    // A part of 0.5 kg on a string would be no joint of the arm; here gravity that is not borne: a position servo sags by its weight.
    let group = group.replace("impedance", "position");
    let text = cell(4.0, "", &group);
    Scene::new(&text, &FILES).in_each(&[], |engine, trace| {
        let [shoulder, elbow] =
            ["shoulder", "elbow"].map(|it| at(trace, &format!("/group/joints.{it}.position"), 4.0));
        let [first, second] = weights_nm(shoulder, elbow);
        // The spring's torque k (r - q) is what bears the weight there.
        assert!(
            (60.0 * (0.3 - shoulder) - first).abs() < 0.02,
            "{engine}: {shoulder}"
        );
        assert!(
            (30.0 * (-0.9 - elbow) - second).abs() < 0.02,
            "{engine}: {elbow}"
        );
    });
}

#[test]
fn a_torque_on_a_slide_accelerates_all_that_it_carries_and_a_speed_is_reached() {
    let text = cell(
        0.4,
        "{ set_param = { \"joints.along_newtons\" = 9.0 } }",
        "mode = \"torque\"",
    );
    Scene::new(&text, &FILES).in_each(&[], |engine, trace| {
        // 9 N on 4.5 kg; the links hang and swing in a plane across the way, so that nothing of it is lost.
        let speed = at(trace, "/group/joints.along.velocity", 0.4);
        assert!((speed - 2.0 * 0.4).abs() < 0.01, "{engine}: {speed} m/s");
    });
    let group = "mode = \"velocity\"\ndamping = [2000.0, 100.0, 50.0]";
    let action = "{ set_param = { \"joints.along_m_s\" = 5.0, \"joints.elbow_rad_s\" = 0.5 } }";
    Scene::new(&cell(0.6, action, group), &FILES).in_each(&[], |engine, trace| {
        let speed = at(trace, "/group/joints.along.velocity", 0.5);
        assert!(
            (speed - 1.0).abs() < 0.01,
            "{engine}: limited to the description's 1 m/s, has {speed}"
        );
        let turning = at(trace, "/group/joints.elbow.velocity", 0.5);
        assert!((turning - 0.5).abs() < 0.1, "{engine}: {turning} rad/s");
    });
}

/// The numeric rates of a reference: speed, acceleration, jerk, by their largest sizes.
fn rates(trace: &Trace, joint: &str) -> [f64; 3] {
    let rows = signal(trace, &format!("/group/joints.{joint}.reference"));
    let step = rows[1].0 - rows[0].0;
    let mut values: Vec<f64> = rows[..rows.len() - 1].iter().map(|row| row.1).collect();
    std::array::from_fn(|_| {
        values = values
            .windows(2)
            .map(|pair| (pair[1] - pair[0]) / step)
            .collect();
        values
            .iter()
            .fold(0.0_f64, |most, value| most.max(value.abs()))
    })
}

const WAY: &str = r#"
    [[trajectory]]
    name = "there"
    group = "joints"
    velocity_scaling = 0.8
    waypoint = [
        { joints = [0.5, -0.4, 1.2] },
        { joints = [0.5, -0.4, 1.2], wait_secs = 0.3 },
        { joints = [-0.2, 0.8, 0.1] },
    ]
"#;

#[test]
fn trajectories_keep_to_their_limits_begin_and_end_together_and_tell_when_they_are_over() {
    for profile in [
        "profile = \"trapezoid\"",
        "profile = \"jerk_limited\"\njerk_limit = 25.0",
    ] {
        let actions =
            "{ send_signal = \"there\", after_secs = 0.1 }, { receive_signal = \"there.done\" }";
        let text = cell(4.5, actions, &format!("{SERVO}\n{profile}\n{WAY}"));
        Scene::new(&text, &FILES).in_each(&[], |engine, trace| {
            let limits = [
                ("along", 1.0, 2.0),
                ("shoulder", 2.0, 4.0),
                ("elbow", 3.0, 6.0),
            ];
            for (joint, speed, acceleration) in limits {
                let [fastest, hardest, jerk] = rates(trace, joint);
                assert!(
                    fastest <= 0.8 * speed * 1.001,
                    "{engine} {joint}: {fastest}"
                );
                assert!(
                    hardest <= acceleration * 1.01,
                    "{engine} {joint}: {hardest}"
                );
                assert!(
                    !profile.contains("jerk") || jerk <= 25.0 * 1.05,
                    "{engine} {joint}: {jerk}"
                );
            }
            for (joint, end) in NAMES.iter().zip([-0.2, 0.8, 0.1]) {
                let reference = at(trace, &format!("/group/joints.{joint}.reference"), 4.5);
                assert_eq!(reference, end, "{engine} {joint}");
                let position = at(trace, &format!("/group/joints.{joint}.position"), 4.5);
                assert!(
                    (position - end).abs() < 0.01,
                    "{engine} {joint}: {position}"
                );
            }
            let moves = [0.05, 0.5, 4.5].map(|secs| at(trace, "/sensor/way.moving", secs));
            assert_eq!(moves, [0.0, 1.0, 0.0], "{engine}");
            assert_eq!(at(trace, "/test.done", 4.5), 1.0, "{engine}");
            assert_eq!(at(trace, "/test.actions_done", 1.0), 1.0, "{engine}");
            together(engine, trace);
        });
    }
}

/// On the first way all joints have come equally far at any time.
fn together(engine: &str, trace: &Trace) {
    let share = |joint: &str, from: f64, to: f64, secs: f64| {
        (at(trace, &format!("/group/joints.{joint}.reference"), secs) - from) / (to - from)
    };
    for secs in [0.3, 0.5, 0.8] {
        let first = share("along", 0.0, 0.5, secs);
        assert!(
            (share("shoulder", 0.3, -0.4, secs) - first).abs() < 1e-9,
            "{engine} at {secs}"
        );
        assert!(
            (share("elbow", -0.9, 1.2, secs) - first).abs() < 1e-9,
            "{engine} at {secs}"
        );
    }
}

#[test]
fn a_way_takes_as_long_as_the_slowest_joint_needs() {
    // The slide needs 0.5 / 0.8 + 0.8 / 2 = 1.025 s, the elbow 2.1 / 2.4 + 2.4 / 6 = 1.275 s: its limits bind everywhere.
    let actions = "{ send_signal = \"there\" }";
    let text = cell(
        2.0,
        actions,
        &format!("{SERVO}\nprofile = \"trapezoid\"\n{WAY}"),
    );
    Scene::new(&text, &FILES).in_each(&[], |engine, trace| {
        let arrives = signal(trace, "/group/joints.elbow.reference");
        let arrives = arrives
            .iter()
            .find(|(_, value)| *value == 1.2)
            .expect("it arrives")
            .0;
        assert!((arrives - 1.275).abs() < 0.006, "{engine}: {arrives} s");
    });
}

const PROGRAM: &str = r#"
    [[controller]]
    name = "program"
    robot = "arm"
    period_secs = 0.01
    [controller.settings]
    plan = PLAN
"#;

#[test]
fn a_controller_s_goal_is_taken_up_on_the_way_within_the_limits() {
    let plan = r#"[[0.0, "joints", "elbow", 1.5], [0.6, "joints", "elbow", -0.5], [0.6, "joints", "along", 0.2]]"#;
    for profile in [
        "profile = \"trapezoid\"",
        "profile = \"jerk_limited\"\njerk_limit = 40.0",
    ] {
        let text = cell(
            3.5,
            "",
            &format!("{SERVO}\n{profile}\n{}", PROGRAM.replace("PLAN", plan)),
        );
        let scene = Scene {
            text: &text,
            files: &FILES,
            start: planned,
        };
        scene.in_each(&[], |engine, trace| {
            for (joint, speed, acceleration) in [("along", 1.0, 2.0), ("elbow", 3.0, 6.0)] {
                let [fastest, hardest, _] = rates(trace, joint);
                assert!(
                    fastest <= speed * 1.001 && hardest <= acceleration * 1.01,
                    "{engine} {joint}: {fastest} {hardest}"
                );
            }
            assert_eq!(
                at(trace, "/group/joints.elbow.reference", 3.5),
                -0.5,
                "{engine}"
            );
            assert_eq!(
                at(trace, "/group/joints.along.reference", 3.5),
                0.2,
                "{engine}"
            );
            assert!(
                most(trace, "/group/joints.elbow.reference") < 1.5,
                "{engine}: it turned back on the way"
            );
        });
    }
}

#[test]
fn a_limp_group_falls_as_far_as_its_joints_let_it_and_a_stuck_one_takes_its_goal_up_later() {
    let limp = "\n[[group.fault]]\nkind = \"weak\"\nstrength = 0.0\nfrom_secs = 1.0";
    let text = cell(2.0, "", &format!("{SERVO}{limp}"));
    Scene::new(&text, &FILES).in_each(&[], |engine, trace| {
        let held = at(trace, "/group/joints.shoulder.position", 1.0);
        assert!((held - 0.3).abs() < 0.01, "{engine}: {held} rad");
        // About y what lies along x falls towards larger angles; there it swings about hanging down, 1.57 rad.
        let lowest = most(trace, "/group/joints.shoulder.position");
        assert!(lowest > 1.2, "{engine}: {lowest} rad");
        assert_eq!(at(trace, "/command/joints.faulty", 1.5), 1.0, "{engine}");
    });
    let stuck = "\n[[group.fault]]\nkind = \"stuck\"\nfrom_secs = 0.1\nuntil_secs = 0.8";
    let action = "{ set_param = { \"joints.elbow_rad\" = 0.2 }, after_secs = 0.3 }";
    let text = cell(
        2.5,
        action,
        &format!("{SERVO}profile = \"trapezoid\"{stuck}"),
    );
    Scene::new(&text, &FILES).in_each(&[], |engine, trace| {
        assert_eq!(
            at(trace, "/group/joints.elbow.reference", 0.79),
            -0.9,
            "{engine}"
        );
        assert_eq!(
            at(trace, "/group/joints.elbow.reference", 2.5),
            0.2,
            "{engine}"
        );
    });
    let wrong =
        "\n[[group.fault]]\nkind = \"offset\"\nfrom_secs = 0.1\noffset = { along_rad = 1.0 }";
    let text = refused(&cell(1.0, "", &format!("{SERVO}{wrong}")));
    assert!(
        text.contains(
            "`group.joints.fault.0.offset.along_rad` is unknown; it may be one of along_m, shoulder_rad, elbow_rad"
        ),
        "{text}"
    );
}

const LINE: &str = r#"
    profile = "trapezoid"
    tool_point = "tip"
    line_speed_m_s = 0.2
    line_acceleration_m_s2 = 0.8
"#;

#[test]
fn a_straight_line_is_straight_and_keeps_to_its_speed() {
    // Beginning stretched out at 45 degrees; the end is 0.3 m lower and 0.1 m to the side.
    let way = r#"
        [[trajectory]]
        name = "draw"
        group = "joints"
        waypoint = [
            { x_m = 0.6, y_m = 0.0, z_m = 1.2 },
            { x_m = 0.6, y_m = 0.1, z_m = 0.9, line = true },
            { joints = [0.0, 0.3, -0.9] },
        ]
    "#;
    let actions = "{ send_signal = \"draw\" }, { receive_signal = \"draw.done\" }";
    let text = cell(5.0, actions, &format!("{SERVO}\n{LINE}\n{way}"));
    let read = ["x", "y", "z"].map(|axis| format!("/truth/arm/tip.{axis}"));
    let mut read: Vec<&str> = read.iter().map(String::as_str).collect();
    read.push("/truth/arm/tip.speed");
    Scene::new(&text, &FILES).in_each(&read, |engine, trace| {
        let tip = |secs: f64| {
            ["x", "y", "z"].map(|axis| at(trace, &format!("/truth/arm/tip.{axis}"), secs))
        };
        // The line begins where the tip first is near its start, and ends at its end.
        let times: Vec<f64> = signal(trace, "/truth/arm/tip.speed")
            .iter()
            .map(|row| row.0)
            .collect();
        let near = |secs: f64, place: [f64; 3]| {
            tip(secs)
                .iter()
                .zip(place)
                .all(|(a, b)| (a - b).abs() < 0.004)
        };
        let begins = *times
            .iter()
            .find(|secs| near(**secs, [0.6, 0.0, 1.2]))
            .expect("its start");
        let ends = *times
            .iter()
            .find(|secs| near(**secs, [0.6, 0.1, 0.9]))
            .expect("its end");
        assert!(
            ends - begins > 0.316 / 0.2,
            "{engine}: from {begins} to {ends} s"
        );
        for secs in times.iter().filter(|secs| (begins..ends).contains(*secs)) {
            let [x, y, z] = tip(*secs);
            let along = ((y * 0.1) + (1.2 - z) * 0.3) / 0.1;
            let off =
                ((x - 0.6).powi(2) + (y - along * 0.1).powi(2) + (1.2 - z - along * 0.3).powi(2))
                    .sqrt();
            assert!(
                off < 0.004,
                "{engine}: {:.1} mm off the line at {secs} s",
                1e3 * off
            );
            let speed = at(trace, "/truth/arm/tip.speed", *secs);
            assert!(
                *secs < begins + 0.1 || speed < 0.2 * 1.03,
                "{engine}: {speed} m/s at {secs} s"
            );
        }
        assert_eq!(at(trace, "/test.done", 5.0), 1.0, "{engine}");
    });
}

#[test]
fn a_goal_out_of_reach_is_told_with_what_is_left_and_nothing_moves() {
    // Stretched the tip is 0.8 m from the shoulder, at most: 0.2 m are left. The slide cannot help.
    let plan = r#"[[0.0, "joints", "x", 0.0], [0.0, "joints", "y", 0.0], [0.0, "joints", "z", 2.0], [0.0, "joints", "pitch", -1.5707963]]"#;
    let text = cell(
        0.5,
        "",
        &format!("{SERVO}\n{LINE}\n{}", PROGRAM.replace("PLAN", plan)),
    );
    let scene = Scene {
        text: &text,
        files: &FILES,
        start: planned,
    };
    scene.in_each(&[], |engine, trace| {
        let left = at(trace, "/group/joints.distance_left", 0.5);
        assert!((left - 0.2).abs() < 2e-3, "{engine}: {left} m");
        assert_eq!(
            at(trace, "/sensor/way.distance_left", 0.5),
            left,
            "{engine}"
        );
        assert_eq!(most(trace, "/group/joints.moving"), 0.0, "{engine}");
    });
}

fn refused(text: &str) -> String {
    let (_, physics) = engines().remove(0);
    match Scene::new(text, &FILES).bench(physics, &[]) {
        Ok(_) => panic!("accepted: {text}"),
        Err(error) => error,
    }
}

#[test]
fn bad_groups_are_told_all_at_once_with_their_keys() {
    let group = r#"
        mode = "position"
        damping = [1.0, 2.0]
        profile = "jerk_limited"
        tool_point = "top"
        [[actuator]]
        name = "extra"
        robot = "arm"
        kind = "velocity"
        joint = "elbow"
        gain = 1.0
        limit = 2.0
        [[group]]
        name = "second"
        robot = "arm"
        joints = ["shoulder", "shoulder"]
        mode = "torque"
        stiffness = 3.0
        [[sensor]]
        name = "lost"
        robot = "arm"
        kind = "grip"
        gripper = "hand"
        rate_hz = 100
        [[trajectory]]
        name = "path"
        group = "jonts"
        waypoint = []
        [[trajectory]]
        name = "other"
        group = "joints"
        velocity_scaling = 2.0
        waypoint = [{ joints = [1.0] }, { x_m = 1.0 }, { joints = [0.0, 0.0, 0.0], wait_secs = -1.0 }]
    "#;
    let text = refused(&cell(1.0, "", group));
    for part in [
        "`group.joints.stiffness` is missing: the mode `position` needs it",
        "`group.joints.acceleration_limit` is missing",
        "`group.joints.jerk_limit` is missing",
        "`group.joints.damping` lists 2 where the group has 3 joints",
        "`group.joints.tool_point` names `top`",
        "`group.joints.joints.2` names `elbow`, which the actuator `extra` drives, too (velocity, here position)",
        "`group.second.joints.1` names `shoulder` twice",
        "`group.second.joints.0` names `shoulder`, which the group `joints` drives, too (position, here torque)",
        "`group.second.stiffness` is not used in the mode `torque`",
        "`trajectory.path.group` names `jonts`",
        "`sensor.lost.gripper` names `hand`",
        "`trajectory.other.velocity_scaling` must lie between 0.001 and 1 (got 2)",
        "`trajectory.other.waypoint.0` lists 1 where the group `joints` has 3 joints",
        "`trajectory.other.waypoint.1` needs either `joints`",
        "`trajectory.other.waypoint.2.wait_secs` must lie between 0 and 36000 (got -1)",
    ] {
        assert!(text.contains(part), "no {part} in\n{text}");
    }
    let wrong = CELL
        .replace("\"elbow\"]", "\"elbo\", \"knee\"]")
        .replace("SECS", "1.0")
        .replace("ACTIONS", "");
    let text = refused(&format!("{wrong}\nmode = \"torque\""));
    assert!(
        text.contains("joints.2` names `elbo`") && text.contains("joints.3` names `knee`"),
        "{text}"
    );
}

#[test]
fn waypoints_out_of_reach_are_refused_with_what_is_left_before_anything_runs() {
    let way = r#"
        [[trajectory]]
        name = "far"
        group = "joints"
        waypoint = [{ x_m = 1.0, y_m = 0.0, z_m = 1.0 }]
        [[trajectory]]
        name = "wide"
        group = "joints"
        waypoint = [{ joints = [0.0, 0.0, 3.0] }]
    "#;
    let text = refused(&cell(1.0, "", &format!("{SERVO}\n{LINE}\n{way}")));
    assert!(
        text.contains(
            "trajectory.far.waypoint.0` cannot be reached from the waypoint before: 200.0 mm"
        ),
        "{text}"
    );
    // 3.0 rad are 0.2 rad, 11.46 degrees, beyond the elbow's limit.
    assert!(
        text.contains("trajectory.wide.waypoint.0` cannot be reached")
            && text.contains("11.46 degrees"),
        "{text}"
    );
}

const TWO_WAYS: &str = r#"
    profile = "trapezoid"
    tool_point = "tip"
    [[trajectory]]
    name = "away"
    group = "joints"
    waypoint = [{ joints = [0.0, 2.6, 0.9] }]
    [[trajectory]]
    name = "fetch"
    group = "joints"
    waypoint = [{ x_m = 0.5, y_m = 0.0, z_m = 1.05, line = true }, { joints = [0.1, 0.3, -0.9] }]
"#;

#[test]
fn a_trajectory_is_tried_where_it_is_begun_and_says_so_where_it_is_out_of_reach() {
    // From the beginning the line is in front of the shoulder; from behind it, it leads through the shoulder, nearer than the
    // elbow's limit of 2.8 rad lets the tip come: 0.136 m.
    let group = format!("{SERVO}{TWO_WAYS}");
    let actions = r#"
        { send_signal = "away" }, { receive_signal = "away.done" },
        { send_signal = "fetch" }, { receive_signal = "fetch.failed" },
    "#;
    let scene = cell(6.0, actions, &group);
    let scene = Scene::new(&scene, &FILES);
    scene.in_each(&[], |engine, trace| {
        assert_eq!(at(trace, "/test.done", 6.0), 1.0, "{engine}");
        assert_eq!(at(trace, "/group/joints.failed", 0.5), 0.0, "{engine}");
        assert_eq!(at(trace, "/group/joints.failed", 6.0), 1.0, "{engine}");
        let left = at(trace, "/group/joints.distance_left", 6.0);
        assert!(left > 1e-3, "{engine}: {left} m");
        let stands = at(trace, "/group/joints.shoulder.reference", 6.0);
        assert_eq!(stands, 2.6, "{engine}");
        let [missed] = testbench::OutOfReach::of(trace).try_into().expect("one");
        assert_eq!((missed.trajectory.as_str(), missed.waypoint), ("fetch", 0));
        assert_eq!(missed.distance_left_m, left, "{engine}");
    });
    let checked = scene
        .bench(testbench::scene::rapier(), &[])
        .expect("a bench");
    let told = checked
        .checked()
        .iter()
        .find(|it| it.key == "trajectory.fetch");
    let told = &told.expect("fetch is told of").what;
    assert!(
        told.contains("in reach from where the scene lets `joints` begin"),
        "{told}"
    );
    let forward = r#"{ send_signal = "fetch" }, { receive_signal = "fetch.done" }"#;
    let scene = cell(4.0, forward, &group);
    Scene::new(&scene, &FILES).in_each(&[], |engine, trace| {
        assert_eq!(at(trace, "/test.done", 4.0), 1.0, "{engine}");
        assert_eq!(at(trace, "/group/joints.failed", 4.0), 0.0, "{engine}");
        assert!(testbench::OutOfReach::of(trace).is_empty(), "{engine}");
    });
}

#[test]
fn a_later_waypoint_that_is_out_of_reach_is_told_before_the_group_moves() {
    let group = format!("{SERVO}{TWO_WAYS}").replace(
        "{ joints = [0.1, 0.3, -0.9] }",
        "{ joints = [0.0, 2.6, 0.9] }, { x_m = 0.5, y_m = 0.0, z_m = 1.05, line = true }",
    );
    // Where the robot begins is drawn, so that nothing is tried beforehand.
    let drawn = "joints = { shoulder = { uniform = [0.3, 0.3001] }, elbow = -0.9 }";
    let actions = r#"{ send_signal = "fetch" }, { receive_signal = "fetch.failed" }"#;
    let text =
        cell(1.0, actions, &group).replace("joints = { shoulder = 0.3, elbow = -0.9 }", drawn);
    let scene = Scene::new(&text, &FILES);
    scene.in_each(&[], |engine, trace| {
        assert_eq!(at(trace, "/test.done", 1.0), 1.0, "{engine}");
        let [missed] = testbench::OutOfReach::of(trace).try_into().expect("one");
        assert_eq!((missed.waypoint, missed.secs), (2, 0.0), "{engine}");
        assert_eq!(most(trace, "/group/joints.moving"), 0.0, "{engine}");
    });
    let bench = scene
        .bench(testbench::scene::rapier(), &[])
        .expect("a bench");
    let told = &bench.checked()[1];
    assert!(
        told.key == "trajectory.fetch"
            && told
                .what
                .contains("not tried, since where `arm` begins is drawn"),
        "{told:?}"
    );
}
