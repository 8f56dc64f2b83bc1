//! Gift wrapping: the facets of a convex hull, found from one another across their edges.
//!
//! A facet is the set of all points within the tolerance of a plane that supports the hull. The first of its points that define a
//! plane define that of the facet. The way on which the facet was found has no effect on it.
//!
//! Source: D. R. Chand, S. S. Kapur, J. ACM 17, 78 (1970).

use std::collections::BTreeSet;

use glam::DVec3;

use super::polytope::Facet;

/// Smallest cosine of the angle between two planes through the same points, which are on one of them within the tolerance.
const LEVEL: f64 = 1.0 - 1e-4;

/// Points of which the hull is wanted.
pub(super) struct Wrapping<'a> {
    pub points: &'a [DVec3],
    pub dimension: usize,
    /// Distance from a plane within which a point counts as on it [m].
    pub tolerance: f64,
    /// Extent of the points [m].
    pub size: f64,
}

impl Wrapping<'_> {
    /// All facets, in the order of the points that define their planes. None if the points are flat or not regular.
    pub fn facets(&self) -> Option<Vec<Facet>> {
        let mut found = vec![self.first()?];
        let mut passed: BTreeSet<[u32; 2]> = BTreeSet::new();
        let mut next = 0;
        while next < found.len() {
            let edges = self.edges(&found[next].1);
            let normal = found[next].1.normal;
            next += 1;
            for (edge, along) in edges {
                if !passed.insert(edge) {
                    continue;
                }
                if self.dimension == 3 {
                    passed.insert([edge[1], edge[0]]);
                }
                let other = self.facet(self.across(edge[0], along, normal)?)?;
                if !found.iter().any(|(triple, _)| *triple == other.0) {
                    found.push(other);
                }
            }
        }
        found.sort_by_key(|(triple, _)| *triple);
        Some(found.into_iter().map(|(_, facet)| facet).collect())
    }

    /// The facet at the point with the least x, from which a plane is tilted until it rests on enough points.
    fn first(&self) -> Option<([u32; 3], Facet)> {
        let order = |&one: &u32, &other: &u32| self.at(one).x.total_cmp(&self.at(other).x).then(one.cmp(&other));
        let start = (0..self.points.len() as u32).min_by(order)?;
        let mut normal = self.across(start, DVec3::Z, DVec3::NEG_X)?;
        if self.dimension == 3 {
            let level = |&other: &u32| (normal.dot(self.at(other) - self.at(start))).abs() <= self.tolerance;
            let far = |&one: &u32, &other: &u32| self.way(start, one).length().total_cmp(&self.way(start, other).length());
            let other = (0..self.points.len() as u32).filter(level).max_by(far)?;
            normal = self.across(start, self.way(start, other).try_normalize()?, normal)?;
        }
        self.facet(normal)
    }

    /// Outward normal of the plane that is reached from the one of a `normal` by a turn about an axis through a point.
    fn across(&self, point: u32, along: DVec3, normal: DVec3) -> Option<DVec3> {
        let ahead = along.cross(normal);
        let turn = |other: u32| {
            let away = self.way(point, other).reject_from_normalized(along);
            let length = away.length();
            // Zero with a positive sign: the angle of a negative zero may be −π.
            let below = (-away.dot(normal)).max(0.0) + 0.0;
            (length > self.tolerance).then(|| (libm::atan2(below, away.dot(ahead)), -length, away))
        };
        let nearest =
            |one: &(f64, f64, DVec3), other: &(f64, f64, DVec3)| one.0.total_cmp(&other.0).then(one.1.total_cmp(&other.1));
        let (_, _, away) = (0..self.points.len() as u32).filter_map(turn).min_by(nearest)?;
        away.cross(along).try_normalize()
    }

    /// The facet near a supporting plane, with the points that define its plane.
    fn facet(&self, near: DVec3) -> Option<([u32; 3], Facet)> {
        // A plane found from two near points may miss others. The second one does not.
        let (_, normal) = self.plane(near)?;
        let (triple, normal) = self.plane(normal)?;
        Some((triple, Facet::new(normal, self.offset(normal), self.points, self.tolerance, self.dimension)))
    }

    /// The first points on a supporting plane whose own plane supports the hull, and its outward normal.
    fn plane(&self, near: DVec3) -> Option<([u32; 3], DVec3)> {
        let level = self.offset(near) - self.tolerance;
        let on: Vec<u32> = (0..self.points.len() as u32).filter(|&point| near.dot(self.at(point)) >= level).collect();
        let supports = |[one, other, third]: [u32; 3]| {
            let normal = if self.dimension == 2 {
                DVec3::Z.cross(self.way(one, other))
            } else {
                let normal = self.way(one, other).cross(self.way(one, third));
                (normal.length() > self.tolerance * self.size).then_some(normal)?
            };
            let normal = normal.try_normalize()?;
            let normal = if normal.dot(near) < 0.0 { -normal } else { normal };
            (self.offset(normal) - normal.dot(self.at(one)) <= self.tolerance && normal.dot(near) > LEVEL).then_some(normal)
        };
        let pairs = on.iter().enumerate().flat_map(|(index, &one)| on[index + 1..].iter().map(move |&other| (one, other)));
        pairs
            .flat_map(|(one, other)| {
                let beyond = on.partition_point(|&point| point <= other);
                let thirds = if self.dimension == 2 { &on[beyond - 1..beyond] } else { &on[beyond..] };
                thirds.iter().map(move |&third| [one, other, third])
            })
            .find_map(|triple| supports(triple).map(|normal| (triple, normal)))
    }

    /// Edges of a facet with their unit directions, counterclockwise; in 2D its vertices with directions along z.
    fn edges(&self, facet: &Facet) -> Vec<([u32; 2], DVec3)> {
        let loops = &facet.loops;
        let place = |index: usize| loops[index % loops.len()];
        let edge = |index: usize| {
            let (from, to) = (place(index), place(index + 1));
            if self.dimension == 3 {
                return ([from, to], self.way(from, to).normalize());
            }
            // The plane turns about z, away from the other end.
            let away = DVec3::Z.cross(facet.normal).dot(self.way(to, from)) > 0.0;
            ([from, to], if away { DVec3::Z } else { DVec3::NEG_Z })
        };
        (0..loops.len()).map(edge).collect()
    }

    /// Largest n·x of all points.
    fn offset(&self, normal: DVec3) -> f64 {
        self.points.iter().map(|point| normal.dot(*point)).fold(f64::NEG_INFINITY, f64::max)
    }

    fn at(&self, point: u32) -> DVec3 {
        self.points[point as usize]
    }

    /// Way from one point to another.
    fn way(&self, from: u32, to: u32) -> DVec3 {
        self.at(to) - self.at(from)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::polytope::FLAT;
    use super::*;

    /// The facets by their definition: every plane through three points, in 2D two, that supports the hull.
    fn enumerated(points: &[DVec3], dimension: usize, tolerance: f64, size: f64) -> Vec<Facet> {
        let mut facets: Vec<Facet> = Vec::new();
        let mut add = |normal: DVec3, through: DVec3| {
            let Some(normal) = normal.try_normalize() else { return };
            for normal in [normal, -normal] {
                let offset = points.iter().map(|point| normal.dot(*point)).fold(f64::NEG_INFINITY, f64::max);
                let known = |facet: &Facet| facet.normal.dot(normal) > 1.0 - FLAT && (facet.offset - offset).abs() <= tolerance;
                if offset - normal.dot(through) <= tolerance && !facets.iter().any(known) {
                    facets.push(Facet::new(normal, offset, points, tolerance, dimension));
                }
            }
        };
        for (index, &one) in points.iter().enumerate() {
            for (next, &other) in points.iter().enumerate().skip(index + 1) {
                if dimension == 2 {
                    add(DVec3::Z.cross(other - one), one);
                    continue;
                }
                for &third in &points[next + 1..] {
                    let normal = (other - one).cross(third - one);
                    if normal.length() > tolerance * size {
                        add(normal, one);
                    }
                }
            }
        }
        facets
    }

    fn wrapped(points: &[DVec3], dimension: usize) -> (Option<Vec<Facet>>, Vec<Facet>) {
        let size = points.iter().map(|point| (*point - points[0]).length()).fold(0.0, f64::max);
        let tolerance = FLAT * size;
        let wrapping = Wrapping { points, dimension, tolerance, size };
        (wrapping.facets(), enumerated(points, dimension, tolerance, size))
    }

    proptest! {
        /// Facets have the same bits and the same order, also of points of a lattice, many of which are on one plane or line.
        #[test]
        fn wrapping_finds_the_facets_of_the_definition(
            rows in prop::collection::vec(prop::array::uniform3(-1.0..1.0_f64), 5..24),
            lattice in prop::bool::ANY,
            dimension in 2..=3_usize,
        ) {
            let place = |row: [f64; 3]| {
                let x = DVec3::from_array(row);
                let x = if lattice { (2.0 * x).round() } else { x };
                if dimension == 2 { x.with_z(0.0) } else { x }
            };
            let points: Vec<DVec3> = rows.into_iter().map(place).collect();
            let (found, expected) = wrapped(&points, dimension);
            let flat = expected.len() <= dimension;
            prop_assume!(!flat);
            prop_assert_eq!(found, Some(expected));
        }
    }

    #[test]
    fn points_may_coincide() {
        let points = [DVec3::ZERO, DVec3::ZERO, DVec3::ZERO, 0.07 * DVec3::Y, 0.63 * DVec3::X];
        let (found, expected) = wrapped(&points, 2);
        assert_eq!(expected.len(), 3);
        assert_eq!(found, Some(expected));
    }

    #[test]
    fn flat_points_have_no_facets_on_two_sides() {
        let points: Vec<DVec3> = (0..9).map(|index| DVec3::new(f64::from(index % 3), f64::from(index / 3), 1.0)).collect();
        assert!(wrapped(&points, 3).0.is_none_or(|facets| facets.len() <= 3));
        let line: Vec<DVec3> = (0..5).map(|index| DVec3::new(f64::from(index), 2.0 * f64::from(index), 0.0)).collect();
        assert!(wrapped(&line, 2).0.is_none_or(|facets| facets.len() <= 2));
    }
}
