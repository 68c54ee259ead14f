//! The messages on `/tf`, `/tf_static` and `/clock`: `tf2_msgs/TFMessage` in CDR, `tf2_msgs/TFMessage` and
//! `tf/tfMessage` as ROS 1 serialises them, and the same as JSON.
//!
//! They hold a list of any length, so they are walked here instead of being decoded by paths. The
//! layout is fixed: for each transform a header (in ROS 1 with a sequence number; stamp; frame),
//! the child's frame, a translation and a quaternion. Everything is checked against the end of the
//! message, so that a wrong length is an error, not a wrong transform.

use crate::reader::Encoding;

/// One transform as it was recorded.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct RecordedTransform {
    pub stamp_nanos: i64,
    pub parent: String,
    pub child: String,
    pub translation_m: [f64; 3],
    pub rotation_xyzw: [f64; 4],
}

/// The transforms of a message, or what is wrong with it.
pub(crate) fn transforms_of(
    encoding: &Encoding,
    data: &[u8],
) -> Result<Vec<RecordedTransform>, String> {
    match encoding {
        Encoding::Cdr => Cursor::cdr(data)?.transforms(false),
        Encoding::Ros1 => Cursor::ros1(data).transforms(true),
        Encoding::Json => json(data),
        other => Err(format!(
            "transforms in {other} are not read; record them as tf2_msgs/TFMessage"
        )),
    }
}

/// The time in nanoseconds that a message of `/clock` (`rosgraph_msgs/Clock`) holds.
pub(super) fn clock_nanos_of(encoding: &Encoding, data: &[u8]) -> Result<i64, String> {
    let mut cursor = match encoding {
        Encoding::Cdr => Cursor::cdr(data)?,
        Encoding::Ros1 => Cursor::ros1(data),
        Encoding::Json => {
            let clock: JsonClock =
                serde_json::from_slice(data).map_err(|error| error.to_string())?;
            return Ok(clock.clock.nanos());
        }
        other => {
            return Err(format!(
                "the clock in {other} is not read; record it as rosgraph_msgs/Clock"
            ));
        }
    };
    let secs = i64::from(cursor.u32()?);
    Ok(secs * 1_000_000_000 + i64::from(cursor.u32()?))
}

struct Cursor<'a> {
    data: &'a [u8],
    at: usize,
    /// Where alignment counts from; `None` if nothing is aligned.
    aligned_from: Option<usize>,
    big_endian: bool,
    /// The widest alignment: 8, in the second version of XCDR 4.
    widest: usize,
}

impl<'a> Cursor<'a> {
    fn cdr(data: &'a [u8]) -> Result<Self, String> {
        let &[0, kind, _, _, ..] = data else {
            return Err("the message is too short for its header".to_owned());
        };
        let widest = match kind {
            0 | 1 => 8,
            6 | 7 => 4,
            _ => return Err(format!("the kind of CDR 0x{kind:02x} is not read")),
        };
        Ok(Cursor {
            data,
            at: 4,
            aligned_from: Some(4),
            big_endian: kind.is_multiple_of(2),
            widest,
        })
    }

    fn ros1(data: &'a [u8]) -> Self {
        Cursor {
            data,
            at: 0,
            aligned_from: None,
            big_endian: false,
            widest: 1,
        }
    }

    fn transforms(mut self, with_sequence: bool) -> Result<Vec<RecordedTransform>, String> {
        let count = self.u32()?;
        let mut found = Vec::new();
        for _ in 0..count {
            found.push(self.transform(with_sequence)?);
        }
        // CDR may be padded to four bytes at the end.
        if self.data.len() - self.at > 3 {
            let rest = self.data.len() - self.at;
            return Err(format!("{rest} bytes are left behind the last transform"));
        }
        Ok(found)
    }

    fn transform(&mut self, with_sequence: bool) -> Result<RecordedTransform, String> {
        if with_sequence {
            self.u32()?;
        }
        let secs = self.u32()?;
        // ROS 2 has signed seconds, ROS 1 unsigned ones.
        let secs = if with_sequence {
            i64::from(secs)
        } else {
            i64::from(secs as i32)
        };
        let stamp_nanos = secs * 1_000_000_000 + i64::from(self.u32()?);
        let (parent, child) = (self.text()?, self.text()?);
        let mut numbers = [0.0; 7];
        for number in &mut numbers {
            *number = self.f64()?;
        }
        let [x, y, z, qx, qy, qz, qw] = numbers;
        Ok(RecordedTransform {
            stamp_nanos,
            parent,
            child,
            translation_m: [x, y, z],
            rotation_xyzw: [qx, qy, qz, qw],
        })
    }

    fn take<const N: usize>(&mut self) -> Result<[u8; N], String> {
        if let Some(from) = self.aligned_from {
            let step = N.min(self.widest);
            self.at += (step - (self.at - from) % step) % step;
        }
        let bytes = self.data.get(self.at..).and_then(|rest| rest.first_chunk());
        let bytes = bytes.ok_or_else(|| format!("the message ends at byte {}", self.data.len()))?;
        self.at += N;
        let mut bytes = *bytes;
        if self.big_endian {
            bytes.reverse();
        }
        Ok(bytes)
    }

    fn u32(&mut self) -> Result<u32, String> {
        Ok(u32::from_le_bytes(self.take()?))
    }

    fn f64(&mut self) -> Result<f64, String> {
        Ok(f64::from_le_bytes(self.take()?))
    }

    fn text(&mut self) -> Result<String, String> {
        let length = self.u32()? as usize;
        let end = self.at.checked_add(length);
        let bytes = end
            .and_then(|end| self.data.get(self.at..end))
            .ok_or_else(|| format!("a text of {length} bytes at byte {} does not fit", self.at))?;
        self.at += length;
        // CDR counts the final zero.
        let bytes = match self.aligned_from {
            Some(_) => bytes.strip_suffix(&[0]).unwrap_or(bytes),
            None => bytes,
        };
        let text = std::str::from_utf8(bytes);
        text.map(str::to_owned)
            .map_err(|_| "the name of a frame is not UTF-8".to_owned())
    }
}

#[derive(serde::Deserialize)]
struct JsonClock {
    clock: JsonStamp,
}

#[derive(serde::Deserialize)]
struct JsonMessage {
    transforms: Vec<JsonTransform>,
}

#[derive(serde::Deserialize)]
struct JsonTransform {
    header: JsonHeader,
    child_frame_id: String,
    transform: JsonPose,
}

#[derive(serde::Deserialize)]
struct JsonHeader {
    #[serde(default)]
    stamp: JsonStamp,
    frame_id: String,
}

#[derive(serde::Deserialize, Default)]
struct JsonStamp {
    #[serde(alias = "secs")]
    sec: i64,
    #[serde(alias = "nsecs", alias = "nsec")]
    nanosec: i64,
}

impl JsonStamp {
    fn nanos(&self) -> i64 {
        self.sec
            .saturating_mul(1_000_000_000)
            .saturating_add(self.nanosec)
    }
}

#[derive(serde::Deserialize)]
struct JsonPose {
    translation: JsonVector,
    rotation: JsonQuaternion,
}

#[derive(serde::Deserialize)]
struct JsonVector {
    x: f64,
    y: f64,
    z: f64,
}

#[derive(serde::Deserialize)]
struct JsonQuaternion {
    x: f64,
    y: f64,
    z: f64,
    w: f64,
}

fn json(data: &[u8]) -> Result<Vec<RecordedTransform>, String> {
    let message: JsonMessage = serde_json::from_slice(data).map_err(|error| error.to_string())?;
    let recorded = message.transforms.into_iter().map(|one| {
        let stamp = &one.header.stamp;
        let (place, turn) = (&one.transform.translation, &one.transform.rotation);
        RecordedTransform {
            stamp_nanos: stamp
                .sec
                .saturating_mul(1_000_000_000)
                .saturating_add(stamp.nanosec),
            parent: one.header.frame_id.clone(),
            child: one.child_frame_id.clone(),
            translation_m: [place.x, place.y, place.z],
            rotation_xyzw: [turn.x, turn.y, turn.z, turn.w],
        }
    });
    Ok(recorded.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn example() -> RecordedTransform {
        RecordedTransform {
            stamp_nanos: 1_500_000_007,
            parent: "base".to_owned(),
            child: "hand".to_owned(),
            translation_m: [1.0, -2.0, 3.5],
            rotation_xyzw: [0.0, 0.0, 1.0, 0.0],
        }
    }

    /// Two transforms as ROS 1 packs them.
    fn ros1() -> Vec<u8> {
        let mut bytes = 2_u32.to_le_bytes().to_vec();
        for _ in 0..2 {
            for number in [9_u32, 1, 500_000_007, 4] {
                bytes.extend(number.to_le_bytes());
            }
            bytes.extend(b"base\x04\0\0\0hand");
            let one = example();
            for number in one.translation_m.iter().chain(&one.rotation_xyzw) {
                bytes.extend(number.to_le_bytes());
            }
        }
        bytes
    }

    /// The same in CDR, with any byte order.
    fn cdr(big_endian: bool) -> Vec<u8> {
        let mut bytes = vec![0, u8::from(!big_endian), 0, 0];
        let mut push = |number: &[u8]| {
            while (bytes.len() - 4) % number.len() != 0 {
                bytes.push(0);
            }
            let ordered = number.iter().copied();
            if big_endian {
                bytes.extend(ordered.rev());
            } else {
                bytes.extend(ordered);
            }
        };
        push(&2_u32.to_le_bytes());
        for _ in 0..2 {
            for number in [1_u32, 500_000_007] {
                push(&number.to_le_bytes());
            }
            for text in [b"base\0", b"hand\0"] {
                push(&5_u32.to_le_bytes());
                for letter in text {
                    push(&[*letter]);
                }
            }
            let one = example();
            for number in one.translation_m.iter().chain(&one.rotation_xyzw) {
                push(&number.to_le_bytes());
            }
        }
        bytes
    }

    #[test]
    fn all_encodings_give_the_same_transforms() {
        let expected = Ok(vec![example(), example()]);
        assert_eq!(transforms_of(&Encoding::Ros1, &ros1()), expected);
        assert_eq!(transforms_of(&Encoding::Cdr, &cdr(false)), expected);
        assert_eq!(transforms_of(&Encoding::Cdr, &cdr(true)), expected);
        let one = r#"{"header":{"stamp":{"sec":1,"nanosec":500000007},"frame_id":"base"},
            "child_frame_id":"hand","transform":{"translation":{"x":1,"y":-2,"z":3.5},
            "rotation":{"x":0,"y":0,"z":1,"w":0}}}"#;
        let json = format!("{{\"transforms\":[{one},{one}]}}");
        assert_eq!(transforms_of(&Encoding::Json, json.as_bytes()), expected);
        assert!(transforms_of(&Encoding::Protobuf, b"").is_err());
    }

    #[test]
    fn cut_messages_are_errors() {
        for (encoding, bytes) in [(Encoding::Ros1, ros1()), (Encoding::Cdr, cdr(false))] {
            for length in 0..bytes.len() {
                assert!(
                    transforms_of(&encoding, &bytes[..length]).is_err(),
                    "{length}"
                );
            }
            let mut long = bytes.clone();
            long.extend([0; 8]);
            assert!(transforms_of(&encoding, &long).is_err());
            let mut lying = bytes;
            lying[if encoding == Encoding::Cdr { 7 } else { 3 }] = 0xff;
            assert!(transforms_of(&encoding, &lying).is_err());
        }
    }
}
