//! Biovision hierarchies (BVH): a skeleton of joints, and for each frame the numbers of its channels.
//!
//! Definition: a joint's frame is at its offset in its parent's, moved by its position channels and turned by its rotation channels,
//! in degrees, one after another about the axes that the turns before have turned: `p = o + t + R1 R2 R3 q`. Positions are those of
//! the joints' origins; the end of a chain has the name of its joint with `.end`.
//!
//! Source: M. Meredith, S. Maddock, "Motion Capture File Formats Explained" (2001).

use super::{BadFile, Raw};
use crate::geometry::{IDENTITY, Pose, Vector, about, add, compose};

/// The largest number of joints.
const JOINTS: usize = 1000;

#[derive(Clone, Copy)]
enum Channel {
    Position(usize),
    Rotation(usize),
}

struct Joint {
    name: String,
    parent: Option<usize>,
    offset: Vector,
    channels: Vec<Channel>,
}

/// The words of a text, with their lines and columns from 1.
struct Words<'t> {
    all: std::vec::IntoIter<(&'t str, usize, usize)>,
    at: (usize, usize),
}

impl<'t> Words<'t> {
    fn of(text: &'t str) -> Self {
        let lines = text.lines().enumerate();
        let words = lines.flat_map(|(line, text)| {
            text.split_whitespace().map(move |word| {
                let column = word.as_ptr() as usize - text.as_ptr() as usize;
                (word, line + 1, column + 1)
            })
        });
        let all: Vec<_> = words.collect();
        Self {
            all: all.into_iter(),
            at: (1, 1),
        }
    }

    fn bad(&self, what: String) -> BadFile {
        BadFile {
            place: format!("{}:{}", self.at.0, self.at.1),
            what,
        }
    }

    fn next(&mut self, expected: &str) -> Result<&'t str, BadFile> {
        let Some((word, line, column)) = self.all.next() else {
            return Err(self.bad(format!("the file ends where {expected} is expected")));
        };
        self.at = (line, column);
        Ok(word)
    }

    fn expect(&mut self, expected: &str) -> Result<(), BadFile> {
        let word = self.next(&format!("`{expected}`"))?;
        match word.eq_ignore_ascii_case(expected) {
            true => Ok(()),
            false => Err(self.bad(format!("`{word}` where `{expected}` is expected"))),
        }
    }

    fn number(&mut self, expected: &str) -> Result<f64, BadFile> {
        let word = self.next(expected)?;
        let number: Option<f64> = word.parse().ok().filter(|it: &f64| it.is_finite());
        number.ok_or_else(|| self.bad(format!("`{word}` where {expected} is expected")))
    }

    fn count(&mut self, expected: &str) -> Result<usize, BadFile> {
        let word = self.next(expected)?;
        let count = word.parse().ok();
        count.ok_or_else(|| self.bad(format!("`{word}` where {expected} is expected")))
    }
}

/// Reads a file.
pub(super) fn read(text: &str) -> Result<Raw, BadFile> {
    let mut words = Words::of(text);
    words.expect("HIERARCHY")?;
    words.expect("ROOT")?;
    let joints = skeleton(&mut words)?;
    let frames = words.next("`MOTION`")?;
    if frames.eq_ignore_ascii_case("ROOT") {
        return Err(words.bad("a second `ROOT`; one skeleton in a file can be read".to_owned()));
    }
    if !frames.eq_ignore_ascii_case("MOTION") {
        return Err(words.bad(format!("`{frames}` where `MOTION` is expected")));
    }
    words.expect("Frames:")?;
    let count = words.count("the number of frames")?;
    words.expect("Frame")?;
    words.expect("Time:")?;
    let step_secs = words.number("the time of a frame in seconds")?;
    if step_secs <= 0.0 {
        return Err(words.bad(format!("a frame takes {step_secs} s; it must be above 0")));
    }
    let mut raw = Raw {
        names: joints.iter().map(|it| it.name.clone()).collect(),
        places: vec![Vec::new(); joints.len()],
        ..Raw::default()
    };
    for frame in 0..count {
        let places = places(&joints, &mut words, frame, count)?;
        raw.times_secs.push(frame as f64 * step_secs);
        for (kept, place) in raw.places.iter_mut().zip(places) {
            kept.push(Some(place));
        }
    }
    match words.all.next() {
        None => Ok(raw),
        Some((word, line, column)) => Err(BadFile {
            place: format!("{line}:{column}"),
            what: format!("`{word}` after the {count} frames that the file announces"),
        }),
    }
}

/// The joints below `ROOT`, parents first.
fn skeleton(words: &mut Words<'_>) -> Result<Vec<Joint>, BadFile> {
    let mut joints: Vec<Joint> = Vec::new();
    let mut open: Vec<usize> = Vec::new();
    begin(words, &mut joints, &mut open)?;
    while let Some(own) = open.last().copied() {
        let word = words.next("`OFFSET`, `CHANNELS`, `JOINT`, `End Site` or `}`")?;
        match word.to_ascii_uppercase().as_str() {
            "OFFSET" => {
                for axis in 0..3 {
                    joints[own].offset[axis] = words.number("an offset")?;
                }
            }
            "CHANNELS" => {
                let count = words.count("the number of channels")?;
                for _ in 0..count {
                    let channel = channel(words)?;
                    joints[own].channels.push(channel);
                }
            }
            "JOINT" => begin(words, &mut joints, &mut open)?,
            "END" => {
                words.expect("Site")?;
                words.expect("{")?;
                words.expect("OFFSET")?;
                let mut offset = [0.0; 3];
                for part in &mut offset {
                    *part = words.number("an offset")?;
                }
                words.expect("}")?;
                joints.push(Joint {
                    name: format!("{}.end", joints[own].name),
                    parent: Some(own),
                    offset,
                    channels: Vec::new(),
                });
            }
            "}" => {
                open.pop();
            }
            _ => {
                return Err(words.bad(format!(
                    "`{word}` where `OFFSET`, `CHANNELS`, `JOINT`, `End Site` or `}}` is expected"
                )));
            }
        }
        if joints.len() > JOINTS {
            return Err(words.bad(format!("more than {JOINTS} joints")));
        }
    }
    Ok(joints)
}

fn begin(
    words: &mut Words<'_>,
    joints: &mut Vec<Joint>,
    open: &mut Vec<usize>,
) -> Result<(), BadFile> {
    let name = words.next("a joint's name")?;
    joints.push(Joint {
        name: name.to_owned(),
        parent: open.last().copied(),
        offset: [0.0; 3],
        channels: Vec::new(),
    });
    open.push(joints.len() - 1);
    words.expect("{")
}

fn channel(words: &mut Words<'_>) -> Result<Channel, BadFile> {
    let word = words.next("a channel")?;
    let lower = word.to_ascii_lowercase();
    let axis = ["x", "y", "z"].iter().position(|it| lower.starts_with(it));
    match (axis, lower.get(1..)) {
        (Some(axis), Some("position")) => Ok(Channel::Position(axis)),
        (Some(axis), Some("rotation")) => Ok(Channel::Rotation(axis)),
        _ => Err(words.bad(format!(
            "`{word}` where a channel (Xposition, ..., Zrotation) is expected"
        ))),
    }
}

/// The places of all joints in the frame whose numbers come next.
fn places(
    joints: &[Joint],
    words: &mut Words<'_>,
    frame: usize,
    count: usize,
) -> Result<Vec<Vector>, BadFile> {
    let expected = format!("a number of frame {} of {count}", frame + 1);
    let mut poses: Vec<Pose> = Vec::with_capacity(joints.len());
    for joint in joints {
        let mut own = Pose {
            position_m: joint.offset,
            orientation: IDENTITY,
        };
        for channel in &joint.channels {
            let number = words.number(&expected)?;
            match channel {
                Channel::Position(axis) => {
                    let mut moved = [0.0; 3];
                    moved[*axis] = number;
                    own.position_m = add(own.position_m, moved);
                }
                Channel::Rotation(axis) => {
                    let mut about_axis = [0.0; 3];
                    about_axis[*axis] = 1.0;
                    let turn = about(about_axis, number.to_radians());
                    own.orientation = compose(own.orientation, turn);
                }
            }
        }
        poses.push(match joint.parent {
            None => own,
            Some(parent) => poses[parent].then(&own),
        });
    }
    Ok(poses.into_iter().map(|pose| pose.position_m).collect())
}
