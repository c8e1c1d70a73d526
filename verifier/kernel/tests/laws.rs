//! Laws of enclosures under random arguments: what holds of numbers holds of the sets around them.

use _kernel::interval::{Enclosure, Interval};
use _kernel::models::{Model, Space};
use _kernel::series::{solution, Function, IntervalRing, Op, Ring, Tape};
use _kernel::sweep::Sweep;
use proptest::prelude::*;
use std::ops::{Add, Div, Mul, Sub};
use std::sync::Arc;

/// Numbers of all magnitudes at which nothing overflows, zeros and neighbours of zero among them.
fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => -10.0..10.0f64,
        2 => (-1.0..1.0f64, -120..120i32).prop_map(|(x, e)| x * 2f64.powi(e)),
        1 => prop::sample::select(vec![0.0, -0.0, 1.0, -1.0, 5e-324, -5e-324, f64::MIN_POSITIVE, 1e-300]),
    ]
}

/// An interval and a number in it.
fn enclosed() -> impl Strategy<Value = (Interval, f64)> {
    (number(), number(), 0.0..=1.0f64).prop_map(|(a, b, share)| {
        let (low, high) = (a.min(b), a.max(b));
        let x = (low + share * (high - low)).clamp(low, high);
        (Interval::new(low, high).expect("in order"), x)
    })
}

/// A part of an interval.
fn nested() -> impl Strategy<Value = (Interval, Interval)> {
    (enclosed(), 0.0..=1.0f64).prop_map(|((whole, x), share)| {
        let low = (whole.low() + share * (x - whole.low())).clamp(whole.low(), x);
        (whole, Interval::new(low, x).expect("in order"))
    })
}

/// Whether an enclosure holds a rounded result: half a step to either side is nearer to the exact one.
fn holds(found: Enclosure, rounded: f64) -> bool {
    match found {
        Ok(x) => x.low() <= rounded && rounded <= x.high(),
        Err(_) => true,
    }
}

fn is_part(inner: Enclosure, outer: Enclosure) -> bool {
    match (inner, outer) {
        (Ok(a), Ok(b)) => b.low() <= a.low() && a.high() <= b.high(),
        (_, Err(_)) => true,
        (Err(_), Ok(_)) => false,
    }
}

const OPERATIONS: [fn(Interval, Interval) -> Enclosure; 6] =
    [Interval::add, Interval::sub, Interval::mul, Interval::div, Interval::min, Interval::max];

const FUNCTIONS: [Function; 6] =
    [Function::Reciprocal, Function::Sqrt, Function::Exp, Function::Log, Function::Sin, Function::Cos];

fn at(f: Function, x: f64) -> f64 {
    match f {
        Function::Reciprocal => 1.0 / x,
        Function::Sqrt => x.sqrt(),
        Function::Exp => x.exp(),
        Function::Log => x.ln(),
        Function::Sin => x.sin(),
        Function::Cos => x.cos(),
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn operations_hold_what_members_give((x, a) in enclosed(), (y, b) in enclosed()) {
        let results = [a + b, a - b, a * b, a / b, a.min(b), a.max(b)];
        for (f, result) in OPERATIONS.iter().zip(results) {
            prop_assert!(holds(f(x, y), result), "{x:?} {y:?} {result}");
        }
    }

    #[test]
    fn parts_have_parts_as_results_up_to_the_step_that_what_is_not_exact_moves((x, a) in nested(), (y, b) in nested()) {
        for f in OPERATIONS {
            prop_assert!(is_part(f(a, b), f(x, y).and_then(Interval::widened)), "{x:?} {a:?} {y:?} {b:?}");
        }
        for f in FUNCTIONS {
            prop_assert!(is_part(f.at(a), f.at(x).and_then(Interval::widened)), "{f:?} {x:?} {a:?}");
        }
    }

    #[test]
    fn functions_hold_their_values((x, a) in enclosed()) {
        for f in FUNCTIONS {
            if let Ok(found) = f.at(x) {
                let value = at(f, a);
                let slack = 1e-15 * value.abs() + 1e-320; // of the standard library
                prop_assert!(found.low() - slack <= value && value <= found.high() + slack, "{f:?} {x:?} {a} {value}");
            }
        }
    }

    #[test]
    fn integer_powers_hold_products_of_members((x, a) in enclosed(), n in 1..6i32) {
        let product = (0..n).fold(1.0, |p, _| p * a);
        if let Ok(found) = x.powi(n) {
            let slack = f64::from(n) * f64::EPSILON * product.abs() + 1e-320;
            prop_assert!(found.low() - slack <= product && product <= found.high() + slack);
        }
    }
}

/// A model near 2, and a point of its box.
fn model(space: Space) -> impl Strategy<Value = Model> {
    let size = space.size();
    (prop::collection::vec(-0.2..0.2f64, size), 0.0..0.01f64).prop_map(move |(mut coefficients, radius)| {
        coefficients[0] += 2.0;
        Model { coefficients, radius }
    })
}

fn value(space: &Space, m: &Model, z: &[f64]) -> f64 {
    let monomial = |e: &Vec<u8>| e.iter().zip(z).map(|(&p, x)| x.powi(i32::from(p))).product::<f64>();
    m.coefficients.iter().zip(&space.exponents).map(|(c, e)| c * monomial(e)).sum()
}

fn flow() -> Tape {
    // x' = x y / (1 + x^2), y' = sin(x) - 0.3 y
    let ops = vec![
        Op::Variable(0),
        Op::Variable(1),
        Op::Mul(0, 1),
        Op::Mul(0, 0),
        Op::Constant(Interval::exactly(1.0).expect("finite")),
        Op::Add(4, 3),
        Op::Div(2, 5),
        Op::Sin(0),
        Op::Cos(0),
        Op::Constant(Interval::new(0.3, 0.3f64.next_up()).expect("in order")),
        Op::Mul(9, 1),
        Op::Sub(7, 10),
    ];
    Tape::validated(ops, vec![6, 11], 2).expect("operands come first")
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn models_hold_what_members_give(
        a in model(Space::new(2, 3)), b in model(Space::new(2, 3)), z in prop::array::uniform2(-1.0..=1.0f64),
        (s, t) in (-1.0..=1.0f64, -1.0..=1.0f64),
    ) {
        let space = Space::new(2, 3);
        let (x, y) = (value(&space, &a, &z) + s * a.radius, value(&space, &b, &z) + t * b.radius);
        let near = |found: &Model, exact: f64| (value(&space, found, &z) - exact).abs() <= found.radius + 1e-13 * (1.0 + exact.abs());
        prop_assert!(near(&space.add(&a, &b).expect("finite"), x + y));
        prop_assert!(near(&space.sub(&a, &b).expect("finite"), x - y));
        prop_assert!(near(&space.mul(&a, &b).expect("finite"), x * y));
        for f in FUNCTIONS {
            if let Ok(found) = space.apply(f, &a) {
                prop_assert!(near(&found, at(f, x)), "{f:?} {x}");
            }
        }
    }

    #[test]
    fn series_over_models_hold_the_series_from_points(
        (x, y) in (0.3..2.0f64, -1.0..1.0f64), (p, q) in (0.0..0.1f64, 0.0..0.1f64), z in prop::array::uniform2(-1.0..=1.0f64),
    ) {
        let (tape, space) = (flow(), Arc::new(Space::new(2, 3)));
        let mut sweep = Sweep::new(&space, &tape, 5, None);
        sweep.restart(&[space.variable(0, x, p), space.variable(1, y, q)]).expect("finite");
        sweep.extend(5).expect("inside the domain");
        let point: Vec<Interval> =
            [x + p * z[0], y + q * z[1]].iter().map(|&c| Interval::exactly(c).expect("finite")).collect();
        let exact = solution(&IntervalRing, &tape, &point, 5).expect("inside the domain");
        for (v, series) in exact.iter().enumerate() {
            for (found, expected) in sweep.series(v, 5).iter().zip(series) {
                let distance = (value(&space, found, &z) - expected.midpoint()).abs();
                prop_assert!(distance <= found.radius + 1e-12 * (1.0 + expected.norm()), "{distance} {}", found.radius);
            }
        }
    }
}
