//! `addKframe`, which all that may move takes.

use super::schema::{Attribute, Schema, block, number, point};

/// `addKframe`
pub(crate) const ADD_KFRAME: Schema =
    Schema::new("addKframe", &[number("time").required(), block(&PRE), block(&KEY), block(&NEX)]);

const PLACEMENT: [Attribute; 3] = [point("pivot"), point("up"), point("right")];
const PRE: Schema = Schema::new("pre", &PLACEMENT);
const KEY: Schema = Schema::new("key", &PLACEMENT);
const NEX: Schema = Schema::new("nex", &PLACEMENT);
