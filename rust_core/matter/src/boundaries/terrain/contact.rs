//! First contact of a particle on its path with a part of a height field.
//!
//! A contact counts only in the region of the part. Where the path enters the ground elsewhere, another part is met before.

use super::{Terrain, TerrainPart};
use crate::boundaries::Path;
use crate::boundaries::gap::first_contact_with_convex;
use crate::boundaries::polynomial::Polynomial;

/// Distance beyond the borders of a face, in spacings, up to which a grazing path still touches the face. The contact of such a
/// path is not sharp in time. The tolerance prevents it from slipping through between two faces. The speed towards the face is
/// then near rounding.
const GRAZING: f64 = 1e-6;

impl Terrain {
    /// Time within `duration` of the first contact of a particle of radius `radius` with a part; `touching` as in
    /// [`Gap::new`](crate::boundaries::Gap::new).
    pub(crate) fn first_contact(
        &self,
        part: TerrainPart,
        path: &Path,
        radius: f64,
        touching: bool,
        duration: f64,
    ) -> Option<f64> {
        if part.is_face() {
            return self.contact_with_face(part, path, radius, touching, duration);
        }
        let nearest = |x| {
            let (from, way) = self.rim(part, x);
            let square = way.length_squared();
            let along = if square > 0.0 { (way.dot(x - from) / square).clamp(0.0, 1.0) } else { 0.0 };
            let away = x - (from + way * along);
            let distance = away.length();
            (distance, if distance > 0.0 { away / distance } else { self.up })
        };
        let time = first_contact_with_convex(nearest, self.extent, path, radius, touching, duration)?;
        let x = path.at(time);
        (self.spot(part, x, f64::INFINITY).beyond <= self.rounding(x)).then_some(time)
    }

    /// Time of first contact with a face. A path that is below the plane at the start is beyond the face. It may meet the face
    /// once, after its highest point.
    fn contact_with_face(&self, part: TerrainPart, path: &Path, radius: f64, touching: bool, duration: f64) -> Option<f64> {
        let face = self.face(part);
        let gap = face.height(path.position) - radius;
        let rounding = self.rounding(path.position);
        let mut start = 0.0;
        if !touching && gap < -rounding {
            let spot = self.spot(part, path.position, f64::INFINITY);
            if spot.beyond <= rounding && spot.distance < radius {
                return Some(0.0);
            }
            let bend = face.normal.dot(path.acceleration);
            start = -face.normal.dot(path.velocity) / bend;
            if !(bend < 0.0 && start > 0.0 && start < duration && face.height(path.at(start)) > radius) {
                return None;
            }
        }
        // A path within rounding of the plane counts as touching it. Otherwise an immediate contact beyond the face would hide
        // the later contact on the face.
        let touching = start == 0.0 && (touching || gap <= rounding);
        let ahead = Path { position: path.at(start), velocity: path.slope(start), ..*path };
        let plane = (face.normal, face.normal.dot(face.point));
        let time = start + Polynomial::plane(plane, &ahead, radius, touching).first_contact(duration - start)?;
        let (x, slope) = (path.at(time), path.slope(time));
        let (beyond, rounding) = (self.spot(part, x, f64::INFINITY).beyond, self.rounding(x));
        // A path along the plane of the face does not approach it.
        let approach = -face.normal.dot(slope) / slope.length();
        let grazes = approach > self.blur() && beyond <= (rounding / approach).min(GRAZING * self.spacing);
        (beyond <= rounding || grazes).then_some(time)
    }
}
