//! Names of truth signals: what is recorded, what is refused, and which names are offered instead.

use crate::truths::{Scene, engines};
use testbench::scene::rapier;

const ARM: &str = r#"<robot name="arm">
  <link name="post"/>
  <link name="hand">
    <inertial><mass value="1"/><inertia ixx="0.05" iyy="0.05" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><sphere radius="0.05"/></geometry></collision>
  </link>
  <joint name="wrist" type="continuous"><parent link="post"/><child link="hand"/><axis xyz="0 1 0"/></joint>
</robot>"#;

const CELL: &str = r#"
    name = "cell"
    simulation = { duration_secs = 0.1 }
    ground = { friction = 0.8 }
    abstract_test = [{ name = "nothing", actions = [] }]
    object = [{ name = "part", box_m = [0.1, 0.1, 0.1], mass_kg = 1.0, x_m = 3.0, z_m = 0.05 }, { name = "wall", box_m = [0.1, 3.0, 2.0], x_m = 5.0 }]
    person = [{ name = "anna", body = "articulated", x_m = -2.0, y_m = 0.0, activity = "stand" }]
    region = [{ name = "tray", box_m = [0.3, 0.3, 0.3], x_m = 3.0 }]
    tool_point = [{ name = "tip", robot = "arm", link = "hand", z_m = -0.1 }]
    [[robot]]
    name = "arm"
    file = "arm.urdf"
    fixed = true
    z_m = 1.0
    recorded_joints = ["wrist"]
"#;

const FILES: [(&str, &str); 1] = [("arm.urdf", ARM)];

fn refused(name: &str) -> String {
    let scene = Scene::new(CELL, &FILES);
    match scene.bench(rapier(), &[name]) {
        Err(error) => error,
        Ok(_) => panic!("{name} is taken"),
    }
}

#[test]
fn what_nobody_reads_is_not_recorded_and_changes_no_row() {
    let scene = Scene::new(CELL, &FILES);
    for (engine, physics) in engines() {
        let plain = scene.run(physics.clone(), &[]).trace;
        // Names that are recorded anyway declare nothing.
        let same = scene
            .run(
                physics.clone(),
                &["/truth/arm.speed", "/truth/arm.wrist.position"],
            )
            .trace;
        assert_eq!(plain, same, "{engine}");
        let more = scene
            .run(
                physics,
                &[
                    "/truth/arm/hand.speed",
                    "/truth/arm.velocity.x",
                    "/truth/anna/left_hand.speed",
                ],
            )
            .trace;
        for channel in &plain.channels {
            let richer = more.channel(&channel.topic).expect("the topic");
            assert_eq!(richer.times_secs, channel.times_secs);
            for row in 0..channel.len() {
                let width = channel.fields.len();
                let bits = |row: &[f64]| row.iter().map(|it| it.to_bits()).collect::<Vec<_>>();
                assert_eq!(
                    bits(&richer.row(row)[..width]),
                    bits(channel.row(row)),
                    "{engine}"
                );
            }
        }
        assert_eq!(more.channels.len(), plain.channels.len() + 2, "{engine}");
    }
}

#[test]
fn fields_have_units_and_frames() {
    let scene = Scene::new(CELL, &FILES);
    let read = [
        "/truth/arm/tip.velocity.x",
        "/truth/arm/tip.body_velocity.x",
        "/truth/arm/tip.speed",
        "/truth/part.contact.ground.impulse",
        "/truth/part.kinetic_energy",
    ];
    let trace = scene.run(rapier(), &read).trace;
    let field = |name: &str| {
        let field = trace.field(trace.signal(name).expect(name)).expect(name);
        (field.unit.clone(), field.frame.clone())
    };
    assert_eq!(field(read[0]), ("m/s".to_owned(), Some("world".to_owned())));
    assert_eq!(
        field(read[1]),
        ("m/s".to_owned(), Some("arm/tip".to_owned()))
    );
    assert_eq!(field(read[2]), ("m/s".to_owned(), None));
    let impulse: trace::units::QuantityValue =
        format!("1 {}", field(read[3]).0).parse().expect("a unit");
    let newton_seconds: trace::units::QuantityValue = "1 kg*m/s".parse().expect("a unit");
    assert_eq!(impulse.dimension(), newton_seconds.dimension());
    assert_eq!(field(read[4]).0, "J");
}

#[test]
fn a_misspelt_name_gets_the_nearest_ones() {
    let error = refused("/truth/arm/hand.sped");
    assert!(error.contains("/truth/arm/hand.speed"), "{error}");
    let error = refused("/truth/arm/hnd.speed");
    assert!(error.contains("/truth/arm/hand.speed"), "{error}");
    // Names that are recorded in any case are among them.
    let error = refused("/truth/arm.persn_distance");
    assert!(error.contains("/truth/arm.person_distance"), "{error}");
    let error = refused("/truth/arm.contact.ana.normal_force");
    assert!(
        error.contains("/truth/arm.contact.anna.normal_force"),
        "{error}"
    );
    let error = refused("/truth/part.in.tary");
    assert!(error.contains("/truth/part.in.tray"), "{error}");
    let error = refused("/truth/arm.wrst.drive_torque");
    assert!(error.contains("/truth/arm.wrist.drive_torque"), "{error}");
    let error = refused("/truth/nobody_here.qqqqqq");
    assert!(error.contains("corroborate inspect STUDY"), "{error}");
}

#[test]
fn what_cannot_be_told_says_why_and_what_to_do() {
    for (name, words) in [
        (
            "/truth/arm.contact.anna.pressure",
            vec!["area", "normal_force"],
        ),
        (
            "/truth/anna.contact.wall.normal_force",
            vec!["gives way", "distance_to"],
        ),
        ("/truth/anna.kinetic_energy", vec!["no mass"]),
        ("/truth/wall.kinetic_energy", vec!["no mass"]),
        (
            "/truth/arm/tip.distance_to.anna",
            vec!["no surface", "origin_distance_to"],
        ),
        ("/truth/arm.wrist.limit_distance", vec!["no limits"]),
        ("/truth/arm.grasped_by", vec!["objects"]),
    ] {
        let error = refused(name);
        assert!(
            words.iter().all(|word| error.contains(word)),
            "{name}: {error}"
        );
    }
}

#[test]
fn a_scene_s_own_list_is_recorded_and_checked() {
    let listed = CELL.replace(
        "tool_point =",
        "truth = { record = [\"/truth/part.tilt\"] }\n    tool_point =",
    );
    let trace = Scene::new(&listed, &FILES).run(rapier(), &[]).trace;
    assert!(trace.signal("/truth/part.tilt").is_some());
    let wrong = listed.replace("part.tilt", "part.tild");
    let error = Scene::new(&wrong, &FILES)
        .bench(rapier(), &[])
        .err()
        .expect("it is refused");
    assert!(
        error.contains("truth.record") && error.contains("/truth/part.tilt"),
        "{error}"
    );
}

#[test]
fn the_vocabulary_lists_what_can_be_named() {
    let bench = Scene::new(CELL, &FILES)
        .bench(rapier(), &[])
        .expect("sound");
    let vocabulary = bench.truth();
    let topics: Vec<&str> = vocabulary
        .topics
        .iter()
        .map(|it| it.topic.as_str())
        .collect();
    for topic in [
        "/truth/arm",
        "/truth/arm/hand",
        "/truth/arm/tip",
        "/truth/part",
        "/truth/anna/left_forearm",
        "/truth/anna/right_hand",
    ] {
        assert!(topics.contains(&topic), "{topic} among {topics:?}");
    }
    assert_eq!(
        vocabulary.topics[0].joints,
        [("wrist".to_owned(), "rad".to_owned())]
    );
    assert!(vocabulary.others.contains(&"anna.left_forearm".to_owned()));
    assert_eq!(vocabulary.regions, ["tray"]);
    // A component is never called a speed.
    for pattern in vocabulary
        .quantities
        .iter()
        .filter(|it| it.name.contains("speed"))
    {
        assert!(
            pattern.frame.is_none() && pattern.meaning.contains("magnitude"),
            "{pattern:?}"
        );
    }
}
