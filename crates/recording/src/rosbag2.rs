//! rosbag2: a folder with `metadata.yaml` and one or more files in SQLite or MCAP, or one such file.
//!
//! | part | file |
//! |---|---|
//! | the folder: which files, in which order, how compressed | [`metadata`], [`split`] |
//! | one SQLite file | [`database`](mod@database), on the tables that [`sqlite`] reads |
//! | types that the recording does not define | [`types`] |
//!
//! MCAP files are read as any other MCAP file. Compressed files (`.db3.zstd`) are uncompressed into
//! memory, one after another, up to [`OpenOptions::record_bytes`] each, because a database is read at
//! many places; larger ones are refused with the command that uncompresses them.
//!
//! Source: the recorder's documentation and its design article ("ROS 2 bags", K. Fritz et al.).
//! Guarantee: files come in the order that the metadata give, the rows of a SQLite file in that of
//! recording. Metadata are written last; without them, the files that have the name of the folder and a
//! number are read in the order of their numbers. A file that the metadata name but that is not there is a [`Loss`](crate::Loss), as are
//! messages that the metadata count but the file does not have.

pub(crate) mod database;
pub(crate) mod metadata;
pub(crate) mod split;
pub(crate) mod sqlite;
pub(crate) mod types;

use std::io::{self, Cursor, Read, Seek};
use std::path::{Path, PathBuf};

use crate::mcap::McapReader;
use crate::reader::{OpenOptions, ReadError, ReadProblem, Reader};
use crate::trials::natural_order;
use database::DatabaseReader;
use sqlite::pager::Source;
use types::Definitions;

/// Opens a database file, with its write-ahead log if that lies beside it.
///
/// # Errors
/// [`ReadError`] if it cannot be read, or needs its recorder to repair it.
pub(crate) fn open_database(
    path: &Path,
    options: &OpenOptions,
) -> Result<Box<dyn Reader + Send>, ReadError> {
    let definitions = definitions(options)?;
    let reader = database(path, options, &definitions, None)?;
    Ok(Box::new(reader))
}

/// Opens a folder with `metadata.yaml`.
///
/// # Errors
/// [`ReadError`] if the metadata or all of the files cannot be read.
pub(crate) fn open_folder(
    folder: &Path,
    options: &OpenOptions,
) -> Result<Box<dyn Reader + Send>, ReadError> {
    let reader = split::SplitReader::open(folder, options)?;
    Ok(Box::new(reader))
}

/// Reads a database that has no write-ahead log.
///
/// # Errors
/// [`ReadError`] if it is no database of a recording.
pub(crate) fn open_database_source(
    main: Box<dyn Source>,
    options: &OpenOptions,
) -> Result<Box<dyn Reader + Send>, ReadError> {
    let reader = DatabaseReader::new(main, None, options, &definitions(options)?, None)?;
    Ok(Box::new(reader))
}

/// Reads what is compressed as a whole.
///
/// # Errors
/// [`ReadError`] if it cannot be uncompressed or is no file of a recording.
pub(crate) fn open_compressed(
    compressed: impl Read,
    options: &OpenOptions,
) -> Result<Box<dyn Reader + Send>, ReadError> {
    let bytes = uncompressed(compressed, options)?;
    if bytes.get_ref().starts_with(database::MAGIC) {
        return open_database_source(Box::new(bytes), options);
    }
    open_mcap(bytes, options)
}

/// Opens a file in MCAP.
///
/// # Errors
/// [`ReadError`] if it cannot be read.
pub(crate) fn open_mcap(
    source: impl Read + Seek + Send + 'static,
    options: &OpenOptions,
) -> Result<Box<dyn Reader + Send>, ReadError> {
    Ok(Box::new(McapReader::new(source, options)?))
}

/// The name of the file that tells which others a recording has.
const METADATA_FILE: &str = "metadata.yaml";

/// Whether rosbag2 recorded the folder.
///
/// # Errors
/// What the operating system says.
pub(crate) fn is_recording(folder: &Path) -> io::Result<bool> {
    Ok(folder.join(METADATA_FILE).try_exists()? || !left_files(folder)?.is_empty())
}

/// The files of a folder without metadata, as a recorder leaves it that was killed: they have the
/// name of the folder and a number each, and are all of one kind.
fn left_files(folder: &Path) -> io::Result<Vec<String>> {
    let folder_name = folder
        .file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned();
    let is_part = |name: &str| {
        let rest = name
            .strip_prefix(&folder_name)
            .and_then(|rest| rest.strip_prefix('_'));
        let split = rest.and_then(|rest| rest.split_once('.'));
        split.is_some_and(|(number, ending)| {
            !number.is_empty()
                && number.bytes().all(|byte| byte.is_ascii_digit())
                && matches!(ending, "db3" | "mcap" | "db3.zstd" | "mcap.zstd")
        })
    };
    let mut names = Vec::new();
    for entry in std::fs::read_dir(folder)? {
        let name = entry?.file_name().to_string_lossy().into_owned();
        if is_part(&name) {
            names.push(name);
        }
    }
    names.sort_by(|a, b| natural_order(a, b));
    let kind = |name: &String| name.contains(".mcap");
    let is_mixed = names.iter().any(|name| kind(name) != kind(&names[0]));
    Ok(if is_mixed { Vec::new() } else { names })
}

fn database(
    path: &Path,
    options: &OpenOptions,
    definitions: &Definitions,
    expected: Option<u64>,
) -> Result<DatabaseReader, ReadError> {
    let of_file = |error: io::Error| ReadError::from(error).in_file(path);
    let main: Box<dyn Source> = Box::new(crate::open::open_file(path).map_err(of_file)?);
    refuse_journal(path)?;
    let wal = match crate::open::open_file(&beside(path, "-wal")) {
        Ok(file) => Some(Box::new(file) as Box<dyn Source>),
        Err(error) if error.kind() == io::ErrorKind::NotFound => None,
        Err(error) => return Err(of_file(error)),
    };
    DatabaseReader::new(main, wal, options, definitions, expected)
        .map_err(|error| error.in_file(path))
}

/// A journal that was not deleted holds the pages as they were before a transaction that was not
/// finished. Only the library can tell whether to go back to them.
fn refuse_journal(path: &Path) -> Result<(), ReadError> {
    const JOURNAL_MAGIC: [u8; 8] = [0xd9, 0xd5, 0x05, 0xf9, 0x20, 0xa1, 0x63, 0xd7];
    let mut first = [0; 8];
    let journal = beside(path, "-journal");
    let read = crate::open::open_file(&journal).and_then(|mut file| file.read_exact(&mut first));
    if read.is_err() || first != JOURNAL_MAGIC {
        return Ok(());
    }
    let message = format!(
        "the recorder is still writing to it or was stopped within a transaction, since {} is there; \
         close the recorder, or let \"sqlite3 {} .tables\" roll the transaction back",
        journal.display(),
        path.display()
    );
    Err(ReadError::from(ReadProblem::Malformed(message)).in_file(path))
}

/// The path with `suffix` behind its name.
fn beside(path: &Path, suffix: &str) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(suffix);
    PathBuf::from(name)
}

fn definitions(options: &OpenOptions) -> Result<Definitions, ReadError> {
    Definitions::with_folders(&options.message_path)
        .map_err(|(path, error)| ReadError::from(error).in_file(&path))
}

/// A file that was compressed as a whole, uncompressed into memory.
fn uncompressed(
    compressed: impl Read,
    options: &OpenOptions,
) -> Result<Cursor<Vec<u8>>, ReadError> {
    let mut bytes = Vec::new();
    unzstd(compressed, options.record_bytes, &mut bytes).map_err(|error| {
        let message = format!(
            "it cannot be uncompressed ({error}); try \"zstd -d\" on it and read the result"
        );
        ReadError::from(ReadProblem::Malformed(message))
    })?;
    Ok(Cursor::new(bytes))
}

/// Uncompresses `compressed`, at most `limit` bytes, so that memory follows what is there.
fn unzstd(compressed: impl Read, limit: u64, out: &mut Vec<u8>) -> io::Result<()> {
    let decoder = zstd::stream::read::Decoder::new(compressed)?;
    decoder.take(limit.saturating_add(1)).read_to_end(out)?;
    if out.len() as u64 > limit {
        return Err(io::Error::other(format!(
            "it holds more than {limit} bytes"
        )));
    }
    Ok(())
}
