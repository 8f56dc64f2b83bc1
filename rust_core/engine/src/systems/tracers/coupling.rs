//! Tracers in the flow of point vortices: a coupling in one direction.

use std::any::Any;
use std::marker::PhantomData;

use super::Tracers;
use super::points::Points;
use super::vortices::{InducedFlow, Vortices};
use crate::math::Real;
use crate::systems::{Coupling, SystemPart};

/// Tracers that follow vortices in the stages of the same steps. Their order is therefore that of the method.
pub struct VortexCoupling<T> {
    /// Index of the vortices among the systems.
    vortices: usize,
    /// Index of the tracers, which come later.
    tracers: usize,
    precision: PhantomData<T>,
}

impl<T: Real> VortexCoupling<T> {
    /// Couples two systems, given by their indices.
    pub fn new(vortices: usize, tracers: usize) -> Self {
        Self { vortices, tracers, precision: PhantomData }
    }

    /// Vortices with their positions, and the flow of the tracers.
    fn pair<'a>(&self, systems: &'a mut [SystemPart]) -> Option<(&'a Points<T, 2>, &'a Vortices<T>, &'a mut InducedFlow<T>)> {
        let [vortices, tracers] = systems.get_disjoint_mut([self.vortices, self.tracers]).ok()?;
        let vortices = (&*vortices.system as &dyn Any).downcast_ref::<Tracers<T, 2>>()?;
        let tracers = (&mut *tracers.system as &mut dyn Any).downcast_mut::<Tracers<T, 2>>()?;
        let flow = (&*vortices.flow as &dyn Any).downcast_ref()?;
        let induced = (&mut *tracers.flow as &mut dyn Any).downcast_mut()?;
        Some((&vortices.points, flow, induced))
    }
}

impl<T: Real> Coupling for VortexCoupling<T> {
    fn systems(&self) -> [usize; 2] {
        [self.vortices, self.tracers]
    }

    fn update(&self, systems: &mut [SystemPart]) {
        if let Some((points, _, induced)) = self.pair(systems) {
            induced.present.copy_from(points);
        }
    }

    fn follow(&self, systems: &mut [SystemPart], advanced: usize) {
        if let (true, Some((points, vortices, induced))) = (advanced == self.vortices, self.pair(systems)) {
            induced.present.copy_from(points);
            induced.stages.iter_mut().zip(&vortices.kept).for_each(|(stages, kept)| stages.clone_from(kept));
        }
    }
}
