//! One SQLite file of a rosbag2 recording, from the first row of its table of messages to the last.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

use super::sqlite::pager::Source;
use super::sqlite::record::{HeaderError, locate};
use super::sqlite::schema::{Owned, Table, rows, tables};
use super::sqlite::table::Row;
use super::sqlite::{Damage, Field, Pager, TableScan};
use super::types::Definitions;
use crate::reader::{
    Encoding, Loss, OpenOptions, RawMessage, ReadError, ReadProblem, Reader, TopicId, TopicInfo,
};
use crate::ros1_bag::loss;
use crate::schema::{Dialect, Schema, parse_idl, parse_msg};
use crate::storage::{Compressed, StoredFile};

/// The first bytes of a SQLite database.
pub(crate) const MAGIC: &[u8; 16] = b"SQLite format 3\0";

/// The first bytes of what zstd compressed. No CDR message begins so.
const ZSTD_MAGIC: [u8; 4] = [0x28, 0xb5, 0x2f, 0xfd];

/// More than this would not be read by anyone; the last one then says that there are more.
const MAX_LOSSES: usize = 1_000;

/// A database that is being read.
pub(crate) struct DatabaseReader {
    pager: Pager,
    scan: TableScan,
    columns: MessageColumns,
    topics: Vec<TopicInfo>,
    topic_of: BTreeMap<i64, TopicId>,
    selected: Vec<bool>,
    /// How many messages there should be.
    expected: Option<u64>,
    found: u64,
    /// The latest time of any row, of a selected topic or not.
    end_nanos: Option<i64>,
    losses: Vec<Loss>,
    metadata: BTreeMap<String, String>,
    record_bytes: u64,
    fields: Vec<Field>,
    payload: Vec<u8>,
    uncompressed: Vec<u8>,
    has_ended: bool,
    has_compressed_messages: bool,
}

/// Which columns of the table of messages are which.
#[derive(Clone, Copy)]
struct MessageColumns {
    topic: usize,
    time: usize,
    data: usize,
}

impl MessageColumns {
    fn of(messages: &Table) -> Option<Self> {
        Some(MessageColumns {
            topic: messages.column("topic_id")?,
            time: messages.column("timestamp")?,
            data: messages.column("data")?,
        })
    }
}

/// Where the data of a message are.
enum Place {
    Page(Row, Range<usize>),
    Payload(Range<usize>),
    Uncompressed,
}

/// A message whose data are in one of the buffers.
struct Found {
    topic: TopicId,
    nanos: i64,
    offset: u64,
    place: Place,
}

impl DatabaseReader {
    /// Finds the tables and topics. `expected` is how many messages the metadata tell.
    ///
    /// # Errors
    /// [`ReadError`] if it is no such database, or its tables cannot be found.
    pub(crate) fn new(
        main: Box<dyn Source>,
        wal: Option<Box<dyn Source>>,
        options: &OpenOptions,
        definitions: &Definitions,
        expected: Option<u64>,
    ) -> Result<Self, ReadError> {
        let (mut pager, mut damages) = Pager::open(main, wal).map_err(unreadable)?;
        let tables = tables(&mut pager, &mut damages);
        let find = |name: &str| tables.iter().find(|table| table.name == name);
        let (Some(messages), Some(topic_table)) = (find("messages"), find("topics")) else {
            return Err(without_tables(&damages));
        };
        let Some(columns) = MessageColumns::of(messages) else {
            return Err(without_tables(&damages));
        };
        let defined = find("message_definitions");
        let defined = defined.map_or_else(BTreeMap::new, |table| {
            definitions_of(&mut pager, table, &mut damages)
        });
        let (topics, topic_of) =
            topics_of(&mut pager, topic_table, &defined, definitions, &mut damages);
        let metadata = distro(&mut pager, find("schema"), &mut damages);
        let mut reader = DatabaseReader {
            scan: TableScan::new(messages.root),
            selected: vec![true; topics.len()],
            pager,
            columns,
            topics,
            topic_of,
            expected,
            found: 0,
            end_nanos: None,
            losses: Vec::new(),
            metadata,
            record_bytes: options.record_bytes,
            fields: Vec::new(),
            payload: Vec::new(),
            uncompressed: Vec::new(),
            has_ended: false,
            has_compressed_messages: false,
        };
        for damage in damages {
            reader.note(damage);
        }
        Ok(reader)
    }

    fn note(&mut self, damage: Damage) {
        match self.losses.len() {
            len if len < MAX_LOSSES => self.losses.push(loss(damage.offset, damage.message)),
            MAX_LOSSES => self
                .losses
                .push(loss(damage.offset, "here and behind there is more damage")),
            _ => {}
        }
    }

    /// The next message of a selected topic.
    fn find_next(&mut self) -> Option<Found> {
        loop {
            let found = match self.scan.next(&mut self.pager) {
                Ok(None) => return None,
                Ok(Some(row)) => {
                    self.found += 1;
                    self.message(row)
                }
                Err(damage) => Err(damage),
            };
            match found {
                Ok(Some(found)) => return Some(found),
                Ok(None) => {}
                Err(damage) => self.note(damage),
            }
        }
    }

    /// The message in `row`; `None` if its topic is not selected.
    fn message(&mut self, row: Row) -> Result<Option<Found>, Damage> {
        let is_whole = self.locate_columns(&row)?;
        let (topic, nanos) = self.topic_and_time(&row, is_whole)?;
        self.end_nanos = self.end_nanos.max(Some(nanos));
        if !self.selected[topic.index()] {
            return Ok(None);
        }
        let data = self.fields.get(self.columns.data);
        let Some(&data) = data.filter(|field| field.is_bytes()) else {
            return Err(lost(&row, "has no data"));
        };
        let range = data.start as usize..(data.start + data.len) as usize;
        let place = if data.is_within(self.scan.local(&row).len()) {
            Place::Page(row, range)
        } else {
            if !is_whole {
                self.scan.whole(&row, &mut self.pager, &mut self.payload)?;
            }
            Place::Payload(range)
        };
        let place = self
            .uncompress(place, topic)
            .map_err(|error| lost(&row, &format!("cannot be uncompressed ({error})")))?;
        let offset = row.offset;
        Ok(Some(Found {
            topic,
            nanos,
            offset,
            place,
        }))
    }

    /// Finds the columns of a row; whether its overflow pages had to be read for that.
    fn locate_columns(&mut self, row: &Row) -> Result<bool, Damage> {
        if row.len > self.record_bytes {
            let problem = format!("claims {} bytes, more than is believed,", row.len);
            return Err(lost(row, &problem));
        }
        let local = self.scan.local(row);
        let mut located = locate(local, row.len, &mut self.fields);
        let is_whole = located == Err(HeaderError::Incomplete);
        if is_whole {
            self.scan.whole(row, &mut self.pager, &mut self.payload)?;
            located = locate(&self.payload, row.len, &mut self.fields);
        }
        match located {
            Ok(()) => Ok(is_whole),
            Err(_) => Err(lost(row, "contradicts its own header")),
        }
    }

    /// Topic and time of a row whose columns are located; `None` if the topic is not selected.
    fn topic_and_time(&self, row: &Row, is_whole: bool) -> Result<(TopicId, i64), Damage> {
        let bytes = match is_whole {
            true => &self.payload[..],
            false => self.scan.local(row),
        };
        let number = |column: usize| self.fields.get(column)?.value(bytes)?.integer();
        let numbers = (number(self.columns.topic), number(self.columns.time));
        let (Some(topic), Some(nanos)) = numbers else {
            return Err(lost(row, "has no topic or no time"));
        };
        let Some(&topic) = self.topic_of.get(&topic) else {
            let problem = format!("belongs to the topic {topic}, which is not described,");
            return Err(lost(row, &problem));
        };
        Ok((topic, nanos))
    }

    /// Uncompresses a message that was compressed on its own.
    fn uncompress(&mut self, place: Place, topic: TopicId) -> std::io::Result<Place> {
        let bytes = match &place {
            Place::Page(row, range) => &self.scan.local(row)[range.clone()],
            Place::Payload(range) => &self.payload[range.clone()],
            Place::Uncompressed => return Ok(place),
        };
        let is_cdr = self.topics[topic.index()].encoding == Encoding::Cdr;
        if !is_cdr || !bytes.starts_with(&ZSTD_MAGIC) {
            return Ok(place);
        }
        self.has_compressed_messages = true;
        self.uncompressed.clear();
        super::unzstd(bytes, self.record_bytes, &mut self.uncompressed)?;
        Ok(Place::Uncompressed)
    }

    /// What shows only at the end.
    fn end(&mut self) {
        self.has_ended = true;
        if self.pager.has_changed() {
            let message = "the database was written to while it was read; close the recorder first";
            self.note(Damage::new(0, message));
        }
        if let Some(expected) = self.expected.filter(|expected| *expected > self.found) {
            let message = format!(
                "the metadata tell {expected} messages, but {} are here; if the file was copied from \
                 a running recorder, copy the file that ends in -wal too",
                self.found
            );
            let messages = Some(expected - self.found);
            self.losses.push(Loss {
                messages,
                ..loss(0, message)
            });
        }
    }
}

impl Reader for DatabaseReader {
    fn topics(&self) -> &[TopicInfo] {
        &self.topics
    }

    fn next(&mut self) -> Result<Option<RawMessage<'_>>, ReadError> {
        if self.has_ended {
            return Ok(None);
        }
        let Some(found) = self.find_next() else {
            self.end();
            return Ok(None);
        };
        let data = match &found.place {
            Place::Page(row, range) => &self.scan.local(row)[range.clone()],
            Place::Payload(range) => &self.payload[range.clone()],
            Place::Uncompressed => &self.uncompressed[..],
        };
        Ok(Some(RawMessage {
            topic: found.topic,
            log_nanos: found.nanos,
            publish_nanos: found.nanos,
            data,
            offset: found.offset,
        }))
    }

    fn losses(&self) -> &[Loss] {
        &self.losses
    }

    fn complete(&self) -> bool {
        self.losses.is_empty()
    }

    fn select(&mut self, wanted: &dyn Fn(&TopicInfo) -> bool) {
        self.selected = self.topics.iter().map(wanted).collect();
    }

    fn metadata(&self) -> &BTreeMap<String, String> {
        &self.metadata
    }

    fn end_nanos(&self) -> Option<i64> {
        self.end_nanos
    }

    /// The database has no checksums.
    fn checked(&self) -> bool {
        false
    }

    fn storage(&self) -> Vec<StoredFile> {
        let file = StoredFile::plain("SQLite");
        vec![match self.has_compressed_messages {
            true => file.compressed_by(Compressed::Messages, "zstd"),
            false => file,
        }]
    }

    /// Rows come in the order in which they were recorded.
    fn in_time_order(&self) -> bool {
        false
    }
}

/// A row that cannot be given: `problem` follows its id.
fn lost(row: &Row, problem: &str) -> Damage {
    Damage::new(row.offset, format!("row {} {problem} and is lost", row.id))
}

/// The schemas that the database itself defines, by type.
fn definitions_of(
    pager: &mut Pager,
    table: &Table,
    damages: &mut Vec<Damage>,
) -> BTreeMap<String, Arc<Schema>> {
    let columns = ["topic_type", "encoding", "encoded_message_definition"];
    let [Some(name), Some(encoding), Some(text)] = columns.map(|column| table.column(column))
    else {
        return BTreeMap::new();
    };
    let rows = rows(pager, table.root, table.id_column, damages);
    let defined = rows.iter().filter_map(|row| {
        let (name, text) = (row.get(name)?.text()?, row.get(text)?.text()?);
        let parsed = match row.get(encoding)?.text()? {
            _ if text.is_empty() => return None,
            "ros2msg" => parse_msg(name, text, Dialect::Ros2).map(Schema::Struct),
            "ros2idl" => parse_idl(name, text).map(Schema::Struct),
            _ => return None,
        };
        let schema = parsed.unwrap_or_else(|error| Schema::Unknown {
            reason: error.to_string(),
        });
        Some((name.to_owned(), Arc::new(schema)))
    });
    defined.collect()
}

/// The topics in the order of their ids, and which topic an id stands for.
fn topics_of(
    pager: &mut Pager,
    table: &Table,
    defined: &BTreeMap<String, Arc<Schema>>,
    definitions: &Definitions,
    damages: &mut Vec<Damage>,
) -> (Vec<TopicInfo>, BTreeMap<i64, TopicId>) {
    let columns = ["id", "name", "type", "serialization_format"].map(|column| table.column(column));
    let value = |row: &[Owned], column: usize| {
        columns[column]
            .and_then(|column| row.get(column).cloned())
            .unwrap_or(Owned::Null)
    };
    let (mut topics, mut topic_of) = (Vec::new(), BTreeMap::new());
    for row in rows(pager, table.root, table.id_column, damages) {
        let (Some(id), Some(name)) = (
            value(&row, 0).integer(),
            value(&row, 1).text().map(str::to_owned),
        ) else {
            damages.push(Damage::new(
                0,
                "a topic has no id or no name; its messages are lost",
            ));
            continue;
        };
        let type_name = value(&row, 2).text().unwrap_or_default().to_owned();
        let encoding = match value(&row, 3).text().unwrap_or("cdr") {
            "cdr" => Encoding::Cdr,
            other => Encoding::Unknown(other.to_owned()),
        };
        let schema = defined.get(&type_name).cloned();
        let schema = schema.unwrap_or_else(|| Arc::new(definitions.schema(&type_name)));
        let topic = TopicId(topics.len() as u32);
        topic_of.insert(id, topic);
        topics.push(TopicInfo {
            id: topic,
            name,
            type_name,
            encoding,
            schema,
            message_count: None,
        });
    }
    (topics, topic_of)
}

/// The release of ROS, where the database tells it.
fn distro(
    pager: &mut Pager,
    table: Option<&Table>,
    damages: &mut Vec<Damage>,
) -> BTreeMap<String, String> {
    let value = table.and_then(|table| {
        let column = table.column("ros_distro")?;
        let row = rows(pager, table.root, table.id_column, damages)
            .into_iter()
            .next()?;
        row.get(column)?.text().map(str::to_owned)
    });
    value
        .map(|distro| ("ros_distro".to_owned(), distro))
        .into_iter()
        .collect()
}

fn unreadable(damage: Damage) -> ReadError {
    ReadError {
        path: None,
        offset: Some(damage.offset),
        problem: ReadProblem::Malformed(format!(
            "{}; copy the file again from where it was recorded",
            damage.message
        )),
    }
}

fn without_tables(damages: &[Damage]) -> ReadError {
    let first = damages.first();
    let message = match first {
        Some(damage) => format!(
            "the tables \"topics\" and \"messages\" of a rosbag2 recording are not found, since {}; \
             copy the file again from where it was recorded",
            damage.message
        ),
        None => "it is a SQLite database without the tables \"topics\" and \"messages\" of a rosbag2 \
                 recording; if it was copied from a running recorder, copy the file that ends in -wal \
                 too"
            .to_owned(),
    };
    ReadError {
        path: None,
        offset: first.map(|damage| damage.offset),
        problem: ReadProblem::Malformed(message),
    }
}
