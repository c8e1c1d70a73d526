//! What is known of the states during one step: the series in time, its last term, the moved errors.

use crate::fault::Fault;
use crate::interval::Interval;
use crate::models::{Model, Space};
use crate::series::Ring;
use std::ops::{Add, Mul};
use std::sync::Arc;

/// A step of length `h`: every state from the set at its start is, `t` later, in the series at `t`, the last term times
/// a power of `t`, and the errors as far as they move.
#[derive(Debug, Clone)]
pub struct Path {
    pub h: f64,
    pub space: Arc<Space>,
    /// The series in time by variable: coefficients that are models of the set.
    pub series: Arc<Vec<Vec<Model>>>,
    /// The coefficients of the term after the last of the series, at any instant of the step.
    pub lagrange: Vec<Interval>,
    /// Bounds of what the errors at the start of the step are at any instant of it.
    pub moved: Vec<f64>,
}

impl Path {
    pub fn order(&self) -> usize {
        self.series[0].len() - 1
    }

    /// The first states at instants `t` of the step, with all errors in their radius; zero in place of those not wanted.
    pub fn states(&self, t: Interval, count: usize, wanted: &[bool]) -> Result<Vec<Model>, Fault> {
        let order = self.order();
        let powers: Vec<Interval> = (0..=order as i32).map(|i| t.powi(i)).collect::<Result<_, _>>()?;
        let last = t.powi(order as i32 + 1)?;
        let state = |v: usize| {
            if !is_wanted(wanted, v) {
                return Ok(self.space.zero());
            }
            let model = self.space.combination(&self.series[v], &powers)?;
            self.space.shifted(&model, self.rest(v, last)?)
        };
        (0..count.min(self.series.len())).map(state).collect()
    }

    /// The same at instants of the step that depend on the set variables.
    pub fn states_at(&self, t: &Model, count: usize, wanted: &[bool]) -> Result<Vec<Model>, Fault> {
        let space = &self.space;
        let last = space.range(t)?.powi(self.order() as i32 + 1)?;
        let state = |v: usize| {
            if !is_wanted(wanted, v) {
                return Ok(space.zero());
            }
            let (highest, rest) = self.series[v].split_last().ok_or(Fault::Unknown)?;
            let sum = rest.iter().rev().try_fold(highest.clone(), |sum, c| space.add(&space.mul(&sum, t)?, c))?;
            space.shifted(&sum, self.rest(v, last)?)
        };
        (0..count.min(self.series.len())).map(state).collect()
    }

    fn rest(&self, v: usize, power: Interval) -> Result<Interval, Fault> {
        power.mul(self.lagrange[v])?.add(Interval::symmetric(self.moved[v])?)
    }
}

/// Whether a state is wanted: what nothing is said about is.
fn is_wanted(wanted: &[bool], v: usize) -> bool {
    wanted.get(v).copied().unwrap_or(true)
}
