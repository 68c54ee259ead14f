//! Tables in CSV, of which each row is a message.
//!
//! One column has the time (see [`row_time`]); the others make topics and fields (see [`columns`]).
//! The first line has the headers; cells are separated by commas, semicolons or tabs, whichever the
//! first line has more of; cells may be quoted.
//!
//! The table is read twice: first to learn what the columns are, then for the messages. A column is
//! of numbers if nine tenths of its filled cells are; an empty cell is then missing (NaN), and any
//! other cell that is no number is missing and a [`Loss`] with its line and column. Guarantee: each
//! row is given once, in the order of the file, or is a [`Loss`]. A last line that does not end with
//! a line break may have lost digits, so it is left out.

pub(crate) mod columns;
pub(crate) mod row_time;

use std::collections::BTreeMap;
use std::io::{self, Read, Seek, SeekFrom};
use std::sync::Arc;

use csv::{ByteRecord, ReaderBuilder};

use crate::reader::{
    Encoding, Loss, OpenOptions, RawMessage, ReadError, ReadProblem, Reader, TopicId, TopicInfo,
};
use crate::ros1_bag::loss;
use crate::schema::Schema;
use crate::storage::StoredFile;
use columns::{Census, Kind, TableTopic, append, layout};
use row_time::{TimeFormat, find_time};

/// More losses than this would not be read by anyone; the last one says that there are more.
const MAX_LOSSES: usize = 1_000;

/// Blank lines in front of a row are counted up to this many bytes.
const MAX_BREAKS: u64 = 4_096;

/// A table that is being read.
pub(crate) struct CsvReader<R> {
    rows: Rows<R>,
    headers: Vec<String>,
    time_column: usize,
    time_format: TimeFormat,
    tables: Vec<TableTopic>,
    topics: Vec<TopicInfo>,
    selected: Vec<bool>,
    metadata: BTreeMap<String, String>,
    losses: Vec<Loss>,
    /// The topic that the present row is to be given for next.
    next_topic: usize,
    nanos: i64,
    /// The latest so far.
    end_nanos: Option<i64>,
    message: Vec<u8>,
    has_ended: bool,
}

/// The rows of a table, with the last one if it is whole.
struct Rows<R> {
    csv: csv::Reader<R>,
    row: ByteRecord,
    /// How long the file is, and whether it ends with a line break.
    len: u64,
    ends_with_break: bool,
}

impl<R: Read + Seek> Rows<R> {
    fn new(mut source: R) -> io::Result<Self> {
        let delimiter = delimiter(&mut source)?;
        let len = source.seek(SeekFrom::End(0))?;
        let mut last = [b'\n'];
        if len > 0 {
            source.seek(SeekFrom::Start(len - 1))?;
            source.read_exact(&mut last)?;
        }
        let ends_with_break = matches!(last, [b'\n' | b'\r']);
        source.seek(SeekFrom::Start(0))?;
        let mut builder = ReaderBuilder::new();
        builder
            .has_headers(false)
            .flexible(true)
            .delimiter(delimiter)
            .trim(csv::Trim::All);
        let csv = builder.from_reader(source);
        Ok(Rows {
            csv,
            row: ByteRecord::new(),
            len,
            ends_with_break,
        })
    }

    /// Goes to the next row; `None` at the end, or if the row is the last one and may be cut.
    fn advance(&mut self) -> Result<Option<()>, ReadError> {
        match self.csv.read_byte_record(&mut self.row) {
            Ok(true) if !self.is_cut() => Ok(Some(())),
            Ok(_) => Ok(None),
            Err(error) => Err(match error.into_kind() {
                csv::ErrorKind::Io(error) => error.into(),
                other => malformed(format!("it is not a table in CSV ({other:?})")),
            }),
        }
    }

    /// Whether the present row is the last one and has no line break behind it.
    fn is_cut(&self) -> bool {
        !self.ends_with_break && self.csv.position().byte() >= self.len
    }

    /// Where the present row begins, or the line break in front of it, in bytes.
    fn offset(&self) -> u64 {
        self.row.position().map_or(0, csv::Position::byte)
    }

    /// The line and the byte at which the present row begins. The position that the parser gives
    /// can be that of line breaks in front of it, so these are read again.
    fn place(&mut self) -> Result<(u64, u64), ReadError> {
        let Some(start) = self.row.position().cloned() else {
            return Ok((1, 0));
        };
        let behind = self.csv.position().clone();
        let (mut line, mut offset) = (start.line(), start.byte());
        let mut bytes = Vec::new();
        let source = self.csv.get_mut();
        source.seek(SeekFrom::Start(offset))?;
        source.take(MAX_BREAKS).read_to_end(&mut bytes)?;
        for byte in bytes
            .iter()
            .take_while(|byte| matches!(byte, b'\n' | b'\r'))
        {
            line += u64::from(*byte == b'\n');
            offset += 1;
        }
        let back = SeekFrom::Start(behind.byte());
        self.csv
            .seek_raw(back, behind)
            .map_err(|error| malformed(error.to_string()))?;
        Ok((line, offset))
    }

    /// Reads all rows, to learn the format of the times (if there are any) and the kinds of the
    /// other columns.
    fn survey(
        &mut self,
        headers: &[String],
        time_column: usize,
        options: &OpenOptions,
    ) -> Result<(Option<TimeFormat>, Vec<Census>), ReadError> {
        let mut census = vec![Census::default(); headers.len()];
        let mut format = None;
        while self.advance()?.is_some() {
            if self.row.len() != headers.len() {
                continue;
            }
            if format.is_none() && !self.cell(time_column).is_empty() {
                let line = self.place()?.0;
                let first = self.cell(time_column);
                format = Some(format_of(&headers[time_column], &first, line, options)?);
            }
            for (column, census) in census.iter_mut().enumerate() {
                census.count(&self.cell(column));
            }
        }
        Ok((format, census))
    }

    /// A cell; bytes that are no text are replaced.
    fn cell(&self, column: usize) -> std::borrow::Cow<'_, str> {
        String::from_utf8_lossy(self.row.get(column).unwrap_or_default())
    }
}

impl<R: Read + Seek> CsvReader<R> {
    /// Reads the table once, to learn what its columns are.
    ///
    /// # Errors
    /// [`ReadError`] if there is no column of times, or its unit is ambiguous.
    pub(crate) fn new(source: R, options: &OpenOptions) -> Result<Self, ReadError> {
        let mut rows = Rows::new(source)?;
        if rows.advance()?.is_none() {
            return Err(match rows.len {
                0 => ReadProblem::Empty.into(),
                _ => malformed("its first line does not end; record it again".to_owned()),
            });
        }
        let headers: Vec<String> = (0..rows.row.len())
            .map(|column| rows.cell(column).into_owned())
            .collect();
        let time_column = time_column(&headers, options)?;
        let start = rows.csv.position().clone();
        let (time_format, census) = rows.survey(&headers, time_column, options)?;
        let columns = census.iter().enumerate();
        let kinds: Vec<Option<Kind>> = columns
            .clone()
            .map(|(column, census)| (column != time_column).then(|| census.kind()))
            .collect();
        let empty = columns.filter(|(_, census)| census.is_empty());
        let empty: Vec<usize> = empty.map(|(column, _)| column).collect();
        let layout = layout(&headers, &kinds, &empty).map_err(malformed)?;
        rows.csv
            .seek(start)
            .map_err(|error| malformed(error.to_string()))?;
        Ok(CsvReader {
            topics: topics(&layout.topics),
            selected: vec![true; layout.topics.len()],
            next_topic: layout.topics.len(),
            tables: layout.topics,
            metadata: layout.notes,
            rows,
            headers,
            time_column,
            // Without any row it is never asked.
            time_format: time_format.unwrap_or(TimeFormat::Date),
            losses: Vec::new(),
            nanos: 0,
            end_nanos: None,
            message: Vec::new(),
            has_ended: false,
        })
    }

    /// Notes that the present row, or a part of it, is lost: `problem` follows its line.
    fn note(&mut self, problem: &str, messages: Option<u64>) -> Result<(), ReadError> {
        if self.losses.len() > MAX_LOSSES {
            return Ok(());
        }
        let (line, offset) = self.rows.place()?;
        self.losses.push(match self.losses.len() {
            MAX_LOSSES => loss(offset, "here and behind there is more damage"),
            _ => Loss {
                messages,
                ..loss(offset, format!("line {line}{problem}"))
            },
        });
        Ok(())
    }

    /// Goes to the next row that has a time; `None` at the end.
    fn next_row(&mut self) -> Result<Option<()>, ReadError> {
        while self.rows.advance()?.is_some() {
            let (found, headers) = (self.rows.row.len(), self.headers.len());
            if found != headers {
                let problem = format!(" has {found} cells, but there are {headers} headers");
                self.note(&problem, Some(1))?;
                continue;
            }
            let time = self.rows.cell(self.time_column);
            if let Some(nanos) = self.time_format.nanos(&time) {
                self.nanos = nanos;
                self.end_nanos = self.end_nanos.max(Some(nanos));
                return Ok(Some(()));
            }
            let column = &self.headers[self.time_column];
            let problem = format!(", column \"{column}\": \"{time}\" is not a valid time");
            self.note(&problem, Some(1))?;
        }
        if self.rows.is_cut() {
            let problem = ", the last one, has no line break behind it and may be cut short, so it \
                           is left out; if it is whole, add the line break";
            self.note(problem, Some(1))?;
        }
        Ok(None)
    }

    /// Serialises the present row for the topic `index`; `false` if it has nothing for it.
    fn serialise(&mut self, index: usize) -> Result<bool, ReadError> {
        let table = &self.tables[index];
        let is_filled = |(column, _): &(usize, Kind)| !self.rows.row[*column].is_empty();
        if table.skips_empty_rows && !table.columns.iter().any(is_filled) {
            return Ok(false);
        }
        self.message.clear();
        let mut wrong = Vec::new();
        for &(column, kind) in &table.columns {
            if !append(&self.rows.cell(column), kind, &mut self.message) {
                wrong.push(column);
            }
        }
        for column in wrong {
            let (header, cell) = (&self.headers[column], self.rows.cell(column));
            let problem = format!(
                ", column \"{header}\": \"{cell}\" is not a number, so it counts as missing"
            );
            self.note(&problem, None)?;
        }
        Ok(true)
    }
}

impl<R: Read + Seek> Reader for CsvReader<R> {
    fn topics(&self) -> &[TopicInfo] {
        &self.topics
    }

    fn next(&mut self) -> Result<Option<RawMessage<'_>>, ReadError> {
        loop {
            if self.has_ended {
                return Ok(None);
            }
            if self.next_topic == self.tables.len() {
                let row = self.next_row();
                self.has_ended = !matches!(row, Ok(Some(())));
                row?;
                self.next_topic = 0;
                continue;
            }
            let index = self.next_topic;
            self.next_topic += 1;
            if self.selected[index] && self.serialise(index)? {
                return Ok(Some(RawMessage {
                    topic: TopicId(index as u32),
                    log_nanos: self.nanos,
                    publish_nanos: self.nanos,
                    data: &self.message,
                    offset: self.rows.offset(),
                }));
            }
        }
    }

    fn losses(&self) -> &[Loss] {
        &self.losses
    }

    fn end_nanos(&self) -> Option<i64> {
        self.end_nanos
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

    /// The format has no checksums.
    fn checked(&self) -> bool {
        false
    }

    fn storage(&self) -> Vec<StoredFile> {
        vec![StoredFile::plain("CSV")]
    }

    fn in_time_order(&self) -> bool {
        false
    }
}

fn topics(tables: &[TableTopic]) -> Vec<TopicInfo> {
    let infos = tables.iter().enumerate().map(|(index, table)| TopicInfo {
        id: TopicId(index as u32),
        name: table.name.clone(),
        type_name: String::new(),
        encoding: Encoding::Columns,
        schema: Arc::new(Schema::Struct(table.message_type.clone())),
        message_count: None,
    });
    infos.collect()
}

fn malformed(message: String) -> ReadError {
    ReadProblem::Malformed(message).into()
}

fn time_column(headers: &[String], options: &OpenOptions) -> Result<usize, ReadError> {
    let names = || headers.iter().map(String::as_str);
    let found = match &options.time_field {
        Some(wanted) => names().position(|name| name == wanted),
        None => find_time(names()),
    };
    found.ok_or_else(|| {
        let wanted = options
            .time_field
            .as_deref()
            .map_or("of times".to_owned(), |name| format!("\"{name}\""));
        let names: Vec<&str> = names().take(20).collect();
        malformed(format!(
            "its first line has no column {wanted}, but \"{}\"; name the column that has the times",
            names.join("\", \"")
        ))
    })
}

fn format_of(
    header: &str,
    first: &str,
    line: u64,
    options: &OpenOptions,
) -> Result<TimeFormat, ReadError> {
    TimeFormat::detect(header, first, options.time_unit).ok_or_else(|| {
        malformed(format!(
            "the unit of the column \"{header}\" cannot be derived from \"{first}\" in line {line}; state \
             the unit (s, ms, us or ns), or call the column \"{header} [s]\""
        ))
    })
}

/// The delimiter that the first line has most of.
fn delimiter(source: &mut (impl Read + Seek)) -> io::Result<u8> {
    source.seek(SeekFrom::Start(0))?;
    let mut start = Vec::new();
    source.take(64 * 1024).read_to_end(&mut start)?;
    let line = start
        .split(|byte| matches!(byte, b'\n' | b'\r'))
        .next()
        .unwrap_or_default();
    let count = |sign: u8| line.iter().filter(|byte| **byte == sign).count();
    // In doubt the comma, which is the last of the greatest.
    Ok([b'\t', b';', b',']
        .into_iter()
        .max_by_key(|sign| count(*sign))
        .unwrap_or(b','))
}
