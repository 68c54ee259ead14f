//! Coverage of source code, from lcov's tracefiles.
//!
//! Source: the format as described by `geninfo(1)` of the Linux Test Project: records `TN`, `SF`,
//! `FN`, `FNDA`, `FNL`, `FNA`, `BRDA`, `DA`, their totals, and `end_of_record`. Deviations: totals
//! (`LF`, `LH`, ...) are not believed but counted; records of kinds that are not known are
//! skipped, as they are by lcov. Cost: O(n log n). Guarantee: merging is associative and
//! commutative; a line that cannot be understood is an error with its number.

use std::collections::BTreeMap;

use crate::error::CampaignError;

/// How much of something was covered.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Share {
    /// How many were covered.
    pub covered: u64,
    /// How many there are.
    pub total: u64,
}

impl Share {
    /// The share between 0 and 1; `None` of nothing.
    #[must_use]
    pub fn rate(&self) -> Option<f64> {
        (self.total > 0).then(|| self.covered as f64 / self.total as f64)
    }

    fn of<'c>(counts: impl Iterator<Item = &'c u64>) -> Self {
        counts.fold(Self::default(), |share, count| Self {
            covered: share.covered + u64::from(*count > 0),
            total: share.total + 1,
        })
    }

    fn and(self, other: Self) -> Self {
        Self {
            covered: self.covered + other.covered,
            total: self.total + other.total,
        }
    }
}

/// What ran of one source file.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct FileCoverage {
    /// Executions of each line, by its number from 1.
    pub lines: BTreeMap<u64, u64>,
    /// Calls of each function, by its name.
    pub functions: BTreeMap<String, u64>,
    /// Executions of each branch, by line, block and name.
    pub branches: BTreeMap<(u64, String, String), u64>,
}

/// Coverage of source files, by path.
///
/// ```
/// let text = "SF:controller.py\nDA:1,4\nDA:2,0\nend_of_record\n";
/// let mut coverage = campaign::Lcov::parse(text)?;
/// coverage.merge(&campaign::Lcov::parse("SF:controller.py\nDA:2,1\nDA:3,0\nend_of_record\n")?);
/// assert_eq!((coverage.lines().covered, coverage.lines().total), (2, 3));
/// assert_eq!(coverage.files["controller.py"].lines_that_never_ran(), [3]);
/// # Ok::<(), campaign::CampaignError>(())
/// ```
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Lcov {
    /// Each file's coverage, by the path as it was written.
    pub files: BTreeMap<String, FileCoverage>,
}

impl FileCoverage {
    /// Numbers of lines that could run and never did.
    #[must_use]
    pub fn lines_that_never_ran(&self) -> Vec<u64> {
        let idle = self.lines.iter().filter(|(_, count)| **count == 0);
        idle.map(|(line, _)| *line).collect()
    }

    fn merge(&mut self, other: &Self) {
        add(&mut self.lines, &other.lines);
        add(&mut self.functions, &other.functions);
        add(&mut self.branches, &other.branches);
    }
}

fn add<K: Ord + Clone>(counts: &mut BTreeMap<K, u64>, more: &BTreeMap<K, u64>) {
    for (key, count) in more {
        let sum = counts.entry(key.clone()).or_insert(0);
        *sum = sum.saturating_add(*count);
    }
}

impl Lcov {
    /// Reads a tracefile; sections of one file are merged.
    ///
    /// # Errors
    /// [`CampaignError::Text`] with the number of the first line that cannot be understood.
    pub fn parse(text: &str) -> Result<Self, CampaignError> {
        let mut coverage = Self::default();
        let mut open: Option<Section> = None;
        let mut last = 0;
        for (index, line) in text.lines().enumerate() {
            last = index + 1;
            let wrong = |problem: String| CampaignError::Text(format!("line {last}: {problem}"));
            let line = line.trim();
            let (kind, rest) = line.split_once(':').unwrap_or((line, ""));
            match (kind, &mut open) {
                ("" | "TN", _) => {}
                ("SF", None) => open = Some(Section::new(rest)),
                ("SF", Some(_)) => {
                    return Err(wrong(
                        "SF before the end_of_record of the file before".into(),
                    ));
                }
                ("end_of_record", Some(_)) => {
                    if let Some(section) = open.take() {
                        let file = coverage.files.entry(section.path.clone()).or_default();
                        file.merge(&section.finish());
                    }
                }
                (_, Some(section)) => section.read(kind, rest).map_err(wrong)?,
                _ if line.starts_with('#') => {}
                _ => return Err(wrong(format!("`{kind}` outside SF ... end_of_record"))),
            }
        }
        match open {
            Some(section) => Err(CampaignError::Text(format!(
                "line {last}: the text ends within {}; end_of_record is missing",
                section.path
            ))),
            None => Ok(coverage),
        }
    }

    /// Adds the counts of another tracefile.
    pub fn merge(&mut self, other: &Self) {
        for (path, file) in &other.files {
            self.files.entry(path.clone()).or_default().merge(file);
        }
    }

    /// Lines that ran, of all files.
    #[must_use]
    pub fn lines(&self) -> Share {
        self.share(|file| Share::of(file.lines.values()))
    }

    /// Functions that were called, of all files.
    #[must_use]
    pub fn functions(&self) -> Share {
        self.share(|file| Share::of(file.functions.values()))
    }

    /// Branches that were taken, of all files.
    #[must_use]
    pub fn branches(&self) -> Share {
        self.share(|file| Share::of(file.branches.values()))
    }

    fn share(&self, of: impl Fn(&FileCoverage) -> Share) -> Share {
        self.files
            .values()
            .map(of)
            .fold(Share::default(), Share::and)
    }
}

/// A file's section while it is read.
struct Section {
    path: String,
    file: FileCoverage,
    /// Functions of the newer form: index to calls by alias.
    indexed: BTreeMap<String, u64>,
}

impl Section {
    fn new(path: &str) -> Self {
        Self {
            path: path.to_owned(),
            file: FileCoverage::default(),
            indexed: BTreeMap::new(),
        }
    }

    fn read(&mut self, kind: &str, rest: &str) -> Result<(), String> {
        let fields: Vec<&str> = rest.split(',').collect();
        let too_few = || format!("`{kind}:{rest}` has too few fields");
        match (kind, fields.as_slice()) {
            ("DA", [line, count, ..]) => {
                let sum = self.file.lines.entry(number(line)?).or_insert(0);
                *sum = sum.saturating_add(count_of(count)?);
            }
            ("FN", [line, name @ ..]) if !name.is_empty() => {
                number(line)?;
                // "FN:start,name" or "FN:start,end,name"; a name can hold commas (templates).
                let name = match name {
                    [end, rest @ ..] if !rest.is_empty() && number(end).is_ok() => rest.join(","),
                    name => name.join(","),
                };
                self.file.functions.entry(name).or_insert(0);
            }
            ("FNDA", [count, name @ ..]) if !name.is_empty() => {
                let sum = self.file.functions.entry(name.join(",")).or_insert(0);
                *sum = sum.saturating_add(count_of(count)?);
            }
            ("FNL", [index, line, ..]) => {
                number(line)?;
                self.indexed.entry((*index).to_owned()).or_insert(0);
            }
            ("FNA", [index, count, name @ ..]) if !name.is_empty() => {
                if !self.indexed.contains_key(*index) {
                    return Err(format!("FNA of function {index}, which no FNL began"));
                }
                let sum = self.file.functions.entry(name.join(",")).or_insert(0);
                *sum = sum.saturating_add(count_of(count)?);
            }
            ("BRDA", [line, block, branch @ .., taken]) if !branch.is_empty() => {
                let key = (number(line)?, (*block).to_owned(), branch.join(","));
                let taken = if *taken == "-" { 0 } else { count_of(taken)? };
                let sum = self.file.branches.entry(key).or_insert(0);
                *sum = sum.saturating_add(taken);
            }
            ("DA" | "FN" | "FNDA" | "FNL" | "FNA" | "BRDA", _) => return Err(too_few()),
            _ => {}
        }
        Ok(())
    }

    fn finish(self) -> FileCoverage {
        self.file
    }
}

fn number(text: &str) -> Result<u64, String> {
    text.trim()
        .parse()
        .map_err(|_| format!("expected a line number, found `{text}`"))
}

/// A count; negative ones, which a race in the program can leave, count as 0, as lcov has it.
fn count_of(text: &str) -> Result<u64, String> {
    let text = text.trim();
    match (text.parse::<u64>(), text.parse::<f64>()) {
        (Ok(count), _) => Ok(count),
        (_, Ok(count)) if count < 0.0 => Ok(0),
        (_, Ok(count)) if count.is_finite() => Ok(count as u64),
        _ => Err(format!("expected a count, found `{text}`")),
    }
}
