//! A person who is replayed from a recording ([`crate::scene::capture`]) in place of walking.
//!
//! While the activity is `walk` and the replay has begun, the recording goes on at its rate; with `stand` it rests. The person is where the
//! middle of the hips is, faces across them, and has arrived when the recording is over. Who is pushed beyond the balance takes the rest of
//! the recording along.

use std::sync::Arc;

use super::Walker;
use crate::scene::capture::Recording;
use crate::scene::data::{Activity, Person};
use crate::scene::draws::Draws;
use crate::scene::person::Stance;

/// A recording in an episode.
#[derive(Debug, Clone)]
pub(super) struct Replay {
    recording: Arc<Recording>,
    /// Where the recording's origin lies, and where its x axis points.
    place_m: [f64; 2],
    heading_rad: f64,
    begins_secs: f64,
    rate: f64,
    again: bool,
    played_secs: f64,
}

impl Replay {
    /// Of a person who has a recording; `stance` has where its origin lies.
    pub(super) fn new(person: &Person, stance: &Stance, draws: Draws) -> Option<Self> {
        let (capture, recording) = (person.capture.as_ref()?, person.recording.as_ref()?);
        let drawn =
            |field: &str, of| draws.of("person", &person.name, &format!("capture.{field}"), of);
        Some(Self {
            recording: Arc::clone(recording),
            place_m: [stance.x_m, stance.y_m],
            heading_rad: stance.heading_rad,
            begins_secs: drawn("begins_secs", &capture.begins_secs),
            rate: drawn("rate", &capture.rate),
            again: person.again,
            played_secs: 0.0,
        })
    }

    /// Whether its end has been reached for good.
    pub(super) fn is_over(&self) -> bool {
        !self.again && self.played_secs >= self.recording.duration_secs()
    }

    /// What is left of it is elsewhere.
    pub(super) fn shift(&mut self, by_m: [f64; 2]) {
        self.place_m = [0, 1].map(|axis| self.place_m[axis] + by_m[axis]);
    }

    /// How the person stands now.
    pub(super) fn stance(&self, before: &Stance) -> Stance {
        let figure = self.recording.at(self.played_secs);
        let figure = figure.placed(self.heading_rad, self.place_m);
        let [x_m, y_m, _] = figure.hips_m();
        Stance {
            x_m,
            y_m,
            heading_rad: figure.heading_rad(),
            figure: Some(figure),
            ..*before
        }
    }

    /// Goes on to a time.
    fn go_on(&mut self, now_secs: f64, period_secs: f64) {
        let since_secs = (now_secs - self.begins_secs).clamp(0.0, period_secs);
        self.played_secs += self.rate * since_secs;
        let duration_secs = self.recording.duration_secs();
        if self.played_secs >= duration_secs {
            self.played_secs = match self.again {
                true => self.played_secs % duration_secs,
                false => duration_secs,
            };
        }
    }
}

impl Walker {
    /// The recording goes on by a period.
    pub(super) fn replay_on(&mut self, now_secs: f64, period_secs: f64) {
        let Some(replay) = &mut self.replay else {
            return;
        };
        if self.activity == Activity::Walk {
            replay.go_on(now_secs, period_secs);
        }
        let before = self.stance;
        let mut now = replay.stance(&before);
        self.velocity_m_s = [now.x_m - before.x_m, now.y_m - before.y_m].map(|it| it / period_secs);
        now.speed_m_s = self.velocity_m_s[0].hypot(self.velocity_m_s[1]);
        now.walked_m += now.speed_m_s * period_secs;
        self.stance = now;
    }
}
