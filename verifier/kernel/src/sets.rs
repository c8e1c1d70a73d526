//! Sets of states: one Taylor model for each variable, over the same box [-1, 1]^n of set variables.

use crate::fault::Fault;
use crate::interval::Interval;
use crate::models::{raised, Model, Space, UNIT};

/// The states `{ p(z) + e : |e_v| <= radius_v }` for `z` in the box.
#[derive(Debug, Clone)]
pub struct Set {
    pub space: Space,
    pub models: Vec<Model>,
}

impl Set {
    /// A box; each side that is wide is a variable of the set, an enclosure of one number is an error.
    pub fn of_box(sides: &[Interval], degree: usize) -> Set {
        let is_wide = |x: &Interval| x.high() - x.low() > (1e-14 * x.norm()).max(1e-305);
        let wide: Vec<usize> = (0..sides.len()).filter(|&v| is_wide(&sides[v])).collect();
        let space = Space::new(wide.len(), degree);
        let models = sides.iter().enumerate().map(|(v, x)| {
            let middle = x.midpoint();
            let half = if x.low() == x.high() { 0.0 } else { raised((x.high() - middle).max(middle - x.low())) };
            match wide.iter().position(|&w| w == v) {
                Some(z) => space.variable(z, middle, half),
                None => Model { radius: half, ..space.number(middle) },
            }
        });
        Set { models: models.collect(), space }
    }

    /// A box around the set.
    pub fn hull(&self) -> Result<Vec<Interval>, Fault> {
        self.models.iter().map(|m| self.space.range(m)).collect()
    }

    /// The same set with more variables: each new one is a model of its own, from -1 to 1.
    pub fn with_choices(&self, count: usize) -> Set {
        let space = Space::new(self.space.variables + count, self.space.degree);
        let mut models: Vec<Model> = self.models.iter().map(|m| embedded(m, &self.space, &space)).collect();
        models.extend((0..count).map(|c| space.variable(self.space.variables + c, 0.0, 1.0)));
        Set { space, models }
    }

    /// The two halves of the set, cut where its most influential variable is zero; `None` for a point.
    pub fn halves(&self) -> Option<[Set; 2]> {
        let influence = |v: usize| {
            let of = |m: &Model| {
                let terms = m.coefficients.iter().zip(&self.space.exponents);
                terms.filter(|(_, e)| e[v] > 0).map(|(c, _)| c.abs()).sum::<f64>()
            };
            self.models.iter().map(of).sum::<f64>()
        };
        let v = (0..self.space.variables).max_by(|&a, &b| influence(a).total_cmp(&influence(b)))?;
        (influence(v) > 0.0).then(|| [-1.0, 1.0].map(|side| self.half(v, side)))
    }

    /// What `z_v = (side + z_v') / 2` leaves.
    fn half(&self, v: usize, side: f64) -> Set {
        let models = self.models.iter().map(|m| substituted(m, &self.space, v, side)).collect();
        Set { space: self.space.clone(), models }
    }
}

/// A model in a space with further variables, which it does not depend on.
fn embedded(m: &Model, from: &Space, to: &Space) -> Model {
    let mut out = to.zero();
    for (c, exponents) in m.coefficients.iter().zip(&from.exponents) {
        let mut wide = exponents.clone();
        wide.resize(to.variables, 0);
        out.coefficients[to.position(&wide)] = *c;
    }
    Model { radius: m.radius, ..out }
}

fn substituted(m: &Model, space: &Space, v: usize, side: f64) -> Model {
    let mut out = space.zero();
    let mut mass = 0.0;
    for (c, exponents) in m.coefficients.iter().zip(&space.exponents) {
        let power = exponents[v];
        let mut target = exponents.clone();
        // The binomial coefficients over a power of two are exact: powers are small.
        let mut binomial = 1.0;
        for j in 0..=power {
            target[v] = power - j;
            let sign = if j % 2 == 1 { side } else { 1.0 };
            let term = c * (sign * binomial / f64::from(1u32 << power));
            out.coefficients[space.position(&target)] += term;
            mass += term.abs();
            binomial = binomial * f64::from(power - j) / f64::from(j + 1);
        }
    }
    let rounding = if mass == 0.0 { 0.0 } else { raised(UNIT * (4 * space.size() + 4) as f64 * mass) };
    out.radius = if rounding == 0.0 { m.radius } else { raised(m.radius + rounding) };
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(space: &Space, m: &Model, z: &[f64]) -> f64 {
        let monomial = |e: &Vec<u8>| e.iter().zip(z).map(|(&p, x)| x.powi(i32::from(p))).product::<f64>();
        m.coefficients.iter().zip(&space.exponents).map(|(c, e)| c * monomial(e)).sum()
    }

    fn set() -> Set {
        let space = Space::new(2, 3);
        let coefficients = (0..space.size()).map(|i| f64::from(i as u32 % 5) - 1.7).collect();
        Set { models: vec![Model { coefficients, radius: 0.0 }], space }
    }

    #[test]
    fn the_halves_are_the_set() {
        let whole = set();
        let halves = whole.halves().expect("it is wide");
        for (half, side) in halves.iter().zip([-1.0, 1.0]) {
            for z in [[0.3, -0.7], [1.0, 1.0], [-1.0, 0.2]] {
                let v = (0..2).find(|&v| {
                    (value(&half.space, &half.models[0], &z)
                        - value(&whole.space, &whole.models[0], &moved(z, v, side)))
                    .abs()
                        < 1e-12
                });
                assert!(v.is_some());
            }
        }
    }

    fn moved(mut z: [f64; 2], v: usize, side: f64) -> [f64; 2] {
        z[v] = (side + z[v]) / 2.0;
        z
    }

    #[test]
    fn choices_are_new_variables() {
        let more = set().with_choices(1);
        assert_eq!(more.models.len(), 2);
        let z = [0.3, -0.7, 0.9];
        assert!(
            (value(&more.space, &more.models[0], &z) - value(&set().space, &set().models[0], &z[..2])).abs() < 1e-12
        );
        assert!((value(&more.space, &more.models[1], &z) - 0.9).abs() < 1e-12);
    }

    #[test]
    fn a_point_has_no_halves() {
        let point = Set::of_box(&[Interval::exactly(1.0).expect("finite")], 3);
        assert!(point.halves().is_none() && point.space.variables == 0);
    }
}
