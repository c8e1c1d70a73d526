//! The Python face of flowpipes: automata from lists, trees of stretches as objects that judge further claims.

use crate::environment::guarded;
use crate::fault::Fault as Why;
use crate::flowpipe::Settings;
use crate::hybrid::{paced, reach, Budget, Edge, End, Guard, Judgement, Mode, Start, Stretch, Until};
use crate::inputs::Inputs;
use crate::interval::Interval;
use crate::models::Model;
use crate::path::Path;
use crate::python::{comparison, condition, intervals, pairs, tape, Fault, Listing, Pair, Words};
use crate::tree;
use pyo3::prelude::*;

pub(crate) type Comparisons = Vec<(usize, String)>;

fn guard(given: &Comparisons) -> Result<Guard, Why> {
    given.iter().map(|(at, sign)| Ok((*at, comparison(sign)?))).collect()
}

/// An edge as Python gives it: target, urgent, guard, reset, choices, landing, claim.
pub(crate) type EdgeListing = (usize, bool, Comparisons, Listing, usize, Listing, Words);
/// A mode as Python gives it: field, ranges of inputs, watched quantities, domain, facts, what else is said, claim,
/// window, edges.
pub(crate) type ModeListing =
    (Listing, Vec<Pair>, Listing, Comparisons, Comparisons, Words, Words, Words, Vec<EdgeListing>);

fn mode(listing: &ModeListing, variables: usize) -> Result<Mode, Why> {
    let (field, inputs, watch, domain, facts, rest, claim, window, edges) = listing;
    let edge = |(target, is_urgent, guarded, reset, choices, landing, claim): &EdgeListing| -> Result<Edge, Why> {
        Ok(Edge {
            target: *target,
            is_urgent: *is_urgent,
            guard: guard(guarded)?,
            reset: tape(reset, variables + choices)?,
            choices: *choices,
            landing: tape(landing, 2 * variables)?,
            claim: condition(&mut claim.iter(), 0)?,
        })
    };
    let whole = tape(field, variables + inputs.len())?;
    let (field, inputs) = if inputs.is_empty() {
        (whole, None)
    } else {
        let inputs = Inputs::new(whole, intervals(inputs)?);
        (inputs.settled()?, Some(inputs))
    };
    Ok(Mode {
        paced: paced(&field)?,
        field,
        watch: tape(watch, variables)?,
        inputs,
        domain: guard(domain)?,
        facts: guard(facts)?,
        rest: condition(&mut rest.iter(), 0)?,
        claim: condition(&mut claim.iter(), 0)?,
        window: condition(&mut window.iter(), 0)?,
        edges: edges.iter().map(edge).collect::<Result<_, _>>()?,
    })
}

/// What is known of a claim, as Python gets it: holds, fails, instants at which it certainly does.
type Judged = (bool, bool, Option<Pair>, Option<Pair>);

fn judged(claim: &Judgement) -> Judged {
    let ends = |x: Option<Interval>| x.map(|x| (x.low(), x.high()));
    (claim.holds, claim.fails, ends(claim.met), ends(claim.violated))
}

/// A jump as Python gets it: edge, time, states before and after, claim.
type JumpRow = (usize, Pair, Vec<Pair>, Vec<Pair>, Judged);
/// A step as Python gets it: time, states, watched quantities, claim, whether it keeps the window, whether runs stay.
type StepRow = (Pair, Vec<Pair>, Vec<Pair>, Judged, bool, bool);
/// A stretch as Python gets it: parent, mode, jumps, certain, jump, steps, how it ended, the states at the horizon.
pub(crate) type StretchRow = (Option<usize>, usize, usize, bool, Option<JumpRow>, Vec<StepRow>, String, Vec<Pair>);

fn stretch_row(s: &Stretch) -> StretchRow {
    let jump = s
        .jump
        .as_ref()
        .map(|j| (j.edge, (j.time.low(), j.time.high()), pairs(&j.before), pairs(&j.after), judged(&j.claim)));
    let steps = s
        .segments
        .iter()
        .map(|g| {
            let time = (g.time.low(), g.time.high());
            (time, pairs(&g.states), pairs(&g.watched), judged(&g.claim), g.keeps_window, g.stays)
        })
        .collect();
    let end = match s.end {
        End::Horizon => "horizon".to_owned(),
        End::Answered => "answered".to_owned(),
        End::Jumped { may_be_stuck: false } => "jumped".to_owned(),
        End::Jumped { may_be_stuck: true } => "left".to_owned(),
        End::Cut => "cut".to_owned(),
        End::Passed => "passed".to_owned(),
        End::Jumps => "jumps".to_owned(),
        End::Steps => "the steps allowed were used up".to_owned(),
        End::Stretches => "the stretches allowed were used up".to_owned(),
        End::Stopped(why) => why.to_string(),
    };
    let last = s.last.as_deref().map(pairs).unwrap_or_default();
    (s.parent, s.mode, s.jumps, s.is_certain, jump, steps, end, last)
}

/// A recorded step as Python gets it: its length, and for each variable the coefficients in time, polynomials themselves
/// without zeros at their end.
type RecordRow = (f64, Vec<Vec<Vec<f64>>>);

/// Orders and steps, tolerance and lengths of steps, budgets, as Python gives them.
pub(crate) type Limits = ((usize, usize, usize, u32), (f64, f64, f64, f64), (usize, usize, usize));

/// Where runs start: a mode, a box, comparisons of watched quantities that hold there exactly.
pub(crate) type StartListing = (usize, Vec<Pair>, Comparisons);

/// The tree of stretches from a start.
#[pyclass(frozen, module = "haverify._kernel")]
pub struct Tree {
    tree: tree::Tree,
}

/// The tree of stretches from a start, found without the interpreter's lock.
pub(crate) fn followed(
    py: Python<'_>,
    modes: &[ModeListing],
    start: &StartListing,
    horizon: f64,
    until: &str,
    limits: Limits,
) -> PyResult<Tree> {
    let ((order, degree, steps, depth), (tolerance, first_step, longest_step, least_step), budget) = limits;
    let settings = Settings { order, degree, tolerance, first_step, longest_step, least_step, steps, depth };
    let (jumps, stretches, cuts) = budget;
    let analysis = || -> Result<tree::Tree, Why> {
        let until = match until {
            "horizon" => Until::Horizon,
            "met" => Until::Met,
            "violated" => Until::Violated,
            "passed" => Until::Passed,
            _ => return Err(Why::Unknown),
        };
        let modes = listed(modes, start.1.len())?;
        let budget = Budget { jumps, stretches, cuts };
        let start = Start { mode: start.0, sides: intervals(&start.1)?, known: guard(&start.2)? };
        let stretches = reach(&modes, &start, horizon, until, &settings, &budget)?;
        Ok(tree::Tree { modes, sides: start.sides, depth, stretches })
    };
    let tree = py.detach(|| guarded(analysis)).map_err(|why| Fault::new_err(why.to_string()))?;
    Ok(Tree { tree })
}

fn listed(modes: &[ModeListing], variables: usize) -> Result<Vec<Mode>, Why> {
    modes.iter().map(|m| mode(m, variables)).collect()
}

#[pymethods]
impl Tree {
    /// The stretches with the claim they were followed for.
    fn rows(&self) -> Vec<StretchRow> {
        self.tree.stretches.iter().map(stretch_row).collect()
    }

    /// The stretches with the claim of other listings of the same modes, and what holds at the start exactly; `middle`
    /// looks only at the runs from the middle of the set.
    fn judged(
        &self,
        py: Python<'_>,
        modes: Vec<ModeListing>,
        known: Comparisons,
        middle: bool,
    ) -> PyResult<Vec<StretchRow>> {
        let analysis = || self.tree.judged(&listed(&modes, self.tree.sides.len())?, &guard(&known)?, middle);
        let found = py.detach(|| guarded(analysis)).map_err(|why| Fault::new_err(why.to_string()))?;
        Ok(found.iter().map(stretch_row).collect())
    }

    /// The polynomials: for each stretch its parent, mode, edge (as the mode lists them), how it ends, and its steps.
    fn records(&self) -> Vec<RecordedStretch> {
        self.tree.stretches.iter().map(recorded).collect()
    }

    /// How many floats the polynomials have.
    fn size(&self) -> usize {
        self.tree.size()
    }
}

/// A stretch as a second checker needs it: its parent, mode, the edge it begins with, how it ends, its steps with the
/// exponents of their monomials.
type RecordedStretch = (Option<usize>, usize, Option<usize>, String, Vec<(Vec<Vec<usize>>, RecordRow)>);

fn recorded(s: &Stretch) -> RecordedStretch {
    let wide = |e: &Vec<u8>| e.iter().map(|&p| usize::from(p)).collect();
    let trimmed =
        |m: &Model| m.coefficients[..m.coefficients.iter().rposition(|&c| c != 0.0).map_or(0, |k| k + 1)].to_vec();
    let coefficients = |series: &Vec<Model>| series.iter().map(trimmed).collect();
    let series = |path: &Path| path.series.iter().map(coefficients).collect();
    let row = |path: &Path| (path.space.exponents.iter().map(wide).collect(), (path.h, series(path)));
    let (parent, mode, _, _, _, _, end, _) = stretch_row(s);
    let steps = s.segments.iter().filter(|g| g.taken.part.0 == 0.0);
    (parent, mode, s.jump.as_ref().map(|j| j.edge), end, steps.map(|g| row(&g.taken.path)).collect())
}
