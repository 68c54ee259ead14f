//! The page of a replay: complete in itself, safe with any text, and small.

use report::replay::{
    Form, Mark, Replay, Role, Scene, Shape, Signal, SignalKind, Tone, Verdict, html,
};
use sha2::{Digest, Sha256};

const SCRIPT: &str = concat!(
    include_str!("../../src/replay/view3d.js"),
    include_str!("../../src/replay/player.js")
);

/// 35 s at 50 Hz of a robot with 28 bodies, one of which stands still.
fn long() -> Replay {
    let turn = |angle: f64| [(angle / 2.0).cos(), 0.0, 0.0, (angle / 2.0).sin()];
    let times_secs: Vec<f64> = (0..1750).map(|i| f64::from(i) * 0.02).collect();
    let pose = |body: usize, time: f64| {
        let phase = if body == 0 { 0.0 } else { time + body as f64 };
        (
            [0.1 * phase.cos(), 0.1 * phase.sin(), 0.05 * body as f64],
            turn(phase),
        )
    };
    let poses = times_secs
        .iter()
        .map(|time| (0..28).map(|body| pose(body, *time)).collect());
    let shape = |body: usize| Shape {
        body: Some(body),
        role: if body.is_multiple_of(2) {
            Role::Robot
        } else {
            Role::Person
        },
        pose: ([0.0; 3], [1.0, 0.0, 0.0, 0.0]),
        form: Form::Capsule {
            radius_m: 0.02,
            length_m: 0.05,
        },
    };
    let kinds = [
        SignalKind::Number("m/s".into()),
        SignalKind::Flag,
        SignalKind::Names(vec!["wait".into(), "go".into()]),
    ];
    let signal = |(index, kind): (usize, &SignalKind)| Signal {
        name: format!("/robot.signal_{index}"),
        kind: kind.clone(),
        values: times_secs
            .iter()
            .map(|time| match kind {
                SignalKind::Number(_) => (3.0 * time).sin(),
                _ => f64::from(u8::from(*time as i64 % 7 > 3)),
            })
            .collect(),
        times_secs: times_secs.clone(),
        causes: vec![(12.0, 13.5)],
    };
    Replay {
        title: "Requirement 1 is violated".into(),
        summary: "A robot hands over.".into(),
        facts: vec![("Seed".into(), "17".into())],
        actions: vec!["send activate".into()],
        verdicts: vec![Verdict {
            id: "1".into(),
            text: "It shall not be dropped.".into(),
            verdict: "violated".into(),
            tone: Tone::Bad,
            reasons: vec!["It is dropped.".into()],
        }],
        marks: vec![Mark {
            time_secs: 13.5,
            text: "1 is violated".into(),
            tone: Tone::Bad,
        }],
        signals: kinds.iter().enumerate().map(signal).collect(),
        scene: Scene {
            bodies: (0..28).map(|body| format!("robot/{body}")).collect(),
            shapes: (0..28).map(shape).collect(),
            poses: poses.collect(),
            times_secs: times_secs.clone(),
        },
        produced_by: "corroborate".into(),
    }
}

#[test]
fn only_the_page_s_own_script_may_run() {
    let page = html(&long());
    let digest = Sha256::digest(SCRIPT.as_bytes());
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut expected = String::new();
    for group in digest.chunks(3) {
        let mut three = [0_u8; 3];
        three[..group.len()].copy_from_slice(group);
        let all = u32::from_be_bytes([0, three[0], three[1], three[2]]);
        for place in 0..4 {
            let letter = LETTERS[(all >> (18 - 6 * place) & 63) as usize];
            expected.push(if place <= group.len() {
                char::from(letter)
            } else {
                '='
            });
        }
    }
    assert!(
        page.contains(&format!("script-src 'sha256-{expected}'")),
        "SCRIPT_HASH in src/replay/page.rs must be {expected}"
    );
    assert!(page.contains(SCRIPT), "the script is in the page as it is");
}

#[test]
fn a_page_of_35_s_is_smaller_than_2_mb_and_loads_nothing() {
    let page = html(&long());
    assert!(page.len() < 2_000_000, "{} bytes", page.len());
    assert!(
        page.len() > 600_000,
        "the poses are in it: {} bytes",
        page.len()
    );
    for outside in ["http://", "https://", "src=\"", "@import", "url("] {
        assert!(!page.contains(outside), "{outside}");
    }
    assert_eq!(page, html(&long()));
}

#[test]
fn text_of_a_study_cannot_become_markup_or_end_the_data() {
    let evil = "</script><script>alert(1)</script><!-- \u{2028} & \"'";
    let mut replay = long();
    replay.title = evil.into();
    replay.marks[0].text = evil.into();
    replay.verdicts[0].reasons[0] = evil.into();
    replay.signals[2].kind = SignalKind::Names(vec![evil.into(), evil.into()]);
    replay.scene.bodies[0] = evil.into();
    let page = html(&replay);
    assert_eq!(page.matches("<script").count(), 2);
    assert_eq!(page.matches("</script>").count(), 2);
    assert!(!page.contains("<!-- "));
}

#[test]
fn nothing_at_all_is_a_page_too() {
    let empty = Replay::default();
    assert!(html(&empty).contains("</html>"));
    let mut gaps = long();
    for signal in &mut gaps.signals {
        signal.values.fill(f64::NAN);
    }
    gaps.signals[0].times_secs.clear();
    gaps.signals[0].values.clear();
    let page = html(&gaps);
    assert!(!page.contains("NaN") && !page.contains("inf\""));
}
