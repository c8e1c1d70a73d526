//! One stretch of flow in a mode: what can happen in a step, what holds in it.

use crate::condition::Comparison;
use crate::fault::Fault;
use crate::flowpipe::{Flow, Step};
use crate::hybrid::{Guard, Judgement, Mode, Segment, Stretch};
use crate::interval::Interval;
use crate::models::Model;
use crate::series::{values, Ring, Tape};
use crate::sets::Set;

/// A stretch being followed.
pub(crate) struct Walk<'a> {
    pub(crate) number: usize,
    pub(crate) mode: &'a Mode,
    pub(crate) flow: Flow<'a>,
    pub(crate) stretch: Stretch,
    pub(crate) cuts: usize,
}

/// How the instants of a step depend on the set: the same for all, or up to the instant of a crossing.
pub(crate) enum Clock<'a> {
    Same(f64),
    Until(&'a Model),
}

/// Whether a comparison that holds may stop to hold where the quantity crosses zero this way.
pub(crate) fn leaves(comparison: Comparison, is_rising: bool) -> bool {
    match comparison {
        Comparison::Less | Comparison::AtMost => is_rising,
        Comparison::Greater | Comparison::AtLeast => !is_rising,
        Comparison::Equal | Comparison::Differ => true,
    }
}

/// The closed half line that a quantity is on before it crosses zero.
fn before(is_rising: bool) -> Comparison {
    if is_rising {
        Comparison::AtMost
    } else {
        Comparison::AtLeast
    }
}

/// Whether all comparisons hold for all values, one of them for none, or neither is known.
pub(crate) fn all(guard: &Guard, values: &[Interval]) -> Option<bool> {
    let mut holds = Some(true);
    for (at, comparison) in guard {
        match comparison.truth(values[*at]) {
            Some(false) => return Some(false),
            Some(true) => {}
            None => holds = None,
        }
    }
    holds
}

/// The ranges of models over the set variables.
pub(crate) fn ranges(set: &Set, models: &[Model]) -> Result<Vec<Interval>, Fault> {
    models.iter().map(|m| set.space.range(m)).collect()
}

/// The judgement on one instant or interval of which a claim has one truth.
pub(crate) fn judged(truth: Option<bool>, time: Interval, is_certain: bool) -> Judgement {
    Judgement {
        holds: truth == Some(true),
        fails: truth == Some(false),
        met: (is_certain && truth == Some(true)).then_some(time),
        violated: (is_certain && truth == Some(false)).then_some(time),
    }
}

/// What is left of watched ranges where the domain holds; `None` if it holds nowhere.
fn kept(domain: &Guard, values: &[Interval]) -> Option<Vec<Interval>> {
    let mut kept = values.to_vec();
    for (at, comparison) in domain {
        kept[*at] = comparison.keep(kept[*at])?;
    }
    Some(kept)
}

impl Walk<'_> {
    /// The time at the start of the next step.
    pub(crate) fn time(&self) -> Result<Interval, Fault> {
        self.flow.set()?.hull()?.pop().ok_or(Fault::Unknown)
    }

    /// A watched quantity alone.
    pub(crate) fn quantity(&self, at: usize) -> Tape {
        Tape { ops: self.mode.watch.ops.clone(), outputs: vec![self.mode.watch.outputs[at]] }
    }

    fn states(&self, step: &Step, clock: &Clock, from: f64, to: f64) -> Result<Vec<Model>, Fault> {
        match clock {
            Clock::Same(h) => self.flow.states(step, Interval::new(from * h, (to * h).min(step.h))?),
            Clock::Until(instant) => {
                let share = Interval::new(from, to)?;
                self.flow.states_at(step, &self.flow.space.scale(instant, share)?)
            }
        }
    }

    fn watched(&self, states: &[Model]) -> Result<Vec<Interval>, Fault> {
        let space = &self.flow.space;
        values(space, &self.mode.watch, states)?.iter().map(|m| space.range(m)).collect()
    }

    fn watched_during(&self, step: &Step, from: f64, to: f64) -> Result<Vec<Interval>, Fault> {
        self.watched(&self.flow.states(step, Interval::new(from, to)?)?)
    }

    /// Whether all states between two instants of the step are certainly in the domain.
    fn is_inside(&self, step: &Step, watched: &[Interval], from: f64, to: f64) -> bool {
        self.mode.domain.iter().all(|&(at, comparison)| {
            comparison.truth(watched[at]) == Some(true) || (from == 0.0 && self.goes_inside(step, at, comparison, to))
        })
    }

    /// Whether a state on the border of the domain certainly moves into it: runs are in the domain where the step starts.
    fn goes_inside(&self, step: &Step, at: usize, comparison: Comparison, to: f64) -> bool {
        let is_rising = match comparison {
            Comparison::Less | Comparison::AtMost => false,
            Comparison::Greater | Comparison::AtLeast => true,
            Comparison::Equal | Comparison::Differ => return false,
        };
        let Ok(span) = Interval::new(0.0, to) else { return false };
        self.flow.least_rate(step, &self.quantity(at), span, is_rising).is_some()
    }

    /// The latest instant up to which, shown by parts, runs stay in the domain and no jump is possible.
    pub(crate) fn quiet(&self, step: &Step, from: f64, to: f64, depth: u32) -> f64 {
        if self.is_quiet(step, from, to) {
            return to;
        }
        let middle = 0.5 * (from + to);
        if depth == 0 || !(from < middle && middle < to) {
            return from;
        }
        let reached = self.quiet(step, from, middle, depth - 1);
        if reached < middle {
            return reached;
        }
        self.quiet(step, middle, to, depth - 1)
    }

    fn is_quiet(&self, step: &Step, from: f64, to: f64) -> bool {
        let Ok(watched) = self.watched_during(step, from, to) else { return false };
        if !self.is_inside(step, &watched, from, to) {
            return false;
        }
        let Some(known) = kept(&self.mode.domain, &watched) else { return false };
        self.mode.edges.iter().all(|e| all(&e.guard, &known) == Some(false))
    }

    /// Whether runs certainly stay in the domain between two instants.
    pub(crate) fn stays(&self, step: &Step, from: f64, to: f64, depth: u32) -> bool {
        let Ok(watched) = self.watched_during(step, from, to) else { return false };
        let middle = 0.5 * (from + to);
        self.is_inside(step, &watched, from, to)
            || (depth > 0 && self.stays(step, from, middle, depth - 1) && self.stays(step, middle, to, depth - 1))
    }

    /// Whether an urgent edge may be due in the step.
    pub(crate) fn may_be_urgent(&self, step: &Step, depth: u32) -> Result<bool, Fault> {
        for (number, edge) in self.mode.edges.iter().enumerate() {
            if edge.is_urgent && self.possible(step, number, 0.0, step.h, depth)?.is_some() {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// An interval of time outside which an edge is not enabled in the step.
    pub(crate) fn possible(
        &self,
        step: &Step,
        number: usize,
        from: f64,
        to: f64,
        depth: u32,
    ) -> Result<Option<Interval>, Fault> {
        let watched = self.watched_during(step, from, to)?;
        let Some(known) = kept(&self.mode.domain, &watched) else { return Ok(None) };
        match all(&self.mode.edges[number].guard, &known) {
            Some(false) => return Ok(None),
            None if depth > 0 => {}
            _ => return Ok(Some(Interval::new(from, to)?)),
        }
        let middle = 0.5 * (from + to);
        let first = self.possible(step, number, from, middle, depth - 1)?;
        let second = self.possible(step, number, middle, to, depth - 1)?;
        Ok(match (first, second) {
            (Some(a), Some(b)) => Some(a.hull(b)?),
            (found, None) | (None, found) => found,
        })
    }

    /// The quantities whose crossing of zero may end the stretch, with its direction: borders of the domain first.
    pub(crate) fn events(&self) -> Vec<(usize, bool)> {
        let mut events = Vec::new();
        let mut add = |event| {
            if !events.contains(&event) {
                events.push(event);
            }
        };
        for &(at, comparison) in &self.mode.domain {
            [true, false].into_iter().filter(|&rising| leaves(comparison, rising)).for_each(|rising| add((at, rising)));
        }
        for edge in self.mode.edges.iter().filter(|e| e.is_urgent) {
            for &(at, comparison) in &edge.guard {
                let begins = |rising: bool| comparison == Comparison::Equal || !leaves(comparison, rising);
                [true, false].into_iter().filter(|&rising| begins(rising)).for_each(|rising| add((at, rising)));
            }
        }
        events
    }

    /// A longer step from the same start, for a crossing that takes more time.
    pub(crate) fn longer(&self, step: &Step) -> Option<Step> {
        let longer = self.flow.step(4.0 * step.h).ok()?.0;
        (longer.h > step.h).then_some(longer)
    }

    /// Whether up to the crossing of a quantity, which is before it on one side of zero, the rest of the domain holds
    /// certainly and no jump is possible.
    pub(crate) fn is_quiet_before(
        &self,
        step: &Step,
        instant: &Model,
        quantity: usize,
        is_rising: bool,
        depth: u32,
    ) -> Result<bool, Fault> {
        let parts = 1u32 << depth.min(4);
        let clock = Clock::Until(instant);
        let start = self.watched_during(step, 0.0, 0.0)?;
        if before(is_rising).truth(start[quantity]) != Some(true) && !self.starts_inside(quantity, is_rising) {
            return Ok(false);
        }
        for part in 0..parts {
            let (from, to) = (f64::from(part) / f64::from(parts), f64::from(part + 1) / f64::from(parts));
            let watched = self.watched(&self.states(step, &clock, from, to)?)?;
            let until = self.flow.space.range(instant)?.high().min(step.h) * to;
            let others = self.mode.domain.iter().filter(|(at, _)| *at != quantity);
            let holds = |&(at, comparison): &(usize, Comparison)| {
                comparison.truth(watched[at]) == Some(true)
                    || (part == 0 && self.goes_inside(step, at, comparison, until.next_up().min(step.h)))
            };
            if !others.clone().all(holds) {
                return Ok(false);
            }
            let Some(mut known) = kept(&self.mode.domain, &watched) else { return Ok(false) };
            let Some(strictly) = strictly(known[quantity], is_rising) else { return Ok(false) };
            known[quantity] = strictly;
            if !self.mode.edges.iter().all(|e| all(&e.guard, &known) == Some(false)) {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Whether the domain says that the quantity starts on the side it crosses from.
    fn starts_inside(&self, quantity: usize, is_rising: bool) -> bool {
        let leaving = |&(at, comparison): &(usize, Comparison)| at == quantity && leaves(comparison, is_rising);
        self.mode.domain.iter().any(leaving)
    }

    /// The edges that may be enabled where a quantity crosses zero, and whether they are for the whole set.
    pub(crate) fn enabled(
        &self,
        states: &[Model],
        quantity: usize,
        is_rising: bool,
    ) -> Result<Vec<(usize, bool)>, Fault> {
        let watched = self.watched(states)?;
        let Some(mut known) = kept(&self.mode.domain, &watched) else { return Ok(Vec::new()) };
        known[quantity] = Interval::ZERO;
        let mut found = Vec::new();
        for (number, edge) in self.mode.edges.iter().enumerate() {
            // An urgent edge whose strict bound holds right after the crossing is due at it.
            let is_due =
                |c: Comparison| edge.is_urgent && !leaves(c, is_rising) || c == Comparison::Differ && edge.is_urgent;
            let guard: Guard =
                edge.guard.iter().filter(|(at, c)| *at != quantity || !(c.at_zero() || is_due(*c))).copied().collect();
            match all(&guard, &known) {
                Some(false) => {}
                truth => found.push((number, truth == Some(true))),
            }
        }
        Ok(found)
    }

    /// Judge the claim and the window during a step, and keep what was seen.
    pub(crate) fn record(&mut self, step: &Step, clock: &Clock, depth: u32) -> Result<(), Fault> {
        let states = self.states(step, clock, 0.0, 1.0)?;
        let hull: Vec<Interval> = states.iter().map(|m| self.flow.space.range(m)).collect::<Result<_, _>>()?;
        let time = *hull.last().ok_or(Fault::Unknown)?;
        let mut look = Look { claim: judged(None, time, false), keeps_window: true, watched: None };
        (look.claim.holds, look.claim.fails) = (true, true);
        self.look(step, clock, (0.0, 1.0), depth, &mut look)?;
        let watched = look.watched.unwrap_or_default();
        let keeps_window = look.keeps_window;
        self.stretch.segments.push(Segment { time, states: hull, watched, claim: look.claim, keeps_window });
        Ok(())
    }

    fn look(&self, step: &Step, clock: &Clock, part: (f64, f64), depth: u32, seen: &mut Look) -> Result<(), Fault> {
        let states = self.states(step, clock, part.0, part.1)?;
        let watched = self.watched(&states)?;
        // Where the domain holds nowhere there is no run to judge.
        let Some(known) = kept(&self.mode.domain, &watched) else { return Ok(()) };
        let (claim, window) = (self.mode.claim.truth(&known), self.mode.window.truth(&known));
        if (claim.is_none() || window != Some(true)) && depth > 0 {
            let middle = 0.5 * (part.0 + part.1);
            self.look(step, clock, (part.0, middle), depth - 1, seen)?;
            return self.look(step, clock, (middle, part.1), depth - 1, seen);
        }
        let time = self.flow.space.range(states.last().ok_or(Fault::Unknown)?)?;
        let raw = self.mode.claim.truth(&watched);
        let is_certain = self.stretch.is_certain && raw == claim && window == Some(true);
        seen.add(judged(claim, time, is_certain), window == Some(true), known)
    }
}

/// What was seen of the parts of a step so far.
struct Look {
    claim: Judgement,
    keeps_window: bool,
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

/// The numbers of an interval strictly on the side of zero that a crossing comes from.
fn strictly(x: Interval, is_rising: bool) -> Option<Interval> {
    let least = f64::from_bits(1);
    if is_rising {
        Interval::new(x.low().min(-least), x.high().min(-least)).ok()
    } else {
        Interval::new(x.low().max(least), x.high().max(least)).ok()
    }
}
