#![doc = include_str!("../README.md")]
//!
//! Sources: Hartmanns and Kaminski 2020, "Optimistic Value Iteration" (inductive bounds); Baier, Klein, Leuschner, Parker
//! and Wunderlich 2017, "Ensuring the Reliability of Your Model Checker: Interval Iteration for Markov Decision
//! Processes"; Chatterjee, Quatmann, Schäffeler, Weininger, Winkler and Zilken 2025, "Fixed Point Certificates for
//! Reachability and Expected Rewards in MDPs" (that progress towards the target must be shown for lower bounds).

mod average;
mod conditional;
mod evaluate;
mod explicit;
mod failure;
mod formula;
mod incoming;
pub mod inequalities;
mod interval;
mod multi;
mod process;
mod product;
mod quantifiers;
mod question;
mod reading;
mod steps;
mod timed;
mod total;
mod windows;

pub use evaluate::Oracle;
pub use failure::Failure;
pub use interval::Interval;
pub use multi::Curve;
pub use question::Question;
pub use reading::{Choice, Reading};

use prism_lang::Property;
use prism_lang::resolved::Model;
use rustc_hash::FxHashMap;

/// Bounds for every reachable state.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Certificate {
    /// The states: the values of the model's variables in its order.
    pub states: Vec<Vec<i64>>,
    /// A lower bound of the value in each of them; infinite where the value is claimed to be.
    pub lower: Vec<f64>,
    /// An upper bound, likewise.
    pub upper: Vec<f64>,
    /// For each state the outcomes of the choice that the scheduler takes, if one was found: the bound on its side (the
    /// lower one of a greatest value, the upper one of a least) is then that of the chain it induces. The states' numbers
    /// ascend; probabilities are compared to within 1e-9.
    pub scheduler: Option<Vec<Option<Outcomes>>>,
}

/// The places of a choice's targets among the certificate's states, with their probabilities.
pub type Outcomes = Vec<(usize, f64)>;

/// What was shown.
#[derive(Clone, Debug, PartialEq)]
pub struct Certified {
    /// The value is at least this in the initial states (the least of them).
    pub low: f64,
    /// The value is at most this in the initial states (the greatest of them).
    pub high: f64,
    /// The least value in the initial states (of a range: in its states), and the greatest: each lies in its interval.
    pub ends: [Interval; 2],
    /// Whether the property holds in all initial states, if it is true or false.
    pub truth: Option<bool>,
    /// What two objectives can have together, if that was asked.
    pub curve: Option<Curve>,
    /// How many states were read.
    pub states: usize,
    /// How many inequalities were checked.
    pub inequalities: u64,
}

/// Checks a certificate of a property's value.
///
/// # Errors
/// What does not hold, or what cannot be certified.
pub fn certify(
    model: &Model,
    property: &Property,
    certificate: &Certificate,
) -> Result<Certified, Failure> {
    let question = Question::new(model, property)?;
    let reading = Reading::new(model, &question)?;
    let bounds = ordered(&reading, certificate)?;
    let inequalities = inequalities::check(&reading, &question, &bounds)?;
    let initial = 0..reading.num_initial;
    let fold = |bounds: &[f64], join: fn(f64, f64) -> f64| {
        (initial.clone().map(|state| bounds[state])).reduce(join)
    };
    let low = fold(&bounds.lower, f64::min).ok_or(Failure::NoInitialState)?;
    let high = fold(&bounds.upper, f64::max).ok_or(Failure::NoInitialState)?;
    let upto = |bounds: &[f64]| bounds[initial.clone()].iter().copied().reduce(f64::max);
    let low_of_greatest = upto(&bounds.lower).ok_or(Failure::NoInitialState)?;
    let least = initial.clone().map(|state| bounds.upper[state]);
    let high_of_least = least.reduce(f64::min).ok_or(Failure::NoInitialState)?;
    let ends = [(low, high_of_least), (low_of_greatest, high)];
    let ends = ends.map(|(low, high)| Interval { low, high });
    let ends = match question.contrary {
        true => [ends[1].contrary(), ends[0].contrary()],
        false => ends,
    };
    Ok(Certified {
        low: ends[0].low,
        high: ends[1].high,
        ends,
        truth: None,
        curve: None,
        states: reading.states.len(),
        inequalities,
    })
}

/// Certifies a property of any kind: what has to be solved on the way is asked of an oracle, whose bounds count only
/// if they are shown to hold; what is true or false only where the bounds leave no doubt.
///
/// # Errors
/// What does not hold, or what cannot be certified.
///
/// ```
/// use certifier::{Oracle, certify_by, inequalities::{Bounds, Problem}};
/// use prism_lang::{Constants, parse_model, parse_properties, resolve, resolve_properties};
///
/// // Nobody to ask: enough for what happens within steps.
/// struct Nobody;
/// impl Oracle for Nobody {
///     fn bounds(&mut self, _: &Problem<'_>, _: u32) -> Option<Bounds> {
///         None
///     }
/// }
/// let text = "dtmc module coin s : [0..2]; [] s=0 -> 1/3:(s'=0) + 1/3:(s'=1) + 1/3:(s'=2); endmodule";
/// let model = resolve(&parse_model(text).tree, &Constants::new()).unwrap();
/// let asked = parse_properties("P=? [ F<=2 s=1 ]").tree;
/// let asked = resolve_properties(&asked, &model, &Constants::new()).unwrap();
/// let certified = certify_by(&model, &asked[0].property, &mut Nobody).unwrap();
/// assert!(certified.low <= 4.0 / 9.0 && 4.0 / 9.0 <= certified.high);
/// assert!(certified.high - certified.low < 1e-15);
/// ```
pub fn certify_by(
    model: &Model,
    property: &Property,
    oracle: &mut dyn Oracle,
) -> Result<Certified, Failure> {
    evaluate::Evaluator::new(model, oracle)?.certified(property)
}

/// The certificate in the order of the states that were read here.
fn ordered(reading: &Reading, certificate: &Certificate) -> Result<inequalities::Bounds, Failure> {
    let lengths = [certificate.lower.len(), certificate.upper.len()];
    if lengths.iter().any(|n| *n != certificate.states.len()) {
        return Err(Failure::Incomplete(
            "the bounds are not as many as the states".to_owned(),
        ));
    }
    let places: FxHashMap<&[i64], usize> = (certificate.states.iter().enumerate())
        .map(|(place, state)| (state.as_slice(), place))
        .collect();
    let mut order = Vec::with_capacity(reading.states.len());
    for state in &reading.states {
        let place = places.get(state.as_slice());
        order.push(*place.ok_or_else(|| {
            Failure::Incomplete(format!(
                "the state {state:?} can be reached, but has no bounds"
            ))
        })?);
    }
    let scheduler = match &certificate.scheduler {
        None => None,
        Some(taken) => Some(chosen(reading, &order, taken)?),
    };
    Ok(inequalities::Bounds {
        lower: order
            .iter()
            .map(|place| certificate.lower[*place])
            .collect(),
        upper: order
            .iter()
            .map(|place| certificate.upper[*place])
            .collect(),
        scheduler,
    })
}

/// For each state the place of the choice with these outcomes.
fn chosen(
    reading: &Reading,
    order: &[usize],
    taken: &[Option<Outcomes>],
) -> Result<Vec<Option<usize>>, Failure> {
    let mut number = vec![usize::MAX; taken.len()];
    for (state, place) in order.iter().enumerate() {
        if let Some(number) = number.get_mut(*place) {
            *number = state;
        }
    }
    let mut found = Vec::with_capacity(order.len());
    for (state, place) in order.iter().enumerate() {
        let Some(Some(outcomes)) = taken.get(*place) else {
            found.push(None);
            continue;
        };
        let mut outcomes: Vec<(usize, f64)> = (outcomes.iter())
            .filter_map(|(target, p)| Some((*number.get(*target)?, *p)))
            .collect();
        outcomes.sort_unstable_by_key(|(target, _)| *target);
        let same = |choice: &Choice| choice.is_like(&outcomes);
        let place = reading.choices[state].iter().position(same);
        found.push(Some(place.ok_or_else(|| {
            Failure::Incomplete(format!(
                "in the state {:?} the scheduler takes a choice that the model does not have",
                reading.states[state]
            ))
        })?));
    }
    Ok(found)
}
