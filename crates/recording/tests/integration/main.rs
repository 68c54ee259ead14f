//! All integration tests of the crate in one program, since each program costs a link.

mod damaged;
mod decode;
mod foreign_readers;
mod frames;
mod mcap;
mod parquet_tables;
mod rosbags;
mod rows;
mod signals;
mod sqlite_peer;
mod storage;
mod trace_file;
