//! All small formulas and words, for tests that compare one reading of a definition with another.

#![allow(dead_code, reason = "each test uses some of these")]

use temporal::formula::{Bound, Formula, Interval, TimeUnit};

/// Windows in whole seconds.
pub fn windows() -> Vec<Interval> {
    let at_least = Interval {
        low: Bound::secs(1.0),
        high: None,
    };
    vec![
        Interval::UNBOUNDED,
        Interval::secs(0.0, 1.0),
        Interval::secs(1.0, 2.0),
        Interval::secs(1.0, 1.0),
        at_least,
    ]
}

/// Windows in samples.
pub fn sample_windows() -> Vec<Interval> {
    let at_least = Interval {
        low: Bound {
            value: 1.0,
            unit: TimeUnit::Samples,
        },
        high: None,
    };
    vec![
        Interval::UNBOUNDED,
        Interval::samples(0, 1),
        Interval::samples(1, 2),
        at_least,
    ]
}

/// Each operator that has one operand, with each window.
pub fn of_one(inner: &Formula, windows: &[Interval], next: bool) -> Vec<Formula> {
    let boxed = || Box::new(inner.clone());
    let mut all = vec![
        Formula::Not(boxed()),
        Formula::Rise(boxed()),
        Formula::Fall(boxed()),
    ];
    if next {
        all.extend([Formula::Next(boxed()), Formula::Previous(boxed())]);
    }
    for &window in windows {
        all.extend([
            Formula::Eventually(window, boxed()),
            Formula::Always(window, boxed()),
            Formula::Once(window, boxed()),
            Formula::Historically(window, boxed()),
        ]);
    }
    all
}

/// Each operator that has two operands, with each window.
pub fn of_two(left: &Formula, right: &Formula, windows: &[Interval]) -> Vec<Formula> {
    let left = || Box::new(left.clone());
    let right = || Box::new(right.clone());
    let mut all = vec![
        Formula::And(vec![*left(), *right()]),
        Formula::Or(vec![*left(), *right()]),
        Formula::Implies(left(), right()),
        Formula::Iff(left(), right()),
    ];
    for &window in windows {
        all.extend([
            Formula::Until(window, left(), right()),
            Formula::WeakUntil(window, left(), right()),
            Formula::Release(window, left(), right()),
            Formula::Since(window, left(), right()),
        ]);
    }
    all
}

/// All formulas with one operator over two atoms, and all with two.
pub fn small(windows: &[Interval], next: bool) -> (Vec<Formula>, Vec<Formula>) {
    let atoms = [Formula::atom(0), Formula::atom(1)];
    let mut one = vec![Formula::True, Formula::False];
    for left in &atoms {
        one.extend(of_one(left, windows, next));
        for right in &atoms {
            one.extend(of_two(left, right, windows));
        }
    }
    let mut two = Vec::new();
    for inner in &one {
        two.extend(of_one(inner, windows, next));
        two.extend(of_two(inner, &atoms[1], windows));
        two.extend(of_two(&atoms[0], inner, windows));
    }
    (one, two)
}

/// A fixed sequence that looks random.
pub struct Numbers(pub u64);

impl Numbers {
    /// A number below `limit`.
    pub fn below(&mut self, limit: u64) -> u64 {
        self.0 = (self.0)
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % limit
    }
}
