use super::*;
use crate::{Bridge, Clock, LossCause, Origin, Publisher, Source, Totals};
use std::collections::VecDeque;
use std::sync::Mutex;

/// An outside that was scripted.
struct Script {
    clock: Clock,
    topics: Vec<Arc<Topic>>,
    coming: VecDeque<Incoming>,
}

impl Source for Script {
    fn next(&mut self, _: Duration) -> Result<Option<Incoming>, LiveError> {
        Ok(self.coming.pop_front())
    }
    fn topics(&self) -> Vec<Arc<Topic>> {
        self.topics.clone()
    }
    fn totals(&self) -> Totals {
        Totals::default()
    }
    fn clock(&self) -> Clock {
        self.clock
    }
    fn stop(&mut self) {}
}

/// Messages, each with the number of its topic.
type Messages = Arc<Mutex<Vec<(usize, Vec<u8>)>>>;

/// Keeps what is sent.
struct Kept(Messages, usize);

impl Publisher for Kept {
    fn advertise(&mut self, _: &Outgoing) -> Result<PublicationId, LiveError> {
        self.1 += 1;
        Ok(PublicationId(self.1 - 1))
    }
    fn publish(&mut self, id: PublicationId, _: i64, data: &[u8]) -> Result<(), LiveError> {
        let mut sent = self.0.lock().expect("no panic elsewhere");
        sent.push((id.0, data.to_vec()));
        Ok(())
    }
}

fn outside_topic(id: u32, name: &str) -> Arc<Topic> {
    Arc::new(Topic {
        id,
        name: name.into(),
        type_name: "t".into(),
        encoding: "cdr".into(),
        schema: None,
        qos: None,
        type_hash: None,
        origin: Origin::Outside,
        numbered: true,
    })
}

/// Events and messages as they stand in the stream, until its end.
fn told(stream: &mut LiveStream) -> Vec<String> {
    let mut told = Vec::new();
    loop {
        match stream.next(Duration::from_secs(60)) {
            Ok(Some(Incoming::Message(m))) => {
                told.push(format!("{} {} {:?}", m.topic.id, m.topic.name, m.data));
            }
            Ok(Some(Incoming::Event { event, .. })) => told.push(match event {
                Event::TopicAppeared { topic } => format!("appeared {} {}", topic.id, topic.name),
                Event::Lost {
                    topic: Some(topic),
                    count,
                    ..
                } => format!("lost {count} {} {}", topic.id, topic.name),
                other => format!("{other:?}"),
            }),
            Ok(None) => {}
            Err(error) => {
                told.push(format!("{error:?}"));
                return told;
            }
        }
    }
}

#[test]
fn both_sides_stand_in_one_stream_under_numbers_of_their_own() {
    let clock = Clock::start();
    let (a, b) = (outside_topic(0, "/a"), outside_topic(1, "/b"));
    let message = |topic: &Arc<Topic>, byte| {
        Incoming::Message(Message {
            topic: topic.clone(),
            publish_nanos: None,
            received_nanos: clock.now_nanos(),
            sequence: None,
            data: vec![byte],
        })
    };
    let event = |event| Incoming::Event { at_nanos: 0, event };
    let coming = VecDeque::from([
        // The second topic is told of first.
        event(Event::TopicAppeared { topic: b.clone() }),
        message(&b, 1),
        event(Event::Lost {
            topic: Some(a.clone()),
            count: 2,
            cause: LossCause::Transport,
        }),
        message(&a, 2),
    ]);
    let topics = vec![a, b];
    let source = Script {
        clock,
        topics,
        coming,
    };
    let sent = Arc::new(Mutex::new(Vec::new()));
    let bridge = Bridge::new(Box::new(source), Box::new(Kept(sent.clone(), 0)));
    let outgoing = ["/bench/x", "/bench/y"].map(|name| Outgoing::ros2(name, "t"));
    let mut stream = LiveStream::of_bench(bridge, &outgoing, |feed, ids| {
        feed.publish(ids[1], vec![9])?;
        feed.listen(Duration::ZERO)?;
        feed.start(0, 0);
        feed.advance(1)?;
        feed.publish(ids[0], vec![8])?;
        assert_eq!(feed.punctuality().steps, 1);
        Ok("done".into())
    })
    .expect("a thread");
    assert_eq!(
        told(&mut stream),
        [
            "appeared 0 /bench/x",
            "appeared 1 /bench/y",
            "1 /bench/y [9]",
            "appeared 2 /b",
            "2 /b [1]",
            "lost 2 3 /a",
            "3 /a [2]",
            "0 /bench/x [8]",
            "Ended(\"done\")",
        ]
    );
    let topics = stream.topics();
    let ids: Vec<u32> = topics.iter().map(|topic| topic.id).collect();
    assert_eq!(ids, [0, 1, 2, 3]);
    assert_eq!(stream.totals().lost_transport, 2);
    let sent = sent.lock().expect("no panic elsewhere").clone();
    assert_eq!(sent, [(1, vec![9]), (0, vec![8])]);
}

#[test]
fn a_bench_that_fails_ends_the_stream_with_its_error() {
    let source = Script {
        clock: Clock::start(),
        topics: Vec::new(),
        coming: VecDeque::new(),
    };
    let bridge = Bridge::new(Box::new(source), Box::new(Kept(Arc::default(), 0)));
    let fail = |_: &mut BridgeFeed, _: &[PublicationId]| Err(LiveError::Transport("broken".into()));
    let mut stream = LiveStream::of_bench(bridge, &[], fail).expect("a thread");
    assert_eq!(told(&mut stream), ["Transport(\"broken\")"]);
}

/// A bridge with one topic of its own to an outside that says `byte`s, each stamped `nanos` before now.
fn bridge_with_waiting(waiting: &[(u8, i64)]) -> (Bridge, PublicationId) {
    let clock = Clock::start();
    let now = clock.now_nanos();
    let message = |&(byte, nanos_ago): &(u8, i64)| {
        Incoming::Message(Message {
            topic: outside_topic(0, "/a"),
            publish_nanos: None,
            received_nanos: now - nanos_ago,
            sequence: None,
            data: vec![byte],
        })
    };
    let script = Script {
        clock,
        topics: Vec::new(),
        coming: waiting.iter().map(message).collect(),
    };
    let mut bridge = Bridge::new(Box::new(script), Box::new(Kept(Messages::default(), 0)));
    let command = bridge
        .advertise(&Outgoing::ros2("/command", "t"))
        .expect("advertised");
    (bridge, command)
}

#[test]
fn times_do_not_go_back_where_an_arrival_was_stamped_before_a_publication() {
    let (mut bridge, command) = bridge_with_waiting(&[(1, 1_000_000)]);
    let mut times = Vec::new();
    let mut take = |incoming| {
        if let Incoming::Message(message) = incoming {
            times.push(message.received_nanos);
        }
    };
    bridge
        .publish(command, vec![9], &mut take)
        .expect("published");
    bridge.listen(Duration::ZERO, &mut take).expect("listening");
    assert_eq!(times.len(), 2);
    assert_eq!(
        times[1], times[0],
        "the arrival stands behind the publication"
    );
}

#[test]
fn a_late_bench_that_publishes_is_still_given_all_that_waits() {
    let waiting: Vec<(u8, i64)> = (0..50).map(|byte| (byte, 1_000_000)).collect();
    let (mut bridge, command) = bridge_with_waiting(&waiting);
    bridge.start(0, 0);
    let mut count = 0;
    let mut take = |incoming| {
        count += usize::from(matches!(incoming, Incoming::Message(_)));
    };
    bridge
        .publish(command, vec![9], &mut take)
        .expect("published");
    // Due before the bench began, so it is late; the arrivals are older still.
    bridge.advance(-500_000, &mut take).expect("listening");
    assert_eq!(count, 51);
}
