//! Parameters of a wave, read from its item and checked.

use super::absorbing::{self, AbsorptionParameters};
use crate::error::Result;
use crate::grid::{EdgeCells, EdgeValues, Edges, Grid, Padding, RowTable};
use crate::integrators::Facts;
use crate::scene::{Item, Value};

/// Parameters of a wave, without its sources and its initial state.
#[derive(Debug)]
pub struct Parameters {
    /// Grid of all cells, including layers; all fields have a value for each.
    pub grid: Grid,
    /// Position of the user's grid within all cells.
    pub padding: Padding,
    pub absorption: Option<AbsorptionParameters>,
    pub edges: Edges,
    /// Speed c [m/s].
    pub speed: RowTable<f64>,
    /// Damping γ [1/s].
    pub damping: RowTable<f64>,
    /// Largest density ρ [kg/m^D].
    pub density: f64,
    /// Density relative to the largest one; None if it is uniform.
    pub relative_density: Option<RowTable<f64>>,
    /// Mask of wall cells, which are cut out.
    pub walls: Option<Vec<bool>>,
    /// Order of the differences: 2 or 4.
    pub order: u32,
}

impl Parameters {
    /// Reads the parameters that an item declares.
    ///
    /// # Errors
    /// If a value is missing or out of range.
    pub fn declared(item: &Item, method: &Facts) -> Result<Self> {
        let grid = Grid::declared(item)?;
        let edges = Edges::declared(item, "edges", &grid)?;
        let absorption = AbsorptionParameters::declared(item, edges, method)?;
        let padding = Padding::new(&grid, absorbing::layers(edges, absorption));
        let densities = grid.non_negative_field(item, "density")?;
        let (least, density) =
            densities.different().iter().fold((f64::INFINITY, 0.0_f64), |(least, most), &each| (least.min(each), most.max(each)));
        if least == 0.0 {
            return Err(item.wrong("density", "a number > 0", Some(&Value::Number(0.0))));
        }
        let relative = || {
            let densities = padding.extend(&densities);
            RowTable::new(padding.outer.rows(), padding.outer.row_length(), 0.0, |row, values| {
                values.iter_mut().zip(densities.row(row)).for_each(|(value, &each)| *value = each / density);
            })
        };
        let order = match item.number("order")? {
            2.0 => 2,
            4.0 => 4,
            _ => return Err(item.wrong("order", "2 or 4", item.values.get("order"))),
        };
        if order == 4 && absorption.is_some() {
            return Err(item.wrong("order", "2 beside absorbing edges", item.values.get("order")));
        }
        let walls = grid.mask(item, "walls")?.filter(|walls| walls.contains(&true));
        Ok(Self {
            speed: padding.extend(&grid.non_negative_field(item, "speed")?),
            damping: padding.extend(&grid.non_negative_field(item, "damping")?),
            walls: walls.map(|walls| (0..padding.outer.count()).map(|cell| walls[padding.nearest(cell)]).collect()),
            density,
            relative_density: (least < density).then(relative),
            order,
            edges,
            absorption,
            grid: padding.outer.clone(),
            padding,
        })
    }

    /// Reads the values at the edges.
    ///
    /// # Errors
    /// If a value is of the wrong shape or not finite, or the differences are of order 4. These would need the second derivative
    /// of the value in time.
    pub fn edge_values(&self, item: &Item) -> Result<EdgeValues> {
        let length = self.grid.row_length();
        let of = |row: usize, column: usize| {
            let wall = self.walls.as_ref().is_some_and(|walls| walls[row * length + column]);
            if wall { 0.0 } else { (self.speed.row(row)[column] / self.grid.spacing).powi(2) }
        };
        let cells = EdgeCells { padding: &self.padding, edges: self.edges, of: &of, all: false, first: 0 };
        let edges = EdgeValues::declared(item, "edges", &cells)?;
        if self.order == 4 && !edges.is_empty() {
            return Err(item.wrong("order", "2 beside edges with values", item.values.get("order")));
        }
        Ok(edges)
    }
}
