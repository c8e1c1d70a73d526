//! Closed intervals with float ends, every operation rounded outwards.
//!
//! For an operation `f` and intervals `X`, `Y`: `f(x, y)` lies in the result for all `x` in `X` and `y` in `Y`, or the
//! result is a fault. Ends are finite and in order, always; faults travel in `Result`.

use crate::elementary::{Elementary, ACOS, ASIN, ATAN, COS, COSH, EXP, LOG, SIN, SINH, TAN, TANH};
use crate::fault::Fault;
use crate::rounding::{add, div, mul, power, sqrt, Towards};
use std::ops::{Add, Div, Mul, Neg, Sub};
use Towards::{Above, Below};

/// What every operation returns.
pub type Enclosure = Result<Interval, Fault>;

/// The numbers from `low` to `high`, ends included.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    low: f64,
    high: f64,
}

/// Half of pi lies between this float, which is half of pi rounded down, and the next.
const HALF_PI: Interval = Interval { low: std::f64::consts::FRAC_PI_2, high: std::f64::consts::FRAC_PI_2.next_up() };

/// Arguments with more quadrants than this between them and zero are not located: their sine is somewhere in [-1, 1].
const FAR: f64 = 1_125_899_906_842_624.0;

impl Interval {
    /// The interval between two finite floats in order.
    #[inline]
    pub fn new(low: f64, high: f64) -> Enclosure {
        match (low, high) {
            _ if low.is_nan() || high.is_nan() => Err(Fault::NotANumber),
            _ if low > high => Err(Fault::Empty),
            _ if low.is_infinite() || high.is_infinite() => Err(Fault::Overflow),
            // Adding zero turns a negative zero into a positive one, so that equal ends are the same bits.
            _ => Ok(Interval { low: low + 0.0, high: high + 0.0 }),
        }
    }

    pub const ZERO: Interval = Interval { low: 0.0, high: 0.0 };
    pub const MINUS_ONE: Interval = Interval { low: -1.0, high: -1.0 };

    /// The one float, if it is finite.
    #[inline]
    pub fn exactly(x: f64) -> Enclosure {
        Interval::new(x, x)
    }

    /// One float more on each side.
    #[inline]
    pub fn widened(self) -> Enclosure {
        Interval::new(self.low.next_down(), self.high.next_up())
    }

    /// All numbers of at most this magnitude.
    #[inline]
    pub fn symmetric(radius: f64) -> Enclosure {
        Interval::new(-radius, radius)
    }

    /// The greatest magnitude.
    #[inline]
    pub fn norm(self) -> f64 {
        self.low.abs().max(self.high.abs())
    }

    /// Whether every number of the other lies strictly between the ends.
    #[inline]
    pub fn holds_inside(self, other: Interval) -> bool {
        self.low < other.low && other.high < self.high
    }

    #[inline]
    pub fn low(self) -> f64 {
        self.low
    }

    #[inline]
    pub fn high(self) -> f64 {
        self.high
    }

    #[inline]
    pub fn contains(self, x: f64) -> bool {
        self.low <= x && x <= self.high
    }

    /// A float of the interval near its middle.
    #[inline]
    pub fn midpoint(self) -> f64 {
        (0.5 * self.low + 0.5 * self.high).clamp(self.low, self.high)
    }

    /// At least `high - low`.
    #[inline]
    pub fn width(self) -> Result<f64, Fault> {
        let width = add(self.high, -self.low, Above);
        if width.is_finite() {
            Ok(width)
        } else {
            Err(Fault::Overflow)
        }
    }

    /// The smallest interval that contains both.
    #[inline]
    pub fn hull(self, other: Interval) -> Enclosure {
        Interval::new(self.low.min(other.low), self.high.max(other.high))
    }

    /// What both contain; a fault if that is nothing.
    #[inline]
    pub fn intersection(self, other: Interval) -> Enclosure {
        Interval::new(self.low.max(other.low), self.high.min(other.high))
    }

    pub fn min(self, other: Interval) -> Enclosure {
        Interval::new(self.low.min(other.low), self.high.min(other.high))
    }

    pub fn max(self, other: Interval) -> Enclosure {
        Interval::new(self.low.max(other.low), self.high.max(other.high))
    }

    /// The least and the greatest magnitude.
    fn magnitudes(self) -> (f64, f64) {
        let (low, high) = (self.low.abs(), self.high.abs());
        (if self.contains(0.0) { 0.0 } else { low.min(high) }, low.max(high))
    }

    pub fn abs(self) -> Enclosure {
        let (least, greatest) = self.magnitudes();
        Interval::new(least, greatest)
    }

    /// The hull of `f` over the four pairs of ends.
    fn corners(self, other: Interval, f: fn(f64, f64, Towards) -> f64) -> Enclosure {
        let pairs = [(self.low, other.low), (self.low, other.high), (self.high, other.low), (self.high, other.high)];
        let low = pairs.iter().map(|&(a, b)| f(a, b, Below)).fold(f64::INFINITY, f64::min);
        let high = pairs.iter().map(|&(a, b)| f(a, b, Above)).fold(f64::NEG_INFINITY, f64::max);
        Interval::new(low, high)
    }

    pub fn sqr(self) -> Enclosure {
        self.natural_power(2)
    }

    /// The power for an exponent of at least one: even powers depend on magnitudes alone, odd ones are monotone.
    fn natural_power(self, exponent: u32) -> Enclosure {
        if exponent.is_multiple_of(2) {
            let (least, greatest) = self.magnitudes();
            return Interval::new(power(least, exponent, Below), power(greatest, exponent, Above));
        }
        let odd = |x: f64, towards, opposite| {
            if x < 0.0 {
                -power(-x, exponent, opposite)
            } else {
                power(x, exponent, towards)
            }
        };
        Interval::new(odd(self.low, Below, Above), odd(self.high, Above, Below))
    }

    /// An integer power; `x^0` is 1 also at zero. A power whose inverse overflows is taken of the inverse instead.
    pub fn powi(self, exponent: i32) -> Enclosure {
        let one = Interval { low: 1.0, high: 1.0 };
        let count = exponent.unsigned_abs();
        match exponent {
            0 => Ok(one),
            1.. => self.natural_power(count),
            _ if self.contains(0.0) => Err(Fault::DivisionByZero),
            _ => match self.natural_power(count).and_then(|power| one.div(power)) {
                Err(_) => one.div(self)?.natural_power(count),
                inverse => inverse,
            },
        }
    }

    pub fn sqrt(self) -> Enclosure {
        if self.low < 0.0 {
            return Err(Fault::Domain);
        }
        Interval::new(sqrt(self.low, Below), sqrt(self.high, Above))
    }

    fn rising(self, f: &Elementary) -> Enclosure {
        Interval::new(f.at(self.low, Below), f.at(self.high, Above))
    }

    fn rising_within(self, low: f64, high: f64, f: &Elementary) -> Enclosure {
        if low <= self.low && self.high <= high {
            self.rising(f)
        } else {
            Err(Fault::Domain)
        }
    }

    pub fn exp(self) -> Enclosure {
        self.rising(&EXP)
    }

    pub fn log(self) -> Enclosure {
        self.rising_within(f64::from_bits(1), f64::INFINITY, &LOG)
    }

    pub fn asin(self) -> Enclosure {
        self.rising_within(-1.0, 1.0, &ASIN)
    }

    pub fn acos(self) -> Enclosure {
        if self.low < -1.0 || self.high > 1.0 {
            return Err(Fault::Domain);
        }
        Interval::new(ACOS.at(self.high, Below), ACOS.at(self.low, Above))
    }

    pub fn atan(self) -> Enclosure {
        self.rising(&ATAN)
    }

    pub fn sinh(self) -> Enclosure {
        self.rising(&SINH)
    }

    pub fn cosh(self) -> Enclosure {
        let (least, greatest) = self.magnitudes();
        Interval::new(COSH.at(least, Below), COSH.at(greatest, Above))
    }

    pub fn tanh(self) -> Enclosure {
        self.rising(&TANH)
    }

    /// Which multiples of a right angle may lie in the interval, first and last; none if the first is greater.
    /// `None` where floats are too coarse to tell.
    fn right_angles(self) -> Option<(i64, i64)> {
        let turns = self.div(HALF_PI).ok()?;
        let located = turns.low.abs() <= FAR && turns.high.abs() <= FAR;
        located.then(|| (turns.low.ceil() as i64, turns.high.floor() as i64))
    }

    /// The range of a sine or cosine that is greatest at the right angles `crest` and least at `crest + 2`, modulo 4.
    fn wave(self, f: &Elementary, crest: i64) -> Enclosure {
        let Some((first, last)) = self.right_angles() else { return Interval::new(-1.0, 1.0) };
        let meets = |phase: i64| first + (phase - first).rem_euclid(4) <= last;
        let low = if meets(crest + 2) { -1.0 } else { f.at(self.low, Below).min(f.at(self.high, Below)) };
        let high = if meets(crest) { 1.0 } else { f.at(self.low, Above).max(f.at(self.high, Above)) };
        Interval::new(low, high)
    }

    pub fn sin(self) -> Enclosure {
        self.wave(&SIN, 1)
    }

    pub fn cos(self) -> Enclosure {
        self.wave(&COS, 0)
    }

    /// The tangent between two poles; a fault if a pole may lie in the interval.
    pub fn tan(self) -> Enclosure {
        let (first, last) = self.right_angles().ok_or(Fault::Domain)?;
        if first + (1 - first).rem_euclid(2) <= last {
            return Err(Fault::Domain);
        }
        self.rising(&TAN)
    }
}

impl Neg for Interval {
    type Output = Enclosure;

    fn neg(self) -> Enclosure {
        Interval::new(-self.high, -self.low)
    }
}

impl Add for Interval {
    type Output = Enclosure;

    fn add(self, other: Interval) -> Enclosure {
        Interval::new(add(self.low, other.low, Below), add(self.high, other.high, Above))
    }
}

impl Sub for Interval {
    type Output = Enclosure;

    fn sub(self, other: Interval) -> Enclosure {
        Interval::new(add(self.low, -other.high, Below), add(self.high, -other.low, Above))
    }
}

impl Mul for Interval {
    type Output = Enclosure;

    fn mul(self, other: Interval) -> Enclosure {
        self.corners(other, mul)
    }
}

impl Div for Interval {
    type Output = Enclosure;

    fn div(self, other: Interval) -> Enclosure {
        if other.contains(0.0) {
            return Err(Fault::DivisionByZero);
        }
        self.corners(other, div)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn interval(low: f64, high: f64) -> Interval {
        Interval::new(low, high).expect("ends in order")
    }

    #[test]
    fn only_finite_ends_in_order_make_an_interval() {
        assert_eq!(Interval::new(f64::NAN, 1.0), Err(Fault::NotANumber));
        assert_eq!(Interval::new(0.0, f64::NAN), Err(Fault::NotANumber));
        assert_eq!(Interval::new(2.0, 1.0), Err(Fault::Empty));
        assert_eq!(Interval::new(0.0, f64::INFINITY), Err(Fault::Overflow));
        assert!(interval(-0.0, -0.0).low().is_sign_positive());
    }

    #[test]
    fn signs_of_a_product_pick_its_ends() {
        let (minus, mixed) = (interval(-3.0, -2.0), interval(-1.0, 4.0));
        assert_eq!(minus.mul(minus), Interval::new(4.0, 9.0));
        assert_eq!(minus.mul(mixed), Interval::new(-12.0, 3.0));
        assert_eq!(mixed.mul(mixed), Interval::new(-4.0, 16.0));
        assert_eq!(mixed.sqr(), Interval::new(0.0, 16.0));
    }

    #[test]
    fn a_divisor_that_may_be_zero_is_a_fault() {
        let one = interval(1.0, 1.0);
        for divisor in [interval(0.0, 0.0), interval(-1.0, 1.0), interval(0.0, 1.0), interval(-1.0, -0.0)] {
            assert_eq!(one.div(divisor), Err(Fault::DivisionByZero));
            assert_eq!(divisor.powi(-1), Err(Fault::DivisionByZero));
        }
    }

    #[test]
    fn overflow_is_a_fault() {
        let large = interval(1e308, 1e308);
        assert_eq!(large.add(large), Err(Fault::Overflow));
        assert_eq!(large.mul(large), Err(Fault::Overflow));
        assert_eq!(large.exp(), Err(Fault::Overflow));
        assert_eq!(large.powi(3), Err(Fault::Overflow));
        assert_eq!(interval(-1e308, 1e308).width(), Err(Fault::Overflow));
    }

    #[test]
    fn negative_powers_survive_the_overflow_of_the_positive_one() {
        let small = interval(10.0, 10.0).powi(-320).expect("a small number");
        assert!(small.low() < 1e-320 && 1e-320 < small.high() && small.low() >= 0.0);
    }

    #[test]
    fn even_and_odd_powers_of_both_signs() {
        assert_eq!(interval(-2.0, 1.0).powi(3), Interval::new(-8.0, 1.0));
        assert_eq!(interval(-2.0, 1.0).powi(4), Interval::new(0.0, 16.0));
        assert_eq!(interval(-2.0, -1.0).powi(-2), Interval::new(0.25, 1.0));
        assert_eq!(interval(-2.0, 1.0).powi(0), Interval::new(1.0, 1.0));
        assert_eq!(interval(1.0, 1.0).powi(i32::MIN), Interval::new(1.0, 1.0));
    }

    #[test]
    fn functions_refuse_what_lies_outside_their_domain() {
        let low = interval(-1.5, 0.5);
        for result in [low.sqrt(), low.log(), low.asin(), low.acos(), interval(0.0, 1.0).log()] {
            assert_eq!(result, Err(Fault::Domain));
        }
    }

    #[test]
    fn waves_reach_their_crests_and_troughs() {
        assert_eq!(interval(0.0, 10.0).sin(), Interval::new(-1.0, 1.0));
        assert_eq!(interval(1.0, 2.0).sin().map(Interval::high), Ok(1.0));
        assert_eq!(interval(4.0, 5.0).sin().map(Interval::low), Ok(-1.0));
        assert_eq!(interval(-0.5, 0.5).cos().map(Interval::high), Ok(1.0));
        assert_eq!(interval(3.0, 3.5).cos().map(Interval::low), Ok(-1.0));
        assert!(interval(2.0, 3.0).sin().expect("finite").high() < 0.91);
    }

    #[test]
    fn far_away_a_wave_is_anything() {
        assert_eq!(interval(1e22, 1e22).sin(), Interval::new(-1.0, 1.0));
        assert_eq!(interval(1e22, 1e22).tan(), Err(Fault::Domain));
        assert_eq!(interval(-1e308, 1e308).cos(), Interval::new(-1.0, 1.0));
    }

    #[test]
    fn the_tangent_stops_at_its_poles() {
        assert_eq!(interval(1.0, 2.0).tan(), Err(Fault::Domain));
        assert_eq!(interval(-2.0, -1.0).tan(), Err(Fault::Domain));
        assert!(interval(2.0, 4.0).tan().is_ok());
    }

    #[test]
    fn half_pi_is_enclosed() {
        let one = interval(1.0, 1.0);
        let twice = one.atan().and_then(|quarter| quarter.add(quarter)).expect("finite");
        assert!(twice.low() <= HALF_PI.low() && HALF_PI.high() <= twice.high());
        // The cosine is positive before half of pi and negative after it.
        assert!(COS.at(HALF_PI.low(), Below) > 0.0 && COS.at(HALF_PI.high(), Above) < 0.0);
    }

    #[test]
    fn disjoint_intervals_have_an_empty_intersection() {
        assert_eq!(interval(0.0, 1.0).intersection(interval(2.0, 3.0)), Err(Fault::Empty));
        assert_eq!(interval(0.0, 2.0).intersection(interval(1.0, 3.0)), Interval::new(1.0, 2.0));
        assert_eq!(interval(0.0, 1.0).hull(interval(2.0, 3.0)), Interval::new(0.0, 3.0));
    }

    #[test]
    fn midpoints_lie_inside() {
        for (low, high) in [(-f64::MAX, f64::MAX), (f64::MAX, f64::MAX), (5e-324, 5e-324), (1.0, 1.0f64.next_up())] {
            assert!(interval(low, high).contains(interval(low, high).midpoint()));
        }
    }
}
