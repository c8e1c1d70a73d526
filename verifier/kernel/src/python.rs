//! The Python face: names of operations to operations, pairs of floats to pairs of floats, faults to exceptions.

use crate::environment::guarded;
use crate::fault::Fault as Why;
use crate::interval::{Enclosure, Interval};
use crate::ratio;
use num_bigint::BigInt;
use num_traits::ToPrimitive;
use pyo3::create_exception;
use pyo3::exceptions::PyArithmeticError;
use pyo3::prelude::*;
use std::ops::{Add, Div, Mul, Neg, Sub};

create_exception!(haverify._kernel, Fault, PyArithmeticError, "Why an operation has no enclosure to give.");

type Pair = (f64, f64);

/// The pair of ends, or the fault as an exception; computed in a tested floating-point environment.
fn pair(analysis: impl FnOnce() -> Enclosure) -> PyResult<Pair> {
    guarded(analysis).map(|found| (found.low(), found.high())).map_err(|why| Fault::new_err(why.to_string()))
}

fn unary_operation(name: &str) -> Result<fn(Interval) -> Enclosure, Why> {
    Ok(match name {
        "neg" => Interval::neg,
        "abs" => Interval::abs,
        "sqr" => Interval::sqr,
        "sqrt" => Interval::sqrt,
        "exp" => Interval::exp,
        "log" => Interval::log,
        "sin" => Interval::sin,
        "cos" => Interval::cos,
        "tan" => Interval::tan,
        "asin" => Interval::asin,
        "acos" => Interval::acos,
        "atan" => Interval::atan,
        "sinh" => Interval::sinh,
        "cosh" => Interval::cosh,
        "tanh" => Interval::tanh,
        _ => return Err(Why::Unknown),
    })
}

fn binary_operation(name: &str) -> Result<fn(Interval, Interval) -> Enclosure, Why> {
    Ok(match name {
        "add" => Interval::add,
        "sub" => Interval::sub,
        "mul" => Interval::mul,
        "div" => Interval::div,
        "min" => Interval::min,
        "max" => Interval::max,
        "hull" => Interval::hull,
        "intersection" => Interval::intersection,
        _ => return Err(Why::Unknown),
    })
}

#[pymodule]
mod _kernel {
    use super::*;

    #[pymodule_export]
    use super::Fault;

    /// The hash of the sources this kernel was built from.
    #[pyfunction]
    fn source_hash() -> &'static str {
        env!("KERNEL_SOURCE_HASH")
    }

    #[pyfunction]
    fn unary(name: &str, x: Pair) -> PyResult<Pair> {
        pair(|| unary_operation(name)?(Interval::new(x.0, x.1)?))
    }

    #[pyfunction]
    fn binary(name: &str, x: Pair, y: Pair) -> PyResult<Pair> {
        pair(|| binary_operation(name)?(Interval::new(x.0, x.1)?, Interval::new(y.0, y.1)?))
    }

    #[pyfunction]
    fn power(x: Pair, exponent: BigInt) -> PyResult<Pair> {
        pair(|| Interval::new(x.0, x.1)?.powi(exponent.to_i32().ok_or(Why::Exponent)?))
    }

    #[pyfunction]
    fn interval(low: f64, high: f64) -> PyResult<Pair> {
        pair(|| Interval::new(low, high))
    }

    #[pyfunction]
    fn enclose(numerator: BigInt, denominator: BigInt) -> PyResult<Pair> {
        pair(|| ratio::enclose(&numerator, &denominator))
    }

    #[pyfunction]
    fn width(x: Pair) -> PyResult<f64> {
        guarded(|| Interval::new(x.0, x.1)?.width()).map_err(|why| Fault::new_err(why.to_string()))
    }

    #[pyfunction]
    fn midpoint(x: Pair) -> PyResult<f64> {
        guarded(|| Ok(Interval::new(x.0, x.1)?.midpoint())).map_err(|why| Fault::new_err(why.to_string()))
    }
}
