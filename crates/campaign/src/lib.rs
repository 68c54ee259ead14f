//! Which stimuli to run next, and what the outcomes so far say.
