//! Batches of weighted rays -> radiance. Knows no files and no threads.
