//! Samples to pixels to files.
