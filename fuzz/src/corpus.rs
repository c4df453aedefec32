//! The stored inputs of a target: seeds, which are named files, and the pack of the inputs that campaigns
//! found.
//!
//! A pack is a tar archive under gzip, `corpora/TARGET.tar.gz`. It holds each input once, in the order of
//! the bytes, under a number, without dates and owners. So the same inputs always give the same file, in
//! any order.

use std::collections::BTreeSet;
use std::fs;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

use flate2::bufread::GzDecoder;
use flate2::write::GzEncoder;
use flate2::{Compression, GzBuilder};
use tar::{Archive, Builder, EntryType, Header};
use thiserror::Error;

/// A stored input.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Input {
    /// Its place: the file of a seed, or the pack and the input's number in it.
    pub name: String,
    /// The input itself.
    pub bytes: Vec<u8>,
}

/// Why stored inputs cannot be read or written.
#[derive(Debug, Error)]
pub enum CorpusError {
    /// A file or folder cannot be read.
    #[error("cannot read {}: {source}. If it is missing, restore it: git checkout -- {}",
        path.display(), path.display())]
    Read {
        /// The file or folder.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// A pack is not complete or not intact.
    #[error("the pack {} is damaged: {source}. Restore it: git checkout -- {}",
        path.display(), path.display())]
    Damaged {
        /// The pack.
        path: PathBuf,
        /// The defect.
        source: io::Error,
    },
    /// A file or folder cannot be written.
    #[error("cannot write {}: {source}. Check the permissions and the free space, then repeat the command.",
        path.display())]
    Write {
        /// The file or folder.
        path: PathBuf,
        /// The system's error.
        source: io::Error,
    },
    /// The folder to unpack to has files in it.
    #[error("{} is not empty. Remove it, or name another folder to unpack to.", path.display())]
    NotEmpty {
        /// The folder.
        path: PathBuf,
    },
}

/// The pack of a target.
#[must_use]
pub fn pack_of(target: &str) -> PathBuf {
    here().join("corpora").join(format!("{target}.tar.gz"))
}

/// The folder of a target's seeds. A target may have none.
#[must_use]
pub fn seeds_of(target: &str) -> PathBuf {
    here().join("seeds").join(target)
}

/// All stored inputs of a target: its seeds, then its pack.
///
/// # Errors
/// [`CorpusError`] naming the file, and how to restore it.
pub fn stored(target: &str) -> Result<Vec<Input>, CorpusError> {
    let mut inputs = seeds(target)?;
    let file = pack_of(target).file_name().unwrap_or_default().to_string_lossy().into_owned();
    let packed = packed(target)?.into_iter().enumerate();
    inputs.extend(packed.map(|(number, bytes)| Input { name: format!("{file}/{}", label(number)), bytes }));
    Ok(inputs)
}

/// The seeds of a target, by name.
///
/// # Errors
/// [`CorpusError::Read`] naming the file.
pub fn seeds(target: &str) -> Result<Vec<Input>, CorpusError> {
    let folder = seeds_of(target);
    if folder.is_dir() { files(&folder) } else { Ok(Vec::new()) }
}

/// The inputs in a target's pack, in order.
///
/// # Errors
/// [`CorpusError`] naming the pack, and how to restore it.
pub fn packed(target: &str) -> Result<Vec<Vec<u8>>, CorpusError> {
    let path = pack_of(target);
    match fs::read(&path) {
        Ok(bytes) => unpack(&bytes).map_err(|source| CorpusError::Damaged { path, source }),
        Err(source) => Err(CorpusError::Read { path, source }),
    }
}

/// Writes the inputs of a target's pack to an empty or new folder, one file each. Returns their number.
///
/// # Errors
/// [`CorpusError`] naming the pack or the folder.
pub fn unpack_to(target: &str, folder: &Path) -> Result<usize, CorpusError> {
    let write = |path: &Path, source| CorpusError::Write { path: path.to_path_buf(), source };
    fs::create_dir_all(folder).map_err(|source| write(folder, source))?;
    let read = |source| CorpusError::Read { path: folder.to_path_buf(), source };
    if fs::read_dir(folder).map_err(read)?.next().is_some() {
        return Err(CorpusError::NotEmpty { path: folder.to_path_buf() });
    }
    let inputs = packed(target)?;
    for (number, bytes) in inputs.iter().enumerate() {
        let path = folder.join(label(number));
        fs::write(&path, bytes).map_err(|source| write(&path, source))?;
    }
    Ok(inputs.len())
}

/// Makes a target's pack from the files of a folder, without copies of its seeds. Returns the number of
/// inputs in the pack.
///
/// # Errors
/// [`CorpusError`] naming the file or the folder. The old pack is then unchanged.
pub fn pack_from(target: &str, folder: &Path) -> Result<usize, CorpusError> {
    let seeds: BTreeSet<Vec<u8>> = seeds(target)?.into_iter().map(|seed| seed.bytes).collect();
    let found = files(folder)?.into_iter().map(|input| input.bytes);
    let inputs: BTreeSet<Vec<u8>> = found.filter(|bytes| !seeds.contains(bytes)).collect();
    let path = pack_of(target);
    // A rename replaces the pack whole, or not at all.
    let part = path.with_extension("tmp");
    let count = inputs.len();
    let written =
        pack(inputs).and_then(|bytes| fs::write(&part, bytes)).and_then(|()| fs::rename(&part, &path));
    written.map_err(|source| CorpusError::Write { path, source })?;
    Ok(count)
}

/// The bytes of a pack with these inputs.
///
/// # Errors
/// Packing in memory does not fail. The signature is that of the writers.
pub fn pack(inputs: impl IntoIterator<Item = Vec<u8>>) -> io::Result<Vec<u8>> {
    let inputs: BTreeSet<Vec<u8>> = inputs.into_iter().collect();
    let gzip: GzEncoder<Vec<u8>> = GzBuilder::new().mtime(0).write(Vec::new(), Compression::best());
    let mut archive = Builder::new(gzip);
    for (number, bytes) in inputs.iter().enumerate() {
        let mut header = Header::new_ustar();
        header.set_path(label(number))?;
        header.set_size(u64::try_from(bytes.len()).map_err(io::Error::other)?);
        header.set_entry_type(EntryType::Regular);
        header.set_mode(0o644);
        header.set_uid(0);
        header.set_gid(0);
        header.set_mtime(0);
        header.set_cksum();
        archive.append(&header, bytes.as_slice())?;
    }
    let mut gzip = archive.into_inner()?;
    gzip.flush()?;
    gzip.finish()
}

/// The inputs in the bytes of a pack, in order.
///
/// # Errors
/// When the bytes are not a whole and intact pack.
pub fn unpack(pack: &[u8]) -> io::Result<Vec<Vec<u8>>> {
    let damaged = |reason: &str| io::Error::new(io::ErrorKind::InvalidData, reason);
    let mut archive = Vec::new();
    let mut gzip = GzDecoder::new(pack);
    // The checksum is at the end, so the code reads all bytes before it uses any.
    gzip.read_to_end(&mut archive)?;
    if !gzip.into_inner().is_empty() {
        return Err(damaged("bytes follow its end"));
    }
    let mut inputs: Vec<Vec<u8>> = Vec::new();
    for entry in Archive::new(archive.as_slice()).entries()? {
        let mut bytes = Vec::new();
        entry?.read_to_end(&mut bytes)?;
        if inputs.last().is_some_and(|last| *last >= bytes) {
            return Err(damaged("its inputs are not in order"));
        }
        inputs.push(bytes);
    }
    Ok(inputs)
}

fn here() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The name of an input in its pack.
fn label(number: usize) -> String {
    format!("{number:04}")
}

/// The files of a folder, by name.
fn files(folder: &Path) -> Result<Vec<Input>, CorpusError> {
    let read = |path: &Path, source| CorpusError::Read { path: path.to_path_buf(), source };
    let entries = fs::read_dir(folder).map_err(|source| read(folder, source))?;
    let paths = entries.map(|entry| Ok(entry?.path())).collect::<io::Result<Vec<_>>>();
    let mut paths = paths.map_err(|source| read(folder, source))?;
    paths.sort();
    let input = |path: PathBuf| {
        let bytes = fs::read(&path).map_err(|source| read(&path, source))?;
        Ok(Input { name: path.file_name().unwrap_or_default().to_string_lossy().into_owned(), bytes })
    };
    paths.into_iter().map(input).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn inputs() -> Vec<Vec<u8>> {
        vec![b"b".to_vec(), vec![], b"a longer one".repeat(100), b"a".to_vec(), vec![0; 512], b"b".to_vec()]
    }

    #[test]
    fn packing_twice_gives_the_same_bytes() {
        let once = pack(inputs()).unwrap();
        assert_eq!(pack(inputs().into_iter().rev()).unwrap(), once);
        let unpacked = unpack(&once).unwrap();
        assert_eq!(unpacked, inputs().into_iter().collect::<BTreeSet<_>>().into_iter().collect::<Vec<_>>());
        assert_eq!(pack(unpacked).unwrap(), once);
    }

    #[test]
    fn damaged_pack_is_refused() {
        let whole = pack(inputs()).unwrap();
        let content = unpack(&whole).unwrap();
        for length in 0..whole.len() {
            assert!(unpack(&whole[..length]).is_err(), "{length} of {} bytes", whole.len());
        }
        assert!(unpack(&[&whole[..], b"x"].concat()).is_err());
        for at in 0..whole.len() {
            let mut changed = whole.clone();
            changed[at] ^= 1;
            // The date and the system in gzip's header have no effect.
            assert!(unpack(&changed).map_or(true, |read| read == content), "byte {at}");
        }
    }

    #[test]
    fn errors_name_the_file_and_the_remedy() {
        let missing = packed("no_such_target").unwrap_err().to_string();
        assert!(
            missing.contains("no_such_target.tar.gz") && missing.contains("git checkout -- "),
            "{missing}"
        );
        let source = unpack(b"no pack").unwrap_err();
        let damaged = CorpusError::Damaged { path: "clear.tar.gz".into(), source }.to_string();
        assert!(
            damaged.contains("clear.tar.gz is damaged") && damaged.contains("git checkout -- "),
            "{damaged}"
        );
        let used = unpack_to("clear", here()).unwrap_err().to_string();
        assert!(used.contains("is not empty"), "{used}");
    }
}
