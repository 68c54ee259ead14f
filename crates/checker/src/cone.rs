//! The states that matter when values are carried back over a number of steps, and that computation.
//!
//! *Definition.* Values `x_0` are given, and `x_k = F(x_(k-1))` on the active states, in which the value of a state depends on
//! those of its successors. Asked for is `x_n` in some states. With `a(s)` the least number of steps from these to `s`, and `b(s)`
//! that from `s` to a state where `x_0` is not 0:
//!
//! ```text
//! x_k(s) is needed only if  a(s) + k <= n,   and is 0 if  k < b(s)
//! ```
//!
//! So step `k` looks only at the states with `b(s) <= k <= n - a(s)`: those within the cone behind the states asked for and
//! within that before the support. Where a model is long and the number of steps small, that is a small part. The second bound
//! holds if a value of 0 stays 0 where all successors have 0, so not if something is earned.
//!
//! Cost: two breadth-first searches, then the entries of the states within both cones, for each step in which they are.
//! Guarantee: what is left out is known exactly; numbers are rounded to nearest, for the caller to account for.

use crate::choices::Choices;
use crate::rounding::SMALLEST_VALUE;

mod blocks;
pub(crate) use blocks::BlockWalk;

/// Not reached.
const FAR: u32 = u32::MAX;

/// The states within both cones, nearest to those asked for first.
#[derive(Debug)]
pub(crate) struct Cone {
    states: Vec<u32>,
    /// How many states are within each distance.
    within: Vec<usize>,
    /// `b` of each of the states.
    first: Vec<u32>,
    /// The number of states of the model.
    all: usize,
}

impl Cone {
    /// For `steps` steps; `support` says where the values are not 0, nothing if that does not matter.
    pub fn new<N>(
        choices: Choices<'_, N>,
        active: &[bool],
        from: &[usize],
        support: Option<&[bool]>,
        steps: usize,
    ) -> Self {
        let targets = |state: u32| &choices.matrix.column[choices.all_entries(state as usize)];
        let mut ahead = vec![FAR; active.len()];
        let mut order: Vec<u32> = Vec::new();
        for state in from.iter().filter(|state| active[**state]) {
            if ahead[*state] == FAR {
                ahead[*state] = 0;
                order.push(*state as u32);
            }
        }
        let mut next = 0;
        while let Some(state) = order.get(next).copied() {
            next += 1;
            let distance = ahead[state as usize] + 1;
            if distance as usize >= steps {
                continue;
            }
            for target in targets(state) {
                let target = *target as usize;
                if active[target] && ahead[target] == FAR {
                    ahead[target] = distance;
                    order.push(target as u32);
                }
            }
        }
        let mut cone = Self {
            states: Vec::new(),
            within: Vec::new(),
            first: Vec::new(),
            all: active.len(),
        };
        let behind = match support {
            Some(support) => distances(&order, &ahead, &targets, support),
            None => vec![1; order.len()],
        };
        for (state, first) in order.iter().zip(behind) {
            let distance = ahead[*state as usize] as usize;
            if first == FAR || distance + first as usize > steps {
                continue;
            }
            while cone.within.len() < distance {
                cone.within.push(cone.states.len());
            }
            cone.states.push(*state);
            cone.first.push(first);
        }
        cone.within.push(cone.states.len());
        cone
    }

    /// How many of the states are within this distance.
    fn within(&self, distance: usize) -> usize {
        self.within[distance.min(self.within.len() - 1)]
    }
}

/// `b` of each of the states in `order`, at least 1.
fn distances<'a>(
    order: &[u32],
    ahead: &[u32],
    targets: &impl Fn(u32) -> &'a [u32],
    support: &[bool],
) -> Vec<u32> {
    let mut place = vec![FAR; ahead.len()];
    for (at, state) in order.iter().enumerate() {
        place[*state as usize] = at as u32;
    }
    let mut start = vec![0_usize; order.len() + 1];
    let inside = |target: &&u32| place[**target as usize] != FAR;
    for state in order {
        for target in targets(*state).iter().filter(inside) {
            start[place[*target as usize] as usize + 1] += 1;
        }
    }
    for at in 0..order.len() {
        start[at + 1] += start[at];
    }
    let mut into = vec![0_u32; start[order.len()]];
    let mut free = start.clone();
    let mut behind = vec![FAR; order.len()];
    let mut queue: Vec<u32> = Vec::new();
    for (at, state) in order.iter().enumerate() {
        let mut is_next = support[*state as usize];
        for target in targets(*state) {
            is_next |= support[*target as usize];
            let target = place[*target as usize];
            if target != FAR {
                into[free[target as usize]] = at as u32;
                free[target as usize] += 1;
            }
        }
        if is_next {
            behind[at] = 1;
            queue.push(at as u32);
        }
    }
    let mut next = 0;
    while let Some(at) = queue.get(next).copied() {
        next += 1;
        let at = at as usize;
        for from in &into[start[at]..start[at + 1]] {
            if behind[*from as usize] == FAR {
                behind[*from as usize] = behind[at] + 1;
                queue.push(*from);
            }
        }
    }
    behind
}

/// Values that go back step by step, `W` problems side by side.
#[derive(Debug)]
pub(crate) struct Walk<const W: usize> {
    cone: Cone,
    steps: usize,
    /// Position of each state among the values: the cone's states, then those that keep theirs.
    place: Vec<u32>,
    /// Rows of each of the cone's states; none if each has one.
    choice_start: Vec<usize>,
    row_start: Vec<usize>,
    column: Vec<u32>,
    weight: Vec<f64>,
    /// What each row earns; nothing if empty.
    reward: Vec<[f64; W]>,
    /// Which problems are maximised.
    maximise: [bool; W],
    now: Vec<[f64; W]>,
    next: Vec<[f64; W]>,
    /// Steps so far.
    pub step: usize,
}

/// What a step has done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Progress {
    /// Whether any value is another; if not, none that is asked for ever will be.
    pub changed: bool,
    /// Whether a value has become so small that digits may be lost.
    pub underflow: bool,
}

impl<const W: usize> Walk<W> {
    /// From `value` of each state; `entries` gives a row of a state.
    pub fn new<N>(
        cone: Cone,
        steps: usize,
        choices: Choices<'_, N>,
        maximise: [bool; W],
        value: impl Fn(usize) -> [f64; W],
        entries: impl Fn(usize, usize, &mut Vec<(u32, f64)>),
    ) -> Self {
        let mut place = vec![FAR; choices.num_states()];
        for (at, state) in cone.states.iter().enumerate() {
            place[*state as usize] = at as u32;
        }
        let mut now: Vec<[f64; W]> = cone.states.iter().map(|s| value(*s as usize)).collect();
        let (mut choice_start, mut row_start) = (Vec::new(), vec![0]);
        let (mut column, mut weight) = (Vec::new(), Vec::new());
        let mut row_entries = Vec::new();
        for state in &cone.states {
            choice_start.push(row_start.len() - 1);
            for row in choices.rows(*state as usize) {
                row_entries.clear();
                entries(*state as usize, row, &mut row_entries);
                for (target, factor) in &row_entries {
                    let target = *target as usize;
                    if place[target] == FAR {
                        place[target] = now.len() as u32;
                        now.push(value(target));
                    }
                    column.push(place[target]);
                    weight.push(*factor);
                }
                row_start.push(column.len());
            }
        }
        choice_start.push(row_start.len() - 1);
        if row_start.len() == choice_start.len() {
            choice_start.clear();
        }
        Self {
            steps,
            place,
            choice_start,
            row_start,
            column,
            weight,
            reward: Vec::new(),
            maximise,
            next: now.clone(),
            now,
            step: 0,
            cone,
        }
    }

    /// With what the rows earn at each step.
    pub fn with_rewards<N>(
        mut self,
        choices: Choices<'_, N>,
        reward: impl Fn(usize) -> [f64; W],
    ) -> Self {
        let rows = (self.cone.states.iter()).flat_map(|state| choices.rows(*state as usize));
        self.reward = rows.map(reward).collect();
        self
    }

    /// The present value of a state that is asked for, or keeps its value next to one; nothing if the state does not matter, so
    /// that its value is what it was.
    pub fn value(&self, state: usize) -> Option<[f64; W]> {
        match self.place[state] {
            FAR => None,
            place => Some(self.now[place as usize]),
        }
    }

    /// The present values on which those that are asked for will depend, after the steps that are left.
    pub fn mattering(&self) -> impl Iterator<Item = &[f64; W]> {
        let count = (self.cone).within(self.steps.saturating_sub(self.step));
        let kept = self.cone.states.len();
        self.now[..count].iter().chain(&self.now[kept..])
    }

    /// Whether some of the values on which those that are asked for depend are kept.
    pub fn keeps_some(&self) -> bool {
        self.now.len() > self.cone.states.len()
    }

    /// What the rows earn at each step; nothing if none does.
    pub fn earned(&self) -> &[[f64; W]] {
        &self.reward
    }

    /// The greatest number of entries of a row.
    pub fn longest(&self) -> usize {
        let lengths = self.row_start.windows(2).map(|ends| ends[1] - ends[0]);
        lengths.max().unwrap_or(0)
    }

    /// One step more; at most as many as there were said to be.
    pub fn advance(&mut self) -> Progress {
        self.step += 1;
        let count = (self.cone).within(self.steps.saturating_sub(self.step));
        let (mut changed, mut underflow) = (false, false);
        let step = self.step as u32;
        for (at, first) in self.cone.first[..count].iter().enumerate() {
            if *first > step {
                continue;
            }
            let new = match self.choice_start.is_empty() {
                true => self.row_value(at),
                false => self.best(at),
            };
            for (new, now) in new.iter().zip(&self.now[at]) {
                changed |= new != now;
                underflow |= *new > 0.0 && *new < SMALLEST_VALUE;
            }
            self.next[at] = new;
        }
        std::mem::swap(&mut self.now, &mut self.next);
        Progress { changed, underflow }
    }

    #[inline]
    fn row_value(&self, row: usize) -> [f64; W] {
        let range = self.row_start[row]..self.row_start[row + 1];
        let mut sum = match self.reward.get(row) {
            Some(reward) => *reward,
            None => [0.0; W],
        };
        for (column, weight) in self.column[range.clone()].iter().zip(&self.weight[range]) {
            let target = self.now[*column as usize];
            for (sum, target) in sum.iter_mut().zip(target) {
                *sum += weight * target;
            }
        }
        sum
    }

    /// The best of a state's choices; what it has if there is none.
    fn best(&self, at: usize) -> [f64; W] {
        let rows = self.choice_start[at]..self.choice_start[at + 1];
        let mut best = None;
        for row in rows {
            let value = self.row_value(row);
            let Some(known) = &mut best else {
                best = Some(value);
                continue;
            };
            for lane in 0..W {
                if (value[lane] > known[lane]) == self.maximise[lane] {
                    known[lane] = value[lane];
                }
            }
        }
        best.unwrap_or(self.now[at])
    }
}
