//! `metadata.yaml`: which files a rosbag2 recording consists of, and how they are compressed.

use std::collections::BTreeMap;
use std::fmt;

use saphyr_parser::{Event, Parser, ScanError};

/// What the metadata say.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Metadata {
    /// `sqlite3` or `mcap`.
    pub(crate) storage: String,
    /// The files in the order of recording, without folders.
    pub(crate) files: Vec<String>,
    /// How many messages each file has, where told.
    pub(crate) counts: BTreeMap<String, u64>,
    /// How many messages each topic has, where told.
    pub(crate) topic_counts: BTreeMap<String, u64>,
    /// For example `zstd`; empty if nothing is compressed.
    pub(crate) compression: String,
    /// Whether the files are compressed as wholes (otherwise, each message).
    pub(crate) files_are_compressed: bool,
    /// What the recorder's user noted, and the release of ROS.
    pub(crate) notes: BTreeMap<String, String>,
}

/// Why the metadata cannot be used.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct MetadataError {
    /// The line, from 1; 0 if something is absent.
    pub(crate) line: usize,
    pub(crate) message: String,
}

impl fmt::Display for MetadataError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.line {
            0 => out.write_str(&self.message),
            line => write!(out, "line {line}: {}", self.message),
        }
    }
}

impl Metadata {
    /// Reads the text of `metadata.yaml`.
    pub(crate) fn parse(text: &str) -> Result<Self, MetadataError> {
        let document = Node::parse(text)?;
        let absent = |key: &str| MetadataError {
            line: 0,
            message: format!("\"{key}\" is absent"),
        };
        let root = document
            .get("rosbag2_bagfile_information")
            .ok_or_else(|| absent("rosbag2_bagfile_information"))?;
        let storage = root
            .text("storage_identifier")
            .ok_or_else(|| absent("storage_identifier"))?;
        let paths = root
            .get("relative_file_paths")
            .map(Node::items)
            .unwrap_or_default();
        let files: Vec<String> = paths
            .iter()
            .filter_map(|path| file_name(path.scalar()?))
            .collect();
        if files.is_empty() || files.len() != paths.len() {
            return Err(absent("relative_file_paths"));
        }
        let mode = root.text("compression_mode").unwrap_or_default();
        let mut metadata = Metadata {
            storage: storage.to_owned(),
            files,
            compression: root
                .text("compression_format")
                .unwrap_or_default()
                .to_owned(),
            files_are_compressed: mode.eq_ignore_ascii_case("file"),
            ..Metadata::default()
        };
        if mode.is_empty() || mode.eq_ignore_ascii_case("none") {
            metadata.compression.clear();
        }
        metadata.read_counts(root);
        metadata.read_notes(root);
        Ok(metadata)
    }

    fn read_counts(&mut self, root: &Node) {
        for file in root.get("files").map(Node::items).unwrap_or_default() {
            let name = file.text("path").and_then(file_name);
            let count = file
                .text("message_count")
                .and_then(|count| count.parse().ok());
            if let (Some(name), Some(count)) = (name, count) {
                self.counts.insert(name, count);
            }
        }
        for topic in root
            .get("topics_with_message_count")
            .map(Node::items)
            .unwrap_or_default()
        {
            let name = topic
                .get("topic_metadata")
                .and_then(|topic| topic.text("name"));
            let count = topic
                .text("message_count")
                .and_then(|count| count.parse::<u64>().ok());
            if let (Some(name), Some(count)) = (name, count) {
                let total = self.topic_counts.entry(name.to_owned()).or_default();
                *total = total.saturating_add(count);
            }
        }
        let total = root
            .text("message_count")
            .and_then(|count| count.parse().ok());
        if let ([only], Some(total)) = (&self.files[..], total) {
            self.counts.entry(only.clone()).or_insert(total);
        }
    }

    fn read_notes(&mut self, root: &Node) {
        if let Some(distro) = root.text("ros_distro").filter(|distro| !distro.is_empty()) {
            self.notes
                .insert("ros_distro".to_owned(), distro.to_owned());
        }
        if let Some(Node::Mapping(pairs)) = root.get("custom_data") {
            for (key, value) in pairs {
                let value = value.scalar().unwrap_or_default();
                self.notes.insert(key.clone(), value.to_owned());
            }
        }
    }
}

/// The last part of a path; older recorders wrote the folder too. A file is never sought elsewhere.
fn file_name(path: &str) -> Option<String> {
    let name = path.rsplit(['/', '\\']).next()?;
    (!matches!(name, "" | "." | "..")).then(|| name.to_owned())
}

/// Deeper than any metadata.
const MAX_DEPTH: usize = 32;

/// A piece of YAML. Aliases are refused: metadata have none, and they can blow up.
enum Node {
    Scalar(String),
    Sequence(Vec<Node>),
    Mapping(Vec<(String, Node)>),
}

impl Node {
    fn parse(text: &str) -> Result<Self, MetadataError> {
        let mut parser = Parser::new_from_str(text);
        loop {
            match next(&mut parser)? {
                (Event::StreamStart | Event::DocumentStart(_) | Event::Nothing, _) => {}
                (event, line) => return Node::of_event(event, line, &mut parser, 0),
            }
        }
    }

    fn of_event<'a>(
        event: Event<'a>,
        line: usize,
        parser: &mut Parser<'a, saphyr_parser::StrInput<'a>>,
        depth: usize,
    ) -> Result<Self, MetadataError> {
        let error = |message: &str| MetadataError {
            line,
            message: message.to_owned(),
        };
        if depth > MAX_DEPTH {
            return Err(error("it is nested too deeply"));
        }
        match event {
            Event::Scalar(text, ..) => Ok(Node::Scalar(text.into_owned())),
            Event::SequenceStart(..) => {
                let mut items = Vec::new();
                loop {
                    match next(parser)? {
                        (Event::SequenceEnd, _) => return Ok(Node::Sequence(items)),
                        (event, line) => {
                            items.push(Node::of_event(event, line, parser, depth + 1)?)
                        }
                    }
                }
            }
            Event::MappingStart(..) => {
                let mut pairs = Vec::new();
                loop {
                    let key = match next(parser)? {
                        (Event::MappingEnd, _) => return Ok(Node::Mapping(pairs)),
                        (Event::Scalar(key, ..), _) => key.into_owned(),
                        _ => return Err(error("a key is not a text")),
                    };
                    let (event, line) = next(parser)?;
                    pairs.push((key, Node::of_event(event, line, parser, depth + 1)?));
                }
            }
            Event::Alias(_) => Err(error("aliases are not supported")),
            _ => Err(error("it is empty")),
        }
    }

    fn get(&self, key: &str) -> Option<&Node> {
        match self {
            Node::Mapping(pairs) => pairs
                .iter()
                .find(|(other, _)| other == key)
                .map(|(_, node)| node),
            _ => None,
        }
    }

    fn items(&self) -> &[Node] {
        match self {
            Node::Sequence(items) => items,
            _ => &[],
        }
    }

    fn scalar(&self) -> Option<&str> {
        match self {
            Node::Scalar(text) => Some(text),
            _ => None,
        }
    }

    fn text(&self, key: &str) -> Option<&str> {
        self.get(key)?.scalar()
    }
}

/// The next event and its line.
fn next<'a>(
    parser: &mut Parser<'a, saphyr_parser::StrInput<'a>>,
) -> Result<(Event<'a>, usize), MetadataError> {
    match parser.next_event() {
        Some(Ok((event, span))) => Ok((event, span.start.line())),
        Some(Err(error)) => Err(of_scanner(&error)),
        None => Err(MetadataError {
            line: 0,
            message: "it is empty".to_owned(),
        }),
    }
}

fn of_scanner(error: &ScanError) -> MetadataError {
    MetadataError {
        line: error.marker().line(),
        message: error.info().to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_counts_compression_and_notes_are_read() {
        let text = "rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: sqlite3\n  \
                    relative_file_paths:\n    - run/run_0.db3.zstd\n    - ../run_1.db3.zstd\n  \
                    message_count: 12\n  compression_format: zstd\n  compression_mode: FILE\n  \
                    files:\n    - path: run_0.db3\n      message_count: 7\n  custom_data: {who: me}\n  \
                    ros_distro: iron\n";
        let metadata = Metadata::parse(text).unwrap();
        assert_eq!(metadata.files, ["run_0.db3.zstd", "run_1.db3.zstd"]);
        assert_eq!(
            metadata.counts,
            BTreeMap::from([("run_0.db3".to_owned(), 7)])
        );
        assert!(metadata.files_are_compressed && metadata.compression == "zstd");
        assert_eq!(metadata.notes["who"], "me");
        assert_eq!(metadata.notes["ros_distro"], "iron");
    }

    #[test]
    fn what_is_no_metadata_is_refused_with_its_line() {
        let message = |text: &str| Metadata::parse(text).unwrap_err().to_string();
        assert!(message("").contains("empty"));
        assert!(message("a: 1\n").contains("\"rosbag2_bagfile_information\" is absent"));
        assert!(message("a: &x [1]\nb: *x\n").starts_with("line 2: aliases"));
        assert!(message("a: [1\nb: ]: 2\n").starts_with("line 2"));
        let files = "rosbag2_bagfile_information:\n  storage_identifier: mcap\n  relative_file_paths: [..]\n";
        assert!(message(files).contains("relative_file_paths"));
        let deep = "[".repeat(5_000);
        assert!(Metadata::parse(&deep).is_err());
    }
}
