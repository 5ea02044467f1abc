//! Inputs that are several files, and numbers from bytes.

/// What stands between the files of an input, on a line of its own, before the name of the next.
const MARK: &[u8] = b"\n==== ";

/// The first file of an input, and all others with their names.
pub(crate) fn files(data: &[u8]) -> (&[u8], Vec<(String, Vec<u8>)>) {
    let mut rest = data;
    let mut parts = Vec::new();
    while let Some(at) = rest.windows(MARK.len()).position(|bytes| bytes == MARK) {
        parts.push(&rest[..at]);
        rest = &rest[at + MARK.len()..];
    }
    parts.push(rest);
    let named = parts[1..].iter().filter_map(|part| {
        let end = part.iter().position(|byte| *byte == b'\n')?;
        let name = String::from_utf8(part[..end].to_vec()).ok()?;
        Some((name, part[end + 1..].to_vec()))
    });
    (parts[0], named.collect())
}

/// Numbers out of bytes; zeros at their end.
#[derive(Clone, Debug)]
pub(crate) struct Numbers<'d>(&'d [u8]);

impl<'d> Numbers<'d> {
    /// All numbers of an input.
    pub(crate) fn of(data: &'d [u8]) -> Self {
        Self(data)
    }

    /// Whether there are more.
    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The next byte.
    pub(crate) fn byte(&mut self) -> u8 {
        let Some((first, rest)) = self.0.split_first() else { return 0 };
        self.0 = rest;
        *first
    }

    /// A number below `end`, which is at most 2^16.
    pub(crate) fn below(&mut self, end: usize) -> usize {
        let number = usize::from(self.byte()) << 8 | usize::from(self.byte());
        number % end.max(1)
    }

    /// A coordinate: often a small whole number, so that corners and edges meet; else any finite number.
    pub(crate) fn coordinate(&mut self) -> f32 {
        match self.byte() {
            0 => {
                let bits = [self.byte(), self.byte(), self.byte(), self.byte()];
                let any = f32::from_le_bytes(bits);
                if any.is_finite() { any.clamp(-1e18, 1e18) } else { 0.0 }
            }
            1..=31 => f32::from(self.byte() as i8) / 7.0 + f32::from(self.byte()) / 5000.0,
            whole => f32::from(whole as i8) / 16.0,
        }
    }
}
