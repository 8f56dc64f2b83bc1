//! The edges of a grid.

use super::Grid;
use crate::error::Result;
use crate::math::AXES;
use crate::scene::Item;

/// What holds at an edge, on the outer faces of the outermost cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Edge {
    /// A field is zero on the face: beyond it, it is mirrored with the other sign.
    Fixed,
    /// Nothing flows through the face: beyond it, a field is mirrored.
    Free,
    /// What arrives leaves: beyond it is a layer that absorbs.
    Absorbing,
    /// The opposite edge follows.
    Periodic,
}

/// The words for them.
const WORDS: [(&str, Edge); 4] =
    [("fixed", Edge::Fixed), ("free", Edge::Free), ("absorbing", Edge::Absorbing), ("periodic", Edge::Periodic)];

/// The edges of a grid: the lower and the upper one of each axis. Those of an axis that the grid lacks are free.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Edges(pub [[Edge; 2]; AXES]);

impl Edges {
    /// The edges that an item has.
    ///
    /// # Errors
    /// If they are not two for each axis, or periodic where the axis is not.
    pub fn declared(item: &Item, grid: &Grid) -> Result<Self> {
        let words = item.words("edges", 2 * grid.dimension, &WORDS.map(|(word, _)| word))?;
        let mut edges = [[Edge::Free; 2]; AXES];
        for (index, word) in words.into_iter().enumerate() {
            let axis = grid.axis(index / 2);
            let edge = WORDS.iter().find(|(known, _)| *known == word).map_or(Edge::Free, |&(_, edge)| edge);
            if (edge == Edge::Periodic) != grid.periodic[axis] {
                return Err(item.wrong("edges", "periodic along periodic axes, and only there", item.values.get("edges")));
            }
            edges[axis][index % 2] = edge;
        }
        Ok(Self(edges))
    }

    /// Whether one of them is of that kind.
    pub fn any(&self, kind: Edge) -> bool {
        self.0.iter().flatten().any(|&edge| edge == kind)
    }
}
