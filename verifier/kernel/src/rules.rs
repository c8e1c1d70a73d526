//! Tapes as rules for the next coefficient of numbered registers.
//!
//! The first registers are the states, whose next coefficient is that of their rate, divided; those of the rules follow
//! in order. A rule reads lower coefficients of any register and equal ones of earlier registers.

use crate::interval::Interval;
use crate::series::{Function, Op, Tape};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// What a coefficient is multiplied by.
#[derive(Debug, Clone, Copy)]
pub enum Factor {
    One,
    Half,
    /// The sign over the order.
    Over(f64),
}

/// How the coefficient of order `k` of a register follows from others.
#[derive(Debug, Clone, Copy)]
pub enum Rule {
    Constant(Interval),
    /// `a_k + sign * b_k`.
    Combine {
        a: usize,
        b: usize,
        sign: f64,
    },
    /// The sum of `a_i b_(k-i)`, without the first and the last `i` if told so; times `i` if weighted.
    Products {
        a: usize,
        b: usize,
        first: usize,
        last: usize,
        weighted: bool,
    },
    Scaled {
        a: usize,
        by: Factor,
    },
    /// A number times `a_k`.
    Multiple {
        a: usize,
        by: Interval,
    },
    /// `a_k b_0`.
    Times {
        a: usize,
        b: usize,
    },
    /// `f(of_0)` first, then the coefficients of another register.
    Start {
        f: Function,
        of: usize,
        then: Option<(usize, Factor)>,
    },
}

/// The rules of a tape; register numbers follow those of the states.
pub struct Compiled {
    pub states: usize,
    pub rules: Vec<Rule>,
}

impl Compiled {
    /// The rules of a tape over as many states as it has outputs, and the registers of those.
    pub fn of(tape: &Tape) -> (Compiled, Vec<usize>) {
        let mut compiled = Compiled { states: tape.outputs.len(), rules: Vec::new() };
        let (mut at, mut numbers) = (Vec::with_capacity(tape.ops.len()), Vec::with_capacity(tape.ops.len()));
        for &op in &tape.ops {
            let number = folded(op, &numbers);
            at.push(match number {
                Some(value) => compiled.push(Rule::Constant(value)),
                None => compiled.multiple(op, &at, &numbers).unwrap_or_else(|| compiled.add(op, &at)),
            });
            numbers.push(number);
        }
        let rates = tape.outputs.iter().map(|&o| at[o]).collect();
        (compiled, rates)
    }

    fn push(&mut self, rule: Rule) -> usize {
        self.rules.push(rule);
        self.states + self.rules.len() - 1
    }

    /// How many registers there are.
    fn count(&self) -> usize {
        self.states + self.rules.len()
    }

    /// The register of a product with a number, or a quotient by one.
    fn multiple(&mut self, op: Op, at: &[usize], numbers: &[Option<Interval>]) -> Option<usize> {
        let (a, by) = match op {
            Op::Mul(a, b) => numbers[b].map(|by| (a, by)).or(numbers[a].map(|by| (b, by)))?,
            Op::Div(a, b) => (a, Interval::exactly(1.0).ok()?.div(numbers[b]?).ok()?),
            _ => return None,
        };
        Some(self.push(Rule::Multiple { a: at[a], by }))
    }

    /// The register of an operation whose operands are in the registers `at`.
    fn add(&mut self, op: Op, at: &[usize]) -> usize {
        let all = |a: usize, b: usize| Rule::Products { a, b, first: 0, last: 0, weighted: false };
        match op {
            Op::Constant(value) => self.push(Rule::Constant(value)),
            Op::Variable(v) => v,
            Op::Add(a, b) => self.push(Rule::Combine { a: at[a], b: at[b], sign: 1.0 }),
            Op::Sub(a, b) => self.push(Rule::Combine { a: at[a], b: at[b], sign: -1.0 }),
            Op::Neg(a) => self.push(Rule::Multiple { a: at[a], by: Interval::MINUS_ONE }),
            Op::Mul(a, b) => self.push(all(at[a], at[b])),
            Op::Div(a, b) => self.quotient(at[a], at[b]),
            Op::Sqrt(a) => self.root(at[a]),
            Op::Exp(a) => {
                let it = self.count() + 1;
                self.wave(Function::Exp, at[a], it, 1.0)
            }
            Op::Log(a) => self.logarithm(at[a]),
            // A sine's register is two before its cosine's, each after its own sum.
            Op::Sin(a) => {
                let cosine = self.count() + 3;
                self.wave(Function::Sin, at[a], cosine, 1.0)
            }
            Op::Cos(a) => {
                let sine = self.count() - 1;
                self.wave(Function::Cos, at[a], sine, -1.0)
            }
        }
    }

    /// `f(a)` where `f'(a)` is `sign` times another register.
    fn wave(&mut self, f: Function, a: usize, slope: usize, sign: f64) -> usize {
        let sum = self.push(Rule::Products { a, b: slope, first: 1, last: 0, weighted: true });
        self.push(Rule::Start { f, of: a, then: Some((sum, Factor::Over(sign))) })
    }

    fn quotient(&mut self, a: usize, b: usize) -> usize {
        let inverse = self.push(Rule::Start { f: Function::Reciprocal, of: b, then: None });
        let it = self.count() + 2;
        let known = self.push(Rule::Products { a: it, b, first: 0, last: 1, weighted: false });
        let top = self.push(Rule::Combine { a, b: known, sign: -1.0 });
        self.push(Rule::Times { a: top, b: inverse })
    }

    fn root(&mut self, a: usize) -> usize {
        let it = self.count() + 3;
        let known = self.push(Rule::Products { a: it, b: it, first: 1, last: 1, weighted: false });
        let top = self.push(Rule::Combine { a, b: known, sign: -1.0 });
        let rest = self.push(Rule::Times { a: top, b: it + 1 });
        let root = self.push(Rule::Start { f: Function::Sqrt, of: a, then: Some((rest, Factor::Half)) });
        self.push(Rule::Start { f: Function::Reciprocal, of: root, then: None });
        root
    }

    fn logarithm(&mut self, a: usize) -> usize {
        let inverse = self.push(Rule::Start { f: Function::Reciprocal, of: a, then: None });
        let it = self.count() + 4;
        let sum = self.push(Rule::Products { a: it, b: a, first: 1, last: 1, weighted: true });
        let known = self.push(Rule::Scaled { a: sum, by: Factor::Over(1.0) });
        let top = self.push(Rule::Combine { a, b: known, sign: -1.0 });
        let rest = self.push(Rule::Times { a: top, b: inverse });
        self.push(Rule::Start { f: Function::Log, of: a, then: Some((rest, Factor::One)) })
    }
}

/// The value of an operation on numbers; `None` if an operand is none, or there is no value (that is found out later).
fn folded(op: Op, numbers: &[Option<Interval>]) -> Option<Interval> {
    let value = match op {
        Op::Constant(value) => return Some(value),
        Op::Variable(_) => return None,
        Op::Add(a, b) => numbers[a]?.add(numbers[b]?),
        Op::Sub(a, b) => numbers[a]?.sub(numbers[b]?),
        Op::Mul(a, b) => numbers[a]?.mul(numbers[b]?),
        Op::Div(a, b) => numbers[a]?.div(numbers[b]?),
        Op::Neg(a) => numbers[a]?.neg(),
        Op::Sqrt(a) => numbers[a]?.sqrt(),
        Op::Exp(a) => numbers[a]?.exp(),
        Op::Log(a) => numbers[a]?.log(),
        // Whether both or none of a pair are numbers depends on the operand alone: sines always have a value.
        Op::Sin(a) => numbers[a]?.sin(),
        Op::Cos(a) => numbers[a]?.cos(),
    };
    value.ok()
}

/// For every register the states it depends on, one by one; with or without what states owe each other over time.
pub fn dependence(compiled: &Compiled, rates: &[usize], over_time: bool) -> Vec<Vec<bool>> {
    let n = compiled.states;
    let mut known: Vec<Vec<bool>> = (0..compiled.count()).map(|r| (0..n).map(|v| r == v).collect()).collect();
    loop {
        let before = known.clone();
        for (i, rule) in compiled.rules.iter().enumerate() {
            let from = match *rule {
                Rule::Constant(_) => vec![],
                Rule::Scaled { a, .. } | Rule::Multiple { a, .. } => vec![a],
                Rule::Combine { a, b, .. } | Rule::Products { a, b, .. } | Rule::Times { a, b } => vec![a, b],
                Rule::Start { of, then, .. } => then.map_or(vec![of], |(rest, _)| vec![of, rest]),
            };
            from.into_iter().for_each(|r| joined(&mut known, n + i, r));
        }
        if over_time {
            rates.iter().enumerate().for_each(|(v, &r)| joined(&mut known, v, r));
        }
        if known == before {
            return known;
        }
    }
}

fn joined(known: &mut [Vec<bool>], to: usize, from: usize) {
    for v in 0..known[to].len() {
        known[to][v] |= known[from][v];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn operations_on_numbers_are_done_once_and_products_with_them_are_multiples() {
        let number = |low, high| Op::Constant(Interval::new(low, high).expect("in order"));
        let ops =
            vec![number(1.0, 2.0), number(4.0, 4.0), Op::Div(0, 1), Op::Variable(0), Op::Mul(3, 2), Op::Div(4, 1)];
        let tape = Tape::validated(ops, vec![5], 1).expect("operands come first");
        let (compiled, rates) = Compiled::of(&tape);
        assert_eq!(rates, [compiled.states + compiled.rules.len() - 1]);
        let factors =
            compiled.rules.iter().filter_map(|r| if let Rule::Multiple { by, .. } = r { Some(*by) } else { None });
        let quarter = |low, high| Interval::new(low / 4.0, high / 4.0).expect("in order");
        assert_eq!(factors.collect::<Vec<_>>(), [quarter(1.0, 2.0), quarter(1.0, 1.0)]);
    }

    #[test]
    fn a_division_by_zero_is_left_for_later() {
        let ops = vec![Op::Constant(Interval::ZERO), Op::Div(0, 0), Op::Variable(0), Op::Div(2, 0)];
        let (compiled, _) = Compiled::of(&Tape::validated(ops, vec![3], 1).expect("operands come first"));
        let starts = compiled.rules.iter().filter(|r| matches!(r, Rule::Start { f: Function::Reciprocal, .. }));
        assert_eq!(starts.count(), 2);
    }
}
