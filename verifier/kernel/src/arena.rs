//! Polynomials in numbered places of one block of floats, so that sums of products need no memory of their own.
//!
//! The arithmetic is that of `models`: a place stands for a Taylor model, with the same bounds of what is rounded and
//! dropped. Beside its coefficients a place knows its sums of magnitudes by degree and how many degrees it has, so that
//! zeros, numbers and low degrees cost little. Coefficients beyond those degrees are zero, whatever the block holds.

use crate::fault::Fault;
use crate::interval::{Enclosure, Interval};
use crate::models::{raised, Model, Space, UNIT};
use std::sync::Arc;

/// A weighted product of two places.
pub type Product = (f64, usize, usize);

/// What is known of a place.
#[derive(Debug, Clone, Copy, Default)]
struct Head {
    radius: f64,
    /// The sum of all magnitudes, rounded up.
    whole: f64,
    /// How many degrees it has: zero for no polynomial at all, one for a number.
    degrees: usize,
}

impl Head {
    fn is_zero(&self) -> bool {
        self.degrees == 0 && self.radius == 0.0
    }
}

pub struct Arena {
    space: Arc<Space>,
    heads: Vec<Head>,
    /// `degree + 1` sums of magnitudes for each place.
    norms: Vec<f64>,
    coefficients: Vec<f64>,
    /// How many degrees of sums of products are kept; bounds of the others go to the radius.
    limit: usize,
    /// Where a sum grows before it is put in its place.
    sum: Vec<f64>,
}

impl Arena {
    /// Places that are all zero.
    pub fn new(space: Arc<Space>, places: usize) -> Arena {
        let (size, degrees) = (space.size(), space.degree + 1);
        Arena {
            heads: vec![Head::default(); places],
            norms: vec![0.0; places * degrees],
            coefficients: vec![0.0; places * size],
            limit: degrees,
            sum: vec![0.0; size],
            space,
        }
    }

    /// A range of a place: around its number, as far as the sums of magnitudes go.
    pub fn range(&self, at: usize) -> Enclosure {
        let middle = self.polynomial(at).first().copied().unwrap_or(0.0);
        let spread = raised(self.norms(at).iter().skip(1).sum::<f64>() + self.heads[at].radius);
        Interval::new((middle - spread).next_down(), (middle + spread).next_up())
    }

    /// Keep all degrees again.
    pub fn keep_all(&mut self) {
        self.limit = self.space.degree + 1;
    }

    /// Keep so many degrees of sums of products from now on, if there are as many.
    pub fn keep(&mut self, degrees: usize) {
        self.limit = degrees.clamp(1, self.space.degree + 1);
    }

    /// How many degrees of a place, the last of them included, have a sum of magnitudes above this.
    pub fn degrees_above(&self, at: usize, least: f64) -> usize {
        self.norms(at).iter().rposition(|&norm| norm > least).map_or(0, |d| d + 1)
    }

    fn count(&self, at: usize) -> usize {
        self.space.upto_degrees(self.heads[at].degrees)
    }

    fn polynomial(&self, at: usize) -> &[f64] {
        let from = at * self.space.size();
        &self.coefficients[from..from + self.count(at)]
    }

    fn norms(&self, at: usize) -> &[f64] {
        let width = self.space.degree + 1;
        &self.norms[at * width..at * width + self.heads[at].degrees]
    }

    pub fn model(&self, at: usize) -> Model {
        let mut model = self.space.zero();
        let known = self.polynomial(at);
        model.coefficients[..known.len()].copy_from_slice(known);
        model.radius = self.heads[at].radius;
        model
    }

    pub fn set(&mut self, at: usize, model: &Model) -> Result<(), Fault> {
        self.sum.copy_from_slice(&model.coefficients);
        self.settle(at, self.space.degree + 1, model.radius)
    }

    /// Put what was summed in its place, of at most so many degrees.
    fn settle(&mut self, at: usize, degrees: usize, radius: f64) -> Result<(), Fault> {
        let size = self.space.size();
        let count = self.space.upto_degrees(degrees);
        self.coefficients[at * size..at * size + count].copy_from_slice(&self.sum[..count]);
        let width = self.space.degree + 1;
        let mut head = Head { radius, whole: 0.0, degrees: 0 };
        let mut from = 0;
        for d in 0..degrees {
            let to = self.space.upto_degrees(d + 1);
            let sum: f64 = self.sum[from..to].iter().map(|c| c.abs()).sum();
            let norm = if sum == 0.0 { 0.0 } else { raised(sum) };
            self.norms[at * width + d] = norm;
            if sum != 0.0 {
                head.degrees = d + 1;
            }
            head.whole += norm;
            from = to;
        }
        self.heads[at] = head;
        // A coefficient that left the floats makes its sum infinite or no number.
        if head.whole.is_finite() && radius.is_finite() {
            Ok(())
        } else {
            Err(Fault::Overflow)
        }
    }

    /// `at = a + sign * b` for a sign of one or minus one.
    pub fn combine(&mut self, at: usize, a: usize, b: usize, sign: f64) -> Result<(), Fault> {
        let (x, y) = (self.heads[a], self.heads[b]);
        if y.is_zero() {
            self.signed(at, a, 1.0);
            return Ok(());
        }
        if x.is_zero() {
            self.signed(at, b, sign);
            return Ok(());
        }
        let degrees = x.degrees.max(y.degrees);
        let size = self.space.size();
        let (m, n) = (self.count(a), self.count(b));
        let sum = &mut self.sum[..m.max(n)];
        sum[..m].copy_from_slice(&self.coefficients[a * size..a * size + m]);
        sum[m..].fill(0.0);
        let mut mass = 0.0;
        for (s, c) in sum.iter_mut().zip(&self.coefficients[b * size..b * size + n]) {
            let exact = *s == 0.0 || *c == 0.0;
            *s += sign * c;
            mass += if exact { 0.0 } else { s.abs() };
        }
        self.settle(at, degrees, bound(x.radius + y.radius, 2.0 * UNIT * mass))
    }

    /// `at = sign * a` for a sign of one or minus one.
    pub fn signed(&mut self, at: usize, a: usize, sign: f64) {
        let (size, count, width) = (self.space.size(), self.count(a), self.space.degree + 1);
        self.heads[at] = self.heads[a];
        self.norms.copy_within(a * width..a * width + self.heads[a].degrees, at * width);
        self.coefficients.copy_within(a * size..a * size + count, at * size);
        if sign < 0.0 {
            self.coefficients[at * size..at * size + count].iter_mut().for_each(|c| *c = -*c);
        }
    }

    /// `at = by * a`.
    pub fn scale(&mut self, at: usize, a: usize, by: Interval) -> Result<(), Fault> {
        let x = self.heads[a];
        if x.is_zero() {
            self.heads[at] = x;
            return Ok(());
        }
        let middle = by.midpoint();
        if by.low() == by.high() && middle.abs() == 1.0 {
            self.signed(at, a, middle);
            return Ok(());
        }
        let half = (by.high() - middle).max(middle - by.low());
        let (size, count) = (self.space.size(), self.count(a));
        for (s, c) in self.sum.iter_mut().zip(&self.coefficients[a * size..a * size + count]) {
            *s = middle * c;
        }
        let rounding = raised(UNIT * 2.0 * middle.abs() * x.whole);
        let radius = raised(raised(half) * x.whole + by.norm() * x.radius + rounding);
        self.settle(at, x.degrees, radius)
    }

    /// `at` becomes the sum of the weighted products; weights are not negative.
    pub fn sum(&mut self, at: usize, products: &[Product]) -> Result<(), Fault> {
        let (mut degrees, mut radius, mut mass, mut count) = (0, 0.0, 0.0, 0usize);
        for &(weight, a, b) in products {
            let (x, y) = (self.heads[a], self.heads[b]);
            if x.is_zero() || y.is_zero() {
                continue;
            }
            radius += weight * ((x.whole + x.radius) * y.radius + x.radius * y.whole);
            count += 3;
            if x.degrees == 0 || y.degrees == 0 {
                continue;
            }
            let reached = (x.degrees + y.degrees - 1).min(self.limit);
            if reached > degrees {
                let (from, to) = (self.space.upto_degrees(degrees), self.space.upto_degrees(reached));
                self.sum[from..to].fill(0.0);
                degrees = reached;
            }
            radius += weight * self.dropped(a, b);
            mass += weight * x.whole * y.whole;
            count += self.count(a).min(self.count(b));
            let (few, many) = if x.degrees <= y.degrees { (a, b) } else { (b, a) };
            self.accumulate(few, many, weight);
        }
        if count == 0 {
            self.heads[at] = Head::default();
            return Ok(());
        }
        self.settle(at, degrees, raised(raised(radius) + raised(UNIT * count as f64 * mass)))
    }

    /// What a product has beyond the degrees that are kept.
    fn dropped(&self, a: usize, b: usize) -> f64 {
        let (x, y) = (self.norms(a), self.norms(b));
        if x.len() + y.len() <= self.limit + 1 {
            return 0.0;
        }
        let beyond = |d: usize| y.iter().skip(self.limit.saturating_sub(d)).sum::<f64>();
        x.iter().enumerate().map(|(d, p)| if *p > 0.0 { p * beyond(d) } else { 0.0 }).sum()
    }

    fn accumulate(&mut self, few: usize, many: usize, weight: f64) {
        let size = self.space.size();
        let x = &self.coefficients[few * size..few * size + self.count(few)];
        let y = &self.coefficients[many * size..many * size + self.count(many)];
        let first = weight * x[0];
        if first != 0.0 {
            let kept = self.space.upto_degrees(self.limit);
            self.sum[..kept].iter_mut().zip(y).for_each(|(s, d)| *s += first * d);
        }
        for d in 1..self.heads[few].degrees.min(self.limit) {
            let own = self.space.upto_degrees(d)..self.space.upto_degrees(d + 1);
            let scale = weight * y[0];
            if scale != 0.0 {
                self.sum[own.clone()].iter_mut().zip(&x[own.clone()]).for_each(|(s, c)| *s += scale * c);
            }
            // The longer block of a pair of degrees is the inner loop.
            let last = self.heads[many].degrees.min(self.limit - d);
            for e in 1..last.min(d) {
                let other = self.space.upto_degrees(e)..self.space.upto_degrees(e + 1);
                self.space.spread(&mut self.sum, weight, (other, y), (own.clone(), x));
            }
            if last > d {
                let others = self.space.upto_degrees(d)..self.space.upto_degrees(last);
                self.space.spread(&mut self.sum, weight, (own, x), (others, y));
            }
        }
    }
}

/// The sum of two nonnegative bounds, zero only if both are.
fn bound(a: f64, b: f64) -> f64 {
    if a == 0.0 && b == 0.0 {
        0.0
    } else {
        raised(raised(a) + raised(b))
    }
}
