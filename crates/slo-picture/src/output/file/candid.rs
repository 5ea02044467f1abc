//! Errors of the system, through encoders that hide them.

use std::io::{self, Read, Seek, SeekFrom, Write};

/// A stream that keeps the system's first error. Encoders tend to hide it in errors of their own, and
/// whether to wait and try again depends on it.
pub(in crate::output) struct Candid<W> {
    out: W,
    error: Option<io::Error>,
}

impl<W> Candid<W> {
    pub(in crate::output) fn new(out: W) -> Self {
        Self { out, error: None }
    }

    /// The system's error if there was one, otherwise what the encoder makes of it.
    pub(in crate::output) fn said<T>(self, result: io::Result<T>) -> io::Result<T> {
        result.map_err(|error| self.error.unwrap_or(error))
    }

    fn note<T>(&mut self, result: io::Result<T>) -> io::Result<T> {
        result.map_err(|error| {
            let kind = error.kind();
            if kind != io::ErrorKind::Interrupted {
                self.error.get_or_insert(error);
            }
            kind.into()
        })
    }
}

impl<W: Write> Write for Candid<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.out.write(bytes);
        self.note(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        let flushed = self.out.flush();
        self.note(flushed)
    }
}

impl<W: Read> Read for Candid<W> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let read = self.out.read(bytes);
        self.note(read)
    }
}

impl<W: Seek> Seek for Candid<W> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let sought = self.out.seek(to);
        self.note(sought)
    }
}
