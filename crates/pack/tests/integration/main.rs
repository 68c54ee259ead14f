//! Packs as strangers meet them: the same bytes for the same parts, every change noticed, by `check` and by the page in the pack.

mod by_the_page;
mod changes;
mod form;
mod made;
