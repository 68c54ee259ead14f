//! What `verify --deep` derives again: answers of formal models by solving them, verdicts on recordings
//! by judging them. Both are determined by their inputs, so every value must be the same.

use super::audit::Audit;
use super::compare;
use crate::corroboration::Piece;
use crate::run::counted_constants;
use crate::technique::Produced;
use crate::technique::model_checking::Compiled;
use crate::technique::operation::Recordings;
use diagnostic::Problem;
use host::Host;
use std::path::Path;
use study::{Entry, Study, Work};

/// Whether an entry is derived again here.
pub fn can(entry: &Entry) -> bool {
    matches!(entry.work, Work::Check { .. } | Work::Judge { .. })
}

/// Holds an entry's findings against those that its model or its recordings give now.
pub fn check(
    study: &Study,
    entry: &Entry,
    before: &[Piece],
    (path, produced): (&Path, &Produced),
    host: &Host,
    audit: &mut Audit,
) -> Result<(), Problem> {
    let (mut again, what) = match &entry.work {
        Work::Check { model, methods } => {
            let compiled = Compiled::new(study, model)?;
            let value_of = |name: &str| compiled.constant(name);
            let counted = counted_constants(study, entry, before, &value_of)?;
            let begin = |title: &str, total: u64| host.events.begin(title, total);
            let again = compiled.produce(&entry.id, methods, &counted, &host.cancel, &begin)?;
            (
                again,
                "values of evidence follow from solving its model again",
            )
        }
        Work::Judge { recordings, .. } => {
            let recordings = Recordings::find(study, recordings)?;
            let title = format!("{}: recordings", entry.id);
            let stage = host.events.begin(&title, recordings.count());
            let say = |line: &str| host.events.say(line);
            let (again, _) = recordings.produce(study, &entry.id, &host.cancel, &stage, &say)?;
            (
                again,
                "values of evidence follow from judging its recordings again",
            )
        }
        _ => return Ok(()),
    };
    // Times differ from run to run.
    again.cost = produced.cost.clone();
    let values = compare::values_at(path, "/content", &again, produced, audit)?;
    audit.checked(values, what);
    Ok(())
}
