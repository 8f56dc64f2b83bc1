//! Reaction–diffusion systems as items.

use std::sync::Arc;

use physcore_base::math::noise;
use physcore_base::scene::{Argument, Array, Callback, Failure, Item, Value};

use super::grids::{grid, on_edges};

/// Pseudorandom value between 0 and 1 for each cell.
pub fn random(index: usize) -> f64 {
    0.5 + 0.5 * noise(index as u64).x
}

/// Builds an item of numbers.
pub fn numbers(kind: &str, values: &[(&'static str, f64)]) -> Item {
    Item::new(kind, values.iter().map(|&(name, number)| (name, Value::Number(number))))
}

/// Gray–Scott kinetics.
pub fn gray_scott() -> Item {
    numbers("GrayScott", &[("feed", 0.035), ("kill", 0.0625)])
}

/// Kinetics without reactions where v = 0.
pub fn inert() -> Item {
    numbers("GrayScott", &[("feed", 0.0), ("kill", 0.0)])
}

/// Builds a field of this shape from a function of the cell's index.
pub fn field(cells: &[usize], of: impl Fn(usize) -> f64) -> Value {
    Value::Numbers(Array { shape: cells.to_vec(), entries: (0..cells.iter().product()).map(of).collect() })
}

/// Builds a reaction–diffusion system on a grid of spacing 1.
pub fn dish(cells: &[usize], edges: &[&str], reaction: Item, species: [(&'static str, f64, Value); 2]) -> Item {
    let diffusion = numbers("", &species.each_ref().map(|(name, rate, _)| (*name, *rate)));
    let initial = Item::new("", species.map(|(name, _, value)| (name, value)));
    let values = [("grid", grid(cells, 1.0, edges)), ("reaction", reaction), ("diffusion", diffusion), ("initial", initial)];
    let mut item = Item::new("ReactionDiffusion", values.map(|(name, inner)| (name, Value::Record(Box::new(inner)))));
    "systems[0]".clone_into(&mut item.path);
    item.values.insert("edges".to_owned(), on_edges(edges));
    item
}

/// Builds a reaction–diffusion system with random values and diffusivities of 0.2 and 0.1.
pub fn noisy(cells: &[usize], edges: &[&str], reaction: Item) -> Item {
    let species = [("u", 0.2, field(cells, random)), ("v", 0.1, field(cells, |index| 0.5 * random(index + 1_000_000)))];
    dish(cells, edges, reaction, species)
}

/// Function of two species.
pub struct SpeciesFunction(pub fn(f64, f64) -> [f64; 2]);

impl Callback for SpeciesFunction {
    fn call(&self, arguments: &[Argument<'_>], _what: &str, shape: &[usize]) -> std::result::Result<Vec<f64>, Failure> {
        let &[Argument::Array { numbers: us, .. }, Argument::Array { numbers: vs, .. }] = arguments else {
            let (found, hint) = (format!("{arguments:?}"), String::new());
            return Err(Failure::Refused { expected: "two arrays".to_owned(), found, hint });
        };
        assert_eq!(shape[0], 2);
        let rates: Vec<_> = us.iter().zip(vs).map(|(&u, &v)| self.0(u, v)).collect();
        Ok([0, 1].iter().flat_map(|&species| rates.iter().map(move |rates| rates[species])).collect())
    }
}

/// Kinetics by a function.
pub fn reaction(species: [&str; 2], function: fn(f64, f64) -> [f64; 2]) -> Item {
    let mut item = Item::new("Reaction", [("species", Value::Texts(species.map(str::to_owned).to_vec()))]);
    item.values.insert("function".to_owned(), Value::Callback(Arc::new(SpeciesFunction(function))));
    item
}
