//! Bytes of messages: ROS 1's serialization, and CDR as ROS 2 writes it.

/// How messages are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Wire {
    /// Little-endian, without padding; headers begin with a sequence number.
    Ros1,
    /// CDR with its four bytes of encapsulation; numbers are aligned to their size.
    Cdr,
}

/// Takes values from a message, one after another.
pub(crate) struct Decoder<'a> {
    bytes: &'a [u8],
    at: usize,
    wire: Wire,
    is_big_endian: bool,
}

/// What is wrong with a message, in words.
pub(crate) type Decoded<T> = Result<T, String>;

macro_rules! number {
    ($name:ident, $type:ty) => {
        pub(crate) fn $name(&mut self) -> Decoded<$type> {
            let bytes = self.aligned(size_of::<$type>())?;
            let mut value = [0; size_of::<$type>()];
            value.copy_from_slice(bytes);
            Ok(if self.is_big_endian { <$type>::from_be_bytes(value) } else { <$type>::from_le_bytes(value) })
        }
    };
}

impl<'a> Decoder<'a> {
    pub(crate) fn new(bytes: &'a [u8], wire: Wire) -> Decoded<Self> {
        match wire {
            Wire::Ros1 => Ok(Self { bytes, at: 0, wire, is_big_endian: false }),
            Wire::Cdr => match bytes {
                [0, kind @ (0 | 1), _, _, rest @ ..] => {
                    Ok(Self { bytes: rest, at: 0, wire, is_big_endian: *kind == 0 })
                }
                _ => Err("not CDR: its first bytes are not 0, 0 or 0, 1".to_owned()),
            },
        }
    }

    number!(u8, u8);
    number!(u32, u32);
    number!(i32, i32);
    number!(f64, f64);

    /// Bytes of a number of that size.
    fn aligned(&mut self, size: usize) -> Decoded<&'a [u8]> {
        if self.wire == Wire::Cdr {
            self.at = self.at.next_multiple_of(size);
        }
        self.take(size)
    }

    /// The next bytes as they are.
    fn take(&mut self, length: usize) -> Decoded<&'a [u8]> {
        let end = self.at.checked_add(length).filter(|end| *end <= self.bytes.len());
        let end = end.ok_or_else(|| {
            format!("it ends at byte {}, within a value of {length} bytes", self.bytes.len())
        })?;
        let bytes = &self.bytes[self.at..end];
        self.at = end;
        Ok(bytes)
    }

    /// A sequence of bytes.
    pub(crate) fn bytes(&mut self) -> Decoded<&'a [u8]> {
        let length = self.u32()? as usize;
        self.take(length)
    }

    /// A text, without the zero that CDR ends it with.
    pub(crate) fn text(&mut self) -> Decoded<String> {
        let bytes = self.bytes()?;
        let bytes = bytes.strip_suffix(&[0]).unwrap_or(bytes);
        Ok(String::from_utf8_lossy(bytes).into_owned())
    }

    /// Numbers without a length before them.
    pub(crate) fn numbers<const N: usize>(&mut self) -> Decoded<[f64; N]> {
        let mut all = [0.0; N];
        for value in &mut all {
            *value = self.f64()?;
        }
        Ok(all)
    }

    /// Numbers with their count before them.
    pub(crate) fn counted(&mut self) -> Decoded<Vec<f64>> {
        let n = self.u32()? as usize;
        // The bytes that are left bound the count before anything is reserved.
        if n > (self.bytes.len() - self.at) / size_of::<f64>() {
            return Err(format!("{n} numbers, more than there is room for"));
        }
        (0..n).map(|_| self.f64()).collect()
    }

    /// A `std_msgs/Header`: its stamp, nanoseconds, and its frame.
    pub(crate) fn header(&mut self) -> Decoded<(i64, String)> {
        if self.wire == Wire::Ros1 {
            self.u32()?;
        }
        let t_ns = self.stamp()?;
        Ok((t_ns, self.text()?))
    }

    /// A time, nanoseconds.
    pub(crate) fn stamp(&mut self) -> Decoded<i64> {
        let seconds = match self.wire {
            Wire::Ros1 => i64::from(self.u32()?),
            Wire::Cdr => i64::from(self.i32()?),
        };
        Ok(seconds * 1_000_000_000 + i64::from(self.u32()?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cdr_is_aligned_and_of_either_order() {
        let little = [0, 1, 0, 0, 7, 0, 0, 0, 2, 0, 0, 0, b'a', 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xf0, 0x3f];
        let mut of = Decoder::new(&little, Wire::Cdr).unwrap();
        assert_eq!((of.u8().unwrap(), of.text().unwrap()), (7, "a".to_owned()));
        let mut padded = little.to_vec();
        padded.splice(16..16, [0; 4]);
        padded.truncate(padded.len() - 4);
        let big = [0, 0, 0, 0, 0, 0, 0, 5];
        assert_eq!(Decoder::new(&big, Wire::Cdr).unwrap().u32(), Ok(5));
        assert!(Decoder::new(&[9, 9, 9, 9], Wire::Cdr).is_err());
    }

    #[test]
    fn ros_1_has_no_padding_and_a_number_before_the_stamp() {
        let mut bytes = vec![1, 0, 0, 0, 5, 0, 0, 0, 6, 0, 0, 0, 3, 0, 0, 0];
        bytes.extend(b"cam");
        bytes.push(9);
        let mut of = Decoder::new(&bytes, Wire::Ros1).unwrap();
        assert_eq!(of.header(), Ok((5_000_000_006, "cam".to_owned())));
        assert_eq!(of.u8(), Ok(9));
        assert_eq!(of.u8(), Err("it ends at byte 20, within a value of 1 bytes".to_owned()));
    }

    #[test]
    fn a_count_that_cannot_be_true_reserves_nothing() {
        let bytes = [0xff, 0xff, 0xff, 0xff, 1, 2, 3];
        assert_eq!(
            Decoder::new(&bytes, Wire::Ros1).unwrap().counted(),
            Err("4294967295 numbers, more than there is room for".to_owned())
        );
        assert!(Decoder::new(&bytes, Wire::Ros1).unwrap().bytes().is_err());
    }
}
