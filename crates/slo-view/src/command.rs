//! What the page asks for.

use glam::DVec3;
use serde_json::Value;

use crate::camera::Move;
use crate::changes::{Field, Kind, New, Place};
use crate::look::Overlay;
use crate::placing::Motion;

/// A request of the page.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Command {
    /// Show another frame.
    Frame(i64),
    /// Move the camera.
    Move(Move),
    /// Change the lens and the shutter.
    Lens(Lens),
    /// Make sharp what is at a place of the picture; both numbers run from 0 to 1.
    Focus([f64; 2]),
    /// Find out what is at a place of the picture, and move about it from now on.
    Pick([f64; 2]),
    /// Select an object or a lamp by its name.
    Select(String),
    /// Show vertices of the selected mesh near a place of the picture; `None`: show none.
    Vertices(Option<[f64; 2]>),
    /// Choose a vertex: `true`: beside those that are chosen.
    Vertex(u32, bool),
    /// Explain what is seen at a place of the picture.
    Why([f64; 2]),
    /// Move, turn or scale a thing by a handle.
    Drag(Drag),
    /// Move a control point of the camera's path.
    Point(PathPoint),
    /// Add a segment in which the camera goes around once, in so many seconds.
    OrbitOnce(f64),
    /// Return to the camera of the scene.
    Reset,
    /// Change how the picture is shown.
    Show(Show),
    /// Render the frame as the program does.
    Finish,
    /// Stop that.
    Cancel,
    /// Change the text.
    Edit(TextEdit),
    /// Open another scene, of which things are to be taken over.
    Open(String),
    /// Take things of it over, by their numbers.
    Take(Vec<usize>),
    /// Close it.
    Close,
    /// Take the last change of the text back.
    Undo,
    /// Repeat a change that was taken back.
    Redo,
    /// Write the text to its file; `true`: even if it has errors.
    Save(bool),
    /// Return to what the file says.
    Revert,
    /// Keep the text, though the file has been changed in the same lines.
    Mine,
}

/// How far a handle is from where it was taken hold of.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Drag {
    /// All steps of one drag have the same number, and the next has another.
    pub(crate) number: u64,
    pub(crate) name: String,
    pub(crate) motion: Motion,
    /// Whether only its chosen vertices are moved.
    pub(crate) is_of_vertices: bool,
}

/// A control point of the camera's path, and where it goes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PathPoint {
    /// As that of a [`Drag`].
    pub(crate) number: u64,
    pub(crate) segment: String,
    pub(crate) is_target: bool,
    pub(crate) index: usize,
    pub(crate) to: DVec3,
}

/// A change of the text; names are those of objects and lamps.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum TextEdit {
    /// Give an attribute a value.
    Set(Field),
    /// Leave it out of the picture.
    Hide(String),
    /// Take it out of the text.
    Remove(String),
    /// Write it once more.
    Copy(String),
    /// Add a key frame where it is.
    KeyFrame(String),
    /// Add something.
    Add(New),
}

/// Numbers of the lens and the shutter; `None`: as they are.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Lens {
    /// Half height of the view at distance 1.
    pub(crate) fov: Option<f64>,
    /// Distance of the sharp plane.
    pub(crate) dof: Option<f64>,
    /// Radius of the lens.
    pub(crate) radius: Option<f64>,
    /// Seconds that the shutter stays open.
    pub(crate) shutter: Option<f64>,
}

/// How the picture is shown; `None`: as it is.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Show {
    /// Stops by which the picture is brightened, beside those of the scene.
    pub(crate) exposure: Option<f32>,
    /// Sides of the picture as a share of the scene's.
    pub(crate) share: Option<f64>,
    /// Word for the structure; empty: the scene's.
    pub(crate) accelerator: Option<String>,
    /// Whether the scene is shown from above.
    pub(crate) plan: Option<bool>,
    /// What is laid over the picture.
    pub(crate) overlay: Option<Overlay>,
}

/// Longest path of a file.
const LONGEST_PATH: usize = 4096;
/// Largest number of anything.
const MOST: f64 = 1e12;

impl Command {
    /// Reads a request. `None` if it is none.
    pub(crate) fn read(value: &Value) -> Option<Self> {
        let number = |name: &str| bounded(value.get(name)?);
        let numbers = |name: &str| -> Option<Vec<f64>> {
            value.get(name)?.as_array().filter(|all| all.len() <= 3)?.iter().map(bounded).collect()
        };
        let pair = |name: &str| <[f64; 2]>::try_from(numbers(name)?).ok();
        let place =
            |name: &str| pair(name).filter(|at| at.iter().all(|at| (0.0..=1.0).contains(at)));
        let vector = |name: &str| Some(DVec3::from(<[f64; 3]>::try_from(numbers(name)?).ok()?));
        Some(match value.get("do")?.as_str()? {
            "frame" => Self::Frame(value.get("frame")?.as_i64()?),
            "orbit" => pair("by").map(|[yaw, pitch]| Self::Move(Move::Orbit(yaw, pitch)))?,
            "turn" => pair("by").map(|[yaw, pitch]| Self::Move(Move::Turn(yaw, pitch)))?,
            "walk" => Self::Move(Move::Walk(vector("by")?)),
            "dolly" => {
                let factor = number("by").filter(|by| (1e-3..=1e3).contains(by))?;
                Self::Move(Move::Dolly(factor))
            }
            "along" => Self::Move(Move::Along(vector("axis")?.try_normalize()?)),
            "lens" => {
                let at_least = |name, least: f64| number(name).filter(|number| *number >= least);
                Self::Lens(Lens {
                    fov: at_least("fov", 1e-4),
                    dof: at_least("dof", 1e-9),
                    radius: at_least("radius", 0.0),
                    shutter: at_least("shutter", 0.0),
                })
            }
            "focus" => Self::Focus(place("at")?),
            "pick" => Self::Pick(place("at")?),
            "select" => Self::Select(word(value, "name")?),
            "vertices" => match value.get("shown")?.as_bool()? {
                true => Self::Vertices(Some(place("near")?)),
                false => Self::Vertices(None),
            },
            "vertex" => Self::Vertex(
                u32::try_from(value.get("vertex")?.as_u64()?).ok()?,
                value.get("beside").and_then(Value::as_bool).unwrap_or(false),
            ),
            "why" => Self::Why(place("at")?),
            "move" => drag(value, Motion::Move(vector("by")?))?,
            "rotate" => {
                drag(value, Motion::Turn(vector("axis")?.try_normalize()?, number("degrees")?))?
            }
            "scale" => {
                let by = vector("by").filter(|by| {
                    by.cmpge(DVec3::splat(1e-6)).all() && by.cmple(DVec3::splat(1e6)).all()
                })?;
                drag(value, Motion::Scale(by))?
            }
            "point" => Self::Point(PathPoint {
                number: value.get("drag")?.as_u64()?,
                segment: word(value, "segment")?,
                is_target: value.get("of")?.as_str()? == "target",
                index: usize::try_from(value.get("index")?.as_u64()?).ok()?,
                to: vector("to")?,
            }),
            "around" => {
                Self::OrbitOnce(number("seconds").filter(|time| (0.04..=3600.0).contains(time))?)
            }
            "add" => Self::Edit(TextEdit::Add(New {
                kind: Kind::read(&word(value, "kind")?)?,
                file: word(value, "file").unwrap_or_default(),
            })),
            "reset" => Self::Reset,
            "show" => Self::Show(Show {
                exposure: number("exposure").map(|stops| stops.clamp(-20.0, 20.0) as f32),
                share: number("share").filter(|share| (0.05..=1.0).contains(share)),
                accelerator: word(value, "accelerator"),
                plan: value.get("plan").and_then(Value::as_bool),
                overlay: word(value, "overlay").and_then(|word| Overlay::read(&word)),
            }),
            "finish" => Self::Finish,
            "cancel" => Self::Cancel,
            "set" => Self::Edit(TextEdit::Set(field(value)?)),
            "hide" => Self::Edit(TextEdit::Hide(word(value, "name")?)),
            "remove" => Self::Edit(TextEdit::Remove(word(value, "name")?)),
            "copy" => Self::Edit(TextEdit::Copy(word(value, "name")?)),
            "key" => Self::Edit(TextEdit::KeyFrame(word(value, "name")?)),
            "open" => Self::Open(word(value, "file").filter(|path| path.len() <= LONGEST_PATH)?),
            "take" => {
                let number = |of: &Value| usize::try_from(of.as_u64()?).ok();
                let things = value.get("things")?.as_array()?;
                Self::Take(things.iter().map(number).collect::<Option<_>>()?)
            }
            "close" => Self::Close,
            "undo" => Self::Undo,
            "redo" => Self::Redo,
            "save" => Self::Save(value.get("anyway").and_then(Value::as_bool).unwrap_or(false)),
            "revert" => Self::Revert,
            "mine" => Self::Mine,
            _ => return None,
        })
    }
}

fn bounded(value: &Value) -> Option<f64> {
    value.as_f64().filter(|number| number.abs() <= MOST)
}

fn drag(value: &Value, motion: Motion) -> Option<Command> {
    let number = value.get("drag")?.as_u64()?;
    let is_of_vertices = value.get("vertices").and_then(Value::as_bool).unwrap_or(false);
    Some(Command::Drag(Drag { number, name: word(value, "name")?, motion, is_of_vertices }))
}

fn word(value: &Value, name: &str) -> Option<String> {
    value.get(name)?.as_str().map(str::to_owned)
}

/// The attribute that a request gives a value.
fn field(value: &Value) -> Option<Field> {
    let block = |block: &Value| {
        let index = usize::try_from(block.get(1)?.as_u64()?).ok()?;
        Some((block.get(0)?.as_str()?.to_owned(), index))
    };
    let blocks = value.get("blocks")?.as_array()?.iter().map(block).collect::<Option<Vec<_>>>()?;
    Some(Field {
        place: Place { keyword: word(value, "keyword")?, name: word(value, "name")?, blocks },
        attribute: word(value, "attribute")?,
        value: word(value, "value")?,
        is_vector: value.get("vector")?.as_bool()?,
    })
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn requests() {
        let read = |value: Value| Command::read(&value);
        assert_eq!(read(json!({ "do": "frame", "frame": -3 })), Some(Command::Frame(-3)));
        let orbit = Command::Move(Move::Orbit(0.5, -1.0));
        assert_eq!(read(json!({ "do": "orbit", "by": [0.5, -1] })), Some(orbit));
        let lens = Lens { radius: Some(0.0), ..Lens::default() };
        assert_eq!(
            read(json!({ "do": "lens", "radius": 0, "fov": -1 })),
            Some(Command::Lens(lens))
        );
    }

    #[test]
    fn what_is_no_request_does_nothing() {
        for wrong in [
            json!(null),
            json!({}),
            json!({ "do": "burn" }),
            json!({ "do": "frame", "frame": 1.5 }),
            json!({ "do": "orbit", "by": [1] }),
            json!({ "do": "orbit", "by": [1, 2, 3] }),
            json!({ "do": "walk", "by": [1, 2, 1e99] }),
            json!({ "do": "dolly", "by": 0 }),
            json!({ "do": "along", "axis": [0, 0, 0] }),
            json!({ "do": "pick", "at": [0.5, 1.1] }),
            json!({ "do": "set", "keyword": "sphere", "name": "a", "attribute": "b", "value": "c" }),
            json!({ "do": "hide" }),
            json!({ "do": "open", "file": "a".repeat(5000) }),
            json!({ "do": "take", "things": [-1] }),
            json!({ "do": "vertices", "shown": true, "near": [0.5, 2] }),
            json!({ "do": "vertex", "vertex": 5e9 }),
            json!({ "do": "move", "drag": 1, "name": "a", "by": [1, 2] }),
            json!({ "do": "rotate", "drag": 1, "name": "a", "axis": [0, 0, 0], "degrees": 5 }),
            json!({ "do": "scale", "drag": 1, "name": "a", "by": [1, 0, 1] }),
            json!({ "do": "scale", "name": "a", "by": [1, 2, 1] }),
        ] {
            assert_eq!(Command::read(&wrong), None, "{wrong}");
        }
    }
}
