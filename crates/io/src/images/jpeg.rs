//! Whether a JPEG file is whole: decoders fill up what is missing with gray and say nothing.

/// Whether the end marker comes after the last scan; what stands behind it (further pictures, notes) does not count.
pub(super) fn is_complete(bytes: &[u8]) -> bool {
    /// Start of scan, end of image.
    const SCAN: u8 = 0xda;
    const END: u8 = 0xd9;
    let mut at = 2;
    loop {
        let Some(&[0xff, marker]) = bytes.get(at..at + 2) else { return false };
        match marker {
            END => return true,
            // Fill bytes, and markers without a length.
            0xff => at += 1,
            0x01 | 0xd0..=0xd8 => at += 2,
            _ => {
                let Some(&[high, low]) = bytes.get(at + 2..at + 4) else { return false };
                at += 2 + usize::from(u16::from_be_bytes([high, low])).max(2);
                if marker == SCAN {
                    match end_of_scan(bytes.get(at..).unwrap_or_default()) {
                        Some(length) => at += length,
                        None => return false,
                    }
                }
            }
        }
    }
}

/// The length of coded data up to the next marker that is not part of it (restarts, and 0xff written as 0xff00).
fn end_of_scan(coded: &[u8]) -> Option<usize> {
    coded.windows(2).position(|two| two[0] == 0xff && !matches!(two[1], 0x00 | 0xd0..=0xd7 | 0xff))
}

#[cfg(test)]
mod tests {
    use super::is_complete;

    #[test]
    fn only_the_end_marker_after_the_last_scan_ends_a_file() {
        // Start, a comment that holds an end marker, a scan with stuffed and restart bytes, the end, and something behind it.
        let whole = [
            &[0xff, 0xd8, 0xff, 0xfe, 0, 4, 0xff, 0xd9][..],
            &[0xff, 0xda, 0, 3, 7, 1, 0xff, 0, 2, 0xff, 0xd3, 3, 0xff, 0xd9],
            &[9, 9],
        ]
        .concat();
        assert!(is_complete(&whole));
        for length in 0..whole.len() - 2 {
            assert!(!is_complete(&whole[..length]), "{length}");
        }
    }
}
