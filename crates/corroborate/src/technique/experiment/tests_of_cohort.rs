//! What a cohort's table says of its trials: whether those of one subject are alike, and whether groups
//! or other columns matter.

use super::{Alike, Cohort};
use crate::technique::confidence;
use diagnostic::Problem;
use evidence::{ClusterTests, Subject, TakenCorrelation};
use study::Study;

/// The p-value of few runs from which on neighbouring rows are called alike.
const NEIGHBOURS: f64 = 0.01;

impl Cohort {
    /// Tests of independence of everything in the table: of successes between
    /// groups, and of numbers with each other.
    pub(super) fn tests(
        &self,
        study: &Study,
        alike: Alike,
    ) -> Result<Option<ClusterTests>, Problem> {
        let level = confidence(study.about.confidence)?;
        let first = study.forms.subjects.iter().find_map(|form| {
            let proposition = form.experiment.as_ref()?;
            let binding = study.vocabulary.propositions.get(proposition)?;
            let column = binding.column.as_ref()?;
            let is_counted = matches!(form.subject, Subject::Requirement(_))
                && !self.left_to_others.contains(&column.text);
            is_counted.then_some(&column.text)
        });
        let by_subject = first.map(|column| self.counts(column)).transpose()?;
        let mut found = match (first, &by_subject) {
            (Some(column), Some(by_subject)) => self.clustering(column, by_subject, level),
            _ => None,
        };
        let common = alike.taken(level);
        if let Some(common) = &common {
            let (estimate, worth) = (common.estimate, alike.worth_of_all(self, level));
            let found = found.get_or_insert_with(|| ClusterTests {
                intraclass_correlation: estimate.unwrap_or(1.0),
                effective_trials: worth,
                ..ClusterTests::default()
            });
            found.tests.push(in_words(study, common));
        }
        let mut found = found.unwrap_or_else(|| self.plain());
        found.subjects = self.subjects();
        found.tests.extend(self.in_order(first)?);
        found.tests.extend(self.rank_tests());
        found.common = common;
        Ok(Some(found))
    }

    /// Of one subject, or one trial of each: independent trials, of that subject alone in the first case.
    fn plain(&self) -> ClusterTests {
        let trials: u64 = self.attempts.iter().sum();
        let is_one = self.subjects() == 1;
        let one = "All trials are of one subject: their interval is of that subject's rate; how subjects differ is not known.";
        ClusterTests {
            effective_trials: trials as f64,
            tests: if is_one {
                vec![one.to_owned()]
            } else {
                Vec::new()
            },
            ..ClusterTests::default()
        }
    }

    /// Whether neighbouring rows of one trial each are alike: then something groups them that the table does not name.
    fn in_order(&self, column: Option<&String>) -> Result<Option<String>, Problem> {
        let single = self.attempts.iter().all(|trials| *trials <= 1);
        let Some(column) = column.filter(|_| single) else {
            return Ok(None);
        };
        let outcomes = self.counts(column)?;
        let outcomes: Vec<bool> = outcomes.iter().map(|row| row.successes > 0).collect();
        let runs = stats::runs_test(&outcomes).filter(|runs| runs.p_value <= NEIGHBOURS);
        Ok(runs.map(|runs| {
            format!(
                "Warning: neighbouring rows are alike in {column} ({} runs where independent trials give {:.1}, \
                 runs test p = {:.1e}): trials drift or come in groups that the table does not name. Give one row to \
                 each session.",
                runs.runs, runs.expected, runs.p_value
            )
        }))
    }

    /// How alike the trials of one subject are by a column; `None` for one subject, or no variation at all,
    /// which leaves nothing to test.
    fn clustering(
        &self,
        column: &str,
        by_subject: &[stats::Sample],
        level: stats::Confidence,
    ) -> Option<ClusterTests> {
        let clustering = stats::clustering(by_subject).ok()?;
        let mut tests = vec![format!(
            "Intraclass correlation of {column} by analysis of variance: {:.3} (F = {:.2}, p = {:.3}).",
            clustering.intraclass_correlation, clustering.f_statistic, clustering.p_value
        )];
        tests.extend(self.cluster_tests(column, by_subject, level));
        // The one effective sample size of this count: that of its measure.
        let rate = stats::clustered_rate(by_subject, level).ok()?;
        Some(ClusterTests {
            intraclass_correlation: clustering.intraclass_correlation,
            effective_trials: rate.worth.trials,
            tests,
            ..ClusterTests::default()
        })
    }

    /// The interval that counts, by the beta-binomial model, and the one without a model beside it.
    fn cluster_tests(
        &self,
        column: &str,
        by_subject: &[stats::Sample],
        level: stats::Confidence,
    ) -> Vec<String> {
        let mut tests = Vec::new();
        let (Ok(rate), Ok(fit), Ok(robust)) = (
            stats::clustered_rate(by_subject, level),
            stats::BetaBinomial::fit(by_subject),
            stats::ClusterRobust::of(by_subject),
        ) else {
            return tests;
        };
        tests.push(format!(
            "{column} by the beta-binomial model of {} subjects: two-sided {:.0} % interval of one look {}, effective \
             sample size {}; intraclass correlation {:.3} (likelihood ratio p = {:.3}).",
            rate.clusters,
            100.0 * level.level(),
            rate.interval,
            evidence::effective_size(rate.worth.trials),
            fit.intraclass_correlation,
            fit.p_value
        ));
        tests.push(format!(
            "{column} by the variance between subjects, without a model: two-sided {:.0} % interval of one look {}.",
            100.0 * level.level(),
            robust.interval(level)
        ));
        tests
    }

    /// Kruskal-Wallis of each column of numbers by each column of categories,
    /// and Spearman between columns of numbers.
    fn rank_tests(&self) -> Vec<String> {
        let mut numbers: Vec<(&str, Vec<f64>)> = Vec::new();
        let mut categories: Vec<(&str, Vec<&str>)> = Vec::new();
        // The first column names the subject; codes of failures are no group.
        for column in self.table.columns().skip(1) {
            match column.as_numbers() {
                Ok(values) if column.header() != "attempts" => {
                    numbers.push((column.header(), values))
                }
                Ok(_) => {}
                Err(_) => {
                    let cells = column.as_texts();
                    if cells.iter().all(|c| !c.is_empty() && !c.contains(' ')) {
                        categories.push((column.header(), cells));
                    }
                }
            }
        }
        let mut tests = Vec::new();
        for (category, labels) in &categories {
            for (number, values) in &numbers {
                tests.extend(kruskal_wallis_in_words(category, labels, number, values));
            }
        }
        for (place, (left, left_values)) in numbers.iter().enumerate() {
            for (right, right_values) in &numbers[place + 1..] {
                tests.extend(spearman_in_words(left, left_values, right, right_values));
            }
        }
        tests
    }
}

/// What was taken for counts that do not tell how alike their trials are, and whose.
fn in_words(study: &Study, common: &TakenCorrelation) -> String {
    let whose: Vec<String> = common
        .taken_for
        .iter()
        .map(|subject| match subject {
            Subject::Requirement(id) => format!("requirement {id}"),
            Subject::FailureMode(id) => id.clone(),
        })
        .collect();
    let whose = whose.join(", ");
    match common.estimate {
        Some(estimate) => format!(
            "Counts that cannot tell how alike the trials of one subject are ({whose}) are given the intraclass \
             correlation that the columns {} have in common: {estimate:.3}, {:.0} % interval {:.3} to {:.3} \
             (profile likelihood, effectively {:.1} independent columns), its uncertainty profiled out.",
            common.columns.join(", "),
            100.0 * study.about.confidence,
            common.interval.low,
            common.interval.high,
            common.effective_columns
        ),
        None => format!(
            "Nothing counted of the subjects tells how alike their trials are: in {whose} each subject counts as \
             one trial."
        ),
    }
}

fn kruskal_wallis_in_words(
    category: &str,
    labels: &[&str],
    number: &str,
    values: &[f64],
) -> Option<String> {
    let mut groups: Vec<(&str, Vec<f64>)> = Vec::new();
    for (label, value) in labels.iter().zip(values) {
        match groups.iter_mut().find(|(known, _)| known == label) {
            Some((_, group)) => group.push(*value),
            None => groups.push((label, vec![*value])),
        }
    }
    let groups: Vec<Vec<f64>> = groups.into_iter().map(|(_, group)| group).collect();
    let test = stats::kruskal_wallis(&groups).ok()?;
    let exact = match stats::kruskal_wallis_exact(&groups) {
        Ok(p) => format!("; exact p = {p:.3}"),
        Err(_) => String::new(),
    };
    Some(format!(
        "Kruskal-Wallis of {number} by {category}: H({}) = {:.3}, p = {:.3}{exact}.",
        test.degrees, test.statistic, test.p_value
    ))
}

fn spearman_in_words(left: &str, x: &[f64], right: &str, y: &[f64]) -> Option<String> {
    let test = stats::spearman(x, y).ok()?;
    // The approximation is rough for few pairs, and 0 for three in order.
    let p = match stats::spearman_exact(x, y) {
        Ok(p) => format!("exact p = {p:.3}"),
        Err(_) => format!("p = {:.3}", test.p_value),
    };
    let rho = test.rho;
    Some(format!(
        "Spearman of {left} and {right}: rho = {rho:.3}, {p}."
    ))
}
