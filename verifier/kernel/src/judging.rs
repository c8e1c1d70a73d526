//! What a step shows of the claim and of the window, by parts of it.

use crate::condition::Comparison;
use crate::fault::Fault;
use crate::flowpipe::Step;
use crate::hybrid::{Judgement, Segment, Taken};
use crate::interval::{Enclosure, Interval};
use crate::models::Model;
use crate::series::{jacobian, values, IntervalRing, Op, Ring, Tape};
use crate::walk::{judged, kept, Clock, Walk};

impl Walk<'_> {
    /// Judge the claim and the window during a step, and keep what was seen.
    pub(crate) fn record(&mut self, step: &Step, clock: &Clock, depth: u32) -> Result<(), Fault> {
        let states = self.states(step, clock, 0.0, 1.0)?;
        let hull: Vec<Interval> = states.iter().map(|m| self.flow.space.range(m)).collect::<Result<_, _>>()?;
        let time = *hull.last().ok_or(Fault::Unknown)?;
        let mut look = Look { claim: judged(None, time, false), keeps_window: true, stays: true, watched: None };
        (look.claim.holds, look.claim.fails) = (true, true);
        self.look(step, clock, (0.0, 1.0), depth, &mut look)?;
        if self.may_be_over(clock)? {
            (look.claim.met, look.claim.violated) = (None, None);
        }
        let watched = look.watched.unwrap_or_default();
        let Look { keeps_window, stays, .. } = look;
        self.stretch.is_certain &= stays;
        let exponents = self.flow.space.exponents.clone();
        let taken = Taken { h: step.h, exponents, series: step.series().to_vec() };
        self.stretch.segments.push(Segment {
            taken,
            time,
            states: hull,
            watched,
            claim: look.claim,
            keeps_window,
            stays,
        });
        Ok(())
    }

    /// Whether the stretch may have no length: it then has no instant but that of its landing, at which other things hold.
    fn may_be_over(&self, clock: &Clock) -> Result<bool, Fault> {
        let Clock::Until(event) = clock else { return Ok(false) };
        Ok(self.stretch.segments.is_empty() && self.flow.space.range(event.instant)?.low() <= 0.0)
    }

    fn look(&self, step: &Step, clock: &Clock, part: (f64, f64), depth: u32, seen: &mut Look) -> Result<(), Fault> {
        let states = self.states(step, clock, part.0, part.1)?;
        let Some(watched) = self.watched_until(&states, clock)? else { return Ok(()) };
        // Where the domain holds nowhere there is no run to judge.
        let Some(mut known) = kept(&self.mode.domain, &watched) else { return Ok(()) };
        if part.0 == 0.0 && self.stretch.segments.is_empty() && !self.known.is_empty() {
            self.add_known(&states, &mut known);
        }
        let (claim, window) = (self.mode.claim.truth(&known), self.mode.window.truth(&known));
        let rest = self.mode.rest.truth(&known);
        if rest == Some(false) {
            seen.stays = false;
            return Ok(());
        }
        if (claim.is_none() || window != Some(true) || rest.is_none()) && depth > 0 {
            let middle = 0.5 * (part.0 + part.1);
            self.look(step, clock, (part.0, middle), depth - 1, seen)?;
            return self.look(step, clock, (middle, part.1), depth - 1, seen);
        }
        let time = self.flow.space.range(states.last().ok_or(Fault::Unknown)?)?;
        let raw = self.mode.claim.truth(&watched);
        seen.stays &= rest == Some(true);
        let is_certain = self.stretch.is_certain && seen.stays && raw == claim && window == Some(true);
        seen.add(judged(claim, time, is_certain), window == Some(true), known)
    }
}

impl Walk<'_> {
    /// Use that what holds where the stretch starts goes on to hold while its quantity moves away from zero.
    fn add_known(&self, states: &[Model], values: &mut [Interval]) {
        let Ok(mut inside) = states.iter().map(|m| self.flow.space.range(m)).collect::<Result<Vec<_>, _>>() else {
            return;
        };
        for &(at, comparison) in &self.mode.domain {
            if let Op::Variable(v) = self.mode.watch.ops[self.mode.watch.outputs[at]] {
                inside[v] = comparison.keep(inside[v]).unwrap_or(inside[v]);
            }
        }
        self.keep_below_the_start(&mut inside);
        for &(at, comparison) in &self.known {
            let rate = interval_rate(&self.quantity(at), &self.mode.field, &inside);
            let goes_away = rate.is_ok_and(|rate| match comparison {
                Comparison::AtMost => rate.high() <= 0.0,
                Comparison::AtLeast => rate.low() >= 0.0,
                _ => false,
            });
            if goes_away {
                values[at] = comparison.keep(values[at]).unwrap_or(values[at]);
            }
        }
    }
}

impl Walk<'_> {
    /// Cut a box of states since the start where variables only fall, or only rise: twice, as one helps the other.
    fn keep_below_the_start(&self, inside: &mut [Interval]) {
        for _ in 0..2 {
            let Ok(speeds) = values(&IntervalRing, &self.mode.field, inside) else { return };
            for ((x, speed), side) in inside.iter_mut().zip(speeds).zip(&self.sides) {
                let low = if speed.low() >= 0.0 { x.low().max(side.low()) } else { x.low() };
                let high = if speed.high() <= 0.0 { x.high().min(side.high()) } else { x.high() };
                *x = Interval::new(low, high).unwrap_or(*x);
            }
        }
    }
}

/// The range of a quantity's rate along a field, for states in a box.
fn interval_rate(quantity: &Tape, field: &Tape, states: &[Interval]) -> Enclosure {
    let slopes = jacobian(&IntervalRing, quantity, states)?.swap_remove(0);
    let speeds = values(&IntervalRing, field, states)?;
    IntervalRing.sum(slopes.iter().zip(&speeds).map(|(s, v)| (1.0, s, v)))
}

/// What was seen of the parts of a step so far.
struct Look {
    claim: Judgement,
    keeps_window: bool,
    /// Whether what else the domain says holds so far.
    stays: bool,
    watched: Option<Vec<Interval>>,
}

impl Look {
    fn add(&mut self, claim: Judgement, keeps_window: bool, watched: Vec<Interval>) -> Result<(), Fault> {
        self.claim.holds &= claim.holds;
        self.claim.fails &= claim.fails;
        self.claim.met = self.claim.met.or(claim.met);
        self.claim.violated = self.claim.violated.or(claim.violated);
        self.keeps_window &= keeps_window;
        self.watched = Some(match self.watched.take() {
            None => watched,
            Some(known) => known.iter().zip(&watched).map(|(a, b)| a.hull(*b)).collect::<Result<_, _>>()?,
        });
        Ok(())
    }
}
