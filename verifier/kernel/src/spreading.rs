//! Jumps that a set makes over a span of time, where no crossing of the whole set at once is found: by boxes.
//!
//! From each step, jumps are made from all states in it that may be at a guard; a box around the landings of an edge, or
//! a layer of it where the guard compares a sum of variables (`affine`), is followed once the span is over. The flow goes on with all states, those outside of the domain cut off where quantities
//! are looked at, until none is inside. Nothing of it is certain.

use crate::affine::Affine;
use crate::condition::Comparison;
use crate::fault::Fault;
use crate::flowpipe::Step;
use crate::hybrid::{Analysis, Guard, Landing};
use crate::interval::{Enclosure, Interval};
use crate::models::Model;
use crate::series::values;
use crate::sets::Set;
use crate::walk::{all, Clock, Walk};

/// What a stretch has found since its set began to leave.
#[derive(Default)]
pub(crate) struct Spreading {
    pub(crate) has_begun: bool,
    /// Whether a run may have come to the border of its domain where no jump is sure to be possible.
    pub(crate) may_be_stuck: bool,
    /// What has landed by each edge.
    landings: Vec<Landed>,
}

/// A landing, a box around all landings by its edge, and a sum with its range there, where the guard compares one.
struct Landed {
    landing: Landing,
    hull: Vec<Interval>,
    layer: Option<(Affine, Interval)>,
}

impl<'a> Analysis<'a> {
    /// Take a step during which some states may leave or jump. False where no state is left in the domain.
    pub(crate) fn spread(&mut self, walk: &mut Walk<'a>, step: &Step) -> Result<bool, Fault> {
        walk.spreading.has_begun = true;
        walk.stretch.is_certain = false;
        let depth = self.settings.depth + 2;
        let watched = walk.watched_during(step, 0.0, step.h)?;
        let Some(known) = walk.mode.kept(&watched) else { return Ok(false) };
        walk.record(step, &Clock::Same, self.settings.depth, self.settings.longest_step)?;
        let mut arriving = Vec::new();
        for number in 0..walk.mode.edges.len() {
            let guard = walk.due_guard(number);
            let Some(part) = walk.possible(step, &guard, 0.0, step.h, depth)? else { continue };
            let Some(set) = self.at_guard(walk, step, part, &guard)? else { continue };
            if let Some(mut landing) = self.landing(walk, number, &set, true)? {
                if std::mem::replace(&mut landing.is_certain, false) {
                    arriving.push(number);
                }
                let layer = match walk.compared(&guard) {
                    Some((at, sum)) => Some((sum, walk.range_of(at, &landing.set)?)),
                    None => None,
                };
                walk.spreading.add(landing, layer)?;
            }
        }
        walk.spreading.may_be_stuck |= !walk.is_served(&arriving, &watched, &known);
        if let Some(last) = walk.stretch.segments.last_mut() {
            last.stays &= !walk.spreading.may_be_stuck;
        }
        walk.flow.land(step)?;
        Ok(true)
    }

    /// A box or a layer around the states of a part of a step that are in the domain and where a guard may hold.
    pub(crate) fn at_guard(
        &self,
        walk: &Walk<'a>,
        step: &Step,
        part: Interval,
        guard: &Guard,
    ) -> Result<Option<Set>, Fault> {
        let states = walk.flow.states(step, part)?;
        let hull = states[..walk.mode.field.outputs.len()].iter().map(|m| walk.flow.space.range(m));
        let hull = hull.collect::<Result<Vec<_>, _>>()?;
        let Some(sides) = walk.mode.cut(&hull, guard) else { return Ok(None) };
        let degree = self.settings.degree.max(1);
        let Some((at, sum)) = walk.compared(guard) else { return Ok(Some(Set::of_box(&sides, degree))) };
        let around = Set { space: walk.flow.space.clone(), models: states };
        let mut conditions = walk.mode.domain.iter().chain(guard).filter(|(other, _)| *other == at);
        let range = conditions.try_fold(walk.range_of(at, &around)?, |known, (_, c)| c.keep(known));
        range.map(|range| sum.layer(&sides, range, degree)).transpose()
    }

    /// Follow what has landed.
    pub(crate) fn settle(&mut self, walk: &mut Walk<'a>) {
        for Landed { mut landing, hull, layer } in std::mem::take(&mut walk.spreading.landings) {
            let target = &self.modes[walk.mode.edges[landing.edge].target];
            let Some(inside) = target.cut(&hull, &Vec::new()) else { continue };
            let degree = self.settings.degree.max(1);
            let thin = layer.and_then(|(sum, range)| sum.layer(&inside, range, degree).ok());
            landing.set = thin.unwrap_or_else(|| Set::of_box(&inside, degree));
            self.leave(walk, landing);
        }
    }
}

impl Spreading {
    fn add(&mut self, landing: Landing, layer: Option<(Affine, Interval)>) -> Result<(), Fault> {
        let hull = landing.set.hull()?;
        let Some(known) = self.landings.iter_mut().find(|l| l.landing.edge == landing.edge) else {
            self.landings.push(Landed { landing, hull, layer });
            return Ok(());
        };
        for (x, y) in known.hull.iter_mut().zip(&hull) {
            *x = x.hull(*y)?;
        }
        known.layer = match (known.layer.take(), layer) {
            (Some((sum, mine)), Some((_, its))) => Some((sum, mine.hull(its)?)),
            _ => None,
        };
        known.landing.widen(&landing)
    }
}

impl Walk<'_> {
    /// Whether wherever the domain may be left, one of some edges is sure to be possible.
    fn is_served(&self, arriving: &[usize], watched: &[Interval], known: &[Interval]) -> bool {
        let serves = |edge: usize, quantity: usize| {
            let (own, others): (Guard, Guard) = self.mode.edges[edge].guard.iter().partition(|(at, _)| *at == quantity);
            own.iter().all(|(_, c)| c.at_zero()) && all(&others, known) == Some(true)
        };
        let mut exits = self.mode.domain.iter().filter(|(at, c)| c.truth(watched[*at]) != Some(true));
        exits.all(|&(at, _)| arriving.iter().any(|&e| serves(e, at)))
    }

    /// The first watched quantity of a guard that is a sum of several variables, and that sum.
    fn compared(&self, guard: &Guard) -> Option<(usize, Affine)> {
        let watch = &self.mode.watch;
        let count = self.mode.field.outputs.len();
        guard.iter().find_map(|&(at, _)| Some((at, Affine::of(watch, watch.outputs[at], count)?)))
    }

    /// The range of a watched quantity over states.
    fn range_of(&self, at: usize, set: &Set) -> Enclosure {
        let found: Vec<Model> = values(&set.space, &self.quantity(at), &set.models)?;
        set.space.range(&found[0])
    }

    /// Where an edge may be taken: an urgent one is due also where its guard holds right after (LANGUAGE S8).
    pub(crate) fn due_guard(&self, number: usize) -> Guard {
        let edge = &self.mode.edges[number];
        let closed = |&(at, c): &(usize, Comparison)| (at, if edge.is_urgent { c.closed() } else { c });
        edge.guard.iter().filter(|(_, c)| !(edge.is_urgent && *c == Comparison::Differ)).map(closed).collect()
    }
}
