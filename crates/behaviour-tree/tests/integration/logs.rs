//! Whose executions a log shows.

use behaviour_tree::{Counts, Event, Executions, Status};

use crate::support::reading;

const TREE: &str = "<root BTCPP_format=\"4\"><BehaviorTree ID=\"Main\">\
    <Sequence name=\"root\">\
    <RecoveryNode name=\"FollowPath\"><FollowPath/><Clear/></RecoveryNode>\
    <Clear/><Spin/>\
    </Sequence></BehaviorTree></root>";

fn run(events: &[(&str, Option<u32>, &str, &str)]) -> Executions {
    let mut run = Executions::default();
    for (node, uid, previous, current) in events {
        run.add(&Event {
            node,
            uid: *uid,
            previous: Status::parse(previous).expect("a status"),
            current: Status::parse(current).expect("a status"),
        });
    }
    run
}

fn counts(succeeded: u64, failed: u64, halted: u64) -> Counts {
    Counts {
        succeeded,
        failed,
        halted,
    }
}

#[test]
fn each_end_is_an_execution_and_halts_are_counted_apart() {
    let found = reading(TREE).tree;
    let runs = [
        run(&[
            ("Spin", None, "IDLE", "RUNNING"),
            ("Spin", None, "RUNNING", "SUCCESS"),
            ("Spin", None, "SUCCESS", "IDLE"),
            ("Spin", None, "IDLE", "FAILURE"),
            ("Spin", None, "FAILURE", "SUCCESS"),
            ("root", None, "RUNNING", "SUCCESS"),
        ]),
        run(&[
            ("Spin", None, "running", "idle"),
            ("Other", None, "IDLE", "SUCCESS"),
            ("root", None, "RUNNING", "IDLE"),
        ]),
    ];
    let found = found.attributed(&runs);
    assert_eq!(found.leaves.len(), 1);
    assert_eq!(found.leaves[0].by_run, [counts(2, 1, 0), counts(0, 0, 1)]);
    assert_eq!(found.leaves[0].total().ended(), 3);
    assert_eq!(found.root, Some(vec![counts(1, 0, 0), counts(0, 0, 1)]));
    assert_eq!(found.unknown.into_iter().collect::<Vec<_>>(), ["Other"]);
}

#[test]
fn numbers_tell_nodes_of_one_name_apart_if_they_are_the_trees() {
    let tree = reading(TREE).tree;
    let by_number = [run(&[
        ("FollowPath", Some(2), "RUNNING", "SUCCESS"),
        ("FollowPath", Some(3), "RUNNING", "FAILURE"),
        ("Clear", Some(4), "IDLE", "SUCCESS"),
        ("Clear", Some(5), "IDLE", "FAILURE"),
    ])];
    let found = tree.attributed(&by_number);
    assert!(found.shared.is_empty());
    let leaves: Vec<(String, Counts)> = found
        .leaves
        .iter()
        .map(|it| (tree.node(it.nodes[0]).path.clone(), it.total()))
        .collect();
    assert_eq!(
        leaves,
        [
            ("root/FollowPath/FollowPath".to_owned(), counts(0, 1, 0)),
            ("root/FollowPath/Clear".to_owned(), counts(1, 0, 0)),
            ("root/Clear".to_owned(), counts(0, 1, 0)),
        ]
    );
    // One number that is another node's: the log is of another version of the tree.
    let mut other = by_number.clone();
    other[0].add(&Event {
        node: "Spin",
        uid: Some(7),
        previous: Status::Idle,
        current: Status::Success,
    });
    let found = tree.attributed(&other);
    let shared: Vec<(&str, bool)> = found
        .shared
        .iter()
        .map(|it| (it.name.as_str(), it.is_mixed))
        .collect();
    assert_eq!(shared, [("FollowPath", true), ("Clear", false)]);
    let leaves: Vec<(usize, Counts)> = found
        .leaves
        .iter()
        .map(|it| (it.nodes.len(), it.total()))
        .collect();
    assert_eq!(leaves, [(2, counts(1, 1, 0)), (1, counts(1, 0, 0))]);
}

#[test]
fn a_table_may_name_leaves_by_their_labels() {
    let tree = reading(TREE).tree;
    let mut table = Executions::by_label();
    table.add(&Event {
        node: "FollowPath",
        uid: None,
        previous: Status::Running,
        current: Status::Success,
    });
    let found = tree.attributed(&[table]);
    assert!(found.shared.is_empty());
    assert_eq!(tree.node(found.leaves[0].nodes[0]).line, 1);
    assert_eq!(found.leaves[0].total(), counts(1, 0, 0));
}

/// Of ten executions one child fails by itself, and two are halted since the time is over.
#[test]
fn a_timeout_that_fails_without_its_child_was_over() {
    let text = "<root BTCPP_format=\"4\"><BehaviorTree ID=\"Main\"><Sequence name=\"root\">\
        <Timeout name=\"limit\" msec=\"5000\"><Grasp/></Timeout>\
        <Timeout name=\"guarded\" msec=\"5000\" _failureIf=\"a\"><Spin/></Timeout>\
        <Timeout name=\"none\" msec=\"0\"><Wait/></Timeout>\
        </Sequence></BehaviorTree></root>";
    let tree = reading(text).tree;
    let ended = |child: &'static str, own: &'static str| {
        [
            ("Grasp", None, "RUNNING", child),
            ("limit", None, "RUNNING", own),
        ]
    };
    let mut events = Vec::new();
    for number in 0..10 {
        events.extend(match number {
            0 => ended("FAILURE", "FAILURE"),
            1 | 2 => ended("IDLE", "FAILURE"),
            3 => ended("IDLE", "IDLE"),
            _ => ended("SUCCESS", "SUCCESS"),
        });
    }
    events.push(("Spin", None, "RUNNING", "IDLE"));
    events.push(("guarded", None, "IDLE", "FAILURE"));
    let deadlines = tree.attributed(&[run(&events)]).deadlines;
    assert_eq!(deadlines.len(), 1, "{deadlines:?}");
    assert_eq!(tree.node(deadlines[0].nodes[0]).name, "limit");
    assert_eq!(deadlines[0].total(), counts(7, 2, 1));
    // A success of the child that the log lacks: it does not say how many ended in time.
    events.retain({
        let mut left = 0;
        move |it| {
            it.0 != "Grasp" || it.3 != "SUCCESS" || {
                left += 1;
                left > 1
            }
        }
    });
    assert!(tree.attributed(&[run(&events)]).deadlines.is_empty());
    // The model has a state of its own for it, and none for a time that is not kept.
    let model = behaviour_tree::to_prism(&tree, &behaviour_tree::Options::default());
    assert!(
        model
            .text
            .contains("label \"limit_late\" = step=late_limit;"),
        "{}",
        model.text
    );
    assert!(!model.text.contains("p_none_in_time"));
}
