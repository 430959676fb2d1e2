//! Pour: bodies that come into being while the simulation runs.
//!
//! Everything about body k except its place is drawn from its own stream `LABEL.k` when the scene is read. Its place
//! is drawn in the frame f in which it is due, from the stream `LABEL.k.f`: the first of up to `attempts` random
//! points of the region where the ball around it is clear of the balls around all bodies that can move. A body that
//! finds no room waits for the next frame, and those behind it wait with it. So nothing needs to be remembered but
//! how many have been emitted.

use super::{GeneratorKind, SHAPED, TURNED};
use crate::body::{MOTION, SURFACE};
use crate::error::Problem;
use crate::node::Table;
use crate::plan::Yard;
use crate::random::Random;
use crate::region::BOX_KEYS;
use crate::rotation;
use crate::spec::{NOT_NEGATIVE, POSITIVE, Spec, Ty, key, required};
use rockfall_math::{DVec3, Quat};
use std::ops::Range;

pub(super) static POUR_KEYS: Spec = Spec {
    name: "pour",
    about: "Bodies that come into being over time, at random places of a region, none overlapping another. When there \
            is no room, they wait.",
    example: r#"[[generators]]
kind = "pour"
shape = "ball"
count = 2000
rate = 400
region = { min = [-4, -4, 20], max = [4, 4, 24] }
velocity = [0, 0, -10]
"#,
    groups: &[
        SHAPED,
        &[
            required("count", Ty::Int(1, 4_294_967_295), "Bodies, all in all."),
            required("rate", Ty::Number(POSITIVE), "Bodies per second."),
            key("start", Ty::Number(NOT_NEGATIVE), "0", "When it begins, s."),
            required(
                "region",
                Ty::Table(&BOX_KEYS),
                "A box in which the bodies appear: `{ min = [..], max = [..] }`.",
            ),
            key("gap", Ty::Number(NOT_NEGATIVE), "0", "Least distance of the balls around the bodies, m."),
            key("attempts", Ty::Int(1, 1_000_000), "100", "Random places that a body tries in a frame."),
        ],
        TURNED,
        SURFACE,
        MOTION,
    ],
};

pub(super) static POUR: GeneratorKind = GeneratorKind {
    spec: &POUR_KEYS,
    count: |table| u128::from(table.int("count")),
    check: |table| table.table("region").map_or(Ok(()), crate::region::check),
    place,
};

/// A pour, ready to run.
#[derive(Clone, Debug)]
pub(crate) struct Pour {
    label: String,
    seed: u64,
    /// Its bodies in the plan.
    pub(crate) rows: Range<usize>,
    pub(crate) template: u32,
    /// All bodies as this, or each its own.
    rotation: Option<Quat>,
    min: DVec3,
    max: DVec3,
    pub(crate) gap: f64,
    attempts: u64,
    rate: f64,
    start: f64,
}

fn place(table: &Table, label: &str, yard: &mut Yard<'_>) -> Result<(), Problem> {
    let template = yard.moving(table);
    let choices = yard.choices(table)?;
    let Some(region) = table.table("region") else { return Ok(()) };
    let (min, max) = (region.dvec3("min"), region.dvec3("max"));
    let count = table.int("count") as usize;
    let mut drawn = Vec::with_capacity(count);
    let mut largest = 0.0_f64;
    for k in 0..count {
        let (shape, scale) =
            yard.draw(&choices, table, &mut Random::new(yard.seed, &format!("{label}.{k}")))?;
        largest = largest.max(yard.ball(shape).1.into());
        drawn.push((shape, scale));
    }
    if (max - min).min_element() < 2.0 * largest {
        let message = format!(
            "`{}` is too small: the ball around the largest body has a radius of {largest:.3} m",
            region.path
        );
        return Err(Problem::at(region.span, message).expecting("room for it"));
    }
    let random = table.text("orientation") == "random";
    let rotation = if random { None } else { Some(rotation::read(table, "rotation")?) };
    let pour = Pour {
        label: label.to_owned(),
        seed: yard.seed,
        rows: 0..0,
        template,
        rotation,
        min,
        max,
        gap: table.f64("gap"),
        attempts: table.int("attempts"),
        rate: table.f64("rate"),
        start: table.f64("start"),
    };
    yard.pour(pour, drawn);
    Ok(())
}

impl Pour {
    /// How many bodies should have come before step `frame` (from 0) at `fps` frames per second.
    pub(crate) fn due(&self, frame: u64, fps: f64) -> usize {
        let time = (frame + 1) as f64 / fps - self.start;
        // The rounding of `time` must not hold back a body for a frame.
        ((time * self.rate + 1e-6).floor().max(0.0) as usize).min(self.rows.len())
    }

    /// The orientation of body k.
    pub(crate) fn rotation(&self, k: usize) -> Quat {
        self.rotation
            .unwrap_or_else(|| Random::new(self.seed, &format!("{}.{k}.orientation", self.label)).rotation())
    }

    /// The centres that body k, with a ball of `radius` around it, tries in frame `frame`.
    pub(crate) fn candidates(&self, k: usize, frame: u64, radius: f64) -> impl Iterator<Item = DVec3> {
        let mut random = Random::new(self.seed, &format!("{}.{k}.{frame}", self.label));
        let (min, max) = (self.min + DVec3::splat(radius), self.max - DVec3::splat(radius));
        (0..self.attempts).map(move |_| random.point(min, max))
    }

    /// Whether a ball reaches into the region.
    pub(crate) fn is_near(&self, centre: DVec3, radius: f64) -> bool {
        let away = (self.min - centre).max(centre - self.max).max(DVec3::ZERO);
        away.length() < radius + self.gap
    }
}

#[cfg(test)]
mod tests {
    use crate::{Running, Scene};
    use rockfall::snapshot::{Error, Reader, Writer};

    const POUR: &str = "[shapes.ball]\nkind = \"sphere\"\nradius = 0.2\n[[generators]]\nkind = \"pour\"\n\
        shape = \"ball\"\ncount = 100\nrate = 90\nstart = 0.5\nregion = { min = [-2, -2, 9], max = [2, 2, 11] }\n\
        velocity = [0, 0, -5]\n[[generators]]\nkind = \"container\"\nsize = [5, 5, 5]\n";

    #[test]
    fn bodies_come_at_their_rate_and_last_in_the_table() {
        let scene = Scene::parse(POUR, "pour.toml", ".").unwrap();
        let plan = scene.plan().unwrap();
        assert_eq!(plan.pours[0].rows, 5..105);
        let due: Vec<usize> = (0..200).map(|frame| plan.pours[0].due(frame, 60.0)).collect();
        assert_eq!((due[28], due[29], due[30], due[31]), (0, 0, 1, 3));
        assert_eq!((due[89], due[199]), (90, 100));
    }

    #[test]
    fn poured_bodies_never_overlap_at_emission() {
        let mut running = Scene::parse(POUR, "pour.toml", ".").unwrap().build().unwrap();
        for frame in 0..120 {
            let emitted = running.before_step(frame).unwrap();
            let poses = running.world.poses();
            for a in poses.len() - emitted..poses.len() {
                for b in 5..a {
                    assert!((poses[a].position - poses[b].position).length() >= 0.4 - 1e-6);
                }
            }
            running.world.step();
        }
        assert_eq!((running.world.len(), running.waiting()), (105, 0));
    }

    #[test]
    fn a_pour_goes_on_where_it_was_saved() {
        let start = || Scene::parse(POUR, "pour.toml", ".").unwrap().build().unwrap();
        let step = |running: &mut Running, frame: u64| {
            running.before_step(frame).unwrap();
            running.world.step();
            (running.waiting(), running.world.hash())
        };
        let mut running = start();
        (0..50).for_each(|frame| assert!(step(&mut running, frame).0 > 10));
        let mut file = Vec::new();
        let mut writer = Writer::new(&mut file).unwrap();
        running.save(&mut writer).unwrap();
        writer.finish().unwrap();
        let mut again = start();
        again.load(&mut Reader::new(&mut &file[..]).unwrap()).unwrap();
        assert!(again.waiting() > 10 && again.waiting() < 90);
        for frame in 50..120 {
            assert_eq!(step(&mut again, frame), step(&mut running, frame));
        }
        let other =
            POUR.replace("kind = \"pour\"", "kind = \"fill\"").replace("rate = 90\nstart = 0.5\n", "");
        let mut other = Scene::parse(&other, "fill.toml", ".").unwrap().build().unwrap();
        let refused = other.load(&mut Reader::new(&mut &file[..]).unwrap());
        assert_eq!(refused, Err(Error::OtherWorld("pours")));
    }

    #[test]
    fn bodies_without_room_wait() {
        let text = "[world]\ngravity = [0, 0, 0]\n[shapes.ball]\nkind = \"sphere\"\nradius = 0.5\n[[generators]]\n\
            kind = \"pour\"\nshape = \"ball\"\ncount = 10\nrate = 600\nregion = { min = [0, 0, 0], max = [2.5, 1.1, 1.1] }\n";
        let mut running = Scene::parse(text, "pour.toml", ".").unwrap().build().unwrap();
        for frame in 0..5 {
            running.before_step(frame).unwrap();
            running.world.step();
        }
        assert!((1..=2).contains(&running.world.len()));
        assert_eq!(running.world.len() + running.waiting(), 10);
    }
}
