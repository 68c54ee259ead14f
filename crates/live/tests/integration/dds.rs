//! Our publisher to our listener, through the network stack of this machine. Each test has a domain of its own.
//!
//! Waiting has no limit: a test that would have to give up would fail on a slow machine alone.

use live::dds::{self, DdsOptions, DdsPublisher};
use live::{
    Bridge, Durability, Event, Incoming, LiveError, LiveStream, Message, Origin, Outgoing,
    PublicationId, Publisher, Source, TopicFilter,
};
use std::time::Duration;

const SHORTLY: Duration = Duration::from_millis(20);

fn options(domain: u16) -> DdsOptions {
    DdsOptions {
        domain,
        ..DdsOptions::default()
    }
}

/// A message of CDR whose body is `number`.
fn numbered(number: u32) -> Vec<u8> {
    let mut data = vec![0, 1, 0, 0];
    data.extend_from_slice(&number.to_le_bytes());
    data
}

fn number_of(message: &Message) -> u32 {
    assert_eq!(message.data[..4], [0, 1, 0, 0]);
    u32::from_le_bytes(message.data[4..].try_into().expect("four bytes"))
}

/// Publishes zeros until one arrives; gives the events before it.
fn warm_up(
    publisher: &mut DdsPublisher,
    publication: PublicationId,
    source: &mut LiveStream,
) -> Vec<Event> {
    let mut events = Vec::new();
    loop {
        publisher
            .publish(publication, 1, &numbered(0))
            .expect("published");
        match source.next(SHORTLY).expect("listening") {
            Some(Incoming::Message(_)) => return events,
            Some(Incoming::Event { event, .. }) => events.push(event),
            None => {}
        }
    }
}

/// The next message, skipping events into `events`.
fn next_message(source: &mut LiveStream, events: &mut Vec<Event>) -> Message {
    loop {
        match source.next(SHORTLY).expect("listening") {
            Some(Incoming::Message(message)) => return message,
            Some(Incoming::Event { event, .. }) => events.push(event),
            None => {}
        }
    }
}

#[test]
fn messages_arrive_unchanged_in_order_with_their_stamps_and_a_publisher_may_come_back() {
    let filter = TopicFilter::new(&["/robot/*"], &["*/unwanted"]);
    let mut source = dds::connect(&options(101), filter).expect("joined");
    let topic = Outgoing::ros2("/robot/count", "std_msgs/msg/UInt32");
    for round in 0..2 {
        let mut publisher = DdsPublisher::new(&options(101)).expect("joined");
        let other = Outgoing::ros2("/robot/unwanted", "std_msgs/msg/UInt32");
        let unwanted = publisher.advertise(&other).expect("advertised");
        let publication = publisher.advertise(&topic).expect("advertised");
        let mut events = warm_up(&mut publisher, publication, &mut source);
        if round == 0 {
            assert_appeared(&events);
        }
        for number in 1..=500 {
            let stamp = 1_700_000_000_000_000_000 + i64::from(number);
            publisher
                .publish(publication, stamp, &numbered(number))
                .expect("published");
            publisher
                .publish(unwanted, stamp, &numbered(number))
                .expect("published");
        }
        assert_arrive(&mut source, &mut events);
        drop(publisher);
        wait_for_silence(&mut source);
    }
    assert_eq!(source.topics().len(), 1);
    assert_eq!(source.totals().lost(), 0);
    source.stop();
    assert!(matches!(source.next(SHORTLY), Err(LiveError::Transport(_))));
}

fn assert_appeared(events: &[Event]) {
    assert!(matches!(&events[0], Event::Connected { to } if to == "DDS domain 101"));
    let appeared: Vec<_> = events
        .iter()
        .filter_map(|event| match event {
            Event::TopicAppeared { topic } => Some(topic),
            _ => None,
        })
        .collect();
    assert_eq!(appeared.len(), 1);
    assert_eq!(appeared[0].name, "/robot/count");
    assert_eq!(appeared[0].type_name, "std_msgs/msg/UInt32");
    assert_eq!(appeared[0].encoding, "cdr");
    assert!(appeared[0].numbered);
}

/// The numbers 1 to 500 arrive in order, after zeros of the warming up.
fn assert_arrive(source: &mut LiveStream, events: &mut Vec<Event>) {
    let mut expected = 1;
    let mut last_received = 0;
    while expected <= 500 {
        let message = next_message(source, events);
        let number = number_of(&message);
        assert!(message.received_nanos >= last_received);
        last_received = message.received_nanos;
        if number > 0 {
            assert_eq!(number, expected);
            let stamp = 1_700_000_000_000_000_000 + i64::from(number);
            assert_eq!(message.publish_nanos, Some(stamp));
            expected += 1;
        }
    }
    let lost = events
        .iter()
        .any(|event| matches!(event, Event::Lost { .. }));
    assert!(!lost, "{events:?}");
}

/// Waits until it is said that nobody publishes the topic any more.
fn wait_for_silence(source: &mut LiveStream) {
    loop {
        let next = source.next(SHORTLY).expect("listening");
        if let Some(Incoming::Event { event, .. }) = next
            && matches!(event, Event::Disconnected { topic: Some(_), .. })
        {
            return;
        }
    }
}

#[test]
fn what_was_latched_is_had_by_those_who_come_later() {
    let mut publisher = DdsPublisher::new(&options(102)).expect("joined");
    let mut topic = Outgoing::ros2("/map_name", "std_msgs/msg/UInt32");
    topic.latched = true;
    let publication = publisher.advertise(&topic).expect("advertised");
    publisher
        .publish(publication, 77, &numbered(7))
        .expect("published");
    let mut source = dds::connect(&options(102), TopicFilter::all()).expect("joined");
    let message = next_message(&mut source, &mut Vec::new());
    assert_eq!((number_of(&message), message.publish_nanos), (7, Some(77)));
    let qos = message.topic.qos.expect("DDS says");
    assert_eq!(qos.durability, Durability::TransientLocal);
}

#[test]
fn what_cannot_be_published_is_refused_with_the_reason() {
    let mut publisher = DdsPublisher::new(&options(103)).expect("joined");
    let mut json = Outgoing::ros2("/x", "std_msgs/msg/UInt32");
    json.encoding = "json".into();
    assert!(matches!(
        publisher.advertise(&json),
        Err(LiveError::Unsupported(_))
    ));
    let topic = Outgoing::ros2("/x", "std_msgs/msg/UInt32");
    let publication = publisher.advertise(&topic).expect("advertised");
    let big_endian = [0, 0, 0, 0, 1];
    assert!(matches!(
        publisher.publish(publication, 0, &big_endian),
        Err(LiveError::Encoding(_))
    ));
    assert!(matches!(
        dds::connect(&options(233), TopicFilter::all()),
        Err(LiveError::Option(_))
    ));
}

/// A part of the robot (the "gripper", here another participant that answers) in the loop with a bench.
#[test]
fn a_bridge_gives_one_stream_of_both_sides() {
    let filter = TopicFilter::new(&["/gripper/*"], &[]);
    let source = dds::connect(&options(104), filter).expect("joined");
    let publisher = DdsPublisher::new(&options(104)).expect("joined");
    let gripper = std::thread::spawn(answer_fifty);
    let mut bridge = Bridge::new(Box::new(source), Box::new(publisher));
    let command = bridge
        .advertise(&Outgoing::ros2("/bench/command", "std_msgs/msg/UInt32"))
        .expect("advertised");
    let mut stream: Vec<Incoming> = Vec::new();
    bridge.start(0, 0);
    let mut step = 0;
    while !gripper.is_finished() {
        step += 1;
        let mut take = |incoming| stream.push(incoming);
        let late = bridge.advance(i64::from(step) * 2_000_000, &mut take);
        assert!(late.expect("listening") >= 0);
        bridge
            .publish(command, numbered(step), &mut take)
            .expect("published");
    }
    gripper.join().expect("the gripper answered");
    // What is still under way.
    bridge
        .advance(i64::from(step + 100) * 2_000_000, &mut |incoming| {
            stream.push(incoming);
        })
        .expect("listening");
    assert_one_stream(&stream, step);
    assert_eq!(bridge.punctuality().steps, u64::from(step) + 1);
    bridge.stop();
}

/// Answers commands with their number plus 1,000,000 until fifty answers were heard by somebody.
fn answer_fifty() {
    let filter = TopicFilter::new(&["/bench/command"], &[]);
    let mut source = dds::connect(&options(104), filter).expect("joined");
    let mut publisher = DdsPublisher::new(&options(104)).expect("joined");
    let topic = Outgoing::ros2("/gripper/state", "std_msgs/msg/UInt32");
    let publication = publisher.advertise(&topic).expect("advertised");
    let mut heard = 0;
    while heard < 50 {
        let message = next_message(&mut source, &mut Vec::new());
        let answer = numbered(number_of(&message) + 1_000_000);
        publisher
            .publish(publication, message.best_nanos(), &answer)
            .expect("published");
        heard += u32::from(publisher.readers("/gripper/state") > 0);
    }
}

/// Each answer stands behind the command that it answers, and times never go back.
fn assert_one_stream(stream: &[Incoming], steps: u32) {
    let mut commands = 0;
    let mut answers = 0;
    let mut last = 0;
    for incoming in stream {
        let Incoming::Message(message) = incoming else {
            continue;
        };
        assert!(message.received_nanos >= last);
        last = message.received_nanos;
        match message.topic.origin {
            Origin::TestBench => {
                commands += 1;
                assert_eq!(number_of(message), commands);
            }
            Origin::Outside => {
                answers += 1;
                assert!(number_of(message) - 1_000_000 <= commands);
            }
        }
    }
    assert_eq!(commands, steps);
    assert!(answers > 0, "no answer arrived");
}
