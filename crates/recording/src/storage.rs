//! How a recording lies in its files: format, compression, chunks, index.

use std::collections::BTreeSet;
use std::fmt;

use serde::Serialize;

/// What of a file is compressed by itself.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Compressed {
    /// Nothing.
    #[default]
    Nothing,
    /// The file as a whole.
    File,
    /// Each chunk, or some of them.
    Chunks,
    /// Each message, or some of them.
    Messages,
}

/// What an index of a file is worth.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum IndexState {
    /// The format has none.
    #[default]
    NotInFormat,
    /// It is there and fits the file; where it has a checksum, that is right.
    Sound,
    /// It is there without a checksum, so it is not believed: the file is read once more instead.
    Unguarded,
    /// It is not there, as after a recorder that was killed or was told to leave it out.
    Missing,
    /// It is there, but damaged, and is not used.
    Damaged,
}

/// How one file of a recording is stored.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
pub struct StoredFile {
    /// Its name within the recording's folder; empty if the recording is one file.
    pub name: String,
    /// Its format, for example `MCAP`.
    pub format: String,
    /// What of it is compressed.
    pub compressed: Compressed,
    /// By which methods (`zstd`, `lz4`, `bz2`), in alphabetical order; empty if nothing is
    /// compressed. Chunks of one file can differ.
    pub methods: BTreeSet<String>,
    /// How many chunks it has; `None` if its format has none.
    pub chunks: Option<u64>,
    /// How many of them are compressed.
    pub compressed_chunks: Option<u64>,
    /// Its index.
    pub index: IndexState,
}

impl StoredFile {
    /// A file of a format without chunks and index, not compressed.
    #[must_use]
    pub fn plain(format: &str) -> Self {
        StoredFile {
            format: format.to_owned(),
            ..StoredFile::default()
        }
    }

    /// A file of chunks, by the compression of each; `none` and an empty name stand for none.
    #[must_use]
    pub fn of_chunks<'c>(
        format: &str,
        compressions: impl IntoIterator<Item = &'c str>,
        index: IndexState,
    ) -> Self {
        let mut file = StoredFile::plain(format);
        let (mut chunks, mut compressed) = (0, 0);
        for compression in compressions {
            chunks += 1;
            if !matches!(compression, "" | "none") {
                compressed += 1;
                file.methods.insert(compression.to_owned());
            }
        }
        if compressed > 0 {
            file.compressed = Compressed::Chunks;
        }
        (file.chunks, file.compressed_chunks) = (Some(chunks), Some(compressed));
        file.index = index;
        file
    }

    /// The same file, of which also something larger or smaller is compressed, by `method`.
    #[must_use]
    pub fn compressed_by(mut self, compressed: Compressed, method: &str) -> Self {
        self.compressed = compressed;
        self.methods.insert(method.to_owned());
        self
    }
}

impl fmt::Display for StoredFile {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.name.is_empty() {
            write!(out, "{}: ", self.name)?;
        }
        write!(out, "{}, ", self.format)?;
        let methods: Vec<&str> = self.methods.iter().map(String::as_str).collect();
        let methods = methods.join(" and ");
        match self.compressed {
            Compressed::Nothing => out.write_str("not compressed")?,
            Compressed::File => write!(out, "compressed as a whole ({methods})")?,
            Compressed::Messages => write!(out, "messages compressed ({methods})")?,
            Compressed::Chunks => write!(out, "chunks compressed ({methods})")?,
        }
        match (self.chunks, self.compressed_chunks) {
            (Some(1), _) => out.write_str(", 1 chunk")?,
            (Some(all), Some(some)) if some > 0 && some < all => {
                write!(out, ", {all} chunks, {some} of them compressed")?;
            }
            (Some(all), _) => write!(out, ", {all} chunks")?,
            (None, _) => {}
        }
        match self.index {
            IndexState::NotInFormat => Ok(()),
            IndexState::Sound => out.write_str(", index sound"),
            IndexState::Unguarded => out.write_str(", index without a checksum"),
            IndexState::Missing => out.write_str(", without an index"),
            IndexState::Damaged => out.write_str(", index damaged"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_described_in_one_line() {
        let shown = |file: StoredFile| file.to_string();
        assert_eq!(shown(StoredFile::plain("CSV")), "CSV, not compressed");
        let mixed = ["zstd", "", "lz4"];
        assert_eq!(
            shown(StoredFile::of_chunks("MCAP", mixed, IndexState::Sound)),
            "MCAP, chunks compressed (lz4 and zstd), 3 chunks, 2 of them compressed, index sound"
        );
        let bag = StoredFile::of_chunks("ROS 1 bag", ["none"], IndexState::Missing);
        assert_eq!(
            shown(bag),
            "ROS 1 bag, not compressed, 1 chunk, without an index"
        );
        let whole = StoredFile {
            name: "a_0.db3".to_owned(),
            ..StoredFile::plain("SQLite")
        };
        assert_eq!(
            shown(whole.compressed_by(Compressed::File, "zstd")),
            "a_0.db3: SQLite, compressed as a whole (zstd)"
        );
    }
}
