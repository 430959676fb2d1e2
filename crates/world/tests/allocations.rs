//! A step at rest asks for no memory. In a file of its own: all threads of a process share one count.

mod common;

use common::columns;
use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// The system's allocator, counted.
struct Counted;

static ALLOCATIONS: AtomicUsize = AtomicUsize::new(0);

// SAFETY: hands everything on to the system's allocator.
unsafe impl GlobalAlloc for Counted {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Relaxed);
        // SAFETY: the caller's promise is handed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        // SAFETY: as above.
        unsafe { System.dealloc(memory, layout) }
    }

    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Relaxed);
        // SAFETY: as above.
        unsafe { System.realloc(memory, layout, size) }
    }
}

#[global_allocator]
static COUNTED: Counted = Counted;

/// Promise: a step in which nothing comes and nothing goes asks for no memory. The queue by which a thread from outside reaches
/// the pool takes a block for every 31 calls; so much is let pass.
#[test]
fn a_settled_step_allocates_nothing() {
    let mut stage = columns(20, false);
    stage.steps(300);
    let (mut quiet, mut noisy) = (0, 0);
    for _ in 0..62 {
        // All rows are sorted every 64 steps.
        if stage.world.report().step.is_multiple_of(64) {
            stage.steps(1);
        }
        let before = ALLOCATIONS.load(Relaxed);
        stage.steps(1);
        let count = ALLOCATIONS.load(Relaxed) - before;
        (quiet, noisy) = if count == 0 { (quiet + 1, noisy) } else { (quiet, noisy + count) };
    }
    println!("{quiet} steps without, {noisy} allocations in the others");
    assert!(quiet >= 58 && noisy <= 4, "{quiet} {noisy}");
}
