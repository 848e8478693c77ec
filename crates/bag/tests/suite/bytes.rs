//! Bytes of messages in ROS 1's form or in CDR, and records of a ROS 1 bag. The fuzz targets use this file, too.

/// Bytes of values.
pub(super) struct Bytes {
    pub(super) all: Vec<u8>,
    is_cdr: bool,
}

impl Bytes {
    /// A message that begins with a header.
    pub(super) fn with_header(is_cdr: bool, t_ns: i64) -> Self {
        let mut of = Self { all: if is_cdr { vec![0, 1, 0, 0] } else { Vec::new() }, is_cdr };
        if !is_cdr {
            of.u32(7);
        }
        of.u32((t_ns / 1_000_000_000) as usize);
        of.u32((t_ns % 1_000_000_000) as usize);
        of.text("frame");
        of
    }

    fn put(&mut self, bytes: &[u8]) {
        if self.is_cdr {
            let at = self.all.len() - 4;
            self.all.resize(at.next_multiple_of(bytes.len()) + 4, 0);
        }
        self.all.extend(bytes);
    }

    pub(super) fn u32(&mut self, value: usize) {
        self.put(&(value as u32).to_le_bytes());
    }

    pub(super) fn numbers(&mut self, values: &[f64]) {
        values.iter().for_each(|value| self.put(&value.to_le_bytes()));
    }

    pub(super) fn text(&mut self, text: &str) {
        self.u32(text.len() + usize::from(self.is_cdr));
        self.all.extend(text.as_bytes());
        self.all.extend(std::iter::repeat_n(0, usize::from(self.is_cdr)));
    }

    pub(super) fn bytes(&mut self, bytes: &[u8]) {
        self.u32(bytes.len());
        self.all.extend(bytes);
    }

    /// An image after its header.
    pub(super) fn image(&mut self, (width, height): (usize, usize), encoding: &str, data: &[u8]) {
        self.u32(height);
        self.u32(width);
        self.text(encoding);
        self.all.push(0);
        self.u32(data.len() / height);
        self.bytes(data);
    }
}

/// A field of a record's head.
pub(super) fn field(name: &str, value: &[u8]) -> Vec<u8> {
    let length = (name.len() + 1 + value.len()) as u32;
    [&length.to_le_bytes()[..], name.as_bytes(), b"=", value].concat()
}

pub(super) fn record(head: &[Vec<u8>], data: &[u8]) -> Vec<u8> {
    let head = head.concat();
    [&(head.len() as u32).to_le_bytes()[..], &head, &(data.len() as u32).to_le_bytes()[..], data].concat()
}
