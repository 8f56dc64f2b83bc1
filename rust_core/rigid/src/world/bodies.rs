//! Constant properties of the bodies; equal ones that follow each other are stored once.

use std::ops::Index;

use crate::rotation::Inertia;
use crate::surface::Surface;

/// Constant properties of a rigid body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SolidBody {
    /// Surface with its shape.
    pub surface: Surface,
    /// Inverse mass [1/kg]; 0 for a fixed body.
    pub inverse_mass: f64,
    /// Moments of inertia.
    pub inertia: Inertia,
}

/// List of bodies.
#[derive(Debug, Default)]
pub struct SolidBodies {
    kinds: Vec<SolidBody>,
    /// Place of each body among the kinds.
    places: Vec<u32>,
}

impl SolidBodies {
    /// Adds a body.
    pub fn push(&mut self, body: SolidBody) {
        if self.kinds.last() != Some(&body) {
            self.kinds.push(body);
        }
        self.places.push(self.kinds.len() as u32 - 1);
    }

    /// Replaces a body.
    pub fn set(&mut self, index: usize, body: SolidBody) {
        self.kinds.push(body);
        self.places[index] = self.kinds.len() as u32 - 1;
    }

    /// Number of bodies.
    pub fn len(&self) -> usize {
        self.places.len()
    }

    /// Whether there is no body.
    pub fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    /// Bodies in their order.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = &SolidBody> {
        self.places.iter().map(|&place| &self.kinds[place as usize])
    }

    /// Whether two bodies are stored as one.
    pub(super) fn are_one(&self, one: usize, other: usize) -> bool {
        self.places[one] == self.places[other]
    }

    /// Memory [bytes].
    pub fn bytes(&self) -> usize {
        size_of_val(self.kinds.as_slice()) + size_of_val(self.places.as_slice())
    }
}

impl Index<usize> for SolidBodies {
    type Output = SolidBody;

    #[inline(always)]
    fn index(&self, index: usize) -> &SolidBody {
        &self.kinds[self.places[index] as usize]
    }
}
