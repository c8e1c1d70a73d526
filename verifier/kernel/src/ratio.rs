//! Rational numbers of any size between two neighbouring floats.

use crate::fault::Fault;
use crate::interval::Interval;
use crate::rounding::{mul, Towards};
use num_bigint::{BigInt, BigUint, Sign};
use num_integer::Integer;
use num_traits::{ToPrimitive, Zero};

/// Binary exponents beyond these leave the floats for good, whatever the 64 bits in front of them.
const EXPONENTS: std::ops::RangeInclusive<i64> = -1400..=1100;

/// `2^exponent` for an exponent of a normal float.
fn power_of_two(exponent: i64) -> f64 {
    f64::from_bits(((1023 + exponent) as u64) << 52)
}

/// A bound, not below zero, of `mantissa * 2^exponent` for a mantissa up to `2^53`; both halves of the power are
/// normal floats, and the product with the first is exact.
fn scale(mantissa: u64, exponent: i64, towards: Towards) -> f64 {
    let half = exponent / 2;
    let first = mantissa as f64 * power_of_two(half);
    mul(first, power_of_two(exponent - half), towards).max(0.0)
}

/// Bounds of a positive ratio: the leading bits of the quotient, and whether anything follows them.
fn magnitude(numerator: &BigUint, denominator: &BigUint) -> Result<(f64, f64), Fault> {
    let shift = 62 - (numerator.bits() as i64 - denominator.bits() as i64);
    if !EXPONENTS.contains(&-shift) {
        return if shift > 0 { Ok((0.0, f64::from_bits(1))) } else { Err(Fault::Overflow) };
    }
    let (quotient, rest) = if shift >= 0 {
        (numerator << shift as u64).div_rem(denominator)
    } else {
        numerator.div_rem(&(denominator << (-shift) as u64))
    };
    let quotient = quotient.to_u64().ok_or(Fault::Overflow)?;
    let dropped = (64 - quotient.leading_zeros()).saturating_sub(53);
    let (kept, unit) = (quotient >> dropped, 1u64 << dropped);
    let exact = rest.is_zero() && quotient & (unit - 1) == 0;
    let exponent = i64::from(dropped) - shift;
    let above = if exact { kept } else { kept + 1 };
    Ok((scale(kept, exponent, Towards::Below), scale(above, exponent, Towards::Above)))
}

/// The tightest enclosure of `numerator / denominator`, at most a step wider on each side below 2^-960.
pub fn enclose(numerator: &BigInt, denominator: &BigInt) -> Result<Interval, Fault> {
    if denominator.is_zero() {
        return Err(Fault::DivisionByZero);
    }
    if numerator.is_zero() {
        return Interval::new(0.0, 0.0);
    }
    let (below, above) = magnitude(numerator.magnitude(), denominator.magnitude())?;
    if (numerator.sign() == Sign::Minus) == (denominator.sign() == Sign::Minus) {
        Interval::new(below, above)
    } else {
        Interval::new(-above, -below)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ratio(numerator: &str, denominator: &str) -> Result<Interval, Fault> {
        enclose(&numerator.parse().expect("an integer"), &denominator.parse().expect("an integer"))
    }

    #[test]
    fn a_float_is_enclosed_by_itself() {
        assert_eq!(ratio("-3", "4"), Interval::new(-0.75, -0.75));
        assert_eq!(ratio("9007199254740991", "-1"), Interval::new(-9007199254740991.0, -9007199254740991.0));
    }

    #[test]
    fn other_numbers_lie_between_neighbours() {
        let third = ratio("1", "3").expect("finite");
        assert_eq!(third.low().next_up(), third.high());
        let beyond = ratio("9007199254740993", "1").expect("finite");
        assert_eq!((beyond.low(), beyond.high()), (9007199254740992.0, 9007199254740994.0));
    }

    #[test]
    fn sizes_cancel_and_extremes_are_bounded() {
        let huge = "1".to_owned() + &"0".repeat(5000);
        assert_eq!(ratio(&huge, &huge), Interval::new(1.0, 1.0));
        assert_eq!(ratio(&huge, "7"), Err(Fault::Overflow));
        assert_eq!(ratio("7", &huge), Interval::new(0.0, f64::from_bits(1)));
        assert_eq!(ratio("-7", &huge), Interval::new(-f64::from_bits(1), 0.0));
        assert_eq!(ratio("1", "0"), Err(Fault::DivisionByZero));
    }
}
