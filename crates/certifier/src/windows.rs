//! Boolean combinations of path formulas, some of which have bounds in time.
//!
//! *Definition.* All windows `left U[a,b] right` are counted from the start. Between two neighbouring ends of windows a
//! path is followed in states of the chain together with what is known of each window and the states of the machines of
//! formulas without bounds. When a state is entered, and when a window begins or ends, an open window becomes true in a
//! state of `right` if it has begun; else false outside `left`, or if it has ended. After the last end a bottom component
//! decides: windows that are open there stay so, which is false, and machines are marked infinitely often or not.
//!
//! *Method.* Forward, what is reachable in each segment of time, up to where the formula is decided; then backward, the
//! probability that it becomes true: by reachability after the last end, by uniformisation in intervals before
//! ([`after`]).
//!
//! Source: Baier, Haverkort, Hermanns and Katoen 2003, section 4 (segments of time); Donatelli, Haddad and Sproston 2009
//! (the product). Trusted: [`crate::formula`]. Cost: states times 3 to the number of windows times the machines' states, in
//! each segment. Guarantee: that of uniformisation in intervals, and of reachability, which is shown by inequalities.

use num_traits::{One, Zero};
use prism_lang::Rational;
use prism_lang::property::Path;
use rustc_hash::FxHashMap;

use crate::evaluate::Evaluator;
use crate::explicit::end_components;
use crate::failure::Failure;
use crate::formula::{Clause, Condition, Machine};
use crate::interval::Interval;
use crate::question::unsupported;
use crate::reading::{Choice, Reading};
use crate::timed::{Window, after};

const MOST_STATES: usize = 2_000_000;

/// The formula, over numbers of windows and of formulas without bounds.
enum Combined {
    Window(usize),
    Untimed(usize),
    Not(Box<Combined>),
    All(Vec<Combined>),
    Any(Vec<Combined>),
}

impl Combined {
    /// Whether it holds, as far as that follows from what is known of its parts.
    fn truth(&self, windows: &[Option<bool>], untimed: &[Option<bool>]) -> Option<bool> {
        let joined = |of: &[Self], neutral: bool| {
            let truths: Vec<Option<bool>> = of.iter().map(|f| f.truth(windows, untimed)).collect();
            match truths.contains(&Some(!neutral)) {
                true => Some(!neutral),
                false if truths.contains(&None) => None,
                false => Some(neutral),
            }
        };
        match self {
            Self::Window(number) => windows[*number],
            Self::Untimed(number) => untimed[*number],
            Self::Not(of) => of.truth(windows, untimed).map(|holds| !holds),
            Self::All(of) => joined(of, true),
            Self::Any(of) => joined(of, false),
        }
    }
}

/// What is read of the formula.
#[derive(Default)]
struct Parts {
    windows: Vec<Window>,
    machines: Vec<Machine>,
    /// For each formula without bounds what machines must do, of which one clause is enough.
    untimed: Vec<Vec<Clause>>,
    sets: Vec<Vec<bool>>,
}

/// A state of a segment.
#[derive(Clone, PartialEq, Eq, Hash)]
enum Place {
    Decided(bool),
    Open {
        state: usize,
        known: Vec<Option<bool>>,
        machines: Vec<usize>,
    },
}

/// What is reachable between two ends of windows.
#[derive(Default)]
struct Segment {
    places: Vec<Place>,
    index: FxHashMap<Place, usize>,
    /// One choice for each place.
    choices: Vec<Vec<Choice>>,
    rate: Vec<Rational>,
}

impl Segment {
    fn enter(&mut self, place: Place) -> usize {
        let new = self.places.len();
        let number = *self.index.entry(place.clone()).or_insert(new);
        if number == new {
            self.places.push(place);
        }
        number
    }
}

/// The formula and the chain.
struct Followed<'a> {
    reading: &'a Reading,
    formula: Combined,
    parts: Parts,
    /// The letter of each state.
    letters: Vec<u64>,
    /// When segments begin.
    times: Vec<Rational>,
}

impl Followed<'_> {
    /// A place in the segment of this number, after what is known of windows there.
    fn judged(
        &self,
        segment: usize,
        state: usize,
        mut known: Vec<Option<bool>>,
        machines: Vec<usize>,
    ) -> Place {
        let now = &self.times[segment];
        for (window, known) in self.parts.windows.iter().zip(&mut known) {
            if known.is_some() {
                continue;
            }
            let has_ended = window.end.as_ref().is_some_and(|end| end <= now);
            if window.begin <= *now && window.right[state] {
                *known = Some(true);
            } else if !window.left[state] || has_ended {
                *known = Some(false);
            }
        }
        let open = vec![None; self.parts.untimed.len()];
        match self.formula.truth(&known, &open) {
            Some(truth) => Place::Decided(truth),
            None => Place::Open {
                state,
                known,
                machines,
            },
        }
    }

    /// The machines' states after the letter of a state.
    fn stepped(&mut self, machines: &[usize], state: usize) -> Result<Vec<usize>, Failure> {
        let letter = self.letters[state];
        let each = self.parts.machines.iter_mut().zip(machines);
        each.map(|(machine, place)| machine.step(*place, letter))
            .collect()
    }

    /// All that is reachable in a segment from where it is entered.
    fn explored(
        &mut self,
        number: usize,
        mut segment: Segment,
        cancelled: &dyn Fn() -> bool,
    ) -> Result<Segment, Failure> {
        while segment.choices.len() < segment.places.len() {
            let from = segment.choices.len();
            if segment.places.len() > MOST_STATES {
                return Err(unsupported("so many bounds in time in so large a model"));
            }
            if from.is_multiple_of(1024) && cancelled() {
                return Err(Failure::Cancelled);
            }
            let (outcomes, rate) = match segment.places[from].clone() {
                Place::Decided(_) => (vec![(from, Rational::one())], Rational::zero()),
                Place::Open {
                    state,
                    known,
                    machines,
                } => {
                    let mut outcomes: Vec<(usize, Rational)> = Vec::new();
                    for (target, p) in &self.reading.choices[state][0].outcomes {
                        let machines = self.stepped(&machines, *target)?;
                        let place = self.judged(number, *target, known.clone(), machines);
                        let to = segment.enter(place);
                        match outcomes.iter_mut().find(|(known, _)| *known == to) {
                            Some((_, sum)) => *sum += p,
                            None => outcomes.push((to, p.clone())),
                        }
                    }
                    outcomes.sort_unstable_by_key(|(to, _)| *to);
                    (outcomes, self.reading.rate[state].clone())
                }
            };
            segment.choices.push(vec![Choice {
                outcomes,
                reward: Rational::zero(),
            }]);
            segment.rate.push(rate);
        }
        Ok(segment)
    }

    /// The places of the last segment from which the formula is true for good.
    fn accepting(&self, last: &Segment) -> Vec<bool> {
        let everywhere = vec![true; last.places.len()];
        let mut accepting = vec![false; last.places.len()];
        for component in end_components(&last.choices, &everywhere, &|_| true) {
            let recurs = |machine: &usize| {
                component.iter().any(|place| match &last.places[*place] {
                    Place::Open { machines, .. } => {
                        self.parts.machines[*machine].is_marked(machines[*machine])
                    }
                    Place::Decided(_) => false,
                })
            };
            let met = |clause: &Clause| {
                clause.again.iter().all(recurs) && !clause.not_again.iter().any(recurs)
            };
            let untimed: Vec<Option<bool>> = (self.parts.untimed.iter())
                .map(|clauses| Some(clauses.iter().any(met)))
                .collect();
            let truth = match &last.places[component[0]] {
                Place::Decided(truth) => Some(*truth),
                Place::Open { known, .. } => {
                    let known: Vec<Option<bool>> =
                        known.iter().map(|k| k.or(Some(false))).collect();
                    self.formula.truth(&known, &untimed)
                }
            };
            for place in component {
                accepting[place] = truth == Some(true);
            }
        }
        accepting
    }
}

impl Evaluator<'_> {
    /// The probability of a formula of which some operators have bounds in time, in each state.
    pub(crate) fn in_windows(&mut self, path: &Path) -> Result<Vec<Interval>, Failure> {
        let mut parts = Parts::default();
        let formula = self.combined(path, &mut parts)?;
        if parts.sets.len() > 64 {
            return Err(unsupported("a formula over more than 64 sets of states"));
        }
        let reading = self.reading()?;
        let letter = |state: usize| {
            let sets = parts.sets.iter().enumerate();
            sets.fold(0u64, |all, (bit, set)| all | u64::from(set[state]) << bit)
        };
        let ends = parts.windows.iter().flat_map(|window| {
            let end = window.end.iter().cloned();
            end.chain([window.begin.clone()])
        });
        let mut times: Vec<Rational> = ends.chain([Rational::zero()]).collect();
        times.sort();
        times.dedup();
        let mut followed = Followed {
            reading: &reading,
            letters: (0..reading.states.len()).map(letter).collect(),
            formula,
            parts,
            times,
        };
        let cancelled = || self.oracle.is_cancelled();
        let mut segment = Segment::default();
        let mut start = Vec::with_capacity(reading.states.len());
        for state in 0..reading.states.len() {
            let before = vec![0; followed.parts.machines.len()];
            let machines = followed.stepped(&before, state)?;
            let open = vec![None; followed.parts.windows.len()];
            start.push(segment.enter(followed.judged(0, state, open, machines)));
        }
        let mut segments = vec![followed.explored(0, segment, &cancelled)?];
        // Where each place of a segment enters the next one.
        let mut entered: Vec<Vec<usize>> = Vec::new();
        for number in 1..followed.times.len() {
            let mut next = Segment::default();
            let places = segments[number - 1].places.iter();
            let each = places.map(|place| {
                let place = match place.clone() {
                    Place::Open {
                        state,
                        known,
                        machines,
                    } => followed.judged(number, state, known, machines),
                    decided => decided,
                };
                next.enter(place)
            });
            entered.push(each.collect());
            segments.push(followed.explored(number, next, &cancelled)?);
        }
        let Some(last) = segments.last() else {
            return Err(unsupported("a formula without bounds in time"));
        };
        let everywhere = vec![true; last.places.len()];
        let accepting = followed.accepting(last);
        let mut values = self.reached(&last.choices, &everywhere, &accepting, true)?;
        for number in (0..entered.len()).rev() {
            let (segment, next) = (&segments[number], &entered[number]);
            let x = next.iter().map(|place| values[*place]).collect();
            let time = &followed.times[number + 1] - &followed.times[number];
            let is_open = |place: usize| matches!(segment.places[place], Place::Open { .. });
            values = after(
                (&segment.choices, &segment.rate),
                &is_open,
                x,
                None,
                &time,
                &|| self.oracle.is_cancelled(),
            )?;
        }
        let probability = |place: &usize| values[*place].at_least(0.0).at_most(1.0);
        Ok(start.iter().map(probability).collect())
    }

    fn combined(&mut self, path: &Path, parts: &mut Parts) -> Result<Combined, Failure> {
        if !path.has_time_bound() {
            let formula = self.formula(path, &mut parts.sets)?;
            let condition = Condition::read(&formula, &mut parts.machines)?;
            parts.untimed.push(condition.clauses());
            return Ok(Combined::Untimed(parts.untimed.len() - 1));
        }
        if let Path::Timed { .. } = path {
            let (window, contrary) = self.window(path)?;
            parts.windows.push(window);
            let window = Combined::Window(parts.windows.len() - 1);
            return Ok(match contrary {
                true => not(window),
                false => window,
            });
        }
        let mut read = |path: &Path| self.combined(path, parts);
        Ok(match path {
            Path::Not(a) => not(read(a)?),
            Path::And(a, b) => Combined::All(vec![read(a)?, read(b)?]),
            Path::Or(a, b) => Combined::Any(vec![read(a)?, read(b)?]),
            Path::Implies(a, b) => Combined::Any(vec![not(read(a)?), read(b)?]),
            Path::Iff(a, b) => {
                let both = Combined::All(vec![read(a)?, read(b)?]);
                let neither = Combined::All(vec![not(read(a)?), not(read(b)?)]);
                Combined::Any(vec![both, neither])
            }
            _ => {
                return Err(unsupported(
                    "a bound in time within another temporal operator",
                ));
            }
        })
    }
}

fn not(of: Combined) -> Combined {
    Combined::Not(Box::new(of))
}
