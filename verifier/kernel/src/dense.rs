//! Plain Taylor series in time of a flow, in floats: nothing here encloses anything.
//!
//! The recursions are those of `series`, on floats and for more functions (A. Griewank, A. Walther, Evaluating
//! Derivatives, chapter 13). A corner of the `program` follows one of its branches through a step; the caller ends the
//! step where that branch ends.

use crate::program::{sign, truth, Op, Program};

/// The series of every register and variable along one step.
#[derive(Debug, Default)]
pub struct Jets {
    pub order: usize,
    pub registers: Vec<f64>,
    pub states: Vec<f64>,
    /// Registers that count as zero at the start of the step, whatever rounding left there.
    pub zeroed: Vec<usize>,
    /// Signs right after the start of registers that are zero there: a choice may jump.
    pub ahead: Vec<(usize, i8)>,
}

impl Jets {
    #[inline]
    pub fn register(&self, r: usize) -> &[f64] {
        &self.registers[r * (self.order + 1)..(r + 1) * (self.order + 1)]
    }

    pub fn state(&self, v: usize) -> &[f64] {
        &self.states[v * (self.order + 1)..(v + 1) * (self.order + 1)]
    }

    /// The series from a state, to an order.
    pub fn expand(&mut self, program: &Program, start: &[f64], order: usize) {
        self.order = order;
        let width = order + 1;
        self.registers.clear();
        self.registers.resize(program.moving * width, 0.0);
        self.states.clear();
        self.states.resize(start.len() * width, 0.0);
        for (v, &x) in start.iter().enumerate() {
            self.states[v * width] = x;
        }
        for at in 0..program.moving {
            self.registers[at * width] = self.coefficient(program, at, 0);
        }
        for k in 0..=order {
            if k > 0 {
                for &at in &program.active {
                    self.registers[at * width + k] = self.coefficient(program, at, k);
                }
            }
            if k < order {
                for (v, slope) in program.slopes.iter().enumerate() {
                    if let Some(r) = slope {
                        self.states[v * width + k + 1] = self.registers[r * width + k] / (k + 1) as f64;
                    }
                }
            }
        }
    }

    /// The values of all registers at a state, those that are only looked at included.
    pub fn values(program: &Program, state: &[f64]) -> Vec<f64> {
        let mut jets = Jets { order: 0, registers: vec![0.0; program.ops.len()], ..Jets::default() };
        jets.states = state.to_vec();
        for at in 0..program.ops.len() {
            jets.registers[at] = jets.coefficient(program, at, 0);
        }
        jets.registers
    }

    /// Whether the slopes have series of numbers; None where they have no value at all.
    pub fn defined(&self, program: &Program) -> Option<bool> {
        let mut slopes = program.slopes.iter().flatten().map(|&r| self.register(r));
        if slopes.clone().any(|s| s[0].is_nan()) {
            return None;
        }
        Some(slopes.all(|s| s.iter().all(|c| c.is_finite())))
    }

    #[inline]
    fn coefficient(&self, program: &Program, at: usize, k: usize) -> f64 {
        let own = self.register(at);
        match program.ops[at] {
            Op::Constant(c) => {
                if k == 0 {
                    c
                } else {
                    0.0
                }
            }
            Op::Variable(v) => self.state(v)[k],
            Op::Add(a, b) => self.register(a)[k] + self.register(b)[k],
            Op::Sub(a, b) => self.register(a)[k] - self.register(b)[k],
            Op::Neg(a) => -self.register(a)[k],
            Op::Mul(a, b) if program.still[a] => self.register(a)[0] * self.register(b)[k],
            Op::Mul(a, b) if program.still[b] => self.register(a)[k] * self.register(b)[0],
            Op::Mul(a, b) => convolved(self.register(a), self.register(b), 0, k, k),
            Op::Div(a, b) if program.still[b] => self.register(a)[k] / self.register(b)[0],
            Op::Div(a, b) => {
                let (a, b) = (self.register(a), self.register(b));
                let carried = if k == 0 { 0.0 } else { convolved(own, b, 0, k - 1, k) };
                (a[k] - carried) / b[0]
            }
            Op::Sqrt(a) => {
                let a = self.register(a);
                if k == 0 {
                    return a[0].sqrt();
                }
                let cross = if k < 2 { 0.0 } else { convolved(own, own, 1, k - 1, k) };
                if a[0] == 0.0 && a[k] == 0.0 && cross == 0.0 {
                    0.0
                } else {
                    (a[k] - cross) / (2.0 * own[0])
                }
            }
            Op::Exp(a) => self.primitive(a, own, k, f64::exp),
            Op::Log(a) => {
                let a = self.register(a);
                if k == 0 {
                    a[0].ln()
                } else {
                    (a[k] - weighted(own, a, 1, k - 1, k) / k as f64) / a[0]
                }
            }
            Op::Power(a, c) => self.power(a, own, c, k),
            Op::Sin(a) => self.primitive(a, self.register(at + 1), k, f64::sin),
            Op::Cos(a) => {
                let found = self.primitive(a, self.register(at - 1), k, f64::cos);
                if k == 0 {
                    found
                } else {
                    -found
                }
            }
            Op::Sinh(a) => self.primitive(a, self.register(at + 1), k, f64::sinh),
            Op::Cosh(a) => self.primitive(a, self.register(at - 1), k, f64::cosh),
            Op::Tanh(a) => self.primitive(a, self.register(at + 1), k, f64::tanh),
            Op::Sech2(_) => {
                let square = convolved(self.register(at - 1), self.register(at - 1), 0, k, k);
                if k == 0 {
                    1.0 - square
                } else {
                    -square
                }
            }
            Op::Atan(a, q) => self.primitive(a, self.register(q), k, f64::atan),
            Op::Asin(a, q) => self.primitive(a, self.register(q), k, f64::asin),
            Op::Acos(a, q) => self.primitive(a, self.register(q), k, f64::acos),
            Op::Turn(y, x, u, v) => {
                let (y, x) = (self.register(y), self.register(x));
                if k == 0 {
                    return y[0].atan2(x[0]);
                }
                (weighted(y, self.register(u), 1, k, k) - weighted(x, self.register(v), 1, k, k)) / k as f64
            }
            Op::Abs(a) => {
                if self.leading(a, k) < 0 {
                    -self.register(a)[k]
                } else {
                    self.register(a)[k]
                }
            }
            Op::Min(a, b, d) => self.register(if self.leading(d, k) > 0 { b } else { a })[k],
            Op::Max(a, b, d) => self.register(if self.leading(d, k) < 0 { b } else { a })[k],
            Op::Choose(c, a, b) => {
                let holds = truth(&program.conditions[c], &|r| self.leading(r, k));
                self.register(if holds { a } else { b })[k]
            }
        }
    }

    /// The coefficient of `f(a)` whose derivative is `q a'`.
    fn primitive(&self, a: usize, q: &[f64], k: usize, f: fn(f64) -> f64) -> f64 {
        let a = self.register(a);
        if k == 0 {
            f(a[0])
        } else {
            weighted(a, q, 1, k, k) / k as f64
        }
    }

    fn power(&self, a: usize, own: &[f64], c: f64, k: usize) -> f64 {
        let a = self.register(a);
        if k == 0 {
            return a[0].powf(c);
        }
        let sum: f64 = (1..=k).map(|i| (c * i as f64 - (k - i) as f64) * a[i] * own[k - i]).sum();
        if sum == 0.0 {
            0.0
        } else {
            sum / (k as f64 * a[0])
        }
    }

    /// The sign of a register right after the start of the step, as far as coefficients up to `k` tell.
    pub fn leading(&self, r: usize, k: usize) -> i8 {
        let from = usize::from(self.zeroed.contains(&r));
        let told = self.register(r).get(from..=k).unwrap_or(&[]).iter().map(|&c| sign(c)).find(|&s| s != 0);
        told.unwrap_or_else(|| self.ahead.iter().find(|known| known.0 == r).map_or(0, |known| known.1))
    }

    /// Note the signs right after the start that its values do not tell; true where there are some.
    pub fn looks_ahead(&mut self, corners: &[usize]) -> bool {
        let unknown = corners.iter().filter(|&&r| self.leading(r, 0) == 0);
        let found = unknown.map(|&r| (r, self.leading(r, self.order))).filter(|f| f.1 != 0).collect();
        self.ahead = found;
        !self.ahead.is_empty()
    }
}

/// The sum of `a_i b_(k-i)` over a range of `i`.
fn convolved(a: &[f64], b: &[f64], from: usize, to: usize, k: usize) -> f64 {
    let (a, b) = (&a[from..to + 1], &b[k - to..k - from + 1]);
    let mut sums = [0.0; 2];
    for (i, (x, y)) in a.iter().zip(b.iter().rev()).enumerate() {
        sums[i % 2] += x * y;
    }
    sums[0] + sums[1]
}

/// The sum of `i a_i b_(k-i)` over a range of `i`.
fn weighted(a: &[f64], b: &[f64], from: usize, to: usize, k: usize) -> f64 {
    if from > to {
        return 0.0;
    }
    let (a, b) = (&a[from..to + 1], &b[k - to..k - from + 1]);
    let mut sums = [0.0; 2];
    for (i, ((x, y), n)) in a.iter().zip(b.iter().rev()).zip(&COUNTS[from..]).enumerate() {
        sums[i % 2] += n * x * y;
    }
    sums[0] + sums[1]
}

/// Small numbers as floats.
const COUNTS: [f64; 64] = {
    let mut counts = [0.0; 64];
    let mut i = 0;
    while i < 64 {
        counts[i] = i as f64;
        i += 1;
    }
    counts
};

/// How far rounding may have moved each register at a state whose entries are off by `errors`, to first order.
pub fn rounding(program: &Program, values: &[f64], errors: &[f64]) -> Vec<f64> {
    let mut found: Vec<f64> = Vec::with_capacity(values.len());
    for (at, op) in program.ops.iter().enumerate().take(values.len()) {
        let own = f64::EPSILON * values[at].abs();
        let e = |a: usize| found[a];
        let x = |a: usize| values[a].abs();
        found.push(match *op {
            Op::Constant(_) => own,
            Op::Variable(v) => errors[v],
            Op::Add(a, b) | Op::Sub(a, b) => e(a) + e(b) + own,
            Op::Mul(a, b) => x(a) * e(b) + x(b) * e(a) + own,
            Op::Div(a, b) => (e(a) + x(at) * e(b)) / x(b) + own,
            Op::Neg(a) | Op::Abs(a) => e(a),
            Op::Sqrt(a) => {
                if x(at) > 0.0 {
                    e(a) / (2.0 * x(at)) + own
                } else {
                    e(a).sqrt()
                }
            }
            Op::Exp(a) => x(at) * e(a) + own,
            Op::Log(a) => e(a) / x(a) + own,
            Op::Power(a, c) => (c * values[at] / values[a]).abs() * e(a) + own,
            Op::Sin(a) | Op::Cos(a) | Op::Tanh(a) | Op::Sech2(a) => e(a) + f64::EPSILON,
            Op::Sinh(a) | Op::Cosh(a) => values[a].cosh() * e(a) + own,
            Op::Atan(a, q) | Op::Asin(a, q) | Op::Acos(a, q) => x(q) * e(a) + own,
            Op::Turn(y, x_, u, v) => x(u) * e(y) + x(v) * e(x_) + own,
            Op::Min(a, b, _) | Op::Max(a, b, _) | Op::Choose(_, a, b) => e(a).max(e(b)),
        });
    }
    found
}

/// The value of a series after a time.
pub fn at(series: &[f64], t: f64) -> f64 {
    series.iter().rev().fold(0.0, |sum, c| sum * t + c)
}
