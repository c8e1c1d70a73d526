//! Sums of multiples of variables, read off a tape, and sets that are boxes but for one such sum.
//!
//! States at a guard that compares several variables lie in a thin layer, which a box around them does not keep. With
//! the sum that the guard compares as a side in place of one of its variables, the box is as thin as the layer.

use crate::fault::Fault;
use crate::interval::{Enclosure, Interval};
use crate::models::Model;
use crate::series::{Op, Tape};
use crate::sets::Set;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// How much thinner than a side of the box a layer has to be to take its place.
const THINNER: f64 = 0.5;

/// The sum of the variables times their weights, and a shift: enclosures of the exact numbers.
#[derive(Debug, Clone)]
pub(crate) struct Affine {
    weights: Vec<Interval>,
    shift: Interval,
}

impl Affine {
    /// What a tape computes at a position from so many variables, if it is such a sum of two of them at least.
    pub(crate) fn of(tape: &Tape, position: usize, variables: usize) -> Option<Affine> {
        let mut known: Vec<Option<Affine>> = Vec::with_capacity(position + 1);
        for op in &tape.ops[..=position] {
            let found = Affine::after(*op, &known, variables);
            known.push(found);
        }
        known.pop()?.filter(|sum| sum.weights.iter().filter(|w| **w != Interval::ZERO).count() > 1)
    }

    fn after(op: Op, known: &[Option<Affine>], variables: usize) -> Option<Affine> {
        let number = |shift: Interval| Affine { weights: vec![Interval::ZERO; variables], shift };
        let pair = |a: usize, b: usize| Some((known[a].as_ref()?, known[b].as_ref()?));
        match op {
            Op::Constant(value) => Some(number(value)),
            Op::Variable(v) => {
                let mut sum = number(Interval::ZERO);
                *sum.weights.get_mut(v)? = Interval::exactly(1.0).ok()?;
                Some(sum)
            }
            Op::Add(a, b) => pair(a, b)?.0.with(known[b].as_ref()?, Interval::add),
            Op::Sub(a, b) => pair(a, b)?.0.with(known[b].as_ref()?, Interval::sub),
            Op::Neg(a) => number(Interval::ZERO).with(known[a].as_ref()?, Interval::sub),
            Op::Mul(a, b) => match pair(a, b)? {
                (x, y) if y.is_number() => x.each(|w| w.mul(y.shift)),
                (x, y) if x.is_number() => y.each(|w| w.mul(x.shift)),
                _ => None,
            },
            Op::Div(a, b) => pair(a, b).filter(|(_, y)| y.is_number()).and_then(|(x, y)| x.each(|w| w.div(y.shift))),
            _ => None,
        }
    }

    fn is_number(&self) -> bool {
        self.weights.iter().all(|w| *w == Interval::ZERO)
    }

    fn with(&self, other: &Affine, op: impl Fn(Interval, Interval) -> Enclosure) -> Option<Affine> {
        let weights = self.weights.iter().zip(&other.weights).map(|(x, y)| op(*x, *y));
        let weights = weights.collect::<Result<Vec<_>, _>>().ok()?;
        Some(Affine { weights, shift: op(self.shift, other.shift).ok()? })
    }

    fn each(&self, op: impl Fn(Interval) -> Enclosure) -> Option<Affine> {
        let weights = self.weights.iter().map(|w| op(*w)).collect::<Result<Vec<_>, _>>().ok()?;
        Some(Affine { weights, shift: op(self.shift).ok()? })
    }

    /// All states of a box at which the sum lies in a range, and perhaps others; the last variable is kept as it is.
    pub(crate) fn layer(&self, sides: &[Interval], range: Interval, degree: usize) -> Result<Set, Fault> {
        let Some(pivot) = self.pivot(sides, range)? else { return Ok(Set::of_box(sides, degree)) };
        let mut bounds = sides.to_vec();
        bounds[pivot] = range;
        let mut set = Set::of_box(&bounds, degree);
        let by = self.weights[pivot];
        let one = Interval::exactly(1.0)?;
        let shares: Result<Vec<Interval>, Fault> = self
            .weights
            .iter()
            .enumerate()
            .map(|(v, w)| if v == pivot { one.div(by) } else { w.div(by)?.neg() })
            .collect();
        let solved: Model = set.space.combination(set.models.iter(), &shares?)?;
        set.models[pivot] = set.space.shifted(&solved, self.shift.div(by)?.neg()?)?;
        Ok(set)
    }

    /// The variable in whose place the sum leaves the thinnest set, if that is much thinner than the box.
    fn pivot(&self, sides: &[Interval], range: Interval) -> Result<Option<usize>, Fault> {
        let mut best = None;
        let mut least = THINNER;
        for (v, side) in sides.iter().enumerate().take(sides.len().saturating_sub(1)) {
            if self.weights[v].contains(0.0) {
                continue;
            }
            let share = range.div(self.weights[v])?.width()? / side.width()?;
            if share < least {
                (best, least) = (Some(v), share);
            }
        }
        Ok(best)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x: f64) -> Interval {
        Interval::exactly(x).expect("finite")
    }

    /// `x - (5 + 1.5 y)` of the variables `x`, `y` and a time.
    fn distance() -> Tape {
        let ops = vec![
            Op::Variable(0),
            Op::Constant(at(5.0)),
            Op::Constant(at(1.5)),
            Op::Variable(1),
            Op::Mul(2, 3),
            Op::Add(1, 4),
            Op::Sub(0, 5),
            Op::Mul(0, 3),
        ];
        Tape::validated(ops, vec![6], 3).expect("valid")
    }

    #[test]
    fn sums_are_read_off_and_products_are_none() {
        let sum = Affine::of(&distance(), 6, 3).expect("a sum");
        assert_eq!(sum.weights, vec![at(1.0), at(-1.5), at(0.0)]);
        assert_eq!(sum.shift, at(-5.0));
        assert!(Affine::of(&distance(), 7, 3).is_none(), "a product");
        assert!(Affine::of(&distance(), 4, 3).is_none(), "one variable");
    }

    #[test]
    fn a_layer_holds_its_states_and_is_thin() {
        let sum = Affine::of(&distance(), 6, 3).expect("a sum");
        let sides = [(47.0, 53.0), (28.0, 32.0), (0.0, 1.0)].map(|(a, b)| Interval::new(a, b).expect("ordered"));
        let range = Interval::new(-0.01, 0.01).expect("ordered");
        let set = sum.layer(&sides, range, 2).expect("a set");
        let hull = set.hull().expect("bounded");
        for y in [28.0, 29.3, 32.0] {
            for g in [-0.01, 0.0, 0.01] {
                assert!(hull[0].contains(5.0 + 1.5 * y + g) && hull[1].contains(y));
            }
        }
        let again = crate::series::values(&set.space, &distance(), &set.models).expect("defined");
        let range = set.space.range(&again[0]).expect("bounded");
        assert!(range.contains(-0.01) && range.contains(0.01) && range.width().expect("finite") < 0.0201);
    }

    #[test]
    fn what_is_no_thinner_stays_a_box() {
        let sum = Affine::of(&distance(), 6, 3).expect("a sum");
        let sides = [(47.0, 48.0), (28.0, 29.0), (0.0, 1.0)].map(|(a, b)| Interval::new(a, b).expect("ordered"));
        let set = sum.layer(&sides, Interval::new(-1.0, 1.0).expect("ordered"), 2).expect("a set");
        let hull = set.hull().expect("bounded");
        assert!(hull[0].high() < 48.1 && hull[1].high() < 29.1);
    }
}
