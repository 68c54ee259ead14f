//! Tables in CSV and JSON lines.

use recording::{
    Extractor, FieldPath, Format, OpenOptions, Reader, SignalStream, TimeUnit, TopicInfo, TopicMap,
    Value, open_bytes,
};

/// Topic, time and the values at some paths.
type Row = (String, i64, Vec<Value>);

/// Reads `text`; `paths` are looked up in each topic that has them.
fn read_with(
    text: &str,
    format: Format,
    options: &OpenOptions,
    paths: &[&str],
) -> Result<(Vec<Row>, Box<dyn Reader + Send>), String> {
    let bytes = text.as_bytes().to_vec();
    let mut reader = open_bytes(bytes, format, options).map_err(|error| error.to_string())?;
    let topics: Vec<TopicInfo> = reader.topics().to_vec();
    let paths: Vec<FieldPath> = paths.iter().map(|path| path.parse().unwrap()).collect();
    let mut rows = Vec::new();
    while let Some(message) = reader.next().map_err(|error| error.to_string())? {
        let topic = &topics[message.topic.index()];
        let known = paths
            .iter()
            .filter(|path| Extractor::new(topic, std::slice::from_ref(path)).is_ok());
        let known: Vec<FieldPath> = known.cloned().collect();
        let mut extractor = Extractor::new(topic, &known).unwrap();
        extractor.verify(message.data).unwrap();
        let values = extractor.extract_values(message.data).unwrap();
        rows.push((topic.name.clone(), message.log_nanos, values));
    }
    Ok((rows, reader))
}

fn csv(text: &str, paths: &[&str]) -> Result<(Vec<Row>, Box<dyn Reader + Send>), String> {
    read_with(text, Format::Csv, &OpenOptions::default(), paths)
}

fn json(text: &str, paths: &[&str]) -> Result<(Vec<Row>, Box<dyn Reader + Send>), String> {
    read_with(text, Format::JsonLines, &OpenOptions::default(), paths)
}

/// Values are compared so that missing numbers are alike.
fn show(rows: &[Row]) -> Vec<String> {
    let rows = rows
        .iter()
        .map(|(topic, nanos, values)| format!("{topic} {nanos} {values:?}"));
    rows.collect()
}

#[test]
fn a_table_is_one_topic_with_a_field_for_each_column() {
    let text = "\u{feff}t [ms];speed [m/s];state;ready;position[0]\n\
                0;0.25;idle;true;1e-3\n250.5;;\"a;b\";false;-2\n";
    let (rows, reader) = csv(text, &["speed", "state", "ready", "position_0"]).unwrap();
    assert_eq!(
        show(&rows),
        [
            "/csv 0 [Number(0.25), Text(\"idle\"), Bool(true), Number(0.001)]",
            "/csv 250500000 [Number(NaN), Text(\"a;b\"), Bool(false), Number(-2.0)]",
        ]
    );
    assert!(reader.complete());
    assert_eq!(reader.metadata()["unit of /csv.speed"], "m/s");
    assert_eq!(
        reader.metadata()["header of /csv.position_0"],
        "position[0]"
    );
}

#[test]
fn a_unit_in_a_header_is_that_of_the_signal() {
    let text = "t [s],speed [mm/s],share [of all],count\n0.0,200,0.5,1\n0.1,300,0.5,2\n";
    let reader = csv(text, &[]).unwrap().1;
    let wanted = ["/csv.speed", "/csv.share", "/csv.count"].map(String::from);
    let stream = SignalStream::new(reader, &TopicMap::default(), &wanted).unwrap();
    let layout = stream.layout();
    let unit = |name: &str| {
        let at = layout.signal(name).unwrap();
        layout.channels[at.channel].fields[at.field].unit.clone()
    };
    // What is no unit is part of a name.
    assert_eq!(wanted.each_ref().map(|name| unit(name)), ["mm/s", "", ""]);
    let slow = trace::Predicate::parse("/csv.speed < 0.25 m/s").unwrap();
    assert!(slow.bind(layout).is_ok());
}

#[test]
fn signals_in_headers_make_topics_of_their_own_rates() {
    let text = "time_secs,/robot.hand.x [m],/human.ready,/robot.state\n\
                0.0,0.5,,idle\n0.1,,false,\n0.2,-1,true,grasp\n";
    let (rows, reader) = csv(text, &["hand.x", "state", "ready"]).unwrap();
    assert_eq!(
        show(&rows),
        [
            "/robot 0 [Number(0.5), Text(\"idle\")]",
            "/human 100000000 [Number(0.0)]",
            "/robot 200000000 [Number(-1.0), Text(\"grasp\")]",
            "/human 200000000 [Number(1.0)]",
        ]
    );
    assert!(reader.complete());
}

#[test]
fn rows_that_cannot_be_read_are_told_with_line_and_column() {
    let mut text = "time_secs,x\r\n".to_owned();
    for row in 0..20 {
        text.push_str(&format!("{row},{}\r\n", row * 2));
    }
    text.push_str("20,1.2.3\r\nsoon,1\r\n22\r\n\r\n23,4\r\n24,5");
    let (rows, reader) = csv(&text, &["x"]).unwrap();
    assert_eq!(rows.len(), 22);
    assert_eq!(
        show(&rows[20..]),
        [
            "/csv 20000000000 [Number(NaN)]",
            "/csv 23000000000 [Number(4.0)]"
        ]
    );
    let losses: Vec<String> = reader.losses().iter().map(ToString::to_string).collect();
    let told = [
        "line 22, column \"x\": \"1.2.3\" is not a number, so it counts as missing",
        "line 23, column \"time_secs\": \"soon\" is not a valid time; 1 message",
        "line 24 has 1 cells, but there are 2 headers; 1 message",
        "line 27, the last one, has no line break",
    ];
    assert_eq!(losses.len(), told.len(), "{losses:?}");
    for (loss, told) in losses.iter().zip(told) {
        assert!(loss.contains(told), "{loss}");
    }
    assert_eq!(
        reader.losses()[0].offset as usize,
        text.find("20,1.2.3").unwrap()
    );
    assert_eq!(
        reader.losses()[3].offset as usize,
        text.find("24,5").unwrap()
    );
    assert!(!reader.complete());
}

#[test]
fn what_is_ambiguous_is_asked_for() {
    let error = |text| csv(text, &[]).err().unwrap();
    assert!(error("t,x\n0.5,1\n").contains("state the unit (s, ms, us or ns)"));
    assert!(error("x,y\n0.5,1\n").contains("no column of times, but \"x\", \"y\""));
    assert!(error("t,x\nsoon,1\n").contains("line 2"));
    assert!(error("time_s,a b,a-b\n0,1,2\n").contains("two columns are called /csv.a_b"));
    assert!(error("").contains("empty"));
    assert!(error("time_s,x").contains("first line does not end"));
    let error = |text| json(text, &[]).err().unwrap();
    assert!(error("{\"t\": 5}\n").contains("state the unit"));
    assert!(error("{\"x\": 5}\n").contains("no time under its keys \"x\""));
    assert!(error("[1]\n").contains("no line is a JSON object"));
    assert!(error("\n \n").contains("empty"));
    let mut options = OpenOptions {
        time_unit: Some(TimeUnit::Micros),
        ..OpenOptions::default()
    };
    let (rows, _) = read_with("t,x\n5,1\n", Format::Csv, &options, &[]).unwrap();
    assert_eq!(rows[0].1, 5_000);
    options.time_field = Some("when".to_owned());
    let (rows, _) = read_with("t,when\n5,1\n", Format::Csv, &options, &[]).unwrap();
    assert_eq!(rows[0].1, 1_000);
    let (rows, _) = read_with("{\"when\": 7}", Format::JsonLines, &options, &[]).unwrap();
    assert_eq!(rows[0].1, 7_000);
}

#[test]
fn lines_are_messages_of_their_topics() {
    let text = "\u{feff}{\"time\": 1700000000.123456789, \"topic\": \"/robot\", \"hand\": {\"x\": [0.5, 2]}}\n\n\
                {\"topic\": \"/human\", \"time\": 1700000001, \"near\": true, \"who\": \"a\\\"b\"}\r\n\
                {\"time\": \"1700000002.5\", \"near\": false}";
    let (rows, reader) = json(text, &["hand.x[1]", "near", "who"]).unwrap();
    assert_eq!(
        show(&rows),
        [
            "/robot 1700000000123456789 [Number(2.0), Missing, Missing]",
            "/human 1700000001000000000 [Missing, Bool(true), Text(\"a\\\"b\")]",
            "/json 1700000002500000000 [Missing, Bool(false), Missing]",
        ]
    );
    assert!(reader.complete());
    let counts: Vec<_> = reader
        .topics()
        .iter()
        .map(|topic| topic.message_count)
        .collect();
    assert_eq!(counts, [Some(1); 3]);
}

#[test]
fn lines_that_cannot_be_read_are_told_with_their_numbers() {
    let text = "{\"time_s\": 1}\n{\"time_s\": \n{\"x\": 2}\n{\"time_s\": \"soon\"}\n[]\n{\"time_s\": 2} 3\n\
                {\"time_s\": 5}\n";
    let (rows, reader) = json(text, &[]).unwrap();
    assert_eq!(
        rows.iter().map(|row| row.1).collect::<Vec<_>>(),
        [1_000_000_000, 5_000_000_000]
    );
    let told = [
        "line 2 is not a",
        "line 3 has no \"time_s\"",
        "line 4: soon is not a valid time",
        "line 5",
        "line 6",
    ];
    for (loss, told) in reader.losses().iter().zip(told) {
        assert!(loss.message.contains(told), "{loss}");
    }
    assert_eq!(reader.losses().len(), told.len());
    assert_eq!(
        reader.losses()[1].offset as usize,
        text.find("{\"x\"").unwrap()
    );
}

/// A cut in the middle of a line must be noticed; at its end it cannot be.
#[test]
fn tables_and_lines_cut_anywhere_give_only_what_was_recorded() {
    let table = "time_secs,x,s\n0.25,12.5,ab\n0.5,13.75,\"c\"\n12.0,14.125,d\n";
    let lines = "{\"time_secs\": 0.25, \"x\": 12.5}\n{\"time_secs\": 12, \"x\": 13}\n";
    for (text, format) in [(table, Format::Csv), (lines, Format::JsonLines)] {
        let options = OpenOptions::default();
        let (whole, _) = read_with(text, format, &options, &["x"]).unwrap();
        for len in 0..text.len() {
            let Ok((rows, reader)) = read_with(&text[..len], format, &options, &["x"]) else {
                continue;
            };
            let ends_with_line =
                matches!(text.as_bytes().get(len), Some(b'\n')) || text[..len].ends_with('\n');
            assert_eq!(show(&rows), show(&whole[..rows.len()]), "cut at {len}");
            assert!(ends_with_line || !reader.complete(), "cut at {len}");
        }
    }
}
