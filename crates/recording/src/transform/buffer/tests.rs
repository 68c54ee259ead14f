use super::*;

fn shifted(x: f64) -> Transform {
    Transform::new([x, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]).unwrap()
}

fn about_z(angle_rad: f64, translation_m: [f64; 3]) -> Transform {
    let half = angle_rad / 2.0;
    Transform::new(translation_m, [0.0, 0.0, half.sin(), half.cos()]).unwrap()
}

/// Two arms on one base; the left one turns with 1 rad/s, sampled at 10 Hz with noise-free
/// poses, of which spherical interpolation is exact.
fn two_arms() -> TransformBuffer {
    let mut buffer = TransformBuffer::new(10.0);
    buffer
        .insert(
            "world",
            "base",
            0.0,
            about_z(std::f64::consts::PI, [2.0, 0.0, 0.0]),
            true,
        )
        .unwrap();
    buffer
        .insert("base", "right", 0.0, shifted(-0.5), true)
        .unwrap();
    for step in 0..=20 {
        let time_secs = f64::from(step) / 10.0;
        buffer
            .insert(
                "base",
                "left",
                time_secs,
                about_z(time_secs, [0.5, 0.0, 0.0]),
                false,
            )
            .unwrap();
    }
    buffer
        .insert("left", "tip", 0.0, shifted(0.3), true)
        .unwrap();
    buffer
}

#[test]
fn chains_across_the_tree_agree_with_the_closed_form() {
    let buffer = two_arms();
    for time_secs in [0.0_f64, 0.05, 0.1, 0.777, 1.99, 2.0] {
        // In the base: (0.5 + 0.3 cos t, 0.3 sin t); seen from the right arm: 0.5 further.
        let (x, y) = (0.5 + 0.3 * time_secs.cos(), 0.3 * time_secs.sin());
        let tip = buffer
            .lookup("right", "tip", time_secs)
            .unwrap()
            .translation_m;
        assert!((tip[0] - (x + 0.5)).abs() < 1e-12, "{time_secs}: {tip:?}");
        assert!((tip[1] - y).abs() < 1e-12, "{time_secs}: {tip:?}");
        // The base is turned by half a turn in the world.
        let tip = buffer
            .lookup("/world", "tip", time_secs)
            .unwrap()
            .translation_m;
        assert!((tip[0] - (2.0 - x)).abs() < 1e-12 && (tip[1] + y).abs() < 1e-12);
        let there = buffer.lookup("tip", "world", time_secs).unwrap();
        let back = buffer
            .lookup("world", "tip", time_secs)
            .unwrap()
            .then_inner(&there);
        assert!(back.distance_m() < 1e-12);
    }
    assert_eq!(
        buffer.lookup("tip", "tip", 99.0).unwrap(),
        Transform::IDENTITY
    );
}

#[test]
fn nothing_is_extrapolated() {
    let buffer = two_arms();
    let late = buffer.lookup("world", "tip", 2.0001).unwrap_err();
    assert!(
        matches!(&late, LookupError::TooLate { frame, newest_secs, .. } if frame == "left" && *newest_secs == 2.0)
    );
    assert!(late.may_come());
    let early = buffer.lookup("world", "tip", -0.1).unwrap_err();
    assert!(matches!(&early, LookupError::TooEarly { frame, .. } if frame == "left"));
    assert!(!early.may_come());
    // What is static is known at all times.
    assert!(buffer.lookup("world", "right", -5.0).is_ok());
}

#[test]
fn what_is_not_connected_is_named() {
    let mut buffer = two_arms();
    let message = buffer
        .lookup("world", "thumb", 1.0)
        .unwrap_err()
        .to_string();
    assert!(
        message.contains("thumb is not known") && message.contains("left"),
        "{message}"
    );
    buffer
        .insert("map", "person", 0.0, shifted(1.0), true)
        .unwrap();
    let message = buffer.lookup("person", "tip", 1.0).unwrap_err().to_string();
    assert!(
        message.contains("person is below map, tip below world"),
        "{message}"
    );
    // A frame that was only asked for is still unknown.
    let (asked, world) = (buffer.frame("ghost"), buffer.frame("world"));
    let message = buffer
        .lookup_frames(world, asked, 1.0)
        .unwrap_err()
        .to_string();
    assert!(
        message.contains("ghost is not known") && !message.contains(", ghost"),
        "{message}"
    );
}

#[test]
fn loops_and_double_kinds_are_refused() {
    let mut buffer = two_arms();
    let problem = buffer
        .insert("tip", "world", 0.0, shifted(0.0), true)
        .unwrap_err();
    assert!(matches!(problem, TransformProblem::Loop { .. }));
    let problem = buffer
        .insert("tip", "tip", 0.0, shifted(0.0), true)
        .unwrap_err();
    assert!(matches!(problem, TransformProblem::Loop { .. }));
    let problem = buffer
        .insert("base", "right", 0.0, shifted(0.0), false)
        .unwrap_err();
    assert!(matches!(problem, TransformProblem::StaticAndMoving { .. }));
    assert!(buffer.insert("base", "", 0.0, shifted(0.0), false).is_err());
    assert!(buffer.lookup("world", "tip", 1.0).is_ok());
}

#[test]
fn history_is_bounded_and_covers_what_it_says() {
    let mut buffer = TransformBuffer::new(1.0);
    for step in 0..1000 {
        let x = f64::from(step) / 10.0;
        buffer
            .insert("world", "cart", x, shifted(x), false)
            .unwrap();
    }
    let x_at = |time_secs| {
        buffer
            .lookup("world", "cart", time_secs)
            .map(|pose| pose.translation_m[0])
    };
    assert!((x_at(98.9).unwrap() - 98.9).abs() < 1e-12);
    assert!(matches!(x_at(98.0), Err(LookupError::TooEarly { .. })));
    let late = buffer
        .clone()
        .insert("world", "cart", 50.0, shifted(0.0), false);
    assert!(matches!(late, Err(TransformProblem::TooOld { .. })));
}

#[test]
fn samples_out_of_order_are_sorted_and_repeated_ones_left_out() {
    let mut buffer = TransformBuffer::new(10.0);
    for time_secs in [0.0, 2.0, 1.0, 1.0] {
        let again = buffer.repeated();
        let x = time_secs * time_secs + again as f64;
        buffer
            .insert("world", "cart", time_secs, shifted(x), false)
            .unwrap();
    }
    assert_eq!(buffer.repeated(), 1);
    let x = buffer.lookup("world", "cart", 1.5).unwrap().translation_m[0];
    assert!((x - 2.5).abs() < 1e-12);
}

#[test]
fn a_change_of_parent_is_not_bridged() {
    let mut buffer = TransformBuffer::new(10.0);
    buffer
        .insert("world", "table", 0.0, shifted(1.0), true)
        .unwrap();
    buffer
        .insert("world", "robot", 0.0, shifted(5.0), true)
        .unwrap();
    buffer
        .insert("table", "cup", 1.0, shifted(0.1), false)
        .unwrap();
    let before = buffer.shape();
    buffer
        .insert("robot", "cup", 2.0, shifted(0.2), false)
        .unwrap();
    assert_ne!(buffer.shape(), before);
    let x_at = |time_secs| {
        buffer
            .lookup("world", "cup", time_secs)
            .map(|pose| pose.translation_m[0])
    };
    assert!((x_at(1.0).unwrap() - 1.1).abs() < 1e-12);
    assert!((x_at(2.0).unwrap() - 5.2).abs() < 1e-12);
    assert!(matches!(x_at(1.5), Err(LookupError::ParentChanges { .. })));
}

#[test]
fn the_chain_names_each_edge_once() {
    let mut buffer = two_arms();
    let [right, tip] = ["right", "tip"].map(|name| buffer.frame(name));
    let chain = buffer.chain(right, tip).unwrap();
    let named: Vec<(&str, bool)> = chain
        .iter()
        .map(|&(frame, fixed)| (buffer.name(frame), fixed))
        .collect();
    assert_eq!(named, [("tip", true), ("left", false), ("right", true)]);
}
