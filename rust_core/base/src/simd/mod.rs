//! SIMD with dispatch at run time: one wheel for every CPU.
//!
//! A kernel is a plain loop over fixed lanes. The function [`dispatch`] runs it inside a function compiled for AVX2 and FMA,
//! which are required on x86-64. The function [`dispatch_wide`] runs it inside one for AVX-512, if the CPU has that. This is
//! done where a benchmark shows that the kernel gains more than a tenth. The portable level serves other targets, and x86-64
//! with the feature `portable`, which compares its bits. Pair sums, which compilers vectorize badly, are written over registers
//! instead: the [`Pack`] of a level.
//!
//! No level changes the bits of results: nothing here reassociates, contracts or estimates.
//!
//! This folder is the only place where `unsafe` is allowed, for three purposes:
//!
//! - calls of such functions after detection of the CPU;
//! - gathers with indices that were checked once;
//! - instructions of a level; code with those takes an [`Isa`], which a [`Kernel`] receives.
#![allow(unsafe_code)]

use std::sync::OnceLock;
#[cfg(target_arch = "x86_64")]
use std::{hint::black_box, mem::MaybeUninit};

use crate::error::{Error, Result};

mod gather;
mod packs;
mod records;
#[cfg(target_arch = "x86_64")]
mod registers;
mod selection;

pub use gather::Gather;
pub use packs::{Number, Pack, Packed};
pub use records::{ParticleRecord, RecordTable, WORDS};
pub use selection::{Group, Selection, at_most};

/// Width of every fixed-lane loop: one AVX-512 register of f32, two of f64.
pub const LANES: usize = 16;

/// One number per lane.
pub type Lanes<T> = [T; LANES];

/// Rounds `count` up to whole groups of lanes. Columns have this length, so no kernel has a remainder.
#[inline]
pub const fn padded(count: usize) -> usize {
    count.div_ceil(LANES) * LANES
}

/// Set of vector instructions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// Base level of the target: on x86-64, registers of four f32 or two f64.
    Portable,
    /// AVX2 with FMA, and the bit-manipulation instructions that come with it.
    Avx2,
    /// AVX-512 F, VL, DQ and BW.
    Avx512,
}

/// Whether the portable level is compiled.
const HAS_PORTABLE: bool = cfg!(any(not(target_arch = "x86_64"), feature = "portable"));

impl Level {
    /// All levels.
    pub const ALL: [Self; 3] = [Self::Portable, Self::Avx2, Self::Avx512];

    /// Name of the level in `PHYSCORE_SIMD` and in the plan.
    #[inline]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Portable => "portable",
            Self::Avx2 => "avx2",
            Self::Avx512 => "avx512",
        }
    }

    /// Detects the best level of this CPU.
    fn detect() -> Self {
        #[cfg(target_arch = "x86_64")]
        {
            let avx2 = is_x86_feature_detected!("avx2")
                && is_x86_feature_detected!("fma")
                && is_x86_feature_detected!("popcnt")
                && is_x86_feature_detected!("bmi1")
                && is_x86_feature_detected!("bmi2");
            let avx512 = avx2
                && is_x86_feature_detected!("avx512f")
                && is_x86_feature_detected!("avx512vl")
                && is_x86_feature_detected!("avx512dq")
                && is_x86_feature_detected!("avx512bw");
            if avx512 {
                return Self::Avx512;
            }
            if avx2 {
                return Self::Avx2;
            }
        }
        Self::Portable
    }

    /// Whether this build has code for this CPU.
    #[inline]
    pub fn is_supported() -> bool {
        HAS_PORTABLE || Self::detect() > Self::Portable
    }

    /// Whether both this build and this CPU have the level.
    fn is_present(self) -> bool {
        self <= Self::detect() && (HAS_PORTABLE || self > Self::Portable)
    }

    /// Checks that `PHYSCORE_SIMD`, if set and not empty, names a level of this build and this CPU.
    ///
    /// # Errors
    /// If it does not.
    #[inline]
    pub fn check() -> Result<()> {
        let name = std::env::var("PHYSCORE_SIMD").unwrap_or_default();
        let present: Vec<_> = Self::ALL.into_iter().filter(|level| level.is_present()).map(Self::name).collect();
        if name.is_empty() || present.contains(&name.as_str()) {
            return Ok(());
        }
        Err(Error::parameter("PHYSCORE_SIMD", format!("a level that is here: {}", present.join(" or ")), format!("{name:?}")))
    }

    /// Level in use: that of the CPU, or a lower one set by the environment variable `PHYSCORE_SIMD`.
    ///
    /// # Panics
    /// If this build has no code for this CPU; see `is_supported`.
    #[inline]
    pub fn current() -> Self {
        static LEVEL: OnceLock<Level> = OnceLock::new();
        *LEVEL.get_or_init(|| {
            assert!(Self::is_supported(), "needs a processor with AVX2 and FMA");
            let wanted = std::env::var("PHYSCORE_SIMD").unwrap_or_default();
            let named = Self::ALL.into_iter().find(|level| level.name() == wanted && level.is_present());
            named.unwrap_or_else(Self::detect)
        })
    }
}

/// Level as a type, whose values exist only if the CPU has the level.
pub trait Isa: Copy {
    /// The level as a value.
    const LEVEL: Level;
    /// Register of the level.
    type Pack<T: Packed>: Pack<Scalar = T>;
    /// Registers for the lanes of a whole group.
    type Group<T: Packed>: Pack<Scalar = T>;
}

/// Computation to run at the best level. `run` and everything that it calls must be `#[inline(always)]`, except functions that
/// only the base level calls.
///
/// The code of each level is a method: compilers then put it beside the other code of the kernel's module, and compile modules in
/// parallel. Functions here would all be compiled as one unit.
pub trait Kernel: Sized {
    /// Result of the computation.
    type Output;

    /// Runs the computation, with the level as a type.
    fn run<I: Isa>(self, isa: I) -> Self::Output;

    /// Runs [`Kernel::run`] at the portable level. Like those of the other levels, it is not inlined into [`dispatch`].
    #[inline(never)]
    fn run_portable(self) -> Self::Output {
        self.run(Portable(()))
    }

    /// Runs [`Kernel::run`] at the level AVX2.
    ///
    /// # Safety
    /// The CPU has AVX2, FMA and the bit-manipulation instructions of the level.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2,fma,popcnt,bmi1,bmi2")]
    unsafe fn run_avx2(self) -> Self::Output {
        CacheLine::align_frame();
        self.run(Avx2(()))
    }

    /// Runs [`Kernel::run`] at the level AVX-512.
    ///
    /// # Safety
    /// The CPU has the AVX-512 instructions of the level.
    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx512f,avx512vl,avx512dq,avx512bw,avx2,fma,popcnt,bmi1,bmi2")]
    unsafe fn run_avx512(self) -> Self::Output {
        CacheLine::align_frame();
        self.run(Avx512(()))
    }
}

macro_rules! level {
    ($name:ident, $level:ident, $pack:ty, $group:ty) => {
        /// Level as a type.
        #[derive(Debug, Clone, Copy)]
        struct $name(());

        impl Isa for $name {
            const LEVEL: Level = Level::$level;
            type Pack<T: Packed> = $pack;
            type Group<T: Packed> = $group;
        }
    };
}

level!(Portable, Portable, T::Base, packs::Twice<packs::Twice<T::Base>>);
#[cfg(target_arch = "x86_64")]
level!(Avx2, Avx2, T::Avx2, T::Avx2Group);
#[cfg(target_arch = "x86_64")]
level!(Avx512, Avx512, T::Avx512, T::Avx512Group);

/// Runs `kernel` at the current level, or with AVX2 if that is AVX-512.
pub fn dispatch<K: Kernel>(kernel: K) -> K::Output {
    let level = Level::current();
    #[cfg(target_arch = "x86_64")]
    if level > Level::Portable {
        // SAFETY: `Level::current` is never above the level of the CPU.
        return unsafe { kernel.run_avx2() };
    }
    #[cfg(any(not(target_arch = "x86_64"), feature = "portable"))]
    return kernel.run_portable();
    #[cfg(not(any(not(target_arch = "x86_64"), feature = "portable")))]
    unreachable!("{level:?} is not compiled")
}

/// Runs `kernel` at the current level.
pub fn dispatch_wide<K: Kernel>(kernel: K) -> K::Output {
    #[cfg(target_arch = "x86_64")]
    if Level::current() == Level::Avx512 {
        // SAFETY: `Level::current` is never above the level of the CPU.
        return unsafe { kernel.run_avx512() };
    }
    dispatch(kernel)
}

/// Cache line on the stack. A function that holds one aligns its frame, and with it the registers that it spills. Compilers do
/// not align a frame for spilled registers alone. A register that straddles two cache lines takes several times as long.
#[cfg(target_arch = "x86_64")]
#[repr(align(64))]
struct CacheLine(#[expect(dead_code, reason = "its place counts, not its value")] [u8; 64]);

#[cfg(target_arch = "x86_64")]
impl CacheLine {
    /// Aligns the frame of the calling function.
    #[inline(always)]
    fn align_frame() {
        black_box(&MaybeUninit::<Self>::uninit());
    }
}
