//! Run-time dispatch: one body, compiled for each instruction set, chosen once per batch.

use std::sync::OnceLock;

/// An instruction set that this machine has.
///
/// A value proves it: the only ways to one are [`Level::BASELINE`], [`Level::detect`], [`Level::available`] and
/// [`Level::named`], so a kernel compiled for a level may be called with it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Level(Set);

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
enum Set {
    Baseline,
    #[cfg(target_arch = "x86_64")]
    Avx2,
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

impl Level {
    /// What the compiler's target has: SSE2 on x86-64, NEON on aarch64.
    pub const BASELINE: Level = Level(Set::Baseline);

    /// The best level of this machine.
    pub fn detect() -> Level {
        static BEST: OnceLock<Level> = OnceLock::new();
        *BEST.get_or_init(|| *Level::available().last().expect("the baseline is always there"))
    }

    /// Every level of this machine, the plainest first.
    pub fn available() -> Vec<Level> {
        #[cfg_attr(not(target_arch = "x86_64"), expect(unused_mut, reason = "there is one level"))]
        let mut levels = vec![Level::BASELINE];
        #[cfg(target_arch = "x86_64")]
        {
            let avx2 = is_x86_feature_detected!("avx2")
                && is_x86_feature_detected!("fma")
                && is_x86_feature_detected!("bmi1")
                && is_x86_feature_detected!("bmi2")
                && is_x86_feature_detected!("lzcnt")
                && is_x86_feature_detected!("popcnt");
            if avx2 {
                levels.push(Level(Set::Avx2));
            }
            let avx512 = is_x86_feature_detected!("avx512f")
                && is_x86_feature_detected!("avx512vl")
                && is_x86_feature_detected!("avx512dq")
                && is_x86_feature_detected!("avx512bw")
                && is_x86_feature_detected!("avx512cd");
            if avx2 && avx512 {
                levels.push(Level(Set::Avx512));
            }
        }
        levels
    }

    /// The level of that name, if this machine has it.
    pub fn named(name: &str) -> Option<Level> {
        Level::available().into_iter().find(|level| level.name() == name)
    }

    /// `baseline`, `avx2` or `avx512`.
    pub fn name(self) -> &'static str {
        match self.0 {
            Set::Baseline => "baseline",
            #[cfg(target_arch = "x86_64")]
            Set::Avx2 => "avx2",
            #[cfg(target_arch = "x86_64")]
            Set::Avx512 => "avx512",
        }
    }

    /// Whether kernels for AVX2, FMA and BMI may run.
    pub fn has_avx2(self) -> bool {
        self > Level::BASELINE
    }

    /// Whether kernels for AVX-512 F, VL, DQ, BW and CD may run.
    pub fn has_avx512(self) -> bool {
        self.name() == "avx512"
    }
}

/// Compiles a function's body for every [`Level`] and chooses by the level given as its first argument.
///
/// A kernel is generic over lifetimes or over types, which its arguments tell. The body is plain Rust over slices; what it calls must be `#[inline(always)]` to be compiled with it. No level fuses
/// a multiplication and an addition on its own, so all of them give the same bits.
#[macro_export]
macro_rules! dispatch {
    ($(
        $(#[$meta:meta])*
        $vis:vis fn $name:ident $(<$($lifetime:lifetime),*>)? $(<$($Type:ident: $bound:path),*>)? ( $($argument:ident : $type:ty),* $(,)? ) $(-> $output:ty)? $body:block
    )*) => {$(
        $(#[$meta])*
        #[allow(unsafe_code, reason = "the level proves that the instruction set is there")]
        #[allow(clippy::too_many_arguments, reason = "a kernel takes its columns")]
        $vis fn $name $(<$($lifetime),*>)? $(<$($Type: $bound),*>)? (level: $crate::Level, $($argument: $type),*) $(-> $output)? {
            #[inline(always)]
            #[allow(clippy::too_many_arguments, reason = "a kernel takes its columns")]
            fn body $(<$($lifetime),*>)? $(<$($Type: $bound),*>)? ($($argument: $type),*) $(-> $output)? $body

            #[cfg(target_arch = "x86_64")]
            {
                #[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
                #[allow(clippy::too_many_arguments, reason = "a kernel takes its columns")]
                fn avx2 $(<$($lifetime),*>)? $(<$($Type: $bound),*>)? ($($argument: $type),*) $(-> $output)? {
                    body($($argument),*)
                }
                #[target_feature(enable = "avx512f,avx512vl,avx512dq,avx512bw,avx512cd,avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
                #[allow(clippy::too_many_arguments, reason = "a kernel takes its columns")]
                fn avx512 $(<$($lifetime),*>)? $(<$($Type: $bound),*>)? ($($argument: $type),*) $(-> $output)? {
                    body($($argument),*)
                }
                if level.has_avx512() {
                    // SAFETY: a `Level` exists only for instruction sets that this machine has.
                    return unsafe { avx512($($argument),*) };
                }
                if level.has_avx2() {
                    // SAFETY: as above.
                    return unsafe { avx2($($argument),*) };
                }
            }
            let _ = level;
            body($($argument),*)
        }
    )*};
}

#[cfg(test)]
mod tests {
    use super::Level;

    dispatch! {
        /// A sum in a fixed order.
        fn dot(a: &[f32], b: &[f32]) -> f32 {
            let mut sum = [0.0f32; 8];
            for (a, b) in a.chunks_exact(8).zip(b.chunks_exact(8)) {
                for i in 0..8 {
                    sum[i] += a[i] * b[i];
                }
            }
            sum.iter().sum()
        }
    }

    #[test]
    fn levels_agree_to_the_bit() {
        let a: Vec<f32> = (0..1024).map(|i| (i as f32 + 0.1).sqrt()).collect();
        let b: Vec<f32> = (0..1024).map(|i| 1.0 / (i as f32 + 0.3)).collect();
        let expected = dot(Level::BASELINE, &a, &b);
        for level in Level::available() {
            assert_eq!(dot(level, &a, &b).to_bits(), expected.to_bits(), "{level:?}");
        }
    }

    #[test]
    fn names_find_their_levels() {
        for level in Level::available() {
            assert_eq!(Level::named(level.name()), Some(level));
        }
        assert_eq!(Level::named("avx1024"), None);
        assert_eq!(Level::available().last(), Some(&Level::detect()));
    }
}
