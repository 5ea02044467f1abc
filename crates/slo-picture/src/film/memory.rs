//! Memory for all pixels of an area, if there is enough.

use slo_scene::memory::check;

use super::area::Area;

/// There is not enough memory for a picture of this size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TooLarge {
    /// Bytes that it needs.
    pub bytes: u64,
}

/// A default value for every pixel of an area.
pub(super) fn filled<T: Clone + Default>(area: Area) -> Result<Vec<T>, TooLarge> {
    filled_times(area, 1)
}

/// So many default values for every pixel of an area.
pub(super) fn filled_times<T: Clone + Default>(
    area: Area,
    times: usize,
) -> Result<Vec<T>, TooLarge> {
    let pixels = u64::from(area.width()) * u64::from(area.height());
    let all = pixels.saturating_mul(times as u64);
    let too_large = TooLarge { bytes: all.saturating_mul(size_of::<T>() as u64) };
    let count = usize::try_from(all).map_err(|_| too_large)?;
    check(too_large.bytes).map_err(|_| too_large)?;
    let mut values = Vec::new();
    values.try_reserve_exact(count).map_err(|_| too_large)?;
    values.resize(count, T::default());
    Ok(values)
}

/// A copy, if there is memory for it.
pub(super) fn copied<T: Clone>(values: &[T]) -> Option<Vec<T>> {
    check(size_of_val(values) as u64).ok()?;
    let mut copy = Vec::new();
    copy.try_reserve_exact(values.len()).ok()?;
    copy.extend_from_slice(values);
    Some(copy)
}
