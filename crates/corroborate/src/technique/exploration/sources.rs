//! What is run next: sources of tests, weighed by what they brought.
//!
//! # Schedule
//! First each test that is there from the beginning is run once: the bench's
//! own, one with each fault alone, those of the formal model. Then a source is
//! drawn for each episode with a probability in proportion to
//! (episodes with something new + 1) / (episodes + 2) of that source: the rule
//! of succession for the chance of news, by which each source is tried for
//! ever and the one that pays most often is tried most. Its values are chosen
//! by the plan's designs in turn.

use super::concretise::{Concretiser, design_name};
use super::episode::Shown;
use super::faults::{self, Fault};
use super::form::SearchReport;
use super::plan::{Plan, SourceKind};
use super::searches::{Falsifier, searches};
use super::situations::Situations;
use super::tests_of_model::ModelTests;
use campaign::{ActionPattern, Coverage, Random};
use diagnostic::Problem;
use std::collections::BTreeMap;
use stimulus::{AbstractTest, Point, Settings, Stimulus};

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
    /// The requirement for whose sake alone it is run, if it is for one.
    pub for_the_sake_of: Option<String>,
    /// The search that asked for it, with its point.
    search: Option<(usize, Point)>,
}

/// Sources of tests.
pub struct Sources<'a> {
    plan: &'a Plan,
    kinds: Vec<SourceKind>,
    /// Tests that are there from the beginning, each first run once.
    given: Vec<Given>,
    faults: Vec<Fault>,
    next_given: usize,
    pool: Vec<AbstractTest>,
    searches: Vec<Falsifier>,
    concretiser: Option<Concretiser>,
    random: Random,
    /// Episodes of each source, and how many of them showed something new.
    pub yields: BTreeMap<SourceKind, (u64, u64)>,
}

/// A test that is there from the beginning.
#[derive(Clone)]
struct Given {
    kind: SourceKind,
    test: AbstractTest,
    /// Faults that are injected, all else as declared.
    faults: Settings,
}

/// What sources are made of.
pub struct Material<'a> {
    /// The bench's own tests.
    pub own: &'a [AbstractTest],
    /// The formal model's.
    pub of_model: &'a ModelTests,
    /// Faults that can be injected.
    pub faults: Vec<Fault>,
}

impl Material<'_> {
    /// Tests that are there from the beginning, in the order in which they are
    /// run.
    fn given(&self, kinds: &[SourceKind]) -> Vec<Given> {
        let of = |kind: SourceKind, test: &AbstractTest, faults: Settings| Given {
            kind,
            test: test.clone(),
            faults,
        };
        let own = self.own.iter();
        let own = own.map(|test| of(SourceKind::Own, test, Settings::new()));
        let faulty = self.own.first().into_iter().flat_map(|test| {
            self.faults.iter().flat_map(move |fault| {
                let values = fault.first().into_iter();
                values.map(move |value| {
                    let settings = Settings::from([(fault.key.clone(), value)]);
                    of(SourceKind::Faults, test, settings)
                })
            })
        });
        let of_model = self.of_model.tests.iter();
        let of_model = of_model.map(|t| of(t.kind, &t.test, Settings::new()));
        let given = own.chain(faulty).chain(of_model);
        given.filter(|given| kinds.contains(&given.kind)).collect()
    }
}

impl<'a> Sources<'a> {
    /// The plan's sources. Without `vary`, the bench's own tests are run as
    /// they are, in turn.
    pub fn new(
        plan: &'a Plan,
        kinds: &[SourceKind],
        material: Material<'_>,
        vary: bool,
        seed: u64,
    ) -> Result<Self, Problem> {
        let given = material.given(kinds);
        let searches = match kinds.contains(&SourceKind::Search) {
            true => searches(plan, material.own, seed)?,
            false => Vec::new(),
        };
        let usable = |kind: &SourceKind| match kind {
            SourceKind::Random => plan.data.grammar.is_some(),
            SourceKind::Mutation => plan.data.grammar.is_some(),
            SourceKind::Agents => !plan.data.agent.is_empty(),
            SourceKind::Search => !searches.is_empty(),
            given_kind => given.iter().any(|given| given.kind == *given_kind),
        };
        let kinds: Vec<SourceKind> = kinds.iter().copied().filter(usable).collect();
        if kinds.is_empty() {
            return Err(plan.mistake("sources", "no source has any test to give"));
        }
        Ok(Self {
            plan,
            kinds,
            given,
            faults: material.faults,
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
        let (kind, test) = match self.given.get(self.next_given).cloned() {
            Some(given) => {
                self.next_given += 1;
                if !given.faults.is_empty() {
                    return Ok(injected(given.test, given.faults, ""));
                }
                (given.kind, given.test)
            }
            None if self.concretiser.is_none() => {
                self.next_given = 1 % self.given.len().max(1);
                match self.given.first() {
                    Some(first) => (first.kind, first.test.clone()),
                    None => return Err(self.plan.mistake("", "the bench has no test of its own")),
                }
            }
            None => match self.draw_kind() {
                SourceKind::Search => return self.searched(),
                kind => (kind, self.test_of(kind, situations, coverage)?),
            },
        };
        let Some(concretiser) = &mut self.concretiser else {
            return Ok(planned(
                kind,
                "own tests as they are".to_owned(),
                Stimulus::of(test),
            ));
        };
        let (stimulus, design) = concretiser.stimulus(&test, situations, coverage)?;
        let how = design_name(design);
        if kind == SourceKind::Faults {
            let mut settings = stimulus.settings;
            settings.extend(faults::draw(&self.faults, &mut self.random));
            return Ok(injected(stimulus.test, settings, how));
        }
        let found_by = format!("{}, {how}", kind.name());
        Ok(planned(kind, found_by, stimulus))
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

    fn test_of(
        &mut self,
        kind: SourceKind,
        situations: &Situations,
        coverage: &Coverage,
    ) -> Result<AbstractTest, Problem> {
        let (data, random) = (&self.plan.data, &mut self.random);
        let bad = |error: campaign::CampaignError| {
            Problem::new("bad-exploration", format!("{}: {error}", kind.name()))
        };
        match (kind, &data.grammar) {
            (SourceKind::Random, Some(grammar)) => {
                let goals = towards_holes(situations, coverage, random)?;
                // What only agents do, the grammar need not be able to.
                let made = grammar.generate_for(&goals, random);
                made.or_else(|_| grammar.generate(random)).map_err(bad)
            }
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
                // A fault may fall into any test.
                let is_any = kind == SourceKind::Faults;
                let of_kind = self.given.iter().filter(|g| is_any || g.kind == kind);
                let of_kind: Vec<&AbstractTest> = of_kind.map(|given| &given.test).collect();
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
        let (point, stimulus) = search.next(self.plan)?;
        Ok(Planned {
            search: Some((place, point)),
            for_the_sake_of: Some(search.requirement.clone()),
            ..planned(SourceKind::Search, search.in_words(), stimulus)
        })
    }

    /// What became of a stimulus: how many new things it showed, and what a
    /// search learns from. Returns what the user should know of that search.
    pub fn tell(&mut self, planned: &Planned, news: usize, shown: &Shown) -> Option<String> {
        let (episodes, with_news) = self.yields.entry(planned.kind).or_default();
        *episodes += 1;
        if news > 0 {
            *with_news += 1;
            // Variants of what the physics cannot simulate would show more of that.
            if shown.broken.is_none() {
                if self.pool.len() == POOL {
                    self.pool.remove(0);
                }
                self.pool.push(planned.stimulus.test.clone());
            }
        }
        let (place, point) = planned.search.as_ref()?;
        self.searches[*place].tell(point, shown)
    }

    /// How each search fared.
    pub fn search_reports(&self) -> Vec<SearchReport> {
        self.searches.iter().map(Falsifier::report).collect()
    }
}

fn planned(kind: SourceKind, found_by: String, stimulus: Stimulus) -> Planned {
    Planned {
        kind,
        found_by,
        stimulus,
        for_the_sake_of: None,
        search: None,
    }
}

/// In half of the cases an action that situations are told apart by, drawn by
/// how much the holes ask for it.
fn towards_holes(
    situations: &Situations,
    coverage: &Coverage,
    random: &mut Random,
) -> Result<Vec<ActionPattern>, Problem> {
    let wanted = situations.wanted_actions(coverage)?;
    let weights: Vec<f64> = wanted.iter().map(|(_, weight)| *weight).collect();
    let goal = random.chance(0.5).then(|| random.weighted(&weights));
    let goal = goal.flatten().and_then(|place| wanted.get(place));
    Ok(goal
        .map(|(pattern, _)| pattern.clone())
        .into_iter()
        .collect())
}

/// A test with faults; `how` says how its other values were chosen, if they
/// are not as declared.
fn injected(test: AbstractTest, settings: Settings, how: &str) -> Planned {
    let found_by = match how {
        "" => format!("fault injection: {}", faults::in_words(&settings)),
        how => format!("fault injection, {how}"),
    };
    planned(SourceKind::Faults, found_by, Stimulus { test, settings })
}
