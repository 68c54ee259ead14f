//! Which files a study reaches: those in its folder, and in folders that the user names.
//!
//! # Definition
//! A path is in reach if what it leads to, once every link and `..` on the way is followed, lies in the study's folder, in a folder
//! of [`Trust::readable`], or in one of [`Trust::folders`] around the study, and is a file or a folder. Of a path at which there is nothing the part
//! that is there counts. Whoever may run programs for a study may read whatever its user can; so folders whose studies may are in
//! reach of them.
//!
//! # Guarantee
//! Nothing is opened to find out: a pipe would wait, and a device may act.
//!
//! # Assumes
//! Nobody else lays links between the question and the reading.

use crate::Trust;
use diagnostic::Problem;
use std::path::{Component, Path, PathBuf};

/// The code of a problem that says that a path leads out of reach.
pub const OUTSIDE: &str = "outside-study";
/// What to do about it.
pub const REMEDY: &str = "copy what is needed into the study, or name its folder: `--allow FOLDER` lets the study read there";

/// The folders in which a study reads.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Reach {
    /// As the system knows them, without links.
    folders: Vec<PathBuf>,
}

impl Reach {
    /// That of a study's folder; of a folder that is not there nothing is in reach.
    pub fn of(study: &Path, trust: &Trust) -> Self {
        let Ok(whole) = study.canonicalize() else {
            return Self::default();
        };
        let known = |it: &PathBuf| it.canonicalize().ok();
        let around = trust.folders.iter().filter_map(known);
        let around: Vec<PathBuf> = around.filter(|it| whole.starts_with(it)).collect();
        let named = trust.readable.iter().filter_map(known);
        Self {
            folders: std::iter::once(whole.clone())
                .chain(named)
                .chain(around)
                .collect(),
        }
    }

    /// Why a path may not be opened, in words; `None` if it may.
    pub fn refuses(&self, path: &Path) -> Option<String> {
        let whole = whole(path);
        if !self.folders.iter().any(|folder| whole.starts_with(folder)) {
            return Some(match whole.starts_with(path) {
                true => "it lies outside of the study's folder".to_owned(),
                false => format!(
                    "it leads to {}, outside of the study's folder",
                    whole.display()
                ),
            });
        }
        let known = std::fs::metadata(&whole).ok()?;
        let is_special = !known.is_file() && !known.is_dir();
        is_special.then(|| "it is a device, a pipe or a socket, not a file".to_owned())
    }

    /// Fails if a path may not be opened that no line of a file names.
    ///
    /// # Errors
    /// `outside-study`.
    pub fn check(&self, path: &Path) -> Result<(), Problem> {
        match self.refuses(path) {
            None => Ok(()),
            Some(why) => {
                let message = format!("{} is not opened: {why}", path.display());
                Err(Problem::new(OUTSIDE, message).remedy(REMEDY))
            }
        }
    }
}

impl Reach {
    /// Fails if a link below a folder that the engine writes into leads out of reach, or to nothing: what is written must not go
    /// through it. A folder that is not there has none.
    ///
    /// # Errors
    /// `outside-study`.
    pub fn check_written(&self, folder: &Path) -> Result<(), Problem> {
        let mut folders = match std::fs::symlink_metadata(folder) {
            Err(_) => return Ok(()),
            Ok(it) if it.is_symlink() => {
                self.check_link(folder)?;
                vec![folder.to_owned()]
            }
            Ok(_) => vec![folder.to_owned()],
        };
        while let Some(below) = folders.pop() {
            for entry in std::fs::read_dir(&below).into_iter().flatten().flatten() {
                match entry.file_type() {
                    Ok(kind) if kind.is_symlink() => self.check_link(&entry.path())?,
                    Ok(kind) if kind.is_dir() => folders.push(entry.path()),
                    // Whoever reads what was kept would wait for it.
                    Ok(kind) if !kind.is_file() => self.check(&entry.path())?,
                    _ => {}
                }
            }
        }
        Ok(())
    }

    fn check_link(&self, link: &Path) -> Result<(), Problem> {
        let why = match link.canonicalize() {
            Ok(_) => self.refuses(link),
            Err(_) => Some("it is a link to what is not there".to_owned()),
        };
        let Some(why) = why else {
            return Ok(());
        };
        let message = format!("nothing is written through {}: {why}", link.display());
        Err(Problem::new(OUTSIDE, message).remedy(
            "remove the link; `--out FOLDER` puts results elsewhere, and `--allow FOLDER` lets the study go there",
        ))
    }
}

/// What a path leads to, without links. Where the end of it is not there, what is there is followed, and the rest is taken as it
/// is written.
fn whole(path: &Path) -> PathBuf {
    let mut rest: Vec<Component<'_>> = Vec::new();
    let mut there = path.components();
    loop {
        let now = match there.as_path() {
            it if it.as_os_str().is_empty() => Path::new("."),
            it => it,
        };
        if let Ok(mut whole) = now.canonicalize() {
            for part in rest.into_iter().rev() {
                match part {
                    Component::ParentDir => drop(whole.pop()),
                    Component::CurDir => {}
                    part => whole.push(part),
                }
            }
            return whole;
        }
        match there.next_back() {
            Some(part) => rest.push(part),
            None => return path.to_owned(),
        }
    }
}

#[cfg(test)]
#[cfg(unix)]
mod tests {
    use super::*;
    use std::os::unix::fs::symlink;

    /// A study beside a folder of secrets, with what leads there.
    fn folders() -> tempfile::TempDir {
        let folder = tempfile::tempdir().expect("a folder");
        let at = |name: &str| folder.path().join(name);
        std::fs::create_dir_all(at("study/inner")).expect("made");
        std::fs::create_dir_all(at("secrets")).expect("made");
        std::fs::write(at("secrets/key"), "k").expect("written");
        std::fs::write(at("study/own"), "o").expect("written");
        symlink("../secrets/key", at("study/link")).expect("linked");
        symlink("../secrets", at("study/away")).expect("linked");
        symlink("inner", at("study/near")).expect("linked");
        folder
    }

    #[test]
    fn what_leads_out_is_out_of_reach() {
        let folder = folders();
        let study = folder.path().join("study");
        let reach = Reach::of(&study, &Trust::default());
        for (path, is_in) in [
            ("own", true),
            ("inner/../own", true),
            ("near", true),
            ("near/not-there", true),
            ("not-there/../own", true),
            ("", true),
            ("..", false),
            ("../study-2/own", false),
            ("../secrets/key", false),
            ("inner/../../secrets/key", false),
            ("not-there/../../secrets/key", false),
            ("link", false),
            ("away/key", false),
            ("away/not-there", false),
            // A link is followed before what comes behind it: the folder around `secrets`.
            ("away/../study/own", true),
            ("away/../secrets", false),
            ("/etc/hostname", false),
            ("/proc/self/environ", false),
        ] {
            let refused = reach.refuses(&study.join(path));
            assert_eq!(refused.is_none(), is_in, "{path}: {refused:?}");
        }
        let problem = reach.check(&study.join("link")).expect_err("out of reach");
        assert!(problem.message().contains("secrets/key"), "{problem:?}");
    }

    #[test]
    fn folders_that_the_user_names_are_in_reach() {
        let folder = folders();
        let study = folder.path().join("study");
        let refuses = |trust: &Trust| Reach::of(&study, trust).refuses(&study.join("link"));
        let named = |readable: &str| Trust {
            readable: vec![folder.path().join(readable)],
            ..Trust::default()
        };
        assert_eq!(refuses(&named("secrets")), None);
        assert!(refuses(&named("study")).is_some());
        assert!(refuses(&named("nowhere")).is_some());
        let around = |it: PathBuf| Trust {
            folders: vec![it],
            ..Trust::default()
        };
        assert_eq!(refuses(&around(folder.path().to_owned())), None);
        // Programs of other studies may run, not this one's.
        assert!(refuses(&around(folder.path().join("secrets"))).is_some());
        assert!(
            Reach::of(&folder.path().join("gone"), &Trust::default())
                .refuses(&study)
                .is_some()
        );
    }

    #[test]
    fn nothing_is_written_through_links_that_lead_out() {
        let folder = folders();
        let study = folder.path().join("study");
        let reach = Reach::of(&study, &Trust::default());
        let results = study.join("results");
        reach.check_written(&results).expect("there is none");
        std::fs::create_dir_all(results.join("a/b")).expect("made");
        std::fs::write(results.join("a/b/c"), "x").expect("written");
        symlink("../inner", results.join("near")).expect("linked");
        reach
            .check_written(&results)
            .expect("it stays in the study");
        for to in [
            "/etc/passwd",
            "../../../../secrets",
            "../../../../not-there",
        ] {
            symlink(to, results.join("a/b/link")).expect("linked");
            let problem = reach.check_written(&results).expect_err("it leads out");
            assert!(problem.message().contains("a/b/link"), "{problem:?}");
            std::fs::remove_file(results.join("a/b/link")).expect("removed");
        }
        let pipe = results.join("a/pipe");
        let made = std::process::Command::new("mkfifo").arg(&pipe).status();
        assert!(made.expect("mkfifo").success());
        let problem = reach.check_written(&results).expect_err("a pipe");
        assert!(problem.message().contains("a pipe or"), "{problem:?}");
        std::fs::remove_dir_all(&results).expect("removed");
        symlink("../secrets", &results).expect("linked");
        let problem = reach.check_written(&results).expect_err("it leads out");
        assert!(problem.message().contains("secrets"), "{problem:?}");
    }

    #[test]
    fn what_is_no_file_is_refused_unopened() {
        let folder = folders();
        let study = folder.path().join("study");
        let pipe = study.join("pipe");
        let made = std::process::Command::new("mkfifo").arg(&pipe).status();
        assert!(made.expect("mkfifo").success());
        let reach = Reach::of(&study, &Trust::default());
        let why = reach.refuses(&pipe).expect("refused");
        assert!(why.contains("a pipe"), "{why}");
        let devices = Trust {
            readable: vec!["/dev".into()],
            ..Trust::default()
        };
        let why = Reach::of(&study, &devices).refuses(Path::new("/dev/zero"));
        assert!(why.is_some());
    }
}
