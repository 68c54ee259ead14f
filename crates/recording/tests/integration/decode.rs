//! Decoding by hand-made bytes: byte order, alignment of both versions of CDR, ROS 1, and whatever bytes.

use std::sync::Arc;

use proptest::prelude::*;
use recording::{
    Dialect, Encoding, Extractor, FieldPath, MessageType, Schema, TopicId, TopicInfo, Type, Value,
    parse_idl, parse_msg,
};

fn topic(encoding: Encoding, message: MessageType) -> TopicInfo {
    TopicInfo {
        id: TopicId(0),
        name: "/topic".to_owned(),
        type_name: message.name.clone(),
        encoding,
        schema: Arc::new(Schema::Struct(message)),
        message_count: None,
    }
}

fn extractor(topic: &TopicInfo, paths: &[&str]) -> Extractor {
    let paths: Vec<FieldPath> = paths.iter().map(|p| FieldPath::parse(p).unwrap()).collect();
    Extractor::new(topic, &paths).unwrap_or_else(|error| panic!("{error}"))
}

fn read(topic: &TopicInfo, paths: &[&str], data: &[u8]) -> Vec<f64> {
    let mut row = vec![0.0; paths.len()];
    extractor(topic, paths)
        .extract(data, &mut row)
        .unwrap_or_else(|error| panic!("{error}"));
    row
}

/// Writes values as CDR does: `first` is the second byte of the header, `most` the largest alignment.
struct Cdr {
    bytes: Vec<u8>,
    big: bool,
    most: usize,
}

impl Cdr {
    fn new(first: u8, big: bool, most: usize) -> Self {
        let bytes = vec![0, first, 0, 0];
        Cdr { bytes, big, most }
    }

    fn put(&mut self, mut value: Vec<u8>) {
        let alignment = value.len().min(self.most);
        let body = self.bytes.len() - 4;
        self.bytes
            .resize(4 + body.next_multiple_of(alignment), 0xee);
        if self.big {
            value.reverse();
        }
        self.bytes.extend(value);
    }

    fn text(&mut self, text: &str) {
        self.put((text.len() as u32 + 1).to_le_bytes().to_vec());
        self.bytes.extend(text.as_bytes());
        self.bytes.push(0);
    }
}

const MIXED: &str = "uint8 a\nfloat64 b\nstring s\nint16 c\nfloat64[] d\nP[2] p\nP[] q\nstring[2] t\nuint64 e\n\
                     ===\nMSG: p/P\nuint8 k\nfloat64 x\nint16 y\n";
const PATHS: [&str; 9] = [
    "a",
    "b",
    "c",
    "d[1]",
    "p[1].x",
    "q[k=6].x",
    "q[2].y",
    "length(t)",
    "e",
];

fn mixed(cdr: &mut Cdr, is_second: bool) {
    let delimiter = |cdr: &mut Cdr| {
        if is_second {
            // Its value is not needed by a reader who knows the type.
            cdr.put(77_u32.to_le_bytes().to_vec());
        }
    };
    let place = |cdr: &mut Cdr, k: u8| {
        cdr.put(vec![k]);
        cdr.put((f64::from(k) + 0.5).to_le_bytes().to_vec());
        cdr.put((-i16::from(k)).to_le_bytes().to_vec());
    };
    cdr.put(vec![9]);
    cdr.put(1.25_f64.to_le_bytes().to_vec());
    cdr.text("odd");
    cdr.put((-3_i16).to_le_bytes().to_vec());
    cdr.put(2_u32.to_le_bytes().to_vec());
    cdr.put(10.0_f64.to_le_bytes().to_vec());
    cdr.put(11.0_f64.to_le_bytes().to_vec());
    delimiter(cdr);
    (1..3).for_each(|k| place(cdr, k));
    delimiter(cdr);
    cdr.put(3_u32.to_le_bytes().to_vec());
    (5..8).for_each(|k| place(cdr, k));
    delimiter(cdr);
    cdr.text("x");
    cdr.text("");
    cdr.put((1_u64 << 40).to_le_bytes().to_vec());
}

#[test]
fn both_byte_orders_and_both_versions_of_cdr_are_read() {
    let message = parse_msg("p/msg/Mixed", MIXED, Dialect::Ros2).unwrap();
    let topic = topic(Encoding::Cdr, message);
    for (first, big, most) in [(0, true, 8), (1, false, 8), (6, true, 4), (7, false, 4)] {
        let mut cdr = Cdr::new(first, big, most);
        mixed(&mut cdr, first >= 6);
        let row = read(&topic, &PATHS, &cdr.bytes);
        let expected = [
            9.0,
            1.25,
            -3.0,
            11.0,
            2.5,
            6.5,
            -7.0,
            2.0,
            (1_u64 << 40) as f64,
        ];
        assert_eq!(row, expected, "header {first}");
        let mut whole = extractor(&topic, &["e"]);
        whole.verify(&cdr.bytes).unwrap();
        let cut = &cdr.bytes[..cdr.bytes.len() - 1];
        let error = whole.extract(cut, &mut [0.0]).unwrap_err();
        assert!(error.offset_in_message <= cut.len() && error.offset_in_message > 4);
    }
    for header in [[0, 2], [0, 3], [0, 8], [0, 9], [1, 1]] {
        let error = extractor(&topic, &["a"]).extract(&[header[0], header[1], 0, 0, 9], &mut [0.0]);
        assert!(error.unwrap_err().to_string().contains("not supported"));
    }
}

#[test]
fn ros_1_is_packed_and_its_texts_have_no_end() {
    let text = "byte b\nfloat64 x\nstring s\ntime t\nduration d\nbool on\n";
    let topic = topic(
        Encoding::Ros1,
        parse_msg("p/T", text, Dialect::Ros1).unwrap(),
    );
    let mut data = vec![0xff];
    data.extend(2.5_f64.to_le_bytes());
    data.extend([2, 0, 0, 0, b'h', b'i']);
    data.extend(3_000_000_000_u32.to_le_bytes());
    data.extend(5_u32.to_le_bytes());
    data.extend((-2_i32).to_le_bytes());
    data.extend((-7_i32).to_le_bytes());
    data.push(1);
    let row = read(
        &topic,
        &["b", "x", "t.sec", "t.nsecs", "d.secs", "d.nanosec", "on"],
        &data,
    );
    assert_eq!(row, [-1.0, 2.5, 3e9, 5.0, -2.0, -7.0, 1.0]);
    let values = extractor(&topic, &["s"]).extract_values(&data).unwrap();
    assert_eq!(values, [Value::Text("hi".into())]);
    *data.last_mut().unwrap() = 2;
    let error = extractor(&topic, &["on"])
        .extract(&data, &mut [0.0])
        .unwrap_err();
    assert_eq!(error.offset_in_message, data.len() - 1);
}

#[test]
fn names_that_stand_behind_what_they_choose_are_found_too() {
    let text = "float64[] position\nint32 between\nstring[] name\n";
    let topic = topic(
        Encoding::Ros1,
        parse_msg("p/T", text, Dialect::Ros1).unwrap(),
    );
    let mut data = vec![2, 0, 0, 0];
    data.extend(1.5_f64.to_le_bytes());
    data.extend(2.5_f64.to_le_bytes());
    data.extend(9_i32.to_le_bytes());
    data.extend([2, 0, 0, 0, 1, 0, 0, 0, b'a', 1, 0, 0, 0, b'b']);
    let row = read(
        &topic,
        &[
            "position[name='b']",
            "between",
            "position[name='c']",
            "position[0]",
        ],
        &data,
    );
    assert_eq!(row[..2], [2.5, 9.0]);
    assert!(row[2].is_nan());
    assert_eq!(row[3], 1.5);
}

#[test]
fn paths_that_do_not_fit_are_refused_with_what_would() {
    let message = parse_msg("p/msg/Mixed", MIXED, Dialect::Ros2).unwrap();
    let topic = topic(Encoding::Cdr, message);
    for (path, hint) in [
        ("nothing", "name one of its fields: a, b"),
        ("p", "give an index"),
        ("p.x", "give an index before .x"),
        ("p[0]", "name one of its fields: k, x, y"),
        ("a.b", "has no parts"),
        ("length(a)", "only arrays"),
        ("d[nobody='x']", "nobody"),
        ("d[a='x']", "not an array"),
    ] {
        let path = FieldPath::parse(path).unwrap();
        let error = Extractor::new(&topic, std::slice::from_ref(&path)).unwrap_err();
        assert!(error.to_string().contains(hint), "{error}");
    }
    let wide = parse_idl(
        "m/A",
        "module m { struct A { double x; wstring w; double y; }; };",
    )
    .unwrap();
    let wide = self::topic(Encoding::Cdr, wide);
    assert_eq!(
        read(&wide, &["x"], &[0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]),
        [0.0]
    );
    let error = Extractor::new(&wide, &[FieldPath::parse("y").unwrap()]).unwrap_err();
    assert!(error.to_string().contains("wide text"), "{error}");
}

#[test]
fn arrays_of_nothing_and_types_without_end_cost_no_time() {
    let text = "E[] e\nE[1000000000000] f\nfloat64[1000000000000] g\nuint8 last\n===\nMSG: p/E\n";
    let topic = topic(
        Encoding::Ros1,
        parse_msg("p/T", text, Dialect::Ros1).unwrap(),
    );
    let data = [0xff, 0xff, 0xff, 0xff, 1, 2, 3];
    assert!(
        extractor(&topic, &["last"])
            .extract(&data, &mut [0.0])
            .is_err()
    );
    assert_eq!(read(&topic, &["length(e)"], &data), [f64::from(u32::MAX)]);
    // Types that double at each level have a thousand million fields, but are understood at once.
    let mut text = String::from("T0 a\nT0 b\nuint8 last\n");
    for level in 0..30 {
        let inner = if level == 29 {
            "uint8".to_owned()
        } else {
            format!("T{}", level + 1)
        };
        text += &format!("===\nMSG: p/T{level}\n{inner} a\n{inner} b\n");
    }
    let topic = self::topic(
        Encoding::Ros1,
        parse_msg("p/T", &text, Dialect::Ros1).unwrap(),
    );
    assert!(
        extractor(&topic, &["last"])
            .extract(&data, &mut [0.0])
            .is_err()
    );
}

/// Paths to every number of a type, arrays by their first element.
fn leaves(message: &MessageType, before: &str, found: &mut Vec<String>) {
    for field in &message.fields {
        let mut path = format!("{before}{}", field.name);
        let mut kind = &field.kind;
        while let Type::Array(element, _) | Type::Sequence(element) = kind {
            path += "[0]";
            kind = element;
        }
        match kind {
            Type::Struct(inner) => leaves(inner, &format!("{path}."), found),
            Type::WideText => {}
            _ => found.push(path),
        }
    }
}

proptest! {
    #[test]
    fn no_bytes_make_decoding_panic(data in proptest::collection::vec(any::<u8>(), 0..200), header in 0..8_u8) {
        let mut data = data;
        if data.len() > 3 {
            // Counts that are believable make it further.
            data[..2].copy_from_slice(&[0, header]);
            data.iter_mut().skip(4).step_by(3).for_each(|byte| *byte &= 3);
        }
        for encoding in [Encoding::Cdr, Encoding::Ros1] {
            let message = parse_msg("p/msg/Mixed", MIXED, Dialect::Ros2).unwrap();
            let mut paths = Vec::new();
            leaves(&message, "", &mut paths);
            let paths: Vec<&str> = paths.iter().map(String::as_str).collect();
            let mut extractor = extractor(&topic(encoding, message), &paths);
            let mut row = vec![0.0; paths.len()];
            if let Err(error) = extractor.extract(&data, &mut row) {
                prop_assert!(error.offset_in_message <= data.len());
            }
            let _ = extractor.verify(&data);
        }
    }

    #[test]
    fn no_text_makes_schemas_panic(text in "(uint8|string|P|float64|=|=====|MSG: p/P|\\[3\\]|\\[\\]|<=| |\n|a|b|#){0,40}") {
        for dialect in [Dialect::Ros1, Dialect::Ros2] {
            let _ = parse_msg("p/T", &text, dialect);
        }
    }

    #[test]
    fn no_text_makes_idl_panic(text in "(module|struct|m|A|\\{|\\}|;|:|::|<|>|sequence|double|long|@|\\(|\\)|\"|/\\*|\\*/|//| |\n|,|3|\\[|\\]){0,40}") {
        let _ = parse_idl("m/A", &text);
    }
}
