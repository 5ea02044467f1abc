//! `addKframe`, which all that may move takes.

use super::schema::{Attribute, Schema, block, choice, number, point};

/// `addKframe`
pub(crate) const ADD_KFRAME: Schema =
    Schema::new("addKframe", &[number("time").required(), block(&PRE), block(&KEY), block(&NEX)]);

/// `repeat`, which stands beside key frames.
pub(crate) const REPEAT: Attribute = choice("repeat");

const PLACEMENT: [Attribute; 5] =
    [point("pivot"), point("up"), point("right"), block(&TURN), point("turn_deg")];
const TURN: Schema =
    Schema::new("turn", &[point("axis").required(), number("angle_deg").required()]);
const PRE: Schema = Schema::new("pre", &PLACEMENT);
const KEY: Schema = Schema::new("key", &PLACEMENT);
const NEX: Schema = Schema::new("nex", &PLACEMENT);
