//! Errors that keep their shape: sums of generators, each a vector of polynomials of degree one in the set variables.
//!
//! The set at `z` is `{ g_1(z) r_1 + g_2(z) r_2 + ... : |r_k| <= 1 }`, so what an error does at one point of the initial
//! set is not mixed with what it does at another. Steps multiply every generator by the transition matrix, itself of
//! degree one in `z`; what is dropped, rounded or new is a box, which becomes new generators. Many generators are merged
//! into few, along axes of their own (compare the symbolic remainders of Flow*, the zonotope reductions of C. Combastel,
//! the moving frames of R. Lohner).

use crate::fault::Fault;
use crate::matrix::axes;
use crate::models::{raised, Model, Space};
use crate::series::Ring;

/// How many generators a variable has at most, and how many of them are left alone when the others are merged.
const MOST: usize = 8;
const KEPT: usize = 4;

/// The generators; `generators[k][v]` is component `v` of the `k`-th, without radius.
#[derive(Debug, Clone)]
pub struct Errors {
    generators: Vec<Vec<Model>>,
}

impl Errors {
    /// A box around zero, given by its radii.
    pub fn of_box(space: &Space, radii: &[f64]) -> Errors {
        let mut errors = Errors { generators: Vec::new() };
        errors.add_box(space, radii);
        errors
    }

    fn add_box(&mut self, space: &Space, radii: &[f64]) {
        for (v, &radius) in radii.iter().enumerate().filter(|(_, r)| **r > 0.0) {
            let mut generator = vec![space.zero(); radii.len()];
            generator[v] = space.number(radius);
            self.generators.push(generator);
        }
    }

    /// The radii of a box around the set, for all `z`.
    pub fn radii(&self, variables: usize) -> Vec<f64> {
        let mut radii = vec![0.0; variables];
        for generator in &self.generators {
            for (radius, component) in radii.iter_mut().zip(generator) {
                *radius += magnitude(component);
            }
        }
        radii.into_iter().map(|r| if r == 0.0 { 0.0 } else { raised(r) }).collect()
    }

    /// The set of `V(z) e + x` for `e` in the set and `x` in the box with these radii.
    pub fn moved(&self, space: &Space, v: &[Vec<Model>], radii: &[f64]) -> Result<Errors, Fault> {
        let mut lost = radii.to_vec();
        let mut generators = Vec::with_capacity(self.generators.len() + radii.len());
        for generator in &self.generators {
            let mut image = Vec::with_capacity(radii.len());
            for (row, lost) in v.iter().zip(&mut lost) {
                let mut sum = space.sum(row.iter().zip(generator).map(|(v, g)| (1.0, v, g)))?;
                *lost = raised(*lost + sum.radius);
                sum.radius = 0.0;
                image.push(sum);
            }
            generators.push(image);
        }
        let mut errors = Errors { generators };
        errors.add_box(space, &lost);
        errors.reduced(space, radii.len())
    }

    /// The same set with few generators: the smallest are merged.
    fn reduced(mut self, space: &Space, variables: usize) -> Result<Errors, Fault> {
        if self.generators.len() <= MOST * variables {
            return Ok(self);
        }
        let mut sized: Vec<(f64, Vec<Model>)> =
            self.generators.into_iter().map(|g| (g.iter().map(magnitude).sum(), g)).collect();
        sized.sort_by(|a, b| b.0.total_cmp(&a.0));
        let small = sized.split_off(KEPT * variables);
        self.generators = sized.into_iter().map(|(_, g)| g).collect();
        let vectors: Vec<Vec<f64>> = small.iter().map(|(_, g)| g.iter().map(|m| m.coefficients[0]).collect()).collect();
        let Some((columns, inverse)) = axes(&vectors, variables) else { return Err(Fault::Overflow) };
        let mut widths = vec![0.0; variables];
        for ((_, generator), vector) in small.iter().zip(&vectors) {
            let spread: Vec<f64> = generator.iter().map(spread).collect();
            let (middles, radii) = inverse.apply(vector, &spread);
            for (width, (m, r)) in widths.iter_mut().zip(middles.iter().zip(&radii)) {
                *width += m.abs() + r;
            }
        }
        let mut lost = vec![0.0; variables];
        for (column, width) in columns.iter().zip(&widths) {
            let width = raised(*width);
            let generator = column.iter().map(|x| space.number(x * width)).collect();
            lost.iter_mut().zip(column).for_each(|(l, x)| *l += (x * width).abs() * f64::EPSILON);
            self.generators.push(generator);
        }
        self.add_box(space, &lost.into_iter().map(raised).collect::<Vec<f64>>());
        Ok(self)
    }
}

/// A bound of a polynomial's magnitude, up to the rounding that callers of a sum of these allow for.
fn magnitude(m: &Model) -> f64 {
    m.coefficients.iter().map(|c| c.abs()).sum()
}

/// A bound of how far a polynomial is from its constant term.
fn spread(m: &Model) -> f64 {
    raised(m.coefficients[1..].iter().map(|c| c.abs()).sum())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Support of the set along a direction at a point: how far it reaches.
    fn reach(errors: &Errors, space: &Space, z: f64, direction: [f64; 2]) -> f64 {
        let at = |m: &Model| m.coefficients[0] + m.coefficients[1..].iter().map(|c| c * z).sum::<f64>();
        let along = |g: &Vec<Model>| (at(&g[0]) * direction[0] + at(&g[1]) * direction[1]).abs();
        assert_eq!(space.variables, 1);
        errors.generators.iter().map(along).sum()
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
            let mut all = errors.clone();
            all.generators = all
                .generators
                .iter()
                .map(|g| v.iter().map(|row| space.sum(row.iter().zip(g).map(|(a, b)| (1.0, a, b))).unwrap()).collect())
                .collect();
            errors = errors.moved(&space, &v, &[1e-6, 1e-6]).expect("finite");
            for direction in [[1.0, 0.0], [0.0, 1.0], [0.6, -0.8], [0.8, 0.6]] {
                for z in [-1.0, 0.0, 0.5, 1.0] {
                    let (before, after) = (reach(&all, &space, z, direction), reach(&errors, &space, z, direction));
                    assert!(before <= after * (1.0 + 1e-12), "step {step}: {before} {after}");
                }
            }
        }
        assert!(errors.generators.len() <= MOST * 2 + 4);
    }

    #[test]
    fn a_box_is_its_own_hull() {
        let errors = Errors::of_box(&Space::new(0, 1), &[0.5, 0.0]);
        let radii = errors.radii(2);
        assert!(radii[0] >= 0.5 && radii[0] < 0.5000001 && radii[1] == 0.0);
    }
}
