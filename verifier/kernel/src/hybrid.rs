//! Runs of a hybrid automaton from a set of starts, enclosed: a tree of stretches of flow between jumps.
//!
//! Every run from the set is followed by one path of the tree, as long as it lasts, up to the horizon: jumps that are only
//! possible are followed as well. What *certainly* exists is marked: a stretch is certain if all runs it encloses really
//! get there. Only that may refute a claim. The state's last component is the time since the start.
//!
//! Facts used: on a run the domain, read as closed, holds until the jump. A flow leaves the domain at the latest where it
//! crosses its border; where the crossing is transversal for the whole set, it is solved exactly (`crossing`). Where
//! it is not, the set is cut in halves. A jump that is open for a while (no crossing forces it) is enclosed as a whole.

use crate::condition::{Comparison, Condition};
use crate::fault::Fault;
use crate::flowpipe::{Flow, Settings, Step};
use crate::halt::allowed;
use crate::inputs::Inputs;
use crate::interval::Interval;
use crate::models::Model;
use crate::path::Path;
use crate::series::{values, Op, Ring, Tape};
use crate::sets::Set;
use crate::spreading::Spreading;
use crate::walk::{all, during, judged, kept, leaves, ranges, Clock, Event, Walk};
use std::collections::VecDeque;
use std::ops::{Add, Sub};
use std::sync::Arc;

/// How much longer a step may be where nothing can happen on the way: what is judged are parts of it.
const STRIDE: f64 = 2.0;

/// How much longer a step is tried where a set at paces of its own does not come to its crossing in one.
const LONGER: f64 = 1.25;
/// How many more variables than the state a set may have.
const SPARE: usize = 1;
/// How many times the steps of one stretch all of them together may have.
const TREE: usize = 2;
/// After how many landings in a mode those without a horizon are widened, and by what part of their width.
const LANDINGS: usize = 3;
const WIDENED: f64 = 0.05;

/// A conjunction of comparisons of watched quantities with zero.
pub type Guard = Vec<(usize, Comparison)>;

/// A jump: where it leads, when it may be made, what it makes of the state.
#[derive(Debug, Clone)]
pub struct Edge {
    pub target: usize,
    pub is_urgent: bool,
    /// On the quantities that the source mode watches.
    pub guard: Guard,
    /// The state after it from the state before it and `choices` further variables, each from -1 to 1.
    pub reset: Tape,
    pub choices: usize,
    /// Quantities of the state after (first) and before it, and the claim on these.
    pub landing: Tape,
    pub claim: Condition,
}

impl Edge {
    /// The quantities of a landing: of the states after and before it.
    pub(crate) fn quantities(&self, landed: &Set) -> Result<Vec<Interval>, Fault> {
        ranges(landed, &values(&landed.space, &self.landing, &landed.models)?)
    }
}

/// A discrete state: its flow, the quantities to watch, and conditions on these.
#[derive(Debug, Clone)]
pub struct Mode {
    pub field: Tape,
    /// The field times a further variable, which does not change.
    pub paced: Tape,
    pub watch: Tape,
    /// What the field is for other inputs than those in the middle of their ranges, if it has any.
    pub inputs: Option<Inputs>,
    /// Read as closed.
    pub domain: Guard,
    /// What else holds on every run that is judged; it ends none.
    pub facts: Guard,
    /// What else the domain says: runs may end where it does not hold.
    pub rest: Condition,
    pub claim: Condition,
    /// Where runs are followed.
    pub window: Condition,
    pub edges: Vec<Edge>,
}

/// The field of a mode times a further variable, which follows the state and does not change.
pub fn paced(field: &Tape) -> Result<Tape, Fault> {
    let mut ops = field.ops.clone();
    let pace = ops.len();
    ops.push(Op::Variable(field.outputs.len()));
    let mut outputs = Vec::with_capacity(field.outputs.len() + 1);
    for &output in &field.outputs {
        outputs.push(ops.len());
        ops.push(Op::Mul(output, pace));
    }
    outputs.push(ops.len());
    ops.push(Op::Constant(Interval::ZERO));
    Tape::validated(ops, outputs, field.outputs.len() + 1)
}

impl Mode {
    /// What is left of watched ranges on runs that are in the mode and judged; `None` if there are none.
    pub(crate) fn kept(&self, values: &[Interval]) -> Option<Vec<Interval>> {
        let mut known = kept(&self.facts, &kept(&self.domain, values)?)?;
        for &(at, _) in self.domain.iter().chain(&self.facts) {
            let Some((v, shift)) = self.shifted(at) else { continue };
            for other in (0..known.len()).filter(|&o| o != at) {
                let Some((w, by)) = self.shifted(other) else { continue };
                let same = || known[at].add(shift)?.sub(by);
                if let (true, Ok(range)) = (v == w, same()) {
                    known[other] = known[other].intersection(range).unwrap_or(known[other]);
                }
            }
        }
        Some(known)
    }

    /// What bounds of single variables in the domain and in a guard leave of a box; `None` if nothing.
    pub(crate) fn cut(&self, sides: &[Interval], guard: &Guard) -> Option<Vec<Interval>> {
        let mut found = sides.to_vec();
        for &(at, comparison) in self.domain.iter().chain(&self.facts).chain(guard) {
            let Some((v, shift)) = self.shifted(at) else { continue };
            let Ok(moved) = found[v].sub(shift) else { continue };
            let kept = comparison.keep(moved)?;
            if let Ok(back) = kept.add(shift) {
                found[v] = found[v].intersection(back).ok()?;
            }
        }
        Some(found)
    }

    /// The variable and the number whose difference a watched quantity is, if it is one.
    fn shifted(&self, at: usize) -> Option<(usize, Interval)> {
        let ops = &self.watch.ops;
        match ops[self.watch.outputs[at]] {
            Op::Variable(v) => Some((v, Interval::ZERO)),
            Op::Sub(a, b) => match (ops[a], ops[b]) {
                (Op::Variable(v), Op::Constant(c)) => Some((v, c)),
                _ => None,
            },
            _ => None,
        }
    }
}

/// When following may stop: never before the horizon, or where the claim certainly holds or fails.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Until {
    Horizon,
    Met,
    Violated,
    /// Nothing depends on time: where all states are among those of which others were followed from, or the same before.
    Passed,
}

/// Limits of the analysis.
#[derive(Debug, Clone)]
pub struct Budget {
    pub jumps: usize,
    pub stretches: usize,
    /// How often a set may be cut where a jump is not transversal.
    pub cuts: usize,
}

/// What is known of the claim during one step or right after a jump.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Judgement {
    pub holds: bool,
    pub fails: bool,
    /// Instants at which it holds on all runs that are in the stretch.
    pub met: Option<Interval>,
    /// Instants at which it fails on all of them, and there are such runs.
    pub violated: Option<Interval>,
}

/// One step of a stretch: all instants and states in it, the quantities the mode watches.
#[derive(Debug, Clone)]
pub struct Segment {
    /// For a second checker.
    pub taken: Taken,
    pub time: Interval,
    pub states: Vec<Interval>,
    pub watched: Vec<Interval>,
    pub claim: Judgement,
    pub keeps_window: bool,
    /// Whether no run ends here because of what else its domain says.
    pub stays: bool,
}

/// The part of a step that is a segment.
#[derive(Debug, Clone)]
pub struct Taken {
    pub path: Path,
    /// An instant at which it ends, and the watched quantity that crosses zero then, rising or not.
    pub until: Option<(Model, usize, bool)>,
    pub part: (f64, f64),
}

impl Taken {
    /// The first states during a part of the step; zero in place of those not wanted.
    pub(crate) fn states(&self, part: (f64, f64), count: usize, wanted: &[bool]) -> Result<Vec<Model>, Fault> {
        during(&self.path, self.until.as_ref().map(|u| &u.0), part, count, wanted)
    }
}

/// The jump that begins a stretch.
#[derive(Debug, Clone)]
pub struct Jump {
    pub edge: usize,
    pub time: Interval,
    pub before: Vec<Interval>,
    pub after: Vec<Interval>,
    pub claim: Judgement,
    /// The states after it, then those before it.
    pub landed: Arc<Set>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub enum End {
    Horizon,
    /// The claim's question was answered.
    Answered,
    /// All runs have jumped, or left the domain without a jump if it says so.
    Jumped {
        may_be_stuck: bool,
    },
    /// Cut in two stretches.
    Cut,
    /// All states are among those from which runs are followed elsewhere.
    Passed,
    Jumps,
    Steps,
    Stretches,
    Stopped(Fault),
}

/// Flow in one mode between jumps.
#[derive(Debug, Clone)]
pub struct Stretch {
    pub parent: Option<usize>,
    pub mode: usize,
    pub jumps: usize,
    pub is_certain: bool,
    pub jump: Option<Jump>,
    pub segments: Vec<Segment>,
    pub end: End,
    /// The states at the horizon, where they are known better than by the last segment.
    pub last: Option<Vec<Interval>>,
}

struct Waiting {
    parent: Option<usize>,
    mode: usize,
    set: Set,
    jumps: usize,
    cuts: usize,
    is_certain: bool,
    jump: Option<Jump>,
    known: Guard,
    sides: Vec<Interval>,
}

/// A jump that was made, and where it led to.
pub(crate) struct Landing {
    pub(crate) edge: usize,
    pub(crate) set: Set,
    jump: Jump,
    pub(crate) is_certain: bool,
    is_boxed: bool,
}

pub(crate) struct Analysis<'a> {
    pub(crate) modes: &'a [Mode],
    horizon: f64,
    until: Until,
    pub(crate) settings: &'a Settings,
    /// Where nothing can happen on the way.
    strides: &'a Settings,
    budget: &'a Budget,
    waiting: VecDeque<Waiting>,
    found: Vec<Stretch>,
    /// Where no horizon ends the analysis: boxes from which runs are followed, by mode; time is left out.
    passed: Vec<(usize, Vec<Interval>)>,
    /// Steps tried in all stretches.
    taken: usize,
}

impl Landing {
    /// The same for further landings by the edge.
    pub(crate) fn widen(&mut self, other: &Landing) -> Result<(), Fault> {
        let (mine, its) = (&mut self.jump, &other.jump);
        mine.time = mine.time.hull(its.time)?;
        for (x, y) in mine.before.iter_mut().zip(&its.before).chain(mine.after.iter_mut().zip(&its.after)) {
            *x = x.hull(*y)?;
        }
        let (a, b) = (&mut mine.claim, &its.claim);
        (a.holds, a.fails, a.violated) = (a.holds && b.holds, a.fails && b.fails, None);
        a.met = if a.holds { Some(mine.time) } else { None };
        let around: Vec<Interval> = mine.after.iter().chain(&mine.before).copied().collect();
        mine.landed = Arc::new(Set::of_box(&around, 1));
        Ok(())
    }
}

/// Where runs start: a mode, a box, comparisons of watched quantities that hold there exactly.
#[derive(Debug, Clone)]
pub struct Start {
    pub mode: usize,
    pub sides: Vec<Interval>,
    pub known: Guard,
}

/// Follow all runs from a box in a mode until the horizon.
pub fn reach(
    modes: &[Mode],
    start: &Start,
    horizon: f64,
    until: Until,
    settings: &Settings,
    budget: &Budget,
) -> Result<Vec<Stretch>, Fault> {
    check(modes, start)?;
    let set = Set::of_box(&start.sides, settings.degree.max(1));
    let known = start.known.clone();
    let first = Waiting {
        parent: None,
        mode: start.mode,
        set,
        jumps: 0,
        cuts: 0,
        is_certain: true,
        jump: None,
        known,
        sides: start.sides.clone(),
    };
    let waiting = VecDeque::from([first]);
    let states = start.sides[..start.sides.len() - 1].to_vec();
    let passed = vec![(start.mode, states)];
    let strides = Settings { longest_step: STRIDE * settings.longest_step, ..settings.clone() };
    let strides = &strides;
    let found = Vec::new();
    let mut analysis = Analysis { modes, horizon, until, settings, strides, budget, waiting, found, passed, taken: 0 };
    while let Some(next) = analysis.waiting.pop_front() {
        allowed()?;
        // What waits is told too: a stretch without successors in the tree would seem to have none.
        let is_over = analysis.found.len() >= budget.stretches;
        let stretch = if is_over { bare(&next, End::Stretches) } else { analysis.follow(next) };
        analysis.found.push(stretch);
    }
    Ok(analysis.found)
}

/// Positions that do not exist are refused here, so that nothing panics later.
pub(crate) fn check(modes: &[Mode], start: &Start) -> Result<(), Fault> {
    let n = start.sides.len();
    let within = |guard: &Guard, count: usize| guard.iter().all(|(at, _)| *at < count);
    let is_good = |m: &Mode| {
        let count = m.watch.outputs.len();
        let edge = |e: &Edge| {
            e.target < modes.len()
                && within(&e.guard, count)
                && e.reset.outputs.len() == n
                && e.claim.reach() <= e.landing.outputs.len()
        };
        m.field.outputs.len() == n
            && within(&m.domain, count)
            && within(&m.facts, count)
            && m.claim.reach().max(m.window.reach()).max(m.rest.reach()) <= count
            && m.edges.iter().all(edge)
    };
    let knows = |m: &Mode| within(&start.known, m.watch.outputs.len());
    if modes.get(start.mode).is_some_and(knows) && n > 0 && modes.iter().all(is_good) {
        Ok(())
    } else {
        Err(Fault::Unknown)
    }
}

/// Two truths taken together.
fn both(a: Option<bool>, b: Option<bool>) -> Option<bool> {
    match (a, b) {
        (Some(false), _) | (_, Some(false)) => Some(false),
        (Some(true), other) => other,
        (None, _) => None,
    }
}

fn ranges_of(flow: &Flow, step: &Step, during: Interval) -> Result<Vec<Interval>, Fault> {
    flow.states(step, during)?.iter().map(|m| flow.space.range(m)).collect()
}

fn bare(from: &Waiting, end: End) -> Stretch {
    Stretch {
        parent: from.parent,
        mode: from.mode,
        jumps: from.jumps,
        is_certain: from.is_certain,
        jump: from.jump.clone(),
        segments: Vec::new(),
        end,
        last: None,
    }
}

impl<'a> Analysis<'a> {
    fn follow(&mut self, mut from: Waiting) -> Stretch {
        if self.until == Until::Passed && from.jump.is_some() {
            match self.boxed(&from) {
                Ok(Some(set)) => (from.set, from.is_certain, from.known) = (set, false, Vec::new()),
                Ok(None) => return bare(&from, End::Passed),
                Err(fault) => return bare(&from, End::Stopped(fault)),
            }
        }
        if from.jumps > self.budget.jumps {
            return bare(&from, End::Jumps);
        }
        let mode = &self.modes[from.mode];
        let stretch = bare(&from, End::Steps);
        let is_free = mode.edges.is_empty() && mode.domain.is_empty() && mode.inputs.is_none();
        let settings = if is_free { self.strides } else { self.settings };
        let flow = Flow::new(&mode.field, from.set, settings).with_inputs(mode.inputs.as_ref());
        let number = self.found.len();
        let mut walk = Walk {
            number,
            mode,
            flow,
            stretch,
            cuts: from.cuts,
            paced: 0,
            known: from.known,
            sides: from.sides,
            spreading: Spreading::default(),
        };
        match self.walked(&mut walk) {
            Ok(end) => walk.stretch.end = end,
            Err(fault) => walk.stretch.end = End::Stopped(fault),
        }
        self.settle(&mut walk);
        walk.stretch
    }

    fn walked(&mut self, walk: &mut Walk<'a>) -> Result<End, Fault> {
        if self.is_answered(walk.stretch.jump.as_ref().map(|j| &j.claim)) {
            return Ok(End::Answered);
        }
        if let Some(end) = self.jumped_at_once(walk)? {
            return Ok(end);
        }
        let mut h = walk.flow.settings().first_step.min(walk.flow.settings().longest_step);
        while walk.stretch.segments.len() < self.settings.steps && self.taken < TREE * self.settings.steps {
            self.taken += 1;
            let left = self.horizon - walk.time()?.low();
            if left <= 0.0 && !walk.stretch.segments.is_empty() {
                return Ok(End::Horizon);
            }
            // A horizon of zero is looked at for a little longer.
            let left = left.max(self.settings.least_step);
            let (step, next) = walk.flow.step(if h < left { h } else { left.next_up() })?;
            let quiet = walk.quiet(&step, 0.0, step.h, self.settings.depth + 2);
            if quiet >= step.h && !walk.spreading.has_begun && walk.pace_ahead(&step)? {
                // The same way again, at the new pace.
            } else if quiet >= step.h {
                self.pass(walk, &step)?;
                h = next;
            } else if walk.spreading.has_begun {
                if !self.spread(walk, &step)? {
                    return Ok(End::Jumped { may_be_stuck: walk.spreading.may_be_stuck });
                }
                h = next;
            } else if let Some(end) = self.crossed(walk, &step)? {
                return Ok(end);
            } else if walk.pace(&step)? {
                // The same way again, at the new pace.
            } else if let Some(end) = self.crossed_later(walk, (LONGER * step.h).min(left.next_up()))? {
                return Ok(end);
            } else if quiet > step.h / 16.0 {
                h = next.min(step.h);
                let step = walk.flow.shortened(step, quiet)?;
                self.pass(walk, &step)?;
            } else if self.open_jumps(walk, &step)? {
                // The flow goes on beside its jumps.
            } else if let Some(end) = self.cut(walk)? {
                return Ok(end);
            } else if !self.spread(walk, &step)? {
                return Ok(End::Jumped { may_be_stuck: walk.spreading.may_be_stuck });
            }
            if self.is_answered(walk.stretch.segments.last().map(|s| &s.claim)) {
                return Ok(End::Answered);
            }
            // Where the stretch starts is among those itself: it is only followed by going on from there.
            let has_moved = !walk.stretch.segments.is_empty();
            if self.until == Until::Passed && has_moved && self.is_passed(walk.stretch.mode, &walk.set()?.hull()?) {
                return Ok(End::Passed);
            }
        }
        Ok(End::Steps)
    }

    fn is_answered(&self, claim: Option<&Judgement>) -> bool {
        match self.until {
            Until::Horizon | Until::Passed => false,
            Until::Met => claim.is_some_and(|c| c.met.is_some()),
            Until::Violated => claim.is_some_and(|c| c.violated.is_some()),
        }
    }

    /// Whether the states of a box with a time are all among those from which runs are followed.
    fn is_passed(&self, mode: usize, hull: &[Interval]) -> bool {
        let inside =
            |known: &[Interval]| known.iter().zip(hull).all(|(k, x)| k.low() <= x.low() && x.high() <= k.high());
        self.passed.iter().any(|(m, known)| *m == mode && inside(known))
    }

    /// The box from which a landing is followed: wider than it where landings in the mode do not come to an end. `None`
    /// where its runs are followed elsewhere.
    fn boxed(&mut self, from: &Waiting) -> Result<Option<Set>, Fault> {
        let mode = &self.modes[from.mode];
        let Some(mut hull) = mode.cut(&from.set.hull()?, &Vec::new()) else { return Ok(None) };
        if self.is_passed(from.mode, &hull) {
            return Ok(None);
        }
        let before: Vec<&Vec<Interval>> = self.passed.iter().filter(|(m, _)| *m == from.mode).map(|(_, b)| b).collect();
        if before.len() >= LANDINGS {
            let last = before[before.len() - 1].clone();
            for (x, known) in hull.iter_mut().zip(&last) {
                let both = x.hull(*known)?;
                *x = both.add(Interval::symmetric(WIDENED * both.width()?)?)?;
            }
            hull = mode.cut(&hull, &Vec::new()).ok_or(Fault::Crossing)?;
        }
        self.passed.push((from.mode, hull[..hull.len() - 1].to_vec()));
        Ok(Some(Set::of_box(&hull, self.settings.degree.max(1))))
    }

    /// Record a step without events and take it.
    fn pass(&self, walk: &mut Walk, step: &Step) -> Result<(), Fault> {
        walk.record(step, &Clock::Same, self.settings.depth, self.settings.longest_step)?;
        let end = self.end_within(walk, step)?;
        walk.flow.land(step)?;
        if let Some((instants, during)) = end {
            walk.stretch.last = Some(walk.flow.arrived(step, instants, &during)?);
        }
        Ok(())
    }

    /// The instants of a step that may be the horizon, and the states then, where time is the same for all.
    fn end_within(&self, walk: &Walk, step: &Step) -> Result<Option<(Interval, Vec<Interval>)>, Fault> {
        let time = walk.time()?;
        if walk.paced > 0 || time.width()? > 1e-9 * self.horizon || time.low() + step.h < self.horizon {
            return Ok(None);
        }
        let first = (self.horizon - time.high()).next_down().clamp(0.0, step.h);
        let last = (self.horizon - time.low()).next_up().clamp(first, step.h);
        let instants = Interval::new(first, last)?;
        Ok(Some((instants, ranges_of(&walk.flow, step, instants)?)))
    }

    /// The stretch ends where the whole set crosses the border of the domain, or that of an urgent guard.
    fn crossed(&mut self, walk: &mut Walk<'a>, step: &Step) -> Result<Option<End>, Fault> {
        for (quantity, is_rising) in walk.events() {
            let tape = walk.quantity(quantity);
            let Ok(Some(found)) = walk.flow.crossing(step, &tape, is_rising) else { continue };
            let event = Event { quantity, is_rising, instant: &found.instant };
            if let Some(end) = self.left(walk, step, &event, &found.states)? {
                return Ok(Some(end));
            }
        }
        Ok(None)
    }

    /// The same in a longer step than is usual: what the set misses may take it that long to cross.
    fn crossed_later(&mut self, walk: &mut Walk<'a>, wanted: f64) -> Result<Option<End>, Fault> {
        if walk.paced == 0 {
            return Ok(None);
        }
        let (longer, _) = walk.flow.step(wanted)?;
        self.crossed(walk, &longer)
    }

    /// Take the jumps at a crossing and those that are possible before it, if it ends the stretch and no urgent edge may
    /// be due before it.
    fn left(
        &mut self,
        walk: &mut Walk<'a>,
        step: &Step,
        event: &Event,
        states: &[Model],
    ) -> Result<Option<End>, Fault> {
        let depth = self.settings.depth + 2;
        let everything: Vec<usize> = (0..walk.mode.edges.len()).collect();
        let (urgent, open): (Vec<usize>, Vec<usize>) = everything.iter().partition(|&&e| walk.mode.edges[e].is_urgent);
        let is_quiet = walk.is_quiet_before(step, event, &everything, depth)?;
        if !is_quiet && (open.is_empty() || !walk.is_quiet_before(step, event, &urgent, depth)?) {
            return Ok(None);
        }
        let mut set = Set { space: walk.flow.space.clone(), models: states[..walk.mode.field.outputs.len()].to_vec() };
        // What crosses a number is that number then.
        if let Some((v, number)) = walk.mode.shifted(event.quantity) {
            set.models[v] = set.space.constant(number);
        }
        let mut landings = Vec::new();
        for (edge, is_certain) in walk.enabled(states, event)? {
            landings.extend(self.landing(walk, edge, &set, is_certain)?);
        }
        let is_exit = walk.mode.domain.iter().any(|&(q, c)| q == event.quantity && leaves(c, event.is_rising));
        let is_forced = landings.iter().any(|l| l.is_certain && walk.mode.edges[l.edge].is_urgent);
        if !is_exit && !is_forced {
            return Ok(None);
        }
        walk.record(step, &Clock::Until(event), self.settings.depth, self.settings.longest_step)?;
        if !is_quiet {
            for edge in open {
                let Some(part) = walk.possible_before(step, event, edge, (0.0, 1.0), depth)? else { continue };
                let mut early = walk.states_before(step, event, part)?;
                if self.until == Until::Passed {
                    let guard = &walk.mode.edges[edge].guard;
                    let Some(sides) = walk.mode.cut(&early.hull()?, guard) else { continue };
                    early = Set::of_box(&sides, self.settings.degree.max(1));
                }
                self.landing(walk, edge, &early, false)?.into_iter().for_each(|l| self.leave(walk, l));
            }
        }
        if self.is_answered(walk.stretch.segments.last().map(|s| &s.claim)) {
            return Ok(Some(End::Answered));
        }
        let may_be_stuck = !landings.iter().any(|l| l.is_certain);
        landings.into_iter().for_each(|l| self.leave(walk, l));
        Ok(Some(End::Jumped { may_be_stuck }))
    }

    /// What a jump makes of a set; `None` where it leads out of the target's domain, so that there is no such jump.
    pub(crate) fn landing(
        &self,
        walk: &Walk<'a>,
        number: usize,
        set: &Set,
        is_certain: bool,
    ) -> Result<Option<Landing>, Fault> {
        let edge = &walk.mode.edges[number];
        let wide = if edge.choices > 0 { set.with_choices(edge.choices) } else { set.clone() };
        let before = &wide.models[..set.models.len()];
        let after = values(&wide.space, &edge.reset, &wide.models)?;
        let target = &self.modes[edge.target];
        let watched = ranges(&wide, &values(&wide.space, &target.watch, &after)?)?;
        let arrives = both(all(&target.domain, &watched), target.rest.truth(&watched));
        if arrives == Some(false) {
            return Ok(None);
        }
        let is_certain = is_certain && arrives == Some(true);
        let pair: Vec<Model> = after.iter().chain(before).cloned().collect();
        let landed = Arc::new(Set { space: wide.space.clone(), models: pair });
        let quantities = edge.quantities(&landed)?;
        let hull = ranges(&wide, &after)?;
        let time = *hull.last().ok_or(Fault::Unknown)?;
        let claim = judged(edge.claim.truth(&quantities), time, is_certain && walk.stretch.is_certain);
        let jump = Jump { edge: number, time, before: ranges(&wide, before)?, after: hull, claim, landed };
        let set = Set { space: wide.space, models: after };
        // A box may have states that no run comes to; parts of it may have no others.
        let is_boxed = set.space.variables > set.models.len() + SPARE;
        let set = if is_boxed { Set::of_box(&set.hull()?, self.settings.degree.max(1)) } else { set };
        Ok(Some(Landing { edge: number, set, jump, is_certain, is_boxed }))
    }

    pub(crate) fn leave(&mut self, walk: &Walk<'a>, mut landing: Landing) {
        if !walk.stretch.is_certain {
            landing.jump.claim.violated = None;
        }
        let target = walk.mode.edges[landing.edge].target;
        self.waiting.push_back(Waiting {
            parent: Some(walk.number),
            mode: target,
            set: landing.set,
            jumps: walk.stretch.jumps + 1,
            cuts: walk.cuts,
            is_certain: landing.is_certain && !landing.is_boxed && walk.stretch.is_certain,
            known: self.modes[target].borders(&landing.jump.after),
            sides: landing.jump.after.clone(),
            jump: Some(landing.jump),
        });
    }

    /// Jumps that are possible at some instants of the step and forced at none: each is made from all of these states at
    /// once, and the flow goes on. False where the flow may have to leave the domain.
    fn open_jumps(&mut self, walk: &mut Walk<'a>, step: &Step) -> Result<bool, Fault> {
        let depth = self.settings.depth + 2;
        if !walk.stays(step, 0.0, step.h, depth) || walk.may_be_urgent(step, depth)? {
            return Ok(false);
        }
        walk.record(step, &Clock::Same, self.settings.depth, self.settings.longest_step)?;
        for number in 0..walk.mode.edges.len() {
            let Some(part) = walk.possible(step, &walk.mode.edges[number].guard, 0.0, step.h, depth)? else { continue };
            let set = if self.until == Until::Passed {
                let Some(set) = self.at_guard(walk, step, part, &walk.mode.edges[number].guard)? else { continue };
                set
            } else {
                let mut models = walk.flow.states(step, part)?;
                models.truncate(walk.mode.field.outputs.len());
                Set { space: walk.flow.space.clone(), models }
            };
            if let Some(landing) = self.landing(walk, number, &set, false)? {
                self.leave(walk, landing);
            }
        }
        walk.flow.land(step)?;
        Ok(true)
    }

    /// Go on with the halves of the set, where it may help: inputs spread smaller sets as well.
    fn cut(&mut self, walk: &mut Walk<'a>) -> Result<Option<End>, Fault> {
        if walk.cuts >= self.budget.cuts || walk.mode.inputs.is_some() || self.until == Until::Passed {
            return Ok(None);
        }
        let Some(halves) = walk.set()?.halves() else { return Ok(None) };
        for set in halves {
            self.waiting.push_back(Waiting {
                parent: Some(walk.number),
                mode: walk.stretch.mode,
                set,
                jumps: walk.stretch.jumps,
                cuts: walk.cuts + 1,
                is_certain: walk.stretch.is_certain,
                jump: None,
                known: Vec::new(),
                sides: Vec::new(),
            });
        }
        Ok(Some(End::Cut))
    }
}
