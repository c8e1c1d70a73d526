//! Functions of one real variable on [-1, 1]: sums of Chebyshev polynomials with float coefficients, and a radius that
//! holds every error.
//!
//! What is dropped and rounded goes to the radius, as in `models`. No Chebyshev polynomial is above 1 on the interval, so
//! sums of magnitudes bound ranges well even at high degrees (compare L. Trefethen, Approximation Theory and
//! Approximation Practice, 2013).

use crate::fault::Fault;
use crate::interval::{Enclosure, Interval};
use crate::models::{raised, Model, UNIT};
use crate::series::{Function, Ring, Term};
use std::ops::{Add, Mul};

/// Models of at most some degree; coefficients that are missing at the end are zero.
pub(crate) struct Line {
    pub(crate) degree: usize,
}

/// At least the sum of the magnitudes.
pub(crate) fn mass(coefficients: &[f64]) -> f64 {
    let sum: f64 = coefficients.iter().map(|c| c.abs()).sum();
    if sum == 0.0 {
        0.0
    } else {
        raised(sum)
    }
}

fn finite(model: Model) -> Result<Model, Fault> {
    if model.radius.is_finite() && model.coefficients.iter().all(|c| c.is_finite()) {
        Ok(model)
    } else {
        Err(Fault::Overflow)
    }
}

/// The range on the whole interval.
pub(crate) fn range(a: &Model) -> Enclosure {
    let (first, rest) = a.coefficients.split_first().ok_or(Fault::Unknown)?;
    Interval::exactly(*first)?.add(Interval::symmetric(raised(mass(rest) + a.radius))?)
}

/// The sum of `weights[i] * models[i]`.
pub(crate) fn combination<'m>(terms: impl Iterator<Item = (&'m Model, Interval)>) -> Result<Model, Fault> {
    let mut sum: Vec<f64> = vec![0.0];
    let (mut radius, mut all, mut count) = (0.0, 0.0, 3.0);
    for (model, weight) in terms {
        let middle = weight.midpoint();
        let half = (weight.high() - middle).max(middle - weight.low());
        let norm = mass(&model.coefficients);
        if sum.len() < model.coefficients.len() {
            sum.resize(model.coefficients.len(), 0.0);
        }
        sum.iter_mut().zip(&model.coefficients).for_each(|(s, c)| *s += middle * c);
        radius += raised(half) * norm + weight.norm() * model.radius;
        all += middle.abs() * norm;
        count += 1.0;
    }
    finite(Model { coefficients: sum, radius: raised(raised(radius) + raised(UNIT * count * all)) })
}

/// The values at -1 and at 1 of a sum without errors.
pub(crate) fn ends(coefficients: &[f64]) -> Result<(Interval, Interval), Fault> {
    let (mut low, mut high) = (Interval::ZERO, Interval::ZERO);
    for (k, &c) in coefficients.iter().enumerate() {
        high = high.add(Interval::exactly(c)?)?;
        low = low.add(Interval::exactly(if k % 2 == 0 { c } else { -c })?)?;
    }
    Ok((low, high))
}

/// The derivative of a sum without errors: `d_(k-1) = d_(k+1) + 2 k c_k`, and half of that for `k = 1`.
pub(crate) fn derivative(coefficients: &[f64]) -> Result<Model, Fault> {
    let degree = coefficients.len().saturating_sub(1);
    let mut found = vec![Interval::ZERO; degree + 2];
    for k in (1..=degree).rev() {
        let own = Interval::exactly(coefficients[k])?.mul(Interval::exactly(2.0 * k as f64)?)?;
        found[k - 1] = found[k + 1].add(own)?;
    }
    found[0] = found[0].mul(Interval::exactly(0.5)?)?;
    let middles: Vec<f64> = found[..degree.max(1)].iter().map(|x| x.midpoint()).collect();
    let off = |(x, m): (&Interval, &f64)| (x.high() - m).max(m - x.low());
    let radius: f64 = found.iter().zip(&middles).map(off).sum();
    finite(Model { coefficients: middles, radius: raised(radius) })
}

/// The coefficients of Chebyshev polynomials in powers of `(1 + s) / 2`: whole numbers that are floats up to this degree.
pub(crate) const MOST: usize = 16;

/// For each degree the coefficients by power.
pub(crate) fn shifted_polynomials(degree: usize) -> Vec<Vec<f64>> {
    let mut found = vec![vec![1.0], vec![-1.0, 2.0]];
    for k in 2..=degree.min(MOST) {
        let (one, two) = (&found[k - 1], &found[k - 2]);
        let at = |x: &Vec<f64>, i: usize| x.get(i).copied().unwrap_or(0.0);
        let next = (0..=k).map(|i| {
            let before = if i > 0 { at(one, i - 1) } else { 0.0 };
            4.0 * before - 2.0 * at(one, i) - at(two, i)
        });
        found.push(next.collect());
    }
    found
}

impl Ring for Line {
    type Element = Model;

    fn constant(&self, value: Interval) -> Model {
        let middle = value.midpoint();
        let rest = (value.high() - middle).max(middle - value.low());
        Model { coefficients: vec![middle], radius: if rest == 0.0 { 0.0 } else { raised(rest) } }
    }

    fn add(&self, a: &Model, b: &Model) -> Result<Model, Fault> {
        let (long, short) = if a.coefficients.len() < b.coefficients.len() { (b, a) } else { (a, b) };
        let mut coefficients = long.coefficients.clone();
        coefficients.iter_mut().zip(&short.coefficients).for_each(|(s, c)| *s += c);
        let rounding = UNIT * mass(&coefficients[..short.coefficients.len()]);
        finite(Model { coefficients, radius: raised(a.radius + b.radius + rounding) })
    }

    fn sub(&self, a: &Model, b: &Model) -> Result<Model, Fault> {
        let negative = Model { coefficients: b.coefficients.iter().map(|c| -c).collect(), radius: b.radius };
        self.add(a, &negative)
    }

    fn scale(&self, a: &Model, by: Interval) -> Result<Model, Fault> {
        combination(std::iter::once((a, by)))
    }

    /// `T_i T_j = (T_(i+j) + T_|i-j|) / 2`.
    fn sum<'e>(&self, terms: impl Iterator<Item = Term<'e, Model>> + Clone) -> Result<Model, Fault> {
        let longest = terms.clone().map(|(_, a, b)| a.coefficients.len() + b.coefficients.len()).max().unwrap_or(2);
        let mut sum = vec![0.0; (longest - 1).min(self.degree + 1)];
        let (mut radius, mut all, mut count) = (0.0, 0.0, 0.0);
        for (weight, a, b) in terms {
            let (norm_a, norm_b) = (mass(&a.coefficients), mass(&b.coefficients));
            let mut dropped = 0.0;
            for (i, x) in a.coefficients.iter().enumerate().filter(|(_, x)| **x != 0.0) {
                for (j, y) in b.coefficients.iter().enumerate() {
                    let half = 0.5 * weight * x * y;
                    for at in [i + j, i.abs_diff(j)] {
                        match sum.get_mut(at) {
                            Some(s) => *s += half,
                            None => dropped += half.abs(),
                        }
                    }
                }
            }
            radius += weight * (norm_a + a.radius) * b.radius + weight * a.radius * norm_b + dropped;
            all += weight * norm_a * norm_b;
            count += 2.0 * (a.coefficients.len() + b.coefficients.len()) as f64 + 6.0;
        }
        finite(Model { coefficients: sum, radius: raised(raised(radius) + raised(UNIT * count * all)) })
    }

    /// The Taylor polynomial of `f` at the first coefficient, with Lagrange's remainder.
    fn apply(&self, f: Function, a: &Model) -> Result<Model, Fault> {
        let centre = Interval::exactly(a.coefficients[0])?;
        let mut rest = a.clone();
        rest.coefficients[0] = 0.0;
        let whole = centre.add(range(&rest)?)?;
        let order = self.degree as u32;
        let mut sum = self.constant(f.coefficient(whole, order + 1)?);
        for k in (0..=order).rev() {
            sum = self.mul(&sum, &rest)?;
            sum = self.add(&sum, &self.constant(f.coefficient(centre, k)?))?;
        }
        Ok(sum)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(coefficients: &[f64], s: f64) -> f64 {
        coefficients.iter().enumerate().map(|(k, c)| c * (k as f64 * s.acos()).cos()).sum()
    }

    fn curves() -> [Model; 2] {
        let one = Model { coefficients: vec![2.0, 0.3, -0.2, 0.05], radius: 1e-3 };
        [one, Model { coefficients: vec![1.5, -0.25, 0.125], radius: 2e-3 }]
    }

    /// Every function of the curves, in the middle or at an end of their radii, lies in the result.
    fn assert_encloses(f: impl Fn(f64, f64) -> f64, g: impl Fn(&Line, &Model, &Model) -> Model) {
        let [a, b] = curves();
        for degree in [3, 5, 12] {
            let result = g(&Line { degree }, &a, &b);
            for (s, u, v) in (0..=20).flat_map(|i| {
                let s = f64::from(i) / 10.0 - 1.0;
                [(s, 0.0, 0.0), (s, 1.0, -1.0), (s, -1.0, 1.0), (s, 1.0, 1.0)]
            }) {
                let exact = f(value(&a.coefficients, s) + u * a.radius, value(&b.coefficients, s) + v * b.radius);
                assert!((exact - value(&result.coefficients, s)).abs() <= result.radius + 1e-13);
                let whole = range(&result).expect("finite");
                assert!(whole.low() - 1e-13 <= exact && exact <= whole.high() + 1e-13);
            }
        }
    }

    #[test]
    fn sums_products_and_functions_enclose() {
        assert_encloses(|a, b| a + b, |l, a, b| l.add(a, b).expect("finite"));
        assert_encloses(|a, b| a - b, |l, a, b| l.sub(a, b).expect("finite"));
        assert_encloses(|a, b| a * b, |l, a, b| l.mul(a, b).expect("finite"));
        assert_encloses(|a, _| a * a, |l, a, _| l.mul(a, a).expect("finite"));
        let third = Interval::new(0.33, 0.34).expect("in order");
        assert_encloses(|a, _| a * 0.333, |l, a, _| l.scale(a, third).expect("finite"));
        for (f, g) in [
            (Function::Reciprocal, (|x: f64| 1.0 / x) as fn(f64) -> f64),
            (Function::Exp, f64::exp),
            (Function::Sin, f64::sin),
            (Function::Sqrt, f64::sqrt),
        ] {
            assert_encloses(|a, _| g(a), |l, a, _| l.apply(f, a).expect("inside the domain"));
        }
    }

    #[test]
    fn derivatives_and_ends_are_those_of_the_sum() {
        let c = [0.5, -0.25, 0.125, 0.75, 0.1];
        let slope = derivative(&c).expect("finite");
        for s in [-0.9, -0.3, 0.0, 0.4, 0.8] {
            let near = (value(&c, s + 1e-6) - value(&c, s - 1e-6)) / 2e-6;
            assert!((value(&slope.coefficients, s) - near).abs() < 1e-8);
        }
        let (low, high) = ends(&c).expect("finite");
        assert!((low.midpoint() - value(&c, -1.0)).abs() < 1e-15 && (high.midpoint() - value(&c, 1.0)).abs() < 1e-15);
    }

    #[test]
    fn powers_add_up_to_chebyshev_polynomials() {
        for (k, powers) in shifted_polynomials(MOST).iter().enumerate() {
            assert_eq!(powers.iter().sum::<f64>(), 1.0);
            assert_eq!(powers[0], if k % 2 == 0 { 1.0 } else { -1.0 });
            let at = powers.iter().rev().fold(0.0, |sum, c| sum * 0.75 + c);
            assert!((at - (k as f64 * 0.5f64.acos()).cos()).abs() < 1e-5);
        }
    }
}
