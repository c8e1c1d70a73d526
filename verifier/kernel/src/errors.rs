//! Errors that keep their shape: sums of generators, each a vector of polynomials of degree one in the set variables.
//!
//! The set at `z` is `{ g_1(z) r_1 + g_2(z) r_2 + ... : |r_k| <= 1 }`, so what an error does at one point of the initial
//! set is not mixed with what it does at another. Steps multiply every generator by the transition matrix, itself of
//! degree one in `z`; what is dropped, rounded or new is a box, which becomes new generators. Many generators are merged
//! into few, along axes of their own (compare the symbolic remainders of Flow*, the zonotope reductions of C. Combastel,
//! the moving frames of R. Lohner).

use crate::fault::Fault;
use crate::matrix::axes;
use crate::models::{raised, Model, Space, UNIT};

/// How many generators a variable has at most, and how many of them are left alone when the others are merged.
const MOST: usize = 8;
const KEPT: usize = 4;

/// The generators: a matrix for each monomial, of one row for each variable and one column for each generator.
#[derive(Debug, Clone)]
pub struct Errors {
    variables: usize,
    count: usize,
    /// By monomial, variable and generator.
    coefficients: Vec<f64>,
}

impl Errors {
    /// A box around zero, given by its radii.
    pub fn of_box(space: &Space, radii: &[f64]) -> Errors {
        Errors { variables: radii.len(), count: 0, coefficients: Vec::new() }.with_box(space, radii, &[])
    }

    /// The sum of some columns, each times a number from -1 to 1, and a box.
    pub(crate) fn of_columns(space: &Space, columns: &[Vec<f64>], radii: &[f64]) -> Errors {
        Errors { variables: radii.len(), count: 0, coefficients: Vec::new() }.with_box(space, radii, columns)
    }

    /// The generators where they do not depend on the set.
    pub(crate) fn columns(&self) -> Vec<Vec<f64>> {
        (0..self.count).map(|k| (0..self.variables).map(|v| self.row(0, v)[k]).collect()).collect()
    }

    fn row(&self, monomial: usize, variable: usize) -> &[f64] {
        let from = (monomial * self.variables + variable) * self.count;
        &self.coefficients[from..from + self.count]
    }

    /// These generators and more: a box, and columns of numbers.
    fn with_box(&self, space: &Space, radii: &[f64], columns: &[Vec<f64>]) -> Errors {
        let wide: Vec<usize> = (0..self.variables).filter(|&v| radii[v] > 0.0).collect();
        let count = self.count + columns.len() + wide.len();
        let mut coefficients = Vec::with_capacity(space.size() * self.variables * count);
        for monomial in 0..space.size() {
            for v in 0..self.variables {
                coefficients.extend_from_slice(if self.count > 0 { self.row(monomial, v) } else { &[] });
                let is_number = monomial == 0;
                coefficients.extend(columns.iter().map(|c| if is_number { c[v] } else { 0.0 }));
                coefficients.extend(wide.iter().map(|&w| if is_number && w == v { radii[v] } else { 0.0 }));
            }
        }
        Errors { variables: self.variables, count, coefficients }
    }

    /// The radii of a box around the set, for all `z`.
    pub fn radii(&self, variables: usize) -> Vec<f64> {
        let mut radii = vec![0.0; variables];
        if self.count > 0 {
            for (at, row) in self.coefficients.chunks(self.count).enumerate() {
                radii[at % variables] += magnitude(row);
            }
        }
        radii.into_iter().map(|r| if r == 0.0 { 0.0 } else { raised(r) }).collect()
    }

    /// The sums of magnitudes by degree, of each variable.
    fn norms(&self, space: &Space) -> Vec<Vec<f64>> {
        let mut norms = vec![vec![0.0; space.degree + 1]; self.variables];
        for degree in 0..=space.degree {
            for monomial in space.upto_degrees(degree)..space.upto_degrees(degree + 1) {
                norms.iter_mut().enumerate().for_each(|(v, n)| n[degree] += magnitude(self.row(monomial, v)));
            }
        }
        norms
    }

    /// The set of `V(z) e + x` for `e` in the set and `x` in the box with these radii.
    pub fn moved(&self, space: &Space, v: &[Vec<Model>], radii: &[f64]) -> Result<Errors, Fault> {
        if self.count == 0 {
            return Ok(self.with_box(space, radii, &[]));
        }
        let norms = self.norms(space);
        let mut image = Errors { coefficients: vec![0.0; self.coefficients.len()], ..*self };
        let mut lost = radii.to_vec();
        for (i, row) in v.iter().enumerate() {
            for (j, entry) in row.iter().enumerate() {
                lost[i] += self.lost(space, entry, &norms[j]);
                self.accumulate(space, entry, j, i, &mut image);
            }
        }
        if lost.iter().chain(&image.coefficients).any(|x| !x.is_finite()) {
            return Err(Fault::Overflow);
        }
        let lost: Vec<f64> = lost.into_iter().map(|l| if l == 0.0 { 0.0 } else { raised(l) }).collect();
        image.with_box(space, &lost, &[]).reduced(space)
    }

    /// A bound of what the products of an entry with all generators, of these norms, lose: radius, degrees, rounding.
    fn lost(&self, space: &Space, entry: &Model, norms: &[f64]) -> f64 {
        let by_degree = |d: usize| magnitude(&entry.coefficients[space.upto_degrees(d)..space.upto_degrees(d + 1)]);
        let (mut mass, mut dropped) = (0.0, 0.0);
        for d in 0..=space.degree {
            let share = by_degree(d);
            mass += share;
            dropped += share * norms[space.degree + 1 - d..].iter().sum::<f64>();
        }
        let terms = (self.variables * space.size() + 3) as f64;
        let all: f64 = norms.iter().sum();
        let lost = (entry.radius + UNIT * terms * mass) * all + dropped;
        if lost == 0.0 && (mass == 0.0 || all == 0.0) {
            0.0
        } else {
            raised(lost)
        }
    }

    /// Add the product of an entry with component `from` of all generators to component `to`.
    fn accumulate(&self, space: &Space, entry: &Model, from: usize, to: usize, image: &mut Errors) {
        let n = self.variables;
        for (i, &c) in entry.coefficients.iter().enumerate().filter(|(_, c)| **c != 0.0) {
            for (j, &at) in space.row(i).iter().enumerate() {
                let sum = (at as usize * n + to) * self.count;
                let terms = image.coefficients[sum..sum + self.count].iter_mut().zip(self.row(j, from));
                terms.for_each(|(s, g)| *s += c * g);
            }
        }
    }

    /// Bounds of how far these generators together are from their numbers, component by component.
    fn spread(&self, space: &Space, which: &[usize]) -> Vec<f64> {
        let of = |m: usize, v: usize| which.iter().map(|&k| self.row(m, v)[k].abs()).sum::<f64>();
        (0..self.variables).map(|v| raised((1..space.size()).map(|m| of(m, v)).sum())).collect()
    }

    /// The same set with few generators: the smallest are merged.
    fn reduced(self, space: &Space) -> Result<Errors, Fault> {
        let n = self.variables;
        if self.count <= MOST * n {
            return Ok(self);
        }
        let mut sizes = vec![0.0; self.count];
        self.coefficients.chunks(self.count).for_each(|row| sizes.iter_mut().zip(row).for_each(|(s, c)| *s += c.abs()));
        let mut order: Vec<usize> = (0..self.count).collect();
        order.sort_by(|&a, &b| sizes[b].total_cmp(&sizes[a]));
        let small = &order[KEPT * n..];
        let vectors: Vec<Vec<f64>> = small.iter().map(|&k| (0..n).map(|v| self.row(0, v)[k]).collect()).collect();
        let Some((mut columns, inverse)) = axes(&vectors, n) else { return Err(Fault::Overflow) };
        let widths = inverse.magnitudes(&vectors, &self.spread(space, small));
        let mut lost = vec![0.0; n];
        for (column, width) in columns.iter_mut().zip(&widths) {
            for (x, lost) in column.iter_mut().zip(&mut lost) {
                *x *= width;
                *lost += x.abs() * f64::EPSILON;
            }
        }
        let lost: Vec<f64> = lost.into_iter().map(raised).collect();
        Ok(self.only(&order[..KEPT * n]).with_box(space, &lost, &columns))
    }

    fn only(&self, kept: &[usize]) -> Errors {
        let rows = self.coefficients.chunks(self.count);
        let coefficients = rows.flat_map(|row| kept.iter().map(|&k| row[k])).collect();
        Errors { variables: self.variables, count: kept.len(), coefficients }
    }
}

/// A bound of a sum of magnitudes, up to the rounding that callers allow for.
fn magnitude(row: &[f64]) -> f64 {
    row.iter().map(|c| c.abs()).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Support of the set along a direction at a point: how far it reaches.
    fn reach(errors: &Errors, space: &Space, z: f64, direction: [f64; 2]) -> f64 {
        assert_eq!((space.variables, space.degree), (1, 1));
        let at = |v: usize, k: usize| errors.row(0, v)[k] + errors.row(1, v)[k] * z;
        (0..errors.count).map(|k| (at(0, k) * direction[0] + at(1, k) * direction[1]).abs()).sum()
    }

    #[test]
    fn merging_generators_never_loses_a_point() {
        let space = Space::new(1, 1);
        let turn = |c: f64, s: f64| {
            let entry = |x: f64, slope: f64| Model { coefficients: vec![x, slope], radius: 1e-12 };
            vec![vec![entry(c, 0.01), entry(s, 0.0)], vec![entry(-s, 0.0), entry(c, -0.02)]]
        };
        let mut errors = Errors::of_box(&space, &[1e-3, 1e-5]);
        for step in 0..60 {
            let v = turn(0.99 * (0.1 * f64::from(step)).cos(), (0.1 * f64::from(step)).sin());
            let mut all = Errors { coefficients: vec![0.0; errors.coefficients.len()], ..errors };
            for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                errors.accumulate(&space, &v[i][j], j, i, &mut all);
            }
            errors = errors.moved(&space, &v, &[1e-6, 1e-6]).expect("finite");
            for direction in [[1.0, 0.0], [0.0, 1.0], [0.6, -0.8], [0.8, 0.6]] {
                for z in [-1.0, 0.0, 0.5, 1.0] {
                    let (before, after) = (reach(&all, &space, z, direction), reach(&errors, &space, z, direction));
                    assert!(before <= after * (1.0 + 1e-12), "step {step}: {before} {after}");
                }
            }
        }
        assert!(errors.count <= MOST * 2 + 4);
    }

    #[test]
    fn a_box_is_its_own_hull() {
        let errors = Errors::of_box(&Space::new(0, 1), &[0.5, 0.0]);
        let radii = errors.radii(2);
        assert!(radii[0] >= 0.5 && radii[0] < 0.5000001 && radii[1] == 0.0);
    }
}
