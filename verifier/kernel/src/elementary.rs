//! Elementary functions of a float, rounded down or up.
//!
//! core-math rounds correctly to nearest: the true value is at most half a step from what it returns, so the
//! neighbour on the side asked for bounds it. By the theorem of Lindemann and Weierstrass no other float than the one
//! given beside a function has a rational value, so nowhere else could a result be exact.

use crate::rounding::Towards;

/// A function, the one float where its value is a float, that value, and the range no bound has to leave.
pub struct Elementary {
    nearest: fn(f64) -> f64,
    fixed: (f64, f64),
    range: (f64, f64),
}

const REALS: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);
const POSITIVE: (f64, f64) = (0.0, f64::INFINITY);
const UNIT: (f64, f64) = (-1.0, 1.0);

const fn elementary(nearest: fn(f64) -> f64, fixed: (f64, f64), range: (f64, f64)) -> Elementary {
    Elementary { nearest, fixed, range }
}

pub const EXP: Elementary = elementary(core_math::exp, (0.0, 1.0), POSITIVE);
pub const LOG: Elementary = elementary(core_math::log, (1.0, 0.0), REALS);
pub const SIN: Elementary = elementary(core_math::sin, (0.0, 0.0), UNIT);
pub const COS: Elementary = elementary(core_math::cos, (0.0, 1.0), UNIT);
pub const TAN: Elementary = elementary(core_math::tan, (0.0, 0.0), REALS);
pub const ASIN: Elementary = elementary(core_math::asin, (0.0, 0.0), REALS);
pub const ACOS: Elementary = elementary(core_math::acos, (1.0, 0.0), POSITIVE);
pub const ATAN: Elementary = elementary(core_math::atan, (0.0, 0.0), REALS);
pub const SINH: Elementary = elementary(core_math::sinh, (0.0, 0.0), REALS);
pub const COSH: Elementary = elementary(core_math::cosh, (0.0, 1.0), (1.0, f64::INFINITY));
pub const TANH: Elementary = elementary(core_math::tanh, (0.0, 0.0), UNIT);

impl Elementary {
    /// A bound of the value at `x`, on the side asked for.
    pub fn at(&self, x: f64, towards: Towards) -> f64 {
        if x == self.fixed.0 {
            return self.fixed.1;
        }
        let nearest = (self.nearest)(x);
        match towards {
            Towards::Below => nearest.next_down().max(self.range.0),
            Towards::Above => nearest.next_up().min(self.range.1),
        }
    }
}
