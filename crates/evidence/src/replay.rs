//! One episode as it is shown: what moved, the signals, the verdicts, the moments to look at. Plain data that whoever runs
//! the episode fills in, and that a face draws.

/// A position in metres and an orientation `[w, x, y, z]`.
pub type Pose = ([f64; 3], [f64; 4]);

/// One episode, with what is shown of it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Replay {
    /// What the episode shows.
    pub title: String,
    /// More about it, in prose.
    pub summary: String,
    /// Where it comes from: names and values.
    pub facts: Vec<(String, String)>,
    /// What was done to the system, one action each.
    pub actions: Vec<String>,
    /// What was judged.
    pub verdicts: Vec<Verdict>,
    /// Moments to look at, in the order of time.
    pub marks: Vec<Mark>,
    /// Signals to plot.
    pub signals: Vec<Signal>,
    /// What moved.
    pub scene: Scene,
    /// The program and its version.
    pub produced_by: String,
}

/// How good a verdict or a moment is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tone {
    /// As required.
    Good,
    /// Not as required.
    Bad,
    /// Undecided.
    Open,
    /// Neither.
    #[default]
    Plain,
}

/// What was judged, and how.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Verdict {
    /// The requirement or failure mode.
    pub id: String,
    /// Its text.
    pub text: String,
    /// The verdict in words.
    pub verdict: String,
    /// How good that is.
    pub tone: Tone,
    /// Why, in sentences.
    pub reasons: Vec<String>,
}

/// A moment to look at.
#[derive(Clone, Debug, PartialEq)]
pub struct Mark {
    /// When.
    pub time_secs: f64,
    /// What happens.
    pub text: String,
    /// How good that is.
    pub tone: Tone,
}

/// What a signal's numbers are.
#[derive(Clone, Debug, PartialEq)]
pub enum SignalKind {
    /// Numbers with a unit, which may be empty.
    Number(String),
    /// 0 is no, 1 is yes.
    Flag,
    /// Places in a list of names.
    Names(Vec<String>),
}

/// A signal over time; each value holds until the next.
#[derive(Clone, Debug, PartialEq)]
pub struct Signal {
    /// Its name.
    pub name: String,
    /// What its numbers are.
    pub kind: SignalKind,
    /// Times, rising.
    pub times_secs: Vec<f64>,
    /// Values; NaN where it is unknown.
    pub values: Vec<f64>,
    /// From when until when it is part of the reason for a violation.
    pub causes: Vec<(f64, f64)>,
}

/// What something is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Part of a robot.
    Robot,
    /// What is handled, or can move.
    Object,
    /// Part of a person.
    Person,
    /// What never moves.
    Surroundings,
}

/// The form of a shape; cylinders and capsules lie along z, centred.
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs, reason = "names carry quantity and unit")]
pub enum Form {
    /// The plane z = 0 of the world.
    Ground,
    Box {
        edges_m: [f64; 3],
    },
    Ellipsoid {
        radii_m: [f64; 3],
    },
    Cylinder {
        radius_m: f64,
        length_m: f64,
    },
    /// `length_m` is that of the straight part.
    Capsule {
        radius_m: f64,
        length_m: f64,
    },
    /// Triangles by the places of their corners.
    Triangles {
        points_m: Vec<[f64; 3]>,
        corners: Vec<[usize; 3]>,
    },
}

/// A shape on a body.
#[derive(Clone, Debug, PartialEq)]
pub struct Shape {
    /// Place of its body among the scene's; `None` for the world.
    pub body: Option<usize>,
    /// What it belongs to.
    pub role: Role,
    /// Its frame in the body's.
    pub pose: Pose,
    /// Its form.
    pub form: Form,
}

/// What can be seen, over time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scene {
    /// The names of the bodies.
    pub bodies: Vec<String>,
    /// Their shapes, and those of the world.
    pub shapes: Vec<Shape>,
    /// The times, rising.
    pub times_secs: Vec<f64>,
    /// Where the bodies are, for each time, in their order.
    pub poses: Vec<Vec<Pose>>,
}
