//! The Python face: names of operations to operations, pairs of floats to pairs of floats, faults to exceptions.

use crate::condition::{Comparison, Condition};
use crate::environment::guarded;
use crate::fault::Fault as Why;
use crate::flowpipe::{flowpipe as flow, End, Pipe, Settings};
use crate::interval::{Enclosure, Interval};
use crate::kinematics;
use crate::ratio;
use crate::recording;
use crate::series::{Op, Tape};
use num_bigint::BigInt;
use num_traits::ToPrimitive;
use pyo3::create_exception;
use pyo3::exceptions::PyArithmeticError;
use pyo3::prelude::*;
use std::ops::{Add, Div, Mul, Neg, Sub};

create_exception!(haverify._kernel, Fault, PyArithmeticError, "Why an operation has no enclosure to give.");

pub(crate) type Pair = (f64, f64);

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

/// A tape as Python gives it: operations by name with operands, constants by position, outputs.
pub(crate) type Listing = (Vec<(String, usize, usize)>, Vec<Pair>, Vec<usize>);

pub(crate) fn tape(listing: &Listing, variables: usize) -> Result<Tape, Why> {
    let (listed, constants, outputs) = listing;
    let mut ops = Vec::with_capacity(listed.len());
    for (name, a, b) in listed {
        ops.push(match name.as_str() {
            "constant" => {
                let (low, high) = *constants.get(*a).ok_or(Why::Unknown)?;
                Op::Constant(Interval::new(low, high)?)
            }
            "variable" => Op::Variable(*a),
            "add" => Op::Add(*a, *b),
            "sub" => Op::Sub(*a, *b),
            "mul" => Op::Mul(*a, *b),
            "div" => Op::Div(*a, *b),
            "neg" => Op::Neg(*a),
            "sqrt" => Op::Sqrt(*a),
            "exp" => Op::Exp(*a),
            "log" => Op::Log(*a),
            "sin" => Op::Sin(*a),
            "cos" => Op::Cos(*a),
            _ => return Err(Why::Unknown),
        });
    }
    Tape::validated(ops, outputs.clone(), variables)
}

/// A tape for each output, with its limits.
fn one_by_one(tape: &Tape, limits: &[Interval]) -> Vec<(Tape, Interval)> {
    let single =
        |(&output, &limits): (&usize, &Interval)| (Tape { ops: tape.ops.clone(), outputs: vec![output] }, limits);
    tape.outputs.iter().zip(limits).map(single).collect()
}

pub(crate) fn pairs(found: &[Interval]) -> Vec<Pair> {
    found.iter().map(|x| (x.low(), x.high())).collect()
}

pub(crate) fn intervals(given: &[Pair]) -> Result<Vec<Interval>, Why> {
    given.iter().map(|&(low, high)| Interval::new(low, high)).collect()
}

pub(crate) fn comparison(sign: &str) -> Result<Comparison, Why> {
    Ok(match sign {
        "<" => Comparison::Less,
        "<=" => Comparison::AtMost,
        ">" => Comparison::Greater,
        ">=" => Comparison::AtLeast,
        "==" => Comparison::Equal,
        "!=" => Comparison::Differ,
        _ => return Err(Why::Unknown),
    })
}

/// A condition as Python gives it, the operator before its members: `all` and `any` with their number, `true`,
/// `false`, or a comparison with the position of the quantity.
pub(crate) type Words = Vec<(String, usize)>;

pub(crate) fn condition(words: &mut std::slice::Iter<(String, usize)>, depth: usize) -> Result<Condition, Why> {
    let (word, number) = words.next().filter(|_| depth < 200).ok_or(Why::Unknown)?;
    let members = |words: &mut std::slice::Iter<(String, usize)>| -> Result<Vec<Condition>, Why> {
        (0..*number).map(|_| condition(words, depth + 1)).collect()
    };
    Ok(match word.as_str() {
        "true" => Condition::Constant(true),
        "false" => Condition::Constant(false),
        "all" => Condition::All(members(words)?),
        "any" => Condition::Any(members(words)?),
        sign => Condition::Atom(*number, comparison(sign)?),
    })
}

/// A stretch of time and what quantities lie in there.
type PieceRow = (f64, f64, Option<Vec<Pair>>);
/// A segment as Python gets it: where it starts, its length, the states, the watched quantities.
type Row = (Pair, f64, Vec<Pair>, Vec<Pair>);

#[pymodule]
mod _kernel {
    use super::*;
    use crate::tree_python::{followed, ModeListing, StartListing};

    #[pymodule_export]
    use super::Fault;
    #[pymodule_export]
    use crate::simulate_python::{Record, Simulator};
    #[pymodule_export]
    use crate::tree_python::Tree;

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

    /// Steps, how it ended (empty: at the horizon), and the states at the horizon (empty if it did not come there).
    #[pyfunction]
    #[allow(clippy::too_many_arguments)]
    fn flowpipe(
        py: Python<'_>,
        field: Listing,
        start: Vec<Pair>,
        horizon: Pair,
        watched: Listing,
        limits: Vec<Pair>,
        order_degree_steps_depth: (usize, usize, usize, u32),
        tolerance_first_longest_least: (f64, f64, f64, f64),
    ) -> PyResult<(Vec<Row>, String, Vec<Pair>)> {
        let (order, degree, steps, depth) = order_degree_steps_depth;
        let (tolerance, first_step, longest_step, least_step) = tolerance_first_longest_least;
        let settings = Settings { order, degree, tolerance, first_step, longest_step, least_step, steps, depth };
        let analysis = || -> Result<Pipe, Why> {
            let field = tape(&field, start.len())?;
            let watch = one_by_one(&tape(&watched, start.len())?, &intervals(&limits)?);
            let horizon = Interval::new(horizon.0, horizon.1)?;
            flow(&field, &intervals(&start)?, horizon, &watch, &settings)
        };
        let pipe = py.detach(|| guarded(analysis)).map_err(|why| Fault::new_err(why.to_string()))?;
        let rows = pipe
            .segments
            .iter()
            .map(|s| ((s.from.low(), s.from.high()), s.step, pairs(&s.states), pairs(&s.watched)))
            .collect();
        let end = match pipe.end {
            End::Horizon => String::new(),
            End::Steps => "the steps allowed were used up".to_owned(),
            End::Stopped(why) => why.to_string(),
        };
        Ok((rows, end, pipe.last.as_deref().map(pairs).unwrap_or_default()))
    }

    /// The tree of stretches that encloses all runs from a box in a mode; `until` is `horizon`, `met` or `violated`.
    #[pyfunction]
    #[allow(clippy::too_many_arguments)]
    fn reach(
        py: Python<'_>,
        modes: Vec<ModeListing>,
        start: StartListing,
        horizon: f64,
        until: &str,
        order_degree_steps_depth: (usize, usize, usize, u32),
        tolerance_first_longest_least: (f64, f64, f64, f64),
        jumps_stretches_cuts: (usize, usize, usize),
    ) -> PyResult<Tree> {
        let limits = (order_degree_steps_depth, tolerance_first_longest_least, jumps_stretches_cuts);
        followed(py, &modes, &start, horizon, until, limits)
    }

    /// The coefficients of polynomials in time and the set as integers in units of `2^-bits`, time in units of `length`:
    /// by variable and power of time from the first on, without zeros at the ends.
    #[pyfunction]
    fn units(series: Vec<Vec<Vec<f64>>>, length: f64, bits: u32) -> PyResult<Vec<Vec<Vec<i64>>>> {
        let found: Result<Vec<_>, Why> = series.iter().map(|x| recording::units(x, length, bits)).collect();
        found.map_err(|why| Fault::new_err(why.to_string()))
    }

    /// Quantities of a motion over stretches of time: ends, and what each quantity lies in, where it has an enclosure.
    #[pyfunction]
    fn along(
        py: Python<'_>,
        positions: Listing,
        readout: Listing,
        derivatives: usize,
        time: Pair,
        widths: Vec<f64>,
        order_depth_stretches: (usize, u32, usize),
    ) -> PyResult<Vec<PieceRow>> {
        let (order, depth, stretches) = order_depth_stretches;
        let analysis = || -> Result<Vec<kinematics::Piece>, Why> {
            let positions = tape(&positions, 1)?;
            let readout = tape(&readout, positions.outputs.len() * (derivatives + 1))?;
            let motion = kinematics::Motion { positions, readout, derivatives };
            let fineness = kinematics::Fineness { order, widths, depth, stretches };
            Ok(kinematics::along(&motion, Interval::new(time.0, time.1)?, &fineness))
        };
        let pieces = py.detach(|| guarded(analysis)).map_err(|why| Fault::new_err(why.to_string()))?;
        Ok(pieces.into_iter().map(|p| (p.low, p.high, p.values.as_deref().map(pairs))).collect())
    }

    /// Ask all flowpipes of this process to give up, or let them go on again.
    #[pyfunction]
    fn halt(is_halted: bool) {
        crate::halt::halt(is_halted);
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
