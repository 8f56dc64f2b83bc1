//! Cell grid of the neighbor search.
//!
//! Space is divided into cells with the size of one support, or a fraction of it along x. They are mapped to a periodic table of
//! buckets: along each axis, cell c is in bucket c modulo the number of buckets. If the table spans all particles, it is a plain
//! grid. If that would take too much memory, a bucket holds several cells. These are far from each other, so that the distance
//! test separates them.
//!
//! In both cases the buckets of neighboring cells are neighbors and distinct. A periodic axis needs no special case, because its
//! number of cells is a multiple of its number of buckets.

use std::ops::Range;

use crate::math::AXES;

/// Relative excess of the cell size over the support, above the rounding error of a coordinate; see [`super`].
const MARGIN: f64 = 1e-6;

/// Cells per support along x, if the table has room for them. Finer cells give fewer candidates.
const FINE: u32 = 4;

/// Maximum number of buckets per particle.
const BUCKETS: usize = 2;

/// Maximum number of rows in the neighborhood of a bucket.
const ROWS: usize = 9;

/// Maximum number of runs of candidates. A row is cut where it wraps around the table, at its beginning or its end.
const RUNS: usize = 2 * ROWS;

/// Maximum number of buckets.
const MOST: usize = 1 << 30;

/// Relative excess of the searched interval over the support, for the rounding of the fractions of cells.
const TRIM: f64 = 1e-5;

/// Bounding box of particles.
#[derive(Debug, Clone, Copy)]
pub struct Bounds {
    /// Lowest coordinate along each axis [m].
    pub low: [f64; AXES],
    /// Highest coordinate along each axis [m].
    pub high: [f64; AXES],
}

impl Bounds {
    /// Empty box.
    pub const EMPTY: Self = Self { low: [f64::INFINITY; AXES], high: [f64::NEG_INFINITY; AXES] };

    /// Distance of a point from the box [m].
    #[inline]
    pub fn distance(&self, point: [f64; AXES]) -> f64 {
        let gap = |axis: usize| (self.low[axis] - point[axis]).max(point[axis] - self.high[axis]).max(0.0);
        (0..AXES).map(|axis| gap(axis).powi(2)).sum::<f64>().sqrt()
    }

    /// Union of both boxes.
    #[must_use]
    #[inline]
    pub fn with(self, other: &Self) -> Self {
        Self {
            low: std::array::from_fn(|axis| self.low[axis].min(other.low[axis])),
            high: std::array::from_fn(|axis| self.high[axis].max(other.high[axis])),
        }
    }
}

/// One axis of the table.
#[derive(Debug, Clone, Copy)]
struct BucketAxis {
    /// Lower end of cell 0 [m].
    low: f64,
    /// Cells per meter [1/m].
    inverse: f64,
    /// Size of a cell [m].
    size: f64,
    /// Number of buckets.
    buckets: u32,
    /// Range of a neighbor in cells, in both directions.
    reach: u32,
}

impl BucketAxis {
    /// An axis past the dimension.
    const NONE: Self = Self { low: 0.0, inverse: 0.0, size: 0.0, buckets: 1, reach: 0 };

    /// Bucket of a coordinate.
    #[inline(always)]
    fn bucket(&self, coordinate: f64) -> u32 {
        let cell = ((coordinate - self.low) * self.inverse).floor();
        // The result is exact, because a quotient of integers below 2⁵³ is never rounded up to an integer.
        let buckets = f64::from(self.buckets);
        (cell - buckets * (cell / buckets).floor()) as u32
    }

    /// Offset of a coordinate in its cell, as a fraction of the cell.
    #[inline(always)]
    fn fraction(&self, coordinate: f64) -> f64 {
        let cells = (coordinate - self.low) * self.inverse;
        cells - cells.floor()
    }

    /// Buckets of all cells within range of a cell: the first bucket, and their number around the table.
    #[inline(always)]
    fn neighborhood(&self, bucket: u32) -> (u32, u32) {
        let number = (2 * self.reach + 1).min(self.buckets);
        if number < 2 * self.reach + 1 { (0, number) } else { ((bucket + self.buckets - self.reach) % self.buckets, number) }
    }

    /// Squared distances from a coordinate to the cells before, at and after its own [m²]. All are 0 if the table is so short
    /// that all cells are searched.
    #[inline(always)]
    fn gaps(&self, coordinate: f64) -> [f64; 3] {
        if self.buckets < 2 * self.reach + 1 || self.reach == 0 {
            return [0.0; 3];
        }
        let fraction = self.fraction(coordinate);
        [fraction, 0.0, 1.0 - fraction].map(|gap| (gap * self.size) * (gap * self.size))
    }
}

/// Table of buckets.
#[derive(Debug, Clone, Copy)]
pub struct BucketGrid {
    axes: [BucketAxis; AXES],
}

/// Rows of buckets that contain all neighbors of the particles of one bucket.
#[derive(Debug, Clone, Copy)]
pub struct BucketRows {
    /// First bucket of each row, and the indices of its gaps along y and z.
    starts: [(u32, usize, usize); ROWS],
    count: usize,
    /// Column of the bucket.
    column: u32,
}

impl BucketRows {
    /// No rows.
    pub const NONE: Self = Self { starts: [(0, 0, 0); ROWS], count: 0, column: 0 };
}

/// Runs of consecutive slots.
#[derive(Debug, Clone, Copy)]
pub struct Runs {
    /// Start and end of each run.
    ends: [(u32, u32); RUNS],
    count: usize,
}

impl Runs {
    /// No runs.
    pub const NONE: Self = Self { ends: [(0, 0); RUNS], count: 0 };

    /// Iterates over the runs.
    #[inline(always)]
    pub fn iter(&self) -> impl Iterator<Item = Range<usize>> {
        self.ends[..self.count].iter().map(|&(start, end)| start as usize..end as usize)
    }

    #[inline(always)]
    fn push(&mut self, start: u32, end: u32) {
        if start < end {
            self.ends[self.count] = (start, end);
            self.count += 1;
        }
    }
}

impl BucketGrid {
    /// A table without buckets.
    pub const NONE: Self = Self { axes: [BucketAxis::NONE; AXES] };

    /// Builds the table for `count` particles.
    pub fn new(count: usize, dimension: usize, periods: &[Option<(f64, f64)>; AXES], support: f64, bounds: &Bounds) -> Self {
        let room = (BUCKETS * count).clamp(64, MOST) as f64;
        let size = support * (1.0 + MARGIN);
        let wanted = |fine: u32| {
            let mut wanted = [1.0; AXES];
            for axis in 0..dimension {
                let reach = if axis == 0 { fine } else { 1 };
                let inverse = f64::from(reach) / size;
                wanted[axis] = match periods[axis] {
                    Some((lower, upper)) => ((upper - lower) * inverse).floor().max(1.0),
                    // Empty cells at the end separate the first cells from the last ones around the table.
                    None => ((bounds.high[axis] - bounds.low[axis]).max(0.0) * inverse).floor() + 1.0 + f64::from(reach),
                };
            }
            wanted
        };
        let mut fine = FINE;
        if wanted(fine).iter().product::<f64>() > room {
            fine = 1;
        }
        let cells = wanted(fine);
        let buckets = fit(cells, room);
        let axis = |axis: usize| {
            let reach = if axis == 0 { fine } else { 1 };
            let (low, inverse) = match periods[axis] {
                Some((lower, upper)) => {
                    let rounds = (cells[axis] / f64::from(buckets[axis])).floor();
                    (lower, rounds * f64::from(buckets[axis]) / (upper - lower))
                }
                None => (bounds.low[axis], f64::from(reach) / size),
            };
            BucketAxis { low, inverse, size: 1.0 / inverse, buckets: buckets[axis], reach }
        };
        Self { axes: std::array::from_fn(|index| if index < dimension { axis(index) } else { BucketAxis::NONE }) }
    }

    /// Number of buckets.
    #[inline]
    pub fn buckets(&self) -> usize {
        self.axes.iter().map(|axis| axis.buckets as usize).product()
    }

    /// Bucket of a point; one past the last for a point that is not finite.
    #[inline(always)]
    pub fn bucket(&self, point: [f64; AXES]) -> u32 {
        let [x, y, z] = self.axes;
        if point.iter().all(|coordinate| coordinate.is_finite()) {
            (z.bucket(point[2]) * y.buckets + y.bucket(point[1])) * x.buckets + x.bucket(point[0])
        } else {
            self.buckets() as u32
        }
    }

    /// Rows around a bucket.
    #[inline(always)]
    pub fn rows(&self, bucket: u32) -> BucketRows {
        let [x, y, z] = self.axes;
        let row = bucket / x.buckets;
        let (first_y, number_y) = y.neighborhood(row % y.buckets);
        let (first_z, number_z) = z.neighborhood(row / y.buckets);
        let mut rows = BucketRows { column: bucket % x.buckets, ..BucketRows::NONE };
        for layer in 0..number_z {
            for line in 0..number_y {
                let row = (first_z + layer) % z.buckets * y.buckets + (first_y + line) % y.buckets;
                rows.starts[rows.count] = (row * x.buckets, line as usize, layer as usize);
                rows.count += 1;
            }
        }
        rows
    }

    /// Finds the runs of slots that contain all neighbors of a point within a distance of the given `square` [m²]. The first slot
    /// of each bucket is in `starts`.
    #[inline(always)]
    pub fn runs(&self, rows: &BucketRows, point: [f64; AXES], square: f64, starts: &[u32], runs: &mut Runs) {
        runs.count = 0;
        let [x, y, z] = self.axes;
        let (gaps_y, gaps_z) = (y.gaps(point[1]), z.gaps(point[2]));
        let fraction = x.fraction(point[0]);
        let whole = 2 * x.reach + 1 >= x.buckets;
        for &(row, line, layer) in &rows.starts[..rows.count] {
            let left = square * (1.0 + 2.0 * TRIM) - gaps_y[line] - gaps_z[layer];
            if left < 0.0 {
                continue;
            }
            let half = left.sqrt() * x.inverse + TRIM;
            // Both column numbers are at least 0, because they are columns of a table shifted by one period.
            let column = f64::from(rows.column + x.buckets) + fraction;
            let (first, last) =
                if whole { (x.buckets, 2 * x.buckets - 1) } else { ((column - half) as u32, (column + half) as u32) };
            let start = |column: u32| starts[(row + column) as usize];
            // Runs in the period before, in the table itself, and in the period after.
            if first < x.buckets {
                runs.push(start(first), start(x.buckets.min(last + 1)));
            }
            if last >= x.buckets {
                runs.push(start(first.max(x.buckets) - x.buckets), start((last + 1).min(2 * x.buckets) - x.buckets));
            }
            if last >= 2 * x.buckets {
                runs.push(start(0), start(last + 1 - 2 * x.buckets));
            }
        }
    }
}

/// Number of buckets per axis: the number of cells, or fewer on the longest axes, within `room` in total.
fn fit(cells: [f64; AXES], mut room: f64) -> [u32; AXES] {
    let mut axes: [usize; AXES] = std::array::from_fn(|axis| axis);
    axes.sort_by(|&one, &other| cells[one].total_cmp(&cells[other]));
    let mut buckets = [1; AXES];
    for (done, axis) in axes.into_iter().enumerate() {
        let share = libm::pow(room, 1.0 / (AXES - done) as f64).floor().max(1.0);
        buckets[axis] = if cells[axis] <= share { cells[axis] as u32 } else { round_table(share as u32) };
        room /= f64::from(buckets[axis]);
    }
    buckets
}

/// Largest number up to `most` that is coprime to 10. Otherwise particles in a regular pattern would often collide in a few
/// buckets.
fn round_table(most: u32) -> u32 {
    (1..=most).rev().find(|number| number % 2 != 0 && number % 5 != 0).unwrap_or(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_bounded_by_the_particles() {
        for count in [0, 1, 10, 1000] {
            for extent in [0.0, 1.0, 30.0, 1e4, 4e8] {
                for shape in [[1.0, 1.0, 1.0], [1.0, 0.0, 1e-3], [1e-2, 1e-5, 1.0]] {
                    for periods in [[None; AXES], [None, Some((0.0, 2.5)), Some((-1e5, 1e5))]] {
                        let bounds = Bounds { low: [0.0; AXES], high: shape.map(|side| side * extent) };
                        let grid = BucketGrid::new(count, 3, &periods, 1.0, &bounds);
                        assert!(grid.buckets() <= (BUCKETS * count).max(64), "{} for {count}", grid.buckets());
                        let corners = [bounds.low, bounds.high].map(|corner| grid.bucket(corner) as usize);
                        assert!(corners.iter().all(|&bucket| bucket < grid.buckets()));
                    }
                }
            }
        }
    }
}
