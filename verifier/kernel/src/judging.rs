//! What a step shows of the claim and of the window, by parts of it.

use crate::condition::Comparison;
use crate::duals::jacobian;
use crate::fault::Fault;
use crate::flowpipe::Step;
use crate::hybrid::{Guard, Judgement, Mode, Segment, Taken};
use crate::interval::{Enclosure, Interval};
use crate::models::Model;
use crate::series::{values, IntervalRing, Op, Ring, Tape};
use crate::walk::{before, judged, kept, Clock, Walk};
use std::ops::Add;

impl Walk<'_> {
    /// Judge the claim and the window during a step, and keep what was seen, by parts of at most some length.
    pub(crate) fn record(&mut self, step: &Step, clock: &Clock, depth: u32, longest: f64) -> Result<(), Fault> {
        let until = match clock {
            Clock::Same => None,
            Clock::Until(event) => Some((event.instant.clone(), event.quantity, event.is_rising)),
        };
        let parts = if until.is_some() { 1 } else { (step.h / longest).ceil().clamp(1.0, MOST_PARTS) as u32 };
        for part in 0..parts {
            let share = |i: u32| f64::from(i) / f64::from(parts);
            let taken = Taken { path: step.path.clone(), until: until.clone(), part: (share(part), share(part + 1)) };
            let is_first = self.stretch.segments.is_empty();
            let judge = Judge {
                mode: self.mode,
                taken: &taken,
                known: if is_first { &self.known } else { &[] },
                sides: &self.sides,
                is_first,
                is_certain: self.stretch.is_certain,
                is_middle: false,
            };
            let seen = judge.seen(depth)?;
            self.stretch.is_certain &= seen.stays && seen.lasts;
            self.stretch.segments.push(seen.of(taken));
        }
        Ok(())
    }
}

/// How many parts a step is looked at in, at most.
const MOST_PARTS: f64 = 16.0;

/// What is judged, and where.
pub(crate) struct Judge<'a> {
    pub(crate) mode: &'a Mode,
    pub(crate) taken: &'a Taken,
    /// What holds exactly where the stretch starts, and the box it starts in.
    pub(crate) known: &'a [(usize, Comparison)],
    pub(crate) sides: &'a [Interval],
    /// Whether it starts here, and whether all that it encloses exists.
    pub(crate) is_first: bool,
    pub(crate) is_certain: bool,
    /// Whether only what starts in the middle of the set is looked at.
    pub(crate) is_middle: bool,
}

impl Judge<'_> {
    /// What is seen during its part of the step.
    pub(crate) fn seen(&self, depth: u32) -> Result<Seen, Fault> {
        let states = self.states(self.taken.part, &[])?;
        let hull: Vec<Interval> = states.iter().map(|m| self.range(m)).collect::<Result<_, _>>()?;
        self.seen_of(&states, hull, depth)
    }

    /// The same where the box of all states is known.
    pub(crate) fn seen_again(&self, hull: &[Interval], depth: u32) -> Result<Seen, Fault> {
        self.seen_of(&self.states(self.taken.part, &self.wanted(self.taken.part))?, hull.to_vec(), depth)
    }

    fn seen_of(&self, states: &[Model], hull: Vec<Interval>, depth: u32) -> Result<Seen, Fault> {
        let time = self.range(states.last().ok_or(Fault::Unknown)?)?;
        let mut look =
            Look { claim: judged(None, time, false), keeps_window: true, stays: true, lasts: true, watched: None };
        (look.claim.holds, look.claim.fails) = (true, true);
        self.look(self.taken.part, states, depth, &mut look)?;
        if self.taken.part.1 == 1.0 && !look.claim.holds && !look.claim.fails {
            self.look_at_the_end(&mut look)?;
        }
        if self.may_be_over()? {
            (look.claim.met, look.claim.violated) = (None, None);
        }
        let Look { claim, keeps_window, stays, lasts, watched } = look;
        Ok(Seen { time, states: hull, watched: watched.unwrap_or_default(), claim, keeps_window, stays, lasts })
    }

    /// The states that are read where a part is judged: those of watched quantities, and the time.
    fn wanted(&self, part: (f64, f64)) -> Vec<bool> {
        let count = self.mode.field.outputs.len();
        let mut wanted = vec![part.0 == 0.0 && !self.known.is_empty(); count];
        wanted[count - 1] = true;
        for op in &self.mode.watch.ops {
            if let Op::Variable(v) = op {
                wanted[*v] = true;
            }
        }
        wanted
    }

    fn range(&self, m: &Model) -> Enclosure {
        if self.is_middle {
            return Interval::exactly(m.coefficients[0])?.add(Interval::symmetric(m.radius)?);
        }
        self.taken.path.space.range(m)
    }

    /// Whether the stretch may have no length: it then has no instant but that of its landing, at which other things hold.
    fn may_be_over(&self) -> Result<bool, Fault> {
        let Some((instant, _, _)) = &self.taken.until else { return Ok(false) };
        Ok(self.is_first && self.taken.path.space.range(instant)?.low() <= 0.0)
    }

    fn states(&self, part: (f64, f64), wanted: &[bool]) -> Result<Vec<Model>, Fault> {
        self.taken.states(part, self.mode.field.outputs.len(), wanted)
    }

    /// The quantities watched in states up to a crossing: what makes it has not made it before.
    fn watched(&self, states: &[Model]) -> Result<Option<Vec<Interval>>, Fault> {
        let space = &*self.taken.path.space;
        let found = values(space, &self.mode.watch, states)?;
        let mut watched: Vec<Interval> = found.iter().map(|m| self.range(m)).collect::<Result<_, _>>()?;
        if let Some((_, quantity, is_rising)) = self.taken.until {
            let Some(side) = before(is_rising).keep(watched[quantity]) else { return Ok(None) };
            watched[quantity] = side;
        }
        Ok(Some(watched))
    }

    fn look(&self, part: (f64, f64), states: &[Model], depth: u32, seen: &mut Look) -> Result<(), Fault> {
        let Some(watched) = self.watched(states)? else { return Ok(()) };
        let Some(lasts) = self.lasts(part, states, &watched) else { return Ok(()) };
        // Where the domain holds nowhere there is no run to judge.
        let Some(mut known) = self.mode.kept(&watched) else {
            seen.lasts &= lasts;
            return Ok(());
        };
        if part.0 == 0.0 && !self.known.is_empty() {
            self.add_known(states, &mut known);
        }
        let (claim, window) = (self.mode.claim.truth(&known), self.mode.window.truth(&known));
        let rest = self.mode.rest.truth(&known);
        if rest == Some(false) {
            seen.stays = false;
            return Ok(());
        }
        if (claim.is_none() || window != Some(true) || rest.is_none() || !lasts) && depth > 0 {
            let middle = 0.5 * (part.0 + part.1);
            let halves = [(part.0, middle), (middle, part.1)];
            return halves.into_iter().try_for_each(|half| {
                let states = self.states(half, &self.wanted(half))?;
                self.look(half, &states, depth - 1, seen)
            });
        }
        let time = self.range(states.last().ok_or(Fault::Unknown)?)?;
        let raw = self.mode.claim.truth(&watched);
        seen.stays &= rest == Some(true);
        seen.lasts &= lasts;
        let is_certain = self.is_certain && seen.stays && seen.lasts && raw == claim && window == Some(true);
        seen.add(judged(claim, time, is_certain), window == Some(true), known)
    }

    /// The instant of a crossing, which runs still have: there what crosses is zero.
    fn look_at_the_end(&self, seen: &mut Look) -> Result<(), Fault> {
        let Some((_, quantity, _)) = self.taken.until else { return Ok(()) };
        let end = (1.0, 1.0);
        let states = self.states(end, &self.wanted(end))?;
        let Some(mut watched) = self.watched(&states)? else { return Ok(()) };
        watched[quantity] = Interval::ZERO;
        let Some(lasts) = self.lasts(end, &states, &watched) else { return Ok(()) };
        let Some(known) = self.mode.kept(&watched) else { return Ok(()) };
        let (claim, time) = (self.mode.claim.truth(&known), self.range(states.last().ok_or(Fault::Unknown)?)?);
        let is_inside = seen.keeps_window && self.mode.window.truth(&known) == Some(true);
        let is_there = seen.stays && seen.lasts && lasts && self.mode.rest.truth(&known) == Some(true);
        let is_judged = is_inside && is_there && self.mode.claim.truth(&watched) == claim;
        let told = judged(claim, time, self.is_certain && is_judged);
        seen.claim.met = seen.claim.met.or(told.met.filter(|_| is_judged));
        seen.claim.violated = seen.claim.violated.or(told.violated);
        Ok(())
    }

    /// Whether all runs in some states are certainly judged: where an assumption fails a run is there, and judged no longer
    /// (LANGUAGE S25). `None` where the domain holds nowhere.
    fn lasts(&self, part: (f64, f64), states: &[Model], watched: &[Interval]) -> Option<bool> {
        let mut inside = kept(&self.mode.domain, watched)?;
        if self.mode.facts.is_empty() {
            return Some(true);
        }
        if part.0 == 0.0 && !self.known.is_empty() {
            self.add_known(states, &mut inside);
        }
        Some(self.mode.rest.truth(&inside) == Some(true))
    }

    /// Use that what holds where the stretch starts goes on to hold while its quantity moves away from zero.
    fn add_known(&self, states: &[Model], values: &mut [Interval]) {
        let Ok(mut inside) = states.iter().map(|m| self.range(m)).collect::<Result<Vec<_>, _>>() else {
            return;
        };
        let watch = &self.mode.watch;
        for &(at, comparison) in &self.mode.domain {
            if let Op::Variable(v) = watch.ops[watch.outputs[at]] {
                inside[v] = comparison.keep(inside[v]).unwrap_or(inside[v]);
            }
        }
        self.keep_below_the_start(&mut inside);
        for &(at, comparison) in self.known {
            let quantity = Tape { ops: watch.ops.clone(), outputs: vec![watch.outputs[at]] };
            let rate = interval_rate(&quantity, self.mode, &inside);
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

    /// Cut a box of states since the start where variables only fall, or only rise: twice, as one helps the other.
    fn keep_below_the_start(&self, inside: &mut [Interval]) {
        for _ in 0..2 {
            let Ok(speeds) = interval_speeds(self.mode, inside) else { return };
            for ((x, speed), side) in inside.iter_mut().zip(speeds).zip(self.sides) {
                let low = if speed.low() >= 0.0 { x.low().max(side.low()) } else { x.low() };
                let high = if speed.high() <= 0.0 { x.high().min(side.high()) } else { x.high() };
                *x = Interval::new(low, high).unwrap_or(*x);
            }
        }
    }
}

impl Mode {
    /// What holds exactly in all of a box where a stretch begins: comparisons of quantities whose range ends at zero.
    pub(crate) fn borders(&self, sides: &[Interval]) -> Guard {
        let Ok(ranges) = values(&IntervalRing, &self.watch, sides) else { return Guard::new() };
        let least = ranges.iter().enumerate().filter(|(_, x)| x.low() == 0.0).map(|(at, _)| (at, Comparison::AtLeast));
        let most = ranges.iter().enumerate().filter(|(_, x)| x.high() == 0.0).map(|(at, _)| (at, Comparison::AtMost));
        least.chain(most).collect()
    }
}

/// What is seen during a part of a step.
pub(crate) struct Seen {
    time: Interval,
    states: Vec<Interval>,
    watched: Vec<Interval>,
    claim: Judgement,
    keeps_window: bool,
    stays: bool,
    /// Whether all runs are certainly judged.
    lasts: bool,
}

impl Seen {
    pub(crate) fn of(self, taken: Taken) -> Segment {
        let Seen { time, states, watched, claim, keeps_window, stays, .. } = self;
        Segment { taken, time, states, watched, claim, keeps_window, stays }
    }
}

/// The ranges of the rates for states in a box and all inputs.
fn interval_speeds(mode: &Mode, states: &[Interval]) -> Result<Vec<Interval>, Fault> {
    let mut speeds = values(&IntervalRing, &mode.field, states)?;
    if let Some(inputs) = &mode.inputs {
        for (speed, more) in speeds.iter_mut().zip(inputs.spread(&IntervalRing, states, |x| Ok(*x))?) {
            *speed = speed.add(Interval::symmetric(more)?)?;
        }
    }
    Ok(speeds)
}

/// The range of a quantity's rate along a mode's flow, for states in a box.
fn interval_rate(quantity: &Tape, mode: &Mode, states: &[Interval]) -> Enclosure {
    let slopes = jacobian(&IntervalRing, quantity, states)?.swap_remove(0);
    let speeds = interval_speeds(mode, states)?;
    IntervalRing.sum(slopes.iter().zip(&speeds).map(|(s, v)| (1.0, s, v)))
}

/// What was seen of the parts of a step so far.
struct Look {
    claim: Judgement,
    keeps_window: bool,
    /// Whether what else the domain says holds so far.
    stays: bool,
    /// Whether all runs so far are certainly judged.
    lasts: bool,
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
