//! Studies from a grammar, as folders that the program runs.
//!
//! * [`machine`]: the truth of a study; [`production`]: the parts from which it is built; [`family`]: which parts each
//!   family joins, and which families are held out of all tuning;
//! * [`prism`], [`simulator`]: the truth as a model's text and as a program that simulates it, in varied styles;
//! * [`draft`], [`files`]: a whole study, and its files;
//! * [`plant`]: the faults and the power of the best test of each;
//! * [`catalogue`]: which studies there are;
//! * [`mod@write`]: all of it as folders;
//! * [`judge`]: the program run on a folder, and what it said held against what was planted;
//! * [`report`]: the figures, of tuned and of held-out families apart.

pub mod catalogue;
pub mod draft;
pub mod family;
pub mod files;
pub mod judge;
pub mod machine;
pub mod plant;
pub mod prism;
pub mod production;
pub mod report;
pub mod simulator;
pub mod write;
