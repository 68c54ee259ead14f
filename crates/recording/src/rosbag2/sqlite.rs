//! Tables of a SQLite database, read without the SQLite library.
//!
//! A rosbag2 recording in SQLite is a table of messages to which rows were only ever added. To
//! judge it one has to walk that table from its first row to its last, to skip what is damaged, and
//! to say where that was. The library offers no such walk: it answers "malformed" without a place
//! and stops. The parts of the file format that are needed are small, stable and documented:
//!
//! | part | file |
//! |---|---|
//! | pages, the header of the file, its write-ahead log | [`pager`], [`wal`] |
//! | the B-tree of a table in the order of its row ids, overflow pages | [`table`] |
//! | a row's columns | [`record`] |
//! | which tables there are, where they begin, their columns | [`schema`] |
//!
//! Source: "Database File Format" (sqlite.org/fileformat2.html), sections 1.2 to 1.6, 2.1, 2.6 and
//! 4; "WAL-mode File Format". Deviations: nothing is written, not even for recovery; a database
//! with a rollback journal beside it is refused by the caller; indexes are not used, so rows come in
//! the order of their ids, which is that of recording. Guarantee: each row is given once, with the
//! bytes that the file holds for it, or a [`Damage`] says where rows were lost. The format has no
//! checksums outside the write-ahead log, so a changed byte inside a value goes unnoticed.
//! Cost: one pass over the pages; memory for one page of each level, the largest row, one bit for
//! each page and twelve bytes for each page in the write-ahead log.

pub(crate) mod pager;
pub(crate) mod record;
pub(crate) mod schema;
pub(crate) mod table;
pub(crate) mod wal;

pub(crate) use pager::Pager;
pub(crate) use record::{Field, Value};
pub(crate) use table::TableScan;

/// What is wrong at a place of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Damage {
    /// Where, in bytes from the start of the database file.
    pub(crate) offset: u64,
    /// What is wrong.
    pub(crate) message: String,
}

impl Damage {
    pub(crate) fn new(offset: u64, message: impl Into<String>) -> Self {
        Damage {
            offset,
            message: message.into(),
        }
    }
}
