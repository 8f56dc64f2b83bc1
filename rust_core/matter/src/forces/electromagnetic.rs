//! Fields that the engine computes: E [V/m] or B [T] as functions of position and time.
//!
//! Sources: J. D. Jackson, Classical Electrodynamics, 3rd edition (1999), § 5.6 (dipole); J. Simpson et al., NASA/TM-2013-217919
//! (current loop); L. S. Brown, G. Gabrielse, Rev. Mod. Phys. 58 (1986) 233, sections II and V (quadrupole trap, bottle); W.
//! Paul, Rev. Mod. Phys. 62 (1990) 531 (trap with an alternating voltage).

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use crate::error::Result;
use crate::math::{AXES, Real};
use crate::scene::Item;

/// Magnetic constant over 4π [N/A²] (CODATA 2018).
const MAGNETIC: f64 = 1.000_000_000_55e-7;
/// Iterations of the arithmetic–geometric mean, for ratios of at least 1e-8. Each iteration doubles the number of correct digits.
const MEANS: usize = 7;

/// Law of a field, as declared.
#[derive(Debug, Clone, Copy)]
pub enum ElectromagneticLaw {
    /// Uniform field.
    Uniform(DVec3),
    /// Quadrupole field s(t) (x/2, y/2, −z) about a center, with s = constant + alternating · cos(2π f t + phase).
    Quadrupole {
        /// Center [m].
        center: DVec3,
        /// Constant part of s.
        constant: f64,
        /// Amplitude of the alternating part of s.
        alternating: f64,
        /// Frequency f [Hz].
        frequency: f64,
        /// Phase [rad].
        phase: f64,
    },
    /// Field of a point dipole of moment m [A·m²].
    Dipole {
        /// Place of the dipole [m].
        center: DVec3,
        /// Moment m [A·m²].
        moment: DVec3,
    },
    /// Field of a circular loop of current [A] about an axis, a unit vector.
    Loop {
        /// Center [m].
        center: DVec3,
        /// Unit vector along the axis.
        axis: DVec3,
        /// Radius [m].
        radius: f64,
        /// Current [A].
        current: f64,
    },
    /// Magnetic bottle B₀ [−xz/L², −yz/L², 1 + (z² − (x² + y²)/2)/L²] about a center.
    Bottle {
        /// Center [m].
        center: DVec3,
        /// Field B₀ at the center [T].
        strength: f64,
        /// Length L over which the field grows [m].
        length: f64,
    },
    /// Plane wave A cos(k·x − 2π f t + phase).
    Wave {
        /// Amplitude A.
        amplitude: DVec3,
        /// Wave vector k [1/m].
        wave_vector: DVec3,
        /// Frequency f [Hz].
        frequency: f64,
        /// Phase [rad].
        phase: f64,
    },
}

impl ElectromagneticLaw {
    /// Law of an item.
    ///
    /// # Errors
    /// If its kind is unknown or a value is not finite.
    pub fn new(item: &Item) -> Result<Self> {
        Ok(match item.kind.as_str() {
            "UniformField" => Self::Uniform(item.vector("field")?),
            "QuadrupoleTrap" => Self::Quadrupole {
                center: item.vector("center")?,
                constant: item.number("strength")?,
                alternating: 0.0,
                frequency: 0.0,
                phase: 0.0,
            },
            "PaulTrap" => Self::Quadrupole {
                center: item.vector("center")?,
                constant: item.number("constant")?,
                alternating: item.number("alternating")?,
                frequency: item.number("frequency")?,
                phase: item.number("phase")?,
            },
            "MagneticDipole" => Self::Dipole { center: item.vector("center")?, moment: item.vector("moment")? },
            "CurrentLoop" => Self::Loop {
                center: item.vector("center")?,
                axis: item.vector("axis")?.normalize(),
                radius: item.number("radius")?,
                current: item.number("current")?,
            },
            "MagneticBottle" => Self::Bottle {
                center: item.vector("center")?,
                strength: item.number("strength")?,
                length: item.number("length")?,
            },
            "TravellingWave" => Self::Wave {
                amplitude: item.vector("amplitude")?,
                wave_vector: item.vector("wave_vector")?,
                frequency: item.number("frequency")?,
                phase: item.number("phase")?,
            },
            _ => return Err(crate::scene::unknown(item, "a field")),
        })
    }

    /// Strength s of a quadrupole at a time, and its rate of change.
    fn quadrupole(self, time: f64) -> [f64; 2] {
        let Self::Quadrupole { constant, alternating, frequency, phase, .. } = self else { return [0.0; 2] };
        let angle = TAU * frequency * time + phase;
        [constant + alternating * libm::cos(angle), -TAU * frequency * alternating * libm::sin(angle)]
    }

    /// Whether the field has a potential.
    #[inline]
    pub fn is_conservative(self) -> bool {
        matches!(self, Self::Uniform(_) | Self::Quadrupole { .. })
    }

    /// Potential φ with E = −∇φ at a position and time [V]; 0 if there is none.
    #[inline]
    pub fn potential(self, place: DVec3, time: f64) -> f64 {
        match self {
            Self::Uniform(field) => -field.dot(place),
            Self::Quadrupole { center, .. } => self.quadrupole(time)[0] * shape(place - center),
            _ => 0.0,
        }
    }

    /// Largest |eigenvalue| of the gradient at any position and time [V/m² or T/m]; 0 where unknown.
    #[inline]
    pub fn gradient(self) -> f64 {
        match self {
            Self::Quadrupole { constant, alternating, .. } => constant.abs() + alternating.abs(),
            Self::Wave { amplitude, wave_vector, .. } => amplitude.length() * wave_vector.length(),
            _ => 0.0,
        }
    }

    /// Shortest period of the field at one position [s].
    #[inline]
    pub fn period(self) -> f64 {
        match self {
            Self::Quadrupole { frequency, alternating, .. } if alternating != 0.0 => frequency.abs().recip(),
            Self::Wave { frequency, .. } => frequency.abs().recip(),
            _ => f64::INFINITY,
        }
    }

    /// The field as an affine function of the position, for a uniform field or a constant quadrupole.
    pub fn affine<T: Real>(self, origin: DVec3) -> Option<Affine<T>> {
        let of = |vector: DVec3| vector.to_array().map(T::from_f64);
        let (uniform, center, strength) = match self {
            Self::Uniform(field) => (field, DVec3::ZERO, 0.0),
            Self::Quadrupole { center, constant, alternating: 0.0, .. } => (DVec3::ZERO, center - origin, constant),
            _ => return None,
        };
        let quadrupole = Quadrupole { center: of(center), strength: T::from_f64(strength), rate: T::ZERO };
        Some(Affine { uniform: of(uniform), quadrupole })
    }

    /// Passes the law at a time to a computation, for positions relative to `origin`.
    pub fn with<T: Real, U: Use<T>>(self, time: f64, origin: DVec3, then: U) {
        let of = |vector: DVec3| vector.to_array().map(T::from_f64);
        match self {
            Self::Uniform(field) => then.with(UniformField(of(field))),
            Self::Quadrupole { center, .. } => {
                let [strength, rate] = self.quadrupole(time).map(T::from_f64);
                then.with(Quadrupole { center: of(center - origin), strength, rate });
            }
            Self::Dipole { center, moment } => then.with(Dipole { center: of(center - origin), moment: of(MAGNETIC * moment) }),
            Self::Loop { center, axis, radius, current } => then.with(CurrentLoop {
                center: of(center - origin),
                axis: of(axis),
                radius: T::from_f64(radius),
                current: T::from_f64(4.0 * MAGNETIC * current),
            }),
            Self::Bottle { center, strength, length } => {
                let curvature = T::from_f64(strength / (length * length));
                then.with(Bottle { center: of(center - origin), strength: T::from_f64(strength), curvature });
            }
            Self::Wave { amplitude, wave_vector, frequency, phase } => then.with(PlaneWave {
                amplitude: of(amplitude),
                per_length: wave_vector,
                phase: wave_vector.dot(origin) - TAU * frequency * time + phase,
            }),
        }
    }
}

/// Potential of a quadrupole of strength 1, z²/2 − (x² + y²)/4.
fn shape(d: DVec3) -> f64 {
    0.5 * d.z * d.z - 0.25 * (d.x * d.x + d.y * d.y)
}

/// A computation for any law.
pub trait Use<T: Real> {
    /// Runs the computation.
    fn with(self, law: impl FieldLaw<T>);
}

/// A field at one time. All implementations are `#[inline(always)]`, so that loops over them are vectorized.
pub trait FieldLaw<T: Real>: Copy + Sync {
    /// The field at a position.
    fn at(&self, x: [T; AXES]) -> [T; AXES];

    /// External power per charge [W/C] supplied to a particle at this position and velocity: ∂φ/∂t if there is a potential, else
    /// E·v.
    fn power(&self, _x: [T; AXES], _v: [T; AXES]) -> T {
        T::ZERO
    }
}

#[inline(always)]
fn from<T: Real>(x: [T; AXES], center: [T; AXES]) -> [T; AXES] {
    [x[0] - center[0], x[1] - center[1], x[2] - center[2]]
}

#[inline(always)]
fn dot<T: Real>(a: [T; AXES], b: [T; AXES]) -> T {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[derive(Clone, Copy)]
struct UniformField<T>([T; AXES]);

impl<T: Real> FieldLaw<T> for UniformField<T> {
    #[inline(always)]
    fn at(&self, _x: [T; AXES]) -> [T; AXES] {
        self.0
    }
}

#[derive(Debug, Clone, Copy)]
struct Quadrupole<T> {
    center: [T; AXES],
    strength: T,
    /// Rate of change ds/dt.
    rate: T,
}

impl<T: Real> FieldLaw<T> for Quadrupole<T> {
    #[inline(always)]
    fn at(&self, x: [T; AXES]) -> [T; AXES] {
        let d = from(x, self.center);
        let half = T::from_f64(0.5) * self.strength;
        [half * d[0], half * d[1], -(self.strength * d[2])]
    }

    #[inline(always)]
    fn power(&self, x: [T; AXES], _v: [T; AXES]) -> T {
        let d = from(x, self.center);
        self.rate * (T::from_f64(0.5) * d[2] * d[2] - T::from_f64(0.25) * (d[0] * d[0] + d[1] * d[1]))
    }
}

/// Sum of a uniform field and a quadrupole.
#[derive(Debug, Clone, Copy)]
pub struct Affine<T> {
    uniform: [T; AXES],
    quadrupole: Quadrupole<T>,
}

impl<T: Real> FieldLaw<T> for Affine<T> {
    #[inline(always)]
    fn at(&self, x: [T; AXES]) -> [T; AXES] {
        let [a, b, c] = self.quadrupole.at(x);
        [self.uniform[0] + a, self.uniform[1] + b, self.uniform[2] + c]
    }
}

#[derive(Clone, Copy)]
struct Dipole<T> {
    center: [T; AXES],
    /// Moment μ₀ m/4π.
    moment: [T; AXES],
}

impl<T: Real> FieldLaw<T> for Dipole<T> {
    #[inline(always)]
    fn at(&self, x: [T; AXES]) -> [T; AXES] {
        let d = from(x, self.center);
        let inverse = T::ONE / dot(d, d);
        let cube = inverse * inverse.sqrt();
        let along = T::from_f64(3.0) * dot(self.moment, d) * inverse;
        let mut field = d;
        for axis in 0..AXES {
            field[axis] = (along * d[axis] - self.moment[axis]) * cube;
        }
        field
    }
}

/// Field of a circular current loop, with C = μ₀ I/π, α² = (a − ρ)² + z², β² = (a + ρ)² + z², m = 4aρ/β² and k′² = 1 − m = α²/β².
/// The complete elliptic integrals are K = π/2M and E = K (1 − m/2 − m² S/2). M is the arithmetic–geometric mean of 1 and k′ with
/// the differences m eₙ, and S = Σ 2ⁿ eₙ². In these terms no difference of K and E is left, and B has no singular factor on the
/// axis.
#[derive(Clone, Copy)]
struct CurrentLoop<T> {
    center: [T; AXES],
    axis: [T; AXES],
    radius: T,
    /// Constant C = μ₀ I/π.
    current: T,
}

impl<T: Real> FieldLaw<T> for CurrentLoop<T> {
    #[inline(always)]
    fn at(&self, x: [T; AXES]) -> [T; AXES] {
        let [half, two] = [0.5, 2.0].map(T::from_f64);
        let d = from(x, self.center);
        let (z, a) = (dot(d, self.axis), self.radius);
        let mut outward = d;
        for axis in 0..AXES {
            outward[axis] = d[axis] - z * self.axis[axis];
        }
        let square = dot(outward, outward);
        let rho = square.sqrt();
        let (near, far) = ((a - rho) * (a - rho) + z * z, (a + rho) * (a + rho) + z * z);
        let m = T::from_f64(4.0) * a * rho / far;
        let (mut mean, mut root) = (T::ONE, (near / far).sqrt());
        let mut difference = half / (T::ONE + root);
        let (mut sum, mut weight) = (T::ZERO, two);
        for _ in 0..MEANS {
            sum += weight * difference * difference;
            weight = two * weight;
            let next = half * (mean + root);
            root = (mean * root).sqrt();
            mean = next;
            difference = m * difference * difference / (two * (mean + root));
        }
        let integral = T::from_f64(0.5 * PI) / mean;
        let beta = far.sqrt();
        let scale = self.current * integral / (near * beta);
        let bracket = T::ONE - (two - m) * sum;
        let radial = scale * two * a * a * z * bracket / far;
        let axial = scale * half * ((a * a - square - z * z) * (T::ONE - half * m - half * m * m * sum) + near);
        let mut field = outward;
        for axis in 0..AXES {
            field[axis] = radial * outward[axis] + axial * self.axis[axis];
        }
        field
    }
}

#[derive(Clone, Copy)]
struct Bottle<T> {
    center: [T; AXES],
    strength: T,
    /// Curvature B₀/L².
    curvature: T,
}

impl<T: Real> FieldLaw<T> for Bottle<T> {
    #[inline(always)]
    fn at(&self, x: [T; AXES]) -> [T; AXES] {
        let d = from(x, self.center);
        let across = -(self.curvature * d[2]);
        let along = d[2] * d[2] - T::from_f64(0.5) * (d[0] * d[0] + d[1] * d[1]);
        [across * d[0], across * d[1], self.strength + self.curvature * along]
    }
}

#[derive(Clone, Copy)]
struct PlaneWave<T> {
    amplitude: [T; AXES],
    /// Wave vector k [rad/m].
    per_length: DVec3,
    phase: f64,
}

impl<T: Real> FieldLaw<T> for PlaneWave<T> {
    #[inline(always)]
    fn at(&self, x: [T; AXES]) -> [T; AXES] {
        let place = DVec3::from_array(x.map(T::to_f64));
        let cosine = T::from_f64(libm::cos(self.per_length.dot(place) + self.phase));
        self.amplitude.map(|amplitude| amplitude * cosine)
    }

    #[inline(always)]
    fn power(&self, x: [T; AXES], v: [T; AXES]) -> T {
        dot(self.at(x), v)
    }
}

/// A field that is constant in time, with the charges in it.
#[derive(Debug, Clone, Copy)]
pub struct ReadyField<'a, T> {
    /// Law of the field.
    pub law: ElectromagneticLaw,
    /// Charges [C]. The electric and the magnetic field of one item share their memory.
    pub charges: &'a [T],
    /// Whether the field is magnetic.
    pub is_magnetic: bool,
}

/// Product of a charge and a field; 0 without a charge, even where the field is infinite.
#[inline(always)]
pub fn times<T: Real>(charge: T, field: [T; AXES]) -> [T; AXES] {
    field.map(|field| if charge == T::ZERO { T::ZERO } else { charge * field })
}
