//! Foreign bytes: whatever comes, reading ends with a tree or with problems, and a tree can be written and posed.

use crate::common;

use common::{ARM, BASE, SWING, load};
use proptest::prelude::*;
use robot_model::{Loaded, MjcfOptions, Problems, parse, to_mjcf};

/// What must hold of every answer.
fn sound(answer: &Result<Loaded, Problems>) {
    match answer {
        Err(problems) => {
            assert!(!problems.0.is_empty());
            for problem in &problems.0 {
                assert!(
                    problem.place.line >= 1 && problem.place.column >= 1,
                    "{problem}"
                );
                assert!(
                    !problem.message.is_empty() && !problem.remedy.is_empty(),
                    "{problem}"
                );
            }
        }
        Ok(loaded) => {
            let model = &loaded.model;
            for (index, link) in model.links.iter().enumerate() {
                assert!(
                    link.parent.is_none_or(|parent| parent < index),
                    "parents come first"
                );
            }
            let links: Vec<usize> = model.joints.iter().map(|joint| joint.link).collect();
            assert!(links.is_sorted(), "joints are listed by link");
            let poses = model
                .poses(&model.reference_positions())
                .expect("its own positions");
            for pose in poses {
                let norm: f64 = pose.rotation.iter().map(|x| x * x).sum();
                assert!((norm - 1.0).abs() < 1e-9 && pose.position_m.iter().all(|x| x.is_finite()));
            }
            if let Ok(written) = to_mjcf(model, &MjcfOptions::default()) {
                let again = load("again.xml", &written.text);
                assert!(
                    again.is_ok(),
                    "what we write, we read: {}",
                    again.expect_err("problems")
                );
            }
        }
    }
}

#[test]
fn deep_nesting_is_refused_and_not_followed() {
    for depth in [401, 100_000] {
        let text = format!("{}{}", "<robot>".repeat(depth), "</robot>".repeat(depth));
        let answer = load("deep.urdf", &text);
        sound(&answer);
        assert!(
            answer
                .expect_err("too deep")
                .to_string()
                .contains("nested more than 400")
        );
    }
    let unclosed = "<a b='/>'>".repeat(100_000);
    sound(&load("open.urdf", &unclosed));
}

#[test]
fn long_chains_are_read_and_written_without_recursion() {
    let count = 3_000;
    let mut text = String::from("<robot name='chain'>");
    for index in 0..count {
        text += &format!("<link name='l{index}'/>");
    }
    for index in 1..count {
        let parent = index - 1;
        text += &format!(
            "<joint name='j{index}' type='fixed'><origin xyz='0 0 0.001'/><parent link='l{parent}'/><child link='l{index}'/></joint>"
        );
    }
    text += "</robot>";
    let loaded = load("chain.urdf", &text).expect("a chain");
    let poses = loaded.model.poses(&[]).expect("nothing moves");
    assert!((poses[count - 1].position_m[2] - 2.999).abs() < 1e-9);
    let written = to_mjcf(&loaded.model, &MjcfOptions::default()).expect("a text");
    assert_eq!(written.text.matches("<body ").count(), count);
}

#[test]
fn includes_that_multiply_are_stopped() {
    let many = "<include file='x.xml'/>".repeat(100);
    let text = format!("<mujoco>{many}</mujoco>");
    let mut asked = 0;
    let mut resolve = |_: &str| {
        asked += 1;
        Ok(text.clone().into_bytes())
    };
    let answer = parse("x.xml", &text, &mut resolve);
    sound(&answer);
    assert!(answer.is_err() && asked <= 2_000, "{asked}");
}

#[test]
fn names_with_signs_of_xml_survive_writing() {
    let text = "<robot name='a &lt;b&gt; &amp; \"c\"'><link name='x &lt;&quot;&gt;'/></robot>";
    let loaded = load("r.urdf", text).expect("a robot");
    let written = to_mjcf(&loaded.model, &MjcfOptions::default()).expect("a text");
    let again = load("again.xml", &written.text).expect("well-formed");
    assert_eq!(again.model.links[0].name, "x <\">");
    assert_eq!(again.model.name, loaded.model.name);
}

#[test]
fn damaged_meshes_are_problems_or_gaps() {
    let robot = |name: &str| {
        format!(
            "<robot name='r'><link name='a'><collision><geometry><mesh filename='{name}'/></geometry></collision></link></robot>"
        )
    };
    let cases: [(&str, &[u8]); 7] = [
        ("a.stl", b""),
        ("b.stl", b"solid x\nvertex 1 2\nendsolid"),
        ("c.stl", b"solid x\nvertex 1 2 3\nvertex 1 2 3\nendsolid"),
        ("d.stl", &[0xff; 90]),
        ("e.obj", b"v 0 0 0\nf 1 2 3\n"),
        ("f.obj", b"v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
        ("g.obj", b"v 1e300 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
    ];
    for (name, bytes) in cases {
        let answer = parse("r.urdf", &robot(name), &mut |_: &str| Ok(bytes.to_vec()));
        sound(&answer);
        let problems = answer.expect_err("damaged").to_string();
        assert!(problems.contains("is damaged"), "{name}: {problems}");
    }
}

/// A text with some bytes cut out, doubled or replaced.
fn varied(text: &'static str) -> impl Strategy<Value = String> {
    let words = prop::sample::select(vec![
        "NaN", "-1", "1e300", "0", "<", ">", "/>", "\"", "world", "a", "<link/>", "<joint>", "::",
        "",
    ]);
    let cuts = prop::collection::vec((0..text.len(), 0_usize..40, words), 1..6);
    cuts.prop_map(move |cuts| {
        let mut bytes = text.as_bytes().to_vec();
        for (start, length, word) in cuts {
            let start = start.min(bytes.len());
            let end = (start + length).min(bytes.len());
            bytes.splice(start..end, word.bytes());
        }
        String::from_utf8_lossy(&bytes).into_owned()
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn varied_urdf_is_read_or_refused(text in varied(ARM)) {
        sound(&load("v.urdf", &text));
    }

    #[test]
    fn varied_sdf_is_read_or_refused(text in varied(BASE)) {
        sound(&load("v.sdf", &text));
    }

    #[test]
    fn varied_mjcf_is_read_or_refused(text in varied(SWING)) {
        sound(&load("v.xml", &text));
    }

    #[test]
    fn varied_meshes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..400), name in prop::sample::select(vec!["m.stl", "m.obj"])) {
        let text = format!("<mujoco><asset><mesh name='m' file='{name}'/></asset><worldbody><body><geom type='mesh' mesh='m'/></body></worldbody></mujoco>");
        sound(&parse("m.xml", &text, &mut |_: &str| Ok(bytes.clone())));
    }
}
