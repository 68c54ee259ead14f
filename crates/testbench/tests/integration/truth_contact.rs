//! Truth of contacts on both engines: weight, impulse, who moved into whom, who grasps.

use crate::truths::{Scene, at, ever, most, name_at, planned, signal};

const GRAVITY: f64 = 9.81;

fn floor(secs: f64, more: &str) -> String {
    format!(
        r#"
        name = "floor"
        simulation = {{ duration_secs = {secs}, record_hz = 100, time_step_secs = 0.001 }}
        ground = {{ friction = 0.8 }}
        abstract_test = [{{ name = "nothing", actions = [] }}]
        {more}"#
    )
}

#[test]
fn a_resting_object_bears_its_weight() {
    let text = floor(
        2.0,
        "object = [{ name = \"block\", box_m = [0.3, 0.2, 0.1], mass_kg = 3.0, z_m = 0.05 }]",
    );
    let read = [
        "/truth/block.contact.ground.normal_force",
        "/truth/block.contact.ground.touching",
        "/truth/block.contact.anything.normal_force",
        "/truth/block.contact.ground.tangential_force",
        "/truth/block.contact.anything.other_body",
        "/truth/block.contact.anything.own_body",
        "/truth/block.contact.ground.relative_speed",
    ];
    Scene::new(&text, &[]).in_each(&read, |engine, trace| {
        for name in ["ground", "anything"] {
            let force = at(
                trace,
                &format!("/truth/block.contact.{name}.normal_force"),
                2.0,
            );
            assert!(
                (force - 3.0 * GRAVITY).abs() < 0.02 * 3.0 * GRAVITY,
                "{engine}: {force} N"
            );
        }
        assert_eq!(
            at(trace, "/truth/block.contact.ground.touching", 2.0),
            1.0,
            "{engine}"
        );
        assert!(
            at(trace, "/truth/block.contact.ground.tangential_force", 2.0) < 0.3,
            "{engine}"
        );
        assert!(
            at(trace, "/truth/block.contact.ground.relative_speed", 2.0) < 0.01,
            "{engine}"
        );
        assert_eq!(
            name_at(trace, "/truth/block.contact.anything.other_body", 2.0),
            "ground",
            "{engine}"
        );
        assert_eq!(
            name_at(trace, "/truth/block.contact.anything.own_body", 2.0),
            "block",
            "{engine}"
        );
    });
}

#[test]
fn the_impulse_of_an_impact_is_the_change_of_momentum() {
    // It falls for 0.45 s, so that it touches at 0.4515 s or so; then it lies, and the ground bears its weight, too.
    let text = floor(
        1.0,
        "object = [{ name = \"ball\", radius_m = 0.1, mass_kg = 2.0, z_m = 1.1 }]",
    );
    let read = [
        "/truth/ball.contact.ground.impulse",
        "/truth/ball.velocity.z",
    ];
    Scene::new(&text, &[]).in_each(&read, |engine, trace| {
        let impulses = signal(trace, "/truth/ball.contact.ground.impulse");
        let (begun, _) = impulses
            .iter()
            .find(|(_, it)| *it > 0.0)
            .expect("it falls on the ground");
        let before = signal(trace, "/truth/ball.velocity.z");
        let (free, falling) = before
            .iter()
            .rev()
            .find(|(time, _)| time < begun)
            .expect("it falls");
        let (end, rising) = before.last().expect("it ends");
        // Newton: m (v1 - v0) = impulse - m g t.
        let momentum = 2.0 * (rising - falling) + 2.0 * GRAVITY * (end - free);
        let impulse = impulses.last().expect("it ends").1;
        assert!(
            (impulse - momentum).abs() < 0.01 * momentum,
            "{engine}: {impulse} N s, {momentum} N s"
        );
        assert!(momentum > 8.0, "{engine}: 2 kg at 4.4 m/s: {momentum} N s");
    });
}

#[test]
fn a_new_contact_begins_its_impulse_anew() {
    // A ball that is thrown against nothing but gravity: a soft material lets it bounce in MuJoCo; Rapier does not know it.
    let text = floor(1.6, "object = [{ name = \"ball\", radius_m = 0.1, mass_kg = 1.0, z_m = 1.1, material = \"rubber\" }]
        material = [{ name = \"rubber\", friction = 0.4, contact_time_secs = 0.02, contact_damping_ratio = 0.2 }]");
    let read = [
        "/truth/ball.contact.ground.impulse",
        "/truth/ball.contact.ground.touching",
    ];
    for (engine, physics) in crate::truths::engines() {
        let scene = Scene::new(&text, &[]);
        if engine == "Rapier" {
            let error = scene.bench(physics, &read).err().expect("it is refused");
            assert!(
                error.contains("softness") && error.contains("simulation.rapier"),
                "{error}"
            );
            continue;
        }
        let trace = scene.run(physics, &read).trace;
        let impulses = signal(&trace, "/truth/ball.contact.ground.impulse");
        let drops = impulses.windows(2).filter(|pair| pair[1].1 < pair[0].1);
        assert!(drops.count() >= 1, "it bounces and falls again");
        // One that gains energy in each contact is refused.
        let stiff = text.replace("damping_ratio = 0.2", "damping_ratio = 0.05");
        let (_, rapier) = crate::truths::engines().remove(0);
        let error = Scene::new(&stiff, &[])
            .bench(rapier, &read)
            .err()
            .expect("it is refused");
        assert!(error.contains("gain energy"), "{error}");
    }
}

/// A cart on a slide along x, its front at 0.3 m, at chest height.
const CART: &str = r#"<robot name="cart">
  <link name="rail"/>
  <link name="cart">
    <inertial><mass value="40"/><inertia ixx="2" iyy="2" izz="2" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><box size="0.6 0.6 0.6"/></geometry></collision>
  </link>
  <joint name="slide" type="prismatic"><parent link="rail"/><child link="cart"/><axis xyz="1 0 0"/>
    <limit lower="-20" upper="20" effort="10000" velocity="10"/></joint>
</robot>"#;

/// A cart that is driven at a speed along its slide, and a person at 3 m.
fn meeting(speed_m_s: f64, person: &str) -> String {
    let speed_m_s = format!("{speed_m_s:?}");
    let text = format!(
        r#"
        name = "meeting"
        simulation = {{ duration_secs = 6.0, record_hz = 50, time_step_secs = 0.002 }}
        abstract_test = [{{ name = "nothing", actions = [] }}]
        [[robot]]
        name = "cart"
        file = "cart.urdf"
        fixed = true
        z_m = 1.0
        [[actuator]]
        name = "drive"
        robot = "cart"
        kind = "velocity"
        joint = "slide"
        gain = 2000.0
        limit = 400.0
        [[person]]
        name = "anna"
        x_m = 3.0
        y_m = 0.0
        heading_rad = 3.14159
        {person}
        [[controller]]
        name = "driver"
        robot = "cart"
        period_secs = 0.02
        settings = {{ plan = [[0.0, "drive", "velocity", SPEED]] }}
        "#
    );
    text.replace("SPEED", &speed_m_s)
}

fn drives_at<'a>(text: &'a str, files: &'a [(&'a str, &'a str)]) -> Scene<'a> {
    Scene {
        text,
        files,
        start: planned,
    }
}

const FILES: [(&str, &str); 1] = [("cart.urdf", CART)];
const STANDS: &str = "activity = \"stand\"";
const WALKS: &str = "speed_m_s = 1.0\nwaypoint = [{ x_m = -3.0, y_m = 0.0 }]";

const READ: [&str; 8] = [
    "/truth/cart.contact.anna.caused_by_self",
    "/truth/cart.contact.anna.caused_by_other",
    "/truth/cart.contact.anna.moving",
    "/truth/cart.contact.anna.other_moving",
    "/truth/cart.contact.anna.touching",
    "/truth/cart.contact.people.relative_speed",
    "/truth/anna/body.contact.cart.cart.caused_by_self",
    "/truth/cart.distance_to.anna",
];

fn who(trace: &trace::Trace) -> [bool; 4] {
    let name = |it: &str| format!("/truth/cart.contact.anna.{it}");
    [
        "caused_by_self",
        "caused_by_other",
        "moving",
        "other_moving",
    ]
    .map(|it| ever(trace, &name(it)))
}

#[test]
fn a_person_who_walks_into_a_standing_robot_causes_the_contact() {
    let text = meeting(0.0, WALKS);
    drives_at(&text, &FILES).in_each(&READ, |engine, trace| {
        assert!(ever(trace, "/truth/cart.contact.anna.touching"), "{engine}");
        assert_eq!(who(trace), [false, true, false, true], "{engine}");
        // The same contact as the person's own signals tell it.
        assert!(
            ever(trace, "/truth/anna/body.contact.cart.cart.caused_by_self"),
            "{engine}"
        );
        let speed = most(trace, "/truth/cart.contact.people.relative_speed");
        assert!((speed - 1.0).abs() < 0.05, "{engine}: {speed}");
        // Always recorded, and it does not tell who came.
        assert!(most(trace, "/truth/cart.person_force") > 0.0, "{engine}");
    });
}

#[test]
fn a_robot_that_drives_into_a_standing_person_causes_the_contact() {
    let text = meeting(0.8, STANDS);
    drives_at(&text, &FILES).in_each(&READ, |engine, trace| {
        assert!(ever(trace, "/truth/cart.contact.anna.touching"), "{engine}");
        assert_eq!(who(trace), [true, false, true, false], "{engine}");
        assert!(
            !ever(trace, "/truth/anna/body.contact.cart.cart.caused_by_self"),
            "{engine}"
        );
        let speed = most(trace, "/truth/cart.contact.people.relative_speed");
        assert!((speed - 0.8).abs() < 0.05, "{engine}: {speed}");
    });
}

#[test]
fn where_both_come_both_cause_it_and_who_flees_does_not() {
    let both = meeting(0.8, WALKS);
    drives_at(&both, &FILES).in_each(&READ, |engine, trace| {
        assert_eq!(who(trace), [true, true, true, true], "{engine}");
    });
    // The robot goes away, slower than the person who comes after it.
    let fleeing = meeting(-0.4, WALKS);
    let fleeing = fleeing.replace("duration_secs = 6.0", "duration_secs = 12.0");
    let fleeing = fleeing.replace("x_m = -3.0", "x_m = -9.0");
    drives_at(&fleeing, &FILES).in_each(&READ, |engine, trace| {
        assert_eq!(who(trace), [false, true, true, true], "{engine}");
    });
}
