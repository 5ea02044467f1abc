//! Work on three axes, in parallel if it is enough.

/// Least number of primitives of a cell that is built in parallel.
pub(super) const PARALLEL_SIZE: usize = 16384;

/// Calls `each` for three axes.
pub(super) fn for_axes<T: Send, R: Send>(
    in_parallel: bool,
    [x, y, z]: [T; 3],
    each: impl Fn(T) -> R + Sync,
) -> [R; 3] {
    if !in_parallel {
        return [each(x), each(y), each(z)];
    }
    let (x, (y, z)) = rayon::join(|| each(x), || rayon::join(|| each(y), || each(z)));
    [x, y, z]
}
