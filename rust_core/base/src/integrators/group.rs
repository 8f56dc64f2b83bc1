//! Components of one group of lanes, as kernels hold them in registers.

use super::Component;
use crate::math::Real;

/// Components of one group of lanes. The arrays are separate, because an array of arrays would not stay in registers.
#[derive(Debug, Clone, Copy)]
pub struct ComponentGroup<T, const W: usize> {
    /// Positions.
    pub x: [T; W],
    /// Velocities.
    pub v: [T; W],
    a: [T; W],
    b: [T; W],
    c: [T; W],
    d: [T; W],
    e: [T; W],
    f: [T; W],
}

impl<T: Real, const W: usize> ComponentGroup<T, W> {
    /// Group of zeros.
    pub const ZERO: Self = {
        let zero = [T::ZERO; W];
        Self { x: zero, v: zero, a: zero, b: zero, c: zero, d: zero, e: zero, f: zero }
    };

    /// Returns the group with these positions, velocities and register values.
    #[inline(always)]
    pub fn new(x: [T; W], v: [T; W], register: impl Fn(usize) -> [T; W]) -> Self {
        Self { x, v, a: register(0), b: register(1), c: register(2), d: register(3), e: register(4), f: register(5) }
    }

    /// Values of a register.
    #[inline(always)]
    pub fn register(&self, index: usize) -> [T; W] {
        // Returned by value: a reference to one of several registers would keep all of them in memory.
        match index {
            0 => self.a,
            1 => self.b,
            2 => self.c,
            3 => self.d,
            4 => self.e,
            _ => self.f,
        }
    }

    /// Component in a lane.
    #[inline(always)]
    pub fn lane(&self, lane: usize) -> Component<T> {
        let registers = [self.a[lane], self.b[lane], self.c[lane], self.d[lane], self.e[lane], self.f[lane]];
        Component { x: self.x[lane], v: self.v[lane], registers }
    }

    /// Replaces the component in a lane.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, component: &Component<T>) {
        self.x[lane] = component.x;
        self.v[lane] = component.v;
        [self.a[lane], self.b[lane], self.c[lane], self.d[lane], self.e[lane], self.f[lane]] = component.registers;
    }

    /// Applies `change` to the component of every lane.
    #[inline(always)]
    pub fn each(&mut self, mut change: impl FnMut(&mut Component<T>, usize)) {
        for lane in 0..W {
            let mut component = self.lane(lane);
            change(&mut component, lane);
            self.set(lane, &component);
        }
    }
}
