//! Convex shapes as the general functions see them: a core that says which of its points is furthest, and a skin.

use crate::ellipsoid;
use crate::gjk::Core;
use crate::poly::{BoxPoly, Poly};
use rockfall_math::{DVec3, Isometry, Vec3};
use rockfall_shape::Frustum;
use smallvec::SmallVec;

/// Corners of the polygon that stands for a disc; a multiple of 4.
const SPOKES: usize = 16;

/// Cosine and sine of the corners of a disc.
pub(crate) const RIM: [[f32; 2]; SPOKES] = {
    const A: f32 = 0.923_879_5;
    const B: f32 = std::f32::consts::FRAC_1_SQRT_2;
    const C: f32 = 0.382_683_43;
    [
        [1.0, 0.0],
        [A, C],
        [B, B],
        [C, A],
        [0.0, 1.0],
        [-C, A],
        [-B, B],
        [-A, C],
        [-1.0, 0.0],
        [-A, -C],
        [-B, -B],
        [-C, -A],
        [0.0, -1.0],
        [C, -A],
        [B, -B],
        [A, -C],
    ]
};

/// A core with a skin around it.
pub(crate) struct Solid<'a> {
    pub(crate) form: Form<'a>,
    /// Thickness of the skin, metres.
    pub(crate) skin: f32,
}

/// What the core is.
#[expect(clippy::large_enum_variant, reason = "one of each body of a pair, on the stack")]
pub(crate) enum Form<'a> {
    /// A segment on the z axis, half its length; a point where that is 0.
    Segment(f32),
    Hull(Poly<'a>),
    Box(BoxPoly),
    Frustum(Frustum),
    /// Half axes.
    Ellipsoid(Vec3),
}

/// A point of a core, with the number of its corner where it has one.
#[derive(Clone, Copy, Default, PartialEq)]
pub(crate) struct Spot {
    point: DVec3,
    name: usize,
}

impl<'a> Solid<'a> {
    pub(crate) fn new(form: Form<'a>, skin: f32) -> Self {
        Solid { form, skin }
    }

    /// The polyhedron that the core is.
    pub(crate) fn poly(&self) -> Option<Poly<'_>> {
        match &self.form {
            Form::Hull(poly) => Some(*poly),
            Form::Box(cuboid) => Some(cuboid.poly()),
            _ => None,
        }
    }

    /// How far the core reaches along a unit vector, and how far it goes the other way: both along `axis`, in a frame
    /// that `pose` maps to.
    pub(crate) fn reach(&self, axis: Vec3, pose: &Isometry) -> f32 {
        let own = pose.inverse_vector(axis);
        let point = self.form.point(self.form.support(own.as_dvec3()));
        point.as_vec3().dot(own) + axis.dot(pose.translation)
    }

    /// A length that is like that of the core.
    pub(crate) fn size(&self) -> f32 {
        match &self.form {
            Form::Segment(half) => *half,
            Form::Frustum(f) => f.half_length + f.widest(),
            Form::Ellipsoid(half) => half.max_element(),
            Form::Hull(_) | Form::Box(_) => self.poly().map_or(0.0, |p| p.vertices[0].length()),
        }
    }

    /// Points of the core, among them all of its corners: a set that is a little smaller where the core is round.
    pub(crate) fn points(&self) -> SmallVec<[Vec3; 32]> {
        let towards = |c: f32, s: f32| DVec3::new(f64::from(c), f64::from(s), 0.0);
        match &self.form {
            Form::Segment(half) => [-*half, *half].map(|z| Vec3::Z * z).into_iter().collect(),
            Form::Hull(_) | Form::Box(_) => {
                self.poly().map_or_else(SmallVec::new, |p| p.vertices.iter().copied().collect())
            }
            Form::Frustum(f) => {
                let rim = |z: f32, r: f32| RIM.iter().map(move |&[c, s]| Vec3::new(r * c, r * s, z));
                rim(-f.half_length, f.lower).chain(rim(f.half_length, f.upper)).collect()
            }
            Form::Ellipsoid(half) => {
                let ring =
                    RIM.iter().flat_map(|&[c, s]| [-1.0, 0.0, 1.0].map(|z| towards(c, s) + DVec3::Z * z));
                ring.chain([DVec3::Z, DVec3::NEG_Z])
                    .map(|d| ellipsoid::support(*half, d * (1.0 / half.as_dvec3())).as_vec3())
                    .collect()
            }
        }
    }

    /// A length below which the core is round or thin, metres.
    pub(crate) fn breadth(&self) -> f32 {
        match &self.form {
            Form::Segment(_) => self.skin,
            Form::Frustum(f) => f.inner_ball().1,
            Form::Ellipsoid(half) => half.min_element(),
            Form::Hull(_) | Form::Box(_) => self.poly().map_or(0.0, |p| p.inner_radius),
        }
    }
}

impl Core for Form<'_> {
    type Vertex = Spot;

    fn support(&self, direction: DVec3) -> Spot {
        let corner = |points: &[Vec3]| {
            let name = points.support(direction);
            Spot { point: points[name].as_dvec3(), name }
        };
        match self {
            Form::Segment(half) => {
                let half = if direction.z < 0.0 { -*half } else { *half };
                Spot { point: DVec3::Z * f64::from(half), name: 0 }
            }
            Form::Hull(poly) => corner(poly.vertices),
            Form::Box(cuboid) => corner(cuboid.poly().vertices),
            Form::Frustum(frustum) => Spot { point: frustum.support(direction), name: 0 },
            Form::Ellipsoid(half) => Spot { point: ellipsoid::support(*half, direction), name: 0 },
        }
    }

    fn first(&self) -> Spot {
        self.support(DVec3::Z)
    }

    fn point(&self, vertex: Spot) -> DVec3 {
        vertex.point
    }

    fn name(vertex: Spot) -> usize {
        vertex.name
    }
}
