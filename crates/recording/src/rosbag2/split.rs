//! The files of a rosbag2 folder, one after another, as one recording.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io::{self, BufReader};
use std::path::{Path, PathBuf};

use super::metadata::Metadata;
use super::sqlite::pager::Source;
use super::types::Definitions;
use super::{METADATA_FILE, database, definitions, left_files, open_mcap, uncompressed, unzstd};
use crate::reader::{
    Loss, OpenOptions, RawMessage, ReadError, ReadProblem, Reader, TopicId, TopicInfo,
};
use crate::ros1_bag::loss;
use crate::storage::{Compressed, StoredFile};

/// A folder that is being read.
pub(crate) struct SplitReader {
    parts: Vec<Part>,
    current: usize,
    options: OpenOptions,
    definitions: Definitions,
    metadata: Metadata,
    topics: Vec<TopicInfo>,
    selected: Vec<bool>,
    losses: Vec<Loss>,
    /// How many losses of the current part are in `losses` already.
    taken_losses: usize,
    is_complete: bool,
    /// When the last message of the parts that were read was logged.
    end_nanos: Option<i64>,
    stored: Vec<StoredFile>,
    /// What the present message holds.
    data: Vec<u8>,
}

/// What comes next in a file.
enum PartStep {
    /// A message, whose data are kept apart.
    Message(RawMessage<'static>),
    Lost(Loss),
    End,
}

/// One file.
struct Part {
    path: PathBuf,
    /// Whether the whole file is compressed.
    is_compressed: bool,
    /// `None` until it is its turn, if it must be uncompressed for that, and after it was read.
    reader: Option<Box<dyn Reader + Send>>,
    /// The topic of this recording for each topic of the file.
    topics: Vec<TopicId>,
}

impl SplitReader {
    /// Reads the metadata and finds the topics of all files.
    pub(crate) fn open(folder: &Path, options: &OpenOptions) -> Result<Self, ReadError> {
        let (metadata, losses) = metadata_of(folder)?;
        let mut reader = SplitReader {
            parts: Vec::new(),
            current: 0,
            options: options.clone(),
            definitions: definitions(options)?,
            metadata,
            topics: Vec::new(),
            selected: Vec::new(),
            losses,
            taken_losses: 0,
            is_complete: true,
            end_nanos: None,
            stored: Vec::new(),
            data: Vec::new(),
        };
        for name in reader.metadata.files.clone() {
            reader.add_part(folder, &name)?;
        }
        if reader.parts.is_empty() {
            let message =
                "none of the files that its metadata.yaml names is there; copy the whole folder";
            let error = ReadError::from(ReadProblem::Malformed(message.to_owned()));
            return Err(error.in_file(folder));
        }
        reader.count_topics();
        reader.selected = vec![true; reader.topics.len()];
        Ok(reader)
    }

    /// Adds the file `name`, or notes that it is not there.
    fn add_part(&mut self, folder: &Path, name: &str) -> Result<(), ReadError> {
        let Some((path, is_compressed)) = find_file(folder, name, &self.metadata) else {
            let message = format!("the file {name}, which the metadata name, is not there");
            let messages = self.metadata.counts.get(name).copied();
            self.losses.push(Loss {
                messages,
                ..loss(0, message)
            });
            return Ok(());
        };
        let reader = match self.open_part(&path, is_compressed, name) {
            Ok(reader) => reader,
            // The others may be whole; if there are no others, this is what is wrong.
            Err(error) if self.metadata.files.len() > 1 => {
                self.losses
                    .push(loss(error.offset.unwrap_or(0), error.to_string()));
                return Ok(());
            }
            Err(error) => return Err(error),
        };
        let mut topics = Vec::new();
        for topic in reader.topics() {
            topics.push(self.topic_like(topic));
        }
        let is_by_message = !self.metadata.compression.is_empty()
            && !self.metadata.files_are_compressed
            && !is_compressed;
        for mut file in reader.storage() {
            file.name = name.to_owned();
            self.stored.push(match (is_compressed, is_by_message) {
                (true, _) => file.compressed_by(Compressed::File, "zstd"),
                (_, true) => file.compressed_by(Compressed::Messages, "zstd"),
                _ => file,
            });
        }
        let reader = (!is_compressed).then_some(reader);
        self.parts.push(Part {
            path,
            is_compressed,
            reader,
            topics,
        });
        Ok(())
    }

    fn open_part(
        &self,
        path: &Path,
        is_compressed: bool,
        name: &str,
    ) -> Result<Box<dyn Reader + Send>, ReadError> {
        let expected = self.metadata.counts.get(name).copied();
        let of_file = |error: ReadError| error.in_file(path);
        let bytes = match is_compressed {
            true => {
                let file = crate::open::open_file(path).map_err(|error| of_file(error.into()))?;
                Some(uncompressed(file, &self.options).map_err(of_file)?)
            }
            false => None,
        };
        match (self.metadata.storage.as_str(), bytes) {
            ("sqlite3", None) => {
                let reader = database(path, &self.options, &self.definitions, expected)?;
                Ok(Box::new(reader))
            }
            ("sqlite3", Some(bytes)) => {
                let main: Box<dyn Source> = Box::new(bytes);
                let definitions = &self.definitions;
                let reader =
                    database::DatabaseReader::new(main, None, &self.options, definitions, expected);
                Ok(Box::new(reader.map_err(of_file)?))
            }
            ("mcap", None) => {
                let file = crate::open::open_file(path).map_err(|error| of_file(error.into()))?;
                open_mcap(BufReader::new(file), &self.options).map_err(of_file)
            }
            ("mcap", Some(bytes)) => open_mcap(bytes, &self.options).map_err(of_file),
            (other, _) => {
                let message = format!(
                    "its storage \"{other}\" is not supported; convert it with \"ros2 bag convert\""
                );
                Err(of_file(ReadProblem::Malformed(message).into()))
            }
        }
    }

    /// The topic of this recording that is like `topic` of a file.
    fn topic_like(&mut self, topic: &TopicInfo) -> TopicId {
        let is_same = |other: &&TopicInfo| {
            other.name == topic.name
                && other.type_name == topic.type_name
                && other.encoding == topic.encoding
                && other.schema == topic.schema
        };
        if let Some(same) = self.topics.iter().find(is_same) {
            return same.id;
        }
        let id = TopicId(self.topics.len() as u32);
        self.topics.push(TopicInfo {
            id,
            message_count: None,
            ..topic.clone()
        });
        id
    }

    /// The metadata tell how many messages a topic has; not which, if two have the same name.
    fn count_topics(&mut self) {
        let mut seen = BTreeSet::new();
        let twice: BTreeSet<String> = self
            .topics
            .iter()
            .filter(|topic| !seen.insert(topic.name.as_str()))
            .map(|topic| topic.name.clone())
            .collect();
        for topic in &mut self.topics {
            if !twice.contains(&topic.name) {
                topic.message_count = self.metadata.topic_counts.get(&topic.name).copied();
            }
        }
    }

    /// Opens the current part if it is not, and passes on what is selected.
    fn prepare(&mut self) -> Result<(), ReadError> {
        let part = &self.parts[self.current];
        if part.reader.is_none() {
            let name = part
                .path
                .file_name()
                .unwrap_or_default()
                .to_string_lossy()
                .into_owned();
            let reader = self.open_part(&part.path, part.is_compressed, &name)?;
            self.parts[self.current].reader = Some(reader);
            self.select_in_part(self.current);
        }
        Ok(())
    }

    fn select_in_part(&mut self, index: usize) {
        let part = &mut self.parts[index];
        let (topics, selected) = (&part.topics, &self.selected);
        if let Some(reader) = &mut part.reader {
            reader.select(&|topic| {
                topics
                    .get(topic.id.index())
                    .is_none_or(|topic| selected[topic.index()])
            });
        }
    }

    /// Reads the next message of the current part, and puts what it holds into `data`.
    fn next_in_part(&mut self) -> Result<PartStep, ReadError> {
        self.prepare()?;
        self.take_losses();
        // Of the two storages, only the database uncompresses messages itself.
        let uncompresses = !self.metadata.compression.is_empty()
            && !self.metadata.files_are_compressed
            && self.metadata.storage == "mcap";
        let part = &mut self.parts[self.current];
        let Some(reader) = &mut part.reader else {
            return Ok(PartStep::End);
        };
        let found = reader.next().map_err(|error| error.in_file(&part.path))?;
        let Some(found) = found else {
            return Ok(PartStep::End);
        };
        // A part that finds topics late names them with ids that are not known here.
        let Some(&topic) = part.topics.get(found.topic.index()) else {
            let message = "a message of a topic that was found late is left out";
            return Ok(PartStep::Lost(loss(found.offset, message)));
        };
        self.data.clear();
        if !uncompresses {
            self.data.extend_from_slice(found.data);
        } else if let Err(error) = unzstd(found.data, self.options.record_bytes, &mut self.data) {
            let message = format!("a message cannot be uncompressed ({error})");
            return Ok(PartStep::Lost(Loss {
                messages: Some(1),
                ..loss(found.offset, message)
            }));
        }
        Ok(PartStep::Message(RawMessage {
            topic,
            log_nanos: found.log_nanos,
            publish_nanos: found.publish_nanos,
            data: &[],
            offset: found.offset,
        }))
    }

    /// Takes over the losses that the current part found by now.
    fn take_losses(&mut self) {
        let part = &self.parts[self.current];
        let Some(reader) = &part.reader else {
            return;
        };
        let name = part.path.file_name().unwrap_or_default().to_string_lossy();
        let is_only = self.parts.len() == 1;
        for found in &reader.losses()[self.taken_losses.min(reader.losses().len())..] {
            let mut found = found.clone();
            if !is_only {
                found.message = format!("in {name}: {}", found.message);
            }
            self.losses.push(found);
        }
        self.taken_losses = reader.losses().len();
        self.is_complete &= reader.complete();
    }
}

impl Reader for SplitReader {
    fn topics(&self) -> &[TopicInfo] {
        &self.topics
    }

    fn next(&mut self) -> Result<Option<RawMessage<'_>>, ReadError> {
        while self.current < self.parts.len() {
            match self.next_in_part() {
                Ok(PartStep::Message(found)) => {
                    let data = &self.data[..];
                    return Ok(Some(RawMessage { data, ..found }));
                }
                Ok(PartStep::Lost(found)) => self.losses.push(found),
                Ok(PartStep::End) => {
                    self.take_losses();
                    self.end_nanos = self.end_nanos();
                    self.parts[self.current].reader = None;
                    self.current += 1;
                    self.taken_losses = 0;
                }
                Err(error) => {
                    self.current = self.parts.len();
                    return Err(error);
                }
            }
        }
        Ok(None)
    }

    fn losses(&self) -> &[Loss] {
        &self.losses
    }

    fn complete(&self) -> bool {
        self.is_complete && self.losses.is_empty()
    }

    fn select(&mut self, wanted: &dyn Fn(&TopicInfo) -> bool) {
        self.selected = self.topics.iter().map(wanted).collect();
        for index in self.current..self.parts.len() {
            self.select_in_part(index);
        }
    }

    fn end_nanos(&self) -> Option<i64> {
        let parts = self.parts[self.current.min(self.parts.len())..].iter();
        let of_parts = parts.filter_map(|part| part.reader.as_ref()?.end_nanos());
        of_parts.max().max(self.end_nanos)
    }

    fn storage(&self) -> Vec<StoredFile> {
        self.stored.clone()
    }

    fn metadata(&self) -> &BTreeMap<String, String> {
        &self.metadata.notes
    }

    fn in_time_order(&self) -> bool {
        match &self.parts[..] {
            [only] => only
                .reader
                .as_ref()
                .is_some_and(|reader| reader.in_time_order()),
            _ => false,
        }
    }

    fn checked(&self) -> bool {
        let part = self.parts.get(self.current);
        part.and_then(|part| part.reader.as_ref())
            .is_some_and(|reader| reader.checked())
    }
}

/// The metadata of a folder; if the recorder did not write any, what its files tell.
fn metadata_of(folder: &Path) -> Result<(Metadata, Vec<Loss>), ReadError> {
    let path = folder.join(METADATA_FILE);
    let of_folder = |error: io::Error| ReadError::from(error).in_file(folder);
    if path.try_exists().map_err(of_folder)? {
        return Ok((read_metadata(&path)?, Vec::new()));
    }
    let files = left_files(folder).map_err(of_folder)?;
    let is_mcap = files.iter().any(|name| name.contains(".mcap"));
    let metadata = Metadata {
        storage: if is_mcap { "mcap" } else { "sqlite3" }.to_owned(),
        files_are_compressed: files.iter().any(|name| name.ends_with(".zstd")),
        files,
        ..Metadata::default()
    };
    let message = "there is no metadata.yaml, so the recorder did not finish; what it had not written \
                   yet is lost";
    Ok((metadata, vec![loss(0, message)]))
}

fn read_metadata(path: &Path) -> Result<Metadata, ReadError> {
    let of_file = |error: ReadError| error.in_file(path);
    let text = fs::read_to_string(path).map_err(|error| of_file(error.into()))?;
    let metadata = Metadata::parse(&text).map_err(|error| {
        let message = format!("{error}; write it anew with \"ros2 bag reindex\"");
        of_file(ReadProblem::Malformed(message).into())
    })?;
    if !matches!(metadata.compression.as_str(), "" | "zstd") {
        let message = format!(
            "its compression \"{}\" is not supported; convert it with \"ros2 bag convert\"",
            metadata.compression
        );
        return Err(of_file(ReadProblem::Malformed(message).into()));
    }
    Ok(metadata)
}

/// Where the file `name` is, and whether it is compressed. The metadata of some recorders lack the
/// ending of the compression, and a user may have uncompressed the file.
fn find_file(folder: &Path, name: &str, metadata: &Metadata) -> Option<(PathBuf, bool)> {
    let is_file = |path: &PathBuf| matches!(fs::metadata(path), Ok(found) if found.is_file());
    let path = folder.join(name);
    if is_file(&path) {
        let is_zstd = path
            .extension()
            .is_some_and(|ending| ending == "zstd" || ending == "zst");
        return Some((path, is_zstd));
    }
    let compressed = folder.join(format!("{name}.zstd"));
    if metadata.files_are_compressed && is_file(&compressed) {
        return Some((compressed, true));
    }
    let plain = folder.join(name.strip_suffix(".zstd")?);
    is_file(&plain).then_some((plain, false))
}
