//! Procedural terrain: a mountain side above a valley, roughened by noise.

use crate::node::Table;
use crate::noise;
use crate::random::Random;
use crate::spec::{ANY, NOT_NEGATIVE, POSITIVE, Range, SHARE, Spec, Ty, key};

const SLOPE: Range = Range { min: 0.0, max: 70.0 };

/// The key `terrain` of shapes.
pub(crate) static TERRAIN: Spec = Spec {
    name: "terrain",
    about: "Procedural terrain around the origin: a slope that falls along x into a valley whose floor is at z = 0, \
            roughened by noise.",
    example: r#"terrain = { size = [300, 150], cells = [300, 150], slope = 35, run_out = 80, amplitude = 3 }
"#,
    groups: &[&[
        key("size", Ty::Numbers(&[2], POSITIVE), "[200, 200]", "Extent along x and y, m."),
        key("cells", Ty::Ints(2, 1, 4096), "[128, 128]", "Cells along x and y; each is two triangles."),
        key("slope", Ty::Number(SLOPE), "0", "Steepness of the mountain side, degrees. 0 for a plain."),
        key("run_out", Ty::Number(NOT_NEGATIVE), "0", "Length of the valley at the end of large x, m."),
        key("bend", Ty::Number(POSITIVE), "20", "Length over which the slope turns into the valley, m."),
        key(
            "trough",
            Ty::Number(ANY),
            "0",
            "How much higher the sides (y) are than the middle, m: positive for a gully, negative for a ridge.",
        ),
        key("rim", Ty::Number(NOT_NEGATIVE), "0", "Height of a bank along the foot and the sides, m."),
        key("amplitude", Ty::Number(NOT_NEGATIVE), "2", "Height of the noise, m."),
        key("wavelength", Ty::Number(POSITIVE), "40", "Size of the largest bumps, m."),
        key("octaves", Ty::Int(1, 16), "6", "Layers of noise, each with bumps of half the size."),
        key("roughness", Ty::Number(SHARE), "0.5", "Height of each layer relative to the one before."),
        key("seed", Ty::Int(0, u64::MAX), "0", "Another number gives another terrain of the same scene."),
    ]],
};

/// Heights over a regular grid that is centred on the origin.
pub(crate) struct Heights {
    pub(crate) columns: u32,
    pub(crate) rows: u32,
    /// Distance of samples along x and y, m.
    pub(crate) spacing: [f32; 2],
    /// m; sample (i, j) is at `j * columns + i`.
    pub(crate) heights: Vec<f32>,
}

/// The terrain that `table` describes. `label` names the shape for the random numbers.
pub(crate) fn heights(table: &Table, seed: u64, label: &str) -> Heights {
    let (length, width) = table.pair("size");
    let cells = table.ints("cells");
    let (nx, ny) = (cells[0], cells[1]);
    let seed = Random::new(seed, &format!("{label}.terrain.{}", table.int("seed"))).bits();
    let fall = libm::tan(table.f64("slope").to_radians());
    let bend = table.f64("bend");
    let foot = 0.5 * length - table.f64("run_out");
    let (amplitude, wavelength) = (table.f64("amplitude"), table.f64("wavelength"));
    let (octaves, roughness) = (table.int("octaves"), table.f64("roughness"));
    let (trough, rim) = (table.f64("trough"), table.f64("rim"));
    // The bank rises over the outermost tenth.
    let bank = |share: f64| {
        let t = ((share - 0.9) * 10.0).clamp(0.0, 1.0);
        t * t * (3.0 - 2.0 * t)
    };
    let mut heights = Vec::with_capacity(((nx + 1) * (ny + 1)) as usize);
    for j in 0..=ny {
        let y = width * (j as f64 / ny as f64 - 0.5);
        for i in 0..=nx {
            let x = length * (i as f64 / nx as f64 - 0.5);
            let (u, v) = (2.0 * x / length, (2.0 * y / width).abs());
            let height = fall * smooth_positive(foot - x, bend)
                + trough * v * v
                + rim * bank(u).max(bank(v))
                + amplitude * noise::octaves(seed, x / wavelength, y / wavelength, octaves, roughness);
            heights.push(height as f32);
        }
    }
    let spacing = [(length / nx as f64) as f32, (width / ny as f64) as f32];
    Heights { columns: nx as u32 + 1, rows: ny as u32 + 1, spacing, heights }
}

/// `x` where it is positive, 0 where it is negative, with a smooth bend of the length `width` between them.
fn smooth_positive(x: f64, width: f64) -> f64 {
    let w = 0.25 * width;
    // ln(1 + e^t) without overflow.
    let t = x / w;
    w * (t.max(0.0) + libm::log1p(libm::exp(-t.abs())))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bend_joins_slope_and_valley() {
        assert!((smooth_positive(100.0, 20.0) - 100.0).abs() < 1e-6);
        assert!(smooth_positive(-100.0, 20.0).abs() < 1e-6);
        assert!((smooth_positive(0.0, 20.0) - 5.0 * std::f64::consts::LN_2).abs() < 1e-12);
    }
}
