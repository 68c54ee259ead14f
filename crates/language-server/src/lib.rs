#![doc = include_str!("../README.md")]
//!
//! [`serve`] speaks the Language Server Protocol over two streams. What it answers is made by functions over a [`Workspace`],
//! which can be asked without a protocol: [`diagnostics::of_file`], [`hover::at`], [`cursor::definitions`],
//! [`rename::rename`], [`completion::at`], [`symbols::of_file`], [`format::edits`].
//!
//! What lies above this crate, the questions of a study to its models and what codes of diagnostics mean, is brought by an
//! [`Engine`].

pub mod completion;
pub mod cursor;
pub mod diagnostics;
pub mod expand;
pub mod format;
mod frame;
pub mod hover;
pub mod kind;
pub mod mentions;
pub mod model;
pub mod properties;
pub mod rename;
mod schema;
mod server;
pub mod study_view;
pub mod symbols;
pub mod text;
pub mod toml_tree;
pub mod workspace;

pub use server::{Ended, serve};
pub use text::Text;
pub use workspace::{Alone, Document, Engine, Mistakes, Workspace};
