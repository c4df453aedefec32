//! The fuzzed properties as tests: over our drawings, and over random mutations of them.

use std::path::Path;

fn drawings() -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/drawings");
    let entries = std::fs::read_dir(folder).expect("the drawings are in the repository");
    let mut names: Vec<_> = entries.map(|entry| entry.expect("readable").path()).collect();
    names.sort();
    names.iter().map(|path| std::fs::read(path).expect("readable")).collect()
}

/// Flips, cuts, doubles and swaps pieces, and replaces numbers by hostile ones.
fn mutated(bytes: &[u8], random: &mut fastrand::Rng) -> Vec<u8> {
    const NUMBERS: [&str; 12] = [
        "nan",
        "inf",
        "-inf",
        "1e300",
        "-1e300",
        "1e-300",
        "0",
        "-0",
        "5368.709121",
        "99999999999",
        "-1",
        "0.00001",
    ];
    let mut lines: Vec<Vec<u8>> = bytes.split(|&byte| byte == b'\n').map(<[u8]>::to_vec).collect();
    for _ in 0..random.usize(1..4) {
        let at = random.usize(0..lines.len());
        match random.u8(0..6) {
            0 => lines[at] = NUMBERS[random.usize(0..NUMBERS.len())].into(),
            1 => {
                lines.remove(at);
            }
            2 => lines.insert(at, lines[at].clone()),
            3 => lines.truncate(at.max(1)),
            4 => {
                let other = random.usize(0..lines.len());
                lines.swap(at, other);
            }
            _ => {
                if let Some(byte) = lines[at].first_mut() {
                    *byte ^= 1 << random.u8(0..8);
                }
            }
        }
        if lines.is_empty() {
            return Vec::new();
        }
    }
    lines.join(&b'\n')
}

#[test]
fn drawings_and_their_mutations() {
    let mut random = fastrand::Rng::with_seed(23);
    for bytes in drawings() {
        keepout_fuzz::dxf_import(&bytes);
        for _ in 0..80 {
            keepout_fuzz::dxf_import(&mutated(&bytes, &mut random));
        }
    }
}

#[test]
fn plan_files_with_a_valid_hash_and_any_contents() {
    let mut random = fastrand::Rng::with_seed(29);
    for length in 0..600 {
        let payload: Vec<u8> = (0..length).map(|_| random.u8(..)).collect();
        let mut bytes = b"KEEPOUT PLAN".to_vec();
        bytes.extend(keepout_planner::plan_file::VERSION.to_le_bytes());
        bytes.extend(keepout_planner::plan_file::hash(&payload));
        bytes.extend(payload);
        keepout_fuzz::plan_file(&bytes);
    }
}

#[test]
fn controller_bytes() {
    let mut random = fastrand::Rng::with_seed(31);
    let words: [&[u8]; 9] = [
        b"<Idle|MPos:",
        b"1.0,2.0,0",
        b"|Bf:15,128",
        b">\r\n",
        b"ok\r\n",
        b"error:",
        b"$10=",
        b"nan",
        b"\xff\x00",
    ];
    for _ in 0..20_000 {
        let bytes: Vec<u8> =
            (0..random.usize(0..8)).flat_map(|_| words[random.usize(0..words.len())].to_vec()).collect();
        keepout_fuzz::grbl_decode(&bytes);
    }
}

/// Any bytes are inputs of some property of the trusted core.
#[test]
fn properties_of_bytes() {
    let mut random = fastrand::Rng::with_seed(37);
    for _ in 0..40_000 {
        let bytes: Vec<u8> = (0..random.usize(2..200)).map(|_| random.u8(..)).collect();
        keepout_proofs::property_of_bytes(&bytes);
    }
}

#[test]
fn structured_drawings() {
    let mut random = fastrand::Rng::with_seed(41);
    for _ in 0..3000 {
        let bytes: Vec<u8> = (0..random.usize(20..400)).map(|_| random.u8(..)).collect();
        keepout_fuzz::drawing(&bytes);
    }
}
