//! Convex parts: all points within a radius of a convex core.

use glam::DVec3;

use super::BoundingBox;
use super::plane::Planar;
use super::skin::Skin;
use crate::pose::Pose;

/// Convex core with a rounding radius, in the frame of a body. A core of one vertex is a disc or a ball, of two a capsule.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Part {
    /// Vertices of the core [m]; of a polygon counterclockwise.
    pub vertices: Vec<DVec3>,
    /// Outward unit normals of the faces of the core. Face i of a polygon is the edge from vertex i to the next.
    pub normals: Vec<DVec3>,
    /// Distances of the planes of the faces from the origin along their normals [m].
    pub offsets: Vec<f64>,
    /// Loops and edges of a polyhedron; empty in 2D.
    pub net: Net,
    /// Rounding radius [m].
    pub radius: f64,
    /// Mean of the vertices [m], and the radius of a ball around it that contains the part [m].
    pub ball: (DVec3, f64),
    /// Radius of a ball around this mean that the core contains [m].
    pub inner: f64,
    /// Half edges of a cuboid [m]. Bit i of the index of a vertex tells on which side along edge i it is.
    pub half: Option<[DVec3; 3]>,
    /// Surface that the part belongs to; None if all of its own surface is one.
    pub skin: Option<Box<Skin>>,
    /// Number of the first feature of the part among those of its shape: vertices, then edges, then faces.
    pub first: u32,
}

/// Faces and edges of a polyhedron.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Net {
    /// Vertices of all faces, counterclockwise as seen from outside.
    pub corners: Vec<u32>,
    /// Start of each face in `corners`, and the end of the last.
    pub starts: Vec<u32>,
    /// Edges between two faces.
    pub edges: Vec<PartEdge>,
}

/// Edge of a polyhedron.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PartEdge {
    /// Vertices at its ends, in the order of the first of the faces.
    pub ends: [u32; 2],
    /// Faces on its left and on its right, as seen from outside.
    pub faces: [u32; 2],
}

impl Net {
    /// Net of faces given by their vertices. None unless every edge has two faces, in opposite directions.
    pub fn new(faces: &[Vec<u32>]) -> Option<Self> {
        let mut net = Self { starts: vec![0], ..Self::default() };
        let mut halves: Vec<([u32; 2], bool, [u32; 2], u32)> = Vec::new();
        for (face, corners) in (0..).zip(faces) {
            net.corners.extend(corners);
            net.starts.push(net.corners.len() as u32);
            for (place, &from) in corners.iter().enumerate() {
                let to = corners[(place + 1) % corners.len()];
                halves.push(([from.min(to), from.max(to)], from > to, [from, to], face));
            }
        }
        halves.sort_unstable();
        for pair in halves.chunks(2) {
            let &[(key, false, ends, left), (other, true, _, right)] = pair else { return None };
            if key != other {
                return None;
            }
            net.edges.push(PartEdge { ends, faces: [left, right] });
        }
        Some(net)
    }

    /// Vertices of a face.
    #[inline]
    pub fn face(&self, face: usize) -> &[u32] {
        &self.corners[self.starts[face] as usize..self.starts[face + 1] as usize]
    }
}

impl Part {
    /// Disc or ball.
    pub fn round(center: DVec3, radius: f64) -> Self {
        Self::new(vec![center], Vec::new(), Net::default(), radius)
    }

    /// Rectangle with these half edges.
    pub fn rectangle(half: DVec3) -> Self {
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, y]| half * DVec3::new(x, y, 0.0));
        Self::polygon(corners.to_vec(), 0.0)
    }

    /// Capsule about a segment; about a point, a disc or a ball.
    pub fn bar(ends: [DVec3; 2], radius: f64, dimension: usize) -> Self {
        if ends[0] == ends[1] { Self::round(ends[0], radius) } else { Self::capsule(ends, radius, dimension) }
    }

    /// Capsule about the segment between two points. In 2D both its sides are faces.
    pub fn capsule(ends: [DVec3; 2], radius: f64, dimension: usize) -> Self {
        if dimension == 2 {
            return Self::polygon(ends.to_vec(), radius);
        }
        let net = Net { edges: vec![PartEdge { ends: [0, 1], faces: [0, 0] }], ..Net::default() };
        Self::new(ends.to_vec(), Vec::new(), net, radius)
    }

    /// Convex polygon of vertices in counterclockwise order, rounded.
    pub fn polygon(vertices: Vec<DVec3>, radius: f64) -> Self {
        let edge = |index: usize| vertices[(index + 1) % vertices.len()] - vertices[index];
        let normals = (0..vertices.len()).map(|index| edge(index).outward().normalize()).collect();
        Self::new(vertices, normals, Net::default(), radius)
    }

    /// Convex polyhedron with flat faces, given by their vertices counterclockwise as seen from outside. None if it is not closed.
    pub fn polyhedron(vertices: Vec<DVec3>, faces: &[Vec<u32>]) -> Option<Self> {
        let net = Net::new(faces)?;
        let normals = faces.iter().map(|corners| normal(&vertices, corners)).collect::<Option<_>>()?;
        Some(Self::new(vertices, normals, net, 0.0))
    }

    /// Convex polyhedron of those points that are corners of its faces.
    pub fn compact(points: &[DVec3], faces: &[Vec<u32>]) -> Option<Self> {
        let mut corners: Vec<u32> = faces.iter().flatten().copied().collect();
        corners.sort_unstable();
        corners.dedup();
        let place = |corner: &u32| corners.binary_search(corner).map_or(0, |place| place as u32);
        let faces: Vec<Vec<u32>> = faces.iter().map(|face| face.iter().map(place).collect()).collect();
        Self::polyhedron(corners.iter().map(|&corner| points[corner as usize]).collect(), &faces)
    }

    /// Triangle with two sides, of which the first has this normal.
    pub fn leaf(vertices: Vec<DVec3>, normal: DVec3) -> Self {
        let edge = |ends: [u32; 2], faces: [u32; 2]| PartEdge { ends, faces };
        let net = Net {
            corners: vec![0, 1, 2, 0, 2, 1],
            starts: vec![0, 3, 6],
            edges: vec![edge([0, 1], [0, 1]), edge([1, 2], [0, 1]), edge([2, 0], [0, 1])],
        };
        Self::new(vertices, vec![normal, -normal], net, 0.0)
    }

    /// Part with a rounding radius [m].
    #[must_use]
    pub fn rounded(mut self, radius: f64) -> Self {
        self.radius = radius;
        self.surround();
        self
    }

    /// Corners of a triangle with two sides; None for other parts.
    pub fn leaf_corners(&self) -> Option<[DVec3; 3]> {
        if self.net.starts.len() == 3 { self.vertices[..].try_into().ok() } else { None }
    }

    /// Upright prism of the vertices of a triangle and of those below them. Its faces are the triangle, the bottom, and the sides
    /// from each vertex to the next.
    pub fn prism(vertices: Vec<DVec3>) -> Self {
        let at = |corner: usize| vertices[corner];
        let top = (at(1) - at(0)).cross(at(2) - at(0)).normalize();
        let side = |from: usize| {
            let way = at((from + 1) % 3) - at(from);
            DVec3::new(way.y, -way.x, 0.0).normalize()
        };
        let normals = vec![top, DVec3::NEG_Z, side(0), side(1), side(2)];
        let edge = |from: u32| {
            let (next, before) = ((from + 1) % 3, (from + 2) % 3);
            [
                PartEdge { ends: [from, next], faces: [0, 2 + from] },
                PartEdge { ends: [from, from + 3], faces: [2 + from, 2 + before] },
                PartEdge { ends: [from + 3, next + 3], faces: [2 + from, 1] },
            ]
        };
        let net = Net {
            corners: vec![0, 1, 2, 3, 5, 4, 1, 0, 3, 4, 2, 1, 4, 5, 0, 2, 5, 3],
            starts: vec![0, 3, 6, 10, 14, 18],
            edges: [0, 1, 2].into_iter().flat_map(edge).collect(),
        };
        Self::new(vertices, normals, net, 0.0)
    }

    /// Box with these half edges.
    pub fn cuboid(half: DVec3) -> Self {
        let corner =
            |bits: u32| DVec3::from_array([0, 1, 2].map(|axis| if bits >> axis & 1 == 0 { -half[axis] } else { half[axis] }));
        let vertices = (0..8).map(corner).collect();
        let faces = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        let mut part = Self::polyhedron(vertices, &faces.map(|corners| corners.to_vec())).expect("a cuboid is closed");
        part.normals = [DVec3::NEG_X, DVec3::X, DVec3::NEG_Y, DVec3::Y, DVec3::NEG_Z, DVec3::Z].to_vec();
        part.half = Some([0, 1, 2].map(|axis| half[axis] * DVec3::AXES[axis]));
        part
    }

    fn new(vertices: Vec<DVec3>, normals: Vec<DVec3>, net: Net, radius: f64) -> Self {
        let mut part = Self {
            vertices,
            normals,
            offsets: Vec::new(),
            net,
            radius,
            ball: (DVec3::ZERO, 0.0),
            inner: 0.0,
            half: None,
            skin: None,
            first: 0,
        };
        part.surround();
        part
    }

    /// Finds the planes of the faces, and the balls around the part and within it.
    fn surround(&mut self) {
        let center = self.vertices.iter().sum::<DVec3>() / self.vertices.len() as f64;
        let reach = self.vertices.iter().map(|vertex| vertex.distance(center)).fold(0.0, f64::max);
        self.ball = (center, reach + self.radius);
        self.offsets = (0..self.normals.len()).map(|face| self.normals[face].dot(self.corner(face))).collect();
        let depths = self.normals.iter().zip(&self.offsets).map(|(normal, offset)| offset - normal.dot(center));
        self.inner = depths.reduce(f64::min).unwrap_or(0.0).max(0.0);
    }

    /// Turns the part and moves it.
    #[must_use]
    pub fn moved(mut self, pose: &Pose) -> Self {
        self.vertices.iter_mut().for_each(|vertex| *vertex = pose.point(*vertex));
        self.normals.iter_mut().for_each(|normal| *normal = pose.rotation * *normal);
        self.half = self.half.map(|half| half.map(|edge| pose.rotation * edge));
        if let Some(skin) = &mut self.skin {
            skin.turn(&pose.rotation);
        }
        self.surround();
        self
    }

    /// Triangles of the faces of a polyhedron.
    pub fn triangles(&self) -> impl Iterator<Item = [DVec3; 3]> + Clone {
        let faces = (0..self.normals.len()).map(|face| self.net.face(face));
        let fans = faces.flat_map(|corners| corners.windows(2).skip(1).map(|side| [corners[0], side[0], side[1]]));
        fans.map(|corners| corners.map(|corner| self.vertices[corner as usize]))
    }

    /// Box along the axes around the part at a pose.
    pub fn bounds(&self, pose: &Pose) -> BoundingBox {
        let corners = self.vertices.iter().map(|vertex| pose.point(*vertex));
        corners
            .map(|corner| BoundingBox { lower: corner, upper: corner })
            .fold(BoundingBox::NOWHERE, BoundingBox::union)
            .grown(self.radius)
    }

    /// Number of features.
    pub fn features(&self) -> u32 {
        (self.vertices.len() + self.net.edges.len() + self.normals.len()) as u32
    }

    /// Number of an edge among the features.
    pub fn edge_feature(&self, edge: usize) -> u32 {
        (self.vertices.len() + edge) as u32
    }

    /// Number of a face among the features.
    pub fn face_feature(&self, face: usize) -> u32 {
        (self.vertices.len() + self.net.edges.len() + face) as u32
    }

    /// Vertex of a face.
    #[inline]
    pub fn corner(&self, face: usize) -> DVec3 {
        if self.net.starts.is_empty() { self.vertices[face] } else { self.vertices[self.net.face(face)[0] as usize] }
    }

    /// Ends of an edge [m]; of a core without edges, twice its vertex.
    #[inline]
    pub fn edge(&self, edge: usize) -> [DVec3; 2] {
        self.net.edges.get(edge).map_or([self.vertices[0]; 2], |edge| edge.ends.map(|end| self.vertices[end as usize]))
    }

    /// Vertex farthest along a direction, the first of equals, and its product with the direction.
    #[inline]
    pub fn support(&self, direction: DVec3) -> (usize, f64) {
        if let Some(half) = self.half {
            let vertex = side_of(half.map(|edge| edge.dot(direction)));
            return (vertex, self.vertices[vertex].dot(direction));
        }
        let mut farthest = (0, self.vertices[0].dot(direction));
        for (index, vertex) in self.vertices.iter().enumerate().skip(1) {
            let along = vertex.dot(direction);
            if along > farthest.1 {
                farthest = (index, along);
            }
        }
        farthest
    }
}

/// Vertex of a cuboid on the side where its half edges rise along a direction.
#[inline]
pub(crate) fn side_of(rises: [f64; 3]) -> usize {
    (0..3).map(|axis| usize::from(rises[axis] > 0.0) << axis).sum()
}

/// Unit normal of a plane polygon by its area; None if it has none.
fn normal(vertices: &[DVec3], corners: &[u32]) -> Option<DVec3> {
    let at = |place: usize| vertices[corners[place % corners.len()] as usize] - vertices[corners[0] as usize];
    (1..corners.len()).map(|place| at(place).cross(at(place + 1))).sum::<DVec3>().try_normalize()
}
