//! SHA-256, by which files are known again.

use std::fmt::Write as _;
use std::io::Read;
use std::path::Path;

use sha2::{Digest as _, Sha256};

use crate::io::error::FileError;
use crate::io::open;

/// One that is made bit by bit.
#[derive(Debug, Clone, Default)]
pub struct Digest(Sha256);

impl Digest {
    /// Nothing so far.
    pub fn new() -> Self {
        Self::default()
    }

    /// Goes on with samples: with their bytes as 32-bit floats, the lowest first, as a WAV file has them.
    pub fn samples(&mut self, samples: &[f32]) {
        let mut bytes = [0; 1024];
        for samples in samples.chunks(bytes.len() / 4) {
            for (sample, bytes) in samples.iter().zip(bytes.chunks_exact_mut(4)) {
                bytes.copy_from_slice(&sample.to_le_bytes());
            }
            self.0.update(&bytes[..4 * samples.len()]);
        }
    }

    /// Goes on with bytes.
    pub fn bytes(&mut self, bytes: &[u8]) {
        self.0.update(bytes);
    }

    /// Of all that, in hexadecimal.
    pub fn finish(self) -> String {
        hexadecimal(&self.0.finalize())
    }
}

/// Of bytes, in hexadecimal.
pub fn of_bytes(bytes: &[u8]) -> String {
    hexadecimal(&Sha256::digest(bytes))
}

/// Of a file, in hexadecimal.
///
/// # Errors
/// One that cannot be read.
pub fn of_file(path: &Path) -> Result<String, FileError> {
    let mut file = open::open(path)?;
    let (mut digest, mut buffer) = (Sha256::default(), vec![0; 1 << 16]);
    loop {
        match file.read(&mut buffer).map_err(|error| FileError::reading(path, &error))? {
            0 => return Ok(hexadecimal(&digest.finalize())),
            read => digest.update(&buffer[..read]),
        }
    }
}

fn hexadecimal(bytes: &[u8]) -> String {
    let mut text = String::with_capacity(2 * bytes.len());
    for byte in bytes {
        // A string takes whatever it is given.
        let _ = write!(text, "{byte:02x}");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::{Digest, of_bytes, of_file};

    #[test]
    fn samples_count_as_a_file_has_them() {
        let samples: Vec<f32> = (0..1000).map(|n| (n as f32 - 300.0) / 700.0).collect();
        let bytes: Vec<u8> = samples.iter().flat_map(|x| x.to_le_bytes()).collect();
        let mut digest = Digest::new();
        let (some, others) = samples.split_at(333);
        digest.samples(some);
        digest.samples(others);
        assert_eq!(digest.finish(), of_bytes(&bytes));
    }

    #[test]
    fn it_is_that_of_the_standard() {
        // FIPS 180-4's example `abc`, and of nothing.
        let abc = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(of_bytes(b"abc"), abc);
        assert_eq!(of_bytes(b""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
        let path = std::env::temp_dir().join(format!("pacinian-digest-{}", std::process::id()));
        std::fs::write(&path, b"abc").unwrap();
        assert_eq!(of_file(&path).unwrap(), abc);
        std::fs::remove_file(&path).unwrap();
        assert!(of_file(&path).is_err());
    }
}
