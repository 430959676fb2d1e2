//! The shapes of a run as triangles: one surface for each, which bodies of that shape share.

use crate::{Error, Moment, Run, Surface};
use rayon::prelude::*;
use rockfall::Shape;
use rockfall_math::Vec3;

/// Surfaces of shapes, or of what is seen in place of them, in the frame of their bodies.
#[derive(Clone, Debug)]
pub struct Prototypes {
    surfaces: Vec<Option<Surface>>,
}

impl Prototypes {
    /// Those of the bodies `rows` of a run, `of` telling which of the inventory's shapes each body has: those that collide (`shape_of`) or those that are seen (`shown_of`). Half-spaces become squares that reach as far as any body gets at the first and the last frame.
    ///
    /// # Errors
    /// Those of [`Run::inventory`], and of reading the first and the last frame where there is a half-space.
    pub fn of(run: &Run, rows: &[u32], of: &[u32]) -> Result<Self, Error> {
        let inventory = run.inventory()?;
        let mut used = vec![false; inventory.shapes.len()];
        rows.iter().for_each(|&row| used[of[row as usize] as usize] = true);
        let endless = |(used, shape): (&bool, &Shape)| *used && matches!(shape, Shape::HalfSpace { .. });
        let reach = if used.iter().zip(&inventory.shapes).any(endless) { reach(run)? } else { 0.0 };
        let surface = |(used, shape): (&bool, &Shape)| used.then(|| Surface::of(shape, reach));
        Ok(Prototypes { surfaces: used.par_iter().zip(&inventory.shapes).map(surface).collect() })
    }

    /// The same with normals at the corners of all surfaces, where any has them: for files in which all triangles lie in one mesh.
    pub fn alike(self) -> Self {
        if self.iter().all(|(_, surface)| surface.normals.is_empty()) {
            return self;
        }
        Prototypes { surfaces: self.surfaces.iter().map(|s| s.as_ref().map(Surface::shaded)).collect() }
    }

    /// Indices of the shapes and their surfaces, ascending.
    pub fn iter(&self) -> impl Iterator<Item = (u32, &Surface)> {
        (0_u32..).zip(&self.surfaces).filter_map(|(shape, surface)| Some((shape, surface.as_ref()?)))
    }

    /// The surface of a shape; `None` where no body that was asked for has it.
    pub fn get(&self, shape: u32) -> Option<&Surface> {
        self.surfaces.get(shape as usize)?.as_ref()
    }
}

/// The size of a shape along the axes of its frame, metres: that of its box. Zero for a half-space, which has none.
pub fn size(shape: &Shape) -> Vec3 {
    match shape {
        Shape::HalfSpace { .. } => Vec3::ZERO,
        _ => {
            let bounds = shape.bounds();
            bounds.max - bounds.min
        }
    }
}

/// How far a half-space has to be seen, metres: from any half-space to the far side of any other body, at the first and at the last frame.
fn reach(run: &Run) -> Result<f32, Error> {
    let inventory = run.inventory()?;
    let all: Vec<u32> = (0..run.bodies().len() as u32).collect();
    let mut reach = 1.0_f32;
    for frame in [0, run.frames() - 1] {
        let moment = Moment::still(frame, (0.0, &run.poses(frame)?), &all);
        let bodies = || {
            let shape = |row: &u32| &inventory.shapes[inventory.shape_of[*row as usize] as usize];
            moment.rows.iter().map(shape).zip(&moment.positions).map(|(s, p)| (s, Vec3::from_array(*p)))
        };
        for (shape, place) in bodies() {
            let Shape::HalfSpace { offset, .. } = shape else { continue };
            let far =
                bodies().filter(|(shape, _)| !matches!(shape, Shape::HalfSpace { .. })).map(|(shape, p)| {
                    let bounds = shape.bounds();
                    p.distance(place) + bounds.min.abs().max(bounds.max.abs()).length()
                });
            reach = far.map(|far| far + offset.abs()).fold(reach, f32::max);
        }
    }
    Ok(reach)
}
