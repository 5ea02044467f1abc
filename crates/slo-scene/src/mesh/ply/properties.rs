//! Properties of a `.ply` element, one item at a time.

use super::header::{Element, Property};
use super::values::{Context, Values};
use crate::format::FileError;

/// The property that is read, for messages.
pub(super) fn context<'h>(element: &'h Element, item: u64, property: &'h Property) -> Context<'h> {
    Context { element: &element.name, item, property: &property.name }
}

/// The length at the start of a list.
///
/// # Errors
/// The next word is something else.
pub(super) fn list_len(
    property: &Property,
    values: &mut Values<'_>,
    context: Context<'_>,
) -> Result<u32, FileError> {
    let value = values.next(property.list.unwrap_or(property.scalar), context)?;
    let len = value as u32;
    if f64::from(len) == value { Ok(len) } else { Err(values.fault(context, "has no length")) }
}

/// Skips a property of one item.
///
/// # Errors
/// The file ends.
pub(super) fn skip_property(
    element: &Element,
    item: u64,
    property: &Property,
    values: &mut Values<'_>,
) -> Result<(), FileError> {
    let context = context(element, item, property);
    let len = match property.list {
        None => 1,
        Some(_) => list_len(property, values, context)?,
    };
    for _ in 0..len {
        values.skip(property.scalar, context)?;
    }
    Ok(())
}
