//! What an editor is answered.

mod any_text;
mod conversation;
mod models;
mod renaming;
mod studies;
mod support;
