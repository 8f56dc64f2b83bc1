//! Boundary conditions at the edges of a grid.

use super::Grid;
use super::edge_values::{DIRICHLET, NEUMANN};
use crate::error::Result;
use crate::math::AXES;
use crate::scene::Item;

/// Boundary condition at an edge, on the outer faces of the outermost cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Edge {
    /// Dirichlet condition: the field is zero on the face. Ghost values are mirror images with the opposite sign. Other values
    /// than zero are [`EdgeValues`](super::EdgeValues).
    Fixed,
    /// Neumann condition: no flux through the face. Ghost values are mirror images. Other fluxes are
    /// [`EdgeValues`](super::EdgeValues).
    Free,
    /// Absorbing edge: outgoing waves leave into an absorbing layer beyond the face.
    Absorbing,
    /// Periodic edge: the opposite edge follows.
    Periodic,
}

/// Names of the boundary conditions, and the kinds of those with values.
const WORDS: [(&str, Edge); 6] = [
    ("fixed", Edge::Fixed),
    ("free", Edge::Free),
    ("absorbing", Edge::Absorbing),
    ("periodic", Edge::Periodic),
    (DIRICHLET, Edge::Fixed),
    (NEUMANN, Edge::Free),
];

/// Names of the sides of a grid, in the order of the conditions.
pub(super) const SIDES: [&str; 2 * AXES] = ["x-", "x+", "y-", "y+", "z-", "z+"];

/// Boundary conditions of a grid, at the lower and the upper edge of each axis. Axes that the grid lacks have free edges.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Edges(pub [[Edge; 2]; AXES]);

impl Edges {
    /// Reads the boundary conditions that an item declares by this name: words, or items where some have a value.
    ///
    /// # Errors
    /// If they are not two for each axis, or not periodic exactly along the periodic axes.
    pub fn declared(item: &Item, name: &str, grid: &Grid) -> Result<Self> {
        let words = item.words(name, 2 * grid.dimension, &WORDS.map(|(word, _)| word))?;
        let mut edges = [[Edge::Free; 2]; AXES];
        for (index, word) in words.into_iter().enumerate() {
            let axis = grid.axis(index / 2);
            let edge = WORDS.iter().find(|(known, _)| *known == word).map_or(Edge::Free, |&(_, edge)| edge);
            if (edge == Edge::Periodic) != grid.periodic[axis] {
                return Err(item.wrong(name, "periodic along periodic axes, and only there", item.values.get(name)));
            }
            edges[axis][index % 2] = edge;
        }
        Ok(Self(edges))
    }

    /// Whether any edge has this boundary condition.
    #[inline]
    pub fn any(&self, kind: Edge) -> bool {
        self.0.iter().flatten().any(|&edge| edge == kind)
    }
}
