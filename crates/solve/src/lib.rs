//! Contact solvers of Rockfall: colours, batches, kernels; knows no shapes.
