//! Files as the engine reads and writes them: texts whole and in UTF-8, results whole or not at all.

use crate::system::is_named;
use diagnostic::{Problem, Source};
use std::borrow::Cow;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

/// How many bytes a text may have that people write: models, properties and the files of a study.
pub const MOST_BYTES: u64 = 64 << 20;

/// Reads a file as text.
pub fn read_source(path: &Path) -> Result<Source, Problem> {
    of_bytes(path, read_file(path, MOST_BYTES)?)
}

/// Reads a file that a program wrote and that may be as large as the memory.
pub fn read_any_size(path: &Path) -> Result<Source, Problem> {
    of_bytes(path, read_file(path, u64::MAX - 1)?)
}

/// Reads a text in the PRISM language. Many published models are written in Latin-1, mostly for an accent in a comment:
/// what is not UTF-8 is read so, with a warning at the first byte that shows it.
pub fn read_prism(path: &Path) -> Result<(Source, Option<Problem>), Problem> {
    prism_of_bytes(path, read_file(path, MOST_BYTES)?)
}

/// The same of the bytes that were read of a file.
///
/// # Errors
/// `not-text`.
pub fn prism_of_bytes(path: &Path, bytes: Vec<u8>) -> Result<(Source, Option<Problem>), Problem> {
    let Err(error) = std::str::from_utf8(&bytes) else {
        return Ok((of_bytes(path, bytes)?, None));
    };
    let first = error.valid_up_to();
    // Texts have no zero bytes; files of other kinds, and UTF-16, do.
    if bytes.contains(&0) {
        return Err(not_text(path, first));
    }
    // Each byte of Latin-1 is the character with its number. What stands before `first` is UTF-8, but perhaps not ASCII:
    // the file is read in one way as a whole.
    let text: String = bytes.iter().copied().map(char::from).collect();
    let place: usize = (bytes[..first].iter().copied())
        .map(|byte| char::from(byte).len_utf8())
        .sum();
    let source = Source {
        name: path.display().to_string(),
        text,
    };
    let message = format!(
        "the file is not UTF-8 (byte 0x{:02X} here) and was read as Latin-1.",
        bytes[first]
    );
    let warning = Problem::new("read-as-latin1", message)
        .at(&source, place..place)
        .remedy("Save it as UTF-8 if letters are wrong.");
    Ok((source, Some(warning)))
}

/// A text with the line ends of the one that it was made of: where all of that one's are CR LF, what was put in gets CR LF, too.
/// Where they are mixed, or LF alone, it stays as it is.
pub fn with_line_ends_of<'t>(text: &'t str, made_of: &str) -> Cow<'t, str> {
    let breaks = made_of.matches('\n').count();
    if breaks == 0 || made_of.matches("\r\n").count() < breaks {
        return Cow::Borrowed(text);
    }
    Cow::Owned(text.replace("\r\n", "\n").replace('\n', "\r\n"))
}

/// Writes a text that was made of another file's, whole or not at all, with the line ends of that one; as it is where that one
/// is not there.
///
/// # Errors
/// `cannot-write`, `cannot-read`, `not-text` of the other one.
pub fn write_text(path: &Path, text: &str, made_of: &Path) -> Result<(), Problem> {
    let old = match made_of.exists() {
        true => read_source(made_of)?.text,
        false => String::new(),
    };
    write_whole(path, with_line_ends_of(text, &old).as_bytes())
}

/// Writes a text in the PRISM language that was made of another's, whole or not at all, in the encoding and with the line ends of
/// that one: bytes outside of what was changed are the same.
///
/// # Errors
/// `not-latin1` if the other was read as Latin-1 ([`read_prism`]) and the text has a character that Latin-1 has not.
pub fn write_prism(path: &Path, text: &str, made_of: &Path) -> Result<(), Problem> {
    let (old, is_latin_1) = read_prism(made_of)?;
    let text = with_line_ends_of(text, &old.text);
    if is_latin_1.is_none() {
        return write_whole(path, text.as_bytes());
    }
    let bytes: Result<Vec<u8>, char> = text
        .chars()
        .map(|letter| u8::try_from(letter).map_err(|_| letter))
        .collect();
    let bytes = bytes.map_err(|letter| {
        let message = format!(
            "{} is written in Latin-1, which has no `{letter}`",
            made_of.display()
        );
        Problem::new("not-latin1", message).remedy("save it as UTF-8 first")
    })?;
    write_whole(path, &bytes)
}

fn of_bytes(path: &Path, bytes: Vec<u8>) -> Result<Source, Problem> {
    let text = String::from_utf8(bytes)
        .map_err(|error| not_text(path, error.utf8_error().valid_up_to()))?;
    Ok(Source {
        name: path.display().to_string(),
        text,
    })
}

fn not_text(path: &Path, first_bad: usize) -> Problem {
    let name = path.display();
    let message = format!("{name} is not UTF-8 text (first bad byte at offset {first_bad})");
    Problem::new("not-text", message)
        .remedy("save the file as UTF-8, or check that it is the file you mean")
}

/// Opens a file for reading. A pipe, a socket or a device is refused: opening it may wait for a writer for ever, and reading it
/// need not end.
///
/// # Errors
/// `cannot-read`.
pub fn open_file(path: &Path) -> Result<File, Problem> {
    let cannot = |error: std::io::Error| Problem::cannot_read(path, &error);
    let metadata = std::fs::metadata(path).map_err(cannot)?;
    if metadata.is_dir() {
        return Err(cannot(std::io::ErrorKind::IsADirectory.into()));
    }
    if !metadata.is_file() {
        let message = format!(
            "{} cannot be read: it is a device or a pipe, not a file",
            path.display()
        );
        return Err(Problem::new("cannot-read", message)
            .remedy("write what it gives into a file, and name that file"));
    }
    File::open(path).map_err(cannot)
}

/// The bytes of a file. Devices and pipes are refused, since they may have no end, and so is a file that has more than `most`
/// bytes, before they are read.
pub fn read_file(path: &Path, most: u64) -> Result<Vec<u8>, Problem> {
    use std::io::Read;
    let cannot = |error: std::io::Error| Problem::cannot_read(path, &error);
    let metadata = std::fs::metadata(path).map_err(cannot)?;
    let mut bytes = Vec::new();
    let file = open_file(path)?;
    if metadata.len() <= most {
        // It may grow while it is read.
        file.take(most + 1)
            .read_to_end(&mut bytes)
            .map_err(cannot)?;
    }
    match metadata.len() > most || bytes.len() as u64 > most {
        true => Err(too_large(&path.display().to_string(), most)),
        false => Ok(bytes),
    }
}

/// A text that is longer than what people write.
pub fn too_large(name: &str, most: u64) -> Problem {
    let message = format!("{name} has more than {} MiB", most >> 20);
    Problem::new("file-too-large", message)
        .remedy("check that it is the file you mean: texts that people write are smaller")
}

/// Writes a file whole, or through what must not be replaced: a device, a pipe, what stands for an open file.
///
/// # Errors
/// `cannot-write`.
pub fn write_whole_or_through(path: &Path, bytes: &[u8]) -> Result<(), Problem> {
    let is_device = path.starts_with("/dev") || path.starts_with("/proc");
    match std::fs::metadata(path) {
        Ok(known) if is_device || !known.is_file() => {
            std::fs::write(path, bytes).map_err(|error| Problem::cannot_write(path, &error))
        }
        _ => write_whole(path, bytes),
    }
}

/// Writes a file whole or not at all: a new file beside it, whose content has reached the disk, is renamed. A link of its
/// name that somebody laid there is replaced, not followed.
pub fn write_whole(path: &Path, content: &[u8]) -> Result<(), Problem> {
    write_whole_by(path, |mut file| {
        let written = file.write_all(content);
        written.map_err(|error| Problem::cannot_write(path, &error))?;
        Ok(file)
    })
}

/// Writes a file whole or not at all that only its user may read and write; its folder, if it is made, only the user may enter.
///
/// # Errors
/// `cannot-write`.
pub fn write_private(path: &Path, content: &[u8]) -> Result<(), Problem> {
    let fail = |error: std::io::Error| Problem::cannot_write(path, &error);
    if let Some(folder) = path.parent() {
        crate::system::make_private_folder(folder).map_err(fail)?;
    }
    write_whole_by(path, |mut file| {
        // Before anything is in it.
        let written = crate::system::keep_private(&file).and_then(|()| file.write_all(content));
        written.map_err(fail)?;
        Ok(file)
    })
}

/// The same of a content that is not held in memory: `write` is given the new file and hands it back when all is written.
pub fn write_whole_by(
    path: &Path,
    write: impl FnOnce(File) -> Result<File, Problem>,
) -> Result<(), Problem> {
    let fail = |error: std::io::Error| Problem::cannot_write(path, &error);
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(fail)?;
    }
    let partial: PathBuf = path.with_extension("partial");
    let written = new_file(&partial).map_err(fail).and_then(write);
    let written = written.and_then(|file| {
        let kept = file.sync_data();
        kept.and_then(|()| std::fs::rename(&partial, path))
            .map_err(fail)
    });
    written.inspect_err(|_| {
        let _ = std::fs::remove_file(&partial);
    })
}

/// A file that was not there; what an interrupted run left of its name goes first.
fn new_file(path: &Path) -> std::io::Result<File> {
    match std::fs::remove_file(path) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => return Err(error),
        _ => {}
    }
    OpenOptions::new().write(true).create_new(true).open(path)
}

/// What keeps other processes and threads from the same work, for as long as it lives. The system releases it when the
/// process ends, however it ends.
#[derive(Debug)]
pub struct Lock {
    /// What is locked; closed behind the removal of its name.
    _file: File,
    path: PathBuf,
}

/// How often a lock's file may be taken away by who held it, before it counts as held.
const LOCK_TRIES: usize = 100;

impl Lock {
    /// Takes the lock of this file, which is made and, on Unix, removed again; `held` is the error while another one has it.
    /// Where no file can be made, since the folder is not there or is read-only, there is no lock, and nothing to keep others from.
    ///
    /// # Errors
    /// `held`; `cannot-write` if the file system has no locks.
    pub fn take(path: &Path, held: impl FnOnce() -> Problem) -> Result<Option<Self>, Problem> {
        not_through_a_link(path)?;
        for _ in 0..LOCK_TRIES {
            let mut options = File::options();
            let file = match options.create(true).truncate(false).write(true).open(path) {
                Ok(file) => file,
                Err(error)
                    if [
                        ErrorKind::NotFound,
                        ErrorKind::NotADirectory,
                        ErrorKind::PermissionDenied,
                        ErrorKind::ReadOnlyFilesystem,
                    ]
                    .contains(&error.kind()) =>
                {
                    return Ok(None);
                }
                Err(error) => return Err(Problem::cannot_write(path, &error)),
            };
            match file.try_lock() {
                // Who held it may have removed its name in between: then others lock another file.
                Ok(()) if is_named(&file, path) => {
                    return Ok(Some(Self {
                        _file: file,
                        path: path.to_owned(),
                    }));
                }
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => break,
                Err(TryLockError::Error(error)) => {
                    return Err(Problem::cannot_write(path, &error));
                }
            }
        }
        Err(held())
    }
}

/// Fails if a path that is to be opened for writing is a link, which somebody else may have laid.
///
/// # Errors
/// `cannot-write`.
pub fn not_through_a_link(path: &Path) -> Result<(), Problem> {
    match path.is_symlink() {
        false => Ok(()),
        true => {
            let message = format!(
                "{} is a link, and nothing is written through it",
                path.display()
            );
            Err(Problem::new("cannot-write", message).remedy("remove the link"))
        }
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        // Still locked here. Elsewhere it cannot be known whether the name is still this file's, and the empty file stays.
        if cfg!(unix) {
            let _ = std::fs::remove_file(&self.path);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn taken(path: &Path) -> Result<Option<Lock>, Problem> {
        Lock::take(path, || Problem::new("held", "another one has it"))
    }

    #[test]
    fn one_at_a_time_has_a_lock() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join(".lock");
        let first = taken(&path).expect("free").expect("a lock");
        assert_eq!(taken(&path).expect_err("held").code, "held");
        drop(first);
        #[cfg(unix)]
        assert!(!path.exists());
        // What a process that was killed has left is not held.
        std::fs::write(&path, "").expect("written");
        assert!(taken(&path).expect("free").is_some());
        assert!(
            taken(&folder.path().join("no/.lock"))
                .expect("no folder")
                .is_none()
        );
    }

    /// Each reads a number and writes one more: with a lock none is lost.
    #[test]
    fn threads_that_wait_for_a_lock_lose_nothing() {
        const THREADS: usize = 4;
        const EACH: usize = 50;
        let folder = tempfile::tempdir().expect("a folder");
        let (lock, number) = (folder.path().join(".lock"), folder.path().join("number"));
        std::fs::write(&number, "0").expect("written");
        let one_more = || {
            let text = std::fs::read_to_string(&number).expect("there");
            let known: usize = text.parse().expect("a number");
            std::thread::yield_now();
            std::fs::write(&number, (known + 1).to_string()).expect("written");
        };
        std::thread::scope(|scope| {
            for _ in 0..THREADS {
                scope.spawn(|| {
                    for _ in 0..EACH {
                        let _lock = loop {
                            match taken(&lock) {
                                Ok(lock) => break lock.expect("a folder"),
                                Err(_) => std::thread::yield_now(),
                            }
                        };
                        one_more();
                    }
                });
            }
        });
        let text = std::fs::read_to_string(&number).expect("there");
        assert_eq!(text, (THREADS * EACH).to_string());
    }

    #[test]
    fn latin_1_is_read_with_a_warning_at_the_first_byte_that_shows_it() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("m.nm");
        std::fs::write(&path, b"dtmc\n// \xA0 caf\xE9\nmodule m\n").expect("a file");
        let (source, warning) = read_prism(&path).expect("it is text");
        assert_eq!(source.text, "dtmc\n// \u{a0} caf\u{e9}\nmodule m\n");
        let line = warning.expect("a warning").warning_line();
        assert!(line.contains("m.nm:2:4: "), "{line}");
        assert!(line.contains("0xA0"), "{line}");
        // The strict reading of other files refuses it, and so are files that are no text.
        assert_eq!(read_source(&path).expect_err("not UTF-8").code, "not-text");
        std::fs::write(&path, b"\xFF\xFEd\0t\0m\0c\0").expect("a file");
        assert_eq!(read_prism(&path).expect_err("UTF-16").code, "not-text");
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn devices_and_large_files_are_refused_unread() {
        let device = read_source(Path::new("/dev/zero")).expect_err("a device");
        assert_eq!(device.code, "cannot-read");
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("large");
        let file = std::fs::File::create(&path).expect("a file");
        file.set_len(1 << 40).expect("a hole");
        let large = read_source(&path).expect_err("too large");
        assert_eq!(large.code, "file-too-large");
    }

    #[test]
    #[cfg(unix)]
    fn a_link_is_replaced_and_what_it_names_stays() {
        let folder = tempfile::tempdir().expect("a folder");
        let (kept, target) = (folder.path().join("kept"), folder.path().join("a.json"));
        std::fs::write(&kept, "theirs").expect("a file");
        for name in ["a.partial", "a.json"] {
            std::os::unix::fs::symlink(&kept, folder.path().join(name)).expect("a link");
        }
        write_whole(&target, b"ours").expect("written");
        assert_eq!(std::fs::read(&kept).expect("there"), b"theirs");
        assert_eq!(std::fs::read(&target).expect("there"), b"ours");
        assert!(!target.is_symlink());
        assert!(!folder.path().join("a.partial").exists());
    }

    #[test]
    fn what_is_made_of_a_text_keeps_its_line_ends() {
        for (made_of, text, expected) in [
            ("a\r\nb\r\n", "a\r\nnew\nb\r\n", "a\r\nnew\r\nb\r\n"),
            ("a\nb\n", "a\nnew\r\nb\n", "a\nnew\r\nb\n"),
            ("a\r\nb\n", "a\r\nnew\nb\n", "a\r\nnew\nb\n"),
            ("one line", "a\nb", "a\nb"),
        ] {
            assert_eq!(with_line_ends_of(text, made_of), expected, "{made_of:?}");
            let folder = tempfile::tempdir().expect("a folder");
            let path = folder.path().join("m.prism");
            std::fs::write(&path, made_of).expect("written");
            write_prism(&folder.path().join("n.prism"), text, &path).expect("written");
            write_text(&path, text, &path).expect("written");
            for name in ["m.prism", "n.prism"] {
                let bytes = std::fs::read(folder.path().join(name)).expect("read");
                assert_eq!(bytes, expected.as_bytes(), "{name}");
            }
        }
    }

    #[test]
    fn what_is_made_of_a_text_in_latin1_keeps_its_bytes() {
        let folder = tempfile::tempdir().expect("a folder");
        let (old, new) = (
            folder.path().join("old.prism"),
            folder.path().join("new.prism"),
        );
        std::fs::write(&old, b"// caf\xe9\nconst p = 1;\n").expect("written");
        let (source, _) = read_prism(&old).expect("it is text");
        let text = source.text.replace("p = 1", "p = 2");
        write_prism(&new, &text, &old).expect("written");
        let bytes = std::fs::read(&new).expect("read");
        assert_eq!(bytes, b"// caf\xe9\nconst p = 2;\n");
        let beyond = write_prism(&new, "// \u{2265}", &old).expect_err("not in Latin-1");
        assert_eq!(beyond.code, "not-latin1");
        assert_eq!(
            std::fs::read(&new).expect("read"),
            bytes,
            "nothing is written"
        );
        write_prism(&old, "// \u{e9}\n", &new).expect("written");
        assert_eq!(std::fs::read(&old).expect("read"), b"// \xe9\n");
    }
}
