//! A tree that is kept answers for other claims what a tree grown for them says.

use _kernel::condition::{Comparison, Condition};
use _kernel::flowpipe::Settings;
use _kernel::hybrid::{paced, reach, Budget, Edge, Mode, Start, Stretch, Until};
use _kernel::interval::Interval;
use _kernel::series::{Op, Tape};
use _kernel::tree::Tree;

const G: f64 = 9.75;

fn interval(low: f64, high: f64) -> Interval {
    Interval::new(low, high).expect("ends in order")
}

fn exactly(x: f64) -> Op {
    Op::Constant(interval(x, x))
}

fn tape(ops: Vec<Op>, outputs: Vec<usize>, variables: usize) -> Tape {
    Tape::validated(ops, outputs, variables).expect("a tape")
}

/// A ball that loses half of its speed at the ground; what is watched are height, speed, and how far it is below `top`.
fn ball(top: f64, claim: Condition, landing: Condition) -> Mode {
    let field = tape(vec![Op::Variable(1), exactly(-G), exactly(1.0)], vec![0, 1, 2], 3);
    let half = vec![exactly(0.0), Op::Variable(1), exactly(-0.5), Op::Mul(1, 2), Op::Variable(2)];
    let edge = Edge {
        target: 0,
        is_urgent: true,
        guard: vec![(0, Comparison::AtMost), (1, Comparison::Less)],
        reset: tape(half, vec![0, 3, 4], 3),
        choices: 0,
        landing: tape(vec![Op::Variable(1), exactly(3.0), Op::Sub(0, 1)], vec![0, 2], 6),
        claim: landing,
    };
    Mode {
        paced: paced(&field).expect("a tape"),
        field,
        watch: tape(vec![Op::Variable(0), Op::Variable(1), exactly(top), Op::Sub(0, 2)], vec![0, 1, 3], 3),
        domain: vec![(0, Comparison::AtLeast)],
        rest: Condition::Constant(true),
        inputs: None,
        facts: Vec::new(),
        claim,
        window: Condition::Constant(true),
        edges: vec![edge],
    }
}

fn below(top: f64) -> Mode {
    ball(top, Condition::Atom(2, Comparison::AtMost), Condition::Atom(1, Comparison::Less))
}

fn grown(mode: Mode) -> Tree {
    let settings = Settings {
        order: 8,
        degree: 4,
        tolerance: 1e-8,
        first_step: 0.05,
        longest_step: 0.1,
        least_step: 1e-9,
        steps: 500,
        depth: 3,
    };
    let start =
        Start { mode: 0, sides: vec![interval(1.0, 1.2), interval(0.0, 0.0), interval(0.0, 0.0)], known: vec![] };
    let budget = Budget { jumps: 5, stretches: 20, cuts: 4 };
    let modes = vec![mode];
    let stretches = reach(&modes, &start, 1.2, Until::Horizon, &settings, &budget).expect("a tree");
    Tree { modes, sides: start.sides, depth: settings.depth, stretches }
}

fn holds(stretches: &[Stretch]) -> Vec<(Option<bool>, Vec<bool>)> {
    let of = |s: &Stretch| (s.jump.as_ref().map(|j| j.claim.holds), s.segments.iter().map(|g| g.claim.holds).collect());
    stretches.iter().map(of).collect()
}

#[test]
fn other_claims_are_judged_as_on_trees_of_their_own() {
    let kept = grown(ball(9.0, Condition::Constant(true), Condition::Constant(true)));
    for top in [1.3, 1.1, 0.4, 0.1] {
        let found = kept.judged(&[below(top)], &vec![], false).expect("the same ball");
        assert_eq!(holds(&found), holds(&grown(below(top)).stretches), "{top}");
    }
    let rising = ball(0.0, Condition::Constant(true), Condition::Atom(0, Comparison::Less));
    let found = kept.judged(&[rising], &vec![], false).expect("the same ball");
    assert!(found[1].jump.as_ref().is_some_and(|j| j.claim.fails && j.claim.violated.is_none()));
}

#[test]
fn the_middle_is_one_run_of_all() {
    let kept = grown(below(9.0));
    let (all, middle) = (&kept.stretches, kept.judged(&[below(9.0)], &vec![], true).expect("the same ball"));
    let fallen = |t: f64| 1.1 - 0.5 * G * t * t;
    for (a, m) in all[0].segments.iter().zip(&middle[0].segments) {
        assert!(a.watched[0].low() <= m.watched[0].low() && m.watched[0].high() <= a.watched[0].high());
        let t = 0.5 * (a.time.low() + a.time.high());
        assert!(t > 0.4 || m.watched[0].contains(fallen(t)), "{t}");
        let spread = a.watched[0].high() - a.watched[0].low();
        assert!(t > 0.4 || m.watched[0].high() - m.watched[0].low() <= spread - 0.15, "{t}");
    }
}

#[test]
fn another_automaton_is_refused() {
    let kept = grown(below(9.0));
    let mut heavy = below(9.0);
    heavy.field = tape(vec![Op::Variable(1), exactly(-2.0 * G), exactly(1.0)], vec![0, 1, 2], 3);
    assert!(kept.judged(&[heavy], &vec![], false).is_err());
    let mut free = below(9.0);
    free.domain.clear();
    assert!(kept.judged(&[free], &vec![], false).is_err());
    let mut lazy = below(9.0);
    lazy.edges[0].is_urgent = false;
    assert!(kept.judged(&[lazy], &vec![], false).is_err());
    let unknown = ball(9.0, Condition::Atom(7, Comparison::Less), Condition::Constant(true));
    assert!(kept.judged(&[unknown], &vec![], false).is_err());
    assert!(kept.judged(&[], &vec![], false).is_err());
    assert!(kept.size() > 0);
}
