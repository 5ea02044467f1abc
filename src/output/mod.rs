//! Pictures as files: PNG, EXR, names, the recipe inside; never half-written.
