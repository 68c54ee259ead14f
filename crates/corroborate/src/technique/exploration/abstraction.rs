//! Holding a recording against a formal model, by propositions that have a
//! meaning for both.
//!
//! # Definition
//! An abstract state is the set of the propositions that hold. The model's
//! quotient has an abstract state for each set that holds in some reachable
//! state, a transition A -> B for each transition of the model from a state of
//! A to one of B, A != B, and A is an end if a bottom component of the model
//! has a state of A. A recording gives a sequence of abstract states, one for
//! each instant; equal neighbours are one; what holds shorter than a declared
//! time is passed over. Its step A -> B is known if the quotient has a path
//! from A to B of at most a declared number of transitions; its end is known
//! if its last abstract state is an end, or the recording was cut short.
//!
//! A proposition that a model does not express is false there: that is how a
//! model that has never heard of something shows it.
//!
//! # Assumes
//! Propositions mean the same of the model and of recordings. What holds shorter than the declared time is noise.
//!
//! # Source and guarantee
//! The quotient is the existential abstraction of E. M. Clarke, O. Grumberg
//! and D. E. Long, "Model checking and abstraction" (1994): it has every
//! behaviour of the model and more. So what is reported as unknown is unknown
//! to the model, to the resolution of the recording; not all that the model
//! does not have is reported.

use super::formal::{Formal, Meaning};
use super::plan::Plan;
use checker::graph::bottom_components;
use diagnostic::Problem;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use study::Study;
use trace::{BoundPredicate, Cursor, Predicate, Sampling, Trace, ticks};

/// A set of propositions, one bit each.
pub type Class = u64;

/// The quotient of a model, and how recordings are abstracted.
pub struct Abstraction {
    names: Vec<String>,
    predicates: Vec<Predicate>,
    shortest_secs: f64,
    /// The abstract states of the model.
    pub states: BTreeSet<Class>,
    /// Its abstract transitions.
    pub transitions: BTreeSet<(Class, Class)>,
    /// Steps that count as known: paths of few transitions.
    known: BTreeSet<(Class, Class)>,
    /// Where the model can stay for ever.
    ends: BTreeSet<Class>,
    /// Where all states of the model are ones that it never leaves.
    rests: BTreeSet<Class>,
    /// The abstract state of each state of the model.
    pub class_of: Vec<Class>,
    /// Propositions that the model does not express, with the reason.
    pub not_expressed: Vec<(String, String)>,
}

/// What a recording does, in abstract states.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct AbstractTrace {
    /// The abstract states, no two neighbours equal.
    pub classes: Vec<Class>,
    /// From when on each held, in seconds.
    pub from_secs: Vec<f64>,
    /// When the recording ends.
    pub end_secs: f64,
    /// Whether the recording is all there is.
    pub complete: bool,
}

impl Abstraction {
    /// The abstraction that a plan declares.
    pub fn new(study: &Study, plan: &Plan, formal: &Formal) -> Result<Option<Self>, Problem> {
        let Some(data) = &plan.data.abstraction else {
            return Ok(None);
        };
        let mut class_of = vec![0; formal.space.num_states()];
        let (mut names, mut predicates, mut not_expressed) = (Vec::new(), Vec::new(), Vec::new());
        for (bit, declared) in data.proposition.iter().enumerate() {
            let name = &declared.name;
            let word = study.vocabulary.propositions.get(name);
            let of_model = word.and_then(|w| w.model.as_ref()).map(|b| &b.text);
            match declared.model.as_ref().or(of_model) {
                Some(text) => match formal.meaning(text)? {
                    Meaning::Holds(flags) => {
                        for (class, holds) in class_of.iter_mut().zip(flags) {
                            *class |= Class::from(holds) << bit;
                        }
                    }
                    Meaning::Unknown(reason) => not_expressed.push((name.clone(), reason)),
                },
                None => not_expressed.push((name.clone(), "it has no meaning for a model".into())),
            }
            let text = declared.trace.as_deref().unwrap_or(name);
            let predicate = study.vocabulary.signals.predicate(text);
            predicates.push(predicate.map_err(|error| {
                plan.mistake(text, error.to_string())
                    .remedy("give the proposition a meaning for recordings: `trace = \"...\"`")
            })?);
            names.push(name.clone());
        }
        let mut abstraction = Self {
            names,
            predicates,
            shortest_secs: data.shortest_secs,
            states: class_of.iter().copied().collect(),
            transitions: BTreeSet::new(),
            known: BTreeSet::new(),
            ends: BTreeSet::new(),
            rests: BTreeSet::new(),
            class_of,
            not_expressed,
        };
        abstraction.quotient(formal, data.steps.max(1));
        Ok(Some(abstraction))
    }

    fn quotient(&mut self, formal: &Formal, steps: usize) {
        let class_of = &self.class_of;
        for (from, class) in class_of.iter().enumerate() {
            for (to, _) in formal.steps().row(from) {
                if class_of[to] != *class {
                    self.transitions.insert((*class, class_of[to]));
                }
            }
        }
        let bottom = bottom_components(formal.steps());
        let last = bottom.iter().flatten().map(|s| class_of[*s as usize]);
        self.ends = last.collect();
        let mut stays = vec![false; class_of.len()];
        for component in &bottom {
            if let [state] = component[..] {
                stays[state as usize] = true;
            }
        }
        let moves = class_of.iter().zip(&stays).filter(|(_, stays)| !**stays);
        let moves: BTreeSet<Class> = moves.map(|(class, _)| *class).collect();
        self.rests = self.states.difference(&moves).copied().collect();
        let mut next: BTreeMap<Class, BTreeSet<Class>> = BTreeMap::new();
        for (from, to) in &self.transitions {
            next.entry(*from).or_default().insert(*to);
        }
        for from in &self.states {
            let mut reached = BTreeSet::from([*from]);
            for _ in 0..steps {
                let more = reached.iter().filter_map(|class| next.get(class)).flatten();
                let more: Vec<Class> = more.copied().collect();
                reached.extend(more);
            }
            let known = reached.into_iter().map(|to| (*from, to));
            self.known.extend(known.filter(|(from, to)| from != to));
        }
    }

    /// The propositions that hold, separated by blanks.
    pub fn describe(&self, class: Class) -> String {
        let holding = self.names.iter().enumerate();
        let holding = holding.filter(|(bit, _)| class >> bit & 1 == 1);
        let names: Vec<&str> = holding.map(|(_, name)| name.as_str()).collect();
        names.join(" ")
    }

    /// The abstract states of a recording.
    pub fn of_trace(&self, trace: &Trace) -> Result<AbstractTrace, Problem> {
        let bad = |error: &dyn std::fmt::Display| Problem::new("bad-recording", error.to_string());
        let bound = self.predicates.iter().map(|p| p.bind(trace));
        let bound: Vec<BoundPredicate> = bound.collect::<Result<_, _>>().map_err(|e| bad(&e))?;
        let times = ticks(trace, Sampling::EveryRow).map_err(|e| bad(&e))?;
        let mut cursor = Cursor::new(trace);
        let mut class = 0;
        let mut held: Vec<(Class, f64)> = Vec::new();
        let end_secs = times.last().copied().unwrap_or(0.0);
        for time_secs in times {
            cursor.seek(time_secs);
            for (bit, predicate) in bound.iter().enumerate() {
                // What is not known stays as it was.
                if let Some(holds) = predicate.eval(&cursor) {
                    class = class & !(1 << bit) | Class::from(holds) << bit;
                }
            }
            if held.last().is_none_or(|(last, _)| *last != class) {
                held.push((class, time_secs));
            }
        }
        let lasting = lasting(&held, end_secs, self.shortest_secs, trace.complete);
        let (classes, from_secs) = lasting.into_iter().unzip();
        Ok(AbstractTrace {
            classes,
            from_secs,
            end_secs,
            complete: trace.complete,
        })
    }

    /// Whether the model has a step.
    pub fn knows(&self, from: Class, to: Class) -> bool {
        self.known.contains(&(from, to))
    }

    /// Steps of a recording that the model does not have; without a second
    /// state, an end.
    pub fn unknown(&self, of: &AbstractTrace) -> Vec<(Class, Option<Class>)> {
        let unknown = self.unknown_at(of).into_iter();
        unknown.map(|(step, _)| step).collect()
    }

    /// The same, each with when it was, in seconds.
    pub fn unknown_at(&self, of: &AbstractTrace) -> Vec<((Class, Option<Class>), f64)> {
        let steps = of.classes.windows(2).zip(of.from_secs.iter().skip(1));
        let steps = steps.map(|(pair, secs)| (pair[0], pair[1], *secs));
        let steps = steps.filter(|(from, to, _)| !self.knows(*from, *to));
        let mut unknown: Vec<_> = steps
            .map(|(from, to, secs)| ((from, Some(to)), secs))
            .collect();
        if let Some(last) = of.classes.last()
            && of.complete
            && !self.ends.contains(last)
        {
            unknown.push(((*last, None), of.end_secs));
        }
        unknown
    }

    /// From when on a recording is where the model stays for ever, whatever state of the model it is; `None` if it never
    /// is, or the model has no such states.
    pub fn rests_from_secs(&self, of: &AbstractTrace) -> Option<f64> {
        let mut held = of.classes.iter().zip(&of.from_secs);
        let found = held.find(|(class, _)| self.rests.contains(class));
        found.map(|(_, secs)| *secs)
    }

    /// Whether the model has states in which it stays for ever.
    pub fn rests(&self) -> bool {
        !self.rests.is_empty()
    }

    /// The signals by which states are told apart, `/topic.field`.
    pub fn signals(&self) -> BTreeSet<String> {
        self.predicates
            .iter()
            .flat_map(Predicate::signals)
            .collect()
    }
}

/// Leaves out what holds shorter than `shortest_secs`, except what holds at the
/// end of a whole recording, and joins equal neighbours.
fn lasting(
    held: &[(Class, f64)],
    end_secs: f64,
    shortest_secs: f64,
    is_whole: bool,
) -> Vec<(Class, f64)> {
    let mut classes: Vec<(Class, f64)> = Vec::new();
    for (place, (class, from_secs)) in held.iter().enumerate() {
        let until_secs = held.get(place + 1).map_or(end_secs, |(_, next)| *next);
        let is_last = is_whole && place + 1 == held.len();
        // Times are sums of steps: a nanosecond is no part of them.
        let lasts = until_secs - from_secs + 1e-9 >= shortest_secs;
        if (lasts || is_last) && classes.last().map(|(last, _)| last) != Some(class) {
            classes.push((*class, *from_secs));
        }
    }
    classes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_holds_shortly_is_passed_over_and_equal_neighbours_are_one() {
        let lasting = |held: &[(Class, f64)], end_secs, shortest_secs, is_whole| -> Vec<Class> {
            let kept = super::lasting(held, end_secs, shortest_secs, is_whole);
            // Each is kept with when it began.
            assert!(kept.iter().all(|it| held.contains(it)));
            kept.into_iter().map(|(class, _)| class).collect()
        };
        let held = [(0, 0.0), (1, 1.0), (3, 1.1), (1, 1.15), (2, 5.0)];
        assert_eq!(lasting(&held, 9.0, 0.0, true), [0, 1, 3, 1, 2]);
        assert_eq!(lasting(&held, 9.0, 0.2, true), [0, 1, 2]);
        assert_eq!(lasting(&held, 9.0, 0.1, true), [0, 1, 2]);
        // What holds at the end is not passed over, however short.
        assert_eq!(lasting(&held, 5.0, 0.2, true), [0, 1, 2]);
        // Of a recording that was cut short it may have lasted or not.
        assert_eq!(lasting(&held, 5.0, 0.2, false), [0, 1]);
        assert_eq!(lasting(&held, 9.0, 0.2, false), [0, 1, 2]);
    }
}
