//! STL, binary and ASCII.
//!
//! Which of the two is told by the length, since the header of a binary file may begin with `solid`: a binary file of n triangles
//! has 84 + 50 n bytes.

use super::{MOST_TRIANGLES, add_polygon, number};
use crate::geom::Vec3;
use crate::geom::mesh::Mesh;

const HEADER: usize = 84;
const TRIANGLE: usize = 50;

/// Reads an STL file, or says what is wrong with it.
pub fn read(bytes: &[u8]) -> Result<Mesh, String> {
    let n = bytes.get(80..HEADER).map_or(0, little_endian) as usize;
    let wanted = HEADER.saturating_add(n.saturating_mul(TRIANGLE));
    let is_ascii = bytes.trim_ascii_start().starts_with(b"solid") && std::str::from_utf8(bytes).is_ok();
    if bytes.len() >= HEADER && (bytes.len() == wanted || !is_ascii) {
        if bytes.len() < wanted {
            let whole = (bytes.len() - HEADER) / TRIANGLE;
            return Err(format!("it ends after {whole} of its {n} triangles"));
        }
        return binary(&bytes[HEADER..wanted]);
    }
    match std::str::from_utf8(bytes) {
        Ok(text) if is_ascii => ascii(text),
        _ => Err("it is no STL: neither does it begin with `solid`, nor has it a header of 84 bytes".into()),
    }
}

fn little_endian(bytes: &[u8]) -> u32 {
    bytes.iter().rev().fold(0, |n, b| n << 8 | u32::from(*b))
}

fn binary(triangles: &[u8]) -> Result<Mesh, String> {
    let mut mesh = Mesh::default();
    if triangles.len() / TRIANGLE > MOST_TRIANGLES {
        return Err(format!(
            "it has more than {MOST_TRIANGLES} triangles; a model for collisions has some hundreds"
        ));
    }
    for (t, triangle) in triangles.chunks_exact(TRIANGLE).enumerate() {
        // The first three numbers are the normal.
        let numbers: Vec<f64> = triangle[12..48]
            .chunks_exact(4)
            .map(|b| f64::from(f32::from_bits(little_endian(b))))
            .collect();
        if numbers.iter().any(|n| !n.is_finite()) {
            return Err(format!("a number of triangle {} is not finite", t + 1));
        }
        let corners: Vec<u32> = numbers
            .chunks_exact(3)
            .map(|p| add_point(&mut mesh, Vec3::new(p[0], p[1], p[2])))
            .collect();
        add_polygon(&mut mesh, &corners)?;
    }
    Ok(mesh)
}

fn ascii(text: &str) -> Result<Mesh, String> {
    let mut mesh = Mesh::default();
    let mut corners = Vec::new();
    let mut is_ended = false;
    for (line, row) in text.lines().enumerate() {
        let mut words = row.split_ascii_whitespace();
        match words.next().unwrap_or_default().to_ascii_lowercase().as_str() {
            "vertex" => {
                let xyz: Option<Vec<f64>> = words.map(number).collect();
                let Some([x, y, z]) = xyz.as_deref() else {
                    return Err(format!("line {} has no three finite numbers after `vertex`", line + 1));
                };
                corners.push(add_point(&mut mesh, Vec3::new(*x, *y, *z)));
            }
            "endloop" => {
                if corners.len() < 3 {
                    return Err(format!(
                        "the face that ends in line {} has fewer than three corners",
                        line + 1
                    ));
                }
                add_polygon(&mut mesh, &corners)?;
                corners.clear();
            }
            "endsolid" => is_ended = true,
            _ => {}
        }
    }
    if !corners.is_empty() || !is_ended {
        return Err("it ends before its `endsolid`".into());
    }
    Ok(mesh)
}

fn add_point(mesh: &mut Mesh, p: Vec3) -> u32 {
    mesh.points.push(p);
    u32::try_from(mesh.points.len() - 1).unwrap_or(u32::MAX)
}
