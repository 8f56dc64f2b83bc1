//! Shapes of the parts of a height field, and their regions.

use glam::DVec3;

use super::{PartKind, Spot, Terrain, TerrainPart};
use crate::boundaries::polytope::Feature;

/// Flat part.
pub struct Face {
    pub normal: DVec3,
    /// Point of the plane [m].
    pub point: DVec3,
    /// Borders: a point of each and a direction along it, such that normal × direction points inward.
    borders: [(DVec3, DVec3); 3],
    /// Number of borders.
    count: usize,
    /// Whether the face is seen from above.
    is_top: bool,
}

impl Face {
    /// Signed distance of a point from the plane [m].
    #[inline]
    pub fn height(&self, x: DVec3) -> f64 {
        self.normal.dot(x - self.point)
    }

    /// Distance of `x` beyond the borders [m]. The borders are extended along `out`, the normal or the vertical.
    fn beyond(&self, x: DVec3, out: DVec3) -> f64 {
        let borders = self.borders[..self.count].iter().map(|&(point, way)| {
            let inward = out.cross(way);
            -inward.dot(x - point) / inward.length()
        });
        borders.fold(f64::NEG_INFINITY, f64::max)
    }
}

impl Terrain {
    /// Part as seen from `x`. If farther away than `reach`, `x` counts as beyond its region.
    pub(crate) fn spot(&self, part: TerrainPart, x: DVec3, reach: f64) -> Spot {
        if part.is_face() { self.spot_of_face(&self.face(part), x, reach) } else { self.spot_of_rim(part, x, reach) }
    }

    /// Curvature of the surface at the distance of `x` from a part, as [`Wall::curvature`](crate::boundaries::Wall::curvature).
    pub(crate) fn curvature(&self, part: TerrainPart, x: DVec3, direction: DVec3) -> f64 {
        if part.is_face() {
            return 0.0;
        }
        let Spot { distance, feature, .. } = self.spot_of_rim(part, x, f64::NEG_INFINITY);
        feature.curvature(distance, direction)
    }

    /// Shape of a flat part.
    #[inline]
    pub fn face(&self, part: TerrainPart) -> Face {
        let at = part.nodes();
        match part.kind {
            PartKind::SideX => self.side(at, self.last(part.kind, at), if at[0] == 0 { DVec3::NEG_X } else { DVec3::X }),
            PartKind::SideY => self.side(at, self.last(part.kind, at), if at[1] == 0 { DVec3::NEG_Y } else { DVec3::Y }),
            kind => self.top_face(at, kind == PartKind::Low),
        }
    }

    /// Triangle of the cell from a node on; in 2D the segment.
    fn top_face(&self, at: [usize; 2], low: bool) -> Face {
        let nodes = self.corners(at);
        let [a, b, c, d] = nodes.map(|node| self.height(node));
        let rises = a + d >= b + c;
        let slope = (if low { b - a } else { d - c }) / self.spacing;
        let across = if self.nodes[1] == 1 { 0.0 } else { (if rises == low { d - b } else { c - a }) / self.spacing };
        let horizontal = if self.nodes[1] == 1 { DVec3::ZERO } else { DVec3::Y * across };
        let steep = self.up - DVec3::X * slope - horizontal;
        let normal = steep / steep.length();
        let [a, b, c, d] = nodes.map(|node| self.node(node));
        if self.nodes[1] == 1 {
            let borders = [(a, DVec3::Z), (b, DVec3::NEG_Z), (a, DVec3::ZERO)];
            return Face { normal, point: a, borders, count: 2, is_top: true };
        }
        let [p, q, r] = match (low, rises) {
            (true, true) => [a, b, d],
            (false, true) => [a, d, c],
            (true, false) => [a, b, c],
            (false, false) => [b, d, c],
        };
        Face { normal, point: p, borders: [(p, q - p), (q, r - q), (r, p - r)], count: 3, is_top: true }
    }

    /// Side below the border from one node to another.
    fn side(&self, from: [usize; 2], to: [usize; 2], normal: DVec3) -> Face {
        let (p, q) = (self.node(from), self.node(to));
        let along = if from == to { DVec3::Z } else { q - p };
        let turn = if normal.cross(along).dot(self.up) < 0.0 { 1.0 } else { -1.0 };
        let borders = [(p, along * turn), (p, self.up * turn), (q, self.up * -turn)];
        Face { normal, point: p, borders, count: if from == to { 1 } else { 3 }, is_top: false }
    }

    /// Face as seen from `x`. Above the ground, the region of a face is the prism over it. Below, the region is where the face is
    /// nearer than the sides, or, for a side, than the top of the ground.
    fn spot_of_face(&self, face: &Face, x: DVec3, reach: f64) -> Spot {
        let distance = face.height(x);
        if distance > reach {
            return Spot { distance, normal: face.normal, beyond: f64::INFINITY, feature: Feature::Facet };
        }
        let out = if distance >= 0.0 || !face.is_top { face.normal } else { self.up };
        let mut beyond = face.beyond(x, out);
        if distance < 0.0 {
            let nearer = if face.is_top { -self.depth_from_sides(x) } else { self.roof(x).0 };
            beyond = if distance < nearer { f64::INFINITY } else { beyond };
        }
        Spot { distance, normal: face.normal, beyond, feature: Feature::Facet }
    }

    /// Distance from the nearest side [m] of a point between the sides.
    fn depth_from_sides(&self, x: DVec3) -> f64 {
        let depth = |axis: usize| match self.nodes[axis] {
            1 => f64::INFINITY,
            count => {
                let from = x[axis] - self.corner[axis];
                from.min((count - 1) as f64 * self.spacing - from)
            }
        };
        depth(0).min(depth(1))
    }

    /// Height of `x` above the ground along the normal [m], and the normal; beside the ground, of the nearest cell.
    fn roof(&self, x: DVec3) -> (f64, DVec3) {
        let [i, j] = [0, 1].map(|axis| self.cells(axis, x[axis], x[axis]).map_or(0, |cells| *cells.start()));
        let heights = [true, false].map(|low| {
            let face = self.top_face([i, j], low);
            (face.height(x), face.normal)
        });
        // A point below both triangles of a cell is in the ground.
        if heights[1].0 > heights[0].0 && self.nodes[1] > 1 { heights[1] } else { heights[0] }
    }

    /// Distance from the surface, which is negative, and the normal, if `x` is in the ground.
    pub(crate) fn inside(&self, x: DVec3) -> Option<(f64, DVec3)> {
        let (side, (roof, normal)) = (self.depth_from_sides(x), self.roof(x));
        if side <= 0.0 || roof >= 0.0 {
            return None;
        }
        if roof >= -side {
            return Some((roof, normal));
        }
        let faces = [DVec3::NEG_X, DVec3::X, DVec3::NEG_Y, DVec3::Y].into_iter().filter(|normal| normal.dot(self.up) == 0.0);
        let far = |normal: DVec3| {
            let end = self.node([self.nodes[0] - 1, self.nodes[1] - 1]);
            normal.dot(x - if normal.max_element() > 0.0 { end } else { self.corner })
        };
        faces.map(|normal| (far(normal), normal)).reduce(|one, other| if other.0 > one.0 { other } else { one })
    }

    /// Rim as seen from `x`. In its region, no node around it is nearer to `x`, to first order, than the point of the rim.
    fn spot_of_rim(&self, part: TerrainPart, x: DVec3, reach: f64) -> Spot {
        let (from, way) = self.rim(part, x);
        let length = way.length();
        let along = if length > 0.0 { way.dot(x - from) / length } else { 0.0 };
        let point = if length > 0.0 { from + way * (along.clamp(0.0, length) / length) } else { from };
        let away = x - point;
        let distance = away.length();
        let normal = if distance > 0.0 { away / distance } else { self.up };
        let mut beyond = if length > 0.0 { (-along).max(along - length) } else { f64::NEG_INFINITY };
        let feature = match part.kind {
            PartKind::Corner => {
                beyond = beyond.max((x - self.node(part.nodes())).dot(self.up));
                Feature::Edge(self.up)
            }
            PartKind::Node => Feature::Vertex,
            _ => Feature::Edge(way / length),
        };
        if distance > reach {
            return Spot { distance, normal, beyond: f64::INFINITY, feature };
        }
        if part.kind != PartKind::Corner {
            beyond = beyond.max(-away.dot(self.up));
        }
        for way in self.around(part).map(|node| node - point) {
            beyond = beyond.max(away.dot(way) / way.length());
        }
        Spot { distance, normal, beyond, feature }
    }

    /// Start of a rim and the vector to its end [m]; for an upright edge, the point level with `x` and zero.
    pub(super) fn rim(&self, part: TerrainPart, x: DVec3) -> (DVec3, DVec3) {
        let at = part.nodes();
        let from = self.node(at);
        match part.kind {
            PartKind::Corner => (from + self.up * (x - from).dot(self.up).min(0.0), DVec3::ZERO),
            PartKind::Diagonal => {
                let [a, b, c, d] = self.corners(at);
                let [start, end] =
                    if self.height(a) + self.height(d) >= self.height(b) + self.height(c) { [a, d] } else { [b, c] };
                (self.node(start), self.node(end) - self.node(start))
            }
            kind => (from, self.node(self.last(kind, at)) - from),
        }
    }

    /// Nodes of the cells that meet at a rim, except its own.
    fn around(&self, part: TerrainPart) -> impl Iterator<Item = DVec3> {
        let (from, to) = (part.nodes(), self.last(part.kind, part.nodes()));
        let (wide_x, wide_y) = match part.kind {
            PartKind::AlongX => (0, 1),
            PartKind::AlongY => (1, 0),
            PartKind::Diagonal => (0, 0),
            _ => (1, 1),
        };
        let range = move |axis: usize, wide: usize| from[axis].saturating_sub(wide)..(to[axis] + wide + 1).min(self.nodes[axis]);
        let nodes = range(0, wide_x).flat_map(move |i| range(1, wide_y).map(move |j| [i, j]));
        let own = match part.kind {
            PartKind::Diagonal => {
                let [a, b, c, d] = self.corners(from);
                if self.height(a) + self.height(d) >= self.height(b) + self.height(c) { [a, d] } else { [b, c] }
            }
            _ => [from, to],
        };
        nodes.filter(move |node| !own.contains(node)).map(|node| self.node(node))
    }
}

impl TerrainPart {
    /// Whether the part is flat.
    #[inline]
    pub fn is_face(self) -> bool {
        super::FACES.contains(&self.kind)
    }

    fn nodes(self) -> [usize; 2] {
        self.node.map(|index| index as usize)
    }
}
