//! Expressions compiled to a tape, and the Taylor series in time that a tape yields over any ring of coefficients.
//!
//! A ring is where coefficients live: intervals (`IntervalRing`), intervals with derivatives (`DualRing`), Taylor
//! models (`models::Space`). One recursion serves them all: `Jet::extend` computes the next coefficient of every
//! register from the lower ones (A. Griewank, A. Walther, Evaluating Derivatives, chapter 13).

use crate::fault::Fault;
use crate::interval::{Enclosure, Interval};
use std::ops::{Add, Div, Mul, Neg, Sub};

/// One operation; operands are positions of earlier operations on the tape.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Op {
    Constant(Interval),
    Variable(usize),
    Add(usize, usize),
    Sub(usize, usize),
    Mul(usize, usize),
    Div(usize, usize),
    Neg(usize),
    Sqrt(usize),
    Exp(usize),
    Log(usize),
    /// The sine; its operand's cosine is the next operation.
    Sin(usize),
    /// The cosine; the sine of the same operand is the operation before it.
    Cos(usize),
}

/// Operations in order of evaluation, and the positions of the results.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Tape {
    pub ops: Vec<Op>,
    pub outputs: Vec<usize>,
}

impl Tape {
    /// Checks that operands come before their use, that sines and cosines stand in pairs, and that variables exist.
    pub fn validated(ops: Vec<Op>, outputs: Vec<usize>, variables: usize) -> Result<Tape, Fault> {
        for (at, op) in ops.iter().enumerate() {
            let good = match *op {
                Op::Constant(_) => true,
                Op::Variable(v) => v < variables,
                Op::Add(a, b) | Op::Sub(a, b) | Op::Mul(a, b) | Op::Div(a, b) => a < at && b < at,
                Op::Neg(a) | Op::Sqrt(a) | Op::Exp(a) | Op::Log(a) => a < at,
                Op::Sin(a) => a < at && ops.get(at + 1) == Some(&Op::Cos(a)),
                Op::Cos(a) => at > 0 && ops[at - 1] == Op::Sin(a),
            };
            if !good {
                return Err(Fault::Unknown);
            }
        }
        if outputs.iter().all(|&o| o < ops.len()) {
            Ok(Tape { ops, outputs })
        } else {
            Err(Fault::Unknown)
        }
    }
}

/// Where the coefficients of a series live. Every operation encloses the exact one.
pub trait Ring {
    type Element: Clone + 'static;

    fn constant(&self, value: Interval) -> Self::Element;
    fn add(&self, a: &Self::Element, b: &Self::Element) -> Result<Self::Element, Fault>;
    fn sub(&self, a: &Self::Element, b: &Self::Element) -> Result<Self::Element, Fault>;
    fn scale(&self, a: &Self::Element, by: Interval) -> Result<Self::Element, Fault>;
    /// The sum of `w a b` over the terms `(w, a, b)`.
    fn sum<'e>(&self, terms: impl Iterator<Item = Term<'e, Self::Element>> + Clone) -> Result<Self::Element, Fault>;
    fn apply(&self, f: Function, a: &Self::Element) -> Result<Self::Element, Fault>;

    fn mul(&self, a: &Self::Element, b: &Self::Element) -> Result<Self::Element, Fault> {
        self.sum(std::iter::once((1.0, a, b)))
    }
}

/// A weighted product.
pub type Term<'e, E> = (f64, &'e E, &'e E);

/// The products `a_i b_(k-i)` for `i` in a range, each with its weight: `i` if `weighted`, else 1.
fn products<'e, E>(
    a: &'e [E],
    b: &'e [E],
    k: usize,
    range: std::ops::RangeInclusive<usize>,
    weighted: bool,
) -> impl Iterator<Item = Term<'e, E>> + Clone {
    range.map(move |i| (if weighted { i as f64 } else { 1.0 }, &a[i], &b[k - i]))
}

/// The functions of one argument that start a series.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Function {
    Reciprocal,
    Sqrt,
    Exp,
    Log,
    Sin,
    Cos,
}

impl Function {
    /// Its value on an interval.
    pub fn at(self, x: Interval) -> Enclosure {
        match self {
            Function::Reciprocal => Interval::exactly(1.0)?.div(x),
            Function::Sqrt => x.sqrt(),
            Function::Exp => x.exp(),
            Function::Log => x.log(),
            Function::Sin => x.sin(),
            Function::Cos => x.cos(),
        }
    }

    /// Its `k`-th Taylor coefficient `f^(k)(x) / k!` on an interval.
    pub fn coefficient(self, x: Interval, k: u32) -> Enclosure {
        if k == 0 {
            return self.at(x);
        }
        let count = Interval::exactly(f64::from(k))?;
        let inverse_factorial = || -> Enclosure {
            (2..=k).try_fold(Interval::exactly(1.0)?, |f, i| f.div(Interval::exactly(f64::from(i))?))
        };
        match self {
            Function::Reciprocal => {
                let power = x.powi(-(k as i32) - 1)?;
                if k.is_multiple_of(2) {
                    Ok(power)
                } else {
                    power.neg()
                }
            }
            Function::Log => {
                let power = x.powi(-(k as i32))?.div(count)?;
                if k.is_multiple_of(2) {
                    power.neg()
                } else {
                    Ok(power)
                }
            }
            Function::Exp => x.exp()?.mul(inverse_factorial()?),
            Function::Sqrt => {
                // The binomial coefficient of one half over k, times x^(1/2 - k).
                let mut binomial = Interval::exactly(1.0)?;
                for i in 0..k {
                    let top = Interval::exactly(0.5 - f64::from(i))?;
                    binomial = binomial.mul(top)?.div(Interval::exactly(f64::from(i + 1))?)?;
                }
                if x.low() <= 0.0 {
                    return Err(Fault::Domain);
                }
                binomial.mul(x.sqrt()?)?.mul(x.powi(-(k as i32))?)
            }
            Function::Sin | Function::Cos => {
                let quarter = if self == Function::Sin { k % 4 } else { (k + 1) % 4 };
                let wave = match quarter {
                    0 => x.sin()?,
                    1 => x.cos()?,
                    2 => x.sin()?.neg()?,
                    _ => x.cos()?.neg()?,
                };
                wave.mul(inverse_factorial()?)
            }
        }
    }
}

/// The series of every register of a tape along the flow, up to the order computed so far.
pub struct Jet<'a, R: Ring> {
    ring: &'a R,
    tape: &'a Tape,
    registers: Vec<Vec<R::Element>>,
    /// The inverse of a divisor, root or argument of a logarithm at order zero, by register.
    inverses: Vec<Option<R::Element>>,
}

impl<'a, R: Ring> Jet<'a, R> {
    pub fn new(ring: &'a R, tape: &'a Tape) -> Self {
        let size = tape.ops.len();
        Jet { ring, tape, registers: vec![Vec::new(); size], inverses: vec![None; size] }
    }

    /// The coefficients of output `i`.
    pub fn output(&self, i: usize) -> &[R::Element] {
        &self.registers[self.tape.outputs[i]]
    }

    /// Compute the next coefficient of every register; `variables[v]` holds those of variable `v` up to that order.
    pub fn extend(&mut self, variables: &[Vec<R::Element>]) -> Result<(), Fault> {
        for at in 0..self.tape.ops.len() {
            let next = self.next(at, variables)?;
            self.registers[at].push(next);
        }
        Ok(())
    }

    fn next(&mut self, at: usize, variables: &[Vec<R::Element>]) -> Result<R::Element, Fault> {
        let (ring, k) = (self.ring, self.registers[at].len());
        let zero = || Interval::exactly(0.0).map(|z| ring.constant(z));
        match self.tape.ops[at] {
            Op::Constant(value) if k == 0 => Ok(ring.constant(value)),
            Op::Constant(_) => zero(),
            Op::Variable(v) => Ok(variables[v][k].clone()),
            Op::Add(a, b) => ring.add(&self.registers[a][k], &self.registers[b][k]),
            Op::Sub(a, b) => ring.sub(&self.registers[a][k], &self.registers[b][k]),
            Op::Neg(a) => ring.sub(&zero()?, &self.registers[a][k]),
            Op::Mul(a, b) => ring.sum(products(&self.registers[a], &self.registers[b], k, 0..=k, false)),
            Op::Div(a, b) => self.quotient(at, a, b, k),
            Op::Sqrt(a) => self.root(at, a, k),
            Op::Exp(a) if k == 0 => ring.apply(Function::Exp, &self.registers[a][0]),
            Op::Exp(a) => self.weighted(a, at, k, 1.0),
            Op::Log(a) => self.logarithm(at, a, k),
            Op::Sin(a) if k == 0 => ring.apply(Function::Sin, &self.registers[a][0]),
            Op::Sin(a) => self.weighted(a, at + 1, k, 1.0),
            Op::Cos(a) if k == 0 => ring.apply(Function::Cos, &self.registers[a][0]),
            Op::Cos(a) => self.weighted(a, at - 1, k, -1.0),
        }
    }

    /// `sign / k` times the sum of `i a_i b_(k-i)` for `i` in `1..=k`.
    fn weighted(&self, a: usize, b: usize, k: usize, sign: f64) -> Result<R::Element, Fault> {
        let sum = self.ring.sum(products(&self.registers[a], &self.registers[b], k, 1..=k, true))?;
        self.ring.scale(&sum, Interval::exactly(sign)?.div(Interval::exactly(k as f64)?)?)
    }

    fn inverse(&mut self, at: usize, of: usize) -> Result<R::Element, Fault> {
        if self.inverses[at].is_none() {
            self.inverses[at] = Some(self.ring.apply(Function::Reciprocal, &self.registers[of][0])?);
        }
        self.inverses[at].clone().ok_or(Fault::Unknown)
    }

    fn quotient(&mut self, at: usize, a: usize, b: usize, k: usize) -> Result<R::Element, Fault> {
        let inverse = self.inverse(at, b)?;
        let mut top = self.registers[a][k].clone();
        if k > 0 {
            // b_(k-i) stands second, so the quotient's own coefficients are the first factor.
            let known = self.ring.sum(products(&self.registers[at], &self.registers[b], k, 0..=k - 1, false))?;
            top = self.ring.sub(&top, &known)?;
        }
        self.ring.mul(&top, &inverse)
    }

    fn root(&mut self, at: usize, a: usize, k: usize) -> Result<R::Element, Fault> {
        if k == 0 {
            return self.ring.apply(Function::Sqrt, &self.registers[a][0]);
        }
        let inverse = self.inverse(at, at)?;
        let mut top = self.registers[a][k].clone();
        if k > 1 {
            let known = self.ring.sum(products(&self.registers[at], &self.registers[at], k, 1..=k - 1, false))?;
            top = self.ring.sub(&top, &known)?;
        }
        self.ring.scale(&self.ring.mul(&top, &inverse)?, Interval::exactly(0.5)?)
    }

    fn logarithm(&mut self, at: usize, a: usize, k: usize) -> Result<R::Element, Fault> {
        if k == 0 {
            return self.ring.apply(Function::Log, &self.registers[a][0]);
        }
        let inverse = self.inverse(at, a)?;
        let mut top = self.registers[a][k].clone();
        if k > 1 {
            let known = self.ring.sum(products(&self.registers[at], &self.registers[a], k, 1..=k - 1, true))?;
            top = self.ring.sub(&top, &self.ring.scale(&known, Interval::exactly(1.0 / k as f64)?.widened()?)?)?;
        }
        self.ring.mul(&top, &inverse)
    }
}

/// The series of the solution of `x' = f(x)` from `start`: coefficients of orders `0..=order` by variable.
pub fn solution<R: Ring>(
    ring: &R,
    field: &Tape,
    start: &[R::Element],
    order: usize,
) -> Result<Vec<Vec<R::Element>>, Fault> {
    let mut x: Vec<Vec<R::Element>> = start.iter().map(|s| vec![s.clone()]).collect();
    let mut jet = Jet::new(ring, field);
    for k in 0..order {
        jet.extend(&x)?;
        let step = Interval::exactly(1.0)?.div(Interval::exactly((k + 1) as f64)?)?;
        for (v, series) in x.iter_mut().enumerate() {
            series.push(ring.scale(&jet.output(v)[k], step)?);
        }
    }
    Ok(x)
}

/// The outputs of a tape at one point of a ring.
pub fn values<R: Ring>(ring: &R, tape: &Tape, at: &[R::Element]) -> Result<Vec<R::Element>, Fault> {
    let variables: Vec<Vec<R::Element>> = at.iter().map(|s| vec![s.clone()]).collect();
    let mut jet = Jet::new(ring, tape);
    jet.extend(&variables)?;
    Ok((0..tape.outputs.len()).map(|i| jet.output(i)[0].clone()).collect())
}

/// Coefficients that are intervals.
pub struct IntervalRing;

impl Ring for IntervalRing {
    type Element = Interval;

    fn constant(&self, value: Interval) -> Interval {
        value
    }

    fn add(&self, a: &Interval, b: &Interval) -> Enclosure {
        Add::add(*a, *b)
    }

    fn sub(&self, a: &Interval, b: &Interval) -> Enclosure {
        Sub::sub(*a, *b)
    }

    fn scale(&self, a: &Interval, by: Interval) -> Enclosure {
        Mul::mul(*a, by)
    }

    fn sum<'e>(&self, terms: impl Iterator<Item = Term<'e, Interval>> + Clone) -> Enclosure {
        let mut sum = Interval::ZERO;
        for (weight, a, b) in terms {
            let product = if std::ptr::eq(a, b) { a.sqr()? } else { a.mul(*b)? };
            sum = sum.add(if weight == 1.0 { product } else { product.mul(Interval::exactly(weight)?)? })?;
        }
        Ok(sum)
    }

    fn apply(&self, f: Function, a: &Interval) -> Enclosure {
        f.at(*a)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn exactly(x: f64) -> Interval {
        Interval::exactly(x).expect("finite")
    }

    fn series(ops: Vec<Op>, output: usize, start: f64, order: usize) -> Vec<Interval> {
        let tape = Tape::validated(ops, vec![output], 1).expect("a tape");
        solution(&IntervalRing, &tape, &[exactly(start)], order).expect("a series").remove(0)
    }

    fn assert_contains(found: &[Interval], expected: &[f64]) {
        assert_eq!(found.len(), expected.len());
        for (interval, &x) in found.iter().zip(expected) {
            let slack = 1e-14 * (1.0 + x.abs());
            assert!(interval.low() - slack <= x && x <= interval.high() + slack, "{interval:?} {x}");
            assert!(interval.width().expect("finite") < 1e-12 * (1.0 + x.abs()));
        }
    }

    #[test]
    fn growth_is_the_exponential_series() {
        assert_contains(&series(vec![Op::Variable(0)], 0, 1.0, 4), &[1.0, 1.0, 0.5, 1.0 / 6.0, 1.0 / 24.0]);
    }

    #[test]
    fn a_quotient_a_root_a_logarithm_and_waves_follow_their_series() {
        // x' = 1 / x from 1: x = sqrt(1 + 2 t).
        let reciprocal = vec![Op::Variable(0), Op::Constant(exactly(1.0)), Op::Div(1, 0)];
        assert_contains(&series(reciprocal, 2, 1.0, 4), &[1.0, 1.0, -0.5, 0.5, -0.625]);
        // x' = sqrt(x) from 1: x = (1 + t / 2)^2.
        assert_contains(&series(vec![Op::Variable(0), Op::Sqrt(0)], 1, 1.0, 4), &[1.0, 1.0, 0.25, 0.0, 0.0]);
        // x' = exp(-x) from 0: x = log(1 + t).
        let decay = vec![Op::Variable(0), Op::Neg(0), Op::Exp(1)];
        assert_contains(&series(decay, 2, 0.0, 4), &[0.0, 1.0, -0.5, 1.0 / 3.0, -0.25]);
        // x' = log(x) from e: the first terms by hand.
        let e = std::f64::consts::E;
        let logarithm = series(vec![Op::Variable(0), Op::Log(0)], 1, e, 3);
        assert_contains(&logarithm[..3], &[e, 1.0, 0.5 / e]);
        // x' = cos(x) from 0: x = 2 atan(tanh(t / 2)) = t - t^3 / 6 + t^5 / 24.
        let wave = vec![Op::Variable(0), Op::Sin(0), Op::Cos(0)];
        assert_contains(&series(wave, 2, 0.0, 5), &[0.0, 1.0, 0.0, -1.0 / 6.0, 0.0, 1.0 / 24.0]);
    }

    #[test]
    fn a_tape_whose_operands_come_late_or_whose_sine_has_no_cosine_is_none() {
        assert!(Tape::validated(vec![Op::Neg(0)], vec![0], 1).is_err());
        assert!(Tape::validated(vec![Op::Variable(1)], vec![0], 1).is_err());
        assert!(Tape::validated(vec![Op::Variable(0), Op::Sin(0)], vec![1], 1).is_err());
        assert!(Tape::validated(vec![Op::Variable(0)], vec![1], 1).is_err());
    }

    #[test]
    fn taylor_coefficients_of_functions_are_their_derivatives_over_factorials() {
        let x = exactly(0.7);
        for f in [Function::Reciprocal, Function::Sqrt, Function::Exp, Function::Log, Function::Sin, Function::Cos] {
            for k in 0..5 {
                // The coefficient of order k + 1 is the slope of that of order k, over k + 1.
                let step = 1e-6;
                let at = |y: f64| f.coefficient(exactly(y), k).expect("inside the domain").midpoint();
                let slope = (at(0.7 + step) - at(0.7 - step)) / (2.0 * step) / f64::from(k + 1);
                let next = f.coefficient(x, k + 1).expect("inside the domain").midpoint();
                assert!((slope - next).abs() < 1e-6 * (1.0 + next.abs()), "{f:?} {k}: {slope} {next}");
            }
        }
    }
}
