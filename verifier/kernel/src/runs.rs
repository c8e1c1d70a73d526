//! What a run is asked for and what it was: plans, the pieces and jumps of a run, how it ended.

use crate::chance::Chance;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Policy {
    Earliest,
    Latest,
    Random,
}

/// A value given to a variable at a time: how inputs move.
#[derive(Debug, Clone, Copy)]
pub struct Write {
    pub time: f64,
    pub variable: usize,
    pub value: f64,
}

#[derive(Debug, Clone)]
pub struct Plan {
    pub mode: usize,
    pub state: Vec<f64>,
    pub horizon: f64,
    pub jumps: usize,
    pub steps: usize,
    pub order: usize,
    pub policy: Policy,
    pub chance: Chance,
    /// In order of time.
    pub writes: Vec<Write>,
    pub keeps_pieces: bool,
}

/// A step of a run: the series of the state and of what is observed, from its start on.
#[derive(Debug, Clone)]
pub struct Piece {
    pub mode: usize,
    pub jumps: usize,
    pub start: f64,
    pub length: f64,
    pub order: usize,
    pub states: Vec<f64>,
    pub observed: Vec<f64>,
    /// The instant after a jump, at which a formula may mean something else than afterwards.
    pub is_landing: bool,
}

impl Piece {
    /// How many coefficients a series of it has.
    pub fn width(&self) -> usize {
        self.order + 1
    }
}

#[derive(Debug, Clone)]
pub struct Jump {
    pub time: f64,
    pub edge: usize,
    pub before: Vec<f64>,
    pub after: Vec<f64>,
}

#[derive(Debug, Clone, PartialEq)]
pub enum End {
    Horizon,
    Jumps,
    Steps,
    /// The start is outside the domain.
    Outside,
    /// No time can pass and no edge is enabled.
    Stuck,
    /// The same in a terminal mode.
    Ended,
    /// Jumps accumulate at a time.
    Zeno(f64),
    /// The state leaves all bounds, or a slope becomes infinite.
    Escape,
    /// Something in the flow has no value.
    Undefined,
}

#[derive(Debug, Clone)]
pub struct Run {
    pub pieces: Vec<Piece>,
    pub jumps: Vec<Jump>,
    pub end: End,
    pub time: f64,
    pub mode: usize,
    pub state: Vec<f64>,
    /// How many were taken, those of no length included.
    pub steps: usize,
}
