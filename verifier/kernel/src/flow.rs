//! A set on its way along `x' = f(x)`: Taylor series in time over Taylor models of the initial set.
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
use crate::flowpipe::Settings;
use crate::halt::allowed;
use crate::inputs::Inputs;
use crate::interval::{Enclosure, Interval};
use crate::matrix::Matrix;
use crate::models::{raised, Model, Space};
use crate::path::Path;
use crate::series::{values, Ring, Tape};
use crate::sets::Set;
use crate::stiff::Stiff;
use crate::sweep::Sweep;
use std::cell::RefCell;
use std::ops::{Add, Mul};
use std::sync::Arc;

/// The order to which the transition of errors over a step is expanded, and its degree in the set variables.
const VARIATION: usize = 4;
const LINEAR: usize = 1;
/// What a step may lose to a simple transition of errors, as a share of the error aimed at.
const LOSS: f64 = 0.1;
/// Terms of the series that are a smaller part of the tolerance than this may be kept as errors.
const SHARE: f64 = 1e-3;
/// How much a step may be longer than the one before.
const GROWTH: f64 = 3.0;
/// A step is made anew where a length below this share of its own is found to be right.
const TOO_LONG: f64 = 0.6;
/// How often an a-priori tube is tried for one length of step.
const ATTEMPTS: usize = 4;

/// What holds during a whole step: the slopes of the field, all states.
pub(crate) struct Tube {
    slopes: Matrix,
    pub(crate) states: Vec<Model>,
    /// How the slopes alone move errors to the end of the step.
    across: Matrix,
    /// Bounds of what inputs have done by any of its instants.
    pushed: Vec<f64>,
}

/// What became of looking for a tube.
enum Tried {
    /// With the last term of the series, and bounds of the moved errors, what inputs do included.
    Found(Tube, Vec<Interval>, Vec<f64>),
    /// The last term of the series is this much too large (a factor for the step).
    TooLong(f64),
}

/// One validated step: the series at its start, what holds during it, how errors move to its end.
pub(crate) struct Step {
    pub(crate) h: f64,
    pub(crate) path: Path,
    pub(crate) tube: Tube,
    transition: Vec<Vec<Model>>,
    /// The set at its end, where that is known without moving errors.
    landed: Option<Landed>,
}

/// The polynomials of a set and its errors.
pub(crate) struct Landed {
    pub(crate) centre: Vec<Model>,
    pub(crate) errors: Errors,
}

/// A set on its way along a field.
pub(crate) struct Flow<'a> {
    field: &'a Tape,
    inputs: Option<&'a Inputs>,
    settings: &'a Settings,
    pub(crate) space: Space,
    pub(crate) shared: Arc<Space>,
    /// The space of what errors and tubes need.
    pub(crate) linear: Space,
    pub(crate) centre: Vec<Model>,
    pub(crate) errors: Errors,
    sweeps: RefCell<Sweeps>,
    stiff: Stiff,
}

/// Room for the series that a step computes: of the set, over a tube, and of its start with errors.
struct Sweeps {
    series: Sweep,
    tube: Sweep,
    start: Sweep,
    /// How far errors and the last term went in the step before, where the next tube is looked for.
    before: Option<(Matrix, Vec<f64>)>,
}

impl Step {
    /// A step whose end is known.
    pub(crate) fn landed(path: Path, slopes: Matrix, states: Vec<Model>, landed: Landed) -> Step {
        let n = states.len();
        let tube = Tube { slopes, states, across: Matrix::identity(n), pushed: vec![0.0; n] };
        Step { h: path.h, path, tube, transition: Vec::new(), landed: Some(landed) }
    }

    /// The series in time by variable: coefficients that are models of the set.
    pub(crate) fn series(&self) -> &[Vec<Model>] {
        &self.path.series
    }
}

impl<'a> Flow<'a> {
    /// From the polynomials of a set; their radii are errors.
    pub(crate) fn new(field: &'a Tape, start: Set, settings: &'a Settings) -> Flow<'a> {
        let Set { space, models } = start;
        let linear = Space::new(space.variables, LINEAR.min(space.degree));
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
        let stiff = Stiff::default();
        Flow { field, inputs: None, settings, space, shared: whole, linear, centre, errors, sweeps, stiff }
    }

    /// The same with inputs, of which the field has the middle.
    pub(crate) fn with_inputs(self, inputs: Option<&'a Inputs>) -> Flow<'a> {
        Flow { inputs, ..self }
    }

    /// The rates at some states, for all inputs.
    pub(crate) fn speeds(&self, space: &Space, states: &[Model]) -> Result<Vec<Model>, Fault> {
        let mut found = values(space, self.field, states)?;
        if let Some(inputs) = self.inputs {
            for (rate, more) in found.iter_mut().zip(inputs.spread(space, states, |m| space.range(m))?) {
                rate.radius = if more == 0.0 { rate.radius } else { raised(rate.radius + more) };
            }
        }
        Ok(found)
    }

    /// What inputs add to errors within a time h, while the states are in a tube: with one more variable, which stays 1,
    /// they are a slope of the rates by it.
    fn pushed(&self, states: &[Model], slopes: &Matrix, h: f64) -> Result<Vec<f64>, Fault> {
        let Some(inputs) = self.inputs else { return Ok(vec![0.0; states.len()]) };
        let spread = inputs.spread(&self.linear, states, |m| self.linear.range(m))?;
        let n = states.len();
        let wide = Matrix::from_fn(n + 1, |i, j| match (i, j) {
            (i, j) if i < n && j < n => slopes.entry(i, j),
            (i, _) if i < n => Interval::exactly(spread[i]),
            _ => Ok(Interval::ZERO),
        })?;
        let one: Vec<f64> = (0..=n).map(|v| if v == n { 1.0 } else { 0.0 }).collect();
        let mut found = wide.growth(h, &one).ok_or(Fault::Overflow)?;
        found.truncate(n);
        Ok(found)
    }

    /// A step of at most `wanted`, and the length to try next.
    pub(crate) fn step(&self, wanted: f64) -> Result<(Step, f64), Fault> {
        allowed()?;
        if let Some(found) = self.stiff.step(self, wanted) {
            return Ok(found);
        }
        let (step, next) = self.explicit(wanted)?;
        let next = if self.is_point() { self.stiff.after(step.h, &step.tube.slopes, next) } else { next };
        Ok((step, next.min(self.settings.longest_step)))
    }

    /// Whether the set is one point, errors aside, and no inputs move it.
    fn is_point(&self) -> bool {
        self.space.variables == 0 && self.inputs.is_none()
    }

    fn explicit(&self, wanted: f64) -> Result<(Step, f64), Fault> {
        // What is left before the horizon may be shorter than any step should be.
        let least_step = self.settings.least_step.min(wanted);
        let series = self.series(wanted)?;
        let known: Vec<Vec<Interval>> =
            (0..series.len()).map(|v| self.known(v, &series[v])).collect::<Result<_, _>>()?;
        let (mut h, mut growth) = (wanted.min(self.foreseen(&known)).max(least_step), GROWTH);
        while h >= least_step {
            let tried = self.tube(&known, h);
            let may_shrink = h > 2.0 * least_step;
            let (tube, lagrange, moved) = match tried {
                Ok(Tried::Found(tube, lagrange, moved)) => (tube, lagrange, moved),
                Ok(Tried::TooLong(factor)) if may_shrink => {
                    h *= factor.max(0.2);
                    continue;
                }
                _ => {
                    h *= if growth > 1.0 { 0.7 } else { 0.5 };
                    growth = 1.0;
                    continue;
                }
            };
            let factor = self.share(&lagrange, h);
            if factor < TOO_LONG && may_shrink {
                h *= factor.max(0.2);
                continue;
            }
            let transition = self.transition(&tube, &tube.across, h)?;
            let path = Path { h, space: self.shared.clone(), series: Arc::new(series), lagrange, moved };
            return Ok((
                Step { h, path, tube, transition, landed: None },
                (h * factor.clamp(0.3, growth)).max(self.settings.least_step).min(self.settings.longest_step),
            ));
        }
        Err(Fault::Step)
    }

    /// The step for which the last terms known would be as small as they should, or more.
    fn foreseen(&self, known: &[Vec<Interval>]) -> f64 {
        let Settings { order, tolerance, .. } = *self.settings;
        let with = |k: usize| {
            let size = known.iter().map(|x| x[k].norm()).fold(0.0, f64::max);
            (tolerance / size).powf(1.0 / k as f64)
        };
        let found = (order.saturating_sub(1).max(1)..=order).map(with).fold(f64::INFINITY, f64::min);
        if found.is_nan() {
            f64::INFINITY
        } else {
            found
        }
    }

    /// How much longer a step may be, given its last term.
    fn share(&self, lagrange: &[Interval], h: f64) -> f64 {
        let Settings { order, tolerance, .. } = *self.settings;
        let last = lagrange.iter().map(|l| l.norm()).fold(0.0, f64::max) * h.powi(order as i32 + 1);
        0.9 * (tolerance / last).powf(1.0 / (order + 1) as f64)
    }

    /// A tube that no solution from the set leaves before `h`.
    fn tube(&self, series: &[Vec<Interval>], h: f64) -> Result<Tried, Fault> {
        let order = self.settings.order;
        let span = Interval::new(0.0, h)?;
        let power = span.powi(order as i32 + 1)?;
        let errors = self.errors.radii(series.len());
        let motion: Vec<Interval> =
            series.iter().map(|r| horner(&r[1..], span)?.mul(span)).collect::<Result<_, _>>()?;
        let mut added = self.guess(&motion, &errors, power, h)?;
        for _ in 0..ATTEMPTS {
            let states = self.around(&added)?;
            let (lagrange, slopes) = self.swept(&states)?;
            let pushed = self.pushed(&states, &slopes, h)?;
            let moved = slopes.growth(h, &errors).ok_or(Fault::Overflow)?;
            let with = |(m, p): (f64, &f64)| if *p == 0.0 { m } else { raised(m + p) };
            let moved: Vec<f64> = moved.into_iter().zip(&pushed).map(with).collect();
            let mut landed = Vec::with_capacity(motion.len());
            for v in 0..motion.len() {
                landed.push(motion[v].add(power.mul(lagrange[v])?)?.add(Interval::symmetric(moved[v])?)?);
            }
            if added.iter().zip(&landed).all(|(m, l)| m.holds_inside(*l)) {
                let far = lagrange.iter().map(|l| l.norm()).collect();
                let across = slopes.transition(Interval::exactly(h)?)?;
                self.sweeps.borrow_mut().before = Some((slopes.clone(), far));
                let tube = Tube { slopes, states: self.around(&landed)?, across, pushed };
                return Ok(Tried::Found(tube, lagrange, moved));
            }
            let factor = self.share(&lagrange, h);
            if factor < TOO_LONG {
                return Ok(Tried::TooLong(factor));
            }
            let wider = added.iter().zip(&landed).map(|(m, l)| inflated(m.hull(*l)?, 0.1));
            added = wider.collect::<Result<_, _>>()?;
        }
        Err(Fault::Step)
    }

    /// Where a tube may be: around the motion of the series, with room for errors and the last term.
    fn guess(&self, motion: &[Interval], errors: &[f64], power: Interval, h: f64) -> Result<Vec<Interval>, Fault> {
        let sweeps = self.sweeps.borrow();
        let before = sweeps.before.as_ref().and_then(|(slopes, far)| Some((slopes.growth(h, errors)?, far)));
        let room: Vec<f64> = match before {
            Some((moved, far)) => moved.iter().zip(far).map(|(e, l)| 1.2 * e + 1.5 * l * power.high()).collect(),
            None => errors.iter().map(|e| 2.0 * e).collect(),
        };
        let wide =
            |(m, r): (&Interval, &f64)| inflated(m.add(Interval::symmetric(r.max(self.settings.tolerance))?)?, 0.01);
        motion.iter().zip(&room).map(wide).collect()
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
        let along = tube.slopes.transition(Interval::new(0.0, h)?)?;
        let rest = last.product(&along).scaled(step.powi(VARIATION as i32 + 1)?);
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
        step.path.states(t, usize::MAX, &[])
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
        if step.landed.is_some() {
            return self.implicit(self.stiff.points(self.settings.order), h).map(|(step, _)| step);
        }
        let across = step.tube.slopes.transition(Interval::exactly(h)?)?;
        let transition = self.transition(&step.tube, &across, h)?;
        Ok(Step { h, transition, path: Path { h, ..step.path }, ..step })
    }

    /// Move the set to the end of the step.
    pub(crate) fn land(&mut self, step: &Step) -> Result<(), Fault> {
        if let Some(Landed { centre, errors }) = &step.landed {
            (self.centre, self.errors) = (centre.clone(), errors.clone());
            self.sweeps.borrow_mut().before = None;
            return Ok(());
        }
        let order = self.settings.order;
        let h = Interval::exactly(step.h)?;
        let powers: Vec<Interval> = (0..=order as i32).map(|i| h.powi(i)).collect::<Result<_, _>>()?;
        let last = h.powi(order as i32 + 1)?;
        let (mut centre, mut radii) = (Vec::new(), Vec::new());
        for ((series, lagrange), pushed) in step.path.series.iter().zip(&step.path.lagrange).zip(&step.tube.pushed) {
            let model = self.space.combination(series, &powers)?;
            let model = self.space.shifted(&model, last.mul(*lagrange)?)?;
            radii.push(if *pushed == 0.0 { model.radius } else { raised(model.radius + pushed) });
            centre.push(self.space.polynomial(&model));
        }
        self.errors = self.errors.moved(&self.linear, &step.transition, &radii)?;
        self.centre = centre;
        Ok(())
    }
}

pub(crate) fn ranges(space: &Space, models: &[Model]) -> Result<Vec<Interval>, Fault> {
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
