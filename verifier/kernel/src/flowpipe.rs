//! Validated flowpipes of `x' = f(x)`: steps from a box to a horizon, and the ranges of watched quantities on the way.

use crate::fault::Fault;
use crate::flow::ranges;
pub(crate) use crate::flow::{Flow, Step};
use crate::interval::{Enclosure, Interval};
use crate::series::{values, Tape};
use crate::sets::Set;
use std::ops::{Add, Mul, Sub};

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

impl Flow<'_> {
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
        let watched =
            watch.iter().map(|(tape, limits)| self.watched(&step, tape, *limits, taken, self.settings().depth));
        let watched = watched.collect::<Result<_, _>>()?;
        let states = ranges(&self.linear, &step.tube.states)?;
        pipe.segments.push(Segment { from: time, step: step.h, states, watched });
        let after = time.add(Interval::exactly(step.h)?)?;
        let arrived = if after.high() >= horizon.low() {
            let first = (horizon.low() - time.high()).next_down().clamp(0.0, step.h);
            let last = (horizon.high() - time.low()).next_up().clamp(first, step.h);
            let instants = Interval::new(first, last)?;
            Some((instants, ranges(&self.space, &self.states(&step, instants)?)?))
        } else {
            None
        };
        self.land(&step)?;
        if let Some((instants, during)) = arrived {
            pipe.last = Some(self.arrived(&step, instants, &during)?);
        }
        Ok((after, next))
    }

    /// The states at some instants of the step just made: back from its end by the mean value theorem, and inside what
    /// the step itself says of them.
    pub(crate) fn arrived(&self, step: &Step, at: Interval, during: &[Interval]) -> Result<Vec<Interval>, Fault> {
        let back = at.sub(Interval::exactly(step.h)?)?;
        let rates = ranges(&self.linear, &self.speeds(&self.linear, &step.tube.states)?)?;
        let ends = self.set()?.hull()?;
        let both = ends.iter().zip(&rates).zip(during);
        both.map(|((end, rate), during)| end.add(rate.mul(back)?)?.intersection(*during)).collect()
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
    fn without_a_degree_the_box_is_all_error() {
        let pipe = follow(vec![Op::Variable(0), Op::Neg(0)], vec![1], &[interval(1.0, 2.0)], 1.0, 0);
        let last = pipe.last.expect("it arrives")[0];
        assert!(last.low() <= (-1.0f64).exp() && 2.0 * (-1.0f64).exp() <= last.high());
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
