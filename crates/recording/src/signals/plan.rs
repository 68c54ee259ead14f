//! What a stream is made of: sources of rows, and the signals that their columns become.

use trace::SignalIndex;

use crate::topic_map::Interpolation;

/// One column of a source's rows and the signal that it becomes.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Output {
    /// The signal in the layout.
    pub signal: SignalIndex,
    /// The column of the source's row.
    pub column: usize,
    pub interpolation: Interpolation,
    /// How long a value counts; `None` for ever.
    pub staleness_nanos: Option<i64>,
}

/// What has to be done with a source's rows before they are values.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Treatment {
    /// Nothing.
    Plain,
    /// The first three columns are coordinates in the frame whose id is in the fourth; they are
    /// wanted in another frame, turned and, if points, shifted. A unit other than metres has this
    /// many metres.
    Transform {
        in_frame: String,
        is_point: bool,
        metres_per_unit: f64,
    },
    /// There are no rows; the values come from the transforms alone.
    Frames(FrameQuantity),
}

/// What is computed from transforms alone: of the frame `source` as seen from `target`.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct FrameQuantity {
    pub target: String,
    pub source: String,
    pub kind: FrameQuantityKind,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum FrameQuantityKind {
    Position,
    Orientation,
    Distance,
    Speed,
}

/// Something that yields rows over time.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SourcePlan {
    /// What stands for it in notes: its topic, or `/tf`.
    pub name: String,
    /// Number of columns of its rows as they arrive.
    pub width: usize,
    pub treatment: Treatment,
    pub outputs: Vec<Output>,
}

impl SourcePlan {
    pub fn is_linear(&self) -> bool {
        let mut outputs = self.outputs.iter();
        outputs.any(|output| output.interpolation == Interpolation::Linear)
    }

    /// The widest gap between two samples that is bridged.
    pub fn bridged_nanos(&self) -> i64 {
        let linear = self
            .outputs
            .iter()
            .filter(|output| output.interpolation == Interpolation::Linear);
        linear
            .filter_map(|output| output.staleness_nanos)
            .max()
            .unwrap_or(0)
    }
}
