//! Quantities of a motion: one tape gives positions as functions of time, another reads them with their derivatives.
//!
//! On a stretch of time every quantity is enclosed by its Taylor polynomial about the middle and the range of the next
//! coefficient over the whole stretch (Taylor's theorem with Lagrange's remainder), cut with its plain interval value.
//! Stretches are halved until these enclosures are as narrow as asked for.

use crate::fault::Fault;
use crate::interval::{Enclosure, Interval};
use crate::series::{IntervalRing, Jet, Tape};
use std::ops::{Add, Mul, Sub};

/// Positions as functions of time, the one variable, and quantities of `[position, velocity, ...]`: variable
/// `d * outputs + i` of the readout is the `d`-th derivative of output `i`.
pub struct Motion {
    pub positions: Tape,
    pub readout: Tape,
    pub derivatives: usize,
}

/// How finely to enclose: the order of the polynomials, how narrow each quantity, halvings on a path, stretches at all.
pub struct Fineness {
    pub order: usize,
    pub widths: Vec<f64>,
    pub depth: u32,
    pub stretches: usize,
}

/// A stretch of time with what the quantities lie in there; `None` where one of them has no enclosure.
pub struct Piece {
    pub low: f64,
    pub high: f64,
    pub values: Option<Vec<Interval>>,
}

/// Enclose all quantities over `time`, in order of time; what exceeds the budget of stretches is left as wide as it is.
pub fn along(motion: &Motion, time: Interval, fineness: &Fineness) -> Vec<Piece> {
    let mut pending = vec![(time.low(), time.high(), 0)];
    let mut done: Vec<Piece> = Vec::new();
    while let Some((low, high, depth)) = pending.pop() {
        let values = Interval::new(low, high).and_then(|x| enclose(motion, x, fineness.order)).ok();
        let middle = 0.5 * low + 0.5 * high;
        let may_halve = depth < fineness.depth && done.len() + pending.len() < fineness.stretches;
        if may_halve && low < middle && middle < high && !is_fine(&values, &fineness.widths) {
            pending.push((middle, high, depth + 1));
            pending.push((low, middle, depth + 1));
        } else {
            done.push(Piece { low, high, values });
        }
    }
    done
}

fn is_fine(values: &Option<Vec<Interval>>, widths: &[f64]) -> bool {
    let is_narrow = |(v, &w): (&Interval, &f64)| v.width().is_ok_and(|width| width <= w);
    values.as_ref().is_some_and(|values| values.iter().zip(widths).all(is_narrow))
}

/// What the quantities lie in over a stretch of time.
pub fn enclose(motion: &Motion, time: Interval, order: usize) -> Result<Vec<Interval>, Fault> {
    let middle = Interval::exactly(time.midpoint())?;
    let at_middle = series(motion, middle, order)?;
    let throughout = series(motion, time, order)?;
    let offset = time.sub(middle)?;
    at_middle.iter().zip(&throughout).map(|(point, whole)| polynomial(point, whole, offset, order)).collect()
}

/// `sum of point_k s^k` below the order, plus `whole_order s^order`, within `whole_0`.
fn polynomial(point: &[Interval], whole: &[Interval], s: Interval, order: usize) -> Enclosure {
    let mut sum = point[0];
    for (k, &coefficient) in point.iter().enumerate().take(order).skip(1) {
        sum = sum.add(coefficient.mul(s.powi(k as i32)?)?)?;
    }
    if order > 0 {
        sum = sum.add(whole[order].mul(s.powi(order as i32)?)?)?;
    }
    sum.intersection(whole[0])
}

/// The Taylor coefficients of the quantities of orders `0..=order` about each point of `time`.
fn series(motion: &Motion, time: Interval, order: usize) -> Result<Vec<Vec<Interval>>, Fault> {
    let ring = IntervalRing;
    let highest = order + motion.derivatives;
    let mut clock = vec![Interval::ZERO; highest + 1];
    clock[0] = time;
    if highest > 0 {
        clock[1] = Interval::exactly(1.0)?;
    }
    let mut positions = Jet::new(&ring, &motion.positions);
    for _ in 0..=highest {
        positions.extend(std::slice::from_ref(&clock))?;
    }
    let mut known = Vec::new();
    for d in 0..=motion.derivatives {
        for i in 0..motion.positions.outputs.len() {
            known.push(derivative(&positions.output(i)[..=order + d], d)?);
        }
    }
    let mut quantities = Jet::new(&ring, &motion.readout);
    for _ in 0..=order {
        quantities.extend(&known)?;
    }
    Ok((0..motion.readout.outputs.len()).map(|i| quantities.output(i).to_vec()).collect())
}

/// The series of the `d`-th derivative: coefficient `k` is `(k + 1) ... (k + d)` times coefficient `k + d`.
fn derivative(series: &[Interval], d: usize) -> Result<Vec<Interval>, Fault> {
    let scaled = |(k, &c): (usize, &Interval)| {
        let factor = (k + 1..=k + d).product::<usize>();
        c.mul(Interval::exactly(factor as f64)?)
    };
    series[d..].iter().enumerate().map(scaled).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::series::Op;

    /// The position `sin(t)`; read are its value and `x^2 + (x')^2`, which is one.
    fn swing() -> Motion {
        let positions = Tape::validated(vec![Op::Variable(0), Op::Sin(0), Op::Cos(0)], vec![1], 1).expect("a tape");
        let ops = vec![Op::Variable(0), Op::Variable(1), Op::Mul(0, 0), Op::Mul(1, 1), Op::Add(2, 3)];
        let readout = Tape::validated(ops, vec![0, 4], 2).expect("a tape");
        Motion { positions, readout, derivatives: 1 }
    }

    fn fineness(width: f64, stretches: usize) -> Fineness {
        Fineness { order: 2, widths: vec![width; 2], depth: 20, stretches }
    }

    #[test]
    fn a_swing_is_enclosed_and_its_energy_kept() {
        let found = along(&swing(), Interval::new(0.0, 3.0).expect("in order"), &fineness(0.01, 10_000));
        assert_eq!(found[0].low, 0.0);
        assert_eq!(found.last().expect("some").high, 3.0);
        for (piece, next) in found.iter().zip(&found[1..]) {
            assert_eq!(piece.high, next.low);
        }
        for piece in &found {
            let values = piece.values.as_ref().expect("enclosed");
            for k in 0..=10 {
                let t = piece.low + (piece.high - piece.low) * f64::from(k) / 10.0;
                assert!(values[0].contains(t.sin()) && values[1].contains(1.0));
            }
            assert!(values.iter().all(|v| v.width().expect("finite") <= 0.01));
        }
    }

    #[test]
    fn the_budget_of_stretches_is_kept() {
        let found = along(&swing(), Interval::new(0.0, 3.0).expect("in order"), &fineness(1e-9, 50));
        assert!(found.len() <= 51);
        assert!(found.iter().all(|p| p.values.is_some()));
    }

    #[test]
    fn where_a_divisor_vanishes_there_is_no_enclosure() {
        let positions = Tape::validated(vec![Op::Variable(0)], vec![0], 1).expect("a tape");
        let ops = vec![Op::Variable(0), Op::Constant(Interval::exactly(1.0).expect("finite")), Op::Div(1, 0)];
        let readout = Tape::validated(ops, vec![2], 1).expect("a tape");
        let motion = Motion { positions, readout, derivatives: 0 };
        let fine = Fineness { order: 2, widths: vec![0.1], depth: 6, stretches: 1000 };
        let found = along(&motion, Interval::new(-1.0, 1.0).expect("in order"), &fine);
        assert!(found.iter().any(|p| p.values.is_none()));
        assert!(found.iter().all(|p| p.values.is_some() || p.low.abs().min(p.high.abs()) <= 0.04));
    }
}
