//! Parameters of a wave, read from its item and checked.

use super::absorbing::{self, AbsorptionParameters};
use crate::error::Result;
use crate::grid::{Edges, Grid, Padding, RowTable};
use crate::integrators::Facts;
use crate::scene::Item;

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
    /// Density ρ [kg/m^D].
    pub density: f64,
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
        let edges = Edges::declared(item, &grid)?;
        let absorption = AbsorptionParameters::declared(item, edges, method)?;
        let padding = Padding::new(&grid, absorbing::layers(edges, absorption));
        let density = item.non_negative("density")?;
        if density == 0.0 {
            return Err(item.wrong("density", "a number > 0", item.values.get("density")));
        }
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
            order,
            edges,
            absorption,
            grid: padding.outer.clone(),
            padding,
        })
    }
}
