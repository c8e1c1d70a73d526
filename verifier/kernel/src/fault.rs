//! Why an operation has no enclosure to give.

use std::fmt;

/// The error value that travels in place of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// No number is in the result: ends in the wrong order, or disjoint intervals intersected.
    Empty,
    /// An end is not a number.
    NotANumber,
    /// An end is beyond the largest float.
    Overflow,
    /// The divisor may be zero.
    DivisionByZero,
    /// The argument may leave the function's domain.
    Domain,
    /// The exponent does not fit 32 bits.
    Exponent,
    /// The name of a function or operation is not known.
    Unknown,
    /// No step of the least length could be validated.
    Step,
    /// A jump could not be told from none: the flow touches a guard, or the whole set does not cross it in one step.
    Crossing,
    /// Rounding is not to nearest, or subnormal numbers are flushed to zero.
    Environment,
    /// The analysis was asked to give up.
    Halted,
}

impl fmt::Display for Fault {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            Fault::Empty => "the interval is empty",
            Fault::NotANumber => "an end of the interval is not a number",
            Fault::Overflow => "an end of the interval is beyond the largest float",
            Fault::DivisionByZero => "the divisor may be zero",
            Fault::Domain => "the argument may leave the domain of the function",
            Fault::Exponent => "the exponent does not fit 32 bits",
            Fault::Unknown => "the kernel has no operation of this name",
            Fault::Step => "no step of the least length could be validated",
            Fault::Crossing => {
                "a jump could not be told from none: the flow touches a guard, or does not cross it within one step"
            }
            Fault::Halted => "the analysis was asked to give up",
            Fault::Environment => {
                "the floating-point unit does not round to nearest, or flushes small numbers to zero: \
                 another library of the process changed its settings"
            }
        })
    }
}

impl std::error::Error for Fault {}
