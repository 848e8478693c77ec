//! The 256-bit ORB descriptor and its Hamming distance.

/// 256 brightness comparisons; bit `i` is bit `i % 64` of word `i / 64` (byte order and bit order as OpenCV's ORB).
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Descriptor(pub [u64; 4]);

impl Descriptor {
    /// Number of differing bits, 0 to 256.
    ///
    /// Where many distances are needed use the searches of this crate: they are compiled for processors with a
    /// population count instruction too and choose at run time.
    #[inline(always)]
    pub fn distance(&self, other: &Self) -> u32 {
        let [a0, a1, a2, a3] = self.0;
        let [b0, b1, b2, b3] = other.0;
        (a0 ^ b0).count_ones() + (a1 ^ b1).count_ones() + (a2 ^ b2).count_ones() + (a3 ^ b3).count_ones()
    }

    /// The 32 bytes as OpenCV stores them.
    pub fn to_bytes(&self) -> [u8; 32] {
        let mut bytes = [0; 32];
        for (chunk, word) in bytes.chunks_exact_mut(8).zip(self.0) {
            chunk.copy_from_slice(&word.to_le_bytes());
        }
        bytes
    }

    /// The descriptor of 32 bytes as OpenCV stores them.
    pub fn from_bytes(bytes: &[u8; 32]) -> Self {
        let mut words = [0; 4];
        for (i, byte) in bytes.iter().enumerate() {
            words[i / 8] |= u64::from(*byte) << (8 * (i % 8));
        }
        Self(words)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distance_counts_differing_bits() {
        let a = Descriptor([0, u64::MAX, 5, 1 << 63]);
        assert_eq!(a.distance(&a), 0);
        assert_eq!(a.distance(&Descriptor([1, u64::MAX - 1, 5, 0])), 3);
        assert_eq!(Descriptor([0; 4]).distance(&Descriptor([u64::MAX; 4])), 256);
    }

    #[test]
    fn bytes_round_trip() {
        let bytes: [u8; 32] = std::array::from_fn(|i| (i * 37 + 11) as u8);
        let descriptor = Descriptor::from_bytes(&bytes);
        assert_eq!(descriptor.to_bytes(), bytes);
        assert_eq!(descriptor.0[0] & 0xff, 11);
    }
}
