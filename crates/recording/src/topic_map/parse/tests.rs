//! Topic maps, right and wrong.

use super::*;

fn errors(text: &str) -> Vec<String> {
    let errors = parse("t.toml", text).unwrap_err();
    errors.iter().map(ToString::to_string).collect()
}

#[test]
fn entries_keep_their_order_and_say_what_they_are() {
    let map = parse(
        "t.toml",
        r#"
["/z.speed"]
norm = "/odom.twist.twist.linear"
unit = "m/s"
scale = 0.5
interpolation = "linear"
staleness = "200 ms"

[time]
from = "header"
reorder = "250 ms"

["/a.state"]
from = "/task.phase"
values = ["idle", "serve"]

["/hand"]
position_of = "/hand_link"
in_frame = "world"
"#,
    )
    .unwrap();
    let names: Vec<String> = map.signal_names().collect();
    assert_eq!(
        names,
        ["/z.speed", "/a.state", "/hand.x", "/hand.y", "/hand.z"]
    );
    assert_eq!(map.time.source, TimeSource::Header);
    assert_eq!(map.time.reorder_secs, 0.25);
    let speed = &map.signals[0];
    assert_eq!(
        (speed.scale, speed.staleness_secs, speed.line),
        (0.5, Some(0.2), 2)
    );
    assert_eq!(
        speed.source,
        SignalSource::Norm {
            of: ["x", "y", "z"]
                .map(|axis| format!("/odom.twist.twist.linear.{axis}"))
                .into()
        }
    );
    assert_eq!(
        map.signals[1].fields()[0].kind,
        FieldKind::Enumeration(vec!["idle".into(), "serve".into()])
    );
    let hand = &map.signals[2].fields()[1];
    assert_eq!(
        (
            hand.name.as_str(),
            hand.unit.as_str(),
            hand.frame.as_deref()
        ),
        ("y", "m", Some("world"))
    );
    assert_eq!(
        map.find("/hand.z").map(|(entry, part)| (entry.line, part)),
        Some((17, 2))
    );
}

#[test]
fn every_mistake_is_told_with_its_line() {
    let found = errors(
        r#"
["/a.x"]
form = "/t.x"
["/b.x"]
from = "/t.x"
point = "/t.p"
["/c.x"]
unit = "m"
["/d.x"]
from = "/tx"
["/e.x"]
from = "/t.x"
staleness = "fast"
["/f.x"]
from = "/t.x"
interpolation = "linear"
["/g"]
from = "/t.x"
["/h"]
position_of = "hand"
["/i.x"]
from = "/t.x"
values = ["a", "a"]
["/j.x"]
from = "/t.x"
in_frame = "world"
["/k"]
point = "/t.p"
["/k.x"]
from = "/t.x"
["/l.x"]
from = "/t.x"
scale = 0
["/m.x"]
distance_between = ["a", "b"]
unit = "mm"
"#,
    );
    let expected = [
        ("3: ", "form"),
        ("6: ", "both from and point"),
        ("7: ", "where its values come from"),
        ("10: ", "not a path into a topic"),
        ("13: ", "\"fast\" is not a valid duration"),
        ("16: ", "needs a staleness"),
        ("17: ", "/g is not a valid name of a signal"),
        ("20: ", "needs the frame from which"),
        ("23: ", "a is listed twice"),
        ("26: ", "not single values"),
        ("29: ", "/k.x is given by the entry of line 27 too"),
        ("33: ", "scale of 0"),
        ("36: ", "does not apply to what comes from transforms"),
    ];
    assert_eq!(found.len(), expected.len(), "{found:#?}");
    for (found, (line, message)) in found.iter().zip(expected) {
        assert!(found.starts_with(&format!("t.toml:{line}")), "{found}");
        assert!(found.contains(message), "{found}");
    }
}

#[test]
fn broken_toml_is_told_with_its_line() {
    assert!(errors("\n[\"/a.x\"\n")[0].starts_with("t.toml:2: "));
    assert!(
        errors("[\"/a.x\"]\nfrom = \"/t.x\"\n[\"/a.x\"]\nfrom = \"/t.y\"\n")[0]
            .starts_with("t.toml:3: ")
    );
    assert!(!errors("\"/a.x\" = 3\n").is_empty());
    assert_eq!(parse("t.toml", "").unwrap(), TopicMap::default());
}
