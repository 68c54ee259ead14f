use super::*;
use crate::Origin;

fn queue(messages: usize, bytes: usize) -> Queue {
    Queue::new(QueueLimits { messages, bytes }, Clock::start())
}

fn topic(queue: &Queue, name: &str) -> Arc<Topic> {
    queue.add_topic(|id| Topic {
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

fn message(topic: &Arc<Topic>, received_nanos: i64, bytes: usize) -> Message {
    Message {
        topic: topic.clone(),
        publish_nanos: None,
        received_nanos,
        sequence: None,
        data: vec![0; bytes],
    }
}

fn pop(queue: &Queue) -> Option<Incoming> {
    queue.pop(Duration::ZERO).expect("not ended")
}

fn lost(item: Option<Incoming>) -> (String, u64, LossCause) {
    match item {
        Some(Incoming::Event {
            event:
                Event::Lost {
                    topic: Some(topic),
                    count,
                    cause,
                },
            ..
        }) => (topic.name.clone(), count, cause),
        other => panic!("expected a loss, got {other:?}"),
    }
}

#[test]
fn what_does_not_fit_is_counted_where_it_is_missing() {
    let queue = queue(2, 1000);
    let (a, b) = (topic(&queue, "/a"), topic(&queue, "/b"));
    for nanos in 1..=4 {
        queue.push_message(message(&a, nanos, 1));
    }
    queue.push_message(message(&b, 5, 1));
    assert!(matches!(pop(&queue), Some(Incoming::Message(m)) if m.received_nanos == 1));
    queue.push_message(message(&a, 6, 1));
    assert!(matches!(pop(&queue), Some(Incoming::Message(m)) if m.received_nanos == 2));
    assert_eq!(lost(pop(&queue)), ("/a".into(), 2, LossCause::Overflow));
    assert_eq!(lost(pop(&queue)), ("/b".into(), 1, LossCause::Overflow));
    assert!(matches!(pop(&queue), Some(Incoming::Message(m)) if m.received_nanos == 6));
    assert!(pop(&queue).is_none());
    let totals = queue.totals();
    assert_eq!((totals.received, totals.lost_overflow), (3, 3));
}

#[test]
fn losses_at_the_end_are_told_without_a_further_message() {
    let queue = queue(1, 1000);
    let a = topic(&queue, "/a");
    queue.push_message(message(&a, 1, 1));
    queue.push_message(message(&a, 2, 1));
    assert!(matches!(pop(&queue), Some(Incoming::Message(_))));
    assert_eq!(lost(pop(&queue)).1, 1);
    assert!(pop(&queue).is_none());
}

#[test]
fn bytes_are_bounded_but_one_message_always_fits() {
    let queue = queue(100, 10);
    let a = topic(&queue, "/a");
    queue.push_message(message(&a, 1, 50));
    queue.push_message(message(&a, 2, 1));
    assert_eq!(queue.totals().lost_overflow, 1);
    pop(&queue);
    pop(&queue);
    queue.push_message(message(&a, 3, 5));
    queue.push_message(message(&a, 4, 5));
    queue.push_message(message(&a, 5, 1));
    assert_eq!(queue.totals().received, 3);
    assert_eq!(queue.totals().lost_overflow, 2);
}

#[test]
fn times_of_arrival_never_go_back() {
    let queue = queue(10, 100);
    let a = topic(&queue, "/a");
    queue.push_message(message(&a, 10, 1));
    queue.push_message(message(&a, 5, 1));
    pop(&queue);
    assert!(matches!(pop(&queue), Some(Incoming::Message(m)) if m.received_nanos == 10));
}

#[test]
fn the_end_comes_after_what_was_received_and_the_first_reason_counts() {
    let queue = queue(10, 100);
    let a = topic(&queue, "/a");
    queue.push_message(message(&a, 1, 1));
    queue.end(LiveError::Transport("first".into()));
    queue.end(LiveError::Transport("second".into()));
    assert!(matches!(pop(&queue), Some(Incoming::Message(_))));
    for _ in 0..2 {
        let end = queue.pop(Duration::from_secs(60));
        assert_eq!(end, Err(LiveError::Transport("first".into())));
    }
}

#[test]
fn events_are_bounded_and_counted_beyond() {
    let queue = queue(10, 100);
    for _ in 0..EVENTS_AT_MOST + 3 {
        let text = "x".into();
        queue.push_event(Event::Notice { text });
    }
    for _ in 0..EVENTS_AT_MOST {
        assert!(pop(&queue).is_some());
    }
    let told = pop(&queue);
    assert!(
        matches!(&told, Some(Incoming::Event { event: Event::Notice { text }, .. })
            if text.starts_with("3 events")),
        "{told:?}"
    );
}
