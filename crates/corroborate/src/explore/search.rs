//! The search of an exploration: everything that it goes by is compiled before anything runs.

use super::ExploreRequest;
use crate::technique::exploration::{
    Abstraction, Explored, Exploring, Formal, Journal, ModelTests, OpenBench, Plan, Signals,
    Situations, SourceKind, Watching, assets_of, inputs_of_all, tests_of_model,
};
use diagnostic::{Problem, did_you_mean};
use host::Host;
use judging::{Judges, SpaceTime};
use std::collections::BTreeMap;
use std::path::Path;
use study::Study;
use trace::{Predicate, Trace};

/// A search, in the physics that the plan chooses.
pub struct Search<'a> {
    pub study: &'a Study,
    pub plan: &'a Plan,
    pub bench: &'a OpenBench,
    pub request: &'a ExploreRequest,
    pub folder: &'a Path,
    pub host: &'a Host,
}

impl<'a> Search<'a> {
    /// Searches.
    pub fn run(&self) -> Result<Explored, Problem> {
        let (study, plan, host) = (self.study, self.plan, self.host);
        let kinds = self.kinds();
        let formal = match &plan.data.model {
            Some(model) => Some(Formal::of_entry(study, model, &host.cancel)?),
            None => None,
        };
        let abstraction = match &formal {
            Some(formal) => Abstraction::new(study, plan, formal)?,
            None => None,
        };
        let of_model = match &formal {
            Some(formal) => {
                let abstraction = abstraction.as_ref();
                tests_of_model(study, plan, formal, abstraction, &kinds, &host.cancel)?
            }
            None => ModelTests::default(),
        };
        let watching = self.watching(abstraction.as_ref())?;
        let journal = Journal::open(self.folder, &self.looked_at_by()?)?;
        let stage = host.events.begin("exploring", plan.data.budget.episodes);
        let exploring = Exploring {
            plan,
            watching: &watching,
            of_model: &of_model,
            kinds: &kinds,
            assets: assets_of(study, plan, false)?,
            vary: !self.request.plain,
            journal: &journal,
            interrupt: &host.cancel,
            stage: &stage,
            talk: &host.events,
        };
        exploring.run()
    }

    /// The sources of tests that are used.
    fn kinds(&self) -> Vec<SourceKind> {
        match (self.request.plain, self.request.sources.is_empty()) {
            (true, _) => vec![SourceKind::Own],
            (_, false) => self.request.sources.clone(),
            _ => self.plan.sources(),
        }
    }

    /// What looks at episodes.
    fn watching<'w>(&self, abstraction: Option<&'w Abstraction>) -> Result<Watching<'w>, Problem>
    where
        'a: 'w,
    {
        let (study, plan) = (self.study, self.plan);
        let judges = Judges::new(study, |_| true)?;
        // A word that the bench's recordings do not know is told before anything runs.
        let layout = self.bench.layout(&self.host.cancel)?;
        judges.start(&layout)?;
        Ok(Watching {
            study,
            bench: self.bench,
            judges,
            searched: self.searched(&layout)?,
            task_over: self.task_over(&layout)?,
            signals: Signals::of(&layout),
            layout,
            early_end: plan.data.budget.early_end,
            code: self.request.coverage.clone(),
            abstraction,
            situations: Situations::new(study, plan)?,
        })
    }

    /// What first holds when the task is over, if the plan says so.
    fn task_over(&self, layout: &Trace) -> Result<Option<Predicate>, Problem> {
        let Some(text) = &self.plan.data.task_over else {
            return Ok(None);
        };
        let wrong = |error: trace::PredicateError| {
            let problem = self.plan.mistake(text, error.to_string());
            problem.remedy("`task_over` is a word of the vocabulary or a predicate over signals")
        };
        let vocabulary = &self.study.vocabulary;
        let predicate = vocabulary.signals.predicate(text).map_err(wrong)?;
        // A signal that the recordings do not have is told before anything runs.
        predicate.bind(layout).map_err(wrong)?;
        Ok(Some(predicate))
    }

    /// What the searches of the plan go by.
    fn searched(&self, layout: &Trace) -> Result<BTreeMap<String, SpaceTime<'a>>, Problem> {
        let (study, plan) = (self.study, self.plan);
        let mut searched = BTreeMap::new();
        for search in &plan.data.search {
            let id = &search.requirement;
            let Some(robustness) = SpaceTime::new(study, id, self.bench.ends_by_secs())? else {
                return Err(self.no_monitor(id));
            };
            // A word that grades another and that the recordings do not know is told before anything runs.
            robustness.start(layout)?;
            searched.insert(id.clone(), robustness);
        }
        Ok(searched)
    }

    fn no_monitor(&self, id: &str) -> Problem {
        let message = format!("this study has no requirement `{id}` with a monitor");
        let subjects = self.study.forms.subjects.iter();
        let known = subjects.map(|form| form.subject.id());
        let problem = self.plan.mistake(&format!("\"{id}\""), message);
        match did_you_mean(id, known) {
            Some(similar) => problem.remedy(format!("did you mean `{similar}`?")),
            None => {
                problem.remedy("name a requirement of requirements.toml with a form for traces")
            }
        }
    }

    /// The hash of all that decides what an episode shows, beside its seed and
    /// its stimulus.
    fn looked_at_by(&self) -> Result<String, Problem> {
        let (study, plan) = (self.study, self.plan);
        let mut inputs = inputs_of_all(study, plan, self.bench, &self.host.build);
        inputs.add("code", &[u8::from(self.request.coverage.is_some())]);
        if let Some(model) = &plan.data.model
            && let Some(model) = study.entry(model)?.work.model()
        {
            let (model, _) = host::files::read_prism(&study.folder.join(model))?;
            inputs.add("model", model.text.as_bytes());
        }
        Ok(inputs.hash())
    }
}
