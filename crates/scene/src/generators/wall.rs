//! A wall of bricks in running bond: each course is moved by half a brick, with half bricks at its ends.

use super::GeneratorKind;
use crate::body::{MOTION, SURFACE};
use crate::error::Problem;
use crate::node::Table;
use crate::plan::Yard;
use crate::rotation;
use crate::spec::{ANY, NOT_NEGATIVE, POSITIVE, Spec, Ty, key, required};
use rockfall::Shape;
use rockfall_math::{Pose, Vec3, rotation::rotate};

pub(super) static WALL_KEYS: Spec = Spec {
    name: "wall",
    about: "A wall of bricks in running bond, numbered course by course from the bottom.",
    example: r#"[[generators]]
kind = "wall"
length = 20
courses = 30
heading = 90
"#,
    groups: &[
        &[
            key(
                "brick",
                Ty::Numbers(&[3], POSITIVE),
                "[0.24, 0.115, 0.071]",
                "Length, depth, height of a brick, m.",
            ),
            required("length", Ty::Int(1, 4_294_967_295), "Bricks in a course."),
            required("courses", Ty::Int(1, 4_294_967_295), "Courses, one on the other."),
            key("gap", Ty::Number(NOT_NEGATIVE), "0", "Between neighbours in a course, m."),
            key("position", Ty::Numbers(&[3], ANY), "[0, 0, 0]", "Middle of the wall's foot, m."),
            key("heading", Ty::Number(ANY), "0", "The wall runs along x, turned about z by this, degrees."),
        ],
        SURFACE,
        MOTION,
    ],
};

pub(super) static WALL: GeneratorKind = GeneratorKind {
    spec: &WALL_KEYS,
    count: |table| {
        let (length, courses) = (u128::from(table.int("length")), u128::from(table.int("courses")));
        // Every second course has one more: two halves instead of one whole.
        length * courses + courses / 2
    },
    check: |table| {
        if table.f64("gap") < 0.9 * table.numbers("brick")[0] {
            return Ok(());
        }
        let message = format!("`{}` leaves no length for the half bricks", table.path_of("gap"));
        Err(Problem::at(table.span_of("gap"), message).expecting("less than nine tenths of a brick's length"))
    },
    place,
};

fn place(table: &Table, _: &str, yard: &mut Yard<'_>) -> Result<(), Problem> {
    let template = yard.moving(table);
    let (brick, gap) = (table.dvec3("brick"), table.f64("gap"));
    let (length, courses) = (table.int("length"), table.int("courses"));
    let half = 0.5 * brick.as_vec3();
    let whole_brick = yard.shape(Shape::Box { half }, table)?;
    // Two halves and their gap are as long as a whole one.
    let short = 0.5 * (brick.x - gap);
    let half_brick = if courses > 1 {
        yard.shape(Shape::Box { half: Vec3::new(0.5 * short as f32, half.y, half.z) }, table)?
    } else {
        whole_brick
    };
    let rotation = rotation::heading(table.f64("heading"));
    let pitch = brick.x + gap;
    let total = pitch * length as f64 - gap;
    for course in 0..courses {
        let height = (course as f64 + 0.5) * brick.z;
        let mut lay = |along: f64, shape| {
            let turned = rotate(rotation, Vec3::new((along - 0.5 * total) as f32, 0.0, 0.0)).as_dvec3();
            let mut position = table.dvec3("position") + turned;
            position.z += height;
            yard.add(template, shape, 1.0, Pose { position, rotation });
        };
        if course % 2 == 0 {
            (0..length).for_each(|i| lay(i as f64 * pitch + 0.5 * brick.x, whole_brick));
        } else {
            lay(0.5 * short, half_brick);
            (1..length).for_each(|i| lay(i as f64 * pitch - 0.5 * gap, whole_brick));
            lay(total - 0.5 * short, half_brick);
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use crate::Scene;
    use rockfall::Shape;

    #[test]
    fn courses_are_equally_long_and_joints_are_over_bricks() {
        let text = "[[generators]]\nkind = \"wall\"\nbrick = [0.5, 0.2, 0.25]\nlength = 4\ncourses = 3\ngap = 0.02\n";
        let plan = Scene::parse(text, "wall.toml", ".").unwrap().plan().unwrap();
        assert_eq!(plan.rows.len(), 4 + 5 + 4);
        let mut ends = vec![Vec::new(); 3];
        for (row, (_, pose)) in plan.rows.iter().zip(&plan.placed) {
            let Shape::Box { half } = plan.shapes[row.shape] else { panic!("a brick is a box") };
            let course = (pose.position.z / 0.25) as usize;
            assert!((pose.position.z - 0.25 * (course as f64 + 0.5)).abs() < 1e-9);
            let half = f64::from(half.x);
            ends[course].push((pose.position.x - half, pose.position.x + half));
        }
        for course in &ends {
            assert!((course[0].0 + 1.03).abs() < 1e-6);
            assert!((course[course.len() - 1].1 - 1.03).abs() < 1e-6);
            assert!(course.windows(2).all(|pair| (pair[1].0 - pair[0].1 - 0.02).abs() < 1e-6));
        }
        for joint in ends[1].windows(2).map(|pair| pair[0].1 + 0.01) {
            assert!(
                ends[0].iter().all(|(left, right)| (joint - left).abs() > 0.2 && (joint - right).abs() > 0.2)
            );
        }
    }
}
