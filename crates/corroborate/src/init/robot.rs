//! A study drafted from a robot's description: one scene with the robot on a floor, its drives and sensors from its joints,
//! and requirements with values that the description gives.

mod drives;
mod shape;

use super::draft::{comment, file_name, filled, is_plain, plain, quoted, rounded};
use super::{Draft, NewFile};
use diagnostic::Problem;
use drives::Drive;
use robot_model::{Joint, JointKind, Loaded, Model};
use shape::Stance;
use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::Path;

/// Joints whose limits one requirement speaks of, at most.
const MOST_JOINTS: usize = 60;

/// How fast the end may be where the description sets no speeds, m/s.
const GUESSED_SPEED: f64 = 1.0;

/// A draft of a study about the robot that a file describes.
///
/// # Errors
/// Those of reading it; `description-refused` with the reasons that `inspect` shows.
pub(super) fn draft(file: &Path) -> Result<Draft, Problem> {
    let loaded = crate::inspect::load(file, &[], &Default::default())?;
    refuse(file, &loaded)?;
    let address = std::path::absolute(file).map_err(|error| Problem::cannot_read(file, &error))?;
    let Some(address) = address.to_str() else {
        let message = format!("the path of {} must be valid UTF-8", file.display());
        return Err(Problem::new("cannot-read", message).remedy("rename the file or its folder"));
    };
    let facts = Facts::of(file, address, &loaded);
    let values = facts.values();
    let values: Vec<(&str, &str)> = values
        .iter()
        .map(|(name, value)| (*name, value.as_str()))
        .collect();
    let files = TEXTS
        .iter()
        .map(|(path, text)| NewFile::text(*path, filled(text, &values)));
    Ok(Draft {
        is: format!("a draft about {}, on a floor", file_name(file)),
        files: files
            .chain([NewFile::text(".gitignore", "results/\n")])
            .collect(),
        notes: vec![format!(
            "the description and its meshes stay where they are: simulation/scene.toml refers to {}",
            comment(address)
        )],
    })
}

/// The texts of `templates/from-robot`.
const TEXTS: [(&str, &str); 7] = [
    (
        "README.md",
        include_str!("../../templates/from-robot/README.md"),
    ),
    (
        "study.toml",
        include_str!("../../templates/from-robot/study.toml"),
    ),
    (
        "parameters.toml",
        include_str!("../../templates/from-robot/parameters.toml"),
    ),
    (
        "vocabulary.toml",
        include_str!("../../templates/from-robot/vocabulary.toml"),
    ),
    (
        "requirements.toml",
        include_str!("../../templates/from-robot/requirements.toml"),
    ),
    (
        "ledger.toml",
        include_str!("../../templates/from-robot/ledger.toml"),
    ),
    (
        "simulation/scene.toml",
        include_str!("../../templates/from-robot/simulation/scene.toml"),
    ),
];

/// What no simulation would take.
fn refuse(file: &Path, loaded: &Loaded) -> Result<(), Problem> {
    if loaded.model.links.is_empty() {
        let message = format!("{} has no link", comment(&file.to_string_lossy()));
        return Err(Problem::new("description-refused", message)
            .remedy("name the whole robot's description, not a file that another one includes"));
    }
    let refusals = loaded.refusals(true).into_iter().map(|refusal| {
        Problem::new("description-refused", refusal.to_string()).remedy(format!(
            "`corroborate inspect {}` shows all of it",
            comment(&file.to_string_lossy())
        ))
    });
    Problem::all(refusals).map_or(Ok(()), Err)
}

/// What a draft takes from a description.
struct Facts<'a> {
    file: String,
    address: &'a str,
    model: &'a Model,
    fixed: bool,
    drives: Vec<Drive<'a>>,
    stance: Stance,
    /// The link at the end of the longest chain, and what the scene calls the point there.
    end: usize,
    end_name: String,
    /// The fastest that the description lets it be, if it says so, m/s.
    end_speed: Option<f64>,
}

impl<'a> Facts<'a> {
    fn of(file: &Path, address: &'a str, loaded: &'a Loaded) -> Self {
        let model = &loaded.model;
        let drives = drives::of(model);
        let is_free = model
            .joints
            .iter()
            .any(|joint| joint.kind == JointKind::Free);
        let wheels = drives.iter().filter(|drive| drive.turns_on()).count();
        let must_be_fixed = !loaded.refusals(false).is_empty();
        // What has wheels or no joint at all stands by itself, as what the description itself lets free.
        let fixed = must_be_fixed || !is_free && wheels < 2 && model.freedoms() > 0;
        let stance = shape::stance(model, &drives, fixed);
        let end = shape::end_link(model);
        let mut taken: BTreeSet<String> =
            model.links.iter().map(|link| link.name.clone()).collect();
        Self {
            file: file_name(file),
            address,
            model,
            fixed,
            stance,
            end,
            end_name: plain("end", &mut taken),
            end_speed: shape::fastest(model, end),
            drives,
        }
    }

    /// What stands in the texts' places.
    fn values(&self) -> Vec<(&'static str, String)> {
        let guess = "a guess: the description sets no speeds of its joints";
        let speed = self.end_speed.filter(|speed| *speed > 0.0);
        let from =
            "what the highest speeds of its joints add up to in the pose that the description has";
        vec![
            ("FILE", self.file.clone()),
            ("ADDRESS", quoted(self.address)),
            ("TITLE", quoted(&format!("A draft about {}", self.file))),
            ("LINK", quoted(&self.model.links[self.end].name)),
            (
                "END_MEANING",
                quoted(&format!(
                    "The robot's end ({}) is not faster than it may be.",
                    comment(&self.model.links[self.end].name)
                )),
            ),
            ("END", self.end_name.clone()),
            ("FIXED", self.fixed.to_string()),
            ("Z", rounded(self.stance.height_m).to_string()),
            ("START", self.start()),
            ("GROUND", self.ground().to_owned()),
            ("DRIVES", self.drives()),
            ("JOINTS", self.encoder()),
            (
                "END_SPEED",
                rounded(speed.unwrap_or(GUESSED_SPEED)).to_string(),
            ),
            ("END_SPEED_FROM", speed.map_or(guess, |_| from).to_owned()),
            ("WORDS", self.words()),
            ("REQUIREMENTS", self.requirements()),
        ]
    }

    fn start(&self) -> String {
        let moved = self.stance.moved.iter();
        let each: Vec<String> = moved
            .map(|(joint, position)| {
                let name = quoted(&self.model.joints[*joint].name);
                format!("{name} = {}", rounded(*position))
            })
            .collect();
        match each.is_empty() {
            true => "# joints = { NAME = 0.5 }   where joints stand at first, in rad or m; all stand as the description has them".into(),
            false => format!(
                "# Where the description's pose is beyond the limits of a joint.\njoints = {{ {} }}",
                each.join(", ")
            ),
        }
    }

    fn ground(&self) -> &'static str {
        match self.stance.has_floor {
            true => "# The description has a floor of its own.",
            false => "[ground]\nfriction = 0.8",
        }
    }

    fn drives(&self) -> String {
        let mut text = String::new();
        let mut taken = BTreeSet::new();
        for drive in &self.drives {
            let name = plain(&drive.joint.name, &mut taken);
            drive.write(&mut text, &name, self.fixed);
        }
        if self.drives.is_empty() {
            text.push_str("# The description has no joint that a drive could move.\n");
        }
        text
    }

    fn encoder(&self) -> String {
        if self.drives.is_empty() {
            return String::new();
        }
        let names: Vec<String> = self
            .drives
            .iter()
            .map(|drive| quoted(&drive.joint.name))
            .collect();
        format!(
            "[[sensor]]\nname = \"joints\"\nrobot = \"robot\"\nkind = \"joint_encoder\"\nrate_hz = 50\njoints = [{}]\n",
            names.join(", ")
        )
    }

    /// Joints with limits whose names predicates can have.
    fn limited(&self) -> Vec<&Joint> {
        let joints = self.drives.iter().map(|drive| drive.joint);
        joints
            .filter(|joint| joint.limits.is_some() && is_plain(&joint.name))
            .take(MOST_JOINTS)
            .collect()
    }

    /// Whether there is a floor of the scene's, and something that moves and can be touched.
    fn can_touch_floor(&self) -> bool {
        let touches = |link: usize| crate::inspect::collision_shapes(self.model, link) > 0;
        let mut links = 0..self.model.links.len();
        !self.stance.has_floor && links.any(|link| !self.model.is_static(link) && touches(link))
    }

    fn words(&self) -> String {
        let mut text = String::new();
        let limited = self.limited();
        if !limited.is_empty() {
            let each = limited.iter();
            let each: Vec<String> = each
                .map(|joint| {
                    format!(
                        "/truth/robot.{}.limit_distance >= -0.02 {}",
                        joint.name,
                        unit_of(joint)
                    )
                })
                .collect();
            let _ = write!(
                text,
                "\n[within_limits]\nmeaning = \"No joint is beyond its limits.\"\ntrace = \"\"\"\n{}\"\"\"\n",
                each.join(" &\n")
            );
        }
        let (word, meaning, trace) = match self.fixed {
            true => (
                "floor_touched",
                "The robot touches the floor.",
                "/truth/robot.contact.ground.touching",
            ),
            false => (
                "upright",
                "The robot stands upright.",
                "/truth/robot.tilt <= tilt_limit",
            ),
        };
        if !self.fixed || self.can_touch_floor() {
            let _ = write!(
                text,
                "\n[{word}]\nmeaning = \"{meaning}\"\ntrace = \"{trace}\"\n"
            );
        }
        text
    }

    fn requirements(&self) -> String {
        let mut text = String::new();
        let mut add = |id: &str, says: &str, shall: &str| {
            let _ = write!(
                text,
                "\n[[requirement]]\nid = \"{id}\"\ntext = \"{says}\"\nshall = \"{shall}\"\nmargin = 0.10\n"
            );
        };
        if !self.limited().is_empty() {
            let says = "DRAFT: in at least 50 % of runs no joint is beyond its limits.";
            add(
                "limits",
                says,
                "The robot shall with probability at least 0.5 always satisfy within_limits.",
            );
        }
        match (self.fixed, self.can_touch_floor()) {
            (false, _) => {
                let says = "DRAFT: in at least 50 % of runs the robot stays upright.";
                add(
                    "upright",
                    says,
                    "The robot shall with probability at least 0.5 always satisfy upright.",
                );
            }
            (true, true) => {
                let says = "DRAFT: in at least 50 % of runs the robot does not touch the floor.";
                add(
                    "floor",
                    says,
                    "The robot shall with probability at least 0.5 never satisfy floor_touched.",
                );
            }
            (true, false) => {}
        }
        text
    }
}

fn unit_of(joint: &Joint) -> &'static str {
    match joint.kind {
        JointKind::Prismatic => "m",
        _ => "rad",
    }
}
