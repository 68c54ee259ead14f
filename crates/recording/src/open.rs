//! Which format a file is in, and its reader.
//!
//! A format is known by its first bytes; tables and lines, which have none of their own, by the
//! ending of their name.

use std::fs::{self, File};
use std::io::{self, BufReader, Cursor, Read};
use std::path::Path;

use crate::csv_rows::CsvReader;
use crate::json_lines::JsonLinesReader;
use crate::reader::{OpenOptions, ReadError, ReadProblem, Reader};
use crate::ros1_bag::{self, RosBagReader};
use crate::rosbag2;

/// The format of a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// MCAP.
    Mcap,
    /// A ROS 1 bag.
    Ros1Bag,
    /// A SQLite file of a rosbag2 recording.
    Rosbag2Database,
    /// A folder that rosbag2 recorded.
    Rosbag2Folder,
    /// A file of a rosbag2 recording that is compressed as a whole.
    Compressed,
    /// A table in CSV.
    Csv,
    /// A JSON object on each line.
    JsonLines,
}

/// The first bytes of an MCAP file.
const MCAP_MAGIC: [u8; 8] = *b"\x89MCAP0\r\n";

/// The first bytes of what zstd compressed.
const ZSTD_MAGIC: [u8; 4] = [0x28, 0xb5, 0x2f, 0xfd];

/// The most bytes that tell a format.
const MAGIC_BYTES: u64 = 16;

/// Opens a file for reading. A pipe, a socket or a device is refused: opening it may wait for a writer for ever, and reading need not
/// end.
pub(crate) fn open_file(path: &Path) -> io::Result<File> {
    match fs::metadata(path)?.is_file() {
        true => File::open(path),
        false => Err(io::Error::new(
            io::ErrorKind::InvalidInput,
            "it is a pipe, a socket or a device, not a file",
        )),
    }
}

/// Finds the format of the recording at `path`.
///
/// # Errors
/// [`ReadError`] if it cannot be read, or is in no known format.
pub fn detect(path: &Path) -> Result<Format, ReadError> {
    let of_file = |error: ReadError| error.in_file(path);
    let found = fs::metadata(path).map_err(|error| of_file(error.into()))?;
    if found.is_dir() {
        return match rosbag2::is_recording(path).map_err(|error| of_file(error.into()))? {
            true => Ok(Format::Rosbag2Folder),
            false => Err(of_file(
                ReadProblem::Malformed(NO_BAG_FOLDER.to_owned()).into(),
            )),
        };
    }
    let mut first = Vec::new();
    let file = open_file(path).map_err(|error| of_file(error.into()))?;
    file.take(MAGIC_BYTES)
        .read_to_end(&mut first)
        .map_err(|error| of_file(error.into()))?;
    let ending = path
        .extension()
        .map(|ending| ending.to_string_lossy().to_ascii_lowercase());
    let ending = ending.unwrap_or_default();
    match of_magic(&first).or_else(|| of_ending(&ending)) {
        // A database that was never copied out of its log is empty.
        Some(format) if !first.is_empty() || format == Format::Rosbag2Database => Ok(format),
        _ if first.is_empty() => Err(of_file(ReadProblem::Empty.into())),
        _ if first.trim_ascii_start().starts_with(b"{") => Ok(Format::JsonLines),
        _ => Err(of_file(ReadProblem::UnknownFormat.into())),
    }
}

const NO_BAG_FOLDER: &str =
    "it is a folder, but not one that rosbag2 recorded; give one of the recordings in it";

fn of_magic(first: &[u8]) -> Option<Format> {
    let formats: [(&[u8], Format); 4] = [
        (&MCAP_MAGIC, Format::Mcap),
        (ros1_bag::MAGIC_OF_ANY_VERSION, Format::Ros1Bag),
        (rosbag2::database::MAGIC, Format::Rosbag2Database),
        (&ZSTD_MAGIC, Format::Compressed),
    ];
    let found = formats
        .into_iter()
        .find(|(magic, _)| first.starts_with(magic));
    found.map(|(_, format)| format)
}

fn of_ending(ending: &str) -> Option<Format> {
    match ending {
        "csv" | "tsv" => Some(Format::Csv),
        "jsonl" | "ndjson" => Some(Format::JsonLines),
        // Damaged at the beginning: their readers say what is wrong.
        "mcap" => Some(Format::Mcap),
        "bag" => Some(Format::Ros1Bag),
        "db3" => Some(Format::Rosbag2Database),
        _ => None,
    }
}

/// Opens the recording at `path`, whatever its format: MCAP, a ROS 1 bag, a rosbag2 folder or one of
/// its files, a table in CSV, JSON lines.
///
/// ```
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("run.csv");
/// std::fs::write(&path, "time_secs,/robot.speed [m/s]\n0.0,0.25\n0.5,0.5\n")?;
///
/// let mut reader = recording::open(&path, &recording::OpenOptions::default())?;
/// assert_eq!(reader.topics()[0].name, "/robot");
/// let mut times_nanos = Vec::new();
/// while let Some(message) = reader.next()? {
///     times_nanos.push(message.log_nanos);
/// }
/// assert_eq!(times_nanos, [0, 500_000_000]);
/// assert!(reader.complete());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`ReadError`] if it cannot be read, or is in no known format.
pub fn open(path: &Path, options: &OpenOptions) -> Result<Box<dyn Reader + Send>, ReadError> {
    let of_file = |error: ReadError| error.in_file(path);
    let format = detect(path)?;
    if format == Format::Rosbag2Folder {
        return rosbag2::open_folder(path, options);
    }
    let file = || open_file(path);
    let opened = || -> Result<Box<dyn Reader + Send>, ReadError> {
        Ok(match format {
            Format::Mcap => rosbag2::open_mcap(BufReader::new(file()?), options)?,
            Format::Ros1Bag => Box::new(RosBagReader::new(BufReader::new(file()?), options)?),
            Format::Rosbag2Database => rosbag2::open_database(path, options)?,
            Format::Rosbag2Folder => rosbag2::open_folder(path, options)?,
            Format::Compressed => rosbag2::open_compressed(BufReader::new(file()?), options)?,
            Format::Csv => Box::new(CsvReader::new(file()?, options)?),
            Format::JsonLines => Box::new(JsonLinesReader::new(BufReader::new(file()?), options)?),
        })
    };
    opened().map_err(of_file)
}

/// Reads a recording that is in memory.
///
/// ```
/// let lines = br#"{"topic": "/robot", "time_ms": 250, "speed": 0.1}"#.to_vec();
/// let format = recording::Format::JsonLines;
/// let mut reader = recording::open_bytes(lines, format, &recording::OpenOptions::default())?;
/// let message = reader.next()?.ok_or("there is one message")?;
/// assert_eq!(message.log_nanos, 250_000_000);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`ReadError`] if it is not in that format. A folder is never in memory.
pub fn open_bytes(
    bytes: Vec<u8>,
    format: Format,
    options: &OpenOptions,
) -> Result<Box<dyn Reader + Send>, ReadError> {
    let source = Cursor::new(bytes);
    Ok(match format {
        Format::Mcap => rosbag2::open_mcap(source, options)?,
        Format::Ros1Bag => Box::new(RosBagReader::new(source, options)?),
        Format::Rosbag2Database => rosbag2::open_database_source(Box::new(source), options)?,
        Format::Rosbag2Folder => {
            return Err(ReadProblem::Malformed(NO_BAG_FOLDER.to_owned()).into());
        }
        Format::Compressed => rosbag2::open_compressed(source, options)?,
        Format::Csv => Box::new(CsvReader::new(source, options)?),
        Format::JsonLines => Box::new(JsonLinesReader::new(source, options)?),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_are_known_by_content_then_by_name() {
        let folder = tempfile::tempdir().unwrap();
        let detect = |name: &str, content: &[u8]| {
            let path = folder.path().join(name);
            fs::write(&path, content).unwrap();
            detect(&path).map_err(|error| error.to_string())
        };
        assert_eq!(detect("a", b"\x89MCAP0\r\n..."), Ok(Format::Mcap));
        assert_eq!(detect("a.csv", b"#ROSBAG V2.0\n"), Ok(Format::Ros1Bag));
        assert_eq!(
            detect("a", b"SQLite format 3\0"),
            Ok(Format::Rosbag2Database)
        );
        assert_eq!(detect("a", b" {\"a\": 1}"), Ok(Format::JsonLines));
        assert_eq!(detect("a.CSV", b"x"), Ok(Format::Csv));
        assert_eq!(detect("a.mcap", b"x"), Ok(Format::Mcap));
        assert!(
            detect("a.txt", b"x")
                .unwrap_err()
                .contains("no format that is known")
        );
        assert!(detect("a.csv", b"").unwrap_err().contains("empty"));
        let error = super::detect(folder.path()).unwrap_err().to_string();
        assert!(error.contains("not one that rosbag2 recorded"), "{error}");
    }
}
