//! Tables of columns, which pandas, polars and pyarrow take over where they lie.

mod arrow;

use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use pyo3::types::{PyCapsule, PyList};
use std::sync::Arc;

/// The values of a column, as Arrow lays them out.
#[derive(Debug)]
enum Values {
    /// Texts one behind the other, and where each begins, one more than there are.
    Texts {
        starts: Vec<i64>,
        bytes: Vec<u8>,
    },
    Numbers(Vec<f64>),
    Wholes(Vec<i64>),
    /// A bit for each, the first ones in the low bits.
    Truths(Vec<u8>),
}

/// A column.
#[derive(Debug)]
pub(crate) struct Column {
    name: String,
    values: Values,
    rows: usize,
    /// A bit for each row: whether it has a value.
    present: Vec<u8>,
    missing: usize,
}

impl Column {
    /// Texts, some of them missing.
    pub(crate) fn texts(name: &str, rows: impl IntoIterator<Item = Option<String>>) -> Self {
        let (mut starts, mut bytes) = (vec![0], Vec::new());
        let present = rows.into_iter().map(|text| {
            bytes.extend_from_slice(text.as_deref().unwrap_or_default().as_bytes());
            starts.push(bytes.len() as i64);
            text.is_some()
        });
        let present: Vec<bool> = present.collect();
        Self::new(name, &present, Values::Texts { starts, bytes })
    }

    /// Numbers, some of them missing.
    pub(crate) fn numbers(name: &str, rows: &[Option<f64>]) -> Self {
        let values = rows.iter().map(|it| it.unwrap_or(f64::NAN)).collect();
        Self::new(name, &are_present(rows), Values::Numbers(values))
    }

    /// Whole numbers, some of them missing.
    pub(crate) fn wholes(name: &str, rows: &[Option<u64>]) -> Self {
        let whole = |it: &Option<u64>| i64::try_from(it.unwrap_or(0)).unwrap_or(i64::MAX);
        let values = rows.iter().map(whole).collect();
        Self::new(name, &are_present(rows), Values::Wholes(values))
    }

    /// Truth values, some of them missing.
    pub(crate) fn truths(name: &str, rows: &[Option<bool>]) -> Self {
        let values: Vec<bool> = rows.iter().map(|it| it.unwrap_or(false)).collect();
        Self::new(name, &are_present(rows), Values::Truths(bits(&values)))
    }

    fn new(name: &str, present: &[bool], values: Values) -> Self {
        Self {
            name: name.to_owned(),
            values,
            rows: present.len(),
            present: bits(present),
            missing: present.iter().filter(|it| !**it).count(),
        }
    }

    fn value<'py>(&self, py: Python<'py>, row: usize) -> PyResult<Bound<'py, PyAny>> {
        if !bit(&self.present, row) {
            return Ok(py.None().into_bound(py));
        }
        Ok(match &self.values {
            Values::Texts { starts, bytes } => {
                let text = &bytes[starts[row] as usize..starts[row + 1] as usize];
                let text = String::from_utf8_lossy(text);
                text.as_ref().into_pyobject(py)?.into_any()
            }
            Values::Numbers(values) => values[row].into_pyobject(py)?.into_any(),
            Values::Wholes(values) => values[row].into_pyobject(py)?.into_any(),
            Values::Truths(values) => bit(values, row).into_pyobject(py)?.to_owned().into_any(),
        })
    }
}

fn are_present<T>(rows: &[Option<T>]) -> Vec<bool> {
    rows.iter().map(Option::is_some).collect()
}

fn bits(flags: &[bool]) -> Vec<u8> {
    let byte = |eight: &[bool]| {
        let set = eight.iter().enumerate();
        set.fold(0, |byte, (place, flag)| byte | u8::from(*flag) << place)
    };
    flags.chunks(8).map(byte).collect()
}

fn bit(bits: &[u8], place: usize) -> bool {
    bits[place / 8] >> (place % 8) & 1 == 1
}

/// A table; use it through `corroborate.Table`.
#[pyclass(module = "corroborate._engine", frozen)]
pub(crate) struct Table {
    columns: Arc<Vec<Column>>,
    rows: usize,
}

impl Table {
    /// Columns of one length.
    pub(crate) fn new(columns: Vec<Column>) -> Self {
        let rows = columns.first().map_or(0, |column| column.rows);
        let columns = Arc::new(columns);
        Self { columns, rows }
    }
}

#[pymethods]
impl Table {
    fn __len__(&self) -> usize {
        self.rows
    }

    #[getter]
    fn names(&self) -> Vec<&str> {
        self.columns
            .iter()
            .map(|column| column.name.as_str())
            .collect()
    }

    /// A column as a list, `None` where a value is missing.
    fn column<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyList>> {
        let found = self.columns.iter().find(|column| column.name == name);
        let column = found.ok_or_else(|| PyKeyError::new_err(name.to_owned()))?;
        let values = (0..self.rows).map(|row| column.value(py, row));
        PyList::new(py, values.collect::<PyResult<Vec<_>>>()?)
    }

    /// The types of the columns, by Arrow's PyCapsule interface.
    fn __arrow_c_schema__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyCapsule>> {
        arrow::schema_capsule(py, &self.columns)
    }

    /// The table, by Arrow's PyCapsule interface: its memory is shared, not copied. No other types can be asked for.
    #[pyo3(signature = (requested_schema = None))]
    fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyCapsule>> {
        // Allowed by the interface: who asks gets the types that there are.
        drop(requested_schema);
        arrow::stream_capsule(py, self.columns.clone(), self.rows)
    }
}
