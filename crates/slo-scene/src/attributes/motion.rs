//! `addKframe`, which all that may move takes.

use super::schema::{Attribute, Schema, block, number, point, word};

/// `addKframe`
pub(crate) const ADD_KFRAME: Schema =
    Schema::new("addKframe", &[number("time").required(), block(&PRE), block(&KEY), block(&NEX)]);

/// What an element hangs in.
pub(crate) const PARENT: Attribute = word("parent", "NAME");

const PLACEMENT: [Attribute; 4] = [point("pivot"), point("up"), point("right"), point("scale")];
const PRE: Schema = Schema::new("pre", &PLACEMENT);
const KEY: Schema = Schema::new("key", &PLACEMENT);
const NEX: Schema = Schema::new("nex", &PLACEMENT);
