//! States on which a feature, or the comparison itself, once failed.
