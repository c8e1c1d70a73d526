//! What is measured: fields as tapes, sets of starts, an automaton.

use _kernel::condition::{Comparison, Condition};
use _kernel::flowpipe::Settings;
use _kernel::hybrid::{paced, Edge, Mode};
use _kernel::interval::Interval;
use _kernel::series::{Op, Tape};

pub fn interval(low: f64, high: f64) -> Interval {
    Interval::new(low, high).expect("ends in order")
}

fn number(x: f64) -> Op {
    Op::Constant(interval(x, x))
}

fn tape(ops: Vec<Op>, outputs: Vec<usize>, variables: usize) -> Tape {
    Tape::validated(ops, outputs, variables).expect("operands come first")
}

/// `x' = y`, `y' = (1 - x^2) y - x`.
pub fn van_der_pol() -> Tape {
    let ops =
        vec![Op::Variable(0), Op::Variable(1), Op::Mul(0, 0), number(1.0), Op::Sub(3, 2), Op::Mul(4, 1), Op::Sub(5, 0)];
    tape(ops, vec![1, 6], 2)
}

/// Seven coupled rates of degree two, as in the model of Laub and Loomis.
pub fn seven_rates() -> Tape {
    let mut ops: Vec<Op> = (0..7).map(Op::Variable).collect();
    ops.extend([1.4, 0.9, 2.0].map(number));
    let mut outputs = Vec::new();
    for v in 0..7 {
        let at = ops.len();
        ops.extend([Op::Mul(7, (v + 2) % 7), Op::Mul(v, (v + 1) % 7), Op::Mul(8, at + 1), Op::Sub(at, at + 2)]);
        outputs.push(at + 3);
    }
    tape(ops, outputs, 7)
}

/// `x' = v`, `v' = -sin(x)`.
pub fn pendulum() -> Tape {
    tape(vec![Op::Variable(0), Op::Variable(1), Op::Sin(0), Op::Cos(0), Op::Neg(2)], vec![1, 4], 2)
}

/// A ball that bounces: height, speed, time.
pub fn ball() -> Mode {
    let field = tape(vec![Op::Variable(1), number(-9.75), number(1.0)], vec![0, 1, 2], 3);
    let reset = vec![number(0.0), Op::Variable(1), number(-0.5), Op::Mul(1, 2), Op::Variable(2)];
    let edge = Edge {
        target: 0,
        is_urgent: true,
        guard: vec![(0, Comparison::AtMost), (1, Comparison::Less)],
        reset: tape(reset, vec![0, 3, 4], 3),
        choices: 0,
        landing: tape(vec![Op::Variable(1)], vec![0], 6),
        claim: Condition::Constant(true),
    };
    Mode {
        paced: paced(&field).expect("a tape"),
        field,
        watch: tape(vec![Op::Variable(0), Op::Variable(1)], vec![0, 1], 3),
        domain: vec![(0, Comparison::AtLeast)],
        rest: Condition::Constant(true),
        claim: Condition::Constant(true),
        window: Condition::Constant(true),
        edges: vec![edge],
    }
}

pub fn settings(order: usize, degree: usize) -> Settings {
    Settings {
        order,
        degree,
        tolerance: 1e-8,
        first_step: 0.02,
        longest_step: 0.2,
        least_step: 1e-9,
        steps: 2000,
        depth: 3,
    }
}
