//! What is going on, as typed events: a face shows them as it likes, and the engine does not know how.

use diagnostic::Problem;
use serde::{Serialize, Serializer};
use std::fmt;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Something that happened while work was under way. Stages are numbered by the [`Events`] that they were begun with.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "event", rename_all = "kebab-case")]
pub enum Event {
    /// A line for the reader.
    Note {
        /// The line, without a newline.
        text: String,
    },
    /// Part of the input is wrong; work goes on with the rest.
    Mistake {
        /// What is wrong.
        #[serde(serialize_with = "in_one_line")]
        problem: Problem,
    },
    /// A stage of work began.
    Started {
        /// Its number.
        stage: u64,
        /// What is done.
        title: String,
        /// How many steps it has at most.
        total: u64,
    },
    /// Steps of a stage were done by an earlier call.
    Skipped {
        /// The stage's number.
        stage: u64,
        /// How many.
        steps: u64,
    },
    /// Steps of a stage were done.
    Advanced {
        /// The stage's number.
        stage: u64,
        /// How many are done, those of earlier calls included.
        done: u64,
        /// The time that the rest may take, in seconds, as far as this call's pace tells.
        left_secs: f64,
        /// How it stands, now and then.
        details: Option<String>,
    },
    /// A stage is over, whether all of its steps were done or not.
    Finished {
        /// Its number.
        stage: u64,
    },
}

fn in_one_line<S: Serializer>(problem: &Problem, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(&problem.line())
}

/// Where events go. Clones are the same place; events of several threads arrive one after another, each stage's in order.
#[derive(Clone)]
pub struct Events {
    sink: Arc<dyn Fn(Event) + Send + Sync>,
    stages: Arc<AtomicU64>,
}

impl fmt::Debug for Events {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Events").finish_non_exhaustive()
    }
}

impl Events {
    /// Events go to `sink`, which is called from any thread.
    pub fn new(sink: impl Fn(Event) + Send + Sync + 'static) -> Self {
        Self {
            sink: Arc::new(sink),
            stages: Arc::default(),
        }
    }

    /// Events go nowhere.
    pub fn none() -> Self {
        Self::new(|_| ())
    }

    /// Says one line.
    pub fn say(&self, line: &str) {
        (self.sink)(Event::Note { text: line.into() });
    }

    /// Tells of a mistake in the input, without which work goes on.
    pub fn mistake(&self, problem: &Problem) {
        let problem = problem.clone();
        (self.sink)(Event::Mistake { problem });
    }

    /// Begins a stage of `total` steps.
    pub fn begin(&self, title: &str, total: u64) -> Stage {
        let number = self.stages.fetch_add(1, Ordering::Relaxed);
        let title = title.to_owned();
        (self.sink)(Event::Started {
            stage: number,
            title,
            total,
        });
        let began = Instant::now();
        Stage {
            events: self.clone(),
            number,
            total,
            skipped: AtomicU64::new(0),
            began,
            progress: Mutex::new(Progress {
                done: 0,
                told: began,
            }),
        }
    }
}

/// A stage of work under way; may be advanced from many threads. It is over when it is dropped.
#[derive(Debug)]
pub struct Stage {
    events: Events,
    number: u64,
    total: u64,
    /// Steps that were done by an earlier call.
    skipped: AtomicU64,
    began: Instant,
    progress: Mutex<Progress>,
}

#[derive(Debug)]
struct Progress {
    done: u64,
    /// When details were last made.
    told: Instant,
}

/// How often details are made: they may cost something.
const DETAILS_EVERY: Duration = Duration::from_millis(500);

impl Stage {
    /// So many steps were done by an earlier call.
    pub fn skip(&self, steps: u64) {
        self.skipped.fetch_add(steps, Ordering::Relaxed);
        let mut progress = self.progress.lock().unwrap_or_else(PoisonError::into_inner);
        progress.done += steps;
        let stage = self.number;
        (self.events.sink)(Event::Skipped { stage, steps });
    }

    /// One step is done; now and then, and at each tenth, `details` are made and go with it.
    pub fn advance_with(&self, details: impl FnOnce() -> String) {
        self.step(Some(details));
    }

    /// One step is done.
    pub fn advance(&self) {
        self.step(None::<fn() -> String>);
    }

    fn step(&self, details: Option<impl FnOnce() -> String>) {
        let mut progress = self.progress.lock().unwrap_or_else(PoisonError::into_inner);
        progress.done += 1;
        let done = progress.done;
        let tenth = |steps: u64| steps * 10 / self.total.max(1);
        let is_due = progress.told.elapsed() >= DETAILS_EVERY || tenth(done) != tenth(done - 1);
        let details = details.filter(|_| is_due).map(|make| {
            progress.told = Instant::now();
            make()
        });
        (self.events.sink)(Event::Advanced {
            stage: self.number,
            done,
            left_secs: self.left_secs(done),
            details,
        });
    }

    fn left_secs(&self, done: u64) -> f64 {
        let new = done.saturating_sub(self.skipped.load(Ordering::Relaxed));
        let step_secs = self.began.elapsed().as_secs_f64() / new.max(1) as f64;
        step_secs * self.total.saturating_sub(done) as f64
    }
}

impl Drop for Stage {
    fn drop(&mut self) {
        let stage = self.number;
        (self.events.sink)(Event::Finished { stage });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stage_is_told_from_its_beginning_to_its_end() {
        let told = Arc::new(Mutex::new(Vec::new()));
        let sink = told.clone();
        let events = Events::new(move |event| sink.lock().expect("whole").push(event));
        let stage = events.begin("episodes", 3);
        stage.skip(1);
        stage.advance();
        stage.advance_with(|| "2 of 2".into());
        drop(stage);
        let told = told.lock().expect("whole");
        assert!(matches!(
            told[0],
            Event::Started {
                stage: 0,
                total: 3,
                ..
            }
        ));
        assert_eq!(told[1], Event::Skipped { stage: 0, steps: 1 });
        assert!(matches!(told[2], Event::Advanced { done: 2, .. }));
        let Event::Advanced {
            done,
            details,
            left_secs,
            ..
        } = &told[3]
        else {
            panic!("{:?}", told[3]);
        };
        assert_eq!(
            (*done, details.as_deref(), *left_secs),
            (3, Some("2 of 2"), 0.0)
        );
        assert_eq!(told[4], Event::Finished { stage: 0 });
    }
}
