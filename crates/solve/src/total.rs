//! The normal impulses of a whole step, for who asks: those of its sub-steps, and of the bounce, added up.
//!
//! Blocks hold the impulses of one sub-step. The sums lie beside them, block by block, and are made by a pass of their own, which only reads:
//! who asks changes no motion, and who does not ask pays nothing.

use crate::block::{Block, Column, LANES};
use crate::contacts::Contacts;
use crate::shelf::{Class, Lane};
use rayon::prelude::*;
use rockfall_math::share::Share;

/// Sums for the blocks of each class.
#[derive(Debug, Default)]
pub(crate) struct Totals {
    ball: Vec<[Column; 1]>,
    one: Vec<[Column; 1]>,
    two: Vec<[Column; 2]>,
    four: Vec<[Column; 4]>,
}

impl Totals {
    /// Bytes held.
    pub(crate) fn memory(&self) -> usize {
        let columns =
            self.ball.capacity() + self.one.capacity() + 2 * self.two.capacity() + 4 * self.four.capacity();
        columns * size_of::<Column>()
    }
}

impl Contacts {
    /// Whether the normal impulses of each step are to be added up.
    pub fn keep_totals(&mut self, keep: bool) {
        if keep != self.totals.is_some() {
            self.totals = keep.then(Totals::default);
        }
    }

    /// The normal impulses of the points of a contact, added up over the last step, N s; nothing where they are not kept.
    pub fn total(&self, at: Lane) -> Option<[f32; 4]> {
        fn of<const P: usize>(totals: &[[Column; P]], at: Lane) -> Option<[f32; 4]> {
            let block = totals.get(at.block())?;
            Some(std::array::from_fn(|p| block.get(p).map_or(0.0, |column| column[at.lane()])))
        }
        let totals = self.totals.as_ref()?;
        match at.class() {
            Class::Ball => of(&totals.ball, at),
            Class::One => of(&totals.one, at),
            Class::Two => of(&totals.two, at),
            Class::Four => of(&totals.four, at),
        }
    }

    /// A step begins.
    pub(crate) fn clear_totals(&mut self) {
        fn clear<const P: usize>(totals: &mut Vec<[Column; P]>, blocks: usize) {
            totals.clear();
            totals.resize(blocks, [[0.0; LANES]; P]);
        }
        if let Some(totals) = &mut self.totals {
            clear(&mut totals.ball, self.ball.blocks.len());
            clear(&mut totals.one, self.one.blocks.len());
            clear(&mut totals.two, self.two.blocks.len());
            clear(&mut totals.four, self.four.blocks.len());
        }
    }

    /// A sub-step ends.
    pub(crate) fn add_up(&mut self) {
        fn add<const P: usize, const T: usize>(totals: &mut [[Column; P]], blocks: &[Block<P, T>]) {
            totals.par_iter_mut().zip(blocks).with_min_len(64).shared().for_each(|(total, block)| {
                let sums = total.as_flattened_mut().iter_mut();
                sums.zip(block.impulses.as_flattened()).for_each(|(sum, impulse)| *sum += impulse);
            });
        }
        if let Some(totals) = &mut self.totals {
            add(&mut totals.ball, &self.ball.blocks);
            add(&mut totals.one, &self.one.blocks);
            add(&mut totals.two, &self.two.blocks);
            add(&mut totals.four, &self.four.blocks);
        }
    }
}
