//! Quantities along a run as pieces of polynomials: least and greatest of two, and over windows of time, exactly.
//!
//! A signal has a group of pieces for each stay of the run (and one for each landing, of no length), so that several
//! instants at one time stay apart.

use crate::dense::at;
use crate::roots::roots;

/// A polynomial of the time since `origin`, from one time to another.
#[derive(Debug, Clone, PartialEq)]
pub struct Segment {
    pub from: f64,
    pub to: f64,
    pub origin: f64,
    pub series: Vec<f64>,
}

pub type Group = Vec<Segment>;
pub type Signal = Vec<Group>;

/// What stands for a value beyond all others.
pub const BEYOND: f64 = 1e300;

impl Segment {
    pub fn value(&self, t: f64) -> f64 {
        at(&self.series, t - self.origin)
    }

    fn constant(from: f64, to: f64, value: f64) -> Segment {
        Segment { from, to, origin: from, series: vec![value] }
    }

    fn clipped(&self, from: f64, to: f64) -> Segment {
        Segment { from: self.from.max(from), to: self.to.min(to), ..self.clone() }
    }

    fn negated(&self) -> Segment {
        Segment { series: self.series.iter().map(|c| -c).collect(), ..self.clone() }
    }

    /// The series from its first time on.
    fn local(&self) -> Vec<f64> {
        shifted(&self.series, self.from - self.origin)
    }

    /// The same later by a time.
    fn moved(&self, by: f64) -> Segment {
        Segment { from: self.from + by, to: self.to + by, origin: self.origin + by, series: self.series.clone() }
    }

    /// Its parts on which it rises or falls.
    fn monotone(&self) -> Vec<Segment> {
        let slope: Vec<f64> = self.local().iter().enumerate().skip(1).map(|(k, c)| k as f64 * c).collect();
        let mut cuts = vec![self.from];
        if slope.len() > 1 {
            cuts.extend(roots(&slope, self.to - self.from, 0, 0.0).into_iter().map(|t| self.from + t));
        }
        cuts.push(self.to);
        cuts.windows(2).filter(|w| w[0] < w[1]).map(|w| self.clipped(w[0], w[1])).collect()
    }

    /// The greatest value.
    pub fn greatest(&self) -> f64 {
        let ends = self.value(self.from).max(self.value(self.to));
        if self.to <= self.from {
            return ends;
        }
        self.monotone().iter().fold(ends, |most, s| most.max(s.value(s.from)))
    }
}

/// The series of the same polynomial around another time.
fn shifted(series: &[f64], by: f64) -> Vec<f64> {
    let mut found = series.to_vec();
    if by != 0.0 {
        for level in 0..found.len() {
            for i in (level..found.len() - 1).rev() {
                found[i] += by * found[i + 1];
            }
        }
    }
    found
}

pub fn negated(signal: &Signal) -> Signal {
    signal.iter().map(|g| g.iter().map(Segment::negated).collect()).collect()
}

/// The greater of two signals over the same groups.
pub fn greater(a: &Signal, b: &Signal) -> Signal {
    a.iter().zip(b).map(|(g, h)| greater_of(g, h)).collect()
}

fn greater_of(a: &Group, b: &Group) -> Group {
    let first = a.first().map_or(0.0, |s| s.from);
    if a.last().is_none_or(|s| s.to <= first) {
        let value = |g: &Group| g.iter().map(|s| s.value(first)).fold(f64::NEG_INFINITY, f64::max);
        return vec![Segment::constant(first, first, value(a).max(value(b)))];
    }
    merged(a, b)
}

/// The upper envelope of two lists of segments, each in order and without overlap; where one has none, the other.
fn merged(a: &[Segment], b: &[Segment]) -> Group {
    let mut cuts: Vec<f64> = a.iter().chain(b).flat_map(|s| [s.from, s.to]).collect();
    cuts.sort_by(f64::total_cmp);
    cuts.dedup();
    let (mut i, mut j) = (0, 0);
    let mut found: Group = Vec::new();
    for w in cuts.windows(2) {
        let (from, to) = (w[0], w[1]);
        while i < a.len() && a[i].to <= from {
            i += 1;
        }
        while j < b.len() && b[j].to <= from {
            j += 1;
        }
        let one = a.get(i).filter(|s| s.from <= from);
        let other = b.get(j).filter(|s| s.from <= from);
        match (one, other) {
            (Some(p), Some(q)) => found.extend(higher(&p.clipped(from, to), &q.clipped(from, to))),
            (Some(p), None) | (None, Some(p)) => found.push(p.clipped(from, to)),
            (None, None) => {}
        }
    }
    found
}

/// The higher of two segments over the same times, cut where they cross.
fn higher(p: &Segment, q: &Segment) -> Vec<Segment> {
    let (a, b) = (p.local(), q.local());
    let get = |s: &[f64], k: usize| s.get(k).copied().unwrap_or(0.0);
    let difference: Vec<f64> = (0..a.len().max(b.len())).map(|k| get(&a, k) - get(&b, k)).collect();
    let skip = difference.iter().take_while(|c| **c == 0.0).count();
    let mut cuts = vec![p.from];
    if skip < difference.len() {
        cuts.extend(roots(&difference, p.to - p.from, skip, 0.0).into_iter().map(|t| p.from + t));
    }
    cuts.push(p.to);
    let mut found: Vec<Segment> = Vec::new();
    for w in cuts.windows(2).filter(|w| w[0] < w[1]) {
        let middle = w[0] + (w[1] - w[0]) / 2.0;
        let better = if p.value(middle) >= q.value(middle) { p } else { q };
        found.push(better.clipped(w[0], w[1]));
    }
    found
}

/// The greatest value in a window of times, of groups from one on; nothing there is less than everything.
pub fn greatest_within(signal: &Signal, from_group: usize, low: f64, high: f64) -> f64 {
    let inside = |s: &&Segment| s.from <= high && s.to >= low;
    let groups = signal[from_group.min(signal.len())..].iter().flatten().filter(inside);
    groups.map(|s| s.clipped(low, high).greatest()).fold(-BEYOND, f64::max)
}

/// At each instant the greatest value of a signal between `a` and `b` later.
pub fn greatest_ahead(signal: &Signal, a: f64, b: f64) -> Signal {
    let last = signal.last().and_then(|g| g.last()).map_or(0.0, |s| s.to);
    let mut parts: Vec<Group> = vec![vec![Segment::constant(-b - 1.0, last + 1.0, -BEYOND)]];
    for s in signal.iter().flatten() {
        parts.extend(contributions(s, a, b).into_iter().filter(|c| c.from < c.to).map(|c| vec![c]));
    }
    let envelope = united(parts);
    let group = |(i, g): (usize, &Group)| -> Group {
        let (from, to) = (g.first().map_or(0.0, |s| s.from), g.last().map_or(0.0, |s| s.to));
        if from >= to {
            let first = if a == 0.0 { i } else { 0 };
            return vec![Segment::constant(from, from, greatest_within(signal, first, from + a, from + b))];
        }
        envelope.iter().map(|s| s.clipped(from, to)).filter(|s| s.from < s.to).collect()
    };
    signal.iter().enumerate().map(group).collect()
}

/// When a segment is in the window that lies `a` to `b` ahead, and the greatest value that it has there.
fn contributions(s: &Segment, a: f64, b: f64) -> Vec<Segment> {
    if s.to <= s.from {
        return vec![Segment::constant(s.from - b, s.from - a, s.value(s.from))];
    }
    let mut found = Vec::new();
    for m in s.monotone() {
        let (first, last) = (m.value(m.from), m.value(m.to));
        if last >= first {
            found.push(m.moved(-b));
            found.push(Segment::constant(m.to - b, m.to - a, last));
        } else {
            found.push(Segment::constant(m.from - b, m.from - a, first));
            found.push(m.moved(-a));
        }
    }
    found
}

fn united(mut parts: Vec<Group>) -> Group {
    while parts.len() > 1 {
        let pairs = parts.chunks(2).map(|c| if c.len() == 2 { merged(&c[0], &c[1]) } else { c[0].clone() });
        parts = pairs.collect();
    }
    parts.pop().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wave() -> Signal {
        let piece = |from: f64, series: Vec<f64>| Segment { from, to: from + 1.0, origin: from, series };
        vec![
            vec![piece(0.0, vec![0.0, 4.0, -4.0])],
            vec![piece(1.0, vec![0.5]), piece(2.0, vec![0.5, -1.0, 0.0, 1.0])],
            vec![piece(3.0, vec![-1.0, 2.0])],
        ]
    }

    fn sampled(signal: &Signal, low: f64, high: f64) -> f64 {
        let all = signal.iter().flatten();
        let values = all.flat_map(|s| (0..=2000).map(move |k| (s, s.from + (s.to - s.from) * f64::from(k) / 2000.0)));
        values.filter(|(_, t)| (low..=high).contains(t)).map(|(s, t)| s.value(t)).fold(-BEYOND, f64::max)
    }

    #[test]
    fn the_greatest_in_a_sliding_window_is_that_of_samples() {
        let signal = wave();
        let ahead = greatest_ahead(&signal, 0.3, 1.1);
        for k in 0..58 {
            let t = 0.0501 * f64::from(k);
            let group = &ahead[if t < 1.0 {
                0
            } else if t < 3.0 {
                1
            } else {
                2
            }];
            let found = group.iter().find(|s| s.from <= t && t <= s.to).unwrap().value(t);
            let expected = sampled(&signal, t + 0.3, t + 1.1);
            assert!((found - expected).abs() < 3e-3, "at {t}: {found} and {expected}");
            assert!((found - greatest_within(&signal, 0, t + 0.3, t + 1.1)).abs() < 1e-12);
        }
    }

    #[test]
    fn the_greater_of_two_is_cut_where_they_cross() {
        let line = vec![vec![Segment { from: 0.0, to: 1.0, origin: 0.0, series: vec![0.75] }]];
        let found = greater(&wave()[..1].to_vec(), &line);
        assert_eq!(found[0].len(), 3);
        assert!((found[0][0].to - 0.25).abs() < 1e-15 && (found[0][1].to - 0.75).abs() < 1e-15);
    }
}
