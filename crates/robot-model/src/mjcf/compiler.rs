//! `<compiler>`: units of angles, order of Euler angles, folders, where inertia comes from; and orientations.

use crate::diagnostics::Effect;
use crate::model::Model;
use crate::pose::{
    Pose, Quaternion, about, cross, direction, dot, from_axes, multiply, normalized, scaled,
    subtract, z_axis_to,
};
use crate::reader::Reader;
use crate::shape::Inertial;
use crate::xml::Element;

/// When a body's inertia is that of its geoms.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum FromGeoms {
    Never,
    IfMissing,
    Always,
}

/// The settings that change what the text means.
#[derive(Debug, Clone)]
pub(super) struct Compiler {
    pub degrees: bool,
    pub automatic_limits: bool,
    pub euler_sequence: [char; 3],
    pub mesh_folder: String,
    pub strips_paths: bool,
    pub from_geoms: FromGeoms,
    smallest_mass_kg: f64,
    smallest_inertia_kg_m2: f64,
    /// Whether moments that no body has become their mean.
    pub balances: bool,
    /// What all masses together are scaled to, if it is positive.
    total_mass_kg: f64,
    pub inertia_groups: [f64; 2],
}

const KNOWN: [&str; 13] = [
    "angle",
    "autolimits",
    "eulerseq",
    "meshdir",
    "assetdir",
    "texturedir",
    "strippath",
    "inertiafromgeom",
    "inertiagrouprange",
    "boundmass",
    "boundinertia",
    "balanceinertia",
    "settotalmass",
];

impl Compiler {
    /// Reads all `<compiler>` elements; later ones override.
    pub fn read(reader: &mut Reader<'_, '_>, root: &Element) -> Self {
        let mut result = Self {
            degrees: true,
            automatic_limits: true,
            euler_sequence: ['x', 'y', 'z'],
            mesh_folder: String::new(),
            strips_paths: false,
            from_geoms: FromGeoms::IfMissing,
            smallest_mass_kg: 0.0,
            smallest_inertia_kg_m2: 0.0,
            balances: false,
            total_mass_kg: -1.0,
            inertia_groups: [0.0, 5.0],
        };
        for element in root.all("compiler") {
            result.element(reader, element);
        }
        result
    }

    fn element(&mut self, reader: &mut Reader<'_, '_>, element: &Element) {
        let mut flag = |name: &str, current: bool| match element.attribute(name) {
            Some(found) => reader
                .truth(&found.place, &format!("compiler@{name}"), &found.value)
                .unwrap_or(current),
            None => current,
        };
        self.automatic_limits = flag("autolimits", self.automatic_limits);
        self.strips_paths = flag("strippath", self.strips_paths);
        self.balances = flag("balanceinertia", self.balances);
        match element.get("angle") {
            Some("radian") => self.degrees = false,
            Some("degree") => self.degrees = true,
            Some(other) => {
                let message = format!("angles in {other} are not known");
                reader.problem(&element.place, message, "use radian or degree");
            }
            None => {}
        }
        match element.get("inertiafromgeom") {
            Some("true") => self.from_geoms = FromGeoms::Always,
            Some("false") => self.from_geoms = FromGeoms::Never,
            _ => {}
        }
        for name in ["assetdir", "meshdir"] {
            if let Some(folder) = element.get(name) {
                folder.clone_into(&mut self.mesh_folder);
            }
        }
        if let Some(sequence) = element.get("eulerseq") {
            let letters: Vec<char> = sequence.chars().collect();
            match <[char; 3]>::try_from(letters) {
                Ok(letters) if letters.iter().all(|c| "xyzXYZ".contains(*c)) => {
                    self.euler_sequence = letters;
                }
                _ => {
                    let message = format!("eulerseq {sequence} is not a sequence of axes");
                    reader.problem(&element.place, message, "give three letters of xyzXYZ");
                }
            }
        }
        if let Some(mass) = reader.number(element, "boundmass") {
            self.smallest_mass_kg = mass;
        }
        if let Some(inertia) = reader.number(element, "boundinertia") {
            self.smallest_inertia_kg_m2 = inertia;
        }
        if let Some(mass) = reader.number(element, "settotalmass") {
            self.total_mass_kg = mass;
        }
        if let Some(groups) = reader.attribute::<2>(element, "inertiagrouprange") {
            self.inertia_groups = groups;
        }
        self.others(reader, element);
    }

    fn others(&self, reader: &mut Reader<'_, '_>, element: &Element) {
        // These do not change how bodies move.
        let harmless = [
            "fusestatic",
            "discardvisual",
            "usethread",
            "fitaabb",
            "saveinertial",
        ];
        for attribute in &element.attributes {
            let name = attribute.name.as_str();
            let is_default = name == "coordinate" && attribute.value == "local";
            if KNOWN.contains(&name) || harmless.contains(&name) || is_default {
                continue;
            }
            let path = format!("compiler@{name}");
            let what = format!("ignored (\"{}\")", attribute.value);
            let consequence = "masses or inertias may differ";
            reader.gap(&attribute.place, path, what, Effect::Motion, consequence);
        }
    }

    /// A body's inertia with what every body has at least (`boundmass`, `boundinertia`), balanced if that is asked for.
    pub fn bounded(&self, given: Option<Inertial>) -> Option<Inertial> {
        let bounds = self.smallest_mass_kg > 0.0 || self.smallest_inertia_kg_m2 > 0.0;
        if !bounds && !self.balances {
            return given;
        }
        const NOTHING: Inertial = Inertial {
            mass_kg: 0.0,
            centre_m: [0.0; 3],
            tensor_kg_m2: [0.0; 6],
        };
        let inertial = given.or(bounds.then_some(NOTHING))?;
        let (moments, _) = inertial.principal_axes();
        let mut bounded = moments.map(|moment| moment.max(self.smallest_inertia_kg_m2));
        let sum: f64 = bounded.iter().sum();
        if self.balances && bounded.iter().any(|moment| sum - moment < *moment) {
            bounded = [sum / 3.0; 3];
        }
        let inertial = match bounded == moments {
            true => inertial,
            false => inertial.with_moments(bounded),
        };
        Some(Inertial {
            mass_kg: inertial.mass_kg.max(self.smallest_mass_kg),
            ..inertial
        })
    }

    /// Scales masses and moments as `settotalmass` says. The world's geoms weigh nothing.
    pub fn set_total_mass(&self, model: &mut Model) {
        let sum_kg = model.total_mass_kg();
        if self.total_mass_kg <= 0.0 || sum_kg <= 0.0 {
            return;
        }
        let factor = self.total_mass_kg / sum_kg;
        let inertials = model
            .links
            .iter_mut()
            .filter_map(|link| link.inertial.as_mut());
        for inertial in inertials {
            inertial.mass_kg *= factor;
            inertial.tensor_kg_m2 = inertial.tensor_kg_m2.map(|moment| moment * factor);
        }
    }

    /// An angle as written, in radians.
    pub fn radians(&self, angle: f64) -> f64 {
        if self.degrees {
            angle.to_radians()
        } else {
            angle
        }
    }

    /// `pos` and any of the orientations of an element.
    pub fn pose(&self, reader: &mut Reader<'_, '_>, element: &Element) -> Pose {
        Pose {
            position_m: reader.attribute::<3>(element, "pos").unwrap_or_default(),
            rotation: self.rotation(reader, element),
        }
    }

    /// `quat`, `axisangle`, `euler`, `xyaxes` or `zaxis`; the identity if there is none.
    pub fn rotation(&self, reader: &mut Reader<'_, '_>, element: &Element) -> Quaternion {
        const NONE: Quaternion = [1.0, 0.0, 0.0, 0.0];
        if let Some(quaternion) = reader.attribute::<4>(element, "quat") {
            if quaternion.iter().all(|x| x.abs() < 1e-9) {
                reader.problem(
                    &element.place,
                    "a quaternion is zero",
                    "give 1 0 0 0 for none",
                );
            }
            return normalized(quaternion);
        }
        if let Some([x, y, z, angle]) = reader.attribute::<4>(element, "axisangle") {
            let axis = reader.axis(&element.place, "axisangle", [x, y, z]);
            return about(axis, self.radians(angle));
        }
        if let Some(angles) = reader.attribute::<3>(element, "euler") {
            return self.euler(angles);
        }
        if let Some([a, b, c, d, e, f]) = reader.attribute::<6>(element, "xyaxes") {
            let x = reader.axis(&element.place, "xyaxes", [a, b, c]);
            let y = [d, e, f];
            let y = subtract(y, scaled(x, dot(x, y)));
            let Some(y) = direction(y) else {
                reader.problem(
                    &element.place,
                    "the axes of xyaxes are parallel",
                    "turn one",
                );
                return NONE;
            };
            return from_axes(x, y, cross(x, y));
        }
        match reader.attribute::<3>(element, "zaxis") {
            Some(axis) => z_axis_to(reader.axis(&element.place, "zaxis", axis)),
            None => NONE,
        }
    }

    /// Small letters turn about the axes that were turned before, capital letters about the fixed ones.
    fn euler(&self, angles: [f64; 3]) -> Quaternion {
        let mut result = [1.0, 0.0, 0.0, 0.0];
        for (letter, angle) in self.euler_sequence.iter().zip(angles) {
            let axis = match letter.to_ascii_lowercase() {
                'x' => [1.0, 0.0, 0.0],
                'y' => [0.0, 1.0, 0.0],
                _ => [0.0, 0.0, 1.0],
            };
            let turn = about(axis, self.radians(angle));
            result = if letter.is_ascii_lowercase() {
                multiply(result, turn)
            } else {
                multiply(turn, result)
            };
        }
        normalized(result)
    }
}
