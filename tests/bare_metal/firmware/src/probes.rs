//! What must be found: a panic and an allocation.

use alloc::alloc::{GlobalAlloc, Layout};
use alloc::boxed::Box;

/// An index that may be out of bounds.
#[unsafe(no_mangle)]
pub extern "C" fn probe_panics(numbers: &[f64; 8], index: usize) -> f64 {
    numbers[index]
}

/// A division that may be by zero.
#[unsafe(no_mangle)]
pub extern "C" fn probe_divides(number: usize, by: usize) -> usize {
    number / by
}

/// A panic behind a pointer that only a table of functions holds.
#[unsafe(no_mangle)]
pub extern "C" fn probe_panics_indirectly(index: usize) -> f64 {
    static TABLE: [fn(usize) -> f64; 2] =
        [|index| if index > 3 { 1.0 } else { 2.0 }, |index| [1.0, 2.0, 3.0][index]];
    TABLE[index & 1](index)
}

/// A number on the heap.
#[unsafe(no_mangle)]
pub extern "C" fn probe_allocates(number: f64) -> *mut f64 {
    Box::into_raw(Box::new(number))
}

/// Has nothing to give.
struct Empty;

// SAFETY: a null pointer is how an allocator refuses.
unsafe impl GlobalAlloc for Empty {
    unsafe fn alloc(&self, _: Layout) -> *mut u8 {
        core::ptr::null_mut()
    }

    unsafe fn dealloc(&self, _: *mut u8, _: Layout) {}
}

#[global_allocator]
static EMPTY: Empty = Empty;
