//! A mobile robot among shelves that runs into a carton: contacts by thing, regions, energy, and a worker who steps up to it.

use crate::truths::{Scene, at, ever, most, name_at, planned, signal};

/// A cart on wheels without a caster: it is driven as a whole.
const BASE: &str = r#"<robot name="base">
  <link name="chassis">
    <inertial><origin xyz="0 0 0.15"/><mass value="30"/><inertia ixx="1" iyy="1.5" izz="2" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><origin xyz="0 0 0.2"/><geometry><box size="0.6 0.5 0.38"/></geometry></collision>
  </link>
  <link name="mast">
    <inertial><origin xyz="0 0 0.4"/><mass value="2"/><inertia ixx="0.1" iyy="0.1" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><origin xyz="0 0 0.4"/><geometry><cylinder radius="0.04" length="0.8"/></geometry></collision>
  </link>
  <joint name="lift" type="prismatic"><parent link="chassis"/><child link="mast"/><origin xyz="0 0 0.4"/><axis xyz="0 0 1"/><limit lower="0" upper="0.5" effort="1000" velocity="1"/></joint>
</robot>"#;

/// The aisle runs along x between two shelves; a tall box stands in it at x = 1.5.
const AISLE: &str = r#"
    name = "aisle"
    ground = { friction = 0.1 }
    abstract_test = [{ name = "drive", actions = [] }]
    simulation = { duration_secs = 6.0, time_step_secs = 0.002, record_hz = 50, people_hz = 100 }
    truth = { standing_below_m_s = 0.1 }
    region = [{ name = "aisle", box_m = [6.0, 1.6, 3.0], z_m = 1.5 }]
    object = [
        { name = "shelf_left", box_m = [6.0, 0.4, 2.0], y_m = 1.2, z_m = 1.0 },
        { name = "shelf_right", box_m = [6.0, 0.4, 2.0], y_m = -1.2, z_m = 1.0 },
        { name = "carton", box_m = [0.15, 0.3, 0.6], mass_kg = 2.0, x_m = 1.5, z_m = 0.3, friction = 0.9 },
    ]
    [[robot]]
    name = "picker"
    file = "base.urdf"
    x_m = -1.0
    z_m = 0.0
    friction = 0.1
    [[actuator]]
    name = "lift"
    robot = "picker"
    kind = "position"
    joint = "lift"
    stiffness = 3000.0
    damping = 300.0
    limit = 500.0
    [[actuator]]
    name = "drive"
    robot = "picker"
    kind = "planar_velocity"
    longest_speed_m_s = 1.0
    longest_turn_rate_rad_s = 1.0
    gain_ns_m = 400.0
    turn_gain_nms_rad = 100.0
    force_limit_newtons = 200.0
    torque_limit_nm = 50.0
    [[controller]]
    name = "program"
    robot = "picker"
    period_secs = 0.02
    settings = { plan = [[0.0, "drive", "forward", SPEED], [4.0, "drive", "forward", 0.0]] }
"#;

const READ: [&str; 11] = [
    "/truth/carton.speed",
    "/truth/carton.in.aisle",
    "/truth/carton.upright",
    "/truth/picker.contact.carton.caused_by_self",
    "/truth/picker.contact.objects.other_body",
    "/truth/picker/mast.z",
    "/truth/picker.wholly_in.aisle",
    "/truth/picker.distance_to.shelf_left",
    "/truth/picker/chassis.body_velocity.x",
    "/truth/picker.kinetic_energy",
    "/truth/picker.lift.limit_distance",
];

fn aisle(speed_m_s: f64, more: &str) -> String {
    format!(
        "{}\n{more}",
        AISLE.replace("SPEED", &format!("{speed_m_s:?}"))
    )
}

fn driving<'a>(text: &'a str, files: &'a [(&'a str, &'a str)]) -> Scene<'a> {
    Scene {
        text,
        files,
        start: planned,
    }
}

const FILES: [(&str, &str); 1] = [("base.urdf", BASE)];

#[test]
fn a_robot_that_runs_into_a_carton_pushes_it_along() {
    let text = aisle(0.8, "");
    driving(&text, &FILES).in_each(&READ, |engine, trace| {
        assert_eq!(at(trace, "/truth/carton.upright", 0.5), 1.0, "{engine}");
        assert!(
            ever(trace, "/truth/picker.contact.carton.caused_by_self"),
            "{engine}"
        );
        let (hit, _) = signal(trace, "/truth/picker.contact.objects.other_body")
            .into_iter()
            .find(|(_, body)| *body != 0.0)
            .expect("it hits something");
        assert_eq!(
            name_at(trace, "/truth/picker.contact.objects.other_body", hit),
            "carton",
            "{engine}"
        );
        // It is pushed along, as fast as the robot drives.
        let pushed = most(trace, "/truth/carton.speed");
        assert!(pushed > 0.6, "{engine}: {pushed} m/s");
        assert_eq!(at(trace, "/truth/carton.in.aisle", 6.0), 1.0, "{engine}");
        let gap = at(trace, "/truth/picker.distance_to.shelf_left", 0.0);
        assert!((gap - 0.75).abs() < 0.01, "{engine}: {gap} m");
        assert_eq!(
            at(trace, "/truth/picker.wholly_in.aisle", 0.0),
            1.0,
            "{engine}"
        );
        let before = hit - 0.1;
        let speed = at(trace, "/truth/picker/chassis.body_velocity.x", before);
        assert!((speed - 0.8).abs() < 0.1, "{engine}: {speed} m/s");
        let energy = at(trace, "/truth/picker.kinetic_energy", before);
        assert!(
            (energy - 16.0 * speed * speed).abs() < 0.05 * energy,
            "{engine}: {energy} J"
        );
        assert!(
            at(trace, "/truth/picker.lift.limit_distance", 1.0).abs() < 0.02,
            "{engine}: it is down"
        );
    });
}

#[test]
fn a_worker_who_walks_into_the_standing_robot_is_told_apart_from_one_it_runs_into() {
    let worker = |x_m: f64, does: &str| {
        format!(
            "[[person]]\nname = \"kim\"\nbody = \"articulated\"\nx_m = {x_m:?}\ny_m = 0.0\nheading_rad = 3.14159\n{does}"
        )
    };
    let read = [
        "/truth/picker.contact.people.caused_by_self",
        "/truth/picker.contact.people.caused_by_other",
        "/truth/picker.contact.people.moving",
        "/truth/picker.contact.people.touching",
        "/truth/picker.contact.people.normal_force",
    ];
    let who = |trace: &trace::Trace| [0, 1, 2].map(|place: usize| ever(trace, read[place]));
    // The carton is out of the way.
    let clear =
        |text: String| text.replace("x_m = 1.5, z_m = 0.3", "x_m = 1.5, y_m = -0.8, z_m = 0.3");
    let walks = "speed_m_s = 1.0\nwaypoint = [{ x_m = -4.0, y_m = 0.0 }]";
    let text = clear(aisle(0.0, &worker(1.0, walks)));
    driving(&text, &FILES).in_each(&read, |engine, trace| {
        assert!(most(trace, read[4]) > 0.0, "{engine}");
        // Pushed on, it may be moving when it is touched again; that tells nothing of who caused it.
        assert_eq!(who(trace)[..2], [false, true], "{engine}");
    });
    let text = clear(aisle(0.8, &worker(1.0, "activity = \"stand\"")));
    driving(&text, &FILES).in_each(&read, |engine, trace| {
        assert!(ever(trace, read[3]), "{engine}");
        assert_eq!(who(trace), [true, false, true], "{engine}");
    });
}
