//! The simulated rest of a robot: an episode at the pace of the clock, whose
//! messages and those from outside are one stream.
//!
//! What the episode records becomes messages by the table `ros2.toml`, except
//! for the topics that are said to be outside. Simulated time begins when all
//! wanted topics are there. A step that begins later than one period of the
//! robot's code makes the run incomplete: the part in the loop has then met a
//! robot that reacted too late.

use super::connection::{self, not_connected, topics_for};
use super::{LiveSystem, WatchRequest};
use crate::rigs;
use crate::ros2_table::{Ros2Table, bad};
use crate::technique::simulation::Seeds;
use diagnostic::Problem;
use host::Host;
use live::{
    Bridge, BridgeFeed, LiveError, LiveStream, Outgoing, PublicationId, Punctuality, SchemaText,
    TopicFilter,
};
use recording::{Ros2Encoder, Ros2Topic, TopicMap};
use rig::{Link, Pace, Rest};
use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use study::{Entry, Study};
use testbench::SimError;
use trace::Trace;

/// How long to listen at once before the episode begins.
const LISTEN: Duration = Duration::from_millis(20);

/// An episode that is to be joined to what runs outside.
pub struct Bench {
    rest: Arc<dyn Rest>,
    /// The topics of its recording.
    layout: Trace,
    seed: u64,
    /// What it publishes.
    topics: Vec<Ros2Topic>,
    tolerance_nanos: i64,
    /// What a recording of the run says of it.
    pub about: BTreeMap<String, String>,
    begin: Arc<AtomicBool>,
    kept: Arc<Mutex<Kept>>,
}

/// How an episode went.
#[derive(Clone, Copy, Debug, Default)]
struct Kept {
    punctuality: Punctuality,
    /// Rows of which no message could be made.
    left_out: u64,
}

impl Bench {
    /// Prepares the episode that is asked for, if one is.
    pub fn new(
        request: &WatchRequest,
        study: &Study,
        map: &TopicMap,
        signals: &[String],
        setting: &Host,
    ) -> Result<Option<Self>, Problem> {
        let Some(asked) = &request.rest else {
            return Ok(None);
        };
        let entry = study.entry(&asked.entry)?;
        let file = entry.work.simulated_file();
        let file = file.ok_or_else(|| no_rest(entry))?;
        let rig = rigs::of_entry(study, entry, setting)?;
        let is_outside = |signals: &[String]| is_outside(&asked.outside, map, signals);
        let rest = rig.rest(&is_outside).ok_or_else(|| no_rest(entry))?;
        let table = Ros2Table::beside(&study.folder.join(file), &study.reach)?;
        let seeds = Seeds::new(asked.seed.unwrap_or(study.about.seed), entry.seeded_as());
        let seed = seeds.of(asked.episode);
        let tool = rig.tool();
        let mut about = BTreeMap::from([
            (
                "simulated",
                format!("{}, episode {}", entry.id, asked.episode),
            ),
            (
                "simulated_by",
                format!("{} {}, {}", tool.name, tool.version, tool.settings),
            ),
            ("simulated_seed", seed.to_string()),
            ("outside", asked.outside.join(", ")),
        ]);
        match entry.work.simulated_parameters() {
            Some(parameters) => about.extend([
                ("simulated_scenario", shown(file)),
                ("simulated_parameters", shown(parameters)),
            ]),
            None => about.extend([("simulated_scene", shown(file))]),
        }
        check_outside(&asked.outside, map, signals, &table, &rest.signals())?;
        let is_inside = |topic: &Ros2Topic| !asked.outside.contains(&topic.name);
        Ok(Some(Self {
            seed,
            topics: table.topics.into_iter().filter(is_inside).collect(),
            tolerance_nanos: nanos(rest.period_secs()),
            layout: rig.layout(&setting.cancel)?,
            rest,
            about: about.into_iter().map(|(k, v)| (k.to_owned(), v)).collect(),
            begin: Arc::default(),
            kept: Arc::default(),
        }))
    }

    /// The signals that the robot reads from outside.
    pub fn signals(&self) -> Vec<String> {
        self.rest.signals()
    }

    /// The way of these signals to the episode, from a stream with this layout.
    pub fn link(&self, layout: &Trace) -> Result<Box<dyn Link>, Problem> {
        self.rest.link(layout)
    }

    /// Attaches, and makes everything ready; the episode waits for
    /// [`Bench::begin`].
    pub fn connect(
        &self,
        system: &LiveSystem,
        mut filter: TopicFilter,
    ) -> Result<LiveStream, Problem> {
        for topic in &self.topics {
            // What is published must not come back from outside.
            filter.leave(&topic.name);
        }
        let outgoing = outgoing(&self.topics, &self.layout)?;
        let source = connection::connect(system, filter)?;
        let bridge = Bridge::new(source, connection::publisher(system)?);
        let mut episode = Episode {
            rest: Arc::clone(&self.rest),
            seed: self.seed,
            topics: self.topics.clone(),
            layout: self.layout.clone(),
            tolerance_nanos: self.tolerance_nanos,
            begin: self.begin.clone(),
            kept: self.kept.clone(),
        };
        LiveStream::of_bench(bridge, &outgoing, move |feed, ids| episode.run(feed, ids))
            .map_err(not_connected)
    }

    /// Lets simulated time begin.
    pub fn begin(&self) {
        self.begin.store(true, Ordering::Release);
    }

    /// What is missing because of the simulation, a clause each.
    pub fn missing(&self) -> Vec<String> {
        let kept = *self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        let late = kept.punctuality;
        let millis = |nanos: i64| nanos as f64 / 1e6;
        let mut missing = Vec::new();
        if late.late_steps > 0 {
            missing.push(format!(
                "{} of {} steps of the simulation were more than {} ms late, at most {:.1} ms",
                late.late_steps,
                late.steps,
                millis(self.tolerance_nanos),
                millis(late.latest_nanos),
            ));
        }
        missing
    }

    /// What was noted while it ran, for the recording.
    pub fn findings(&self) -> BTreeMap<String, String> {
        let kept = *self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        let late = kept.punctuality;
        [
            ("simulated_steps", late.steps.to_string()),
            ("simulated_late_steps", late.late_steps.to_string()),
            ("simulated_latest_nanos", late.latest_nanos.to_string()),
            ("simulated_rows_left_out", kept.left_out.to_string()),
        ]
        .map(|(key, value)| (key.to_owned(), value))
        .into()
    }
}

fn shown(path: &Path) -> String {
    path.to_string_lossy().replace('\\', "/")
}

/// Said of an entry whose episodes cannot keep step with a robot.
fn no_rest(entry: &Entry) -> Problem {
    let message = format!("`{}` is not a simulation of this study", entry.id);
    Problem::new("not-a-simulation", message)
        .remedy("name an entry of the ledger with a scenario or a scene")
}

/// Whether one of these signals comes from a topic that is said to be outside.
fn is_outside(outside: &[String], map: &TopicMap, signals: &[String]) -> bool {
    let topics = topics_for(map, signals);
    outside.iter().any(|topic| topics.contains(topic))
}

/// A topic from outside that nobody reads is a slip of the pen.
fn check_outside(
    outside: &[String],
    map: &TopicMap,
    signals: &[String],
    table: &Ros2Table,
    of_inputs: &[String],
) -> Result<(), Problem> {
    let mut known = topics_for(map, signals);
    known.extend(topics_for(map, of_inputs));
    known.extend(table.topics.iter().map(|topic| topic.name.clone()));
    match outside.iter().find(|it| !known.contains(*it)) {
        None => Ok(()),
        Some(topic) => Err(Problem::new(
            "unknown-live-topic",
            format!("nothing is read from {topic}: neither a requirement nor the simulated robot needs it"),
        )
        .remedy("name a topic of ros2.toml or of the topic map; to record others, use --topics")),
    }
}

/// The topics as they are made known.
fn outgoing(topics: &[Ros2Topic], layout: &Trace) -> Result<Vec<Outgoing>, Problem> {
    let describe = |topic: &Ros2Topic| {
        let encoder = Ros2Encoder::new(layout, topic);
        let encoder = encoder.map_err(|error| bad(format!("{}: {error}", topic.name)))?;
        let mut outgoing = Outgoing::ros2(&topic.name, &topic.type_name);
        outgoing.schema = Some(SchemaText {
            encoding: "ros2msg".into(),
            data: encoder.schema_text().into_bytes(),
        });
        Ok(outgoing)
    };
    topics.iter().map(describe).collect()
}

/// The episode as its thread has it.
struct Episode {
    rest: Arc<dyn Rest>,
    seed: u64,
    topics: Vec<Ros2Topic>,
    layout: Trace,
    tolerance_nanos: i64,
    begin: Arc<AtomicBool>,
    kept: Arc<Mutex<Kept>>,
}

impl Episode {
    fn run(&mut self, feed: &mut BridgeFeed, ids: &[PublicationId]) -> Result<String, LiveError> {
        while !self.begin.load(Ordering::Acquire) {
            if feed.stopped() {
                return Ok("it was stopped".into());
            }
            feed.listen(LISTEN)?;
        }
        let encoders = self
            .topics
            .iter()
            .map(|it| Ros2Encoder::new(&self.layout, it));
        let encoders = encoders.collect::<Result<Vec<_>, _>>();
        let encoders = encoders.map_err(|error| LiveError::Encoding(error.to_string()))?;
        let mut kept = KeptInStep {
            sent: vec![0; encoders.len()],
            encoders,
            feed,
            ids,
            kept: &self.kept,
            tolerance_nanos: self.tolerance_nanos,
            message: Vec::new(),
            failed: None,
        };
        let episode = self.rest.run(self.seed, &mut kept);
        if let Some(error) = kept.failed {
            return Err(error);
        }
        match episode {
            Ok((trace, sim_secs)) => {
                kept.publish(&trace)?;
                Ok(format!("the episode is over after {sim_secs:.2} s"))
            }
            Err(SimError::Cancelled) => Ok("it was stopped".into()),
            Err(error) => Err(LiveError::Unsupported(format!(
                "the simulation failed: {error}"
            ))),
        }
    }
}

/// What an episode under way meets.
struct KeptInStep<'r> {
    feed: &'r mut BridgeFeed,
    ids: &'r [PublicationId],
    encoders: Vec<Ros2Encoder<'r>>,
    /// For each topic, the rows that were sent.
    sent: Vec<usize>,
    kept: &'r Mutex<Kept>,
    tolerance_nanos: i64,
    message: Vec<u8>,
    failed: Option<LiveError>,
}

impl KeptInStep<'_> {
    /// Sends what was recorded since.
    fn publish(&mut self, recorded: &Trace) -> Result<(), LiveError> {
        let encoding = |error: recording::Ros2WriteError| LiveError::Encoding(error.to_string());
        for (place, encoder) in self.encoders.iter().enumerate() {
            let times = &recorded.channels[encoder.channel()].times_secs;
            for (row, secs) in times.iter().enumerate().skip(self.sent[place]) {
                let message = &mut self.message;
                let made = encoder.encode(recorded, row, nanos(*secs), message);
                if made.map_err(encoding)? {
                    self.feed.publish(self.ids[place], message.clone())?;
                } else {
                    let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
                    kept.left_out += 1;
                }
            }
            self.sent[place] = times.len();
        }
        Ok(())
    }

    fn keep_step(&mut self, now_secs: f64, recorded: &Trace) -> Result<(), LiveError> {
        self.publish(recorded)?;
        self.feed.advance(nanos(now_secs))?;
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        kept.punctuality = self.feed.punctuality();
        Ok(())
    }
}

impl Pace for KeptInStep<'_> {
    fn start(&mut self) {
        self.feed.start(0, self.tolerance_nanos);
    }

    fn step(&mut self, now_secs: f64, recorded: &Trace) -> ControlFlow<()> {
        if self.feed.stopped() {
            return ControlFlow::Break(());
        }
        match self.keep_step(now_secs, recorded) {
            Ok(()) => ControlFlow::Continue(()),
            Err(error) => {
                self.failed = Some(error);
                ControlFlow::Break(())
            }
        }
    }
}

/// Seconds of simulated time in nanoseconds.
fn nanos(secs: f64) -> i64 {
    // A conversion from a double saturates.
    (secs * 1e9).round() as i64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_outside_follows_from_the_topic_map() {
        let text = "[\"/sensors.pressure_ok\"]\nfrom = \"/gripper/felt.data\"\nkind = \"bool\"\n";
        let map = TopicMap::parse("topics.toml", text).expect("a map");
        let is =
            |topic: &str, signal: &str| is_outside(&[topic.to_owned()], &map, &[signal.to_owned()]);
        assert!(is("/gripper/felt", "/sensors.pressure_ok"));
        assert!(is("/sensors", "/sensors.gaze_ok"));
        assert!(!is("/sensors", "/sensors.pressure_ok"));
        assert!(!is("/elsewhere", "/sensors.gaze_ok"));
    }
}
