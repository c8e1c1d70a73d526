//! Paces: the states of a set move at speeds of their own, so that all come to a crossing at about the same instant.
//!
//! Time scaled by a positive function of the set changes no run, only when it is where (S. Bak, S. Bogomolov, M. Althoff,
//! Time-triggered conversion of guards for reachability analysis of hybrid automata, FORMATS 2017). What is aimed at need
//! not be right: a pace that is off leaves the crossing spread over more time than a better one.

use crate::fault::Fault;
use crate::flowpipe::{Flow, Step};
use crate::interval::Interval;
use crate::series::Ring;
use crate::walk::Walk;
use std::ops::Div;

/// How often the pace of a stretch may be changed.
const PACES: usize = 3;
/// How many steps a crossing may take before the pace is changed ahead of it.
const SPREAD: f64 = 1.5;
/// Which part of the longest way the shortest is where no pace makes them more alike.
const EVEN: f64 = 0.999;

/// The time until the first and until the last state of a set are at a crossing, roughly.
struct Ahead {
    first: f64,
    last: f64,
}

impl Walk<'_> {
    /// Change the pace once where the set is about as far from a crossing as it is deep, if the crossing would take more
    /// than a step and no other may come before its end: seen from afar, the ways of all states differ by little.
    pub(crate) fn pace_ahead(&mut self, step: &Step) -> Result<bool, Fault> {
        if self.paced > 0 {
            return Ok(false);
        }
        let ways: Vec<((usize, bool), Ahead)> =
            self.events().into_iter().filter_map(|event| Some((event, self.ahead(event)?))).collect();
        let Some(((at, is_rising), way)) = ways.iter().min_by(|a, b| a.1.first.total_cmp(&b.1.first)) else {
            return Ok(false);
        };
        let others = ways.iter().filter(|(event, _)| event != &(*at, *is_rising));
        let is_alone = others.into_iter().all(|(_, other)| other.first > way.last);
        let spread = way.last - way.first;
        if !is_alone || way.first > spread || spread <= SPREAD * step.h {
            return Ok(false);
        }
        self.pace_towards(step, *at, *is_rising)
    }

    /// When a quantity is about to cross zero, as the last two segments show it; `None` if it moves away from there.
    fn ahead(&self, (at, is_rising): (usize, bool)) -> Option<Ahead> {
        let [.., before, last] = &self.stretch.segments[..] else { return None };
        let sign = if is_rising { 1.0 } else { -1.0 };
        let passed = last.time.midpoint() - before.time.midpoint();
        let (now, then) = (last.watched.get(at)?, before.watched.get(at)?);
        let rate = sign * (now.midpoint() - then.midpoint()) / passed;
        let ends = [now.low(), now.high()].map(|x| -sign * x / rate);
        let (first, most) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
        (rate > 0.0 && first > 0.0).then_some(Ahead { first, last: most - passed })
    }

    /// Change the pace for the first crossing that the set comes to.
    pub(crate) fn pace(&mut self, step: &Step) -> Result<bool, Fault> {
        for (at, is_rising) in self.events() {
            if self.flow.approach(step, &self.quantity(at), is_rising).is_some() {
                return self.pace_towards(step, at, is_rising);
            }
        }
        Ok(false)
    }

    /// Let all states come to the crossing of a quantity at about the same instant. Paces are further variables that do
    /// not change, after those of the state.
    fn pace_towards(&mut self, step: &Step, at: usize, is_rising: bool) -> Result<bool, Fault> {
        let may = self.paced < PACES && self.mode.inputs.is_none();
        let Some(way) = self.flow.approach(step, &self.quantity(at), is_rising).filter(|_| may) else {
            return Ok(false);
        };
        let longest = self.flow.space.range(&way)?;
        if longest.low() <= 0.0 || longest.low() > EVEN * longest.high() {
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
}
