//! Values that depend on transforms, which may come later than what needs them.

use std::collections::VecDeque;

use super::plan::{FrameQuantity, FrameQuantityKind, SourcePlan, Treatment};
use crate::transform::{FrameId, LookupError, Transform, TransformBuffer};

/// A row that waits for its transform; empty if the values come from transforms alone.
#[derive(Debug)]
struct Request {
    time_nanos: i64,
    row: Box<[f64]>,
}

/// Frames, and whether each is static.
type Chain = Vec<(FrameId, bool)>;

/// The waiting rows of one source, and what is known of its frames.
#[derive(Debug)]
pub(super) struct FrameSource {
    task: Task,
    waiting: VecDeque<Request>,
    /// The frames on the way between the two of a quantity, for a shape of the tree.
    chain: Option<(u64, Option<Chain>)>,
    /// Time and place of the last sample, for a speed.
    last: Option<(i64, [f64; 3])>,
}

#[derive(Debug)]
enum Task {
    Transform {
        target: FrameId,
        is_point: bool,
        metres_per_unit: f64,
    },
    Quantity {
        target: FrameId,
        source: FrameId,
        kind: FrameQuantityKind,
    },
}

/// A row whose transform was found, or for which none will come.
pub(super) struct Resolved {
    pub time_nanos: i64,
    pub row: Vec<f64>,
    /// Why the values are missing.
    pub missing: Option<LookupError>,
}

impl FrameSource {
    /// What `plan` asks of the frames in `buffer`; `None` if nothing.
    pub fn new(plan: &SourcePlan, buffer: &mut TransformBuffer) -> Option<Self> {
        let task = match &plan.treatment {
            Treatment::Plain => return None,
            Treatment::Transform {
                in_frame,
                is_point,
                metres_per_unit,
            } => Task::Transform {
                target: buffer.frame(in_frame),
                is_point: *is_point,
                metres_per_unit: *metres_per_unit,
            },
            Treatment::Frames(FrameQuantity {
                target,
                source,
                kind,
            }) => Task::Quantity {
                target: buffer.frame(target),
                source: buffer.frame(source),
                kind: *kind,
            },
        };
        Some(FrameSource {
            task,
            waiting: VecDeque::new(),
            chain: None,
            last: None,
        })
    }

    /// A row whose coordinates are to be transformed.
    pub fn row(&mut self, time_nanos: i64, row: &[f64]) {
        let row = row.into();
        self.waiting.push_back(Request { time_nanos, row });
    }

    /// A transform of `frame` was taken at `time_nanos`; if a quantity depends on it, it has a new
    /// sample there.
    pub fn transform(&mut self, time_nanos: i64, frame: FrameId, buffer: &TransformBuffer) {
        let Task::Quantity { target, source, .. } = self.task else {
            return;
        };
        if self
            .chain
            .as_ref()
            .is_none_or(|(shape, _)| *shape != buffer.shape())
        {
            self.chain = Some((buffer.shape(), buffer.chain(target, source)));
        }
        let Some((_, Some(chain))) = &self.chain else {
            return;
        };
        let touched = chain.iter().find(|(other, _)| *other == frame);
        // Static transforms hold for all times: they only matter alone.
        let matters = match touched {
            Some((_, false)) => true,
            Some((_, true)) => chain.iter().all(|(_, is_static)| *is_static),
            None => false,
        };
        let asked = self.waiting.back().map(|request| request.time_nanos);
        if matters && asked != Some(time_nanos) {
            let row = Box::default();
            self.waiting.push_back(Request { time_nanos, row });
        }
    }

    /// The time of the first row that still waits.
    pub fn waiting_since(&self) -> Option<i64> {
        self.waiting.front().map(|request| request.time_nanos)
    }

    /// The next row in order whose transform is known, or that has waited until `give_up_nanos`.
    pub fn resolve(
        &mut self,
        buffer: &TransformBuffer,
        give_up_nanos: i64,
        secs: impl Fn(i64) -> f64,
    ) -> Option<Resolved> {
        let request = self.waiting.front()?;
        let (target, source) = match self.task {
            Task::Transform { target, .. } => (target, frame_of(&request.row)),
            Task::Quantity { target, source, .. } => (target, Some(source)),
        };
        let unknown = || LookupError::UnknownFrame {
            frame: "\"\" (the header names none)".to_owned(),
            known: Vec::new(),
        };
        let looked_up = source
            .ok_or_else(unknown)
            .and_then(|source| buffer.lookup_frames(target, source, secs(request.time_nanos)));
        if let Err(error) = &looked_up
            && error.may_come()
            && request.time_nanos > give_up_nanos
        {
            return None;
        }
        let Request { time_nanos, row } = self.waiting.pop_front()?;
        let row = match &looked_up {
            Ok(pose) => self.values(time_nanos, &row, pose),
            Err(_) => {
                self.last = None;
                vec![f64::NAN; 4]
            }
        };
        let missing = looked_up.err();
        Some(Resolved {
            time_nanos,
            row,
            missing,
        })
    }

    fn values(&mut self, time_nanos: i64, row: &[f64], pose: &Transform) -> Vec<f64> {
        match self.task {
            Task::Transform {
                is_point,
                metres_per_unit,
                ..
            } => {
                let recorded: [f64; 3] = std::array::from_fn(|axis| row[axis] * metres_per_unit);
                let wanted = if is_point {
                    pose.apply(recorded)
                } else {
                    pose.rotate(recorded)
                };
                wanted.map(|part| part / metres_per_unit).to_vec()
            }
            Task::Quantity { kind, .. } => match kind {
                FrameQuantityKind::Position => pose.translation_m.to_vec(),
                FrameQuantityKind::Orientation => one_sign(pose.rotation_xyzw).to_vec(),
                FrameQuantityKind::Distance => vec![pose.distance_m()],
                FrameQuantityKind::Speed => vec![self.speed_m_s(time_nanos, pose)],
            },
        }
    }

    /// Distance by time since the last sample.
    fn speed_m_s(&mut self, time_nanos: i64, pose: &Transform) -> f64 {
        let here = pose.translation_m;
        let last = self.last.replace((time_nanos, here));
        let Some((then_nanos, there)) = last.filter(|(then, _)| *then < time_nanos) else {
            return f64::NAN;
        };
        let moved: [f64; 3] = std::array::from_fn(|axis| here[axis] - there[axis]);
        let passed_secs = (time_nanos - then_nanos) as f64 / 1e9;
        moved[0].hypot(moved[1]).hypot(moved[2]) / passed_secs
    }
}

/// Of the two quaternions of a rotation, the one with w >= 0.
fn one_sign(quaternion: [f64; 4]) -> [f64; 4] {
    if quaternion[3] < 0.0 {
        quaternion.map(|part| -part)
    } else {
        quaternion
    }
}

/// The frame whose number stands in the fourth column.
fn frame_of(row: &[f64]) -> Option<FrameId> {
    let number = *row.get(3)?;
    (number >= 0.0).then(|| FrameId::from_number(number as u32))
}
