//! Interval operations, sums of products of series, steps of Taylor models, crossings.

use _kernel::flowpipe::flowpipe;
use _kernel::hybrid::{reach, Budget, Start, Until};
use _kernel::interval::Interval;
use _kernel::models::{Model, Space};
use _kernel::sweep::Sweep;
use criterion::{criterion_group, criterion_main, Criterion};
use haverify_kernel_benches::{ball, interval, pendulum, settings, seven_rates, van_der_pol};
use std::hint::black_box;
use std::ops::{Add, Div, Mul};
use std::sync::Arc;

fn intervals(c: &mut Criterion) {
    let (x, y) = (interval(0.1, 0.7), interval(-1.3, 2.9));
    c.bench_function("interval: sum", |b| b.iter(|| black_box(x).add(black_box(y))));
    c.bench_function("interval: product", |b| b.iter(|| black_box(x).mul(black_box(y))));
    c.bench_function("interval: quotient", |b| b.iter(|| black_box(y).div(black_box(x))));
    c.bench_function("interval: sine", |b| b.iter(|| black_box(x).sin()));
    c.bench_function("interval: exponential", |b| b.iter(|| black_box(x).exp()));
}

fn starts(space: &Space, count: usize) -> Vec<Model> {
    (0..count).map(|v| space.variable(v, 1.0 + 0.1 * v as f64, 0.05)).collect()
}

fn series(c: &mut Criterion) {
    for (name, tape, count, degree) in
        [("2 variables, degree 5", van_der_pol(), 2, 5), ("7 variables, degree 3", seven_rates(), 7, 3)]
    {
        let space = Arc::new(Space::new(count, degree));
        let at = starts(&space, count);
        let mut sweep = Sweep::new(&space, &tape, 8, None);
        c.bench_function(&format!("series of order 8, {name}"), |b| {
            b.iter(|| {
                sweep.restart(&at).expect("finite");
                sweep.extend(8).expect("finite");
                sweep.range(0, 8)
            });
        });
    }
}

fn flows(c: &mut Criterion) {
    let second = Interval::exactly(1.0).expect("finite");
    let box_of = |n: usize| (0..n).map(|v| interval(0.9 + 0.1 * v as f64, 1.0 + 0.1 * v as f64)).collect::<Vec<_>>();
    for (name, tape, n, order, degree) in [
        ("Van der Pol", van_der_pol(), 2, 8, 5),
        ("seven rates", seven_rates(), 7, 8, 3),
        ("pendulum", pendulum(), 2, 16, 1),
    ] {
        let settings = settings(order, degree);
        let start = box_of(n);
        c.bench_function(&format!("flowpipe of 1 s, {name}"), |b| {
            b.iter(|| flowpipe(&tape, &start, second, &[], &settings).expect("a flowpipe"));
        });
    }
}

fn crossings(c: &mut Criterion) {
    let sides = vec![interval(1.0, 1.2), interval(0.0, 0.0), interval(0.0, 0.0)];
    let (modes, start) = ([ball()], Start { mode: 0, sides, known: Vec::new() });
    let budget = Budget { jumps: 5, stretches: 20, cuts: 4 };
    let settings = settings(8, 4);
    c.bench_function("a ball and its first impact", |b| {
        b.iter(|| reach(&modes, &start, 0.7, Until::Horizon, &settings, &budget).expect("a tree"));
    });
}

criterion_group!(inner, intervals, series, flows, crossings);
criterion_main!(inner);
