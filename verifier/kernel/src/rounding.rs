//! Sum, product, quotient and root of floats, rounded down or up.
//!
//! The unit rounds to nearest. The sign of the error of that rounding is found by an error-free transform where the
//! transform is exact, and then a result moves one step at most, and none if it is exact. Where the transform may
//! lose its exactness (small numbers), the result moves one step always, which covers an error of half a step.
//!
//! Results may be infinite or, for infinite arguments, NaN: `Interval::new` refuses both.

/// The direction of a rounding.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Towards {
    Below,
    Above,
}

/// What is known of `exact - rounded`.
#[derive(Debug, Clone, Copy)]
enum Error {
    /// Its sign: that of this number.
    Sign(f64),
    /// Nothing but that it is at most half a step.
    HalfStep,
}

/// Below this, products of rounding errors may be subnormal and no longer exact: 2^-960, with room to spare.
const SMALL: f64 = f64::from_bits((1023 - 960) << 52);

/// A bound of the exact result, on the side asked for.
#[inline]
fn settle(rounded: f64, error: Error, towards: Towards) -> f64 {
    match (towards, error) {
        (Towards::Below, Error::Sign(sign)) if sign >= 0.0 => rounded,
        (Towards::Above, Error::Sign(sign)) if sign <= 0.0 => rounded,
        (Towards::Below, _) => rounded.next_down(),
        (Towards::Above, _) => rounded.next_up(),
    }
}

/// `a + b`. Knuth's TwoSum gives the error exactly, also under gradual underflow.
#[inline]
pub fn add(a: f64, b: f64, towards: Towards) -> f64 {
    let sum = a + b;
    let b_part = sum - a;
    let error = (a - (sum - b_part)) + (b - b_part);
    // Overflow within the transform leaves no finite error; then the sum moves a step.
    settle(sum, if error.is_finite() { Error::Sign(error) } else { Error::HalfStep }, towards)
}

/// `a * b`. The fused `a * b - product` is the error exactly, unless the product is small; nothing is rounded
/// where a factor is zero or one.
#[inline]
pub fn mul(a: f64, b: f64, towards: Towards) -> f64 {
    let product = a * b;
    if [0.0, 1.0].contains(&a) || [0.0, 1.0].contains(&b) {
        return product;
    }
    let exact = product.abs() >= SMALL && product.is_finite();
    let error = if exact { Error::Sign(a.mul_add(b, -product)) } else { Error::HalfStep };
    settle(product, error, towards)
}

/// `a / b`. The remainder `a - quotient * b` is a float unless numbers are small or huge; its sign and that of `b`
/// give the sign of the error.
#[inline]
pub fn div(a: f64, b: f64, towards: Towards) -> f64 {
    let quotient = a / b;
    if a == 0.0 {
        return quotient;
    }
    let exact = a.abs() >= SMALL && quotient.abs() >= SMALL && quotient.is_finite() && b.is_finite();
    let remainder = (-quotient).mul_add(b, a);
    let error = if exact { Error::Sign(remainder * b.signum()) } else { Error::HalfStep };
    settle(quotient, error, towards)
}

/// The square root of `a >= 0`, never below zero.
#[inline]
pub fn sqrt(a: f64, towards: Towards) -> f64 {
    let root = a.sqrt();
    if a == 0.0 {
        return 0.0;
    }
    let error = if a >= SMALL { Error::Sign((-root).mul_add(root, a)) } else { Error::HalfStep };
    settle(root, error, towards)
}

/// The `exponent`-th power of `base >= 0` by repeated squaring, each product rounded the same way; never below zero.
pub fn power(base: f64, exponent: u32, towards: Towards) -> f64 {
    let (mut result, mut square, mut rest) = (1.0, base, exponent);
    while rest > 0 {
        if rest & 1 == 1 {
            result = mul(result, square, towards).max(0.0);
        }
        rest >>= 1;
        if rest > 0 {
            square = mul(square, square, towards).max(0.0);
        }
    }
    result
}

#[cfg(test)]
mod tests {
    use super::Towards::{Above, Below};
    use super::*;

    #[test]
    fn exact_results_do_not_move() {
        for towards in [Below, Above] {
            assert_eq!(add(0.5, 0.25, towards), 0.75);
            assert_eq!(mul(1.5, -3.0, towards), -4.5);
            assert_eq!(div(-7.0, 2.0, towards), -3.5);
            assert_eq!(sqrt(2.25, towards), 1.5);
            assert_eq!(power(3.0, 20, towards), 3486784401.0);
        }
    }

    #[test]
    fn inexact_results_are_neighbours() {
        let tenth_and_fifth = (add(0.1, 0.2, Below), add(0.1, 0.2, Above));
        assert_eq!(tenth_and_fifth.0.next_up(), tenth_and_fifth.1);
        assert_eq!(div(1.0, 3.0, Below).next_up(), div(1.0, 3.0, Above));
        assert_eq!(div(1.0, -3.0, Below), -div(1.0, 3.0, Above));
        assert_eq!(mul(0.1, 0.1, Below).next_up(), mul(0.1, 0.1, Above));
        assert_eq!(sqrt(2.0, Below).next_up(), sqrt(2.0, Above));
    }

    #[test]
    fn products_that_vanish_are_bounded_away() {
        let tiny = f64::from_bits(1);
        assert!(mul(tiny, tiny, Above) > 0.0);
        assert!(mul(tiny, -tiny, Below) < 0.0);
        assert_eq!(power(tiny, 3, Below), 0.0);
        assert!(power(tiny, 3, Above) > 0.0);
    }

    #[test]
    fn the_error_of_a_subnormal_quotient_is_not_trusted() {
        let tiny = f64::from_bits(3);
        assert!(div(tiny, 2.0, Below) * 2.0 < tiny || div(tiny, 2.0, Below) < div(tiny, 2.0, Above));
    }

    #[test]
    fn a_finite_sum_beyond_the_largest_float_is_bounded_by_it_from_below() {
        assert_eq!(add(f64::MAX, f64::MAX, Below), f64::MAX);
        assert_eq!(add(f64::MAX, f64::MAX, Above), f64::INFINITY);
        assert_eq!(add(-f64::MAX, -f64::MAX, Above), -f64::MAX);
    }
}
