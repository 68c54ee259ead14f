//! A tree as a model in the PRISM language, laid out to be read.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use crate::flow::{At, Change, Command, Counter, Flow, Guard, Key, Target, Variable, flow};
use crate::tree::{BehaviourTree, Draw, Kind, Leaf, Node, NodeId, Outcome};

/// What a condition shows when it is executed again.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Conditions {
    /// A result of its own each time, with the same chance.
    #[default]
    DrawnAgain,
    /// What it showed the first time in the run.
    Kept,
}

/// How a model is made.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// What conditions show when they are executed again. It bears on leaves that are known to be conditions.
    pub conditions: Conditions,
    /// Values of constants by name; the others stay open, to be given when the model is checked.
    pub values: BTreeMap<String, f64>,
}

/// A constant of the model.
#[derive(Clone, Debug, PartialEq)]
pub struct Constant {
    /// Its name, `p_` and the name of what is drawn.
    pub name: String,
    /// The node.
    pub node: NodeId,
    /// What it is the chance of.
    pub draw: Draw,
}

/// A model.
#[derive(Clone, Debug)]
pub struct PrismModel {
    /// The text.
    pub text: String,
    /// Its constants, in the order of the text: one for each draw.
    pub constants: Vec<Constant>,
    /// Whether a run can end skipped, beside success and failure.
    pub may_be_skipped: bool,
}

/// A discrete-time Markov chain of one run of the root, until it ends in success, failure or skipped.
///
/// For each leaf it has labels `"NAME_ran"` and `"NAME_failed"`, true where the leaf has just ended; for each `Timeout`
/// `"NAME_ran"` and `"NAME_late"`, true where it is known whether its time suffices; `"success"`, `"failure"` and, where that
/// can be, `"skipped"` for the run. `NAME` is [`Node::label`].
pub fn to_prism(tree: &BehaviourTree, options: &Options) -> PrismModel {
    let outcomes = crate::read::outcomes(tree);
    let flow = flow(tree, options.conditions, &outcomes);
    let may_be_skipped = flow
        .points
        .contains_key(&(tree.root(), At::Over(Outcome::Skipped)));
    let mut text = Text {
        tree,
        flow: &flow,
        options,
        text: String::new(),
    };
    text.head();
    let constants = text.constants();
    text.points();
    text.module();
    text.labels();
    PrismModel {
        text: text.text,
        constants,
        may_be_skipped,
    }
}

struct Text<'a> {
    tree: &'a BehaviourTree,
    flow: &'a Flow,
    options: &'a Options,
    text: String,
}

impl Text<'_> {
    fn line(&mut self, line: impl AsRef<str>) {
        self.text.push_str(line.as_ref());
        self.text.push('\n');
    }

    fn head(&mut self) {
        let root = self.tree.node(self.tree.root());
        let id = match self.tree.id.is_empty() {
            true => &root.name,
            false => &self.tree.id,
        };
        self.line(format!(
            "// One run of the behaviour tree {} ({}), until its root succeeds or fails.",
            shown(id),
            shown(&root.file)
        ));
        self.line("// A node that is executed runs to its end before another one is; draws are independent.");
        let again = match self.options.conditions {
            Conditions::DrawnAgain => "A condition that is executed again is drawn again.",
            Conditions::Kept => "A condition keeps its first value for the whole run.",
        };
        self.line(format!("// {again}"));
        self.line("//");
        let lines: Vec<String> = self
            .tree
            .nodes()
            .map(|(id, _)| self.drawn_node(id))
            .collect();
        lines.iter().for_each(|line| self.line(line));
        self.line("dtmc\n");
    }

    /// A node as a line of the tree's picture.
    fn drawn_node(&self, id: NodeId) -> String {
        let node = self.tree.node(id);
        let mut depth = 0;
        let mut around = node.parent;
        while let Some((parent, _)) = around {
            depth += 1;
            around = self.tree.node(parent).parent;
        }
        let name = match node.name == node.type_name {
            true => String::new(),
            false => format!(" {}", shown(&node.name)),
        };
        let indent = "  ".repeat(depth);
        let type_name = shown(&node.type_name);
        format!(
            "//   {indent}{type_name}{name}{}  [line {}]",
            detail(&node.kind),
            node.line
        )
    }

    fn constants(&mut self) -> Vec<Constant> {
        let mut found = Vec::new();
        for (key, commands) in &self.flow.points {
            for draw in commands.iter().filter_map(|it| it.draw) {
                let node = self.tree.node(key.0);
                let name = format!("p_{}", node.draw_name(draw));
                let constant = Constant {
                    name,
                    node: key.0,
                    draw,
                };
                if !found.contains(&constant) {
                    found.push(constant);
                }
            }
        }
        for constant in &found {
            let value = self.options.values.get(&constant.name);
            let value = value.map_or(String::new(), |it| format!(" = {it}"));
            let node = self.tree.node(constant.node);
            let name = &constant.name;
            self.line(format!("// {}", meaning(node, constant.draw)));
            self.line(format!("const double {name}{value};"));
        }
        self.line("");
        found
    }

    fn points(&mut self) {
        self.line("// Where the run is.");
        let keys: Vec<Key> = self.keys();
        for (number, key) in keys.iter().enumerate() {
            let name = self.point(*key);
            self.line(format!("const int {name} = {number};"));
        }
        self.line("");
    }

    /// The points in the order of the tree, the ends of the run last.
    fn keys(&self) -> Vec<Key> {
        let is_over = |key: &&Key| matches!(key.1, At::Over(_));
        let keys = self.flow.points.keys();
        let (over, others): (Vec<&Key>, Vec<&Key>) = keys.partition(is_over);
        others.into_iter().chain(over).copied().collect()
    }

    fn point(&self, (id, at): Key) -> String {
        let label = &self.tree.node(id).label;
        match at {
            At::Precondition(place) => format!("precondition_{}_{label}", place + 1),
            At::Begin(0) => format!("begin_{label}"),
            At::Begin(case) => format!("case_{}_{label}", case + 1),
            At::Run => format!("at_{label}"),
            At::Succeeded => format!("{}_{label}", self.ends(id)[0]),
            At::Failed => format!("{}_{label}", self.ends(id)[1]),
            At::Counted(ended) => format!("after_{ended}_{label}"),
            At::Again => format!("again_{label}"),
            At::Done => format!("done_{label}"),
            At::Over(Outcome::Success) => "succeeded".to_owned(),
            At::Over(Outcome::Failure) => "failed".to_owned(),
            At::Over(Outcome::Skipped) => "skipped".to_owned(),
        }
    }

    /// What the points begin with at which a leaf has ended, or is known whether a time suffices: the good one, and the other.
    fn ends(&self, id: NodeId) -> [&'static str; 2] {
        self.tree.node(id).ends()
    }

    fn counter(&self, (id, counter): Variable) -> String {
        let prefix = match counter {
            Counter::Rounds => "rounds",
            Counter::Next => "next",
            Counter::Tried => "tried",
            Counter::Any => "any",
            Counter::Successes => "successes",
            Counter::Failures => "failures",
            Counter::Ran => "ran",
            Counter::Kept => "kept",
        };
        format!("{prefix}_{}", self.tree.node(id).label)
    }

    fn module(&mut self) {
        let flow = self.flow;
        let last = flow.points.len().saturating_sub(1);
        let start = flow.start.map_or(String::new(), |key| self.point(key));
        self.line("module tree");
        self.line(format!("  step : [0..{last}] init {start};"));
        for (variable, most) in &flow.counters {
            let name = self.counter(*variable);
            let says = counted(variable.1);
            self.line(format!("  {name} : [0..{most}] init 0; // {says}"));
        }
        let mut of = None;
        for key in self.keys() {
            let commands = &flow.points[&key];
            if of != Some(key.0) && !commands.is_empty() {
                of = Some(key.0);
                let node = self.tree.node(key.0);
                let (path, line) = (shown(&node.path), node.line);
                self.line(format!("\n  // {path}, line {line}"));
            }
            for command in commands {
                let text = self.command(key, command);
                self.line(text);
            }
        }
        self.line("");
        for (key, _) in flow.points.iter().filter(|(_, it)| it.is_empty()) {
            let name = self.point(*key);
            self.line(format!("  [] step={name} -> true;"));
        }
        self.line("endmodule\n");
    }

    fn command(&self, key: Key, command: &Command) -> String {
        let mut text = format!("  [] step={}", self.point(key));
        for guard in &command.guards {
            let _ = match guard {
                Guard::Is(variable, value) => {
                    write!(text, " & {}={value}", self.counter(*variable))
                }
                Guard::Below(variable, value) => {
                    write!(text, " & {}<{value}", self.counter(*variable))
                }
                Guard::AtLeast(variable, value) => {
                    write!(text, " & {}>={value}", self.counter(*variable))
                }
            };
        }
        text.push_str(" -> ");
        match (command.draw, command.to.as_slice()) {
            (Some(draw), [succeeded, failed]) => {
                let name = format!("p_{}", self.tree.node(key.0).draw_name(draw));
                let (succeeded, failed) = (self.target(succeeded), self.target(failed));
                let _ = write!(text, "{name} : {succeeded} + 1-{name} : {failed};");
            }
            (_, targets) => {
                let targets: Vec<String> = targets.iter().map(|it| self.target(it)).collect();
                let _ = write!(text, "{};", targets.join(" + "));
            }
        }
        text
    }

    fn target(&self, target: &Target) -> String {
        let mut text = format!("(step'={})", self.point(target.key));
        for (variable, change) in &target.changes {
            let name = self.counter(*variable);
            let _ = match change {
                Change::To(value) => write!(text, " & ({name}'={value})"),
                Change::Plus(more) => write!(text, " & ({name}'={name}+{more})"),
            };
        }
        text
    }

    fn labels(&mut self) {
        for (outcome, label) in [
            (Outcome::Success, "success"),
            (Outcome::Failure, "failure"),
            (Outcome::Skipped, "skipped"),
        ] {
            let key = (self.tree.root(), At::Over(outcome));
            let text = match self.flow.points.contains_key(&key) {
                true => format!("step={}", self.point(key)),
                false if outcome == Outcome::Skipped => continue,
                false => "false".to_owned(),
            };
            self.line(format!("label \"{label}\" = {text};"));
        }
        let is_drawn = |node: &Node| node.is_leaf() || node.kind == Kind::Deadline;
        for (id, node) in self.tree.nodes().filter(|(_, node)| is_drawn(node)) {
            let label = &node.label;
            let [good, bad] = self.ends(id);
            let is_reached = self.flow.points.contains_key(&(id, At::Failed));
            let (ran, failed) = match is_reached {
                true => (
                    format!("step={good}_{label} | step={bad}_{label}"),
                    format!("step={bad}_{label}"),
                ),
                false => ("false".to_owned(), "false".to_owned()),
            };
            self.line(format!("label \"{label}_ran\" = {ran};"));
            let what = if node.is_leaf() { "failed" } else { bad };
            self.line(format!("label \"{label}_{what}\" = {failed};"));
        }
    }
}

/// What a constant is the chance of, in words.
pub(crate) fn meaning(node: &Node, draw: Draw) -> String {
    let path = shown(&node.path);
    let line = node.line;
    let what = match draw {
        Draw::Leaf => match node.kind {
            Kind::Leaf(Leaf::Condition) => "is true when it is asked",
            _ => "succeeds once it is executed",
        },
        Draw::Precondition(which) => {
            let mut scripts = node.preconditions.iter();
            let script = scripts.find(|(it, _)| *it == which);
            let script = script.map_or(String::new(), |(_, it)| shown(&it.text));
            return format!(
                "{path}, line {line}: _{}=\"{script}\" is true",
                which.word()
            );
        }
        Draw::Gate => "lets its child be executed, by the blackboard",
        Draw::Deadline => "has time enough for its child",
        Draw::Case(at) => {
            return format!("{path}, line {line}: takes case {}, if none before", at + 1);
        }
    };
    format!("{path}, line {line}: {what}")
}

/// What a counter counts, in words.
fn counted(counter: Counter) -> &'static str {
    match counter {
        Counter::Rounds => "rounds before the one under way",
        Counter::Next => "the child that comes next, from 0",
        Counter::Tried => "children that were tried in this round",
        Counter::Any => "1 once a child was not skipped",
        Counter::Successes => "children that succeeded",
        Counter::Failures => "children that failed",
        Counter::Ran => "0 not yet executed, 1 executed, 2 executed and failed",
        Counter::Kept => "the value that is kept: 0 none yet, 1 true, 2 false",
    }
}

/// What a node's line in the picture says beside its name.
fn detail(kind: &Kind) -> String {
    let count = |most: &Option<u32>| match most {
        Some(most) => format!(" ({most} times)"),
        None => " (without end)".to_owned(),
    };
    match kind {
        Kind::Retry(most) | Kind::Repeat(most) => count(most),
        Kind::Recovery(most) => format!(" ({most} recoveries)"),
        Kind::Parallel {
            successes,
            failures,
            ..
        } => format!(" (success with {successes}, failure with {failures})"),
        Kind::ParallelAll { failures } => format!(" (failure with {failures})"),
        Kind::Leaf(Leaf::Whole) => " (one leaf with all that is in it)".to_owned(),
        _ => String::new(),
    }
}

/// A text of the tree's file in a comment of one line.
fn shown(text: &str) -> String {
    let clean = |c: char| if c.is_control() { ' ' } else { c };
    let text: String = text.chars().map(clean).collect();
    match text.char_indices().nth(200) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text,
    }
}
