//! The Python face of the simulator: automata from lists, runs as objects that answer questions.

use crate::automaton::{Automaton, Edge, Mode, Reset};
use crate::chance::Chance;
use crate::condition::Condition;
use crate::dense::{at, Jets};
use crate::program::{Op, Program};
use crate::python::{condition, Words};
use crate::robustness::{robustness, Formula};
use crate::runs::{End, Plan, Policy, Run, Write};
use crate::simulate::simulate;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::sync::Arc;

/// An operation: name, operands, number.
type Operation = (String, Vec<usize>, f64);
/// A reset: variable, register, and another register where any value between both may be taken.
type ResetListing = (usize, usize, Option<usize>);
/// Target, urgent, enabled, resets, observed registers at the landing.
type EdgeListing = (usize, bool, Words, Vec<ResetListing>, Vec<usize>);
/// A formula, the operator before its members: its word, a number (of members, or of a quantity), a window.
type FormulaWords = Vec<(String, usize, f64, f64)>;
/// Operations, how many move, slopes, conditions, domain, terminal, edges, observed registers, outputs.
type ModeListing =
    (Vec<Operation>, usize, Vec<Option<usize>>, Vec<Words>, Words, bool, Vec<usize>, Vec<usize>, Vec<usize>);
/// Mode, state, horizon, limits (jumps, steps, order), policy, seed, given choices, writes.
type PlanListing = (usize, Vec<f64>, f64, (usize, usize, usize), String, u64, Vec<f64>, Vec<(f64, usize, f64)>);

/// How a run ended, when, after how many jumps, in which mode and state.
type EndRow = (String, f64, usize, usize, Vec<f64>);
/// Time, mode, jumps, state, outputs.
type SampleRow = (f64, usize, usize, Vec<f64>, Vec<f64>);

fn wrong(what: &str) -> PyErr {
    PyValueError::new_err(format!("no such {what}"))
}

fn operation((name, a, x): &Operation) -> Option<Op> {
    Some(match (name.as_str(), a.as_slice()) {
        ("constant", []) => Op::Constant(*x),
        ("variable", &[v]) => Op::Variable(v),
        ("add", &[a, b]) => Op::Add(a, b),
        ("sub", &[a, b]) => Op::Sub(a, b),
        ("mul", &[a, b]) => Op::Mul(a, b),
        ("div", &[a, b]) => Op::Div(a, b),
        ("neg", &[a]) => Op::Neg(a),
        ("sqrt", &[a]) => Op::Sqrt(a),
        ("exp", &[a]) => Op::Exp(a),
        ("log", &[a]) => Op::Log(a),
        ("power", &[a]) => Op::Power(a, *x),
        ("sin", &[a]) => Op::Sin(a),
        ("cos", &[a]) => Op::Cos(a),
        ("sinh", &[a]) => Op::Sinh(a),
        ("cosh", &[a]) => Op::Cosh(a),
        ("tanh", &[a]) => Op::Tanh(a),
        ("sech2", &[a]) => Op::Sech2(a),
        ("atan", &[a, q]) => Op::Atan(a, q),
        ("asin", &[a, q]) => Op::Asin(a, q),
        ("acos", &[a, q]) => Op::Acos(a, q),
        ("turn", &[y, x, u, v]) => Op::Turn(y, x, u, v),
        ("abs", &[a]) => Op::Abs(a),
        ("min", &[a, b, d]) => Op::Min(a, b, d),
        ("max", &[a, b, d]) => Op::Max(a, b, d),
        ("choose", &[c, a, b]) => Op::Choose(c, a, b),
        _ => return None,
    })
}

fn read(words: &Words) -> PyResult<Condition> {
    condition(&mut words.iter(), 0).map_err(|_| wrong("condition"))
}

fn edge((target, is_urgent, enabled, resets, landing): &EdgeListing) -> PyResult<Edge> {
    let reset = |&(v, a, b): &ResetListing| b.map_or(Reset::To(v, a), |b| Reset::Between(v, a, b));
    let resets = resets.iter().map(reset).collect();
    Ok(Edge { target: *target, is_urgent: *is_urgent, enabled: read(enabled)?, resets, landing: landing.clone() })
}

fn mode(listing: &ModeListing, edges: &[Edge]) -> PyResult<Mode> {
    let (ops, moving, slopes, conditions, domain, is_terminal, own, observed, _) = listing;
    let ops = ops.iter().map(operation).collect::<Option<Vec<Op>>>().ok_or_else(|| wrong("operation"))?;
    let conditions = conditions.iter().map(read).collect::<PyResult<Vec<Condition>>>()?;
    Program::validated(ops, *moving, slopes.clone(), conditions)
        .and_then(|p| Mode::prepared(p, read(domain).ok()?, *is_terminal, own.clone(), observed.clone(), edges))
        .ok_or_else(|| wrong("register"))
}

/// An automaton, ready to run.
#[pyclass(frozen, module = "haverify._kernel")]
pub struct Simulator {
    automaton: Arc<Automaton>,
    outputs: Arc<Vec<Vec<usize>>>,
}

/// What one run did.
#[pyclass(frozen, module = "haverify._kernel")]
pub struct Record {
    run: Run,
    automaton: Arc<Automaton>,
    outputs: Arc<Vec<Vec<usize>>>,
}

fn plan(listing: PlanListing, keeps_pieces: bool, automaton: &Automaton) -> PyResult<Plan> {
    let (mode, state, horizon, (jumps, steps, order), policy, seed, given, writes) = listing;
    let policy = match policy.as_str() {
        "earliest" => Policy::Earliest,
        "latest" => Policy::Latest,
        "random" => Policy::Random,
        _ => return Err(wrong("policy")),
    };
    let variables = automaton.variables;
    let fits = mode < automaton.modes.len() && state.len() == variables && (3..=60).contains(&order);
    if !fits || writes.iter().any(|w| w.1 >= variables) {
        return Err(wrong("start"));
    }
    let writes = writes.into_iter().map(|(time, variable, value)| Write { time, variable, value }).collect();
    let chance = Chance::new(given, seed);
    Ok(Plan { mode, state, horizon, jumps, steps, order, policy, chance, writes, keeps_pieces })
}

#[pymethods]
impl Simulator {
    #[new]
    fn new(modes: Vec<ModeListing>, edges: Vec<EdgeListing>, variables: usize, clock: Option<usize>) -> PyResult<Self> {
        let edges = edges.iter().map(edge).collect::<PyResult<Vec<Edge>>>()?;
        let listed = modes.iter().map(|m| mode(m, &edges)).collect::<PyResult<Vec<Mode>>>()?;
        let sound = listed.iter().all(|m| m.program.slopes.len() == variables)
            && edges.iter().all(|e| listed.get(e.target).is_some_and(|m| lands(e, m)))
            && modes.iter().zip(&listed).all(|(l, m)| l.8.iter().all(|&r| r < m.program.ops.len()))
            && listed.iter().all(|m| m.edges.iter().all(|&e| resets_fit(&edges[e], m, variables)))
            && clock.is_none_or(|v| v < variables);
        if !sound {
            return Err(wrong("register"));
        }
        let outputs = modes.iter().map(|m| m.8.clone()).collect();
        Ok(Simulator {
            automaton: Arc::new(Automaton { modes: listed, edges, variables, clock }),
            outputs: Arc::new(outputs),
        })
    }

    /// One run with all its pieces.
    fn run(&self, py: Python<'_>, listing: PlanListing) -> PyResult<Record> {
        let plan = plan(listing, true, &self.automaton)?;
        let run = py.detach(|| simulate(&self.automaton, plan));
        Ok(Record { run, automaton: self.automaton.clone(), outputs: self.outputs.clone() })
    }

    /// The values of all registers of a mode at a state.
    fn values(&self, mode: usize, state: Vec<f64>) -> PyResult<Vec<f64>> {
        match self.automaton.modes.get(mode) {
            Some(m) if state.len() == self.automaton.variables => Ok(Jets::values(&m.program, &state)),
            _ => Err(wrong("state")),
        }
    }

    /// The slopes of the state in a mode.
    fn slopes(&self, mode: usize, state: Vec<f64>) -> PyResult<Vec<f64>> {
        let values = self.values(mode, state)?;
        Ok(self.automaton.modes[mode].program.slopes.iter().map(|s| s.map_or(0.0, |r| values[r])).collect())
    }

    /// The value of a formula on many runs.
    fn robustness(&self, py: Python<'_>, listings: Vec<PlanListing>, words: FormulaWords) -> PyResult<Vec<f64>> {
        let asked = judged(&words, &self.automaton)?;
        let plans = listings.into_iter().map(|l| plan(l, true, &self.automaton)).collect::<PyResult<Vec<Plan>>>()?;
        let value = |p| robustness(&simulate(&self.automaton, p), &asked);
        Ok(py.detach(|| plans.into_iter().map(value).collect()))
    }

    /// The ends of many runs: how each ended, when, after how many jumps, in which mode and state.
    fn ends(&self, py: Python<'_>, listings: Vec<PlanListing>) -> PyResult<Vec<EndRow>> {
        let plans = listings.into_iter().map(|l| plan(l, false, &self.automaton)).collect::<PyResult<Vec<Plan>>>()?;
        let runs: Vec<Run> = py.detach(|| plans.into_iter().map(|p| simulate(&self.automaton, p)).collect());
        Ok(runs.into_iter().map(|r| (word(&r.end).to_owned(), r.time, r.jumps.len(), r.mode, r.state)).collect())
    }
}

fn lands(edge: &Edge, target: &Mode) -> bool {
    let fits = edge.landing.is_empty() || edge.landing.len() == target.observed.len();
    fits && edge.landing.iter().all(|&r| r < target.program.ops.len())
}

fn formula(words: &mut std::slice::Iter<(String, usize, f64, f64)>, depth: usize) -> PyResult<Formula> {
    let (word, n, a, b) = words.next().filter(|_| depth < 200).ok_or_else(|| wrong("formula"))?;
    let mut one = || formula(words, depth + 1).map(Box::new);
    Ok(match word.as_str() {
        "atom" => Formula::Atom(*n),
        "not" => Formula::Not(one()?),
        "globally" => Formula::Globally(*a, *b, one()?),
        "eventually" => Formula::Eventually(*a, *b, one()?),
        "until" => Formula::Until(*a, *b, one()?, one()?),
        "and" => Formula::And((0..*n).map(|_| formula(words, depth + 1)).collect::<PyResult<_>>()?),
        "or" => Formula::Or((0..*n).map(|_| formula(words, depth + 1)).collect::<PyResult<_>>()?),
        _ => return Err(wrong("formula")),
    })
}

/// A formula whose quantities every mode observes.
fn judged(words: &FormulaWords, automaton: &Automaton) -> PyResult<Formula> {
    let found = formula(&mut words.iter(), 0)?;
    let highest = words.iter().filter(|w| w.0 == "atom").map(|w| w.1 + 1).max().unwrap_or(0);
    if automaton.modes.iter().any(|m| m.observed.len() < highest) || !found.is_supported() {
        return Err(wrong("formula"));
    }
    Ok(found)
}

fn resets_fit(edge: &Edge, mode: &Mode, variables: usize) -> bool {
    let count = mode.program.ops.len();
    edge.resets.iter().all(|r| match *r {
        Reset::To(v, a) => v < variables && a < count,
        Reset::Between(v, a, b) => v < variables && a < count && b < count,
    })
}

fn word(end: &End) -> &'static str {
    match end {
        End::Horizon => "horizon",
        End::Jumps => "jumps",
        End::Steps => "steps",
        End::Outside => "outside",
        End::Stuck => "stuck",
        End::Ended => "ended",
        End::Zeno(_) => "zeno",
        End::Escape => "escape",
        End::Undefined => "undefined",
    }
}

/// A piece as Python gets it: mode, jumps, start, length, series of the variables, series of what is observed.
type PieceRow = (usize, usize, f64, f64, Vec<Vec<f64>>, Vec<Vec<f64>>);

fn rows(flat: &[f64], count: usize) -> Vec<Vec<f64>> {
    let width = flat.len().checked_div(count).unwrap_or(1).max(1);
    flat.chunks(width).map(<[f64]>::to_vec).collect()
}

#[pymethods]
impl Record {
    /// How it ended, when, in which mode and state, at which time jumps accumulate (NaN where they do not), steps.
    fn end(&self) -> (String, f64, usize, Vec<f64>, f64, usize) {
        let r = &self.run;
        let limit = if let End::Zeno(limit) = r.end { limit } else { f64::NAN };
        (word(&r.end).to_owned(), r.time, r.mode, r.state.clone(), limit, r.steps)
    }

    /// The jumps: time, edge, state before, state after.
    fn jumps(&self) -> Vec<(f64, usize, Vec<f64>, Vec<f64>)> {
        self.run.jumps.iter().map(|j| (j.time, j.edge, j.before.clone(), j.after.clone())).collect()
    }

    /// The value of a formula.
    fn robustness(&self, words: FormulaWords) -> PyResult<f64> {
        Ok(robustness(&self.run, &judged(&words, &self.automaton)?))
    }

    fn pieces(&self) -> Vec<PieceRow> {
        let n = self.automaton.variables;
        let row = |p: &crate::runs::Piece| {
            let observed = rows(&p.observed, self.automaton.modes[p.mode].observed.len());
            (p.mode, p.jumps, p.start, p.length, rows(&p.states, n), observed)
        };
        self.run.pieces.iter().map(row).collect()
    }

    /// At each time, and at both sides of each jump: time, mode, jumps, state, outputs.
    fn sample(&self, times: Vec<f64>) -> Vec<SampleRow> {
        let mut found = Vec::new();
        let mut next = times.iter().copied().peekable();
        let mut last = None;
        for p in self.run.pieces.iter() {
            let end = p.start + p.length;
            let mut inside = Vec::new();
            if last != Some(p.jumps) {
                inside.push(p.start);
            }
            while let Some(&t) = next.peek().filter(|&&t| t <= end) {
                if t >= p.start && inside.last() != Some(&t) {
                    inside.push(t);
                }
                next.next();
            }
            last = Some(p.jumps);
            let is_last = !self.run.pieces.iter().any(|q| q.jumps == p.jumps && q.start > p.start);
            if is_last && inside.last() != Some(&end) {
                inside.push(end);
            }
            found.extend(inside.into_iter().map(|t| self.row(p, t)));
        }
        found
    }
}

impl Record {
    fn row(&self, p: &crate::runs::Piece, t: f64) -> SampleRow {
        let state: Vec<f64> = rows(&p.states, self.automaton.variables).iter().map(|s| at(s, t - p.start)).collect();
        let values = Jets::values(&self.automaton.modes[p.mode].program, &state);
        let outputs = self.outputs[p.mode].iter().map(|&r| values[r]).collect();
        (t, p.mode, p.jumps, state, outputs)
    }
}
