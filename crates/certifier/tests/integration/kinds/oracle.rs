//! Value iteration in floating point as an oracle, and what is asserted with it.

use certifier::inequalities::{Bounds, Problem};
use certifier::{Certified, Choice, Failure, Oracle, certify_by};
use prism_lang::{
    Constants, Rational, parse_model, parse_properties, rational_to_f64, resolve,
    resolve_properties,
};

/// Iterates from below; bounds are widened by steps against slowness, and spoilt by so much at the state from which
/// most is left open.
pub struct Iteration {
    spoilt: [f64; 2],
    pub asked: usize,
    /// What it says the values themselves are.
    pub exact: Option<Vec<Rational>>,
}

impl Iteration {
    pub fn new(low: f64, high: f64) -> Self {
        Self {
            spoilt: [low, high],
            asked: 0,
            exact: None,
        }
    }
}

impl Oracle for Iteration {
    fn bounds(&mut self, problem: &Problem<'_>, attempt: u32) -> Option<Bounds> {
        self.asked += 1;
        let states = problem.choices.len();
        let start = |s: usize| {
            if problem.target[s] && !problem.is_reward {
                1.0
            } else {
                0.0
            }
        };
        let mut x: Vec<f64> = (0..states).map(start).collect();
        // How long it takes to leave the open states: what bounds may be moved by.
        let mut long = vec![0.0; states];
        let open = |s: usize| !problem.target[s] && !problem.failed[s];
        let rounded = |choices: &Vec<Choice>| -> Vec<(f64, Vec<(usize, f64)>)> {
            let row = |choice: &Choice| {
                let reward = if problem.is_reward {
                    rational_to_f64(&choice.reward)
                } else {
                    0.0
                };
                let outcomes = choice.outcomes.iter();
                let outcomes = outcomes.map(|(t, p)| (*t, rational_to_f64(p)));
                (reward, outcomes.collect())
            };
            choices.iter().map(row).collect()
        };
        let choices: Vec<_> = problem.choices.iter().map(rounded).collect();
        for _ in 0..1200 {
            for s in (0..states).filter(|s| open(*s)) {
                let values = choices[s].iter().map(|(reward, outcomes)| {
                    (outcomes.iter()).fold(*reward, |sum, (t, p)| sum + p * x[*t])
                });
                x[s] = match problem.maximise {
                    true => values.fold(0.0, f64::max),
                    false => values.fold(f64::INFINITY, f64::min),
                };
                let times = choices[s].iter().map(|(_, outcomes)| {
                    (outcomes.iter()).fold(1.0, |sum, (t, p)| sum + p * long[*t])
                });
                long[s] = if x[s] > 0.0 {
                    times.fold(0.0, f64::max)
                } else {
                    0.0
                };
            }
        }
        // What grew without end is infinite, and so it is where the target can be missed.
        let reaches = possible(problem, problem.target);
        let never: Vec<bool> = reaches.iter().map(|reaches| !reaches).collect();
        let misses = possible(problem, &never);
        let misses = |s: usize| {
            if problem.maximise {
                misses[s]
            } else {
                never[s]
            }
        };
        let infinite = |(s, x): (usize, &f64)| match problem.is_reward && (*x > 1000.0 || misses(s))
        {
            true => f64::INFINITY,
            false => *x,
        };
        let x: Vec<f64> = x.iter().enumerate().map(infinite).collect();
        let wide = 1e-12 * 100f64.powi(attempt as i32);
        let mut bounds = Bounds {
            lower: (0..states)
                .map(|s| (x[s] - wide * long[s]).max(0.0))
                .collect(),
            upper: (0..states)
                .map(|s| x[s] + if x[s] > 0.0 { wide * long[s] } else { 0.0 })
                .collect(),
            scheduler: None,
        };
        if !problem.is_reward {
            bounds.upper.iter_mut().for_each(|u| *u = u.min(1.0));
        }
        for s in
            (0..states).filter(|s| open(*s) && x[*s] > 0.0 && (problem.is_reward || x[*s] < 1.0))
        {
            bounds.lower[s] += self.spoilt[0];
            bounds.upper[s] -= self.spoilt[1];
        }
        Some(bounds)
    }

    fn exact(&mut self, _: &Problem<'_>) -> Option<Vec<Option<Rational>>> {
        let values = self.exact.clone()?;
        Some(values.into_iter().map(Some).collect())
    }
}

/// Solves the equations of chains, too, in rationals.
pub struct Elimination(pub Iteration);

impl Oracle for Elimination {
    fn bounds(&mut self, problem: &Problem<'_>, attempt: u32) -> Option<Bounds> {
        self.0.bounds(problem, attempt)
    }

    fn exact(&mut self, problem: &Problem<'_>) -> Option<Vec<Option<Rational>>> {
        let states = problem.choices.len();
        let number = |n: i64| Rational::from_integer(n.into());
        let reaches = possible(problem, problem.target);
        let mut lines: Vec<Vec<Rational>> = Vec::new();
        for (s, choices) in problem.choices.iter().enumerate() {
            let mut line = vec![number(0); states + 1];
            line[s] = number(1);
            if problem.target[s] {
                line[states] = number(i64::from(!problem.is_reward));
            } else if reaches[s] && !problem.failed[s] {
                for (to, p) in &choices[0].outcomes {
                    line[*to] -= p;
                }
                if problem.is_reward {
                    line[states] = choices[0].reward.clone();
                }
            }
            lines.push(line);
        }
        for column in 0..states {
            let pivot = (column..states).find(|row| lines[*row][column] != number(0))?;
            lines.swap(column, pivot);
            let own = lines[column].clone();
            for (row, line) in lines.iter_mut().enumerate() {
                let factor = &line[column] / &own[column];
                if row != column && factor != number(0) {
                    line.iter_mut()
                        .zip(&own)
                        .for_each(|(a, b)| *a -= &factor * b);
                }
            }
        }
        let value = |row: usize| Some(&lines[row][states] / &lines[row][row]);
        Some((0..states).map(value).collect())
    }
}

/// The states that may come to a set outside the target.
fn possible(problem: &Problem<'_>, set: &[bool]) -> Vec<bool> {
    let mut reached = set.to_vec();
    for _ in 0..reached.len() {
        for s in (0..reached.len()).filter(|s| !problem.target[*s]) {
            let mut targets = problem.choices[s]
                .iter()
                .flat_map(|choice| &choice.outcomes);
            let leads = targets.any(|(t, _)| reached[*t]);
            reached[s] |= leads;
        }
    }
    reached
}

pub fn certified(text: &str, asked: &str, oracle: &mut dyn Oracle) -> Result<Certified, Failure> {
    let model = resolve(&parse_model(text).tree, &Constants::new()).unwrap();
    let asked = parse_properties(asked).into_result().unwrap();
    let asked = resolve_properties(&asked, &model, &Constants::new()).unwrap();
    certify_by(&model, &asked[0].property, oracle)
}

/// The value is certified to within 1e-6; where something is asked of the oracle, bounds that are wrong by little are not.
pub fn holds(text: &str, asked: &str, expected: f64) {
    let mut oracle = Iteration::new(0.0, 0.0);
    let found = certified(text, asked, &mut oracle).unwrap_or_else(|e| panic!("{asked}: {e}"));
    let near = |x: f64| x == expected || (x - expected).abs() <= 1e-6 * expected.abs().max(1e-3);
    assert!(near(found.low) && near(found.high), "{asked}: {found:?}");
    assert!(
        found.low <= expected * (1.0 + 1e-15) && expected * (1.0 - 1e-15) <= found.high,
        "{asked}: {found:?}"
    );
    if oracle.asked > 0 && expected.is_finite() {
        for (low, high) in [(1e-3, 0.0), (0.0, 1e-3), (1e-3, -1e-2), (-1e-2, 1e-3)] {
            let mut oracle = Iteration::new(low, high);
            match certified(text, asked, &mut oracle) {
                Err(Failure::Broken { .. }) => {}
                // What is spoilt may not matter in the initial state, but then the bounds still hold.
                Ok(found) => {
                    assert!(
                        found.low <= expected + 1e-12 && expected <= found.high + 1e-12,
                        "{asked}: {found:?}"
                    );
                }
                Err(other) => panic!("{asked}: {other}"),
            }
        }
    }
}
