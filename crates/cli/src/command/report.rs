//! `corroborate report`: the report of a study that has been run.

use super::{Done, json};
use crate::args::{Format, Report};
use crate::terminal::{terminal_width, use_colour};
use crate::written;
use corroborate::Ended;
use corroborate::results::{REPORT, read_current_result, results_folder};
use diagnostic::Problem;
use host::files::write_whole;

/// Writes the report again.
pub fn report(arguments: &Report) -> Result<Done, Problem> {
    let folder = results_folder(&arguments.study, arguments.out.as_deref());
    let result = read_current_result(&arguments.study, &folder)?;
    let to = arguments.to.clone().unwrap_or_else(|| folder.join(REPORT));
    write_whole(&to, report::html(&result).as_bytes())?;
    written::keep(&arguments.written, &arguments.study, Ok(&result))?;
    let output = match arguments.format {
        Format::Json => json(&result)?,
        Format::Text => format!(
            "{}\nReport: {}\n",
            report::text(&result, terminal_width(), use_colour()),
            to.display()
        ),
    };
    Ok(Done {
        output,
        outcome: result.outcome(),
    })
}
