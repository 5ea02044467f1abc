//! Which instruction set kernels run on: chosen once, passed down, never asked for each ray.

pub(crate) mod compress;

/// An instruction set that kernels are compiled for. All sets give the same bits.
///
/// Outside this crate a set other than [`Portable`](Self::Portable) comes only from functions that
/// ask the CPU for it, so a value is proof that the CPU can run it:
///
/// ```compile_fail,E0603
/// let isa = slo_accel::Isa::Avx512;
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Isa {
    /// Plain Rust, the reference of the others. On x86-64, fused operations are calls of a library
    /// here, which is several times slower.
    Portable,
    /// NEON with fused operations, which every AArch64 CPU has: 8 lanes in two registers.
    #[non_exhaustive]
    Neon,
    /// AVX2, FMA, BMI, LZCNT and POPCNT: 8 lanes.
    #[non_exhaustive]
    Avx2,
    /// AVX-512 F, BW, DQ and VL, with all of [`Avx2`](Self::Avx2): 16 lanes.
    #[non_exhaustive]
    Avx512,
}

/// Work over whole columns of numbers, written in plain Rust. [`Isa::run`] is compiled once for
/// each instruction set, so that the compiler makes vector code of the loops.
///
/// `run` must be `#[inline(always)]`, and so must everything that it calls: a function that is not
/// inlined is compiled without the set's instructions. This holds for closures of `array::map`,
/// too. Rust neither reorders nor fuses operations, so every set gives the same bits.
///
/// ```
/// use slo_accel::{Isa, Lanewise};
///
/// struct Halve<'a>(&'a mut [f32]);
///
/// impl Lanewise for Halve<'_> {
///     type Output = ();
///
///     #[inline(always)]
///     fn run(self) {
///         for x in self.0 {
///             *x *= 0.5;
///         }
///     }
/// }
///
/// let mut column = [3.0; 100];
/// Isa::best().run(Halve(&mut column));
/// assert_eq!(column, [1.5; 100]);
/// ```
pub trait Lanewise {
    /// Result of the work.
    type Output;

    /// Does the work.
    fn run(self) -> Self::Output;
}

impl Isa {
    /// Does the work with this set's instructions, and returns its result.
    #[inline]
    pub fn run<W: Lanewise>(self, work: W) -> W::Output {
        debug_assert!(self.is_available());
        match self {
            // SAFETY: there is a value of a set only if the CPU has it.
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => unsafe { run_avx512(work) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => unsafe { run_avx2(work) },
            // On AArch64 all code is compiled for NEON.
            _ => work.run(),
        }
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn run_avx512<W: Lanewise>(work: W) -> W::Output {
    work.run()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn run_avx2<W: Lanewise>(work: W) -> W::Output {
    work.run()
}

impl std::fmt::Display for Isa {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Portable => "portable",
            Self::Neon => "NEON",
            Self::Avx2 => "AVX2",
            Self::Avx512 => "AVX-512",
        })
    }
}

impl Isa {
    /// The set that the environment variable `SLO_RT_ISA` names, as [`by_name`](Self::by_name)
    /// knows it; the best one if the variable is not set.
    ///
    /// # Errors
    /// If the variable names no set, or one that the CPU lacks.
    #[doc(hidden)]
    pub fn from_env() -> Result<Self, String> {
        match std::env::var("SLO_RT_ISA") {
            Ok(name) => Self::by_name(&name),
            Err(_) => Ok(Self::best()),
        }
    }

    /// The set of a name: `avx512`, `avx2`, `neon`, `portable`, or `auto` for the best.
    ///
    /// # Errors
    /// If the name is none of these, or the CPU lacks the set.
    pub fn by_name(name: &str) -> Result<Self, String> {
        let isa = match name {
            "auto" | "" => return Ok(Self::best()),
            "portable" => Self::Portable,
            "avx2" => Self::Avx2,
            "avx512" => Self::Avx512,
            "neon" => Self::Neon,
            _ => {
                return Err(format!(
                    "unknown instruction set `{name}`, expected avx512, avx2, neon, portable or auto"
                ));
            }
        };
        if isa.is_available() {
            Ok(isa)
        } else {
            Err(format!("this CPU has no {name} instructions"))
        }
    }

    /// The best set that this CPU has.
    pub fn best() -> Self {
        [Self::Avx512, Self::Avx2, Self::Neon]
            .into_iter()
            .find(|isa| isa.is_available())
            .unwrap_or(Self::Portable)
    }

    /// All sets that this CPU has, [`Portable`](Self::Portable) first.
    pub fn available() -> Vec<Self> {
        [Self::Portable, Self::Neon, Self::Avx2, Self::Avx512]
            .into_iter()
            .filter(|isa| isa.is_available())
            .collect()
    }

    /// Whether this CPU has the instructions.
    pub(crate) fn is_available(self) -> bool {
        match self {
            Self::Portable => true,
            Self::Neon => cfg!(target_arch = "aarch64"),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => {
                is_x86_feature_detected!("avx2")
                    && is_x86_feature_detected!("fma")
                    && is_x86_feature_detected!("bmi1")
                    && is_x86_feature_detected!("bmi2")
                    && is_x86_feature_detected!("lzcnt")
                    && is_x86_feature_detected!("popcnt")
            }
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => {
                Self::Avx2.is_available()
                    && is_x86_feature_detected!("avx512f")
                    && is_x86_feature_detected!("avx512bw")
                    && is_x86_feature_detected!("avx512dq")
                    && is_x86_feature_detected!("avx512vl")
            }
            #[cfg(not(target_arch = "x86_64"))]
            Self::Avx2 | Self::Avx512 => false,
        }
    }
}
