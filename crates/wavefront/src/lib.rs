//! Columns to samples, one bounce at a time.
