//! Memory in large pages.
//!
//! Incoherent rays touch blocks all over a tree; with pages of 4 KiB most of those are not in the address cache (15 to 40 % of
//! the time of such rays on a million triangles). Linux gives pages of 2 MiB to who asks; elsewhere nothing is asked.
#![expect(unsafe_code, reason = "asking for large pages is a system call")]

/// Moves items to memory for which large pages are asked.
pub(crate) fn in_large_pages<T: Copy>(items: Vec<T>) -> Vec<T> {
    let mut moved = Vec::new();
    // Without memory for a moment of both, the old place will do.
    if size_of_val(&*items) < PAGE || moved.try_reserve_exact(items.len()).is_err() {
        return items;
    }
    ask(moved.as_mut_ptr(), size_of_val(&*items));
    moved.extend_from_slice(&items);
    moved
}

/// A large page.
const PAGE: usize = 2 << 20;

#[cfg(target_os = "linux")]
fn ask<T>(start: *mut T, bytes: usize) {
    let first = start.addr().next_multiple_of(4096);
    let length = (bytes - (first - start.addr())) & !4095;
    // SAFETY: the range lies in one allocation of ours, and advice changes nothing that is stored there.
    unsafe {
        libc::madvise(start.with_addr(first).cast(), length, libc::MADV_HUGEPAGE);
    }
}

#[cfg(not(target_os = "linux"))]
fn ask<T>(_start: *mut T, _bytes: usize) {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn items_stay_the_same() {
        for count in [0u32, 10, 3_000_000] {
            let items: Vec<u32> = (0..count).collect();
            assert!(in_large_pages(items.clone()) == items);
        }
    }
}
