//! Elements as they are written: which attributes each takes, and their values, checked.
//!
//! Nothing here knows how a single element is read: a [`schema::Schema`] says what one takes, a [`Language`] holds all of
//! them, [`Fields`] reads one.

mod elsewhere;
mod fields;
mod language;
mod motion;
mod references;
pub(crate) mod schema;
mod values;

pub(crate) use crate::settings::Bound;
pub(crate) use elsewhere::element_meant;
pub(crate) use fields::{Element, Field, Fields, Value, nameless, quoted_list};
pub(crate) use language::{INCLUDE, Language};
pub(crate) use motion::{ADD_KFRAME, REPEAT};
pub(crate) use references::{References, Referred};
pub(crate) use values::{FARTHEST, Found, SHORTEST, looks_like_bytes};
