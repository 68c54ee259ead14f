//! What `corroborate check` says of bad models, properties and constants: every mistake with its place, and the rest answered.

use crate::support;

use super::bad_input::assert_refused;
use support::program::{Said, Study, corroborate};
use support::root;

/// `corroborate check` on the wrong models of `conformance/bad`: each of their mistakes is shown with its line.
#[test]
fn check_shows_every_mistake_of_a_model_at_once() {
    let folder = root().join("conformance/bad");
    let said = corroborate(&folder, &["check", "names.prism"]);
    assert_eq!(said.code, 2, "{said:?}");
    for line in [
        "names.prism:6:34",
        "names.prism:7:6",
        "names.prism:8:17",
        "names.prism:10:25",
    ] {
        assert!(
            said.talk.contains(line),
            "{line} is missing:\n{}",
            said.talk
        );
    }
    assert!(
        said.talk.contains("did you mean") || said.talk.contains("Did you mean"),
        "{}",
        said.talk
    );
}

#[test]
fn check_names_the_place_in_a_property_of_the_command_line() {
    let folder = root().join("conformance/models");
    let said = corroborate(
        &folder,
        &["check", "knuth_die.prism", "P=? [ F \"finished\" ]"],
    );
    assert_refused(&said, "unknown-label", "<property>:1:9");
    let said = corroborate(&folder, &["check", "knuth_die.prism", "P=? [ F s=7"]);
    assert_refused(&said, "syntax", "<property>:1:");
    let said = corroborate(&folder, &["check", "knuth_die.prism", "missing.props"]);
    assert_refused(&said, "cannot-read", "missing.props");
}

#[test]
fn check_refuses_constants_that_do_not_fit() {
    let folder = root().join("conformance/models");
    let check = |constants| {
        corroborate(
            &folder,
            &[
                "check",
                "gambler.prism",
                "P=? [ F money=0 ]",
                "--const",
                constants,
            ],
        )
    };
    assert_refused(
        &check("N=3,k=1,p=1.5"),
        "not-a-probability",
        "gambler.prism:11:27",
    );
    assert_refused(
        &check("N=3,k=9,p=0.5"),
        "init-out-of-range",
        "gambler.prism:10",
    );
    assert_refused(&check("N=3,k=1,p=0.5,q=1"), "unknown-constant", "q");
    assert_refused(&check("N=1e30,k=1,p=0.5"), "type", "gambler.prism:5");
    assert_refused(&check("N=,k=1"), "bad-constants", "--const");
}

#[test]
fn a_call_that_is_wrong_says_what_is_right() {
    let study = Study::new();
    for arguments in [
        &["chekc"][..],
        &["check"],
        &["run", "study", "--treads", "2"],
        &["run", "study", "-j", "0"],
    ] {
        let said = study.run(arguments);
        assert_eq!(said.code, 2, "{said:?}");
        assert!(
            said.out.is_empty() && said.talk.contains("--help") || said.talk.contains("Usage"),
            "{said:?}"
        );
    }
}

/// A syntax error costs its own property; the others are answered.
#[test]
fn check_answers_the_properties_beside_one_with_a_syntax_error() {
    let study = Study::new();
    study.write(
        "some.props",
        "P=? [ F s=7 & d=1 ];\n\"half\": P=? [ F s=7 ;\nP=? [ F s=7 & d=2 ]\n",
    );
    let model = root().join("conformance/models/knuth_die.prism");
    let model = model.to_string_lossy();
    let said = study.run(&["check", &model, "study/some.props", "--format", "json"]);
    assert_eq!(said.code, 2, "{said:?}");
    assert!(said.talk.contains("study/some.props:2:"), "{}", said.talk);
    let report: serde_json::Value = serde_json::from_str(&said.out).expect("a report");
    let properties = report["properties"].as_array().expect("properties");
    let answers: Vec<_> = properties.iter().map(|p| p["value"].as_f64()).collect();
    assert_eq!((answers.len(), answers[1]), (3, None), "{report}");
    for answer in [answers[0], answers[2]] {
        assert!(
            (answer.expect("a value") - 1.0 / 6.0).abs() < 1e-6,
            "{report}"
        );
    }
    assert_eq!(properties[1]["name"], "half");
    let error = properties[1]["error"].as_str().expect("why not");
    assert!(error.contains("some.props:2:"), "{error}");
}

/// Older models have an accent in Latin-1: they are read, and places are right behind it.
#[test]
fn check_reads_latin_1_with_a_note() {
    let study = Study::new();
    let text = b"// Caf\xE9\ndtmc\nmodule m x : [0..1]; [] x=0 -> (x'=1); endmodule\n";
    study.write("old.nm", text);
    let said = study.run(&["check", "study/old.nm", "P=? [ F x=1 ]"]);
    assert_eq!(said.code, 0, "{said:?}");
    assert!(said.talk.contains("study/old.nm:1:7: "), "{}", said.talk);
    study.write("old.nm", b"// \xE9\xE9\xE9\ndtmc /* module".as_slice());
    let said = study.run(&["check", "study/old.nm", "P=? [ F x=1 ]"]);
    assert!(said.talk.contains("study/old.nm:2:6"), "{}", said.talk);
}

/// Inputs without end, or with 100,000 mistakes: one short message.
#[test]
fn check_has_limits_from_the_first_byte() {
    let study = Study::new();
    let short = |said: &Said, code: &str| {
        assert_eq!(said.code, 2, "{}", said.talk.len());
        assert!(
            said.talk.contains(&format!("error[{code}]")),
            "{}",
            &said.talk[..300]
        );
        assert!(said.talk.len() < 40_000, "{} bytes", said.talk.len());
    };
    #[cfg(target_os = "linux")]
    short(&study.run(&["check", "/dev/zero"]), "cannot-read");
    let commands = "  [] y=0 -> (x'=1);\n".repeat(100_000);
    study.write(
        "many.prism",
        format!("dtmc\nmodule m x : [0..1];\n{commands}endmodule\n"),
    );
    let said = study.run(&["check", "study/many.prism"]);
    short(&said, "unknown-name");
    assert!(
        said.talk.contains("99950 more mistakes are not shown"),
        "{}",
        said.talk
    );
    let digits = "7".repeat(2_000_000);
    study.write(
        "long.prism",
        format!("dtmc\nmodule m x : [0..{digits}]; endmodule\n"),
    );
    short(
        &study.run(&["check", "study/long.prism"]),
        "literal-too-large",
    );
    study.write(
        "long.prism",
        format!("dtmc\nconst double p = 0.{digits};\n"),
    );
    short(
        &study.run(&["check", "study/long.prism"]),
        "literal-too-large",
    );
    let copies =
        (1..3_000).map(|i| format!("module m{i} = m{} [x{}=x{i}] endmodule\n", i - 1, i - 1));
    let copies: String = copies.collect();
    let text = format!("mdp\nmodule m0 x0 : [0..1]; [] z=0 -> (x0'=1); endmodule\n{copies}");
    study.write("copies.prism", text);
    short(&study.run(&["check", "study/copies.prism"]), "unknown-name");
}

/// Rounded probabilities: an error that names PRISM's option; with it, bounds that contain what was meant.
#[test]
fn check_takes_rounded_probabilities_where_it_is_asked_to() {
    let study = Study::new();
    let text = "dtmc\nmodule m x : [0..3];\n\
        [] x=0 -> 0.333333:(x'=1) + 0.333333:(x'=2) + 0.333333:(x'=3);\nendmodule\n\
        rewards \"r\" true : 1; endrewards\n";
    study.write("third.prism", text);
    let asked = ["check", "study/third.prism", "P=? [ F x=1 ]"];
    let said = study.run(&asked);
    assert_refused(&said, "probability-sum", "third.prism:3:1");
    assert!(said.talk.contains("-sumroundoff"), "{}", said.talk);
    for method in ["sound", "exact"] {
        let with = [
            &asked[..],
            &[
                "-sumroundoff",
                "1e-5",
                "--method",
                method,
                "--format",
                "json",
            ],
        ];
        let said = study.run(&with.concat());
        assert_eq!(said.code, 0, "{said:?}");
        let report: serde_json::Value = serde_json::from_str(&said.out).expect("a report");
        let answer = &report["properties"][0];
        assert_eq!(
            (&answer["guarantee"], &answer["exact"]),
            (&"bounded".into(), &false.into())
        );
        let (low, high) = (
            answer["low"].as_f64().expect("low"),
            answer["high"].as_f64().expect("high"),
        );
        // The missing millionth may belong to this outcome, or to the others.
        assert!(
            low <= 0.333333 && 0.333334 <= high && high - low < 3e-6,
            "{low} {high}"
        );
    }
    // Of rewards there are no such bounds, and of choices neither.
    let rewards = [
        "check",
        "study/third.prism",
        "R=? [ F x>0 ]",
        "-sumroundoff",
        "1e-5",
        "--format",
        "json",
    ];
    let said = study.run(&rewards);
    let report: serde_json::Value = serde_json::from_str(&said.out).expect("a report");
    assert_eq!(
        report["properties"][0]["guarantee"], "estimated",
        "{report}"
    );
    study.edit("third.prism", "dtmc", "mdp");
    let choices = [
        "check",
        "study/third.prism",
        "Pmax=? [ F x=1 ]",
        "-sumroundoff",
        "1e-5",
        "--format",
        "json",
    ];
    let said = study.run(&choices);
    let report: serde_json::Value = serde_json::from_str(&said.out).expect("a report");
    assert_eq!(
        report["properties"][0]["guarantee"], "estimated",
        "{report}"
    );
    // A sum that misses 1 by more than is asked for.
    let said = study.run(&[&choices[..4], &["1e-7"]].concat());
    assert_refused(&said, "probability-sum", "third.prism:3:1");
}
