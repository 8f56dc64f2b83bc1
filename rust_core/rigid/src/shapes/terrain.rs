//! Height fields: ground below heights over a uniform grid, whose cells are cut into prisms that reach far enough down.
//!
//! In 3D the two triangles of a cell meet along its higher diagonal, so that a cell has the same surface in its mirror image.

use glam::DVec3;
use physcore_base::error::{Error, Result};
use physcore_base::scene::{Item, Value};

use super::skin::{Corner, Skin};
use super::{BoundingBox, Part, Planar};

/// Features of a prism: of the quadrilateral below a segment, and of that below a triangle.
const FEATURES: [u32; 2] = [8, 20];

/// Node of the grid.
type ProfileNode = [usize; 2];

/// Heights of the nodes of a uniform grid, along y in 2D and along z in 3D.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct GroundProfile {
    /// Heights [m] of nodes (i, j), with j varying fastest.
    heights: Vec<f64>,
    /// Number of nodes along each horizontal axis; in 2D one along y.
    nodes: ProfileNode,
    spacing: f64,
    dimension: usize,
    lowest: f64,
    highest: f64,
}

impl GroundProfile {
    /// Ground of an item's `heights` [m] at the nodes of a grid with its `spacing` [m], and its `origin`.
    pub fn declared(item: &Item, dimension: usize) -> Result<(Self, DVec3)> {
        let axes = dimension - 1;
        let array = match item.values.get("heights") {
            Some(Value::Numbers(array)) if array.shape.len() == axes && array.shape.iter().all(|&count| count >= 2) => array,
            other => return Err(item.wrong("heights", &format!("an array with {axes} axes of at least 2 nodes"), other)),
        };
        let spacing = super::declared::positive(item, "spacing")?;
        if let Some(height) = array.entries.iter().find(|height| !height.is_finite()) {
            return Err(Error::parameter(item.path_of("heights"), "finite heights", height));
        }
        let extreme = |pick: fn(f64, f64) -> f64| array.entries.iter().copied().reduce(pick).unwrap_or(0.0);
        let terrain = Self {
            nodes: [array.shape[0], if axes == 2 { array.shape[1] } else { 1 }],
            heights: array.entries.clone(),
            spacing,
            dimension,
            lowest: extreme(f64::min),
            highest: extreme(f64::max),
        };
        let origin = item.vector("origin")?;
        Ok((terrain, if dimension == 2 { DVec3::X * origin.x } else { origin.with_z(0.0) }))
    }

    /// Number of features of all prisms.
    pub fn features(&self) -> u32 {
        let cells = self.nodes.map(|count| (count - 1).max(1) as u32);
        cells[0].wrapping_mul(cells[1]).wrapping_mul(FEATURES[self.dimension - 2] * (self.dimension as u32 - 1))
    }

    /// Box around the ground, which has no lower end.
    pub fn bounds(&self) -> BoundingBox {
        let end = self.nodes.map(|count| (count - 1) as f64 * self.spacing);
        match self.dimension {
            2 => BoundingBox { lower: DVec3::ZERO.with_y(f64::NEG_INFINITY), upper: DVec3::new(end[0], self.highest, 0.0) },
            _ => BoundingBox { lower: DVec3::new(0.0, 0.0, f64::NEG_INFINITY), upper: DVec3::new(end[0], end[1], self.highest) },
        }
    }

    /// Calls `visit` with the prisms below the surface that reach into a box.
    pub fn near(&self, bounds: &BoundingBox, visit: &mut dyn FnMut(&Part)) {
        let up = self.dimension - 1;
        let finite = |value: f64, other: f64| if value.is_finite() { value } else { other };
        let size = finite((bounds.upper - bounds.lower).max_element(), self.spacing).max(self.spacing);
        let bottom = self.lowest.min(finite(bounds.lower[up], self.lowest)) - size;
        let [is, js] = [0, 1].map(|axis| self.cells(axis, bounds));
        let (Some([i0, i1]), Some([j0, j1])) = (is, js) else { return };
        for i in i0..=i1 {
            for j in j0..=j1 {
                let corners = self.corners([i, j]);
                if corners.into_iter().all(|node| self.height(node) < bounds.lower[up]) {
                    continue;
                }
                let cell = (i * (self.nodes[1] - 1).max(1) + j) as u32;
                if self.dimension == 2 {
                    visit(&Part { first: cell.wrapping_mul(FEATURES[0]), ..self.quadrilateral(i, bottom) });
                    continue;
                }
                for (place, triangle) in (0..).zip(self.triangles([i, j])) {
                    let first = cell.wrapping_mul(2).wrapping_add(place).wrapping_mul(FEATURES[1]);
                    visit(&Part { first, ..self.prism(triangle, bottom) });
                }
            }
        }
    }

    /// First and last cell along an axis that a box overlaps.
    fn cells(&self, axis: usize, bounds: &BoundingBox) -> Option<[usize; 2]> {
        if self.nodes[axis] == 1 {
            return Some([0, 0]);
        }
        let last = (self.nodes[axis] - 2) as f64;
        let [first, end] = [bounds.lower, bounds.upper].map(|corner| (corner[axis] / self.spacing).floor());
        (first <= last + 1.0 && end >= -1.0).then(|| [first, end].map(|cell| cell.clamp(0.0, last) as usize))
    }

    fn height(&self, [i, j]: ProfileNode) -> f64 {
        self.heights[i * self.nodes[1] + j]
    }

    /// Position of a node [m].
    fn node(&self, node: ProfileNode) -> DVec3 {
        let [x, y] = node.map(|index| index as f64 * self.spacing);
        if self.dimension == 2 { DVec3::new(x, self.height(node), 0.0) } else { DVec3::new(x, y, self.height(node)) }
    }

    /// Nodes of a cell: its first, the next along x, along y, and along both.
    fn corners(&self, [i, j]: ProfileNode) -> [ProfileNode; 4] {
        let next = usize::from(self.nodes[1] > 1);
        [[i, j], [i + 1, j], [i, j + next], [i + 1, j + next]]
    }

    /// Ground below the segment from node i to the next.
    fn quadrilateral(&self, i: usize, bottom: f64) -> Part {
        let [left, right] = [[i, 0], [i + 1, 0]].map(|node| self.node(node));
        let mut part = Part::polygon(vec![left.with_y(bottom), right.with_y(bottom), right, left], 0.0);
        let last = self.nodes[0] - 1;
        let corner = |index: usize| {
            let here = self.node([index, 0]);
            let to = |is_border: bool, other: usize| {
                if is_border { DVec3::NEG_Y } else { (self.node([other, 0]) - here).normalize() }
            };
            let ways = [to(index == last, index + 1), to(index == 0, index.wrapping_sub(1))];
            Some(Corner { outward: ways[1].outward() - ways[0].outward(), ways: ways.to_vec() })
        };
        let faces = vec![false, i + 1 == last, true, i == 0];
        part.skin = Some(Box::new(Skin { faces, edges: Vec::new(), vertices: vec![None, None, corner(i + 1), corner(i)] }));
        part
    }

    /// Triangles of a cell, counterclockwise as seen from above.
    fn triangles(&self, cell: ProfileNode) -> [[ProfileNode; 3]; 2] {
        let [a, b, c, d] = self.corners(cell);
        if self.is_rising(cell) { [[a, b, d], [a, d, c]] } else { [[a, b, c], [b, d, c]] }
    }

    /// Whether the diagonal of a cell is that from its first node.
    fn is_rising(&self, cell: ProfileNode) -> bool {
        let [a, b, c, d] = self.corners(cell).map(|node| self.height(node));
        a + d >= b + c
    }

    /// Upward unit normal of a triangle.
    fn normal(&self, triangle: [ProfileNode; 3]) -> DVec3 {
        let [a, b, c] = triangle.map(|node| self.node(node));
        (b - a).cross(c - a).normalize()
    }

    /// Cells around an edge or, from a node to itself, around that node.
    fn cells_at(&self, [from, to]: [ProfileNode; 2]) -> impl Iterator<Item = ProfileNode> + '_ {
        let range = move |axis: usize| {
            let [low, high] = [from[axis].min(to[axis]), from[axis].max(to[axis])];
            high.saturating_sub(1)..=low.min(self.nodes[axis] - 2)
        };
        range(0).flat_map(move |i| range(1).map(move |j| [i, j]))
    }

    /// Normal of the surface on the left of a way between two neighbors; at the border, that of the upright side.
    fn beside(&self, from: ProfileNode, to: ProfileNode) -> DVec3 {
        let has = |triangle: &[ProfileNode; 3]| (0..3).any(|side| triangle[side] == from && triangle[(side + 1) % 3] == to);
        let found = self.cells_at([from, to]).find_map(|cell| self.triangles(cell).into_iter().find(has));
        found.map_or_else(|| self.side(from, to), |triangle| self.normal(triangle))
    }

    /// Outward normal of the upright side below an edge of the border, which runs clockwise around the grid.
    fn side(&self, from: ProfileNode, to: ProfileNode) -> DVec3 {
        let way = self.node(to) - self.node(from);
        DVec3::new(-way.y, way.x, 0.0).normalize()
    }

    /// Outward normals of the upright sides at a node, one for each axis.
    fn sides(&self, node: ProfileNode) -> [Option<DVec3>; 2] {
        [0, 1].map(|axis| {
            let outward = DVec3::AXES[axis];
            if node[axis] == 0 { Some(-outward) } else { (node[axis] + 1 == self.nodes[axis]).then_some(outward) }
        })
    }

    /// Surface around a node.
    fn corner(&self, node: ProfileNode) -> Corner {
        let mut corner = Corner::new();
        let way = |other: ProfileNode| (self.node(other) - self.node(node)).normalize();
        for cell in self.cells_at([node, node]) {
            for triangle in self.triangles(cell) {
                if let Some(place) = triangle.iter().position(|one| *one == node) {
                    let others = [1, 2].map(|step| triangle[(place + step) % 3]);
                    corner.add(others.map(way), self.normal(triangle));
                }
            }
        }
        let sides = self.sides(node);
        for axis in 0..2 {
            let Some(normal) = sides[axis] else { continue };
            // The side runs along the other axis.
            let along = 1 - axis;
            let mut beside = [node, node];
            beside[0][along] = node[along].wrapping_sub(1);
            beside[1][along] += 1;
            for other in beside.into_iter().filter(|other| other[along] < self.nodes[along]) {
                corner.add([way(other), DVec3::NEG_Z], normal);
            }
        }
        corner
    }

    /// Ground below a triangle of nodes.
    fn prism(&self, triangle: [ProfileNode; 3], bottom: f64) -> Part {
        let top = triangle.map(|node| self.node(node));
        let vertices = top.into_iter().chain(top.map(|corner| corner.with_z(bottom))).collect();
        let sides = [0, 1, 2].map(|side| [triangle[side], triangle[(side + 1) % 3]]);
        let mut part = Part::prism(vertices);
        let front = self.normal(triangle);
        let across = sides.map(|[from, to]| self.beside(to, from));
        let edges = part.net.edges.iter().map(|edge| {
            let [from, to] = edge.ends.map(|end| end as usize);
            if from < 3 && to < 3 {
                return Some([front, across[from]]);
            }
            // An upright edge at the border; its ends are in the order of their numbers, downward.
            let [one, other] = if from + 3 == to { self.sides(triangle[from]) } else { [None, None] };
            let [one, other] = [one.or(other)?, other.or(one)?];
            Some(if one.across(other) > 0.0 { [other, one] } else { [one, other] })
        });
        let skin = Skin {
            edges: edges.collect(),
            faces: [true, false].into_iter().chain(across.map(|normal| normal.z == 0.0)).collect(),
            vertices: triangle.map(|node| Some(self.corner(node))).into_iter().chain([None, None, None]).collect(),
        };
        part.skin = Some(Box::new(skin));
        part
    }
}
