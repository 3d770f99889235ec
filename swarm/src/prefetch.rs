//! Asking for memory before it is needed, where many robots' learners do not fit the caches.

/// Bytes of a cache line.
#[cfg(target_arch = "x86_64")]
const LINE_BYTES: usize = 64;

/// Asks for every cache line of a value or slice; reads nothing.
#[inline(always)]
pub fn prefetch<T: ?Sized>(value: &T) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        let first = std::ptr::from_ref(value).cast::<i8>();
        let bytes = size_of_val(value);
        let mut at = 0;
        while at < bytes {
            // SAFETY: a prefetch reads nothing, and the address lies inside `value`.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(first.add(at)) };
            at += LINE_BYTES;
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = value;
}
