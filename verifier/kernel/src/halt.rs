//! A request to give up: flowpipes look at it before each step.
//!
//! Nothing wrong comes of a halt at any instant: what was not followed is a fault, and a fault shows nothing.

use crate::fault::Fault;
use std::sync::atomic::{AtomicBool, Ordering};

static HALTED: AtomicBool = AtomicBool::new(false);

/// Ask all analyses of this process to give up, or let them go on again.
pub fn halt(is_halted: bool) {
    HALTED.store(is_halted, Ordering::Relaxed);
}

/// A fault while giving up is asked for.
pub fn allowed() -> Result<(), Fault> {
    if HALTED.load(Ordering::Relaxed) {
        return Err(Fault::Halted);
    }
    Ok(())
}
