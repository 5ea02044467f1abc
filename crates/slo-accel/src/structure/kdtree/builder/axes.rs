//! Work on three axes, in parallel where it is worth its while.

/// Cells with at least so many primitives are built in parallel.
pub(super) const PARALLEL_SIZE: usize = 16384;

/// Does the same for three axes.
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
