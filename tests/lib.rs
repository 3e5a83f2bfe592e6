//! What the tests and the slow truths share.

pub mod agreement;
