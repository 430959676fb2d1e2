//! Exports of a run, compared with the run by the programs that they are for.

mod csv;
mod glb;
mod parquet;
mod promises;
mod python;
mod sample;
mod usd;
mod vtp;
