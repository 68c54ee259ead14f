//! Arrow's C data interface, by hand: the only `unsafe` code of this crate, since the interface consists of C structures with
//! pointers and of functions that C calls.
//!
//! The structures are those of the specification ("The Arrow C data interface", "The Arrow C stream interface", "The Arrow
//! PyCapsule Interface", Apache Arrow). A table is a stream of one batch, a structure of its columns. Who takes a structure over
//! copies it and sets `release` to null in ours; it calls `release` once when it is done. The columns live as long as any batch:
//! each holds them by an [`Arc`].

#![allow(unsafe_code)]

use super::{Column, Values};
use pyo3::prelude::*;
use pyo3::types::PyCapsule;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::ptr::{null, null_mut};
use std::sync::Arc;

/// A field may be missing.
const NULLABLE: i64 = 2;
/// The columns of a table.
type Columns = Arc<Vec<Column>>;

/// A type: `struct ArrowSchema`.
#[repr(C)]
struct Schema {
    format: *const c_char,
    name: *const c_char,
    metadata: *const c_char,
    flags: i64,
    n_children: i64,
    children: *mut *mut Schema,
    dictionary: *mut Schema,
    release: Option<unsafe extern "C" fn(*mut Schema)>,
    private_data: *mut c_void,
}

/// Values: `struct ArrowArray`.
#[repr(C)]
struct Array {
    length: i64,
    null_count: i64,
    offset: i64,
    n_buffers: i64,
    n_children: i64,
    buffers: *mut *const c_void,
    children: *mut *mut Array,
    dictionary: *mut Array,
    release: Option<unsafe extern "C" fn(*mut Array)>,
    private_data: *mut c_void,
}

/// Batches: `struct ArrowArrayStream`.
#[repr(C)]
struct Stream {
    get_schema: Option<unsafe extern "C" fn(*mut Stream, *mut Schema) -> c_int>,
    get_next: Option<unsafe extern "C" fn(*mut Stream, *mut Array) -> c_int>,
    get_last_error: Option<unsafe extern "C" fn(*mut Stream) -> *const c_char>,
    release: Option<unsafe extern "C" fn(*mut Stream)>,
    private_data: *mut c_void,
}

/// What a type keeps alive.
struct OfSchema {
    name: CString,
    children: Vec<*mut Schema>,
}

/// What values keep alive.
struct OfArray {
    buffers: Vec<*const c_void>,
    children: Vec<*mut Array>,
    _columns: Columns,
}

/// What a stream still has to give.
struct OfStream {
    columns: Columns,
    rows: usize,
    is_given: bool,
}

// SAFETY: each owns what its `private_data` points to, and what that points to is never changed but by who owns the structure.
unsafe impl Send for Schema {}
// SAFETY: as above.
unsafe impl Send for Stream {}

impl Drop for Schema {
    fn drop(&mut self) {
        if let Some(release) = self.release {
            // SAFETY: it was not released, since that sets `release` to null.
            unsafe { release(self) }
        }
    }
}

impl Drop for Stream {
    fn drop(&mut self) {
        if let Some(release) = self.release {
            // SAFETY: it was not released, since that sets `release` to null.
            unsafe { release(self) }
        }
    }
}

/// The type of a table, in a capsule that releases it if nobody takes it over.
pub(super) fn schema_capsule<'py>(
    py: Python<'py>,
    columns: &[Column],
) -> PyResult<Bound<'py, PyCapsule>> {
    PyCapsule::new_with_value(py, table_schema(columns), c"arrow_schema")
}

/// A table as a stream, in a capsule that releases it if nobody takes it over.
pub(super) fn stream_capsule(
    py: Python<'_>,
    columns: Columns,
    rows: usize,
) -> PyResult<Bound<'_, PyCapsule>> {
    let state = OfStream {
        columns,
        rows,
        is_given: false,
    };
    let stream = Stream {
        get_schema: Some(stream_schema),
        get_next: Some(stream_next),
        get_last_error: Some(stream_error),
        release: Some(release_stream),
        private_data: Box::into_raw(Box::new(state)).cast(),
    };
    PyCapsule::new_with_value(py, stream, c"arrow_array_stream")
}

fn format_of(values: &Values) -> &'static CStr {
    match values {
        Values::Texts { .. } => c"U",
        Values::Numbers(_) => c"g",
        Values::Wholes(_) => c"l",
        Values::Truths(_) => c"b",
    }
}

fn table_schema(columns: &[Column]) -> Schema {
    let child = |column: &Column| {
        let format = format_of(&column.values);
        Box::into_raw(Box::new(schema(format, &column.name, NULLABLE, Vec::new())))
    };
    let children = columns.iter().map(child).collect();
    schema(c"+s", "", 0, children)
}

fn schema(format: &'static CStr, name: &str, flags: i64, children: Vec<*mut Schema>) -> Schema {
    // A zero within a name would end it.
    let name = CString::new(name.replace('\0', "")).unwrap_or_default();
    let mut held = Box::new(OfSchema { name, children });
    Schema {
        format: format.as_ptr(),
        name: held.name.as_ptr(),
        metadata: null(),
        flags,
        n_children: held.children.len() as i64,
        children: held.children.as_mut_ptr(),
        dictionary: null_mut(),
        release: Some(release_schema),
        private_data: Box::into_raw(held).cast(),
    }
}

fn table_array(columns: &Columns, rows: usize) -> Array {
    let child = |column: &Column| Box::into_raw(Box::new(column_array(columns, column)));
    let children = columns.iter().map(child).collect();
    array(columns, rows, 0, vec![null()], children)
}

fn column_array(columns: &Columns, column: &Column) -> Array {
    let present = match column.missing {
        0 => null(),
        _ => column.present.as_ptr().cast(),
    };
    let buffers = match &column.values {
        Values::Texts { starts, bytes } => {
            vec![present, starts.as_ptr().cast(), bytes.as_ptr().cast()]
        }
        Values::Numbers(values) => vec![present, values.as_ptr().cast()],
        Values::Wholes(values) => vec![present, values.as_ptr().cast()],
        Values::Truths(values) => vec![present, values.as_ptr().cast()],
    };
    array(columns, column.rows, column.missing, buffers, Vec::new())
}

fn array(
    columns: &Columns,
    rows: usize,
    missing: usize,
    buffers: Vec<*const c_void>,
    children: Vec<*mut Array>,
) -> Array {
    let mut held = Box::new(OfArray {
        buffers,
        children,
        _columns: columns.clone(),
    });
    Array {
        length: rows as i64,
        null_count: missing as i64,
        offset: 0,
        n_buffers: held.buffers.len() as i64,
        n_children: held.children.len() as i64,
        buffers: held.buffers.as_mut_ptr(),
        children: held.children.as_mut_ptr(),
        dictionary: null_mut(),
        release: Some(release_array),
        private_data: Box::into_raw(held).cast(),
    }
}

/// Called once by who owns the type.
unsafe extern "C" fn release_schema(schema: *mut Schema) {
    // SAFETY: the caller owns a type of `schema()` that was not released, so its private data is the box made there, and
    // its children are boxes made in `table_schema`, each released by its `Drop` unless it was before.
    unsafe {
        let held = Box::from_raw((*schema).private_data.cast::<OfSchema>());
        for child in held.children {
            drop(Box::from_raw(child));
        }
        (*schema).release = None;
    }
}

/// Called once by who owns the values.
unsafe extern "C" fn release_array(array: *mut Array) {
    // SAFETY: the caller owns values of `array()` that were not released, so their private data is the box made there, and
    // the children are boxes made in `table_array`; one that was taken over has no `release` any more.
    unsafe {
        let held = Box::from_raw((*array).private_data.cast::<OfArray>());
        for child in held.children {
            let mut child = Box::from_raw(child);
            if let Some(release) = child.release {
                release(&mut *child);
            }
        }
        (*array).release = None;
    }
}

unsafe extern "C" fn stream_schema(stream: *mut Stream, into: *mut Schema) -> c_int {
    // SAFETY: the caller gives a stream that was not released, whose private data is that of `stream_capsule`, and room for a
    // type, which holds nothing yet.
    unsafe {
        let state = &*(*stream).private_data.cast::<OfStream>();
        into.write(table_schema(&state.columns));
    }
    0
}

unsafe extern "C" fn stream_next(stream: *mut Stream, into: *mut Array) -> c_int {
    // SAFETY: as in `stream_schema`; nobody else uses the stream meanwhile. Zeros are the structure without `release`, which
    // says that the stream is at its end.
    unsafe {
        let state = &mut *(*stream).private_data.cast::<OfStream>();
        match std::mem::replace(&mut state.is_given, true) {
            false => into.write(table_array(&state.columns, state.rows)),
            true => into.write_bytes(0, 1),
        }
    }
    0
}

/// Nothing fails, so that there is no error to tell.
unsafe extern "C" fn stream_error(_: *mut Stream) -> *const c_char {
    null()
}

/// Called once by who owns the stream.
unsafe extern "C" fn release_stream(stream: *mut Stream) {
    // SAFETY: the caller owns a stream that was not released, so its private data is the box of `stream_capsule`.
    unsafe {
        drop(Box::from_raw((*stream).private_data.cast::<OfStream>()));
        (*stream).release = None;
    }
}
