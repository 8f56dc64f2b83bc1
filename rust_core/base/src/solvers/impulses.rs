//! Impulses by projected Gauss–Seidel iteration: the velocities nearest to given ones that satisfy inequalities, the rows.
//!
//! A row acts between up to four [`Handle`]s: contacts, and limits of lengths. All rows require relative
//! normal velocities J v ≥ b. With impulses λ ≥ 0,
//!
//!     v = v* + M⁻¹ Jᵀ λ   where λ maximizes   D(λ) = −½ λᵀ J M⁻¹ Jᵀ λ − λᵀ (J v* − b).
//!
//! Coulomb's friction is added, `|λ_t|` ≤ μ λ. The kinetic energy changes by λᵀ b − D(λ) at most. With b ≤ 0 it does not grow
//! as long as D ≥ 0. The iteration starts from the impulses of the last step, scaled such that D ≥ 0. No iteration lowers D.
//! Sources: J. J. Moreau, "Unilateral contact and dry friction in finite freedom dynamics", 1988; D. M. Kaufman et al., ACM
//! Trans. Graph. 27, 164 (2008).

use glam::DVec3;

/// Maximum number of iterations.
const MOST: u32 = 20;
/// Tolerance of convergence: the change of relative velocities in one iteration, over the largest change needed.
pub const CONVERGED: f64 = 1e-3;
/// Number of iterations from one over all rows to the next.
const COMPLETE: u32 = 5;

/// Degree of freedom that an impulse moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Handle {
    /// Particle, by its index.
    Particle(u32),
    /// Nothing that moves, such as a wall.
    Fixed,
}

impl Handle {
    /// Velocity, given those of all particles [m/s].
    #[inline(always)]
    pub fn velocity(self, velocities: &[DVec3]) -> DVec3 {
        match self {
            Self::Particle(index) => velocities[index as usize],
            Self::Fixed => DVec3::ZERO,
        }
    }

    /// Inverse mass, given those of all particles [1/kg].
    pub fn inverse_mass(self, inverse_mass: &[f64]) -> f64 {
        match self {
            Self::Particle(index) => inverse_mass[index as usize],
            Self::Fixed => 0.0,
        }
    }

    /// Changes the velocity [m/s].
    #[inline(always)]
    fn push(self, change: DVec3, velocities: &mut [DVec3]) {
        if let Self::Particle(index) = self {
            velocities[index as usize] += change;
        }
    }
}

/// Inequality for the relative velocity of up to four handles, with friction.
#[derive(Debug, Clone, Copy)]
pub struct ImpulseRow<T> {
    /// Handles.
    pub ends: [Handle; 4],
    /// Weights wᵢ: the relative velocity is Σ wᵢ vᵢ.
    pub weights: [f64; 4],
    /// Unit normal n.
    pub normal: DVec3,
    /// Least normal velocity b [m/s].
    pub least: f64,
    /// Coulomb's coefficient μ.
    pub friction: f64,
    /// Normal impulse λ [kg·m/s].
    pub impulse: f64,
    /// Impulse of friction [kg·m/s].
    pub tangential: DVec3,
    /// Mark of the owner.
    pub mark: T,
    /// wᵢ/mᵢ [1/kg], and the effective mass 1/Σ wᵢ²/mᵢ [kg].
    change: [f64; 4],
    mass: f64,
}

impl<T> ImpulseRow<T> {
    /// Creates a row without impulse; None if none of its ends is free to move.
    pub fn new(
        (ends, mark): ([Handle; 4], T),
        weights: [f64; 4],
        normal: DVec3,
        (least, friction): (f64, f64),
        inverse_mass: &[f64],
    ) -> Option<Self> {
        let change: [f64; 4] = std::array::from_fn(|end| weights[end] * ends[end].inverse_mass(inverse_mass));
        let inverse: f64 = weights.iter().zip(&change).map(|(weight, change)| weight * change).sum();
        let (impulse, tangential) = (0.0, DVec3::ZERO);
        (inverse > 0.0).then_some(Self {
            ends,
            weights,
            normal,
            least,
            friction,
            impulse,
            tangential,
            mark,
            change,
            mass: 1.0 / inverse,
        })
    }

    /// Relative velocity [m/s].
    #[inline(always)]
    pub fn velocity(&self, velocities: &[DVec3]) -> DVec3 {
        let [a, b, c, d] = self.ends.map(|end| end.velocity(velocities));
        let [wa, wb, wc, wd] = self.weights;
        wa * a + wb * b + wc * c + wd * d
    }

    /// Energy supplied by the supports of fixed ends [J].
    pub fn supplied(&self, is_fixed: impl Fn(Handle) -> bool, velocities: &[DVec3]) -> f64 {
        let fixed = self.ends.iter().zip(self.weights).filter(|&(&end, weight)| weight != 0.0 && is_fixed(end));
        let velocity: DVec3 = fixed.map(|(&end, weight)| weight * end.velocity(velocities)).sum();
        -velocity.dot(self.impulse * self.normal + self.tangential)
    }

    /// Adds an impulse of the row to the velocities.
    #[inline(always)]
    fn push(&self, impulse: DVec3, velocities: &mut [DVec3]) {
        for (end, change) in self.ends.into_iter().zip(self.change) {
            end.push(change * impulse, velocities);
        }
    }

    /// Sets the impulses that satisfy this row alone; returns the change of the normal velocity [m/s].
    #[inline(always)]
    fn relax(&mut self, velocities: &mut [DVec3]) -> f64 {
        let relative = self.velocity(velocities);
        let normal = self.normal.dot(relative);
        let impulse = (self.impulse + self.mass * (self.least - normal)).max(0.0);
        let mut push = (impulse - self.impulse) * self.normal;
        let change = (impulse - self.impulse).abs() / self.mass;
        self.impulse = impulse;
        if self.friction > 0.0 {
            let slip = relative - normal * self.normal;
            let wanted = self.tangential - self.mass * slip;
            let tangential = wanted.clamp_length_max(self.friction * impulse);
            push += tangential - self.tangential;
            self.tangential = tangential;
        }
        if push != DVec3::ZERO {
            self.push(push, velocities);
        }
        change
    }
}

/// Applies the initial normal impulses, scaled by the factor from 0 to 1 at which D is largest. On entry `velocities` do not
/// include them.
pub fn start<T>(rows: &mut [ImpulseRow<T>], velocities: &mut [DVec3]) {
    let mut changes = vec![DVec3::ZERO; velocities.len()];
    rows.iter().for_each(|row| row.push(row.impulse * row.normal, &mut changes));
    let (mut linear, mut square) = (0.0, 0.0);
    for row in rows.iter() {
        linear -= row.impulse * (row.normal.dot(row.velocity(velocities)) - row.least);
        square += row.impulse * row.normal.dot(row.velocity(&changes));
    }
    let factor = if square > 0.0 { (linear / square).clamp(0.0, 1.0) } else { 0.0 };
    rows.iter_mut().for_each(|row| row.impulse *= factor);
    velocities.iter_mut().zip(&changes).for_each(|(velocity, change)| *velocity += factor * *change);
}

/// Iterates over the rows in alternating order. Most iterations skip rows without impulse.
pub fn solve<T>(rows: &mut [ImpulseRow<T>], velocities: &mut [DVec3]) {
    let violation = |row: &ImpulseRow<T>| row.least - row.normal.dot(row.velocity(velocities));
    let carried = rows.iter().map(|row| row.impulse / row.mass).fold(0.0, f64::max);
    let needed = rows.iter().map(violation).fold(carried, f64::max);
    if needed <= 0.0 {
        return;
    }
    let mut pressing: Vec<u32> = Vec::with_capacity(rows.len());
    let mut complete = true;
    for iteration in 0..MOST {
        let mut largest = 0.0_f64;
        if complete {
            pressing.clear();
            for (row, index) in rows.iter_mut().zip(0..) {
                largest = largest.max(row.relax(velocities));
                if row.impulse > 0.0 {
                    pressing.push(index);
                }
            }
        } else {
            let mut relax = |&index: &u32| largest = largest.max(rows[index as usize].relax(velocities));
            if iteration % 2 == 0 { pressing.iter().for_each(&mut relax) } else { pressing.iter().rev().for_each(&mut relax) }
        }
        if largest <= CONVERGED * needed {
            if complete {
                break;
            }
            complete = true;
        } else {
            complete = (iteration + 1) % COMPLETE == 0;
        }
    }
}
