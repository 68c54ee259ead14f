//! Random trees as ticked trees and as texts, with a chance for each draw.

use std::collections::BTreeMap;
use std::fmt::Write;

use crate::ticks::{Status, Ticked, Type};

/// A generator of numbers (SplitMix64).
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut x = self.0;
        x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        x ^ (x >> 31)
    }

    pub fn below(&mut self, count: usize) -> usize {
        (self.next() % count as u64) as usize
    }

    pub fn is_below(&mut self, chance: f64) -> bool {
        ((self.next() >> 11) as f64) < chance * (1_u64 << 53) as f64
    }
}

/// What of trees is generated.
#[derive(Clone, Copy, Debug)]
pub struct Kinds {
    /// Loops without end.
    pub endless: bool,
    /// Nodes whose result depends on which of their children are under way.
    pub reactive: bool,
    pub preconditions: bool,
}

pub struct Trees {
    pub random: Random,
    pub kinds: Kinds,
    count: usize,
    pub chances: BTreeMap<String, f64>,
}

const CHANCES: [f64; 6] = [0.1, 0.25, 0.4, 0.6, 0.7, 0.9];

impl Trees {
    pub fn new(seed: u64, kinds: Kinds) -> Self {
        Self {
            random: Random(seed),
            kinds,
            count: 0,
            chances: BTreeMap::new(),
        }
    }

    fn chance(&mut self, name: String) {
        let chance = CHANCES[self.random.below(CHANCES.len())];
        self.chances.insert(name, chance);
    }

    fn some(&mut self, least: usize, most: usize, depth: usize) -> Vec<Ticked> {
        let count = least + self.random.below(most - least + 1);
        (0..count).map(|_| self.tree(depth - 1)).collect()
    }

    pub fn tree(&mut self, depth: usize) -> Ticked {
        self.count += 1;
        let number = self.count;
        if depth == 0 || self.random.below(5) == 0 {
            return self.leaf(number);
        }
        let name = format!("N{number}");
        let kind = self.kind();
        let (least, most) = match kind {
            Type::IfThenElse | Type::WhileDoElse => (2, 3),
            Type::Switch | Type::TryCatch => (3, 3),
            Type::Recovery(_) => (2, 2),
            Type::Sequence
            | Type::ReactiveSequence
            | Type::Memory
            | Type::Pipeline
            | Type::Persistent
            | Type::Fallback
            | Type::ReactiveFallback
            | Type::RoundRobin(_) => (1, 3),
            Type::Parallel(..) | Type::ParallelAll(_) => (3, 3),
            _ => (1, 1),
        };
        match kind {
            Type::Gate(_) => self.chance(format!("p_{name}_if")),
            Type::Timeout => self.chance(format!("p_{name}_in_time")),
            Type::Switch => {
                self.chance(format!("p_{name}_case_1"));
                self.chance(format!("p_{name}_case_2"));
            }
            _ => {}
        }
        let children = self.some(least, most, depth);
        let node = Ticked::new(name, kind, children);
        self.with_preconditions(node)
    }

    fn leaf(&mut self, number: usize) -> Ticked {
        let name = format!("L{number}");
        let kind = match self.random.below(8) {
            0 => Type::Always(Status::Success),
            1 => Type::Always(Status::Failure),
            2 | 3 => Type::Condition,
            _ => Type::Leaf,
        };
        if !matches!(kind, Type::Always(_)) {
            self.chance(format!("p_{name}"));
        }
        let node = Ticked::new(name, kind, Vec::new());
        self.with_preconditions(node)
    }

    fn with_preconditions(&mut self, mut node: Ticked) -> Ticked {
        if !self.kinds.preconditions {
            return node;
        }
        for which in ["failureIf", "successIf", "skipIf", "while"] {
            let often = if which == "skipIf" { 5 } else { 16 };
            if self.random.below(often) > 0 {
                continue;
            }
            let literal = match self.random.below(6) {
                0 => Some(true),
                1 => Some(false),
                _ => None,
            };
            if literal.is_none() {
                self.chance(format!("p_{}_{which}", node.name));
            }
            node.preconditions.push((which, literal));
        }
        node
    }

    fn kind(&mut self) -> Type {
        let random = &mut self.random;
        let most = 1 + random.below(3) as i64;
        let endless = self.kinds.endless && random.below(2) == 0;
        let rounds = if endless { -1 } else { most };
        let forced = [Status::Success, Status::Failure][random.below(2)];
        let reactive = self.kinds.reactive;
        loop {
            return match random.below(27) {
                0 | 1 => Type::Sequence,
                2 | 3 => Type::Fallback,
                4 if reactive => Type::ReactiveSequence,
                5 if reactive => Type::ReactiveFallback,
                6 => Type::Memory,
                7 if reactive => Type::Pipeline,
                8 => Type::Persistent,
                9 if reactive => Type::Parallel([-1, 1, 2, 3, -2, 0][random.below(6)], most),
                10 if reactive => Type::ParallelAll(random.below(4) as i64),
                11 => Type::IfThenElse,
                12 if reactive => Type::WhileDoElse,
                13 => Type::Switch,
                14 => Type::TryCatch,
                15 => Type::Inverter,
                16 => Type::Force(forced),
                17 | 18 => Type::Retry(rounds),
                19 => Type::Repeat(rounds),
                20 if self.kinds.endless => Type::KeepRunning,
                21 => Type::RunOnce(random.below(2) == 0),
                22 => {
                    Type::Gate([Status::Success, Status::Failure, Status::Skipped][random.below(3)])
                }
                23 => [Type::Timeout, Type::Delay][random.below(2)].clone(),
                24 | 25 => Type::Recovery(random.below(3) as i64),
                26 => Type::RoundRobin(random.below(3) > 0),
                _ => continue,
            };
        }
    }
}

/// The text of a tree, in format 4.
pub fn text(tree: &Ticked) -> String {
    let mut text = "<root BTCPP_format=\"4\">\n<BehaviorTree ID=\"Main\">\n".to_owned();
    write_node(tree, &mut text);
    text + "</BehaviorTree>\n</root>\n"
}

fn write_node(node: &Ticked, text: &mut String) {
    let word = |status: &Status| match status {
        Status::Success => "SUCCESS",
        Status::Failure => "FAILURE",
        _ => "SKIPPED",
    };
    let (tag, attributes) = match &node.kind {
        Type::Leaf => ("Action ID=\"Act\"".to_owned(), String::new()),
        Type::Condition => ("Condition ID=\"Is\"".to_owned(), String::new()),
        Type::Always(Status::Success) => ("AlwaysSuccess".to_owned(), String::new()),
        Type::Always(_) => ("AlwaysFailure".to_owned(), String::new()),
        Type::Parallel(successes, failures) => (
            "Parallel".to_owned(),
            format!(" success_count=\"{successes}\" failure_count=\"{failures}\""),
        ),
        Type::ParallelAll(failures) => (
            "ParallelAll".to_owned(),
            format!(" max_failures=\"{failures}\""),
        ),
        Type::Switch => (
            "Switch2".to_owned(),
            " variable=\"{x}\" case_1=\"1\" case_2=\"2\"".to_owned(),
        ),
        Type::Force(Status::Success) => ("ForceSuccess".to_owned(), String::new()),
        Type::Force(_) => ("ForceFailure".to_owned(), String::new()),
        Type::Retry(most) => (
            "RetryUntilSuccessful".to_owned(),
            format!(" num_attempts=\"{most}\""),
        ),
        Type::Repeat(most) => ("Repeat".to_owned(), format!(" num_cycles=\"{most}\"")),
        Type::KeepRunning => ("KeepRunningUntilFailure".to_owned(), String::new()),
        Type::RunOnce(then_skip) => ("RunOnce".to_owned(), format!(" then_skip=\"{then_skip}\"")),
        Type::Gate(otherwise) => (
            "Precondition".to_owned(),
            format!(" if=\"x > 1\" else=\"{}\"", word(otherwise)),
        ),
        Type::Timeout => ("Timeout".to_owned(), " msec=\"100\"".to_owned()),
        Type::Delay => ("Delay".to_owned(), " delay_msec=\"100\"".to_owned()),
        Type::Recovery(most) => (
            "RecoveryNode".to_owned(),
            format!(" number_of_retries=\"{most}\""),
        ),
        Type::RoundRobin(wraps) => ("RoundRobin".to_owned(), format!(" wrap_around=\"{wraps}\"")),
        Type::Memory => ("SequenceWithMemory".to_owned(), String::new()),
        Type::Pipeline => ("PipelineSequence".to_owned(), String::new()),
        Type::Persistent => ("PersistentSequence".to_owned(), String::new()),
        other => (format!("{other:?}"), String::new()),
    };
    let _ = write!(text, "<{tag} name=\"{}\"{attributes}", node.name);
    for (which, literal) in &node.preconditions {
        let value = literal.map_or("x == 2".to_owned(), |it| it.to_string());
        let _ = write!(text, " _{which}=\"{value}\"");
    }
    text.push_str(">\n");
    node.children.iter().for_each(|it| write_node(it, text));
    let end = tag.split(' ').next().unwrap_or_default();
    let _ = writeln!(text, "</{end}>");
}
