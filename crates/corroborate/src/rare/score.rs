//! How near a run comes to an event, while it runs.
//!
//! A score is a quantity over signals, of which the greatest value so far
//! counts; or a proposition, of which the longest time counts during which it
//! held without interruption; or a requirement, of which minus the space-time
//! robustness so far counts ([`SpaceTime`]): it is violated from 0 on, and never
//! falls. The event is a score of at least the limit.

use super::file::EventText;
use diagnostic::{Problem, Source, did_you_mean};
use judging::{SpaceTime, SpaceTimeSession};
use study::Study;
use study::placed::quoted;
use testbench::{Control, Watch};
use trace::{BoundPredicate, BoundQuantity, SignalIndex, Snapshot, Trace};

/// Times that differ by less are equal: half of a step of the fastest rates.
const SAME_SECS: f64 = 1e-6;

/// A score bound to what the bench records.
pub struct Score<'a> {
    kind: Kind<'a>,
    channels: Vec<usize>,
    layout: Trace,
    /// Rungs of the ladder, the last being the limit; rising.
    pub rungs: Vec<f64>,
}

enum Kind<'a> {
    Greatest(BoundQuantity),
    Longest(BoundPredicate),
    Requirement(Box<SpaceTime<'a>>),
}

/// A score so far; a saved run is continued with a copy of it.
#[derive(Clone)]
pub struct Follower<'s> {
    snapshot: Snapshot,
    since_secs: Option<f64>,
    /// Of a requirement: its monitor, and the instant of which more rows may come.
    session: Option<SpaceTimeSession<'s>>,
    open_secs: Option<f64>,
    /// The score so far.
    pub highest: f64,
}

impl<'a> Score<'a> {
    /// Binds the event's score to the channels of `layout`.
    pub fn new(
        study: &'a Study,
        source: &Source,
        event: &EventText,
        layout: Trace,
    ) -> Result<Self, Problem> {
        let words = &study.vocabulary.signals;
        let wrong = |text: &str, reason: String| {
            let message = format!("event `{}`: {reason}", event.name);
            Problem::new("bad-predicate", message)
                .at(source, quoted(source, text))
                .remedy("correct the score: signals are written /topic.field, words are the vocabulary's")
        };
        let kind = match (&event.greatest, &event.longest) {
            (Some(text), _) => Kind::Greatest(
                words
                    .quantity(text)
                    .and_then(|q| q.bind(&layout))
                    .map_err(|error| wrong(text, error.kind.to_string()))?,
            ),
            (_, Some(text)) => Kind::Longest(
                words
                    .predicate(text)
                    .and_then(|p| p.bind(&layout))
                    .map_err(|error| wrong(text, error.kind.to_string()))?,
            ),
            (None, None) => Kind::Requirement(Box::new(requirement(study, source, event)?)),
        };
        let of = |signals: Vec<SignalIndex>| signals.iter().map(|it| it.channel).collect();
        let channels = match &kind {
            Kind::Greatest(quantity) => of(quantity.signals()),
            Kind::Longest(predicate) => of(predicate.signals()),
            // Monitors see every instant.
            Kind::Requirement(it) => {
                it.start(&layout)?;
                (0..layout.channels.len()).collect()
            }
        };
        Ok(Self {
            channels,
            kind,
            layout,
            rungs: event.rungs(),
        })
    }

    /// Before a run.
    pub fn start(&self) -> Result<Follower<'_>, Problem> {
        let session = match &self.kind {
            Kind::Requirement(it) => Some(it.start(&self.layout)?),
            _ => None,
        };
        Ok(Follower {
            snapshot: Snapshot::new(&self.layout),
            since_secs: None,
            session,
            open_secs: None,
            highest: f64::NEG_INFINITY,
        })
    }

    /// How many rungs a score has reached.
    pub fn rung(&self, score: f64) -> usize {
        let slack = match self.kind {
            Kind::Greatest(_) | Kind::Requirement(_) => 0.0,
            Kind::Longest(_) => SAME_SECS,
        };
        self.rungs.partition_point(|rung| score + slack >= *rung)
    }

    fn take(&self, follower: &mut Follower<'_>, time_secs: f64) {
        let now = match &self.kind {
            // Only an instant of which all rows are there is judged.
            Kind::Requirement(_) => None,
            Kind::Greatest(quantity) => quantity.eval(&follower.snapshot),
            Kind::Longest(predicate) => match predicate.eval(&follower.snapshot) {
                Some(true) => {
                    let since = *follower.since_secs.get_or_insert(time_secs);
                    Some(time_secs - since)
                }
                _ => {
                    follower.since_secs = None;
                    None
                }
            },
        };
        if let Some(score) = now.filter(|score| !score.is_nan()) {
            follower.highest = follower.highest.max(score);
        }
    }
}

impl Follower<'_> {
    /// Judges the instant before `time_secs`, of which no more rows come.
    fn judge_before(&mut self, time_secs: f64) -> Result<(), Problem> {
        let Some(session) = &mut self.session else {
            return Ok(());
        };
        if let Some(open_secs) = self.open_secs.filter(|open_secs| *open_secs < time_secs) {
            session.step(open_secs, &self.snapshot)?;
            if let Some(robustness) = session.so_far() {
                self.highest = self.highest.max(-robustness);
            }
        }
        self.open_secs = Some(time_secs);
        Ok(())
    }
}

/// The space-time robustness of the requirement that an event names.
fn requirement<'a>(
    study: &'a Study,
    source: &Source,
    event: &EventText,
) -> Result<SpaceTime<'a>, Problem> {
    let id = event.requirement.as_deref().unwrap_or_default();
    if let Some(found) = SpaceTime::new(study, id, Some(event.until_secs))? {
        return Ok(found);
    }
    let message = format!(
        "event `{}`: this study has no requirement or failure mode `{id}` with a monitor",
        event.name
    );
    let known = study.forms.subjects.iter().map(|form| form.subject.id());
    let problem = Problem::new("bad-rare-event", message).at(source, quoted(source, id));
    Err(match did_you_mean(id, known) {
        Some(similar) => problem.remedy(format!("did you mean `{similar}`?")),
        None => problem.remedy("name one of requirements.toml with a form for traces"),
    })
}

/// Follows a score along a run, which ends once the limit is reached.
pub struct Following<'f, 's> {
    pub score: &'f Score<'s>,
    pub follower: &'f mut Follower<'s>,
    pub until_secs: f64,
    /// What kept it from being followed.
    pub problem: Option<Problem>,
}

impl Watch for Following<'_, '_> {
    fn row(&mut self, topic: usize, time_secs: f64, values: &[f64]) -> Control {
        if !self.score.channels.contains(&topic) {
            return Control::Continue;
        }
        if time_secs > self.until_secs + SAME_SECS {
            return Control::Finish;
        }
        if let Err(problem) = self.follower.judge_before(time_secs) {
            self.problem = Some(problem);
            return Control::Finish;
        }
        if let Err(error) = self.follower.snapshot.update(topic, time_secs, values) {
            self.problem = Some(Problem::new("bad-recording", error.to_string()));
            return Control::Finish;
        }
        self.score.take(self.follower, time_secs);
        match self.score.rung(self.follower.highest) >= self.score.rungs.len() {
            true => Control::Finish,
            false => Control::Continue,
        }
    }
}
