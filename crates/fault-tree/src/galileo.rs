//! Galileo's text format, as far as it is static.
//!
//! ```text
//! toplevel "T";
//! "T" and "A" "B";          // and, or, not, nand, nor, xor, 2of3 (or vot2)
//! "A" prob=0.1;             // a probability
//! "B" lambda=0.001 dorm=0;  // a failure rate, with the mission time of the settings
//! ```
//!
//! Source: K. J. Sullivan, J. B. Dugan, D. Coppit, *The Galileo Fault Tree Analysis Tool*, FTCS 1999, and the dialect of Storm.
//! Comments are `// ...` and `/* ... */`; names may stand without quotation marks. Dynamic gates (`pand`, `por`, `seq`, `fdep`,
//! `pdep`, `rdep`, `wsp`, `csp`, `hsp`, `mutex`, `inspect`), repair, imperfect coverage and other distributions are refused by name: their events
//! are not independent of order or of each other, so no static value is theirs. Only a spare gate makes an event dormant, and
//! there is none; so `dorm` has no effect, which is a warning.

mod lexer;
mod statement;
mod written;

use diagnostic::{Problem, Source};

use crate::draft::Draft;
use crate::mistakes::Mistakes;
use crate::reading::{Reading, Settings};
use statement::Statements;
pub(crate) use statement::check_count;
pub(crate) use written::written_in_galileo;

/// Reads a tree in Galileo's format.
///
/// # Errors
/// All mistakes of the text as one problem, each with its place and a remedy: what is not well-formed, not defined, defined
/// twice or depends on itself (`bad-fault-tree`), and what is well-formed and dynamic (`unsupported-fault-tree`).
pub fn read_galileo(source: &Source, settings: &Settings) -> Result<Reading, Problem> {
    let mut mistakes = Mistakes::new(source);
    let mut warnings = Mistakes::new(source);
    let tokens = lexer::tokens(&source.text, &mut mistakes);
    let mut draft = Draft::default();
    Statements {
        settings,
        draft: &mut draft,
        mistakes: &mut mistakes,
        warnings: &mut warnings,
    }
    .read(&tokens);
    if draft.top.is_none() {
        mistakes.add(
            0..0,
            "the text has no `toplevel`",
            "begin with `toplevel \"name\";`",
        );
    }
    let mut reading = draft.resolve(source, mistakes)?;
    let (mut said, _) = warnings.into_problems(&[]);
    reading.warnings.append(&mut said);
    Ok(reading)
}
