//! One stretch of flow in a mode: what can happen in a step, what holds in it.

use crate::condition::Comparison;
use crate::fault::Fault;
use crate::flowpipe::{Flow, Step};
use crate::hybrid::{Guard, Judgement, Mode, Segment, Stretch, Taken};
use crate::interval::{Enclosure, Interval};
use crate::models::Model;
use crate::series::{jacobian, values, IntervalRing, Op, Ring, Tape};
use crate::sets::Set;
use std::ops::Div;

/// How often the pace of a stretch may be changed.
const PACES: usize = 3;

/// A stretch being followed.
pub(crate) struct Walk<'a> {
    pub(crate) number: usize,
    pub(crate) mode: &'a Mode,
    pub(crate) flow: Flow<'a>,
    pub(crate) stretch: Stretch,
    pub(crate) cuts: usize,
    /// How often the pace of the flow was made a function of the set.
    pub(crate) paced: usize,
    /// What holds exactly where runs start, and the box they start in; nothing where the stretch is no start.
    pub(crate) known: Guard,
    pub(crate) sides: Vec<Interval>,
}

/// How the instants of a step depend on the set: the same for all, or up to the instant of a crossing.
pub(crate) enum Clock<'a> {
    Same(f64),
    Until(&'a Model),
}

/// The crossing of zero by a watched quantity, at an instant that depends on the set.
pub(crate) struct Event<'a> {
    pub(crate) quantity: usize,
    pub(crate) is_rising: bool,
    pub(crate) instant: &'a Model,
}

/// Whether a comparison that holds may stop to hold where the quantity crosses zero this way.
pub(crate) fn leaves(comparison: Comparison, is_rising: bool) -> bool {
    match comparison {
        Comparison::Less | Comparison::AtMost => is_rising,
        Comparison::Greater | Comparison::AtLeast => !is_rising,
        Comparison::Equal | Comparison::Differ => true,
    }
}

/// Whether a comparison holds right after the quantity crossed zero this way.
fn holds_beyond(comparison: Comparison, is_rising: bool) -> bool {
    match comparison {
        Comparison::Less | Comparison::AtMost => !is_rising,
        Comparison::Greater | Comparison::AtLeast => is_rising,
        Comparison::Equal => false,
        Comparison::Differ => true,
    }
}

/// What a guard asks of other quantities where `holds` says which comparisons of one are true; `None` if one is not.
fn guarded(guard: &Guard, quantity: usize, holds: impl Fn(Comparison) -> bool) -> Option<Guard> {
    let (own, others): (Guard, Guard) = guard.iter().copied().partition(|(at, _)| *at == quantity);
    own.iter().all(|&(_, c)| holds(c)).then_some(others)
}

/// Whether a guard holds at all times right after a crossing, the domain ignored (LANGUAGE S8): a quantity that may be
/// at its border at the crossing itself may move either way.
fn due_after(guard: &Guard, quantity: usize, is_rising: bool, values: &[Interval]) -> Option<bool> {
    let Some(others) = guarded(guard, quantity, |c| holds_beyond(c, is_rising)) else { return Some(false) };
    let certain: Guard = others.iter().map(|&(at, c)| (at, c.opened())).collect();
    let differs = |c: Comparison| c == Comparison::Differ;
    let possible: Guard = others.iter().filter(|(_, c)| !differs(*c)).map(|&(at, c)| (at, c.closed())).collect();
    if all(&certain, values) == Some(true) {
        Some(true)
    } else if all(&possible, values) == Some(false) {
        Some(false)
    } else {
        None
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

/// The judgement on one instant or interval of which a claim has one truth; only what is certain violates.
pub(crate) fn judged(truth: Option<bool>, time: Interval, is_certain: bool) -> Judgement {
    Judgement {
        holds: truth == Some(true),
        fails: truth == Some(false),
        met: (truth == Some(true)).then_some(time),
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
    /// The set at the start of the next step.
    pub(crate) fn set(&self) -> Result<Set, Fault> {
        let mut set = self.flow.set()?;
        set.models.truncate(self.mode.field.outputs.len());
        Ok(set)
    }

    /// The time at the start of the next step.
    pub(crate) fn time(&self) -> Result<Interval, Fault> {
        self.set()?.hull()?.pop().ok_or(Fault::Unknown)
    }

    /// Let the states of the set move at paces of their own, so that all come to the crossing of a quantity at about the
    /// same instant. Paces are further variables that do not change, after those of the state.
    pub(crate) fn pace(&mut self, step: &Step) -> Result<bool, Fault> {
        let way = self
            .events()
            .into_iter()
            .find_map(|(at, is_rising)| self.flow.approach(step, &self.quantity(at), is_rising));
        let Some(way) = way.filter(|_| self.paced < PACES) else { return Ok(false) };
        let longest = self.flow.space.range(&way)?;
        if longest.low() <= 0.0 {
            return Ok(false);
        }
        let mut set = self.set()?;
        let inverse = Interval::exactly(1.0)?.div(Interval::exactly(longest.high())?)?;
        let mut pace = set.space.scale(&way, inverse)?;
        if let Some(known) = self.flow.set()?.models.get(set.models.len()) {
            pace = set.space.mul(&pace, known)?;
        }
        set.models.push(pace);
        self.flow = Flow::new(&self.mode.paced, set, self.flow.settings());
        self.paced += 1;
        Ok(true)
    }

    /// A watched quantity alone.
    pub(crate) fn quantity(&self, at: usize) -> Tape {
        Tape { ops: self.mode.watch.ops.clone(), outputs: vec![self.mode.watch.outputs[at]] }
    }

    fn states(&self, step: &Step, clock: &Clock, from: f64, to: f64) -> Result<Vec<Model>, Fault> {
        let mut states = match clock {
            Clock::Same(h) => self.flow.states(step, Interval::new(from * h, (to * h).min(step.h))?)?,
            Clock::Until(instant) => {
                let share = Interval::new(from, to)?;
                self.flow.states_at(step, &self.flow.space.scale(instant, share)?)?
            }
        };
        states.truncate(self.mode.field.outputs.len());
        Ok(states)
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

    /// Whether up to the crossing of a quantity, which is before it on one side of zero, the rest of the domain holds
    /// certainly and none of some edges is possible.
    pub(crate) fn is_quiet_before(
        &self,
        step: &Step,
        event: &Event,
        edges: &[usize],
        depth: u32,
    ) -> Result<bool, Fault> {
        let start = self.watched_during(step, 0.0, 0.0)?;
        let is_before = before(event.is_rising).truth(start[event.quantity]) == Some(true);
        Ok((is_before || self.starts_inside(event))
            && self.is_quiet_on_the_way(step, event, edges, (0.0, 1.0), depth)?)
    }

    fn is_quiet_on_the_way(
        &self,
        step: &Step,
        event: &Event,
        edges: &[usize],
        (from, to): (f64, f64),
        depth: u32,
    ) -> Result<bool, Fault> {
        let watched = self.watched(&self.states(step, &Clock::Until(event.instant), from, to)?)?;
        let until = (self.flow.space.range(event.instant)?.high() * to).next_up().min(step.h);
        let holds = |&(at, comparison): &(usize, Comparison)| {
            at == event.quantity
                || comparison.truth(watched[at]) == Some(true)
                || (from == 0.0 && self.goes_inside(step, at, comparison, until))
        };
        if self.mode.domain.iter().all(holds) {
            let Some(known) = self.on_the_way(&watched, event) else { return Ok(false) };
            if edges.iter().all(|&e| all(&self.mode.edges[e].guard, &known) == Some(false)) {
                return Ok(true);
            }
        }
        let middle = 0.5 * (from + to);
        Ok(depth > 0
            && self.is_quiet_on_the_way(step, event, edges, (from, middle), depth - 1)?
            && self.is_quiet_on_the_way(step, event, edges, (middle, to), depth - 1)?)
    }

    /// What is left of watched ranges before a crossing.
    fn on_the_way(&self, watched: &[Interval], event: &Event) -> Option<Vec<Interval>> {
        let mut known = kept(&self.mode.domain, watched)?;
        known[event.quantity] = strictly(known[event.quantity], event.is_rising)?;
        Some(known)
    }

    /// A part of the way to a crossing outside which an edge is not enabled; `None` if it is nowhere.
    pub(crate) fn possible_before(
        &self,
        step: &Step,
        event: &Event,
        edge: usize,
        (from, to): (f64, f64),
        depth: u32,
    ) -> Result<Option<(f64, f64)>, Fault> {
        let watched = self.watched(&self.states(step, &Clock::Until(event.instant), from, to)?)?;
        let Some(known) = self.on_the_way(&watched, event) else { return Ok(None) };
        match all(&self.mode.edges[edge].guard, &known) {
            Some(false) => return Ok(None),
            None if depth > 0 => {}
            _ => return Ok(Some((from, to))),
        }
        let middle = 0.5 * (from + to);
        let first = self.possible_before(step, event, edge, (from, middle), depth - 1)?;
        let second = self.possible_before(step, event, edge, (middle, to), depth - 1)?;
        Ok(match (first, second) {
            (Some(a), Some(b)) => Some((a.0, b.1)),
            (found, None) | (None, found) => found,
        })
    }

    /// The states on a part of the way to a crossing.
    pub(crate) fn states_before(&self, step: &Step, event: &Event, part: (f64, f64)) -> Result<Set, Fault> {
        let models = self.states(step, &Clock::Until(event.instant), part.0, part.1)?;
        Ok(Set { space: self.flow.space.clone(), models })
    }

    /// Whether the domain says that the quantity starts on the side it crosses from.
    fn starts_inside(&self, event: &Event) -> bool {
        let leaving =
            |&(at, comparison): &(usize, Comparison)| at == event.quantity && leaves(comparison, event.is_rising);
        self.mode.domain.iter().any(leaving)
    }

    /// The edges that may be enabled where a quantity crosses zero, and whether they are for the whole set.
    pub(crate) fn enabled(
        &self,
        states: &[Model],
        &Event { quantity, is_rising, .. }: &Event,
    ) -> Result<Vec<(usize, bool)>, Fault> {
        let watched = self.watched(states)?;
        let Some(mut known) = kept(&self.mode.domain, &watched) else { return Ok(Vec::new()) };
        known[quantity] = Interval::ZERO;
        let mut found = Vec::new();
        for (number, edge) in self.mode.edges.iter().enumerate() {
            let here =
                guarded(&edge.guard, quantity, Comparison::at_zero).map_or(Some(false), |rest| all(&rest, &known));
            let later =
                if edge.is_urgent { due_after(&edge.guard, quantity, is_rising, &watched) } else { Some(false) };
            match (here, later) {
                (Some(false), Some(false)) => {}
                _ => found.push((number, here == Some(true) || later == Some(true))),
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
        if self.may_be_over(clock)? {
            (look.claim.met, look.claim.violated) = (None, None);
        }
        let watched = look.watched.unwrap_or_default();
        let keeps_window = look.keeps_window;
        let exponents = self.flow.space.exponents.clone();
        let taken = Taken { h: step.h, exponents, series: step.series().to_vec() };
        self.stretch.segments.push(Segment { taken, time, states: hull, watched, claim: look.claim, keeps_window });
        Ok(())
    }

    /// Whether the stretch may have no length: it then has no instant but that of its landing, at which other things hold.
    fn may_be_over(&self, clock: &Clock) -> Result<bool, Fault> {
        let Clock::Until(instant) = clock else { return Ok(false) };
        Ok(self.stretch.segments.is_empty() && self.flow.space.range(instant)?.low() <= 0.0)
    }

    fn look(&self, step: &Step, clock: &Clock, part: (f64, f64), depth: u32, seen: &mut Look) -> Result<(), Fault> {
        let states = self.states(step, clock, part.0, part.1)?;
        let watched = self.watched(&states)?;
        // Where the domain holds nowhere there is no run to judge.
        let Some(mut known) = kept(&self.mode.domain, &watched) else { return Ok(()) };
        if part.0 == 0.0 && self.stretch.segments.is_empty() && !self.known.is_empty() {
            self.add_known(&states, &mut known);
        }
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
