//! Which instruction set the kernels run on: decided once, passed down, never asked per ray.

pub(crate) mod compress;

/// An instruction set that kernels are compiled for. All give the same hits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Isa {
    /// Plain Rust; the reference of the others.
    Portable,
    /// AVX2, FMA, and BMI: 8 lanes.
    Avx2,
    /// AVX-512 F, BW, DQ, VL, with AVX2 and FMA: 16 lanes.
    Avx512,
}

/// Work over whole columns of numbers, written in plain Rust: [`Isa::run`] compiles it once for each
/// instruction set, and the compiler makes vector code of its loops.
///
/// It must be `#[inline(always)]`, and so must be what it calls: what is not inlined is compiled
/// without the set's instructions. Rust neither reorders nor fuses operations, so that every set
/// gives the same bits.
pub trait Lanewise {
    /// What comes back.
    type Output;

    /// Does the work.
    fn run(self) -> Self::Output;
}

impl Isa {
    /// Does lanewise work with this set's instructions, which the CPU must have.
    #[inline]
    pub fn run<W: Lanewise>(self, work: W) -> W::Output {
        debug_assert!(self.is_available());
        match self {
            // SAFETY: a set is chosen only where the CPU has it.
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => unsafe { run_avx512(work) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => unsafe { run_avx2(work) },
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
            Self::Avx2 => "AVX2",
            Self::Avx512 => "AVX-512",
        })
    }
}

impl Isa {
    /// The best set that this CPU has, or what `SLO_RT_ISA` asks for (`avx512`, `avx2`,
    /// `portable`).
    ///
    /// # Errors
    /// A value of `SLO_RT_ISA` that is no set, or a set that the CPU lacks.
    pub fn from_env() -> Result<Self, String> {
        match std::env::var("SLO_RT_ISA") {
            Ok(name) => Self::by_name(&name),
            Err(_) => Ok(Self::best()),
        }
    }

    /// The set of that name: `avx512`, `avx2`, `portable`, or `auto` for the best.
    ///
    /// # Errors
    /// A name that is no set, or a set that the CPU lacks.
    pub fn by_name(name: &str) -> Result<Self, String> {
        let isa = match name {
            "auto" | "" => return Ok(Self::best()),
            "portable" => Self::Portable,
            "avx2" => Self::Avx2,
            "avx512" => Self::Avx512,
            _ => {
                return Err(format!(
                    "unknown instruction set `{name}`, expected avx512, avx2, portable or auto"
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
        [Self::Avx512, Self::Avx2]
            .into_iter()
            .find(|isa| isa.is_available())
            .unwrap_or(Self::Portable)
    }

    /// Every set that this CPU has, the reference first.
    pub fn available() -> Vec<Self> {
        [Self::Portable, Self::Avx2, Self::Avx512]
            .into_iter()
            .filter(|isa| isa.is_available())
            .collect()
    }

    /// Whether this CPU can run it.
    pub fn is_available(self) -> bool {
        match self {
            Self::Portable => true,
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
            _ => false,
        }
    }
}
