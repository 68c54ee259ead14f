//! Against peers that are not ours: Eclipse Cyclone DDS and the Foxglove SDK, both from Python. `tests/live/run` sets
//! them up in a network of their own, with or without loss, and runs these tests with
//!
//! * `LIVE_PEER_PYTHON`: the words of a command that runs Python with the peers' packages,
//! * `LIVE_PEER_HOST`: the address at which a peer's server is reached,
//! * `LIVE_SECONDS`: for how long messages are sent,
//! * `LIVE_LOSSY`: set if the network loses datagrams.

use live::dds::{self, DdsOptions, DdsPublisher};
use live::foxglove::{self, FoxgloveOptions};
use live::{Event, Incoming, LiveStream, Message, Outgoing, Publisher, Source, TopicFilter};
use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::time::{Duration, Instant};

const SHORTLY: Duration = Duration::from_millis(20);
const RATE: u64 = 1000;

/// A peer in a process of its own; it is ended with the test.
struct Peer {
    child: Child,
    input: ChildStdin,
    output: BufReader<ChildStdout>,
}

impl Peer {
    /// Starts a script of `tests/live` and waits until it is ready.
    fn start(script: &str, arguments: &[String]) -> Self {
        let python = std::env::var("LIVE_PEER_PYTHON").expect("run by tests/live/run");
        let mut words = python.split_whitespace();
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/live");
        let mut child = Command::new(words.next().expect("a command"))
            .args(words)
            .arg(folder.join(script))
            .args(arguments)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("the peer starts");
        let input = child.stdin.take().expect("piped");
        let output = BufReader::new(child.stdout.take().expect("piped"));
        let mut peer = Self {
            child,
            input,
            output,
        };
        assert_eq!(peer.line(), "ready");
        peer
    }

    /// The next line that it says.
    fn line(&mut self) -> String {
        let mut line = String::new();
        self.output.read_line(&mut line).expect("it speaks");
        line.trim().to_owned()
    }

    /// How many messages it says it sent.
    fn sent(&mut self) -> u64 {
        let line = self.line();
        let count = line.strip_prefix("sent ").expect("it says what it sent");
        count.parse().expect("a number")
    }

    fn go_on(&mut self) {
        writeln!(self.input).expect("it listens");
    }

    fn signal(&self, name: &str) {
        let status = Command::new("kill")
            .args([&format!("-{name}"), &self.child.id().to_string()])
            .status();
        assert!(status.expect("kill runs").success());
    }
}

impl Drop for Peer {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn seconds() -> u64 {
    let text = std::env::var("LIVE_SECONDS").unwrap_or_else(|_| "10".to_owned());
    text.parse().expect("LIVE_SECONDS is a number")
}

fn lossy() -> bool {
    std::env::var("LIVE_LOSSY").is_ok()
}

fn joint_states(domain: u16, seconds: u64, best_effort: bool) -> Peer {
    let mut arguments = vec![
        format!("--domain={domain}"),
        format!("--rate={RATE}"),
        format!("--seconds={seconds}"),
    ];
    if best_effort {
        arguments.push("--best-effort".to_owned());
    }
    Peer::start("cyclone_publisher.py", &arguments)
}

fn listen(domain: u16) -> LiveStream {
    let options = DdsOptions {
        domain,
        ..DdsOptions::default()
    };
    dds::connect(&options, TopicFilter::new(&["/joint_states"], &[])).expect("joined")
}

/// The number of a joint state: the position of its first joint. All that was sent is checked.
fn number_of(message: &Message) -> u64 {
    let mut reader = Cdr {
        data: &message.data[4..],
        at: 8,
    };
    assert_eq!(reader.text(), "base");
    for k in 0..reader.count() {
        assert_eq!(reader.text(), format!("joint_{k}"));
    }
    let positions = reader.doubles();
    assert_eq!(positions.len(), 7);
    for (k, position) in positions.iter().enumerate() {
        assert_eq!(*position, positions[0] + k as f64 / 1000.0);
    }
    assert_eq!(reader.doubles(), [0.0; 7]);
    assert_eq!(reader.doubles().len(), 0);
    positions[0] as u64
}

/// Just enough of little-endian CDR for joint states.
struct Cdr<'a> {
    data: &'a [u8],
    at: usize,
}

impl Cdr<'_> {
    fn count(&mut self) -> usize {
        self.at = self.at.next_multiple_of(4);
        let bytes = self.data[self.at..self.at + 4].try_into();
        self.at += 4;
        u32::from_le_bytes(bytes.expect("four")) as usize
    }

    fn text(&mut self) -> String {
        let length = self.count();
        let bytes = &self.data[self.at..self.at + length - 1];
        self.at += length;
        String::from_utf8(bytes.to_vec()).expect("text")
    }

    fn doubles(&mut self) -> Vec<f64> {
        let count = self.count();
        if count == 0 {
            return Vec::new();
        }
        self.at = self.at.next_multiple_of(8);
        let bytes = &self.data[self.at..self.at + 8 * count];
        self.at += 8 * count;
        bytes
            .chunks_exact(8)
            .map(|chunk| f64::from_le_bytes(chunk.try_into().expect("eight")))
            .collect()
    }
}

/// What was seen of a stream.
#[derive(Default)]
struct Seen {
    received: u64,
    lost: u64,
    sent_before: u64,
    first: u64,
    last: u64,
    latencies_nanos: Vec<i64>,
    disconnected: u64,
    reconnected: u64,
}

impl Seen {
    /// Takes what comes until `done`.
    fn take_until(
        &mut self,
        source: &mut LiveStream,
        number: fn(&Message) -> u64,
        mut done: impl FnMut(&Self) -> bool,
    ) {
        while !done(self) {
            match source.next(SHORTLY).expect("listening") {
                Some(Incoming::Message(message)) => self.message(&message, number(&message)),
                Some(Incoming::Event { event, .. }) => self.event(&event),
                None => {}
            }
        }
    }

    fn message(&mut self, message: &Message, number: u64) {
        self.received += 1;
        if self.first == 0 {
            self.first = number;
        }
        self.last = number;
        let published = message.publish_nanos.expect("it stamps");
        self.latencies_nanos
            .push(message.received_nanos - published);
    }

    fn event(&mut self, event: &Event) {
        match event {
            Event::Lost { count, .. } => self.lost += count,
            Event::PublisherJoined { sent_before, .. } => self.sent_before += sent_before,
            Event::TopicAppeared { topic } => println!("{}: {:?}", topic.name, topic.qos),
            Event::Disconnected { .. } => self.disconnected += 1,
            Event::Reconnected { .. } => self.reconnected += 1,
            _ => {}
        }
    }

    /// Every message is accounted for, up to the last that arrived.
    fn assert_adds_up(&self, last: u64) {
        assert_eq!(self.received + self.lost + self.sent_before, last);
    }

    fn report(&mut self, what: &str, cost: &Cost) {
        assert!(self.received > 0, "{what}: nothing arrived");
        self.latencies_nanos.sort_unstable();
        let at = |share: f64| {
            let place = (self.latencies_nanos.len() - 1) as f64 * share;
            self.latencies_nanos[place as usize] as f64 / 1000.0
        };
        println!(
            "{what}: received {}, lost {}, before joining {}; latency p50 {:.0} us, p99 {:.0} us, max {:.0} us; {:.1} % of a core",
            self.received,
            self.lost,
            self.sent_before,
            at(0.5),
            at(0.99),
            at(1.0),
            cost.percent()
        );
    }
}

/// The processor time of this process over a while.
struct Cost {
    start: Instant,
    start_ticks: u64,
}

impl Cost {
    fn start() -> Self {
        Self {
            start: Instant::now(),
            start_ticks: ticks(),
        }
    }

    /// Of one core. The kernel counts in hundredths of a second.
    fn percent(&self) -> f64 {
        (ticks() - self.start_ticks) as f64 / self.start.elapsed().as_secs_f64()
    }
}

fn ticks() -> u64 {
    let stat = std::fs::read_to_string("/proc/self/stat").expect("Linux");
    let (_, behind_name) = stat.rsplit_once(')').expect("a name");
    let fields: Vec<&str> = behind_name.split_whitespace().collect();
    let field = |n: usize| fields[n].parse::<u64>().expect("a number");
    field(11) + field(12)
}

#[test]
#[ignore = "needs a peer: tests/live/run"]
fn reliable_joint_states_arrive_all_and_in_order_whatever_the_network_loses() {
    let mut source = listen(1);
    let mut peer = joint_states(1, seconds(), false);
    let cost = Cost::start();
    let mut seen = Seen::default();
    let last = RATE * seconds();
    seen.take_until(&mut source, number_of, |seen| {
        seen.last == last || seen.disconnected > 0
    });
    seen.report("Cyclone DDS, reliable", &cost);
    assert_eq!(peer.sent(), last);
    assert_eq!(seen.last, last);
    seen.assert_adds_up(last);
    assert_eq!(seen.lost, 0);
    assert_eq!(seen.received, last - seen.first + 1);
}

#[test]
#[ignore = "needs a peer: tests/live/run"]
fn best_effort_joint_states_are_counted_when_they_do_not_arrive() {
    let mut source = listen(2);
    let mut peer = joint_states(2, seconds(), true);
    let cost = Cost::start();
    let mut seen = Seen::default();
    seen.take_until(&mut source, number_of, |seen| seen.disconnected > 0);
    seen.report("Cyclone DDS, best effort", &cost);
    let sent = peer.sent();
    seen.assert_adds_up(seen.last);
    // The last few may be lost, and nothing came after them to show it.
    assert!(sent - seen.last < 20, "{} of {sent}", seen.last);
    let share = seen.lost as f64 / (seen.lost + seen.received) as f64;
    if lossy() {
        assert!(share > 0.02 && share < 0.10, "lost {share}, not about 0.05");
    } else {
        assert_eq!(seen.lost, 0);
    }
}

#[test]
#[ignore = "needs a peer: tests/live/run"]
fn a_robot_that_is_killed_and_started_again_is_listened_to_again() {
    let mut source = listen(3);
    let mut seen = Seen::default();
    let peer = joint_states(3, 600, false);
    seen.take_until(&mut source, number_of, |seen| seen.last >= 3000);
    seen.assert_adds_up(seen.last);
    peer.signal("KILL");
    seen.take_until(&mut source, number_of, |seen| seen.disconnected == 1);
    assert_eq!(seen.lost, 0);
    drop(peer);
    let mut again = joint_states(3, 3, false);
    let mut second = Seen::default();
    second.take_until(&mut source, number_of, |seen| seen.last == 3000);
    assert_eq!(again.sent(), 3000);
    assert_eq!((second.reconnected, second.lost), (1, 0));
    second.assert_adds_up(3000);
    println!(
        "killed and started again: {} then {} received, none lost",
        seen.received, second.received
    );
}

#[test]
#[ignore = "needs a peer: tests/live/run"]
fn a_robot_that_stands_still_for_long_comes_back_and_nothing_goes_uncounted() {
    let mut source = listen(4);
    let mut seen = Seen::default();
    let mut peer = joint_states(4, 12, true);
    seen.take_until(&mut source, number_of, |seen| seen.last >= 2000);
    peer.signal("STOP");
    seen.take_until(&mut source, number_of, |seen| seen.disconnected == 1);
    peer.signal("CONT");
    seen.take_until(&mut source, number_of, |seen| seen.disconnected == 2);
    assert_eq!(peer.sent(), 12_000);
    assert_eq!(seen.reconnected, 1);
    seen.assert_adds_up(seen.last);
    println!(
        "stopped and continued: {} received, {} counted as lost",
        seen.received, seen.lost
    );
}

#[test]
#[ignore = "needs a peer: tests/live/run"]
fn what_we_publish_is_taken_by_the_peer_completely_and_in_order() {
    let options = DdsOptions {
        domain: 5,
        ..DdsOptions::default()
    };
    let mut publisher = DdsPublisher::new(&options).expect("joined");
    let topic = Outgoing::ros2("/bench/count", "std_msgs/msg/UInt32");
    let publication = publisher.advertise(&topic).expect("advertised");
    let last = 5 * RATE;
    let mut peer = Peer::start(
        "cyclone_subscriber.py",
        &["--domain=5".to_owned(), format!("--last={last}")],
    );
    while publisher.readers("/bench/count") == 0 {
        std::thread::sleep(SHORTLY);
    }
    let start = Instant::now();
    for number in 1..=last {
        let mut data = vec![0, 1, 0, 0];
        data.extend_from_slice(&u32::try_from(number).expect("small").to_le_bytes());
        let stamp = i64::try_from(number).expect("small");
        publisher
            .publish(publication, stamp, &data)
            .expect("published");
        let due = Duration::from_micros(number * 1_000_000 / RATE);
        std::thread::sleep(due.saturating_sub(start.elapsed()));
    }
    let line = peer.line();
    println!("our publisher to Cyclone DDS: {line}");
    let words: Vec<&str> = line.split_whitespace().collect();
    let number = |at: usize| words[at].parse::<u64>().expect("a number");
    assert_eq!((words[0], words[8 - 1]), ("got", "order"));
    assert_eq!(number(5), last);
    assert_eq!(number(1), last - number(3) + 1);
    assert!(number(3) < RATE, "joined late: {line}");
}

/// The number in `{"n": number, …}`.
fn number_in_json(message: &Message) -> u64 {
    let text = std::str::from_utf8(&message.data).expect("text");
    let (_, behind) = text.split_once("\"n\":").expect("the member n");
    let digits: String = behind
        .trim_start()
        .chars()
        .take_while(char::is_ascii_digit)
        .collect();
    digits.parse().expect("a number")
}

#[test]
#[ignore = "needs a peer: tests/live/run"]
fn a_foxglove_server_is_listened_to_and_again_after_it_was_killed() {
    let host = std::env::var("LIVE_PEER_HOST").expect("run by tests/live/run");
    let arguments = |seconds: u64| {
        vec![
            "--port=18765".to_owned(),
            format!("--rate={RATE}"),
            format!("--seconds={seconds}"),
        ]
    };
    let mut peer = Peer::start("foxglove_server.py", &arguments(seconds()));
    let url = format!("ws://{host}:18765");
    let mut source =
        foxglove::connect(&url, TopicFilter::all(), &FoxgloveOptions::default()).expect("reached");
    while source.topics().is_empty() {
        std::thread::sleep(SHORTLY);
    }
    std::thread::sleep(Duration::from_secs(1));
    let cost = Cost::start();
    peer.go_on();
    let mut seen = Seen::default();
    let last = RATE * seconds();
    seen.take_until(&mut source, number_in_json, |seen| seen.last == last);
    assert_eq!(peer.sent(), last);
    seen.report("Foxglove SDK", &cost);
    assert_eq!((seen.first, seen.received, seen.lost), (1, last, 0));
    peer.signal("KILL");
    seen.take_until(&mut source, number_in_json, |seen| seen.disconnected == 1);
    drop(peer);
    let mut again = Peer::start("foxglove_server.py", &arguments(3));
    // The connection and then the topic.
    seen.take_until(&mut source, number_in_json, |seen| seen.reconnected == 2);
    std::thread::sleep(Duration::from_secs(1));
    again.go_on();
    let mut second = Seen::default();
    second.take_until(&mut source, number_in_json, |seen| seen.last == 3 * RATE);
    assert_eq!((second.first, second.received), (1, 3 * RATE));
    again.go_on();
}
