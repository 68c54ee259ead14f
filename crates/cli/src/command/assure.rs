//! `corroborate assure`: a study's assurance case, its provenance, and its evidence as statements
//! that others can sign and check.

use super::{Done, json};
use crate::args::{Assure, Format};
use crate::drawing::drawing;
use corroborate::{AssureRequest, Outcome};
use diagnostic::{Problem, counted};

/// Writes the assurance case.
pub fn assure(arguments: &Assure) -> Result<Done, Problem> {
    let request = AssureRequest {
        study: arguments.study.clone(),
        out: arguments.out.clone(),
        to: arguments.to.clone(),
    };
    let report = corroborate::assure(&request, &drawing())?;
    Ok(Done {
        output: match arguments.format {
            Format::Json => json(&report)?,
            Format::Text => format!(
                "{} in {}\nThe arguments have {}: {} undeveloped, {} defeated.\n",
                counted(report.files.len(), "file"),
                report.folder.display(),
                counted(report.elements, "element"),
                report.undeveloped,
                report.defeated,
            ),
        },
        outcome: Outcome::Holds,
    })
}

#[cfg(test)]
mod tests {
    use crate::command::tests::assert_schema_is_committed;
    use corroborate::assure::{EvidencePredicate, Statement, StudyPredicate};

    #[test]
    fn the_committed_schemas_are_the_forms_that_are_written() {
        let schema = schemars::schema_for!(Statement<EvidencePredicate>).into();
        assert_schema_is_committed("statement-evidence.schema.json", &schema);
        let schema = schemars::schema_for!(Statement<StudyPredicate>).into();
        assert_schema_is_committed("statement-study.schema.json", &schema);
        let schema = schemars::schema_for!(corroborate::AssureReport).into();
        assert_schema_is_committed("assure.schema.json", &schema);
    }
}
