//! When a part of a moving shape first comes near a part of another.

use crate::{Motion, Sweep, Toi};
use rockfall_math::{Aabb, Vec3};
use rockfall_shape::{Part, Shape};

/// The first time that `impact`, of two shapes on their ways and the target distance, tells of a part, where one of the two shapes is a compound.
pub(crate) fn first_impact(
    a: &Shape,
    b: &Shape,
    sweep: &Sweep,
    target_distance: f32,
    impact: impl Fn(&Shape, &Shape, &Sweep, f32) -> Option<Toi>,
) -> Option<Toi> {
    let Sweep { a: motion_a, b: motion_b } = *sweep;
    let sweeps: Vec<(&Shape, &Shape, Sweep)> = match (a, b) {
        (_, Shape::Compound(compound)) => {
            let mut numbers: Vec<u32> = Vec::new();
            compound.tree().query(&passed(a, sweep, target_distance), |number| numbers.push(number));
            numbers.sort_unstable();
            let parts = numbers.into_iter().map(|number| &compound.parts()[number as usize]);
            parts.map(|part| (a, &part.shape, Sweep { b: of_part(&motion_b, part), ..*sweep })).collect()
        }
        (Shape::Compound(compound), _) => {
            let parts = compound.parts().iter();
            parts.map(|part| (&part.shape, b, Sweep { a: of_part(&motion_a, part), ..*sweep })).collect()
        }
        _ => return None,
    };
    let tois = sweeps.into_iter().filter_map(|(a, b, sweep)| impact(a, b, &sweep, target_distance));
    tois.reduce(|first, other| if other.time < first.time { other } else { first })
}

/// The motion of a part of what moves.
fn of_part(whole: &Motion, part: &Part) -> Motion {
    Motion {
        start: whole.start.then_after(&part.place),
        center: part.place.inverse_point(whole.center),
        ..*whole
    }
}

/// The part of B's frame that A passes through.
fn passed(a: &Shape, Sweep { a: motion_a, b: motion_b }: &Sweep, target: f32) -> Aabb {
    let start = motion_a.start.point(motion_a.center);
    let way = motion_a.translation - motion_b.translation;
    let ends = [start, start + way].map(|p| motion_b.start.inverse_point(p));
    // A turn of B moves A's centre, seen from B, on an arc around B's centre.
    let arm = ends.iter().fold(0.0_f32, |arm, p: &Vec3| arm.max(p.distance(motion_b.center)));
    let reach = a.radius_about(motion_a.center) + motion_b.rotation.length() * arm;
    let size = ends[0].abs().max(ends[1].abs()).max_element();
    Aabb::from_points(ends).grown(1.01 * reach + 1.1 * target + 1e-5 * size)
}
