//! Absorbing edges: a convolutional perfectly matched layer (CPML).
//!
//! In a layer normal to the axis a, ∂ₐ is divided by 1 + ζ/s in Laplace space. With memory variables p at faces and q at centers,
//!
//! ```text
//!     u'' = Σₐ [∂ₐ (c² (∂ₐ u + p)) + q],   p' = −ζ (p + ∂ₐ u),   q' = −ζ (q + ∂ₐ (c² (∂ₐ u + p)))
//! ```
//!
//! Nothing is reflected at any angle, apart from discretization errors and waves that return from the free outer end. These are
//! damped to R = exp(−2 ∫ζ dx / c) at normal incidence; ζ grows with the square of the depth.
//!
//! A kick advances p and q with their means over it, as in the Crank–Nicolson method. Since p follows from u, and q from p, no
//! equations have to be solved. Steps up to the limit without a layer stay stable. Runge–Kutta methods use p and q at the stage.
//!
//! Source: D. Komatitsch, R. Martin, Geophysics 72 (2007) SM155; R. Martin, D. Komatitsch, S. D. Gedney, CMES 37 (2008) 274.

use std::ops::Range;

use super::medium::Medium;
use super::stage::{BufferedStage, Input, WaveStageAction};
use super::state::{WaveCells, fill, register};
use crate::error::{Error, Result};
use crate::grid::{Edge, Edges, Padding};
use crate::history::Archive;
use crate::integrators::REGISTERS;
use crate::integrators::{Component, Facts};
use crate::math::{AXES, Real};
use crate::memory;
use crate::scene::{Item, Value};

/// Default width of a layer [cells].
const WIDTH: usize = 20;

/// Requested width [cells] and reflection of the layers.
#[derive(Debug, Clone, Copy)]
pub struct AbsorptionParameters {
    pub width: usize,
    pub reflection: f64,
}

impl AbsorptionParameters {
    /// Reads the absorption that an item declares, if an edge absorbs.
    ///
    /// # Errors
    /// If a value is missing or out of range, or the integrator runs backwards in some of its substeps.
    pub fn declared(item: &Item, edges: Edges, method: &Facts) -> Result<Option<Self>> {
        if !edges.any(Edge::Absorbing) {
            return Ok(None);
        }
        if runs_backwards(method) {
            let fits = |other: &Facts| !runs_backwards(other) && !other.gyrates;
            let known: Vec<_> = Facts::all().iter().filter(|other| fits(other)).map(|other| other.name).collect();
            let expected = format!("one without negative substeps beside absorbing edges: {}", known.join(", "));
            return Err(Error::parameter("integrator", expected, method.name));
        }
        let item = item.record("absorbing")?;
        let width = match item.values.get("cells") {
            Some(Value::Text(word)) if word == "auto" => WIDTH,
            Some(Value::Number(cells)) if *cells >= 1.0 && *cells <= 1e4 && cells.fract() == 0.0 => *cells as usize,
            other => return Err(item.wrong("cells", "a whole number from 1 to 10000 or \"auto\"", other)),
        };
        match item.number("reflection")? {
            reflection if reflection > 0.0 && reflection < 1.0 => Ok(Some(Self { width, reflection })),
            reflection => Err(item.wrong("reflection", "a number between 0 and 1", Some(&Value::Number(reflection)))),
        }
    }

    /// Damping ζ at a depth [cells] in a medium of this speed [1/s].
    fn damping(self, depth: f64, speed: f64, spacing: f64) -> f64 {
        let width = self.width as f64;
        let profile = -1.5 * libm::log(self.reflection) / (width * spacing);
        profile * speed * (depth / width).powi(2)
    }

    /// Amplitude that the layer returns at normal incidence, for waves of `k` per spacing. The differences themselves reflect
    /// nothing. The stationary equation is solved inward from the free outer end, where no flux leaves.
    pub fn returned(self, k: f64) -> f64 {
        let product = |[a, b]: [f64; 2], [c, d]: [f64; 2]| [a * c - b * d, a * d + b * c];
        let frequency = 2.0 * libm::sin(0.5 * k);
        let stretch = |depth: f64| [1.0, -self.damping(depth, 1.0, 1.0) / frequency];
        let (mut value, mut flux) = ([1.0, 0.0], [0.0; 2]);
        let mut inside = value;
        for cell in (0..=self.width).rev() {
            let depth = (cell as f64 - 0.5).max(0.0);
            let source = product(stretch(depth), value);
            flux = [0, 1].map(|part| flux[part] + frequency * frequency * source[part]);
            let drop = product(stretch((cell as f64 - 1.0).max(0.0)), flux);
            inside = value;
            value = [0, 1].map(|part| value[part] - drop[part]);
        }
        let part = |sign: f64| {
            let turned = product(inside, [libm::cos(k), sign * libm::sin(k)]);
            libm::hypot(value[0] - turned[0], value[1] - turned[1])
        };
        part(1.0) / part(-1.0)
    }
}

/// Whether some substeps are negative.
fn runs_backwards(method: &Facts) -> bool {
    method.drift_kick.is_some() && method.refuses_fields.is_some()
}

/// Number of cells added at each edge.
pub fn layers(edges: Edges, absorption: Option<AbsorptionParameters>) -> [[usize; 2]; AXES] {
    let width = absorption.map_or(0, |absorption| absorption.width);
    edges.0.map(|pair| pair.map(|edge| if edge == Edge::Absorbing { width } else { 0 }))
}

/// Cell in a layer of one axis, with its inner face.
#[derive(Debug, Clone, Copy)]
struct Site<T> {
    cell: u32,
    /// Next cell inward.
    inner: u32,
    /// Site of the next cell outward; the site itself if there is none.
    outward: u32,
    /// Coefficient w at the inner face [1/s²].
    weight: T,
    /// Damping ζ at the inner face and at the center [1/s].
    face: T,
    center: T,
}

/// Face between the user's grid and a layer: inner cell, outer cell, and mass times w [kg/s²].
#[derive(Debug, Clone, Copy)]
struct Meter {
    inside: u32,
    outside: u32,
    weight: f64,
}

/// All layers, with their memory variables: p of all sites, then q.
#[derive(Debug)]
pub struct Layers<T> {
    sites: Vec<Site<T>>,
    /// Index at which the sites of each row begin.
    rows: Vec<usize>,
    meters: Vec<Meter>,
    /// Index at which the meters of each row begin.
    metered: Vec<usize>,
    memory: MemoryVariables<T>,
    saved: MemoryVariables<T>,
    /// Registers that do not persist, rates p' and q', and means over a kick.
    registers: Vec<Vec<T>>,
    rates: Vec<T>,
    means: Vec<T>,
    /// Contributions of the sites to the accelerations of their cells.
    forces: Vec<T>,
    /// Placeholder for displacements, which p and q do not have.
    blank: Vec<T>,
    /// Largest ζ [1/s].
    pub steepest: f64,
}

/// Memory variables p and q with the persistent registers of the integrator.
#[derive(Debug, Clone)]
struct MemoryVariables<T> {
    values: Vec<T>,
    persistent: Vec<Vec<T>>,
}

impl<T: Real> Layers<T> {
    /// Memory of the layers, with that during their construction [bytes].
    fn footprint(padding: &Padding, method: &Facts) -> usize {
        let outside = |axis: usize| padding.outer.cells[axis] - padding.inside(axis).len();
        let sites: usize = (0..AXES).map(|axis| outside(axis) * (padding.outer.count() / padding.outer.cells[axis])).sum();
        // Values, their copy, registers, rates and means of p and q; then the sites, twice, and the forces.
        let columns = 2 * (2 + 2 * method.persistent + (method.registers - method.persistent) + 3);
        sites * ((columns + 1) * size_of::<T>() + 2 * size_of::<(u32, usize, Site<T>, bool)>())
    }

    /// Builds the layers around a grid in a medium.
    ///
    /// # Errors
    /// If they do not fit into memory.
    pub fn new(
        padding: &Padding,
        medium: &Medium<T>,
        absorption: AbsorptionParameters,
        speed: impl Fn(usize) -> f64,
        mass: f64,
        method: &Facts,
    ) -> Result<Self> {
        memory::check("the absorbing layers", Self::footprint(padding, method), 0, || {
            "thinner ones, or a coarser grid".to_owned()
        })?;
        let outer = &padding.outer;
        let (length, width) = (outer.row_length(), absorption.width);
        let strides = [outer.cells[1] * length, length, 1];
        let mut found: Vec<(u32, usize, Site<T>, bool)> = Vec::new();
        let mut steepest = 0.0_f64;
        for cell in 0..outer.count() {
            let row = cell / length;
            let place = outer.place(row);
            let place = [place[0], place[1], cell % length];
            for axis in outer.axes() {
                let inside = padding.inside(axis);
                if inside.contains(&place[axis]) {
                    continue;
                }
                let lower = place[axis] < inside.start;
                let depth = if lower { inside.start - 1 - place[axis] } else { place[axis] - inside.end };
                let (inner, below) =
                    if lower { (cell + strides[axis], cell) } else { (cell - strides[axis], cell - strides[axis]) };
                let zeta = |depth: f64| absorption.damping(depth, speed(cell), outer.spacing);
                steepest = steepest.max(zeta(depth as f64 + 0.5));
                let site = Site {
                    cell: cell as u32,
                    inner: inner as u32,
                    outward: if depth + 1 < width {
                        (if lower { cell - strides[axis] } else { cell + strides[axis] }) as u32
                    } else {
                        u32::MAX
                    },
                    weight: medium.laplacian.faces[axis].row(below / length)[below % length],
                    face: T::from_f64(zeta(depth as f64)),
                    center: T::from_f64(zeta(depth as f64 + 0.5)),
                };
                let crosses = depth == 0 && (0..AXES).all(|other| other == axis || padding.inside(other).contains(&place[other]));
                found.push((cell as u32, axis, site, crosses));
            }
        }
        let index = |cell: u32, axis: usize| found.binary_search_by_key(&(cell, axis), |&(cell, axis, ..)| (cell, axis)).ok();
        let sites: Vec<Site<T>> = found
            .iter()
            .enumerate()
            .map(|(own, &(_, axis, site, _))| Site { outward: index(site.outward, axis).unwrap_or(own) as u32, ..site })
            .collect();
        let mut meters: Vec<Meter> = found
            .iter()
            .filter(|(.., crosses)| *crosses)
            .map(|(.., site, _)| Meter { inside: site.inner, outside: site.cell, weight: mass * site.weight.to_f64() })
            .collect();
        meters.sort_by_key(|meter| (meter.inside, meter.outside));
        let starts = |cells: &mut dyn Iterator<Item = u32>| {
            let mut starts = vec![0; outer.rows() + 1];
            cells.for_each(|cell| starts[cell as usize / length + 1] += 1);
            (0..outer.rows()).for_each(|row| starts[row + 1] += starts[row]);
            starts
        };
        let rows = starts(&mut sites.iter().map(|site| site.cell));
        let metered = starts(&mut meters.iter().map(|meter| meter.inside));
        let column = || vec![T::ZERO; 2 * sites.len()];
        let memory = MemoryVariables { values: column(), persistent: vec![column(); method.persistent] };
        Ok(Self {
            rows,
            metered,
            saved: memory.clone(),
            memory,
            registers: vec![column(); method.registers - method.persistent],
            rates: column(),
            means: column(),
            forces: vec![T::ZERO; sites.len()],
            blank: column(),
            steepest,
            meters,
            sites,
        })
    }

    /// Whether energy is measured in a row.
    pub fn meters(&self, row: usize) -> bool {
        self.metered[row] < self.metered[row + 1]
    }

    /// Evaluates p', q' and the forces at a stage, from the displacement at the stage.
    pub fn evaluate(&mut self, u: &[T], action: WaveStageAction, h: f64, method: &Facts) {
        let Self { sites, memory, registers, rates, means, forces, .. } = self;
        let (before, half) = match action {
            WaveStageAction::Update { stage, .. } => center(method, stage, h),
            _ => (None, 0.0),
        };
        let before = before.map_or(&memory.values, |register| {
            let persistent = memory.persistent.len();
            if register < persistent { &memory.persistent[register] } else { &registers[register - persistent] }
        });
        let half = T::from_f64(half);
        let (faces, centers) = before.split_at(sites.len());
        let (face_rates, center_rates) = rates.split_at_mut(sites.len());
        let (face_means, center_means) = means.split_at_mut(sites.len());
        let gradient = |site: &Site<T>| u[site.cell as usize] - u[site.inner as usize];
        for (index, site) in sites.iter().enumerate() {
            let rate = -(site.face * (faces[index] + gradient(site))) / (T::ONE + site.face * half);
            face_rates[index] = rate;
            face_means[index] = faces[index] + half * rate;
        }
        for (index, site) in sites.iter().enumerate() {
            let own = site.weight * face_means[index];
            let (mut divergence, mut added) = (-(site.weight * gradient(site)) - own, -own);
            let outward = site.outward as usize;
            if outward != index {
                let next = &sites[outward];
                let flux = next.weight * face_means[outward];
                divergence += next.weight * gradient(next) + flux;
                added += flux;
            }
            let rate = -(site.center * (centers[index] + divergence)) / (T::ONE + site.center * half);
            center_rates[index] = rate;
            center_means[index] = centers[index] + half * rate;
            forces[index] = added + center_means[index];
        }
    }

    /// Adds the forces to the accelerations of the cells of a row. The forces on one cell are summed first.
    pub fn push(&self, row: usize, first: usize, medium: &Medium<T>, out: &mut [T]) {
        let range = self.rows[row]..self.rows[row + 1];
        let mut pairs = self.sites[range.clone()].iter().zip(&self.forces[range]).peekable();
        while let Some((site, &force)) = pairs.next() {
            let mut sum = force;
            while let Some((_, &other)) = pairs.next_if(|(other, _)| other.cell == site.cell) {
                sum += other;
            }
            let cell = site.cell as usize;
            if (first..first + out.len()).contains(&cell) {
                let mut sums = [sum];
                let column = cell % medium.laplacian.grid.row_length();
                medium.divide(row, column..column + 1, &mut sums);
                out[cell - first] += sums[0];
            }
        }
    }

    /// Power from some cells of a row into layers, from their velocities [W].
    pub fn power(&self, row: usize, cells: Range<usize>, velocity: impl Fn(usize) -> f64, u: impl Fn(usize) -> T) -> f64 {
        let mut power = 0.0;
        for meter in &self.meters[self.metered[row]..self.metered[row + 1]] {
            let (inside, outside) = (meter.inside as usize, meter.outside as usize);
            if cells.contains(&inside) {
                let rise = u(outside).to_f64() - u(inside).to_f64();
                power -= meter.weight * velocity(inside - cells.start) * rise;
            }
        }
        power
    }

    /// Advances p and q by the stage that was [evaluated](Self::evaluate).
    pub fn advance(&mut self, action: WaveStageAction, h: f64, method: &Facts, kernel: BufferedStage<T>) {
        let Self { memory, saved, registers, rates, blank, .. } = self;
        let mut columns = memory.persistent.iter_mut().chain(registers).map(Vec::as_mut_slice);
        let cells = WaveCells {
            displacement: blank,
            rate: &mut memory.values,
            registers: std::array::from_fn(|_| columns.next().unwrap_or_default()),
        };
        let mut persistent: [&[T]; REGISTERS] = [&[]; REGISTERS];
        persistent.iter_mut().zip(&saved.persistent).for_each(|(slot, column)| *slot = column);
        // The kernel requires displacements, but nothing reads them.
        let input = Input { displacement: rates, rate: &saved.values, persistent, acceleration: rates.as_slice(), damping: None };
        kernel(method, cells, input, h, action);
    }

    /// Saves p and q at the start of a batch.
    pub fn save(&mut self) {
        self.saved.clone_from(&self.memory);
    }

    /// Restores the saved p and q.
    pub fn rollback(&mut self) {
        self.memory.clone_from(&self.saved);
    }

    /// Writes p and q to an archive.
    pub fn capture(&self, archive: &mut Archive) {
        archive.write("values", self.memory.values.iter().map(|number| number.to_f64()));
        for (index, column) in self.memory.persistent.iter().enumerate() {
            archive.write(&register(index), column.iter().map(|number| number.to_f64()));
        }
    }

    /// Reads p and q from an archive.
    pub fn restore(&mut self, archive: &mut Archive) -> Result<()> {
        fill("values", &mut self.memory.values, archive)?;
        let mut registers = self.memory.persistent.iter_mut().enumerate();
        registers.try_for_each(|(index, column)| fill(&register(index), column, archive))
    }

    /// Memory [bytes].
    pub fn bytes(&self) -> usize {
        let columns = 2 * (1 + self.memory.persistent.len()) + self.registers.len() + 3;
        size_of_val(self.sites.as_slice()) + columns * size_of_val(self.rates.as_slice()) + size_of_val(self.forces.as_slice())
    }
}

/// Register of the velocity before the kick of a stage (None: the velocity itself), and the time from there to the middle of the
/// kick. The time is 0 if the stage is no kick.
fn center(method: &Facts, stage: usize, h: f64) -> (Option<usize>, f64) {
    let Some(drift_kick) = method.drift_kick else { return (None, 0.0) };
    let Some(register) = method.drifts_by_register() else { return (None, 0.5 * h) };
    // The velocity at which the stage evaluates velocity-dependent forces, for an acceleration of 1.
    let mut probe = Component::new(0.0, 0.0, 1.0);
    (method.stage_state)(stage, &mut probe, h);
    debug_assert_eq!(register, drift_kick.velocity);
    (Some(register), probe.v - probe.registers[register])
}

#[cfg(test)]
mod tests {
    use super::AbsorptionParameters;

    #[test]
    fn thin_layers_return_most_of_a_wave_and_thick_ones_what_is_asked() {
        let returned =
            |width, reflection, cells: f64| AbsorptionParameters { width, reflection }.returned(std::f64::consts::TAU / cells);
        assert!(returned(1, 1e-6, 20.0) > 0.5);
        // In the continuum, exactly R. Differences of a profile of second order add less than that for gentle layers.
        for reflection in [0.3, 0.03] {
            let ratio = returned(200, reflection, 40.0) / reflection;
            assert!((ratio - 1.0).abs() < 0.05, "{reflection}: {ratio}");
        }
        // The free end alone returns everything.
        assert!((returned(20, 1.0 - 1e-12, 20.0) - 1.0).abs() < 1e-9);
    }
}
