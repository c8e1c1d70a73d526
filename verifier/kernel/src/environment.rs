//! Does the floating-point unit work as every argument of this crate assumes?

use crate::fault::Fault;
use std::hint::black_box;

/// Half of the distance between 1 and the next float.
const HALF_ULP: f64 = f64::EPSILON / 2.0;

/// True if ties go to even in both directions, which rounding to nearest alone does.
///
/// Upward rounding fails on `1 + ulp/2`, downward and towards zero on `1 + 3 ulp/2`; negated numbers tell the same
/// of the other side.
fn rounds_to_nearest() -> bool {
    let one = black_box(1.0);
    let tie = one + black_box(HALF_ULP);
    let above = (one + f64::EPSILON) + black_box(HALF_ULP);
    let negative = -one - black_box(HALF_ULP);
    let below = (-one - f64::EPSILON) - black_box(HALF_ULP);
    tie == 1.0 && above == 1.0 + 2.0 * f64::EPSILON && negative == -1.0 && below == -1.0 - 2.0 * f64::EPSILON
}

/// True if subnormal numbers survive as results (no flush to zero) and as operands (no denormals-are-zero).
///
/// Compared as bits, because a comparison would take a flushed operand for zero as well.
fn keeps_subnormals() -> bool {
    let smallest = black_box(f64::MIN_POSITIVE);
    let result = black_box(smallest * black_box(0.5));
    let operand = black_box(f64::from_bits(1)) * black_box(4_503_599_627_370_496.0);
    result.to_bits() == 1 << 51 && operand.to_bits() == f64::MIN_POSITIVE.to_bits()
}

/// Fails unless rounding is to nearest and subnormal numbers are kept, on this thread, now.
pub fn check() -> Result<(), Fault> {
    if rounds_to_nearest() && keeps_subnormals() {
        Ok(())
    } else {
        Err(Fault::Environment)
    }
}

/// The result of `analysis`, if the environment was right before it and after it.
pub fn guarded<T>(analysis: impl FnOnce() -> Result<T, Fault>) -> Result<T, Fault> {
    check()?;
    let result = analysis();
    check()?;
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fresh_thread_rounds_to_nearest_and_keeps_subnormals() {
        assert_eq!(std::thread::spawn(check).join().expect("no panic"), Ok(()));
    }

    #[test]
    fn a_fault_of_the_analysis_is_kept() {
        assert_eq!(guarded(|| Err::<(), Fault>(Fault::Domain)), Err(Fault::Domain));
    }
}
