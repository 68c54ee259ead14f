//! What the node types of BehaviorTree.CPP and Nav2 mean.
//!
//! Sources: BehaviorTree.CPP 4.x, `src/controls`, `src/decorators`, `src/tree_node.cpp`; Nav2, `nav2_behavior_tree/plugins`.
//! Format 3 has the same nodes but for `SKIPPED`; where names or attributes differ, both are read.

use crate::files::Element;
use crate::mistakes::Mistakes;
use crate::tree::{Kind, Leaf, Outcome};

/// What is known of an element when its type is looked up.
pub(crate) struct Typed<'a, 'd> {
    pub element: Element<'d>,
    pub type_name: &'d str,
    /// Whether the tag, or `TreeNodesModel`, says what leaf it is, or that it is none.
    pub declared: Option<Option<Leaf>>,
    pub children: usize,
    pub is_format_4: bool,
    /// The value of an attribute, with ports looked up; `None` where only the blackboard has it.
    pub value: &'a dyn Fn(&str) -> Value<'d>,
}

/// The value of an attribute.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Value<'d> {
    Absent,
    Text(&'d str),
    /// An entry of the blackboard.
    Entry(&'d str),
}

/// A kind, and whether the node asks its first children again while a later one runs.
pub(crate) struct Found {
    pub kind: Kind,
    pub is_reactive: bool,
    /// Why it stands for all that is below it, or is taken for one version of several.
    pub why: Option<String>,
}

impl From<Kind> for Found {
    fn from(kind: Kind) -> Self {
        Self {
            kind,
            is_reactive: false,
            why: None,
        }
    }
}

/// A leaf in place of all that is below it.
pub(crate) fn whole(why: impl Into<String>) -> Found {
    Found {
        why: Some(why.into()),
        ..Kind::Leaf(Leaf::Whole).into()
    }
}

fn reactive(kind: Kind) -> Found {
    Found {
        is_reactive: true,
        ..kind.into()
    }
}

const SEQUENCE: Kind = Kind::Sequence {
    memory: false,
    all_skipped: Outcome::Skipped,
};

/// Nav2's conditions, whose tags do not say what they are.
const CONDITIONS: [&str; 20] = [
    "AreErrorCodesPresent",
    "ArePosesNear",
    "DistanceTraveled",
    "GlobalUpdatedGoal",
    "GoalReached",
    "GoalUpdated",
    "InitialPoseReceived",
    "IsBatteryCharging",
    "IsBatteryLow",
    "IsGoalNearby",
    "IsPathValid",
    "IsStopped",
    "IsStuck",
    "IsWithinPathTrackingBounds",
    "PathExpiringTimer",
    "TimeExpired",
    "TransformAvailable",
    "WouldAControllerRecoveryHelp",
    "WouldAPlannerRecoveryHelp",
    "WouldARouteRecoveryHelp",
];

impl Typed<'_, '_> {
    /// The meaning of the type; mistakes are said.
    pub fn found(&self, mistakes: &mut Mistakes) -> Found {
        let found = match self.control() {
            Some(found) => found,
            None => match self.decorator(mistakes) {
                Some(found) => found,
                None => return self.leaf(mistakes),
            },
        };
        self.check_children(&found.kind, mistakes);
        found
    }

    fn control(&self) -> Option<Found> {
        Some(match self.type_name {
            "Sequence" | "AsyncSequence" => SEQUENCE.into(),
            "ReactiveSequence" | "PipelineSequence" | "NonblockingSequence" => reactive(SEQUENCE),
            "SequenceWithMemory" | "SequenceStar" => Kind::Sequence {
                memory: true,
                all_skipped: Outcome::Skipped,
            }
            .into(),
            "PersistentSequence" => Kind::Sequence {
                memory: false,
                all_skipped: Outcome::Success,
            }
            .into(),
            "Fallback" | "AsyncFallback" | "FallbackStar" => Kind::Fallback.into(),
            "ReactiveFallback" => reactive(Kind::Fallback),
            "Parallel" | "ParallelNode" => self.parallel(),
            "ParallelAll" => self.parallel_all(),
            "IfThenElse" => Kind::Choice.into(),
            "WhileDoElse" => reactive(Kind::Choice),
            "Switch2" | "Switch3" | "Switch4" | "Switch5" | "Switch6" => Kind::Switch.into(),
            "TryCatch" => Kind::TryCatch.into(),
            "RecoveryNode" => match self.count("number_of_retries", Some(1)) {
                Count::Known(retries) => Kind::Recovery(retries.try_into().unwrap_or(0)).into(),
                Count::Unknown(why) => whole(why),
            },
            "RoundRobin" => self.round_robin(),
            _ => return None,
        })
    }

    fn decorator(&self, mistakes: &mut Mistakes) -> Option<Found> {
        Some(match self.type_name {
            "Inverter" => Kind::Inverter.into(),
            "ForceSuccess" => Kind::Force(Outcome::Success).into(),
            "ForceFailure" => Kind::Force(Outcome::Failure).into(),
            "RetryUntilSuccessful" | "RetryUntilSuccesful" => {
                self.looped("num_attempts", mistakes, Kind::Retry, Outcome::Failure)
            }
            "Repeat" => self.looped("num_cycles", mistakes, Kind::Repeat, Outcome::Success),
            "KeepRunningUntilFailure" => Kind::KeepRunningUntilFailure.into(),
            "RunOnce" => match (self.value)("then_skip") {
                Value::Entry(entry) => whole(format!("`then_skip` is the entry `{entry}`")),
                Value::Text(text) => self.run_once(text.trim() != "false"),
                Value::Absent => self.run_once(true),
            },
            // Without a time none is kept.
            "Timeout" => match (self.value)("msec") {
                Value::Text(text) if text.trim() == "0" => Kind::Pass.into(),
                _ => Kind::Deadline.into(),
            },
            "Delay"
            | "RateController"
            | "DistanceController"
            | "SpeedController"
            | "GoalUpdater"
            | "GoalUpdatedController"
            | "SingleTrigger"
            | "WaitValueUpdate" => Kind::Pass.into(),
            "Precondition" => self.gate("else"),
            "BlackboardCheckInt"
            | "BlackboardCheckDouble"
            | "BlackboardCheckString"
            | "BlackboardCheckBool" => self.gate("return_on_mismatch"),
            "SkipUnlessUpdated" => Kind::Gate(Outcome::Skipped).into(),
            _ => return None,
        })
    }

    fn run_once(&self, then_skip: bool) -> Found {
        let then_skip = then_skip && self.is_format_4;
        Kind::RunOnce { then_skip }.into()
    }

    fn leaf(&self, mistakes: &mut Mistakes) -> Found {
        let type_name = self.type_name;
        let built_in = match type_name {
            "AlwaysSuccess" | "Script" | "SetBlackboard" | "UnsetBlackboard" | "Sleep" => {
                Some(Kind::Always(Outcome::Success))
            }
            "AlwaysFailure" => Some(Kind::Always(Outcome::Failure)),
            "ScriptCondition" | "WasEntryUpdated" => Some(Kind::Leaf(Leaf::Condition)),
            _ => None,
        };
        let is_childless = built_in.is_some() || matches!(self.declared, Some(Some(_)));
        if is_childless && self.children > 0 {
            let message = format!(
                "`{type_name}` has {} and is a leaf",
                children(self.children)
            );
            let remedy = "take them out of it, or make it a control node or a decorator";
            mistakes.add(self.element.spot(), message, remedy);
        }
        if let Some(kind) = built_in {
            return kind.into();
        }
        if self.children > 0 || self.declared == Some(None) {
            return whole(format!(
                "what the type `{type_name}` does with its children is not known here"
            ));
        }
        let by_name = CONDITIONS.contains(&type_name).then_some(Leaf::Condition);
        let declared = self.declared.flatten();
        Kind::Leaf(declared.or(by_name).unwrap_or(Leaf::Unknown)).into()
    }

    fn parallel(&self) -> Found {
        let attribute = |names: &[&'static str]| {
            let given = names.iter().find(|it| (self.value)(it) != Value::Absent);
            given.copied()
        };
        let successes = attribute(&["success_count", "success_threshold", "threshold"]);
        let failures = attribute(&["failure_count", "failure_threshold"]);
        let of = |name: Option<&str>, default| match name {
            Some(name) => self.count(name, None),
            None => Count::Known(default),
        };
        // The oldest files have one threshold alone: a node fails once it can no longer succeed.
        let failures = match successes {
            Some("threshold") => Count::Known(-1),
            _ => of(failures, 1),
        };
        match (of(successes, -1), failures) {
            (Count::Known(successes), Count::Known(failures)) => {
                let all = successes == -1;
                let number = |count: i64| self.of_children(count);
                let (successes, failures) = (number(successes), number(failures));
                if successes > self.children || failures > self.children {
                    return whole("it asks for more children than it has, and ends with an error");
                }
                if failures == 0 {
                    return whole("it ends with its first child that does not fail");
                }
                Kind::Parallel {
                    successes,
                    failures,
                    all,
                }
                .into()
            }
            (Count::Unknown(why), _) | (_, Count::Unknown(why)) => whole(why),
        }
    }

    fn parallel_all(&self) -> Found {
        match self.count("max_failures", Some(1)) {
            Count::Known(failures) => Kind::ParallelAll {
                failures: self.of_children(failures),
            }
            .into(),
            Count::Unknown(why) => whole(why),
        }
    }

    /// A number of children; -1 is all, -2 all but one.
    fn of_children(&self, count: i64) -> usize {
        let children = self.children as i64;
        let count = if count < 0 {
            children + count + 1
        } else {
            count
        };
        count.max(0) as usize
    }

    fn round_robin(&self) -> Found {
        match (self.value)("wrap_around") {
            Value::Entry(entry) => whole(format!("`wrap_around` is the entry `{entry}`")),
            Value::Text(text) => Kind::RoundRobin {
                wraps: text.trim() != "false",
            }
            .into(),
            Value::Absent => Found {
                why: Some("`wrap_around` is not given".to_owned()),
                ..Kind::RoundRobin { wraps: true }.into()
            },
        }
    }

    fn gate(&self, otherwise: &str) -> Found {
        match (self.value)(otherwise) {
            Value::Absent | Value::Text("FAILURE") => Kind::Gate(Outcome::Failure).into(),
            Value::Text("SUCCESS") => Kind::Gate(Outcome::Success).into(),
            Value::Text("SKIPPED") => Kind::Gate(Outcome::Skipped).into(),
            Value::Text(other) => whole(format!(
                "it gives `{other}` where its child is not executed"
            )),
            Value::Entry(entry) => whole(format!("`{otherwise}` is the entry `{entry}`")),
        }
    }

    fn looped(
        &self,
        attribute: &str,
        mistakes: &mut Mistakes,
        kind: fn(Option<u32>) -> Kind,
        of_none: Outcome,
    ) -> Found {
        if (self.value)(attribute) == Value::Absent {
            let message = format!("`{}` has no `{attribute}`", self.type_name);
            let remedy = format!("write `{attribute}=\"3\"`; -1 has no end");
            mistakes.add(self.element.spot(), message, remedy);
        }
        match self.count(attribute, Some(1)) {
            Count::Known(-1) => kind(None).into(),
            Count::Known(count) if count <= 0 => Kind::Always(of_none).into(),
            Count::Known(count) => kind(Some(count.try_into().unwrap_or(u32::MAX))).into(),
            Count::Unknown(why) => whole(why),
        }
    }

    fn count(&self, attribute: &str, default: Option<i64>) -> Count {
        match (self.value)(attribute) {
            Value::Absent => Count::Known(default.unwrap_or(1)),
            Value::Entry(entry) => Count::Unknown(format!(
                "`{attribute}` is the entry `{entry}` of the blackboard, whose value is not known here"
            )),
            Value::Text(text) => match text.trim().parse::<i64>() {
                Ok(count) if count.abs() <= 1_000_000 => Count::Known(count),
                _ => Count::Unknown(format!("`{attribute}` is `{text}`, and not a whole number")),
            },
        }
    }

    fn check_children(&self, kind: &Kind, mistakes: &mut Mistakes) {
        let count = self.children;
        let cases = self.type_name.strip_prefix("Switch");
        let expected = match kind {
            Kind::Choice if ![2, 3].contains(&count) => "2 or 3 children",
            Kind::Recovery(_) if count != 2 => "2 children",
            Kind::TryCatch if count < 2 => "at least 2 children",
            Kind::Switch if cases.and_then(|it| it.parse().ok()) != count.checked_sub(1) => {
                "a child for each case and one by default"
            }
            Kind::Choice | Kind::Recovery(_) | Kind::TryCatch | Kind::Switch => return,
            Kind::Sequence { .. }
            | Kind::Fallback
            | Kind::Parallel { .. }
            | Kind::ParallelAll { .. }
            | Kind::RoundRobin { .. } => match count {
                0 => "at least 1 child",
                _ => return,
            },
            Kind::Leaf(_) if count > 0 => return,
            _ if count != 1 => "1 child",
            _ => return,
        };
        let message = format!(
            "`{}` has {}, not {expected}",
            self.type_name,
            children(count)
        );
        let remedy = format!("give it {expected}");
        mistakes.add(self.element.spot(), message, remedy);
    }
}

enum Count {
    Known(i64),
    Unknown(String),
}

/// "1 child", "3 children".
fn children(count: usize) -> String {
    match count {
        0 => "no children".to_owned(),
        1 => "1 child".to_owned(),
        _ => format!("{count} children"),
    }
}
