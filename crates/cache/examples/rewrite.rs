//! What the trajectory of a run takes on disk and of a processor, lossless and within a bound, and what reading of it costs:
//! `cargo run --release -p rockfall-cache --example rewrite -- RUN FOLDER [METRES DEGREES]`. FOLDER is made, and left for a look at it.

use rockfall_cache::trajectory::TrajectoryWriter;
use rockfall_cache::{BodyTable, Contents, Frame, Precision, RunReader, SUMMARY, TRAJECTORY};
use std::error::Error as Anything;
use std::fs;
use std::path::Path;

fn main() -> Result<(), Box<dyn Anything>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [run, folder, bounds @ ..] = &arguments[..] else {
        return Err("expected RUN FOLDER [METRES DEGREES]".into());
    };
    let reader = RunReader::open(Path::new(run))?;
    let (table, times) = (reader.bodies()?, reader.times()?);
    let number = |at: usize, default: f64| bounds.get(at).map_or(Ok(default), |text| text.parse());
    let bounded =
        Precision { position: Some(number(0, 1e-4)?), rotation: Some(number(1, 0.1)?.to_radians()) };
    println!("{} bodies, {} frames", table.len(), times.len());
    for (kind, precision) in [("lossless", Precision::default()), ("bounded", bounded)] {
        let path = Path::new(folder).join(kind);
        fs::create_dir_all(path.join(TRAJECTORY))?;
        reader.summary().write(&path.join(SUMMARY))?;
        let contents = Contents { precision, ..Contents::from(reader.origin()?) };
        let rate = reader.summary().frames_per_second;
        let mut writer = TrajectoryWriter::create(&path.join(TRAJECTORY), &table, &contents, rate)?;
        let (mut spent, mut there) = (0.0, 0);
        for (frame, &time) in (0..).zip(&times) {
            let poses = reader.poses(frame)?;
            there += poses.positions.chunks_exact(3).filter(|p| !p[0].is_nan()).count();
            let frame = Frame { time, poses, ..Frame::default() };
            let start = processor()?;
            writer.append(&frame)?;
            spent += processor()? - start;
        }
        writer.flush()?;
        let bytes = size(&path.join(TRAJECTORY), |_| true)? as f64 / there as f64;
        let time = 1e9 * spent / (table.len() * times.len()) as f64;
        println!("{kind}: {bytes:.2} bytes and {time:.0} ns of a processor for each body and frame");
        read(&path, &table)?;
    }
    Ok(())
}

/// Reads the frame in the middle, and the history of the body in the middle.
fn read(path: &Path, table: &BodyTable) -> Result<(), Box<dyn Anything>> {
    let trajectory = path.join(TRAJECTORY);
    let metadata: serde_json::Value =
        serde_json::from_slice(&fs::read(trajectory.join("position/zarr.json"))?)?;
    let chunk = |at: usize| metadata["chunk_grid"]["configuration"]["chunk_shape"][at].as_u64().unwrap_or(1);
    let (frame, body) = (RunReader::open(path)?.frames()? / 2, table.len() / 2);
    let (row, column) = (frame / chunk(0), body as u64 / chunk(1));
    let start = processor()?;
    RunReader::open(path)?.poses(frame)?;
    let took = 1e3 * (processor()? - start);
    let touched = size(&trajectory, |at| at[0] == row)?;
    let all = size(&trajectory, |_| true)?;
    println!("  one frame: {took:.1} ms of a processor, {touched} of {all} bytes");
    let start = processor()?;
    RunReader::open(path)?.history(body)?;
    let took = 1e3 * (processor()? - start);
    println!(
        "  one body's history: {took:.1} ms of a processor, {} of {all} bytes",
        size(&trajectory, |at| at[1] == column)?
    );
    Ok(())
}

/// Bytes of the chunks of poses whose row and column are wanted.
fn size(trajectory: &Path, wanted: impl Fn([u64; 2]) -> bool) -> Result<u64, Box<dyn Anything>> {
    let mut sum = 0;
    for name in ["position", "orientation"] {
        for entry in fs::read_dir(trajectory.join(name))? {
            let entry = entry?;
            let name = entry.file_name().into_string().unwrap_or_default();
            let numbers: Vec<u64> = name.split('.').filter_map(|part| part.parse().ok()).collect();
            if let [row, column, _] = numbers[..]
                && wanted([row, column])
            {
                sum += entry.metadata()?.len();
            }
        }
    }
    Ok(sum)
}

/// Seconds that this thread has had of a processor (Linux).
fn processor() -> Result<f64, Box<dyn Anything>> {
    let text = fs::read_to_string("/proc/thread-self/schedstat")?;
    Ok(1e-9 * text.split(' ').next().unwrap_or_default().parse::<f64>()?)
}
