//! No two random decisions share a stream.

use std::collections::BTreeSet;

use super::*;

#[test]
fn purpose_frame_and_partner_each_change_the_seed() {
    use SeedPurpose::{InitialPair, LoopVerification, ReferenceKeyframe, Relocalization};
    let mut seeds = BTreeSet::new();
    let mut n = 0;
    for purpose in [ReferenceKeyframe, Relocalization, LoopVerification, InitialPair] {
        for seed in [0, 1] {
            for of in 0..20 {
                for with in 0..20 {
                    seeds.insert(purpose.seed(seed, of, with));
                    n += 1;
                }
            }
        }
    }
    assert_eq!(seeds.len(), n);
}

#[test]
fn the_numbers_of_earlier_versions_stay() {
    // A journal replays with the same seeds: purpose in the lowest byte, partner above.
    assert_eq!(SeedPurpose::ReferenceKeyframe.seed(3, 5, 7), mix_seed(3, 5, 1 + (7 << 8)));
    assert_eq!(SeedPurpose::Relocalization.seed(3, 5, 7), mix_seed(3, 5, 2 + (7 << 8)));
    assert_eq!(SeedPurpose::LoopVerification.seed(3, 5, 7), mix_seed(3, 5, 3 + (7 << 8)));
    assert_eq!(SeedPurpose::InitialPair.seed(3, 5, 0), mix_seed(3, 5, 4));
}
