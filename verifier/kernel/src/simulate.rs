//! Whole runs of a hybrid automaton in floats: flows by Taylor series, jumps where the signs of guards change.
//!
//! A stay in a mode goes on until its domain ends, an urgent edge is due, or the horizon comes; the policy picks among
//! the edges that were enabled on the way. Runs are plain simulations: they prove nothing.

use crate::automaton::{Automaton, Mode, Reset};
use crate::chance::Chance;
use crate::dense::{at, rounding, sign, truth, Jets};
use crate::events::{Part, Signs};
use crate::zeno::{accumulation, Accumulation};

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Policy {
    Earliest,
    Latest,
    Random,
}

/// A value given to a variable at a time: how inputs move.
#[derive(Debug, Clone, Copy)]
pub struct Write {
    pub time: f64,
    pub variable: usize,
    pub value: f64,
}

#[derive(Debug, Clone)]
pub struct Plan {
    pub mode: usize,
    pub state: Vec<f64>,
    pub horizon: f64,
    pub jumps: usize,
    pub steps: usize,
    pub order: usize,
    pub policy: Policy,
    pub chance: Chance,
    /// In order of time.
    pub writes: Vec<Write>,
    pub keeps_pieces: bool,
}

/// A step of a run: the series of the state and of what is observed, from its start on.
#[derive(Debug, Clone)]
pub struct Piece {
    pub mode: usize,
    pub jumps: usize,
    pub start: f64,
    pub length: f64,
    pub order: usize,
    pub states: Vec<f64>,
    pub observed: Vec<f64>,
    /// The instant after a jump, at which a formula may mean something else than afterwards.
    pub is_landing: bool,
}

impl Piece {
    /// How many coefficients a series of it has.
    pub fn width(&self) -> usize {
        self.order + 1
    }
}

#[derive(Debug, Clone)]
pub struct Jump {
    pub time: f64,
    pub edge: usize,
    pub before: Vec<f64>,
    pub after: Vec<f64>,
}

#[derive(Debug, Clone, PartialEq)]
pub enum End {
    Horizon,
    Jumps,
    Steps,
    /// The start is outside the domain.
    Outside,
    /// No time can pass and no edge is enabled.
    Stuck,
    /// The same in a terminal mode.
    Ended,
    /// Jumps accumulate at a time.
    Zeno(f64),
    /// The state leaves all bounds, or a slope becomes infinite.
    Escape,
    /// Something in the flow has no value.
    Undefined,
}

#[derive(Debug, Clone)]
pub struct Run {
    pub pieces: Vec<Piece>,
    pub jumps: Vec<Jump>,
    pub end: End,
    pub time: f64,
    pub mode: usize,
    pub state: Vec<f64>,
    /// How many were taken, those of no length included.
    pub steps: usize,
}

/// An edge that may be taken from one time to another.
#[derive(Debug, Clone, Copy)]
struct Opening {
    edge: usize,
    from: f64,
    to: f64,
}

/// How a step ended.
enum Stop {
    Runs,
    /// At an instant, where some edges may fire, and whether the domain ends there.
    Here(f64, Vec<usize>, bool),
    Take(f64, usize),
    End(End),
}

const SPREAD: f64 = 1e-9; // an edge with an open guard fires so much after it comes to hold
const LARGEST: f64 = 1e100;
const TRIES: usize = 32;

struct Runner<'a> {
    automaton: &'a Automaton,
    plan: Plan,
    jets: Jets,
    run: Run,
    errors: Vec<f64>,
    /// Where the pieces and the steps of this stay begin.
    first: usize,
    openings: Vec<Opening>,
    /// Edges that were tried in this stay and have no outcome.
    blocked: Vec<usize>,
    written: usize,
    accumulation: Accumulation,
}

/// Follow one run to its end.
pub fn simulate(automaton: &Automaton, plan: Plan) -> Run {
    let run = Run {
        pieces: Vec::new(),
        jumps: Vec::new(),
        end: End::Horizon,
        time: 0.0,
        mode: plan.mode,
        state: plan.state.clone(),
        steps: 0,
    };
    let errors = vec![0.0; automaton.variables];
    let accumulation = Accumulation::default();
    let jets = Jets::default();
    let (openings, blocked) = (Vec::new(), Vec::new());
    let mut runner =
        Runner { automaton, plan, jets, run, errors, first: 0, openings, blocked, written: 0, accumulation };
    runner.run.end = runner.follow();
    runner.run
}

impl<'a> Runner<'a> {
    fn mode(&self) -> &'a Mode {
        &self.automaton.modes[self.run.mode]
    }

    fn follow(&mut self) -> End {
        loop {
            self.openings.clear();
            self.blocked.clear();
            self.jets.zeroed.clear();
            if !self.plan.keeps_pieces {
                self.run.pieces.clear();
            }
            self.first = self.run.pieces.len();
            if let Some(end) = self.stay() {
                return end;
            }
            let limit = accumulation(&mut self.accumulation, self.run.time);
            if limit.is_some() || self.run.jumps.len() >= self.plan.jumps {
                self.keep_last();
                return limit.map_or(End::Jumps, End::Zeno);
            }
        }
    }

    /// The state after the last jump, where the run goes no farther.
    fn keep_last(&mut self) {
        self.first = self.run.pieces.len();
        let state = self.run.state.clone();
        self.cut(self.run.time, &state);
    }

    /// One stay in a mode, up to a jump (None) or the end of the run.
    fn stay(&mut self) -> Option<End> {
        loop {
            match self.step() {
                Stop::Runs => {}
                Stop::End(End::Horizon) => return self.chosen(None, &[]),
                Stop::End(end) => return Some(end),
                Stop::Here(time, edges, leaves) => {
                    let end = self.chosen(Some(time), &edges);
                    if end.is_none() || leaves {
                        return end;
                    }
                    self.blocked.extend(edges);
                }
                Stop::Take(time, edge) => {
                    if self.jump(time, edge) {
                        return None;
                    }
                    self.blocked.push(edge);
                }
            }
        }
    }

    /// Jump as the policy says, where a stay ended (at a time, with edges that may fire there, or at the horizon).
    fn chosen(&mut self, stop: Option<f64>, edges: &[usize]) -> Option<End> {
        let mut ways: Vec<Opening> =
            stop.map(|t| edges.iter().map(|&edge| Opening { edge, from: t, to: t }).collect()).unwrap_or_default();
        if self.plan.policy == Policy::Random {
            let stay_on = usize::from(stop.is_none() || (self.mode().is_terminal && ways.is_empty()));
            let mut all = self.openings.clone();
            all.extend(ways);
            while !all.is_empty() {
                let k = self.plan.chance.pick(all.len() + stay_on);
                if k >= all.len() {
                    break;
                }
                let way = all.swap_remove(k);
                let time = way.from + self.plan.chance.share() * (way.to - way.from);
                if self.jump(time, way.edge) {
                    return None;
                }
            }
        } else {
            if stop.is_some() && ways.is_empty() && !self.mode().is_terminal {
                ways.extend(self.openings.iter().rev().map(|o| Opening { from: o.to, ..*o }));
            }
            for way in ways {
                if self.jump(way.from, way.edge) {
                    return None;
                }
            }
        }
        Some(match stop {
            None => End::Horizon,
            Some(_) if self.mode().is_terminal => End::Ended,
            Some(_) if self.run.jumps.is_empty() && self.run.time == 0.0 && !self.starts_inside() => End::Outside,
            Some(_) => End::Stuck,
        })
    }

    fn starts_inside(&self) -> bool {
        self.is_inside(self.run.mode, &self.run.state, &self.errors)
    }

    fn is_inside(&self, mode: usize, state: &[f64], errors: &[f64]) -> bool {
        let m = &self.automaton.modes[mode];
        let values = Jets::values(&m.program, state);
        let off = rounding(&m.program, &values, errors);
        truth(&m.domain, &|r| if values[r].abs() <= off[r] { 0 } else { sign(values[r]) })
    }

    /// Take an edge at a time of this stay; false where no outcome lies in the target's domain.
    fn jump(&mut self, time: f64, edge: usize) -> bool {
        let before = self.state_at(time);
        let way = &self.automaton.edges[edge];
        let program = &self.mode().program;
        let values = Jets::values(program, &before);
        let off = rounding(program, &values, &self.errors);
        let tries = if way.chooses() { TRIES } else { 1 };
        for _ in 0..tries {
            let mut after = before.clone();
            let mut errors = self.errors.clone();
            for reset in &way.resets {
                match *reset {
                    Reset::To(v, r) => (after[v], errors[v]) = (values[r], off[r]),
                    Reset::Between(v, low, high) => {
                        after[v] = values[low] + self.plan.chance.share() * (values[high] - values[low]);
                        errors[v] = 0.0;
                    }
                }
            }
            if !way.chooses() || self.is_inside(way.target, &after, &errors) {
                self.cut(time, &before);
                self.run.jumps.push(Jump { time, edge, before, after: after.clone() });
                (self.run.time, self.run.mode, self.run.state, self.errors) = (time, way.target, after, errors);
                self.land(&way.landing);
                return true;
            }
        }
        false
    }

    /// Keep the instant after a jump, where formulas tell it from what follows.
    fn land(&mut self, landing: &[usize]) {
        if landing.is_empty() || !self.plan.keeps_pieces {
            return;
        }
        let values = Jets::values(&self.mode().program, &self.run.state);
        self.run.pieces.push(Piece {
            mode: self.run.mode,
            jumps: self.run.jumps.len(),
            start: self.run.time,
            length: 0.0,
            order: 0,
            states: self.run.state.clone(),
            observed: landing.iter().map(|&r| values[r]).collect(),
            is_landing: true,
        });
    }

    /// The state at a time of this stay.
    fn state_at(&self, time: f64) -> Vec<f64> {
        if time == self.run.time {
            return self.run.state.clone();
        }
        let pieces = &self.run.pieces[self.first..];
        match pieces.iter().rev().find(|p| p.start <= time) {
            Some(p) => {
                let width = p.width();
                (0..self.automaton.variables)
                    .map(|v| at(&p.states[v * width..(v + 1) * width], time - p.start))
                    .collect()
            }
            None => self.run.state.clone(),
        }
    }

    /// Forget what lies after a time of this stay; a stay of no length leaves a piece of no length.
    fn cut(&mut self, time: f64, state: &[f64]) {
        while self.run.pieces.len() > self.first && self.run.pieces[self.run.pieces.len() - 1].start > time {
            self.run.pieces.pop();
        }
        let is_new = self.run.pieces.len() == self.first;
        if is_new && self.plan.keeps_pieces {
            let mode = self.mode();
            let values = Jets::values(&mode.program, state);
            let observed = mode.observed.iter().map(|&r| values[r]).collect();
            let (mode, jumps) = (self.run.mode, self.run.jumps.len());
            let (states, order, is_landing) = (state.to_vec(), 0, false);
            self.run.pieces.push(Piece { mode, jumps, start: time, length: 0.0, order, states, observed, is_landing });
        } else if let Some(p) = self.run.pieces.last_mut() {
            p.length = p.length.min(time - p.start).max(0.0);
        }
    }

    /// One step of a flow.
    fn step(&mut self) -> Stop {
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
        self.jets.expand(&mode.program, &self.run.state, self.plan.order);
        if self.stands_at_corner(mode) {
            self.jets.expand(&mode.program, &self.run.state, self.plan.order);
        }
        let next = self.plan.writes.get(self.written).map_or(self.plan.horizon, |w| w.time.min(self.plan.horizon));
        let room = next - self.run.time;
        let size = self.run.state.iter().fold(0.0f64, |m, x| m.max(x.abs()));
        match self.jets.defined(&mode.program) {
            Some(true) => {}
            Some(false) => return Stop::End(End::Escape),
            None => return Stop::End(End::Undefined),
        }
        let mut h = self.jets.length(mode, room);
        if h < room && h < 4.0 * f64::EPSILON * self.run.time.max(1e-3) || size > LARGEST {
            return Stop::End(End::Escape);
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
