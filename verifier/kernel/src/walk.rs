//! One stretch of flow in a mode: what can happen in a step.

use crate::condition::Comparison;
use crate::fault::Fault;
use crate::flowpipe::{Flow, Step};
use crate::hybrid::{Guard, Judgement, Mode, Stretch};
use crate::interval::Interval;
use crate::models::Model;
use crate::path::Path;
use crate::series::{values, Ring, Tape};
use crate::sets::Set;
use crate::spreading::Spreading;

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
    pub(crate) spreading: Spreading,
}

/// How the instants of a step depend on the set: the same for all, or up to the instant of a crossing.
pub(crate) enum Clock<'a> {
    Same,
    Until(&'a Event<'a>),
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
pub(crate) fn before(is_rising: bool) -> Comparison {
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
pub(crate) fn kept(domain: &Guard, values: &[Interval]) -> Option<Vec<Interval>> {
    let mut kept = values.to_vec();
    for (at, comparison) in domain {
        kept[*at] = comparison.keep(kept[*at])?;
    }
    Some(kept)
}

/// The states during a part of a step, or of its way to an instant that depends on the set.
pub(crate) fn during(
    path: &Path,
    until: Option<&Model>,
    part: (f64, f64),
    count: usize,
    wanted: &[bool],
) -> Result<Vec<Model>, Fault> {
    match until {
        None => path.states(Interval::new(part.0 * path.h, (part.1 * path.h).min(path.h))?, count, wanted),
        Some(instant) => {
            let share = Interval::new(part.0, part.1)?;
            path.states_at(&path.space.scale(instant, share)?, count, wanted)
        }
    }
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

    /// A watched quantity alone.
    pub(crate) fn quantity(&self, at: usize) -> Tape {
        Tape { ops: self.mode.watch.ops.clone(), outputs: vec![self.mode.watch.outputs[at]] }
    }

    pub(crate) fn states(&self, step: &Step, clock: &Clock, from: f64, to: f64) -> Result<Vec<Model>, Fault> {
        let until = match clock {
            Clock::Same => None,
            Clock::Until(event) => Some(event.instant),
        };
        during(&step.path, until, (from, to), self.mode.field.outputs.len(), &[])
    }

    pub(crate) fn watched(&self, states: &[Model]) -> Result<Vec<Interval>, Fault> {
        let space = &self.flow.space;
        values(space, &self.mode.watch, states)?.iter().map(|m| space.range(m)).collect()
    }

    pub(crate) fn watched_during(&self, step: &Step, from: f64, to: f64) -> Result<Vec<Interval>, Fault> {
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
        let Some(known) = self.mode.kept(&watched) else { return false };
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
        for edge in &self.mode.edges {
            if edge.is_urgent && self.possible(step, &edge.guard, 0.0, step.h, depth)?.is_some() {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// An interval of time outside which a guard does not hold in the step.
    pub(crate) fn possible(
        &self,
        step: &Step,
        guard: &Guard,
        from: f64,
        to: f64,
        depth: u32,
    ) -> Result<Option<Interval>, Fault> {
        let watched = self.watched_during(step, from, to)?;
        let Some(known) = self.mode.kept(&watched) else { return Ok(None) };
        match all(guard, &known) {
            Some(false) => return Ok(None),
            None if depth > 0 => {}
            _ => return Ok(Some(Interval::new(from, to)?)),
        }
        let middle = 0.5 * (from + to);
        let first = self.possible(step, guard, from, middle, depth - 1)?;
        let second = self.possible(step, guard, middle, to, depth - 1)?;
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
        let watched = self.watched(&self.states(step, &Clock::Until(event), from, to)?)?;
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
        let mut known = self.mode.kept(watched)?;
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
        let watched = self.watched(&self.states(step, &Clock::Until(event), from, to)?)?;
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
        let models = self.states(step, &Clock::Until(event), part.0, part.1)?;
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
        let Some(mut known) = self.mode.kept(&watched) else { return Ok(Vec::new()) };
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
