//! People from motion capture: where the joints of a body were, from BVH, C3D or tables, replayed in an episode.
//!
//! # Definition
//! A file gives the places of named points at times. The scene says which of them are which points of the body ([`POINTS`]; the
//! mean of several, as of markers around a joint), in which unit they are, and which of the file's axes point up and forwards: a place
//! `p` of the file is at `R (unit F p) + t` in the world, where `F` takes the axes forwards, left and up to x, y and z, and `R`, `t` are
//! the person's heading and place in the scene. Between frames, places are on a straight line: that is how the recording is resampled to the
//! scene's rate. A point that was not seen for no longer than the longest gap is on the line between its places before and after.
//!
//! Of the points follow the poses of the body's parts: a limb begins at its upper joint and points to its lower one, with the
//! length that the person's height gives it.
//!
//! # Deviation
//! Knees do not bend: a leg points from hip to foot. Limbs have the lengths of the person's height, not those of the recorded person. How a
//! limb is turned about itself is not recorded.

mod bvh;
mod c3d;
mod csv;

use std::collections::BTreeMap;
use std::sync::Arc;

use super::data::{Capture, CaptureAxis, SceneData, key_of};
use super::load::ReadFile;
use crate::bench::ScenarioError;
use crate::geometry::{Vector, add, cross, dot, scale, subtract};

/// The points of a body, as a scene names them.
pub(super) const POINTS: [&str; 11] = [
    "head",
    "left_shoulder",
    "right_shoulder",
    "left_elbow",
    "right_elbow",
    "left_hand",
    "right_hand",
    "left_hip",
    "right_hip",
    "left_foot",
    "right_foot",
];

/// How far from the recording's origin a point may be.
const FARTHEST_M: f64 = 1e4;

/// Where the points of a body are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Figure {
    /// In the order of [`POINTS`].
    pub(super) points_m: [Vector; 11],
}

/// What a file holds.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Raw {
    pub(super) times_secs: Vec<f64>,
    pub(super) names: Vec<String>,
    /// For each name its places, in the file's unit and axes; none of a frame in which it was not seen.
    pub(super) places: Vec<Vec<Option<Vector>>>,
    /// The unit, if the file says it.
    pub(super) unit: Option<String>,
}

/// Why a file cannot be read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct BadFile {
    /// Line and column, or byte.
    pub(super) place: String,
    pub(super) what: String,
}

/// The files of a scene's people, by their paths.
pub(super) type Files = BTreeMap<String, Raw>;

/// A recording in the frame of its person.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Recording {
    times_secs: Vec<f64>,
    figures: Vec<Figure>,
}

/// Reads the files of all people, each once.
///
/// # Errors
/// [`ScenarioError::Description`] with the place in the file.
pub(super) fn read_all(data: &SceneData, file: &ReadFile<'_>) -> Result<Files, ScenarioError> {
    let mut files = Files::new();
    let mut wrong = Vec::new();
    for capture in data.people.iter().filter_map(|it| it.capture.as_ref()) {
        if files.contains_key(&capture.file) {
            continue;
        }
        match read(capture, file) {
            Ok(raw) => {
                files.insert(capture.file.clone(), raw);
            }
            Err(reason) => wrong.push(ScenarioError::Description {
                file: capture.file.clone(),
                reason,
            }),
        }
    }
    ScenarioError::all(wrong).map(|()| files)
}

fn read(capture: &Capture, file: &ReadFile<'_>) -> Result<Raw, String> {
    let bytes = file(&capture.file)?;
    let ending = capture
        .file
        .rsplit_once('.')
        .map(|(_, ending)| ending.to_ascii_lowercase());
    let text = || {
        std::str::from_utf8(&bytes)
            .map_err(|error| format!("byte {}: not UTF-8 text", error.valid_up_to()))
    };
    let read = match ending.as_deref() {
        Some("bvh") => bvh::read(text()?),
        Some("c3d") => c3d::read(&bytes),
        Some("csv" | "tsv" | "txt") => csv::read(text()?, &capture.time_column),
        _ => {
            return Err(
                "is read by its ending, which is .bvh, .c3d or .csv of what is read".to_owned(),
            );
        }
    };
    let raw = read.map_err(|bad| format!("{}: {}", bad.place, bad.what))?;
    match raw.times_secs.len() {
        0 | 1 => Err(format!(
            "has {} frames; two are needed to move",
            raw.times_secs.len()
        )),
        _ => Ok(raw),
    }
}

/// Fills in the recordings of a scene's people.
///
/// # Errors
/// Names that a file does not have, gaps that are too long, and what cannot be a person that stands upright.
pub(super) fn complete(data: &mut SceneData, files: &Files) -> Vec<ScenarioError> {
    let mut wrong = Vec::new();
    for person in &mut data.people {
        let Some(capture) = &person.capture else {
            continue;
        };
        let Some(raw) = files.get(&capture.file) else {
            continue;
        };
        let tall_m = person.height_m.quantile(0.5);
        match Recording::new(&person.name, capture, raw, tall_m) {
            Ok(recording) => person.recording = Some(Arc::new(recording)),
            Err(found) => wrong.extend(found),
        }
    }
    wrong
}

impl Recording {
    fn new(
        person: &str,
        capture: &Capture,
        raw: &Raw,
        tall_m: f64,
    ) -> Result<Self, Vec<ScenarioError>> {
        let key = |field: &str| key_of("person", person, &format!("capture.{field}"));
        let wrong =
            |field: &str, problem: String| vec![ScenarioError::value(&key(field), &problem)];
        let unit_m = unit_of(capture, raw).map_err(|problem| wrong("unit", problem))?;
        let (from, to) = cut(capture, raw).map_err(|(field, problem)| wrong(field, problem))?;
        let mut found = Vec::new();
        let mut tracks: Vec<Vec<Vector>> = Vec::new();
        for point in POINTS {
            let field = format!("points.{point}");
            let track = match capture.points.get(point) {
                None => Err(format!(
                    "is missing; the file {} has {}",
                    capture.file,
                    raw.names.join(", ")
                )),
                Some(names) => track(names.all(), raw, from..to, capture.longest_gap_secs),
            };
            match track {
                Ok(track) => tracks.push(track),
                Err(problem) => found.push(ScenarioError::value(&key(&field), &problem)),
            }
        }
        if !found.is_empty() {
            return Err(found);
        }
        let axes = axes(capture);
        let figures = (0..to - from).map(|frame| Figure {
            points_m: std::array::from_fn(|point| {
                let place = scale(unit_m, tracks[point][frame]);
                axes.map(|axis| dot(axis, place))
            }),
        });
        let begins_secs = raw.times_secs[from];
        let recording = Self {
            times_secs: raw.times_secs[from..to]
                .iter()
                .map(|it| it - begins_secs)
                .collect(),
            figures: figures.collect(),
        };
        recording
            .check(tall_m)
            .map_err(|problem| wrong("unit", problem))?;
        Ok(recording)
    }

    /// A person who stands at some time is as tall as the scene says, by half.
    fn check(&self, tall_m: f64) -> Result<(), String> {
        let points = self
            .figures
            .iter()
            .flat_map(|it| it.points_m.as_flattened());
        if !points.into_iter().all(|it| it.abs() <= FARTHEST_M) {
            return Err(format!(
                "puts a point farther than {FARTHEST_M} m from the origin"
            ));
        }
        let tallest = self.figures.iter().map(Figure::upright_m);
        let stands_m = tallest.fold(f64::NEG_INFINITY, f64::max);
        if (0.5 * tall_m..1.5 * tall_m).contains(&stands_m) {
            return Ok(());
        }
        Err(format!(
            "lets the head be at most {stands_m:.3} m above the feet, where the person is {tall_m} m tall; check `unit`, `up` and the names of the points"
        ))
    }

    pub(super) fn duration_secs(&self) -> f64 {
        self.times_secs.last().copied().unwrap_or(0.0)
    }

    /// The points at a time, between frames on a straight line.
    pub(super) fn at(&self, secs: f64) -> Figure {
        let after = self.times_secs.partition_point(|it| *it <= secs);
        if after == 0 {
            return self.figures[0];
        }
        let Some(next_secs) = self.times_secs.get(after) else {
            return self.figures[self.figures.len() - 1];
        };
        let before_secs = self.times_secs[after - 1];
        let share = (secs - before_secs) / (next_secs - before_secs);
        let [before, next] = [after - 1, after].map(|it| self.figures[it].points_m);
        Figure {
            points_m: std::array::from_fn(|point| between(before[point], next[point], share)),
        }
    }
}

impl Figure {
    /// How far the head is above the lower foot.
    fn upright_m(&self) -> f64 {
        let feet = self.points_m[9][2].min(self.points_m[10][2]);
        self.points_m[0][2] - feet
    }

    /// The same turned about z and moved.
    pub(super) fn placed(&self, heading_rad: f64, [x_m, y_m]: [f64; 2]) -> Self {
        let (sine, cosine) = heading_rad.sin_cos();
        Self {
            points_m: self
                .points_m
                .map(|[x, y, z]| [x_m + cosine * x - sine * y, y_m + sine * x + cosine * y, z]),
        }
    }

    /// The middle of the hips.
    pub(super) fn hips_m(&self) -> Vector {
        between(self.points_m[7], self.points_m[8], 0.5)
    }

    /// The middle of the shoulders.
    pub(super) fn shoulders_m(&self) -> Vector {
        between(self.points_m[1], self.points_m[2], 0.5)
    }

    /// Where the person faces: to the right of the way from the right hip to the left one.
    pub(super) fn heading_rad(&self) -> f64 {
        let left = subtract(self.points_m[7], self.points_m[8]);
        (-left[0]).atan2(left[1])
    }
}

fn between(a: Vector, b: Vector, share: f64) -> Vector {
    add(scale(1.0 - share, a), scale(share, b))
}

/// The file's unit in metres: what the file says, or else what the scene says; they must not say different things.
fn unit_of(capture: &Capture, raw: &Raw) -> Result<f64, String> {
    let of_file = raw.unit.as_deref().filter(|it| !it.is_empty());
    let known = match of_file.map(str::to_ascii_lowercase).as_deref() {
        None => None,
        Some("m" | "meter" | "meters" | "metre" | "metres") => Some(1.0),
        Some("cm") => Some(1e-2),
        Some("mm" | "millimeter" | "millimeters") => Some(1e-3),
        Some("in" | "inch" | "inches") => Some(0.0254),
        Some(other) => {
            let stated = capture.unit.map(super::data::CaptureUnit::metres);
            return stated.ok_or_else(|| {
                format!("is missing, and `{other}` of the file is not a known unit of length")
            });
        }
    };
    match (known, capture.unit.map(super::data::CaptureUnit::metres)) {
        (Some(known), Some(stated)) if known != stated => Err(format!(
            "is not what the file says: `{}`; leave it out",
            of_file.unwrap_or_default()
        )),
        (Some(known), _) => Ok(known),
        (None, Some(stated)) => Ok(stated),
        (None, None) => Err("is missing, and the file does not say it".to_owned()),
    }
}

/// The frames that are replayed.
fn cut(capture: &Capture, raw: &Raw) -> Result<(usize, usize), (&'static str, String)> {
    let first_secs = raw.times_secs[0];
    let last_secs = raw.times_secs[raw.times_secs.len() - 1];
    let from = raw
        .times_secs
        .partition_point(|it| *it < first_secs + capture.from_secs);
    let until_secs = capture.until_secs.map_or(last_secs, |it| first_secs + it);
    let to = raw
        .times_secs
        .partition_point(|it| *it <= until_secs + 1e-9);
    if to < from + 2 {
        let field = if capture.until_secs.is_some() {
            "until_secs"
        } else {
            "from_secs"
        };
        return Err((
            field,
            format!(
                "leaves {} frames of {:.3} s; two are needed",
                to.saturating_sub(from),
                last_secs - first_secs
            ),
        ));
    }
    Ok((from, to))
}

/// The places of a point: the mean of its names' where all are seen, and on a line over gaps.
fn track(
    names: &[String],
    raw: &Raw,
    frames: std::ops::Range<usize>,
    longest_gap_secs: f64,
) -> Result<Vec<Vector>, String> {
    let mut of_names = Vec::new();
    for name in names {
        let place = raw.names.iter().position(|it| it == name);
        let place = place.ok_or_else(|| {
            format!(
                "names `{name}`, which the file does not have; it has {}",
                raw.names.join(", ")
            )
        })?;
        of_names.push(&raw.places[place]);
    }
    let mean = |frame: usize| -> Option<Vector> {
        let mut sum = [0.0; 3];
        for places in &of_names {
            sum = add(sum, places[frame]?);
        }
        Some(scale(1.0 / of_names.len() as f64, sum))
    };
    let seen: Vec<(usize, Vector)> = frames
        .clone()
        .filter_map(|frame| Some((frame, mean(frame)?)))
        .collect();
    let gap = |from: usize, to: usize| {
        let [from_secs, to_secs] = [from, to].map(|it| raw.times_secs[it]);
        format!(
            "is not seen from {from_secs:.3} s to {to_secs:.3} s of the file, longer than `longest_gap_secs` = {longest_gap_secs} lets pass; cut the recording with `from_secs` and `until_secs`, or fill the gap"
        )
    };
    let (Some(first), Some(last)) = (seen.first(), seen.last()) else {
        return Err(gap(frames.start, frames.end - 1));
    };
    if first.0 != frames.start {
        return Err(gap(frames.start, first.0));
    }
    if last.0 + 1 != frames.end {
        return Err(gap(last.0, frames.end - 1));
    }
    let mut track = vec![first.1];
    for pair in seen.windows(2) {
        let [(from, before), (to, then)] = [pair[0], pair[1]];
        let [from_secs, to_secs] = [from, to].map(|it| raw.times_secs[it]);
        if to > from + 1 && to_secs - from_secs > longest_gap_secs {
            return Err(gap(from, to));
        }
        for frame in from + 1..=to {
            let share = (raw.times_secs[frame] - from_secs) / (to_secs - from_secs);
            track.push(between(before, then, share));
        }
    }
    Ok(track)
}

/// The file's directions forwards, left and up.
fn axes(capture: &Capture) -> [Vector; 3] {
    let [up, forward] = [capture.up, capture.forward].map(CaptureAxis::direction);
    [forward, cross(up, forward), up]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A small hierarchy, and a table of the same length.
    const BVH: &str = "HIERARCHY\nROOT a\n{ OFFSET 0 0 0 CHANNELS 4 Xposition Zrotation Xrotation Yrotation JOINT b { OFFSET 1 2 3 CHANNELS 0 End Site { OFFSET 0 1 0 } } }\nMOTION\nFrames: 2\nFrame Time: 0.1\n1 90 0 0\n2 0 0 0\n";
    const CSV: &str = "time_secs,a.x,a.y,a.z\n0,1,2,3\n0.1,,2,3\n";

    #[test]
    fn turns_of_a_hierarchy_are_taken_one_after_another() {
        let raw = bvh::read(BVH).unwrap();
        assert_eq!(raw.names, ["a", "b", "b.end"]);
        // A quarter turn about z takes (1, 2, 3) to (-2, 1, 3).
        let near = |found: Option<Vector>, wanted: Vector| {
            let off = subtract(found.unwrap(), wanted);
            assert!(dot(off, off) < 1e-18, "{found:?} is not {wanted:?}");
        };
        near(raw.places[1][0], [-1.0, 1.0, 3.0]);
        near(raw.places[2][0], [-2.0, 1.0, 3.0]);
        near(raw.places[1][1], [3.0, 2.0, 3.0]);
    }

    #[test]
    fn a_table_has_points_that_were_not_seen() {
        let raw = csv::read(CSV, "time_secs").unwrap();
        assert_eq!(raw.places, [vec![Some([1.0, 2.0, 3.0]), None]]);
        let tabs = CSV
            .replace(',', "\t")
            .replace("a.x", "A_X")
            .replace("a.y", "A_Y")
            .replace("a.z", "A_Z");
        let raw = csv::read(&tabs, "time_secs").unwrap();
        assert_eq!(
            (raw.names[0].as_str(), raw.places[0][0]),
            ("A", Some([1.0, 2.0, 3.0]))
        );
    }

    /// Whatever the bytes are: a recording, or why not.
    #[test]
    fn no_bytes_make_a_reader_fail_otherwise_than_by_saying_so() {
        let mut c3d = vec![0_u8; 1536];
        c3d[..2].copy_from_slice(&[2, 0x50]);
        c3d[2..12].copy_from_slice(&[1, 0, 0, 0, 1, 0, 2, 0, 0, 0]);
        c3d[12..16].copy_from_slice(&(-1.0_f32).to_le_bytes());
        c3d[16] = 3;
        c3d[20..24].copy_from_slice(&50.0_f32.to_le_bytes());
        c3d[512..516].copy_from_slice(&[1, 0x50, 1, 84]);
        let group = b"\x05\xffPOINT\x03\x00\x00";
        let labels = b"\x06\x01LABELS\x09\x00\xff\x02\x02\x01ab\x00\x00\x00";
        c3d[516..516 + group.len()].copy_from_slice(group);
        let next = 516 + group.len();
        c3d[next..next + labels.len()].copy_from_slice(labels);
        let good = c3d::read(&c3d).unwrap();
        assert_eq!(
            (good.names, good.times_secs),
            (vec!["ab".to_owned()], vec![0.0, 0.02])
        );
        let mut state = 1_u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as usize
        };
        for good in [BVH.as_bytes(), CSV.as_bytes(), &c3d] {
            for _ in 0..3000 {
                let mut bytes = good.to_vec();
                bytes.truncate(1 + random() % good.len());
                let place = random() % bytes.len();
                bytes[place] = random() as u8;
                let text = String::from_utf8_lossy(&bytes);
                let _ = (
                    bvh::read(&text),
                    csv::read(&text, "time_secs"),
                    c3d::read(&bytes),
                );
            }
        }
    }
}
