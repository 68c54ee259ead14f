//! The replay's data as JSON for the page's script.
//!
//! Poses are 16-bit whole numbers in base64: for each body that moves, for each
//! frame, x, y, z in steps of that body's range and w, x, y, z in 1/32767. So a
//! body that stays within 2 m is shown to 0.03 mm. Frames are thinned evenly
//! until the poses fit into [`MOST_BYTES`].

use serde_json::{Value, json};

use super::strip::thinned;
use super::{Form, Pose, Replay, Role, Scene, Shape, SignalKind, Tone};

/// Largest size of all poses, before base64 makes it a third larger.
const MOST_BYTES: usize = 900_000;
/// Bytes of one pose.
const POSE_BYTES: usize = 14;

/// The frames that are shown, and what is written of them.
pub(super) struct Packed {
    /// How many recorded frames become one.
    pub(super) stride: usize,
    /// For the script.
    pub(super) json: String,
}

/// Everything that the script needs.
pub(super) fn packed(replay: &Replay) -> Packed {
    let scene = &replay.scene;
    let moving: Vec<usize> = (0..scene.bodies.len())
        .filter(|body| moves(scene, *body))
        .collect();
    let wanted = scene.poses.len() * moving.len() * POSE_BYTES;
    let stride = wanted.div_ceil(MOST_BYTES).max(1);
    let frames = frames(scene.poses.len(), stride);
    let mut bytes = Vec::with_capacity(frames.len() * moving.len() * POSE_BYTES);
    let mut place = 0;
    let bodies: Vec<Value> = (0..scene.bodies.len())
        .map(|body| {
            if !moving.contains(&body) {
                return json!({"fixed": scene.poses.first().map_or_else(Vec::new, |p| flat(&p[body]))});
            }
            let (low, step) = range(scene, body);
            for frame in &frames {
                pack(&scene.poses[*frame][body], low, step, &mut bytes);
            }
            place += 1;
            json!({"place": place - 1, "low": low.map(rounded), "step": step})
        })
        .collect();
    let times: Vec<f64> = frames
        .iter()
        .map(|f| rounded(scene.times_secs[*f]))
        .collect();
    let data = json!({
        "times": times, "bodies": bodies, "poses": base64(&bytes),
        "shapes": scene.shapes.iter().map(shape).collect::<Vec<_>>(),
        "marks": replay.marks.iter().map(|mark| {
            json!({"time": rounded(mark.time_secs), "text": mark.text, "tone": tone(mark.tone)})
        }).collect::<Vec<_>>(),
        "signals": replay.signals.iter().map(signal).collect::<Vec<_>>(),
    });
    Packed {
        stride,
        // Within a script element `</` would end it, and `<!--` begin a comment.
        json: data.to_string().replace('<', "\\u003c"),
    }
}

/// Every `stride`-th frame, and the last.
fn frames(count: usize, stride: usize) -> Vec<usize> {
    let mut frames: Vec<usize> = (0..count).step_by(stride).collect();
    if frames.last().is_some_and(|last| last + 1 < count) {
        frames.push(count - 1);
    }
    frames
}

fn moves(scene: &Scene, body: usize) -> bool {
    scene
        .poses
        .iter()
        .any(|poses| poses[body] != scene.poses[0][body])
}

/// The least coordinates of a body, and the step in which they are counted.
fn range(scene: &Scene, body: usize) -> ([f64; 3], f64) {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for poses in &scene.poses {
        for axis in 0..3 {
            low[axis] = low[axis].min(poses[body].0[axis]);
            high[axis] = high[axis].max(poses[body].0[axis]);
        }
    }
    let widest_m = (0..3)
        .map(|axis| high[axis] - low[axis])
        .fold(0.0, f64::max);
    // As the page has it, or the error of rounding would grow with the count.
    (low.map(rounded), (widest_m / 65_000.0).max(1e-7))
}

fn pack((position_m, orientation): &Pose, low: [f64; 3], step: f64, bytes: &mut Vec<u8>) {
    for axis in 0..3 {
        let steps = ((position_m[axis] - low[axis]) / step).round() - 32_768.0;
        bytes.extend((steps as i16).to_le_bytes());
    }
    for part in orientation {
        bytes.extend(((part * 32_767.0).round() as i16).to_le_bytes());
    }
}

/// To six places: less than is seen.
fn rounded(value: f64) -> f64 {
    (value * 1e6).round() / 1e6
}

fn flat((position_m, orientation): &Pose) -> Vec<f64> {
    position_m
        .iter()
        .chain(orientation)
        .copied()
        .map(rounded)
        .collect()
}

fn shape(shape: &Shape) -> Value {
    let role = match shape.role {
        Role::Robot => "robot",
        Role::Object => "object",
        Role::Person => "person",
        Role::Surroundings => "surroundings",
    };
    let form = match &shape.form {
        Form::Ground => json!({"kind": "ground"}),
        Form::Box { edges_m } => json!({"kind": "box", "edges": edges_m}),
        Form::Ellipsoid { radii_m } => json!({"kind": "ellipsoid", "radii": radii_m}),
        Form::Cylinder { radius_m, length_m } => {
            json!({"kind": "cylinder", "radius": radius_m, "length": length_m})
        }
        Form::Capsule { radius_m, length_m } => {
            json!({"kind": "capsule", "radius": radius_m, "length": length_m})
        }
        Form::Triangles { points_m, corners } => json!({
            "kind": "triangles", "corners": corners,
            "points": points_m.iter().map(|point| point.map(rounded)).collect::<Vec<_>>(),
        }),
    };
    json!({"body": shape.body, "role": role, "pose": flat(&shape.pose), "form": form})
}

fn signal(signal: &super::Signal) -> Value {
    let (times, values): (Vec<f64>, Vec<Option<f64>>) = thinned(signal)
        .into_iter()
        .map(|(time_secs, value)| (rounded(time_secs), Some(value).filter(|v| v.is_finite())))
        .unzip();
    let (unit, names) = match &signal.kind {
        SignalKind::Number(unit) => (unit.clone(), None),
        SignalKind::Flag => (String::new(), Some(vec!["no".to_owned(), "yes".to_owned()])),
        SignalKind::Names(names) => (String::new(), Some(names.clone())),
    };
    json!({"t": times, "v": values, "unit": unit, "names": names})
}

/// The class by which the style knows a tone.
pub(super) fn tone(tone: Tone) -> &'static str {
    match tone {
        Tone::Good => "good",
        Tone::Bad => "bad",
        Tone::Open => "open",
        Tone::Plain => "plain",
    }
}

/// Base64 with padding (RFC 4648, section 4).
fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for group in bytes.chunks(3) {
        let all = group
            .iter()
            .fold(0_u32, |all, byte| all << 8 | u32::from(*byte));
        let all = all << (8 * (3 - group.len()));
        for place in 0..4 {
            if place <= group.len() {
                text.push(char::from(LETTERS[(all >> (18 - 6 * place) & 63) as usize]));
            } else {
                text.push('=');
            }
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_is_as_the_standard_s_examples() {
        let examples = [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foob", "Zm9vYg=="),
            ("fooba", "Zm9vYmE="),
            ("foobar", "Zm9vYmFy"),
        ];
        for (text, expected) in examples {
            assert_eq!(base64(text.as_bytes()), expected);
        }
    }

    #[test]
    fn poses_are_packed_to_a_fraction_of_a_millimetre() {
        let poses: Vec<Vec<Pose>> = (0..200)
            .map(|i| {
                let t = f64::from(i) / 199.0;
                let half: f64 = t;
                vec![(
                    [2.0 * t - 0.7, 0.1 * t, 1.0],
                    [half.cos(), 0.0, half.sin(), 0.0],
                )]
            })
            .collect();
        let scene = Scene {
            bodies: vec!["a".into()],
            times_secs: (0..200).map(f64::from).collect(),
            poses,
            ..Scene::default()
        };
        let (low, step) = range(&scene, 0);
        for poses in &scene.poses {
            let mut bytes = Vec::new();
            pack(&poses[0], low, step, &mut bytes);
            let read = |i: usize| f64::from(i16::from_le_bytes([bytes[2 * i], bytes[2 * i + 1]]));
            for (axis, low) in low.iter().enumerate() {
                let back_m = low + (read(axis) + 32_768.0) * step;
                assert!((back_m - poses[0].0[axis]).abs() < 3e-5, "{back_m}");
            }
            for part in 0..4 {
                assert!((read(3 + part) / 32_767.0 - poses[0].1[part]).abs() < 2e-5);
            }
        }
    }

    #[test]
    fn a_long_episode_is_thinned_until_it_fits_and_keeps_its_end() {
        assert_eq!(frames(5, 2), [0, 2, 4]);
        assert_eq!(frames(6, 2), [0, 2, 4, 5]);
        assert!(frames(0, 1).is_empty());
        let pose = |t: usize| ([t as f64, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]);
        let replay = Replay {
            scene: Scene {
                bodies: vec!["a".into(); 30],
                times_secs: (0..12_000).map(|t| t as f64 * 0.02).collect(),
                poses: (0..12_000).map(|t| vec![pose(t); 30]).collect(),
                ..Scene::default()
            },
            ..Replay::default()
        };
        let packed = packed(&replay);
        assert_eq!(packed.stride, 6);
        assert!(packed.json.len() < 1_400_000, "{}", packed.json.len());
    }
}
