//! How far a run is from violating a formula of bounded time logic, in the units of its comparisons.
//!
//! Dense time, on the pieces of the run: extrema are those of polynomials, not of samples (A. Donze, O. Maler, Robust
//! satisfaction of temporal logic over real-valued signals, 2010).

use crate::runs::Run;
use crate::signal::{greater, greatest_ahead, greatest_within, negated, Group, Segment, Signal, BEYOND};

#[derive(Debug, Clone, PartialEq)]
pub enum Formula {
    /// An observed quantity, which holds where it is positive.
    Atom(usize),
    Not(Box<Formula>),
    And(Vec<Formula>),
    Or(Vec<Formula>),
    Globally(f64, f64, Box<Formula>),
    Eventually(f64, f64, Box<Formula>),
    Until(f64, f64, Box<Formula>, Box<Formula>),
}

impl Formula {
    /// Whether `until` stands only where it is judged at the start.
    pub fn is_supported(&self) -> bool {
        match self {
            Formula::Atom(_) => true,
            Formula::Not(f) => f.is_supported(),
            Formula::And(fs) | Formula::Or(fs) => fs.iter().all(Formula::is_supported),
            Formula::Globally(_, _, f) | Formula::Eventually(_, _, f) => f.is_plain(),
            Formula::Until(_, _, f, g) => f.is_plain() && g.is_plain(),
        }
    }

    fn is_plain(&self) -> bool {
        match self {
            Formula::Atom(_) => true,
            Formula::Not(f) => f.is_plain(),
            Formula::And(fs) | Formula::Or(fs) => fs.iter().all(Formula::is_plain),
            Formula::Globally(_, _, f) | Formula::Eventually(_, _, f) => f.is_plain(),
            Formula::Until(..) => false,
        }
    }
}

/// The value of a formula at the start of a run.
pub fn robustness(run: &Run, formula: &Formula) -> f64 {
    match formula {
        Formula::Not(f) => -robustness(run, f),
        Formula::And(fs) => fs.iter().map(|f| robustness(run, f)).fold(BEYOND, f64::min),
        Formula::Or(fs) => fs.iter().map(|f| robustness(run, f)).fold(-BEYOND, f64::max),
        Formula::Eventually(a, b, f) => greatest_within(&signal(run, f), 0, *a, *b),
        Formula::Globally(a, b, f) => -greatest_within(&negated(&signal(run, f)), 0, *a, *b),
        Formula::Until(a, b, f, g) => until(&signal(run, f), &signal(run, g), *a, *b),
        Formula::Atom(_) => signal(run, formula).first().and_then(|g| g.first()).map_or(-BEYOND, |s| s.value(s.from)),
    }
}

fn signal(run: &Run, formula: &Formula) -> Signal {
    match formula {
        Formula::Atom(k) => quantity(run, *k),
        Formula::Not(f) => negated(&signal(run, f)),
        Formula::Or(fs) => joined(run, fs, false),
        Formula::And(fs) => negated(&joined(run, fs, true)),
        Formula::Eventually(a, b, f) => greatest_ahead(&signal(run, f), *a, *b),
        Formula::Globally(a, b, f) => negated(&greatest_ahead(&negated(&signal(run, f)), *a, *b)),
        Formula::Until(..) => Vec::new(),
    }
}

fn joined(run: &Run, formulas: &[Formula], is_negated: bool) -> Signal {
    let one = |f: &Formula| if is_negated { negated(&signal(run, f)) } else { signal(run, f) };
    let mut all = formulas.iter().map(one);
    let first = all.next().unwrap_or_default();
    all.fold(first, |a, b| greater(&a, &b))
}

/// An observed quantity, a group for each stay; a landing is a group of its own.
fn quantity(run: &Run, k: usize) -> Signal {
    let mut found: Signal = Vec::new();
    let mut last = None;
    for p in &run.pieces {
        let key = (p.jumps, p.is_landing);
        if last != Some(key) {
            found.push(Vec::new());
            last = Some(key);
        }
        let width = p.width();
        let series = p.observed[k * width..(k + 1) * width].to_vec();
        let segment = Segment { from: p.start, to: p.start + p.length, origin: p.start, series };
        if let Some(group) = found.last_mut() {
            group.push(segment);
        }
    }
    found
}

/// The best instant for `g` in a window with `f` before it.
fn until(f: &Signal, g: &Signal, a: f64, b: f64) -> f64 {
    let mut least = BEYOND;
    let mut best = -BEYOND;
    for (mine, theirs) in f.iter().zip(g) {
        for (p, q) in cut_together(mine, theirs) {
            if p.from > b {
                return best;
            }
            if q.to >= a {
                best = best.max(best_before(&p, &q, least, a, b));
            }
            let down = Segment { series: p.series.iter().map(|c| -c).collect(), ..p };
            least = least.min(-down.greatest());
        }
    }
    best
}

/// The greatest of `min(g, least f so far)` on one piece: by halving the level that is reached.
fn best_before(p: &Segment, q: &Segment, least: f64, a: f64, b: f64) -> f64 {
    let (low, high) = (q.from.max(a), q.to.min(b));
    let reached = |t: f64| {
        let part = Segment { to: t, series: p.series.iter().map(|c| -c).collect(), ..p.clone() };
        least.min(if t > p.from { -part.greatest() } else { BEYOND })
    };
    // The least value so far falls with time, so the best instant for each level of g is the first one that has it.
    let whole = Segment { from: low, to: high, ..q.clone() };
    let (mut bad, mut good) = (whole.greatest(), -BEYOND);
    let first = |level: f64| first_at(&whole, level);
    if reached(first(bad)) >= bad {
        return bad;
    }
    good = good.max(whole.value(low).min(reached(low)));
    for _ in 0..60 {
        let level = good + (bad - good) / 2.0;
        if reached(first(level)) >= level {
            good = level
        } else {
            bad = level
        }
    }
    good
}

/// The first time at which a segment comes to a level.
fn first_at(s: &Segment, level: f64) -> f64 {
    if s.value(s.from) >= level {
        return s.from;
    }
    let start = s.from - s.origin;
    let mut series = s.series.clone();
    for l in 0..series.len() {
        for i in (l..series.len() - 1).rev() {
            series[i] += start * series[i + 1];
        }
    }
    series[0] -= level;
    crate::roots::roots(&series, s.to - s.from, 0, 1e-14 * level.abs()).first().map_or(s.to, |t| s.from + t)
}

fn cut_together(f: &Group, g: &Group) -> Vec<(Segment, Segment)> {
    let mut found = Vec::new();
    for p in f {
        for q in g {
            let (from, to) = (p.from.max(q.from), p.to.min(q.to));
            if from < to || (from == to && (p.from == p.to || q.from == q.to)) {
                found.push((Segment { from, to, ..p.clone() }, Segment { from, to, ..q.clone() }));
            }
        }
    }
    found
}
