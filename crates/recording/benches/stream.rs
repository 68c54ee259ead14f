//! From a recording to predicates: messages a second on one core, with five signals of two topics.

use std::io::Write as _;

use recording::{OpenOptions, Ros2Recording, Ros2Value, SignalStream, TopicMap, open};

/// Messages of the joints; one of the points comes with each fifth.
const MESSAGES: i64 = 400_000;

fn main() {
    divan::main();
}

fn written() -> Result<tempfile::NamedTempFile, Box<dyn std::error::Error>> {
    let mut recording = Ros2Recording::new()?;
    let joints = recording.add_topic("/joint_states", "sensor_msgs/msg/JointState")?;
    let point = recording.add_topic("/person", "geometry_msgs/msg/PointStamped")?;
    for step in 0..MESSAGES {
        let nanos = 1_700_000_000_000_000_000 + step * 1_000_000;
        let angle = step as f64 * 1e-3;
        let mut fields = vec![("header.stamp", Ros2Value::Nanos(nanos))];
        for (path, name) in [
            ("name[0]", "a"),
            ("name[1]", "b"),
            ("name[2]", "c"),
            ("name[3]", "d"),
            ("name[4]", "e"),
            ("name[5]", "f"),
            ("name[6]", "g"),
        ] {
            fields.push((path, Ros2Value::Text(name)));
        }
        for path in [
            "position[0]",
            "position[1]",
            "position[2]",
            "position[3]",
            "position[4]",
            "position[5]",
            "position[6]",
        ] {
            fields.push((path, Ros2Value::Number(angle.sin())));
        }
        for path in [
            "velocity[0]",
            "velocity[1]",
            "velocity[2]",
            "velocity[3]",
            "velocity[4]",
            "velocity[5]",
            "velocity[6]",
        ] {
            fields.push((path, Ros2Value::Number(angle.cos())));
        }
        recording.write(joints, nanos, &fields)?;
        if step % 5 == 0 {
            recording.write(
                point,
                nanos,
                &[
                    ("header.stamp", Ros2Value::Nanos(nanos)),
                    ("header.frame_id", Ros2Value::Text("world")),
                    ("point.x", Ros2Value::Number(angle)),
                ],
            )?;
        }
    }
    let mut file = tempfile::NamedTempFile::new()?;
    file.write_all(&recording.finish()?)?;
    Ok(file)
}

const MAP: &str = r#"
["/robot.speed"]
from = "/joint_states.velocity[name='d']"
staleness = "100 ms"
["/robot.elbow"]
from = "/joint_states.position[3]"
["/person"]
point = "/person.point"
"#;

fn judge(
    path: &std::path::Path,
    text: &str,
    wanted: &[&str],
) -> Result<u64, Box<dyn std::error::Error>> {
    let map = TopicMap::parse("bench", text).map_err(|mut errors| errors.remove(0))?;
    let wanted: Vec<String> = wanted.iter().map(|name| (*name).to_owned()).collect();
    let reader = open(path, &OpenOptions::default())?;
    let mut stream =
        SignalStream::new(reader, &map, &wanted).map_err(|mut errors| errors.remove(0))?;
    let slow = trace::Predicate::parse("/robot.speed < 0.5 | /person.x > /robot.elbow")?
        .bind(stream.layout())?;
    let mut count = 0;
    while stream.next_instant()?.is_some() {
        count += u64::from(slow.eval(stream.snapshot()) == Some(true));
    }
    assert!(stream.complete() && count > 0);
    Ok(count)
}

#[divan::bench_group(sample_count = 5, sample_size = 1)]
mod stream {
    use super::*;

    fn bench(bencher: divan::Bencher<'_, '_>, map: &str) {
        let file = written().expect("the recording is written");
        bencher
            .counter(divan::counter::ItemsCount::new(MESSAGES as usize * 6 / 5))
            .bench_local(|| judge(file.path(), map, &[]).expect("the recording is read"));
    }

    #[divan::bench]
    fn by_log_time(bencher: divan::Bencher<'_, '_>) {
        bench(bencher, MAP);
    }

    #[divan::bench]
    fn by_header_time(bencher: divan::Bencher<'_, '_>) {
        bench(bencher, &format!("{MAP}[time]\nfrom = \"header\"\n"));
    }

    #[divan::bench]
    fn with_a_linear_signal(bencher: divan::Bencher<'_, '_>) {
        bench(
            bencher,
            &MAP.replace("staleness", "interpolation = \"linear\"\nstaleness"),
        );
    }

    #[divan::bench]
    fn inspected(bencher: divan::Bencher<'_, '_>) {
        let file = written().expect("the recording is written");
        bencher
            .counter(divan::counter::ItemsCount::new(MESSAGES as usize * 6 / 5))
            .bench_local(|| {
                let options = recording::InspectOptions::default();
                recording::inspect(file.path(), &OpenOptions::default(), &options)
                    .expect("the recording is read")
            });
    }
}
