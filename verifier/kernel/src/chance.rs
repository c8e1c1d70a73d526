//! What a run leaves to chance: numbers in [0, 1] that are given first, then drawn (Steele, Lea, Flood 2014).

#[derive(Debug, Clone)]
pub struct Chance {
    given: Vec<f64>,
    used: usize,
    state: u64,
}

impl Chance {
    pub fn new(given: Vec<f64>, seed: u64) -> Chance {
        Chance { given, used: 0, state: seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ 0xD1B5_4A32_D192_ED03 }
    }

    pub fn share(&mut self) -> f64 {
        if let Some(&x) = self.given.get(self.used) {
            self.used += 1;
            return x.clamp(0.0, 1.0);
        }
        self.state = self.state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.state;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// One of so many.
    pub fn pick(&mut self, count: usize) -> usize {
        ((self.share() * count as f64) as usize).min(count.saturating_sub(1))
    }
}
