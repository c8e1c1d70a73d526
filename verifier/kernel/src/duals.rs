//! Coefficients that carry their derivatives: slopes of a tape, and of the series of a solution by its start.
//!
//! A `Dual` over any ring is a value with its partial derivatives (A. Griewank, A. Walther, Evaluating Derivatives,
//! chapter 3); the recursions of `series` over the ring of duals then give derivatives of everything they compute.

use crate::fault::Fault;
use crate::interval::Interval;
use crate::series::{solution, values, Function, Ring, Tape, Term};
use std::ops::Neg;

/// A coefficient and its partial derivatives.
#[derive(Debug, Clone)]
pub struct Dual<E> {
    pub value: E,
    pub slope: Vec<E>,
}

/// Coefficients of another ring that carry their derivatives by some number of variables.
pub struct DualRing<'a, R: Ring> {
    pub base: &'a R,
    pub variables: usize,
}

/// The derivative of a function, given its argument and its value.
pub fn derivative<R: Ring>(ring: &R, f: Function, a: &R::Element, value: &R::Element) -> Result<R::Element, Fault> {
    let one = Interval::exactly(1.0)?;
    match f {
        Function::Reciprocal => ring.scale(&ring.mul(value, value)?, one.neg()?),
        Function::Sqrt => ring.scale(&ring.apply(Function::Reciprocal, value)?, Interval::exactly(0.5)?),
        Function::Exp => Ok(value.clone()),
        Function::Log => ring.apply(Function::Reciprocal, a),
        Function::Sin => ring.apply(Function::Cos, a),
        Function::Cos => ring.scale(&ring.apply(Function::Sin, a)?, one.neg()?),
    }
}

impl<R: Ring> DualRing<'_, R> {
    fn each(&self, f: impl Fn(usize) -> Result<R::Element, Fault>) -> Result<Vec<R::Element>, Fault> {
        (0..self.variables).map(f).collect()
    }
}

impl<R: Ring> Ring for DualRing<'_, R> {
    type Element = Dual<R::Element>;

    fn constant(&self, value: Interval) -> Self::Element {
        let zero = self.base.constant(Interval::ZERO);
        Dual { value: self.base.constant(value), slope: vec![zero; self.variables] }
    }

    fn add(&self, a: &Self::Element, b: &Self::Element) -> Result<Self::Element, Fault> {
        let slope = self.each(|i| self.base.add(&a.slope[i], &b.slope[i]))?;
        Ok(Dual { value: self.base.add(&a.value, &b.value)?, slope })
    }

    fn sub(&self, a: &Self::Element, b: &Self::Element) -> Result<Self::Element, Fault> {
        let slope = self.each(|i| self.base.sub(&a.slope[i], &b.slope[i]))?;
        Ok(Dual { value: self.base.sub(&a.value, &b.value)?, slope })
    }

    fn scale(&self, a: &Self::Element, by: Interval) -> Result<Self::Element, Fault> {
        let slope = self.each(|i| self.base.scale(&a.slope[i], by))?;
        Ok(Dual { value: self.base.scale(&a.value, by)?, slope })
    }

    fn sum<'e>(&self, terms: impl Iterator<Item = Term<'e, Self::Element>> + Clone) -> Result<Self::Element, Fault> {
        let value = self.base.sum(terms.clone().map(|(w, a, b)| (w, &a.value, &b.value)))?;
        let slope = self.each(|j| {
            let by_second = terms.clone().map(|(w, a, b)| (w, &a.value, &b.slope[j]));
            let by_first = terms.clone().map(|(w, a, b)| (w, &a.slope[j], &b.value));
            self.base.sum(by_second.chain(by_first))
        })?;
        Ok(Dual { value, slope })
    }

    fn apply(&self, f: Function, a: &Self::Element) -> Result<Self::Element, Fault> {
        let value = self.base.apply(f, &a.value)?;
        let by = derivative(self.base, f, &a.value, &value)?;
        let slope = self.each(|i| self.base.mul(&a.slope[i], &by))?;
        Ok(Dual { value, slope })
    }
}

/// Each variable with derivative one by itself.
fn seeds<R: Ring>(ring: &R, at: &[R::Element]) -> Result<Vec<Dual<R::Element>>, Fault> {
    let one = ring.constant(Interval::exactly(1.0)?);
    let seed = |v: usize| {
        let mut slope = vec![ring.constant(Interval::ZERO); at.len()];
        slope[v] = one.clone();
        Dual { value: at[v].clone(), slope }
    };
    Ok((0..at.len()).map(seed).collect())
}

/// A square matrix over a ring, by rows.
pub type Square<R> = Vec<Vec<<R as Ring>::Element>>;

/// The matrix of partial derivatives of a tape's outputs.
pub fn jacobian<R: Ring>(ring: &R, tape: &Tape, at: &[R::Element]) -> Result<Square<R>, Fault> {
    let duals = DualRing { base: ring, variables: at.len() };
    Ok(values(&duals, tape, &seeds(ring, at)?)?.into_iter().map(|d| d.slope).collect())
}

/// The matrices of partial derivatives, by the start, of the solution's Taylor coefficients of orders `0..=order`.
pub fn variations<R: Ring>(ring: &R, field: &Tape, at: &[R::Element], order: usize) -> Result<Vec<Square<R>>, Fault> {
    let duals = DualRing { base: ring, variables: at.len() };
    let series = solution(&duals, field, &seeds(ring, at)?, order)?;
    Ok((0..=order).map(|i| series.iter().map(|s| s[i].slope.clone()).collect()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::series::{IntervalRing, Op};

    fn exactly(x: f64) -> Interval {
        Interval::exactly(x).expect("finite")
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
    fn slopes_are_those_of_the_product_rule() {
        let tape =
            Tape::validated(vec![Op::Variable(0), Op::Variable(1), Op::Mul(0, 1), Op::Sin(2), Op::Cos(2)], vec![3], 2)
                .expect("a tape");
        let slopes = jacobian(&IntervalRing, &tape, &[exactly(0.5), exactly(2.0)]).expect("slopes");
        assert_contains(&slopes[0], &[2.0 * 1.0f64.cos(), 0.5 * 1.0f64.cos()]);
    }
}
