//! Watching a source that is scripted, silence included.

use super::*;
use live::{Clock, Incoming, LiveError, Message, Origin, Topic, Totals};
use std::collections::VecDeque;

/// A topic of JSON whose messages come when the script says: after so many
/// milliseconds, with this value of `x`.
struct Script {
    clock: Clock,
    topic: Arc<Topic>,
    began_nanos: i64,
    coming: VecDeque<(i64, f64)>,
    received: u64,
}

impl Script {
    fn new(coming: &[(i64, f64)]) -> Box<Self> {
        let topic = Topic {
            id: 0,
            name: "/a".into(),
            type_name: "A".into(),
            encoding: "json".into(),
            schema: None,
            qos: None,
            type_hash: None,
            origin: Origin::Outside,
            numbered: true,
        };
        let clock = Clock::start();
        Box::new(Self {
            topic: Arc::new(topic),
            began_nanos: clock.now_nanos(),
            clock,
            coming: coming.iter().copied().collect(),
            received: 0,
        })
    }
}

impl Source for Script {
    fn next(&mut self, timeout: Duration) -> Result<Option<Incoming>, LiveError> {
        let due = |at_ms: i64| self.began_nanos + at_ms * 1_000_000;
        let now_nanos = self.clock.now_nanos();
        match self.coming.front() {
            Some((at_ms, value)) if due(*at_ms) <= now_nanos => {
                let data = format!("{{\"x\": {value}}}").into_bytes();
                self.coming.pop_front();
                self.received += 1;
                Ok(Some(Incoming::Message(Message {
                    topic: self.topic.clone(),
                    publish_nanos: None,
                    received_nanos: now_nanos,
                    sequence: None,
                    data,
                })))
            }
            _ => {
                std::thread::sleep(timeout.min(Duration::from_millis(5)));
                Ok(None)
            }
        }
    }
    fn topics(&self) -> Vec<Arc<Topic>> {
        vec![self.topic.clone()]
    }
    fn totals(&self) -> Totals {
        Totals {
            received: self.received,
            ..Totals::default()
        }
    }
    fn clock(&self) -> Clock {
        self.clock
    }
    fn stop(&mut self) {}
}

/// A study of one requirement with a deadline: what is high is answered by
/// what is very high.
fn study(folder: &Path, staleness: &str) {
    let write = |name: &str, text: &str| {
        std::fs::write(folder.join(name), text).expect("written");
    };
    write(
        "study.toml",
        "title = \"t\"\nsummary = \"s\"\nseed = 1\nconfidence = 0.95\nagreement = 0.95\n[conditions]\nfield = \"f\"\n",
    );
    write(
        "requirements.toml",
        "[[requirement]]\nid = \"formula\"\ntext = \"t\"\nformula = \"always (high implies eventually[0, 300 ms] answered)\"\n\
         [[requirement]]\nid = \"stages\"\ntext = \"t\"\nmonitor.when = \"high\"\nmonitor.then = [{ wait_for = \"answered\", within_secs = 0.3 }]\n\
         [[requirement]]\nid = \"open\"\ntext = \"t\"\nformula = \"eventually answered\"\n",
    );
    write(
        "vocabulary.toml",
        "[high]\nmeaning = \"m\"\ntrace = \"/s.x > 1\"\n[answered]\nmeaning = \"m\"\ntrace = \"/s.x > 2\"\n",
    );
    write(
        "topics.toml",
        &format!("[\"/s.x\"]\nfrom = \"/a.x\"\n{staleness}"),
    );
}

/// Watches the script for 1.5 s and gives the lines that were kept.
fn watched(staleness: &str, coming: &[(i64, f64)]) -> (tempfile::TempDir, Vec<serde_json::Value>) {
    let folder = tempfile::tempdir().expect("a folder");
    study(folder.path(), staleness);
    let out = folder.path().join("runs");
    let system = LiveSystem::Dds {
        domain: 0,
        networks: Vec::new(),
    };
    let request = WatchRequest {
        limit: Some(Duration::from_millis(1500)),
        out: Some(out.clone()),
        ..WatchRequest::new(folder.path(), system)
    };
    let setting = Host::silent(host::BuildId::new("test"));
    let study = Study::load(folder.path()).expect("a study");
    let judges = judges(&study, &[]).expect("judges");
    let map = topic_map(&study, &request).expect("a map");
    let signals: Vec<String> = judges.signals().into_iter().collect();
    let asked = Asked {
        request: &request,
        judges: &judges,
        map: &map,
        signals: &signals,
    };
    let source = Script::new(coming);
    attached(&asked, &setting, source, None, Box::new(NoAudience)).expect("watched");
    let lines = only_file(&out.join("events"));
    let lines = std::fs::read_to_string(lines).expect("events");
    let lines = lines
        .lines()
        .map(|line| serde_json::from_str(line).expect("JSON"));
    let lines = lines.collect();
    (folder, lines)
}

fn only_file(folder: &Path) -> std::path::PathBuf {
    let mut files = std::fs::read_dir(folder).expect("a folder");
    files.next().expect("a file").expect("readable").path()
}

/// A subject's name and its verdict.
type Said = (String, String);

/// What was told while it ran, and at the end.
fn said(lines: &[serde_json::Value]) -> (Vec<Said>, Vec<Said>) {
    let pair = |it: &serde_json::Value| {
        let text = |key: &str| it[key].as_str().unwrap_or_default().to_owned();
        (text("subject"), text("verdict"))
    };
    let told = lines.iter().filter(|line| line["event"] == "verdict");
    let end = lines.last().expect("an end");
    let at_end = end["verdicts"].as_array().expect("verdicts");
    (told.map(pair).collect(), at_end.iter().map(pair).collect())
}

fn judged_again(folder: &Path) -> Vec<Said> {
    let study = Study::load(folder).expect("a study");
    let judges = judges(&study, &[]).expect("judges");
    let rules = ReadingRules::of_study(folder, None).expect("rules");
    let path = only_file(&folder.join("runs/recordings"));
    let judged = rules.judge(&judges, &path, &|| Ok(())).expect("judged");
    let pairs = judged.judgements.iter().map(LiveVerdict::of);
    pairs
        .map(|it| (it.subject, it.verdict.to_string()))
        .collect()
}

fn pairs(of: &[(&str, &str)]) -> Vec<Said> {
    let owned = of.iter().map(|(a, b)| ((*a).to_owned(), (*b).to_owned()));
    owned.collect()
}

#[test]
fn a_publisher_that_falls_silent_misses_its_deadline_while_all_is_silent() {
    let (folder, lines) = watched("", &[(0, 0.0), (100, 1.5)]);
    let (told, at_end) = said(&lines);
    let missed = [("formula", "violated"), ("stages", "violated")];
    assert_eq!(told, pairs(&missed));
    assert_eq!(at_end[..2], pairs(&missed)[..]);
    // The deadline is 300 ms behind the second message: long before the end.
    let at = |event: &str| {
        let found = lines.iter().find(|line| line["event"] == event);
        found
            .and_then(|line| line["unix_secs"].as_f64())
            .expect("told")
    };
    assert!(at("end") - at("verdict") > 0.0);
    let decided = lines.iter().find(|line| line["event"] == "verdict");
    let decided = decided.and_then(|line| line["decided_at_secs"].as_f64());
    assert!(decided.expect("a time") < 1.5, "{decided:?}");
    assert_eq!(judged_again(folder.path()), at_end);
}

#[test]
fn an_answer_in_time_is_no_violation_however_long_the_silence_after_it() {
    let coming = [(0, 0.0), (100, 1.5), (200, 3.0), (250, 0.0)];
    let (folder, lines) = watched("", &coming);
    let (told, at_end) = said(&lines);
    assert_eq!(told, pairs(&[("open", "satisfied")]));
    assert!(
        at_end.iter().all(|(_, verdict)| verdict == "satisfied"),
        "{at_end:?}"
    );
    assert_eq!(judged_again(folder.path()), at_end);
}

/// What was too old when the deadline passed is not known, so nobody can say
/// that it was missed.
#[test]
fn a_value_that_is_too_old_does_not_miss_a_deadline() {
    let staleness = "staleness = \"150 ms\"\n";
    let (folder, lines) = watched(staleness, &[(0, 0.0), (100, 1.5)]);
    let (told, at_end) = said(&lines);
    // Not even when all is over: from 250 ms on nobody knows.
    assert_eq!(told, []);
    assert_eq!(judged_again(folder.path()), at_end);
}
