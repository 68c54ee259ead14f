//! People who take what a robot offers: they pull with their grip and no more, and have it once the robot lets go.

use crate::truths::{Scene, at, signal};
use trace::Trace;

/// A cup that looks along x and is held where it is.
const CUP: &str = r#"<robot name="cup">
  <link name="frame"/>
  <link name="cup"><inertial><mass value="2"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><sphere radius="0.01"/></geometry></collision></link>
  <joint name="slide" type="prismatic"><parent link="frame"/><child link="cup"/><axis xyz="1 0 0"/><limit lower="-1" upper="1" effort="500" velocity="1"/></joint>
</robot>"#;

/// Anna faces the cup, her right shoulder across from the part.
const CELL: &str = r#"
    name = "offered"
    [simulation]
    duration_secs = 4.0
    time_step_secs = 0.002
    record_hz = 100
    [[abstract_test]]
    name = "offer"
    actions = [
        { set_param = { "cup.suction" = 1.0 } },
        { receive_signal = "anna.took" },
        LAST
    ]
    [[object]]
    name = "part"
    box_m = [0.06, 0.06, 0.06]
    mass_kg = 0.5
    x_m = 0.045
    y_m = 0.2
    z_m = 1.2
    [[robot]]
    name = "arm"
    file = "cup.urdf"
    fixed = true
    y_m = 0.2
    z_m = 1.2
    [[tool_point]]
    name = "rim"
    robot = "arm"
    link = "cup"
    pitch_rad = 1.5707963267948966
    [[group]]
    name = "slide"
    robot = "arm"
    joints = ["slide"]
    mode = "position"
    stiffness = 20000.0
    damping = 500.0
    [[gripper]]
    name = "cup"
    robot = "arm"
    kind = "suction"
    tool_point = "rim"
    reach_m = 0.03
    holding_force_newtons = 200.0
    [[person]]
    name = "anna"
    body = "BODY"
    x_m = 0.7
    y_m = 0.0
    heading_rad = 3.141592653589793
    activity = "stand"
    takes = { object = "part", within_m = 0.72, delay_secs = 0.3, grip_newtons = 20.0 }
"#;

const FILES: [(&str, &str); 1] = [("cup.urdf", CUP)];

fn cell(body: &str, last: &str) -> String {
    let step = if body == "compliant" {
        "0.0005"
    } else {
        "0.002"
    };
    CELL.replace("BODY", body)
        .replace("STEP", step)
        .replace("LAST", last)
}

/// When a truth value becomes true.
fn since(trace: &Trace, name: &str) -> Option<f64> {
    let rows = signal(trace, name);
    rows.into_iter()
        .find(|(_, value)| *value == 1.0)
        .map(|(secs, _)| secs)
}

fn place(trace: &Trace, of: &str, secs: f64) -> [f64; 3] {
    ["x", "y", "z"].map(|axis| at(trace, &format!("{of}{axis}"), secs))
}

fn apart(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|it| (a[it] - b[it]).powi(2)).sum::<f64>().sqrt()
}

const READ: [&str; 3] = ["/truth/part.x", "/truth/part.y", "/truth/part.z"];

#[test]
fn who_takes_what_is_not_let_go_pulls_with_the_grip_and_no_more() {
    let text = cell("articulated", "");
    Scene::new(&text, &FILES).in_each(&READ, |engine, trace| {
        let of = engine;
        let took = since(trace, "/truth/anna.holding").expect("she takes it");
        // Offered from the beginning: 0.3 s, then some 0.5 m at 0.6 m/s.
        assert!((0.3..2.0).contains(&took), "{of}: at {took} s");
        // The part is at rest between both: what pulls it is what the cup bears against.
        let pulls = at(trace, "/gripper/cup.force", 3.9);
        assert!((pulls - 20.0).abs() < 1.0, "{of}: {pulls} N");
        let largest = signal(trace, "/gripper/cup.force").into_iter();
        let largest = largest
            .filter(|row| row.1.is_finite())
            .map(|row| row.1)
            .fold(0.0, f64::max);
        assert!(largest < 24.0, "{of}: {largest} N");
        let part = place(trace, "/truth/part.", 3.9);
        assert!(apart(part, [0.045, 0.2, 1.2]) < 5e-3, "{of}: {part:?}");
    });
}

#[test]
fn who_is_given_the_part_has_it_in_the_hand_before_the_chest() {
    let lets_go = r#"{ set_param = { "cup.suction" = 0.0 }, after_secs = 0.3 },"#;
    let text = cell("articulated", lets_go);
    Scene::new(&text, &FILES).in_each(&READ, |engine, trace| {
        let of = engine;
        assert_eq!(at(trace, "/test.done", 3.9), 1.0, "{of}");
        assert_eq!(at(trace, "/truth/anna.holding", 3.9), 1.0, "{of}");
        let [early, late] = [3.4, 3.9].map(|secs| place(trace, "/truth/part.", secs));
        assert!(apart(early, late) < 3e-3, "{of}: {early:?} to {late:?}");
        // It is where the hand is, and no longer where it was offered.
        let hand = place(trace, "/truth/anna.right_hand.", 3.9);
        assert!(
            apart(late, hand) < 0.12,
            "{of}: {late:?}, the hand at {hand:?}"
        );
        // Upper arm and forearm at 0.2 and 1.6 rad from hanging: 0.186 and 0.254 of 1.75 m.
        let (ahead, below) = (
            1.75 * (0.186 * 0.2_f64.sin() + 0.254 * 1.6_f64.sin()),
            1.75 * (0.186 * 0.2_f64.cos() + 0.254 * 1.6_f64.cos()),
        );
        let rests = [0.7 - ahead, 0.129 * 1.75, 1.4 - below];
        assert!(
            apart(hand, rests) < 2e-3,
            "{of}: the hand at {hand:?}, not {rests:?}"
        );
        assert!(apart(late, [0.045, 0.2, 1.2]) > 0.08, "{of}: {late:?}");
    });
}

#[test]
fn what_is_out_of_reach_is_not_reached_for_and_what_cannot_be_taken_is_refused() {
    let text = cell("articulated", "").replace("x_m = 0.7\n", "x_m = 1.5\n");
    Scene::new(&text, &FILES).in_each(&READ, |engine, trace| {
        assert_eq!(since(trace, "/truth/anna.holding"), None, "{engine}");
        let hand = place(trace, "/truth/anna.right_hand.", 3.9);
        assert!(hand[2] < 0.9, "{engine}: it hangs, at {hand:?}");
    });
    for (from, to, words) in [
        ("object = \"part\"", "object = \"cup\"", "takes.object"),
        ("mass_kg = 0.5\n", "\n", "is fixed to the world"),
        ("\"articulated\"", "\"capsule\"", "needs hands that are led"),
        (
            "\"articulated\"",
            "\"compliant\"",
            "needs hands that are led",
        ),
    ] {
        let text = cell("articulated", "").replace(from, to);
        let refused = Scene::new(&text, &FILES).bench(testbench::scene::rapier(), &[]);
        let refused = refused.err().expect("it is refused");
        assert!(refused.contains(words), "{words}: {refused}");
    }
}
