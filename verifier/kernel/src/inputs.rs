//! Fields with inputs: any measurable function of time in a box, taken with its middle; what is left is a disturbance.
//!
//! `f(x, u) = f(x, m) + d` with `|d| <= |df/du (x, u')| |u - m|` for some `u'` between `u` and `m`, by the mean value theorem.

use crate::duals::jacobian;
use crate::fault::Fault;
use crate::interval::{Enclosure, Interval};
use crate::models::raised;
use crate::series::{Op, Ring, Tape};

/// A field over the state and inputs after it, and the ranges of these.
#[derive(Debug, Clone, PartialEq)]
pub struct Inputs {
    field: Tape,
    ranges: Vec<Interval>,
}

impl Inputs {
    pub fn new(field: Tape, ranges: Vec<Interval>) -> Inputs {
        Inputs { field, ranges }
    }

    /// The field of the state alone, inputs in the middle of their ranges.
    pub fn settled(&self) -> Result<Tape, Fault> {
        let n = self.field.outputs.len();
        let fixed = |op: &Op| match *op {
            Op::Variable(v) if v >= n => Interval::exactly(self.ranges[v - n].midpoint()).map(Op::Constant),
            other => Ok(other),
        };
        let ops = self.field.ops.iter().map(fixed).collect::<Result<_, _>>()?;
        Tape::validated(ops, self.field.outputs.clone(), n)
    }

    /// Bounds of how far the rates at some states may be from those of the settled field.
    pub fn spread<R: Ring>(
        &self,
        ring: &R,
        states: &[R::Element],
        range: impl Fn(&R::Element) -> Enclosure,
    ) -> Result<Vec<f64>, Fault> {
        let n = states.len();
        let at: Vec<R::Element> = states.iter().cloned().chain(self.ranges.iter().map(|&u| ring.constant(u))).collect();
        let slopes = jacobian(ring, &self.field, &at)?;
        let mut found = Vec::with_capacity(n);
        for row in &slopes {
            let mut sum = 0.0;
            for (slope, u) in row[n..].iter().zip(&self.ranges) {
                let middle = u.midpoint();
                let half = raised((u.high() - middle).max(middle - u.low()).max(0.0));
                let size = range(slope)?.norm();
                sum += if size == 0.0 { 0.0 } else { size * half };
            }
            found.push(if sum == 0.0 { 0.0 } else { raised(sum) });
        }
        Ok(found)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::series::IntervalRing;

    fn interval(low: f64, high: f64) -> Interval {
        Interval::new(low, high).expect("ends in order")
    }

    /// `x' = x u` for u in [1, 3]: around 2 x, at most 1 |x| away.
    fn product() -> Inputs {
        let tape = Tape::validated(vec![Op::Variable(0), Op::Variable(1), Op::Mul(0, 1)], vec![2], 2).expect("a tape");
        Inputs::new(tape, vec![interval(1.0, 3.0)])
    }

    #[test]
    fn the_middle_of_an_input_is_a_number_of_the_field() {
        let field = product().settled().expect("a tape");
        let found = crate::series::values(&IntervalRing, &field, &[interval(5.0, 5.0)]).expect("defined");
        assert!(found[0].contains(10.0) && found[0].width().expect("finite") < 1e-9);
    }

    #[test]
    fn the_rest_of_an_input_is_bounded_by_its_slope() {
        let found = product().spread(&IntervalRing, &[interval(-4.0, 2.0)], |x| Ok(*x)).expect("defined");
        assert!((4.0..4.0001).contains(&found[0]));
    }
}
