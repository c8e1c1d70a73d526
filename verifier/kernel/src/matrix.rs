//! Square matrices of balls (a float and a radius): products, near-orthogonal inverses, transitions of linear equations.
//!
//! A matrix stands for all matrices entry by entry within the radius of the middle. Sums of products are rounded to
//! nearest; `UNIT` times their magnitudes, counted generously, goes to the radius (S. Rump, Verification methods, 2010).

use crate::fault::Fault;
use crate::interval::Interval;
use crate::models::{raised, UNIT};

/// How many terms a transition has at most, and the rest of the series that is worth no further one.
const TERMS: u32 = 24;
const HALVINGS: i32 = 8;
const GROWTH_TERMS: u32 = 120;
const NEGLIGIBLE: f64 = 1e-15;

#[derive(Debug, Clone)]
pub struct Matrix {
    n: usize,
    middle: Vec<f64>,
    radius: Vec<f64>,
}

impl Matrix {
    /// The matrix of the entries `f(i, j)`, enclosed.
    pub fn from_fn(n: usize, mut f: impl FnMut(usize, usize) -> Result<Interval, Fault>) -> Result<Matrix, Fault> {
        let mut m = Matrix { n, middle: Vec::with_capacity(n * n), radius: Vec::with_capacity(n * n) };
        for i in 0..n {
            for j in 0..n {
                let x = f(i, j)?;
                let (middle, radius) = ball(x);
                m.middle.push(middle);
                m.radius.push(radius);
            }
        }
        Ok(m)
    }

    pub(crate) fn size(&self) -> usize {
        self.n
    }

    pub(crate) fn is_zero_row(&self, i: usize) -> bool {
        let row = i * self.n..(i + 1) * self.n;
        self.middle[row.clone()].iter().chain(&self.radius[row]).all(|&x| x == 0.0)
    }

    /// The greatest rate on the diagonal, turned around: how fast something decays by itself.
    pub(crate) fn fastest_decay(&self) -> f64 {
        (0..self.n).map(|i| -self.middle[i * self.n + i]).fold(0.0, f64::max)
    }

    /// Columns that are floats.
    fn of_columns(columns: &[Vec<f64>]) -> Matrix {
        let n = columns.len();
        let middle = (0..n * n).map(|at| columns[at % n][at / n]).collect();
        Matrix { n, middle, radius: vec![0.0; n * n] }
    }

    pub fn identity(n: usize) -> Matrix {
        let middle = (0..n * n).map(|at| f64::from(u8::from(at / n == at % n))).collect();
        Matrix { n, middle, radius: vec![0.0; n * n] }
    }

    fn transposed(&self) -> Matrix {
        let n = self.n;
        let turn = |m: &[f64]| (0..n * n).map(|at| m[(at % n) * n + at / n]).collect();
        Matrix { n, middle: turn(&self.middle), radius: turn(&self.radius) }
    }

    pub fn entry(&self, i: usize, j: usize) -> Result<Interval, Fault> {
        let (m, r) = (self.middle[i * self.n + j], self.radius[i * self.n + j]);
        if r == 0.0 {
            return Interval::exactly(m);
        }
        Interval::new((m - r).next_down(), (m + r).next_up())
    }

    /// The width of an entry, rounded up.
    pub fn width(&self, i: usize, j: usize) -> f64 {
        raised(2.0 * self.radius[i * self.n + j])
    }

    pub fn product(&self, other: &Matrix) -> Matrix {
        let n = self.n;
        let mut out = Matrix { n, middle: vec![0.0; n * n], radius: vec![0.0; n * n] };
        let mut mass = vec![0.0; n];
        for i in 0..n {
            let row = i * n..(i + 1) * n;
            mass.fill(0.0);
            for k in 0..n {
                let (a, r) = (self.middle[i * n + k], self.radius[i * n + k]);
                if a == 0.0 && r == 0.0 {
                    continue;
                }
                let (size, below) = (a.abs(), k * n..(k + 1) * n);
                let sums = out.middle[row.clone()].iter_mut().zip(&mut out.radius[row.clone()]).zip(&mut mass);
                let factors = other.middle[below.clone()].iter().zip(&other.radius[below]);
                for (((middle, radius), mass), (b, s)) in sums.zip(factors) {
                    *middle += a * b;
                    *mass += size * b.abs();
                    *radius += (size + r) * s + r * b.abs();
                }
            }
            for (radius, mass) in out.radius[row].iter_mut().zip(&mass) {
                *radius = raised(*radius + UNIT * (n + 3) as f64 * mass);
            }
        }
        out
    }

    /// Add `factor` times another matrix.
    fn add_scaled(&mut self, other: &Matrix, factor: Interval) {
        let (by, spread) = ball(factor);
        for at in 0..self.middle.len() {
            let (m, r) = (other.middle[at], other.radius[at]);
            let term = by * m;
            self.middle[at] += term;
            let rounding = UNIT * 3.0 * (self.middle[at].abs() + term.abs());
            self.radius[at] = raised(self.radius[at] + (by.abs() + spread) * r + spread * m.abs() + rounding);
        }
    }

    pub fn scaled(&self, factor: Interval) -> Matrix {
        let mut out = Matrix { n: self.n, middle: vec![0.0; self.n * self.n], radius: vec![0.0; self.n * self.n] };
        out.add_scaled(self, factor);
        out
    }

    /// The greatest row sum of magnitudes, rounded up.
    pub(crate) fn norm(&self) -> f64 {
        let magnitude = |at: usize| self.middle[at].abs() + self.radius[at];
        let row = |i: usize| (0..self.n).map(|j| magnitude(i * self.n + j)).sum::<f64>();
        raised((0..self.n).map(row).fold(0.0, f64::max))
    }

    /// Radii that bound, entry by entry, the product with vectors whose entries are at most these.
    pub fn bounds(&self, radii: &[f64]) -> Vec<f64> {
        let row = |i: usize| {
            (0..self.n).map(|j| (self.middle[i * self.n + j].abs() + self.radius[i * self.n + j]) * radii[j]).sum()
        };
        (0..self.n).map(|i| raised(row(i))).collect()
    }

    /// Bounds, component by component, of the sum of the magnitudes of the products with vectors of balls: the middles
    /// given one by one, the radii summed and rounded up.
    pub fn magnitudes(&self, vectors: &[Vec<f64>], radii: &[f64]) -> Vec<f64> {
        let n = self.n;
        let mut sizes = vec![0.0; n];
        vectors.iter().for_each(|x| sizes.iter_mut().zip(x).for_each(|(s, x)| *s += x.abs()));
        let component = |i: usize| {
            let (row, spread) = (&self.middle[i * n..(i + 1) * n], &self.radius[i * n..(i + 1) * n]);
            let image = |x: &Vec<f64>| row.iter().zip(x).map(|(a, x)| a * x).sum::<f64>().abs();
            let sum: f64 = vectors.iter().map(image).sum();
            let rest =
                row.iter().zip(spread).zip(sizes.iter().zip(radii)).map(|((a, r), (size, radius))| {
                    (a.abs() + r) * radius + (r + UNIT * (n + 3) as f64 * a.abs()) * size
                });
            raised(sum + raised(rest.sum::<f64>()))
        };
        (0..n).map(component).collect()
    }

    /// The matrices `V(t)` with `V' = A(t) V`, `V(0) = I`, for any `A(t)` in this one and `t` in a span, which starts
    /// at zero or is a point: the Peano-Baker series, over a part of the span that makes it short, then squares for a
    /// point, as every part of a way has the transitions of the first.
    pub fn transition(&self, span: Interval) -> Result<Matrix, Fault> {
        let size = self.norm() * span.norm();
        let is_point = span.low() == span.high();
        let halvings = if is_point && size > 1.0 { (size.log2().ceil() as i32).min(HALVINGS) } else { 0 };
        let part = Interval::exactly(0.5f64.powi(halvings))?;
        let mut result = self.series(std::ops::Mul::mul(span, part)?)?;
        for _ in 0..halvings {
            result = result.product(&result);
        }
        if result.middle.iter().chain(&result.radius).all(|x| x.is_finite()) {
            Ok(result)
        } else {
            Err(Fault::Overflow)
        }
    }

    fn series(&self, span: Interval) -> Result<Matrix, Fault> {
        let mut result = Matrix::identity(self.n);
        let mut power = Matrix::identity(self.n);
        let mut factor = Interval::exactly(1.0)?;
        let size = self.norm() * span.norm();
        for k in 1..=TERMS {
            power = if k == 1 { self.clone() } else { self.product(&power) };
            factor = std::ops::Mul::mul(factor, span)?;
            factor = std::ops::Div::div(factor, Interval::exactly(f64::from(k))?)?;
            result.add_scaled(&power, factor);
            // The rest of the series: its terms shrink at least like powers of `g`.
            let g = raised(size / f64::from(k + 1));
            let rest = raised(2.0 * g * power.norm() * factor.norm());
            if g < 0.5 && (rest <= NEGLIGIBLE || (k == TERMS && rest.is_finite())) {
                result.radius.iter_mut().for_each(|r| *r = raised(*r + rest));
                return Ok(result);
            }
        }
        Err(Fault::Overflow)
    }

    /// Bounds of `|V(t) e|` for `V' = A(t) V`, `V(0) = I`, any `A(t)` in this matrix, `t` from 0 to `h` and `|e|` at
    /// most these radii; `None` where they leave the floats.
    ///
    /// With `u' = M u`, where `M` has the magnitudes of this matrix, and on its diagonal no more than the positive part:
    /// the magnitudes of a solution grow no faster (W. Walter, Differential and integral inequalities), and `u` grows.
    pub fn growth(&self, h: f64, radii: &[f64]) -> Option<Vec<f64>> {
        let n = self.n;
        let rate = |at: usize| {
            let (m, r) = (self.middle[at], self.radius[at]);
            h * if at.is_multiple_of(n + 1) { (m + r).max(0.0) } else { m.abs() + r }
        };
        let rates: Vec<f64> = (0..n * n).map(|at| if rate(at) == 0.0 { 0.0 } else { raised(rate(at)) }).collect();
        let size = raised(rates.chunks(n).map(|row| row.iter().sum()).fold(0.0, f64::max));
        let (mut sum, mut term) = (radii.to_vec(), radii.to_vec());
        for k in 1..=GROWTH_TERMS {
            let part = 1.0 / f64::from(k);
            let row = |row: &[f64]| row.iter().zip(&term).map(|(a, x)| a * x).sum::<f64>() * part;
            term = rates.chunks(n).map(row).map(|x| if x == 0.0 { 0.0 } else { raised(x) }).collect();
            sum.iter_mut().zip(&term).for_each(|(s, x)| *s += x);
            let (g, last) = (size / f64::from(k + 1), term.iter().fold(0.0, |a: f64, &x| a.max(x)));
            let rest = raised(2.0 * g * last);
            if g < 0.5 && rest <= 1e-290 + 1e-13 * sum.iter().fold(0.0, |a: f64, &x| a.max(x)) {
                return Some(sum.into_iter().map(|s| raised(raised(s) + rest)).collect());
            }
        }
        None
    }
}

/// A float of an interval and the radius around it that covers the interval.
fn ball(x: Interval) -> (f64, f64) {
    let middle = x.midpoint();
    let radius = (x.high() - middle).max(middle - x.low());
    (middle, if radius == 0.0 { 0.0 } else { raised(radius) })
}

/// Axes that are nearly orthogonal, the first along the first of the vectors, and an enclosure of the inverse of the
/// matrix that has them as columns; `None` if they are not orthogonal enough.
///
/// With `D = I - Q'Q` and `|D| < 1` in the maximum norm, the inverse is `(I + D + D^2 + ...) Q'`, which differs from
/// `Q'` by a matrix whose entries are at most `|D| / (1 - |D|)` times the greatest magnitude of an entry of `Q'`.
pub fn axes(vectors: &[Vec<f64>], n: usize) -> Option<(Vec<Vec<f64>>, Matrix)> {
    let columns = orthogonal(vectors, n);
    let q = Matrix::of_columns(&columns);
    let mut inverse = q.transposed();
    let mut defect = inverse.product(&q).scaled(Interval::exactly(-1.0).ok()?);
    defect.add_scaled(&Matrix::identity(n), Interval::exactly(1.0).ok()?);
    let size = defect.norm();
    if size.is_nan() || size > 1e-3 {
        return None;
    }
    // Entries of Q' are at most 1 + |D| in magnitude.
    inverse.radius.iter_mut().for_each(|r| *r = raised(*r + 2.1 * size));
    Some((columns, inverse))
}

/// An orthonormal basis, up to rounding, that follows the given vectors, the earlier the better.
fn orthogonal(vectors: &[Vec<f64>], n: usize) -> Vec<Vec<f64>> {
    let units: Vec<Vec<f64>> = (0..n).map(|i| (0..n).map(|j| f64::from(u8::from(i == j))).collect()).collect();
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for candidate in vectors.iter().chain(&units) {
        if basis.len() == n {
            break;
        }
        let mut rest = candidate.clone();
        for _ in 0..2 {
            for b in &basis {
                let along: f64 = rest.iter().zip(b).map(|(x, y)| x * y).sum();
                rest.iter_mut().zip(b).for_each(|(x, y)| *x -= along * y);
            }
        }
        let (before, after) = (length(candidate), length(&rest));
        if after > 1e-2 * before && after.is_normal() {
            basis.push(rest.iter().map(|x| x / after).collect());
        }
    }
    basis
}

fn length(x: &[f64]) -> f64 {
    x.iter().map(|v| v * v).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn matrix(rows: &[[f64; 2]; 2], radius: f64) -> Matrix {
        let entry = |i: usize, j: usize| Interval::new(rows[i][j] - radius, rows[i][j] + radius);
        Matrix::from_fn(2, entry).expect("finite")
    }

    fn assert_holds(m: &Matrix, rows: &[[f64; 2]; 2], width: f64) {
        for (i, row) in rows.iter().enumerate() {
            for (j, &x) in row.iter().enumerate() {
                let found = m.entry(i, j).expect("finite");
                assert!(found.contains(x), "{found:?} {x}");
                assert!(found.width().expect("finite") <= width);
            }
        }
    }

    #[test]
    fn products_hold_those_of_all_members() {
        let (a, b) = ([[1.0, 2.0], [3.0, -4.0]], [[0.5, 0.0], [-1.0, 2.0]]);
        let found = matrix(&a, 0.1).product(&matrix(&b, 0.1));
        assert_holds(&found, &[[-1.5, 4.0], [5.5, -8.0]], 2.0);
        assert_holds(&found, &[[1.1 * 0.6 - 1.9 * 0.9, 1.1 * 0.1 + 1.9 * 2.1], [5.5, -8.0]], 2.0);
    }

    #[test]
    fn the_transition_of_a_rotation_is_a_rotation() {
        let m = matrix(&[[0.0, 1.0], [-1.0, 0.0]], 0.0).transition(Interval::exactly(0.3).expect("finite"));
        let (c, s) = (0.3f64.cos(), 0.3f64.sin());
        assert_holds(&m.expect("short"), &[[c, s], [-s, c]], 1e-6);
        let all = matrix(&[[0.0, 1.0], [-1.0, 0.0]], 0.0).transition(Interval::new(0.0, 0.3).expect("finite"));
        assert_holds(&all.expect("short"), &[[1.0, 0.0], [0.0, 1.0]], 0.7);
    }

    #[test]
    fn a_long_span_is_made_of_short_ones_and_a_longer_one_refused() {
        let m = matrix(&[[0.0, 9.0], [9.0, 0.0]], 0.0);
        let at = |t: f64| m.transition(Interval::exactly(t).expect("finite"));
        let (c, s) = (27f64.cosh(), 27f64.sinh());
        assert_holds(&at(3.0).expect("short enough"), &[[c, s], [s, c]], 10.0);
        assert!(at(1e6).is_err());
        assert!(m.growth(1e6, &[1.0, 1.0]).is_none());
    }

    #[test]
    fn growth_bounds_solutions_also_where_they_fall_first() {
        let rows = [[-8.0, 1.0], [0.5, 0.25]];
        let m = matrix(&rows, 0.0);
        let bounds = m.growth(1.0, &[1.0, 0.5]).expect("short");
        assert!(bounds[0] < 3.0 && bounds[1] < 2.0, "{bounds:?}");
        for (mut x, mut y) in [(1.0, 0.5), (1.0, -0.5)] {
            for _ in 0..10_000 {
                assert!(f64::abs(x) <= bounds[0] && f64::abs(y) <= bounds[1], "{x} {y} {bounds:?}");
                (x, y) = (x + 1e-4 * (rows[0][0] * x + rows[0][1] * y), y + 1e-4 * (rows[1][0] * x + rows[1][1] * y));
            }
        }
    }

    #[test]
    fn axes_are_inverted() {
        let vectors = [vec![3.0, 4.0], vec![3.0, 4.0001]];
        let (columns, inverse) = axes(&vectors, 2).expect("nearly orthogonal");
        assert_holds(&inverse.product(&Matrix::of_columns(&columns)), &[[1.0, 0.0], [0.0, 1.0]], 1e-12);
        assert!((columns[0][0] - 0.6).abs() < 1e-12 && (columns[0][1] - 0.8).abs() < 1e-12);
    }
}
