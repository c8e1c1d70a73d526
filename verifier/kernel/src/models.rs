//! Taylor models: polynomials over the box [-1, 1]^n with float coefficients, and a radius that holds every error.
//!
//! A model stands for all functions `p(z) + e(z)` with `|e| <= radius` on the box. Operations drop terms beyond the
//! degree of the space and round to nearest; bounds of both go to the radius (K. Makino, M. Berz, Taylor models and
//! other validated functional inclusion methods, 2003). `UNIT` bounds half a step relative to a float, `FLOOR` what
//! gradual underflow can lose; sums of magnitudes are raised by `raised`, which covers more additions than there are.

use crate::fault::Fault;
use crate::interval::{Enclosure, Interval};
use crate::series::{Function, Ring, Term};
use std::ops::{Add, Mul, Range};

pub const UNIT: f64 = f64::EPSILON / 2.0;
const FLOOR: f64 = 1e-300;

/// The highest degree of a space.
pub const MOST: usize = 8;

/// At least the exact value of a sum of fewer than a million nonnegative terms that was rounded to nearest.
#[inline]
pub fn raised(x: f64) -> f64 {
    x * (1.0 + 1e-9) + FLOOR
}

/// The monomials of at most some degree in some number of variables, by degree, and how they multiply.
#[derive(Debug, Clone)]
pub struct Space {
    pub variables: usize,
    pub degree: usize,
    /// The exponents of each monomial.
    pub exponents: Vec<Vec<u8>>,
    /// How many monomials there are of at most each degree.
    upto: Vec<usize>,
    /// The position of the product of monomials `i` and `j`, by rows of `i` with `upto[degree - degrees[i]]` entries.
    products: Vec<Vec<u32>>,
}

/// A polynomial in the monomials of a space, and the bound of its error.
#[derive(Debug, Clone, PartialEq)]
pub struct Model {
    pub coefficients: Vec<f64>,
    pub radius: f64,
}

fn of_degree(variables: usize, degree: usize) -> Vec<Vec<u8>> {
    if variables == 0 {
        return if degree == 0 { vec![Vec::new()] } else { Vec::new() };
    }
    (0..=degree)
        .rev()
        .flat_map(|first| {
            of_degree(variables - 1, degree - first).into_iter().map(move |mut rest| {
                rest.insert(0, first as u8);
                rest
            })
        })
        .collect()
}

impl Space {
    pub fn new(variables: usize, degree: usize) -> Space {
        let mut exponents = Vec::new();
        let (mut degrees, mut upto) = (Vec::new(), Vec::new());
        for d in 0..=degree {
            let found = of_degree(variables, d);
            degrees.extend(std::iter::repeat_n(d, found.len()));
            exponents.extend(found);
            upto.push(exponents.len());
        }
        let index: std::collections::HashMap<&Vec<u8>, u32> =
            exponents.iter().enumerate().map(|(i, e)| (e, i as u32)).collect();
        let products = (0..exponents.len())
            .map(|i| {
                (0..upto[degree - degrees[i]])
                    .map(|j| {
                        let sum: Vec<u8> = exponents[i].iter().zip(&exponents[j]).map(|(a, b)| a + b).collect();
                        index[&sum]
                    })
                    .collect()
            })
            .collect();
        Space { variables, degree, exponents, upto, products }
    }

    #[inline]
    pub fn size(&self) -> usize {
        self.exponents.len()
    }

    /// How many monomials have fewer than this degree.
    #[inline]
    pub fn upto_degrees(&self, degrees: usize) -> usize {
        if degrees == 0 {
            0
        } else {
            self.upto[degrees - 1]
        }
    }

    /// The positions of the products of monomial `i` with the first monomials, as far as they are of the space.
    #[inline]
    pub fn row(&self, i: usize) -> &[u32] {
        &self.products[i]
    }

    /// Add `weight` times the product of parts of two polynomials, the first of them few coefficients.
    pub fn spread(&self, sum: &mut [f64], weight: f64, few: (Range<usize>, &[f64]), many: (Range<usize>, &[f64])) {
        let others = &many.1[many.0.clone()];
        for i in few.0 {
            let factor = weight * few.1[i];
            if factor == 0.0 {
                continue;
            }
            if self.variables == 1 {
                sum[i + many.0.start..].iter_mut().zip(others).for_each(|(s, c)| *s += factor * c);
            } else {
                let places = &self.products[i][many.0.clone()];
                places.iter().zip(others).for_each(|(&at, c)| sum[at as usize] += factor * c);
            }
        }
    }

    /// The position of a monomial of the space, given by its exponents.
    pub fn position(&self, exponents: &[u8]) -> usize {
        let degree: usize = exponents.iter().map(|&e| usize::from(e)).sum();
        let from = if degree == 0 { 0 } else { self.upto[degree - 1] };
        let found = self.exponents[from..self.upto[degree]].iter().position(|e| e == exponents);
        from + found.expect("a monomial of the space")
    }

    pub fn zero(&self) -> Model {
        Model { coefficients: vec![0.0; self.size()], radius: 0.0 }
    }

    /// `centre + half * z_v`.
    pub fn variable(&self, v: usize, centre: f64, half: f64) -> Model {
        let mut model = self.zero();
        model.coefficients[0] = centre;
        if self.degree > 0 {
            model.coefficients[1 + v] = half;
        } else {
            model.radius = half.abs();
        }
        model
    }

    /// The constant `value`.
    pub fn number(&self, value: f64) -> Model {
        let mut model = self.zero();
        model.coefficients[0] = value;
        model
    }

    /// The sums of magnitudes by degree, rounded up; zero for a sum of zeros.
    fn norms(&self, a: &Model) -> [f64; MOST + 1] {
        let (mut norms, mut from) = ([0.0; MOST + 1], 0);
        for (norm, &to) in norms.iter_mut().zip(&self.upto) {
            let sum: f64 = a.coefficients[from..to].iter().map(|c| c.abs()).sum();
            *norm = if sum == 0.0 { 0.0 } else { raised(sum) };
            from = to;
        }
        norms
    }

    /// A range of the polynomial and its error: even monomials are never negative.
    pub fn range(&self, a: &Model) -> Enclosure {
        let (mut low, mut high) = (0.0, 0.0);
        for (c, e) in a.coefficients.iter().zip(&self.exponents).skip(1) {
            if e.iter().all(|p| p % 2 == 0) {
                low += c.min(0.0);
                high += c.max(0.0);
            } else {
                low -= c.abs();
                high += c.abs();
            }
        }
        let out = |bound: f64| if bound == 0.0 { 0.0 } else { raised(bound) };
        let spread = Interval::new(-out(-low), out(high))?;
        spread.add(Interval::exactly(a.coefficients[0])?)?.add(Interval::symmetric(a.radius)?)
    }

    /// The range on a part of the box [-1, 1]^n.
    pub fn range_on(&self, a: &Model, part: &[Interval]) -> Enclosure {
        let mut sum = Interval::symmetric(a.radius)?;
        for (c, e) in a.coefficients.iter().zip(&self.exponents) {
            if *c == 0.0 {
                continue;
            }
            let mut term = Interval::exactly(*c)?;
            for (z, &p) in part.iter().zip(e) {
                if p > 0 {
                    term = term.mul(z.powi(i32::from(p))?)?;
                }
            }
            sum = sum.add(term)?;
        }
        Ok(sum)
    }

    /// `a + value`: the middle of the interval goes to the constant term, the rest to the radius.
    pub fn shifted(&self, a: &Model, value: Interval) -> Result<Model, Fault> {
        let mut sum = a.clone();
        let middle = value.midpoint();
        sum.coefficients[0] += middle;
        let rest = (value.high() - middle).max(middle - value.low());
        sum.radius = raised(a.radius + raised(rest) + UNIT * 2.0 * sum.coefficients[0].abs());
        checked(sum)
    }

    /// The sum of `weights[i] * models[i]`.
    pub fn combination<'m>(
        &self,
        models: impl IntoIterator<Item = &'m Model>,
        weights: &[Interval],
    ) -> Result<Model, Fault> {
        let mut sum = self.zero();
        let (mut mass, mut radius) = (0.0, 0.0);
        for (model, weight) in models.into_iter().zip(weights) {
            let middle = weight.midpoint();
            let half = raised((weight.high() - middle).max(middle - weight.low()));
            let mut norm = 0.0;
            for (s, c) in sum.coefficients.iter_mut().zip(&model.coefficients) {
                *s += middle * c;
                norm += c.abs();
            }
            mass += middle.abs() * norm;
            radius += half * raised(norm) + weight.norm() * model.radius;
        }
        let rounding = UNIT * (weights.len() + 3) as f64 * mass;
        sum.radius = raised(raised(radius) + raised(rounding));
        checked(sum)
    }

    /// The model in a space of lower degree in the same variables: the terms of higher degree go to the radius.
    pub fn lowered(&self, a: &Model, to: &Space) -> Result<Model, Fault> {
        let (kept, rest) = a.coefficients.split_at(to.size());
        let dropped: f64 = rest.iter().map(|c| c.abs()).sum();
        checked(Model { coefficients: kept.to_vec(), radius: total(a.radius, dropped) })
    }

    /// The polynomial alone: the radius is left behind.
    pub fn polynomial(&self, a: &Model) -> Model {
        Model { coefficients: a.coefficients.clone(), radius: 0.0 }
    }

    /// `f(a)` by the Taylor polynomial of `f` at the constant term, with Lagrange's remainder.
    fn composed(&self, f: Function, a: &Model) -> Result<Model, Fault> {
        let centre = Interval::exactly(a.coefficients[0])?;
        let mut rest = a.clone();
        rest.coefficients[0] = 0.0;
        let spread = self.range(&rest)?;
        let all = centre.add(spread)?;
        let order = self.degree as u32;
        // Horner's scheme from the highest coefficient, which is taken over the whole range.
        let last = f.coefficient(all, order + 1)?;
        let mut sum = self.shifted(&self.zero(), last)?;
        for k in (0..=order).rev() {
            sum = self.mul(&sum, &rest)?;
            sum = self.shifted(&sum, f.coefficient(centre, k)?)?;
        }
        // A function known to be tighter than its model is cut by nothing here: the model must hold pointwise.
        checked(sum)
    }
}

fn is_zero(a: &Model) -> bool {
    a.radius == 0.0 && a.coefficients.iter().all(|&c| c == 0.0)
}

/// The model, unless it left the floats.
fn checked(model: Model) -> Result<Model, Fault> {
    let finite = model.radius.is_finite() && model.coefficients.iter().all(|c| c.is_finite());
    if finite {
        Ok(model)
    } else {
        Err(Fault::Overflow)
    }
}

impl Ring for Space {
    type Element = Model;

    fn constant(&self, value: Interval) -> Model {
        let middle = value.midpoint();
        let mut model = self.zero();
        model.coefficients[0] = middle;
        let rest = (value.high() - middle).max(middle - value.low());
        model.radius = if rest == 0.0 { 0.0 } else { raised(rest) };
        model
    }

    fn add(&self, a: &Model, b: &Model) -> Result<Model, Fault> {
        let mut mass = 0.0;
        let coefficients: Vec<f64> = a
            .coefficients
            .iter()
            .zip(&b.coefficients)
            .map(|(x, y)| {
                let sum = x + y;
                if *x != 0.0 && *y != 0.0 {
                    mass += sum.abs();
                }
                sum
            })
            .collect();
        checked(Model { coefficients, radius: total(a.radius + b.radius, mass * 2.0 * UNIT) })
    }

    fn sub(&self, a: &Model, b: &Model) -> Result<Model, Fault> {
        let negative = Model { coefficients: b.coefficients.iter().map(|c| -c).collect(), radius: b.radius };
        self.add(a, &negative)
    }

    fn scale(&self, a: &Model, by: Interval) -> Result<Model, Fault> {
        self.combination(std::iter::once(a), &[by])
    }

    fn sum<'e>(&self, terms: impl Iterator<Item = Term<'e, Model>> + Clone) -> Result<Model, Fault> {
        let mut sum = self.zero();
        let (mut radius, mut mass, mut count) = (0.0, 0.0, 0usize);
        for (weight, x, y) in terms {
            if is_zero(x) || is_zero(y) {
                continue;
            }
            self.accumulate(&mut sum.coefficients, x, y, weight);
            let (nx, ny) = (self.norms(x), self.norms(y));
            let (whole_x, whole_y): (f64, f64) = (nx.iter().sum(), ny.iter().sum());
            let mut dropped = 0.0;
            for (d, p) in nx[..=self.degree].iter().enumerate() {
                if *p > 0.0 {
                    dropped += p * ny[self.degree + 1 - d..].iter().sum::<f64>();
                }
            }
            radius += weight * (dropped + raised(whole_x + x.radius) * y.radius + x.radius * whole_y);
            mass += weight * whole_x * whole_y;
            count += self.size() + 3;
        }
        if count > 0 {
            sum.radius = raised(raised(radius) + raised(UNIT * count as f64 * mass));
        }
        checked(sum)
    }

    fn apply(&self, f: Function, a: &Model) -> Result<Model, Fault> {
        self.composed(f, a)
    }
}

/// The sum of two nonnegative bounds, zero only if both are.
fn total(a: f64, b: f64) -> f64 {
    if a == 0.0 && b == 0.0 {
        0.0
    } else {
        raised(raised(a) + raised(b))
    }
}

impl Space {
    /// Add `weight * x * y`, as far as it is of the space, to the coefficients.
    fn accumulate(&self, sum: &mut [f64], x: &Model, y: &Model, weight: f64) {
        for (i, &c) in x.coefficients.iter().enumerate() {
            if c == 0.0 {
                continue;
            }
            let c = c * weight;
            let row = &self.products[i];
            for (&at, &d) in row.iter().zip(&y.coefficients) {
                sum[at as usize] += c * d;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers in [-1, 1] that look random and are the same in every run.
    struct Numbers(u64);

    impl Numbers {
        fn next(&mut self) -> f64 {
            self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
        }

        fn model(&mut self, space: &Space, scale: f64) -> Model {
            let coefficients = (0..space.size()).map(|_| self.next() * scale).collect();
            Model { coefficients, radius: self.next().abs() * 1e-3 * scale }
        }
    }

    fn value(space: &Space, m: &Model, z: &[f64]) -> f64 {
        let monomial = |e: &Vec<u8>| e.iter().zip(z).map(|(&p, x)| x.powi(i32::from(p))).product::<f64>();
        m.coefficients.iter().zip(&space.exponents).map(|(c, e)| c * monomial(e)).sum()
    }

    /// Every function of the models `a`, `b` (middle or an end of the radius) maps into the model of the result.
    fn assert_encloses(f: impl Fn(f64, f64) -> f64, g: impl Fn(&Space, &Model, &Model) -> Model) {
        let mut numbers = Numbers(7);
        for (variables, degree) in [(1, 1), (2, 3), (3, 2), (0, 2)] {
            let space = Space::new(variables, degree);
            for _ in 0..50 {
                let (mut a, b) = (numbers.model(&space, 0.2), numbers.model(&space, 0.2));
                a.coefficients[0] += 2.0;
                let result = g(&space, &a, &b);
                let z: Vec<f64> = (0..variables).map(|_| numbers.next()).collect();
                for (s, t) in [(0.0, 0.0), (1.0, 1.0), (-1.0, 1.0), (1.0, -1.0)] {
                    let exact = f(value(&space, &a, &z) + s * a.radius, value(&space, &b, &z) + t * b.radius);
                    let distance = (exact - value(&space, &result, &z)).abs();
                    assert!(distance <= result.radius * (1.0 + 1e-9) + 1e-14, "{distance} {}", result.radius);
                    let range = space.range(&result).expect("finite");
                    assert!(range.low() - 1e-14 <= exact && exact <= range.high() + 1e-14);
                }
            }
        }
    }

    #[test]
    fn sums_products_and_functions_enclose() {
        assert_encloses(|a, b| a + b, |s, a, b| s.add(a, b).expect("finite"));
        assert_encloses(|a, b| a - b, |s, a, b| s.sub(a, b).expect("finite"));
        assert_encloses(|a, b| a * b, |s, a, b| s.mul(a, b).expect("finite"));
        let applied = |f: Function| move |s: &Space, a: &Model, _: &Model| s.apply(f, a).expect("inside the domain");
        assert_encloses(|a, _| 1.0 / a, applied(Function::Reciprocal));
        assert_encloses(|a, _| a.sqrt(), applied(Function::Sqrt));
        assert_encloses(|a, _| a.exp(), applied(Function::Exp));
        assert_encloses(|a, _| a.ln(), applied(Function::Log));
        assert_encloses(|a, _| a.sin(), applied(Function::Sin));
        assert_encloses(|a, _| a.cos(), applied(Function::Cos));
    }

    #[test]
    fn products_of_tiny_numbers_keep_a_radius() {
        let space = Space::new(1, 1);
        let tiny = space.variable(0, 0.0, 1e-200);
        assert!(space.mul(&tiny, &tiny).expect("finite").radius > 0.0);
    }

    #[test]
    fn a_model_that_leaves_the_floats_is_a_fault() {
        let space = Space::new(1, 2);
        let huge = space.variable(0, 1e200, 1.0);
        assert_eq!(space.mul(&huge, &huge), Err(Fault::Overflow));
    }

    #[test]
    fn a_lower_degree_keeps_what_it_drops_in_the_radius() {
        let (space, linear) = (Space::new(1, 2), Space::new(1, 1));
        let square = space.mul(&space.variable(0, 0.0, 1.0), &space.variable(0, 0.0, 1.0)).expect("finite");
        let low = space.lowered(&square, &linear).expect("finite");
        assert!(low.radius >= 1.0 && low.coefficients.iter().all(|&c| c == 0.0));
    }
}
