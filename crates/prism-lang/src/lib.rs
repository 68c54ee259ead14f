//! The PRISM language: text to typed models and properties, with spans.
