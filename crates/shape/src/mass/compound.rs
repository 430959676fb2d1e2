//! Several solids as one: sums of masses and first moments, and inertias moved to the common centre (Huygens and Steiner).

use super::MassProperties;
use rockfall_math::{DVec3, Mat3, Pose, Vec3};

/// Mass properties of solids, each in its place.
pub(crate) fn sum(solids: &[(MassProperties, Pose)]) -> MassProperties {
    let placed: Vec<Placed> = solids.iter().map(|(solid, pose)| Placed::new(solid, pose)).collect();
    let mass: f64 = placed.iter().map(|p| p.mass).sum();
    let center = placed.iter().map(|p| p.mass * p.center).sum::<DVec3>() / mass;
    let (mut diagonal, mut products) = (DVec3::ZERO, DVec3::ZERO);
    for p in &placed {
        let d = p.center - center;
        let s = d * d;
        diagonal += p.diagonal + p.mass * DVec3::new(s.y + s.z, s.z + s.x, s.x + s.y);
        products += p.products - p.mass * DVec3::new(d.y * d.z, d.z * d.x, d.x * d.y);
    }
    MassProperties::new(mass, center, diagonal, products)
}

/// A solid in the frame of the whole.
struct Placed {
    mass: f64,
    center: DVec3,
    /// About its own centre of mass.
    diagonal: DVec3,
    /// Off the diagonal: yz, zx, xy.
    products: DVec3,
}

impl Placed {
    fn new(solid: &MassProperties, pose: &Pose) -> Self {
        let turn = rows(&Mat3::from_quat(pose.rotation));
        let axis = |v: Vec3| turn.map(|row| row.dot(v.as_dvec3()));
        // R I, then R I Rᵀ.
        let [x, y, z] = solid.inertia.to_cols_array_2d().map(|column| axis(Vec3::from_array(column)));
        let half: [DVec3; 3] = std::array::from_fn(|i| DVec3::new(x[i], y[i], z[i]));
        let entry = |i: usize, j: usize| half[i].dot(turn[j]);
        Placed {
            mass: f64::from(solid.mass),
            center: pose.position + DVec3::from_array(axis(solid.center)),
            diagonal: DVec3::new(entry(0, 0), entry(1, 1), entry(2, 2)),
            products: DVec3::new(entry(1, 2), entry(2, 0), entry(0, 1)),
        }
    }
}

fn rows(m: &Mat3) -> [DVec3; 3] {
    let t = m.transpose();
    [t.x_axis, t.y_axis, t.z_axis].map(|row| row.as_dvec3())
}
