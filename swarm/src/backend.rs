//! Which instructions hot code is compiled for, chosen when the program starts.

/// Which instructions the step loop is compiled for. All give the same bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Backend {
    /// The baseline of the target.
    Portable,
    /// 256-bit vectors.
    Avx2,
}

/// Work that is compiled once for each backend: `run` has to be `#[inline(always)]`.
pub(crate) trait Compiled {
    /// What it gives.
    type Output;

    /// Does it.
    fn run(self) -> Self::Output;
}

impl Backend {
    /// The best that this machine has.
    pub fn detect() -> Self {
        #[cfg(target_arch = "x86_64")]
        if std::arch::is_x86_feature_detected!("avx2") {
            return Backend::Avx2;
        }
        Backend::Portable
    }

    /// The backend itself where this machine has it, else the baseline.
    pub fn or_portable(self) -> Self {
        match self {
            Backend::Avx2 => Backend::detect(),
            Backend::Portable => Backend::Portable,
        }
    }

    /// Does work with these instructions. A backend that this machine lacks is not used.
    #[inline(always)]
    pub(crate) fn run<W: Compiled>(self, work: W) -> W::Output {
        match self.or_portable() {
            #[cfg(target_arch = "x86_64")]
            // SAFETY: `or_portable` gives `Avx2` after detection alone.
            Backend::Avx2 => unsafe { with_avx2(work) },
            _ => work.run(),
        }
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn with_avx2<W: Compiled>(work: W) -> W::Output {
    work.run()
}
