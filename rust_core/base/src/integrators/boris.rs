//! Boris method, order 2: half a drift, a kick with the magnetic rotation in its middle, half a drift.
//!
//! The rotation couples the components of the velocity and is therefore not part of this file. If [`Splitting::GYRATES`], the
//! engine's `matter` system rotates the velocity about q B by 2 atan(|q B| h/2m). Volume in phase space is conserved, and a
//! magnetic field alone conserves the speed.
//!
//! Sources: J. P. Boris, Proc. 4th Conf. Numerical Simulation of Plasmas (1970) 3; C. K. Birdsall, A. B. Langdon, Plasma Physics
//! via Computer Simulation (1985), § 4-3; H. Qin et al., Phys. Plasmas 20 (2013) 084503.

use super::Splitting;

/// Drifts by ½, ½ around one kick, in units of h.
#[derive(Debug)]
pub struct Boris;

impl Splitting for Boris {
    const NAME: &'static str = "Boris";
    const ORDER: u32 = 2;
    const DRIFTS: &'static [f64] = &[0.5, 0.5];
    const KICKS: &'static [f64] = &[1.0];
    const COUPLED: f64 = 0.99;
    const GYRATES: bool = true;
}
