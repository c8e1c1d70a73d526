//! The Python face: names of operations to operations, pairs of floats to pairs of floats, faults to exceptions.

use crate::condition::{Comparison, Condition};
use crate::environment::guarded;
use crate::fault::Fault as Why;
use crate::flowpipe::{flowpipe as flow, End, Pipe, Settings};
use crate::hybrid::End as Ended;
use crate::hybrid::{paced, reach as follow, Budget, Edge, Guard, Judgement, Mode, Start, Stretch, Taken, Until};
use crate::interval::{Enclosure, Interval};
use crate::kinematics;
use crate::models::Model;
use crate::ratio;
use crate::series::{Op, Tape};
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

/// A tape as Python gives it: operations by name with operands, constants by position, outputs.
type Listing = (Vec<(String, usize, usize)>, Vec<Pair>, Vec<usize>);

fn tape(listing: &Listing, variables: usize) -> Result<Tape, Why> {
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

fn pairs(found: &[Interval]) -> Vec<Pair> {
    found.iter().map(|x| (x.low(), x.high())).collect()
}

fn intervals(given: &[Pair]) -> Result<Vec<Interval>, Why> {
    given.iter().map(|&(low, high)| Interval::new(low, high)).collect()
}

fn comparison(sign: &str) -> Result<Comparison, Why> {
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

type Comparisons = Vec<(usize, String)>;

fn guard(given: &Comparisons) -> Result<Guard, Why> {
    given.iter().map(|(at, sign)| Ok((*at, comparison(sign)?))).collect()
}

/// An edge as Python gives it: target, urgent, guard, reset, choices, landing, claim.
type EdgeListing = (usize, bool, Comparisons, Listing, usize, Listing, Words);
/// A stretch of time and what quantities lie in there.
type PieceRow = (f64, f64, Option<Vec<Pair>>);
/// A mode as Python gives it: field, watched quantities, domain, what else it says, claim, window, edges.
type ModeListing = (Listing, Listing, Comparisons, Words, Words, Words, Vec<EdgeListing>);

fn mode(listing: &ModeListing, variables: usize) -> Result<Mode, Why> {
    let (field, watch, domain, rest, claim, window, edges) = listing;
    let edge = |(target, is_urgent, guarded, reset, choices, landing, claim): &EdgeListing| -> Result<Edge, Why> {
        Ok(Edge {
            target: *target,
            is_urgent: *is_urgent,
            guard: guard(guarded)?,
            reset: tape(reset, variables + choices)?,
            choices: *choices,
            landing: tape(landing, 2 * variables)?,
            claim: condition(&mut claim.iter(), 0)?,
        })
    };
    let field = tape(field, variables)?;
    Ok(Mode {
        paced: paced(&field)?,
        field,
        watch: tape(watch, variables)?,
        domain: guard(domain)?,
        rest: condition(&mut rest.iter(), 0)?,
        claim: condition(&mut claim.iter(), 0)?,
        window: condition(&mut window.iter(), 0)?,
        edges: edges.iter().map(edge).collect::<Result<_, _>>()?,
    })
}

/// What is known of a claim, as Python gets it: holds, fails, instants at which it certainly does.
type Judged = (bool, bool, Option<Pair>, Option<Pair>);

fn judged(claim: &Judgement) -> Judged {
    let ends = |x: Option<Interval>| x.map(|x| (x.low(), x.high()));
    (claim.holds, claim.fails, ends(claim.met), ends(claim.violated))
}

/// A jump as Python gets it: edge, time, states before and after, claim.
type JumpRow = (usize, Pair, Vec<Pair>, Vec<Pair>, Judged);
/// A step as Python gets it: time, states, watched quantities, claim, whether it keeps the window, whether runs stay.
type StepRow = (Pair, Vec<Pair>, Vec<Pair>, Judged, bool, bool);
/// A stretch as Python gets it: parent, mode, jumps, certain, jump, steps, how it ended, the states at the horizon.
type StretchRow = (Option<usize>, usize, usize, bool, Option<JumpRow>, Vec<StepRow>, String, Vec<Pair>);

fn stretch_row(s: &Stretch) -> StretchRow {
    let jump = s
        .jump
        .as_ref()
        .map(|j| (j.edge, (j.time.low(), j.time.high()), pairs(&j.before), pairs(&j.after), judged(&j.claim)));
    let steps = s
        .segments
        .iter()
        .map(|g| {
            let time = (g.time.low(), g.time.high());
            (time, pairs(&g.states), pairs(&g.watched), judged(&g.claim), g.keeps_window, g.stays)
        })
        .collect();
    let end = match s.end {
        Ended::Horizon => "horizon".to_owned(),
        Ended::Answered => "answered".to_owned(),
        Ended::Jumped { may_be_stuck: false } => "jumped".to_owned(),
        Ended::Jumped { may_be_stuck: true } => "left".to_owned(),
        Ended::Cut => "cut".to_owned(),
        Ended::Jumps => "jumps".to_owned(),
        Ended::Steps => "the steps allowed were used up".to_owned(),
        Ended::Stretches => "the stretches allowed were used up".to_owned(),
        Ended::Stopped(why) => why.to_string(),
    };
    let last = s.last.as_deref().map(pairs).unwrap_or_default();
    (s.parent, s.mode, s.jumps, s.is_certain, jump, steps, end, last)
}

/// A segment as Python gets it: where it starts, its length, the states, the watched quantities.
type Row = (Pair, f64, Vec<Pair>, Vec<Pair>);

/// A recorded step as Python gets it: its length, and for each variable the coefficients in time, polynomials themselves.
type RecordRow = (f64, Vec<Vec<Vec<f64>>>);

/// Orders and steps, tolerance and lengths of steps, budgets, as Python gives them.
type Limits = ((usize, usize, usize, u32), (f64, f64, f64, f64), (usize, usize, usize));

/// The tree of stretches from a start, found without the interpreter's lock.
fn tree(
    py: Python<'_>,
    modes: &[ModeListing],
    start: &(usize, Vec<Pair>, Comparisons),
    horizon: f64,
    until: &str,
    limits: Limits,
) -> PyResult<Vec<Stretch>> {
    let ((order, degree, steps, depth), (tolerance, first_step, longest_step, least_step), budget) = limits;
    let settings = Settings { order, degree, tolerance, first_step, longest_step, least_step, steps, depth };
    let (jumps, stretches, cuts) = budget;
    let analysis = || -> Result<Vec<Stretch>, Why> {
        let until = match until {
            "horizon" => Until::Horizon,
            "met" => Until::Met,
            "violated" => Until::Violated,
            _ => return Err(Why::Unknown),
        };
        let given: Vec<Mode> = modes.iter().map(|m| mode(m, start.1.len())).collect::<Result<_, _>>()?;
        let budget = Budget { jumps, stretches, cuts };
        let start = Start { mode: start.0, sides: intervals(&start.1)?, known: guard(&start.2)? };
        follow(&given, &start, horizon, until, &settings, &budget)
    };
    py.detach(|| guarded(analysis)).map_err(|why| Fault::new_err(why.to_string()))
}

/// A stretch as a second checker needs it: its parent, mode, the edge it begins with, how it ends, its steps with the
/// exponents of their monomials.
type RecordedStretch = (Option<usize>, usize, Option<usize>, String, Vec<(Vec<Vec<usize>>, RecordRow)>);

fn recorded(s: &Stretch) -> RecordedStretch {
    let wide = |e: &Vec<u8>| e.iter().map(|&p| usize::from(p)).collect();
    let coefficients = |series: &Vec<Model>| series.iter().map(|m| m.coefficients.clone()).collect();
    let row = |t: &Taken| (t.exponents.iter().map(wide).collect(), (t.h, t.series.iter().map(coefficients).collect()));
    let (parent, mode, _, _, _, _, end, _) = stretch_row(s);
    (parent, mode, s.jump.as_ref().map(|j| j.edge), end, s.segments.iter().map(|g| row(&g.taken)).collect())
}

#[pymodule]
mod _kernel {
    use super::*;

    #[pymodule_export]
    use super::Fault;
    #[pymodule_export]
    use crate::simulate_python::{Record, Simulator};

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
        start: (usize, Vec<Pair>, Comparisons),
        horizon: f64,
        until: &str,
        order_degree_steps_depth: (usize, usize, usize, u32),
        tolerance_first_longest_least: (f64, f64, f64, f64),
        jumps_stretches_cuts: (usize, usize, usize),
    ) -> PyResult<Vec<StretchRow>> {
        let limits = (order_degree_steps_depth, tolerance_first_longest_least, jumps_stretches_cuts);
        Ok(tree(py, &modes, &start, horizon, until, limits)?.iter().map(stretch_row).collect())
    }

    /// The polynomials of the tree of stretches: for each its parent, mode, edge (as the mode lists them) and steps.
    #[pyfunction]
    #[allow(clippy::too_many_arguments)]
    fn reach_record(
        py: Python<'_>,
        modes: Vec<ModeListing>,
        start: (usize, Vec<Pair>, Comparisons),
        horizon: f64,
        until: &str,
        order_degree_steps_depth: (usize, usize, usize, u32),
        tolerance_first_longest_least: (f64, f64, f64, f64),
        jumps_stretches_cuts: (usize, usize, usize),
    ) -> PyResult<Vec<RecordedStretch>> {
        let limits = (order_degree_steps_depth, tolerance_first_longest_least, jumps_stretches_cuts);
        Ok(tree(py, &modes, &start, horizon, until, limits)?.iter().map(recorded).collect())
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

    #[pyfunction]
    fn width(x: Pair) -> PyResult<f64> {
        guarded(|| Interval::new(x.0, x.1)?.width()).map_err(|why| Fault::new_err(why.to_string()))
    }

    #[pyfunction]
    fn midpoint(x: Pair) -> PyResult<f64> {
        guarded(|| Ok(Interval::new(x.0, x.1)?.midpoint())).map_err(|why| Fault::new_err(why.to_string()))
    }
}
