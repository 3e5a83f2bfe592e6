//! The report of a study: one page of HTML that needs no network, with a table beside every chart.

mod charts;
mod page;

pub(crate) use charts::charts;
pub(crate) use page::html;

use crate::plot::Diagram;

/// A chart of a report.
pub(crate) struct Chart {
    /// What it shows, which is the name of its file, too.
    pub name: String,
    /// Where it stands in the report: the title of its section.
    pub section: String,
    /// What a reader should look at.
    pub caption: String,
    pub diagram: Diagram,
}
