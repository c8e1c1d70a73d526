//! A hybrid automaton as runs follow it: for each mode its program, domain and edges, in floats.

use crate::condition::Condition;
use crate::program::{atoms, Op, Program};

/// The value of a variable after a jump, from registers of the source mode.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Reset {
    To(usize, usize),
    /// Any value between two.
    Between(usize, usize, usize),
}

#[derive(Debug, Clone)]
pub struct Edge {
    pub target: usize,
    pub is_urgent: bool,
    /// Guard; without choices also that the outcome lies in the target's domain. Over registers of the source mode.
    pub enabled: Condition,
    pub resets: Vec<Reset>,
    /// Registers of the target for what is observed right after the jump; none: the same as during the stay.
    pub landing: Vec<usize>,
}

impl Edge {
    pub fn chooses(&self) -> bool {
        self.resets.iter().any(|r| matches!(r, Reset::Between(..)))
    }
}

#[derive(Debug, Clone)]
pub struct Mode {
    pub program: Program,
    pub domain: Condition,
    pub is_terminal: bool,
    /// Edges that leave it.
    pub edges: Vec<usize>,
    /// Registers whose series a record keeps, for formulas over runs.
    pub observed: Vec<usize>,
    /// Registers that domain and guards compare with zero.
    pub watched: Vec<usize>,
    /// Registers where an operation changes its branch.
    pub corners: Vec<usize>,
    /// For some registers the variable that is, at their zeros, exactly what another register says, or its negation.
    pub snaps: Vec<(usize, usize, Option<usize>, f64)>,
}

#[derive(Debug, Clone)]
pub struct Automaton {
    pub modes: Vec<Mode>,
    pub edges: Vec<Edge>,
    pub variables: usize,
    /// The variable that is the time since the start.
    pub clock: Option<usize>,
}

impl Mode {
    /// None where a condition reads a register that is not followed along the flow.
    pub fn prepared(
        program: Program,
        domain: Condition,
        is_terminal: bool,
        edges: Vec<usize>,
        observed: Vec<usize>,
        all: &[Edge],
    ) -> Option<Mode> {
        let mut watched = atoms(&domain);
        for &e in &edges {
            watched.extend(atoms(&all.get(e)?.enabled));
        }
        watched.sort_unstable();
        watched.dedup();
        if watched.iter().chain(&observed).any(|&r| r >= program.moving) {
            return None;
        }
        let corners = program.corners();
        let snaps = watched.iter().filter_map(|&r| snap(&program, r)).collect();
        Some(Mode { program, domain, is_terminal, edges, observed, watched, corners, snaps })
    }
}

/// What a variable is exactly where a register is zero.
fn snap(program: &Program, r: usize) -> Option<(usize, usize, Option<usize>, f64)> {
    let variable = |a: usize| match program.ops[a] {
        Op::Variable(v) if program.slopes[v].is_some() => Some(v),
        _ => None,
    };
    let is_still = |a: usize| matches!(program.ops[a], Op::Constant(_)) || program.is_still(a);
    match program.ops[r] {
        Op::Variable(_) => variable(r).map(|v| (r, v, None, 0.0)),
        Op::Sub(a, b) if is_still(b) => variable(a).map(|v| (r, v, Some(b), 1.0)),
        Op::Sub(a, b) if is_still(a) => variable(b).map(|v| (r, v, Some(a), 1.0)),
        Op::Add(a, b) if is_still(b) => variable(a).map(|v| (r, v, Some(b), -1.0)),
        _ => None,
    }
}
