//! The client against a small server of this test, which is scripted: what it says, when it breaks off.

use live::foxglove::{self, FoxgloveOptions, FoxglovePublisher};
use live::{Event, Incoming, LiveError, LiveStream, Outgoing, Publisher, Source, TopicFilter};
use std::io::Write;
use std::net::{TcpListener, TcpStream};
use std::thread::JoinHandle;
use std::time::Duration;
use tungstenite::handshake::server::{Request, Response};
use tungstenite::http::HeaderValue;
use tungstenite::{Message as Frame, WebSocket};

const SHORTLY: Duration = Duration::from_millis(20);

const INFO: &str = r#"{"op":"serverInfo","name":"test","capabilities":["clientPublish"],"supportedEncodings":["json"]}"#;

/// One channel, `/count`, under the number `id`, and one that nobody wants.
fn advertise(id: u32) -> String {
    format!(
        r#"{{"op":"advertise","channels":[
            {{"id":{id},"topic":"/count","encoding":"json","schemaName":"Count","schemaEncoding":"jsonschema","schema":"{{}}"}},
            {{"id":99,"topic":"/other","encoding":"json","schemaName":"","schema":""}}]}}"#
    )
}

fn message(subscription: u32, nanos: u64, payload: &[u8]) -> Frame {
    let mut frame = vec![1];
    frame.extend_from_slice(&subscription.to_le_bytes());
    frame.extend_from_slice(&nanos.to_le_bytes());
    frame.extend_from_slice(payload);
    Frame::binary(frame)
}

/// Takes one client, which must ask for the protocol.
#[allow(clippy::result_large_err)] // The form of this callback is given.
fn accept(listener: &TcpListener) -> WebSocket<TcpStream> {
    let (stream, _) = listener.accept().expect("a client");
    let choose = |request: &Request, mut response: Response| {
        let asked = request.headers().get("Sec-WebSocket-Protocol");
        let asked = asked.and_then(|value| value.to_str().ok()).unwrap_or("");
        assert!(asked.split(", ").any(|one| one == "foxglove.websocket.v1"));
        response.headers_mut().insert(
            "Sec-WebSocket-Protocol",
            HeaderValue::from_static("foxglove.websocket.v1"),
        );
        Ok(response)
    };
    let mut socket = tungstenite::accept_hdr(stream, choose).expect("a handshake");
    socket.send(Frame::text(INFO)).expect("sent");
    socket
}

/// The next text of the client.
fn text(socket: &mut WebSocket<TcpStream>) -> String {
    loop {
        if let Frame::Text(text) = socket.read().expect("a frame") {
            return text.as_str().to_owned();
        }
    }
}

fn subscribe(socket: &mut WebSocket<TcpStream>, id: u32) {
    socket.send(Frame::text(advertise(id))).expect("sent");
    assert_eq!(
        text(socket),
        format!(r#"{{"op":"subscribe","subscriptions":[{{"id":{id},"channelId":{id}}}]}}"#)
    );
}

/// Runs a server in a thread; gives its address.
fn serve(script: impl FnOnce(TcpListener) + Send + 'static) -> (String, JoinHandle<()>) {
    let listener = TcpListener::bind("localhost:0").expect("a free port");
    let port = listener.local_addr().expect("bound").port();
    let thread = std::thread::spawn(move || script(listener));
    (format!("ws://localhost:{port}"), thread)
}

/// Everything up to the `count`th message, events as they are written by `Debug`, messages as their payload.
fn until_messages(source: &mut LiveStream, count: usize) -> Vec<String> {
    let mut seen = Vec::new();
    let mut messages = 0;
    while messages < count {
        match source.next(SHORTLY).expect("listening") {
            Some(Incoming::Message(message)) => {
                messages += 1;
                seen.push(format!(
                    "{}@{:?}={}",
                    message.topic.name,
                    message.publish_nanos,
                    String::from_utf8_lossy(&message.data)
                ));
            }
            Some(Incoming::Event { event, .. }) => seen.push(brief(&event)),
            None => {}
        }
    }
    seen
}

fn brief(event: &Event) -> String {
    let name = |topic: &Option<std::sync::Arc<live::Topic>>| {
        topic.as_ref().map_or("all".to_owned(), |t| t.name.clone())
    };
    match event {
        Event::Connected { .. } => "connected".into(),
        Event::TopicAppeared { topic } => format!("appeared {} {}", topic.name, topic.type_name),
        Event::Lost { count, cause, .. } => format!("lost {count} {cause:?}"),
        Event::Disconnected { topic, .. } => format!("disconnected {}", name(topic)),
        Event::Reconnected { topic, .. } => format!("reconnected {}", name(topic)),
        Event::Notice { text } => format!("notice {text}"),
        other => format!("{other:?}"),
    }
}

#[test]
fn a_broken_connection_is_made_again_and_every_topic_asked_for_again() {
    let (url, server) = serve(|listener| {
        let mut first = accept(&listener);
        subscribe(&mut first, 3);
        first.send(message(3, 10, b"a")).expect("sent");
        first
            .send(message(99, 11, b"of no subscription"))
            .expect("sent");
        first.send(Frame::binary(vec![1, 2])).expect("sent");
        first.send(message(3, 12, b"b")).expect("sent");
        // Without a goodbye, as a crash does.
        drop(first);
        let mut second = accept(&listener);
        subscribe(&mut second, 5);
        second.send(message(5, 13, b"c")).expect("sent");
        let gone = Frame::text(r#"{"op":"unadvertise","channelIds":[5]}"#);
        second.send(gone).expect("sent");
        subscribe(&mut second, 6);
        second.send(message(6, 14, b"d")).expect("sent");
        // Until the client says goodbye.
        while second.read().is_ok() {}
    });
    let filter = TopicFilter::new(&["/count"], &[]);
    let mut source =
        foxglove::connect(&url, filter, &FoxgloveOptions::default()).expect("connected");
    assert_eq!(
        until_messages(&mut source, 4),
        [
            "connected",
            "appeared /count Count",
            "/count@Some(10)=a",
            "lost 1 Undecodable",
            "/count@Some(12)=b",
            "disconnected all",
            "reconnected all",
            "reconnected /count",
            "/count@Some(13)=c",
            "disconnected /count",
            "reconnected /count",
            "/count@Some(14)=d",
        ]
    );
    let topics = source.topics();
    assert_eq!(topics.len(), 1);
    let schema = topics[0].schema.as_ref().expect("a definition");
    assert_eq!(
        (schema.encoding.as_str(), schema.data.as_slice()),
        ("jsonschema", &b"{}"[..])
    );
    assert!(!topics[0].numbered);
    source.stop();
    server.join().expect("the script went through");
    assert!(matches!(source.next(SHORTLY), Err(LiveError::Transport(_))));
}

#[test]
fn a_server_that_falls_silent_counts_as_lost() {
    let (url, server) = serve(|listener| {
        let silent = accept(&listener);
        // It neither speaks nor answers; the client must come again by itself.
        let mut second = accept(&listener);
        subscribe(&mut second, 1);
        second.send(message(1, 1, b"x")).expect("sent");
        while second.read().is_ok() {}
        drop(silent);
    });
    let options = FoxgloveOptions {
        silence_limit: Duration::from_millis(200),
        ..FoxgloveOptions::default()
    };
    let filter = TopicFilter::new(&["/count"], &[]);
    let mut source = foxglove::connect(&url, filter, &options).expect("connected");
    let seen = until_messages(&mut source, 1);
    assert_eq!(
        &seen[..3],
        ["connected", "disconnected all", "reconnected all"]
    );
    source.stop();
    server.join().expect("the script went through");
}

#[test]
fn what_a_server_says_wrongly_is_told_and_survived() {
    let (url, server) = serve(|listener| {
        let mut socket = accept(&listener);
        for text in [
            "{not json",
            r#"{"op":"status","level":1,"message":"slow"}"#,
            r#"{"op":"advertise","channels":[{"id":-1}]}"#,
            r#"{"op":"somethingNew","x":1}"#,
        ] {
            socket.send(Frame::text(text)).expect("sent");
        }
        subscribe(&mut socket, 1);
        socket.send(message(1, u64::MAX, b"x")).expect("sent");
        while socket.read().is_ok() {}
    });
    let filter = TopicFilter::new(&["/count"], &[]);
    let mut source =
        foxglove::connect(&url, filter, &FoxgloveOptions::default()).expect("connected");
    let seen = until_messages(&mut source, 1);
    assert!(seen[1].starts_with("notice a text of the server is not understood"));
    assert_eq!(seen[2], "notice the server says: slow");
    assert!(seen[3].starts_with("notice a text of the server is not understood"));
    assert_eq!(seen[4..], ["appeared /count Count", "/count@None=x"]);
    source.stop();
    server.join().expect("the script went through");
}

/// Bytes as they go over the wire, past what the library would send.
fn send_raw(socket: &mut WebSocket<TcpStream>, bytes: &[u8]) {
    socket.get_mut().write_all(bytes).expect("sent");
}

/// Frames that lie about themselves break the connection, and only that: it is made again, and what is lost is told.
#[test]
fn a_server_that_lies_about_its_frames_is_left_and_met_again() {
    let lies: [&[u8]; 6] = [
        // A text of 2^62 bytes, of which none follow.
        &[0x81, 127, 0x40, 0, 0, 0, 0, 0, 0, 0],
        // A binary frame above the limit of this test.
        &[0x82, 127, 0, 0, 0, 0, 0, 1, 0, 0],
        // Bits that are reserved.
        &[0xf2, 1, 0],
        // An operation that does not exist.
        &[0x83, 0],
        // A text that is not UTF-8.
        &[0x81, 2, 0xff, 0xfe],
        // A masked frame, which only clients send.
        &[0x82, 0x81, 1, 2, 3, 4, 5],
    ];
    let count = lies.len();
    let (url, server) = serve(move |listener| {
        for (place, lie) in lies.iter().enumerate() {
            let mut socket = accept(&listener);
            subscribe(&mut socket, 1);
            let number = [u8::try_from(place).expect("few")];
            socket.send(message(1, 1, &number)).expect("sent");
            send_raw(&mut socket, lie);
            while socket.read().is_ok() {}
        }
        let mut honest = accept(&listener);
        subscribe(&mut honest, 1);
        honest.send(message(1, 2, b"end")).expect("sent");
        while honest.read().is_ok() {}
    });
    let options = FoxgloveOptions {
        largest_message: 1000,
        ..FoxgloveOptions::default()
    };
    let filter = TopicFilter::new(&["/count"], &[]);
    let mut source = foxglove::connect(&url, filter, &options).expect("connected");
    let seen = until_messages(&mut source, count + 1);
    let times = |what: &str| seen.iter().filter(|it| *it == what).count();
    assert_eq!(times("disconnected all"), count, "{seen:?}");
    assert_eq!(times("reconnected all"), count);
    assert_eq!(seen.last().map(String::as_str), Some("/count@Some(2)=end"));
    assert_eq!(source.totals().received, count as u64 + 1);
    source.stop();
    server.join().expect("the script went through");
}

/// Messages whose frame is too short or of an unknown kind, or that nobody asked for, are counted or passed over.
#[test]
fn frames_that_hold_no_message_are_counted_and_the_next_one_is_read() {
    let (url, server) = serve(|listener| {
        let mut socket = accept(&listener);
        subscribe(&mut socket, 1);
        for length in [0, 1, 5, 12] {
            let cut = message(1, 1, b"").into_data()[..length].to_vec();
            socket.send(Frame::binary(cut)).expect("sent");
        }
        socket.send(Frame::binary(vec![200; 40])).expect("sent");
        socket.send(message(7, 1, b"nobody asked")).expect("sent");
        socket.send(message(1, 3, b"")).expect("sent");
        while socket.read().is_ok() {}
    });
    let filter = TopicFilter::new(&["/count"], &[]);
    let mut source =
        foxglove::connect(&url, filter, &FoxgloveOptions::default()).expect("connected");
    let seen = until_messages(&mut source, 1);
    let lost = seen.iter().filter(|it| *it == "lost 1 Undecodable").count();
    assert_eq!(lost, 4, "{seen:?}");
    assert_eq!(seen.last().map(String::as_str), Some("/count@Some(3)="));
    assert_eq!(source.totals().lost_undecodable, 4);
    source.stop();
    server.join().expect("the script went through");
}

#[test]
fn messages_go_to_the_server_also_after_a_break() {
    let (url, server) = serve(|listener| {
        let announcement = r#"{"op":"advertise","channels":[{"id":0,"topic":"/go","encoding":"json","schemaName":"Go"}]}"#;
        let mut first = accept(&listener);
        assert_eq!(text(&mut first), announcement);
        let frame = first.read().expect("a frame");
        assert_eq!(frame.into_data().as_ref(), b"\x01\0\0\0\0{}");
        first.close(None).expect("closed");
        while first.read().is_ok() {}
        drop(first);
        let mut second = accept(&listener);
        assert_eq!(text(&mut second), announcement);
        let frame = second.read().expect("a frame");
        assert_eq!(frame.into_data().as_ref(), b"\x01\0\0\0\0[2]");
    });
    let mut publisher =
        FoxglovePublisher::new(&url, &FoxgloveOptions::default()).expect("connected");
    let mut topic = Outgoing::ros2("/go", "Go");
    assert!(matches!(
        publisher.advertise(&topic),
        Err(LiveError::Unsupported(_))
    ));
    topic.encoding = "json".into();
    let publication = publisher.advertise(&topic).expect("advertised");
    publisher.publish(publication, 0, b"{}").expect("sent");
    // Until the break is noticed a message may go into the void, so send until the server has what it waits for.
    while !server.is_finished() {
        let _ = publisher.publish(publication, 0, b"[2]");
        std::thread::sleep(SHORTLY);
    }
    server.join().expect("the script went through");
}

#[test]
fn a_server_that_is_not_there_is_an_error_at_once() {
    let listener = TcpListener::bind("localhost:0").expect("a free port");
    let port = listener.local_addr().expect("bound").port();
    drop(listener);
    let url = format!("ws://localhost:{port}");
    let result = foxglove::connect(&url, TopicFilter::all(), &FoxgloveOptions::default());
    let Err(LiveError::Connect { to, .. }) = result else {
        panic!("connected to nobody");
    };
    assert_eq!(to, url);
}
