//! A small random generator whose numbers never change.

/// SplitMix64 (Steele, Lea, Flood 2014, "Fast splittable pseudorandom number generators"): 64 bits of state, passes
/// the usual test batteries, twelve lines. Written here so that a seed means the same job for good.
#[derive(Clone, Debug)]
pub struct Rng(u64);

impl Rng {
    /// A generator for a seed; neighbouring seeds give unrelated numbers.
    pub fn new(seed: u64) -> Self {
        let mut rng = Self(seed);
        rng.0 = rng.next().rotate_left(17) ^ seed;
        rng
    }

    /// 64 random bits.
    #[allow(clippy::should_implement_trait, reason = "an endless generator is no iterator")]
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Uniform in [lo, hi).
    pub fn real(&mut self, lo: f64, hi: f64) -> f64 {
        lo + (hi - lo) * self.unit()
    }

    /// Between lo and hi, the logarithm uniform; both > 0.
    pub fn log(&mut self, lo: f64, hi: f64) -> f64 {
        lo * (hi / lo).powf(self.unit())
    }

    /// Uniform in lo ..= hi.
    pub fn int(&mut self, lo: usize, hi: usize) -> usize {
        lo + ((u128::from(self.next()) * (hi - lo + 1) as u128) >> 64) as usize
    }

    /// True with this probability.
    pub fn chance(&mut self, probability: f64) -> bool {
        self.unit() < probability
    }

    /// One entry of a list that is not empty.
    pub fn pick<'a, T>(&mut self, list: &'a [T]) -> &'a T {
        &list[self.int(0, list.len() - 1)]
    }

    /// A direction: an angle in [0, 2π).
    pub fn angle(&mut self) -> f64 {
        self.real(0.0, std::f64::consts::TAU)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_numbers_are_frozen() {
        let mut rng = Rng::new(42);
        let got = [rng.next(), rng.next(), rng.next()];
        assert_eq!(got, FROZEN, "{got:#x?}");
    }

    const FROZEN: [u64; 3] = [0xcb25_7c66_00c0_4a6b, 0x3342_e265_3013_7e4c, 0x4e69_2c0d_8243_f38c];

    #[test]
    fn ranges_are_kept() {
        let mut rng = Rng::new(7);
        let mut seen = [0; 5];
        for _ in 0..1000 {
            seen[rng.int(0, 4)] += 1;
            let x = rng.log(0.1, 10.0);
            assert!((0.1..10.0).contains(&x) && rng.unit() < 1.0);
        }
        assert!(seen.iter().all(|&n| n > 140), "{seen:?}");
    }
}
