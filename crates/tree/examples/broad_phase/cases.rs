//! The boxes that are measured. All are made from fixed seeds and lie along the Hilbert curve, as the rows of a world do.

use rockfall_math::hash::mix;
use rockfall_math::{Aabb, Vec3};
use rockfall_tree::{Tree, hilbert, morton::Grid};

/// A stream of numbers in [0, 1).
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        (mix(self.0) >> 40) as f32 / (1_u64 << 24) as f32
    }

    pub(crate) fn point(&mut self) -> Vec3 {
        Vec3::new(self.next(), self.next(), self.next())
    }
}

/// Boxes with sides of 1.03 on a cubic lattice with spacing 1, jittered by up to 0.15: a heap on a square that is twice as wide
/// as the heap is high. A box meets some ten others, as the fat boxes of a settled pile do.
pub(crate) fn pile(count: usize) -> Vec<Aabb> {
    let wide = (2.0 * count as f64).cbrt().ceil() as usize;
    let mut random = Random(1);
    let boxes = (0..count).map(|i| {
        let cell = Vec3::new((i % wide) as f32, (i / wide % wide) as f32, (i / wide / wide) as f32);
        let centre = cell + random.point() * 0.3;
        Aabb::new(centre, centre).grown(0.515)
    });
    along_the_curve(boxes.collect())
}

/// Diameters of 1 to 100, of which each octave fills the same volume: the number of boxes larger than d goes by d⁻³. Places are random
/// in a cube of which balls of these diameters would fill 55 %; a centre within a ball that is larger by an octave is drawn again. Boxes are
/// fatter than balls by 12 %.
pub(crate) fn mixed(count: usize) -> Vec<Aabb> {
    let mut random = Random(2);
    let mut diameters: Vec<f32> =
        (0..count).map(|_| (1.0 - random.next() * (1.0 - 1e-6)).powf(-1.0 / 3.0)).collect();
    diameters.sort_unstable_by(|a, b| b.total_cmp(a));
    let volume: f64 = diameters.iter().map(|&d| std::f64::consts::FRAC_PI_6 * f64::from(d).powi(3)).sum();
    let side = (volume / 0.55).cbrt() as f32;
    let mut boxes: Vec<Aabb> = Vec::with_capacity(count);
    while boxes.len() < count {
        let (placed, tree) = (boxes.len(), Tree::build(&boxes));
        let least = 0.5 * diameters[placed];
        for &d in diameters[placed..].iter().take_while(|d| **d > least) {
            let mut centre = random.point() * side;
            for _ in 0..1000 {
                let mut taken = false;
                tree.query(&Aabb::new(centre, centre), |item| {
                    let area = &boxes[item as usize];
                    taken |= area.center().distance(centre) < area.half_extents().x / 1.12;
                });
                if !taken {
                    break;
                }
                centre = random.point() * side;
            }
            boxes.push(Aabb::new(centre, centre).grown(0.56 * d));
        }
    }
    along_the_curve(boxes)
}

/// A bed of fixed unit boxes, four deep, twenty times as wide and more.
pub(crate) fn bed(count: usize) -> Vec<Aabb> {
    let wide = (count as f64 / 4.0).sqrt().ceil() as usize;
    let mut random = Random(3);
    let boxes = (0..count).map(|i| {
        let cell = Vec3::new((i / 4 % wide) as f32, (i / 4 / wide) as f32, (i % 4) as f32);
        let centre = cell + random.point() * 0.3;
        Aabb::new(centre, centre).grown(0.515)
    });
    along_the_curve(boxes.collect())
}

/// Boxes of the same size, strewn over a bed.
pub(crate) fn strewn(count: usize, bed: &[Aabb]) -> Vec<Aabb> {
    let bounds = bed.iter().fold(Aabb::EMPTY, |a, b| a.union(b));
    let size = bounds.max - bounds.min;
    let mut random = Random(4);
    let boxes = (0..count).map(|_| {
        let centre = bounds.min + random.point() * Vec3::new(size.x, size.y, 1.0) + Vec3::Z * (size.z - 1.0);
        Aabb::new(centre, centre).grown(0.515)
    });
    along_the_curve(boxes.collect())
}

/// One box in so many, at random, moves by up to a tenth of its size on each axis.
pub(crate) fn move_some(boxes: &[Aabb], one_in: u64, seed: u64) -> (Vec<Aabb>, Vec<bool>) {
    let mut random = Random(seed);
    let moved: Vec<bool> =
        (0..boxes.len() as u64).map(|i| mix(i ^ seed << 32).is_multiple_of(one_in)).collect();
    let step = |(area, &moved): (&Aabb, &bool)| {
        let way = (random.point() - 0.5) * 0.2 * (area.max - area.min);
        if moved { Aabb::new(area.min + way, area.max + way) } else { *area }
    };
    (boxes.iter().zip(&moved).map(step).collect(), moved)
}

fn along_the_curve(mut boxes: Vec<Aabb>) -> Vec<Aabb> {
    let bounds = boxes.iter().fold(Aabb::EMPTY, |a, b| a.union(b));
    let cells = Grid::new(&bounds);
    boxes.sort_by_cached_key(|area| hilbert(cells.morton(area.center())));
    boxes
}
