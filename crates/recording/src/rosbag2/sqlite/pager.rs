//! The pages of a database, as of the last committed transaction.

use std::io::{self, Read, Seek, SeekFrom};

use super::Damage;
use super::wal::Wal;

/// Bytes that can be read at any place: a file, or memory.
pub(crate) trait Source: Read + Seek + Send {}
impl<T: Read + Seek + Send> Source for T {}

/// Reads ahead this much, since recordings are read from front to back.
const BLOCK_BYTES: usize = 128 * 1024;

/// A source with its length and the block that was read last.
pub(crate) struct Blocks {
    source: Box<dyn Source>,
    len: u64,
    block: Vec<u8>,
    block_start: u64,
}

impl Blocks {
    /// Finds the length of `source`.
    pub(crate) fn new(mut source: Box<dyn Source>) -> io::Result<Self> {
        let len = source.seek(SeekFrom::End(0))?;
        Ok(Blocks {
            source,
            len,
            block: Vec::new(),
            block_start: 0,
        })
    }

    /// The length when it was opened, in bytes.
    pub(crate) fn len(&self) -> u64 {
        self.len
    }

    /// Fills `out` from `offset`; an error if the source ends before.
    pub(crate) fn read_at(&mut self, offset: u64, out: &mut [u8]) -> io::Result<()> {
        let mut filled = 0;
        while filled < out.len() {
            let at = offset + filled as u64;
            let within = at.checked_sub(self.block_start).map(|skip| skip as usize);
            match within.and_then(|skip| self.block.get(skip..)) {
                Some(ready) if !ready.is_empty() => {
                    let count = ready.len().min(out.len() - filled);
                    out[filled..filled + count].copy_from_slice(&ready[..count]);
                    filled += count;
                }
                _ => self.load(at)?,
            }
        }
        Ok(())
    }

    fn load(&mut self, offset: u64) -> io::Result<()> {
        self.block.clear();
        self.block_start = offset;
        self.source.seek(SeekFrom::Start(offset))?;
        let wanted = BLOCK_BYTES as u64;
        (&mut self.source)
            .take(wanted)
            .read_to_end(&mut self.block)?;
        if self.block.is_empty() {
            return Err(io::Error::from(io::ErrorKind::UnexpectedEof));
        }
        Ok(())
    }

    /// Reads again what may have changed, for comparison with what was read first.
    pub(crate) fn reread(&mut self, offset: u64, out: &mut [u8]) -> io::Result<()> {
        self.source.seek(SeekFrom::Start(offset))?;
        self.source.read_exact(out)
    }
}

/// How texts are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TextEncoding {
    Utf8,
    Utf16Le,
    Utf16Be,
}

impl TextEncoding {
    /// The text; characters that are none are replaced.
    pub(crate) fn decode(self, bytes: &[u8]) -> String {
        let units = |join: fn([u8; 2]) -> u16| -> String {
            let pairs = bytes.as_chunks::<2>().0.iter().map(|pair| join(*pair));
            char::decode_utf16(pairs)
                .map(|unit| unit.unwrap_or(char::REPLACEMENT_CHARACTER))
                .collect()
        };
        match self {
            TextEncoding::Utf8 => String::from_utf8_lossy(bytes).into_owned(),
            TextEncoding::Utf16Le => units(u16::from_le_bytes),
            TextEncoding::Utf16Be => units(u16::from_be_bytes),
        }
    }
}

/// The pages of a database with its write-ahead log.
pub(crate) struct Pager {
    main: Blocks,
    wal: Option<Wal>,
    /// The header as it was read first.
    header: [u8; HEADER_BYTES],
    page_bytes: usize,
    /// Bytes of a page that hold content.
    usable_bytes: usize,
    page_count: u32,
    encoding: TextEncoding,
}

const HEADER_BYTES: usize = 100;
use crate::rosbag2::database::MAGIC;

impl Pager {
    /// Reads the header of the database, from `wal` if its first page was committed there.
    ///
    /// # Errors
    /// [`Damage`] if it is no SQLite database that can be read.
    pub(crate) fn open(
        main: Box<dyn Source>,
        wal: Option<Box<dyn Source>>,
    ) -> Result<(Self, Vec<Damage>), Damage> {
        let unreadable = |error: io::Error| Damage::new(0, format!("it cannot be read ({error})"));
        let main = Blocks::new(main).map_err(unreadable)?;
        let wal = match wal {
            Some(source) => {
                Wal::read(Blocks::new(source).map_err(unreadable)?).map_err(unreadable)?
            }
            None => None,
        };
        let mut pager = Pager {
            header: [0; HEADER_BYTES],
            page_bytes: wal.as_ref().map_or(0, Wal::page_bytes),
            usable_bytes: 0,
            page_count: 0,
            encoding: TextEncoding::Utf8,
            wal,
            main,
        };
        let mut header = [0; HEADER_BYTES];
        pager.read_header(&mut header)?;
        pager.interpret(header)?;
        let damages = pager.missing_pages();
        Ok((pager, damages))
    }

    fn read_header(&mut self, header: &mut [u8; HEADER_BYTES]) -> Result<(), Damage> {
        if let Some(wal) = &mut self.wal
            && wal.contains(1)
        {
            let mut page = Vec::new();
            wal.read_page(1, &mut page)
                .map_err(|error| Damage::new(0, format!("its log cannot be read ({error})")))?;
            header.copy_from_slice(&page[..HEADER_BYTES]);
            return Ok(());
        }
        let len = self.main.len();
        self.main
            .read_at(0, header)
            .map_err(|error| match error.kind() {
                io::ErrorKind::UnexpectedEof => Damage::new(
                    len,
                    format!("it ends after {len} bytes, before its header does"),
                ),
                _ => Damage::new(0, format!("it cannot be read ({error})")),
            })
    }

    fn interpret(&mut self, header: [u8; HEADER_BYTES]) -> Result<(), Damage> {
        if header[..16] != MAGIC[..] {
            return Err(Damage::new(0, "it does not begin as a SQLite database"));
        }
        let page_bytes = match u16::from_be_bytes([header[16], header[17]]) {
            1 => 65_536,
            size if size >= 512 && size.is_power_of_two() => usize::from(size),
            size => {
                let message = format!("its header tells pages of {size} bytes, which cannot be");
                return Err(Damage::new(16, message));
            }
        };
        if self
            .wal
            .as_ref()
            .is_some_and(|wal| wal.page_bytes() != page_bytes)
        {
            let message =
                "its write-ahead log has pages of another size; it belongs to another file";
            return Err(Damage::new(16, message));
        }
        let usable_bytes = page_bytes - usize::from(header[20]);
        if usable_bytes < 480 || header[19] > 2 {
            let message = "its header asks for a version of the format that is not supported";
            return Err(Damage::new(19, message));
        }
        self.encoding = match be_u32(&header, 56) {
            0 | 1 => TextEncoding::Utf8,
            2 => TextEncoding::Utf16Le,
            3 => TextEncoding::Utf16Be,
            _ => {
                return Err(Damage::new(
                    56,
                    "its header names an unknown encoding of texts",
                ));
            }
        };
        self.page_count = self.count_pages(&header, page_bytes);
        (self.header, self.page_bytes, self.usable_bytes) = (header, page_bytes, usable_bytes);
        Ok(())
    }

    /// The number of pages that the last commit left.
    fn count_pages(&self, header: &[u8; HEADER_BYTES], page_bytes: usize) -> u32 {
        let in_file = self.main.len().div_ceil(page_bytes as u64);
        let in_file = u32::try_from(in_file).unwrap_or(u32::MAX);
        let stated = be_u32(header, 28);
        // An old writer leaves the field as it was; then it is not for the present change counter.
        let is_current = stated != 0 && be_u32(header, 24) == be_u32(header, 92);
        match &self.wal {
            Some(wal) => wal.page_count(),
            None if is_current => stated,
            None => in_file,
        }
    }

    /// A file that is shorter than it should be.
    fn missing_pages(&self) -> Vec<Damage> {
        let len = self.main.len();
        let stated = u64::from(self.page_count) * self.page_bytes as u64;
        let in_wal = |page| self.wal.as_ref().is_some_and(|wal| wal.contains(page));
        // Pages that were never copied out of the log need not be in the file.
        let whole = u32::try_from(len / self.page_bytes as u64).unwrap_or(u32::MAX);
        let first_missing = (whole + 1..=self.page_count).find(|page| !in_wal(*page));
        match first_missing {
            Some(_) => vec![Damage::new(
                len,
                format!(
                    "the file ends after {len} bytes, but its header tells {} pages of {} bytes, \
                     that is {stated} bytes; what was on the missing pages is lost",
                    self.page_count, self.page_bytes
                ),
            )],
            None => Vec::new(),
        }
    }

    /// Where `page` (from 1) begins in the file.
    pub(crate) fn offset_of(&self, page: u32) -> u64 {
        u64::from(page).saturating_sub(1) * self.page_bytes as u64
    }

    /// Bytes of a page that hold content.
    pub(crate) fn usable_bytes(&self) -> usize {
        self.usable_bytes
    }

    /// The highest page that can be read; a header may tell more.
    pub(crate) fn highest_page(&self) -> u32 {
        let in_file = self.main.len() / self.page_bytes as u64;
        let in_file = u32::try_from(in_file).unwrap_or(u32::MAX);
        let in_wal = self.wal.as_ref().map_or(0, Wal::highest_page);
        in_file.max(in_wal).min(self.page_count)
    }

    /// How its texts are stored.
    pub(crate) fn encoding(&self) -> TextEncoding {
        self.encoding
    }

    /// The most bytes that anything in this file can have.
    pub(crate) fn content_bytes(&self) -> u64 {
        u64::from(self.page_count) * self.page_bytes as u64
    }

    /// Reads `page` (from 1) into `out`.
    ///
    /// # Errors
    /// [`Damage`] if there is no such page or it cannot be read.
    pub(crate) fn read(&mut self, page: u32, out: &mut Vec<u8>) -> Result<(), Damage> {
        let offset = self.offset_of(page);
        if page == 0 || page > self.page_count {
            let message = format!(
                "page {page} is asked for, but there are {}",
                self.page_count
            );
            return Err(Damage::new(offset, message));
        }
        out.resize(self.page_bytes, 0);
        let read = match &mut self.wal {
            Some(wal) if wal.contains(page) => wal.read_page(page, out),
            _ => self.main.read_at(offset, out),
        };
        read.map_err(|error| match error.kind() {
            io::ErrorKind::UnexpectedEof => {
                Damage::new(offset, format!("page {page} is beyond the end of the file"))
            }
            _ => Damage::new(offset, format!("page {page} cannot be read ({error})")),
        })
    }

    /// Whether the header in the file is no longer the one that was read.
    pub(crate) fn has_changed(&mut self) -> bool {
        if self.wal.is_some() {
            return self.wal.as_mut().is_some_and(Wal::has_changed);
        }
        let mut now = [0; HEADER_BYTES];
        self.main.reread(0, &mut now).is_err() || now[24..32] != self.header[24..32]
    }
}

/// The big-endian number at `at`, which must be within `bytes`.
pub(crate) fn be_u32(bytes: &[u8], at: usize) -> u32 {
    let mut four = [0; 4];
    four.copy_from_slice(&bytes[at..at + 4]);
    u32::from_be_bytes(four)
}
