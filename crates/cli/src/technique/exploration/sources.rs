//! What is run next: sources of tests, weighed by what they brought.

use super::concretise::{Concretiser, design_name};
use super::plan::{Plan, SourceKind};
use super::situations::Situations;
use super::tests_of_model::ModelTests;
use crate::problem::Problem;
use campaign::{Coverage, Method, Random, Search, Searcher};
use std::collections::BTreeMap;
use stimulus::{AbstractTest, Point, Space, Stimulus};

/// Tests that showed something new and are kept for mutation, at most.
const POOL: usize = 64;

/// A stimulus with where it comes from.
#[derive(Clone, Debug)]
pub struct Planned {
    /// The source.
    pub kind: SourceKind,
    /// The source and how its values were chosen, in words.
    pub found_by: String,
    /// What is done.
    pub stimulus: Stimulus,
    /// The search that asked for it, with its point.
    search: Option<(usize, Point)>,
}

/// Sources of tests.
pub struct Sources<'a> {
    plan: &'a Plan,
    kinds: Vec<SourceKind>,
    /// Tests that are there from the beginning, each first run once.
    given: Vec<(SourceKind, AbstractTest)>,
    next_given: usize,
    pool: Vec<AbstractTest>,
    searches: Vec<Falsifier>,
    concretiser: Option<Concretiser>,
    random: Random,
    /// Episodes of each source, and how many of them showed something new.
    pub yields: BTreeMap<SourceKind, (u64, u64)>,
}

struct Falsifier {
    requirement: String,
    method: Method,
    test: AbstractTest,
    space: Space,
    searcher: Searcher,
}

impl<'a> Sources<'a> {
    /// The plan's sources. Without `vary`, the bench's own tests are run as
    /// they are, in turn.
    pub fn new(
        plan: &'a Plan,
        kinds: &[SourceKind],
        own: &[AbstractTest],
        of_model: &ModelTests,
        vary: bool,
        seed: u64,
    ) -> Result<Self, Problem> {
        let own_tests = own.iter().map(|test| (SourceKind::Own, test.clone()));
        let of_model = of_model.tests.iter().map(|t| (t.kind, t.test.clone()));
        let given = own_tests.chain(of_model);
        let given: Vec<_> = given.filter(|(kind, _)| kinds.contains(kind)).collect();
        let mut searches = Vec::new();
        if kinds.contains(&SourceKind::Search) {
            for (number, data) in plan.data.search.iter().enumerate() {
                let test = own.iter().find(|test| test.name == data.test);
                let test = test.cloned().ok_or_else(|| {
                    plan.mistake(&data.test, format!("the bench has no test `{}`", data.test))
                })?;
                let space = plan.space.with_delays_of(&test);
                let searcher = Searcher::new(data.method, space.clone(), seed + number as u64);
                searches.push(Falsifier {
                    requirement: data.requirement.clone(),
                    method: data.method,
                    test,
                    searcher: searcher.map_err(|e| plan.mistake("[[search]]", e.to_string()))?,
                    space,
                });
            }
        }
        let usable = |kind: &SourceKind| match kind {
            SourceKind::Random => plan.data.grammar.is_some(),
            SourceKind::Mutation => plan.data.grammar.is_some(),
            SourceKind::Agents => !plan.data.agent.is_empty(),
            SourceKind::Search => !searches.is_empty(),
            given_kind => given.iter().any(|(kind, _)| kind == given_kind),
        };
        let kinds: Vec<SourceKind> = kinds.iter().copied().filter(usable).collect();
        if kinds.is_empty() {
            return Err(plan.mistake("sources", "no source has any test to give"));
        }
        Ok(Self {
            plan,
            kinds,
            given,
            next_given: 0,
            pool: Vec::new(),
            searches,
            concretiser: vary.then(|| Concretiser::new(&plan.space, &plan.data.designs, seed)),
            random: Random::new(seed, "sources"),
            yields: BTreeMap::new(),
        })
    }

    /// The next stimuli.
    pub fn next(
        &mut self,
        count: usize,
        situations: &Situations,
        coverage: &Coverage,
    ) -> Result<Vec<Planned>, Problem> {
        let mut planned = Vec::with_capacity(count);
        while planned.len() < count {
            planned.push(self.one(situations, coverage)?);
        }
        Ok(planned)
    }

    fn one(&mut self, situations: &Situations, coverage: &Coverage) -> Result<Planned, Problem> {
        let (kind, test) = match self.given.get(self.next_given) {
            Some(given) => {
                self.next_given += 1;
                given.clone()
            }
            None if self.concretiser.is_none() => {
                self.next_given = 1 % self.given.len().max(1);
                match self.given.first() {
                    Some(first) => first.clone(),
                    None => return Err(self.plan.mistake("", "the bench has no test of its own")),
                }
            }
            None => {
                let kind = self.draw_kind();
                if kind == SourceKind::Search {
                    return self.searched();
                }
                (kind, self.test_of(kind)?)
            }
        };
        let (stimulus, found_by) = match &mut self.concretiser {
            Some(concretiser) => {
                let (stimulus, design) = concretiser.stimulus(&test, situations, coverage)?;
                let how = design_name(design);
                (stimulus, format!("{}, {how}", kind.name()))
            }
            None => (Stimulus::of(test), "own tests as they are".to_owned()),
        };
        Ok(Planned {
            kind,
            found_by,
            stimulus,
            search: None,
        })
    }

    /// A source, in proportion to how often it showed something new.
    fn draw_kind(&mut self) -> SourceKind {
        let weight = |kind: &SourceKind| {
            let (episodes, news) = self.yields.get(kind).copied().unwrap_or_default();
            // Mutation needs something to begin with.
            let is_idle = *kind == SourceKind::Mutation && self.pool.is_empty();
            if is_idle {
                0.0
            } else {
                (news as f64 + 1.0) / (episodes as f64 + 2.0)
            }
        };
        let weights: Vec<f64> = self.kinds.iter().map(weight).collect();
        let drawn = self.random.weighted(&weights).unwrap_or(0);
        self.kinds[drawn]
    }

    fn test_of(&mut self, kind: SourceKind) -> Result<AbstractTest, Problem> {
        let (data, random) = (&self.plan.data, &mut self.random);
        let bad = |error: campaign::CampaignError| {
            Problem::new("bad-exploration", format!("{}: {error}", kind.name()))
        };
        match (kind, &data.grammar) {
            (SourceKind::Random, Some(grammar)) => grammar.generate(random).map_err(bad),
            (SourceKind::Mutation, Some(grammar)) => {
                let test = self.pool[random.index(self.pool.len())].clone();
                // A test that keeps no rule of the grammar cannot be changed within them.
                match grammar.mutate(&test, &self.pool, random) {
                    Ok(mutant) => Ok(mutant),
                    Err(_) => grammar.generate(random).map_err(bad),
                }
            }
            (SourceKind::Agents, _) => {
                let agent = &data.agent[random.index(data.agent.len())];
                agent.generate(random).map_err(bad)
            }
            _ => {
                let of_kind = self.given.iter().filter(|(given, _)| *given == kind);
                let of_kind: Vec<&AbstractTest> = of_kind.map(|(_, test)| test).collect();
                match of_kind.get(random.index(of_kind.len())) {
                    Some(test) => Ok((*test).clone()),
                    None => Err(self.plan.mistake("", "a source has no test to give")),
                }
            }
        }
    }

    fn searched(&mut self) -> Result<Planned, Problem> {
        let place = self.random.index(self.searches.len());
        let search = &mut self.searches[place];
        let point = match search.searcher.ask(1).into_iter().next() {
            Some(point) => point,
            None => search.space.nominal(),
        };
        let stimulus = search.space.stimulus(&search.test, &point);
        let stimulus = stimulus.map_err(|e| self.plan.mistake("[[search]]", e.to_string()))?;
        let method = match search.method {
            Method::CrossEntropy => "cross-entropy",
            Method::CmaEs => "CMA-ES",
            Method::Bayesian => "Bayesian optimisation",
        };
        Ok(Planned {
            kind: SourceKind::Search,
            found_by: format!("{method} against requirement {}", search.requirement),
            stimulus,
            search: Some((place, point)),
        })
    }

    /// What became of a stimulus: how many new things it showed, and the
    /// robustness of each requirement.
    pub fn tell(&mut self, planned: &Planned, news: usize, robustness: &BTreeMap<String, f64>) {
        let (episodes, with_news) = self.yields.entry(planned.kind).or_default();
        *episodes += 1;
        if news > 0 {
            *with_news += 1;
            if self.pool.len() == POOL {
                self.pool.remove(0);
            }
            self.pool.push(planned.stimulus.test.clone());
        }
        if let Some((place, point)) = &planned.search {
            let search = &mut self.searches[*place];
            let value = robustness.get(&search.requirement).copied();
            search
                .searcher
                .tell(&[(point.clone(), value.unwrap_or(f64::NAN))]);
        }
    }
}
