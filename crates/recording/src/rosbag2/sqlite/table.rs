//! The rows of a table, in the order of their ids.
//!
//! A table is a B-tree: interior pages point to further pages, leaf pages hold the rows; what does
//! not fit on a leaf continues on a chain of overflow pages. Each page belongs to one place only,
//! so a page that is reached twice, or ids that do not ascend, are damage.

use super::Damage;
use super::pager::{Pager, be_u32};
use super::record::varint;

/// Deeper than any database that fits on a disk.
const MAX_DEPTH: usize = 24;

/// One row; its bytes are had from the scan.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Row {
    /// Its id.
    pub(crate) id: i64,
    /// Where it begins in the file, in bytes.
    pub(crate) offset: u64,
    /// How long it is, in bytes.
    pub(crate) len: u64,
    local_start: usize,
    local_len: usize,
    overflow_page: u32,
}

/// A page of the path from the root to the present row.
struct Level {
    number: u32,
    page: Vec<u8>,
    is_leaf: bool,
    cells: usize,
    next: usize,
}

/// A walk over the rows of a table.
pub(crate) struct TableScan {
    root: u32,
    levels: Vec<Level>,
    /// Buffers of pages that were left.
    spare: Vec<Vec<u8>>,
    /// One bit for each page: whether it was reached.
    reached: Vec<u64>,
    overflow: Vec<u8>,
    last_id: Option<i64>,
    has_begun: bool,
}

impl TableScan {
    /// A walk over the table that begins at page `root`.
    pub(crate) fn new(root: u32) -> Self {
        TableScan {
            root,
            levels: Vec::new(),
            spare: Vec::new(),
            reached: Vec::new(),
            overflow: Vec::new(),
            last_id: None,
            has_begun: false,
        }
    }

    /// The next row, `None` after the last one.
    ///
    /// # Errors
    /// [`Damage`] where rows are lost; the walk goes on behind it at the next call.
    pub(crate) fn next(&mut self, pager: &mut Pager) -> Result<Option<Row>, Damage> {
        if !self.has_begun {
            self.has_begun = true;
            self.enter(self.root, pager)?;
        }
        loop {
            let Some(level) = self.levels.last_mut() else {
                return Ok(None);
            };
            if level.is_leaf {
                if level.next < level.cells {
                    return self.row(pager).map(Some);
                }
            } else if level.next <= level.cells {
                let child = level.child(pager)?;
                self.enter(child, pager)?;
                continue;
            }
            if let Some(level) = self.levels.pop() {
                self.spare.push(level.page);
            }
        }
    }

    /// Begins with page `number`.
    fn enter(&mut self, number: u32, pager: &mut Pager) -> Result<(), Damage> {
        let offset = pager.offset_of(number);
        if self.levels.len() >= MAX_DEPTH {
            return Err(Damage::new(offset, "the tables are nested too deeply"));
        }
        self.mark(number, pager)?;
        let mut page = self.spare.pop().unwrap_or_default();
        pager.read(number, &mut page)?;
        let head = head_start(number);
        let is_leaf = match page[head] {
            0x0d => true,
            0x05 => false,
            _ => {
                let message = format!("page {number} is not of a table; its rows are lost");
                return Err(Damage::new(offset, message));
            }
        };
        let cells = usize::from(u16::from_be_bytes([page[head + 3], page[head + 4]]));
        let pointers = head + if is_leaf { 8 } else { 12 };
        if pointers + 2 * cells > pager.usable_bytes() {
            let message = format!("page {number} tells more rows than fit on it; they are lost");
            return Err(Damage::new(offset, message));
        }
        let level = Level {
            number,
            page,
            is_leaf,
            cells,
            next: 0,
        };
        let adds_up = level.adds_up(pager.usable_bytes());
        self.levels.push(level);
        if !adds_up {
            let message = format!("page {number} does not add up; rows on it may be lost");
            return Err(Damage::new(offset, message));
        }
        Ok(())
    }

    /// Notes that a page is reached.
    fn mark(&mut self, number: u32, pager: &Pager) -> Result<(), Damage> {
        if self.reached.is_empty() {
            // A header may tell more pages than there are: what can be read bounds the memory.
            self.reached = vec![0; pager.highest_page() as usize / 64 + 1];
        }
        let bit = 1_u64 << (number % 64);
        match self.reached.get_mut(number as usize / 64) {
            Some(word) if *word & bit == 0 => {
                *word |= bit;
                Ok(())
            }
            _ => {
                let message = format!("page {number} is used twice or does not exist");
                Err(Damage::new(pager.offset_of(number), message))
            }
        }
    }

    /// The row at the present place of the leaf, which is left behind.
    fn row(&mut self, pager: &Pager) -> Result<Row, Damage> {
        let usable = pager.usable_bytes();
        let Some(level) = self.levels.last_mut() else {
            return Err(Damage::new(0, "there is no page"));
        };
        let index = level.next;
        level.next += 1;
        let start = level.cell_start(index);
        let page_offset = pager.offset_of(level.number);
        let offset = page_offset + start as u64;
        let row = level.row_at(start, usable, offset).ok_or_else(|| {
            let message = format!(
                "row {} of page {} does not fit on it and is lost",
                index + 1,
                level.number
            );
            Damage::new(offset, message)
        })?;
        if row.len > pager.content_bytes() {
            let message = format!(
                "row {} claims to be longer than the file; it is lost",
                row.id
            );
            return Err(Damage::new(offset, message));
        }
        if self.last_id.is_some_and(|last| row.id <= last) {
            let message = format!("row {} is out of order and is left out", row.id);
            return Err(Damage::new(offset, message));
        }
        self.last_id = Some(row.id);
        Ok(row)
    }

    /// The first bytes of the row that was given last: all, if it has no overflow pages.
    pub(crate) fn local(&self, row: &Row) -> &[u8] {
        let page = self.levels.last().map(|level| &level.page[..]);
        let range = row.local_start..row.local_start + row.local_len;
        page.and_then(|page| page.get(range)).unwrap_or_default()
    }

    /// All bytes of the row that was given last.
    ///
    /// # Errors
    /// [`Damage`] if its overflow pages are not all there.
    pub(crate) fn whole(
        &mut self,
        row: &Row,
        pager: &mut Pager,
        out: &mut Vec<u8>,
    ) -> Result<(), Damage> {
        out.clear();
        out.extend_from_slice(self.local(row));
        let usable = pager.usable_bytes();
        let mut page = row.overflow_page;
        let mut overflow = std::mem::take(&mut self.overflow);
        while (out.len() as u64) < row.len {
            let read = self
                .mark(page, pager)
                .and_then(|()| pager.read(page, &mut overflow));
            if let Err(damage) = read {
                self.overflow = overflow;
                let message = format!("row {} is cut short and lost: {}", row.id, damage.message);
                return Err(Damage::new(row.offset, message));
            }
            page = be_u32(&overflow, 0);
            let rest = row.len - out.len() as u64;
            let count = rest.min(usable as u64 - 4) as usize;
            out.extend_from_slice(&overflow[4..4 + count]);
        }
        self.overflow = overflow;
        Ok(())
    }
}

impl Level {
    fn cell_start(&self, index: usize) -> usize {
        let pointers = head_start(self.number) + if self.is_leaf { 8 } else { 12 };
        let at = pointers + 2 * index;
        usize::from(u16::from_be_bytes([self.page[at], self.page[at + 1]]))
    }

    /// Whether the cells, the free blocks and the fragments that the page tells fill its content
    /// area, so that no cell can have been dropped from it.
    fn adds_up(&self, usable: usize) -> bool {
        let head = head_start(self.number);
        let u16_at = |at: usize| {
            let pair = self.page.get(at..at + 2)?;
            Some(usize::from(u16::from_be_bytes([pair[0], pair[1]])))
        };
        let start = match u16_at(head + 5) {
            Some(0) => 65_536,
            Some(start) => start,
            None => return false,
        };
        let mut filled = usize::from(self.page[head + 7]);
        for index in 0..self.cells {
            let cell = self.cell_bytes(self.cell_start(index), usable);
            // A cell takes the room of a free block at least.
            filled += cell.map_or(0, |bytes| bytes.max(4));
        }
        let mut block = u16_at(head + 1).unwrap_or(0);
        while block != 0 {
            let (Some(next), Some(bytes)) = (u16_at(block), u16_at(block + 2)) else {
                return false;
            };
            filled += bytes;
            // Free blocks stand in order; the last one points to none.
            if next != 0 && next <= block {
                return false;
            }
            block = next;
        }
        usable.checked_sub(start) == Some(filled)
    }

    /// How long the cell at `start` is, with the pointer to its overflow pages.
    fn cell_bytes(&self, start: usize, usable: usize) -> Option<usize> {
        if self.is_leaf {
            let row = self.row_at(start, usable, 0)?;
            let pointer = if (row.local_len as u64) < row.len {
                4
            } else {
                0
            };
            return Some(row.local_start + row.local_len + pointer - start);
        }
        let (_, bytes) = varint(self.page.get(start + 4..usable)?)?;
        Some(4 + bytes)
    }

    /// The next page below an interior page; the last one is named in its head.
    fn child(&mut self, pager: &Pager) -> Result<u32, Damage> {
        let index = self.next;
        self.next += 1;
        let at = match index {
            index if index == self.cells => head_start(self.number) + 8,
            index => self.cell_start(index),
        };
        if at + 4 > pager.usable_bytes() {
            let message = format!(
                "page {} points to no page at place {}",
                self.number,
                index + 1
            );
            return Err(Damage::new(pager.offset_of(self.number), message));
        }
        Ok(be_u32(&self.page, at))
    }

    fn row_at(&self, start: usize, usable: usize, offset: u64) -> Option<Row> {
        let cell = self.page.get(start..usable)?;
        let (len, len_bytes) = varint(cell)?;
        let (id, id_bytes) = varint(&cell[len_bytes..])?;
        let local_len = local_bytes(len, usable);
        let local_start = start + len_bytes + id_bytes;
        let local_end = local_start + local_len;
        let has_overflow = (local_len as u64) < len;
        let end = local_end + if has_overflow { 4 } else { 0 };
        if end > usable {
            return None;
        }
        let overflow_page = if has_overflow {
            be_u32(&self.page, local_end)
        } else {
            0
        };
        Some(Row {
            id: id as i64,
            offset,
            len,
            local_start,
            local_len,
            overflow_page,
        })
    }
}

/// The first page begins with the header of the file.
fn head_start(page: u32) -> usize {
    if page == 1 { 100 } else { 0 }
}

/// How much of a row of `len` bytes is on its leaf page.
fn local_bytes(len: u64, usable: usize) -> usize {
    let usable = usable as u64;
    let most = usable - 35;
    if len <= most {
        return len as usize;
    }
    let least = (usable - 12) * 32 / 255 - 23;
    let fitting = least + (len - least) % (usable - 4);
    if fitting <= most {
        fitting as usize
    } else {
        least as usize
    }
}
