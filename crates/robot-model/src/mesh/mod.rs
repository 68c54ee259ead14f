//! Triangle meshes: STL (binary and text), Wavefront OBJ and MuJoCo's MSH.

mod hollow;
mod msh;
mod obj;
mod stl;
mod volume;

use std::collections::HashMap;

use crate::pose::Vector;
use crate::shape::Inertial;

/// Triangles a mesh may have; more is refused, since every simulation would carry them.
const MAX_TRIANGLES: usize = 2_000_000;

/// A mesh that shapes name.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    /// What the description calls it: the address it was read from, or the name of an asset.
    pub source: String,
    /// Corners in metres, scale applied, each once, in the order of the file; empty if it was not loaded.
    pub vertices_m: Vec<Vector>,
    /// Triangles as indices of corners, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Factors by which the file's coordinates were multiplied.
    pub scale: Vector,
    /// Whether its volume counts every triangle as facing outwards, as MuJoCo does unless told otherwise.
    pub unsigned_volume: bool,
}

impl Mesh {
    /// Whether the corners span a volume, so that a convex hull exists: some corner lies farther than a millionth of
    /// the extent from a plane through three others.
    #[must_use]
    pub fn is_solid(&self) -> bool {
        volume::spans_a_volume(&self.vertices_m)
    }

    /// How deep its hollows are, at least, if they are deeper than a fiftieth of its extent: what a convex hull fills.
    #[must_use]
    pub fn hollow_m(&self) -> Option<f64> {
        let (depth_m, extent_m) = hollow::depth_and_extent(self);
        (depth_m > extent_m / 50.0).then_some(depth_m)
    }

    /// Mass, centre and inertia at a density of 1 kg/m³, so that the mass is the volume in m³; all zero if the
    /// triangles enclose nothing.
    #[must_use]
    pub fn solid(&self) -> Inertial {
        volume::solid(self)
    }
}

/// Corners and triangles of a file.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Triangles {
    pub vertices: Vec<Vector>,
    pub triangles: Vec<[u32; 3]>,
}

/// Why a mesh cannot be used.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum MeshError {
    /// Its format is not read.
    Format(String),
    /// It is damaged; the sentence says where.
    Damaged(String),
}

/// Reads a mesh by the ending of its name.
pub(crate) fn read(name: &str, bytes: &[u8]) -> Result<Triangles, MeshError> {
    let ending = name.rsplit('.').next().unwrap_or("").to_ascii_lowercase();
    let read = match ending.as_str() {
        "stl" | "stlb" => stl::read(bytes)?,
        "obj" => obj::read(bytes)?,
        "msh" => msh::read(bytes)?,
        _ => return Err(MeshError::Format(ending)),
    };
    let finite = read.vertices.iter().flatten().all(|x| x.abs() < 1e9);
    if !finite {
        return Err(MeshError::Damaged(
            "a coordinate is not a finite number below 1e9".to_owned(),
        ));
    }
    if read.vertices.is_empty() {
        return Err(MeshError::Damaged("it has no vertex".to_owned()));
    }
    Ok(read)
}

/// Merges corners with equal coordinates, keeping the order in which they first appear.
fn merged(corners: &[Vector]) -> Triangles {
    let mut known: HashMap<[u64; 3], u32> = HashMap::with_capacity(corners.len() / 4);
    let mut result = Triangles::default();
    for triangle in corners.chunks_exact(3) {
        let indices = [0, 1, 2].map(|corner: usize| {
            // Adding zero makes -0 and 0 one corner.
            let corner = triangle[corner].map(|x| x + 0.0);
            let next = result.vertices.len() as u32;
            let index = *known.entry(corner.map(f64::to_bits)).or_insert(next);
            if index == next {
                result.vertices.push(corner);
            }
            index
        });
        let [a, b, c] = indices;
        if a != b && b != c && a != c {
            result.triangles.push(indices);
        }
    }
    result
}
