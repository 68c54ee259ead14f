//! Code coverage of a controller, read from files in the format of lcov.

use super::form::CodeReport;
use super::plan::Plan;
use campaign::Lcov;
use diagnostic::Problem;
use std::path::{Path, PathBuf};
use study::Study;

/// What of a controller's code ran.
#[derive(Debug, Default)]
pub struct Code {
    all: Option<Lcov>,
}

impl Code {
    /// Adds what the files say that a plan names.
    pub fn read(&mut self, study: &Study, plan: &Plan) -> Result<(), Problem> {
        for pattern in &plan.data.lcov {
            let paths = matching(&study.folder.join(pattern));
            if paths.is_empty() {
                let shown = pattern.display().to_string();
                return Err(plan.mistake(&shown, format!("there is no file `{shown}`")));
            }
            for path in paths {
                study.reach.check(&path)?;
                let source = host::files::read_source(&path)?;
                self.add(&source.text, &source.name)?;
            }
        }
        Ok(())
    }

    /// Takes what one episode left; the lines that ran in it.
    pub fn take(&mut self, text: &str) -> Result<Vec<String>, Problem> {
        let lcov = self.add(text, "what a controller left")?;
        let mut lines = Vec::new();
        for (name, file) in &lcov.files {
            let ran = file.lines.iter().filter(|(_, count)| **count > 0);
            lines.extend(ran.map(|(line, _)| format!("{name}:{line}")));
        }
        Ok(lines)
    }

    fn add(&mut self, text: &str, name: &str) -> Result<Lcov, Problem> {
        let lcov = Lcov::parse(text).map_err(|error| {
            Problem::new("bad-exploration", format!("{name}: {error}"))
                .remedy("name files in the format that lcov and coverage tools write")
        })?;
        self.all.get_or_insert_with(Lcov::default).merge(&lcov);
        Ok(lcov)
    }

    /// What ran, and what there is.
    pub fn report(&self) -> Option<CodeReport> {
        let pair = |share: campaign::Share| [share.covered, share.total];
        let lcov = self.all.as_ref()?;
        Some(CodeReport {
            lines: pair(lcov.lines()),
            functions: pair(lcov.functions()),
            branches: pair(lcov.branches()),
            never_run: lcov
                .files
                .iter()
                .filter_map(|(name, file)| {
                    let lines = file.lines_that_never_ran();
                    let lines: Vec<String> = lines.iter().map(u64::to_string).collect();
                    (!lines.is_empty()).then(|| format!("{name}: {}", lines.join(", ")))
                })
                .collect(),
        })
    }
}

/// The files that a path means, whose last part may hold a `*`, in order.
pub fn matching(pattern: &Path) -> Vec<PathBuf> {
    let name = pattern.file_name().unwrap_or_default().to_string_lossy();
    let Some((before, after)) = name.split_once('*') else {
        return vec![pattern.to_owned()];
    };
    let folder = pattern.parent().unwrap_or(Path::new("."));
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let fits = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let rest = name.strip_prefix(before);
        rest.is_some_and(|rest| rest.ends_with(after) && rest.len() >= after.len())
    };
    let mut found: Vec<PathBuf> = entries.map(|entry| entry.path()).filter(fits).collect();
    found.sort();
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_that_ran_are_named_and_those_that_never_did_are_left() {
        let mut code = Code::default();
        assert!(code.report().is_none());
        let ran = code
            .take("SF:a.py\nDA:1,2\nDA:2,0\nDA:3,0\nend_of_record\n")
            .unwrap();
        assert_eq!(ran, ["a.py:1"]);
        let ran = code
            .take("SF:a.py\nDA:1,0\nDA:2,1\nend_of_record\n")
            .unwrap();
        assert_eq!(ran, ["a.py:2"]);
        let report = code.report().unwrap();
        assert_eq!(
            (report.lines, report.never_run),
            ([2, 3], vec!["a.py: 3".to_owned()])
        );
        assert!(code.take("DA:1,2\n").is_err());
    }

    #[test]
    fn a_star_stands_for_anything_in_a_name() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["7.a.info", "7.b.info", "77.a.info", "7.a.info.12"] {
            std::fs::write(folder.path().join(name), "").unwrap();
        }
        let named = |pattern: &str| matching(&folder.path().join(pattern));
        let of = |names: &[&str]| {
            names
                .iter()
                .map(|n| folder.path().join(n))
                .collect::<Vec<_>>()
        };
        assert_eq!(named("7.*info"), of(&["7.a.info", "7.b.info"]));
        assert_eq!(named("8.*info"), of(&[]));
        assert_eq!(named("any.info"), of(&["any.info"]));
    }
}
