//! Shapes that move, as a recording that Foxglove shows in its 3D panel.
//!
//! # Format
//! An MCAP file of JSON messages with Foxglove's own types, compressed with zstd:
//!
//! | topic | type | holds |
//! |---|---|---|
//! | `/scene` | `foxglove.SceneUpdate` | all shapes once, each in the frame of its body |
//! | `/transforms` | `foxglove.FrameTransforms` | where the bodies are in the frame `world`, at each time |
//!
//! Each message of `/transforms` has every body, and the one of `/scene` every shape, so that a viewer
//! that jumps to a time needs only the last message of each topic.
//!
//! # Example
//! ```
//! use recording::{SceneFile, SceneForm, ScenePose, SceneShape};
//! let pose = ScenePose { position_m: [0.0, 0.0, 0.5], orientation: [1.0, 0.0, 0.0, 0.0] };
//! let cup = SceneShape {
//!     name: "cup".into(), body: Some("cup".into()), pose,
//!     form: SceneForm::Cylinder { radius_m: 0.04, length_m: 0.1 }, colour: [0.8, 0.3, 0.1, 1.0],
//! };
//! let mut file = SceneFile::new()?;
//! file.shapes(0, &[cup])?;
//! file.poses(20_000_000, &[("cup".into(), pose)])?;
//! let bytes = file.finish()?;
//! # assert!(!bytes.is_empty());
//! # Ok::<(), recording::RawWriteError>(())
//! ```

use std::collections::BTreeMap;
use std::io::Cursor;

use mcap::records::MessageHeader;
use mcap::{Compression, WriteOptions, Writer};
use serde_json::{Value, json};

use crate::raw_writer::RawWriteError;

/// Size of a chunk before compression, in bytes.
const CHUNK_BYTES: u64 = 1024 * 1024;
/// The frame in which bodies are placed.
const WORLD: &str = "world";
/// Facets of a capsule's half sphere from pole to rim, and of its circle.
const CAP_RINGS: usize = 6;
const CAP_SECTORS: usize = 20;

/// A position and an orientation `[w, x, y, z]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScenePose {
    /// Metres.
    pub position_m: [f64; 3],
    /// A unit quaternion.
    pub orientation: [f64; 4],
}

/// The form of a shape; cylinders and capsules lie along z, centred.
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs, reason = "names carry quantity and unit")]
pub enum SceneForm {
    Box {
        edges_m: [f64; 3],
    },
    Ellipsoid {
        radii_m: [f64; 3],
    },
    Cylinder {
        radius_m: f64,
        length_m: f64,
    },
    /// `length_m` is that of the straight part.
    Capsule {
        radius_m: f64,
        length_m: f64,
    },
    /// Triangles by the places of their corners.
    Triangles {
        points_m: Vec<[f64; 3]>,
        corners: Vec<[usize; 3]>,
    },
}

/// A shape on a body.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneShape {
    /// Unique among shapes.
    pub name: String,
    /// The body's name; `None` for the world.
    pub body: Option<String>,
    /// Its frame in the body's.
    pub pose: ScenePose,
    /// Its form.
    pub form: SceneForm,
    /// Red, green, blue and opacity, 0 to 1.
    pub colour: [f64; 4],
}

/// A recording of moving shapes that is being written.
pub struct SceneFile {
    writer: Writer<Cursor<Vec<u8>>>,
    scene: u16,
    transforms: u16,
    sequence: u32,
}

impl SceneFile {
    /// A file without shapes.
    ///
    /// # Errors
    /// [`RawWriteError::Format`] if the container cannot be begun.
    pub fn new() -> Result<Self, RawWriteError> {
        let options = WriteOptions::new()
            .library("corroborate")
            .compression(Some(Compression::Zstd))
            // Threads would make the bytes depend on the machine.
            .compression_threads(0)
            .chunk_size(Some(CHUNK_BYTES));
        let mut writer = options.create(Cursor::new(Vec::new()))?;
        let mut topic = |name: &str, type_name: &str, schema: Value| {
            let text = schema.to_string();
            let schema = writer.add_schema(type_name, "jsonschema", text.as_bytes())?;
            writer.add_channel(schema, name, "json", &BTreeMap::new())
        };
        let scene = topic("/scene", "foxglove.SceneUpdate", scene_schema())?;
        let transforms = topic(
            "/transforms",
            "foxglove.FrameTransforms",
            transforms_schema(),
        )?;
        Ok(Self {
            writer,
            scene,
            transforms,
            sequence: 0,
        })
    }

    /// Writes all shapes, in the place of those written before.
    ///
    /// # Errors
    /// [`RawWriteError`] if the time is before 1970 or the container refuses.
    pub fn shapes(&mut self, log_nanos: i64, shapes: &[SceneShape]) -> Result<(), RawWriteError> {
        let stamp = stamp_of(log_nanos);
        let entities: Vec<Value> = shapes.iter().map(|it| entity(&stamp, it)).collect();
        let message = json!({"deletions": [], "entities": entities});
        self.write(self.scene, log_nanos, &message)
    }

    /// Writes where bodies are.
    ///
    /// # Errors
    /// As [`SceneFile::shapes`].
    pub fn poses(
        &mut self,
        log_nanos: i64,
        poses: &[(String, ScenePose)],
    ) -> Result<(), RawWriteError> {
        let stamp = stamp_of(log_nanos);
        let transforms = poses.iter().map(|(body, pose)| {
            json!({
                "timestamp": stamp,
                "parent_frame_id": WORLD,
                "child_frame_id": body,
                "translation": vector(pose.position_m),
                "rotation": quaternion(pose.orientation),
            })
        });
        let message = json!({"transforms": transforms.collect::<Vec<Value>>()});
        self.write(self.transforms, log_nanos, &message)
    }

    fn write(&mut self, channel: u16, nanos: i64, message: &Value) -> Result<(), RawWriteError> {
        let time = u64::try_from(nanos).map_err(|_| RawWriteError::Time(nanos))?;
        let header = MessageHeader {
            channel_id: channel,
            sequence: self.sequence,
            log_time: time,
            publish_time: time,
        };
        self.sequence = self.sequence.wrapping_add(1);
        let text = message.to_string();
        Ok(self
            .writer
            .write_to_known_channel(&header, text.as_bytes())?)
    }

    /// The bytes of the file; the same calls give the same bytes.
    ///
    /// # Errors
    /// [`RawWriteError::Format`] if the container refuses.
    pub fn finish(mut self) -> Result<Vec<u8>, RawWriteError> {
        self.writer.finish()?;
        Ok(self.writer.into_inner().into_inner())
    }
}

fn stamp_of(nanos: i64) -> Value {
    const SECOND: i64 = 1_000_000_000;
    json!({"sec": nanos.div_euclid(SECOND), "nsec": nanos.rem_euclid(SECOND)})
}

/// Micrometres and millionths are more than is seen.
fn shown(value: f64) -> f64 {
    (value * 1e6).round() / 1e6
}

fn vector(of: [f64; 3]) -> Value {
    let [x, y, z] = of.map(shown);
    json!({"x": x, "y": y, "z": z})
}

fn quaternion(of: [f64; 4]) -> Value {
    let [w, x, y, z] = of.map(shown);
    json!({"x": x, "y": y, "z": z, "w": w})
}

fn pose(of: &ScenePose) -> Value {
    json!({"position": vector(of.position_m), "orientation": quaternion(of.orientation)})
}

/// A shape as an entity with one primitive.
fn entity(stamp: &Value, shape: &SceneShape) -> Value {
    let [r, g, b, a] = shape.colour;
    let colour = json!({"r": r, "g": g, "b": b, "a": a});
    let place = pose(&shape.pose);
    let (mut cubes, mut spheres, mut cylinders, mut triangles) = (vec![], vec![], vec![], vec![]);
    match &shape.form {
        SceneForm::Box { edges_m } => {
            cubes.push(json!({"pose": place, "size": vector(*edges_m), "color": colour}));
        }
        SceneForm::Ellipsoid { radii_m } => {
            let size = vector(radii_m.map(|radius| 2.0 * radius));
            spheres.push(json!({"pose": place, "size": size, "color": colour}));
        }
        SceneForm::Cylinder { radius_m, length_m } => cylinders.push(json!({
            "pose": place, "size": vector([2.0 * radius_m, 2.0 * radius_m, *length_m]),
            "bottom_scale": 1.0, "top_scale": 1.0, "color": colour,
        })),
        SceneForm::Capsule { radius_m, length_m } => {
            let (points_m, corners) = capsule(*radius_m, *length_m);
            triangles.push(mesh(&place, &points_m, &corners, &colour));
        }
        SceneForm::Triangles { points_m, corners } => {
            triangles.push(mesh(&place, points_m, corners, &colour));
        }
    }
    json!({
        "timestamp": stamp, "frame_id": shape.body.as_deref().unwrap_or(WORLD), "id": shape.name,
        "lifetime": {"sec": 0, "nsec": 0}, "frame_locked": true, "metadata": [],
        "arrows": [], "cubes": cubes, "spheres": spheres, "cylinders": cylinders, "lines": [],
        "triangles": triangles, "texts": [], "models": [],
    })
}

fn mesh(pose: &Value, points_m: &[[f64; 3]], corners: &[[usize; 3]], colour: &Value) -> Value {
    json!({
        "pose": pose, "color": colour, "colors": [],
        "points": points_m.iter().map(|point| vector(*point)).collect::<Vec<_>>(),
        "indices": corners.as_flattened(),
    })
}

/// A capsule's surface: rings from the lower pole to the upper one, the caps half a length away.
fn capsule(radius_m: f64, length_m: f64) -> (Vec<[f64; 3]>, Vec<[usize; 3]>) {
    let quarter = std::f64::consts::FRAC_PI_2;
    let ring = |latitude: f64, shift_m: f64| {
        (0..CAP_SECTORS).map(move |sector| {
            let around = std::f64::consts::TAU * sector as f64 / CAP_SECTORS as f64;
            let out_m = radius_m * latitude.cos();
            let up_m = radius_m * latitude.sin() + shift_m;
            [out_m * around.cos(), out_m * around.sin(), up_m]
        })
    };
    let mut points_m = Vec::new();
    for (side, first) in [(-1.0, -quarter), (1.0, 0.0)] {
        for step in 0..=CAP_RINGS {
            let latitude = first + quarter * step as f64 / CAP_RINGS as f64;
            points_m.extend(ring(latitude, side * length_m / 2.0));
        }
    }
    let rings = points_m.len() / CAP_SECTORS;
    let corners = (0..rings - 1).flat_map(|below| {
        (0..CAP_SECTORS).flat_map(move |sector| {
            let next = (sector + 1) % CAP_SECTORS;
            let at = |ring: usize, sector: usize| ring * CAP_SECTORS + sector;
            [
                [at(below, sector), at(below, next), at(below + 1, next)],
                [
                    at(below, sector),
                    at(below + 1, next),
                    at(below + 1, sector),
                ],
            ]
        })
    });
    let corners = corners.collect();
    (points_m, corners)
}

fn object(title: &str, properties: Value) -> Value {
    json!({"title": title, "type": "object", "properties": properties})
}

fn numbers(title: &str, names: &[&str]) -> Value {
    let properties = names
        .iter()
        .map(|name| ((*name).to_owned(), json!({"type": "number"})));
    object(title, Value::Object(properties.collect()))
}

fn list(items: Value) -> Value {
    json!({"type": "array", "items": items})
}

fn time(title: &str) -> Value {
    let whole = json!({"type": "integer"});
    object(title, json!({"sec": whole, "nsec": whole}))
}

fn transforms_schema() -> Value {
    let text = json!({"type": "string"});
    let transform = object(
        "foxglove.FrameTransform",
        json!({
            "timestamp": time("time"), "parent_frame_id": text, "child_frame_id": text,
            "translation": numbers("foxglove.Vector3", &["x", "y", "z"]),
            "rotation": numbers("foxglove.Quaternion", &["x", "y", "z", "w"]),
        }),
    );
    object(
        "foxglove.FrameTransforms",
        json!({"transforms": list(transform)}),
    )
}

fn scene_schema() -> Value {
    let text = json!({"type": "string"});
    let number = json!({"type": "number"});
    let vector = numbers("foxglove.Vector3", &["x", "y", "z"]);
    let colour = numbers("foxglove.Color", &["r", "g", "b", "a"]);
    let orientation = numbers("foxglove.Quaternion", &["x", "y", "z", "w"]);
    let pose = object(
        "foxglove.Pose",
        json!({"position": vector, "orientation": orientation}),
    );
    let sized = |title: &str| {
        object(
            title,
            json!({"pose": pose, "size": vector, "color": colour}),
        )
    };
    let mut cylinder = sized("foxglove.CylinderPrimitive");
    for scale in ["bottom_scale", "top_scale"] {
        cylinder["properties"][scale] = number.clone();
    }
    let triangles = object(
        "foxglove.TriangleListPrimitive",
        json!({
            "pose": pose, "points": list(numbers("foxglove.Point3", &["x", "y", "z"])),
            "color": colour, "colors": list(colour.clone()),
            "indices": list(json!({"type": "integer", "minimum": 0})),
        }),
    );
    let pair = object("foxglove.KeyValuePair", json!({"key": text, "value": text}));
    // Primitives that are never written are described by their kind alone.
    let unused = |title: &str| list(object(title, json!({})));
    let entity = object(
        "foxglove.SceneEntity",
        json!({
            "timestamp": time("time"), "frame_id": text, "id": text, "lifetime": time("duration"),
            "frame_locked": {"type": "boolean"}, "metadata": list(pair),
            "arrows": unused("foxglove.ArrowPrimitive"), "cubes": list(sized("foxglove.CubePrimitive")),
            "spheres": list(sized("foxglove.SpherePrimitive")), "cylinders": list(cylinder),
            "lines": unused("foxglove.LinePrimitive"), "triangles": list(triangles),
            "texts": unused("foxglove.TextPrimitive"), "models": unused("foxglove.ModelPrimitive"),
        }),
    );
    let deletion = object(
        "foxglove.SceneEntityDeletion",
        json!({"timestamp": time("time"), "type": {"type": "integer"}, "id": text}),
    );
    object(
        "foxglove.SceneUpdate",
        json!({"deletions": list(deletion), "entities": list(entity)}),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Format, OpenOptions, open_bytes};

    const PLACE: ScenePose = ScenePose {
        position_m: [1.0, 2.0, 3.0],
        orientation: [0.5, 0.5, -0.5, 0.5],
    };

    fn shape(name: &str, form: SceneForm) -> SceneShape {
        SceneShape {
            name: name.to_owned(),
            body: (name != "floor").then(|| "arm".to_owned()),
            pose: PLACE,
            form,
            colour: [0.1, 0.2, 0.3, 1.0],
        }
    }

    fn written() -> Vec<u8> {
        let edges_m = [1.0, 2.0, 3.0];
        let (radius_m, length_m) = (0.1, 0.5);
        let shapes = [
            shape("floor", SceneForm::Box { edges_m }),
            shape("ball", SceneForm::Ellipsoid { radii_m: edges_m }),
            shape("rod", SceneForm::Cylinder { radius_m, length_m }),
            shape("limb", SceneForm::Capsule { radius_m, length_m }),
        ];
        let mut file = SceneFile::new().unwrap();
        file.shapes(1_500_000_000, &shapes).unwrap();
        file.poses(1_500_000_000, &[("arm".to_owned(), PLACE)])
            .unwrap();
        assert!(file.poses(-1, &[]).is_err());
        file.finish().unwrap()
    }

    #[test]
    fn shapes_and_poses_are_read_back_as_foxglove_s_types() {
        let bytes = written();
        assert_eq!(bytes, written());
        let mut reader = open_bytes(bytes, Format::Mcap, &OpenOptions::default()).unwrap();
        let types: Vec<(String, String)> = reader
            .topics()
            .iter()
            .map(|topic| (topic.name.clone(), topic.type_name.clone()))
            .collect();
        let expected = [
            ("/scene", "foxglove.SceneUpdate"),
            ("/transforms", "foxglove.FrameTransforms"),
        ];
        assert_eq!(types, expected.map(|(a, b)| (a.to_owned(), b.to_owned())));
        let mut messages = Vec::new();
        while let Some(message) = reader.next().unwrap() {
            messages.push(serde_json::from_slice::<Value>(message.data).unwrap());
        }
        let entities = messages[0]["entities"].as_array().unwrap();
        assert_eq!(entities[0]["frame_id"], "world");
        assert_eq!(entities[0]["cubes"][0]["size"]["z"], 3.0);
        assert_eq!(entities[0]["cubes"][0]["pose"]["orientation"]["w"], 0.5);
        assert_eq!(entities[1]["spheres"][0]["size"]["y"], 4.0);
        assert_eq!(entities[2]["cylinders"][0]["size"]["x"], 0.2);
        assert_eq!(entities[3]["triangles"][0]["points"][0]["z"], -0.35);
        assert_eq!(entities[3]["timestamp"]["nsec"], 500_000_000);
        let transform = &messages[1]["transforms"][0];
        assert_eq!(transform["child_frame_id"], "arm");
        assert_eq!(transform["rotation"]["y"], -0.5);
    }

    #[test]
    fn a_capsule_is_closed_and_of_its_size() {
        let (points_m, corners) = capsule(0.1, 0.5);
        for [x, y, z] in &points_m {
            let beyond_m = (z.abs() - 0.25_f64).max(0.0);
            let from_axis_m = (x * x + y * y + beyond_m * beyond_m).sqrt();
            assert!((from_axis_m - 0.1).abs() < 1e-12, "{x} {y} {z}");
        }
        assert!(corners.as_flattened().iter().all(|at| *at < points_m.len()));
        // Outwards: the volume by the divergence theorem is positive and a little less than exact.
        let volume_m3: f64 = corners
            .iter()
            .map(|[a, b, c]| {
                let [a, b, c] = [points_m[*a], points_m[*b], points_m[*c]];
                (a[0] * (b[1] * c[2] - b[2] * c[1])
                    + a[1] * (b[2] * c[0] - b[0] * c[2])
                    + a[2] * (b[0] * c[1] - b[1] * c[0]))
                    / 6.0
            })
            .sum();
        let exact_m3 = std::f64::consts::PI * (0.1_f64.powi(2) * 0.5 + 4.0 / 3.0 * 0.1_f64.powi(3));
        let share = volume_m3 / exact_m3;
        assert!((0.95..1.0).contains(&share), "{share}");
    }
}
