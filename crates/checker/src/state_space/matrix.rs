//! Sparse matrices in compressed rows.

/// A square sparse matrix in compressed sparse rows; columns of a row ascend.
#[derive(Clone, Debug, PartialEq)]
pub struct Csr<N> {
    /// Where each row starts in `column` and `value`; one entry more than there are rows.
    pub row_start: Vec<usize>,
    /// Columns of the entries, row by row.
    pub column: Vec<u32>,
    /// Values of the entries, row by row.
    pub value: Vec<N>,
}

impl<N> Csr<N> {
    /// A matrix from rows of `(column, value)`; entries must have distinct columns within a row.
    pub fn from_rows(rows: Vec<Vec<(u32, N)>>) -> Self {
        let mut matrix = Self::with_capacity(rows.len());
        for mut row in rows {
            row.sort_by_key(|(column, _)| *column);
            matrix.push_row(row);
        }
        matrix
    }

    /// A matrix without rows, with room for this many.
    pub(crate) fn with_capacity(rows: usize) -> Self {
        let mut row_start = Vec::with_capacity(rows + 1);
        row_start.push(0);
        Self {
            row_start,
            column: Vec::new(),
            value: Vec::new(),
        }
    }

    /// Appends a row whose columns ascend.
    pub(crate) fn push_row(&mut self, row: impl IntoIterator<Item = (u32, N)>) {
        for (column, value) in row {
            self.column.push(column);
            self.value.push(value);
        }
        self.row_start.push(self.column.len());
    }

    /// The number of rows.
    pub fn num_rows(&self) -> usize {
        self.row_start.len().saturating_sub(1)
    }

    /// The number of entries.
    pub fn num_entries(&self) -> usize {
        self.column.len()
    }

    /// The entries of a row: `(column, value)`, columns ascending.
    ///
    /// # Panics
    /// If there is no such row.
    pub fn row(&self, row: usize) -> impl Iterator<Item = (usize, &N)> {
        let range = self.row_start[row]..self.row_start[row + 1];
        let columns = self.column[range.clone()].iter().map(|c| *c as usize);
        columns.zip(&self.value[range])
    }
}
