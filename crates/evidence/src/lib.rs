//! What was asked of which asset by which technique, what it showed, and whether it agrees.
