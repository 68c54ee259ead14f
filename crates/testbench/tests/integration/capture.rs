//! People from motion capture: one motion in three formats is the same motion, at the scene's rate, in the scene's frame.

use crate::truths::{Scene, at, name_at};
use std::collections::BTreeMap;
use std::sync::Arc;
use stimulus::Stimulus;
use testbench::scene::{SceneBench, rapier};
use testbench::{Bench, Cancel, Unwatched};
use trace::Trace;

/// The points at a time, in metres, x forwards, y to the left, z up: somebody who walks forwards at 1 m/s with the left arm stretched
/// forwards, the right one hanging.
fn points(secs: f64) -> Vec<(&'static str, [f64; 3])> {
    let x = secs;
    let mut all = vec![("head", [x, 0.0, 1.64])];
    for (side, y) in [("left", 1.0), ("right", -1.0)] {
        let forward = if side == "left" { 1.0 } else { 0.0 };
        let arm = |length: f64| {
            [
                x + forward * length,
                0.2 * y,
                1.4 - (1.0 - forward) * length,
            ]
        };
        let named =
            |left: &'static str, right: &'static str| if side == "left" { left } else { right };
        all.push((named("left_shoulder", "right_shoulder"), arm(0.0)));
        all.push((named("left_elbow", "right_elbow"), arm(0.3)));
        all.push((named("left_hand", "right_hand"), arm(0.7)));
        all.push((named("left_hip", "right_hip"), [x, 0.1 * y, 0.95]));
        all.push((named("left_foot", "right_foot"), [x, 0.1 * y, 0.05]));
    }
    all
}

/// Ten frames in a second.
fn times(frames: usize) -> Vec<f64> {
    (0..frames).map(|it| it as f64 / 10.0).collect()
}

/// A table in metres with z up, and the names of the body.
fn csv(frames: usize) -> String {
    let mut text = "time_secs".to_owned();
    for (name, _) in points(0.0) {
        text.push_str(&format!(",{name}.x,{name}.y,{name}.z"));
    }
    text.push('\n');
    for secs in times(frames) {
        text.push_str(&secs.to_string());
        for (_, place) in points(secs) {
            text.push_str(&place.map(|it| format!(",{it}")).concat());
        }
        text.push('\n');
    }
    text
}

/// A hierarchy in centimetres with y up and z forwards, so that x is to the left. Its arms hang at rest; the left one is turned by
/// -90 degrees about x, which takes it from down to forwards.
fn bvh(frames: usize) -> String {
    let arm = |side: &str, x: f64| {
        format!(
            "JOINT {side}Arm\n{{ OFFSET {x} 45 0 CHANNELS 3 Zrotation Xrotation Yrotation
            JOINT {side}ForeArm\n{{ OFFSET 0 -30 0 CHANNELS 3 Zrotation Xrotation Yrotation
            JOINT {side}Hand\n{{ OFFSET 0 -40 0 CHANNELS 3 Zrotation Xrotation Yrotation End Site {{ OFFSET 0 -5 0 }} }} }} }}\n"
        )
    };
    let leg = |side: &str, x: f64| {
        format!(
            "JOINT {side}Leg\n{{ OFFSET {x} 0 0 CHANNELS 3 Zrotation Xrotation Yrotation End Site {{ OFFSET 0 -90 0 }} }}\n"
        )
    };
    let mut text = format!(
        "HIERARCHY\nROOT Hips\n{{ OFFSET 0 0 0 CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
        {}{}{}{}JOINT Head\n{{ OFFSET 0 69 0 CHANNELS 3 Zrotation Xrotation Yrotation End Site {{ OFFSET 0 10 0 }} }} }}
        MOTION\nFrames: {frames}\nFrame Time: 0.1\n",
        arm("Left", 20.0),
        arm("Right", -20.0),
        leg("Left", 10.0),
        leg("Right", -10.0),
    );
    for secs in times(frames) {
        let root = format!("0 95 {} 0 0 0", 100.0 * secs);
        let still = "0 0 0";
        let left = format!("0 -90 0 {still} {still}");
        let rest = [still; 6].join(" ");
        text.push_str(&format!("{root} {left} {rest}\n"));
    }
    text
}

const OF_BVH: &str = r#"
    unit = "cm"
    up = "y"
    forward = "z"
    [person.capture.points]
    head = "Head"
    left_shoulder = "LeftArm"
    right_shoulder = "RightArm"
    left_elbow = "LeftForeArm"
    right_elbow = "RightForeArm"
    left_hand = "LeftHand"
    right_hand = "RightHand"
    left_hip = "LeftLeg"
    right_hip = "RightLeg"
    left_foot = "LeftLeg.end"
    right_foot = "RightLeg.end"
"#;

/// Names of the body's points as they are; the head is the middle of itself and itself.
fn own_names(unit: &str) -> String {
    let names = points(0.0).into_iter().map(|(name, _)| match name {
        "head" => "head = [\"head\", \"head\"]\n".to_owned(),
        name => format!("{name} = \"{name}\"\n"),
    });
    let names: String = names.collect();
    format!("{unit}\nup = \"z\"\nforward = \"x\"\n[person.capture.points]\n{names}")
}

/// Bytes of a C3D file in millimetres, as floating-point numbers or scaled whole ones, of an Intel or a MIPS processor.
struct C3d {
    is_big_endian: bool,
    is_whole: bool,
}

impl C3d {
    fn whole(&self, number: i16) -> [u8; 2] {
        if self.is_big_endian {
            number.to_be_bytes()
        } else {
            number.to_le_bytes()
        }
    }

    fn float(&self, number: f32) -> [u8; 4] {
        if self.is_big_endian {
            number.to_be_bytes()
        } else {
            number.to_le_bytes()
        }
    }

    fn parameter(&self, id: i8, name: &str, kind: i8, dimensions: &[u8], data: &[u8]) -> Vec<u8> {
        let mut bytes = vec![name.len() as u8, id as u8];
        bytes.extend(name.as_bytes());
        let next = 2 + 2 + dimensions.len() + data.len() + 1;
        bytes.extend(self.whole(next as i16));
        bytes.extend([kind as u8, dimensions.len() as u8]);
        bytes.extend(dimensions);
        bytes.extend(data);
        bytes.push(0);
        bytes
    }

    fn of(&self, frames: usize, missing: &dyn Fn(usize, &str) -> bool) -> Vec<u8> {
        let names = points(0.0);
        let scale = if self.is_whole { 0.1 } else { -0.1 };
        let mut header = vec![2, 0x50];
        for number in [names.len() as i16, 0, 1, frames as i16, 10] {
            header.extend(self.whole(number));
        }
        header.extend(self.float(scale));
        header.extend(self.whole(4));
        header.extend(self.whole(0));
        header.extend(self.float(10.0));
        header.resize(512, 0);
        let mut parameters = vec![1, 0x50, 2, if self.is_big_endian { 86 } else { 84 }];
        parameters.extend([5, 255]);
        parameters.extend(b"POINT");
        parameters.extend(self.whole(3));
        parameters.push(0);
        let labels: String = names
            .iter()
            .map(|(name, _)| format!("{name:<16}"))
            .collect();
        let count = names.len() as u8;
        parameters.extend(self.parameter(1, "LABELS", -1, &[16, count], labels.as_bytes()));
        parameters.extend(self.parameter(1, "UNITS", -1, &[2], b"mm"));
        parameters.extend(self.parameter(1, "RATE", 4, &[], &self.float(10.0)));
        parameters.extend([0, 0]);
        parameters.resize(1024, 0);
        let mut all = [header, parameters].concat();
        for (frame, secs) in times(frames).into_iter().enumerate() {
            for (name, place) in points(secs) {
                let residual = if missing(frame, name) { -1.0 } else { 0.0 };
                for number in place.map(|it| 1000.0 * it) {
                    match self.is_whole {
                        true => all.extend(self.whole((number / 0.1).round() as i16)),
                        false => all.extend(self.float(number as f32)),
                    }
                }
                match self.is_whole {
                    true => all.extend(self.whole(residual as i16)),
                    false => all.extend(self.float(residual)),
                }
            }
        }
        all
    }
}

const CELL: &str = r#"
    name = "replayed"
    abstract_test = [{ name = "go", actions = [{ receive_signal = "anna.arrived" }] }]
    [simulation]
    duration_secs = 3.0
    record_hz = 100
    people_hz = 100
    time_step_secs = 0.002
    [[person]]
    name = "anna"
    body = "BODY"
    x_m = 4.0
    y_m = 1.0
    heading_rad = 1.5707963267948966
    MORE
    [person.capture]
    file = "FILE"
"#;

fn cell(file: &str, capture: &str) -> String {
    let text = CELL
        .replace("FILE", file)
        .replace("BODY", "articulated")
        .replace("MORE", "");
    format!("{text}{capture}")
}

fn bench(text: &str, file: &str, bytes: &[u8]) -> Result<SceneBench, String> {
    let files: BTreeMap<&str, &[u8]> = BTreeMap::from([(file, bytes)]);
    let read = |name: &str| {
        files
            .get(name)
            .map(|it| it.to_vec())
            .ok_or(format!("no {name}"))
    };
    let none = Arc::new(crate::truths::no_controller);
    let made = SceneBench::new(text, &read, rapier(), none).map_err(|error| error.to_string())?;
    let hand = "/truth/anna/left_forearm.z".to_owned();
    let declared = made
        .0
        .record_truth([hand])
        .map_err(|error| error.to_string())?;
    declared.map_err(|unknown| unknown.to_string())
}

fn run(text: &str, file: &str, bytes: &[u8]) -> Trace {
    let bench = bench(text, file, bytes).unwrap_or_else(|error| panic!("{error}"));
    let first = Stimulus::of(bench.tests()[0].clone());
    let run = bench.run(&first, 3, &mut Unwatched, &Cancel::default());
    run.unwrap_or_else(|error| panic!("{error}")).trace
}

/// From (4, 1) along y at 1 m/s for 2 s, the left hand stretched forwards at the shoulder's height.
fn assert_walks(trace: &Trace, of: &str, within: f64) {
    let near = |name: &str, secs: f64, wanted: f64| {
        let found = at(trace, &format!("/truth/anna{name}"), secs);
        assert!(
            (found - wanted).abs() < within,
            "{of}: {name} is {found} at {secs} s, not {wanted}"
        );
    };
    for secs in [0.0_f64, 0.5, 1.234, 1.99, 2.5] {
        // People are led to where they are at the end of each update of 10 ms.
        let walked = (secs * 100.0 + 1e-6).floor() / 100.0;
        near(".x", secs, 4.0);
        near(".y", secs, 1.0 + walked.min(2.0));
        near(".heading", secs, std::f64::consts::FRAC_PI_2);
        // The forearm leads from the elbow to the hand; its end is 0.254 of the height from the elbow.
        near(
            ".left_hand.y",
            secs,
            1.0 + walked.min(2.0) + 0.3 + 0.254 * 1.75,
        );
        near(".left_hand.x", secs, 4.0 - 0.2);
        near(".left_hand.z", secs, 1.4);
        near(".right_hand.z", secs, 1.4 - 0.3 - 0.254 * 1.75);
        near(".right_hand.x", secs, 4.0 + 0.2);
        near("/left_forearm.z", secs, 1.4);
    }
    near(".speed", 1.0, 1.0);
    near(".speed", 2.5, 0.0);
    assert_eq!(at(trace, "/truth/anna.arrived", 1.9), 0.0, "{of}");
    assert_eq!(at(trace, "/truth/anna.arrived", 2.1), 1.0, "{of}");
    assert_eq!(at(trace, "/test.done", 2.5), 1.0, "{of}");
}

#[test]
fn one_motion_is_the_same_from_every_format() {
    let table = csv(21);
    let trace = run(
        &cell("walk.csv", &own_names("unit = \"m\"")),
        "walk.csv",
        table.as_bytes(),
    );
    assert_walks(&trace, "CSV", 1e-9);
    let text = bvh(21);
    let trace = run(&cell("walk.bvh", OF_BVH), "walk.bvh", text.as_bytes());
    assert_walks(&trace, "BVH", 1e-9);
    for (is_big_endian, is_whole) in [(false, false), (false, true), (true, false), (true, true)] {
        // One frame in which a marker is hidden is bridged.
        let bytes = C3d {
            is_big_endian,
            is_whole,
        }
        .of(21, &|frame, name| frame == 7 && name == "left_hip");
        let capture = own_names("longest_gap_secs = 0.25");
        let trace = run(&cell("walk.c3d", &capture), "walk.c3d", &bytes);
        let of = format!("C3D (big endian {is_big_endian}, whole numbers {is_whole})");
        assert_walks(&trace, &of, 1e-4);
    }
}

#[test]
fn a_replay_is_cut_begins_later_runs_faster_rests_and_starts_again() {
    let text = csv(21);
    let y = |more: &str, capture: &str, secs: &[f64]| -> Vec<f64> {
        let cell = cell(
            "walk.csv",
            &format!("{capture}\n{}", own_names("unit = \"m\"")),
        );
        let cell = cell.replace(
            "heading_rad = 1.5707963267948966",
            &format!("heading_rad = 1.5707963267948966\n{more}"),
        );
        let trace = run(&cell, "walk.csv", text.as_bytes());
        secs.iter()
            .map(|secs| at(&trace, "/truth/anna.y", *secs))
            .collect()
    };
    let assert_near = |found: Vec<f64>, wanted: &[f64]| {
        let same = found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-6);
        assert!(
            same && found.len() == wanted.len(),
            "{found:?} is not {wanted:?}"
        );
    };
    // From 0.5 to 1.5 s of the recording, from 1 s on, twice as fast.
    let cut = "from_secs = 0.5\nuntil_secs = 1.5\nbegins_secs = 1.0\nrate = 2.0";
    assert_near(
        y("", cut, &[0.5, 1.0, 1.25, 1.5, 2.0]),
        &[1.5, 1.5, 2.0, 2.5, 2.5],
    );
    assert_near(y("again = true", "", &[1.5, 2.5]), &[2.5, 1.5]);
    assert_near(y("activity = \"stand\"", "", &[0.5, 2.0]), &[1.0, 1.0]);
}

#[test]
fn who_is_replayed_and_gives_way_is_held_where_the_recording_is() {
    let text = csv(21);
    let cell = cell("walk.csv", &own_names("unit = \"m\""));
    let cell = cell
        .replace("\"articulated\"", "\"compliant\"")
        .replace("0.002", "0.0005");
    let trace = run(&cell, "walk.csv", text.as_bytes());
    // At rest at the end of the recording: parts hang on springs and bear their weight.
    for (name, wanted) in [
        (".left_hand.y", 3.0 + 0.3 + 0.254 * 1.75),
        (".left_hand.z", 1.4),
    ] {
        let found = at(&trace, &format!("/truth/anna{name}"), 2.9);
        assert!(
            (found - wanted).abs() < 2e-3,
            "{name}: {found}, not {wanted}"
        );
    }
}

fn refused(text: &str, file: &str, bytes: &[u8], words: &[&str]) {
    let Err(error) = bench(text, file, bytes) else {
        panic!("{words:?} is not told");
    };
    for word in words {
        assert!(error.contains(word), "{word}: {error}");
    }
}

#[test]
fn bad_files_are_told_with_their_places() {
    let named = own_names("unit = \"m\"");
    let of_csv = |text: &str, words: &[&str]| {
        refused(
            &cell("walk.csv", &named),
            "walk.csv",
            text.as_bytes(),
            words,
        )
    };
    let lines: Vec<String> = csv(4).lines().map(str::to_owned).collect();
    let with = |line: usize, text: &str| {
        let mut lines = lines.clone();
        lines[line] = text.to_owned();
        lines.join("\n")
    };
    of_csv("", &["walk.csv: 1:1", "the file is empty"]);
    of_csv(
        &lines.join("\n").replace("time_secs", "clock"),
        &["1:1", "no column `time_secs`", "clock"],
    );
    of_csv(
        &with(2, "0.1,1"),
        &["3:1", "2 cells where the first line has 34"],
    );
    let broken = lines[2].replacen("1.64", "1.6.4", 1);
    of_csv(
        &with(2, &broken),
        &["3:11", "`1.6.4` in the column `head.z` is not a number"],
    );
    let late = lines[1].replacen('0', "0.5", 1);
    of_csv(
        &with(1, &late),
        &["3:1", "the time 0.1 is not after the one before"],
    );
    of_csv(&lines[..2].join("\n"), &["has 1 frames"]);
    let of_bvh = |text: &str, words: &[&str]| {
        refused(
            &cell("walk.bvh", OF_BVH),
            "walk.bvh",
            text.as_bytes(),
            words,
        )
    };
    let good = bvh(3);
    of_bvh(
        "HIERARCHY\nJOINT Hips",
        &["walk.bvh: 2:1", "`JOINT` where `ROOT` is expected"],
    );
    of_bvh(
        &good.replacen("Xrotation", "Wrotation", 1),
        &["`Wrotation` where a channel"],
    );
    of_bvh(
        &good.replace("Frames: 3", "Frames: 4"),
        &["the file ends where a number of frame 4 of 4"],
    );
    of_bvh(
        &good.replace("Frames: 3", "Frames: 2"),
        &["after the 2 frames that the file announces"],
    );
    of_bvh(&good.replace("0.1\n", "0\n"), &["a frame takes 0 s"]);
    let bytes = C3d {
        is_big_endian: false,
        is_whole: false,
    }
    .of(4, &|_, _| false);
    let of_c3d = |bytes: &[u8], words: &[&str]| {
        refused(&cell("walk.c3d", &own_names("")), "walk.c3d", bytes, words)
    };
    of_c3d(
        &bytes[..bytes.len() - 3],
        &["walk.c3d: byte", "the file ends in the middle"],
    );
    of_c3d(b"RIFF", &["byte 1", "not a C3D file"]);
    let mut dec = bytes.clone();
    dec[515] = 85;
    of_c3d(&dec, &["byte 515", "DEC"]);
}

#[test]
fn what_does_not_fit_the_file_is_told_with_its_key() {
    let text = csv(21);
    let of = |capture: &str, words: &[&str]| {
        refused(
            &cell("walk.csv", capture),
            "walk.csv",
            text.as_bytes(),
            words,
        )
    };
    let named = own_names("unit = \"m\"");
    of(
        &own_names("unit = \"cm\""),
        &["person.anna.capture.unit", "at most 0.016 m above the feet"],
    );
    of(&own_names(""), &["person.anna.capture.unit", "is missing"]);
    of(
        &named.replace("\"left_elbow\"", "\"LELB\""),
        &[
            "capture.points.left_elbow",
            "names `LELB`",
            "left_shoulder, left_elbow",
        ],
    );
    of(
        &named.replace("left_elbow = \"left_elbow\"\n", ""),
        &["capture.points.left_elbow", "is missing"],
    );
    of(
        &named.replace("left_elbow =", "left_knee ="),
        &["capture.points.left_knee", "is not a point of the body"],
    );
    of(
        &named.replace("forward = \"x\"", "forward = \"-z\""),
        &["capture.forward", "same axis as `up`"],
    );
    of(
        &named.replace("unit = \"m\"", "unit = \"m\"\nfrom_secs = 9.0"),
        &["capture.from_secs", "leaves 0 frames"],
    );
    let bytes = C3d {
        is_big_endian: false,
        is_whole: false,
    }
    .of(21, &|frame, name| {
        (5..9).contains(&frame) && name == "left_hip"
    });
    let of_c3d = |capture: &str, words: &[&str]| {
        refused(&cell("walk.c3d", capture), "walk.c3d", &bytes, words)
    };
    of_c3d(
        &own_names(""),
        &[
            "capture.points.left_hip",
            "not seen from 0.400 s to 0.900 s",
        ],
    );
    of_c3d(
        &own_names("unit = \"m\"\nlongest_gap_secs = 1.0"),
        &["capture.unit", "is not what the file says: `mm`"],
    );
    let beside = cell("walk.csv", &named).replace(
        "body = \"articulated\"",
        "waypoint = [{ x_m = 1.0, y_m = 0.0 }]\nactivity = \"follow\"",
    );
    refused(
        &beside,
        "walk.csv",
        text.as_bytes(),
        &[
            "person.anna.waypoint",
            "person.anna.body",
            "person.anna.activity",
        ],
    );
    let other = cell("walk.txt2", &named);
    refused(
        &other,
        "walk.txt2",
        text.as_bytes(),
        &["walk.txt2", "read by its ending"],
    );
    let acts = cell("walk.csv", &named).replace(
        r#"{ receive_signal = "anna.arrived" }"#,
        r#"{ set_param = { "anna.arms" = "reach" } }"#,
    );
    refused(
        &acts,
        "walk.csv",
        text.as_bytes(),
        &["replayed from a recording"],
    );
}

#[test]
fn a_test_lets_the_replay_rest_and_go_on() {
    let text = csv(21);
    let actions = r#"{ set_param = { "anna.activity" = "stand" }, after_secs = 0.5 }, { set_param = { "anna.activity" = "walk" }, after_secs = 1.0 }"#;
    let cell = cell("walk.csv", &own_names("unit = \"m\""))
        .replace(r#"{ receive_signal = "anna.arrived" }"#, actions);
    let files = [("walk.csv", text.as_str())];
    Scene::new(&cell, &files).in_each(&[], |engine, trace| {
        let y = |secs: f64| at(trace, "/truth/anna.y", secs);
        assert!((y(1.4) - y(0.6)).abs() < 1e-9, "{engine}");
        assert_eq!(
            name_at(trace, "/truth/anna.activity", 1.0),
            "stand",
            "{engine}"
        );
        assert!(
            (y(2.5) - y(1.5) - 1.0).abs() < 0.011,
            "{engine}: {}",
            y(2.5)
        );
    });
}
