//! The border to the model checker: inputs, assumptions, failures and memory.
#![expect(unsafe_code, reason = "imports of the model checker, and an allocator")]

use core::alloc::{GlobalAlloc, Layout};
use core::cell::UnsafeCell;
use core::panic::PanicInfo;
use core::sync::atomic::{AtomicUsize, Ordering};

use crate::Cases;

#[link(wasm_import_module = "checker")]
unsafe extern "C" {
    fn any() -> i32;
    fn assume(condition: i32);
    fn fail() -> !;
}

/// All inputs at once.
pub(crate) struct AllInputs;

impl Cases for AllInputs {
    fn int(&mut self, low: i32, high: i32) -> i32 {
        // SAFETY: the model checker defines both functions for all arguments.
        unsafe {
            let value = any();
            assume(i32::from(low <= value && value <= high));
            value
        }
    }

    fn wide(&mut self) -> i64 {
        // SAFETY: the model checker defines this function.
        let (high, low) = unsafe { (any(), any()) };
        i64::from(high) << 32 | i64::from(low.cast_unsigned())
    }
}

#[panic_handler]
fn panicked(_: &PanicInfo<'_>) -> ! {
    // SAFETY: the model checker ends the path here.
    unsafe { fail() }
}

const ARENA: usize = 16 << 10;

#[repr(align(64))]
struct Arena(UnsafeCell<[u8; ARENA]>);

// SAFETY: a harness has one thread.
unsafe impl Sync for Arena {}

static MEMORY: Arena = Arena(UnsafeCell::new([0; ARENA]));
static USED: AtomicUsize = AtomicUsize::new(0);

/// Hands out memory and takes none back, so that addresses are constants for the model checker.
struct Bump;

// SAFETY: each call gets memory of its own, aligned as asked. A call that does not fit fails.
unsafe impl GlobalAlloc for Bump {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let at = USED.load(Ordering::Relaxed).next_multiple_of(layout.align());
        USED.store(at + layout.size(), Ordering::Relaxed);
        if at + layout.size() > ARENA {
            // SAFETY: the model checker ends the path here.
            unsafe { fail() }
        }
        // SAFETY: the end of this block lies within the arena.
        unsafe { MEMORY.0.get().cast::<u8>().add(at) }
    }

    unsafe fn dealloc(&self, _: *mut u8, _: Layout) {}
}

#[global_allocator]
static ALLOCATOR: Bump = Bump;
