//! Mesh files: where a name leads, what a file holds, and the hulls that stand for it.
//!
//! STL, OBJ and COLLADA, told by the end of the name. Only positions and triangles are read: no colours, textures, normals or
//! animations. Hulls contain the mesh (`geom::hull`, `geom::mesh`); the triangles themselves are gone after that: they are ten times
//! slower to test. Parts of a mesh are kept in the cache that [`Files`] offers, by the content of the file.
//! Readers of our own: what we found in the registry puts out a binary STL that begins with `solid`, a geometry that a scene has
//! twice, or panics at an index (decision 26).

mod cache;
mod collada;
mod find;
mod obj;
mod stl;

use indexmap::IndexMap;
use std::sync::Arc;

use crate::geom::Vec3;
use crate::geom::hull::Hull;
use crate::geom::mesh::Mesh;
use crate::geom::shape::Shape;
use crate::source::Files;

/// No mesh has more triangles: a scan, not a model.
const MOST_TRIANGLES: usize = 2_000_000;
/// Nothing of a world is farther from its frame [m]; meshes beyond it are in millimetres.
const FARTHEST: f64 = 100.0;

/// Why there is no mesh.
#[derive(Debug, Clone, PartialEq)]
pub enum NoMesh {
    /// Nothing there can be read; each path that was tried, with the reason.
    NotFound { tried: Vec<(String, String)> },
    /// A file of another format.
    Format,
    /// Damaged, empty, too large; a sentence without its end.
    Unreadable { path: String, why: String },
}

/// How a mesh is wanted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wanted<'a> {
    /// As the file has it: relative, absolute, `file://` or `package://`.
    pub name: &'a str,
    /// Factors along the axes of the mesh; negative ones mirror.
    pub scale: [f64; 3],
    /// Several convex parts instead of one hull.
    pub in_parts: bool,
}

/// Meshes of one model or world file: each is read once.
pub struct Meshes<'a> {
    files: &'a dyn Files,
    /// Folders in which packages are looked for, first those that the file names.
    packages: Vec<String>,
    /// Whether parts are kept on disk.
    is_cached: bool,
    known: IndexMap<String, Result<Hulls, NoMesh>>,
}

/// Hulls, each with its origin in the mesh's frame.
type Hulls = Vec<(Arc<Hull>, Vec3)>;

impl<'a> Meshes<'a> {
    /// `packages` come before those of `files`.
    pub fn new(files: &'a dyn Files, mut packages: Vec<String>, is_cached: bool) -> Self {
        packages.extend(files.packages());
        Meshes {
            files,
            packages,
            is_cached,
            known: IndexMap::new(),
        }
    }

    /// Returns the paths to which a name in `file` may lead.
    pub fn paths(&self, file: &str, name: &str) -> Vec<String> {
        find::candidates(file, name, &self.packages)
    }

    /// Returns the shapes of a mesh that `file` names, each with its frame's origin in the frame of the mesh.
    pub fn shapes(&mut self, file: &str, wanted: &Wanted<'_>) -> Result<Vec<(Shape, Vec3)>, NoMesh> {
        let key = format!("{file}\n{}\n{:?}\n{}", wanted.name, wanted.scale, wanted.in_parts);
        if !self.known.contains_key(&key) {
            let found = self.read(file, wanted);
            self.known.insert(key.clone(), found);
        }
        let hulls = self.known.get(&key).cloned().unwrap_or(Ok(Vec::new()))?;
        Ok(hulls
            .into_iter()
            .map(|(hull, origin)| (Shape::Hull(hull), origin))
            .collect())
    }

    fn read(&self, file: &str, wanted: &Wanted<'_>) -> Result<Hulls, NoMesh> {
        let reader = reader(wanted.name).ok_or(NoMesh::Format)?;
        let mut tried = Vec::new();
        let candidates = find::candidates(file, wanted.name, &self.packages);
        let found = candidates
            .into_iter()
            .find_map(|path| match self.files.read_bytes(&path) {
                Ok(bytes) => Some((path, bytes)),
                Err(why) => {
                    tried.push((path, why));
                    None
                }
            });
        let (path, bytes) = found.ok_or(NoMesh::NotFound { tried })?;
        let unreadable = |why: String| NoMesh::Unreadable {
            path: path.clone(),
            why,
        };
        let key = cache::key(&bytes, &wanted.scale);
        let is_kept = wanted.in_parts && self.is_cached;
        if is_kept && let Some(hulls) = self.files.cached(&key).and_then(|kept| cache::read(&kept)) {
            return Ok(hulls);
        }
        let mut mesh = reader(&bytes).map_err(unreadable)?;
        if mesh.triangles.is_empty() {
            return Err(unreadable("it has no triangles".into()));
        }
        for p in &mut mesh.points {
            p.component_mul_assign(&Vec3::from(wanted.scale));
        }
        let far = mesh.points.iter().map(Vec3::amax).fold(0.0, f64::max);
        if far > FARTHEST {
            return Err(unreadable(format!(
                "it reaches {far:.0} m from its frame; meshes are in metres, others need a `scale` such as 0.001"
            )));
        }
        let hulls: Vec<(Hull, Vec3)> = if wanted.in_parts {
            mesh.parts()
        } else {
            mesh.hull().into_iter().collect()
        };
        if hulls.is_empty() {
            return Err(unreadable("all of its points are in one place".into()));
        }
        let hulls: Hulls = hulls
            .into_iter()
            .map(|(hull, origin)| (Arc::new(hull), origin))
            .collect();
        if !wanted.in_parts {
            return Ok(hulls);
        }
        // Kept or not, parts come out of their bytes: to the last bit they are the same with and without the cache.
        let kept = cache::write(&hulls);
        if is_kept {
            self.files.keep(&key, &kept);
        }
        Ok(cache::read(&kept).unwrap_or(hulls))
    }
}

type Reader = fn(&[u8]) -> Result<Mesh, String>;

/// Returns the reader of files with such a name.
fn reader(name: &str) -> Option<Reader> {
    let (_, end) = name.rsplit_once('.')?;
    match end.to_ascii_lowercase().as_str() {
        "stl" => Some(stl::read),
        "obj" => Some(obj::read),
        "dae" => Some(collada::read),
        _ => None,
    }
}

/// Adds a polygon's triangles, all about its first corner; complains about one triangle too many.
fn add_polygon(mesh: &mut Mesh, corners: &[u32]) -> Result<(), String> {
    let rest = corners.get(1..).unwrap_or_default();
    mesh.triangles.extend(rest.windows(2).map(|w| [corners[0], w[0], w[1]]));
    if mesh.triangles.len() > MOST_TRIANGLES {
        return Err(format!(
            "it has more than {MOST_TRIANGLES} triangles; a model for collisions has some hundreds"
        ));
    }
    Ok(())
}

/// Returns the finite number that a word is.
fn number(word: &str) -> Option<f64> {
    word.parse::<f64>().ok().filter(|n| n.is_finite())
}
