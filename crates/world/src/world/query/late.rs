//! Bodies that are not where the trees of the last step have them.
//!
//! Boxes are made at the start of a step and have room for slow motion, so that after it nearly all bodies are still in theirs; the way
//! that each has left (`spares`) tells for most of them without a look. The others, bodies that were put somewhere else and bodies that
//! came since have a small tree of their own, which is made when the first query after the change comes. Height fields are in it too:
//! they are solid below their boxes.

use crate::bodies::State;
use crate::recall::way;
use crate::{Kind, Shape, World};
use rayon::prelude::*;
use rockfall_math::Aabb;
use rockfall_shape::UNBOUNDED;
use rockfall_tree::Tree;

/// Rows that the trees do not have, or have in the wrong place.
#[derive(Debug, Default)]
pub(crate) struct Late {
    /// Ascending.
    pub(crate) rows: Vec<u32>,
    /// Over places in `rows`.
    pub(crate) tree: Tree,
    /// A bit for each row; nothing where no row is late.
    marks: Vec<u64>,
}

impl Late {
    #[inline]
    pub(crate) fn contains(&self, row: u32) -> bool {
        self.marks.get(row as usize / 64).is_some_and(|bits| bits >> (row % 64) & 1 == 1)
    }

    /// Bytes held.
    pub(crate) fn memory(&self) -> usize {
        self.rows.capacity() * size_of::<u32>()
            + self.tree.memory()
            + self.marks.capacity() * size_of::<u64>()
    }
}

impl World {
    /// Who is late now.
    pub(crate) fn late(&self) -> &Late {
        self.late.get_or_init(|| self.pool.install(|| self.find_late()))
    }

    fn find_late(&self) -> Late {
        let old = self.bodies.rows() - self.fresh;
        let drifted = self.drifted.get_or_init(|| {
            let fields = self.shapes.iter().any(|shape| matches!(shape, Shape::HeightField(_)));
            let rows = (1..old as u32).into_par_iter().with_min_len(4096);
            rows.filter(|&row| {
                self.has_left(row as usize)
                    || fields && matches!(self.shape_of(row as usize), Some(Shape::HeightField(_)))
            })
            .collect()
        });
        let alive = |row: &u32| self.bodies.states[*row as usize] != State::Dead;
        let come = old as u32..self.bodies.rows() as u32;
        let mut rows: Vec<u32> =
            drifted.iter().copied().chain(self.stirred.iter().copied()).chain(come).filter(alive).collect();
        rows.sort_unstable();
        rows.dedup();
        let boxes: Vec<Aabb> =
            rows.par_iter().with_min_len(256).map(|&row| self.tight(row as usize)).collect();
        let last = rows.last().map_or(0, |&row| row as usize / 64 + 1);
        let mut marks = vec![0_u64; last];
        for &row in &rows {
            marks[row as usize / 64] |= 1 << (row % 64);
        }
        Late { tree: Tree::build(&boxes), rows, marks }
    }

    /// Whether a body has left the box that the last step made for it.
    fn has_left(&self, row: usize) -> bool {
        let bodies = &self.bodies;
        if bodies.kinds[row] == Kind::Static || bodies.states[row] == State::Dead {
            return false;
        }
        let radius = if bodies.balls[row] { 0.0 } else { bodies.radii[row] };
        let gone = way(&bodies.drifts[row], radius);
        gone >= bodies.spares[row] && !bodies.boxes[row].contains(&self.tight(row))
    }

    /// The box that a query looks for.
    fn tight(&self, row: usize) -> Aabb {
        let pose = self.bodies.shape_pose(row);
        match self.shape_of(row) {
            Some(Shape::HeightField(field)) => {
                let bounds = field.bounds;
                let below = bounds.min.with_z(-UNBOUNDED);
                Aabb::new(below, bounds.max)
                    .placed(&pose)
                    .union(&Shape::HeightField(field.clone()).placed_bounds(&pose))
            }
            Some(shape) => shape.placed_bounds(&pose),
            None => Aabb::EMPTY,
        }
    }

    fn shape_of(&self, row: usize) -> Option<&Shape> {
        self.shapes.get(self.bodies.shapes[row] as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Body, Filter, Material, Ray, Settings};
    use rockfall_math::{DVec3, Pose, Vec3};

    /// A light ball that is hit in the course of a step leaves the box that it had at rest.
    #[test]
    fn a_body_that_leaves_its_box_within_a_step_is_found_where_it_is() {
        let settings = Settings { gravity: Vec3::ZERO, threads: 1, ..Settings::default() };
        let mut world = World::new(settings).expect("good settings");
        let stuff = Material { restitution: 1.0, ..Material::default() };
        let (rock, foam) =
            (world.add_material(stuff), world.add_material(Material { density: 1.0, ..stuff }));
        let ball = world.add_shape(Shape::Sphere { radius: 0.5 }).expect("a ball");
        let at = |x: f64| Pose::at(DVec3::new(x, 0.0, 0.0));
        let thrown = Body { velocity: Vec3::X * 12.0, ..Body::new(ball, rock.expect("a material"), at(0.0)) };
        world.spawn(thrown).expect("a body");
        let light = world.spawn(Body::new(ball, foam.expect("a material"), at(1.3))).expect("a body");
        let mut late = 0;
        for _ in 0..8 {
            world.step();
            let row = world.row(light).expect("it is there") as u32;
            late += usize::from(world.late().contains(row));
            let x = world.pose(light).expect("it is there").position.x;
            let from_above = Ray::new(DVec3::new(x, 0.0, 3.0), Vec3::NEG_Z);
            let hit = world.cast_ray(&from_above, &Filter::default()).expect("the ball is below");
            assert!(hit.body == light && (hit.distance - 2.5).abs() < 1e-6, "{hit:?}");
        }
        assert!(late > 0, "it never left its box, so this tests nothing");
    }
}
