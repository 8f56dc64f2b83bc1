//! Height field: the ground below heights over a uniform grid, which is not convex.
//!
//! The ground is the set of all points below its surface. Upright sides at the borders of the grid have no lower end. The four
//! nodes of a cell span two triangles that meet along the higher diagonal. These are the upper side of the nodes' convex hull, so
//! that a cell has the same surface in its mirror image.
//!
//! The surface consists of [`TerrainPart`]s: *faces* (triangles, in 2D segments, and strips of the sides), and *rims* (edges
//! and nodes). Each part has a region, in which it is the nearest part locally. The region of a rim is the cone of the normals
//! between its faces. It is empty along a valley or on flat ground. A ball that rolls from one cell to the next therefore feels
//! no edge between them, as it would between neighboring solids.

use std::ops::RangeInclusive;

use glam::DVec3;

use super::polytope::Feature;

mod contact;
mod shapes;

/// Rounding errors of a distance from a part or from the border of its region, in units of the operands' rounding.
const ROUNDINGS: f64 = 16.0;
/// Smallest radius of a particle that touches edges and nodes, in units of the rounding error; a smaller particle is a point.
const ROUND: f64 = 64.0;

/// Heights of the nodes of a uniform grid, along y in 2D and along z in 3D.
#[derive(Debug, Clone, PartialEq)]
pub struct Terrain {
    /// Heights [m] of nodes (i, j), with j varying fastest.
    heights: Vec<f64>,
    /// Number of nodes along each horizontal axis; in 2D one along y.
    nodes: [usize; 2],
    /// Distance h between nodes [m].
    spacing: f64,
    /// Lower corner of the grid [m].
    corner: DVec3,
    /// Vertical direction: y in 2D, z in 3D.
    up: DVec3,
    /// Largest height [m].
    highest: f64,
    /// Largest coordinate [m].
    extent: f64,
}

/// Part of the surface, identified by its kind and the first of its nodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TerrainPart {
    kind: PartKind,
    node: [u32; 2],
}

/// Kind of a part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum PartKind {
    /// Triangle of a cell with its lower edge along x; in 2D the segment.
    Low,
    /// Other triangle of a cell.
    High,
    /// Side below the border at the first or the last x.
    SideX,
    /// Side below the border at the first or the last y.
    SideY,
    Node,
    /// Edge to the next node along x.
    AlongX,
    /// Edge to the next node along y.
    AlongY,
    /// Edge between the triangles of a cell.
    Diagonal,
    /// Upright edge below a corner of the grid.
    Corner,
}

const FACES: [PartKind; 4] = [PartKind::Low, PartKind::High, PartKind::SideX, PartKind::SideY];
const RIMS: [PartKind; 5] = [PartKind::Node, PartKind::AlongX, PartKind::AlongY, PartKind::Diagonal, PartKind::Corner];

/// Part of the surface as seen from a point.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Spot {
    /// Signed distance [m].
    pub distance: f64,
    /// Outward unit normal.
    pub normal: DVec3,
    /// Distance of the point beyond the region of the part [m]; at most 0 within the region.
    pub beyond: f64,
    /// Feature of the part: a facet, an edge or a vertex.
    pub feature: Feature,
}

impl Terrain {
    /// Ground below `heights` [m] of nodes (i, j), with j varying fastest; one row in 2D. `corner` is the lower corner of the
    /// grid.
    #[inline]
    pub fn new(heights: Vec<f64>, nodes: [usize; 2], spacing: f64, corner: DVec3, dimension: usize) -> Self {
        let up = DVec3::AXES[dimension - 1];
        let highest = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let mut terrain = Self { heights, nodes, spacing, corner: corner.reject_from(up), up, highest, extent: 0.0 };
        let ends = [terrain.corner, terrain.node([nodes[0] - 1, nodes[1] - 1]).reject_from(up)];
        let widest = ends.map(|end| end.abs().max_element()).into_iter().fold(0.0, f64::max);
        terrain.extent = terrain.heights.iter().map(|height| height.abs()).fold(widest, f64::max);
        terrain
    }

    /// Largest coordinate [m].
    #[inline]
    pub fn extent(&self) -> f64 {
        self.extent
    }

    /// Vertical axis and largest height [m], above which nothing touches the ground.
    #[inline]
    pub fn top(&self) -> (DVec3, f64) {
        (self.up, self.highest)
    }

    /// Memory [bytes].
    #[inline]
    pub fn bytes(&self) -> usize {
        std::mem::size_of_val(self.heights.as_slice())
    }

    /// Rounding error of a distance at `x` [m].
    pub(super) fn rounding(&self, x: DVec3) -> f64 {
        ROUNDINGS * f64::EPSILON * (x.abs().max_element() + self.extent)
    }

    /// Rounding error of a normal, which contains the rounded heights of four nodes.
    pub(super) fn blur(&self) -> f64 {
        4.0 * ROUNDINGS * f64::EPSILON * (1.0 + self.extent / self.spacing)
    }

    /// Signed distance from `x` [m], and the normal, for distances of at most `reach`; infinite beyond.
    #[inline]
    pub fn distance(&self, x: DVec3, reach: f64) -> (f64, DVec3) {
        if let Some(inside) = self.inside(x) {
            return inside;
        }
        let near = self.parts(x - reach, x + reach, f64::INFINITY).map(|part| self.spot(part, x, reach));
        let near = near.filter(|spot| spot.beyond <= self.rounding(x) && spot.distance <= reach);
        near.map(|spot| (spot.distance, spot.normal))
            .reduce(|one, other| if other.0 < one.0 { other } else { one })
            .unwrap_or((f64::INFINITY, self.up))
    }

    /// Parts of the surface that a particle of `radius` may touch within a box along the axes. A point touches faces alone.
    pub fn parts(&self, lower: DVec3, upper: DVec3, radius: f64) -> impl Iterator<Item = TerrainPart> {
        let rounding = self.rounding(lower.abs().max(upper.abs()));
        let rims = radius > ROUND * rounding;
        let (lower, upper) = (lower - rounding, upper + rounding);
        let lowest = lower.dot(self.up);
        let [x, y] = [0, 1].map(|axis| self.cells(axis, lower[axis], upper[axis]));
        let nodes = |cells: Option<RangeInclusive<usize>>, many: bool| match cells {
            Some(cells) => *cells.start()..*cells.end() + 1 + usize::from(many),
            None => 0..0,
        };
        let [ends_x, ends_y] = [(&x, 0), (&y, 1)].map(|(cells, axis)| nodes(cells.clone(), self.nodes[axis] > 1));
        let kinds = move || FACES.into_iter().chain(RIMS.into_iter().filter(move |_| rims));
        let within = [ends_x.end, ends_y.end];
        let all = ends_x.flat_map(move |i| ends_y.clone().flat_map(move |j| kinds().map(move |kind| (kind, [i, j]))));
        all.filter(move |&(kind, at)| {
            let last = self.last(kind, at);
            (0..2).all(|axis| last[axis] < within[axis] && self.is_across(axis, (at, last), lower[axis], upper[axis]))
                && self.height_of(at, last) >= lowest
                && self.is_there(kind, at)
        })
        .map(|(kind, node)| TerrainPart { kind, node: node.map(|index| index as u32) })
    }

    /// Cells along a horizontal axis that have a part between two coordinates.
    fn cells(&self, axis: usize, lower: f64, upper: f64) -> Option<RangeInclusive<usize>> {
        let count = self.nodes[axis];
        if count == 1 {
            return Some(0..=0);
        }
        let place = |coordinate: f64| ((coordinate - self.corner[axis]) / self.spacing).floor();
        let last = (count - 2) as f64;
        let (first, end) = (place(lower), place(upper));
        // A border belongs to the grid, even if its position is rounded.
        let overlaps = first <= last + 1.0 && end >= -1.0;
        overlaps.then(|| first.clamp(0.0, last) as usize..=end.clamp(0.0, last) as usize)
    }

    /// Whether a part from one node to another is between two coordinates along an axis. A part with an extent along the axis
    /// always counts.
    fn is_across(&self, axis: usize, (from, to): ([usize; 2], [usize; 2]), lower: f64, upper: f64) -> bool {
        let place = self.corner[axis] + self.spacing * from[axis] as f64;
        self.nodes[axis] == 1 || from[axis] < to[axis] || (lower <= place && place <= upper)
    }

    /// Last of the nodes of a part.
    fn last(&self, kind: PartKind, [i, j]: [usize; 2]) -> [usize; 2] {
        let next = usize::from(self.nodes[1] > 1);
        match kind {
            PartKind::Low | PartKind::High | PartKind::Diagonal => [i + 1, j + next],
            PartKind::SideX | PartKind::AlongY => [i, j + next],
            PartKind::SideY | PartKind::AlongX => [i + 1, j],
            PartKind::Node | PartKind::Corner => [i, j],
        }
    }

    /// Whether a part of a kind exists at nodes of the grid. An edge exists where the ground is bent outward.
    fn is_there(&self, kind: PartKind, at: [usize; 2]) -> bool {
        let is_spatial = self.nodes[1] > 1;
        let ends = [0, 1].map(|axis| at[axis] == 0 || at[axis] == self.nodes[axis] - 1);
        match kind {
            PartKind::Low | PartKind::Node => true,
            PartKind::SideX => ends[0],
            PartKind::High => is_spatial,
            PartKind::SideY => is_spatial && ends[1],
            PartKind::Corner => is_spatial && ends[0] && ends[1],
            PartKind::AlongX => is_spatial && self.is_ridge(at, [1, 0]),
            PartKind::AlongY => is_spatial && self.is_ridge(at, [0, 1]),
            PartKind::Diagonal => {
                let [a, b, c, d] = self.corners(at).map(|node| self.height(node));
                is_spatial && ((a + d) - (b + c)).abs() > self.flat()
            }
        }
    }

    /// Whether the ground is bent outward along the edge from a node along an axis. At a border it always is.
    fn is_ridge(&self, [i, j]: [usize; 2], [di, dj]: [usize; 2]) -> bool {
        let (across, limit) = if di == 1 { (j, self.nodes[1]) } else { (i, self.nodes[0]) };
        if across == 0 || across + 1 == limit {
            return true;
        }
        let drop = |from: [usize; 2]| {
            let beside = [from, [from[0] + di, from[1] + dj]];
            let ends = [[i, j], [i + di, j + dj]];
            // The triangle ends in the node that is less below the level of the edge.
            let drops = [0, 1].map(|end| self.height(ends[end]) - self.height(beside[end]));
            drops[0].min(drops[1])
        };
        drop([i - dj, j - di]) + drop([i + dj, j + di]) > self.flat()
    }

    /// Tolerance below which a difference of sums of heights is due to rounding [m].
    fn flat(&self) -> f64 {
        ROUNDINGS * f64::EPSILON * self.extent
    }

    /// Largest height of the nodes from one to another.
    fn height_of(&self, from: [usize; 2], to: [usize; 2]) -> f64 {
        let nodes = (from[0]..=to[0]).flat_map(|i| (from[1]..=to[1]).map(move |j| [i, j]));
        nodes.map(|node| self.height(node)).fold(f64::NEG_INFINITY, f64::max)
    }

    fn height(&self, [i, j]: [usize; 2]) -> f64 {
        self.heights[i * self.nodes[1] + j]
    }

    /// Position of a node [m].
    fn node(&self, [i, j]: [usize; 2]) -> DVec3 {
        let across = if self.nodes[1] > 1 { DVec3::Y * (self.spacing * j as f64) } else { DVec3::ZERO };
        self.corner + DVec3::X * (self.spacing * i as f64) + across + self.up * self.height([i, j])
    }

    /// Nodes of the cell from a node on: that node, the next along x, along y, and along both.
    fn corners(&self, [i, j]: [usize; 2]) -> [[usize; 2]; 4] {
        let next = usize::from(self.nodes[1] > 1);
        [[i, j], [i + 1, j], [i, j + next], [i + 1, j + next]]
    }
}
