//! Steps of one point through a stiff field: a polynomial in time found in floats, and a bound of what it misses.
//!
//! Let `p` be the polynomial and `e = x - p` what a solution is away from it. Then `e' = A e + d`, where `d = f(p) - p'`
//! and `A` is a mean of the field's slopes between `p` and `x`. With a matrix `S` whose inverse is enclosed, `u = S e`
//! obeys `u' = B u + S d`, `B = S A S^-1`. While `|u|` stays below `w`, `B` is in the matrix of intervals over that tube,
//! and `|u|` is at most the solution of the comparison equation (`comparison`). If that stays below `w` as well, no first
//! exit exists. The directions are chosen so that `B` is nearly diagonal: fast decay, which limits the steps of explicit
//! methods, then is a negative rate (compare the logarithmic norms of G. Dahlquist, 1958, and G. Soderlind, The
//! logarithmic norm, 2006).

use crate::chebyshev::{combination, derivative, ends, range, shifted_polynomials, Line, MOST};
use crate::collocation::{slopes, Points};
use crate::comparison::Comparison;
use crate::duals::jacobian;
use crate::fault::Fault;
use crate::flow::{Flow, Landed, Step};
use crate::frame::Frame;
use crate::interval::Interval;
use crate::matrix::Matrix;
use crate::models::{raised, Model, UNIT};
use crate::path::Path;
use crate::series::{values, Ring};
use std::cell::{Cell, OnceCell};
use std::ops::{Add, Div, Mul, Sub};
use std::sync::Arc;

/// The least degree in time.
const DEGREE: usize = 12;
/// States that are followed so, at most.
const STATES: usize = 16;
/// The fastest decay times the step from which on a field is stiff.
const ONSET: f64 = 1.0;
/// How many explicit steps are made where no implicit one was found.
const PAUSE: u32 = 12;
/// How much longer a step may be than the one before, and when one is made anew.
const GROWTH: f64 = 2.5;
const TOO_LONG: f64 = 0.5;
const TRIES: usize = 4;
const ATTEMPTS: usize = 4;
/// A step may miss so much: near rounding, as more degrees cost little.
const FINE: f64 = 1e-13;
const ROUNDING: f64 = 2e-14;
/// How much errors may grow in a step by what directions that change on the way mix.
const MIXED: f64 = 1.5;

/// Whether steps are implicit, for one flow.
#[derive(Default)]
pub(crate) struct Stiff {
    is_on: Cell<bool>,
    pause: Cell<u32>,
    points: OnceCell<Points>,
}

/// The degree of the polynomials in time.
fn degree(order: usize) -> usize {
    order.clamp(DEGREE, MOST)
}

impl Stiff {
    pub(crate) fn points(&self, order: usize) -> &Points {
        self.points.get_or_init(|| Points::new(degree(order)))
    }

    /// An implicit step, if the field is stiff and one is found.
    pub(crate) fn step(&self, flow: &Flow, wanted: f64) -> Option<(Step, f64)> {
        if !self.is_on.get() {
            return None;
        }
        let mut h = wanted;
        for _ in 0..TRIES {
            match flow.implicit(self.points(flow.settings().order), h) {
                Ok((step, factor)) if factor >= TOO_LONG => {
                    let next = (h * factor.min(GROWTH)).min(flow.settings().longest_step);
                    return Some((step, next));
                }
                Ok((_, factor)) => h *= factor.max(0.1),
                Err(_) => h *= 0.25,
            }
        }
        self.is_on.set(false);
        self.pause.set(PAUSE);
        None
    }

    /// The length of the next step after an explicit one: fast decay that limits it is noticed.
    pub(crate) fn after(&self, h: f64, slopes: &Matrix, next: f64) -> f64 {
        self.pause.set(self.pause.get().saturating_sub(1));
        let fastest = slopes.fastest_decay();
        if self.pause.get() > 0 || slopes.size() > STATES || h * fastest < ONSET {
            return next;
        }
        self.is_on.set(true);
        next.max(2.0 * h)
    }
}

/// What is known of a step: the tube of slopes, bounds of `|u|` during it and at its end, and of what it missed itself.
struct Bounded {
    slopes: Matrix,
    during: Vec<f64>,
    end: Vec<f64>,
    missed: Vec<f64>,
    /// By how much the greatest error grew.
    growth: f64,
}

impl Flow<'_> {
    /// A step of this length, and how much longer it might be.
    pub(crate) fn implicit(&self, points: &Points, h: f64) -> Result<(Step, f64), Fault> {
        let n = self.centre.len();
        let from: Vec<f64> = self.centre.iter().map(|m| m.coefficients[0]).collect();
        let curves = points.solve(self.field(), &from, h).ok_or(Fault::Step)?;
        let middle: Vec<f64> = curves.iter().map(|c| in_the_middle(c)).collect();
        let frame = Frame::of(&slopes(self.field(), &middle)?, n).ok_or(Fault::Step)?;
        let both: Vec<(Interval, Interval)> = curves.iter().map(|c| ends(c)).collect::<Result<_, _>>()?;
        let gap = |(x, (low, _)): (&f64, &(Interval, Interval))| Ok(Interval::exactly(*x)?.sub(*low)?.norm());
        let gaps: Vec<f64> = from.iter().zip(&both).map(gap).collect::<Result<_, Fault>>()?;
        let start = frame.inwards(&self.errors.columns(), &gaps);
        let models: Vec<Model> = curves.iter().map(|c| Model { coefficients: c.clone(), radius: 0.0 }).collect();
        let bounded = self.bounded(&models, &frame, &start, h)?;
        let factor = self.longer(&curves, &bounded, h);
        let step = self.settled(&models, &both, &frame, &bounded, h)?;
        Ok((step, factor))
    }

    /// Bounds of what a solution is away from the polynomials, in the directions of a frame.
    fn bounded(&self, models: &[Model], frame: &Frame, start: &[f64], h: f64) -> Result<Bounded, Fault> {
        let driven = self.driven(models, frame, h)?;
        let mut room: Vec<f64> = start.iter().zip(&driven).map(|(r, d)| 1.5 * (r + h * d) + 1e-250).collect();
        for _ in 0..ATTEMPTS {
            let (slopes, rates) = self.rates(models, frame, &room)?;
            let comparison = Comparison { rates, driven: driven.clone() };
            let during = comparison.during(h, start).ok_or(Fault::Overflow)?.sum();
            if during.iter().zip(&room).all(|(d, r)| raised(*d) < *r) {
                let end = comparison.after(h, start).ok_or(Fault::Overflow)?;
                let most = |x: &[f64]| frame.outwards(x).into_iter().fold(0.0, f64::max);
                let growth = most(&end.moved) / most(start).max(f64::MIN_POSITIVE);
                return Ok(Bounded { slopes, during, missed: frame.outwards(&end.driven), end: end.sum(), growth });
            }
            room = during.iter().zip(&room).map(|(d, r)| 1.5 * d.max(*r)).collect();
        }
        Err(Fault::Step)
    }

    /// Bounds of `|S d|`.
    fn driven(&self, models: &[Model], frame: &Frame, h: f64) -> Result<Vec<f64>, Fault> {
        let line = Line { degree: 2 * (models[0].coefficients.len() - 1) };
        let fast = Interval::exactly(2.0)?.div(Interval::exactly(h)?)?;
        let missed = |(f, p): (Model, &Model)| line.sub(&f, &line.scale(&derivative(&p.coefficients)?, fast)?);
        let rates = values(&line, self.field(), models)?;
        let defects: Vec<Model> = rates.into_iter().zip(models).map(missed).collect::<Result<_, _>>()?;
        let n = models.len();
        let along = |i: usize| {
            let weights = frame.forth[i * n..(i + 1) * n].iter();
            let weights: Vec<Interval> = weights.map(|&s| Interval::exactly(s)).collect::<Result<_, _>>()?;
            Ok(range(&combination(defects.iter().zip(weights))?)?.norm())
        };
        (0..n).map(along).collect()
    }

    /// The slopes of the field over the step while `|u|` is below some bounds, and the matrix to compare with.
    fn rates(&self, models: &[Model], frame: &Frame, room: &[f64]) -> Result<(Matrix, Vec<f64>), Fault> {
        let n = models.len();
        let line = Line { degree: models[0].coefficients.len() - 1 };
        let around = |(m, r): (&Model, f64)| Model { coefficients: m.coefficients.clone(), radius: r };
        let tube: Vec<Model> = models.iter().zip(frame.outwards(room)).map(around).collect();
        let slopes = jacobian(&line, self.field(), &tube)?;
        let inverse: Vec<Interval> = (0..n * n).map(|at| frame.inverse(at / n, at % n)).collect::<Result<_, _>>()?;
        let mut turned = Vec::with_capacity(n * n);
        for row in &slopes {
            for j in 0..n {
                turned.push(combination(row.iter().zip(inverse.iter().skip(j).step_by(n).copied()))?);
            }
        }
        let mut rates = Vec::with_capacity(n * n);
        for i in 0..n {
            let weights: Vec<Interval> =
                frame.forth[i * n..(i + 1) * n].iter().map(|&s| Interval::exactly(s)).collect::<Result<_, _>>()?;
            for j in 0..n {
                let column = turned.iter().skip(j).step_by(n);
                let found = range(&combination(column.zip(weights.iter().copied()))?)?;
                rates.push(if i == j { found.high() } else { found.norm() });
            }
        }
        Ok((Matrix::from_fn(n, |i, j| range(&slopes[i][j]))?, rates))
    }

    /// How much longer the step may be for what it missed.
    fn longer(&self, curves: &[Vec<f64>], bounded: &Bounded, h: f64) -> f64 {
        let moving: Vec<usize> = (0..curves.len()).filter(|&v| !bounded.slopes.is_zero_row(v)).collect();
        let size = moving.iter().fold(0.0f64, |m, &v| m.max(curves[v][0].abs()));
        let wanted = self.settings().tolerance.min(FINE * size).max(ROUNDING * size);
        let missed = moving.iter().fold(0.0f64, |m, &v| m.max(bounded.missed[v]));
        let by_size = (0.5 * wanted / missed).powf(1.0 / curves[0].len() as f64);
        let by_size = if missed <= wanted { f64::INFINITY } else { by_size };
        // Longer steps mix more: with the square of their length.
        let by_mixing = if bounded.growth > MIXED { (MIXED / bounded.growth).sqrt() } else { f64::INFINITY };
        let by_decay = moving.iter().map(|&v| by_decay(&curves[v])).fold(f64::INFINITY, f64::min).max(1.0);
        let known = by_size.min(by_mixing).min(by_decay);
        if h >= self.settings().longest_step && known > 1.0 {
            1.0
        } else {
            known
        }
    }

    /// The step as others see it, with the set at its end.
    fn settled(
        &self,
        models: &[Model],
        both: &[(Interval, Interval)],
        frame: &Frame,
        bounded: &Bounded,
        h: f64,
    ) -> Result<Step, Fault> {
        let moved = frame.outwards(&bounded.during);
        let table = shifted_polynomials(models[0].coefficients.len() - 1);
        let series = models.iter().map(|m| self.powers(&m.coefficients, &table, h)).collect::<Result<_, _>>()?;
        let lagrange = vec![Interval::ZERO; models.len()];
        let path = Path { h, space: self.shared.clone(), series: Arc::new(series), lagrange, moved: moved.clone() };
        let whole = |(m, r): (&Model, f64)| Ok(self.linear.constant(range(m)?.add(Interval::symmetric(r)?)?));
        let states = models.iter().zip(moved).map(whole).collect::<Result<_, Fault>>()?;
        let centre = both.iter().map(|(_, last)| self.space.number(last.midpoint())).collect();
        let rest = |(_, last): &(Interval, Interval)| {
            let middle = last.midpoint();
            (last.high() - middle).max(middle - last.low())
        };
        let rest: Vec<f64> = both.iter().map(rest).collect();
        let errors = frame.errors(self, &bounded.end, &rest);
        Ok(Step::landed(path, bounded.slopes.clone(), states, Landed { centre, errors }))
    }

    /// A sum of Chebyshev polynomials over the step as a series in time.
    fn powers(&self, coefficients: &[f64], table: &[Vec<f64>], h: f64) -> Result<Vec<Model>, Fault> {
        let (step, mut length) = (Interval::exactly(h)?, Interval::exactly(1.0)?);
        let mut found = Vec::with_capacity(coefficients.len());
        for k in 0..coefficients.len() {
            let terms = || coefficients.iter().zip(table).skip(k).map(|(c, powers)| c * powers[k]);
            let mass: f64 = terms().map(f64::abs).sum();
            let rounding = Interval::symmetric(raised(UNIT * (coefficients.len() + 3) as f64 * mass))?;
            found.push(self.shared.constant(Interval::exactly(terms().sum())?.add(rounding)?.div(length)?));
            length = length.mul(step)?;
        }
        Ok(found)
    }
}

/// The value of a sum of Chebyshev polynomials at zero.
fn in_the_middle(coefficients: &[f64]) -> f64 {
    coefficients.iter().step_by(2).enumerate().map(|(k, c)| if k % 2 == 0 { *c } else { -c }).sum()
}

/// How much longer a step may be for coefficients that fall like powers: those up to the first that is nothing but
/// rounding tell how fast, and the last should come to rounding.
fn by_decay(coefficients: &[f64]) -> f64 {
    let size = coefficients.iter().skip(1).fold(0.0f64, |m, c| m.max(c.abs()));
    let least = UNIT * coefficients[0].abs().max(size);
    let known = coefficients.iter().rposition(|c| c.abs() > 4.0 * least).unwrap_or(1).max(1);
    if size <= least {
        return f64::INFINITY;
    }
    (least / size).powf(1.0 / (coefficients.len() as f64 - 1.0) - 1.0 / known as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flowpipe::{flowpipe, End, Settings};
    use crate::series::{Op, Tape};
    use crate::sets::Set;

    fn settings(longest_step: f64) -> Settings {
        Settings {
            order: 16,
            degree: 1,
            tolerance: 1e-13,
            first_step: 1e-3,
            longest_step,
            least_step: 1e-9,
            steps: 500,
            depth: 3,
        }
    }

    fn exactly(x: f64) -> Interval {
        Interval::exactly(x).expect("finite")
    }

    /// x' = -1000 (x - y), y' = -y.
    fn pulled() -> Tape {
        let ops = vec![
            Op::Variable(0),
            Op::Variable(1),
            Op::Sub(1, 0),
            Op::Constant(exactly(1000.0)),
            Op::Mul(3, 2),
            Op::Neg(1),
        ];
        Tape::validated(ops, vec![4, 5], 2).expect("a tape")
    }

    /// Its solution from (1, 1).
    fn solution(t: f64) -> [f64; 2] {
        let slow = (-t).exp();
        [(1000.0 * slow - (-1000.0 * t).exp()) / 999.0, slow]
    }

    #[test]
    fn a_stiff_pull_is_followed_in_few_steps_and_enclosed_all_the_way() {
        let start = [exactly(1.0), exactly(1.0)];
        let pipe = flowpipe(&pulled(), &start, exactly(3.0), &[], &settings(1.0)).expect("a flowpipe");
        assert_eq!(pipe.end, End::Horizon);
        assert!(pipe.segments.len() < 60, "{}", pipe.segments.len());
        for s in &pipe.segments {
            for part in 0..=8 {
                let t = s.from.midpoint() + s.step * f64::from(part) / 8.0;
                for (x, found) in solution(t).into_iter().zip(&s.states) {
                    assert!(found.low() - 1e-14 <= x && x <= found.high() + 1e-14, "{t}: {x} {found:?}");
                }
            }
        }
        for (x, found) in solution(3.0).into_iter().zip(pipe.last.expect("it arrives")) {
            assert!(found.low() - 1e-15 <= x && x <= found.high() + 1e-15 && found.width().expect("finite") < 1e-11);
        }
    }

    /// Where x is beside y = 1 when nothing decays fast any more.
    const SLOW: f64 = 1000.0 / 999.0;

    fn bounds_of(miss: f64) -> (Vec<f64>, Vec<f64>, Frame) {
        let (field, settings) = (pulled(), settings(1.0));
        let flow = Flow::new(&field, Set::of_box(&[exactly(SLOW), exactly(1.0)], 1), &settings);
        let mut curves = Points::new(12).solve(&field, &[SLOW, 1.0], 0.5).expect("it converges");
        curves[1][3] += miss;
        curves[0][12] -= miss;
        let ends: Vec<f64> = curves.iter().map(|c| ends(c).expect("finite").1.midpoint()).collect();
        let frame = Frame::of(&slopes(&field, &[1.0, 1.0]).expect("finite"), 2).expect("regular");
        let models: Vec<Model> = curves.into_iter().map(|c| Model { coefficients: c, radius: 0.0 }).collect();
        // Where the polynomials start is not where they should.
        let start = frame.inwards(&[], &[2.0 * miss, 2.0 * miss]);
        let bounded = flow.bounded(&models, &frame, &start, 0.5).expect("bounds");
        (ends, frame.outwards(&bounded.end), frame)
    }

    #[test]
    fn what_polynomials_miss_is_bounded_however_bad_they_are() {
        let exact = [SLOW * (-0.5f64).exp(), (-0.5f64).exp()];
        for miss in [1e-12, 1e-6, 1e-3] {
            let (found, radii, _) = bounds_of(miss);
            for ((x, p), r) in exact.iter().zip(&found).zip(&radii) {
                assert!((x - p).abs() <= r + 1e-15, "{miss}: {} {r}", x - p);
                assert!(*r < 1e4 * miss + 1e-12);
            }
            assert!((found[1] - exact[1]).abs() > 0.5 * miss);
        }
    }

    #[test]
    fn frames_take_errors_in_and_out() {
        let (_, _, frame) = bounds_of(1e-6);
        let inside = frame.inwards(&[vec![3e-3, -1e-3]], &[1e-4, 2e-4]);
        let outside = frame.outwards(&inside);
        assert!(outside[0] >= 3e-3 + 1e-4 && outside[1] >= 1e-3 + 2e-4);
        for at in 0..4 {
            let product: Interval = (0..2).fold(Interval::ZERO, |sum, k| {
                let term = frame.inverse(at / 2, k).and_then(|x| x.mul(exactly(frame.forth[k * 2 + at % 2])));
                sum.add(term.expect("finite")).expect("finite")
            });
            assert!(product.contains(f64::from(u8::from(at / 2 == at % 2))));
        }
    }
}
