//! What the model of a node leaves out or assumes, said at its line.

use crate::expand::Drafted;
use crate::mistakes::Mistakes;
use crate::tree::{Draw, Kind, Leaf};

/// All notes of the nodes that are part of the model.
pub(crate) fn add(drafted: &[Drafted], is_inside: &[bool], mistakes: &mut Mistakes) {
    for (at, _) in drafted.iter().enumerate().filter(|(at, _)| is_inside[*at]) {
        let one = &drafted[at];
        of_kind(one, mistakes);
        if one.node.is_reactive && one.node.children.len() > 1 {
            let message = format!(
                "`{}` asks its first children once per execution here, and not again while a later one runs",
                one.node.name
            );
            let remedy =
                "what ends a running child that way has to be part of that child's success rate";
            mistakes.note(one.spot.clone(), message, remedy);
        }
        of_scripts(one, mistakes);
    }
}

fn of_kind(one: &Drafted, mistakes: &mut Mistakes) {
    let name = &one.node.name;
    let (message, remedy) = match &one.node.kind {
        Kind::Leaf(Leaf::Whole) => {
            let why = one.why.as_deref().unwrap_or("its inside is not modelled");
            (
                format!("`{name}` is one leaf with all that is in it: {why}"),
                "its constant is the success rate of the whole, and is counted as such".to_owned(),
            )
        }
        Kind::Parallel {
            successes,
            failures,
            ..
        } => of_parallel(one, *successes, *failures),
        Kind::ParallelAll { .. } => (
            format!("the children of `{name}` run one after another here"),
            "its result does not depend on their order if they are independent".to_owned(),
        ),
        Kind::Pass => match of_pass(&one.node.type_name) {
            Some(what) => (
                format!("`{name}` gives its child's result: {what}"),
                "time has to be part of the child's success rate".to_owned(),
            ),
            None => return,
        },
        Kind::Deadline => (
            format!("there is no time in the model: whether that of `{name}` suffices is drawn"),
            "set its constant to the share of executions that end in time; recordings show it"
                .to_owned(),
        ),
        Kind::RoundRobin { wraps: true } if one.why.is_some() => (
            format!(
                "`{name}` goes on with the first child behind the last, as in Nav2 up to Jazzy"
            ),
            "later versions do so with `wrap_around=\"true\"` alone: write it, or \"false\""
                .to_owned(),
        ),
        Kind::Sequence { .. } if one.node.type_name == "PersistentSequence" => (
            format!("`{name}` begins with its first child"),
            "another beginning on the blackboard is not modelled".to_owned(),
        ),
        Kind::KeepRunningUntilFailure | Kind::Retry(None) | Kind::Repeat(None) => (
            format!("`{name}` may run without end"),
            "a run that does not end is neither a success nor a failure: ask for both".to_owned(),
        ),
        _ => return,
    };
    mistakes.note(one.spot.clone(), message, remedy);
}

fn of_parallel(one: &Drafted, successes: usize, failures: usize) -> (String, String) {
    let name = &one.node.name;
    let count = one.node.children.len();
    let limit = failures.min((count + 1).saturating_sub(successes));
    if successes + limit == count + 1 {
        return (
            format!("the children of `{name}` run one after another here, until its result is known"),
            "its result does not depend on their order if they are independent; which of them end does"
                .to_owned(),
        );
    }
    (
        format!(
            "the children of `{name}` end in the order of the text here, and its result depends on the order"
        ),
        "bring the one that ends first to the front, or ask for all results".to_owned(),
    )
}

/// What is left out of a decorator that passes its child's result on; `None` for a subtree.
fn of_pass(type_name: &str) -> Option<&'static str> {
    Some(match type_name {
        "Delay" => "there is no time in the model",
        "RateController" | "DistanceController" | "SpeedController" => {
            "that it is executed anew while another node runs is not modelled"
        }
        "GoalUpdater" | "GoalUpdatedController" | "WaitValueUpdate" => {
            "a new value on the blackboard is not modelled"
        }
        "SingleTrigger" => "that it fails when it is executed again is not modelled",
        _ => return None,
    })
}

fn of_scripts(one: &Drafted, mistakes: &mut Mistakes) {
    let name = &one.node.name;
    for draw in one.node.draws() {
        let (what, remedy) = match draw {
            Draw::Precondition(which) if which.word() == "while" => (
                format!(
                    "whether `_while` of `{name}` is true is drawn when it begins, and not asked while it runs"
                ),
                "set its constant to the share of executions in which it is",
            ),
            Draw::Precondition(which) => (
                format!(
                    "the blackboard is not modelled: whether `_{}` of `{name}` is true is drawn each time",
                    which.word()
                ),
                "set its constant to the share of executions in which it is",
            ),
            Draw::Gate => (
                format!(
                    "the blackboard is not modelled: whether `{name}` executes its child is drawn each time"
                ),
                "set its constant to the share of executions in which it does",
            ),
            Draw::Case(0) => (
                format!(
                    "the blackboard is not modelled: which case `{name}` takes is drawn each time"
                ),
                "set its constants to the shares of its cases, each among those that take none before",
            ),
            Draw::Case(_) | Draw::Leaf | Draw::Deadline => continue,
        };
        mistakes.note(one.spot.clone(), what, remedy);
    }
}
