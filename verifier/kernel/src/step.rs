//! One step of a run: how far the series of the flow reach, what domain and guards make of it, where it ends.

use crate::automaton::Mode;
use crate::dense::{at, rounding};
use crate::events::{Part, Signs};
use crate::program::truth;
use crate::runs::{End, Piece, Policy};
use crate::simulate::{Opening, Runner, Stop};

const SPREAD: f64 = 1e-9; // an edge with an open guard fires so much after it comes to hold
const LARGEST: f64 = 1e100;

impl Runner<'_> {
    /// One step of a flow.
    pub fn step(&mut self) -> Stop {
        while self.written < self.plan.writes.len() && self.plan.writes[self.written].time <= self.run.time {
            let w = self.plan.writes[self.written];
            self.run.state[w.variable] = w.value;
            self.written += 1;
        }
        if let Some(v) = self.automaton.clock {
            self.run.state[v] = self.run.time;
        }
        self.run.steps += 1;
        if self.run.steps > self.plan.steps {
            return Stop::End(End::Steps);
        }
        let mode = self.mode();
        self.jets.ahead.clear();
        self.jets.expand(&mode.program, &self.run.state, self.plan.order);
        if self.stands_at_corner(mode) {
            self.jets.expand(&mode.program, &self.run.state, self.plan.order);
        }
        if self.jets.looks_ahead(&mode.corners) {
            self.jets.expand(&mode.program, &self.run.state, self.plan.order);
        }
        let next = self.plan.writes.get(self.written).map_or(self.plan.horizon, |w| w.time.min(self.plan.horizon));
        let room = next - self.run.time;
        let size = self.run.state.iter().fold(0.0f64, |m, x| m.max(x.abs()));
        match self.jets.defined(&mode.program) {
            Some(true) => {}
            Some(false) if size <= LARGEST && self.jets.nears_a_pole(&mode.program, 0.0) => {
                return Stop::End(End::Undefined)
            }
            Some(false) => return Stop::End(End::Escape),
            None => return Stop::End(End::Undefined),
        }
        let mut h = self.jets.length(mode, room);
        if h < room && h < 4.0 * f64::EPSILON * self.run.time.max(1e-3) || size > LARGEST {
            let ends = size <= LARGEST && self.jets.nears_a_pole(&mode.program, h);
            return Stop::End(if ends { End::Undefined } else { End::Escape });
        }
        let corner = self.first_corner(mode, h);
        if let Some((t, _)) = corner {
            h = t;
        }
        let signs = Signs::along(mode, &self.jets, h, &self.errors);
        let stop = self.looked(mode, &signs, h, room <= 0.0);
        if matches!(stop, Stop::End(_)) {
            return stop;
        }
        self.keep(mode, h);
        match stop {
            Stop::Here(t, edges, leaves) => {
                let t = self.advance(mode, &signs, t);
                Stop::Here(t, edges, leaves)
            }
            Stop::Take(t, edge) => {
                let t = self.advance(mode, &signs, t);
                Stop::Take(t, edge)
            }
            _ => {
                self.jets.zeroed.clear();
                if let Some((_, r)) = corner {
                    self.jets.zeroed.push(r);
                }
                let end = if h >= room { next } else { self.run.time + h };
                self.moved(h, end);
                Stop::Runs
            }
        }
    }

    /// Whether a branch begins to be told by more than rounding; such registers count as zero from here on.
    fn stands_at_corner(&mut self, mode: &Mode) -> bool {
        let doubt = 1e3 * self.errors.iter().fold(0.0f64, |most, e| most.max(*e));
        let near = |r: &usize| self.jets.register(*r)[0].abs() <= doubt && !self.jets.zeroed.contains(r);
        if !mode.corners.iter().any(near) {
            return false;
        }
        let values: Vec<f64> = (0..mode.program.moving).map(|r| self.jets.register(r)[0]).collect();
        let off = rounding(&mode.program, &values, &self.errors);
        let zeroed =
            mode.corners.iter().copied().filter(|r| near(r) && values[*r] != 0.0 && values[*r].abs() <= off[*r]);
        let zeroed: Vec<usize> = zeroed.collect();
        self.jets.zeroed.extend(&zeroed);
        !zeroed.is_empty()
    }

    /// The first change of a branch within a step.
    fn first_corner(&self, mode: &Mode, h: f64) -> Option<(f64, usize)> {
        let of = |&r: &usize| {
            let series = self.jets.register(r);
            let skip = usize::from(self.jets.zeroed.contains(&r) || series[0] == 0.0);
            crate::roots::roots(series, h, skip, 0.0).first().map(|&t| (t, r))
        };
        mode.corners.iter().filter_map(of).filter(|c| c.0 < h).min_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// What the conditions of a mode make of a step.
    fn looked(&mut self, mode: &Mode, signs: &Signs, h: f64, is_over: bool) -> Stop {
        let automaton = self.automaton;
        let now = self.run.time;
        let edges: Vec<usize> = mode.edges.iter().copied().filter(|e| !self.blocked.contains(e)).collect();
        let parts: Vec<Part> = if is_over { vec![Part::Start] } else { signs.parts().collect() };
        let holds = |condition, part| truth(condition, &|r| signs.sign(mode, &self.jets, h, part, r));
        let mut found: Vec<Opening> = Vec::new();
        for (i, &part) in parts.iter().enumerate() {
            let (low, high) = signs.ends(part, h);
            let following = parts.get(i + 1);
            if let Part::Open(_) = part {
                for &e in edges.iter().filter(|&&e| !automaton.edges[e].is_urgent) {
                    if holds(&automaton.edges[e].enabled, part) {
                        let spread = (SPREAD * (1.0 + now)).min((high - low) / 2.0);
                        if self.plan.policy == Policy::Earliest {
                            return Stop::Take(low + spread, e);
                        }
                        found.push(Opening { edge: e, from: now + low + spread, to: now + high - spread });
                    }
                }
                continue;
            }
            let is_inside = holds(&mode.domain, part);
            let enabled = |e: &usize| {
                let edge = &automaton.edges[*e];
                holds(&edge.enabled, part)
                    || (edge.is_urgent && following.is_some_and(|&next| holds(&edge.enabled, next)))
            };
            let leaves = !is_inside || following.is_some_and(|&next| !holds(&mode.domain, next));
            let ready: Vec<usize> = edges.iter().copied().filter(enabled).collect();
            if leaves || ready.iter().any(|&e| automaton.edges[e].is_urgent) {
                self.openings.extend(found);
                return Stop::Here(low, ready, leaves);
            }
            if self.plan.policy == Policy::Earliest {
                if let Some(&e) = ready.first() {
                    return Stop::Take(low, e);
                }
            }
            found.extend(ready.iter().map(|&edge| Opening { edge, from: now + low, to: now + low }));
        }
        self.openings.extend(found);
        if is_over {
            Stop::End(End::Horizon)
        } else {
            Stop::Runs
        }
    }

    fn keep(&mut self, mode: &Mode, h: f64) {
        let observed = mode.observed.iter().flat_map(|&r| self.jets.register(r).iter().copied()).collect();
        let piece = Piece {
            mode: self.run.mode,
            jumps: self.run.jumps.len(),
            start: self.run.time,
            length: h,
            order: self.jets.order,
            states: self.jets.states.clone(),
            observed,
            is_landing: false,
        };
        self.run.pieces.push(piece);
    }

    /// Go to an instant of this step, with variables exactly where a zero puts them.
    fn advance(&mut self, mode: &Mode, signs: &Signs, t: f64) -> f64 {
        let now = self.run.time + t;
        if let Some(p) = self.run.pieces.last_mut() {
            p.length = t;
        }
        self.moved(t, now);
        let zeros = signs.zeros_at(mode, t);
        for &(_, v, to, factor) in mode.snaps.iter().filter(|s| zeros.contains(&s.0)) {
            self.run.state[v] = to.map_or(0.0, |c| factor * self.jets.register(c)[0]);
            self.errors[v] = 0.0;
        }
        now
    }

    fn moved(&mut self, h: f64, end: f64) {
        for v in 0..self.automaton.variables {
            let series = self.jets.state(v);
            let mut size = 0.0;
            let mut power = 1.0;
            for c in series {
                size += c.abs() * power;
                power *= h;
            }
            if self.mode().program.slopes[v].is_some() && h > 0.0 {
                self.errors[v] = 4.0 * f64::EPSILON * size;
            }
            self.run.state[v] = at(series, h);
        }
        self.run.time = end;
        if let Some(v) = self.automaton.clock {
            self.run.state[v] = end;
        }
    }
}
