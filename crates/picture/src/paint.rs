//! What colour each body has, by what it is or by how it is.

mod islands;

use crate::legend::{Legend, Span};
use crate::ramp::{GROUND, MUTE, hue, ramp, stone};
use crate::{Error, Sight};
use islands::islands;
use rockfall::Kind;
use rockfall_math::Vec3;

/// What colours tell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum ColorBy {
    /// Which body it is: the colour that the scene gives it, or else that of a stone.
    #[default]
    Body,
    /// What it is made of.
    Material,
    /// How large it is.
    Size,
    /// How fast its centre of mass is.
    Speed,
    /// How hard it is pressed.
    Force,
    /// Whether it sleeps.
    Sleep,
    /// Who hangs together by contacts.
    Island,
    /// How deep others are in it.
    Penetration,
}

/// What a colour mode says of each body.
enum Told {
    /// A number, `None` of one it has nothing to say of.
    Numbers(Vec<Option<f32>>),
    /// A colour of its own.
    Colors(Vec<[f32; 3]>, Legend),
}

/// Share of the largest numbers that have the colour of the end: a body in a thousand should not take the colours from all others.
const BEYOND: usize = 100;

impl ColorBy {
    /// All of them with their words, for people who ask for one.
    pub const WORDS: [(&'static str, ColorBy); 8] = [
        ("body", ColorBy::Body),
        ("material", ColorBy::Material),
        ("size", ColorBy::Size),
        ("speed", ColorBy::Speed),
        ("force", ColorBy::Force),
        ("sleep", ColorBy::Sleep),
        ("island", ColorBy::Island),
        ("penetration", ColorBy::Penetration),
    ];

    /// Its word.
    pub fn word(self) -> &'static str {
        ColorBy::WORDS[self as usize].0
    }

    /// Whether the colour of a body may change from frame to frame.
    pub fn changes(self) -> bool {
        !matches!(self, ColorBy::Body | ColorBy::Material | ColorBy::Size)
    }

    /// Its title and unit.
    fn title(self) -> (&'static str, &'static str) {
        match self {
            ColorBy::Body => ("body", ""),
            ColorBy::Material => ("material", ""),
            ColorBy::Size => ("size", "m"),
            ColorBy::Speed => ("speed", "m/s"),
            ColorBy::Force => ("contact force", "N"),
            ColorBy::Sleep => ("sleep", ""),
            ColorBy::Island => ("islands", ""),
            ColorBy::Penetration => ("penetration", "m"),
        }
    }

    /// The span of the colours that suits what is seen; `None` where this mode has no numbers.
    ///
    /// # Errors
    /// [`Error::Unknown`].
    pub fn span(self, sight: &Sight) -> Result<Option<Span>, Error> {
        let Told::Numbers(numbers) = self.tell(sight)? else { return Ok(None) };
        let mut numbers: Vec<f32> = numbers.into_iter().flatten().filter(|x| x.is_finite()).collect();
        if numbers.is_empty() {
            return Ok(Some([0.0, 1.0]));
        }
        numbers.sort_unstable_by(f32::total_cmp);
        let most = numbers[numbers.len() - 1 - numbers.len() / BEYOND];
        Ok(Some([0.0, round_up(most)]))
    }

    /// The colour of each body, and what explains them; numbers up to the end of `span`, or of the span that suits what is seen.
    ///
    /// # Errors
    /// [`Error::Unknown`] where what is seen does not tell.
    pub fn paint(self, sight: &Sight, span: Option<Span>) -> Result<(Vec<[f32; 3]>, Legend), Error> {
        let span = match span {
            Some(span) => span,
            None => self.span(sight)?.unwrap_or([0.0, 1.0]),
        };
        match self.tell(sight)? {
            Told::Colors(colors, legend) => Ok((colors, legend)),
            Told::Numbers(numbers) => {
                let share = |x: f32| (x - span[0]) / (span[1] - span[0]);
                let color = |number: &Option<f32>| number.map_or(MUTE, |x| ramp(share(x))).to_array();
                let (title, unit) = self.title();
                Ok((numbers.iter().map(color).collect(), Legend::Scale { title, unit, span }))
            }
        }
    }

    fn tell(self, sight: &Sight) -> Result<Told, Error> {
        let moves = |k: usize| sight.bodies[k].kind != Kind::Static;
        let unknown = |why: &String| Error::Unknown { what: self.title().0, why: why.clone() };
        let numbers = |number: &dyn Fn(usize) -> f32| {
            let all = (0..sight.bodies.len()).map(|k| moves(k).then(|| number(k))).collect();
            Ok(Told::Numbers(all))
        };
        let colors = |color: &dyn Fn(usize) -> Vec3, legend: Legend| {
            let all = (0..sight.bodies.len()).map(|k| color(k).to_array()).collect();
            Ok(Told::Colors(all, legend))
        };
        match self {
            ColorBy::Body => {
                let own = |k: usize| match sight.bodies[k].color.or(sight.color_of(sight.bodies[k].material))
                {
                    Some(color) => Vec3::from_array(color),
                    None if moves(k) => stone(sight.bodies[k].id),
                    None => GROUND,
                };
                colors(&own, Legend::None)
            }
            ColorBy::Material => {
                let color = |material: u32, kind| {
                    let own = sight.color_of(material);
                    Vec3::from_array(own.unwrap_or_else(|| rockfall_export::color(material, kind)))
                };
                let used =
                    |m: u32| sight.bodies.iter().any(|body| body.material == m && body.kind != Kind::Static);
                let names = (0..).zip(&sight.materials).filter(|(m, _)| used(*m));
                let entries = names.map(|(m, name)| (name.clone(), color(m, Kind::Dynamic).to_array()));
                let legend = Legend::Names { title: "material", entries: entries.collect() };
                colors(&|k| color(sight.bodies[k].material, sight.bodies[k].kind), legend)
            }
            ColorBy::Size => {
                let size = |shape: &rockfall::Shape| 2.0 * shape.radius_about(shape.bounds().center());
                let sizes: Vec<f32> = sight.shapes.iter().map(size).collect();
                numbers(&|k| sizes[sight.bodies[k].shape as usize])
            }
            ColorBy::Speed => numbers(&|k| sight.bodies[k].velocity.length()),
            ColorBy::Force => {
                let forces = sight.forces.as_ref().map_err(unknown)?;
                numbers(&|k| forces[k])
            }
            ColorBy::Sleep => {
                let asleep = sight.asleep.as_ref().map_err(unknown)?;
                let [awake_color, asleep_color] = [ramp(0.78), ramp(0.18)];
                let entries = [("awake", awake_color), ("asleep", asleep_color)];
                let entries = entries.map(|(name, color)| (name.to_owned(), color.to_array())).to_vec();
                let color = |k: usize| match (moves(k), asleep[k]) {
                    (false, _) => GROUND,
                    (true, false) => awake_color,
                    (true, true) => asleep_color,
                };
                colors(&color, Legend::Names { title: "sleep", entries })
            }
            ColorBy::Island => {
                let contacts = sight.contacts.as_ref().map_err(unknown)?;
                let found = islands(sight, contacts);
                let count = found.iter().flatten().max().map_or(0, |last| last + 1);
                let color = |k: usize| match found[k] {
                    Some(island) => hue(u64::from(island) + 1),
                    None if moves(k) => MUTE,
                    None => GROUND,
                };
                let entries = vec![(format!("{count} of bodies that touch"), hue(1).to_array())];
                colors(&color, Legend::Names { title: "islands", entries })
            }
            ColorBy::Penetration => {
                let contacts = sight.contacts.as_ref().map_err(unknown)?;
                let mut deepest = vec![0.0_f32; sight.bodies.len()];
                for ((&a, &b), &distance) in contacts.a.iter().zip(&contacts.b).zip(&contacts.distances) {
                    for row in [a, b].into_iter().filter_map(|id| sight.row(id)) {
                        deepest[row] = deepest[row].max(-distance);
                    }
                }
                numbers(&|k| deepest[k])
            }
        }
    }
}

/// A round number that is not smaller: 1, 2 or 5 times a power of ten.
fn round_up(x: f32) -> f32 {
    if x <= 1e-9 || x.is_nan() {
        return 1.0;
    }
    let mut ten = 1e-9_f64;
    loop {
        for round in [1.0, 2.0, 5.0] {
            // A share of a millionth above it is rounding.
            if round * ten * (1.0 + 1e-6) >= f64::from(x) || ten > 1e30 {
                return (round * ten) as f32;
            }
        }
        ten *= 10.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spans_end_with_round_numbers() {
        for (x, expected) in [(0.0, 1.0), (0.3, 0.5), (1.0, 1.0), (1.1, 2.0), (2300.0, 5000.0), (4e-4, 5e-4)]
        {
            let found = round_up(x);
            assert!((found / expected - 1.0).abs() < 1e-5, "{x}: {found}");
        }
        assert!(round_up(f32::MAX).is_finite() && round_up(f32::NAN) == 1.0);
    }
}
