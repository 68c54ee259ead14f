//! Trials of one table that are alike where it does not say that they belong together, as questions.
//!
//! What is tested, and its guarantee, stand in `experiment::groups`; a question is settled by the piece's own name in
//! `independent`, which says why its trials are independent of each other.

use super::{LIMIT, probability, subject_in_words};
use crate::technique::experiment::groups::{AlikeRows, alike_rows};
use diagnostic::Problem;
use evidence::{CopyKind, Evidence, LineageQuestion};
use study::Study;

/// The questions of all pieces, each with the place of its piece.
pub(super) fn questions(
    study: &Study,
    evidence: &[Evidence],
) -> Result<Vec<(usize, LineageQuestion)>, Problem> {
    let rows = alike_rows(study)?;
    let beyond_chance = rows.iter().filter(|found| found.chance <= LIMIT);
    let questions = beyond_chance.filter_map(|found| {
        let place = evidence.iter().position(|it| it.id == found.evidence)?;
        Some((place, question(found)))
    });
    Ok(questions.collect())
}

fn question(found: &AlikeRows) -> LineageQuestion {
    let id = &found.evidence;
    LineageQuestion {
        with: id.clone(),
        kind: CopyKind::Trials,
        subjects: vec![found.subject.clone()],
        finding: format!(
            "in {}, {} are alike in {} ({}; by chance with a probability of at most {} by itself)",
            found.path,
            found.groups,
            found.counted,
            subject_in_words(&found.subject),
            probability(found.p_value)
        ),
        places: vec![format!("{}:{}", found.path, found.line)],
        chance: found.chance,
        blocks: true,
        settled: None,
        remedy: format!(
            "if they belong together, give each group one row with all its trials, so that the intervals allow for it; if \
             not, write `independent = {{ {id} = \"reason\" }}` in {id}'s entry of ledger.toml"
        ),
    }
}
