//! Units and axes of a stage.

use super::values::{as_number, as_word, said};
use crate::affine::Affine;
use crate::build::Builder;
use openusd::usd::Stage;
use rockfall_math::{DMat3, DVec3};

/// What a stage measures in.
#[derive(Debug)]
pub(super) struct Units {
    /// Of the stage's unit of length, m.
    pub(super) metre: f64,
    /// Of its unit of mass, kg.
    pub(super) mass: f64,
    /// Of its unit of density, kg/m³.
    pub(super) density: f64,
    /// Axes of the stage to ours.
    pub(super) turn: DMat3,
    /// Away from the ground in the axes of the stage.
    pub(super) up: DVec3,
}

impl Units {
    /// What the metadata say, or what OpenUSD takes where they say nothing: centimetres, kilograms, y up.
    pub(super) fn read(stage: &Stage, builder: &mut Builder) -> Result<Units, String> {
        let metadata = |key: &str| stage.stage_metadata(key).map_err(said);
        let unit = |key: &str| -> Result<Option<f64>, String> {
            match metadata(key)?.as_ref().and_then(as_number) {
                Some(unit) if !(unit > 0.0 && unit.is_finite()) => {
                    Err(format!("`{key}` is {unit}, expected a number greater than 0"))
                }
                unit => Ok(unit),
            }
        };
        let metre = unit("metersPerUnit")?.unwrap_or_else(|| {
            builder.note("there is no `metersPerUnit`: its unit is a centimetre, as OpenUSD has it", "");
            0.01
        });
        let mass = unit("kilogramsPerUnit")?.unwrap_or(1.0);
        let up = metadata("upAxis")?.as_ref().and_then(as_word);
        let (turn, up) = match up.as_deref() {
            Some("Z") => (DMat3::IDENTITY, DVec3::Z),
            Some("Y") | None => (DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::NEG_Y), DVec3::Y),
            Some(other) => return Err(format!("`upAxis` is {other}, expected Y or Z")),
        };
        Ok(Units { metre, mass, density: mass / (metre * metre * metre), turn, up })
    }

    /// The map of a whole stage to the world.
    pub(super) fn root(&self, place: &Affine) -> Affine {
        place.after(&Affine::linear(self.turn * DMat3::from_diagonal(DVec3::splat(self.metre))))
    }
}
