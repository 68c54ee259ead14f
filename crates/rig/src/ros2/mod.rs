//! Controllers that are nodes of ROS 2.
//!
//! A scene's controller with a table `ros2` is joined over topics of DDS. At each tick the sensors'
//! measurements that have arrived are published in the types of ROS 2, then `/clock` with the
//! simulated time, which begins at 0 with each episode.
//!
//! # Lock step
//! Without `real_time_factor`, simulated time stands still until each topic of `subscribe` has had
//! one message: the answer to this tick. `/clock` is told when all reliable readers have
//! acknowledged what was measured, so a node that takes what is there when the clock comes has it
//! all. A topic with `stamp` repeats the time that it answers, and is checked. What breaks the step
//! (two messages for a tick, a loss, no answer within `answer_within_secs` of the wall clock) ends
//! the episode with an error, never with a number.
//!
//! Before time begins, `/clock` 0 is repeated until the node has answered on all topics, because
//! neither side of DDS knows when the other has found it; what it answers then is not looked at.
//! With `settle_secs` that time is waited for instead.
//!
//! What is lost against the lock-step protocol: types of 32 bits round what they carry; the node
//! ticks at time 0 more than once; and a node is repeatable only if it decides by what it was told
//! when the clock came, not by the order or the wall-clock time of its callbacks. If it does, the
//! recording is the same, byte for byte.
//!
//! # Free running
//! With `real_time_factor` each tick takes the period over that factor on the wall clock, and what
//! has come by then counts: the latest message of each topic. Episodes are then not repeatable.
//!
//! A node with a `command` is started for each episode and ended with it, as `ros2 run` would, with
//! `ROS_DOMAIN_ID`, `use_sim_time`, `seed` and the scene's `settings` as parameters. One that runs
//! already is told of a new episode by the clock that goes back to 0.

mod codec;
mod domains;
mod link;
mod node;
mod table;

use crate::consent::Consent;
use domains::Domain;
pub use domains::Domains;
use link::Link;
use node::Node;
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
pub use table::{Join, check_text};
use testbench::controller::{Controller, ControllerError, Description, Inputs, Outputs, Setup};
use testbench::scene::ControllerData;

/// A controller over topics of ROS 2; see the module.
pub struct Ros2Controller {
    join: Join,
    description: Description,
    command: Vec<String>,
    folder: PathBuf,
    python_path: Option<OsString>,
    /// That its program may run; a node without one needs none.
    consent: Option<Consent>,
    longest: Duration,
    domains: Domains,
    link: Option<Link>,
    /// For a node that runs freely.
    pace: Option<Pace>,
}

/// Time of a node that runs freely.
struct Pace {
    /// When simulated time began.
    began: Instant,
    /// When a message came last.
    heard: Instant,
    /// Seconds of the wall clock for one of simulated time.
    wall_secs: f64,
}

impl Ros2Controller {
    /// Prepares a controller; nothing is connected before its first episode.
    pub fn new(
        join: Join,
        data: &ControllerData,
        (folder, python_path): (&Path, Option<&OsStr>),
        domains: &Domains,
        consent: Option<&Consent>,
    ) -> Self {
        Self {
            description: join.describe(data),
            join,
            command: data.command.clone(),
            folder: folder.to_owned(),
            python_path: python_path.map(OsStr::to_owned),
            consent: consent.cloned(),
            longest: Duration::from_secs_f64(data.answer_within_secs),
            domains: domains.clone(),
            link: None,
            pace: None,
        }
    }

    fn domain(&self) -> Result<Domain, ControllerError> {
        let domain = self.domains.take(&self.join.domains);
        domain.ok_or_else(|| ControllerError::Transport {
            reason: "no domain is named".into(),
        })
    }

    /// What came during a tick of a node that runs freely.
    fn free(&mut self, time_secs: f64) -> Result<Outputs, ControllerError> {
        let (Some(link), Some(pace)) = (&mut self.link, &mut self.pace) else {
            return Ok(Outputs::default());
        };
        let due = pace.began + Duration::from_secs_f64((time_secs * pace.wall_secs).max(0.0));
        let (outputs, has_come) = link.latest(due)?;
        if has_come {
            pace.heard = Instant::now();
        } else if pace.heard.elapsed() > self.longest {
            let secs = self.longest.as_secs_f64();
            return Err(link.silent(&format!(
                "by {time_secs} s nothing has come for {secs} s of the wall clock (`answer_within_secs`)"
            )));
        }
        Ok(outputs)
    }
}

/// What evidence says of how such a controller was joined.
pub fn said_of(data: &ControllerData) -> String {
    let free = Join::of(data)
        .ok()
        .flatten()
        .and_then(|it| it.real_time_factor);
    let step = match free {
        None => "in lock step".to_owned(),
        Some(factor) => format!("at {factor} times real time, so not repeatable"),
    };
    let whose = if data.command.is_empty() {
        ", its program started elsewhere"
    } else {
        ""
    };
    format!(", controller {} over ROS 2 {step}{whose}", data.name)
}

impl Controller for Ros2Controller {
    fn describe(&self) -> &Description {
        &self.description
    }

    fn set_up(&mut self, setup: &Setup) -> Result<(), ControllerError> {
        // An episode before this one gives its domain back first.
        self.link = None;
        let mut link = Link::new(&self.join, setup, self.domain()?, self.longest)?;
        if let Some(consent) = self.consent.as_ref().filter(|_| !self.command.is_empty()) {
            let place = (self.folder.as_path(), self.python_path.as_deref());
            let node = Node::start(&self.command, place, link.domain(), setup, consent);
            link.keep(node.map_err(|reason| ControllerError::Transport { reason })?);
        }
        link.wake(self.join.settle_secs.map(Duration::from_secs_f64))?;
        self.link = Some(link);
        let now = Instant::now();
        self.pace = self.join.real_time_factor.map(|factor| Pace {
            began: now,
            heard: now,
            wall_secs: 1.0 / factor,
        });
        Ok(())
    }

    fn tick(&mut self, inputs: &Inputs) -> Result<Outputs, ControllerError> {
        let is_free = self.pace.is_some();
        let Some(link) = &mut self.link else {
            return Err(ControllerError::Transport {
                reason: "no episode was begun".into(),
            });
        };
        if !is_free {
            link.check_quiet(inputs.time_secs)?;
        }
        link.tell(inputs)?;
        if is_free {
            return self.free(inputs.time_secs);
        }
        link.answers(inputs.time_secs)
    }

    fn end(&mut self) -> Result<(), ControllerError> {
        self.link = None;
        Ok(())
    }
}
