//! How rare events are, by splitting.

mod bench;
mod file;
mod report;
mod runs;
mod score;
mod work;

pub use file::{EventText, RareText};
pub use report::{EventReport, PlainReport, RareReport, RunFailures};

use crate::technique::confidence;
use crate::technique::rows::{self, Rows};
use crate::technique::simulation::Seeds;
use diagnostic::{Problem, Source};
use host::Host;
use host::store::{Inputs, Store};
use judging::inputs_of;
use rig::Rig;
use runs::Runs;
use score::Score;
use stats::Confidence;
use std::path::PathBuf;
use std::sync::Mutex;
use stimulus::Space;
use study::Study;
use study::placed::quoted;
use work::Work;

/// Events whose probability is asked for. [`RareRequest::new`] has the defaults.
#[derive(Clone, Debug)]
pub struct RareRequest {
    /// The study's folder.
    pub study: PathBuf,
    /// The file of events.
    pub file: PathBuf,
    /// The names of the events that are estimated; all of the file if there are none.
    pub only: Vec<String>,
    /// Where finished parts are kept; by default in the folder `results/rare` of the study.
    pub out: Option<PathBuf>,
}

impl RareRequest {
    /// All events of this file, in the study in this folder.
    pub fn new(study: impl Into<PathBuf>, file: impl Into<PathBuf>) -> Self {
        Self {
            study: study.into(),
            file: file.into(),
            only: Vec::new(),
            out: None,
        }
    }
}

/// Estimates the probability of each event in an episode, by splitting on saved states or by subset simulation over inputs,
/// with an interval from replications. Finished parts are kept, and an earlier call's are taken.
///
/// # Errors
/// What the study's files and the file of events say wrong, each with its place, before anything runs; `interrupted` if the host
/// was asked to stop; `results-in-use` if another call writes to the same folder; `no-physics-library` if episodes cannot be
/// simulated here.
pub fn rare(request: &RareRequest, host: &Host) -> Result<RareReport, Problem> {
    let study = Study::load_for(&request.study, &host.trust)?;
    let source = host::files::read_source(&request.file)?;
    let text = RareText::read(&source)?;
    check_only(&request.only, &text)?;
    let wanted = |event: &&EventText| request.only.is_empty() || request.only.contains(&event.name);
    let level = confidence(text.confidence)?;
    let rig = bench::open(&study, &source, &text, host)?;
    let folder = request.out.clone();
    let asked = Asked {
        store: Store::open(&folder.unwrap_or_else(|| study.folder.join("results/rare")))?,
        wanted: text.events.iter().filter(wanted).collect(),
        study: &study,
        source: &source,
        rig: rig.as_ref(),
        level,
        host,
    };
    let events = asked.reports()?;
    Ok(RareReport {
        format: "1.1".into(),
        engine: rig.engine(),
        confidence: level.level(),
        events,
    })
}

fn check_only(only: &[String], text: &RareText) -> Result<(), Problem> {
    let unknown = |name: &&String| text.events.iter().all(|event| event.name != **name);
    match only.iter().find(unknown) {
        None => Ok(()),
        Some(name) => {
            let known = text.events.iter().map(|event| event.name.as_str());
            let message = format!("there is no event `{name}`");
            Err(Problem::new("bad-rare-event", message).remedy(format!(
                "the file has: {}",
                known.collect::<Vec<_>>().join(", ")
            )))
        }
    }
}

/// What is to be estimated.
struct Asked<'a> {
    study: &'a Study,
    source: &'a Source,
    rig: &'a dyn Rig,
    wanted: Vec<&'a EventText>,
    store: Store,
    level: Confidence,
    host: &'a Host,
}

impl Asked<'_> {
    /// One report for each event that is wanted; all scores and inputs are tried before anything runs.
    fn reports(&self) -> Result<Vec<EventReport>, Problem> {
        self.can_be_split()?;
        let layout = self.rig.layout(&self.host.cancel)?;
        let scored: Vec<(&EventText, Score<'_>)> = (self.wanted.iter())
            .map(|event| {
                let layout = layout.clone();
                Ok((*event, Score::new(self.study, self.source, event, layout)?))
            })
            .collect::<Result<_, Problem>>()?;
        let mut works = Vec::new();
        for (event, score) in &scored {
            let work = Work {
                runs: Runs {
                    rig: self.rig,
                    score,
                    event,
                    host: self.host,
                    ended: Mutex::default(),
                },
                store: &self.store,
                inputs: self.inputs(event),
                seeds: Seeds::new(self.study.about.seed, &format!("rare: {}", event.name)),
                space: Space {
                    parameters: event.parameters.clone(),
                    constraints: Vec::new(),
                },
            };
            work.accepts(self.source)?;
            works.push(work);
        }
        let mut rows = Rows::default();
        let reports: Vec<EventReport> = (works.iter())
            .map(|work| work.report(self.level, &mut rows))
            .collect::<Result<_, Problem>>()?;
        let path = self.store.folder().join(rows::FILE);
        let about = [
            ("study", self.study.about.title.as_str()),
            ("events", &self.source.name),
        ];
        rows.write(&path, &about)?;
        Ok(reports)
    }

    /// Refuses events that ask for splitting of a rig whose runs cannot be saved.
    fn can_be_split(&self) -> Result<(), Problem> {
        let mut split = self
            .wanted
            .iter()
            .filter(|event| event.parameters.is_empty());
        match (self.rig.resumable(), split.next()) {
            (None, Some(event)) => {
                let message = format!(
                    "event `{}`: runs of {} cannot be saved and continued, which splitting needs",
                    event.name,
                    self.rig.engine()
                );
                Err(Problem::new(file::CODE, message)
                    .at(self.source, quoted(self.source, &event.name))
                    .remedy("give the inputs that vary as [[event.parameter]] tables; the event is then sought among them"))
            }
            _ => Ok(()),
        }
    }

    fn inputs(&self, event: &EventText) -> Inputs {
        let mut inputs = Inputs::default();
        self.rig.test_inputs(&self.host.build, &mut inputs);
        inputs.add("event", format!("{event:?}").as_bytes());
        inputs.add("vocabulary", self.study.vocabulary.source.text.as_bytes());
        if event.requirement.is_some() {
            inputs_of(self.study, &mut inputs);
        }
        inputs
    }
}
