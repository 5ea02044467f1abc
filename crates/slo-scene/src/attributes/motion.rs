//! `addKframe`, which all that may move takes.

use super::schema::{Attribute, Schema, block, choice, number, point, word};

/// `addKframe`
pub(crate) const ADD_KFRAME: Schema =
    Schema::new("addKframe", &[number("time").required(), block(&PRE), block(&KEY), block(&NEX)]);

/// What an element hangs in.
pub(crate) const PARENT: Attribute = word("parent", "NAME");

/// `repeat`, which stands beside key frames.
pub(crate) const REPEAT: Attribute = choice("repeat");

const PLACEMENT: [Attribute; 6] =
    [point("pivot"), point("up"), point("right"), point("scale"), block(&TURN), point("turn_deg")];
const TURN: Schema =
    Schema::new("turn", &[point("axis").required(), number("angle_deg").required()]);
const PRE: Schema = Schema::new("pre", &PLACEMENT);
const KEY: Schema = Schema::new("key", &PLACEMENT);
const NEX: Schema = Schema::new("nex", &PLACEMENT);
