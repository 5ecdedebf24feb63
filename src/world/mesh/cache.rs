//! Convex parts on disk: the points of each part, under a key of the mesh's bytes and its scale.
//!
//! A hull is made around the corners that were kept; what can't be read is made anew.

use std::sync::Arc;

use super::Hulls;
use crate::geom::Vec3;
use crate::geom::hull::Hull;

/// Counted up whenever parts or hulls are computed in another way.
const VERSION: &str = "1";

/// Returns the name under which the parts of a mesh are kept.
pub fn key(bytes: &[u8], scale: &[f64; 3]) -> String {
    let scale = scale.map(f64::to_bits).map(u64::to_le_bytes);
    let hash = hash(bytes.iter().chain(scale.as_flattened()));
    format!("{hash:032x}-{VERSION}.parts")
}

/// FNV-1a of 128 bits (RFC 9923): the same on every machine. Not against malice: who can write the cache can write the mesh.
fn hash<'a>(bytes: impl Iterator<Item = &'a u8>) -> u128 {
    const PRIME: u128 = 0x0000_0000_0100_0000_0000_0000_0000_013b;
    const START: u128 = 0x6c62_272e_07bb_0142_62b8_2175_6295_c58d;
    bytes.fold(START, |hash, byte| (hash ^ u128::from(*byte)).wrapping_mul(PRIME))
}

/// Returns the parts as bytes.
pub fn write(hulls: &Hulls) -> Vec<u8> {
    let mut out = Vec::new();
    let number = |n: usize| u32::try_from(n).unwrap_or(u32::MAX).to_le_bytes();
    out.extend(number(hulls.len()));
    for (hull, origin) in hulls {
        let numbers = hull.as_numbers();
        out.extend(number(numbers.len()));
        for n in origin.iter().chain(&numbers) {
            out.extend(n.to_le_bytes());
        }
    }
    out.extend(hash(out.iter()).to_le_bytes());
    out
}

/// Returns the parts of bytes that [`write`] made; `None` for any others.
pub fn read(bytes: &[u8]) -> Option<Hulls> {
    let (content, end) = bytes.split_last_chunk::<16>()?;
    if hash(content.iter()) != u128::from_le_bytes(*end) {
        return None;
    }
    let mut rest = content;
    let count = |rest: &mut &[u8]| -> Option<usize> {
        let (n, after) = rest.split_first_chunk::<4>()?;
        *rest = after;
        usize::try_from(u32::from_le_bytes(*n)).ok()
    };
    let mut hulls = Vec::new();
    for _ in 0..count(&mut rest)? {
        let n = count(&mut rest)?;
        let mut numbers = Vec::new();
        for _ in 0..n.checked_add(3)? {
            let (number, after) = rest.split_first_chunk::<8>()?;
            rest = after;
            numbers.push(f64::from_le_bytes(*number));
        }
        let (origin, hull) = numbers.split_first_chunk::<3>()?;
        hulls.push((Arc::new(Hull::from_numbers(hull)?), Vec3::from(*origin)));
    }
    (rest.is_empty() && !hulls.is_empty()).then_some(hulls)
}
