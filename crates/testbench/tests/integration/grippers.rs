//! Grippers and tool changers: forces, friction, momentum and balances by mechanics, in both engines.

use crate::truths::{Scene, at, engines, ever, most, name_at, signal};
use stimulus::Stimulus;
use testbench::{Bench, Cancel, Creep, Savable, Unwatched};
use trace::Trace;

/// A slide upwards with a hand whose fingers close along y.
const HAND: &str = r#"<robot name="hand">
  <link name="frame"/>
  <link name="palm"><inertial><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="left"><inertial><mass value="0.2"/><inertia ixx="0.001" iyy="0.001" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><box size="0.03 0.01 0.06"/></geometry></collision></link>
  <link name="right"><inertial><mass value="0.2"/><inertia ixx="0.001" iyy="0.001" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><box size="0.03 0.01 0.06"/></geometry></collision></link>
  <joint name="up" type="prismatic"><parent link="frame"/><child link="palm"/><axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="500" velocity="1"/></joint>
  <joint name="left_finger" type="prismatic"><parent link="palm"/><child link="left"/><origin xyz="0 0.005 0"/><axis xyz="0 1 0"/><limit lower="0" upper="0.05" effort="100" velocity="1"/></joint>
  <joint name="right_finger" type="prismatic"><parent link="palm"/><child link="right"/><origin xyz="0 -0.005 0"/><axis xyz="0 -1 0"/><limit lower="0" upper="0.05" effort="100" velocity="1"/>MIMIC</joint>
</robot>"#;

const CELL: &str = r#"
    name = "cell"
    [simulation]
    duration_secs = SECS
    time_step_secs = 0.002
    record_hz = 100
    MORE
    [[abstract_test]]
    name = "grip"
    actions = [
        { set_param = { "hand.width_m" = 0.0, "hand.force_newtons" = FORCE }, after_secs = 0.2 },
        { send_signal = "lift", after_secs = 0.8 },
        { receive_signal = "lift.done" },
        LAST
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
    [[robot]]
    name = "arm"
    file = "hand.urdf"
    fixed = true
    friction = 0.9
    joints = { left_finger = 0.045, right_finger = 0.045 }
    [[sensor]]
    name = "feels"
    robot = "arm"
    kind = "grip"
    gripper = "hand"
    rate_hz = 50
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
    width_m = 0.1
    force_limit_newtons = 40.0
"#;

const BOTH: &str = r#"
    joints = ["left_finger", "right_finger"]
    open = [0.05, 0.05]
    closed = [0.0, 0.0]
"#;

fn hand(mimic: bool) -> String {
    let follows = if mimic {
        r#"<mimic joint="left_finger"/>"#
    } else {
        ""
    };
    HAND.replace("MIMIC", follows)
}

fn cell(force_newtons: f64, last: &str, more: &str, gripper: &str) -> String {
    let cell = CELL
        .replace("SECS", "3.0")
        .replace("LAST", last)
        .replace("MORE", more);
    let cell = cell.replace("FORCE", &format!("{force_newtons:?}"));
    format!("{cell}{gripper}")
}

const READ: [&str; 4] = [
    "/truth/part.grasped_by",
    "/truth/arm/left.contact.part.normal_force",
    "/truth/arm/right.contact.part.normal_force",
    "/truth/part.z",
];

#[test]
fn fingers_press_with_the_commanded_force_whether_both_are_driven_or_one_follows() {
    let one = "joints = [\"left_finger\"]\nopen = [0.05]\nclosed = [0.0]\n";
    for (mimic, gripper) in [(false, BOTH), (true, one)] {
        let (urdf, text) = (hand(mimic), cell(20.0, "", "", gripper));
        let files = [("hand.urdf", urdf.as_str())];
        Scene::new(&text, &files).in_each(&READ, |engine, trace| {
            for finger in ["left", "right"] {
                let name = format!("/truth/arm/{finger}.contact.part.normal_force");
                // In the air both bear the same; on the table its friction is between them.
                let newtons = at(trace, &name, 2.9);
                assert!(
                    (newtons - 20.0).abs() < 1.0,
                    "{engine} {finger} (mimic {mimic}): {newtons} N"
                );
            }
            let width = at(trace, "/gripper/hand.width", 0.95);
            // Contacts give way: Rapier's by 1.3 mm on each side at this force.
            assert!((width - 0.05).abs() < 0.003, "{engine}: {width} m");
            assert_eq!(
                name_at(trace, "/gripper/hand.holding", 0.1),
                "nothing",
                "{engine}"
            );
            assert_eq!(
                name_at(trace, "/gripper/hand.holding", 2.9),
                "part",
                "{engine}"
            );
            assert_eq!(
                name_at(trace, "/truth/part.grasped_by", 2.9),
                "arm",
                "{engine}"
            );
            let holds = [0.1, 2.9].map(|secs| at(trace, "/sensor/feels.holding", secs));
            assert_eq!(holds, [0.0, 1.0], "{engine}");
            assert_eq!(at(trace, "/gripper/hand.attached", 2.9), 0.0, "{engine}");
            assert!(
                (at(trace, "/truth/part.z", 2.9) - 0.2).abs() < 0.01,
                "{engine}"
            );
        });
    }
}

#[test]
fn friction_bears_a_part_up_to_its_cone_and_no_further() {
    // Two fingers at the smaller friction, 0.6, bear 1.2 F; the part weighs 4.905 N and is lifted with 0.5 m/s² more: 5.155 N,
    // so that 4.30 N are needed.
    let urdf = hand(false);
    let files = [("hand.urdf", urdf.as_str())];
    for (newtons, holds) in [(4.9, true), (3.7, false)] {
        let text = cell(newtons, "", "mujoco = { no_slip_iterations = 10 }", BOTH);
        Scene::new(&text, &files).in_each(&READ, |engine, trace| {
            let risen = at(trace, "/truth/part.z", 3.0);
            match holds {
                true => assert!(
                    risen > 0.19,
                    "{engine}: {newtons} N hold it, it is at {risen} m"
                ),
                false => assert!(
                    risen < 0.05,
                    "{engine}: {newtons} N do not, it is at {risen} m"
                ),
            }
        });
    }
}

#[test]
fn what_is_attached_when_grasped_does_not_creep_and_is_let_go_as_the_hand_opens() {
    let urdf = hand(false);
    let files = [("hand.urdf", urdf.as_str())];
    let opens = "{ set_param = { \"hand.width_m\" = 0.1 }, after_secs = 0.5 },";
    // Friction that is much too soft: without the attachment the part creeps.
    let soft = "mujoco = { cone = \"pyramidal\", impratio = 0.1 }";
    let gripper = format!("{BOTH}\nattach = \"when-grasped\"");
    let text = cell(20.0, opens, soft, &gripper);
    let scene = Scene::new(&text, &files);
    scene.in_each(&READ, |engine, trace| {
        assert_eq!(at(trace, "/gripper/hand.attached", 0.25), 0.0, "{engine}");
        assert_eq!(at(trace, "/gripper/hand.attached", 1.5), 1.0, "{engine}");
        assert_eq!(
            name_at(trace, "/truth/part.grasped_by", 2.0),
            "arm",
            "{engine}"
        );
        let [up, part] = ["/group/slide.up.position", "/truth/part.z"];
        let apart = |secs: f64| at(trace, part, secs) - at(trace, up, secs);
        // It gives way as it is accelerated: by m a / k = 0.03 mm, and in MuJoCo by what its soft friction adds, which there
        // follows accelerations without the implicit damping of drives.
        let [lifted, stands] = [apart(2.0) - apart(2.6), apart(2.75) - apart(2.55)];
        assert!(lifted.abs() < 2e-4, "{engine}: {lifted} m");
        assert!(stands.abs() < 5e-6, "{engine}: {stands} m in 0.2 s");
        assert!(Creep::of(trace).is_empty(), "{engine}");
        assert_eq!(at(trace, "/gripper/hand.attached", 3.0), 0.0, "{engine}");
        assert!(at(trace, part, 3.0) < 0.15, "{engine}: it falls");
    });
    let text = cell(20.0, opens, soft, BOTH);
    Scene::new(&text, &files).in_each(&READ, |engine, trace| {
        assert_eq!(Creep::of(trace).is_empty(), engine == "Rapier", "{engine}");
    });
}

/// A slide with a cup that looks along x or downwards.
const CUP: &str = r#"<robot name="cup">
  <link name="frame"/>
  <link name="cup"><inertial><mass value="2"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><origin xyz="0 0 0"/><geometry><sphere radius="0.01"/></geometry></collision></link>
  <joint name="slide" type="prismatic"><parent link="frame"/><child link="cup"/><axis xyz="AXIS"/><limit lower="-3" upper="3" effort="500" velocity="3"/></joint>
</robot>"#;

const TAKEN: &str = r#"
    name = "taken on the way"
    [simulation]
    duration_secs = 2.0
    time_step_secs = 0.001
    gravity_m_s2 = 0.0
    record_hz = 200
    [[abstract_test]]
    name = "push"
    actions = [
        { set_param = { "slide.slide_newtons" = 4.0, "cup.suction" = 1.0 } },
        { set_param = { "slide.slide_newtons" = 0.0 }, after_secs = 0.25 },
    ]
    [[object]]
    name = "part"
    radius_m = 0.05
    mass_kg = 0.5
    x_m = 0.3
    [[robot]]
    name = "arm"
    file = "cup.urdf"
    fixed = true
    [[tool_point]]
    name = "rim"
    robot = "arm"
    link = "cup"
    pitch_rad = 1.5707963267948966
    [[group]]
    name = "slide"
    robot = "arm"
    joints = ["slide"]
    mode = "torque"
    [[gripper]]
    name = "cup"
    robot = "arm"
    kind = "suction"
    tool_point = "rim"
    reach_m = 0.03
    holding_force_newtons = 2000.0
"#;

#[test]
fn momentum_is_kept_as_a_part_is_taken_on_the_way() {
    let urdf = CUP.replace("AXIS", "1 0 0");
    let files = [("cup.urdf", urdf.as_str())];
    let read = [
        "/truth/part.velocity.x",
        "/truth/part.grasped_by",
        "/truth/part.angular_speed",
    ];
    Scene::new(TAKEN, &files).in_each(&read, |engine, trace| {
        // 4 N for 0.25 s on 2 kg: 0.5 m/s. Then the part of 0.5 kg comes with it: 1 Ns over 2.5 kg are 0.4 m/s.
        let before = at(trace, "/group/slide.slide.velocity", 0.4);
        assert!((before - 0.5).abs() < 0.005, "{engine}: {before} m/s");
        let [cup, part] = ["/group/slide.slide.velocity", "/truth/part.velocity.x"];
        let impulse = |secs: f64| 2.0 * at(trace, cup, secs) + 0.5 * at(trace, part, secs);
        for secs in [0.4, 0.55, 0.7, 1.0, 2.0] {
            assert!(
                (impulse(secs) - impulse(0.4)).abs() < 1e-3,
                "{engine}: {} Ns at {secs} s",
                impulse(secs)
            );
        }
        let after = at(trace, part, 2.0);
        assert!((after - 0.4).abs() < 0.005, "{engine}: {after} m/s");
        assert!((at(trace, cup, 2.0) - after).abs() < 1e-3, "{engine}");
        assert_eq!(
            name_at(trace, "/truth/part.grasped_by", 0.4),
            "nobody",
            "{engine}"
        );
        assert_eq!(
            name_at(trace, "/truth/part.grasped_by", 2.0),
            "arm",
            "{engine}"
        );
    });
}

const LIFTED: &str = r#"
    name = "lifted"
    [simulation]
    duration_secs = 2.0
    time_step_secs = 0.001
    record_hz = 200
    [[abstract_test]]
    name = "lift"
    actions = [
        { set_param = { "cup.suction" = 1.0 }, after_secs = 0.2 },
        { send_signal = "lift", after_secs = 0.3 },
        { receive_signal = "lift.done" },
        { set_param = { "cup.suction" = 0.0 }, after_secs = 0.3 },
    ]
    [[object]]
    name = "table"
    box_m = [1.0, 1.0, 0.1]
    z_m = -0.05
    [[object]]
    name = "part"
    box_m = [0.1, 0.1, 0.1]
    mass_kg = 1.0
    z_m = 0.05
    [[robot]]
    name = "arm"
    file = "cup.urdf"
    fixed = true
    z_m = 0.12
    [[tool_point]]
    name = "rim"
    robot = "arm"
    link = "cup"
    roll_rad = 3.141592653589793
    [[group]]
    name = "slide"
    robot = "arm"
    joints = ["slide"]
    mode = "position"
    stiffness = 50000.0
    damping = 1500.0
    acceleration_limit = HARD
    jerk_limit = 60.0
    profile = "jerk_limited"
    [[trajectory]]
    name = "lift"
    group = "slide"
    waypoint = [{ joints = [0.4] }]
    [[gripper]]
    name = "cup"
    robot = "arm"
    kind = "suction"
    tool_point = "rim"
    reach_m = 0.03
    holding_force_newtons = 12.0
"#;

#[test]
fn a_cup_holds_up_to_its_force_and_comes_off_beyond() {
    // 1 kg needs 9.81 N and its acceleration: 11.3 N with 1.5 m/s², 13.3 N with 3.5 m/s².
    let urdf = CUP.replace("AXIS", "0 0 1");
    let files = [("cup.urdf", urdf.as_str())];
    let read = ["/truth/part.z", "/truth/part.grasped_by"];
    for (hard, holds) in [(1.5, true), (3.5, false)] {
        let text = LIFTED.replace("HARD", &format!("{hard:?}"));
        Scene::new(&text, &files).in_each(&read, |engine, trace| {
            let highest = most(trace, "/truth/part.z");
            let pull = signal(trace, "/gripper/cup.force")
                .into_iter()
                .map(|row| row.1);
            let pull = pull.filter(|it| it.is_finite()).fold(0.0, f64::max);
            match holds {
                true => {
                    assert!((highest - 0.45).abs() < 0.01, "{engine}: {highest} m");
                    assert!((pull - 11.31).abs() < 0.3, "{engine}: {pull} N");
                }
                false => {
                    assert!(highest < 0.2, "{engine}: it comes off at {highest} m");
                    assert!(pull < 12.3, "{engine}: {pull} N");
                    assert_eq!(
                        name_at(trace, "/gripper/cup.holding", 2.0),
                        "nothing",
                        "{engine}"
                    );
                }
            }
            assert_eq!(at(trace, "/gripper/cup.attached", 0.4), 1.0, "{engine}");
            // At rest on the table it is borne by both; what the cup bears is no more than the weight.
            assert_eq!(at(trace, "/gripper/cup.attached", 2.0), 0.0, "{engine}");
        });
    }
}

#[test]
fn an_episode_that_was_saved_with_something_in_the_cup_goes_on_bit_for_bit() {
    let urdf = CUP.replace("AXIS", "0 0 1");
    let files = [("cup.urdf", urdf.as_str())];
    let text = LIFTED.replace("HARD", "1.5");
    for (engine, physics) in engines() {
        let bench = Scene::new(&text, &files)
            .bench(physics, &[])
            .expect("a bench");
        let first = Stimulus::of(bench.tests()[0].clone());
        let cancel = Cancel::default();
        let whole = bench
            .run(&first, 3, &mut Unwatched, &cancel)
            .expect("a run")
            .trace;
        let mut running = bench.start(&first, 3).expect("a start");
        let middle = bench.advance(&mut running, 0.803, &mut Unwatched, &cancel);
        middle.expect("half of it");
        let saved = bench.save(&running).expect("a state");
        let mut resumed = bench.resume(&saved, None).expect("a start");
        let end = bench.advance(&mut resumed, f64::INFINITY, &mut Unwatched, &cancel);
        end.expect("the other half");
        let resumed = bench.finish(resumed).expect("a recording").trace;
        for name in ["/gripper/cup.force", "/group/slide.slide.position"] {
            let (bits, on) = (signal(&resumed, name), signal(&whole, name));
            assert_eq!(bits.len(), on.len(), "{engine} {name}");
            let same = bits
                .iter()
                .zip(&on)
                .all(|(a, b)| a.1.to_bits() == b.1.to_bits());
            assert!(same, "{engine} {name}");
        }
    }
}

#[test]
fn bad_grippers_are_told_all_at_once_with_their_keys() {
    let wrong = r#"
    [[gripper]]
    name = "second"
    robot = "arm"
    kind = "tool_changer"
    tool_point = "rom"
    tools = ["part", "hammer", "table"]
    reach_m = -1.0
    [[gripper]]
    name = "third"
    robot = "arm"
    kind = "parallel"
    joints = ["slide", "thumb"]
    open = [0.1]
    closed = [0.1, 0.0]
    width_m = 0.0
    force_limit_newtons = 10.0
"#;
    let text = LIFTED.replace("HARD", "1.5") + wrong;
    let urdf = CUP.replace("AXIS", "0 0 1");
    let files = [("cup.urdf", urdf.as_str())];
    let (_, physics) = engines().remove(0);
    let told = Scene::new(&text, &files)
        .bench(physics, &[])
        .err()
        .expect("a refusal");
    for part in [
        "`gripper.second.tool_point` names `rom`",
        "`gripper.second.tools.1` names `hammer`",
        "`gripper.second.tools.2` names `table`, which is fixed to the world",
        "`gripper.second.reach_m` must lie between 0.000000001 and 1000000 (got -1)",
        "`gripper.third.open` lists 1 where the gripper has 2 joints",
        "`gripper.third.open` is as `closed` for a joint",
        "`gripper.third.width_m` must lie between 0.000000001 and 1000000 (got 0)",
        "`gripper.third.joints.0` names `slide`, which the group `slide` drives, too",
    ] {
        assert!(told.contains(part), "no {part} in\n{told}");
    }
}

/// A second arm that comes towards the first one along the same way, with a cup that looks back.
const GIVEN: &str = r#"
    [[robot]]
    name = "other"
    file = "cup.urdf"
    fixed = true
    x_m = 0.7
    [[tool_point]]
    name = "back"
    robot = "other"
    link = "cup"
    pitch_rad = -1.5707963267948966
    [[group]]
    name = "track"
    robot = "other"
    joints = ["slide"]
    mode = "torque"
    [[gripper]]
    name = "taker"
    robot = "other"
    kind = "suction"
    tool_point = "back"
    reach_m = 0.03
    holding_force_newtons = 2000.0
"#;

#[test]
fn momentum_is_kept_as_one_arm_gives_a_part_to_another() {
    let urdf = CUP.replace("AXIS", "1 0 0");
    let files = [("cup.urdf", urdf.as_str())];
    // The first has the part from 0.55 s on, and meets the second, which stands, at about 0.9 s; then it lets go.
    let test = r#"{ set_param = { "slide.slide_newtons" = 0.0, "taker.suction" = 1.0 }, after_secs = 0.25 },
        { set_param = { "cup.suction" = 0.0, "slide.slide_newtons" = -2.0 }, after_secs = 0.55 },
        { set_param = { "slide.slide_newtons" = 0.0 }, after_secs = 0.1 },"#;
    let before = r#"{ set_param = { "slide.slide_newtons" = 0.0 }, after_secs = 0.25 },"#;
    let text = format!("{}{GIVEN}", TAKEN.replace(before, test));
    let read = ["/truth/part.velocity.x", "/truth/part.grasped_by"];
    Scene::new(&text, &files).in_each(&read, |engine, trace| {
        let names = [
            "/group/slide.slide.velocity",
            "/group/track.slide.velocity",
            "/truth/part.velocity.x",
        ];
        let impulse = |secs: f64| {
            let [first, second, part] = names.map(|name| at(trace, name, secs));
            2.0 * first + 2.0 * second + 0.5 * part
        };
        // 4 N for 0.25 s; then 2 N for 0.1 s the other way.
        for (secs, expected) in [(0.4, 1.0), (0.78, 1.0), (0.95, 0.8), (1.2, 0.8), (1.9, 0.8)] {
            assert!(
                (impulse(secs) - expected).abs() < 2e-3,
                "{engine}: {} Ns at {secs} s",
                impulse(secs)
            );
        }
        assert_eq!(
            name_at(trace, "/truth/part.grasped_by", 0.75),
            "arm",
            "{engine}"
        );
        assert_eq!(
            name_at(trace, "/truth/part.grasped_by", 1.9),
            "other",
            "{engine}"
        );
        let [_, second, part] = names.map(|name| at(trace, name, 1.9));
        assert!(
            (second - part).abs() < 1e-3,
            "{engine}: {second} and {part} m/s"
        );
    });
}

#[test]
fn a_wrist_bears_what_is_attached_beyond_it() {
    let urdf = CUP.replace("AXIS", "0 0 1");
    let files = [("cup.urdf", urdf.as_str())];
    let wrist = r#"
    [[sensor]]
    name = "wrist"
    robot = "arm"
    kind = "force_torque"
    link = "cup"
    rate_hz = 100
"#;
    let text = LIFTED.replace("HARD", "1.5").replace(
        "holding_force_newtons = 12.0",
        "holding_force_newtons = 40.0",
    );
    Scene::new(&format!("{text}{wrist}"), &files).in_each(&[], |engine, trace| {
        // The cup of 2 kg alone, then with the part of 1 kg that it has lifted and holds at rest.
        for (secs, mass_kg) in [(0.15, 2.0), (1.78, 3.0)] {
            let attached = at(trace, "/gripper/cup.attached", secs);
            assert_eq!(
                attached,
                f64::from(u8::from(mass_kg > 2.5)),
                "{engine}: at {secs} s"
            );
            let newtons = at(trace, "/sensor/wrist.force.2", secs);
            assert!(
                (newtons - 9.81 * mass_kg).abs() < 0.1,
                "{engine}: {newtons} N at {secs} s"
            );
        }
    });
}

/// A finger of two phalanges that hangs down and bends about y.
const FINGER: &str = r#"<robot name="finger">
  <link name="base"/>
  <link name="first"><inertial><origin xyz="0 0 -0.025"/><mass value="0.05"/><inertia ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><origin xyz="0 0 -0.025"/><geometry><box size="0.01 0.02 0.04"/></geometry></collision></link>
  <link name="second"><inertial><origin xyz="0 0 -0.02"/><mass value="0.03"/><inertia ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="near" type="revolute"><parent link="base"/><child link="first"/><axis xyz="0 -1 0"/><limit lower="-0.1" upper="2" effort="10" velocity="9"/><dynamics damping="0.01"/></joint>
  <joint name="far" type="revolute"><parent link="first"/><child link="second"/><origin xyz="0 0 -0.05"/><axis xyz="0 -1 0"/><limit lower="-0.1" upper="2" effort="10" velocity="9"/><dynamics damping="0.01"/></joint>
</robot>"#;

const TENDON: &str = r#"
    name = "tendon"
    abstract_test = [{ name = "pull", actions = [{ set_param = { "finger.tension_newtons" = 20.0 } }] }]
    [simulation]
    duration_secs = 3.0
    time_step_secs = 0.001
    gravity_m_s2 = 0.0
    [[robot]]
    name = "arm"
    file = "finger.urdf"
    fixed = true
    recorded_joints = ["near", "far"]
    [[gripper]]
    name = "finger"
    robot = "arm"
    kind = "under_actuated"
    joints = ["near", "far"]
    pulley_radii_m = [0.01, 0.006]
    return_stiffness = [0.4, 0.2]
    tension_limit_newtons = 50.0
"#;

/// Something in the way of the first phalanx, fixed to the world.
const POST: &str = r#"
    [[object]]
    name = "post"
    box_m = [0.02, 0.2, 0.02]
    x_m = 0.025
    z_m = -0.03
"#;

#[test]
fn a_tendon_bends_each_joint_as_far_as_its_spring_lets_it_and_goes_on_where_one_is_stopped() {
    let files = [("finger.urdf", FINGER)];
    let angles = |trace: &Trace| {
        ["near", "far"].map(|it| at(trace, &format!("/truth/arm.{it}.position"), 3.0))
    };
    // Radius times tension over stiffness: 0.2 Nm over 0.4 Nm/rad, 0.12 over 0.2.
    Scene::new(TENDON, &files).in_each(&[], |engine, trace| {
        let [near, far] = angles(trace);
        assert!(
            (near - 0.5).abs() < 0.005 && (far - 0.6).abs() < 0.005,
            "{engine}: {near}, {far}"
        );
    });
    let text = format!("{TENDON}{POST}");
    let read = [
        "/truth/arm/first.contact.post.normal_force",
        "/truth/arm/first.contact.post.touching",
    ];
    Scene::new(&text, &files).in_each(&read, |engine, trace| {
        assert!(ever(trace, read[1]), "{engine}");
        let [near, far] = angles(trace);
        assert!(near < 0.45, "{engine}: the post stops it, it is at {near}");
        assert!((far - 0.6).abs() < 0.01, "{engine}: {far}");
        // About the near joint: the tendon's torque less the spring's is what the post takes, at an arm of 20 to 45 mm.
        let newtons = at(trace, read[0], 3.0);
        let torque = 0.2 - 0.4 * near;
        assert!(
            (torque / 0.045..torque / 0.018).contains(&newtons),
            "{engine}: {newtons} N for {torque} Nm"
        );
    });
}

/// A tool with a joint of its own.
const TOOL: &str = r#"<robot name="tool">
  <link name="body"><inertial><mass value="0.8"/><inertia ixx="0.002" iyy="0.002" izz="0.002" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><box size="0.08 0.08 0.04"/></geometry></collision></link>
  <link name="bit"><inertial><origin xyz="0.05 0 0"/><mass value="0.2"/><inertia ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="turns" type="revolute"><parent link="body"/><child link="bit"/><axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="5" velocity="9"/><dynamics damping="0.01"/></joint>
</robot>"#;

#[test]
fn a_tool_is_taken_carried_and_set_down_by_events() {
    let changer = r#"
    kind = "tool_changer"
    tool_point = "rim"
    tools = ["driver", "spare"]
    reach_m = 0.12
    [[robot]]
    name = "driver"
    file = "tool.urdf"
    z_m = 0.02
    [[object]]
    name = "spare"
    radius_m = 0.02
    mass_kg = 0.1
    x_m = 0.3
    z_m = 0.02
"#;
    let cup = LIFTED.find("    kind = \"suction\"").expect("the gripper");
    let part = LIFTED
        .find("    [[object]]\n    name = \"part\"")
        .expect("the part");
    let robot = LIFTED.find("    [[robot]]").expect("the robot");
    let text = format!("{}{}{changer}", &LIFTED[..part], &LIFTED[robot..cup]);
    let text = text
        .replace("cup.suction", "cup.lock")
        .replace("HARD", "2.0")
        .replace("duration_secs = 2.0", "duration_secs = 3.0");
    let urdf = CUP.replace("AXIS", "0 0 1");
    let files = [("cup.urdf", urdf.as_str()), ("tool.urdf", TOOL)];
    let read = ["/truth/driver.tilt"];
    Scene::new(&text, &files).in_each(&read, |engine, trace| {
        assert_eq!(
            name_at(trace, "/gripper/cup.holding", 0.4),
            "driver",
            "{engine}"
        );
        let highest = most(trace, "/truth/driver.z");
        assert!((highest - 0.42).abs() < 0.005, "{engine}: {highest} m");
        // 1 kg with its bit, whose weight acts beside the flange: it hangs straight all the same.
        let carried = signal(trace, "/gripper/cup.attached");
        let last = carried
            .iter()
            .rfind(|(_, is)| *is == 1.0)
            .expect("it is carried")
            .0;
        assert!(at(trace, "/truth/driver.tilt", last) < 0.01, "{engine}");
        let newtons = at(trace, "/gripper/cup.force", last);
        assert!((newtons - 9.81).abs() < 0.1, "{engine}: {newtons} N");
        assert_eq!(
            name_at(trace, "/gripper/cup.holding", 3.0),
            "nothing",
            "{engine}"
        );
        assert!(
            at(trace, "/truth/driver.z", 3.0) < 0.05,
            "{engine}: it is set down, and falls"
        );
    });
}

/// A person whose hand is held out into the open fingers.
const HELD_OUT: &str = r#"
    name = "a hand in the gripper"
    [simulation]
    duration_secs = 1.5
    time_step_secs = 0.0005
    gravity_m_s2 = 0.0
    [[abstract_test]]
    name = "close"
    actions = [{ set_param = { "hand.width_m" = 0.0, "hand.force_newtons" = 30.0 }, after_secs = 0.2 }]
    [[person]]
    name = "anna"
    body = "compliant"
    activity = "stand"
    x_m = 0.0
    y_m = 0.0
    arms = "reach"
    reach = { shoulder_rad = 1.5707963267948966, elbow_rad = 0.0 }
    [person.compliance]
    dissipation_s_m = 5.0
    skin_n_mm = { hand = 75.0 }
    [[robot]]
    name = "arm"
    file = "hand.urdf"
    fixed = true
    x_m = 0.6755
    y_m = -0.22575
    z_m = 1.4
    joints = { left_finger = 0.048, right_finger = 0.048 }
    [[group]]
    name = "slide"
    robot = "arm"
    joints = ["up"]
    mode = "position"
    stiffness = 20000.0
    damping = 600.0
    [[gripper]]
    name = "hand"
    robot = "arm"
    kind = "parallel"
    width_m = 0.1
    force_limit_newtons = 40.0
    joints = ["left_finger", "right_finger"]
    open = [0.05, 0.05]
    closed = [0.0, 0.0]
"#;

#[test]
fn a_hand_between_the_fingers_bears_the_force_of_the_grip_and_its_skin_gives_way_by_it() {
    let urdf = hand(false);
    let files = [("hand.urdf", urdf.as_str())];
    let read = [
        "/truth/arm/left.contact.anna.right_hand.normal_force",
        "/truth/arm/right.contact.anna.right_hand.normal_force",
    ];
    Scene::new(HELD_OUT, &files).in_each(&read, |engine, trace| {
        for name in read {
            let newtons = at(trace, name, 1.5);
            assert!(
                (newtons - 30.0).abs() < 1.5,
                "{engine}: {newtons} N of {name}"
            );
        }
        // A ball of 35 mm between plane fingers: twice 30 N over 75 N/mm less than its diameter of 70 mm.
        let width = at(trace, "/gripper/hand.width", 1.5);
        assert!(
            (width - (0.07 - 2.0 * 0.0004)).abs() < 1e-3,
            "{engine}: {width} m"
        );
    });
}
