//! Polynomials of a step as a certificate has them: integers in units of a power of two.
//!
//! Nothing rests on how they are rounded: the checker bounds how far solutions are from them.

use crate::fault::Fault;

/// The magnitude that no integer comes to: certificates have 18 digits at most.
const LIMIT: f64 = 1e18;

/// The coefficients of one variable in units of `2^-bits`, time in units of `length`: by power of time from the first
/// on, zeros at the ends left out.
pub fn units(series: &[Vec<f64>], length: f64, bits: u32) -> Result<Vec<Vec<i64>>, Fault> {
    let unit = 2f64.powi(i32::try_from(bits).map_err(|_| Fault::Overflow)?);
    let mut rows = Vec::with_capacity(series.len());
    for (k, row) in (0i32..).zip(series).skip(1) {
        let scale = length.powi(k);
        let integers: Result<Vec<i64>, Fault> = row.iter().map(|c| integer(c * scale * unit)).collect();
        rows.push(trimmed(integers?, |q| *q == 0));
    }
    Ok(trimmed(rows, Vec::is_empty))
}

fn integer(x: f64) -> Result<i64, Fault> {
    if x.abs() < LIMIT {
        Ok(x.round_ties_even() as i64)
    } else {
        Err(Fault::Overflow)
    }
}

fn trimmed<T>(mut row: Vec<T>, is_nothing: impl Fn(&T) -> bool) -> Vec<T> {
    while row.last().is_some_and(&is_nothing) {
        row.pop();
    }
    row
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_of_time_are_scaled_and_zeros_at_the_ends_left_out() {
        let series = [vec![7.0], vec![0.5, 0.0], vec![1.0, -3.0, 0.1], vec![], vec![0.0]];
        assert_eq!(units(&series, 0.5, 2), Ok(vec![vec![1], vec![1, -3]]));
    }

    #[test]
    fn what_has_too_many_digits_is_a_fault() {
        assert_eq!(units(&[vec![], vec![1e9]], 1.0, 40), Err(Fault::Overflow));
        assert_eq!(units(&[vec![], vec![f64::NAN]], 1.0, 4), Err(Fault::Overflow));
    }
}
