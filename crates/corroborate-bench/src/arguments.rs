//! What the command is told.

use corroborate_bench::family::Family;
use corroborate_bench::grammar::family::Kind;
use corroborate_bench::grammar::plant::Plant;
use std::path::PathBuf;

/// How the command is called.
pub const USAGE: &str = "\
usage: corroborate-bench [--small] [--seed NUMBER] [--without-case-studies] [--only FAMILY] [--to FOLDER] [--misses]
       corroborate-bench write --to FOLDER [--each NUMBER] [--seed NUMBER] [--only FAMILY] [--fault FAULT] [--show-held-out]
       corroborate-bench judge --program PATH --to FOLDER [--each NUMBER] [--seed NUMBER] [--only FAMILY] [--fault FAULT]
                               [--misses] [--show-held-out] [--small]";

/// What the command is told.
#[derive(Debug, Default)]
pub struct Arguments {
    /// `write`, `judge`, or nothing.
    pub verb: Option<String>,
    /// The small plan.
    pub small: bool,
    /// The seed.
    pub seed: Option<u64>,
    /// Without the families of the case studies.
    pub without_case_studies: bool,
    /// The one family.
    pub only: Option<String>,
    /// The one fault.
    pub fault: Option<Plant>,
    /// Where to.
    pub to: Option<PathBuf>,
    /// The program that is judged.
    pub program: Option<PathBuf>,
    /// Studies of each fault in each family.
    pub each: Option<usize>,
    /// Whether to tell of misses.
    pub misses: bool,
    /// Whether studies of families that are held out are written, and told of.
    pub show_held_out: bool,
}

impl Arguments {
    /// Reads the words after the program's name.
    ///
    /// # Errors
    /// What is wrong with them.
    pub fn read(words: impl Iterator<Item = String>) -> Result<Self, String> {
        let mut words = words.peekable();
        let mut it = Self {
            verb: words.next_if(|word| ["write", "judge"].contains(&word.as_str())),
            ..Self::default()
        };
        while let Some(word) = words.next() {
            let mut value = || {
                words
                    .next()
                    .ok_or_else(|| format!("`{word}` needs a value; {USAGE}"))
            };
            match word.as_str() {
                "--small" => it.small = true,
                "--without-case-studies" => it.without_case_studies = true,
                "--misses" => it.misses = true,
                "--show-held-out" => it.show_held_out = true,
                "--seed" => it.seed = Some(number(&word, &value()?)?),
                "--each" => it.each = Some(number(&word, &value()?)?),
                "--only" => it.only = Some(value()?),
                "--fault" => it.fault = Some(fault(&value()?)?),
                "--to" => it.to = Some(value()?.into()),
                "--program" => it.program = Some(value()?.into()),
                other => return Err(format!("unknown argument `{other}`; {USAGE}")),
            }
        }
        Ok(it)
    }

    /// The one family of those made by hand.
    ///
    /// # Errors
    /// If there is none of that name.
    pub fn family(&self) -> Result<Option<Family>, String> {
        one_of(self.only.as_deref(), &Family::ALL, |family| family.name())
    }

    /// The one family of the grammar.
    ///
    /// # Errors
    /// If there is none of that name.
    pub fn kind(&self) -> Result<Option<Kind>, String> {
        one_of(self.only.as_deref(), &Kind::ALL, |kind| kind.name())
    }
}

fn number<T: std::str::FromStr>(word: &str, text: &str) -> Result<T, String> {
    text.parse()
        .map_err(|_| format!("`{word}` needs a whole number (got `{text}`); {USAGE}"))
}

fn fault(name: &str) -> Result<Plant, String> {
    let found = one_of(Some(name), &Plant::ALL, |plant| plant.name())?;
    found.ok_or_else(|| USAGE.to_owned())
}

fn one_of<T: Copy>(
    name: Option<&str>,
    all: &[T],
    of: impl Fn(T) -> &'static str,
) -> Result<Option<T>, String> {
    let Some(name) = name else {
        return Ok(None);
    };
    let found = all.iter().copied().find(|it| of(*it) == name);
    let names: Vec<&str> = all.iter().map(|it| of(*it)).collect();
    found
        .map(Some)
        .ok_or_else(|| format!("`{name}` is not one of: {}", names.join(", ")))
}
