//! Closed surfaces of triangles: convex ones are polyhedra, others are made of their triangles.

use glam::DVec3;
use physcore_base::error::{Error, Result};
use physcore_base::scene::Item;

use super::declared::finite_rows;
use super::part::Net;
use super::skin::{Corner, Skin};
use super::{MassProperties, Part, hull};

/// Difference of the volumes of a surface and of its hull, relative to these, at which it counts as convex.
const CONVEX: f64 = 1e-9;

/// Parts and mass properties of the closed surface of the item's `vertices` and `faces`.
pub(super) fn parts(item: &Item) -> Result<(Vec<Part>, MassProperties)> {
    let vertices = finite_rows(item, "vertices", 3)?;
    let mut faces = item.tuples::<3>("faces")?.to_vec();
    let wrong = |expected: &str, found: String| Err(Error::parameter(item.path_of("faces"), expected, found));
    if let Some(&index) = faces.iter().flatten().find(|&&index| index as usize >= vertices.len()) {
        return wrong(&format!("indices of {} vertices", vertices.len()), index.to_string());
    }
    let corners = |faces: &[[u32; 3]]| faces.iter().map(|face| face.to_vec()).collect::<Vec<_>>();
    if Net::new(&corners(&faces)).is_none() {
        let (edge, count) = open_edge(&faces);
        let closed = "a closed surface, with two faces at each edge that run along it in opposite directions";
        return wrong(closed, format!("{count} faces along the edge from vertex {} to {}", edge[0], edge[1]));
    }
    let properties = |faces: &[[u32; 3]]| {
        let triangles: Vec<_> = faces.iter().map(|face| face.map(|corner| vertices[corner as usize])).collect();
        MassProperties::polyhedron(&triangles.into_iter())
    };
    let mut mass = properties(&faces);
    if mass.size < 0.0 {
        faces.iter_mut().for_each(|[_, b, c]| std::mem::swap(b, c));
        mass = properties(&faces);
    }
    if let Some(part) = hull::polyhedron(&vertices) {
        let whole = MassProperties::polyhedron(&part.triangles());
        if (whole.size - mass.size).abs() <= CONVEX * whole.size {
            return Ok((vec![part], mass));
        }
    }
    let surface = MeshSurface::new(vertices, faces);
    match surface {
        Some(surface) => Ok(((0..surface.faces.len()).map(|face| surface.part(face)).collect(), mass)),
        None => wrong("triangles that are not flat", "one without an area".to_owned()),
    }
}

/// Edge that a surface lacks a neighbor at, and the number of faces along it in this direction and the other.
fn open_edge(faces: &[[u32; 3]]) -> ([u32; 2], usize) {
    let halves = || faces.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
    let count = |[from, to]: [u32; 2]| {
        let along = halves().filter(|&half| half == [from, to]).count();
        (along, halves().filter(|&half| half == [to, from]).count())
    };
    let edge = halves().find(|&half| count(half) != (1, 1)).unwrap_or([0, 0]);
    let (along, back) = count(edge);
    (edge, along + back)
}

/// Closed surface of triangles.
struct MeshSurface {
    vertices: Vec<DVec3>,
    faces: Vec<[u32; 3]>,
    normals: Vec<DVec3>,
    /// Face beyond each side of each face; the sides begin at its vertices.
    beyond: Vec<[u32; 3]>,
    corners: Vec<Corner>,
}

impl MeshSurface {
    /// None if a face has no normal.
    fn new(vertices: Vec<DVec3>, faces: Vec<[u32; 3]>) -> Option<Self> {
        let normal = |face: &[u32; 3]| {
            let [a, b, c] = face.map(|corner| vertices[corner as usize]);
            (b - a).cross(c - a).try_normalize()
        };
        let normals: Vec<DVec3> = faces.iter().map(normal).collect::<Option<_>>()?;
        let mut halves: Vec<([u32; 2], u32)> =
            (0..).zip(&faces).flat_map(|(face, &[a, b, c])| [[a, b], [b, c], [c, a]].map(|half| (half, face))).collect();
        halves.sort_unstable();
        let face_of =
            |from: u32, to: u32| halves.binary_search_by_key(&[from, to], |half| half.0).map_or(0, |place| halves[place].1);
        let beyond = faces.iter().map(|&[a, b, c]| [face_of(b, a), face_of(c, b), face_of(a, c)]).collect();
        let mut corners: Vec<Corner> = vertices.iter().map(|_| Corner::new()).collect();
        for (&face, &normal) in faces.iter().zip(&normals) {
            for place in 0..3 {
                let [here, next, last] = [0, 1, 2].map(|step| vertices[face[(place + step) % 3] as usize]);
                let ways = [(next - here).try_normalize()?, (last - here).try_normalize()?];
                corners[face[place] as usize].add(ways, normal);
            }
        }
        Some(Self { vertices, faces, normals, beyond, corners })
    }

    /// Triangle with two sides, of which the outer one is on the surface.
    fn part(&self, face: usize) -> Part {
        let corners = self.faces[face];
        let vertices = corners.map(|corner| self.vertices[corner as usize]).to_vec();
        let front = self.normals[face];
        let mut part = Part::leaf(vertices, front);
        let edges = self.beyond[face].map(|other| Some([front, self.normals[other as usize]]));
        let skin = Skin {
            edges: edges.to_vec(),
            faces: vec![true, false],
            vertices: corners.map(|corner| Some(self.corners[corner as usize].clone())).to_vec(),
        };
        part.skin = Some(Box::new(skin));
        part
    }
}
