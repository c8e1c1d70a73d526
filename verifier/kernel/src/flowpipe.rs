//! Validated flowpipes of `x' = f(x)`: Taylor series in time over Taylor models of the initial set.
//!
//! Between steps the set is `{ p(z) + e : z in [-1, 1]^n, e in the errors at z }`. One step of length `h`:
//! 1. `x_0 .. x_k`, the series in time from `p(z)`, as Taylor models in `z`;
//! 2. an a-priori tube: for each `z`, a box `p(z) + M` that no solution from the set leaves before `h`. The series,
//!    Lagrange's term over the tube and the moved errors must end up strictly inside `M`: then no first exit exists;
//! 3. the series at `h` becomes the next `p`; all its error, moved errors included, the next errors.
//!
//! Soundness: solutions from `p(z) + e` and from `p(z)` differ by `V e`, `V' = Df(x) V` for some `x` in the tube at
//! `z`, because that tube is convex and holds both. A series of `V` in `h` has coefficients that are polynomials of
//! the field's derivatives at the start, and for its last term at some state of the tube.

use crate::errors::Errors;
use crate::fault::Fault;
use crate::interval::{Enclosure, Interval};
use crate::matrix::Matrix;
use crate::models::{Model, Space};
use crate::series::{values, Ring, Tape};
use crate::sets::Set;
use crate::sweep::Sweep;
use std::cell::RefCell;
use std::ops::{Add, Mul, Sub};
use std::sync::Arc;

/// How finely to compute; none of it decides whether a result is true.
#[derive(Debug, Clone)]
pub struct Settings {
    /// Of the series in time.
    pub order: usize,
    /// Of the polynomials in the set variables.
    pub degree: usize,
    /// The last term of the series to aim at, in the units of the state.
    pub tolerance: f64,
    pub first_step: f64,
    pub longest_step: f64,
    pub least_step: f64,
    pub steps: usize,
    /// How often a step is halved where a watched quantity leaves its limits.
    pub depth: u32,
}

/// One step: instants, the box of all states in it, ranges of the watched quantities.
#[derive(Debug, Clone)]
pub struct Segment {
    pub from: Interval,
    pub step: f64,
    pub states: Vec<Interval>,
    pub watched: Vec<Interval>,
}

/// How a flowpipe ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum End {
    Horizon,
    Steps,
    Stopped(Fault),
}

/// The steps, how it ended, and the states at the horizon if it came there.
#[derive(Debug, Clone)]
pub struct Pipe {
    pub segments: Vec<Segment>,
    pub end: End,
    pub last: Option<Vec<Interval>>,
}

/// What to watch: tapes over the state, each with the range in which nothing needs a closer look.
pub type Watch<'a> = &'a [(Tape, Interval)];

/// The order to which the transition of errors over a step is expanded, and its degree in the set variables.
const VARIATION: usize = 4;
const LINEAR: usize = 1;
/// What a step may lose to a simple transition of errors, as a share of the error aimed at.
const LOSS: f64 = 0.1;
/// Terms of the series that are a smaller part of the tolerance than this may be kept as errors.
const SHARE: f64 = 1e-3;
/// How often an a-priori tube is tried for one length of step.
const ATTEMPTS: usize = 4;

/// What holds during a whole step: the last coefficient of the series, the slopes of the field, all states.
pub(crate) struct Tube {
    lagrange: Vec<Interval>,
    slopes: Matrix,
    states: Vec<Model>,
    /// How the slopes alone move errors: to any instant of the step, and to its end.
    along: Matrix,
    across: Matrix,
}

/// One validated step: the series at its start, what holds during it, how errors move to its end.
pub(crate) struct Step {
    pub(crate) h: f64,
    series: Vec<Vec<Model>>,
    tube: Tube,
    transition: Vec<Vec<Model>>,
    /// Bounds of what the errors at its start are at any of its instants.
    moved: Vec<f64>,
}

/// A set on its way along a field.
pub(crate) struct Flow<'a> {
    field: &'a Tape,
    settings: &'a Settings,
    pub(crate) space: Space,
    /// The space of what errors and tubes need.
    linear: Space,
    centre: Vec<Model>,
    errors: Errors,
    sweeps: RefCell<Sweeps>,
}

/// Room for the series that a step computes: of the set, over a tube, and of its start with errors.
struct Sweeps {
    series: Sweep,
    tube: Sweep,
    start: Sweep,
    /// How far errors and the last term went in the step before, where the next tube is looked for.
    before: Option<(Matrix, Vec<f64>)>,
}

/// Follow the box `start` until the latest instant of `horizon`, or as far as it goes.
pub fn flowpipe(
    field: &Tape,
    start: &[Interval],
    horizon: Interval,
    watch: Watch,
    settings: &Settings,
) -> Result<Pipe, Fault> {
    let mut flow = Flow::new(field, Set::of_box(start, settings.degree), settings);
    let mut pipe = Pipe { segments: Vec::new(), end: End::Steps, last: None };
    let (mut time, mut h) = (Interval::ZERO, settings.first_step.min(settings.longest_step));
    while pipe.segments.len() < settings.steps {
        let left = horizon.high() - time.low();
        if left <= 0.0 {
            pipe.end = End::Horizon;
            break;
        }
        match flow.advance(time, horizon, if h < left { h } else { left.next_up() }, watch, &mut pipe) {
            Ok((after, next)) => (time, h) = (after, next),
            Err(fault) => {
                pipe.end = End::Stopped(fault);
                break;
            }
        }
    }
    Ok(pipe)
}

/// One step as a second integrator may check it: its length, and the series in time of every variable from its start.
pub type Recorded = (f64, Vec<Vec<Model>>);

/// The polynomials of a flowpipe: the exponents of their monomials, and the steps until the latest instant of `horizon`.
/// They prove nothing by themselves: errors are left out.
pub fn record(
    field: &Tape,
    start: &[Interval],
    horizon: Interval,
    settings: &Settings,
) -> Result<(Vec<Vec<u8>>, Vec<Recorded>), Fault> {
    let mut flow = Flow::new(field, Set::of_box(start, settings.degree), settings);
    let (mut time, mut wanted) = (Interval::ZERO, settings.first_step.min(settings.longest_step));
    let mut steps = Vec::new();
    while horizon.high() > time.low() {
        if steps.len() == settings.steps {
            return Err(Fault::Step);
        }
        let left = horizon.high() - time.low();
        let (step, next) = flow.step(if wanted < left { wanted } else { left.next_up() })?;
        flow.land(&step)?;
        (time, wanted) = (time.add(Interval::exactly(step.h)?)?, next);
        steps.push((step.h, step.series));
    }
    Ok((flow.space.exponents, steps))
}

impl Step {
    /// The series in time by variable: coefficients that are models of the set.
    pub(crate) fn series(&self) -> &[Vec<Model>] {
        &self.series
    }

    /// The coefficient of the term after the last of the series, at any instant of the step.
    pub(crate) fn lagrange(&self, v: usize) -> Interval {
        self.tube.lagrange[v]
    }

    /// Bounds of what the errors at the start of the step are at any instant of it.
    pub(crate) fn moved(&self, v: usize) -> f64 {
        self.moved[v]
    }

    pub(crate) fn order(&self) -> usize {
        self.series[0].len() - 1
    }
}

impl<'a> Flow<'a> {
    /// From the polynomials of a set; their radii are errors.
    pub(crate) fn new(field: &'a Tape, start: Set, settings: &'a Settings) -> Flow<'a> {
        let Set { space, models } = start;
        let linear = Space::new(space.variables, LINEAR);
        let radii: Vec<f64> = models.iter().map(|m| m.radius).collect();
        let centre = models.iter().map(|m| space.polynomial(m)).collect();
        let errors = Errors::of_box(&linear, &radii);
        let (whole, low) = (Arc::new(space.clone()), Arc::new(linear.clone()));
        let sweeps = RefCell::new(Sweeps {
            series: Sweep::new(&whole, field, settings.order, None),
            tube: Sweep::new(&low, field, settings.order.max(VARIATION) + 1, Some(VARIATION + 1)),
            start: Sweep::new(&low, field, VARIATION, Some(VARIATION)),
            before: None,
        });
        Flow { field, settings, space, linear, centre, errors, sweeps }
    }

    /// Take one step of at most `wanted` and record it; the instant after it and the length to try next.
    fn advance(
        &mut self,
        time: Interval,
        horizon: Interval,
        wanted: f64,
        watch: Watch,
        pipe: &mut Pipe,
    ) -> Result<(Interval, f64), Fault> {
        let (step, next) = self.step(wanted)?;
        let taken = Interval::new(0.0, step.h)?;
        let watched = watch.iter().map(|(tape, limits)| self.watched(&step, tape, *limits, taken, self.settings.depth));
        let watched = watched.collect::<Result<_, _>>()?;
        let states = ranges(&self.linear, &step.tube.states)?;
        pipe.segments.push(Segment { from: time, step: step.h, states, watched });
        let after = time.add(Interval::exactly(step.h)?)?;
        let arrived = if after.high() >= horizon.low() {
            let first = (horizon.low() - time.high()).next_down().max(0.0).min(step.h);
            Some((first, ranges(&self.space, &self.states(&step, Interval::new(first, step.h)?)?)?))
        } else {
            None
        };
        self.land(&step)?;
        if let Some((first, during)) = arrived {
            pipe.last = Some(self.arrived(&step, first, &during)?);
        }
        Ok((after, next))
    }

    /// The states from an instant of the step just made to its end: back from its end by the mean value theorem, and
    /// inside what the step itself says of them.
    fn arrived(&self, step: &Step, first: f64, during: &[Interval]) -> Result<Vec<Interval>, Fault> {
        let back = Interval::new(first, step.h)?.sub(Interval::exactly(step.h)?)?;
        let rates = ranges(&self.linear, &values(&self.linear, self.field, &step.tube.states)?)?;
        let ends = self.set()?.hull()?;
        let both = ends.iter().zip(&rates).zip(during);
        both.map(|((end, rate), during)| end.add(rate.mul(back)?)?.intersection(*during)).collect()
    }

    /// A step of at most `wanted`, and the length to try next.
    pub(crate) fn step(&self, wanted: f64) -> Result<(Step, f64), Fault> {
        let Settings { order, tolerance, .. } = *self.settings;
        // What is left before the horizon may be shorter than any step should be.
        let least_step = self.settings.least_step.min(wanted);
        let series = self.series(wanted)?;
        let known: Vec<Vec<Interval>> = (0..series.len()).map(|v| self.known(v, &series[v])).collect::<Result<_, _>>()?;
        let (mut h, mut growth) = (wanted, 1.5);
        while h >= least_step {
            let Ok(tube) = self.tube(&known, h) else {
                h *= if growth > 1.0 { 0.7 } else { 0.5 };
                growth = 1.0;
                continue;
            };
            let last = tube.lagrange.iter().map(|l| l.norm()).fold(0.0, f64::max) * h.powi(order as i32 + 1);
            let factor = 0.9 * (tolerance / last).powf(1.0 / (order + 1) as f64);
            if factor < 0.6 && h > 2.0 * least_step {
                h *= factor.max(0.2);
                continue;
            }
            let transition = self.transition(&tube, &tube.across, h)?;
            let moved = tube.along.bounds(&self.errors.radii(self.centre.len()));
            return Ok((
                Step { h, series, tube, transition, moved },
                (h * factor.clamp(0.3, growth)).min(self.settings.longest_step),
            ));
        }
        Err(Fault::Step)
    }

    /// A tube that no solution from the set leaves before `h`.
    fn tube(&self, series: &[Vec<Interval>], h: f64) -> Result<Tube, Fault> {
        let order = self.settings.order;
        let span = Interval::new(0.0, h)?;
        let power = span.powi(order as i32 + 1)?;
        let errors = self.errors.radii(series.len());
        let motion: Vec<Interval> =
            series.iter().map(|r| horner(&r[1..], span)?.mul(span)).collect::<Result<_, _>>()?;
        let mut added = self.guess(&motion, &errors, power)?;
        for _ in 0..ATTEMPTS {
            let states = self.around(&added)?;
            let (lagrange, slopes) = self.swept(&states)?;
            let [along, across] = slopes.transitions([span, Interval::exactly(h)?])?;
            let moved = along.bounds(&errors);
            let mut landed = Vec::with_capacity(motion.len());
            for v in 0..motion.len() {
                landed.push(motion[v].add(power.mul(lagrange[v])?)?.add(Interval::symmetric(moved[v])?)?);
            }
            if added.iter().zip(&landed).all(|(m, l)| m.holds_inside(*l)) {
                let far = lagrange.iter().map(|l| l.norm()).collect();
                self.sweeps.borrow_mut().before = Some((along.clone(), far));
                return Ok(Tube { lagrange, slopes, states: self.around(&landed)?, along, across });
            }
            let wider = added.iter().zip(&landed).map(|(m, l)| inflated(m.hull(*l)?, 0.1));
            added = wider.collect::<Result<_, _>>()?;
        }
        Err(Fault::Step)
    }

    /// Where a tube may be: around the motion of the series, with room for errors and the last term.
    fn guess(&self, motion: &[Interval], errors: &[f64], power: Interval) -> Result<Vec<Interval>, Fault> {
        let sweeps = self.sweeps.borrow();
        let room: Vec<f64> = match &sweeps.before {
            Some((along, lagrange)) => {
                let moved = along.bounds(errors);
                moved.iter().zip(lagrange).map(|(e, l)| 1.2 * e + 1.5 * l * power.high()).collect()
            }
            None => errors.iter().map(|e| 2.0 * e).collect(),
        };
        motion.iter().zip(&room).map(|(m, r)| inflated(m.add(Interval::symmetric(*r)?)?, 0.01)).collect()
    }

    /// The series from the set without its errors.
    fn series(&self, h: f64) -> Result<Vec<Vec<Model>>, Fault> {
        let sweep = &mut self.sweeps.borrow_mut().series;
        sweep.restart(&self.centre)?;
        sweep.extend_for(self.settings.order, Some((h, SHARE * self.settings.tolerance)))?;
        Ok((0..self.centre.len()).map(|v| sweep.series(v, self.settings.order)).collect())
    }

    /// Ranges of the coefficients of a state's series: the first terms decide how wide a tube has to be.
    fn known(&self, v: usize, series: &[Model]) -> Result<Vec<Interval>, Fault> {
        let sweep = &self.sweeps.borrow().series;
        let range = |(k, m)| if k < 3 { self.space.range(m) } else { sweep.range(v, k) };
        series.iter().enumerate().map(range).collect()
    }

    /// The coefficient after the last of the series, and the slopes of the field, from all states of a tube.
    fn swept(&self, states: &[Model]) -> Result<(Vec<Interval>, Matrix), Fault> {
        let (n, next) = (states.len(), self.settings.order + 1);
        let sweep = &mut self.sweeps.borrow_mut().tube;
        sweep.restart(states)?;
        sweep.extend(next)?;
        let lagrange = (0..n).map(|v| self.linear.range(&sweep.coefficient(v, next))).collect::<Result<_, _>>()?;
        Ok((lagrange, Matrix::from_fn(n, |i, j| self.range_or_zero(sweep.rate_slope(i, j)?))?))
    }

    fn range_or_zero(&self, slope: Option<Model>) -> Enclosure {
        slope.map_or(Ok(Interval::ZERO), |m| self.linear.range(&m))
    }

    /// The set at the start of the step without its errors, of low degree, a box added to each of its points.
    fn around(&self, added: &[Interval]) -> Result<Vec<Model>, Fault> {
        let low = |(m, x): (&Model, &Interval)| self.linear.shifted(&self.space.lowered(m, &self.linear)?, *x);
        self.centre.iter().zip(added).map(low).collect()
    }

    /// How errors at the start of a step move to its end: what the slopes alone give, and where that would lose much,
    /// the series of the transition, whose last term is taken over the tube.
    fn transition(&self, tube: &Tube, coarse: &Matrix, h: f64) -> Result<Vec<Vec<Model>>, Fault> {
        let n = self.centre.len();
        let radii = self.errors.radii(n);
        let lost = |i: usize| (0..n).map(|j| coarse.width(i, j) * radii[j]).sum::<f64>();
        let is_costly = (0..n).map(lost).fold(0.0, f64::max) > LOSS * self.settings.tolerance;
        let fine = if is_costly { Some(self.expanded(tube, h, &radii)?) } else { None };
        let entry = |i: usize, j: usize| {
            let simple = || Ok(self.linear.constant(coarse.entry(i, j)?));
            let Some(fine) = fine.as_ref().map(|m| &m[i][j]) else { return simple() };
            if self.linear.range(fine)?.width()? > coarse.width(i, j) {
                return simple();
            }
            Ok(fine.clone())
        };
        (0..n).map(|i| (0..n).map(|j| entry(i, j)).collect()).collect()
    }

    /// The series of the transition, of degree one in the set variables.
    fn expanded(&self, tube: &Tube, h: f64, radii: &[f64]) -> Result<Vec<Vec<Model>>, Fault> {
        let n = self.centre.len();
        let step = Interval::exactly(h)?;
        let errors: Vec<Interval> = radii.iter().map(|&r| Interval::symmetric(r)).collect::<Result<_, _>>()?;
        let Sweeps { start, tube: during, .. } = &mut *self.sweeps.borrow_mut();
        start.restart(&self.around(&errors)?)?;
        start.extend_slopes(VARIATION)?;
        during.restart(&tube.states)?;
        during.extend_slopes(VARIATION + 1)?;
        let last = Matrix::from_fn(n, |i, j| self.range_or_zero(during.slope_of(i, j, VARIATION + 1)))?;
        let rest = last.product(&tube.along).scaled(step.powi(VARIATION as i32 + 1)?);
        let powers: Vec<Interval> = (0..=VARIATION as i32).map(|i| step.powi(i)).collect::<Result<_, _>>()?;
        let entry = |i: usize, j: usize| {
            let first: Vec<Model> = (0..=VARIATION).map_while(|k| start.slope_of(i, j, k)).collect();
            let sum = self.linear.combination(&first, &powers)?;
            self.linear.shifted(&sum, rest.entry(i, j)?)
        };
        (0..n).map(|i| (0..n).map(|j| entry(i, j)).collect()).collect()
    }

    /// The states at instants `t` of the step, as Taylor models with all errors in their radius.
    pub(crate) fn states(&self, step: &Step, t: Interval) -> Result<Vec<Model>, Fault> {
        let order = self.settings.order;
        let powers: Vec<Interval> = (0..=order as i32).map(|i| t.powi(i)).collect::<Result<_, _>>()?;
        let last = t.powi(order as i32 + 1)?;
        let state = |v: usize| {
            let model = self.space.combination(&step.series[v], &powers)?;
            self.space.shifted(&model, last.mul(step.tube.lagrange[v])?.add(Interval::symmetric(step.moved[v])?)?)
        };
        (0..step.series.len()).map(state).collect()
    }

    pub(crate) fn settings(&self) -> &'a Settings {
        self.settings
    }

    pub(crate) fn field(&self) -> &Tape {
        self.field
    }

    /// The states at the start of the next step.
    pub(crate) fn set(&self) -> Result<Set, Fault> {
        let radii = self.errors.radii(self.centre.len());
        let with = |(m, r): (&Model, f64)| Model { coefficients: m.coefficients.clone(), radius: r };
        Ok(Set { space: self.space.clone(), models: self.centre.iter().zip(radii).map(with).collect() })
    }

    /// The first part of a step as a step of its own.
    pub(crate) fn shortened(&self, step: Step, h: f64) -> Result<Step, Fault> {
        let across = step.tube.slopes.transition(Interval::exactly(h)?)?;
        let transition = self.transition(&step.tube, &across, h)?;
        Ok(Step { h, transition, ..step })
    }

    /// The range of a watched quantity during a part of a step; a closer look is taken where it leaves its limits.
    fn watched(&self, step: &Step, tape: &Tape, limits: Interval, t: Interval, depth: u32) -> Enclosure {
        let whole = self.space.range(&values(&self.space, tape, &self.states(step, t)?)?[0])?;
        if depth == 0 || (limits.low() <= whole.low() && whole.high() <= limits.high()) {
            return Ok(whole);
        }
        let middle = t.midpoint();
        let first = self.watched(step, tape, limits, Interval::new(t.low(), middle)?, depth - 1)?;
        first.hull(self.watched(step, tape, limits, Interval::new(middle, t.high())?, depth - 1)?)
    }

    /// Move the set to the end of the step.
    pub(crate) fn land(&mut self, step: &Step) -> Result<(), Fault> {
        let order = self.settings.order;
        let h = Interval::exactly(step.h)?;
        let powers: Vec<Interval> = (0..=order as i32).map(|i| h.powi(i)).collect::<Result<_, _>>()?;
        let last = h.powi(order as i32 + 1)?;
        let (mut centre, mut radii) = (Vec::new(), Vec::new());
        for (series, lagrange) in step.series.iter().zip(&step.tube.lagrange) {
            let model = self.space.combination(series, &powers)?;
            let model = self.space.shifted(&model, last.mul(*lagrange)?)?;
            radii.push(model.radius);
            centre.push(self.space.polynomial(&model));
        }
        self.errors = self.errors.moved(&self.linear, &step.transition, &radii)?;
        self.centre = centre;
        Ok(())
    }
}

fn ranges(space: &Space, models: &[Model]) -> Result<Vec<Interval>, Fault> {
    models.iter().map(|m| space.range(m)).collect()
}

/// The value of a polynomial with interval coefficients.
fn horner(coefficients: &[Interval], t: Interval) -> Enclosure {
    coefficients.iter().rev().try_fold(Interval::ZERO, |sum, c| sum.mul(t)?.add(*c))
}

/// The interval, widened on each side by a share of its width and a little more.
fn inflated(x: Interval, share: f64) -> Enclosure {
    let extra = x.width()? * share + x.norm() * 1e-12 + 1e-30;
    x.add(Interval::symmetric(extra)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::series::Op;

    fn interval(low: f64, high: f64) -> Interval {
        Interval::new(low, high).expect("ends in order")
    }

    fn settings(degree: usize) -> Settings {
        Settings {
            order: 8,
            degree,
            tolerance: 1e-8,
            first_step: 0.05,
            longest_step: 1.0,
            least_step: 1e-9,
            steps: 2000,
            depth: 3,
        }
    }

    fn follow(ops: Vec<Op>, outputs: Vec<usize>, start: &[Interval], horizon: f64, degree: usize) -> Pipe {
        let field = Tape::validated(ops, outputs, start.len()).expect("a tape");
        let horizon = Interval::exactly(horizon).expect("finite");
        flowpipe(&field, start, horizon, &[], &settings(degree)).expect("a flowpipe")
    }

    fn assert_around(found: Interval, low: f64, high: f64, slack: f64) {
        assert!(found.low() <= low && high <= found.high(), "{found:?} does not hold [{low}, {high}]");
        assert!(low - found.low() <= slack && found.high() - high <= slack, "{found:?} is far from [{low}, {high}]");
    }

    #[test]
    fn decay_keeps_the_ends_of_its_box() {
        let pipe = follow(vec![Op::Variable(0), Op::Neg(0)], vec![1], &[interval(1.0, 2.0)], 3.0, 1);
        assert_eq!(pipe.end, End::Horizon);
        assert_around(pipe.last.expect("it arrives")[0], (-3.0f64).exp(), 2.0 * (-3.0f64).exp(), 1e-6);
    }

    #[test]
    fn a_full_turn_of_an_oscillator_comes_back() {
        let ops = vec![Op::Variable(0), Op::Variable(1), Op::Neg(0)];
        let start = [interval(0.9, 1.1), interval(-0.1, 0.1)];
        let pipe = follow(ops, vec![1, 2], &start, std::f64::consts::TAU, 1);
        let last = pipe.last.expect("it arrives");
        assert_around(last[0], 0.9 + 1e-12, 1.1 - 1e-12, 1e-5);
        assert_around(last[1], -0.1 + 1e-12, 0.1 - 1e-12, 1e-5);
    }

    #[test]
    fn states_during_a_step_are_inside_its_box() {
        let square = vec![Op::Variable(0), Op::Mul(0, 0)];
        let pipe = follow(square, vec![1], &[interval(0.4, 0.5)], 1.0, 3);
        for s in &pipe.segments {
            for part in 0..=4 {
                let t = (s.from.low() + s.step * f64::from(part) / 4.0).min(1.0);
                for x in [0.4, 0.45, 0.5] {
                    assert!(s.states[0].contains(x / (1.0 - x * t)), "t {t}, x {x}: {:?}", s.states[0]);
                }
            }
        }
    }

    #[test]
    fn a_number_that_is_no_float_stays_inside() {
        let tenth = crate::ratio::enclose(&1.into(), &10.into()).expect("finite");
        let pipe = follow(vec![Op::Variable(0), Op::Neg(0)], vec![1], &[tenth], 1.0, 1);
        let last = pipe.last.expect("it arrives")[0];
        assert_around(last, 0.1 * (-1.0f64).exp(), 0.1 * (-1.0f64).exp(), 1e-7);
        assert!(last.width().expect("finite") > 0.0);
    }

    #[test]
    fn finite_escape_is_reported_where_it_happens() {
        let square = vec![Op::Variable(0), Op::Mul(0, 0)];
        let pipe = follow(square, vec![1], &[interval(1.0, 1.0)], 2.0, 1);
        assert_ne!(pipe.end, End::Horizon);
        let reached = pipe.segments.last().expect("some steps").from.low();
        assert!(0.9 < reached && reached < 1.0);
        assert!(pipe.last.is_none());
    }

    #[test]
    fn a_field_that_is_undefined_at_the_start_has_no_step() {
        let ops = vec![Op::Variable(0), Op::Constant(interval(1.0, 1.0)), Op::Div(1, 0)];
        let pipe = follow(ops, vec![2], &[interval(-1.0, 1.0)], 1.0, 2);
        assert!(matches!(pipe.end, End::Stopped(_)) && pipe.segments.is_empty());
    }

    #[test]
    fn what_is_watched_is_looked_at_closely_near_its_limit() {
        let field = Tape::validated(vec![Op::Variable(0), Op::Neg(0)], vec![1], 1).expect("a tape");
        let watch = Tape::validated(vec![Op::Variable(0)], vec![0], 1).expect("a tape");
        let greatest = |limit: f64| {
            let watched = [(watch.clone(), interval(-1e9, limit))];
            let pipe =
                flowpipe(&field, &[interval(1.0, 2.0)], interval(1.0, 1.0), &watched, &settings(1)).expect("a pipe");
            pipe.segments.iter().map(|s| s.watched[0].high()).fold(f64::MIN, f64::max)
        };
        assert!(greatest(2.0) <= greatest(1e9) && greatest(2.0) >= 2.0);
    }
}
