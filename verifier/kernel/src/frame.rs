//! Directions in which errors are bounded, and what undoes them.

use crate::collocation::Factors;
use crate::decoupling::directions;
use crate::errors::Errors;
use crate::fault::Fault;
use crate::flow::Flow;
use crate::interval::Interval;
use crate::matrix::Matrix;
use crate::models::{raised, UNIT};
use std::ops::{Add, Sub};

/// Directions and what undoes them: floats `S`, a matrix `T` of floats near its inverse, by rows, and how far at most
/// the entries of `T^-1 S^-1` are from those of the identity.
pub(crate) struct Frame {
    size: usize,
    pub(crate) forth: Vec<f64>,
    back: Vec<f64>,
    off: f64,
}

impl Frame {
    pub(crate) fn of(matrix: &[f64], n: usize) -> Option<Frame> {
        let back = directions(matrix, n);
        let factors = Factors::of(back.clone(), n)?;
        let mut forth = vec![0.0; n * n];
        for j in 0..n {
            let mut column: Vec<f64> = (0..n).map(|i| f64::from(u8::from(i == j))).collect();
            factors.solve(&mut column);
            (0..n).for_each(|i| forth[i * n + j] = column[i]);
        }
        let exact = |m: &[f64]| Matrix::from_fn(n, |i, j| Interval::exactly(m[i * n + j]));
        let (s, t) = (exact(&forth).ok()?, exact(&back).ok()?);
        let product = s.product(&t);
        let one = |i: usize, j: usize| Interval::exactly(f64::from(u8::from(i == j)));
        let missed = Matrix::from_fn(n, |i, j| one(i, j)?.sub(product.entry(i, j)?)).ok()?.norm();
        // S T = I - E: the inverse of S is T (I + E + E^2 + ...).
        (missed < 1e-3).then(|| Frame { size: n, forth, back, off: raised(missed / (1.0 - missed)) })
    }

    /// Entries of the inverse of `S`.
    pub(crate) fn inverse(&self, i: usize, j: usize) -> Result<Interval, Fault> {
        let row = &self.back[i * self.size..(i + 1) * self.size];
        let more = raised(self.off * row.iter().map(|x| x.abs()).sum::<f64>());
        Interval::exactly(row[j])?.add(Interval::symmetric(more)?)
    }

    /// Bounds of `|S x|` for sums of columns, each times a number from -1 to 1, and a box.
    pub(crate) fn inwards(&self, columns: &[Vec<f64>], radii: &[f64]) -> Vec<f64> {
        let n = self.size;
        let bound = |i: usize| {
            let row = &self.forth[i * n..(i + 1) * n];
            let size: f64 = row.iter().zip(radii).map(|(s, r)| s.abs() * r).sum();
            let of = |c: &Vec<f64>| {
                let sum: f64 = row.iter().zip(c).map(|(s, x)| s * x).sum();
                let mass: f64 = row.iter().zip(c).map(|(s, x)| (s * x).abs()).sum();
                sum.abs() + UNIT * (n + 3) as f64 * mass
            };
            let all: f64 = size + columns.iter().map(of).sum::<f64>();
            if all == 0.0 {
                0.0
            } else {
                raised(all)
            }
        };
        (0..n).map(bound).collect()
    }

    /// Bounds of `|S^-1 u|` for `|u|` at most this.
    pub(crate) fn outwards(&self, bounds: &[f64]) -> Vec<f64> {
        let n = self.size;
        let total: f64 = bounds.iter().sum();
        let of = |i: usize| {
            let row = &self.back[i * n..(i + 1) * n];
            let own: f64 = row.iter().zip(bounds).map(|(t, u)| t.abs() * u).sum();
            raised(own + self.off * total * row.iter().map(|t| t.abs()).sum::<f64>())
        };
        (0..n).map(of).collect()
    }

    /// The errors `S^-1 u` for `|u|` at most this, and a box.
    pub(crate) fn errors(&self, flow: &Flow, bounds: &[f64], rest: &[f64]) -> Errors {
        let n = self.size;
        let total: f64 = bounds.iter().sum();
        let columns: Vec<Vec<f64>> =
            (0..n).map(|j| (0..n).map(|i| self.back[i * n + j] * bounds[j]).collect()).collect();
        let lost = |i: usize| {
            let row = &self.back[i * n..(i + 1) * n];
            let mass: f64 = row.iter().zip(bounds).map(|(t, u)| t.abs() * u).sum();
            raised(rest[i] + 2.0 * UNIT * mass + self.off * total * row.iter().map(|t| t.abs()).sum::<f64>())
        };
        Errors::of_columns(&flow.linear, &columns, &(0..n).map(lost).collect::<Vec<_>>())
    }
}
