//! What is in a description of a robot or a scene: its tree, and what of it a simulation would not have.

use diagnostic::{Problem, Source};
use robot_model::{Arguments, Loaded, Model, Role, own_package_path, package_paths};
use schemars::JsonSchema;
use serde::Serialize;
use std::path::{Path, PathBuf};
use testbench::scene::{SceneGap, description_gaps};

/// Whether a file is a description, by the ending of its name.
pub(crate) fn is_description(path: &Path) -> bool {
    let ending = path.extension().and_then(|ending| ending.to_str());
    matches!(ending, Some("urdf" | "sdf" | "world" | "xml" | "xacro"))
}

/// What is in a description.
#[derive(Debug, Serialize, JsonSchema)]
pub struct DescriptionReport {
    /// Version of this form.
    format: String,
    /// The file.
    file: String,
    /// URDF, SDF or MJCF.
    language: String,
    /// The name that it gives itself.
    name: String,
    /// Sum of the links' masses.
    total_mass_kg: f64,
    /// Degrees of freedom.
    freedoms: usize,
    /// Links, parents before their children.
    links: Vec<LinkForm>,
    /// Joints.
    joints: Vec<JointForm>,
    /// Names of the sensors.
    sensors: Vec<String>,
    /// Names of the drives.
    drives: Vec<String>,
    /// What a scene with it lacks, but for what is probably wrong.
    gaps: Vec<GapForm>,
    /// What is probably wrong, with places.
    warnings: Vec<String>,
    /// Why a simulation refuses it, whether or not its base is fixed, with places.
    refused: Vec<String>,
    /// Why a simulation refuses it unless its base is fixed.
    refused_unless_fixed: Vec<String>,
}

/// A link.
#[derive(Debug, Serialize, JsonSchema)]
struct LinkForm {
    name: String,
    /// The link it hangs on; none: the world.
    parent: Option<String>,
    mass_kg: f64,
    /// Shapes that can be touched.
    collision_shapes: usize,
}

/// A joint.
#[derive(Debug, Serialize, JsonSchema)]
struct JointForm {
    name: String,
    /// fixed, revolute, prismatic, ball or free.
    kind: String,
    /// The link that it moves.
    link: String,
    /// Lowest and highest position, rad or m.
    limits: Option<[f64; 2]>,
}

/// Something that is not carried over.
#[derive(Debug, Serialize, JsonSchema)]
struct GapForm {
    file: String,
    /// None: it concerns the whole.
    line: Option<u32>,
    column: Option<u32>,
    element: String,
    what: String,
    /// motion, contact, sensing, control, looks or nothing.
    effect: String,
    consequence: String,
}

impl DescriptionReport {
    /// What is in the description of this file.
    pub fn new(file: String, loaded: &Loaded) -> Self {
        let model = &loaded.model;
        let lacking = description_gaps(&file, loaded);
        let refused = loaded.refusals(true);
        let mut unless_fixed = loaded.refusals(false);
        unless_fixed.retain(|refusal| !refused.contains(refusal));
        Self {
            format: "1.1".into(),
            file,
            language: model.format.to_string(),
            name: model.name.clone(),
            total_mass_kg: model.total_mass_kg(),
            freedoms: model.freedoms(),
            links: (0..model.links.len())
                .map(|link| link_form(model, link))
                .collect(),
            joints: model
                .joints
                .iter()
                .map(|joint| JointForm {
                    name: joint.name.clone(),
                    kind: joint.kind.to_string(),
                    link: model.links[joint.link].name.clone(),
                    limits: joint.limits,
                })
                .collect(),
            sensors: model
                .sensors
                .iter()
                .map(|sensor| sensor.name.clone())
                .collect(),
            drives: model
                .actuators
                .iter()
                .map(|drive| drive.name.clone())
                .collect(),
            gaps: lacking
                .into_iter()
                .filter(|gap| gap.effect != "doubt")
                .map(gap_form)
                .collect(),
            warnings: loaded.warnings.iter().map(ToString::to_string).collect(),
            refused: refused.iter().map(ToString::to_string).collect(),
            refused_unless_fixed: unless_fixed.iter().map(ToString::to_string).collect(),
        }
    }
}

/// Reads a description with values of its arguments, and what it names in packages of these folders and of those around it.
pub(crate) fn load(
    path: &Path,
    packages: &[PathBuf],
    arguments: &Arguments,
) -> Result<Loaded, Problem> {
    let source = host::files::read_source(path)?;
    let name = path.display().to_string();
    let mut resolve = |address: &str| resolved(path, packages, address);
    robot_model::parse_with(&name, &source.text, arguments, &mut resolve)
        .map_err(|problems| refused(&source, &name, &problems))
}

/// The bytes at an address: `package://` and `model://` in the named folders,
/// then beside the file and in the folders around it.
fn resolved(file: &Path, packages: &[PathBuf], address: &str) -> Result<Vec<u8>, String> {
    let candidates = match address.split_once("://") {
        None => vec![PathBuf::from(address)],
        Some(("file", path)) => vec![PathBuf::from(path)],
        Some(("package" | "model", named)) => {
            let whole = std::path::absolute(file).unwrap_or_else(|_| file.to_owned());
            let whole = whole.to_string_lossy();
            let around = package_paths(&whole, address).into_iter();
            let mut text = |path: &str| std::fs::read_to_string(path).ok();
            let own = own_package_path(&whole, address, &mut text);
            let given = packages.iter().map(|folder| folder.join(named));
            given.chain(around.chain(own).map(PathBuf::from)).collect()
        }
        Some((scheme, _)) => return Err(format!("{scheme}:// is not fetched")),
    };
    for candidate in &candidates {
        if candidate.is_file() {
            return std::fs::read(candidate).map_err(|error| error.to_string());
        }
    }
    Err("no such file; name the folder of its packages".to_owned())
}

/// The problems, each shown in the text where it is in this file.
fn refused(source: &Source, file: &str, problems: &robot_model::Problems) -> Problem {
    let shown = problems.0.iter().map(|problem| {
        if *problem.place.file == *file {
            let at = offset(&source.text, problem.place.line, problem.place.column);
            Problem::new("bad-description", &problem.message)
                .at(source, at..at + 1)
                .remedy(&problem.remedy)
        } else {
            let message = format!("{}: {}", problem.place, problem.message);
            Problem::new("bad-description", message).remedy(&problem.remedy)
        }
    });
    Problem::all(shown).unwrap_or_else(|| Problem::new("bad-description", "nothing was read"))
}

/// The byte at a line and a column of characters.
fn offset(text: &str, line: u32, column: u32) -> usize {
    let mut lines = text.split_inclusive('\n');
    let before: usize = lines
        .by_ref()
        .take(line.saturating_sub(1) as usize)
        .map(str::len)
        .sum();
    let rest = lines.next().unwrap_or("");
    let inside = rest.char_indices().nth(column.saturating_sub(1) as usize);
    before + inside.map_or(rest.len(), |(index, _)| index)
}

/// Shapes of a link that can be touched.
pub fn collision_shapes(model: &Model, link: usize) -> usize {
    let shapes = model.links[link].shapes.iter();
    shapes.filter(|shape| shape.role == Role::Collision).count()
}

fn link_form(model: &Model, index: usize) -> LinkForm {
    let link = &model.links[index];
    LinkForm {
        name: link.name.clone(),
        parent: link.parent.map(|parent| model.links[parent].name.clone()),
        mass_kg: link.inertial.map_or(0.0, |inertial| inertial.mass_kg),
        collision_shapes: collision_shapes(model, index),
    }
}

fn gap_form(gap: SceneGap) -> GapForm {
    GapForm {
        file: gap.file,
        line: gap.place.map(|[line, _]| line),
        column: gap.place.map(|[_, column]| column),
        element: gap.element,
        what: gap.what,
        effect: gap.effect,
        consequence: gap.consequence,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_and_columns_lead_to_bytes() {
        let text = "ä<b>\r\nxy<c>";
        assert_eq!(&text[offset(text, 1, 2)..][..3], "<b>");
        assert_eq!(&text[offset(text, 2, 3)..][..3], "<c>");
        assert_eq!(offset(text, 9, 9), text.len());
    }

    #[test]
    fn packages_are_found_in_the_folders_around_the_file() {
        let folder = tempfile::tempdir().expect("a folder");
        let robot = folder.path().join("arm/urdf/arm.urdf");
        let mesh = folder.path().join("arm/meshes/link.stl");
        for path in [&robot, &mesh] {
            std::fs::create_dir_all(path.parent().expect("a folder")).expect("made");
            std::fs::write(path, path.display().to_string()).expect("written");
        }
        let found = resolved(&robot, &[], "package://arm/meshes/link.stl").expect("found");
        assert_eq!(found, mesh.display().to_string().into_bytes());
        // The folder's own package file says what it is called, too.
        let package = folder.path().join("arm/package.xml");
        std::fs::write(&package, "<package><name>arm_description</name></package>")
            .expect("written");
        let found = resolved(&robot, &[], "package://arm_description/meshes/link.stl");
        assert_eq!(found, Ok(mesh.display().to_string().into_bytes()));
        let missing = resolved(&robot, &[], "package://leg/meshes/link.stl");
        assert!(
            missing
                .expect_err("no such package")
                .contains("folder of its packages")
        );
    }
}
