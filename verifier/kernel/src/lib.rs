//! Numbers and sets with outward rounding: what is computed contains what is true.
//!
//! `interval` is built on `rounding` (operations) and `elementary` (functions), both of which round to nearest and
//! step outwards; `environment` tests that the unit does round to nearest; a `fault` travels where no number would
//! be true.
// The binding generates unsafe code; nothing else has any.
#![cfg_attr(not(feature = "python"), forbid(unsafe_code))]

#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
compile_error!("the rounding arguments of this crate hold for x86_64 and aarch64 only");

mod affine;
pub mod arena;
pub mod automaton;
pub mod chance;
mod chebyshev;
mod collocation;
mod comparison;
pub mod condition;
pub mod crossing;
mod decoupling;
pub mod dense;
pub mod duals;
pub mod elementary;
pub mod environment;
pub mod errors;
pub mod events;
pub mod fault;
mod flow;
pub mod flowpipe;
mod frame;
pub mod halt;
pub mod hybrid;
pub mod inputs;
mod instantly;
pub mod interval;
mod judging;
pub mod kinematics;
pub mod matrix;
pub mod models;
mod pacing;
pub mod path;
pub mod program;
#[cfg(feature = "python")]
mod python;
pub mod ratio;
pub mod recording;
pub mod robustness;
pub mod roots;
pub mod rounding;
pub mod rules;
pub mod runs;
pub mod series;
pub mod sets;
pub mod signal;
pub mod simulate;
#[cfg(feature = "python")]
mod simulate_python;
mod spreading;
mod step;
pub mod stepping;
mod stiff;
pub mod sweep;
pub mod tree;
#[cfg(feature = "python")]
mod tree_python;
mod walk;
pub mod zeno;
