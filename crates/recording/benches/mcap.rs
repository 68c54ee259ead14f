//! How fast values come out of an MCAP file of a robot: joint states of seven joints at 1 kHz, an IMU at 400 Hz, transforms
//! at 100 Hz; one thread reads and decompresses, one decodes.
//!
//!     cargo bench -p corroborate-recording --bench mcap [-- FOLDER [MINUTES [none|zstd]]]
//!
//! With a folder, the files stay there, and other readers can be measured on them; the program tells what it measured.
//! With a compression, only that file is written, and nothing is read.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};
use std::time::Instant;

use mcap::records::MessageHeader;
use recording::{Extractor, FieldPath, OpenOptions, TopicInfo, open};

const RULE: &str =
    "================================================================================";
const JOINTS: [&str; 7] = [
    "shoulder_pan",
    "shoulder_lift",
    "upper_arm_roll",
    "elbow_flex",
    "forearm_roll",
    "wrist_flex",
    "wrist_roll",
];

/// What is read of each topic.
const WANTED: [(&str, &[&str]); 3] = [
    (
        "/joint_states",
        &[
            "header.stamp.sec",
            "header.stamp.nanosec",
            "position[3]",
            "velocity[name='wrist_flex']",
        ],
    ),
    ("/imu", &["linear_acceleration.z", "angular_velocity.x"]),
    (
        "/tf",
        &["transforms[child_frame_id='hand'].transform.translation.x"],
    ),
];

/// Little-endian CDR, as far as it is needed here.
struct Cdr(Vec<u8>);

impl Cdr {
    fn new() -> Self {
        Cdr(vec![0, 1, 0, 0])
    }

    fn align(&mut self, to: usize) {
        let body = self.0.len() - 4;
        self.0.resize(4 + body.next_multiple_of(to), 0);
    }

    fn u32(&mut self, value: u32) {
        self.align(4);
        self.0.extend(value.to_le_bytes());
    }

    fn f64(&mut self, value: f64) {
        self.align(8);
        self.0.extend(value.to_le_bytes());
    }

    fn text(&mut self, text: &str) {
        self.u32(text.len() as u32 + 1);
        self.0.extend(text.as_bytes());
        self.0.push(0);
    }

    fn header(&mut self, nanos: u64, frame: &str) {
        self.u32((nanos / 1_000_000_000) as u32);
        self.u32((nanos % 1_000_000_000) as u32);
        self.text(frame);
    }
}

/// Digits like those of a sensor: a slow movement and noise in the last places.
fn noisy(nanos: u64, joint: usize, state: &mut u64) -> f64 {
    *state = state
        .wrapping_mul(6364136223846793005)
        .wrapping_add(1442695040888963407);
    let noise = (*state >> 40) as f64 / 2.0_f64.powi(24) - 0.5;
    let time_secs = nanos as f64 / 1e9;
    (time_secs * (0.3 + 0.1 * joint as f64)).sin() + 1e-3 * noise
}

fn joint_state(nanos: u64, state: &mut u64) -> Vec<u8> {
    let mut cdr = Cdr::new();
    cdr.header(nanos, "base_link");
    cdr.u32(JOINTS.len() as u32);
    JOINTS.iter().for_each(|name| cdr.text(name));
    for _ in 0..3 {
        cdr.u32(JOINTS.len() as u32);
        (0..JOINTS.len()).for_each(|joint| cdr.f64(noisy(nanos, joint, state)));
    }
    cdr.0
}

fn imu(nanos: u64, state: &mut u64) -> Vec<u8> {
    let mut cdr = Cdr::new();
    cdr.header(nanos, "imu");
    (0..37).for_each(|place| cdr.f64(noisy(nanos, place, state)));
    cdr.0
}

fn transforms(nanos: u64, state: &mut u64) -> Vec<u8> {
    let mut cdr = Cdr::new();
    let frames = ["link1", "link2", "link3", "hand"];
    cdr.u32(frames.len() as u32);
    for frame in frames {
        cdr.header(nanos, "base_link");
        cdr.text(frame);
        (0..7).for_each(|place| cdr.f64(noisy(nanos, place, state)));
    }
    cdr.0
}

fn schemas() -> [(&'static str, &'static str, String); 3] {
    let header = format!(
        "{RULE}\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n{RULE}\n\
         MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"
    );
    let vectors = format!(
        "{RULE}\nMSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n{RULE}\n\
         MSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n"
    );
    let joints = "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\n\
                  float64[] effort\n";
    let imu = "std_msgs/Header header\ngeometry_msgs/Quaternion orientation\n\
               float64[9] orientation_covariance\ngeometry_msgs/Vector3 angular_velocity\n\
               float64[9] angular_velocity_covariance\n\
               geometry_msgs/Vector3 linear_acceleration\n\
               float64[9] linear_acceleration_covariance\n";
    let tf = format!(
        "geometry_msgs/TransformStamped[] transforms\n{RULE}\nMSG: geometry_msgs/TransformStamped\n\
         std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform\n{RULE}\n\
         MSG: geometry_msgs/Transform\ngeometry_msgs/Vector3 translation\n\
         geometry_msgs/Quaternion rotation\n"
    );
    [
        (
            "/joint_states",
            "sensor_msgs/msg/JointState",
            format!("{joints}{header}"),
        ),
        (
            "/imu",
            "sensor_msgs/msg/Imu",
            format!("{imu}{header}{vectors}"),
        ),
        (
            "/tf",
            "tf2_msgs/msg/TFMessage",
            format!("{tf}{header}{vectors}"),
        ),
    ]
}

fn generate(path: &Path, compression: Option<mcap::Compression>, secs: u64) -> u64 {
    let out = BufWriter::new(File::create(path).expect("a file"));
    let options = mcap::WriteOptions::new()
        .profile("ros2")
        .compression(compression);
    let mut writer = options.create(out).expect("a writer");
    let mut channels = Vec::new();
    for (topic, name, text) in schemas() {
        let schema = writer
            .add_schema(name, "ros2msg", text.as_bytes())
            .expect("a schema");
        let channel = writer.add_channel(schema, topic, "cdr", &Default::default());
        channels.push(channel.expect("a channel"));
    }
    let (mut state, mut count) = (1, 0);
    // One step is half a millisecond.
    for step in 0..secs * 2000 {
        let nanos = 1_700_000_000_000_000_000 + step * 500_000;
        for (channel, every, make) in [
            (0, 2, joint_state as fn(u64, &mut u64) -> Vec<u8>),
            (1, 5, imu),
            (2, 20, transforms),
        ] {
            if step % every == 0 {
                let header = MessageHeader {
                    channel_id: channels[channel],
                    sequence: count as u32,
                    log_time: nanos,
                    publish_time: nanos,
                };
                let data = make(nanos, &mut state);
                writer
                    .write_to_known_channel(&header, &data)
                    .expect("a message");
                count += 1;
            }
        }
    }
    writer.finish().expect("a finished file");
    count
}

fn extractor(topic: &TopicInfo) -> (Extractor, Vec<f64>) {
    let wanted = WANTED.iter().find(|(name, _)| *name == topic.name);
    let paths = wanted.map_or(&[][..], |(_, paths)| paths);
    let paths: Vec<FieldPath> = paths
        .iter()
        .map(|path| FieldPath::parse(path).expect("a path"))
        .collect();
    let made = Extractor::new(topic, &paths).expect("an extractor");
    (made, vec![0.0; paths.len()])
}

/// Reads all that is wanted; gives the number of messages and a sum over all values.
fn read(path: &Path) -> (u64, f64) {
    let mut reader = open(path, &OpenOptions::default()).expect("a recording");
    let mut extractors: Vec<_> = reader.topics().iter().map(extractor).collect();
    let (mut count, mut sum) = (0, 0.0);
    while let Some(message) = reader.next().expect("a readable file") {
        let (extractor, values) = &mut extractors[message.topic.index()];
        extractor
            .extract(message.data, values)
            .expect("a well-formed message");
        sum += values.iter().sum::<f64>();
        count += 1;
    }
    assert!(reader.complete() && reader.checked());
    (count, sum)
}

fn main() {
    let arguments: Vec<String> = std::env::args()
        .skip(1)
        .filter(|a| !a.starts_with("--"))
        .collect();
    let folder = tempfile::tempdir().expect("a folder");
    let chosen = arguments.first().map(PathBuf::from);
    let place = chosen.unwrap_or_else(|| folder.path().to_owned());
    let minutes = arguments
        .get(1)
        .map_or(5, |text| text.parse().expect("a number of minutes"));
    for (name, compression) in [("none", None), ("zstd", Some(mcap::Compression::Zstd))] {
        if arguments.get(2).is_some_and(|only| only != name) {
            continue;
        }
        let path = place.join(format!("robot_{name}.mcap"));
        let written = generate(&path, compression, minutes * 60);
        let bytes = std::fs::metadata(&path).expect("a file").len();
        if arguments.len() > 2 {
            println!("{name}: {written} messages, {:.0} MB", bytes as f64 / 1e6);
            continue;
        }
        let mut best_secs = f64::INFINITY;
        for _ in 0..5 {
            let begin = Instant::now();
            let (count, sum) = read(&path);
            assert!(count == written && sum.is_finite());
            best_secs = best_secs.min(begin.elapsed().as_secs_f64());
        }
        println!(
            "{name}: {written} messages, {:.0} MB, {best_secs:.3} s: {:.2} million messages/s",
            bytes as f64 / 1e6,
            written as f64 / best_secs / 1e6
        );
    }
}
