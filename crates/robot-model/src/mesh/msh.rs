//! MuJoCo's own MSH: four 32-bit counts (vertices, normals, texture coordinates, faces), then as 32-bit floats three for each
//! vertex, three for each normal and two for each texture coordinate, and three 32-bit indices for each face; little
//! endian (XML reference of MuJoCo 3.17, `asset/mesh`). Normals and texture coordinates are looks.

use super::{MAX_TRIANGLES, MeshError, Triangles};

const HEADER: usize = 16;

pub(super) fn read(bytes: &[u8]) -> Result<Triangles, MeshError> {
    let damaged = |what: String| Err(MeshError::Damaged(what));
    let words: Vec<[u8; 4]> = bytes.as_chunks::<4>().0.to_vec();
    let Some(counts) = words.first_chunk::<4>() else {
        let held = bytes.len();
        return damaged(format!(
            "it has {held} bytes, fewer than the {HEADER} of the header of an MSH file"
        ));
    };
    let counts = counts.map(|word| u32::from_le_bytes(word) as usize);
    let [vertices, normals, texture, faces] = counts;
    if vertices > 3 * MAX_TRIANGLES || faces > MAX_TRIANGLES {
        return damaged(format!(
            "it has {faces} triangles, more than {MAX_TRIANGLES}"
        ));
    }
    let (first, behind) = (4 + 3 * vertices, 3 * normals + 2 * texture);
    let expected = 4 * first.saturating_add(behind).saturating_add(3 * faces);
    if bytes.len() != expected {
        let held = bytes.len();
        return damaged(format!("its counts make {expected} bytes, it has {held}"));
    }
    let float = |word: &[u8; 4]| f64::from(f32::from_le_bytes(*word));
    let corners = words[4..first].as_chunks::<3>().0.iter();
    let triangles: Vec<[u32; 3]> = words[first + behind..]
        .as_chunks::<3>()
        .0
        .iter()
        .map(|face| face.map(u32::from_le_bytes))
        .collect();
    if triangles
        .iter()
        .flatten()
        .any(|corner| *corner as usize >= vertices)
    {
        return damaged("a face names no known vertex".to_owned());
    }
    Ok(Triangles {
        vertices: corners
            .map(|[x, y, z]| [float(x), float(y), float(z)])
            .collect(),
        triangles,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tetrahedron with a normal and a texture coordinate, which are passed over.
    fn tetrahedron() -> Vec<u8> {
        let mut bytes: Vec<u8> = [4_u32, 1, 1, 4]
            .into_iter()
            .flat_map(u32::to_le_bytes)
            .collect();
        let corners = [
            [0.0_f32; 3],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 1.0],
        ];
        let floats = corners
            .into_iter()
            .flatten()
            .chain([0.0, 0.0, 1.0, 0.5, 0.5]);
        bytes.extend(floats.flat_map(f32::to_le_bytes));
        let faces = [[0_u32, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        bytes.extend(faces.into_iter().flatten().flat_map(u32::to_le_bytes));
        bytes
    }

    #[test]
    fn vertices_and_faces_are_read_past_what_is_only_seen() {
        let read = read(&tetrahedron()).expect("sound");
        assert_eq!((read.vertices.len(), read.triangles.len()), (4, 4));
        assert_eq!(read.vertices[3], [0.0, 0.0, 1.0]);
        assert_eq!(read.triangles[3], [1, 2, 3]);
    }

    #[test]
    fn a_wrong_length_or_index_is_damage() {
        let whole = tetrahedron();
        let mut wrong = whole.clone();
        let last = wrong.len() - 4;
        wrong[last] = 9;
        for (bytes, says) in [
            (&whole[..7], "header"),
            (&whole[..whole.len() - 4], "counts make"),
            (&wrong[..], "names no known"),
        ] {
            let Err(MeshError::Damaged(reason)) = read(bytes) else {
                panic!("{says} should be damage");
            };
            assert!(reason.contains(says), "{reason}");
        }
    }
}
