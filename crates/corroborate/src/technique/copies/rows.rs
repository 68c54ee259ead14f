//! Rows of tables that repeat another table's, by name, by place or by content.
//!
//! # Assumes
//! Contents of different trials come to names and places by chance, as `stats::shared_rows` and `stats::renamed_rows` have
//! it.

use super::{Candidate, probability};
use crate::technique::experiment::renamed;
use diagnostic::Problem;
use evidence::{CopyKind, Evidence, RepeatedRows};
use study::Study;

/// What `repeated` found by name, and what repeats another table under other names.
pub(super) fn candidates(study: &Study, evidence: &[Evidence]) -> Result<Vec<Candidate>, Problem> {
    let place = |id: &str| evidence.iter().position(|piece| piece.id == id);
    let mut candidates = Vec::new();
    for (later, piece) in evidence.iter().enumerate() {
        for rows in &piece.shared_rows {
            if let Some(earlier) = place(&rows.with) {
                candidates.push(by_name(later, earlier, rows));
            }
        }
    }
    for found in renamed::pairs(study)? {
        let (Some(later), Some(earlier)) = (place(&found.later), place(&found.earlier)) else {
            continue;
        };
        let is_known = |rows: &RepeatedRows| rows.with == found.earlier;
        if evidence[later].shared_rows.iter().any(is_known) {
            continue;
        }
        candidates.push(Candidate {
            pieces: [later, earlier],
            kind: CopyKind::Rows,
            subjects: Vec::new(),
            key: format!("{later} {earlier}"),
            chance: found.chance,
            met: found.same > 0,
            notable: false,
            finding: format!(
                "{} of the {} rows of `{}` are {} rows of `{}` under other names (by chance with a probability of at most {})",
                found.same,
                found.rows,
                found.paths[1],
                found.how,
                found.paths[0],
                probability(found.chance)
            ),
            places: found.places,
            declare: None,
        });
    }
    Ok(candidates)
}

fn by_name(later: usize, earlier: usize, rows: &RepeatedRows) -> Candidate {
    let [one, other] = &rows.tables;
    Candidate {
        pieces: [later, earlier],
        kind: CopyKind::Rows,
        subjects: Vec::new(),
        key: format!("{later} {earlier}"),
        chance: rows.chance,
        met: true,
        notable: false,
        finding: format!(
            "{} of the {} rows that `{one}` and `{other}` both have are the same (by chance with a probability of at most {})",
            rows.same,
            rows.common,
            probability(rows.chance)
        ),
        places: vec![other.clone(), one.clone()],
        declare: None,
    }
}
