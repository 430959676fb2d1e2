//! The rockfall program.
fn main() {}
