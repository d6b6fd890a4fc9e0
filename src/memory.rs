//! Memory for the program's solve, taken in large pages before anything needs it.
//!
//! A process that lives for milliseconds spends a good part of them on its first touch of every page of 4 kB: 5,500 of them in a
//! stack of 36 cells, a third of its solve. Where the system hands out pages of 2 MB to those who ask, the first part of the
//! heap is asked for as such. Nothing is touched by that, so what is not used costs nothing.

#![allow(unsafe_code, reason = "the heap's own calls have no safe form")]

/// Takes the heap's first part in large pages, where the system has them. To be called once, before other threads begin.
pub fn reserve() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    heap::reserve();
}

#[cfg(all(target_os = "linux", target_env = "gnu"))]
mod heap {
    /// Blocks that the heap is made to grow by, and their size in bytes: a little less than what the allocator would map apart.
    const BLOCKS: usize = 4;
    const BLOCK: usize = 31 << 20;
    /// Blocks of at least this size are mapped apart, the most that the allocator accepts.
    const APART: libc::c_int = 32 << 20;
    /// So much of the heap's end may be free before it is given back.
    const KEPT: libc::c_int = 1 << 30;
    /// Size of a large page in bytes.
    const PAGE: usize = 2 << 20;

    pub(super) fn reserve() {
        // SAFETY: both options take any number and concern later calls alone; blocks are freed once and never read or written.
        // The advice covers whole pages between the first block and the last, all of them the heap's, and changes no content.
        unsafe {
            libc::mallopt(libc::M_MMAP_THRESHOLD, APART);
            libc::mallopt(libc::M_TRIM_THRESHOLD, KEPT);
            let blocks: [*mut libc::c_void; BLOCKS] = std::array::from_fn(|_| libc::malloc(BLOCK));
            let row = blocks.windows(2).all(|pair| {
                let apart = (pair[1] as usize).wrapping_sub(pair[0] as usize);
                (BLOCK..BLOCK + PAGE).contains(&apart)
            });
            if row && !blocks[0].is_null() {
                let first = (blocks[0] as usize).next_multiple_of(PAGE);
                let end = (blocks[BLOCKS - 1] as usize + BLOCK) / PAGE * PAGE;
                libc::madvise(first as *mut libc::c_void, end - first, libc::MADV_HUGEPAGE);
            }
            blocks.into_iter().for_each(|block| libc::free(block));
        }
    }
}
