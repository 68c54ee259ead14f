//! Programs that fail in some episodes only: they are counted and found, and nothing is blocked by them.
//!
//! Needs `python3`, in which the programs are written. What is simulated in physics needs its library, too; without it
//! those tests are skipped with a line that says so, except in continuous integration, where nothing is skipped.

use crate::support;

use serde_json::Value;
use std::path::Path;
use support::program::{Said, code_of_verdicts, contents, corroborate};
use support::simulation::{driven, library};

/// A copy of a study of the repository, with changes: file, old, new.
fn copy_of(study: &str, changes: &[(&str, &str, &str)]) -> tempfile::TempDir {
    let folder = tempfile::TempDir::new().expect("a folder");
    let from = support::root().join(study);
    for (path, bytes) in contents(&from) {
        let name = path.strip_prefix(&from).expect("inside");
        if !name.starts_with("results") {
            let to = folder.path().join(name);
            std::fs::create_dir_all(to.parent().expect("a folder")).expect("made");
            std::fs::write(to, bytes).expect("written");
        }
    }
    for (file, old, new) in changes {
        let path = folder.path().join(file);
        let text = std::fs::read_to_string(&path).expect("a text");
        assert!(text.contains(old), "{file} has no `{old}`");
        std::fs::write(&path, text.replacen(old, new, 1)).expect("written");
    }
    folder
}

fn json(said: &Said) -> Value {
    serde_json::from_str(&said.out).unwrap_or_else(|error| panic!("{error}: {said:?}"))
}

fn bytes(path: &Path) -> Vec<u8> {
    std::fs::read(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// The cart's simulator, which dies of a wrong address in one seed of five, and says in which it has run.
fn dying_simulator() -> tempfile::TempDir {
    let begins = "    stimulus, seed, recording = sys.argv[1:]\n";
    let dies = format!(
        "{begins}    open(\"begun\", \"a\").write(seed + \"\\n\")\n    if int(seed) % 5 == 0:\n        \
         print(\"out of its tracks\", file=sys.stderr, flush=True)\n        \
         __import__(\"os\").kill(__import__(\"os\").getpid(), 11)\n"
    );
    copy_of("conformance/command", &[("simulate.py", begins, &dies)])
}

fn begun(folder: &Path) -> Vec<u64> {
    let text = std::fs::read_to_string(folder.join("begun")).expect("seeds");
    text.lines()
        .map(|line| line.parse().expect("a seed"))
        .collect()
}

#[test]
fn a_simulator_that_dies_in_some_seeds_is_counted_and_neither_lost_nor_repeated() {
    let folder = dying_simulator();
    let simulate = |threads: &str, more: &[&str]| {
        let mut arguments = vec![
            "simulate", ".", "sim", "-n", "40", "-j", threads, "--out", threads,
        ];
        arguments.extend(more);
        corroborate(folder.path(), &arguments)
    };
    let first = simulate("1", &["--format", "json"]);
    assert_eq!(first.code, code_of_verdicts(&json(&first)), "{first:?}");
    let mut seeds = begun(folder.path());
    seeds.sort_unstable();
    let dead = seeds.iter().filter(|seed| *seed % 5 == 0).count() as u64;
    assert_eq!(seeds.len(), 40);
    assert!((1..40).contains(&dead), "{dead}");
    let report = json(&first);
    let failure = &report["failures"][0];
    assert_eq!(failure["kind"], "simulator-failed", "{report}");
    assert_eq!(
        (failure["count"].as_u64(), failure["trials"].as_u64()),
        (Some(dead), Some(40))
    );
    let words = failure["said"].as_str().expect("a file");
    let words = String::from_utf8(bytes(&folder.path().join(words))).expect("text");
    assert!(
        words.contains("out of its tracks") && words.contains("signal: 11"),
        "{words}"
    );
    // A requirement is judged on what is left: no trial has come from nowhere.
    let trials = report["estimates"][0]["trials"].as_u64();
    assert_eq!(trials, Some(40 - dead), "{report}");

    // Another call repeats none of them, in another number of threads they are the same bytes.
    assert_eq!(simulate("1", &["--format", "json"]).out, first.out);
    assert_eq!(begun(folder.path()).len(), 40);
    assert_eq!(simulate("3", &[]).code, first.code);
    for file in ["journal", "episodes.parquet"] {
        let of = |threads: &str| bytes(&folder.path().join(threads).join(file));
        assert!(of("1") == of("3"), "{file}");
    }
    let text = simulate("1", &[]).out;
    assert!(
        text.contains("simulator-failed") && text.contains("the simulator fails"),
        "{text}"
    );

    // Who wants it to stop there is told where, whether it was counted before or not.
    for threads in ["1", "2"] {
        let stopped = simulate(threads, &["--on-failure", "stop"]);
        assert_eq!((stopped.code, stopped.out.as_str()), (2, ""), "{stopped:?}");
        assert!(
            stopped.talk.contains("out of its tracks"),
            "{}",
            stopped.talk
        );
        assert!(
            stopped.talk.contains("--on-failure count"),
            "{}",
            stopped.talk
        );
    }
    let counted = simulate("2", &[]);
    assert_eq!(counted.code, first.code, "{counted:?}");
    assert!(bytes(&folder.path().join("1/journal")) == bytes(&folder.path().join("2/journal")));
}

#[test]
fn a_failure_stands_in_the_evidence_in_the_report_and_is_verified() {
    let folder = dying_simulator();
    std::fs::write(folder.path().join("exploration.toml"), CARTS).expect("written");
    let explore = ["explore", ".", "exploration.toml", "--causes", "3"];
    let explored = corroborate(folder.path(), &explore);
    assert_eq!(explored.code, 1, "{explored:?}");
    std::fs::remove_file(folder.path().join("begun")).expect("seeds of the exploration");
    let run = corroborate(folder.path(), &["run", "."]);
    assert!([0, 1, 3].contains(&run.code), "{run:?}");
    assert!(run.talk.contains("the simulator fails in"), "{}", run.talk);
    let study: Value =
        serde_json::from_slice(&bytes(&folder.path().join("results/study.json"))).expect("JSON");
    let failure = &study["evidence"][0]["failures"][0];
    let dead = begun(folder.path())
        .iter()
        .filter(|seed| *seed % 5 == 0)
        .count() as u64;
    assert_eq!(failure["kind"], "simulator-failed");
    assert_eq!(
        failure["measure"]["count"].as_u64(),
        Some(dead),
        "{failure}"
    );
    assert_eq!(failure["measure"]["trials"].as_u64(), Some(40));
    let page = String::from_utf8(bytes(&folder.path().join("results/report.html"))).expect("text");
    assert!(
        page.contains("the simulator fails"),
        "it is not in the report"
    );
    // What was explored stands there, each cause with what runs it again.
    for finding in study["exploration"]["findings"]
        .as_array()
        .expect("findings")
    {
        for cause in finding["causes"].as_array().expect("causes") {
            let file = cause["file"].as_str().expect("a file");
            let file = file.rsplit('/').next().expect("a name");
            assert!(page.contains(file), "{file} is not in the report");
        }
    }
    let verified = corroborate(folder.path(), &["verify", "results", "--deep"]);
    assert_eq!(verified.code, 0, "{verified:?}");
    let again = "scenarios of findings show again what was found";
    assert!(verified.out.contains(again), "{}", verified.out);

    // An episode without a recording is none that violated anything, and none that did not.
    let diagnosed = corroborate(folder.path(), &["diagnose", ".", "--format", "json"]);
    assert!([0, 1].contains(&diagnosed.code), "{diagnosed:?}");
    for cell in json(&diagnosed)["cells"].as_array().expect("cells") {
        if cell["subject"]["id"] == "clear" && cell["trials"] != 0 {
            assert_eq!(cell["trials"].as_u64(), Some(40 - dead), "{cell}");
        }
    }

    // Of another plan it says nothing.
    let plan = folder.path().join("exploration.toml");
    std::fs::write(&plan, format!("{CARTS}# Later.\n")).expect("written");
    let later = corroborate(folder.path(), &["run", ".", "--format", "json"]);
    assert!(
        later.talk.contains("the exploration is left out"),
        "{}",
        later.talk
    );
    assert_eq!(json(&later)["exploration"], Value::Null);

    // Who writes another count into the evidence is found out.
    let kept = std::fs::read_dir(folder.path().join("results/evidence")).expect("evidence");
    let kept = kept
        .flatten()
        .map(|entry| entry.path())
        .next()
        .expect("a file");
    let mut edited: Value = serde_json::from_slice(&bytes(&kept)).expect("JSON");
    edited["content"]["failures"] = Value::Array(Vec::new());
    std::fs::write(&kept, edited.to_string()).expect("edited");
    let verified = corroborate(folder.path(), &["verify", "results"]);
    assert_ne!(verified.code, 0, "{verified:?}");
    assert!(format!("{verified:?}").contains("failures"), "{verified:?}");
}

/// How the cart's own simulator is explored: its speed and braking vary.
const CARTS: &str = r#"
evidence = "sim"
sources = ["own", "random"]
designs = ["boundary", "random"]

[budget]
episodes = 12
batch = 6

[grammar]
name = "random"
length = [1, 2]

[[grammar.action]]
send_signal = "go"

[[parameter]]
name = "speed"
sets = ["cart.speed_cm_per_s"]
uniform = [100.0, 200.0]
nominal = 150.0
"#;

/// Each episode of a finding has met one of its causes, or is said to have met none.
fn grouped_by_cause(folder: &Path, found: &Value) {
    let causes = found["causes"].as_array().expect("causes");
    assert!(!causes.is_empty(), "{found}");
    let counts = causes
        .iter()
        .map(|it| it["episodes"].as_u64().expect("a count"));
    let without = found["without_cause"].as_u64().expect("a count");
    assert_eq!(
        counts.sum::<u64>() + without,
        found["episodes"].as_u64().expect("a count")
    );
    for cause in causes {
        assert!(
            folder
                .join("again")
                .join(cause["file"].as_str().expect("a file"))
                .exists()
        );
    }
    // The simulator dies of its seed, whatever is done and set.
    if found["shows"]["failed"] == "simulator-failed" {
        assert_eq!((causes.len(), without), (1, 0), "{found}");
        assert_eq!(
            (&causes[0]["settings"], &causes[0]["test"]),
            (&Value::Array(Vec::new()), &"".into())
        );
    }
}

#[test]
fn another_simulator_is_explored_shrunk_and_replayed() {
    let folder = dying_simulator();
    std::fs::write(folder.path().join("exploration.toml"), CARTS).expect("written");
    let call = |arguments: &[&str]| corroborate(folder.path(), arguments);
    let explore = |out: &str, more: &[&str]| {
        let mut arguments = vec!["explore", ".", "exploration.toml", "--out", out];
        arguments.extend(["--format", "json"]);
        arguments.extend(more);
        let said = call(&arguments);
        assert_eq!(said.code, 1, "{said:?}");
        json(&said)
    };
    let report = explore("out", &[]);
    assert_eq!(report["episodes"], 12, "{report}");
    let mut again = explore("again", &["--causes", "12"]);
    for found in again["findings"].as_array_mut().expect("findings") {
        grouped_by_cause(folder.path(), found);
        found["causes"] = Value::Array(Vec::new());
        found["without_cause"] = Value::Null;
    }
    assert_eq!(again, report);
    let table = |out: &str| bytes(&folder.path().join(out).join("episodes.parquet"));
    assert!(table("out") == table("again") && table("out").starts_with(b"PAR1"));
    let findings = report["findings"].as_array().expect("findings");
    assert!(findings.iter().all(|it| it["replayed"] == true), "{report}");
    let find = |what: &str, id: &str| {
        let mut all = findings.iter();
        let found = all.find(|it| it["shows"][what] == id);
        let found = found.unwrap_or_else(|| panic!("{what} {id}: {report}"));
        format!("out/{}", found["file"].as_str().expect("a file"))
    };
    for (file, name) in [
        (find("violated", "clear"), "touches"),
        (find("failed", "simulator-failed"), "dies"),
    ] {
        let arguments = [
            "shrink", ".", &file, "--name", name, "--budget", "60", "--format", "json",
        ];
        let said = call(&arguments);
        assert_eq!(said.code, 0, "{said:?}");
        let report = json(&said);
        assert_eq!(report["after"]["actions"], 0, "{report}");
        let reason = report["not_pinned"].as_str().expect("a reason");
        assert!(reason.contains("does not say"), "{reason}");
        let regression = format!("regressions/{name}.toml");
        let said = call(&["replay", ".", &regression, "--format", "json"]);
        assert_eq!(said.code, 0, "{said:?}");
        assert!(said.talk.contains("shows no bodies"), "{}", said.talk);
        let replayed = json(&said);
        assert_eq!(replayed["shown"], true, "{replayed}");
        assert_eq!(replayed["same_bytes"], true, "{replayed}");
        let page = format!("results/replays/{name}/replay.html");
        assert!(folder.path().join(page).exists());
    }
    let checked = call(&["replay", ".", "--check"]);
    assert_eq!(checked.code, 0, "{checked:?}");
    assert!(checked.out.contains("2 of 2"), "{}", checked.out);

    // An episode of the campaign is the same one.
    let simulated = call(&[
        "simulate", ".", "sim", "-n", "10", "--out", "recorded", "--format", "json",
    ]);
    let first = json(&simulated)["failures"][0]["first_episode"]
        .as_u64()
        .expect("one dies");
    let said = call(&["replay", ".", &format!("sim:{first}"), "--format", "json"]);
    assert_eq!(json(&said)["failed"], "simulator-failed", "{said:?}");
    assert!(
        json(&said)["said"]
            .as_str()
            .expect("words")
            .contains("out of its tracks")
    );
}

/// An event that no run comes to, whether its program fails or not.
const SPLIT: &str = r#"
scene = "simulation/scene.toml"
test = "ben_crosses"

[[event]]
name = "far"
meaning = "The robot is far along."
greatest = "/truth/carrier.x"
levels = [0.5]
limit = 30.0
until_secs = 12.0
particles = 4
killed = 2
replications = 2
plain = 4
"#;

#[test]
fn a_program_that_fails_is_counted_where_runs_are_split_and_engines_compared() {
    let Some(library) = library() else { return };
    let folder = corridor("raise ValueError(\"no way to stop\")");
    let scene = folder.path().join("simulation/scene.toml");
    let mut text = std::fs::read_to_string(&scene).expect("a scene");
    // For what the test waits.
    for (old, new) in [
        ("time_step_secs = 0.002", "time_step_secs = 0.005"),
        ("duration_secs = 40", "duration_secs = 14"),
    ] {
        assert!(text.contains(old), "{text}");
        text = text.replace(old, new);
    }
    std::fs::write(&scene, text).expect("written");
    let call = |arguments: &[&str]| driven(&library, folder.path(), arguments);
    // Where the ledger says that a failure ends it all, it does, with the first one's words.
    let ledger = folder.path().join("ledger.toml");
    let counts = std::fs::read_to_string(&ledger).expect("a ledger");
    let stops = counts.replacen("id = \"S2\"\n", "id = \"S2\"\non_failure = \"stop\"\n", 1);
    assert_ne!(stops, counts);
    std::fs::write(&ledger, stops).expect("written");
    let said = call(&["engines", ".", "S2", "-n", "1"]);
    assert_eq!((said.code, said.out.as_str()), (2, ""), "{said:?}");
    for words in ["episode 1", "no way to stop", "on_failure = \"stop\""] {
        assert!(said.talk.contains(words), "{}", said.talk);
    }
    std::fs::write(&ledger, counts).expect("written");
    let engines = ["engines", ".", "S2", "-n", "2", "--format", "json"];
    let said = call(&engines);
    assert!([0, 1].contains(&said.code), "{said:?}");
    let failures = &json(&said)["failures"][0];
    assert!(
        failures["engine"]
            .as_str()
            .is_some_and(|it| it.starts_with("MuJoCo")),
        "{said:?}"
    );
    let first = &failures["failures"][0];
    assert_eq!(first["kind"], "controller-failed", "{said:?}");
    assert_eq!(first["measure"]["trials"], 2, "{said:?}");

    std::fs::write(folder.path().join("rare.toml"), SPLIT).expect("written");
    let said = call(&["rare", ".", "rare.toml", "--format", "json"]);
    assert_eq!(said.code, 3, "it is never as far: {said:?}");
    let event = &json(&said)["events"][0];
    let (runs, plain) = (&event["failures"][0], &event["plain"]["failures"][0]);
    assert_eq!(runs["kind"], "controller-failed", "{event}");
    assert!(runs["count"].as_u64() <= runs["runs"].as_u64(), "{event}");
    assert_eq!(plain["kind"], "controller-failed", "{event}");
    assert_eq!(plain["measure"]["trials"], 4, "{event}");
    let text = call(&["rare", ".", "rare.toml"]).out;
    assert!(text.contains("which count up to there"), "{text}");
}

/// The corridor, whose program fails where it has to stop.
fn corridor(failing: &str) -> tempfile::TempDir {
    let outputs = "        outputs = Outputs(finished=self.state == \"arrived\")\n";
    let fails = format!("        if self.state == \"stop\":\n            {failing}\n{outputs}");
    // Its description moreover has what is not simulated.
    let lamp =
        "<gazebo reference=\"base\"><plugin name=\"lamp\" filename=\"lamp.so\"/></gazebo></robot>";
    copy_of(
        "case-studies/corridor",
        &[
            ("controller/corridor.py", outputs, &fails),
            ("simulation/carrier.urdf", "</robot>", lamp),
        ],
    )
}

#[test]
fn a_robots_program_that_fails_is_counted_and_the_campaign_goes_on() {
    let Some(library) = library() else { return };
    for (failing, kind, episodes) in [
        (
            "raise ValueError(\"no way to stop\")",
            "controller-failed",
            "6",
        ),
        ("__import__(\"os\")._exit(3)", "controller-failed", "6"),
        ("__import__(\"time\").sleep(600)", "controller-hung", "2"),
    ] {
        let folder = corridor(failing);
        if kind == "controller-hung" {
            // Long enough for a busy machine to start a program.
            let scene = folder.path().join("simulation/scene.toml");
            let text = std::fs::read_to_string(&scene).expect("a scene");
            let limit = "[[controller]]\nanswer_within_secs = 10.0";
            std::fs::write(&scene, text.replacen("[[controller]]", limit, 1)).expect("written");
        }
        let simulate = |threads: &str| {
            let arguments = [
                "simulate", ".", "S2", "-n", episodes, "-j", threads, "--out", threads, "--format",
                "json",
            ];
            let said = driven(&library, folder.path(), &arguments);
            let report = json(&said);
            assert_eq!(said.code, code_of_verdicts(&report), "{failing}: {said:?}");
            report
        };
        let report = simulate("1");
        let failure = &report["failures"][0];
        assert_eq!(failure["kind"], kind, "{failing}: {report}");
        let count = failure["count"].as_u64().expect("a count");
        assert!(count >= 1, "{report}");
        let recordings = report["recordings"].as_array().map(Vec::len);
        assert_eq!(recordings, episodes.parse().ok(), "{report}");
        let gap = &report["description_gaps"][0];
        assert_eq!(gap["file"], "simulation/carrier.urdf", "{report}");
        assert!(
            gap["element"]
                .as_str()
                .is_some_and(|it| it.contains("plugin")),
            "{report}"
        );
        simulate("2");
        let of = |threads: &str| bytes(&folder.path().join(threads).join("journal"));
        assert!(of("1") == of("2"), "{failing}");
    }
}

#[test]
fn a_program_that_cannot_be_set_up_is_a_mistake() {
    let Some(library) = library() else { return };
    let begins = "        lidar = setup.sensors[\"lidar\"]\n";
    let fails = format!("        raise ValueError(\"no map of this floor\")\n{begins}");
    let folder = copy_of(
        "case-studies/corridor",
        &[("controller/corridor.py", begins, &fails)],
    );
    for arguments in [
        &["simulate", ".", "S2", "-n", "2", "--out", "out"][..],
        &[
            "explore",
            ".",
            "exploration.toml",
            "-n",
            "4",
            "--out",
            "out",
        ],
    ] {
        let said = driven(&library, folder.path(), arguments);
        assert_eq!((said.code, said.out.as_str()), (2, ""), "{said:?}");
        assert!(said.talk.contains("no map of this floor"), "{}", said.talk);
        assert!(said.talk.contains("controller-failed"), "{}", said.talk);
    }
}

#[test]
fn a_robots_program_that_fails_is_found_shrunk_and_replayed() {
    let Some(library) = library() else { return };
    let folder = corridor("raise ValueError(\"no way to stop\")");
    let call = |arguments: &[&str]| driven(&library, folder.path(), arguments);
    let explored = call(&[
        "explore",
        ".",
        "exploration.toml",
        "-n",
        "8",
        "--out",
        "out",
        "--format",
        "json",
    ]);
    assert_eq!(explored.code, 1, "{explored:?}");
    let report = json(&explored);
    assert_eq!(
        report["broken"].as_array().map(Vec::len),
        Some(0),
        "{report}"
    );
    let mut findings = report["findings"].as_array().expect("findings").iter();
    let found = findings.find(|it| it["shows"]["failed"] == "controller-failed");
    let found = found.unwrap_or_else(|| panic!("{report}"));
    assert_eq!(found["replayed"], true, "{found}");
    let file = format!("out/{}", found["file"].as_str().expect("a file"));

    let shrunk = call(&["shrink", ".", &file, "--budget", "40", "--format", "json"]);
    assert_eq!(shrunk.code, 0, "{shrunk:?}");
    let (before, after) = (&json(&shrunk)["before"], &json(&shrunk)["after"]);
    assert!(after["actions"].as_u64() <= before["actions"].as_u64());
    let regression = json(&shrunk)["file"].as_str().expect("a file").to_owned();
    let replayed = call(&["replay", ".", &regression, "--format", "json"]);
    assert_eq!(replayed.code, 0, "{replayed:?}");
    let replayed = json(&replayed);
    assert_eq!(replayed["shown"], true);
    assert_eq!(replayed["same_bytes"], true);
    assert_eq!(replayed["failed"], "controller-failed");
    let said = replayed["said"].as_str().expect("words");
    assert!(said.contains("no way to stop"), "{said}");
    let checked = call(&["replay", ".", "--check"]);
    assert_eq!(checked.code, 0, "{checked:?}");
}

/// A drive that can be so stiff that the physics gives no numbers.
const STIFF: &str = r#"
evidence = "S2"
sources = ["own", "search"]
designs = ["boundary"]

[budget]
episodes = 4
batch = 2

[[parameter]]
name = "gain"
sets = ["actuator.drive.gain_nms_rad"]
choice = [2.0, 1e9]
nominal = 2.0

[[parameter]]
name = "torque"
sets = ["actuator.drive.torque_limit_nm"]
choice = [6.0, 1e9]
nominal = 6.0

[[search]]
requirement = "speed"
test = "ben_crosses"
method = "bayesian"
"#;

#[test]
fn physics_without_numbers_is_no_violation_of_the_robot_and_can_be_replayed() {
    let Some(library) = library() else { return };
    let folder = copy_of("case-studies/corridor", &[]);
    std::fs::write(folder.path().join("exploration.toml"), STIFF).expect("written");
    let call = |arguments: &[&str]| driven(&library, folder.path(), arguments);
    let explore = ["explore", ".", "exploration.toml", "--out", "out"];
    let explored = call(&[&explore[..], &["--format", "json"]].concat());
    // Data were lost; nothing is violated.
    assert_eq!(explored.code, 3, "{explored:?}");
    let report = json(&explored);
    let broken = report["broken"].as_array().expect("episodes");
    assert!(!broken.is_empty(), "{report}");
    let findings = report["findings"].as_array().expect("findings");
    assert_eq!(findings.len(), 1, "{report}");
    let found = &findings[0];
    assert_eq!(found["shows"]["failed"], "simulator-failed", "{found}");
    assert_eq!(found["episodes"].as_u64(), Some(broken.len() as u64));
    assert_eq!(found["replayed"], true, "{found}");
    assert_eq!(report["searches"][0]["violated"], 0, "{report}");
    let text = call(&explore).out;
    let words = "which is not evidence about the robot";
    assert!(text.contains(words), "{text}");
    let file = format!("out/{}", found["file"].as_str().expect("a file"));
    let replayed = call(&["replay", ".", &file, "--format", "json"]);
    assert_eq!(replayed.code, 0, "{replayed:?}");
    let replayed = json(&replayed);
    assert_eq!(replayed["shown"], true, "{replayed}");
    let said = replayed["said"].as_str().expect("words");
    assert!(said.contains("unstable"), "{said}");
    let verdicts = replayed["verdicts"].as_array().expect("verdicts");
    assert!(
        verdicts.iter().all(|it| it["verdict"] != "violated"),
        "{replayed}"
    );
}
