//! Which instruction set there is, as a value.

use super::{Kernel, portable::Portable};

/// The instruction set that traversal uses. A value of this type proves that the processor has it.
///
/// The answers of all of them are the same, bit for bit; only the time differs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct SimdWidth(Set);

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Set {
    Portable,
    #[cfg(target_arch = "x86_64")]
    Avx2,
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

impl SimdWidth {
    /// What any processor has: the same lanes in plain code, which the compiler makes vectors of where it can.
    pub const PORTABLE: Self = Self(Set::Portable);

    /// AVX2 with FMA, BMI1, BMI2, LZCNT and POPCNT, where the processor has them all.
    pub fn avx2() -> Option<Self> {
        #[cfg(target_arch = "x86_64")]
        if std::is_x86_feature_detected!("avx2")
            && std::is_x86_feature_detected!("fma")
            && std::is_x86_feature_detected!("bmi1")
            && std::is_x86_feature_detected!("bmi2")
            && std::is_x86_feature_detected!("lzcnt")
            && std::is_x86_feature_detected!("popcnt")
        {
            return Some(Self(Set::Avx2));
        }
        None
    }

    /// AVX-512 (F, VL, DQ, BW) on 256 bits, where the processor has it and all that [`avx2`](Self::avx2) asks for.
    pub fn avx512() -> Option<Self> {
        #[cfg(target_arch = "x86_64")]
        if Self::avx2().is_some()
            && std::is_x86_feature_detected!("avx512f")
            && std::is_x86_feature_detected!("avx512vl")
            && std::is_x86_feature_detected!("avx512dq")
            && std::is_x86_feature_detected!("avx512bw")
        {
            return Some(Self(Set::Avx512));
        }
        None
    }

    /// The widest that the processor has. Asked once by the standard library, which keeps the answer.
    pub fn widest() -> Self {
        Self::avx512().or_else(Self::avx2).unwrap_or(Self::PORTABLE)
    }

    /// All that the processor has, the widest first.
    pub fn available() -> Vec<Self> {
        [Self::avx512(), Self::avx2(), Some(Self::PORTABLE)].into_iter().flatten().collect()
    }

    /// Its name in tables and on command lines.
    pub const fn name(self) -> &'static str {
        match self.0 {
            Set::Portable => "portable",
            #[cfg(target_arch = "x86_64")]
            Set::Avx2 => "avx2",
            #[cfg(target_arch = "x86_64")]
            Set::Avx512 => "avx512",
        }
    }

    /// Runs `kernel`, compiled for this instruction set.
    #[inline]
    pub(crate) fn run<K: Kernel>(self, kernel: K) -> K::Output {
        match self.0 {
            Set::Portable => run_portable(kernel),
            // SAFETY: this value was made by `avx2`, after the processor said that it has every feature of `run_avx2`.
            #[cfg(target_arch = "x86_64")]
            Set::Avx2 => unsafe { run_avx2(kernel) },
            // SAFETY: this value was made by `avx512`, after the processor said that it has every feature of
            // `run_avx512`.
            #[cfg(target_arch = "x86_64")]
            Set::Avx512 => unsafe { run_avx512(kernel) },
        }
    }
}

impl Default for SimdWidth {
    fn default() -> Self {
        Self::widest()
    }
}

/// A function of its own, as the others are: compiled into the choice between them it gave that a frame of 9 KB.
#[inline(never)]
fn run_portable<K: Kernel>(kernel: K) -> K::Output {
    kernel.run::<Portable>()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn run_avx2<K: Kernel>(kernel: K) -> K::Output {
    kernel.run::<super::avx2::Avx2>()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512vl,avx512dq,avx512bw,avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn run_avx512<K: Kernel>(kernel: K) -> K::Output {
    kernel.run::<super::avx512::Avx512>()
}
