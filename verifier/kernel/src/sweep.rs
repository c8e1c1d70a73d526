//! The series in time of a tape over Taylor models, and of its slopes, in one arena: what `series::solution` and
//! `series::variations` compute over any ring.
//!
//! Values follow the rules of the tape, slopes the rule of products, rule by rule, and only for the states on which a
//! register depends; places that are zero cost nothing.

use crate::arena::{Arena, Product};
use crate::duals::derivative;
use crate::fault::Fault;
use crate::interval::{Enclosure, Interval};
use crate::models::{Model, Space};
use crate::rules::{dependence, Compiled, Factor, Rule};
use crate::series::{Ring, Tape};
use std::ops::{Div, Neg};
use std::sync::Arc;

/// Where the slopes of a register are: one row of places for each state it depends on.
struct Register {
    /// The place of the value's coefficient of order zero.
    value: usize,
    /// The states it depends on and the places of the slopes' coefficients of order zero.
    slopes: Vec<(usize, usize)>,
}

impl Register {
    fn slope(&self, state: usize) -> Option<usize> {
        self.slopes.iter().find(|s| s.0 == state).map(|s| s.1)
    }
}

pub struct Sweep {
    space: Arc<Space>,
    states: usize,
    rules: Vec<Rule>,
    registers: Vec<Register>,
    /// The registers of the rates.
    rates: Vec<usize>,
    arena: Arena,
    /// A place for a factor, and how many orders of the rules' values and slopes are known.
    spare: usize,
    known: usize,
    ruled: usize,
    sloped: usize,
    products: Vec<Product>,
    /// One over each order.
    inverses: Vec<Interval>,
}

impl Sweep {
    /// Room for the states' series up to `order`, and for their slopes up to `slope_order` (none if that is `None`).
    pub fn new(space: &Arc<Space>, tape: &Tape, order: usize, slope_order: Option<usize>) -> Sweep {
        let (compiled, rates) = Compiled::of(tape);
        let depends = dependence(&compiled, &rates, slope_order.is_some_and(|k| k > 0));
        let mut places = 0;
        let mut take = |n: usize| {
            places += n;
            places - n
        };
        let registers = depends.iter().map(|d| {
            let value = take(order + 1);
            let of = |k: usize| d.iter().enumerate().filter(|(_, &b)| b).map(move |(v, _)| (v, k));
            let slopes = slope_order.map_or(vec![], |k| of(k).map(|(v, k)| (v, take(k + 1))).collect());
            Register { value, slopes }
        });
        let registers: Vec<Register> = registers.collect();
        let spare = take(1);
        let arena = Arena::new(space.clone(), places);
        let Compiled { states, rules } = compiled;
        let products = Vec::new();
        let inverses = (0..=order).filter_map(|k| one_over(k.max(1)).ok()).collect();
        Sweep {
            space: space.clone(),
            states,
            rules,
            registers,
            rates,
            arena,
            spare,
            known: 0,
            ruled: 0,
            sloped: 0,
            products,
            inverses,
        }
    }

    /// Forget everything and start at these states.
    ///
    /// What places hold from before is never read: each is written anew before, or is never written and zero.
    pub fn restart(&mut self, at: &[Model]) -> Result<(), Fault> {
        self.arena.keep_all();
        (self.known, self.ruled, self.sloped) = (0, 0, 0);
        let one = self.space.number(1.0);
        for (v, model) in at.iter().enumerate() {
            self.arena.set(self.registers[v].value, model)?;
            if let Some(place) = self.registers[v].slope(v) {
                self.arena.set(place, &one)?;
            }
        }
        Ok(())
    }

    /// Compute the states' series up to an order.
    pub fn extend(&mut self, order: usize) -> Result<(), Fault> {
        self.extend_for(order, None)
    }

    /// Compute the states' series up to an order; for a step and an error given, with as many degrees, order by order,
    /// as matter: one more than those whose terms at the end of the step are above the error.
    pub fn extend_for(&mut self, order: usize, step_and_error: Option<(f64, f64)>) -> Result<(), Fault> {
        while self.known < order {
            let k = self.known;
            if let Some((h, error)) = step_and_error.filter(|_| k > 0) {
                let least = error / h.powi(k as i32);
                let matter = (0..self.states).map(|v| self.arena.degrees_above(self.at(v, k), least)).max();
                self.arena.keep(matter.unwrap_or(0) + 1);
            }
            for r in 0..self.rules.len() {
                self.value(r, k)?;
            }
            for v in 0..self.states {
                let (to, from) = (self.registers[v].value + k + 1, self.registers[self.rates[v]].value + k);
                self.arena.scale(to, from, self.inverses[k + 1])?;
            }
            self.known += 1;
        }
        Ok(())
    }

    /// Compute the slopes of the states' series up to an order.
    pub fn extend_slopes(&mut self, order: usize) -> Result<(), Fault> {
        self.extend(order)?;
        while self.sloped < order {
            let k = self.sloped;
            self.rules_slopes(k)?;
            for v in 0..self.states {
                for s in 0..self.registers[v].slopes.len() {
                    let (state, to) = self.registers[v].slopes[s];
                    if let Some(from) = self.registers[self.rates[v]].slope(state) {
                        self.arena.scale(to + k + 1, from + k, self.inverses[k + 1])?;
                    }
                }
            }
            self.sloped += 1;
        }
        Ok(())
    }

    /// Compute the slopes of the rules' coefficients of order `k`, if those of lower orders are known.
    fn rules_slopes(&mut self, k: usize) -> Result<(), Fault> {
        if self.ruled > k {
            return Ok(());
        }
        for r in 0..self.rules.len() {
            let chain = self.chain(r, k)?;
            for s in 0..self.registers[self.states + r].slopes.len() {
                let (state, place) = self.registers[self.states + r].slopes[s];
                self.slope(r, k, state, place + k, chain)?;
            }
        }
        self.ruled = k + 1;
        Ok(())
    }

    /// The place of a value's coefficient.
    fn at(&self, register: usize, k: usize) -> usize {
        self.registers[register].value + k
    }

    fn factor(&self, by: Factor, k: usize) -> Enclosure {
        match by {
            Factor::One => Interval::exactly(1.0),
            Factor::Half => Interval::exactly(0.5),
            Factor::Over(sign) if sign < 0.0 => self.inverses[k].neg(),
            Factor::Over(_) => Ok(self.inverses[k]),
        }
    }

    fn value(&mut self, r: usize, k: usize) -> Result<(), Fault> {
        let place = self.at(self.states + r, k);
        match self.rules[r] {
            Rule::Constant(value) if k == 0 => self.arena.set(place, &self.space.constant(value)),
            Rule::Constant(_) => Ok(()),
            Rule::Combine { a, b, sign } => self.arena.combine(place, self.at(a, k), self.at(b, k), sign),
            Rule::Multiple { a, by } => self.arena.scale(place, self.at(a, k), by),
            Rule::Scaled { a, by } => self.arena.scale(place, self.at(a, k), self.factor(by, k)?),
            Rule::Times { a, b } => self.arena.sum(place, &[(1.0, self.at(a, k), self.at(b, 0))]),
            Rule::Start { f, of, .. } if k == 0 => {
                let model = self.space.apply(f, &self.arena.model(self.at(of, 0)))?;
                self.arena.set(place, &model)
            }
            Rule::Start { then, .. } => match then {
                Some((rest, by)) => self.arena.scale(place, self.at(rest, k), self.factor(by, k)?),
                None => Ok(()),
            },
            Rule::Products { a, b, first, last, weighted } => {
                let mut products = std::mem::take(&mut self.products);
                products.clear();
                let (x, y) = (self.at(a, 0), self.at(b, 0));
                if a == b && !weighted {
                    products.extend(squares(x, k, first));
                } else {
                    let terms = (first..(k + 1).saturating_sub(last)).map(|i| (weight(i, weighted), x + i, y + k - i));
                    products.extend(terms);
                }
                let done = self.arena.sum(place, &products);
                self.products = products;
                done
            }
        }
    }

    /// The derivative of the function that starts a register, in the spare place; whether there is one.
    fn chain(&mut self, r: usize, k: usize) -> Result<bool, Fault> {
        let Rule::Start { f, of, .. } = self.rules[r] else { return Ok(false) };
        if k > 0 {
            return Ok(false);
        }
        let (argument, value) = (self.arena.model(self.at(of, 0)), self.arena.model(self.at(self.states + r, 0)));
        self.arena.set(self.spare, &derivative(&*self.space, f, &argument, &value)?)?;
        Ok(true)
    }

    /// The slope by one state of the coefficient of order `k`.
    fn slope(&mut self, r: usize, k: usize, state: usize, place: usize, chain: bool) -> Result<(), Fault> {
        let of = |s: &Sweep, register: usize, k: usize| s.registers[register].slope(state).map(|p| p + k);
        match self.rules[r] {
            Rule::Constant(_) => Ok(()),
            Rule::Combine { a, b, sign } => match (of(self, a, k), of(self, b, k)) {
                (Some(x), Some(y)) => self.arena.combine(place, x, y, sign),
                (Some(x), None) => {
                    self.arena.signed(place, x, 1.0);
                    Ok(())
                }
                (None, Some(y)) => self.arena.scale(place, y, Interval::exactly(sign)?),
                (None, None) => Ok(()),
            },
            Rule::Multiple { a, by } => self.scaled(place, of(self, a, k), by),
            Rule::Scaled { a, by } => self.scaled(place, of(self, a, k), self.factor(by, k)?),
            Rule::Start { of: a, .. } if chain => {
                let products: Vec<Product> = of(self, a, 0).map(|x| (1.0, x, self.spare)).into_iter().collect();
                self.arena.sum(place, &products)
            }
            Rule::Start { then, .. } => match then {
                Some((rest, by)) => self.scaled(place, of(self, rest, k), self.factor(by, k)?),
                None => Ok(()),
            },
            Rule::Times { a, b } => self.slopes_of_products(place, k, state, (a, b), k..k + 1, false),
            Rule::Products { a, b, first, last, weighted } => {
                self.slopes_of_products(place, k, state, (a, b), first..(k + 1).saturating_sub(last), weighted)
            }
        }
    }

    fn scaled(&mut self, place: usize, from: Option<usize>, by: Interval) -> Result<(), Fault> {
        from.map_or(Ok(()), |from| self.arena.scale(place, from, by))
    }

    /// The slope of the sum of `a_i b_(k-i)`, weighted or not.
    fn slopes_of_products(
        &mut self,
        place: usize,
        k: usize,
        state: usize,
        (a, b): (usize, usize),
        range: std::ops::Range<usize>,
        weighted: bool,
    ) -> Result<(), Fault> {
        let mut products = std::mem::take(&mut self.products);
        products.clear();
        let (x, y) = (&self.registers[a], &self.registers[b]);
        if let Some(slope) = y.slope(state) {
            products.extend(range.clone().map(|i| (weight(i, weighted), x.value + i, slope + k - i)));
        }
        if let Some(slope) = x.slope(state) {
            products.extend(range.map(|i| (weight(i, weighted), slope + i, y.value + k - i)));
        }
        let done = self.arena.sum(place, &products);
        self.products = products;
        done
    }

    /// The coefficients of a state's series up to an order.
    pub fn series(&self, state: usize, order: usize) -> Vec<Model> {
        (0..=order).map(|k| self.arena.model(self.at(state, k))).collect()
    }

    /// The coefficient of one order of a state's series.
    pub fn coefficient(&self, state: usize, k: usize) -> Model {
        self.arena.model(self.at(state, k))
    }

    /// A range of the coefficient of one order of a state's series: coarse, but quick.
    pub fn range(&self, state: usize, k: usize) -> Enclosure {
        self.arena.range(self.at(state, k))
    }

    /// The slope of a coefficient of a state's series by a state; `None` where there is none.
    pub fn slope_of(&self, of: usize, by: usize, k: usize) -> Option<Model> {
        self.registers[of].slope(by).map(|p| self.arena.model(p + k))
    }

    /// The slope of a rate by a state, at the start.
    pub fn rate_slope(&mut self, of: usize, by: usize) -> Result<Option<Model>, Fault> {
        self.extend(1)?;
        self.rules_slopes(0)?;
        Ok(self.registers[self.rates[of]].slope(by).map(|p| self.arena.model(p)))
    }
}

fn weight(i: usize, weighted: bool) -> f64 {
    if weighted {
        i as f64
    } else {
        1.0
    }
}

/// The terms of a square's coefficient of order `k`, each pair of equal products once; `first` is also left out last.
fn squares(x: usize, k: usize, first: usize) -> impl Iterator<Item = Product> {
    (first..(k + 2) / 2).filter(move |&i| i + first <= k).map(move |i| {
        let weight = if 2 * i == k { 1.0 } else { 2.0 };
        (weight, x + i, x + k - i)
    })
}

fn one_over(k: usize) -> Enclosure {
    Interval::exactly(1.0)?.div(Interval::exactly(k as f64)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::duals::{jacobian, variations};
    use crate::series::{solution, Op};

    struct Numbers(u64);

    impl Numbers {
        fn below(&mut self, n: usize) -> usize {
            self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (self.0 >> 33) as usize % n
        }

        fn tape(&mut self, states: usize) -> Tape {
            let mut ops: Vec<Op> = (0..states).map(Op::Variable).collect();
            // Narrow: operations on numbers alone are intervals here, Taylor models in the rings.
            ops.push(Op::Constant(Interval::new(0.6, 0.6f64.next_up()).expect("in order")));
            for _ in 0..8 {
                let (a, b, at) = (self.below(ops.len()), self.below(ops.len()), ops.len());
                match self.below(9) {
                    0 => ops.push(Op::Add(a, b)),
                    1 => ops.push(Op::Sub(a, b)),
                    2 | 3 => ops.push(Op::Mul(a, b)),
                    4 => ops.push(Op::Mul(a, a)),
                    5 => ops.extend([Op::Sin(a), Op::Cos(a), Op::Div(b, at + 1)]),
                    6 => ops.extend([Op::Exp(a), Op::Sqrt(at), Op::Log(at)]),
                    7 => ops.extend([Op::Mul(a, a), Op::Constant(Interval::exactly(1.0).expect("finite"))]),
                    _ => ops.push(Op::Neg(a)),
                }
            }
            let outputs = (0..states).map(|i| ops.len() - 1 - i).collect();
            Tape::validated(ops, outputs, states).expect("operands come first")
        }
    }

    /// Both enclose the same function: nowhere are they further apart than their radii allow, and both are narrow.
    fn assert_same(a: &Model, b: &Model) {
        let distance: f64 = a.coefficients.iter().zip(&b.coefficients).map(|(x, y)| (x - y).abs()).sum();
        let size: f64 = a.coefficients.iter().map(|c| c.abs()).sum::<f64>() + a.radius;
        assert!(distance <= 1e-12 * size + 1e-11, "{distance} {size}");
        assert!(distance <= a.radius + b.radius, "{distance} {} {}", a.radius, b.radius);
        assert!((a.radius - b.radius).abs() <= 1e-6 * a.radius + 1e-11, "{} {}", a.radius, b.radius);
    }

    #[test]
    fn what_was_there_before_is_forgotten() {
        let (mut numbers, mut compared) = (Numbers(5), 0);
        let space = Arc::new(Space::new(2, 3));
        for _ in 0..40 {
            let tape = numbers.tape(2);
            let wide = [space.variable(0, 0.4, 0.05), space.variable(1, 0.3, 0.05)];
            let narrow = [space.number(0.35), space.variable(0, 0.3, 0.01)];
            let mut used = Sweep::new(&space, &tape, 4, Some(3));
            let mut fresh = Sweep::new(&space, &tape, 4, Some(3));
            if used.restart(&wide).and_then(|()| used.extend_slopes(3)).is_err() {
                continue;
            }
            for sweep in [&mut used, &mut fresh] {
                sweep.restart(&narrow).and_then(|()| sweep.extend_slopes(3)).expect("inside what was computed before");
            }
            compared += 1;
            for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                assert_eq!(used.series(i, 4), fresh.series(i, 4));
                assert_eq!(used.slope_of(i, j, 3), fresh.slope_of(i, j, 3));
                assert_eq!(used.rate_slope(i, j), fresh.rate_slope(i, j));
            }
        }
        assert!(compared > 10, "{compared}");
    }

    #[test]
    fn series_and_slopes_are_those_of_the_rings() {
        let (mut numbers, mut compared) = (Numbers(3), 0);
        for (states, variables, degree) in [(2, 2, 3), (3, 2, 1), (2, 0, 2), (3, 3, 2)].repeat(12) {
            let (tape, space) = (numbers.tape(states), Space::new(variables, degree));
            let at: Vec<Model> = (0..states)
                .map(|v| {
                    let model = if v < variables { space.variable(v, 0.4, 0.05) } else { space.number(0.3) };
                    Model { radius: 1e-3 * (v % 2) as f64, ..model }
                })
                .collect();
            let mut sweep = Sweep::new(&Arc::new(space.clone()), &tape, 4, Some(3));
            let Ok(series) = solution(&space, &tape, &at, 4) else { continue };
            sweep.restart(&at).expect("finite");
            sweep.extend(4).expect("what the ring computes");
            let slopes = variations(&space, &tape, &at, 3).expect("slopes exist");
            let rates = jacobian(&space, &tape, &at).expect("slopes exist");
            sweep.extend_slopes(3).expect("what the ring computes");
            compared += 1;
            for (i, expected) in series.iter().enumerate() {
                sweep.series(i, 4).iter().zip(expected).for_each(|(a, b)| assert_same(a, b));
                for j in 0..states {
                    let zero = || space.zero();
                    for (k, expected) in slopes.iter().enumerate() {
                        assert_same(&sweep.slope_of(i, j, k).unwrap_or_else(zero), &expected[i][j]);
                    }
                    assert_same(&sweep.rate_slope(i, j).expect("finite").unwrap_or_else(zero), &rates[i][j]);
                }
            }
        }
        assert!(compared > 20, "{compared}");
    }
}
