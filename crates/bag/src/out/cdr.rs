//! CDR as ROS 2 writes it: little-endian, numbers aligned to their size, counted from behind the four bytes of encapsulation.

/// Takes the fields of a message one after another.
#[derive(Debug)]
pub struct Cdr {
    bytes: Vec<u8>,
}

/// Plain CDR, little-endian, without options.
const ENCAPSULATION: [u8; 4] = [0, 1, 0, 0];

impl Cdr {
    /// A message without fields.
    pub(super) fn new() -> Self {
        Self { bytes: ENCAPSULATION.to_vec() }
    }

    /// The message.
    pub(super) fn into_bytes(self) -> Vec<u8> {
        self.bytes
    }

    fn aligned<const N: usize>(&mut self, bytes: [u8; N]) {
        let length = self.bytes.len() - ENCAPSULATION.len();
        self.bytes.resize(ENCAPSULATION.len() + length.next_multiple_of(N), 0);
        self.bytes.extend(bytes);
    }

    pub(super) fn u8(&mut self, value: u8) {
        self.bytes.push(value);
    }

    pub(super) fn bool(&mut self, value: bool) {
        self.bytes.push(u8::from(value));
    }

    pub(super) fn u32(&mut self, value: u32) {
        self.aligned(value.to_le_bytes());
    }

    pub(super) fn i32(&mut self, value: i32) {
        self.aligned(value.to_le_bytes());
    }

    pub(super) fn f64(&mut self, value: f64) {
        self.aligned(value.to_le_bytes());
    }

    /// Numbers of an array whose length the type tells.
    pub(super) fn numbers(&mut self, values: impl IntoIterator<Item = f64>) {
        values.into_iter().for_each(|value| self.f64(value));
    }

    /// How many elements follow.
    pub(super) fn count(&mut self, n: usize) {
        // Messages of 2^32 elements do not fit into a chunk.
        self.u32(u32::try_from(n).unwrap_or(u32::MAX));
    }

    /// A text with its length, the zero at its end included.
    pub(super) fn text(&mut self, text: &str) {
        self.count(text.len() + 1);
        self.bytes.extend(text.as_bytes());
        self.bytes.push(0);
    }

    /// Bytes with their number.
    pub(super) fn blob(&mut self, bytes: &[u8]) {
        self.count(bytes.len());
        self.bytes.extend(bytes);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wire::{Decoder, Wire};

    #[test]
    fn what_is_written_is_read_with_its_alignment() {
        let mut to = Cdr::new();
        to.u8(7);
        to.text("odom");
        to.f64(-2.5);
        to.bool(true);
        to.i32(-3);
        to.blob(&[1, 2, 3]);
        to.u32(9);
        let bytes = to.into_bytes();
        // Behind the text (length 5 at 4) comes the number at 16, the whole number at 28, and so on.
        assert_eq!(bytes.len(), 4 + 16 + 8 + 1 + 3 + 4 + 4 + 3 + 1 + 4);
        let mut of = Decoder::new(&bytes, Wire::Cdr).unwrap();
        assert_eq!(of.u8().unwrap(), 7);
        assert_eq!(of.text().unwrap(), "odom");
        assert_eq!(of.numbers::<1>().unwrap(), [-2.5]);
        assert_eq!(of.u8().unwrap(), 1);
        assert_eq!(of.u32().unwrap() as i32, -3);
        assert_eq!(of.bytes().unwrap(), [1, 2, 3]);
        assert_eq!(of.u32().unwrap(), 9);
    }
}
