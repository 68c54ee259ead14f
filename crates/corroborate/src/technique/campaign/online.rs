//! Monitors that judge an episode while it runs.
//!
//! # Definition
//! A trace has a sample at every time at which any of its topics has a row, with the rows of all topics
//! of that time; another row of the same topic and time is another sample. On line the rows come one
//! at a time and times never go back, so a sample is complete when a row of a later time or another one
//! of a topic that it has comes, or at the end. The monitors are then given the same samples with the
//! same values as by reading the finished trace, hence say the same.
//!
//! # Early end
//! If that is asked for, the episode ends once every monitor is determined: whatever came later, no
//! verdict would change. Counts of triggers and robustness are then those of the shorter trace. An
//! episode that is run for the sake of one subject can be ended once that one's is determined.
//!
//! # Assumes
//! Rows come in the order of their times.
//!
//! # Guarantee
//! Verdicts, robustness and coverage are those of the finished trace (tested sample by sample); of an episode that is ended early the
//! verdicts alone.

use diagnostic::Problem;
use judging::{Judgement, Judges, News, Session};
use testbench::{Control, Watch};
use trace::{Snapshot, Trace};

/// Sessions that are given an episode's rows.
pub struct OnLine<'s, 'a> {
    sessions: Vec<Session<'s, 'a>>,
    now: Snapshot,
    /// Channels of the instant that is not complete.
    changed: Vec<bool>,
    /// The time of that instant.
    open_secs: Option<f64>,
    early_end: bool,
    /// The subject for whose sake alone the episode is run, if it is for one.
    only: Option<String>,
    failed: Option<Problem>,
}

impl<'s, 'a> OnLine<'s, 'a> {
    /// Begins to judge an episode with the topics of `layout`, by several sets of judges.
    pub fn new(
        judges: &[&'s Judges<'a>],
        layout: &Trace,
        early_end: bool,
    ) -> Result<Self, Problem> {
        let sessions = judges.iter().map(|judges| judges.start(layout));
        Ok(Self {
            sessions: sessions.collect::<Result<_, _>>()?,
            now: Snapshot::new(layout),
            changed: vec![false; layout.channels.len()],
            open_secs: None,
            early_end,
            only: None,
            failed: None,
        })
    }

    /// Ends the episode once one subject's main monitor is determined,
    /// whatever others say.
    pub fn until_decided(self, id: &str) -> Self {
        Self {
            early_end: true,
            only: Some(id.to_owned()),
            ..self
        }
    }

    /// What each set of judges says; `complete` is false if the episode was cut short.
    pub fn finish(mut self, complete: bool) -> Result<Vec<Vec<Judgement<'a>>>, Problem> {
        let end_secs = self.now.time_secs();
        if self.failed.is_none()
            && let Err(problem) = self.close(false)
        {
            self.failed = Some(problem);
        }
        match self.failed {
            Some(problem) => Err(problem),
            None => Ok(self
                .sessions
                .into_iter()
                .map(|it| it.finish_run(complete, end_secs))
                .collect()),
        }
    }

    /// The open sample is complete; whether `more` of its instant follow.
    fn close(&mut self, more: bool) -> Result<(), Problem> {
        let Some(time_secs) = self.open_secs.take() else {
            return Ok(());
        };
        for session in &mut self.sessions {
            let news = News {
                changed: &self.changed,
                sampled: None,
                dropped: None,
                more,
            };
            session.step_changed(time_secs, &self.now, &news)?;
        }
        self.changed.fill(false);
        Ok(())
    }

    fn take(&mut self, topic: usize, time_secs: f64, values: &[f64]) -> Result<(), Problem> {
        if self
            .open_secs
            .is_some_and(|open_secs| open_secs < time_secs)
        {
            self.close(false)?;
        } else if self.changed.get(topic).is_some_and(|it| *it) {
            self.close(true)?;
        }
        self.open_secs = Some(time_secs);
        let updated = self.now.update(topic, time_secs, values);
        updated.map_err(|error| Problem::new("bad-recording", error.to_string()))?;
        if let Some(changed) = self.changed.get_mut(topic) {
            *changed = true;
        }
        Ok(())
    }

    fn is_determined(&self) -> bool {
        let mut all = self.sessions.iter().flat_map(Session::determined);
        let Some(only) = &self.only else {
            return all.all(|(_, _, verdict)| verdict.is_some());
        };
        all.any(|(subject, reading, verdict)| {
            subject.id() == only && reading.is_none() && verdict.is_some()
        })
    }
}

impl Watch for OnLine<'_, '_> {
    fn row(&mut self, topic_index: usize, time_secs: f64, values: &[f64]) -> Control {
        let is_new_instant = self.open_secs.is_none_or(|open_secs| open_secs < time_secs);
        if let Err(problem) = self.take(topic_index, time_secs, values) {
            self.failed.get_or_insert(problem);
            return Control::Finish;
        }
        // Only a completed instant can determine anything.
        if self.early_end && is_new_instant && self.is_determined() {
            return Control::Finish;
        }
        Control::Continue
    }
}
