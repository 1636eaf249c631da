//! Decompresses files.

use std::io::{self, BufReader, Cursor, ErrorKind, Read};

use super::gzip::{self, Members};
use super::zstd::{self, Frames};

/// The number of bytes that are needed to detect a compression format.
const START: usize = 4;

/// Decompresses `input` if it starts with the magic of gzip or zstd. Other input stays unchanged. Only the first bytes
/// are read in advance. The input may contain several consecutive gzip members or zstd frames, and zeros after them.
/// Reading fails if other data follows them. The returned flag is true if the input is unchanged.
///
/// All bytes before an error can be read. The error then repeats.
pub fn decompressed(mut input: impl Read + Send + 'static) -> io::Result<(Box<dyn Read + Send>, bool)> {
    let mut start = Vec::with_capacity(START);
    input.by_ref().take(START as u64).read_to_end(&mut start)?;
    let (is_gzip, is_zstd) = (start.starts_with(&gzip::MAGIC), zstd::is_frame(&start));
    let whole = Cursor::new(start).chain(input);
    Ok(if is_gzip {
        (Box::new(Lasting::new("gzip data: ", Members::new(BufReader::new(whole)))), false)
    } else if is_zstd {
        (Box::new(Lasting::new("zstd data: ", Frames::new(BufReader::new(whole))?)), false)
    } else {
        (Box::new(Lasting::new("", whole)), true)
    })
}

/// A reader whose first error repeats. Decoders return an error once, and then behave as if the data had ended. Code
/// that reads ahead would therefore lose the error.
struct Lasting<R> {
    input: R,
    /// The start of the error's text.
    prefix: &'static str,
    failure: Option<(ErrorKind, String)>,
}

impl<R> Lasting<R> {
    fn new(prefix: &'static str, input: R) -> Self {
        Self { input, prefix, failure: None }
    }
}

impl<R: Read> Read for Lasting<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        if self.failure.is_none() {
            match self.input.read(out) {
                Err(error) if error.kind() != ErrorKind::Interrupted => {
                    self.failure = Some((error.kind(), format!("{}{error}", self.prefix)));
                }
                result => return result,
            }
        }
        let (kind, text) = self.failure.clone().unwrap_or((ErrorKind::Other, String::new()));
        Err(io::Error::new(kind, text))
    }
}

/// A reader that ends at the first error. Readers of captures look ahead, so an error would hide the last records before
/// it.
pub struct UpToError<R> {
    input: R,
    /// The error, once the input has ended there.
    pub error: Option<io::Error>,
}

impl<R> UpToError<R> {
    /// Reads this input.
    pub fn new(input: R) -> Self {
        Self { input, error: None }
    }
}

impl<R: Read> Read for UpToError<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        if self.error.is_some() {
            return Ok(0);
        }
        match self.input.read(out) {
            Err(error) if error.kind() != ErrorKind::Interrupted => {
                self.error = Some(error);
                Ok(0)
            }
            result => result,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write as _;

    use flate2::Compression;
    use flate2::write::GzEncoder;
    use ruzstd::encoding::{CompressionLevel, compress_to_vec};

    use super::*;

    /// The readable bytes, and the error.
    fn read(bytes: &[u8]) -> (Vec<u8>, Option<String>) {
        let mut text = Vec::new();
        let mut input = match decompressed(Cursor::new(bytes.to_vec())) {
            Ok((input, _)) => input,
            Err(error) => return (text, Some(error.to_string())),
        };
        let error = input.read_to_end(&mut text).err().map(|error| error.to_string());
        let again = input.read(&mut [0]).err().map(|error| error.to_string());
        assert_eq!(again, error, "the error repeats");
        (text, error)
    }

    fn gzip(bytes: &[u8]) -> Vec<u8> {
        let mut gzip = GzEncoder::new(Vec::new(), Compression::fast());
        gzip.write_all(bytes).expect("memory");
        gzip.finish().expect("memory")
    }

    fn zstd(bytes: &[u8]) -> Vec<u8> {
        compress_to_vec(bytes, CompressionLevel::Fastest)
    }

    #[test]
    fn detects_compression_from_the_first_bytes() {
        let text = b"ULog and more, ".repeat(1_000);
        let (gzip, zstd) = (gzip(&text), zstd(&text));
        for bytes in [&text, &gzip, &zstd] {
            assert_eq!(read(bytes), (text.clone(), None));
        }
        for packed in [&gzip, &zstd] {
            let zeros = [&packed[..], &vec![0; 70_000]].concat();
            assert_eq!(read(&zeros), (text.clone(), None), "zeros after the data");
            for twice in [[&packed[..], packed].concat(), [&zeros[..], packed].concat()] {
                assert_eq!(read(&twice), (text.repeat(2), None), "several members");
                let (found, error) = read(&[&twice[..], b"neither this nor that"].concat());
                assert_eq!(found, text.repeat(2));
                assert!(error.is_some(), "trailing data");
            }
        }
        let skipped = b"\x50\x2a\x4d\x18\x03\0\0\0abc";
        assert_eq!(read(&[&skipped[..], &zstd].concat()), (text, None), "as written by pzstd");
        for short in [&b""[..], b"U", b"\x1f", b"\x28\xb5"] {
            assert_eq!(read(short), (short.to_vec(), None));
        }
    }

    #[test]
    fn reads_up_to_an_error() {
        let text: Vec<u8> =
            (0..200_000_u32).flat_map(|number| number.wrapping_mul(number).to_le_bytes()).collect();
        let (gzip, zstd) = (gzip(&text), zstd(&text));
        for (packed, trailer) in [(&gzip, 8), (&zstd, 4)] {
            for cut in 1..=trailer {
                let (found, error) = read(&packed[..packed.len() - cut]);
                assert_eq!(found, text, "only the trailer is truncated: {cut}");
                assert!(error.is_some(), "{cut}");
            }
            for (cut, min) in [(packed.len() / 2, 1), (packed.len() - trailer - 1, text.len() / 2)] {
                let (found, error) = read(&packed[..cut]);
                assert!(text.starts_with(&found) && found.len() >= min, "{} of {}", found.len(), text.len());
                assert!(error.is_some());
            }
        }
        // The checksum and the length of gzip data.
        for at in 1..=8 {
            let mut changed = gzip.clone();
            let at = changed.len() - at;
            changed[at] ^= 1;
            let (found, error) = read(&changed);
            assert_eq!(found, text);
            let error = error.expect("a wrong trailer");
            assert!(error.starts_with("gzip data: ") && error.contains("checksum"), "{error}");
        }
    }
}
