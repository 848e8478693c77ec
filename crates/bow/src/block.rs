//! The bytes of a vocabulary, wherever they are.
#![allow(unsafe_code)]

use memmap2::Mmap;
use std::fs::{self, File};
use std::io;
use std::path::Path;
use std::sync::Arc;

/// Bytes that are shared, not copied, by a clone.
#[derive(Clone, Debug)]
pub(crate) enum Block {
    /// Part of the program.
    Static(&'static [u8]),
    /// A file as the system shows it.
    Mapped(Arc<Mmap>),
    /// On the heap.
    Bytes(Arc<Vec<u8>>),
    /// On the heap and aligned, with zeros up to a multiple of eight bytes.
    Words(Arc<Vec<u64>>),
}

impl Block {
    /// The contents of a file: mapped, as reading costs ten times as much on first use (memory must be found for it), and
    /// read where the file is nothing that can be mapped.
    /// Pipes, devices and folders are refused.
    pub(crate) fn of_file(path: &Path) -> io::Result<Self> {
        ::io::check_file(path)?;
        let file = File::open(path)?;
        // SAFETY: the map is read-only and every access to it is checked. The file must not be changed in place while
        // it is in use; `tool::save` never does that but puts a new file in its stead.
        if let Ok(map) = unsafe { Mmap::map(&file) } {
            return Ok(Self::Mapped(Arc::new(map)));
        }
        Ok(Self::Bytes(Arc::new(fs::read(path)?)))
    }

    pub(crate) fn bytes(&self) -> &[u8] {
        match self {
            Self::Static(bytes) => bytes,
            Self::Mapped(map) => map,
            Self::Bytes(bytes) => bytes,
            Self::Words(words) => bytemuck::cast_slice(words),
        }
    }

    /// The block if it begins at a multiple of eight bytes, otherwise a copy that does.
    pub(crate) fn aligned(self) -> Self {
        let bytes = self.bytes();
        if bytes.as_ptr().cast::<u64>().is_aligned() {
            return self;
        }
        let mut words = vec![0u64; bytes.len().div_ceil(8)];
        bytemuck::cast_slice_mut(&mut words)[..bytes.len()].copy_from_slice(bytes);
        Self::Words(Arc::new(words))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_anywhere_become_aligned_ones() {
        static BYTES: [u8; 24] = [7; 24];
        for start in 0..8 {
            let block = Block::Static(&BYTES[start..start + 13]).aligned();
            assert!(block.bytes().as_ptr().cast::<u64>().is_aligned());
            assert_eq!(block.bytes()[..13], BYTES[..13]);
            assert!(block.bytes()[13..].iter().all(|&byte| byte == 0));
        }
    }

    #[test]
    fn only_files_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let empty = folder.path().join("empty");
        fs::write(&empty, "").unwrap();
        assert!(Block::of_file(&empty).is_ok_and(|block| block.bytes().is_empty()));
        for path in ["/dev/null", "/"] {
            assert!(Block::of_file(Path::new(path)).is_err(), "{path}");
        }
    }
}
