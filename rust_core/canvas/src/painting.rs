//! Many shapes at once, painted from the far to the near.

use crate::canvas::Canvas;
use crate::shapes::{Disc, Line};

/// Shapes that wait to be painted together. Those with greater depth come first, and of equal depth those that were added first.
#[derive(Debug, Default)]
pub struct Painting {
    discs: Vec<Disc>,
    lines: Vec<Line>,
    order: Vec<Entry>,
    has_depth: bool,
}

#[derive(Clone, Copy, Debug)]
struct Entry {
    depth: f32,
    shape: Shape,
}

#[derive(Clone, Copy, Debug)]
enum Shape {
    Disc(u32),
    Line(u32),
}

impl Painting {
    /// Adds a disc; `depth` is its distance from the viewer, in any unit.
    pub fn disc(&mut self, disc: Disc, depth: f32) {
        self.add(depth, Shape::Disc(self.discs.len() as u32));
        self.discs.push(disc);
    }

    /// Adds a line; `depth` as for [`Painting::disc`].
    pub fn line(&mut self, line: Line, depth: f32) {
        self.add(depth, Shape::Line(self.lines.len() as u32));
        self.lines.push(line);
    }

    /// Paints everything that was added and forgets it; the memory is kept for the next frame.
    pub fn paint(&mut self, canvas: &mut Canvas) {
        if self.has_depth {
            self.order.sort_by(|p, q| q.depth.total_cmp(&p.depth));
        }
        for entry in &self.order {
            match entry.shape {
                Shape::Disc(index) => canvas.disc(self.discs[index as usize]),
                Shape::Line(index) => canvas.line(self.lines[index as usize]),
            }
        }
        self.discs.clear();
        self.lines.clear();
        self.order.clear();
        self.has_depth = false;
    }

    fn add(&mut self, depth: f32, shape: Shape) {
        self.has_depth |= depth != 0.0;
        self.order.push(Entry { depth, shape });
    }
}
