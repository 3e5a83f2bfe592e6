//! Throughput studies: which way of scheduling is faster, measured fairly, with the evidence kept.
//!
//! [`run`] renders scenes by every policy in turn ([`measure`]) and checks every picture; [`statistics`] says what is more than noise;
//! [`samples`] counts sample by sample, [`record`] is what is kept of it all, [`files`] writes it down, and [`report`] draws it.

mod counters;
mod files;
mod machine;
mod measure;
mod quality;
mod record;
mod report;
mod rows;
mod run;
mod samples;
mod statistics;
mod subject;
mod trees;

pub(crate) use files::{Folder, commit, date, slug};
pub(crate) use machine::Machine;
pub(crate) use quality::quality;
pub(crate) use record::{Results, VERSION};
pub(crate) use run::{Watch, experiment, load};
pub(crate) use statistics::confidence;
pub(crate) use subject::{Subject, intervals, subjects, ways};
