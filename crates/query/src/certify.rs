//! `check --certify`: each answer checked again by code that shares nothing with the solver (crate `certifier`).

use crate::ending::Ending;
use crate::properties::Asked;
use crate::report::{CheckReport, PropertyReport};
use crate::request::CheckRequest;
use crate::written::number as text_of;
use certifier::inequalities::{self, Bounds};
use certifier::{Certified, Failure, Oracle, certify_by};
use checker::state_space::{Csr, Rewards, StateSpace, TransitionRewards};
use checker::{AnswerValue, CheckError, Options};
use diagnostic::Problem;
use prism_lang::ast::Optimum;
use prism_lang::property::{Quantity, RewardObjective, RewardQuery};
use prism_lang::resolved::{self, ModelType};
use prism_lang::{
    NamedProperty, Path, Property, Rational, StateFormula, TimeBound, rational_to_f64,
};
use schemars::JsonSchema;
use serde::Serialize;

/// What became of checking an answer again.
#[derive(Debug, Serialize, JsonSchema)]
pub struct CertificateReport {
    /// `certified`: the bounds below are shown, and the answer agrees with them; `refuted`: they are shown, and it
    /// does not; `not certified`: nothing was shown; `not finished`: the command had to end before.
    pub status: String,
    /// What the value is at least.
    pub low: Option<f64>,
    /// What the value is at most.
    pub high: Option<f64>,
    /// How many states of the model were read anew.
    pub states: u64,
    /// How many inequalities were checked.
    pub inequalities: u64,
    /// Why nothing was shown, or what does not agree.
    pub why: Option<String>,
}

impl CertificateReport {
    /// Whether the answer was certified.
    pub fn is_good(&self) -> bool {
        self.status == "certified"
    }

    /// Whether the command had to end before.
    pub fn is_unfinished(&self) -> bool {
        self.status == NOT_FINISHED
    }
}

/// The status of what the command had to end before.
const NOT_FINISHED: &str = "not finished";

/// How many times more than the residual bounds are widened by, one after the other.
const SLACKS: [f64; 5] = [2.0, 32.0, 1024.0, 1_048_576.0, 1_073_741_824.0];

/// The relative width of bounds beyond which they confirm no number.
const COARSE: f64 = 1e-3;

/// Certifies all answers of a report.
pub(crate) fn all(
    report: &mut CheckReport,
    request: &CheckRequest,
    model: &resolved::Model,
    asked: &[Asked],
    ending: &Ending,
) -> Result<(), Problem> {
    let cancel = || ending.is_due();
    let options = Options {
        precision: request.precision,
        cancel: Some(&cancel),
        ..Options::default()
    };
    for property in &mut report.properties {
        let Some(Asked::Property(named)) = asked.get(property.prop_idx - 1) else {
            continue;
        };
        if property.error.is_some() {
            continue;
        }
        let is_fair = request.fair && model.model_type == resolved::ModelType::Mdp;
        let found = match is_fair {
            _ if ending.is_due() => None,
            true => Some(nothing(
                "values over fair schedulers cannot be certified yet".into(),
            )),
            false => one(property, named, model, &options),
        };
        // The answer stays.
        let ended = || CertificateReport {
            status: NOT_FINISHED.into(),
            ..nothing(format!("the command was {}", ending.reason()))
        };
        property.certificate = Some(found.unwrap_or_else(ended));
    }
    Ok(())
}

/// What became of an answer; nothing if the work had to end.
fn one(
    report: &PropertyReport,
    named: &NamedProperty,
    model: &resolved::Model,
    options: &Options<'_>,
) -> Option<CertificateReport> {
    let mut solver = Solver {
        options,
        is_cancelled: false,
        why: None,
    };
    let found = certify_by(model, &named.property, &mut solver);
    match found {
        Err(Failure::Cancelled) => None,
        Err(_) if solver.is_cancelled => None,
        Ok(certified) => Some(judged(report, &certified)),
        Err(failure) => {
            let why = solver.why.unwrap_or_else(|| failure.to_string());
            Some(nothing(why))
        }
    }
}

/// The solver as the certifier's oracle: it is asked about explicit problems, and trusted in nothing.
struct Solver<'a> {
    options: &'a Options<'a>,
    is_cancelled: bool,
    /// Why the last problem has no bounds.
    why: Option<String>,
}

impl Oracle for Solver<'_> {
    fn is_cancelled(&self) -> bool {
        self.options.cancel.is_some_and(|cancel| cancel())
    }

    fn bounds(&mut self, problem: &inequalities::Problem<'_>, attempt: u32) -> Option<Bounds> {
        let slack = *SLACKS.get(attempt as usize)?;
        let (space, property) = asked_of_the_solver(problem, vec![0], rational_to_f64);
        match checker::bounds_of_states(&space, &property, self.options, slack) {
            Ok(bounds) => Some(Bounds {
                lower: bounds.lower,
                upper: bounds.upper,
                scheduler: None,
            }),
            Err(CheckError::Cancelled) => {
                self.is_cancelled = true;
                None
            }
            Err(error) => {
                self.why = Some(error.to_string());
                None
            }
        }
    }

    fn exact(&mut self, problem: &inequalities::Problem<'_>) -> Option<Vec<Option<Rational>>> {
        let everywhere = (0..problem.choices.len()).collect();
        let (space, property) = asked_of_the_solver(problem, everywhere, Rational::clone);
        match checker::check_exact(&space, &property, self.options) {
            Ok(answer) => (answer.initial.into_iter())
                .map(|of| match of.value {
                    AnswerValue::Exact(value) => Some(Some(value)),
                    AnswerValue::Number(f64::INFINITY) => Some(None),
                    _ => None,
                })
                .collect(),
            Err(CheckError::Cancelled) => {
                self.is_cancelled = true;
                None
            }
            Err(_) => None,
        }
    }
}

/// A problem as a state space without variables and a property of it.
fn asked_of_the_solver<N>(
    problem: &inequalities::Problem<'_>,
    initial: Vec<usize>,
    number: impl Fn(&Rational) -> N,
) -> (StateSpace<N>, Property) {
    let is_chain = problem.choices.iter().all(|choices| choices.len() == 1);
    let rows = problem.choices.iter().flatten().map(|choice| {
        let entry = |(target, p): &(usize, Rational)| (*target as u32, number(p));
        choice.outcomes.iter().map(entry).collect()
    });
    let matrix = Csr::from_rows(rows.collect());
    let (kind, choice_start) = match is_chain {
        true => (ModelType::Dtmc, Vec::new()),
        false => {
            let mut start = vec![0];
            for choices in problem.choices {
                start.push(start[start.len() - 1] + choices.len());
            }
            (ModelType::Mdp, start)
        }
    };
    let waits = problem.failed.iter().map(|failed| !failed).collect();
    let labels = vec![
        ("target".to_owned(), problem.target.to_vec()),
        ("waits".to_owned(), waits),
    ];
    let mut space = StateSpace::from_parts(kind, matrix, choice_start, initial, labels);
    let label = |name: &str| StateFormula::Label(name.to_owned());
    let path = |name: &str| Box::new(Path::State(Box::new(label(name))));
    let optimum = match problem.maximise {
        _ if is_chain => None,
        true => Some(Optimum::Max),
        false => Some(Optimum::Min),
    };
    let quantity = match problem.is_reward {
        false => Quantity::Probability {
            optimum,
            path: Box::new(Path::Until {
                left: path("waits"),
                right: path("target"),
                bound: TimeBound::default(),
            }),
        },
        true => {
            let earned = problem.choices.iter().flatten();
            let earned: Vec<N> = earned.map(|choice| number(&choice.reward)).collect();
            let nothing = problem
                .choices
                .iter()
                .map(|_| number(&Rational::from_integer(0.into())));
            let rewards = match is_chain {
                true => Rewards::of_states(earned),
                false => Rewards {
                    transition: TransitionRewards::Row(earned),
                    ..Rewards::of_states(nothing.collect())
                },
            };
            space = space.with_rewards(None, rewards);
            let objective = RewardObjective::Reach(Box::new(label("target")));
            let reward = RewardQuery {
                structure: 0,
                divisor: None,
                objective,
            };
            Quantity::Reward { optimum, reward }
        }
    };
    (space, Property::Number(quantity))
}

fn nothing(why: String) -> CertificateReport {
    CertificateReport {
        status: "not certified".into(),
        low: None,
        high: None,
        states: 0,
        inequalities: 0,
        why: Some(why),
    }
}

/// Whether an answer agrees with what was shown.
fn judged(report: &PropertyReport, certified: &Certified) -> CertificateReport {
    let (low, high) = (certified.low, certified.high);
    let why = match (report.result.as_deref(), certified.truth) {
        (Some(answer @ ("true" | "false")), Some(truth)) => Some((answer == "true") == truth),
        // Nothing meets the bounds of several objectives, so that there is no optimum.
        (Some("NaN"), Some(false)) => Some(true),
        (Some(_), Some(false)) => Some(false),
        (Some("NaN"), _) => (low > f64::NEG_INFINITY).then_some(false),
        (Some("Infinity"), _) if low == f64::INFINITY => Some(true),
        (Some("Infinity"), _) => (high < f64::INFINITY).then_some(false),
        (Some(text), _) if certified.curve.is_some() => {
            let (curve, corners) = (certified.curve.as_ref(), corners(text));
            curve
                .zip(corners)
                .and_then(|(curve, corners)| curve.has_corners(&corners))
        }
        (Some(text), _) if text.starts_with('[') => several(report, text, certified),
        _ => match (report.low.or(report.value), report.high.or(report.value)) {
            (Some(from), Some(to)) if from > high || to < low => Some(false),
            (Some(_), Some(_)) if !is_coarse(low, high) => Some(true),
            _ => None,
        },
    };
    let (status, why) = match why {
        Some(true) => ("certified", None),
        Some(false) if certified.curve.is_some() => {
            let why = "schedulers are shown to attain more, or less, than these corners";
            ("refuted", Some(why.to_owned()))
        }
        None if certified.curve.is_some() => {
            let why = "the curve is not shown closely enough";
            ("not certified", Some(why.to_owned()))
        }
        Some(false) => {
            let why = format!(
                "the value is shown to lie between {} and {}",
                text_of(low),
                text_of(high)
            );
            ("refuted", Some(why))
        }
        None => {
            let why = format!(
                "the value is shown to lie between {} and {} only",
                text_of(low),
                text_of(high)
            );
            ("not certified", Some(why))
        }
    };
    let finite = |x: f64| x.is_finite().then_some(x);
    CertificateReport {
        status: status.into(),
        low: finite(low),
        high: finite(high),
        states: certified.states as u64,
        inequalities: certified.inequalities,
        why,
    }
}

/// Whether the least and the greatest value agree with what was shown of each: `[low,high]`, as the answer is printed.
///
/// The answer's bounds are those of both together: its least value is as far from their lower end as its own are wide.
fn several(report: &PropertyReport, text: &str, certified: &Certified) -> Option<bool> {
    let (low, high) = text.strip_prefix('[')?.strip_suffix(']')?.split_once(',')?;
    let (low, high) = (number(low)?, number(high)?);
    let own = |end: f64, bound: Option<f64>| {
        let width = bound.map_or(0.0, |bound| (end - bound).abs());
        match width.is_finite() {
            true => [end - width, end + width],
            false => [end, end],
        }
    };
    let ends = [own(low, report.low), own(high, report.high)];
    let mut narrow = true;
    for ([from, to], shown) in ends.iter().zip(&certified.ends) {
        if *from > shown.high || *to < shown.low {
            return Some(false);
        }
        narrow &= !is_coarse(shown.low, shown.high);
    }
    narrow.then_some(true)
}

/// The corners of a curve, `[(a,b),(c,d)]`, as the answer is printed.
fn corners(text: &str) -> Option<Vec<[f64; 2]>> {
    let pairs = text.strip_prefix("[(")?.strip_suffix(")]")?.split("),(");
    let pair = |pair: &str| {
        let (a, b) = pair.split_once(',')?;
        Some([number(a.trim())?, number(b.trim())?])
    };
    pairs.map(pair).collect()
}

/// A number as answers print it.
fn number(text: &str) -> Option<f64> {
    match text {
        "Infinity" => Some(f64::INFINITY),
        "-Infinity" => Some(f64::NEG_INFINITY),
        _ => match text.contains('/') {
            true => text.parse().ok().map(|exact| rational_to_f64(&exact)),
            false => text.parse().ok(),
        },
    }
}

/// Whether bounds are too far apart to confirm a number.
fn is_coarse(low: f64, high: f64) -> bool {
    low < high && high - low > COARSE * low.abs().max(high.abs())
}

#[cfg(test)]
mod tests {
    use super::*;
    use prism_lang::{Constants, parse_model, parse_properties, resolve, resolve_properties};
    use study::Method;

    const MODEL: &str = "mdp module m s : [0..3];
        [a] s=0 -> 1/3:(s'=1) + 2/3:(s'=2); [b] s=0 -> 1/2:(s'=0) + 1/2:(s'=2);
        [a] s=1 -> (s'=3); [b] s=1 -> (s'=1); [] s=3 -> (s'=1); [] s=2 -> true; endmodule
        rewards s=1 : 1; s=3 : 2; s=0 : 1; endrewards
        rewards \"once\" s=0 : 1; [a] s=0 : 1; endrewards";

    #[test]
    fn answers_of_each_kind_are_certified_and_altered_ones_refuted() {
        let model = resolve(&parse_model(MODEL).tree, &Constants::new()).unwrap();
        let space = checker::explore::explore::<f64>(&model).unwrap();
        let options = Options::default();
        let judge = |report: &PropertyReport, named: &NamedProperty| {
            let found = one(report, named, &model, &options).unwrap();
            (found.status, found.why)
        };
        for text in [
            "Pmax=? [ F s=3 ]",
            "Pmin=? [ F s=2 ]",
            "Pmax=? [ F<=4 s=3 ]",
            "Pmax=? [ X s=2 ]",
            "Pmax=? [ (G F s=1) & (G F s=3) ]",
            "Pmin=? [ (G F s=1) => (G F s=3) ]",
            "Pmax=? [ F (P>=1 [ X s=3 ]) ]",
            "Rmin=? [ F s!=0 ]",
            "Rmax=? [ C<=5 ]",
            "Rmin=? [ I=3 ]",
            "Rmin=? [ C ]",
            "Rmax=? [ S ]",
            "Rmax=? [ F (s!=0 & (X true)) ]",
            "Pmax=? [ F s=3 ] + Rmax=? [ C<=2 ]",
            "Pmin=? [ s=0 U (G s=2) ]",
            "Pmax=? [ F s=3 || F s>0 ]",
            "multi(Pmax=? [ F s=3 ], P>=0.8 [ F s=2 ])",
            "multi(Pmax=? [ F s=3 ], P>=1 [ F s=2 ], P>=0.5 [ F s=1 ])",
            "E [ F s=3 ]",
            "A [ G s<3 ]",
            "filter(range, Pmax=? [ F s=3 ], s!=1)",
            "filter(max, Pmax=? [ F s=3 ], s!=1)",
            "P>=0.3 [ F s=1 ]",
            "Rmax=? [ S ] > 0.2 & P<=0.4 [ F s=3 ]",
            "multi(Pmax=? [ F s=3 ], Pmax=? [ F s=2 ])",
            "multi(R{\"once\"}min=? [ C ], P>=0.2 [ F s=3 ])",
            "multi(R{\"once\"}min=? [ C ], Pmax=? [ F s=3 ])",
            // Bounds that are met exactly.
            "P>=1/3 [ F s=3 ] & P<=1/3 [ F s=3 ]",
            "filter(forall, P<=1/9 [ F<=2 s=3 ], s=2)",
        ] {
            let asked = parse_properties(text).into_result().unwrap();
            let asked = resolve_properties(&asked, &model, &Constants::new()).unwrap();
            let answer = checker::check(&space, &model, &asked[0].property, &options);
            let mut report =
                crate::report::property_report(1, &asked[0], answer, Method::Sound, 0.0);
            assert_eq!(
                judge(&report, &asked[0]),
                ("certified".into(), None),
                "{text}"
            );
            match report.result.as_deref() {
                Some("true") => report.result = Some("false".into()),
                Some("false") => report.result = Some("true".into()),
                Some("NaN") => {
                    (report.result, report.value) = (Some("0.5".into()), Some(0.5));
                }
                Some(curve) if curve.starts_with("[(") => {
                    report.result = Some(curve.replacen("[(", "[(1.01,1.01),(", 1));
                }
                Some(range) if range.starts_with('[') => {
                    report.result = Some("[0,0.51]".into());
                }
                _ => {
                    let altered = |end: &mut Option<f64>| {
                        *end = end.map(|x| if x == 0.0 { 1e-3 } else { x * 1.002 });
                    };
                    altered(&mut report.low);
                    altered(&mut report.high);
                    altered(&mut report.value);
                }
            }
            assert_eq!(judge(&report, &asked[0]).0, "refuted", "{text}");
        }
    }
}
