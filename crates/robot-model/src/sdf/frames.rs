//! Frames given relative to other frames, and where each stands in the world.
//!
//! Every frame is known by its full name (`model::nested::link`; the world is the empty name). A frame's pose in the
//! world is the product of the poses on the way up. A model with a placement frame stands so that this frame has the
//! model's pose: `X = X_parent P X_model_placement⁻¹`. A way that comes back to itself is a cycle and an error. Cost:
//! logarithmic look-ups, each frame resolved once.

use std::collections::{BTreeMap, BTreeSet};

use crate::diagnostics::Place;
use crate::pose::Pose;
use crate::reader::Reader;

/// A frame.
#[derive(Debug, Clone)]
pub(super) struct Frame {
    /// The frame that the pose is relative to.
    pub parent: String,
    /// Its pose in that frame.
    pub pose: Pose,
    /// For models: the frame inside that the pose places.
    pub placement: Option<String>,
    /// The frame whose link it moves with.
    pub attached: String,
    pub place: Place,
}

/// All frames of a document.
#[derive(Default)]
pub(super) struct Frames {
    frames: BTreeMap<String, Frame>,
    in_world: BTreeMap<String, Pose>,
    /// Whether a missing frame or a cycle has been reported, by name.
    reported: BTreeSet<String>,
}

impl Frames {
    /// Adds a frame; two of one name are a problem.
    pub fn add(&mut self, reader: &mut Reader<'_, '_>, name: &str, frame: Frame) {
        if self.frames.contains_key(name) {
            let message = format!("two things in one model are called {name}");
            reader.problem(&frame.place, message, "rename one of them");
            return;
        }
        self.frames.insert(name.to_owned(), frame);
    }

    /// Whether a frame of that name exists.
    pub fn has(&self, name: &str) -> bool {
        name.is_empty() || self.frames.contains_key(name)
    }

    /// The pose of a frame in the world; a problem and the identity if it is unknown or lies on a cycle.
    pub fn in_world(&mut self, reader: &mut Reader<'_, '_>, name: &str, place: &Place) -> Pose {
        if let Some(known) = self.in_world.get(name) {
            return *known;
        }
        match self.climb(name, "", 0) {
            Ok(pose) => {
                self.in_world.insert(name.to_owned(), pose);
                pose
            }
            Err(Lost { at, cycle }) => {
                if self.reported.insert(at.clone()) {
                    let message = if cycle {
                        format!("the pose of {at} depends on itself")
                    } else {
                        format!("there is no frame {at}")
                    };
                    let remedy = "correct relative_to, attached_to or expressed_in";
                    reader.problem(place, message, remedy);
                }
                Pose::IDENTITY
            }
        }
    }

    /// The pose of `name` in `top`, which is on its way up.
    fn climb(&self, name: &str, top: &str, depth: usize) -> Result<Pose, Lost> {
        let mut pose = Pose::IDENTITY;
        let mut at = name;
        let mut passed = BTreeSet::new();
        while at != top {
            let found = self
                .frames
                .get(at)
                .filter(|_| depth < crate::xml::MAX_DEPTH);
            let Some(frame) = found else {
                return Err(Lost {
                    at: at.to_owned(),
                    cycle: self.frames.contains_key(at),
                });
            };
            if !passed.insert(at) {
                return Err(Lost {
                    at: at.to_owned(),
                    cycle: true,
                });
            }
            if at == name
                && top.is_empty()
                && let Some(known) = self.in_world.get(&frame.parent)
                && frame.placement.is_none()
            {
                return Ok(known.then(&frame.pose));
            }
            let mut own = frame.pose;
            if let Some(placement) = &frame.placement {
                own = own.then(&self.climb(placement, at, depth + 1)?.inverse());
            }
            pose = own.then(&pose);
            at = &frame.parent;
        }
        Ok(pose)
    }

    /// The frame among `links` that a frame moves with; `None` for the world or a lost one.
    pub fn link_of(&self, name: &str, is_link: &dyn Fn(&str) -> bool) -> Option<String> {
        let mut at = name;
        for _ in 0..self.frames.len() + 1 {
            if is_link(at) {
                return Some(at.to_owned());
            }
            at = &self.frames.get(at)?.attached;
        }
        None
    }
}

/// A way up that ends nowhere.
struct Lost {
    at: String,
    cycle: bool,
}
