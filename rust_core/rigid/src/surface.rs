//! Surfaces of bodies, and friction between them.

/// Friction of a contact.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Friction<N = f64> {
    /// Coulomb's coefficient μ.
    pub sliding: N,
    /// Lever arm of the moment of friction about the tangents [m].
    pub rolling: N,
    /// Lever arm of the moment of friction about the normal [m].
    pub torsional: N,
}

impl Friction {
    /// Friction between two surfaces: the geometric mean of Coulomb's coefficients, the larger lever arms. A particle has that of
    /// the body which it meets.
    pub(crate) fn between(one: Option<Self>, other: Option<Self>) -> Self {
        let (Some(one), Some(other)) = (one, other) else { return one.or(other).unwrap_or_default() };
        Friction {
            sliding: (one.sliding * other.sliding).sqrt(),
            rolling: one.rolling.max(other.rolling),
            torsional: one.torsional.max(other.torsional),
        }
    }

    /// Friction of a body on a face of a network, which takes no moments.
    pub(crate) fn on_face(body: Option<Self>) -> Self {
        Friction { sliding: body.unwrap_or_default().sliding, ..Self::default() }
    }
}

/// Surface of a mover.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Surface {
    /// Index of the shape.
    pub shape: usize,
    /// Friction; None for a particle, which has the friction of the body that it meets.
    pub friction: Option<Friction>,
    /// Coefficient of restitution.
    pub restitution: f64,
}
