//! What happens on one step: where the signs of the watched quantities change, and what that does to conditions.

use crate::automaton::Mode;
use crate::dense::{at, rounding, Jets};
use crate::program::sign;
use crate::roots::roots;

const TOUCH: f64 = 1e-14; // of the magnitude of a series counts as zero at a touch
const NEAR: f64 = 1e-7; // of the magnitude of a series; a value nearer to zero is compared with its rounding error

const DOUBT: f64 = 1e3; // times the error of the state; the same

/// The signs of the watched quantities along a step: at its start, at each instant where one is zero, and in between.
#[derive(Debug, Default)]
pub struct Signs {
    /// Instants after the start of the step, in order.
    pub instants: Vec<f64>,
    /// For each instant the registers that are zero there.
    zeros: Vec<Vec<usize>>,
    /// For each watched register how many powers of time its series is divisible by, rounding aside.
    skips: Vec<usize>,
    /// What counts as zero of each watched register at an instant.
    slacks: Vec<f64>,
}

/// A part of a step: its start, one of the instants, or what lies open before the next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Part {
    Start,
    Open(usize),
    Instant(usize),
}

impl Signs {
    /// Where the watched quantities of a mode are zero within a step; `errors` is how far the state may be off.
    pub fn along(mode: &Mode, jets: &Jets, h: f64, errors: &[f64]) -> Signs {
        let mut signs = Signs::default();
        let mut slack: Option<Vec<f64>> = None;
        let known = || -> Vec<f64> {
            let values: Vec<f64> = (0..mode.program.moving).map(|r| jets.register(r)[0]).collect();
            rounding(&mode.program, &values, errors)
        };
        let mut sizes = Vec::with_capacity(mode.watched.len());
        let doubt = DOUBT * errors.iter().fold(0.0f64, |most, e| most.max(*e));
        let mut found: Vec<(f64, usize)> = Vec::new();
        for &r in &mode.watched {
            let series = jets.register(r);
            if mode.program.is_still(r) {
                signs.skips.push(if series[0] == 0.0 { series.len() } else { 0 });
                sizes.push(0.0);
                continue;
            }
            let (mut size, mut power) = (0.0, 1.0);
            for c in series {
                size += c.abs() * power;
                power *= h;
            }
            let mut skip = 0;
            let mut off = 0.0;
            if series[0].abs() <= NEAR * size + doubt {
                off = slack.get_or_insert_with(known)[r];
                skip = leading_zeros(series, h, off, jets.zeroed.contains(&r));
            }
            signs.skips.push(skip);
            sizes.push(size);
            if skip < series.len() {
                found.extend(roots(series, h, skip, TOUCH * size + off).into_iter().map(|t| (t, r)));
            }
        }
        if !found.is_empty() {
            let off = slack.get_or_insert_with(known);
            let all = mode.watched.iter().zip(&sizes);
            signs.slacks = all.map(|(&r, size)| off[r] + 4.0 * f64::EPSILON * size).collect();
        }
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (t, r) in found {
            match signs.instants.last() {
                Some(&last) if t - last <= 4.0 * f64::EPSILON * t => signs.zeros[signs.instants.len() - 1].push(r),
                _ => {
                    signs.instants.push(t);
                    signs.zeros.push(vec![r]);
                }
            }
        }
        signs
    }

    /// The parts of a step in order; the last one is open.
    pub fn parts(&self) -> impl Iterator<Item = Part> {
        let count = self.instants.len();
        std::iter::once(Part::Start)
            .chain((0..count).flat_map(|i| [Part::Open(i), Part::Instant(i)]))
            .chain(std::iter::once(Part::Open(count)))
    }

    /// The ends of a part.
    pub fn ends(&self, part: Part, h: f64) -> (f64, f64) {
        let after = |i: usize| if i == 0 { 0.0 } else { self.instants[i - 1] };
        match part {
            Part::Start => (0.0, 0.0),
            Part::Instant(i) => (self.instants[i], self.instants[i]),
            Part::Open(i) => (after(i), self.instants.get(i).copied().unwrap_or(h)),
        }
    }

    /// The sign of a watched register on a part.
    pub fn sign(&self, mode: &Mode, jets: &Jets, h: f64, part: Part, r: usize) -> i8 {
        let Ok(index) = mode.watched.binary_search(&r) else { return 0 };
        let (series, skip) = (jets.register(r), self.skips[index]);
        if skip >= series.len() {
            return 0;
        }
        if mode.program.is_still(r) {
            return sign(series[0]);
        }
        match part {
            Part::Start => {
                if skip > 0 {
                    0
                } else {
                    sign(series[0])
                }
            }
            Part::Instant(i) if self.zeros[i].contains(&r) => 0,
            Part::Instant(i) => {
                let value = at(series, self.instants[i]);
                if value.abs() <= self.slacks[index] {
                    0
                } else {
                    sign(value)
                }
            }
            Part::Open(_) => {
                let (low, high) = self.ends(part, h);
                sign(at(&series[skip..], low + (high - low) / 2.0))
            }
        }
    }

    /// The registers that are zero at the start of the step or at one of its instants.
    pub fn zeros_at(&self, mode: &Mode, t: f64) -> Vec<usize> {
        match self.instants.iter().position(|&x| x == t) {
            Some(i) => self.zeros[i].clone(),
            None if t == 0.0 => mode.watched.iter().zip(&self.skips).filter(|r| *r.1 > 0).map(|r| *r.0).collect(),
            None => Vec::new(),
        }
    }
}

/// How many coefficients at the head of a series are nothing but rounding.
fn leading_zeros(series: &[f64], h: f64, off: f64, is_zeroed: bool) -> usize {
    if series[0].abs() > off && !is_zeroed {
        return 0;
    }
    let mut power = h;
    let mut skip = 1;
    while skip < series.len() && series[skip].abs() * power <= off {
        skip += 1;
        power *= h;
    }
    skip
}
