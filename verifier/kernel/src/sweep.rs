//! The series in time of a tape over Taylor models, and of its slopes, in one arena: what `series::solution` and
//! `series::variations` compute over any ring.
//!
//! A tape becomes a list of rules for the next coefficient of numbered registers. The first registers are the states,
//! whose next coefficient is that of their rate, divided. Slopes follow by the rule of products, rule by rule, and only
//! for the states on which a register depends; places that are zero cost nothing.

use crate::arena::{Arena, Product};
use crate::fault::Fault;
use crate::interval::{Enclosure, Interval};
use crate::models::{Model, Space};
use crate::series::{derivative, Function, Op, Ring, Tape};
use std::ops::Div;
use std::sync::Arc;

/// What a coefficient is multiplied by.
#[derive(Debug, Clone, Copy)]
enum Factor {
    One,
    Half,
    /// The sign over the order.
    Over(f64),
}

/// How the coefficient of order `k` of a register follows from others.
#[derive(Debug, Clone, Copy)]
enum Rule {
    Constant(Interval),
    /// `a_k + sign * b_k`.
    Combine { a: usize, b: usize, sign: f64 },
    Negative(usize),
    /// The sum of `a_i b_(k-i)`, without the first and the last `i` if told so; times `i` if weighted.
    Products { a: usize, b: usize, first: usize, last: usize, weighted: bool },
    Scaled { a: usize, by: Factor },
    /// `a_k b_0`.
    Times { a: usize, b: usize },
    /// `f(of_0)` first, then the coefficients of another register.
    Start { f: Function, of: usize, then: Option<(usize, Factor)> },
}

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
}

/// The rules of a tape; register numbers follow those of the states.
struct Compiled {
    states: usize,
    rules: Vec<Rule>,
}

impl Compiled {
    fn push(&mut self, rule: Rule) -> usize {
        self.rules.push(rule);
        self.states + self.rules.len() - 1
    }

    /// How many registers there are.
    fn count(&self) -> usize {
        self.states + self.rules.len()
    }

    /// The register of an operation whose operands are in the registers `at`.
    fn add(&mut self, op: Op, at: &[usize]) -> usize {
        let all = |a: usize, b: usize| Rule::Products { a, b, first: 0, last: 0, weighted: false };
        match op {
            Op::Constant(value) => self.push(Rule::Constant(value)),
            Op::Variable(v) => v,
            Op::Add(a, b) => self.push(Rule::Combine { a: at[a], b: at[b], sign: 1.0 }),
            Op::Sub(a, b) => self.push(Rule::Combine { a: at[a], b: at[b], sign: -1.0 }),
            Op::Neg(a) => self.push(Rule::Negative(at[a])),
            Op::Mul(a, b) => self.push(all(at[a], at[b])),
            Op::Div(a, b) => self.quotient(at[a], at[b]),
            Op::Sqrt(a) => self.root(at[a]),
            Op::Exp(a) => {
                let it = self.count() + 1;
                self.wave(Function::Exp, at[a], it, 1.0)
            }
            Op::Log(a) => self.logarithm(at[a]),
            // A sine's register is two before its cosine's, each after its own sum.
            Op::Sin(a) => {
                let cosine = self.count() + 3;
                self.wave(Function::Sin, at[a], cosine, 1.0)
            }
            Op::Cos(a) => {
                let sine = self.count() - 1;
                self.wave(Function::Cos, at[a], sine, -1.0)
            }
        }
    }

    /// `f(a)` where `f'(a)` is `sign` times another register.
    fn wave(&mut self, f: Function, a: usize, slope: usize, sign: f64) -> usize {
        let sum = self.push(Rule::Products { a, b: slope, first: 1, last: 0, weighted: true });
        self.push(Rule::Start { f, of: a, then: Some((sum, Factor::Over(sign))) })
    }

    fn quotient(&mut self, a: usize, b: usize) -> usize {
        let inverse = self.push(Rule::Start { f: Function::Reciprocal, of: b, then: None });
        let it = self.count() + 2;
        let known = self.push(Rule::Products { a: it, b, first: 0, last: 1, weighted: false });
        let top = self.push(Rule::Combine { a, b: known, sign: -1.0 });
        self.push(Rule::Times { a: top, b: inverse })
    }

    fn root(&mut self, a: usize) -> usize {
        let it = self.count() + 3;
        let known = self.push(Rule::Products { a: it, b: it, first: 1, last: 1, weighted: false });
        let top = self.push(Rule::Combine { a, b: known, sign: -1.0 });
        let rest = self.push(Rule::Times { a: top, b: it + 1 });
        let root = self.push(Rule::Start { f: Function::Sqrt, of: a, then: Some((rest, Factor::Half)) });
        self.push(Rule::Start { f: Function::Reciprocal, of: root, then: None });
        root
    }

    fn logarithm(&mut self, a: usize) -> usize {
        let inverse = self.push(Rule::Start { f: Function::Reciprocal, of: a, then: None });
        let it = self.count() + 4;
        let sum = self.push(Rule::Products { a: it, b: a, first: 1, last: 1, weighted: true });
        let known = self.push(Rule::Scaled { a: sum, by: Factor::Over(1.0) });
        let top = self.push(Rule::Combine { a, b: known, sign: -1.0 });
        let rest = self.push(Rule::Times { a: top, b: inverse });
        self.push(Rule::Start { f: Function::Log, of: a, then: Some((rest, Factor::One)) })
    }
}

/// For every register the states it depends on, one by one; with or without what states owe each other over time.
fn dependence(compiled: &Compiled, rates: &[usize], over_time: bool) -> Vec<Vec<bool>> {
    let n = compiled.states;
    let mut known: Vec<Vec<bool>> = (0..compiled.count()).map(|r| (0..n).map(|v| r == v).collect()).collect();
    loop {
        let before = known.clone();
        for (i, rule) in compiled.rules.iter().enumerate() {
            let from = match *rule {
                Rule::Constant(_) => vec![],
                Rule::Negative(a) | Rule::Scaled { a, .. } => vec![a],
                Rule::Combine { a, b, .. } | Rule::Products { a, b, .. } | Rule::Times { a, b } => vec![a, b],
                Rule::Start { of, then, .. } => then.map_or(vec![of], |(rest, _)| vec![of, rest]),
            };
            from.into_iter().for_each(|r| joined(&mut known, n + i, r));
        }
        if over_time {
            rates.iter().enumerate().for_each(|(v, &r)| joined(&mut known, v, r));
        }
        if known == before {
            return known;
        }
    }
}

fn joined(known: &mut [Vec<bool>], to: usize, from: usize) {
    for v in 0..known[to].len() {
        known[to][v] |= known[from][v];
    }
}

impl Sweep {
    /// Room for the states' series up to `order`, and for their slopes up to `slope_order` (none if that is `None`).
    pub fn new(space: &Arc<Space>, tape: &Tape, order: usize, slope_order: Option<usize>) -> Sweep {
        let states = tape.outputs.len();
        let mut compiled = Compiled { states, rules: Vec::new() };
        let mut at = Vec::with_capacity(tape.ops.len());
        for &op in &tape.ops {
            at.push(compiled.add(op, &at));
        }
        let rates: Vec<usize> = tape.outputs.iter().map(|&o| at[o]).collect();
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
        let (rules, products) = (compiled.rules, Vec::new());
        Sweep { space: space.clone(), states, rules, registers, rates, arena, spare, known: 0, ruled: 0, sloped: 0, products }
    }

    /// Forget everything and start at these states.
    pub fn restart(&mut self, at: &[Model]) -> Result<(), Fault> {
        self.arena.clear();
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
        while self.known < order {
            let k = self.known;
            for r in 0..self.rules.len() {
                self.value(r, k)?;
            }
            for v in 0..self.states {
                let (to, from) = (self.registers[v].value + k + 1, self.registers[self.rates[v]].value + k);
                self.arena.scale(to, from, one_over(k + 1)?)?;
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
                        self.arena.scale(to + k + 1, from + k, one_over(k + 1)?)?;
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

    fn value(&mut self, r: usize, k: usize) -> Result<(), Fault> {
        let place = self.at(self.states + r, k);
        match self.rules[r] {
            Rule::Constant(value) if k == 0 => self.arena.set(place, &self.space.constant(value)),
            Rule::Constant(_) => Ok(()),
            Rule::Combine { a, b, sign } => self.arena.combine(place, self.at(a, k), self.at(b, k), sign),
            Rule::Negative(a) => self.arena.scale(place, self.at(a, k), Interval::exactly(-1.0)?),
            Rule::Scaled { a, by } => self.arena.scale(place, self.at(a, k), factor(by, k)?),
            Rule::Times { a, b } => self.arena.sum(place, &[(1.0, self.at(a, k), self.at(b, 0))]),
            Rule::Start { f, of, .. } if k == 0 => {
                let model = self.space.apply(f, &self.arena.model(self.at(of, 0)))?;
                self.arena.set(place, &model)
            }
            Rule::Start { then, .. } => match then {
                Some((rest, by)) => self.arena.scale(place, self.at(rest, k), factor(by, k)?),
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
                (Some(x), None) => self.arena.copy(place, x),
                (None, Some(y)) => self.arena.scale(place, y, Interval::exactly(sign)?),
                (None, None) => Ok(()),
            },
            Rule::Negative(a) => self.scaled(place, of(self, a, k), Interval::exactly(-1.0)?),
            Rule::Scaled { a, by } => self.scaled(place, of(self, a, k), factor(by, k)?),
            Rule::Start { of: a, .. } if chain => {
                let products: Vec<Product> = of(self, a, 0).map(|x| (1.0, x, self.spare)).into_iter().collect();
                self.arena.sum(place, &products)
            }
            Rule::Start { then, .. } => match then {
                Some((rest, by)) => self.scaled(place, of(self, rest, k), factor(by, k)?),
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

fn factor(by: Factor, k: usize) -> Enclosure {
    match by {
        Factor::One => Interval::exactly(1.0),
        Factor::Half => Interval::exactly(0.5),
        Factor::Over(sign) => Interval::exactly(sign)?.div(Interval::exactly(k.max(1) as f64)?),
    }
}
