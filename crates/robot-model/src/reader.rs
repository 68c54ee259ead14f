//! What the readers of all three languages share: numbers with places, gaps, files that a description names.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::diagnostics::{Effect, Gap, Place, Problem, Problems};
use crate::mesh::{self, Mesh, MeshError};
use crate::model::Model;
use crate::pose::{Vector, direction};
use crate::xacro::{self, Arguments};
use crate::xml::{self, Element};

/// Gives the bytes of what a description names, or a sentence saying why not.
///
/// It gets an address: `package://...`, `model://...`, `file://...`, an absolute path, or a path that is already
/// joined to the folder of the file that names it.
pub type Resolver<'a> = dyn FnMut(&str) -> Result<Vec<u8>, String> + 'a;

/// A loaded description.
#[derive(Debug, Clone, PartialEq)]
pub struct Loaded {
    /// The tree.
    pub model: Model,
    /// What the tree does not hold, or holds approximately, in the order of the text.
    pub gaps: Vec<Gap>,
    /// What is probably wrong, though it could be loaded (inertias no body can have, a moving link without mass).
    pub warnings: Vec<Problem>,
    /// Where each link stands in the text.
    pub places: Vec<Place>,
}

/// Numbers beyond this are mistakes: no robot has a length, mass or stiffness like it, and sums of them overflow.
const LARGEST: f64 = 1e15;

/// Limits from here on mean "none" (SDF writes 1e16, some URDFs 1e30).
const NO_LIMIT: f64 = 1e10;

/// Files that one description may name; more is a trap (includes that include each other's copies).
const MAX_FILES: usize = 2_000;

/// Corners of all meshes together.
const MAX_CORNERS: usize = 8_000_000;

/// Gaps and problems that are kept; a description with more is not what it seems.
const MAX_NOTES: usize = 100_000;

/// The state of a reading.
pub(crate) struct Reader<'r, 's> {
    resolve: &'r mut Resolver<'s>,
    pub gaps: Vec<Gap>,
    pub warnings: Vec<Problem>,
    pub problems: Vec<Problem>,
    pub meshes: Vec<Mesh>,
    /// Where the model's links stand in the text, in their order.
    pub link_places: Vec<Place>,
    /// Files that could not be had: gaps, unless something else fails because of them.
    missing: Vec<Problem>,
    mesh_index: BTreeMap<(String, [u64; 3], bool), Option<usize>>,
    files: usize,
    corners: usize,
}

impl<'r, 's> Reader<'r, 's> {
    pub fn new(resolve: &'r mut Resolver<'s>) -> Self {
        Self {
            resolve,
            gaps: vec![],
            warnings: vec![],
            problems: vec![],
            meshes: vec![],
            link_places: vec![],
            missing: vec![],
            mesh_index: BTreeMap::new(),
            files: 0,
            corners: 0,
        }
    }

    /// Ends the reading.
    pub fn finish(mut self, model: Option<Model>) -> Result<Loaded, Problems> {
        match model {
            Some(mut model) if self.problems.is_empty() => {
                model.meshes = self.meshes;
                Ok(Loaded {
                    model,
                    gaps: self.gaps,
                    warnings: self.warnings,
                    places: self.link_places,
                })
            }
            _ => {
                if self.problems.is_empty() {
                    // A reader without a model has always said why; this keeps the promise of at least one problem.
                    self.problems.push(Problem {
                        place: xml::start_of(""),
                        message: "the description holds no model".to_owned(),
                        remedy: "give a robot, a model, a world or a mujoco element".to_owned(),
                    });
                }
                self.missing.append(&mut self.problems);
                Err(Problems(self.missing))
            }
        }
    }

    /// Notes something wrong that prevents loading.
    pub fn problem(
        &mut self,
        place: &Place,
        message: impl Into<String>,
        remedy: impl Into<String>,
    ) {
        if self.problems.len() < MAX_NOTES {
            self.problems.push(Problem {
                place: place.clone(),
                message: message.into(),
                remedy: remedy.into(),
            });
        }
    }

    /// Notes something doubtful.
    pub fn warn(&mut self, place: &Place, message: impl Into<String>, remedy: impl Into<String>) {
        if self.warnings.len() < MAX_NOTES {
            self.warnings.push(Problem {
                place: place.clone(),
                message: message.into(),
                remedy: remedy.into(),
            });
        }
    }

    /// Notes what is not carried over.
    pub fn gap(
        &mut self,
        place: &Place,
        element: impl Into<String>,
        what: impl Into<String>,
        effect: Effect,
        consequence: impl Into<String>,
    ) {
        if self.gaps.len() < MAX_NOTES {
            self.gaps.push(Gap {
                place: place.clone(),
                element: element.into(),
                what: what.into(),
                consequence: consequence.into(),
                effect,
            });
        }
    }

    /// Notes an element that is passed over whole.
    pub fn passed_over(&mut self, parent: &str, element: &Element, effect: Effect) {
        let consequence = match effect {
            Effect::Motion => "bodies may move differently than described",
            Effect::Contact => "contact may be different than described",
            Effect::Sensing => "what it measures is not available",
            Effect::Control => "what it commands or computes is missing",
            Effect::Looks => "it only looks different",
            Effect::Nothing => "no physical consequence",
        };
        let name = format!("{parent}/{}", element.name);
        self.gap(&element.place, name, "ignored", effect, consequence);
    }

    /// Notes attributes other than the known ones.
    pub fn known_attributes(&mut self, element: &Element, known: &[&str]) {
        for attribute in &element.attributes {
            if !known.contains(&attribute.name.as_str()) {
                let name = format!("{}@{}", element.name, attribute.name);
                let what = format!("ignored (\"{}\")", shortened(&attribute.value));
                let consequence = "this reader does not know the attribute";
                self.gap(&attribute.place, name, what, Effect::Nothing, consequence);
            }
        }
    }

    /// Numbers separated by spaces, or by commas with a warning, as other readers take them; a wrong one is a problem and reads as `None`.
    pub fn numbers(&mut self, place: &Place, what: &str, text: &str) -> Option<Vec<f64>> {
        let mut found = vec![];
        if text.contains(',') {
            let message = format!("{what} has commas (\"{}\")", shortened(text));
            self.warn(
                place,
                message,
                "separate numbers by spaces only; they are read as if",
            );
        }
        let separates = |character: char| character.is_ascii_whitespace() || character == ',';
        for word in text.split(separates).filter(|word| !word.is_empty()) {
            match word.parse::<f64>() {
                Ok(number) if number.abs() <= LARGEST => found.push(number),
                Ok(number) => {
                    let message =
                        format!("{what} holds {number}, which is too large or not finite");
                    let remedy = format!("give finite numbers in SI units, at most {LARGEST:e}");
                    self.problem(place, message, remedy);
                    return None;
                }
                Err(_) => {
                    let message = format!(
                        "{what} holds \"{}\", which is not a number",
                        shortened(word)
                    );
                    self.problem(place, message, "give decimal numbers separated by spaces");
                    return None;
                }
            }
        }
        Some(found)
    }

    /// Exactly `N` numbers.
    pub fn exactly<const N: usize>(
        &mut self,
        place: &Place,
        what: &str,
        text: &str,
    ) -> Option<[f64; N]> {
        let found = self.numbers(place, what, text)?;
        let count = found.len();
        let result = found.try_into().ok();
        if result.is_none() {
            let message = format!("{what} has {count} numbers");
            self.problem(place, message, format!("give {N}"));
        }
        result
    }

    /// An attribute with `N` numbers, if it is there.
    pub fn attribute<const N: usize>(&mut self, element: &Element, name: &str) -> Option<[f64; N]> {
        let attribute = element.attribute(name)?;
        let what = format!("{}@{name}", element.name);
        self.exactly(&attribute.place, &what, &attribute.value)
    }

    /// An attribute with one number, if it is there.
    pub fn number(&mut self, element: &Element, name: &str) -> Option<f64> {
        self.attribute::<1>(element, name).map(|[number]| number)
    }

    /// A number that limits something: `inf` and very large ones mean no limit.
    pub fn limit(&mut self, place: &Place, what: &str, text: &str) -> Option<f64> {
        match text.trim().parse::<f64>() {
            Ok(number) if number.is_nan() => {
                self.problem(place, format!("{what} is NaN"), "give a number");
                None
            }
            Ok(number) => (number.abs() < NO_LIMIT).then_some(number),
            Err(_) => {
                let message = format!(
                    "{what} holds \"{}\", which is not a number",
                    shortened(text)
                );
                self.problem(place, message, "give one decimal number");
                None
            }
        }
    }

    /// An attribute that limits something.
    pub fn limit_attribute(&mut self, element: &Element, name: &str) -> Option<f64> {
        let attribute = element.attribute(name)?;
        let what = format!("{}@{name}", element.name);
        self.limit(&attribute.place, &what, &attribute.value)
    }

    /// The number in the text of a child, if it is there.
    pub fn child_number(&mut self, element: &Element, name: &str) -> Option<f64> {
        let child = element.child(name)?;
        let what = format!("{}/{name}", element.name);
        self.exactly::<1>(&child.place, &what, &child.text)
            .map(|[number]| number)
    }

    /// A size of a shape: positive, or `None`: after a gap if it is 0, since nothing can touch such a shape, or else after
    /// a problem.
    pub fn size(&mut self, place: &Place, what: &str, number: f64) -> Option<f64> {
        if number != 0.0 {
            return self.positive(place, what, number);
        }
        let consequence = "the shape is left out, so nothing touches it";
        self.gap(place, what, "a size of 0", Effect::Contact, consequence);
        None
    }

    /// A size: positive, or a problem (and `None`).
    pub fn positive(&mut self, place: &Place, what: &str, number: f64) -> Option<f64> {
        if number > 0.0 {
            return Some(number);
        }
        self.problem(
            place,
            format!("{what} is {number}"),
            "give a positive number",
        );
        None
    }

    /// A unit vector, or a problem (and x).
    pub fn axis(&mut self, place: &Place, what: &str, vector: Vector) -> Vector {
        direction(vector).unwrap_or_else(|| {
            self.problem(
                place,
                format!("{what} has no direction"),
                "give a vector other than 0 0 0",
            );
            [1.0, 0.0, 0.0]
        })
    }

    /// An attribute that must be there; a problem and `""` if it is not.
    pub fn required<'e>(&mut self, element: &'e Element, name: &str) -> &'e str {
        element.get(name).unwrap_or_else(|| {
            let message = format!("{} has no attribute {name}", element.name);
            self.problem(&element.place, message, format!("add {name}=\"...\""));
            ""
        })
    }

    /// `true`, `false`, `1`, `0`.
    pub fn truth(&mut self, place: &Place, what: &str, text: &str) -> Option<bool> {
        match text.trim() {
            "true" | "1" | "True" => Some(true),
            "false" | "0" | "False" => Some(false),
            other => {
                let message = format!("{what} holds \"{}\"", shortened(other));
                self.problem(place, message, "give true or false");
                None
            }
        }
    }

    /// The bytes at an address; a reason if there are none, or too many files were asked for.
    fn bytes(&mut self, address: &str) -> Result<Vec<u8>, String> {
        self.files += 1;
        if self.files > MAX_FILES {
            return Err(format!("more than {MAX_FILES} files are included"));
        }
        (self.resolve)(address)
    }

    /// The XML that a description stands for, if it is a xacro template; else the description.
    pub fn expanded(&mut self, root: Element, arguments: &Arguments) -> Result<Element, Problems> {
        let place = root.place.clone();
        let (root, declared) = match xacro::is_template(&root) {
            true => xacro::expand(self, root, arguments.clone())
                .map_err(|problem| Problems(vec![problem]))?,
            false => (root, Vec::new()),
        };
        let unknown = arguments.keys().filter(|name| !declared.contains(name));
        let problems: Vec<Problem> = unknown
            .map(|name| xacro::no_such_argument(&place, name, &declared))
            .collect();
        match problems.is_empty() {
            true => Ok(root),
            false => Err(Problems(problems)),
        }
    }

    /// The text at an address, or why it cannot be had.
    pub fn text_at(&mut self, address: &str) -> Result<String, String> {
        let bytes = self.bytes(address)?;
        String::from_utf8(bytes).map_err(|_| "it is not text in UTF-8".to_owned())
    }

    /// The text at an address as XML. What cannot be had is a gap, what cannot be read a problem.
    pub fn optional_document(&mut self, include: &Element, address: &str) -> Option<Element> {
        let place = &include.place;
        let text = match self.bytes(address).map(String::from_utf8) {
            Ok(Ok(text)) => text,
            Ok(Err(_)) => {
                let message = format!("{} is not text in UTF-8", shortened(address));
                self.problem(place, message, "save it as UTF-8");
                return None;
            }
            Err(reason) => {
                let what = format!("{} cannot be had: {reason}", shortened(address));
                let consequence = "what it describes is missing";
                self.missing.push(Problem {
                    place: place.clone(),
                    message: what.clone(),
                    remedy: "other things may be missing because of it".to_owned(),
                });
                self.gap(place, &include.name, what, Effect::Motion, consequence);
                return None;
            }
        };
        match xml::read(address, &text) {
            Ok(root) => Some(root),
            Err(problem) => {
                self.problems.push(problem);
                None
            }
        }
    }

    /// The text at the first of some addresses that can be had, as XML; a problem if none can.
    pub fn needed_document(&mut self, place: &Place, addresses: &[String]) -> Option<Element> {
        let mut reason = String::new();
        for address in addresses {
            match self.bytes(address) {
                Ok(bytes) => {
                    let text = String::from_utf8_lossy(&bytes);
                    let read = xml::read(address, &text);
                    return read.map_err(|problem| self.problems.push(problem)).ok();
                }
                Err(why) if reason.is_empty() => reason = why,
                Err(_) => {}
            }
        }
        let address = addresses.first().map_or("", String::as_str);
        let message = format!("{} cannot be included: {reason}", shortened(address));
        self.problem(place, message, "put the file there, or correct its name");
        None
    }

    /// The index of the mesh at an address, read once for each scale. `None` after a gap or a problem.
    ///
    /// A mesh that is only looked at is named, not read.
    pub fn mesh(
        &mut self,
        place: &Place,
        address: &str,
        scale: Vector,
        only_seen: bool,
    ) -> Option<usize> {
        let key = (address.to_owned(), scale.map(f64::to_bits), only_seen);
        if let Some(known) = self.mesh_index.get(&key) {
            return *known;
        }
        let found = if only_seen {
            Some(self.unread_mesh(address, scale))
        } else {
            self.read_mesh(place, address, scale)
        };
        self.mesh_index.insert(key, found);
        found
    }

    /// As [`mesh`](Self::mesh), of a shape that is touched, in a language that means the surface and not its hull.
    pub fn surface_mesh(&mut self, place: &Place, address: &str, scale: Vector) -> Option<usize> {
        let known = self.meshes.len();
        let index = self.mesh(place, address, scale, false)?;
        if index >= known
            && let Some(depth_m) = self.meshes[index].hollow_m()
        {
            let what = format!(
                "{} has hollows of {depth_m:.3} m or more, which its convex hull fills",
                shortened(address)
            );
            let consequence =
                "nothing gets into them; make the shape of convex parts if that matters";
            self.gap(place, "mesh", what, Effect::Contact, consequence);
        }
        Some(index)
    }

    fn unread_mesh(&mut self, address: &str, scale: Vector) -> usize {
        self.meshes.push(Mesh {
            source: address.to_owned(),
            vertices_m: vec![],
            triangles: vec![],
            scale,
            unsigned_volume: false,
        });
        self.meshes.len() - 1
    }

    fn read_mesh(&mut self, place: &Place, address: &str, scale: Vector) -> Option<usize> {
        let without = "the shape is left out, so nothing touches it";
        let bytes = match self.bytes(address) {
            Ok(bytes) => bytes,
            Err(reason) => {
                let what = format!("{} cannot be read: {reason}", shortened(address));
                self.gap(place, "mesh", what, Effect::Contact, without);
                return None;
            }
        };
        let read = match mesh::read(address, &bytes) {
            Ok(read) => read,
            Err(MeshError::Format(ending)) => {
                let what = format!(
                    "meshes of type .{ending} are not read; convert {} to STL or OBJ",
                    shortened(address)
                );
                self.gap(place, "mesh", what, Effect::Contact, without);
                return None;
            }
            Err(MeshError::Damaged(reason)) => {
                let message = format!("the mesh {} is damaged: {reason}", shortened(address));
                self.problem(place, message, "export it again");
                return None;
            }
        };
        self.keep_mesh(place, address, scale, read)
    }

    /// Takes over corners and triangles that were read, scaled.
    pub fn keep_mesh(
        &mut self,
        place: &Place,
        source: &str,
        scale: Vector,
        read: mesh::Triangles,
    ) -> Option<usize> {
        self.corners += read.vertices.len();
        if self.corners > MAX_CORNERS {
            let message = format!("the meshes have more than {MAX_CORNERS} corners together");
            self.problem(place, message, "simplify the meshes of collision shapes");
            return None;
        }
        let scaled = |corner: &Vector| std::array::from_fn(|axis| corner[axis] * scale[axis]);
        let mirrored = scale.iter().product::<f64>() < 0.0;
        let turned = |[a, b, c]: [u32; 3]| if mirrored { [a, c, b] } else { [a, b, c] };
        self.meshes.push(Mesh {
            source: source.to_owned(),
            vertices_m: read.vertices.iter().map(scaled).collect(),
            triangles: read.triangles.into_iter().map(turned).collect(),
            scale,
            unsigned_volume: false,
        });
        Some(self.meshes.len() - 1)
    }
}

/// A text short enough for a message.
pub(crate) fn shortened(text: &str) -> String {
    const MOST: usize = 120;
    if text.chars().count() <= MOST {
        return text.to_owned();
    }
    let start: String = text.chars().take(MOST).collect();
    format!("{start}...")
}

/// The address of what a file names: joined to the file's folder unless it is absolute or has a scheme.
pub(crate) fn joined(from: &Arc<str>, named: &str) -> String {
    let absolute = named.contains("://") || named.starts_with('/');
    match from.rsplit_once('/') {
        Some((folder, _)) if !absolute => format!("{folder}/{named}"),
        _ => named.to_owned(),
    }
}
