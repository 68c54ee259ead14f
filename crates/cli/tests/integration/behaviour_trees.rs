//! Studies drafted from behaviour trees: they run at once, and their constants are set to what recordings show.

use crate::support::program::corroborate;
use crate::support::read;
use serde_json::Value;
use std::fmt::Write as _;
use std::path::Path;
use tempfile::TempDir;

const TREE: &str = r#"<root BTCPP_format="4">
  <BehaviorTree ID="Main">
    <RecoveryNode name="FollowPath" number_of_retries="1">
      <Sequence name="way"><IsPathClear/><FollowPath/></Sequence>
      <Spin/>
    </RecoveryNode>
  </BehaviorTree>
</root>
"#;

/// A run in which the way fails as often as said, and is found at last.
fn log(failures: usize, numbers: bool) -> String {
    let nodes = ["FollowPath", "way", "IsPathClear", "FollowPath", "Spin"];
    let mut events = Vec::new();
    let mut change = |node: usize, from: &str, to: &str| {
        let uid = match numbers {
            true => format!("\"uid\": {}, ", node + 1),
            false => String::new(),
        };
        events.push(format!(
            "{{{uid}\"node_name\": \"{}\", \"previous_status\": \"{from}\", \"current_status\": \"{to}\"}}",
            nodes[node]
        ));
    };
    change(0, "IDLE", "RUNNING");
    for _ in 0..failures {
        change(2, "IDLE", "SUCCESS");
        change(3, "IDLE", "RUNNING");
        change(3, "RUNNING", "FAILURE");
        change(4, "RUNNING", "SUCCESS");
    }
    change(2, "IDLE", "SUCCESS");
    change(3, "RUNNING", "SUCCESS");
    change(0, "RUNNING", "SUCCESS");
    change(4, "RUNNING", "IDLE");
    let mut lines = String::new();
    for (at, event) in events.chunks(3).enumerate() {
        let list = event.join(", ");
        let _ = writeln!(
            lines,
            "{{\"topic\": \"/robot/behavior_tree_log\", \"time_ms\": {}, \"event_log\": [{list}]}}",
            10 * at
        );
    }
    lines
}

fn drafted(place: &Path, numbers: bool) -> String {
    std::fs::create_dir(place.join("runs")).expect("made");
    std::fs::write(place.join("tree.xml"), TREE).expect("written");
    for run in 0..6 {
        let text = log(usize::from(run == 5), numbers);
        std::fs::write(place.join(format!("runs/{run}.jsonl")), text).expect("written");
    }
    let arguments = [
        "init",
        "study",
        "--from",
        "tree.xml",
        "--recordings",
        "runs",
    ];
    let said = corroborate(place, &arguments);
    assert_eq!(said.code, 0, "{said:?}");
    said.out
}

#[test]
fn counts_of_recordings_become_constants_whose_uncertainty_is_carried_on() {
    let place = TempDir::new().expect("a folder");
    drafted(place.path(), true);
    let study = place.path().join("study");
    let modes = read(&study.join("counts/failure_modes.csv"));
    for row in [
        "IsPathClear_failed,0,7",
        "FollowPath_failed,1,7",
        "Spin_failed,0,1",
    ] {
        assert!(modes.contains(row), "{modes}");
    }
    let model = read(&study.join("model.prism"));
    assert!(
        model.contains("const double p_FollowPath = 0.857143;"),
        "{model}"
    );
    assert!(
        model.contains("1 of 1 execution succeeded, and 6 halted"),
        "{model}"
    );
    let said = corroborate(place.path(), &["run", "study", "--format", "json"]);
    assert!([0, 3].contains(&said.code), "{said:?}");
    let result: Value = serde_json::from_str(&said.out).expect("JSON");
    let text = result.to_string();
    // The root's rate has an interval from the counts, and the leaves' agreement with their own counts is a fit.
    assert!(text.contains("\"credible\":{"), "{text}");
    assert!(!text.contains("\"corroborates\""), "{text}");
    assert!(read(&study.join("README.md")).contains("is a fit"));
}

#[test]
fn a_leaf_that_shares_its_name_with_a_control_node_is_not_counted_without_numbers() {
    let place = TempDir::new().expect("a folder");
    let output = drafted(place.path(), false);
    assert!(
        output.contains("2 nodes are logged as FollowPath, and not all of them are leaves"),
        "{output}"
    );
    assert!(
        output.contains("1 of 3 constants in model.prism are guesses"),
        "{output}"
    );
    let said = corroborate(place.path(), &["run", "study"]);
    assert!([0, 3].contains(&said.code), "{said:?}");
}

#[test]
fn a_draft_without_recordings_runs_and_says_that_it_is_guessed() {
    let place = TempDir::new().expect("a folder");
    std::fs::write(place.path().join("tree.xml"), TREE).expect("written");
    let said = corroborate(place.path(), &["init", "study", "--from", "tree.xml"]);
    assert!(
        said.out
            .contains("3 of 3 constants in model.prism are guesses"),
        "{said:?}"
    );
    let said = corroborate(place.path(), &["run", "study"]);
    assert_eq!(said.code, 0, "{said:?}");
    let said = corroborate(
        place.path(),
        &["check", "study/model.prism", "P=? [ F \"success\" ]"],
    );
    // The way, and once more after a spin, each leaf guessed at 0.9: 0.81 + 0.19 * 0.9 * 0.81.
    assert!(said.out.contains("0.94851"), "{said:?}");
}

#[test]
fn what_cannot_be_counted_is_refused_and_leaves_no_study() {
    let place = TempDir::new().expect("a folder");
    std::fs::write(place.path().join("tree.xml"), TREE).expect("written");
    std::fs::write(
        place.path().join("other.csv"),
        "node,status\nElse,SUCCESS\n",
    )
    .expect("written");
    std::fs::write(place.path().join("bad.csv"), "node,status\nSpin,DONE\n").expect("written");
    std::fs::write(place.path().join("none.csv"), "time_secs,speed\n0,1\n").expect("written");
    for (from, recordings, code) in [
        ("tree.xml", "other.csv", "no-executions"),
        ("tree.xml", "bad.csv", "bad-recording"),
        ("tree.xml", "none.csv", "no-executions"),
        ("none.csv", "other.csv", "recordings-without-tree"),
    ] {
        let arguments = ["init", "study", "--from", from, "--recordings", recordings];
        let said = corroborate(place.path(), &arguments);
        assert_eq!(said.code, 2, "{said:?}");
        assert!(said.talk.contains(code), "{said:?}");
        assert!(!place.path().join("study").exists());
    }
    std::fs::write(
        place.path().join("wrong.xml"),
        "<root><BehaviorTree><Inverter/></BehaviorTree></root>",
    )
    .expect("written");
    let said = corroborate(place.path(), &["init", "study", "--from", "wrong.xml"]);
    assert!(said.talk.contains("bad-behaviour-tree"), "{said:?}");
}

/// Three of ten executions are halted by their `Timeout`: its constant is set to that, and its uncertainty is carried on.
#[test]
fn whether_a_time_suffices_is_counted_too() {
    let place = TempDir::new().expect("a folder");
    let tree = "<root BTCPP_format=\"4\"><BehaviorTree ID=\"Fetch\"><Sequence name=\"fetch\">\n\
        <Timeout msec=\"5000\" name=\"limit\"><Grasp/></Timeout><Drop/>\n\
        </Sequence></BehaviorTree></root>";
    std::fs::write(place.path().join("tree.xml"), tree).expect("written");
    let mut rows = String::from("run,node,status\n");
    for run in 0..10 {
        let (grasp, limit) = match run {
            0..3 => ("RUNNING\nRUN,Grasp,IDLE", "FAILURE"),
            3 => ("FAILURE", "FAILURE"),
            _ => ("SUCCESS", "SUCCESS"),
        };
        let drop = if run > 3 { "RUN,Drop,SUCCESS\n" } else { "" };
        let text = format!("RUN,Grasp,{grasp}\nRUN,limit,{limit}\n{drop}RUN,fetch,{limit}\n");
        rows += &text
            .replace("RUN", &run.to_string())
            .replace(&format!("{run}NING"), "RUNNING");
    }
    std::fs::write(place.path().join("runs.csv"), rows).expect("written");
    let said = corroborate(
        place.path(),
        &[
            "init",
            "s",
            "--from",
            "tree.xml",
            "--recordings",
            "runs.csv",
        ],
    );
    assert_eq!(said.code, 0, "{said:?}");
    let study = place.path().join("s");
    let model = read(&study.join("model.prism"));
    assert!(
        model.contains("const double p_limit_in_time = 0.7; // 7 of 10 executions ended in time"),
        "{model}"
    );
    assert!(!model.contains("DRAFT"), "{model}");
    assert!(read(&study.join("counts/failure_modes.csv")).contains("limit_late,3,10"));
    let said = corroborate(place.path(), &["run", "s", "--format", "json"]);
    assert!([0, 1, 3].contains(&said.code), "{said:?}");
    let result: Value = serde_json::from_str(&said.out).expect("JSON");
    // Of the runs that come to it, the model is late in the share that was counted.
    let late = |evidence: &Value| {
        let findings = evidence["findings"].as_array().expect("findings").clone();
        let own = findings
            .into_iter()
            .find(|it| it["subject"]["id"] == "limit_late");
        own.unwrap_or_else(|| panic!("{evidence}"))["measure"].clone()
    };
    let pieces = result["evidence"].as_array().expect("evidence");
    assert_eq!(
        (
            late(&pieces[0])["count"].as_u64(),
            late(&pieces[0])["trials"].as_u64()
        ),
        (Some(3), Some(10))
    );
    let text = late(&pieces[1]).to_string();
    assert!(
        text.contains("0.3") || text.contains("0.30000000000000004"),
        "{text}"
    );
}
