//! Wavefront OBJ: vertices and faces; everything else is skipped.

use super::{add_polygon, number};
use crate::geom::Vec3;
use crate::geom::mesh::Mesh;

/// Reads an OBJ file, or says what is wrong with it.
pub fn read(bytes: &[u8]) -> Result<Mesh, String> {
    let text =
        std::str::from_utf8(bytes).map_err(|e| format!("it is not text: byte {} is not UTF-8", e.valid_up_to()))?;
    let mut mesh = Mesh::default();
    let mut faces: Vec<(usize, Vec<u32>)> = Vec::new();
    let mut rows = text.lines().enumerate();
    while let Some((line, row)) = rows.next() {
        let mut row = row.to_string();
        // A backslash goes on in the next line.
        while let Some(begun) = row.strip_suffix('\\') {
            let next = rows.next().map_or("", |(_, next)| next);
            row = format!("{begun} {next}");
        }
        let mut words = row.split_ascii_whitespace();
        match words.next() {
            Some("v") => {
                // A weight or a colour may follow.
                let xyz: Vec<Option<f64>> = words.take(3).map(number).collect();
                let [Some(x), Some(y), Some(z)] = xyz[..] else {
                    return Err(format!("line {} has no three finite numbers after `v`", line + 1));
                };
                mesh.points.push(Vec3::new(x, y, z));
            }
            Some("f") => {
                let corners: Option<Vec<u32>> = words.map(|word| index(word, mesh.points.len())).collect();
                match corners {
                    Some(corners) if corners.len() >= 3 => faces.push((line, corners)),
                    _ => return Err(format!("line {} is no face of three vertices or more", line + 1)),
                }
            }
            _ => {}
        }
    }
    for (line, corners) in faces {
        if corners.iter().any(|c| *c as usize >= mesh.points.len()) {
            return Err(format!("line {} names a vertex that the file lacks", line + 1));
        }
        add_polygon(&mut mesh, &corners)?;
    }
    Ok(mesh)
}

/// Returns the index, from 0, of the vertex that `7/1/3` names: counted from 1, or backwards from the last one so far.
fn index(word: &str, so_far: usize) -> Option<u32> {
    let n: i64 = word.split('/').next()?.parse().ok()?;
    let index = if n < 0 { i64::try_from(so_far).ok()? + n } else { n - 1 };
    u32::try_from(index).ok()
}
