//! Statistics: each function gives numbers in a tuple; the package names them.

use crate::problem::{guarded, raised_input};
use ::stats::{
    Arm, ClusterMethod, Confidence, Decision, DifferenceVariance, Goal, Interval, IntervalMethod,
    Pairs, RunningInterval, Sample, SequentialTest, StatsError,
};
use pyo3::prelude::*;

/// Successes and trials.
type Counts = (u64, u64);
/// The two ends of an interval.
type Ends = (f64, f64);
/// Counts, clusters, method, interval, and what the counts are worth in independent trials.
type Clustered = (Counts, usize, &'static str, Ends, (f64, f64));
/// Q with degrees of freedom and p-value; I squared and tau squared; the pooled rate with its interval.
type Scattered = ((f64, usize, f64), (f64, f64), (f64, Ends));

fn wrong(error: StatsError) -> PyErr {
    raised_input(
        "bad-statistics",
        error,
        "correct the counts or the setting that is named",
    )
}

fn sample((successes, trials): Counts) -> PyResult<Sample> {
    Sample::new(successes, trials).map_err(wrong)
}

fn samples(counts: &[Counts]) -> PyResult<Vec<Sample>> {
    counts.iter().copied().map(sample).collect()
}

fn level(confidence: f64) -> PyResult<Confidence> {
    Confidence::new(confidence).map_err(wrong)
}

fn ends(interval: Interval) -> Ends {
    (interval.low, interval.high)
}

fn method(name: &str) -> PyResult<IntervalMethod> {
    let known = IntervalMethod::ALL.into_iter();
    let spelled = |method: &IntervalMethod| method.name().to_lowercase() == name;
    known.clone().find(spelled).ok_or_else(|| {
        let names: Vec<String> = known.map(|method| method.name().to_lowercase()).collect();
        let message = format!("there is no method `{name}` for the interval of a rate");
        raised_input(
            "bad-statistics",
            message,
            &format!("the methods are {}", names.join(", ")),
        )
    })
}

fn none_without_trials<T>(found: Option<T>) -> PyResult<T> {
    found.ok_or_else(|| wrong(StatsError::NoTrials))
}

fn trials_in_both(first: Sample, second: Sample) -> PyResult<()> {
    let both = first.is_informative() && second.is_informative();
    none_without_trials(both.then_some(()))
}

fn margin_of(margin: f64) -> PyResult<f64> {
    let is_margin = margin > 0.0 && margin < 1.0;
    is_margin.then_some(margin).ok_or_else(|| {
        wrong(StatsError::OutOfRange {
            what: "margin",
            value: margin,
            expected: "between 0 and 1",
        })
    })
}

/// Statistics; use `corroborate.stats`.
#[pymodule(name = "stats")]
pub(crate) mod statistics {
    use super::*;

    #[pymodule_export]
    use super::RunningRate;

    #[pyfunction]
    fn interval(counts: Counts, confidence: f64, method: &str) -> PyResult<Ends> {
        let method = super::method(method)?;
        guarded(|| Ok(ends(method.interval(sample(counts)?, level(confidence)?))))
    }

    /// The p-values against "at least", "at most" and "equal to" the threshold.
    #[pyfunction]
    fn rate_tests(counts: Counts, threshold: f64) -> PyResult<(f64, f64, f64)> {
        let counts = sample(counts)?;
        // Looks at the range of the threshold.
        SequentialTest::new(threshold, Confidence::P95).map_err(wrong)?;
        guarded(|| {
            Ok((
                ::stats::binomial_test_below(counts, threshold),
                ::stats::binomial_test_above(counts, threshold),
                ::stats::binomial_test_two_sided(counts, threshold),
            ))
        })
    }

    /// Estimate, interval and p-value of the difference of two rates, first minus second.
    #[pyfunction]
    fn difference(first: Counts, second: Counts, confidence: f64) -> PyResult<(f64, Ends, f64)> {
        let (first, second, level) = (sample(first)?, sample(second)?, level(confidence)?);
        guarded(|| {
            let of = |sample: Sample| Some((sample.rate()?, ::stats::wilson(sample, level)));
            let both = of(first).zip(of(second));
            let (one, other) = none_without_trials(both)?;
            let interval = ::stats::difference_interval(one, other);
            Ok((
                one.0 - other.0,
                ends(interval),
                ::stats::boschloo_exact(first, second),
            ))
        })
    }

    #[pyfunction]
    fn equivalence(first: Counts, second: Counts, margin: f64, method: &str) -> PyResult<f64> {
        let (first, second, margin) = (sample(first)?, sample(second)?, margin_of(margin)?);
        let found = guarded(|| match method {
            "exact" => Ok(::stats::exact_equivalence(first, second, margin)),
            "score" => Ok(::stats::score_equivalence(first, second, margin)),
            "tost" => Ok(
                ::stats::tost(first, second, margin, DifferenceVariance::AgrestiCaffo)
                    .map(|tost| tost.p_value()),
            ),
            other => {
                let message = format!("there is no test of equivalence `{other}`");
                let remedy = "the tests are exact, score and tost";
                Err(raised_input("bad-statistics", message, remedy))
            }
        })?;
        trials_in_both(first, second)?;
        found.ok_or_else(|| {
            let message = "this test has no value for these counts and this margin";
            raised_input("bad-statistics", message, "use method=\"score\"")
        })
    }

    /// The rate, interval, method and effective counts of clusters, and how alike their trials are.
    #[pyfunction]
    fn clustered_rate(clusters: Vec<Counts>, confidence: f64) -> PyResult<Clustered> {
        let (clusters, level) = (samples(&clusters)?, level(confidence)?);
        let found = guarded(|| ::stats::clustered_rate(&clusters, level).map_err(wrong))?;
        let name = match found.method {
            ClusterMethod::Profile => "profile",
            ClusterMethod::Common => "common",
            ClusterMethod::OneEach => "one-each",
            ClusterMethod::Independent => "independent",
        };
        let total = (found.total.successes, found.total.trials);
        let worth = (found.worth.successes, found.worth.trials);
        Ok((total, found.clusters, name, ends(found.interval), worth))
    }

    /// Intraclass correlation, design effect, effective size, F and its p-value.
    #[pyfunction]
    fn clustering(clusters: Vec<Counts>) -> PyResult<(f64, f64, f64, f64, f64)> {
        let clusters = samples(&clusters)?;
        let found = guarded(|| ::stats::clustering(&clusters).map_err(wrong))?;
        let (correlation, effect) = (found.intraclass_correlation, found.design_effect);
        Ok((
            correlation,
            effect,
            found.effective_size,
            found.f_statistic,
            found.p_value,
        ))
    }

    #[pyfunction]
    fn confidence_sequence(counts: Counts, confidence: f64) -> PyResult<Ends> {
        let (counts, level) = (sample(counts)?, level(confidence)?);
        guarded(|| Ok(ends(::stats::confidence_sequence(counts, level))))
    }

    /// 1 if the rate is at least the threshold, -1 if below, 0 if that is open.
    #[pyfunction]
    fn decide(counts: Counts, threshold: f64, confidence: f64) -> PyResult<i8> {
        let test = SequentialTest::new(threshold, level(confidence)?).map_err(wrong)?;
        let counts = sample(counts)?;
        guarded(|| {
            Ok(match test.decide(counts) {
                Decision::AtLeast => 1,
                Decision::Below => -1,
                Decision::Open => 0,
            })
        })
    }

    #[pyfunction]
    fn continued_interval(looks: Vec<Counts>, confidence: f64) -> PyResult<Ends> {
        let (looks, level) = (samples(&looks)?, level(confidence)?);
        guarded(|| Ok(ends(::stats::continued_interval(&looks, level))))
    }

    #[pyfunction]
    fn trials_per_arm(
        rates: (f64, f64),
        margin: Option<f64>,
        confidence: f64,
        power: f64,
    ) -> PyResult<Option<u64>> {
        let (goal, level) = (goal(margin)?, level(confidence)?);
        guarded(|| ::stats::trials_per_arm(goal, rates, level, power).map_err(wrong))
    }

    #[pyfunction]
    fn power(
        rates: (f64, f64),
        trials: (u64, u64),
        margin: Option<f64>,
        confidence: f64,
    ) -> PyResult<f64> {
        let (goal, level) = (goal(margin)?, level(confidence)?);
        // Looks at the range of the rates.
        ::stats::trials_per_arm(Goal::Difference, rates, level, 0.5).map_err(wrong)?;
        let arm = |rate, trials: u64| Arm::with_size(rate, trials as f64);
        let (first, second) = (arm(rates.0, trials.0), arm(rates.1, trials.1));
        guarded(|| Ok(goal.power(first, second, level)))
    }

    /// Difference (second minus first), its interval and the p-value of matched pairs.
    #[pyfunction]
    fn paired(
        pairs: u64,
        only_first: u64,
        only_second: u64,
        confidence: f64,
    ) -> PyResult<(f64, Ends, f64)> {
        let differing = only_first.saturating_add(only_second);
        sample((differing, pairs))?;
        let (level, pairs) = (
            level(confidence)?,
            Pairs {
                pairs,
                only_first,
                only_second,
            },
        );
        let difference = none_without_trials(pairs.difference())?;
        guarded(|| Ok((difference, ends(pairs.interval(level)), pairs.p_value())))
    }

    #[pyfunction]
    fn holm(p_values: Vec<f64>) -> PyResult<Vec<f64>> {
        guarded(|| Ok(::stats::holm(&p_values)))
    }

    /// Q, degrees of freedom, p-value, I squared, tau squared, and the pooled rate with its interval.
    #[pyfunction]
    fn heterogeneity(counts: Vec<Counts>, confidence: f64) -> PyResult<Scattered> {
        let (counts, level) = (samples(&counts)?, level(confidence)?);
        let found = guarded(|| ::stats::heterogeneity(&counts).map_err(wrong))?;
        let pooled = (found.random.rate(), ends(found.random.interval(level)));
        let q = (found.statistic, found.degrees, found.p_value);
        Ok((q, (found.i_squared, found.tau_squared), pooled))
    }

    fn goal(margin: Option<f64>) -> PyResult<Goal> {
        Ok(match margin {
            Some(margin) => Goal::Equivalence {
                margin: margin_of(margin)?,
            },
            None => Goal::Difference,
        })
    }
}

/// A confidence sequence that is followed trial by trial; use `corroborate.stats.RunningRate`.
#[pyclass(module = "corroborate._engine.stats")]
pub(crate) struct RunningRate(RunningInterval);

#[pymethods]
impl RunningRate {
    #[new]
    fn new(confidence: f64) -> PyResult<Self> {
        Ok(Self(RunningInterval::new(level(confidence)?)))
    }

    fn observe(&mut self, success: bool) -> PyResult<Ends> {
        guarded(|| {
            self.0.observe(success);
            Ok(ends(self.0.interval()))
        })
    }

    fn counts(&self) -> Counts {
        (self.0.sample().successes, self.0.sample().trials)
    }

    fn interval(&self) -> Ends {
        ends(self.0.interval())
    }
}
