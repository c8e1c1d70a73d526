//! The tree of stretches from a start, kept so that other claims are judged without following the flow again.

use crate::fault::Fault;
use crate::hybrid::{check, Edge, Guard, Jump, Mode, Segment, Start, Stretch};
use crate::interval::Interval;
use crate::judging::Judge;
use crate::walk::judged;

pub struct Tree {
    pub modes: Vec<Mode>,
    pub sides: Vec<Interval>,
    /// How often a part of a step is halved where a claim is open.
    pub depth: u32,
    pub stretches: Vec<Stretch>,
}

impl Tree {
    /// How many floats its polynomials have.
    pub fn size(&self) -> usize {
        let steps = self.stretches.iter().flat_map(|s| &s.segments).filter(|g| g.taken.part.0 == 0.0);
        steps.map(|g| g.taken.path.series.iter().flatten().map(|m| m.coefficients.len()).sum::<usize>()).sum()
    }

    /// The stretches as the claims of other modes are judged on them; these may differ in nothing but what they claim.
    /// Nothing is certain here: what is judged may prove, not refute.
    ///
    /// In the middle, only the runs are looked at that start where all set variables are zero.
    pub fn judged(&self, modes: &[Mode], known: &Guard, is_middle: bool) -> Result<Vec<Stretch>, Fault> {
        let is_alike = modes.len() == self.modes.len() && modes.iter().zip(&self.modes).all(|(a, b)| alike(a, b));
        if !is_alike {
            return Err(Fault::Unknown);
        }
        let mode = self.stretches.first().map_or(0, |s| s.mode);
        check(modes, &Start { mode, sides: self.sides.clone(), known: known.clone() })?;
        self.stretches.iter().map(|s| self.stretch(s, modes, known, is_middle)).collect()
    }

    fn stretch(&self, s: &Stretch, modes: &[Mode], known: &Guard, is_middle: bool) -> Result<Stretch, Fault> {
        let mode = &modes[s.mode];
        let landed = s.jump.as_ref().map(|jump| (mode.borders(&jump.after), &jump.after));
        let (first, sides) = match &landed {
            Some((borders, after)) => (borders, *after),
            None if s.parent.is_none() => (known, &self.sides),
            None => (&Guard::new(), &self.sides),
        };
        let segment = |(number, g): (usize, &Segment)| -> Result<Segment, Fault> {
            let is_first = number == 0;
            let judge = Judge {
                mode,
                taken: &g.taken,
                known: if is_first { first } else { &[] },
                sides,
                is_first,
                is_certain: false,
                is_middle,
            };
            // Whether runs stay is no matter of the claim.
            Ok(Segment { stays: g.stays, ..judge.seen_again(&g.states, self.depth)?.of(g.taken.clone()) })
        };
        let segments = s.segments.iter().enumerate().map(segment).collect::<Result<_, _>>()?;
        let jump = match (&s.jump, s.parent) {
            (Some(jump), Some(parent)) => Some(again(jump, &modes[self.stretches[parent].mode].edges[jump.edge])?),
            _ => None,
        };
        Ok(Stretch { segments, jump, last: s.last.clone(), ..*s })
    }
}

/// A jump, its claim judged anew.
fn again(jump: &Jump, edge: &Edge) -> Result<Jump, Fault> {
    let truth = edge.claim.truth(&edge.quantities(&jump.landed)?);
    Ok(Jump { claim: judged(truth, jump.time, false), ..jump.clone() })
}

/// Whether two modes have the same runs, as far as this can be seen without comparing expressions.
fn alike(a: &Mode, b: &Mode) -> bool {
    let edges = a.edges.len() == b.edges.len() && a.edges.iter().zip(&b.edges).all(|(x, y)| alike_edges(x, y));
    a.field.ops == b.field.ops
        && a.field.outputs == b.field.outputs
        && a.inputs == b.inputs
        && a.domain == b.domain
        && a.facts == b.facts
        && a.rest == b.rest
        && edges
}

fn alike_edges(a: &Edge, b: &Edge) -> bool {
    let reset = a.reset.ops == b.reset.ops && a.reset.outputs == b.reset.outputs;
    reset && (a.target, a.is_urgent, a.choices) == (b.target, b.is_urgent, b.choices) && a.guard == b.guard
}
