//! Whole runs of a hybrid automaton in floats: flows by Taylor series, jumps where the signs of guards change.
//!
//! A stay in a mode goes on until its domain ends, an urgent edge is due, or the horizon comes; the policy picks among
//! the edges that were enabled on the way. Runs are plain simulations: they prove nothing.

use crate::automaton::{Automaton, Mode, Reset};
use crate::dense::{at, rounding, Jets};
use crate::program::{sign, truth};
use crate::runs::{End, Jump, Piece, Plan, Policy, Run};
use crate::zeno::{accumulation, Accumulation};

/// An edge that may be taken from one time to another.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Opening {
    pub edge: usize,
    pub from: f64,
    pub to: f64,
}

/// How a step ended.
pub(crate) enum Stop {
    Runs,
    /// At an instant, where some edges may fire, and whether the domain ends there.
    Here(f64, Vec<usize>, bool),
    Take(f64, usize),
    End(End),
}

const TRIES: usize = 32;

pub(crate) struct Runner<'a> {
    pub automaton: &'a Automaton,
    pub plan: Plan,
    pub jets: Jets,
    pub run: Run,
    pub errors: Vec<f64>,
    /// Where the pieces and the steps of this stay begin.
    pub first: usize,
    pub openings: Vec<Opening>,
    /// Edges that were tried in this stay and have no outcome.
    pub blocked: Vec<usize>,
    pub written: usize,
    pub accumulation: Accumulation,
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
    pub fn mode(&self) -> &'a Mode {
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
}
