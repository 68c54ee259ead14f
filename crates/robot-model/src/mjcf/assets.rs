//! `<asset>`: meshes from files or from numbers in the text.

use super::Context;
use crate::diagnostics::Effect;
use crate::mesh::Triangles;
use crate::pose::{Pose, conjugate, normalized};
use crate::reader::joined;
use crate::xml::Element;

impl Context<'_, '_, '_> {
    pub(super) fn assets(&mut self, element: &Element) {
        for child in &element.children {
            match child.name.as_str() {
                "mesh" => self.mesh(child),
                "material" | "texture" | "skin" => {
                    self.reader.passed_over("asset", child, Effect::Looks);
                }
                _ => self.reader.passed_over("asset", child, Effect::Motion),
            }
        }
    }

    fn mesh(&mut self, given: &Element) {
        let element = self.defaults.applied(self.reader, given, None);
        let file = element.get("file").unwrap_or("");
        let stem = file.rsplit('/').next().unwrap_or(file);
        let stem = stem.rsplit_once('.').map_or(stem, |(stem, _)| stem);
        let name = element.get("name").unwrap_or(stem).to_owned();
        let known = [
            "file",
            "scale",
            "vertex",
            "face",
            "refpos",
            "refquat",
            "normal",
            "texcoord",
            "smoothnormal",
            "maxhullvert",
            "content_type",
            "material",
        ];
        self.ignored(
            &element,
            &[&known[..], &["inertia"]].concat(),
            Effect::Motion,
        );
        for child in &element.children {
            self.reader.passed_over("mesh", child, Effect::Motion);
        }
        let scale = self
            .reader
            .attribute::<3>(&element, "scale")
            .unwrap_or([1.0; 3]);
        if scale.contains(&0.0) {
            let remedy = "give factors other than 0";
            self.reader
                .problem(&element.place, "the scale of a mesh has a zero", remedy);
            return;
        }
        let index = if element.get("vertex").is_some() {
            self.written_mesh(&element, &name, scale)
        } else if file.is_empty() {
            self.reader.gap(
                &element.place,
                "asset/mesh",
                format!("mesh {name} has neither a file nor vertices"),
                Effect::Contact,
                "shapes of it are left out",
            );
            None
        } else {
            let address = self.address(file);
            self.reader.mesh(&element.place, &address, scale, false)
        };
        let index = index.and_then(|index| self.referred(&element, index));
        let exact = match element.get("inertia") {
            None | Some("legacy") => false,
            Some("exact") => true,
            Some(_) => {
                self.ignored(&element, &known, Effect::Motion);
                false
            }
        };
        if let Some(mesh) = index.and_then(|index| self.reader.meshes.get_mut(index)) {
            mesh.unsigned_volume = !exact;
        }
        if self.meshes.insert(name.clone(), index).is_some() {
            let message = format!("two meshes are called {name}");
            self.reader
                .problem(&element.place, message, "rename one of them");
        }
    }

    /// The address of a mesh's file.
    fn address(&self, file: &str) -> String {
        let file = if self.compiler.strips_paths {
            file.rsplit('/').next().unwrap_or(file)
        } else {
            file
        };
        let folder = self.compiler.mesh_folder.trim_end_matches('/');
        if folder.is_empty() || file.starts_with('/') {
            joined(&self.main, file)
        } else {
            joined(&self.main, &format!("{folder}/{file}"))
        }
    }

    /// Vertices and faces that stand in the text.
    fn written_mesh(&mut self, element: &Element, name: &str, scale: [f64; 3]) -> Option<usize> {
        let mut all = |attribute: &str| {
            let found = element.attribute(attribute)?;
            let what = format!("mesh@{attribute}");
            self.reader.numbers(&found.place, &what, &found.value)
        };
        let (corners, faces) = (all("vertex")?, all("face").unwrap_or_default());
        let count = corners.len() / 3;
        let wrong = corners.len() % 3 != 0
            || faces.len() % 3 != 0
            || faces
                .iter()
                .any(|index| index.fract() != 0.0 || *index < 0.0 || *index >= count as f64);
        if wrong {
            let message = format!("the numbers of mesh {name} make no triangles");
            let remedy =
                "give three numbers for each vertex, three indices below their count for each face";
            self.reader.problem(&element.place, message, remedy);
            return None;
        }
        let read = Triangles {
            vertices: corners
                .chunks_exact(3)
                .map(|c| [c[0], c[1], c[2]])
                .collect(),
            triangles: faces
                .chunks_exact(3)
                .map(|face| [face[0] as u32, face[1] as u32, face[2] as u32])
                .collect(),
        };
        self.reader.keep_mesh(&element.place, name, scale, read)
    }

    /// Applies `refpos` and `refquat`: the mesh is moved so that this pose becomes its origin.
    fn referred(&mut self, element: &Element, index: usize) -> Option<usize> {
        let position = self.reader.attribute::<3>(element, "refpos");
        let rotation = self.reader.attribute::<4>(element, "refquat");
        if position.is_none() && rotation.is_none() {
            return Some(index);
        }
        let reference = Pose {
            position_m: position.unwrap_or_default(),
            rotation: normalized(rotation.unwrap_or([1.0, 0.0, 0.0, 0.0])),
        };
        let mut copy = self.reader.meshes.get(index)?.clone();
        for corner in &mut copy.vertices_m {
            let moved = crate::pose::subtract(*corner, reference.position_m);
            *corner = crate::pose::rotate(conjugate(reference.rotation), moved);
        }
        self.reader.meshes.push(copy);
        Some(self.reader.meshes.len() - 1)
    }
}
