//! Rates with their intervals, as rows of a table.

use stats::{Confidence, Sample, wilson};

/// How often a statement was made that is wrong.
#[derive(Clone, Copy, Debug)]
pub enum Rate {
    /// In so many of so many studies.
    Counted(u64, u64),
    /// By a sum over all outcomes.
    Exact(f64),
}

/// A rate and what is promised of it.
#[derive(Clone, Debug)]
pub struct Row {
    pub case: String,
    pub statement: &'static str,
    pub rate: Rate,
    /// The promise; `None` where nothing is promised, as of power.
    pub most: Option<f64>,
}

impl Row {
    /// A row of studies, of which so many made the statement.
    pub fn counted(
        case: &str,
        statement: &'static str,
        (found, studies): (u64, u64),
        most: Option<f64>,
    ) -> Self {
        Self {
            case: case.to_owned(),
            statement,
            rate: Rate::Counted(found, studies),
            most,
        }
    }

    /// Whether it exceeds its promise by more than chance explains: four standard deviations of a simulation at the
    /// promise, or rounding of a sum.
    pub fn breaks_its_promise(&self) -> bool {
        let Some(most) = self.most else { return false };
        match self.rate {
            Rate::Exact(rate) => rate > most + 1e-9,
            Rate::Counted(found, studies) => {
                let studies = studies as f64;
                found as f64 / studies > most + 4.0 * (most * (1.0 - most) / studies).sqrt()
            }
        }
    }

    fn figures(&self) -> String {
        match self.rate {
            Rate::Exact(rate) => format!("{:.2}, a sum", 100.0 * rate),
            Rate::Counted(successes, trials) => {
                let interval = wilson(Sample { successes, trials }, Confidence::P95);
                format!(
                    "{:.2} [{:.2}, {:.2}] of {trials}",
                    100.0 * successes as f64 / trials as f64,
                    100.0 * interval.low,
                    100.0 * interval.high
                )
            }
        }
    }
}

pub fn markdown(rows: &[Row]) -> String {
    let mut text =
        "| case | statement | %, 95 % interval | at most |\n|---|---|---|---|\n".to_owned();
    for row in rows {
        let most = row
            .most
            .map_or(String::new(), |most| format!("{}", 100.0 * most));
        // What breaks its promise stands out.
        let mark = if row.breaks_its_promise() { "**" } else { "" };
        let figures = format!("{mark}{}{mark}", row.figures());
        text += &format!(
            "| {} | {} | {figures} | {most} |\n",
            row.case, row.statement
        );
    }
    text
}

/// A part of a table that is worked out by itself.
pub type Job<'a> = Box<dyn Fn() -> Vec<Row> + Send + Sync + 'a>;

/// The rows of all jobs in their order, worked out side by side.
pub fn all(jobs: &[Job<'_>]) -> Vec<Row> {
    let next = std::sync::atomic::AtomicUsize::new(0);
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let mut found: Vec<(usize, Vec<Row>)> = std::thread::scope(|scope| {
        let work = || {
            let mut own = Vec::new();
            loop {
                let place = next.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
                let Some(job) = jobs.get(place) else {
                    break own;
                };
                own.push((place, job()));
            }
        };
        let workers: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
        let done = workers
            .into_iter()
            .flat_map(|it| it.join().expect("no panic"));
        done.collect()
    });
    found.sort_by_key(|(place, _)| *place);
    found.into_iter().flat_map(|(_, rows)| rows).collect()
}
