//! STL: triangles as triples of corners, binary or text (3D Systems, StereoLithography Interface Specification, 1988).
//!
//! Binary: 80 bytes of header, a 32-bit count, then for each triangle a normal, three corners (32-bit floats, little
//! endian) and two bytes of attributes. Text: `solid`, then `facet normal .. outer loop vertex .. endloop endfacet`.
//! A binary file may begin with the word `solid` too, so the length decides.

use super::{MAX_TRIANGLES, MeshError, Triangles, merged};
use crate::pose::Vector;

const HEADER: usize = 84;
const RECORD: usize = 50;

pub(super) fn read(bytes: &[u8]) -> Result<Triangles, MeshError> {
    let count = bytes.get(80..84).and_then(|four| four.try_into().ok());
    let count = count.map(|four| u32::from_le_bytes(four) as usize);
    match count {
        Some(count) if bytes.len() == HEADER + count.saturating_mul(RECORD) => binary(bytes, count),
        _ if bytes.trim_ascii_start().starts_with(b"solid") => text(bytes),
        // Some programs append bytes after the last triangle.
        Some(count) if bytes.len() > HEADER + count.saturating_mul(RECORD) => binary(bytes, count),
        Some(count) => Err(MeshError::Damaged(format!(
            "it announces {count} triangles, but {} bytes hold {}",
            bytes.len(),
            (bytes.len() - HEADER.min(bytes.len())) / RECORD
        ))),
        None => Err(MeshError::Damaged(format!(
            "it has {} bytes, fewer than the header of an STL file",
            bytes.len()
        ))),
    }
}

fn binary(bytes: &[u8], count: usize) -> Result<Triangles, MeshError> {
    if count > MAX_TRIANGLES {
        return Err(too_many(count));
    }
    let mut corners: Vec<Vector> = Vec::with_capacity(count * 3);
    for record in bytes[HEADER..].chunks_exact(RECORD).take(count) {
        let float = |index: usize| {
            let four = [0, 1, 2, 3].map(|byte| record[index * 4 + byte]);
            f64::from(f32::from_le_bytes(four))
        };
        corners.extend([3, 6, 9].map(|first| [float(first), float(first + 1), float(first + 2)]));
    }
    Ok(merged(&corners))
}

fn too_many(count: usize) -> MeshError {
    MeshError::Damaged(format!(
        "it has {count} triangles, more than {MAX_TRIANGLES}"
    ))
}

fn text(bytes: &[u8]) -> Result<Triangles, MeshError> {
    let text = String::from_utf8_lossy(bytes);
    let mut corners: Vec<Vector> = vec![];
    for (index, line) in text.lines().enumerate() {
        let mut words = line.split_ascii_whitespace();
        if words.next() != Some("vertex") {
            continue;
        }
        let numbers: Vec<f64> = words.map_while(|word| word.parse().ok()).collect();
        let Ok(corner) = Vector::try_from(numbers) else {
            return Err(MeshError::Damaged(format!(
                "line {} must be a vertex with three numbers",
                index + 1
            )));
        };
        corners.push(corner);
    }
    if !corners.len().is_multiple_of(3) {
        return Err(MeshError::Damaged(format!(
            "its {} vertices do not make whole triangles",
            corners.len()
        )));
    }
    if corners.len() / 3 > MAX_TRIANGLES {
        return Err(too_many(corners.len() / 3));
    }
    Ok(merged(&corners))
}
