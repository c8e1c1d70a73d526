//! How long a step may be (A. Jorba, M. Zou, A software package for the numerical integration of ODEs, 2005).

use crate::automaton::Mode;
use crate::dense::Jets;
use crate::program::{Op, Program};

const FLOOR: f64 = 1e-12; // a state nearer to zero does not ask for shorter steps
const NEAR: f64 = 1e3; // steps to a zero
const TAIL: f64 = 1e-14; // of a watched quantity's magnitude is lost beyond the order

impl Jets {
    /// The length of the step from here: the last two coefficients of state and watched quantities stay in rounding.
    pub fn length(&self, mode: &Mode, room: f64) -> f64 {
        let slopes = &mode.program.slopes;
        let moving = || (0..slopes.len()).filter(|&v| slopes[v].is_some());
        let norm = |k: usize| moving().map(|v| self.state(v)[k].abs()).fold(0.0f64, f64::max);
        let size = norm(0).max(FLOOR);
        let p = self.order;
        let reach = |k: usize| match norm(k) {
            0.0 => f64::INFINITY,
            last => (size / last).powf(1.0 / k as f64),
        };
        let safety = (-2.0 - 0.7 / (p - 1) as f64).exp();
        let mut h = (reach(p - 1).min(reach(p)) * safety).min(room);
        for &r in mode.watched.iter().chain(&mode.observed) {
            h = self.within(r, h);
        }
        h
    }

    /// Whether something that must not be zero will be within about a step: a denominator, what has a logarithm or root.
    pub fn nears_a_pole(&self, program: &Program, h: f64) -> bool {
        program.ops[..program.moving].iter().any(|op| match *op {
            Op::Div(_, a) | Op::Sqrt(a) | Op::Log(a) | Op::Power(a, _) => {
                let series = self.register(a);
                series[0] == 0.0 || series[0].abs() <= NEAR * h * series[1].abs()
            }
            _ => false,
        })
    }

    /// A step on which the series of a register is good, too.
    fn within(&self, r: usize, mut h: f64) -> f64 {
        let series = self.register(r);
        let p = self.order;
        if series[p] == 0.0 && series[p - 1] == 0.0 || !series.iter().all(|c| c.is_finite()) {
            return h;
        }
        for _ in 0..4 {
            let tail = series[p - 1].abs() * h.powi(p as i32 - 1) + series[p].abs() * h.powi(p as i32);
            let size = series[..p - 1].iter().rev().fold(0.0, |sum, c| sum * h + c.abs());
            if tail <= TAIL * size {
                break;
            }
            h *= 0.9 * (TAIL * size / tail).powf(1.0 / (p - 1) as f64).clamp(0.01, 1.0);
        }
        h
    }
}
