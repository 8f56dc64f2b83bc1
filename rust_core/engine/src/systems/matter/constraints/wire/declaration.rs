//! Wires that a scene declares.

use glam::DVec3;

use super::super::{Declaration, WIRES, refuse, rods, self_contact};
use super::{AHEAD, Bead, LARGEST_ANGLE, NEAREST, WireCurve, Wires};
use crate::catalog::Space;
use crate::error::{Error, Result};
use crate::forces::springs;
use crate::math::spline::CubicSpline;
use crate::scene::{Item, Value};
use crate::systems::matter::methods::{MethodProperties, Treatment};

/// Kind of the items.
const KIND: &str = "Wire";

impl Wires {
    /// Wires that a scene declares; None if there are none.
    ///
    /// # Errors
    /// If a value is wrong, if the method does not carry wires, or if another constraint or a wall acts on a bead.
    pub fn declared<V: Space>(declared: &Declaration<'_, V>) -> Result<Option<Self>> {
        let Declaration { scene, properties, method, .. } = *declared;
        let items: Vec<&Item> = scene.constraints.iter().filter(|item| item.kind == KIND).collect();
        let Some(first) = items.first() else { return Ok(None) };
        refuse(WIRES, method)?;
        if scene.periodic.is_some() {
            return Err(Error::parameter(&first.path, "no Periodic domain", "one"));
        }
        let curves = items.iter().map(|item| curve(item, V::DIMENSION, properties.origin, method)).collect::<Result<Vec<_>>>()?;
        let smooth = method.drifts_first() && curves.iter().all(|curve| curve.friction == 0.0);
        let order = if smooth { u32::MAX } else { 1 };
        let mut wires = Self { curves, beads: Vec::new(), removed: 0.0, placed: false, order };
        for (wire, item) in items.into_iter().enumerate() {
            wires.put(item, wire, declared)?;
        }
        wires.refuse_others(declared)?;
        Ok(Some(wires))
    }

    /// Puts the particles of an item onto its wire, at its beginning.
    fn put<V: Space>(&mut self, item: &Item, wire: usize, declared: &Declaration<'_, V>) -> Result<()> {
        let properties = declared.properties;
        let engine = properties.engine();
        let mut taken = vec![false; properties.count()];
        self.beads.iter().for_each(|bead| taken[bead.particle as usize] = true);
        let members = declared.scene.members(item);
        for (caller, _) in members.iter().enumerate().filter(|(_, member)| **member) {
            let particle = engine[caller];
            if properties.is_fixed(particle as usize) {
                let found = format!("particle {caller}, which is fixed");
                return Err(Error::parameter(format!("{}.on", item.path), "particles that move", found)
                    .with_hint("name the others with on=(body, indices)"));
            }
            if taken[particle as usize] {
                let found = format!("particle {caller} on a second one");
                return Err(Error::parameter(&item.path, "one wire for each particle", found));
            }
            self.beads.push(Bead { particle, wire, ..Bead::default() });
        }
        Ok(())
    }

    /// Refuses beads that rods, walls or other meshes hold too: their constraints would have to be solved together.
    fn refuse_others<V: Space>(
        &self,
        Declaration { scene, springs: declared_springs, properties, walls, .. }: &Declaration<'_, V>,
    ) -> Result<()> {
        let mut held = vec![false; properties.count()];
        declared_springs
            .iter()
            .filter(|spring| rods::is_rod(spring))
            .flat_map(|rod| rod.ends)
            .for_each(|end| held[end as usize] = true);
        let meshes = self_contact::bodies(scene)?;
        let strains = springs::strains(scene, "strain_limit")?;
        let mut limited = vec![false; properties.count()];
        let taut = declared_springs.iter().zip(strains).filter(|(_, strain)| strain.is_finite());
        taut.flat_map(|(spring, _)| spring.ends).for_each(|end| limited[end as usize] = true);
        for bead in &self.beads {
            let index = bead.particle as usize;
            let other = if held[index] {
                "a rod"
            } else if limited[index] {
                "a strain limit"
            } else if walls.as_ref().is_some_and(|walls| walls.walls_of(properties, index).next().is_some()) {
                "a boundary"
            } else if meshes.contains(&(properties.body[index] as usize)) {
                "SelfContact"
            } else {
                continue;
            };
            let path = format!("{}.on", self.curves[bead.wire].path);
            let found = format!("particle {}, on which {other} acts too", properties.caller[index]);
            return Err(Error::parameter(path, "particles that nothing but the wire holds", found)
                .with_hint("name the bodies of the other with on=, or the particles of the wire with on=(body, indices)"));
        }
        Ok(())
    }
}

/// Curve that an item declares, relative to an origin.
fn curve(item: &Item, dimension: usize, origin: DVec3, method: &MethodProperties) -> Result<WireCurve> {
    let points = item.vectors("points", None, dimension)?;
    let (closed, friction) = (item.flag("closed")?, item.non_negative("friction")?);
    let length: f64 = points.windows(2).map(|ends| (ends[1] - ends[0]).length()).sum();
    let coincide = |one: &DVec3, other: &DVec3| (*one - *other).length() <= NEAREST * length;
    let repeats = closed && points.len() > 1 && coincide(&points[0], &points[points.len() - 1]);
    if points.len() < if closed { 3 } else { 2 } || points.windows(2).any(|ends| coincide(&ends[0], &ends[1])) || repeats {
        let given = Value::Text(format!("{} points", points.len()));
        let expected = "at least two points, three for a closed wire, that differ from the next";
        return Err(item.wrong("points", expected, Some(&given)));
    }
    if friction > 0.0 && method.springs == Treatment::Rods && method.orders[0] > 2 {
        let path = format!("{}.friction", item.path);
        return Err(Error::parameter(path, format!("0 with {}(order=4)", method.name), friction)
            .with_hint("parts of its steps go backward in time, where friction would speed beads up: take order=2"));
    }
    let points: Vec<DVec3> = points.iter().map(|point| *point - origin).collect();
    let spline = CubicSpline::through(&points, closed);
    let reaches = spline.reaches(LARGEST_ANGLE, AHEAD);
    Ok(WireCurve { path: item.path.clone(), spline, friction, reaches })
}
