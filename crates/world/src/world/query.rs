//! Questions to a world between two steps: rays, shapes on their way, overlaps, nearest points.
//!
//! All of them go over the same trees as the broad phase. These date from the start of the last step; [`late`] has what is not where they
//! say. A batch is answered by all threads, each answer by one, in the order of the questions: nothing depends on the number of threads.
//! Of several bodies at the same distance it is the one with the smallest id.

pub(crate) mod late;
mod lists;
mod points;
mod rays;
mod shapes;

pub use lists::Lists;
pub use points::PointHit;
pub use rays::{Ray, RayHit};
pub use shapes::{Cast, CastHit, Penetration};

use crate::bodies::{Bodies, State};
use crate::{BodyId, Shape, World};
use late::Late;
use rockfall_collide as collide;
use rockfall_math::{Aabb, DVec3, rotation};
use rockfall_tree::Tree;

/// Questions that one task answers.
const BLOCK: usize = 64;

/// Which bodies a query asks for, by who moves them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Movers {
    /// All.
    #[default]
    All,
    /// Dynamic and kinematic ones.
    Only,
    /// Static ones.
    None,
}

/// Which bodies a query sees. The default sees all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Filter {
    /// Bodies that have one of these groups (see [`Body::group`](crate::Body::group)). With all bits set, as by default, every body, those in no group included.
    pub mask: u32,
    /// By who moves them.
    pub movers: Movers,
    /// All but this one, as the body that looks. Nobody is left out where no body has the id.
    pub except: Option<BodyId>,
}

impl Default for Filter {
    fn default() -> Self {
        Filter { mask: u32::MAX, movers: Movers::All, except: None }
    }
}

impl Filter {
    /// All bodies but one.
    pub fn except(body: BodyId) -> Self {
        Filter { except: Some(body), ..Filter::default() }
    }

    /// Bodies that have one of these groups.
    pub fn groups(mask: u32) -> Self {
        Filter { mask, ..Filter::default() }
    }
}

/// A world as a query sees it.
pub(super) struct View<'a> {
    bodies: &'a Bodies,
    shapes: &'a [Shape],
    late: &'a Late,
    /// Trees, and for each what its items are.
    trees: [(&'a Tree, Items); 3],
    filter: Filter,
    except: u32,
    /// Whether rows of removed bodies are still there.
    dead: bool,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Items {
    /// Rows where the trees say they are, but for those that are late.
    Rows,
    /// Places in the list of those that are late.
    Late,
    /// Filtered out as a whole.
    Unasked,
}

impl World {
    pub(super) fn view(&self, filter: &Filter) -> View<'_> {
        let asked = |movers: bool| match filter.movers {
            Movers::All => Items::Rows,
            Movers::Only if movers => Items::Rows,
            Movers::None if !movers => Items::Rows,
            _ => Items::Unasked,
        };
        let late = self.late();
        let row = filter.except.and_then(|id| self.row(id).ok());
        View {
            bodies: &self.bodies,
            shapes: &self.shapes,
            late,
            trees: [
                (&self.index.fixed, asked(false)),
                (&self.index.movers, asked(true)),
                (&late.tree, Items::Late),
            ],
            filter: *filter,
            // The world itself is no body.
            except: row.unwrap_or(0) as u32,
            dead: self.bodies.rows() - 1 != self.slots.len(),
        }
    }
}

impl View<'_> {
    /// The body that an item of a tree stands for, with its shape, if the filter lets it through.
    #[inline]
    fn body(&self, items: Items, item: u32) -> Option<(u32, &Shape)> {
        let row = match items {
            Items::Rows if self.late.contains(item) => return None,
            Items::Rows => item,
            Items::Late => self.late.rows[item as usize],
            Items::Unasked => return None,
        };
        let i = row as usize;
        if row == self.except
            || self.dead && self.bodies.states[i] == State::Dead
            || self.filter.mask != u32::MAX && self.bodies.filters[i][0] & self.filter.mask == 0
        {
            return None;
        }
        if items == Items::Late && self.filter.movers != Movers::All {
            let only = self.filter.movers == Movers::Only;
            if self.bodies.is_mover(i) != only {
                return None;
            }
        }
        Some((row, self.shapes.get(self.bodies.shapes[i] as usize)?))
    }

    /// The trees that may have answers.
    fn trees(&self) -> impl Iterator<Item = (&Tree, Items)> {
        self.trees.iter().copied().filter(|(tree, items)| !tree.is_empty() && *items != Items::Unasked)
    }

    /// Calls `f` with the row and the shape of all bodies whose boxes meet `area`.
    pub(super) fn within(&self, area: &Aabb, mut f: impl FnMut(usize, &Shape)) {
        for (tree, items) in self.trees() {
            tree.query(area, |item| {
                if let Some((row, shape)) = self.body(items, item) {
                    f(row as usize, shape);
                }
            });
        }
    }

    /// A point of the world in the frame of a body's shape.
    #[inline]
    fn local(&self, row: usize, p: DVec3) -> DVec3 {
        let from_center = p - self.bodies.positions[row];
        rotation::rotate_back_double(self.bodies.rotations[row], from_center)
            + self.bodies.centers[row].as_dvec3()
    }

    fn id(&self, row: u32) -> BodyId {
        BodyId(self.bodies.ids[row as usize])
    }
}

/// The box of single precision around a point; not valid where the point is not finite.
fn around(p: DVec3) -> Aabb {
    Aabb::around(p, p)
}

/// In single precision, not less.
fn up(x: f64) -> f32 {
    let single = x as f32;
    if f64::from(single) < x { single.next_up() } else { single }
}
