//! Contact impulses by projected Gauss–Seidel iteration: the velocities nearest to given ones at which no contact closes too
//! far.
//!
//! All contacts require relative normal velocities J v ≥ b. With impulses λ ≥ 0,
//!
//!     v = v* + M⁻¹ Jᵀ λ   where λ maximizes   D(λ) = −½ λᵀ J M⁻¹ Jᵀ λ − λᵀ (J v* − b).
//!
//! Coulomb's friction is added, `|λ_t|` ≤ μ λ. The kinetic energy changes by λᵀ b − D(λ) at most. With b ≤ 0 it does not grow
//! as long as D ≥ 0. The iteration starts from the impulses of the last step, scaled such that D ≥ 0. No iteration lowers D.
//! Sources: J. J. Moreau, "Unilateral contact and dry friction in finite freedom dynamics", 1988; D. M. Kaufman et al., ACM
//! Trans. Graph. 27, 164 (2008).

use glam::DVec3;

use super::distance::combined;

/// Maximum number of iterations. Tolerance of convergence: the change of relative velocities in one iteration, over the
/// largest change needed.
const MOST: u32 = 20;
pub const CONVERGED: f64 = 1e-3;
/// Number of iterations from one over all contacts to the next.
const COMPLETE: u32 = 5;

/// Origin of a contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Origin {
    /// Pair that is near at the start of a step, by its key.
    Pair(u64),
    /// Vertex at a wall.
    Wall,
    /// Pair that meets on its path.
    Way,
}

/// Contact of up to four particles.
#[derive(Debug, Clone, Copy)]
pub struct MeshContact {
    pub nodes: [u32; 4],
    /// Weights wᵢ: the relative velocity is Σ wᵢ vᵢ.
    pub weights: [f64; 4],
    /// Unit normal n.
    pub normal: DVec3,
    /// Least normal velocity b [m/s].
    pub least: f64,
    /// Coulomb's coefficient μ.
    pub friction: f64,
    pub origin: Origin,
    /// Normal impulse λ and impulse of friction [kg·m/s].
    pub impulse: f64,
    pub tangential: DVec3,
    /// wᵢ/mᵢ [1/kg], and the effective mass 1/Σ wᵢ²/mᵢ [kg].
    change: [f64; 4],
    mass: f64,
}

impl MeshContact {
    /// Creates a contact without impulse; None if no particle of it is free to move.
    pub fn new(
        (nodes, origin): ([u32; 4], Origin),
        weights: [f64; 4],
        normal: DVec3,
        (least, friction): (f64, f64),
        inverse_mass: &[f64],
    ) -> Option<Self> {
        let change: [f64; 4] = std::array::from_fn(|node| weights[node] * inverse_mass[nodes[node] as usize]);
        let inverse: f64 = weights.iter().zip(&change).map(|(weight, change)| weight * change).sum();
        let (impulse, tangential) = (0.0, DVec3::ZERO);
        (inverse > 0.0).then_some(Self {
            nodes,
            weights,
            normal,
            least,
            friction,
            origin,
            impulse,
            tangential,
            change,
            mass: 1.0 / inverse,
        })
    }

    /// Relative velocity [m/s].
    #[inline(always)]
    pub fn velocity(&self, velocities: &[DVec3]) -> DVec3 {
        combined(&self.weights, &self.nodes.map(|node| velocities[node as usize]))
    }

    /// Energy supplied by the supports of fixed particles [J].
    pub fn supplied(&self, is_fixed: impl Fn(u32) -> bool, velocities: &[DVec3]) -> f64 {
        let fixed = self.nodes.iter().zip(self.weights).filter(|&(&node, weight)| weight != 0.0 && is_fixed(node));
        let velocity: DVec3 = fixed.map(|(&node, weight)| weight * velocities[node as usize]).sum();
        -velocity.dot(self.impulse * self.normal + self.tangential)
    }

    /// Adds an impulse of the contact to the velocities.
    #[inline(always)]
    fn push(&self, impulse: DVec3, velocities: &mut [DVec3]) {
        for (node, change) in self.nodes.iter().zip(self.change) {
            velocities[*node as usize] += change * impulse;
        }
    }

    /// Sets the impulses that satisfy this contact alone; returns the change of the normal velocity [m/s].
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
pub fn start(contacts: &mut [MeshContact], velocities: &mut [DVec3]) {
    let mut changes = vec![DVec3::ZERO; velocities.len()];
    contacts.iter().for_each(|contact| contact.push(contact.impulse * contact.normal, &mut changes));
    let (mut linear, mut square) = (0.0, 0.0);
    for contact in contacts.iter() {
        linear -= contact.impulse * (contact.normal.dot(contact.velocity(velocities)) - contact.least);
        square += contact.impulse * contact.normal.dot(contact.velocity(&changes));
    }
    let factor = if square > 0.0 { (linear / square).clamp(0.0, 1.0) } else { 0.0 };
    contacts.iter_mut().for_each(|contact| contact.impulse *= factor);
    velocities.iter_mut().zip(&changes).for_each(|(velocity, change)| *velocity += factor * *change);
}

/// Iterates over the contacts in alternating order. Most iterations skip contacts without impulse.
pub fn solve(contacts: &mut [MeshContact], velocities: &mut [DVec3]) {
    let violation = |contact: &MeshContact| contact.least - contact.normal.dot(contact.velocity(velocities));
    let carried = contacts.iter().map(|contact| contact.impulse / contact.mass).fold(0.0, f64::max);
    let needed = contacts.iter().map(violation).fold(carried, f64::max);
    if needed <= 0.0 {
        return;
    }
    let mut pressing: Vec<u32> = Vec::with_capacity(contacts.len());
    let mut complete = true;
    for iteration in 0..MOST {
        let mut largest = 0.0_f64;
        if complete {
            pressing.clear();
            for (contact, index) in contacts.iter_mut().zip(0..) {
                largest = largest.max(contact.relax(velocities));
                if contact.impulse > 0.0 {
                    pressing.push(index);
                }
            }
        } else {
            let mut relax = |&index: &u32| largest = largest.max(contacts[index as usize].relax(velocities));
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
