//! CSV: one row per body and frame, for spreadsheets and scripts.

use crate::{Error, Format, Ids, Job, Makes, Moment, Motion};
use std::fs::File;
use std::io::Write;
use std::path::Path;

/// Names of the columns; units are part of them.
const COLUMNS: [&str; 17] = [
    "frame", "time_s", "id", "name", "x_m", "y_m", "z_m", "qx", "qy", "qz", "qw", "vx_m_s", "vy_m_s",
    "vz_m_s", "wx_rad_s", "wy_rad_s", "wz_rad_s",
];

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
        let failed = |error: std::io::Error| Error::io("write", to, &error);
        let mut file = File::create_new(to).map_err(failed)?;
        let mut header = COLUMNS.join(",");
        header.push('\n');
        file.write_all(header.as_bytes()).map_err(failed)?;
        let encode = |moment: Moment| text(job, &moment).map_err(failed);
        job.stream(&rows, Motion::Wanted, encode, |text| file.write_all(&text).map_err(failed))
    }
}

/// The lines of one frame. Numbers are written so that reading them gives the same bits.
fn text(job: &Job<'_>, moment: &Moment) -> std::io::Result<Vec<u8>> {
    let (table, origin) = (job.run().bodies(), job.run().origin());
    let mut writer = csv::Writer::from_writer(Vec::new());
    let (frame, time) = (moment.frame.to_string(), moment.time.to_string());
    for (k, &row) in moment.rows.iter().enumerate() {
        let row = row as usize;
        writer.write_field(&frame)?;
        writer.write_field(&time)?;
        writer.write_field(table.ids[row].to_string())?;
        writer.write_field(&table.names[row])?;
        for axis in 0..3 {
            // Sums only where there is something to add: single precision has fewer digits.
            let (start, x) = (origin[axis], moment.positions[k][axis]);
            writer.write_field(if start == 0.0 {
                x.to_string()
            } else {
                (start + f64::from(x)).to_string()
            })?;
        }
        let motion = moment.velocities[k].iter().chain(&moment.spins[k]);
        for value in moment.rotations[k].iter().chain(motion) {
            writer.write_field(value.to_string())?;
        }
        writer.write_record(None::<&[u8]>)?;
    }
    writer.into_inner().map_err(|error| error.into_error())
}
