//! Seeds for random generators that are created afresh for each frame and purpose.

/// Mixes a run's seed, a frame number and a purpose number into a seed whose bits all depend on all three inputs
/// (the finaliser of SplitMix64, Steele, Lea and Flood 2014, applied once per input).
pub fn mix_seed(seed: u64, frame: u64, purpose: u64) -> u64 {
    splitmix(splitmix(splitmix(seed) ^ frame) ^ purpose)
}

fn splitmix(value: u64) -> u64 {
    let mut z = value.wrapping_add(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn splitmix_returns_the_published_first_outputs_for_seed_zero() {
        assert_eq!(splitmix(0), 0xE220_A839_7B1D_CDAF);
        assert_eq!(splitmix(0x9E37_79B9_7F4A_7C15), 0x6E78_9E6A_A1B9_65F4);
    }

    #[test]
    fn neighboring_inputs_and_swapped_arguments_give_distinct_seeds() {
        let mut seen = BTreeSet::new();
        for seed in 0..16 {
            for frame in 0..16 {
                for purpose in 0..16 {
                    assert!(seen.insert(mix_seed(seed, frame, purpose)));
                }
            }
        }
    }
}
