//! Searches for the violation of a requirement, and whether they can see.
//!
//! A search goes by the requirement's space-time robustness
//! ([`judging::SpaceTime`]). Where that is the same in all
//! episodes of the first batch, or there is none, the search is as good as
//! blind: it draws at random with more effort. That is told, with the reason.

use super::episode::Shown;
use super::form::SearchReport;
use super::plan::{Plan, SearchData};
use campaign::{Method, Search, Searcher};
use diagnostic::Problem;
use stimulus::{AbstractTest, Point, Space, Stimulus};

/// A search for the violation of a requirement.
pub struct Falsifier {
    /// The requirement.
    pub requirement: String,
    method: Method,
    test: AbstractTest,
    space: Space,
    searcher: Searcher,
    /// How many episodes are looked at to tell whether it can see.
    batch: u64,
    /// Why it could not, after these.
    blind: Option<String>,
    told: Told,
}

/// What it was told.
#[derive(Default)]
struct Told {
    episodes: u64,
    /// In how many of them the requirement came up.
    triggered: u64,
    with_robustness: u64,
    /// The least and the greatest robustness.
    range: Option<(f64, f64)>,
    violated: u64,
    violated_after: Option<u64>,
}

impl Falsifier {
    fn new(
        plan: &Plan,
        own: &[AbstractTest],
        (number, data): (usize, &SearchData),
        seed: u64,
    ) -> Result<Self, Problem> {
        let test = own.iter().find(|test| test.name == data.test);
        let test = test.cloned().ok_or_else(|| {
            plan.mistake(&data.test, format!("the bench has no test `{}`", data.test))
        })?;
        let space = data.space().unwrap_or_else(|| plan.space.clone());
        let space = space.with_delays_of(&test);
        let searcher = Searcher::new(data.method, space.clone(), seed.wrapping_add(number as u64));
        Ok(Self {
            requirement: data.requirement.clone(),
            method: data.method,
            test,
            searcher: searcher.map_err(|e| plan.mistake("[[search]]", e.to_string()))?,
            space,
            batch: plan.data.budget.batch.max(2),
            blind: None,
            told: Told::default(),
        })
    }

    /// The next point, and the stimulus that it is.
    pub fn next(&mut self, plan: &Plan) -> Result<(Point, Stimulus), Problem> {
        let asked = self.searcher.ask(1).into_iter().next();
        let point = asked.unwrap_or_else(|| self.space.nominal());
        let stimulus = self.space.stimulus(&self.test, &point);
        let stimulus = stimulus.map_err(|e| plan.mistake("[[search]]", e.to_string()))?;
        Ok((point, stimulus))
    }

    /// What it is, in words.
    pub fn in_words(&self) -> String {
        let method = method_name(self.method);
        format!("{method} against requirement {}", self.requirement)
    }

    /// What a point led to. Returns, once, that the search is as good as
    /// blind.
    pub fn tell(&mut self, point: &Point, shown: &Shown) -> Option<String> {
        self.told.take(&self.requirement, shown);
        let value = shown.robustness.unwrap_or(f64::NAN);
        self.searcher.tell(&[(point.clone(), value)]);
        let is_random = self.method == Method::Random;
        if self.told.episodes != self.batch || is_random || self.told.sees() {
            return None;
        }
        self.blind = Some(self.told.why_blind(&self.requirement));
        self.blind.clone()
    }

    /// How it fared.
    pub fn report(&self) -> SearchReport {
        SearchReport {
            requirement: self.requirement.clone(),
            method: method_name(self.method).to_owned(),
            episodes: self.told.episodes,
            with_robustness: self.told.with_robustness,
            least_robustness: self.told.range.map(|(low, _)| low),
            violated_after: self.told.violated_after,
            violated: self.told.violated,
            blind: self.blind.clone(),
        }
    }
}

impl Told {
    fn take(&mut self, requirement: &String, shown: &Shown) {
        self.episodes += 1;
        self.triggered += u64::from(shown.triggered.contains(requirement));
        let of_modes = shown.failure_modes.contains(requirement);
        if of_modes || shown.violated.contains(requirement) {
            self.violated += 1;
            self.violated_after.get_or_insert(self.episodes);
        }
        if let Some(value) = shown.robustness {
            self.with_robustness += 1;
            let (low, high) = self.range.unwrap_or((value, value));
            self.range = Some((low.min(value), high.max(value)));
        }
    }

    /// Whether some episodes are nearer to a violation than others.
    fn sees(&self) -> bool {
        self.violated > 0 || self.range.is_some_and(|(low, high)| low < high)
    }

    /// Why none is, and what would help.
    fn why_blind(&self, id: &str) -> String {
        let count = self.episodes;
        let reason = match (self.triggered, self.with_robustness) {
            (0, 0) => {
                "the requirement never came up; name a `test` that leads to it, or let what leads to it vary"
            }
            _ => {
                "all are as near to a violation, since the words of its monitor are only true or false; give them \
                 `graded` in the vocabulary (a comparison of the signals that they come from), or a stage `within_secs`"
            }
        };
        format!(
            "the search against requirement {id} cannot see: in its first {count} episodes {reason}"
        )
    }
}

fn method_name(method: Method) -> &'static str {
    match method {
        Method::CrossEntropy => "cross-entropy",
        Method::CmaEs => "CMA-ES",
        Method::Bayesian => "Bayesian optimisation",
        Method::Random => "random points",
    }
}

/// The searches of a plan, ready to be asked.
pub fn searches(plan: &Plan, own: &[AbstractTest], seed: u64) -> Result<Vec<Falsifier>, Problem> {
    let numbered = plan.data.search.iter().enumerate();
    numbered
        .map(|search| Falsifier::new(plan, own, search, seed))
        .collect()
}
