//! Spray: drops of a liquid in 3D with few neighbors. They are smaller than those inside, and a clear liquid is white there.

use super::Drop;

/// Distance to which neighbors are counted, over the support of a drop. Inside a liquid there are 50, in a sheet of one layer 16.
const REACH: f32 = 2.0;
/// Number of neighbors of a drop from which on it belongs to the liquid, and up to which it is alone.
const CROWD: [f32; 2] = [10.0, 2.0];
/// Radius of a single drop, over that of a drop inside.
const SMALLER: f32 = 0.55;
/// Color of foam, and its opacity over that of milk.
const FOAM: [f32; 4] = [238.0, 243.0, 248.0, 200.0];

/// Makes the drops with few neighbors spray. Depths are in pixels.
pub(super) fn spray(drops: &mut [Drop]) {
    let widest = drops.iter().map(|drop| drop.radius).fold(0.0, f32::max);
    let cells = Cells::new(drops, REACH * widest);
    let alone: Vec<f32> = drops.iter().map(|drop| alone(drop, drops, &cells)).collect();
    for (drop, share) in drops.iter_mut().zip(alone) {
        drop.radius *= 1.0 - (1.0 - SMALLER) * share;
        let clear = 1.0 - f32::from(drop.color[3]) / 255.0;
        for (channel, foam) in drop.color.iter_mut().zip(FOAM) {
            *channel = (f32::from(*channel) + (foam - f32::from(*channel)).max(0.0) * share * clear) as u8;
        }
    }
}

/// Whether a drop is alone: 1 without neighbors, 0 in a crowd.
fn alone(drop: &Drop, drops: &[Drop], cells: &Cells) -> f32 {
    let square = (REACH * drop.radius).powi(2);
    let near = |other: &Drop| {
        let apart = [other.center[0] - drop.center[0], other.center[1] - drop.center[1], other.depth - drop.depth];
        apart.into_iter().map(|way| way * way).sum::<f32>() < square
    };
    // No more than a crowd is counted, and the drop itself.
    let count = cells.around(drop).filter(|&index| near(&drops[index])).take(CROWD[0] as usize + 1).count().saturating_sub(1);
    ((CROWD[0] - count as f32) / (CROWD[0] - CROWD[1])).clamp(0.0, 1.0)
}

/// Drops sorted by cubic cells.
struct Cells {
    size: f32,
    /// Cell and index of each drop, in order.
    sorted: Vec<([i32; 3], usize)>,
}

impl Cells {
    fn new(drops: &[Drop], size: f32) -> Self {
        let mut sorted: Vec<_> = drops.iter().enumerate().map(|(index, drop)| (cell(drop, size), index)).collect();
        sorted.sort_unstable();
        Self { size, sorted }
    }

    /// Indices of the drops in the cell of a drop and the cells beside it.
    fn around(&self, drop: &Drop) -> impl Iterator<Item = usize> {
        let [x, y, z] = cell(drop, self.size);
        let columns = (-1..=1).flat_map(move |dx| (-1..=1).map(move |dy| [x.saturating_add(dx), y.saturating_add(dy)]));
        columns.flat_map(move |[x, y]| {
            let from = self.sorted.partition_point(|(cell, _)| *cell < [x, y, z.saturating_sub(1)]);
            let last = [x, y, z.saturating_add(1)];
            self.sorted[from..].iter().take_while(move |(cell, _)| *cell <= last).map(|&(_, index)| index)
        })
    }
}

/// Cell of a drop.
fn cell(drop: &Drop, size: f32) -> [i32; 3] {
    [drop.center[0], drop.center[1], drop.depth].map(|place| (place / size).floor() as i32)
}
