//! What a scene is warned of beforehand: joints beyond their limits, drives that the step does not carry, fingers that sink.
//! What is told of drives is held against what the engines then do.

use crate::truths::{Scene, at, engines, most, signal};
use stimulus::Stimulus;
use testbench::scene::rapier;
use testbench::{Bench, Cancel, SimError, Unwatched};

/// An upper link and a light one at its end, which turn about z, without gravity's help.
const ARM: &str = r#"<robot name="arm">
  <link name="frame"/>
  <link name="upper"><inertial><origin xyz="0.2 0 0"/><mass value="1.5"/><inertia ixx="0.002" iyy="0.02" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="fore"><inertial><origin xyz="0.2 0 0"/><mass value="1"/><inertia ixx="0.001" iyy="0.015" izz="0.015" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="shoulder" type="revolute"><parent link="frame"/><child link="upper"/><axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="80" velocity="2"/></joint>
  <joint name="elbow" type="revolute"><parent link="upper"/><child link="fore"/><origin xyz="0.4 0 0"/><axis xyz="0 0 1"/><limit lower="0.5" upper="2.8" effort="50" velocity="3"/></joint>
</robot>"#;

const FILES: [(&str, &str); 1] = [("arm.urdf", ARM)];

const CELL: &str = r#"
    name = "cell"
    [[abstract_test]]
    name = "go"
    actions = [{ set_param = { "joints.shoulder_rad" = 0.0005, "joints.elbow_rad" = 1.0005 } }]
    [simulation]
    duration_secs = 2.0
    time_step_secs = 0.002
    record_hz = 250
    [[robot]]
    name = "arm"
    file = "arm.urdf"
    fixed = true
    BEGINS
    [[group]]
    name = "joints"
    robot = "arm"
    joints = ["shoulder", "elbow"]
    mode = "position"
    stiffness = STIFFNESS
    damping = DAMPING
    torque_limit = 2000.0
"#;

/// Inertias of both joints with the elbow at 1 rad, each with the other free: `det M / M_jj` of the mass matrix by hand.
fn effective() -> [f64; 2] {
    let (along, lever) = (1.0_f64.cos(), 0.4 * 0.2);
    let fore = 0.015 + 0.2 * 0.2;
    let upper = 0.02 + 1.5 * 0.2 * 0.2 + 0.4 * 0.4 + fore + 2.0 * lever * along;
    let between = fore + lever * along;
    let det = upper * fore - between * between;
    [det / fore, det / upper]
}

fn cell(stiffness: [f64; 2], damping: f64) -> String {
    CELL.replace("BEGINS", "joints = { elbow = 1.0 }")
        .replace("STIFFNESS", &format!("{stiffness:?}"))
        .replace("DAMPING", &format!("{damping:?}"))
}

/// How far the joints swing from where they are told to be in the second half of the run.
fn swings(trace: &trace::Trace) -> f64 {
    let far = |joint: &str, wanted: f64| {
        let rows = signal(trace, &format!("/group/joints.{joint}.position"));
        let late = rows.into_iter().filter(|(secs, _)| *secs > 1.0);
        late.map(|(_, position)| (position - wanted).abs())
            .fold(0.0, f64::max)
    };
    far("shoulder", 0.0005).max(far("elbow", 1.0005))
}

#[test]
fn drives_are_told_to_chatter_where_they_do_by_the_bound_of_the_integrator() {
    let step_secs: f64 = 0.002;
    for damping in [0.0, 3.0] {
        let alone = effective()
            .map(|inertia| (4.0 * inertia + 2.0 * step_secs * damping) / step_secs.powi(2));
        // Shares of what each joint alone would carry. Two joints at 0.8 of it are too much together.
        for (shares, chatters) in [
            ([0.4, 0.4], false),
            ([0.9, 0.01], false),
            ([1.1, 0.01], true),
            ([0.01, 0.9], false),
            ([0.01, 1.1], true),
            ([0.8, 0.8], true),
        ] {
            let stiffness = [0, 1].map(|it| shares[it] * alone[it]);
            let text = cell(stiffness, damping);
            let scene = Scene::new(&text, &FILES);
            for (engine, physics) in engines() {
                let of = format!("{engine}, {shares:?} with {damping} Nms/rad");
                let bench = scene.bench(physics, &[]).expect("a bench");
                let told = bench.cautions();
                // Rapier's drives are implicit in their stiffness, too.
                let chatters = chatters && engine == "MuJoCo";
                assert_eq!(told.len(), usize::from(chatters), "{of}: {told:?}");
                let first = Stimulus::of(bench.tests()[0].clone());
                let swings = match bench.run(&first, 3, &mut Unwatched, &Cancel::default()) {
                    Ok(recorded) => swings(&recorded.trace),
                    Err(SimError::Unstable { .. }) => f64::INFINITY,
                    Err(other) => panic!("{of}: {other}"),
                };
                assert_eq!(swings > 0.02, chatters, "{of}: {swings} rad");
            }
        }
    }
}

#[test]
fn a_drive_that_chatters_is_told_with_its_numbers_and_a_step_that_carries_it() {
    let Some((_, mujoco)) = engines().into_iter().find(|it| it.0 == "MuJoCo") else {
        return;
    };
    let [_, inertia] = effective();
    let text = cell([100.0, 1.5 * 4.0 * inertia / 4e-6], 0.0);
    let told = Scene::new(&text, &FILES)
        .bench(mujoco.clone(), &[])
        .expect("a bench");
    let [told] = told.cautions() else {
        panic!("one caution: {:?}", told.cautions());
    };
    assert_eq!(
        (told.key.as_str(), told.element.as_str()),
        ("group.joints.stiffness", "joint elbow")
    );
    let stable = format!("{:.4} Nm/rad are stable", 4.0 * inertia / 4e-6);
    assert!(told.what.contains(&stable), "{stable}: {}", told.what);
    let shorter = 0.002 / 1.5_f64.sqrt();
    assert!(
        told.consequence.contains(&format!("below {shorter:.2e} s")),
        "{shorter}: {}",
        told.consequence
    );
    let text = text.replace("time_step_secs = 0.002", "time_step_secs = 0.001");
    let mended = Scene::new(&text, &FILES)
        .bench(mujoco, &[])
        .expect("a bench");
    assert!(mended.cautions().is_empty(), "{:?}", mended.cautions());
}

#[test]
fn a_joint_that_is_put_beyond_its_limits_is_refused_and_one_that_is_so_described_is_told() {
    let text = |begins: &str| {
        CELL.replace("BEGINS", begins)
            .replace("STIFFNESS", "50.0")
            .replace("DAMPING", "5.0")
    };
    for (begins, says) in [
        ("joints = { elbow = 2.9 }", "is 2.9"),
        (
            "joints = { elbow = { uniform = [2.0, 3.0] } }",
            "draws from 2 to 3",
        ),
    ] {
        let refused = Scene::new(&text(begins), &FILES).bench(rapier(), &[]);
        let refused = refused.err().expect("it is refused");
        for words in [
            "robot.arm.joints.elbow",
            says,
            "range in arm.urdf is 0.5 to 2.8",
        ] {
            assert!(refused.contains(words), "{words}: {refused}");
        }
    }
    // As stock arms do: the description's position 0 is none that the elbow can have.
    let text = text("");
    let scene = Scene::new(&text, &FILES);
    for (engine, physics) in engines() {
        let bench = scene.bench(physics, &[]).expect("a bench");
        let [told] = bench.cautions() else {
            panic!("{engine}: {:?}", bench.cautions());
        };
        assert_eq!(told.key, "robot.arm", "{engine}");
        assert!(
            told.what
                .contains("begins at 0 rad, beyond its range of 0.5 to 2.8 rad in arm.urdf")
                && told.consequence.contains("robot.arm.joints.elbow"),
            "{engine}: {told:?}"
        );
    }
}

/// Two fingers and a part between them that is heavy beside them.
const HAND: &str = r#"<robot name="hand">
  <link name="palm"/>
  <link name="left"><inertial><mass value="0.015"/><inertia ixx="1e-5" iyy="1e-5" izz="1e-5" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><box size="0.03 0.04 0.03"/></geometry></collision></link>
  <link name="right"><inertial><mass value="0.015"/><inertia ixx="1e-5" iyy="1e-5" izz="1e-5" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><box size="0.03 0.04 0.03"/></geometry></collision></link>
  <joint name="left_finger" type="prismatic"><parent link="palm"/><child link="left"/><origin xyz="0 0.02 0"/><axis xyz="0 1 0"/><limit lower="0" upper="0.08" effort="100" velocity="1"/></joint>
  <joint name="right_finger" type="prismatic"><parent link="palm"/><child link="right"/><origin xyz="0 -0.02 0"/><axis xyz="0 -1 0"/><limit lower="0" upper="0.08" effort="100" velocity="1"/><mimic joint="left_finger"/></joint>
</robot>"#;

const GRIP: &str = r#"
    name = "cell"
    abstract_test = [{ name = "grip", actions = [{ set_param = { "hand.width_m" = 0.0 } }] }]
    [simulation]
    duration_secs = 2.0
    time_step_secs = 0.002
    gravity_m_s2 = 0.0
    SOLVER
    [[object]]
    name = "part"
    box_m = [0.1, 0.1, 0.1]
    mass_kg = 5.0
    [[robot]]
    name = "arm"
    file = "hand.urdf"
    fixed = true
    joints = { left_finger = 0.06 }
    [[gripper]]
    name = "hand"
    robot = "arm"
    kind = "parallel"
    joints = ["left_finger"]
    open = [0.08]
    closed = [0.0]
    width_m = 0.16
    force_limit_newtons = 30.0
"#;

#[test]
fn fingers_that_sink_into_what_they_hold_are_told_in_rapier_with_a_frequency_that_helps() {
    let files = [("hand.urdf", HAND)];
    let sinks = |solver: &str| {
        let text = GRIP.replace("SOLVER", solver);
        let scene = Scene::new(&text, &files);
        let bench = scene.bench(rapier(), &[]).expect("a bench");
        let trace = scene.run(rapier(), &["/truth/arm/left.y"]).trace;
        // The finger's middle less half of it and half of the part.
        (
            bench.cautions().to_vec(),
            0.07 - at(&trace, "/truth/arm/left.y", 2.0),
        )
    };
    let (told, deep_m) = sinks("");
    let [told] = told.as_slice() else {
        panic!("{told:?}");
    };
    // 30 N on four points of 15 g at 30 Hz: 14 mm.
    assert!((deep_m - 0.014).abs() < 0.003, "{deep_m} m");
    assert!(told.what.contains("sink about 14 mm"), "{told:?}");
    let hz = told.consequence.split("contact_frequency_hz = ").nth(1);
    let hz = hz.and_then(|it| it.split(' ').next()).expect("a frequency");
    let (told, deep_m) = sinks(&format!("rapier = {{ contact_frequency_hz = {hz} }}"));
    assert!(told.is_empty(), "{told:?}");
    assert!(deep_m < 0.0015, "{deep_m} m at {hz} Hz");
}

#[test]
fn nothing_is_told_of_a_scene_with_which_nothing_is_wrong() {
    let text = cell([400.0, 150.0], 20.0);
    for (engine, physics) in engines() {
        let scene = Scene::new(&text, &FILES);
        let bench = scene.bench(physics.clone(), &[]).expect("a bench");
        assert!(
            bench.cautions().is_empty(),
            "{engine}: {:?}",
            bench.cautions()
        );
        let trace = scene.run(physics, &[]).trace;
        assert!(
            most(&trace, "/group/joints.elbow.position") < 1.01,
            "{engine}"
        );
    }
}
