//! Wavefront OBJ: `v x y z` and `f a b c ...`, where an index may be negative (from the end) and carry `/t/n`.
//!
//! Faces with more corners are cut into a fan. Normals, textures, groups and materials are looks and are passed over.

use super::{MAX_TRIANGLES, MeshError, Triangles};
use crate::pose::Vector;

pub(super) fn read(bytes: &[u8]) -> Result<Triangles, MeshError> {
    let text = String::from_utf8_lossy(bytes);
    let mut result = Triangles::default();
    for (index, line) in text.lines().enumerate() {
        let damaged = |what: &str| MeshError::Damaged(format!("line {}: {what}", index + 1));
        let mut words = line.split_ascii_whitespace();
        match words.next() {
            Some("v") => {
                let numbers: Vec<f64> = words.map_while(|word| word.parse().ok()).collect();
                let corner = numbers.first_chunk::<3>().copied();
                let corner: Vector = corner.ok_or_else(|| damaged("a vertex has three numbers"))?;
                result.vertices.push(corner);
            }
            Some("f") => {
                let corners: Option<Vec<u32>> = words
                    .map(|word| corner_index(word, result.vertices.len()))
                    .collect();
                let corners = corners.ok_or_else(|| damaged("a face names no known vertex"))?;
                // One with fewer has no area.
                let fan = corners.windows(2).skip(1);
                result
                    .triangles
                    .extend(fan.map(|pair| [corners[0], pair[0], pair[1]]));
            }
            _ => {}
        }
        if result.triangles.len() > MAX_TRIANGLES || result.vertices.len() > 3 * MAX_TRIANGLES {
            return Err(damaged("it has more triangles than are read"));
        }
    }
    Ok(result)
}

/// `7`, `7/1`, `7//2`, `-1`.
fn corner_index(word: &str, known: usize) -> Option<u32> {
    let number: i64 = word.split('/').next()?.parse().ok()?;
    let known = i64::try_from(known).ok()?;
    let index = match number {
        1.. => number - 1,
        ..=-1 => known + number,
        0 => return None,
    };
    (0..known)
        .contains(&index)
        .then(|| u32::try_from(index).ok())?
}
