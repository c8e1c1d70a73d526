//! Conditions on watched quantities, decided on enclosures: true for all, false for all, or open.

use crate::interval::Interval;

/// How a quantity compares with zero.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Comparison {
    Less,
    AtMost,
    Greater,
    AtLeast,
    Equal,
    Differ,
}

/// A formula over the quantities of a tape, by position.
#[derive(Debug, Clone, PartialEq)]
pub enum Condition {
    Constant(bool),
    Atom(usize, Comparison),
    All(Vec<Condition>),
    Any(Vec<Condition>),
}

impl Comparison {
    /// Whether it holds for all numbers of the interval (`Some(true)`), for none (`Some(false)`), or for some.
    pub fn truth(self, x: Interval) -> Option<bool> {
        let (low, high) = (x.low(), x.high());
        let (yes, no) = match self {
            Comparison::Less => (high < 0.0, low >= 0.0),
            Comparison::AtMost => (high <= 0.0, low > 0.0),
            Comparison::Greater => (low > 0.0, high <= 0.0),
            Comparison::AtLeast => (low >= 0.0, high < 0.0),
            Comparison::Equal => (low == 0.0 && high == 0.0, low > 0.0 || high < 0.0),
            Comparison::Differ => (low > 0.0 || high < 0.0, low == 0.0 && high == 0.0),
        };
        match (yes, no) {
            (true, _) => Some(true),
            (_, true) => Some(false),
            _ => None,
        }
    }

    /// The comparison with its border left out.
    pub fn opened(self) -> Comparison {
        match self {
            Comparison::AtMost => Comparison::Less,
            Comparison::AtLeast => Comparison::Greater,
            same => same,
        }
    }

    /// The comparison with its border.
    pub fn closed(self) -> Comparison {
        match self {
            Comparison::Less => Comparison::AtMost,
            Comparison::Greater => Comparison::AtLeast,
            same => same,
        }
    }

    /// Its truth at zero itself.
    pub fn at_zero(self) -> bool {
        matches!(self, Comparison::AtMost | Comparison::AtLeast | Comparison::Equal)
    }

    /// What is left of an interval where the comparison, closed, is known to hold; `None` if nothing is.
    pub fn keep(self, x: Interval) -> Option<Interval> {
        let low = if matches!(self, Comparison::Greater | Comparison::AtLeast | Comparison::Equal) {
            x.low().max(0.0)
        } else {
            x.low()
        };
        let high = if matches!(self, Comparison::Less | Comparison::AtMost | Comparison::Equal) {
            x.high().min(0.0)
        } else {
            x.high()
        };
        Interval::new(low, high).ok()
    }
}

impl Condition {
    pub fn truth(&self, values: &[Interval]) -> Option<bool> {
        match self {
            Condition::Constant(value) => Some(*value),
            Condition::Atom(at, comparison) => comparison.truth(values[*at]),
            Condition::All(members) => junction(members, values, false),
            Condition::Any(members) => junction(members, values, true),
        }
    }

    /// The greatest position of a quantity in it, one more; 0 if it has none.
    pub fn reach(&self) -> usize {
        match self {
            Condition::Constant(_) => 0,
            Condition::Atom(at, _) => at + 1,
            Condition::All(members) | Condition::Any(members) => {
                members.iter().map(Condition::reach).max().unwrap_or(0)
            }
        }
    }
}

fn junction(members: &[Condition], values: &[Interval], decisive: bool) -> Option<bool> {
    let mut open = false;
    for member in members {
        match member.truth(values) {
            Some(found) if found == decisive => return Some(decisive),
            Some(_) => {}
            None => open = true,
        }
    }
    if open {
        None
    } else {
        Some(!decisive)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn interval(low: f64, high: f64) -> Interval {
        Interval::new(low, high).expect("ends in order")
    }

    #[test]
    fn comparisons_are_decided_by_the_ends() {
        let cases = [
            (Comparison::Less, Some(true), None, Some(false)),
            (Comparison::AtMost, Some(true), Some(true), None),
            (Comparison::Greater, Some(false), Some(false), None),
            (Comparison::AtLeast, Some(false), None, Some(true)),
            (Comparison::Equal, Some(false), None, None),
            (Comparison::Differ, Some(true), None, None),
        ];
        for (comparison, below, touching_from_below, touching_from_above) in cases {
            assert_eq!(comparison.truth(interval(-2.0, -1.0)), below);
            assert_eq!(comparison.truth(interval(-2.0, 0.0)), touching_from_below);
            assert_eq!(comparison.truth(interval(0.0, 1.0)), touching_from_above);
        }
        assert_eq!(Comparison::Equal.truth(Interval::ZERO), Some(true));
        assert_eq!(Comparison::Differ.truth(Interval::ZERO), Some(false));
    }

    #[test]
    fn junctions_are_open_where_a_member_decides_and_is_open() {
        let (yes, no, open) = (interval(1.0, 2.0), interval(-2.0, -1.0), interval(-1.0, 1.0));
        let atom = |i| Condition::Atom(i, Comparison::Greater);
        let all = Condition::All(vec![atom(0), atom(1)]);
        let any = Condition::Any(vec![atom(0), atom(1)]);
        assert_eq!(all.truth(&[yes, open]), None);
        assert_eq!(all.truth(&[no, open]), Some(false));
        assert_eq!(any.truth(&[yes, open]), Some(true));
        assert_eq!(any.truth(&[no, open]), None);
        assert_eq!((all.reach(), Condition::Constant(true).reach()), (2, 0));
    }

    #[test]
    fn what_is_known_to_hold_cuts_an_interval() {
        assert_eq!(Comparison::AtMost.keep(interval(-1.0, 2.0)), Some(interval(-1.0, 0.0)));
        assert_eq!(Comparison::Greater.keep(interval(-1.0, 2.0)), Some(interval(0.0, 2.0)));
        assert_eq!(Comparison::AtLeast.keep(interval(-2.0, -1.0)), None);
    }
}
