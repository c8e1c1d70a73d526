//! Trees of stretches against runs that are known in closed form.

use _kernel::condition::{Comparison, Condition};
use _kernel::flowpipe::Settings;
use _kernel::hybrid::{paced, reach, Budget, Edge, End, Jump, Mode, Start, Stretch, Until};
use _kernel::interval::Interval;
use _kernel::series::{Op, Tape};

const G: f64 = 9.75; // a float, so that the closed forms are about the same numbers

fn interval(low: f64, high: f64) -> Interval {
    Interval::new(low, high).expect("ends in order")
}

fn exactly(x: f64) -> Op {
    Op::Constant(interval(x, x))
}

fn tape(ops: Vec<Op>, outputs: Vec<usize>, variables: usize) -> Tape {
    Tape::validated(ops, outputs, variables).expect("a tape")
}

/// Height, speed, time; what is watched are height and speed.
fn ball(edge: Edge, claim: Condition) -> Mode {
    let field = tape(vec![Op::Variable(1), exactly(-G), exactly(1.0)], vec![0, 1, 2], 3);
    Mode {
        paced: paced(&field).expect("a tape"),
        field,
        watch: tape(vec![Op::Variable(0), Op::Variable(1)], vec![0, 1], 3),
        domain: vec![(0, Comparison::AtLeast)],
        rest: Condition::Constant(true),
        inputs: None,
        facts: Vec::new(),
        claim,
        window: Condition::Constant(true),
        edges: vec![edge],
    }
}

/// The ball turns with half of its speed.
fn bounce(is_urgent: bool) -> Edge {
    let half = vec![exactly(0.0), Op::Variable(1), exactly(-0.5), Op::Mul(1, 2), Op::Variable(2)];
    Edge {
        target: 0,
        is_urgent,
        guard: vec![(0, Comparison::AtMost), (1, Comparison::Less)],
        reset: tape(half, vec![0, 3, 4], 3),
        choices: 0,
        landing: tape(vec![Op::Variable(1)], vec![0], 6),
        claim: Condition::Atom(0, Comparison::Greater),
    }
}

fn settings() -> Settings {
    Settings {
        order: 8,
        degree: 4,
        tolerance: 1e-8,
        first_step: 0.05,
        longest_step: 0.3,
        least_step: 1e-9,
        steps: 500,
        depth: 3,
    }
}

fn follow(modes: &[Mode], sides: Vec<Interval>, horizon: f64, until: Until) -> Vec<Stretch> {
    let start = Start { mode: 0, sides, known: Vec::new() };
    let budget = Budget { jumps: 20, stretches: 100, cuts: 4 };
    reach(modes, &start, horizon, until, &settings(), &budget).expect("a tree")
}

fn dropped_from(low: f64, high: f64) -> Vec<Interval> {
    vec![interval(low, high), interval(0.0, 0.0), interval(0.0, 0.0)]
}

#[test]
fn a_ball_bounces_when_it_should() {
    let tree = follow(&[ball(bounce(true), Condition::Constant(true))], dropped_from(1.0, 1.2), 1.2, Until::Horizon);
    let first = tree[1].jump.as_ref().expect("it bounces");
    let (soonest, latest) = ((2.0 / G).sqrt(), (2.4 / G).sqrt());
    assert!(first.time.low() <= soonest && latest <= first.time.high());
    assert!(soonest - first.time.low() < 1e-3 && first.time.high() - latest < 1e-3, "{:?}", first.time);
    // Each way up and down again takes half as long as the one before it: it lands at 1 and 2 and 2.5 times the fall.
    let second = tree[2].jump.as_ref().expect("it bounces again");
    assert!(second.time.low() <= 2.0 * soonest && 2.0 * latest <= second.time.high());
    assert!(second.time.high() - 2.0 * latest < 1e-2);
    assert!(tree.iter().all(|s| s.is_certain && s.claim_holds_where_it_lands()));
    assert!(tree[..2].iter().all(|s| s.end == End::Jumped { may_be_stuck: false }));
}

trait Lands {
    fn claim_holds_where_it_lands(&self) -> bool;
}

impl Lands for Stretch {
    fn claim_holds_where_it_lands(&self) -> bool {
        self.jump.as_ref().is_none_or(|j| j.claim.holds)
    }
}

#[test]
fn a_domain_forces_a_jump_that_is_not_urgent() {
    let tree = follow(&[ball(bounce(false), Condition::Constant(true))], dropped_from(1.0, 1.0), 0.6, Until::Horizon);
    assert_eq!(tree.len(), 2);
    assert!(tree[1].is_certain && tree[1].end == End::Horizon);
}

#[test]
fn states_at_all_instants_are_in_a_step_of_their_stretch() {
    let tree = follow(&[ball(bounce(true), Condition::Constant(true))], dropped_from(0.9, 1.1), 1.2, Until::Horizon);
    for height in [0.9, 0.95, 1.0, 1.1] {
        for k in 0..=120 {
            let t = f64::from(k) / 100.0;
            let (jumps, x, v) = at(height, t);
            let is_in = |s: &Stretch| {
                s.jumps == jumps
                    && s.segments
                        .iter()
                        .any(|g| g.time.contains(t) && g.states[0].contains(x) && g.states[1].contains(v))
            };
            assert!(tree.iter().any(is_in), "from {height} at {t}: {x}, {v} after {jumps}");
        }
    }
}

/// The number of bounces before `t`, height and speed then, for a ball dropped from a height.
fn at(height: f64, t: f64) -> (usize, f64, f64) {
    let fall = (2.0 * height / G).sqrt();
    let (mut jumps, mut start, mut speed) = (0, -fall, G * fall);
    let mut flight = 2.0 * fall;
    while t > start + flight {
        start += flight;
        flight *= 0.5;
        speed *= 0.5;
        jumps += 1;
    }
    let s = t - start;
    (jumps, speed * s - 0.5 * G * s * s, speed - G * s)
}

#[test]
fn a_violation_of_certain_runs_is_certain() {
    let low = Condition::Atom(1, Comparison::Less);
    let tree = follow(&[ball(bounce(true), low)], dropped_from(1.0, 1.0), 1.0, Until::Violated);
    let violated: Vec<_> = tree.iter().flat_map(|s| &s.segments).filter_map(|g| g.claim.violated).collect();
    let after = (2.0 / G).sqrt();
    assert!(!violated.is_empty() && violated.iter().all(|t| t.high() >= after || t.low() <= 1e-6));
}

#[test]
fn a_claim_that_holds_is_never_violated() {
    let slow = Condition::Atom(0, Comparison::AtLeast);
    let tree = follow(&[ball(bounce(true), slow)], dropped_from(0.8, 1.0), 1.3, Until::Horizon);
    assert!(tree.iter().flat_map(|s| &s.segments).all(|g| g.claim.holds && g.claim.violated.is_none()));
}

#[test]
fn where_the_guard_is_closed_too_early_runs_may_be_stuck() {
    let mut edge = bounce(true);
    edge.guard.push((1, Comparison::Greater));
    let tree = follow(&[ball(edge, Condition::Constant(true))], dropped_from(1.0, 1.1), 1.0, Until::Horizon);
    assert_eq!(tree.len(), 1);
    assert_eq!(tree[0].end, End::Jumped { may_be_stuck: true });
}

#[test]
fn a_flow_that_touches_its_border_may_jump_or_go_on() {
    // x' = v, v' = 2: from x = 1, v = -2 the least height is 0, reached at 1 with v = 0; it is at 1 again at 2.
    let mut mode = ball(bounce(true), Condition::Constant(true));
    mode.field = tape(vec![Op::Variable(1), exactly(2.0), exactly(1.0)], vec![0, 1, 2], 3);
    mode.paced = paced(&mode.field).expect("a tape");
    let touching = vec![interval(1.0, 1.0), interval(-2.0, -2.0), interval(0.0, 0.0)];
    let tree = follow(&[mode], touching, 2.0, Until::Horizon);
    assert!(!tree[0].is_certain);
    let holds = |s: &Stretch, t: f64, x: f64| s.segments.iter().any(|g| g.time.contains(t) && g.states[0].contains(x));
    for t in [0.5_f64, 1.0, 1.5, 2.0] {
        assert!(holds(&tree[0], t, (t - 1.0) * (t - 1.0)), "{t}");
    }
    let touched = |j: &Jump| j.time.contains(1.0) && j.after[0].contains(0.0) && j.after[1].contains(0.0);
    assert!(tree.iter().filter_map(|s| s.jump.as_ref()).any(touched));
}

#[test]
fn choices_after_a_jump_are_all_enclosed() {
    // After the bounce the speed is anything from 1 to 3.
    let mut edge = bounce(true);
    let chosen = vec![exactly(0.0), exactly(2.0), Op::Variable(3), Op::Add(1, 2), Op::Variable(2)];
    edge.reset = tape(chosen, vec![0, 3, 4], 4);
    edge.choices = 1;
    let tree = follow(&[ball(edge, Condition::Constant(true))], dropped_from(1.0, 1.0), 0.6, Until::Horizon);
    let after = tree[1].jump.as_ref().expect("it bounces").after[1];
    assert!(after.low() <= 1.0 && 3.0 <= after.high() && after.high() < 3.001);
    let fall = (2.0 / G).sqrt();
    for speed in [1.0, 2.0, 3.0] {
        let (t, x) = (fall + 0.05, speed * 0.05 - 0.5 * G * 0.0025);
        let holds = |s: &Stretch| s.segments.iter().any(|g| g.time.contains(t) && g.states[0].contains(x));
        assert!(tree.iter().any(|s| s.jumps == 1 && holds(s)));
    }
}

#[test]
fn a_jump_that_may_wait_is_made_at_any_time() {
    // x' = 1 in a mode that may be left for one with x' = 0 from x = 1 on, and must be at x = 2.
    let rate = |r: f64| tape(vec![exactly(r), exactly(1.0)], vec![0, 1], 2);
    let keep = tape(vec![Op::Variable(0), Op::Variable(1)], vec![0, 1], 2);
    let edge = Edge {
        target: 1,
        is_urgent: false,
        guard: vec![(1, Comparison::AtLeast)],
        reset: keep,
        choices: 0,
        landing: tape(vec![Op::Variable(0)], vec![0], 4),
        claim: Condition::Constant(true),
    };
    let watch = tape(vec![Op::Variable(0), exactly(1.0), Op::Sub(0, 1), exactly(2.0), Op::Sub(0, 3)], vec![0, 2, 4], 2);
    let mode = |r: f64, domain, edges| Mode {
        field: rate(r),
        paced: paced(&rate(r)).expect("a tape"),
        watch: watch.clone(),
        domain,
        rest: Condition::Constant(true),
        inputs: None,
        facts: Vec::new(),
        claim: Condition::Constant(true),
        window: Condition::Constant(true),
        edges,
    };
    let modes = [mode(1.0, vec![(2, Comparison::AtMost)], vec![edge]), mode(0.0, Vec::new(), Vec::new())];
    let tree = follow(&modes, vec![interval(0.0, 0.1), interval(0.0, 0.0)], 3.0, Until::Horizon);
    for x in [1.0, 1.3, 1.77, 2.0] {
        let rests =
            |s: &Stretch| s.mode == 1 && s.segments.iter().any(|g| g.time.contains(2.9) && g.states[0].contains(x));
        assert!(tree.iter().any(rests), "{x}");
    }
    assert!(tree.iter().all(|s| matches!(s.end, End::Horizon | End::Jumped { .. } | End::Cut)));
}

/// `x' = -x / 10` down to 1, then at rest: from `x` the jump is after `10 log x`.
fn decay(start: Interval) -> Vec<Stretch> {
    let field = |rate: f64| tape(vec![Op::Variable(0), exactly(rate), Op::Mul(0, 1), exactly(1.0)], vec![2, 3], 2);
    let watch = tape(vec![Op::Variable(0), exactly(1.0), Op::Sub(0, 1)], vec![2], 2);
    let edge = Edge {
        target: 1,
        is_urgent: true,
        guard: vec![(0, Comparison::AtMost)],
        reset: tape(vec![Op::Variable(0), Op::Variable(1)], vec![0, 1], 2),
        choices: 0,
        landing: tape(vec![Op::Variable(0)], vec![0], 4),
        claim: Condition::Constant(true),
    };
    let mode = |rate: f64, domain, edges| Mode {
        field: field(rate),
        paced: paced(&field(rate)).expect("a tape"),
        watch: watch.clone(),
        domain,
        rest: Condition::Constant(true),
        inputs: None,
        facts: Vec::new(),
        claim: Condition::Constant(true),
        window: Condition::Constant(true),
        edges,
    };
    let modes = [mode(-0.1, vec![(0, Comparison::AtLeast)], vec![edge]), mode(0.0, Vec::new(), Vec::new())];
    let start = Start { mode: 0, sides: vec![start, interval(0.0, 0.0)], known: Vec::new() };
    let budget = Budget { jumps: 1, stretches: 10, cuts: 0 };
    reach(&modes, &start, 25.0, Until::Horizon, &settings(), &budget).expect("a tree")
}

#[test]
fn a_set_that_takes_many_steps_to_cross_does_so_as_a_whole() {
    let tree = decay(interval(4.0, 6.0));
    assert_eq!(tree.len(), 2);
    assert_eq!(tree[0].end, End::Jumped { may_be_stuck: false });
    assert!(tree[1].is_certain && tree[1].end == End::Horizon);
    let found = tree[1].jump.as_ref().expect("it jumps").time;
    let (soonest, latest) = (10.0 * 4f64.ln(), 10.0 * 6f64.ln());
    assert!(found.low() <= soonest && latest <= found.high(), "{found:?}");
    assert!(soonest - found.low() < 0.3 && found.high() - latest < 0.3, "{found:?}");
    // Each start jumps in what is found for it alone, and that is in what is found for all.
    for x in [4.0, 4.7, 5.5, 6.0] {
        let alone = decay(interval(x, x))[1].jump.as_ref().expect("it jumps").time;
        assert!(alone.contains(10.0 * f64::ln(x)) && found.low() <= alone.low() && alone.high() <= found.high());
    }
}

#[test]
fn positions_that_do_not_exist_are_refused() {
    let mut edge = bounce(true);
    edge.target = 7;
    let start = Start { mode: 0, sides: dropped_from(1.0, 1.0), known: Vec::new() };
    let budget = Budget { jumps: 1, stretches: 1, cuts: 0 };
    let modes = [ball(edge, Condition::Constant(true))];
    assert!(reach(&modes, &start, 1.0, Until::Horizon, &settings(), &budget).is_err());
}
