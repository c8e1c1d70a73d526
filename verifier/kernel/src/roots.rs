//! Where a polynomial in floats is zero on a step: all crossings, and touches as far as rounding lets them be seen.
//!
//! Bernstein coefficients over the step; parts without a change of sign have no root, parts with one have one, others
//! are halved (G. Collins, A. Akritas 1976; R. Rouillier, P. Zimmermann 2004).

use crate::dense::at;

const SMALLEST: f64 = 1e-10; // part of the step below which several changes of sign are one touch

const NOTHING: f64 = 1e-17; // of the magnitude of a series; coefficients at its end that are smaller are left out

/// The roots in `(0, h]` in order, after those at zero itself were divided out by `skip`; `slack` is what counts as zero.
pub fn roots(series: &[f64], h: f64, skip: usize, slack: f64) -> Vec<f64> {
    let mut scaled = Vec::with_capacity(series.len());
    let mut power = 1.0;
    for (k, &c) in series.iter().enumerate() {
        if k >= skip {
            scaled.push(c * power);
        }
        power *= h;
    }
    let first = scaled.first().copied().unwrap_or(0.0).abs();
    let rest: f64 = scaled.iter().skip(1).map(|c| c.abs()).sum();
    if first > rest || first + rest == 0.0 || !(first + rest).is_finite() {
        return Vec::new();
    }
    while scaled.len() > 1 && scaled[scaled.len() - 1].abs() <= NOTHING * (first + rest) {
        scaled.pop();
    }
    let mut found = Vec::new();
    let coefficients = bernstein(&scaled);
    let may_touch = changes(&coefficients) > 1 || coefficients.iter().any(|c| c.abs() <= slack);
    isolate(&scaled, coefficients, (0.0, 1.0), &mut found);
    if may_touch && scaled.len() > 2 {
        found.extend(touches(&scaled, slack));
    }
    merged(&scaled, found, slack).iter().map(|&s| s * h).collect()
}

/// Where a polynomial is least or greatest with a value that counts as zero.
fn touches(powers: &[f64], slack: f64) -> Vec<f64> {
    let slope: Vec<f64> = powers.iter().enumerate().skip(1).map(|(k, c)| k as f64 * c).collect();
    let mut found = Vec::new();
    isolate(&slope, bernstein(&slope), (0.0, 1.0), &mut found);
    found.retain(|&x| at(powers, x).abs() <= slack);
    found
}

/// Bernstein coefficients on [0, 1] of a polynomial given by powers.
fn bernstein(powers: &[f64]) -> Vec<f64> {
    let n = powers.len() - 1;
    let mut binomial = 1.0;
    let mut sums: Vec<f64> = Vec::with_capacity(n + 1);
    for (k, c) in powers.iter().enumerate() {
        sums.push(c / binomial);
        binomial = binomial * (n - k) as f64 / (k + 1) as f64;
    }
    for level in 1..=n {
        for i in (level..=n).rev() {
            sums[i] += sums[i - 1];
        }
    }
    sums
}

fn changes(coefficients: &[f64]) -> usize {
    let mut last = 0.0;
    let mut count = 0;
    for &c in coefficients.iter().filter(|c| **c != 0.0) {
        count += usize::from(last * c < 0.0 || (last != 0.0 && (last > 0.0) != (c > 0.0)));
        last = c;
    }
    count
}

fn isolate(powers: &[f64], coefficients: Vec<f64>, part: (f64, f64), found: &mut Vec<f64>) {
    let (low, high) = part;
    let n = coefficients.len() - 1;
    let is_zero_at_end = coefficients[n] == 0.0;
    match changes(&coefficients) {
        0 if is_zero_at_end => found.push(high),
        0 => {}
        1 if coefficients[0] != 0.0 && !is_zero_at_end => found.push(crossing(powers, low, high)),
        _ if high - low < SMALLEST => {
            if coefficients[0] * coefficients[n] < 0.0 {
                found.push(crossing(powers, low, high));
            }
        }
        _ => {
            let (left, right) = halved(coefficients);
            let middle = (low + high) / 2.0;
            isolate(powers, left, (low, middle), found);
            isolate(powers, right, (middle, high), found);
        }
    }
}

/// De Casteljau's cut in the middle.
fn halved(mut right: Vec<f64>) -> (Vec<f64>, Vec<f64>) {
    let n = right.len();
    let mut left = Vec::with_capacity(n);
    for level in 0..n {
        left.push(right[0]);
        for i in 0..n - 1 - level {
            right[i] = (right[i] + right[i + 1]) / 2.0;
        }
    }
    (left, right)
}

/// The one root between two places of different sign: Newton's steps, kept inside by bisection.
fn crossing(powers: &[f64], mut low: f64, mut high: f64) -> f64 {
    let is_rising = at(powers, high) > at(powers, low);
    let mut x = (low + high) / 2.0;
    for _ in 0..100 {
        let (value, slope) = with_slope(powers, x);
        if value == 0.0 {
            return x;
        }
        if (value > 0.0) == is_rising {
            high = x
        } else {
            low = x
        }
        let newton = x - value / slope;
        let next = if newton > low && newton < high { newton } else { (low + high) / 2.0 };
        if next == x || (next - x).abs() <= f64::EPSILON * 0.25 * x.abs() {
            return next;
        }
        x = next;
    }
    x
}

fn with_slope(powers: &[f64], x: f64) -> (f64, f64) {
    powers.iter().rev().fold((0.0, 0.0), |(value, slope), c| (value * x + c, slope * x + value))
}

/// Roots in order; two with nothing but rounding between them are one touch.
fn merged(powers: &[f64], mut found: Vec<f64>, slack: f64) -> Vec<f64> {
    found.sort_by(f64::total_cmp);
    let mut kept: Vec<f64> = Vec::with_capacity(found.len());
    for x in found {
        match kept.last() {
            Some(&last) if x - last < 1e-6 && at(powers, (x + last) / 2.0).abs() <= slack => {}
            _ => kept.push(x),
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    fn product(given: &[f64]) -> Vec<f64> {
        given.iter().fold(vec![1.0], |p, r| {
            let mut next = vec![0.0; p.len() + 1];
            for (i, c) in p.iter().enumerate() {
                next[i + 1] += c;
                next[i] -= r * c;
            }
            next
        })
    }

    #[test]
    fn every_crossing_is_found_also_two_close_together() {
        let found = roots(&product(&[0.25, 0.2500001, 0.75, 1.5]), 1.0, 0, 1e-16);
        assert_eq!(found.len(), 3);
        assert!(
            (found[0] - 0.25).abs() < 1e-9 && (found[1] - 0.2500001).abs() < 1e-9 && (found[2] - 0.75).abs() < 1e-14
        );
    }

    #[test]
    fn a_touch_is_found_and_a_near_miss_is_not() {
        let touching = product(&[0.3, 0.3]);
        assert_eq!(roots(&touching, 1.0, 0, 1e-15).len(), 1);
        let mut missing = touching;
        missing[0] += 1e-9;
        assert!(roots(&missing, 1.0, 0, 1e-15).is_empty());
    }

    #[test]
    fn a_root_at_the_end_counts_and_one_at_the_start_is_skipped() {
        let series = product(&[0.0, 2.0]);
        assert_eq!(roots(&series, 2.0, 1, 1e-15), vec![2.0]);
    }
}
