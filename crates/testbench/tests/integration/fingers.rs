//! How hard the fingers of grippers press, and that they do not give way one by one: by balances of forces, in both engines.
//!
//! Theory, for fingers that are one mechanism with the width as its freedom: by virtual work the mean of what both sides press with
//! is the commanded force `F`, whatever the fingers weigh and wherever the part was; their difference is what else pushes
//! the part along the line of closing, here its weight's share `m g sin(tilt)`.

use crate::truths::{Scene, at};
use trace::Trace;

/// How hard the hand is told to press.
const FORCE: f64 = 40.0;
const GRAVITY: f64 = 9.81;
/// Mass of the part.
const PART_KG: f64 = 0.5;
/// Forces in both engines are within this share of theory.
const WITHIN: f64 = 0.02;

/// A slide upwards, tilted about x, with a hand whose fingers of a mass close along y. `right` is the second finger's way, and what
/// it follows.
fn hand(mass_kg: f64, tilt_rad: f64, follows: &str) -> String {
    let moment = 0.001 * mass_kg;
    let link = |name: &str| {
        format!(
            r#"<link name="{name}"><inertial><mass value="{mass_kg}"/><inertia ixx="{moment}" iyy="{moment}" izz="{moment}" ixy="0" ixz="0" iyz="0"/></inertial>
            <collision><geometry><box size="0.03 0.01 0.06"/></geometry></collision></link>"#
        )
    };
    format!(
        r#"<robot name="hand">
        <link name="frame"/>
        <link name="palm"><inertial><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
        {}{}
        <joint name="up" type="prismatic"><parent link="frame"/><child link="palm"/><origin rpy="{tilt_rad} 0 0"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="500" velocity="1"/></joint>
        <joint name="left_finger" type="prismatic"><parent link="palm"/><child link="left"/><origin xyz="0 0.005 0"/><axis xyz="0 1 0"/><limit lower="0" upper="0.05" effort="100" velocity="1"/></joint>
        <joint name="right_finger" type="prismatic"><parent link="palm"/><child link="right"/><origin xyz="0 -0.005 0"/><axis xyz="0 -1 0"/><limit lower="0" upper="0.05" effort="100" velocity="1"/>{follows}</joint>
        </robot>"#,
        link("left"),
        link("right"),
    )
}

/// Light parts of a tree sink far into what they press on in Rapier, unless its contacts are stiffer than usual.
const CELL: &str = r#"
    name = "cell"
    [simulation]
    duration_secs = 3.0
    time_step_secs = 0.002
    record_hz = 100
    rapier = { contact_frequency_hz = 150 }
    [[abstract_test]]
    name = "grip"
    actions = [
        { set_param = { "hand.width_m" = 0.0 }, after_secs = 0.2 },
        { send_signal = "lift", after_secs = 0.8 },
        { receive_signal = "lift.done" },
    ]
    [[object]]
    name = "table"
    box_m = [1.0, 1.0, 0.1]
    z_m = -0.1
    [[object]]
    name = "part"
    box_m = [0.04, 0.05, 0.1]
    mass_kg = 0.5
    friction = 0.6
    y_m = OFF
    [[robot]]
    name = "arm"
    file = "hand.urdf"
    fixed = true
    friction = 0.9
    joints = { left_finger = 0.045 }
    [[group]]
    name = "slide"
    robot = "arm"
    joints = ["up"]
    mode = "position"
    stiffness = 20000.0
    damping = 600.0
    acceleration_limit = 0.5
    profile = "trapezoid"
    [[trajectory]]
    name = "lift"
    group = "slide"
    waypoint = [{ joints = [0.2] }]
    [[gripper]]
    name = "hand"
    robot = "arm"
    kind = "parallel"
    force_limit_newtons = 40.0
"#;

const BOTH: &str = r#"
    joints = ["left_finger", "right_finger"]
    open = [0.05, 0.05]
    closed = [0.0, 0.0]
    width_m = 0.1
"#;
const ONE: &str = r#"
    joints = ["left_finger"]
    open = [0.05]
    closed = [0.0]
    width_m = 0.1
"#;

const PRESSED: [&str; 2] = [
    "/truth/arm/left.contact.part.normal_force",
    "/truth/arm/right.contact.part.normal_force",
];

fn pressed(trace: &Trace, secs: f64) -> [f64; 2] {
    PRESSED.map(|name| at(trace, name, secs))
}

/// What both press with at rest in the air against theory.
fn assert_presses(trace: &Trace, tilt_rad: f64, of: &str) {
    let [left, right] = pressed(trace, 2.95);
    let mean = (left + right) / 2.0;
    assert!(
        (mean - FORCE).abs() < WITHIN * FORCE,
        "{of}: {left} N and {right} N"
    );
    let weighs = PART_KG * GRAVITY * tilt_rad.sin();
    assert!(
        (right - left - weighs).abs() < WITHIN * FORCE,
        "{of}: {right} N less {left} N is not {weighs} N"
    );
}

#[test]
fn fingers_of_any_mass_press_with_the_commanded_force_whether_both_are_driven_or_one_follows() {
    let follows = r#"<mimic joint="left_finger"/>"#;
    let off_m = 0.008;
    for (of, gripper, follows) in [("both driven", BOTH, ""), ("one follows", ONE, follows)] {
        for (mass_kg, tilt_rad) in [(0.2, 0.3), (0.015, 0.0), (0.015, 0.3)] {
            let urdf = hand(mass_kg, tilt_rad, follows);
            let text = format!("{CELL}{gripper}").replace("OFF", &format!("{off_m:?}"));
            let files = [("hand.urdf", urdf.as_str())];
            Scene::new(&text, &files).in_each(&PRESSED, |engine, trace| {
                let of = format!("{engine}, {of}, {mass_kg} kg, {tilt_rad} rad");
                assert_presses(trace, tilt_rad, &of);
            });
        }
    }
}

#[test]
fn a_finger_that_follows_at_half_the_way_presses_as_the_one_that_leads() {
    // Of 75 mm the left finger has 50, the right one 25: the force is on the width, the same on both sides.
    let urdf = hand(
        0.015,
        0.0,
        r#"<mimic joint="left_finger" multiplier="0.5"/>"#,
    );
    let gripper = ONE.replace("width_m = 0.1", "width_m = 0.075");
    let text = format!("{CELL}{gripper}").replace("OFF", "0.01");
    let files = [("hand.urdf", urdf.as_str())];
    Scene::new(&text, &files).in_each(&PRESSED, |engine, trace| {
        assert_presses(trace, 0.0, engine);
        let width = at(trace, "/gripper/hand.width", 0.0);
        assert!((width - 0.0675).abs() < 1e-4, "{engine}: {width} m");
    });
}

#[test]
fn what_two_driven_fingers_hold_stays_between_them_when_its_weight_pulls_it_to_one_side() {
    // Each finger alone would give way: 20 N on one side, 1.4 N less on the other, and nothing that centres them.
    let urdf = hand(0.015, 0.3, "");
    let text = format!("{CELL}{BOTH}").replace("OFF", "0.0");
    let files = [("hand.urdf", urdf.as_str())];
    let read = [
        "/truth/arm/left.y",
        "/truth/arm/left.z",
        "/truth/arm/right.y",
        "/truth/arm/right.z",
        "/truth/arm/palm.y",
        "/truth/arm/palm.z",
    ];
    Scene::new(&text, &files).in_each(&read, |engine, trace| {
        let middle = |secs: f64| {
            let along = |part: &str| {
                let [y, z] =
                    ["y", "z"].map(|axis| at(trace, &format!("/truth/arm/{part}.{axis}"), secs));
                y * 0.3_f64.cos() + z * 0.3_f64.sin()
            };
            (along("left") + along("right")) / 2.0 - along("palm")
        };
        for secs in [0.2, 1.0, 2.0, 2.95] {
            let off = middle(secs);
            assert!(off.abs() < 2e-4, "{engine}: {off} m at {secs} s");
        }
    });
}

/// Two fingers that turn about hinges 60 mm apart, with balls as tips 100 mm ahead of them.
const HINGED: &str = r#"<robot name="hand">
  <link name="palm"/>
  <link name="left"><inertial><origin xyz="0.05 0 0"/><mass value="0.02"/><inertia ixx="2e-5" iyy="2e-5" izz="2e-5" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><origin xyz="0.1 0 0"/><geometry><sphere radius="0.01"/></geometry></collision></link>
  <link name="right"><inertial><origin xyz="0.05 0 0"/><mass value="0.02"/><inertia ixx="2e-5" iyy="2e-5" izz="2e-5" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><origin xyz="0.1 0 0"/><geometry><sphere radius="0.01"/></geometry></collision></link>
  <joint name="left_finger" type="revolute"><parent link="palm"/><child link="left"/><origin xyz="0 0.03 0"/><axis xyz="0 0 1"/><limit lower="-0.2" upper="0.6" effort="100" velocity="3"/></joint>
  <joint name="right_finger" type="revolute"><parent link="palm"/><child link="right"/><origin xyz="0 -0.03 0"/><axis xyz="0 0 1"/><limit lower="-0.6" upper="0.2" effort="100" velocity="3"/><mimic joint="left_finger" multiplier="-1"/></joint>
</robot>"#;

#[test]
fn hinged_fingers_press_by_the_torque_that_the_mean_leverage_gives_over_their_own() {
    // Closed at -0.2 rad, open at 0.6: by the tips' ways over their turns the width is 0.1 (sin 0.6 + sin 0.2) 2 m.
    let width_m = 0.2 * (0.6_f64.sin() + 0.2_f64.sin());
    let text = CELL
        .replace(
            "box_m = [0.04, 0.05, 0.1]",
            "box_m = [0.04, 0.06, 0.1]\n    x_m = 0.1",
        )
        .replace(
            "joints = { left_finger = 0.045 }",
            "joints = { left_finger = 0.4 }",
        )
        .replace("OFF", "0.0");
    let cut =
        text.find("[[group]]").expect("the group")..text.find("[[gripper]]").expect("the gripper");
    let mut text = text;
    text.replace_range(cut, "");
    let lift = r#"{ send_signal = "lift", after_secs = 0.8 },
        { receive_signal = "lift.done" },"#;
    let text = text.replace(lift, "");
    let gripper = ONE
        .replace("open = [0.05]", "open = [0.6]")
        .replace("closed = [0.0]", "closed = [-0.2]")
        .replace("width_m = 0.1", &format!("width_m = {width_m:?}"));
    let files = [("hand.urdf", HINGED)];
    let text = format!("{text}{gripper}");
    let read = [PRESSED[0], PRESSED[1], "/truth/arm/left.yaw"];
    Scene::new(&text, &files).in_each(&read, |engine, trace| {
        // A ball touches beside its centre: the lever is 0.1 m times the cosine of the finger's turn.
        let turned = at(trace, "/truth/arm/left.yaw", 2.95);
        let theory = FORCE * (width_m / 0.8) / (2.0 * 0.1 * turned.cos());
        let [left, right] = pressed(trace, 2.95);
        let mean = (left + right) / 2.0;
        assert!(
            (mean - theory).abs() < WITHIN * theory,
            "{engine}: {left} N and {right} N at {turned} rad, {theory} N by theory"
        );
    });
}

#[test]
fn joints_that_are_coupled_begin_together_or_are_refused() {
    let urdf = hand(0.2, 0.0, "");
    let files = [("hand.urdf", urdf.as_str())];
    let text = format!("{CELL}{BOTH}").replace("OFF", "0.0").replace(
        "joints = { left_finger = 0.045 }",
        "joints = { left_finger = 0.045, right_finger = 0.01 }",
    );
    let scene = Scene::new(&text, &files);
    let refused = scene.bench(testbench::scene::rapier(), &[]);
    let refused = refused.err().expect("it is refused");
    assert!(
        refused.contains("robot.arm.joints.right_finger")
            && refused.contains("coupled to `left_finger`, which takes it to 0.045"),
        "{refused}"
    );
}

const FELT: &str = r#"
    [[sensor]]
    name = "wrist"
    robot = "arm"
    kind = "force_torque"
    link = "palm"
    rate_hz = 100
    [[sensor]]
    name = "pad"
    robot = "arm"
    kind = "force_torque"
    link = "left"
    rate_hz = 100
    [[sensor]]
    name = "other"
    robot = "arm"
    kind = "force_torque"
    link = "right"
    rate_hz = 100
"#;

#[test]
fn a_wrist_and_a_finger_bear_what_friction_holds_at_rest_and_on_the_way() {
    let urdf = hand(0.2, 0.0, "");
    let text = format!("{CELL}{BOTH}{FELT}").replace("OFF", "0.0");
    let files = [("hand.urdf", urdf.as_str())];
    Scene::new(&text, &files).in_each(&[], |engine, trace| {
        let near = |name: &str, secs: f64, wanted: f64, within: f64| {
            let found = at(trace, &format!("/sensor/{name}"), secs);
            assert!(
                (found - wanted).abs() < within,
                "{engine}: {name} is {found} at {secs} s, not {wanted}"
            );
        };
        // Palm, fingers and part: upwards with 0.5 m/s² first, which it then loses again.
        let all_kg = 1.0 + 2.0 * 0.2 + PART_KG;
        // MuJoCo's sensors are read before it takes the drive's damping, 600 Ns/m, implicitly: by `h d a` too much.
        let implicit_kg = if engine == "MuJoCo" {
            0.002 * 600.0
        } else {
            0.0
        };
        for (secs, rises_m_s2) in [(1.35, 0.5), (1.95, -0.5), (2.9, 0.0)] {
            let bears = all_kg * (GRAVITY + rises_m_s2) + implicit_kg * rises_m_s2;
            near("wrist.force.2", secs, bears, 0.15);
        }
        // Each finger is pressed outwards; which of them bears how much of the part is friction's own.
        near("pad.force.1", 2.9, -FORCE, WITHIN * FORCE);
        near("other.force.1", 2.9, FORCE, WITHIN * FORCE);
        let bears = ["pad", "other"].map(|name| at(trace, &format!("/sensor/{name}.force.2"), 2.9));
        let both = (2.0 * 0.2 + PART_KG) * GRAVITY;
        assert!(
            (bears[0] + bears[1] - both).abs() < 0.02 * both,
            "{engine}: {bears:?} N are not {both} N"
        );
        assert!(
            bears.iter().all(|it| *it > 0.35 * both),
            "{engine}: {bears:?} N"
        );
    });
}
