//! Attaching: which topics are wanted, how the connection is made, and
//! waiting until the topics are there.

use super::LiveSystem;
use diagnostic::Problem;
use host::Host;
use live::{LiveError, Publisher, SchemaText, Source, Topic, TopicFilter, dds, foxglove};
use recording::{
    Loss, RawMessage, ReadError, Reader, SignalSource, SignalStream, StoredFile, TimeSource,
    TopicInfo, TopicMap, TypeDefinitions,
};
use std::collections::{BTreeMap, BTreeSet};
use std::net::IpAddr;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// How often to look whether a topic has appeared.
const LOOK_EVERY: Duration = Duration::from_millis(20);

/// After how long of waiting to say for what.
const PATIENCE: Duration = Duration::from_secs(2);

/// The topics that the signals need.
pub fn topics_for(map: &TopicMap, signals: &[String]) -> BTreeSet<String> {
    let mut topics = BTreeSet::new();
    for signal in signals {
        match map.find(signal) {
            Some((entry, _)) => topics.extend(topics_of(&entry.source)),
            None => topics.extend(topic_of(signal)),
        }
    }
    topics
}

/// The topics that the signals need, and those that were asked for.
pub fn filter(asked: &[String], map: &TopicMap, signals: &[String]) -> TopicFilter {
    let mut patterns = topics_for(map, signals);
    patterns.extend(asked.iter().cloned());
    if map.time.source == TimeSource::Clock {
        patterns.insert("/clock".into());
    }
    let patterns: Vec<&str> = patterns.iter().map(String::as_str).collect();
    TopicFilter::new(&patterns, &[])
}

fn topics_of(source: &SignalSource) -> Vec<String> {
    let frames = || ["/tf", "/tf_static"].map(str::to_owned);
    match source {
        SignalSource::Value { from } => topic_of(from).into_iter().collect(),
        SignalSource::Norm { of } => of.iter().flat_map(|path| topic_of(path)).collect(),
        // The frame may be known only with the message.
        SignalSource::Point { of, .. } | SignalSource::Vector { of, .. } => {
            topic_of(of).into_iter().chain(frames()).collect()
        }
        SignalSource::PositionOf { .. }
        | SignalSource::OrientationOf { .. }
        | SignalSource::DistanceBetween { .. }
        | SignalSource::SpeedOf { .. } => frames().into(),
    }
}

/// The topic of `/topic.path`, or without its slash for topics of plain DDS.
fn topic_of(path: &str) -> Vec<String> {
    let topic = path.split('.').next().unwrap_or(path);
    let plain = topic.strip_prefix('/').unwrap_or(topic);
    vec![topic.to_owned(), plain.to_owned()]
}

/// Attaches to the running system.
pub fn connect(system: &LiveSystem, filter: TopicFilter) -> Result<Box<dyn Source>, Problem> {
    let connected: Result<Box<dyn Source>, LiveError> = match system {
        LiveSystem::Foxglove { url } => {
            let options = foxglove::FoxgloveOptions::default();
            foxglove::connect(url, filter, &options).map(|stream| Box::new(stream) as _)
        }
        LiveSystem::Dds { domain, networks } => {
            let options = dds_options(*domain, networks);
            dds::connect(&options, filter).map(|stream| Box::new(stream) as _)
        }
    };
    connected.map_err(not_connected)
}

/// Makes ready to publish into the running system.
pub fn publisher(system: &LiveSystem) -> Result<Box<dyn Publisher>, Problem> {
    let made: Result<Box<dyn Publisher>, LiveError> = match system {
        LiveSystem::Foxglove { url } => {
            let options = foxglove::FoxgloveOptions::default();
            foxglove::FoxglovePublisher::new(url, &options).map(|it| Box::new(it) as _)
        }
        LiveSystem::Dds { domain, networks } => {
            dds::DdsPublisher::new(&dds_options(*domain, networks)).map(|it| Box::new(it) as _)
        }
    };
    made.map_err(not_connected)
}

fn dds_options(domain: u16, networks: &[IpAddr]) -> dds::DdsOptions {
    dds::DdsOptions {
        domain,
        networks: networks.to_vec(),
        ..dds::DdsOptions::default()
    }
}

/// A connection that could not be made.
pub fn not_connected(error: LiveError) -> Problem {
    Problem::new("cannot-connect", error.to_string())
}

/// The definition of a topic's type: that of the connection, or a known one.
pub fn schema_of(topic: &Topic, types: &TypeDefinitions) -> Option<SchemaText> {
    let known = || defined(types, &topic.type_name);
    topic.schema.clone().or_else(known)
}

fn defined(types: &TypeDefinitions, type_name: &str) -> Option<SchemaText> {
    types.text(type_name).map(|text| SchemaText {
        encoding: "ros2msg".into(),
        data: text.into_bytes(),
    })
}

/// A topic as a recording's.
pub fn info_of(topic: &Topic, types: &TypeDefinitions) -> TopicInfo {
    topic.info(&|type_name| defined(types, type_name))
}

/// Waits until every topic is there that the signals need. After `limit`, what
/// is there has to do, if anything is: signals without a topic are missing.
/// Messages meanwhile wait in the source's queue.
pub fn wait_for_topics(
    source: &dyn Source,
    types: &TypeDefinitions,
    map: &TopicMap,
    signals: &[String],
    limit: Duration,
    setting: &Host,
) -> Result<(), Problem> {
    let began = Instant::now();
    let mut looked_at = None;
    let mut state = Probe::Missing(Vec::new());
    let mut has_said = false;
    loop {
        setting.go_on()?;
        let topics = source.topics();
        if looked_at != Some(topics.len()) {
            looked_at = Some(topics.len());
            state = probe(&topics, types, map, signals);
        }
        let waited = began.elapsed();
        match &state {
            Probe::Ready => return Ok(()),
            Probe::Missing(_) if waited >= limit && !topics.is_empty() => return Ok(()),
            Probe::Missing(texts) | Probe::Unfit(texts) if waited >= limit => {
                return Err(not_there(texts, limit));
            }
            Probe::Missing(texts) | Probe::Unfit(texts) if waited >= PATIENCE && !has_said => {
                has_said = true;
                setting.events.say("waiting for topics:");
                texts.iter().for_each(|text| setting.events.say(text));
            }
            Probe::Missing(_) | Probe::Unfit(_) => {}
        }
        std::thread::sleep(LOOK_EVERY);
    }
}

fn not_there(texts: &[String], limit: Duration) -> Problem {
    let waited = limit.as_secs_f64();
    let why = match texts {
        [] => "no wanted topic has appeared".to_owned(),
        texts => texts.join("; "),
    };
    Problem::new("no-live-topics", format!("after {waited} s: {why}")).remedy(
        "check the domain or address and the names of the topics; say in topics.toml where the signals are; for types \
         of your own, name the folder of their .msg files with --message-path",
    )
}

/// Whether signals can be read of the topics.
enum Probe {
    Ready,
    /// Some topics are not there.
    Missing(Vec<String>),
    /// Something does not fit, at least so far.
    Unfit(Vec<String>),
}

fn probe(
    topics: &[Arc<Topic>],
    types: &TypeDefinitions,
    map: &TopicMap,
    signals: &[String],
) -> Probe {
    let known = KnownTopics {
        topics: topics.iter().map(|topic| info_of(topic, types)).collect(),
        metadata: BTreeMap::new(),
    };
    match SignalStream::new(Box::new(known), map, signals) {
        Ok(stream) if stream.absent().is_empty() => Probe::Ready,
        Ok(stream) => Probe::Missing(stream.absent().iter().map(ToString::to_string).collect()),
        Err(errors) => Probe::Unfit(errors.iter().map(ToString::to_string).collect()),
    }
}

/// Topics without messages.
struct KnownTopics {
    topics: Vec<TopicInfo>,
    metadata: BTreeMap<String, String>,
}

impl Reader for KnownTopics {
    fn topics(&self) -> &[TopicInfo] {
        &self.topics
    }
    fn next(&mut self) -> Result<Option<RawMessage<'_>>, ReadError> {
        Ok(None)
    }
    fn losses(&self) -> &[Loss] {
        &[]
    }
    fn complete(&self) -> bool {
        true
    }
    fn select(&mut self, _: &dyn Fn(&TopicInfo) -> bool) {}
    fn metadata(&self) -> &BTreeMap<String, String> {
        &self.metadata
    }
    fn in_time_order(&self) -> bool {
        true
    }

    /// A running system has no end.
    fn end_nanos(&self) -> Option<i64> {
        None
    }

    fn checked(&self) -> bool {
        false
    }

    fn storage(&self) -> Vec<StoredFile> {
        Vec::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_topics_that_the_signals_need_are_listened_to() {
        let text = "[\"/robot.speed\"]\nnorm = \"/odom.twist.linear\"\nunit = \"m/s\"\n[\"/hand\"]\nposition_of = \"hand\"\nin_frame = \"world\"\n";
        let map = TopicMap::parse("topics.toml", text).expect("a map");
        let signals = ["/robot.speed", "/hand.x", "/task.phase"].map(str::to_owned);
        let filter = filter(&["/extra/*".to_owned()], &map, &signals);
        for wanted in ["/odom", "/tf", "/tf_static", "/task", "task", "/extra/a"] {
            assert!(filter.wants(wanted), "{wanted}");
        }
        assert!(!filter.wants("/robot") && !filter.wants("/camera"));
    }
}
