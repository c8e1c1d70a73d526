//! Jumps that accumulate: the time at which they would, by the ratio of the times between them.

const LEAST: usize = 8; // jumps before anything is said
const STEADY: f64 = 0.02; // how much the ratio may still change
const REST: f64 = 1e-7; // of the time so far, or of a second: a rest so short is extrapolated
const AT_ONCE: usize = 400; // jumps at one instant

#[derive(Debug, Default)]
pub struct Accumulation {
    times: Vec<f64>,
}

/// Note a jump; the time at which jumps accumulate, where they have come close to it.
pub fn accumulation(known: &mut Accumulation, time: f64) -> Option<f64> {
    known.times.push(time);
    let n = known.times.len();
    if n > AT_ONCE && known.times[n - 1] == known.times[n - 1 - AT_ONCE] {
        return Some(time);
    }
    (1..=2).find_map(|lag| {
        if n < LEAST + 3 * lag {
            return None;
        }
        let gap = |k: usize| known.times[n - 1 - k * lag] - known.times[n - 1 - (k + 1) * lag];
        let (last, before, earlier) = (gap(0), gap(1), gap(2));
        let (ratio, older) = (last / before, before / earlier);
        let rest = last * ratio / (1.0 - ratio);
        let shrinks = last > 0.0 && ratio < 0.9999 && older < 0.9999 && (ratio - older).abs() < STEADY * (1.0 - ratio);
        (shrinks && rest < REST * time.max(1e-3)).then_some(time + rest)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_geometric_series_ends_at_its_sum() {
        let mut known = Accumulation::default();
        let mut t = 0.0;
        let limit = (0..200).find_map(|k| {
            t += 0.7f64.powi(k);
            accumulation(&mut known, t)
        });
        assert!((limit.unwrap() - 1.0 / 0.3).abs() < 1e-12);
    }

    #[test]
    fn even_steps_never_accumulate() {
        let mut known = Accumulation::default();
        assert!((0..3000).all(|k| accumulation(&mut known, f64::from(k)).is_none()));
    }
}
