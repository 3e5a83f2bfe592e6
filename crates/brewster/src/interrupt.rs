//! Ctrl-C: the first one asks, the second one ends the program at once.

use std::process;
use std::sync::Arc;

use brewster::wavefront::Control;

use crate::commands::Failure;

/// Whether the user pressed Ctrl-C.
pub(crate) struct Interrupt(Arc<Control>);

impl Interrupt {
    /// Listens from now on. Once in a process.
    pub(crate) fn listen() -> Result<Interrupt, Failure> {
        let control = Arc::new(Control::default());
        let heard = Arc::clone(&control);
        ctrlc::set_handler(move || {
            if heard.stopped() {
                process::exit(Failure::INTERRUPTED.into());
            }
            heard.stop();
        })
        .map_err(Failure::input)?;
        Ok(Interrupt(control))
    }

    /// Whether it was pressed.
    pub(crate) fn asked(&self) -> bool {
        self.0.stopped()
    }

    /// What stops in the middle of its first pass when it is pressed.
    pub(crate) fn control(&self) -> &Control {
        &self.0
    }
}
