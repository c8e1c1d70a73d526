//! Bounds of the solutions of `v' = M v + d`, where `M` has no negative entry off its diagonal: such solutions bound the
//! magnitudes of those of a linear equation whose diagonal is at most that of `M`, and whose other entries are at most
//! its entries in magnitude (W. Walter, Differential and Integral Inequalities, 1970).

use crate::interval::Interval;
use crate::models::raised;

const TERMS: usize = 40;
const SQUARES: u32 = 60;

/// A square matrix by rows, and `d`.
pub(crate) struct Comparison {
    pub(crate) rates: Vec<f64>,
    pub(crate) driven: Vec<f64>,
}

/// What becomes of a start: bounds at the end that grow with the start, and those from `d` alone.
pub(crate) struct Bounds {
    pub(crate) moved: Vec<f64>,
    pub(crate) driven: Vec<f64>,
}

impl Bounds {
    pub(crate) fn sum(&self) -> Vec<f64> {
        self.moved.iter().zip(&self.driven).map(|(m, d)| raised(m + d)).collect()
    }
}

impl Comparison {
    /// At the end of a time `h`, from at most these magnitudes; `None` where they leave the floats.
    pub(crate) fn after(&self, h: f64, start: &[f64]) -> Option<Bounds> {
        self.with(h, start, |rate| rate)
    }

    /// At all instants up to `h`.
    pub(crate) fn during(&self, h: f64, start: &[f64]) -> Option<Bounds> {
        // With no negative rate solutions grow, and so bound themselves at earlier instants.
        self.with(h, start, |rate| rate.max(0.0))
    }

    fn with(&self, h: f64, start: &[f64], diagonal: impl Fn(f64) -> f64) -> Option<Bounds> {
        let n = start.len();
        let m = n + 1; // one more state, which stays 1, drives the others
        let rate = |i: usize, j: usize| match (i, j) {
            (i, _) if i == n => 0.0,
            (i, j) if j == n => self.driven[i],
            (i, j) if i == j => diagonal(self.rates[i * n + i]),
            (i, j) => self.rates[i * n + j],
        };
        let fastest = (0..n).map(|i| -rate(i, i)).fold(0.0, f64::max);
        let row = |i: usize| (0..m).map(|j| if i == j { rate(i, i).abs() } else { rate(i, j) }).sum::<f64>();
        let size = h * (fastest + (0..n).map(row).fold(0.0, f64::max));
        let halvings = if size > 0.5 { (size.log2().ceil().max(0.0) as u32).saturating_add(1) } else { 0 };
        if !size.is_finite() || halvings > SQUARES {
            return None;
        }
        let part = h * 0.5f64.powi(halvings as i32);
        let up = |x: f64| if x <= 0.0 { 0.0 } else { raised(x) };
        let shifted = |at: usize| {
            let (i, j) = (at / m, at % m);
            part * if i == j { up(raised(rate(i, i) + fastest).max(0.0)) } else { rate(i, j) }
        };
        // The shift is exact up to rounding that is far below what `raised` adds to entries of its size.
        let slack = 4.0 * f64::EPSILON * (fastest * part);
        let matrix: Vec<f64> =
            (0..m * m).map(|at| up(shifted(at) + if at % (m + 1) == 0 { slack } else { 0.0 })).collect();
        let mut found = exponential(&matrix, m)?;
        let back = Interval::exactly(part).ok()?;
        let back = std::ops::Mul::mul(back, Interval::exactly(fastest).ok()?).ok()?;
        let shrunk = std::ops::Neg::neg(back).ok()?.exp().ok()?.high();
        found.iter_mut().for_each(|x| *x = up(*x * shrunk));
        for _ in 0..halvings {
            found = product(&found, &found, m);
        }
        let moved = |i: usize| up((0..n).map(|j| found[i * m + j] * start[j]).sum());
        let bounds =
            Bounds { moved: (0..n).map(moved).collect(), driven: (0..n).map(|i| up(found[i * m + n])).collect() };
        bounds.moved.iter().chain(&bounds.driven).all(|x| x.is_finite()).then_some(bounds)
    }
}

/// At least the product of matrices without negative entries.
fn product(a: &[f64], b: &[f64], n: usize) -> Vec<f64> {
    let entry = |at: usize| (0..n).map(|k| a[(at / n) * n + k] * b[k * n + at % n]).sum::<f64>();
    (0..n * n).map(entry).map(|x| if x == 0.0 { 0.0 } else { raised(x) }).collect()
}

/// At least the exponential of a matrix without negative entries.
fn exponential(a: &[f64], n: usize) -> Option<Vec<f64>> {
    let norm = |x: &[f64]| raised(x.chunks(n).map(|row| row.iter().sum::<f64>()).fold(0.0, f64::max));
    let size = norm(a);
    let mut sum: Vec<f64> = (0..n * n).map(|at| f64::from(u8::from(at / n == at % n))).collect();
    let mut term = sum.clone();
    for k in 1..=TERMS {
        let scale = 1.0 / k as f64;
        term = product(&term, a, n).into_iter().map(|x| if x == 0.0 { 0.0 } else { raised(x * scale) }).collect();
        sum.iter_mut().zip(&term).for_each(|(s, t)| *s = if *t == 0.0 { *s } else { raised(*s + t) });
        // Later terms shrink at least like powers of a half.
        let last = norm(&term);
        if size < 0.5 * k as f64 && last < 1e-40 {
            sum.iter_mut().for_each(|s| *s = raised(*s + last));
            return Some(sum);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decay_and_drive_are_bounded_closely() {
        let fast = Comparison { rates: vec![-1e4], driven: vec![2.0] };
        let end = fast.after(1.0, &[3.0]).expect("finite");
        assert!(end.moved[0] < 1e-30 && (end.driven[0] - 2e-4).abs() < 2e-6);
        let slow = Comparison { rates: vec![0.5], driven: vec![0.0] };
        let end = slow.after(2.0, &[1.0]).expect("finite");
        assert!(end.moved[0] >= 1f64.exp() && end.moved[0] < 1f64.exp() * (1.0 + 1e-6) && end.driven[0] < 1e-30);
    }

    #[test]
    fn coupled_solutions_stay_below() {
        let rows = [[-8.0, 1.0], [0.5, 0.25]];
        let all = Comparison { rates: rows.concat(), driven: vec![0.1, 0.2] };
        let (end, during) =
            (all.after(1.0, &[1.0, 0.5]).expect("finite"), all.during(1.0, &[1.0, 0.5]).expect("finite"));
        let (mut x, mut y) = (1.0, 0.5);
        for _ in 0..100_000 {
            assert!(x <= during.sum()[0] && y <= during.sum()[1]);
            let (u, v) = (rows[0][0] * x + rows[0][1] * y + 0.1, rows[1][0] * x + rows[1][1] * y + 0.2);
            (x, y) = (x + 1e-5 * u, y + 1e-5 * v);
        }
        let sum = end.sum();
        assert!(x <= sum[0] + 1e-4 && y <= sum[1] + 1e-4 && sum[0] < x + 1e-4 && sum[1] < y + 1e-4);
    }

    #[test]
    fn what_leaves_the_floats_has_no_bound() {
        assert!(Comparison { rates: vec![1e6], driven: vec![1.0] }.after(1.0, &[1.0]).is_none());
        assert!(Comparison { rates: vec![f64::INFINITY], driven: vec![1.0] }.after(1.0, &[1.0]).is_none());
    }
}
