//! Rare events as a user meets them: in a scene whose exact answers are known, interrupted, and
//! asked for wrongly. Files that are wrong are in the tests of the library.
//!
//! Needs the physics library; without it the tests that simulate are skipped with a line that says
//! so, except in continuous integration, where nothing is skipped.

use crate::support;

use serde_json::Value;
use support::program::Said;
use support::simulation::{library, simulating};
use support::{copy_study, read, root, schema};

/// A robot that stands still; its pose is measured ten times a second with a known error.
const SCENE: &str = r#"
name = "standing"
simulation = { duration_secs = 2.0, time_step_secs = 0.01 }

[[robot]]
name = "carrier"
file = "carrier.urdf"
y_m = 0

[[sensor]]
name = "pose"
robot = "carrier"
kind = "pose"
rate_hz = 10
noise = { x_m = 1.0 }

[[abstract_test]]
name = "nothing"
actions = []
"#;

/// A measurement is beyond 1.2816 with probability 0.1; `k` in a row last `(k - 1) / 10` s.
const EVENTS: &str = r#"
scene = "simulation/standing.toml"
test = "nothing"

[[event]]
name = "three in a row"
meaning = "Three measurements in a row are 1.28 m off."
longest = "/sensor/pose.x > 1.2816"
levels = [0.0, 0.1]
limit = 0.2
until_secs = 2.0
particles = 60
killed = 12
replications = 5
plain = 256

[[event]]
name = "six in a row"
meaning = "Six measurements in a row are 1.28 m off."
longest = "/sensor/pose.x > 1.2816"
levels = [0.0, 0.1, 0.2, 0.3, 0.4]
limit = 0.5
until_secs = 2.0
particles = 60
killed = 12
replications = 5

[[event]]
name = "far to the left"
meaning = "The robot is placed where one in a thousand is."
greatest = "/truth/carrier.y"
limit = 3.0902
until_secs = 0.1
particles = 100
killed = 20
replications = 4

[[event.parameter]]
name = "place"
unit = "m"
sets = ["robot.carrier.y_m"]
normal = [0.0, 1.0]

[[event]]
name = "violated to the left"
meaning = "The same, as a requirement."
requirement = "place"
until_secs = 0.1
particles = 100
killed = 20
replications = 4

[[event.parameter]]
name = "place"
unit = "m"
sets = ["robot.carrier.y_m"]
normal = [0.0, 1.0]
"#;

/// The third event as a requirement.
const REQUIREMENT: &str = r#"
[[requirement]]
id = "place"
text = "The robot is not far to the left."
shall = "The robot shall always satisfy placed."
margin = 0.05
"#;

const WORD: &str = r#"
[placed]
meaning = "The robot is where 999 in 1000 are."
trace = "/truth/carrier.y < 3.0902 m"
"#;

/// The corridor's study with the scene and the file, changed.
fn study(old: &str, new: &str) -> tempfile::TempDir {
    let folder = tempfile::TempDir::new().expect("a folder");
    copy_study(&root().join("case-studies/corridor"), folder.path());
    assert!(EVENTS.contains(old), "no `{old}`");
    for (file, more) in [
        ("requirements.toml", REQUIREMENT),
        ("vocabulary.toml", WORD),
    ] {
        let file = folder.path().join(file);
        std::fs::write(&file, read(&file) + more).expect("written");
    }
    let scene = folder.path().join("simulation/standing.toml");
    std::fs::write(scene, SCENE).expect("written");
    let events = EVENTS.replacen(old, new, 1);
    std::fs::write(folder.path().join("rare.toml"), events).expect("written");
    folder
}

fn json(said: &Said) -> Value {
    serde_json::from_str(&said.out).unwrap_or_else(|error| panic!("{error}: {said:?}"))
}

/// The probability of `k` successes in a row among `n` trials of probability `p`, by the chain of
/// the length of the run so far.
fn in_a_row(n: usize, k: usize, p: f64) -> f64 {
    let (mut lengths, mut done) = (vec![0.0; k], 0.0);
    lengths[0] = 1.0;
    for _ in 0..n {
        let all: f64 = lengths.iter().sum();
        done += lengths[k - 1] * p;
        lengths.rotate_right(1);
        lengths.iter_mut().for_each(|length| *length *= p);
        lengths[0] = all * (1.0 - p);
    }
    done
}

#[test]
fn a_scene_gives_the_exact_probabilities_and_the_same_again() {
    let Some(library) = library() else { return };
    let folder = study("three", "three");
    let arguments = ["rare", ".", "rare.toml", "--format", "json", "-j", "1"];
    let said = simulating(&library, folder.path(), &arguments);
    assert_eq!(said.code, 0, "{said:?}");
    let report = json(&said);
    let schema: Value =
        serde_json::from_str(&read(&root().join("schemas/rare.schema.json"))).expect("a schema");
    let violations = schema::violations(&schema, &report);
    assert!(violations.is_empty(), "{violations:?}");
    let number = |event: usize, key: &str| report["events"][event][key].as_f64().expect("a number");
    // 20 or 21 measurements, as one is made at the beginning and maybe one at the end.
    let exact = |k: usize| (in_a_row(20, k, 0.1), in_a_row(21, k, 0.1));
    // Of seeded runs: intervals at 95 % widened by half, lest a right answer fail.
    let within = |event: usize, (low, high): (f64, f64)| {
        let (from, to) = (number(event, "low") / 1.5, number(event, "high") * 1.5);
        assert!(from < high && low < to, "{}", report["events"][event]);
    };
    within(0, exact(3));
    within(1, exact(6));
    within(2, (1e-3, 1e-3));
    within(3, (1e-3, 1e-3));
    assert!(number(1, "probability") < 2e-4 && number(1, "high") < 1e-3);
    assert!(number(1, "episode_equivalents") < 3000.0);
    let plain = &report["events"][0]["plain"];
    assert_eq!(plain["episodes"], 256);
    assert!(plain["p_value"].as_f64() > Some(0.01), "{plain}");
    assert!(
        report["events"][2]["guarantee"]
            .as_str()
            .is_some_and(|it| it.contains("bias"))
    );

    // Another number of threads in another folder gives the same bytes; what is kept does, too.
    let other = [
        "rare",
        ".",
        "rare.toml",
        "--format",
        "json",
        "-j",
        "2",
        "--out",
        "other",
    ];
    assert_eq!(simulating(&library, folder.path(), &other).out, said.out);
    let table = |folder_of: &str| {
        let path = folder.path().join(folder_of).join("episodes.parquet");
        std::fs::read(path).expect("a table")
    };
    assert!(table("other") == table("results/rare") && table("other").starts_with(b"PAR1"));
    assert_eq!(
        simulating(&library, folder.path(), &arguments).out,
        said.out
    );
}

#[test]
fn wrong_names_of_signals_tests_and_keys_are_said_before_anything_runs() {
    let Some(library) = library() else { return };
    for (old, new, message) in [
        (
            "/sensor/pose.x > 1.2816\"\nlevels = [0.0, 0.1]",
            "/sensor/posse.x > 1.2816\"\nlevels = [0.0, 0.1]",
            "posse",
        ),
        ("test = \"nothing\"", "test = \"nothin\"", "nothing"),
        (
            "requirement = \"place\"",
            "requirement = \"plase\"",
            "did you mean `place`",
        ),
        ("unit = \"m\"", "unit = \"mm\"", "1 mm = 0.001 m"),
        ("robot.carrier.y_m", "robot.carrier.y_mm", "y_mm"),
        (
            "simulation/standing.toml",
            "simulation/sitting.toml",
            "sitting",
        ),
    ] {
        let folder = study(old, new);
        let arguments = ["rare", ".", "rare.toml"];
        let said = simulating(&library, folder.path(), &arguments);
        assert_eq!(said.code, 2, "{new}: {said:?}");
        assert!(said.talk.contains(message), "{new}: {said:?}");
        let kept = folder.path().join("results/rare");
        let parts = std::fs::read_dir(kept).into_iter().flatten().flatten();
        let mut parts = parts.filter(|it| it.path().extension().is_some_and(|it| it == "json"));
        assert!(parts.next().is_none(), "{new}: nothing should have run");
    }
}
