//! Runs of Rockfall on disk: trajectories, frames, summaries.
