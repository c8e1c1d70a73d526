//! What plain series are computed of: a list of operations in order of evaluation.
//!
//! The first part gives the right sides of the flow, the next the quantities that are watched, the last what is only
//! looked at. A corner (`abs`, `min`, `max`, a choice by condition) has branches.

use crate::condition::{Comparison, Condition};

/// One operation; operands are positions of earlier operations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Op {
    Constant(f64),
    Variable(usize),
    Add(usize, usize),
    Sub(usize, usize),
    Mul(usize, usize),
    Div(usize, usize),
    Neg(usize),
    Sqrt(usize),
    Exp(usize),
    Log(usize),
    /// A power with a number for exponent.
    Power(usize, f64),
    /// The sine; its operand's cosine is the next operation.
    Sin(usize),
    Cos(usize),
    /// The hyperbolic sine; its operand's cosine is the next operation.
    Sinh(usize),
    Cosh(usize),
    /// The hyperbolic tangent; one less its square is the next operation.
    Tanh(usize),
    Sech2(usize),
    /// A function with its derivative in the second register: `y' = a' q`.
    Atan(usize, usize),
    Asin(usize, usize),
    Acos(usize, usize),
    /// The angle of `(x, y)`, given as `(y, x, x / (x^2 + y^2), y / (x^2 + y^2))`.
    Turn(usize, usize, usize, usize),
    Abs(usize),
    /// The least or greatest of two, with their difference.
    Min(usize, usize, usize),
    Max(usize, usize, usize),
    /// One of two, by a condition of the program.
    Choose(usize, usize, usize),
}

#[derive(Debug, Clone, Default)]
pub struct Program {
    pub ops: Vec<Op>,
    /// How many operations the flow and what is watched need.
    pub moving: usize,
    /// For each variable the register of its slope; none: it stays what it is.
    pub slopes: Vec<Option<usize>>,
    /// Conditions of `Choose`; their atoms are registers.
    pub conditions: Vec<Condition>,
    /// Registers that never change along a flow.
    pub(crate) still: Vec<bool>,
    /// The others, of the moving part.
    pub(crate) active: Vec<usize>,
}

impl Program {
    /// None where an operand does not come before its use, or a register or variable does not exist.
    pub fn validated(
        ops: Vec<Op>,
        moving: usize,
        slopes: Vec<Option<usize>>,
        conditions: Vec<Condition>,
    ) -> Option<Program> {
        let mut still = Vec::with_capacity(ops.len());
        for (at, op) in ops.iter().enumerate() {
            let is_pair = |next: Op| ops.get(at + 1) == Some(&next);
            let sound = match *op {
                Op::Variable(v) => v < slopes.len(),
                Op::Sin(a) => is_pair(Op::Cos(a)),
                Op::Sinh(a) => is_pair(Op::Cosh(a)),
                Op::Tanh(a) => is_pair(Op::Sech2(a)),
                Op::Cos(_) | Op::Cosh(_) | Op::Sech2(_) => at > 0,
                Op::Choose(c, _, _) => c < conditions.len() && atoms(&conditions[c]).iter().all(|&a| a < at),
                _ => true,
            };
            if !sound || operands(*op).iter().any(|&a| a >= at) {
                return None;
            }
            still.push(match *op {
                Op::Constant(_) => true,
                Op::Variable(v) => slopes[v].is_none(),
                Op::Choose(c, a, b) => still[a] && still[b] && atoms(&conditions[c]).iter().all(|&a| still[a]),
                _ => operands(*op).iter().all(|&a| still[a]),
            });
        }
        let known = slopes.iter().flatten().all(|&s| s < moving) && moving <= ops.len();
        let active = (0..moving.min(ops.len())).filter(|&r| !still[r]).collect();
        known.then_some(Program { ops, moving, slopes, conditions, still, active })
    }

    /// Whether a register keeps its value along every flow.
    pub fn is_still(&self, register: usize) -> bool {
        self.still[register]
    }

    /// The registers at whose zeros an operation of the moving part changes its branch.
    pub fn corners(&self) -> Vec<usize> {
        let mut found = Vec::new();
        for op in &self.ops[..self.moving] {
            match *op {
                Op::Abs(a) => found.push(a),
                Op::Min(_, _, d) | Op::Max(_, _, d) => found.push(d),
                Op::Choose(c, _, _) => found.extend(atoms(&self.conditions[c])),
                _ => {}
            }
        }
        found.sort_unstable();
        found.dedup();
        found.retain(|&r| !self.still[r]);
        found
    }
}

/// The quantities a condition compares, by position.
pub fn atoms(condition: &Condition) -> Vec<usize> {
    match condition {
        Condition::Constant(_) => Vec::new(),
        Condition::Atom(at, _) => vec![*at],
        Condition::All(members) | Condition::Any(members) => members.iter().flat_map(atoms).collect(),
    }
}

/// The truth of a condition, by the signs of its quantities.
pub fn truth(condition: &Condition, sign: &impl Fn(usize) -> i8) -> bool {
    match condition {
        Condition::Constant(value) => *value,
        Condition::All(members) => members.iter().all(|m| truth(m, sign)),
        Condition::Any(members) => members.iter().any(|m| truth(m, sign)),
        Condition::Atom(at, comparison) => {
            let s = sign(*at);
            match comparison {
                Comparison::Less => s < 0,
                Comparison::AtMost => s <= 0,
                Comparison::Greater => s > 0,
                Comparison::AtLeast => s >= 0,
                Comparison::Equal => s == 0,
                Comparison::Differ => s != 0,
            }
        }
    }
}

pub(crate) fn operands(op: Op) -> Vec<usize> {
    match op {
        Op::Constant(_) | Op::Variable(_) => vec![],
        Op::Add(a, b) | Op::Sub(a, b) | Op::Mul(a, b) | Op::Div(a, b) => vec![a, b],
        Op::Atan(a, b) | Op::Asin(a, b) | Op::Acos(a, b) | Op::Choose(_, a, b) => vec![a, b],
        Op::Neg(a) | Op::Sqrt(a) | Op::Exp(a) | Op::Log(a) | Op::Power(a, _) | Op::Abs(a) => vec![a],
        Op::Sin(a) | Op::Cos(a) | Op::Sinh(a) | Op::Cosh(a) | Op::Tanh(a) | Op::Sech2(a) => vec![a],
        Op::Turn(a, b, c, d) => vec![a, b, c, d],
        Op::Min(a, b, c) | Op::Max(a, b, c) => vec![a, b, c],
    }
}

pub fn sign(x: f64) -> i8 {
    i8::from(x > 0.0) - i8::from(x < 0.0)
}
