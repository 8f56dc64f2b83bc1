//! Broad phase: pairs of overlapping boxes.
//!
//! Space is cut into columns along x. The boxes of a column are swept in the order of their lower ends. Boxes that would cover
//! many columns, and infinite ones, are compared with all others.

use crate::shapes::BoundingBox;

/// Largest number of columns of a box along y or z.
const WIDEST: f64 = 4.0;
/// Number of columns along an axis that are too few to cut it.
const FEW: f64 = 3.0;
/// Largest number of columns along y or z.
const COLUMNS: f64 = 1e6;

/// Box in a column.
#[derive(Debug, Clone, Copy)]
struct BroadEntry {
    column: [u32; 2],
    start: f64,
    index: u32,
}

/// Columns of equal width along y and z; a single one along an axis that few would cut.
struct BroadColumns {
    lower: [f64; 2],
    width: f64,
    is_cut: [bool; 2],
}

impl BroadColumns {
    /// Columns of twice the mean size of the boxes.
    fn new(bounds: &[BoundingBox]) -> Self {
        let (mut lower, mut upper, mut sum, mut count) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2], 0.0, 0.0_f64);
        for one in bounds.iter().filter(|one| one.is_finite()) {
            for axis in [0, 1] {
                lower[axis] = lower[axis].min(one.lower[axis + 1]);
                upper[axis] = upper[axis].max(one.upper[axis + 1]);
            }
            let size = one.upper - one.lower;
            sum += size.y.max(size.z);
            count += 1.0;
        }
        let extents = [0, 1].map(|axis| upper[axis] - lower[axis]);
        let width = (2.0 * sum / count.max(1.0)).max(extents[0].max(extents[1]) / COLUMNS);
        Self { lower, width, is_cut: extents.map(|extent| width > 0.0 && extent > FEW * width) }
    }

    fn place(&self, axis: usize, coordinate: f64) -> u32 {
        if self.is_cut[axis] { ((coordinate - self.lower[axis]) / self.width) as u32 } else { 0 }
    }

    /// First and last column of a box along y and z.
    fn range(&self, one: &BoundingBox) -> [[u32; 2]; 2] {
        [0, 1].map(|axis| [one.lower, one.upper].map(|corner| self.place(axis, corner[axis + 1])))
    }

    /// Whether a box is infinite or would cover many columns.
    fn is_wide(&self, one: &BoundingBox) -> bool {
        let size = one.upper - one.lower;
        !one.is_finite() || [size.y, size.z].iter().zip(self.is_cut).any(|(size, cut)| cut && *size > WIDEST * self.width)
    }
}

/// Replaces `pairs` by all pairs i < j of overlapping boxes of which at least one moves, in ascending order.
pub fn pairs(bounds: &[BoundingBox], moves: &[bool], pairs: &mut Vec<[u32; 2]>) {
    pairs.clear();
    let columns = BroadColumns::new(bounds);
    let (mut entries, mut wide) = (Vec::with_capacity(2 * bounds.len()), Vec::new());
    for (index, one) in (0..).zip(bounds) {
        if columns.is_wide(one) {
            wide.push(index);
            continue;
        }
        let [[y0, y1], [z0, z1]] = columns.range(one);
        for y in y0..=y1 {
            entries.extend((z0..=z1).map(|z| BroadEntry { column: [y, z], start: one.lower.x, index }));
        }
    }
    let mut meet = |one: u32, other: u32| {
        let [a, b] = [one, other].map(|index| index as usize);
        if (moves[a] || moves[b]) && bounds[a].overlaps(&bounds[b]) {
            pairs.push([one.min(other), one.max(other)]);
        }
    };
    entries.sort_unstable_by(|a, b| a.column.cmp(&b.column).then(a.start.total_cmp(&b.start)).then(a.index.cmp(&b.index)));
    for (place, one) in entries.iter().enumerate() {
        let end = bounds[one.index as usize].upper.x;
        let beside = entries[place + 1..].iter().take_while(|other| other.column == one.column && other.start <= end);
        for other in beside {
            // Of all columns that two boxes share, the one of the lower corner of their intersection.
            let [a, b] = [one, other].map(|entry| bounds[entry.index as usize].lower);
            if [0, 1].map(|axis| columns.place(axis, a[axis + 1].max(b[axis + 1]))) == one.column {
                meet(one.index, other.index);
            }
        }
    }
    let mut is_wide = vec![false; bounds.len()];
    for &one in &wide {
        is_wide[one as usize] = true;
    }
    for &one in &wide {
        for other in 0..bounds.len() as u32 {
            // Two wide boxes meet once.
            if one < other || !is_wide[other as usize] {
                meet(one, other);
            }
        }
    }
    pairs.sort_unstable();
}
