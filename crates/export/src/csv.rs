//! CSV: one row per body and frame, for spreadsheets and scripts.

use crate::columns::{COLUMNS, Column};
use crate::{Detail, Error, Format, Ids, Job, Makes, Moment, Run};
use std::fs::File;
use std::io::{self, Write};
use std::path::Path;

/// Rows of text, frame by frame, in each the bodies by ascending id. A body that is not there at a frame has no row.
#[derive(Clone, Debug, Default)]
pub struct Csv {
    /// Which bodies; all where `None`.
    pub bodies: Option<Ids>,
}

impl Format for Csv {
    fn name(&self) -> &'static str {
        "csv"
    }

    fn makes(&self) -> Makes {
        Makes::File { extension: "csv" }
    }

    fn write(&self, job: &Job<'_>, to: &Path) -> Result<(), Error> {
        let rows = job.rows(self.bodies.as_ref())?;
        let failed = |error: io::Error| Error::io("write", to, &error);
        let mut file = File::create_new(to).map_err(failed)?;
        let header = COLUMNS.map(|(name, _)| name).join(",") + "\n";
        file.write_all(header.as_bytes()).map_err(failed)?;
        let encode = |moment: Moment| text(job.run(), &moment).map_err(failed);
        job.stream(&rows, Detail::Motion, encode, |text| file.write_all(&text).map_err(failed))
    }
}

/// The lines of one frame. Numbers are written so that reading them gives the same bits.
fn text(run: &Run, moment: &Moment) -> io::Result<Vec<u8>> {
    let (table, origin) = (run.bodies(), run.origin());
    let (frame, time) = (moment.frame.to_string(), moment.time.to_string());
    let mut writer = csv::Writer::from_writer(Vec::new());
    for (k, &row) in moment.rows.iter().enumerate() {
        let row = row as usize;
        for (_, column) in COLUMNS {
            let number = match column {
                Column::Frame => frame.clone(),
                Column::Time => time.clone(),
                Column::Id => table.ids[row].to_string(),
                Column::Name => table.names[row].clone(),
                Column::Shape => table.shapes[row].to_string(),
                Column::Scale => table.scales[row].to_string(),
                // Single precision has fewer digits: it stays where there is nothing to add.
                Column::Position(axis) if origin[axis] == 0.0 => moment.positions[k][axis].to_string(),
                Column::Position(axis) => (origin[axis] + f64::from(moment.positions[k][axis])).to_string(),
                Column::Rotation(axis) => moment.rotations[k][axis].to_string(),
                Column::Velocity(axis) => moment.velocities[k][axis].to_string(),
                Column::Spin(axis) => moment.spins[k][axis].to_string(),
            };
            writer.write_field(number)?;
        }
        writer.write_record(None::<&[u8]>)?;
    }
    writer.into_inner().map_err(|error| error.into_error())
}
