//! The built-in vocabulary, see `vocab/README.md`.

use crate::error::FormatError;
use crate::vocabulary::Vocabulary;

/// Makes the linker put the bytes where they can be used in place.
#[repr(C, align(64))]
struct Aligned<T: ?Sized>(T);

static BYTES: &Aligned<[u8]> = &Aligned(*include_bytes!("../orb.dbow"));

impl Vocabulary {
    /// The built-in vocabulary: nothing to find, nothing to copy. Checks every byte, so keep it.
    ///
    /// # Errors
    /// [`FormatError`] when the program was built with a broken `vocab/orb.dbow`.
    pub fn built_in() -> Result<Self, FormatError> {
        Self::from_static(&BYTES.0)
    }
}
