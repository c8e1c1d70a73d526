//! Where the flow carries a quantity through zero: the instant as a Taylor model in the set variables.
//!
//! On a step whose series is `x(t, z)`, the quantity `g` crosses zero transversally where its rate along the flow keeps
//! one sign. Newton's iteration in polynomials gives `tau(z)`; how far it is from the true instant follows from the mean
//! value theorem: the greatest `|g(x(tau(z), z))|`, errors of the flow included, over the least `|g'|` on the way.

use crate::duals::jacobian;
use crate::fault::Fault;
use crate::flowpipe::{Flow, Step};
use crate::interval::{Enclosure, Interval};
use crate::models::{raised, Model, Space};
use crate::series::{values, Function, IntervalRing, Ring, Tape};

/// A transversal crossing of a whole set.
pub(crate) struct Crossing {
    /// The instant after the start of the step, its error in the radius.
    pub(crate) instant: Model,
    /// The states there.
    pub(crate) states: Vec<Model>,
}

/// How often an interval of time is halved to show the sign of a rate.
const LOOKS: u32 = 5;
/// Rounds of Newton's iteration: each doubles the degree that is right.
const ROUNDS: usize = 4;
/// How often the rate is looked at, each time farther beyond the instants found.
const REACHES: usize = 2;

/// The rate of a quantity along a field, inputs in the middle.
fn rate(space: &Space, quantity: &Tape, field: &Tape, at: &[Model]) -> Result<Model, Fault> {
    let slopes = jacobian(space, quantity, at)?.swap_remove(0);
    let speeds = values(space, field, at)?;
    space.sum(slopes.iter().zip(&speeds).map(|(s, v)| (1.0, s, v)))
}

impl Flow<'_> {
    /// The range of a quantity's rate during a part of the step.
    fn rate_during(&self, step: &Step, quantity: &Tape, t: Interval) -> Enclosure {
        let states = self.states(step, t)?;
        let slopes = jacobian(&self.space, quantity, &states)?.swap_remove(0);
        let speeds = self.speeds(&self.space, &states)?;
        self.space.range(&self.space.sum(slopes.iter().zip(&speeds).map(|(s, v)| (1.0, s, v)))?)
    }

    /// The least magnitude of a quantity's rate during a part of the step, if it has the sign all the time.
    pub(crate) fn least_rate(&self, step: &Step, quantity: &Tape, t: Interval, is_rising: bool) -> Option<f64> {
        self.least(step, quantity, t, is_rising, LOOKS)
    }

    fn least(&self, step: &Step, quantity: &Tape, t: Interval, is_rising: bool, depth: u32) -> Option<f64> {
        if let Ok(found) = self.rate_during(step, quantity, t) {
            let least = if is_rising { found.low() } else { -found.high() };
            if least > 0.0 {
                return Some(least);
            }
        }
        if depth == 0 {
            return None;
        }
        let middle = t.midpoint();
        let first = self.least(step, quantity, Interval::new(t.low(), middle).ok()?, is_rising, depth - 1)?;
        let second = self.least(step, quantity, Interval::new(middle, t.high()).ok()?, is_rising, depth - 1)?;
        Some(first.min(second))
    }

    /// The crossing of a quantity that has not been beyond zero before the step, if the whole set makes it within the
    /// step, and its rate has one sign until then.
    pub(crate) fn crossing(&self, step: &Step, quantity: &Tape, is_rising: bool) -> Result<Option<Crossing>, Fault> {
        let Some(first) = self.root(step, quantity, is_rising, step.h) else { return Ok(None) };
        let Some(instant) = self.refined(step, quantity, first) else { return Ok(None) };
        let reached = self.space.range(&instant)?;
        if reached.low() < 0.0 || reached.high() > step.h {
            return Ok(None);
        }
        let states = step.path.states_at(&instant, usize::MAX, &[])?;
        let defect = self.space.range(&values(&self.space, quantity, &states)?[0])?.norm();
        let Some((error, until)) = self.apart(step, quantity, is_rising, reached.high(), defect)? else {
            return Ok(None);
        };
        let window = Interval::new((reached.low() - raised(error)).next_down().max(0.0), until)?;
        let speeds = self.speeds(&self.space, &self.states(step, window)?)?;
        let mut moved = Vec::with_capacity(states.len());
        for (state, speed) in states.iter().zip(&speeds) {
            let extra = raised(self.space.range(speed)?.norm() * error);
            let radius = if error == 0.0 { state.radius } else { raised(state.radius + extra) };
            moved.push(Model { coefficients: state.coefficients.clone(), radius });
        }
        let instant = Model { coefficients: instant.coefficients, radius: error };
        Ok(Some(Crossing { instant, states: moved }))
    }

    /// How far the true instants are from those found, of which this is the last, and an instant of the step after all of
    /// them up to which the rate has one sign: what lies beyond is looked at no further than needed.
    fn apart(
        &self,
        step: &Step,
        quantity: &Tape,
        is_rising: bool,
        last: f64,
        defect: f64,
    ) -> Result<Option<(f64, f64)>, Fault> {
        let mut beyond = 0.01 * step.h;
        for _ in 0..REACHES {
            let until = (last + beyond).min(step.h);
            let Some(least) = self.least_rate(step, quantity, Interval::new(0.0, until)?, is_rising) else {
                return Ok(None);
            };
            let error = if defect == 0.0 { 0.0 } else { raised(raised(defect) / least) };
            if (last + raised(error)).next_up() <= until {
                return Ok(Some((error, until)));
            }
            beyond = 1.5 * error;
        }
        Ok(None)
    }

    /// About when the states of the set make a crossing, which may be after the step; nothing depends on it being right.
    pub(crate) fn approach(&self, step: &Step, quantity: &Tape, is_rising: bool) -> Option<Model> {
        let ends = [1.0, 2.0, 4.0, 8.0, 16.0, 32.0].map(|factor| factor * step.h);
        let first = ends.into_iter().find_map(|end| self.root(step, quantity, is_rising, end))?;
        self.refined(step, quantity, first)
    }

    /// An instant before `end` near the root of the run from the middle of the set; nothing depends on its precision.
    fn root(&self, step: &Step, quantity: &Tape, is_rising: bool, end: f64) -> Option<f64> {
        let sign = if is_rising { 1.0 } else { -1.0 };
        let at = |t: f64| -> Option<f64> {
            let value = |series: &Vec<Model>| series.iter().rev().fold(0.0, |sum, m| sum * t + m.coefficients[0]);
            let state: Vec<Interval> =
                step.series().iter().map(|s| Interval::exactly(value(s))).collect::<Result<_, _>>().ok()?;
            Some(sign * values(&IntervalRing, quantity, &state).ok()?[0].midpoint())
        };
        let (mut low, mut high) = (0.0, end);
        if at(high)? < 0.0 {
            return None;
        }
        for _ in 0..40 {
            let middle = 0.5 * (low + high);
            if at(middle)? < 0.0 {
                low = middle;
            } else {
                high = middle;
            }
        }
        Some(high)
    }

    /// Newton's iteration for the instant as a polynomial; `None` where it has no sense.
    fn refined(&self, step: &Step, quantity: &Tape, first: f64) -> Option<Model> {
        let space = &self.space;
        let mut instant = space.number(first);
        for _ in 0..ROUNDS {
            let states: Vec<Model> =
                step.series().iter().map(|s| self.along(s, &instant)).collect::<Result<_, _>>().ok()?;
            let value = values(space, quantity, &states).ok()?.swap_remove(0);
            let slope = rate(space, quantity, self.field(), &states).ok()?;
            let inverse = space.apply(Function::Reciprocal, &slope).ok()?;
            let change = space.mul(&value, &inverse).ok()?;
            instant = space.polynomial(&space.sub(&instant, &change).ok()?);
        }
        Some(instant)
    }

    /// A series at an instant that depends on the set variables, by Horner's scheme.
    fn along(&self, series: &[Model], t: &Model) -> Result<Model, Fault> {
        let (highest, rest) = series.split_last().ok_or(Fault::Unknown)?;
        rest.iter()
            .rev()
            .try_fold(highest.clone(), |sum, coefficient| self.space.add(&self.space.mul(&sum, t)?, coefficient))
    }
}
