//! Faces of spring networks that meet rigid bodies.
//!
//! These are the triangles of surfaces, in 2D the sides at their rims, and the springs of chains such as ropes. Particles that are
//! tied to a body do not meet it by themselves, and the faces at them do not meet any. A face along a spring that breaks is gone. Balls
//! and discs that are large against a face need its corners alone.

use std::collections::BTreeMap;

use glam::DVec3;
use physcore_rigid::face::NetFace;
use physcore_rigid::world::{FreeFace, FreePoint};

use crate::error::Result;
use crate::forces::springs;
use crate::scene::Scene;
use crate::systems::matter::constraints::self_contact::{self, BodySurface};

/// Radius of balls and discs that meet the particles at the corners of a face alone, over its longest side a at the start. Between them
/// the face is within such a ball by at most (a/√3)²/2R, a 24th of a.
const LARGE: f64 = 4.0;

/// Triangle of a surface or segment of a chain, by the places of its corners among the points, with the springs along its sides. The
/// third corner of a segment is its second.
#[derive(Debug, Clone)]
struct SpringFace {
    corners: [usize; 3],
    springs: Vec<u32>,
    radius: f64,
}

impl SpringFace {
    fn is_segment(&self) -> bool {
        self.corners[1] == self.corners[2]
    }
}

/// Faces of all networks of a scene.
#[derive(Debug, Default)]
pub struct NetworkFaces {
    declared: Vec<SpringFace>,
    is_planar: bool,
    /// Faces between points, but for those along broken springs.
    faces: Vec<FreeFace>,
}

impl NetworkFaces {
    /// Faces of the networks of a scene between the points that may meet bodies, which have these radii [m]. All bodies are balls or
    /// discs of at least the radius `round` [m]; it is 0 if there are others.
    ///
    /// # Errors
    /// If the faces of a body are wrong.
    pub fn declared(scene: &Scene, engine: &[u32], points: &[(u32, FreePoint)], (radius, round): (&[f64], f64)) -> Result<Self> {
        let mut positions = vec![DVec3::ZERO; engine.len()];
        engine.iter().zip(scene.positions()).for_each(|(&particle, position)| positions[particle as usize] = position);
        let is_small = |[a, b, c]: [u32; 3]| {
            let length = |one: u32, other: u32| positions[one as usize].distance(positions[other as usize]);
            round >= LARGE * length(a, b).max(length(b, c)).max(length(c, a))
        };
        let mut places = vec![None; engine.len()];
        points.iter().enumerate().for_each(|(place, (particle, _))| places[*particle as usize] = Some(place));
        let mut all = Self { is_planar: scene.dimension == 2, ..Self::default() };
        for body in (0..scene.bodies.len()).filter(|&body| scene.bodies[body].item.kind == springs::KIND) {
            let BodySurface { faces, edges } = self_contact::surface(scene, body, engine)?;
            let mut count = vec![0; engine.len()];
            edges.iter().flat_map(|(ends, _)| ends).for_each(|&end| count[end as usize] += 1);
            let is_chain = count.iter().all(|&count| count <= 2);
            let chain = edges.into_iter().filter(|_| is_chain);
            for (corners, springs) in faces.into_iter().chain(chain.map(|([one, other], springs)| ([one, other, other], springs)))
            {
                if is_small(corners) {
                    continue;
                }
                let of = |corner: u32| places[corner as usize];
                let [Some(a), Some(b), Some(c)] = corners.map(of) else { continue };
                let radius = corners.map(|corner| radius[corner as usize]).into_iter().fold(f64::INFINITY, f64::min);
                all.declared.push(SpringFace { corners: [a, b, c], springs, radius });
            }
        }
        all.leave_out_broken(&[]);
        Ok(all)
    }

    /// Number of faces.
    pub fn len(&self) -> usize {
        self.faces.len()
    }

    /// Memory [bytes].
    pub fn bytes(&self) -> usize {
        size_of_val(self.declared.as_slice()) + size_of_val(self.faces.as_slice())
    }

    /// Removes the faces along broken springs.
    pub fn leave_out_broken(&mut self, broken: &[bool]) {
        let is_broken = |&spring: &u32| broken.get(spring as usize) == Some(&true);
        let whole = self.declared.iter().enumerate().filter(|(_, face)| !face.springs.iter().any(is_broken));
        // Faces along each side, with the place of the side among theirs.
        let mut sides: BTreeMap<[usize; 2], Vec<(usize, usize)>> = BTreeMap::new();
        let mut faces: Vec<FreeFace> = Vec::new();
        for (index, declared) in whole {
            let SpringFace { corners, radius, .. } = *declared;
            for side in 0..if declared.is_segment() { 0 } else { 3 } {
                let ends = [corners[side], corners[(side + 1) % 3]];
                sides.entry([ends[0].min(ends[1]), ends[0].max(ends[1])]).or_default().push((faces.len(), side));
            }
            faces.push(FreeFace { index, face: NetFace { corners, beyond: [None; 3], owns: [false; 3], radius } });
        }
        if self.is_planar {
            let rim = sides.values().filter_map(|along| if let [only] = along[..] { Some(only) } else { None });
            let edge = |(place, side): (usize, usize)| {
                let FreeFace { index, face: NetFace { corners, radius, .. } } = faces[place];
                let [from, to] = [corners[side], corners[(side + 1) % 3]];
                let face = NetFace { corners: [from, to, to], beyond: [None; 3], owns: [false; 3], radius };
                FreeFace { index: 3 * index + side, face }
            };
            let segments = faces.iter().filter(|each| self.declared[each.index].is_segment());
            let segments = segments.map(|each| FreeFace { index: 3 * each.index, ..*each });
            self.faces = rim.map(edge).chain(segments).collect();
            self.faces.sort_unstable_by_key(|face| face.index);
            return;
        }
        for along in sides.values() {
            faces[along[0].0].face.owns[along[0].1] = true;
            if let [one, other] = along[..] {
                for ((here, side), (there, across)) in [(one, other), (other, one)] {
                    faces[here].face.beyond[side] = Some(faces[there].face.corners[(across + 2) % 3]);
                }
            }
        }
        self.faces = faces;
    }

    /// Faces that the box between two corners may meet within a step, given the places of the points and their ways [m].
    pub fn near(&self, (lower, upper): (DVec3, DVec3), place: impl Fn(usize) -> (DVec3, f64)) -> impl Iterator<Item = &FreeFace> {
        self.faces.iter().filter(move |each| {
            let corners = each.face.corners.map(&place);
            let reach = corners.iter().map(|corner| corner.1).fold(0.0, f64::max) + each.face.radius;
            let [least, most] = [DVec3::min, DVec3::max].map(|of| corners.iter().map(|corner| corner.0).reduce(of));
            let is_above = least.is_some_and(|least| (least - reach).cmple(upper).all());
            is_above && most.is_some_and(|most| (most + reach).cmpge(lower).all())
        })
    }
}
