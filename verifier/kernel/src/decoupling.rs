//! Directions in which what a linear equation does to a state hardly mixes: nearly the eigenvectors of its matrix, where
//! eigenvalues are real and apart. In floats; nothing rests on them.

/// Steps of the QR iteration, unshifted: large eigenvalues, the fast ones, come apart first.
const TURNS: usize = 24;
/// Eigenvalues apart by less than this share of the larger are left together.
const APART: f64 = 0.05;

/// Columns, by rows, for a square matrix by rows; states that nothing depends on and that nothing moves keep theirs.
pub(crate) fn directions(matrix: &[f64], n: usize) -> Vec<f64> {
    let is_used = |i: usize| (0..n).any(|j| matrix[i * n + j] != 0.0 || matrix[j * n + i] != 0.0);
    let used: Vec<usize> = (0..n).filter(|&i| is_used(i)).collect();
    let m = used.len();
    let mut a: Vec<f64> = used.iter().flat_map(|&i| used.iter().map(move |&j| matrix[i * n + j])).collect();
    let mut turned = identity(m);
    for _ in 0..TURNS {
        let q = orthogonal(&a, m);
        a = product(&transposed(&q, m), &product(&a, &q, m), m);
        turned = product(&turned, &q, m);
    }
    let found = product(&turned, &apart(&a, m), m);
    let mut all = identity(n);
    for (i, &to) in used.iter().enumerate() {
        for (j, &at) in used.iter().enumerate() {
            all[to * n + at] = found[i * m + j];
        }
    }
    all
}

fn identity(n: usize) -> Vec<f64> {
    (0..n * n).map(|at| f64::from(u8::from(at / n == at % n))).collect()
}

fn transposed(a: &[f64], n: usize) -> Vec<f64> {
    (0..n * n).map(|at| a[(at % n) * n + at / n]).collect()
}

fn product(a: &[f64], b: &[f64], n: usize) -> Vec<f64> {
    let entry = |at: usize| (0..n).map(|k| a[(at / n) * n + k] * b[k * n + at % n]).sum();
    (0..n * n).map(entry).collect()
}

/// The orthogonal factor of a matrix, by reflections.
fn orthogonal(a: &[f64], n: usize) -> Vec<f64> {
    let (mut r, mut q) = (a.to_vec(), identity(n));
    for k in 0..n.saturating_sub(1) {
        let mut v: Vec<f64> = (k..n).map(|i| r[i * n + k]).collect();
        let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
        if v[1..].iter().all(|&x| x == 0.0) || length == 0.0 {
            continue;
        }
        v[0] += if v[0] < 0.0 { -length } else { length };
        let square: f64 = v.iter().map(|x| x * x).sum();
        for j in 0..n {
            let along: f64 = 2.0 / square * (k..n).map(|i| v[i - k] * r[i * n + j]).sum::<f64>();
            (k..n).for_each(|i| r[i * n + j] -= along * v[i - k]);
            let along: f64 = 2.0 / square * (k..n).map(|i| v[i - k] * q[j * n + i]).sum::<f64>();
            (k..n).for_each(|i| q[j * n + i] -= along * v[i - k]);
        }
    }
    q
}

/// Eigenvectors of a triangular matrix, one for each of its eigenvalues that is apart from those before it.
fn apart(r: &[f64], n: usize) -> Vec<f64> {
    let mut x = identity(n);
    for j in 0..n {
        for i in (0..j).rev() {
            let gap = r[i * n + i] - r[j * n + j];
            if gap.abs() > APART * r[i * n + i].abs().max(r[j * n + j].abs()) {
                let sum: f64 = (i + 1..=j).map(|k| r[i * n + k] * x[k * n + j]).sum();
                x[i * n + j] = -sum / gap;
            }
        }
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collocation::Factors;

    #[test]
    fn fast_and_slow_come_apart() {
        let a = [-0.4, 650.0, 1.8, 0.4, -1000.0, -1.8, 0.0, 350.0, 0.0];
        let t = directions(&a, 3);
        let factors = Factors::of(t.clone(), 3).expect("regular");
        let image = product(&a, &t, 3);
        for j in 0..3 {
            let mut column: Vec<f64> = (0..3).map(|i| image[i * 3 + j]).collect();
            factors.solve(&mut column);
            for (i, x) in column.iter().enumerate() {
                assert!(i == j || x.abs() < 1e-6, "{i} {j} {x}");
            }
        }
    }

    #[test]
    fn states_apart_from_all_others_keep_their_direction() {
        let t = directions(&[0.0, 0.0, 0.0, 0.0, -1.0, 2.0, 0.0, 0.5, -3.0], 3);
        assert_eq!((t[0], t[1], t[2], t[3], t[6]), (1.0, 0.0, 0.0, 0.0, 0.0));
    }
}
