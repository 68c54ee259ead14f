#![doc = include_str!("../README.md")]
//!
//! * [`family`]: how the truth of a study is drawn: toys, tasks of several stages with retries, and the
//!   handover's own model;
//! * [`task`]: a task as a chain in the PRISM language and as a simulator of the same runs;
//! * [`journey`]: the corridor's;
//! * [`fault`]: the catalogue, and how each fault is planted in one asset;
//! * [`formal`], [`judges`], [`trials`]: evidence from the model checker, from monitors on traces, and from
//!   people whose attempts are alike;
//! * [`carried`]: what counted constants leave open of a formal model's answers;
//! * [`study`]: one study, compared and diagnosed by the code of the product ([`evidence::compare`],
//!   [`evidence::rank`]);
//! * [`matrix`]: requirement models on traces of each system model;
//! * [`words`], [`texts`]: what the formal model's propositions mean, and the assets as texts;
//! * [`repair`]: the first proposal applied, and the study run again;
//! * [`grammar`]: studies drawn from a grammar, written as folders and judged by running the program itself;
//! * [`theory`]: the power of the test that matches a fault, the bound to be measured against;
//! * [`score`], [`coverage`], [`mod@bench`], [`table`], [`targets`]: the figures.

pub mod bench;
pub mod carried;
pub mod coverage;
pub mod family;
pub mod fault;
pub mod formal;
pub mod grammar;
pub mod journey;
pub mod judges;
pub mod matrix;
pub mod random;
pub mod repair;
pub mod requirements;
pub mod score;
pub mod study;
pub mod table;
pub mod targets;
pub mod task;
pub mod texts;
pub mod theory;
pub mod trials;
pub mod words;
