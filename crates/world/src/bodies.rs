//! The bodies' columns: one row a body, row 0 the world itself.

use crate::slender::{is_slender, over_turn};
use crate::{Body, Kind};
use rayon::prelude::*;
use rockfall_math::lanes::Row;
use rockfall_math::share::Share;
use rockfall_math::snapshot::{Error, Reader, Writer};
use rockfall_math::stored_byte;
use rockfall_math::{Aabb, DVec3, Mat3, Pose, Quat, Vec3, rotation};
use rockfall_solve::line::Role;
use rockfall_solve::{Columns, Drift, FIXED, Line};

/// Whether a body takes part.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum State {
    /// In motion, or about to be.
    #[default]
    Awake,
    /// At rest with its whole island.
    Asleep,
    /// Its state was not finite; it is left where it was.
    Frozen,
    /// Removed; the row goes with the next step.
    Dead,
}

stored_byte!(Kind: "kind", Kind::Dynamic = 0, Kind::Kinematic = 1, Kind::Static = 2);
stored_byte!(State: "state", State::Awake = 0, State::Asleep = 1, State::Frozen = 2, State::Dead = 3);

/// Declares the columns once; everything that must treat all of them alike is made from the list.
macro_rules! columns {
    ($($(#[$doc:meta])* $name:ident: $type:ty = $world:expr),* $(,)?) => {
        /// All columns, of one length.
        #[derive(Debug)]
        pub(crate) struct Bodies {
            $($(#[$doc])* pub(crate) $name: Vec<$type>,)*
        }

        /// One row of every column.
        pub(crate) struct BodyRow {
            $(pub(crate) $name: $type,)*
        }

        impl BodyRow {
            /// The world: immobile, without shape, read by all and written by none.
            fn world() -> Self {
                BodyRow { $($name: $world,)* }
            }
        }

        impl Bodies {
            /// Row 0 alone.
            pub(crate) fn new() -> Self {
                let BodyRow { $($name,)* } = BodyRow::world();
                Bodies { $($name: vec![$name],)* }
            }

            /// Adds a row.
            pub(crate) fn push(&mut self, row: BodyRow) {
                $(self.$name.push(row.$name);)*
            }

            /// Row i becomes what was row `order[i]`; rows that `order` does not name are gone.
            pub(crate) fn reorder(&mut self, order: &[u32]) {
                let rows = || order.par_iter().with_min_len(4096).shared();
                $(self.$name = rows().map(|&i| self.$name[i as usize].clone()).collect();)*
            }

            /// Writes all columns.
            pub(crate) fn save(&self, to: &mut Writer<'_>) -> Result<(), Error> {
                $(to.column(stringify!($name), &self.$name)?;)*
                Ok(())
            }

            fn read(from: &mut Reader<'_>) -> Result<Self, Error> {
                let mut rows = None;
                $(
                    let $name: Vec<$type> = match rows {
                        None => from.column(stringify!($name))?,
                        Some(rows) => from.column_of(stringify!($name), rows)?,
                    };
                    rows = Some($name.len());
                )*
                let _ = rows;
                Ok(Bodies { $($name,)* })
            }

            /// Bytes held.
            pub(crate) fn memory(&self) -> usize {
                0 $(+ self.$name.capacity() * size_of::<$type>())*
            }
        }
    };
}

columns! {
    /// The user's names.
    ids: u64 = u64::MAX,
    /// Number under which the row is looked up; it stays when rows are sorted.
    slots: u32 = 0,
    /// Who moves.
    kinds: Kind = Kind::Static,
    /// Who takes part.
    states: State = State::Awake,
    /// The two above, for the solver.
    roles: Role = Role::Still,
    /// Centres of mass, metres.
    positions: DVec3 = DVec3::ZERO,
    /// Body to world.
    rotations: Quat = Quat::IDENTITY,
    /// Velocities, inverse mass and inverse inertia in world axes.
    lines: Line = Line::default(),
    /// Motion within a step.
    drifts: Drift = Drift::default(),
    /// See `rockfall_solve::push`.
    references: Row = [0.0; 8],
    /// Principal axes to body.
    frames: Quat = Quat::IDENTITY,
    /// Inverse principal moments, 1/(kg m²).
    inverse_moments: Vec3 = Vec3::ZERO,
    /// Distance from the centre of mass to the farthest point, metres.
    radii: f32 = 0.0,
    /// Radius of a ball that fits inside, metres; 0 for surfaces.
    inners: f32 = 0.0,
    /// Whether the body is a ball about its centre of mass, with the same inertia about all axes: turning it changes nothing that can
    /// be seen.
    balls: bool = false,
    /// Centre of mass in the frame of the shape, metres.
    centers: Vec3 = Vec3::ZERO,
    /// Linear and angular, 1/s.
    dampings: [f32; 2] = [0.0; 2],
    /// See [`Columns::locks`].
    locks: u8 = 0,
    /// Index of the shape.
    shapes: u32 = u32::MAX,
    /// Index of the material.
    materials: u32 = 0,
    /// Group and mask.
    filters: [u32; 2] = [0; 2],
    /// Seconds at rest.
    rests: f32 = 0.0,
    /// The step after the last in which [`crate::sweep`] stopped a thin body.
    stops: u32 = u32::MAX,
    /// How far outside of the surface a contact is made, metres.
    reaches: f32 = 0.0,
    /// Way gone so far, and what was added to the reach; see `crate::recall`.
    ways: u32 = 0,
    /// Way, in the same counts, that the body surely has left in its box.
    spares: u32 = 0,
    /// What the broad phase sees: a box with room to move in.
    boxes: Aabb = Aabb::EMPTY,
}

impl Bodies {
    /// Reads all columns, of a world with so many shapes and materials.
    pub(crate) fn load(from: &mut Reader<'_>, shapes: usize, materials: usize) -> Result<Self, Error> {
        let bodies = Bodies::read(from)?;
        let world = bodies.kinds.first() == Some(&Kind::Static) && bodies.states[0] != State::Dead;
        Error::unless(
            world && bodies.rows() < FIXED as usize,
            "ids",
            "no row of the world, or too many rows",
        )?;
        let known = |column: &[u32], count: usize| column[1..].iter().all(|&index| (index as usize) < count);
        Error::unless(known(&bodies.shapes, shapes), "shapes", "a shape that is not there")?;
        Error::unless(known(&bodies.materials, materials), "materials", "a material that is not there")?;
        Ok(bodies)
    }

    /// Number of rows, the world's and dead ones included.
    pub(crate) fn rows(&self) -> usize {
        self.ids.len()
    }

    /// Whether forces or a velocity can move the body of a row.
    pub(crate) fn is_mover(&self, row: usize) -> bool {
        self.kinds[row] != Kind::Static
    }

    /// The frame of the shape in the world.
    #[inline]
    pub(crate) fn shape_pose(&self, row: usize) -> Pose {
        let rotation = self.rotations[row];
        let center = rotation::rotate(rotation, self.centers[row]);
        Pose { position: self.positions[row] - center.as_dvec3(), rotation }
    }

    /// Inverse inertia in world axes, locked rotations taken out.
    pub(crate) fn world_inverse_inertia(&self, row: usize) -> Mat3 {
        self.turned_inverse_inertia(row, self.inverse_moments[row])
    }

    /// The same over a step of `dt` seconds; see [`crate::slender`].
    pub(crate) fn inverse_inertia_over(&self, row: usize, line: &Line, dt: f32) -> Mat3 {
        let moments = self.inverse_moments[row];
        if !is_slender(moments) {
            return self.turned_inverse_inertia(row, moments);
        }
        let frame = rotation::compose(self.rotations[row], self.frames[row]);
        let turn = rotation::rotate_back(frame, line.angular_velocity()) * dt;
        let tip = line.velocity().length() * dt / self.radii[row];
        self.turned_inverse_inertia(row, over_turn(moments, turn.abs() + tip))
    }

    /// Of a body with these inverse moments.
    fn turned_inverse_inertia(&self, row: usize, moments: Vec3) -> Mat3 {
        let locks = self.locks[row] >> 3;
        if moments.x == moments.y && moments.y == moments.z && locks == 0 {
            return Mat3::from_diagonal(moments);
        }
        let axes = Mat3::from_quat(rotation::compose(self.rotations[row], self.frames[row]));
        let scaled =
            Mat3::from_cols(axes.x_axis * moments.x, axes.y_axis * moments.y, axes.z_axis * moments.z);
        let mut m = scaled * axes.transpose();
        for axis in 0..3 {
            // A rotation that is locked is a constraint; its impulse is eliminated (Schur complement).
            if locks >> axis & 1 == 1 {
                let column = m.col(axis);
                let diagonal = column[axis];
                if diagonal > 0.0 {
                    let outer = |x: f32| column * (x / diagonal);
                    m = Mat3::from_cols(
                        m.x_axis - outer(column.x),
                        m.y_axis - outer(column.y),
                        m.z_axis - outer(column.z),
                    );
                }
            }
        }
        m
    }

    /// The columns that the solver sees, in a step that began with the rotations `starts`.
    pub(crate) fn solver_columns<'a>(&'a mut self, starts: &'a [Quat]) -> Columns<'a> {
        Columns {
            lines: &mut self.lines,
            drifts: &mut self.drifts,
            references: &mut self.references,
            rotations: &mut self.rotations,
            starts,
            frames: &self.frames,
            inverse_moments: &self.inverse_moments,
            dampings: &self.dampings,
            roles: &self.roles,
            locks: &self.locks,
        }
    }
}

/// Mass properties of a body, ready for its row.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Mass {
    pub(crate) inverse_mass: f32,
    pub(crate) inverse_moments: Vec3,
    pub(crate) frame: Quat,
    pub(crate) center: Vec3,
    pub(crate) radius: f32,
    /// Radius of a ball that fits inside of the shape, metres; 0 for surfaces.
    pub(crate) inner_radius: f32,
    /// Whether the shape is a sphere.
    pub(crate) sphere: bool,
}

impl BodyRow {
    /// The row of a body whose numbers have been checked.
    pub(crate) fn of(body: &Body, id: u64, slot: u32, mass: &Mass) -> Self {
        let rotation = rotation::normalize(body.pose.rotation);
        let center = rotation::rotate(rotation, mass.center);
        let moves = body.kind == Kind::Dynamic;
        let mut line = Line::default();
        if body.kind != Kind::Static {
            line.set_velocities(body.velocity, body.angular_velocity);
        }
        line.motion[6] = if moves { mass.inverse_mass } else { 0.0 };
        line.motion[7] = if moves { body.gravity_scale } else { 0.0 };
        let bit = |i: usize, set: bool| u8::from(set) << i;
        let locks = (0..3)
            .map(|i| bit(i, body.locks.linear[i]) | bit(3 + i, body.locks.angular[i]))
            .fold(0, |all, bits| all | bits);
        let inverse_moments = if moves { mass.inverse_moments } else { Vec3::ZERO };
        let even = inverse_moments == Vec3::splat(inverse_moments.x) && locks >> 3 == 0;
        BodyRow {
            ids: id,
            slots: slot,
            kinds: body.kind,
            positions: body.pose.position + center.as_dvec3(),
            rotations: rotation,
            lines: line,
            frames: mass.frame,
            inverse_moments,
            radii: mass.radius,
            inners: mass.inner_radius,
            balls: mass.sphere && mass.center == Vec3::ZERO && even,
            centers: mass.center,
            dampings: [body.linear_damping, body.angular_damping],
            locks,
            shapes: body.shape.0,
            materials: body.material.0,
            // Nothing collides with a sensor, nor a sensor with anything.
            filters: [body.group, if body.sensor { 0 } else { body.mask }],
            ..BodyRow::world()
        }
    }
}
