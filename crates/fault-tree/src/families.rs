//! Families of sets as zero-suppressed decision diagrams, with a limit on their nodes.
//!
//! Source: S. Minato, *Zero-suppressed BDDs for set manipulation in combinatorial problems*, DAC 1993. All walks have their
//! own stacks.

use diagnostic::{Cancel, Problem};
use rustc_hash::FxHashMap;

use crate::bdd::{BOTTOM, Decision, FALSE, TRUE};
use crate::results::Results;

/// The family without a set.
pub(crate) const NO_SET: u32 = FALSE;
/// The family of the empty set alone.
pub(crate) const EMPTY_SET: u32 = TRUE;
/// Steps between looks at the flag that asks to stop.
const STEPS_BETWEEN_LOOKS: u64 = 4_096;
/// Sizes that are told apart; larger sets are listed after all others.
const SIZES: usize = 64;

enum Task {
    Visit(u32, u32),
    /// Takes from the last result what contains a set of this family, too.
    Again(u32),
    Join(u32, u32, u32),
}

/// Families over one order of the elements.
pub(crate) struct Families<'a> {
    pub nodes: Vec<Decision>,
    unique: FxHashMap<Decision, u32>,
    results: Results,
    limit: usize,
    steps: u64,
    cancel: &'a Cancel,
}

impl<'a> Families<'a> {
    pub fn new(limit: usize, cancel: &'a Cancel) -> Self {
        let constant = |value| Decision {
            level: BOTTOM,
            low: value,
            high: value,
        };
        Self {
            nodes: vec![constant(NO_SET), constant(EMPTY_SET)],
            unique: FxHashMap::default(),
            results: Results::new(),
            limit: limit.min(u32::MAX as usize - 2),
            steps: 0,
            cancel,
        }
    }

    /// The sets of `low`, and those of `high` with the element of this level, which is above both.
    pub fn family(&mut self, level: u32, low: u32, high: u32) -> Result<u32, Problem> {
        if high == NO_SET {
            return Ok(low);
        }
        let node = Decision { level, low, high };
        if let Some(known) = self.unique.get(&node) {
            return Ok(*known);
        }
        if self.nodes.len() - 2 >= self.limit {
            let message = format!(
                "the cut sets need more than the {} nodes of a decision diagram that are allowed",
                self.limit
            );
            return Err(Problem::undecided("fault-tree-limit", message)
                .remedy("allow more nodes, choose another order of the events, or ask for an event further down"));
        }
        let index = self.nodes.len() as u32;
        self.nodes.push(node);
        self.unique.insert(node, index);
        Ok(index)
    }

    /// The sets of `family` that contain no set of `others`, no set of which contains another.
    pub fn without(&mut self, family: u32, others: u32) -> Result<u32, Problem> {
        let mut tasks = vec![Task::Visit(family, others)];
        let mut results: Vec<u32> = Vec::new();
        while let Some(task) = tasks.pop() {
            match task {
                Task::Visit(a, b) => match self.known(a, b) {
                    Some(result) => results.push(result),
                    None => self.visit(a, b, &mut tasks)?,
                },
                Task::Again(b) => {
                    let a = results.pop().expect("the result before");
                    tasks.push(Task::Visit(a, b));
                }
                Task::Join(level, a, b) => {
                    let high = results.pop().expect("the second of two");
                    let low = results.pop().expect("the first of two");
                    let result = self.family(level, low, high)?;
                    self.results.put((a, b, 0), result, self.nodes.len());
                    results.push(result);
                }
            }
        }
        Ok(results[0])
    }

    fn known(&self, a: u32, b: u32) -> Option<u32> {
        match (a, b) {
            // Of a family in which no set contains another, the empty set is alone.
            (NO_SET, _) | (_, EMPTY_SET) => Some(NO_SET),
            (_, NO_SET) | (EMPTY_SET, _) => Some(a),
            _ if a == b => Some(NO_SET),
            _ => self.results.get((a, b, 0)),
        }
    }

    fn visit(&mut self, a: u32, b: u32, tasks: &mut Vec<Task>) -> Result<(), Problem> {
        self.step()?;
        let (left, right) = (self.nodes[a as usize], self.nodes[b as usize]);
        if left.level > right.level {
            // Sets with an element that none of `a` has are contained in none of them.
            tasks.push(Task::Visit(a, right.low));
            return Ok(());
        }
        tasks.push(Task::Join(left.level, a, b));
        if left.level < right.level {
            tasks.push(Task::Visit(left.high, b));
            tasks.push(Task::Visit(left.low, b));
        } else {
            tasks.push(Task::Again(right.low));
            tasks.push(Task::Visit(left.high, right.high));
            tasks.push(Task::Visit(left.low, right.low));
        }
        Ok(())
    }

    /// Looks from time to time whether the caller asks to stop.
    pub fn step(&mut self) -> Result<(), Problem> {
        self.steps += 1;
        if self.steps.is_multiple_of(STEPS_BETWEEN_LOOKS) && self.cancel.is_cancelled() {
            return Err(Problem::interrupted_while(
                "computing the cut sets of a fault tree",
            ));
        }
        Ok(())
    }

    /// At most `most` sets, the smallest first, each as the levels of its elements.
    pub fn smallest(&mut self, family: u32, most: usize) -> Result<Vec<Vec<u32>>, Problem> {
        let sizes = self.sizes(family);
        let mut found = Vec::new();
        for size in 0..SIZES {
            let fits = |node: u32, so_far: usize| {
                let missing = size.checked_sub(so_far);
                missing.is_some_and(|missing| sizes[node as usize].0 >> missing & 1 == 1)
            };
            self.list(family, fits, most, &mut found)?;
        }
        // Those that are larger than all sizes that are told apart.
        let fits = |node: u32, so_far: usize| {
            let largest = sizes[node as usize].1;
            largest.is_some_and(|largest| largest + so_far >= SIZES)
        };
        self.list(family, fits, most, &mut found)?;
        Ok(found)
    }

    /// Of each family: which sizes below [`SIZES`] its sets have, as bits, and the largest size.
    fn sizes(&self, family: u32) -> Vec<(u64, Option<usize>)> {
        let mut sizes = vec![(0, None), (1, Some(0))];
        for node in self.nodes.iter().take(family as usize + 1).skip(2) {
            let (low, high): ((u64, Option<usize>), (u64, Option<usize>)) =
                (sizes[node.low as usize], sizes[node.high as usize]);
            let larger = high.1.map(|size| size + 1);
            sizes.push((low.0 | high.0 << 1, low.1.max(larger)));
        }
        sizes
    }

    /// Appends the sets on whose way each node fits, given how many elements lead to it.
    fn list(
        &mut self,
        family: u32,
        fits: impl Fn(u32, usize) -> bool,
        most: usize,
        found: &mut Vec<Vec<u32>>,
    ) -> Result<(), Problem> {
        // A node, and how many elements lead to it; the last of them is taken first.
        let mut open = vec![(family, 0, None)];
        let mut path: Vec<u32> = Vec::new();
        while let Some((at, so_far, element)) = open.pop() {
            if found.len() >= most {
                break;
            }
            path.truncate(so_far - usize::from(element.is_some()));
            path.extend(element);
            if !fits(at, so_far) {
                continue;
            }
            self.step()?;
            if at == EMPTY_SET {
                found.push(path.clone());
                continue;
            }
            let node = self.nodes[at as usize];
            open.push((node.low, so_far, None));
            open.push((node.high, so_far + 1, Some(node.level)));
        }
        Ok(())
    }
}
