//! Solutions of stiff fields in floats: polynomials that obey the field at the points where Chebyshev's bend, the end
//! of the step among them. Nothing rests on them: what they miss is bounded afterwards (`stiff`).

use crate::chebyshev::MOST;
use crate::duals::jacobian;
use crate::fault::Fault;
use crate::interval::Interval;
use crate::series::{values, IntervalRing, Op, Tape};

/// Rounds of Newton's method, and how much nearer each has to come for the slopes of the field to be kept.
const ROUNDS: usize = 10;
const FAST: f64 = 0.02;
/// Relative to the size of the solution: what is no longer worth a round.
const ENOUGH: f64 = 1e-16;
const SURELY: f64 = 1e-11;

/// Points, derivatives at them from values there, and Chebyshev coefficients from the values.
#[derive(Debug, Clone)]
pub(crate) struct Points {
    degree: usize,
    at: Vec<f64>,
    derivative: Vec<Vec<f64>>,
    transform: Vec<Vec<f64>>,
}

impl Points {
    pub(crate) fn new(degree: usize) -> Points {
        let q = degree.clamp(2, MOST);
        let at: Vec<f64> = (0..=q).map(|i| -(std::f64::consts::PI * i as f64 / q as f64).cos()).collect();
        let weight = |i: usize| if i == 0 || i == q { 2.0 } else { 1.0 };
        let sign = |i: usize| if i.is_multiple_of(2) { 1.0 } else { -1.0 };
        let off = |i: usize, j: usize| weight(i) / weight(j) * sign(i + j) / (at[i] - at[j]);
        let row = |i: usize| -> Vec<f64> {
            let mut row: Vec<f64> = (0..=q).map(|j| if i == j { 0.0 } else { off(i, j) }).collect();
            row[i] = -row.iter().sum::<f64>();
            row
        };
        let entry = |k: usize, i: usize| {
            let wave = (std::f64::consts::PI * (k * (q - i)) as f64 / q as f64).cos();
            2.0 / (q as f64 * weight(k) * weight(i)) * wave
        };
        let transform = (0..=q).map(|k| (0..=q).map(|i| entry(k, i)).collect()).collect();
        let derivative = (0..=q).map(row).collect();
        Points { degree: q, derivative, transform, at }
    }

    /// Chebyshev coefficients by variable of the solution from a state over a time; `None` where Newton's method fails.
    pub(crate) fn solve(&self, field: &Tape, from: &[f64], h: f64) -> Option<Vec<Vec<f64>>> {
        let n = from.len();
        let sought: Vec<usize> = (0..n).filter(|&v| is_coupled(field, v)).collect();
        // How far the points are from the first: small numbers keep their digits.
        let mut x = self.straight(field, from, h).ok()?;
        let mut factors: Option<Factors> = None;
        let (mut before, mut fresh) = (f64::INFINITY, 2);
        for round in 0..ROUNDS {
            if fresh > 0 {
                factors =
                    Some(Factors::of(self.slopes(field, from, &x, &sought, h).ok()?, sought.len() * self.degree)?);
                fresh -= 1;
            }
            let mut change = self.missed(field, from, &x, &sought, h).ok()?;
            factors.as_ref()?.solve(&mut change);
            let mut most = 0.0f64;
            for (s, &v) in sought.iter().enumerate() {
                let size = x.iter().skip(v).step_by(n).fold(from[v].abs().max(1e-12), |m, s| m.max(s.abs()));
                let far = change.iter().skip(s).step_by(sought.len()).fold(0.0f64, |m, c| m.max(c.abs()));
                most = most.max(far / size);
                let own = x[n..].iter_mut().skip(v).step_by(n);
                own.zip(change.iter().skip(s).step_by(sought.len())).for_each(|(x, c)| *x -= c);
            }
            if !most.is_finite() || (round > 3 && most > 10.0 * before && before > SURELY) {
                return None;
            }
            if most <= ENOUGH || (most >= 0.2 * before && before <= SURELY) {
                return Some(self.coefficients(from, &x));
            }
            fresh = usize::from(fresh > 0 || (most > FAST * before && most > SURELY));
            before = most;
        }
        (before <= SURELY).then(|| self.coefficients(from, &x))
    }

    /// The way of states that nothing changes the rates of; no way of the others.
    fn straight(&self, field: &Tape, from: &[f64], h: f64) -> Result<Vec<f64>, Fault> {
        let speeds = rates(field, from)?;
        let mut x = Vec::with_capacity(from.len() * (self.degree + 1));
        for at in &self.at {
            let t = 0.5 * h * (1.0 + at);
            x.extend(speeds.iter().enumerate().map(|(v, f)| if is_coupled(field, v) { 0.0 } else { t * f }));
        }
        Ok(x)
    }

    /// The derivative less the field, times half the step, at all points but the first, of the states sought.
    fn missed(&self, field: &Tape, from: &[f64], x: &[f64], sought: &[usize], h: f64) -> Result<Vec<f64>, Fault> {
        let n = from.len();
        let mut found = vec![0.0; sought.len() * self.degree];
        for (i, row) in found.chunks_mut(sought.len()).enumerate() {
            let at = &x[(i + 1) * n..(i + 2) * n];
            let speeds = rates(field, &moved(from, at))?;
            for (r, &v) in row.iter_mut().zip(sought) {
                // The sum of a row's entries is zero: differences keep small numbers.
                let slope = self.derivative[i + 1].iter().enumerate().map(|(j, d)| d * (x[j * n + v] - at[v]));
                *r = slope.sum::<f64>() - 0.5 * h * speeds[v];
            }
        }
        Ok(found)
    }

    /// The slopes of what is missed by the values sought.
    fn slopes(&self, field: &Tape, from: &[f64], x: &[f64], sought: &[usize], h: f64) -> Result<Vec<f64>, Fault> {
        let (n, m) = (from.len(), sought.len());
        let size = m * self.degree;
        let mut found = vec![0.0; size * size];
        for i in 0..self.degree {
            let own = slopes(field, &moved(from, &x[(i + 1) * n..(i + 2) * n]))?;
            for (r, &v) in sought.iter().enumerate() {
                let row = &mut found[(i * m + r) * size..(i * m + r + 1) * size];
                (0..self.degree).for_each(|j| row[j * m + r] += self.derivative[i + 1][j + 1]);
                sought.iter().enumerate().for_each(|(c, &w)| row[i * m + c] -= 0.5 * h * own[v * n + w]);
            }
        }
        Ok(found)
    }

    fn coefficients(&self, from: &[f64], x: &[f64]) -> Vec<Vec<f64>> {
        let n = from.len();
        let sum = |row: &Vec<f64>, v: usize| row.iter().enumerate().map(|(i, t)| t * x[i * n + v]).sum::<f64>();
        let of = |v: usize| {
            let mut found: Vec<f64> = self.transform.iter().map(|row| sum(row, v)).collect();
            found[0] += from[v];
            found
        };
        (0..n).map(of).collect()
    }
}

fn moved(from: &[f64], by: &[f64]) -> Vec<f64> {
    from.iter().zip(by).map(|(x, d)| x + d).collect()
}

/// Whether the rate of a state depends on any state.
fn is_coupled(field: &Tape, v: usize) -> bool {
    let mut waiting = vec![field.outputs[v]];
    while let Some(at) = waiting.pop() {
        match field.ops[at] {
            Op::Variable(_) => return true,
            Op::Constant(_) => {}
            Op::Add(a, b) | Op::Sub(a, b) | Op::Mul(a, b) | Op::Div(a, b) => waiting.extend([a, b]),
            Op::Neg(a) | Op::Sqrt(a) | Op::Exp(a) | Op::Log(a) | Op::Sin(a) | Op::Cos(a) => waiting.push(a),
        }
    }
    false
}

fn points(at: &[f64]) -> Result<Vec<Interval>, Fault> {
    at.iter().map(|&x| Interval::exactly(x)).collect()
}

fn rates(field: &Tape, at: &[f64]) -> Result<Vec<f64>, Fault> {
    Ok(values(&IntervalRing, field, &points(at)?)?.iter().map(|x| x.midpoint()).collect())
}

/// The slopes of a field in floats, row by row.
pub(crate) fn slopes(field: &Tape, at: &[f64]) -> Result<Vec<f64>, Fault> {
    Ok(jacobian(&IntervalRing, field, &points(at)?)?.iter().flatten().map(|x| x.midpoint()).collect())
}

/// A matrix as a product of triangular ones, its rows exchanged.
pub(crate) struct Factors {
    size: usize,
    entries: Vec<f64>,
    rows: Vec<usize>,
}

impl Factors {
    pub(crate) fn of(mut entries: Vec<f64>, size: usize) -> Option<Factors> {
        let mut rows: Vec<usize> = (0..size).collect();
        for k in 0..size {
            let best =
                (k..size).max_by(|&a, &b| entries[a * size + k].abs().total_cmp(&entries[b * size + k].abs()))?;
            if entries[best * size + k] == 0.0 || !entries[best * size + k].is_finite() {
                return None;
            }
            if best != k {
                (0..size).for_each(|c| entries.swap(best * size + c, k * size + c));
                rows.swap(best, k);
            }
            let (above, below) = entries.split_at_mut((k + 1) * size);
            let pivot = &above[k * size..];
            for row in below.chunks_mut(size) {
                let factor = row[k] / pivot[k];
                row[k] = factor;
                if factor != 0.0 {
                    row[k + 1..].iter_mut().zip(&pivot[k + 1..]).for_each(|(x, p)| *x -= factor * p);
                }
            }
        }
        Some(Factors { size, entries, rows })
    }

    pub(crate) fn solve(&self, right: &mut [f64]) {
        let (n, given) = (self.size, right.to_vec());
        for i in 0..n {
            let row = &self.entries[i * n..i * n + i];
            let known: f64 = row.iter().zip(right.iter()).map(|(a, x)| a * x).sum();
            right[i] = given[self.rows[i]] - known;
        }
        for i in (0..n).rev() {
            let row = &self.entries[i * n + i..(i + 1) * n];
            let known: f64 = row[1..].iter().zip(&right[i + 1..]).map(|(a, x)| a * x).sum();
            right[i] = (right[i] - known) / row[0];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chebyshev::ends;

    #[test]
    fn fast_decay_is_followed_in_one_long_step() {
        // x' = -1000 (x - y), y' = -y from (1, 1): the slow solution has x = 1000 / 999 y, nearly.
        let ops = vec![
            Op::Variable(0),
            Op::Variable(1),
            Op::Sub(1, 0),
            Op::Constant(Interval::exactly(1000.0).expect("finite")),
            Op::Mul(3, 2),
            Op::Neg(1),
        ];
        let field = Tape::validated(ops, vec![4, 5], 2).expect("a tape");
        let found = Points::new(12).solve(&field, &[1000.0 / 999.0, 1.0], 1.0).expect("it converges");
        let last: Vec<f64> = found.iter().map(|c| ends(c).expect("finite").1.midpoint()).collect();
        assert!((last[1] - (-1.0f64).exp()).abs() < 1e-14);
        assert!((last[0] - 1000.0 / 999.0 * (-1.0f64).exp()).abs() < 1e-13);
    }

    #[test]
    fn systems_of_equations_are_solved() {
        let rows = vec![0.0, 2.0, 1.0, 1.0, 0.5, -1.0, 3.0, 0.25, 2.0];
        let factors = Factors::of(rows.clone(), 3).expect("regular");
        let mut x = vec![1.0, -2.0, 0.5];
        factors.solve(&mut x);
        for (i, b) in [1.0, -2.0, 0.5].iter().enumerate() {
            let sum: f64 = (0..3).map(|j| rows[3 * i + j] * x[j]).sum();
            assert!((sum - b).abs() < 1e-14);
        }
        assert!(Factors::of(vec![1.0, 2.0, 2.0, 4.0], 2).is_none());
    }
}
