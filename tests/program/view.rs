//! `view`: the server, as a browser and as strangers see it.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use super::{Folder, SCENE};

/// How long anything may take on a busy machine.
const PATIENCE: Duration = Duration::from_secs(60);

/// A program that shows a scene, until this is dropped.
struct View {
    child: Child,
    /// Host and port.
    host: String,
    /// Path of the page.
    path: String,
}

/// An answer of the server.
#[derive(Debug)]
struct Answer {
    status: u16,
    head: String,
    body: Vec<u8>,
}

impl View {
    fn start(folder: &Folder, typed: &str) -> Self {
        let mut command = folder.command(&format!("view -q --threads 2 {typed}"));
        let mut child = command.stdout(Stdio::piped()).spawn().expect("the program starts");
        let mut address = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut address).unwrap();
        let address = address.trim().strip_prefix("http://").expect("an address is printed");
        let (host, path) = address.split_once('/').unwrap();
        Self { child, host: host.to_owned(), path: format!("/{path}") }
    }

    /// Sends bytes and returns the answer.
    fn send(&self, bytes: &[u8]) -> Answer {
        let mut stream = TcpStream::connect(&self.host).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        // A server that refuses may close the connection before it has read everything.
        let _ = stream.write_all(bytes);
        let mut answer = Vec::new();
        let _ = stream.read_to_end(&mut answer);
        let end = answer.windows(4).position(|four| four == b"\r\n\r\n").unwrap_or(answer.len());
        let head = String::from_utf8_lossy(&answer[..end]).into_owned();
        let status = head.split(' ').nth(1).and_then(|status| status.parse().ok()).unwrap_or(0);
        Answer { status, head, body: answer.get(end + 4..).unwrap_or_default().to_vec() }
    }

    /// Gets something with headers of its own, which begin with the host.
    fn get_with(&self, path: &str, headers: &str) -> Answer {
        self.send(format!("GET {path} HTTP/1.1\r\n{headers}connection: close\r\n\r\n").as_bytes())
    }

    fn get(&self, name: &str) -> Answer {
        self.get_with(&format!("{}{name}", self.path), &format!("host: {}\r\n", self.host))
    }

    /// Asks for something, which must be possible.
    fn ask(&self, command: &Value) -> Value {
        let answer = self.post(&command.to_string());
        assert_eq!(answer.status, 200, "{command}: {}", answer.head);
        serde_json::from_slice(&answer.body).unwrap()
    }

    fn post(&self, body: &str) -> Answer {
        let (path, host, len) = (&self.path, &self.host, body.len());
        let head = format!("POST {path}do HTTP/1.1\r\nhost: {host}\r\norigin: http://{host}\r\n");
        self.send(
            format!("{head}content-length: {len}\r\nconnection: close\r\n\r\n{body}").as_bytes(),
        )
    }

    fn state(&self) -> Value {
        let answer = self.get("state");
        assert_eq!(answer.status, 200, "{}", answer.head);
        serde_json::from_slice(&answer.body).unwrap()
    }

    /// Waits until the state has something.
    fn state_with<T>(&self, has: impl Fn(&Value) -> Option<T>) -> T {
        let start = Instant::now();
        loop {
            let state = self.state();
            if let Some(found) = has(&state) {
                return found;
            }
            assert!(start.elapsed() < PATIENCE, "{state:#}");
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// Waits for the picture of a change that has all of its samples: its facts, and its file.
    fn picture(&self, picture: u64) -> (Value, Vec<u8>) {
        let mut after = 0;
        loop {
            let answer = self.get(&format!("picture?after={after}"));
            assert_eq!(answer.status, 200, "{}", answer.head);
            let facts = answer.head.lines().find_map(|line| line.strip_prefix("slo-facts: "));
            let facts: Value = serde_json::from_str(facts.unwrap()).unwrap();
            after = facts["number"].as_u64().unwrap();
            if facts["picture"].as_u64().unwrap() >= picture && facts["done"] == true {
                return (facts, answer.body);
            }
        }
    }
}

impl Drop for View {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[test]
fn strangers_get_nothing() {
    let folder = Folder::new();
    let view = View::start(&folder, "scene.txt");
    let (host, path) = (&view.host, &view.path);
    let page = view.get("");
    assert_eq!(page.status, 200);
    assert!(page.head.contains("content-security-policy: default-src 'none'"), "{}", page.head);
    assert!(page.head.contains("referrer-policy: no-referrer"), "{}", page.head);
    let port = host.rsplit(':').next().unwrap();
    let token = path.trim_matches('/');
    let wrong = "0".repeat(32);
    for (path, headers) in [
        ("/".to_owned(), format!("host: {host}\r\n")),
        ("/state".to_owned(), format!("host: {host}\r\n")),
        (format!("/{wrong}/state"), format!("host: {host}\r\n")),
        (format!("/{}/state", &token[..31]), format!("host: {host}\r\n")),
        (format!("{path}state"), format!("host: evil.example:{port}\r\n")),
        (format!("{path}state"), format!("host: {host}\r\norigin: http://evil.example\r\n")),
        (format!("{path}state"), format!("host: {host}\r\nsec-fetch-site: cross-site\r\n")),
        (format!("{path}../../scene.txt"), format!("host: {host}\r\n")),
    ] {
        let answer = view.get_with(&path, &headers);
        assert_eq!((answer.status, answer.body.len()), (404, 0), "{path} {headers}");
        assert!(!answer.head.contains(token), "{}", answer.head);
    }
    assert_eq!(view.get_with(&format!("{path}state"), "").status, 404, "no host");
    // What the page itself would not send.
    assert_eq!(view.post("{").status, 400);
    assert_eq!(view.post(r#"{ "do": "burn" }"#).status, 400);
    assert_eq!(view.post(&format!("\"{}\"", "x".repeat(70_000))).status, 413);
    let long = format!("GET {path}{} HTTP/1.1\r\nhost: {host}\r\n\r\n", "x".repeat(100_000));
    assert_ne!(view.send(long.as_bytes()).status, 200);
    assert_eq!(view.get("").status, 200, "the page is still there");
    // A flood is cut off, and the person is not.
    let flood = (0..100).map(|_| view.get_with("/guess/", &format!("host: {host}\r\n")).status);
    let flood: Vec<u16> = flood.collect();
    assert!(flood.iter().all(|status| [404, 429, 0].contains(status)), "{flood:?}");
    let silent: Vec<_> = (0..50).map(|_| TcpStream::connect(host).unwrap()).collect();
    assert_eq!(view.get("").status, 200);
    drop(silent);
}

#[test]
fn the_finished_frame_is_the_file_of_the_program() {
    let folder = Folder::new();
    let view = View::start(&folder, "scene.txt --frame 3");
    view.ask(&json!({ "do": "finish" }));
    let name = view.state_with(|state| Some(state["finish"]["name"].as_str()?.to_owned()));
    assert_eq!(name, "ball_00003.png");
    let finished = view.get("finished");
    assert_eq!(folder.printed("-s scene.txt -f 3 -q"), "ball_00003.png\n");
    assert!(finished.body == folder.read("ball_00003.png"));
    drop(view);
    assert_eq!(folder.names(), ["ball_00003.png"], "nothing else is written");
}

#[test]
fn the_picture_follows_the_text() {
    let folder = Folder::new();
    let view = View::start(&folder, "scene.txt");
    let (facts, before) = view.picture(1);
    assert_eq!((&facts["width"], &facts["height"]), (&json!(16), &json!(9)));
    let frame = |state: &Value| state["scene"]["stage"]["frame"].as_i64();
    assert_eq!(view.state_with(frame), 0);

    folder.write("scene.txt", SCENE.replace("diffuse { .7 .6 .5 }", "diffuse { .1 .9 .1 }"));
    let number = facts["picture"].as_u64().unwrap();
    let (facts, green) = view.picture(number + 1);
    assert_ne!(before, green, "{facts}");

    folder.write("scene.txt", SCENE.replace("radius 1", "radius x"));
    let message = view.state_with(|state| {
        let messages = state["scene"]["messages"].as_array()?;
        messages.first().cloned()
    });
    assert_eq!(message["severity"], "error");
    assert_eq!(message["place"]["line"], 14, "{message}");
    assert!(message["place"]["text"].as_str().unwrap().contains("radius x"));
    let (now, last_good) = view.picture(0);
    assert_eq!(last_good, green, "{now} after {facts}");

    folder.write("scene.txt", SCENE);
    let (_, after) = view.picture(facts["picture"].as_u64().unwrap() + 1);
    assert_eq!(after, before);
    assert_eq!(view.state_with(|state| state["scene"]["messages"].as_array().map(Vec::len)), 0);
}

#[test]
fn the_camera_goes_where_it_is_sent() {
    let folder = Folder::new();
    let view = View::start(&folder, "scene.txt");
    let (_, before) = view.picture(1);
    let numbers = |state: &Value, name: &str| -> Vec<f64> {
        let numbers = state["scene"]["stage"]["camera"][name].as_array().unwrap();
        numbers.iter().map(|number| number.as_f64().unwrap()).collect()
    };
    view.ask(&json!({ "do": "pick", "at": [0.5, 0.5] }));
    let picked = view.state_with(|state| {
        Some(state["scene"]["picked"].clone()).filter(|picked| !picked.is_null())
    });
    assert_eq!((&picked["object"], &picked["material"]), (&json!("ball"), &json!("matte")));
    // The ball has the radius 1, and its middle is 5.1 away.
    let depth = picked["depth"].as_f64().unwrap();
    assert!((depth - 26f64.sqrt() + 1.0).abs() < 0.1, "{picked}");

    let answer = view.ask(&json!({ "do": "along", "axis": [0, 0, 1] }));
    let (_, above) = view.picture(answer["picture"].as_u64().unwrap());
    assert_ne!(above, before);
    let position = numbers(&view.state(), "position");
    assert!(position[2] > 4.0 && position[1].abs() < 1.5, "{position:?}");

    let answer = view.ask(&json!({ "do": "reset" }));
    assert_eq!(view.picture(answer["picture"].as_u64().unwrap()).1, before);
    let answer = view.ask(&json!({ "do": "focus", "at": [0.5, 0.5] }));
    assert!(answer["picture"].is_u64(), "{answer}");
    assert!(
        (view.state()["scene"]["stage"]["camera"]["dof"].as_f64().unwrap() - depth).abs() < 0.1
    );
    let answer = view.ask(&json!({ "do": "focus", "at": [0.0, 0.0] }));
    assert_eq!(answer["refused"], "there is nothing to focus on");
}

#[test]
fn a_signal_ends_it_at_once() {
    let folder = Folder::new();
    let mut view = View::start(&folder, "scene.txt");
    let _stream = TcpStream::connect(&view.host).unwrap();
    // SIGINT may be ignored where tests run in the background.
    let interrupt = std::process::Command::new("kill")
        .args(["-TERM", &view.child.id().to_string()])
        .status()
        .unwrap();
    assert!(interrupt.success());
    let start = Instant::now();
    assert_eq!(view.child.wait().unwrap().code(), Some(75));
    assert!(start.elapsed() < PATIENCE);
}

#[test]
fn what_can_not_be_shown_is_said() {
    let folder = Folder::new();
    for (typed, exit, said) in [
        ("view gone.txt", 66, "can't read the scene `gone.txt`"),
        ("view scene.txt --listen here", 2, "such as 127.0.0.1:8000"),
        ("view scene.txt -f 99999", 2, "frame 99999"),
        ("view scene.txt --listen 192.0.2.1:80", 73, "can't listen on 192.0.2.1:80"),
    ] {
        let run = folder.run(typed);
        assert_eq!(run.exit, exit, "{typed}: {}", run.said);
        assert!(run.said.contains(said), "{typed}: {}", run.said);
    }
}

/// What the page says about the text.
fn differences(view: &View) -> Vec<(String, String)> {
    let state = view.state();
    let hunks = state["scene"]["text"]["differences"].as_array().unwrap();
    let lines = |of: &Value| -> String {
        of.as_array().unwrap().iter().map(|line| line.as_str().unwrap()).collect()
    };
    hunks.iter().map(|hunk| (lines(&hunk["old"]), lines(&hunk["new"]))).collect()
}

#[test]
fn handles_change_a_few_characters_and_each_drag_is_one_step() {
    let folder = Folder::new();
    let view = View::start(&folder, "scene.txt");
    view.ask(&json!({ "do": "select", "name": "ball" }));
    let picked = view.state()["scene"]["picked"].clone();
    assert_eq!(picked["material"], "matte");
    let at = |state: &Value| state["scene"]["picked"]["handle"]["at"].clone();
    let before = at(&view.state());
    for by in [0.1, 0.3, 0.5] {
        let drag = json!({ "do": "move", "drag": 1, "name": "ball", "by": [by, 0, 0] });
        assert!(view.ask(&drag)["picture"].is_u64());
    }
    let moved = differences(&view);
    assert_eq!(moved.len(), 1);
    let (old, new) = &moved[0];
    let changed = old.chars().filter(|c| !new.contains(*c)).count() + new.len() - old.len();
    assert!(changed <= 4, "{old}{new}");
    let x = |at: &Value| at[0].as_f64().unwrap();
    assert!((x(&at(&view.state())) - x(&before) - 0.5).abs() < 1e-9);
    view.ask(&json!({ "do": "move", "drag": 2, "name": "ball", "by": [0, 0, 1] }));
    view.ask(&json!({ "do": "undo" }));
    assert_eq!(differences(&view), moved, "the second drag is a step of its own");
    let late = view.ask(&json!({ "do": "move", "drag": 2, "name": "ball", "by": [0, 0, 2] }));
    assert_eq!(late["refused"], "the text has changed meanwhile");
    view.ask(&json!({ "do": "undo" }));
    assert_eq!(differences(&view), [], "all steps of a drag are one");
    let none = view.ask(&json!({ "do": "move", "drag": 3, "name": "none", "by": [0, 0, 2] }));
    assert_eq!(none["refused"], "`none` has no place of its own");
}

#[test]
fn frames_that_are_not_there_are_refused() {
    let folder = Folder::new();
    let view = View::start(&folder, "scene.txt");
    let answer = view.ask(&json!({ "do": "frame", "frame": 99 }));
    assert_eq!(answer["refused"], "there is no frame 99: the scene has 0 to 25");
    assert_eq!(view.state()["scene"]["stage"]["frame"], 0);
    view.ask(&json!({ "do": "frame", "frame": 20 }));
    assert!(view.state()["scene"]["missing"].is_null());
    // A shorter scene does not have it any more.
    folder.write("scene.txt", SCENE.replace("videoEnd 1", "videoEnd .4"));
    let said = view.state_with(|state| Some(state["scene"]["missing"].as_str()?.to_owned()));
    assert_eq!(said, "there is no frame 20: the scene has 0 to 10");
    assert_eq!(view.state()["scene"]["stage"]["frame"], 10);
}

/// A triangle and a corner that belongs to nothing.
const MESH: &str = "slo_mesh 1 vertices { -1 0 -1  1 0 -1  0 0 1  9 9 9 } faces { 0 1 2 }";

#[test]
fn things_of_another_scene_are_taken_over() {
    let folder = Folder::new();
    std::fs::create_dir(folder.path().join("men")).unwrap();
    folder.write("men/knight.slo", MESH);
    let knight =
        "phong_info matte { diffuse { .1 .2 .3 } }\nmaterial_phong matte { phong_info matte }
# a knight\nmesh ball { filename knight.slo material matte }\n";
    folder.write("men/knight.txt", knight);
    let view = View::start(&folder, "scene.txt");
    view.picture(1);
    let refused = |path: &str| view.ask(&json!({ "do": "open", "file": path }))["refused"].clone();
    let path = "men/knigt.txt";
    assert_eq!(refused(path), "there is no `men/knigt.txt`; did you mean `men/knight.txt`?");
    assert_eq!(refused("../scene.txt"), "`../scene.txt` leaves the input folder");
    assert!(refused("men/knight.slo").as_str().unwrap().contains("is no scene"));
    view.ask(&json!({ "do": "open", "file": "men/knight.txt" }));
    let state = view.state();
    assert_eq!(state["scene"]["scenes"], json!(["men/knight.txt"]));
    let lists = &state["scene"]["other"]["lists"];
    assert_eq!(lists[0]["things"], json!([{ "index": 2, "keyword": "mesh", "name": "ball" }]));
    let answer = view.ask(&json!({ "do": "take", "things": [2] }));
    assert!(answer["picture"].is_u64(), "{answer}");
    let state = view.state();
    let note = "Added 1, and 2 more that it needs; matte is now matte_2, ball is now ball_2";
    assert_eq!(state["scene"]["other"]["note"], note);
    assert_eq!(state["scene"]["messages"], json!([]));
    view.ask(&json!({ "do": "save" }));
    let added = "# From men/knight.txt\nphong_info matte_2 { diffuse { .1 .2 .3 } }
material_phong matte_2 { phong_info matte_2 }
# a knight\nmesh ball_2 { filename men/knight.slo material matte_2 }\n";
    assert_eq!(String::from_utf8(folder.read("scene.txt")).unwrap(), format!("{SCENE}{added}"));
    view.ask(&json!({ "do": "close" }));
    assert!(view.state()["scene"]["other"].is_null());
}

#[test]
fn vertices_are_moved_into_a_file_of_their_own() {
    let folder = Folder::new();
    folder.write("flag.slo", MESH);
    folder.write("flag_2.slo", "taken");
    let meshes = "mesh one { filename flag.slo material matte }
mesh two { filename flag.slo material matte addKframe { time 0 key { pivot { 0 1 0 } } } }\n";
    let text = format!("{SCENE}{meshes}").replace("sphere ball", "# sphere ball");
    folder.write("scene.txt", &text);
    let view = View::start(&folder, "scene.txt");
    view.picture(1);
    view.ask(&json!({ "do": "select", "name": "one" }));
    assert_eq!(view.state()["scene"]["mesh"], 4);
    view.ask(&json!({ "do": "vertices", "shown": true, "near": [0.5, 0.5] }));
    let shown = view.state()["scene"]["vertices"].clone();
    assert_eq!(shown["shown"].as_array().unwrap().len(), 3, "{shown}");
    assert_eq!((&shown["all"], &shown["handle"]), (&json!(true), &Value::Null));
    let drag = |number: u64, z: f64| {
        let by = json!([0, 0, z]);
        view.ask(
            &json!({ "do": "move", "drag": number, "name": "one", "vertices": true, "by": by }),
        )
    };
    assert_eq!(drag(1, 1.0)["refused"], "choose a vertex first");
    view.ask(&json!({ "do": "vertex", "vertex": 2 }));
    let at = || view.state()["scene"]["vertices"]["handle"]["at"][2].as_f64();
    assert_eq!(at(), Some(1.0));
    for z in [0.2, 0.5] {
        assert!(drag(2, z)["picture"].is_u64());
    }
    drag(3, 0.25);
    assert_eq!(at(), Some(1.75));
    let old = "mesh one { filename flag.slo material matte }\n".to_owned();
    let new = old.replace("flag", "flag_3");
    assert_eq!(differences(&view), [(old, new)]);
    assert!(!folder.path().join("flag_3.slo").exists(), "nothing is written before it is saved");
    for (step, z) in [("undo", 1.5), ("undo", 1.0), ("redo", 1.5), ("redo", 1.75)] {
        view.ask(&json!({ "do": step }));
        assert_eq!(at(), Some(z), "{step}");
    }
    // Another program takes the name.
    folder.write("flag_3.slo", "theirs");
    let answer = view.ask(&json!({ "do": "save" }));
    assert!(answer["picture"].is_u64(), "{answer}");
    let saved = text.replacen("flag.slo", "flag_4.slo", 1);
    assert_eq!(String::from_utf8(folder.read("scene.txt")).unwrap(), saved);
    let mesh = String::from_utf8(folder.read("flag_4.slo")).unwrap();
    assert!(mesh.contains("0 0 1.75\n"), "{mesh}");
    for (name, content) in [("flag.slo", MESH), ("flag_2.slo", "taken"), ("flag_3.slo", "theirs")] {
        assert_eq!(String::from_utf8(folder.read(name)).unwrap(), content);
    }
    assert_eq!(
        (at(), view.state()["scene"]["text"]["changed"].clone()),
        (Some(1.75), json!(false))
    );
    assert_eq!(folder.run("--check -s scene.txt").exit, 0);
    // What is saved is a file like any other, so the next change gets a file of its own.
    drag(4, 1.0);
    assert!(differences(&view)[0].1.contains("flag_5.slo"));
    view.ask(&json!({ "do": "select", "name": "two" }));
    assert!(view.state()["scene"]["vertices"].is_null());
}

#[test]
fn a_pixel_is_explained_as_the_program_does() {
    let folder = Folder::new();
    let view = View::start(&folder, "scene.txt");
    view.picture(1);
    view.ask(&json!({ "do": "why", "at": [0.5, 0.5] }));
    let why = view.state()["scene"]["why"].clone();
    assert_eq!((&why["pixel"], &why["frame"]), (&json!([8, 4]), &json!(0)));
    assert_eq!(why["replay"], "slo-rt why 8,4 scene.txt -f 0");
    let told: Value =
        serde_json::from_str(&folder.printed("why 8,4 scene.txt -f 0 --json")).unwrap();
    for (name, same) in [("samples", "samples"), ("rays", "rays"), ("mean", "mean")] {
        assert_eq!(why[name], told[same], "{why:#} {told:#}");
    }
    let first = &why["tables"][0]["shares"][0];
    assert_eq!(first["name"], told["byLight"][0]["name"]);
    assert!(why["brightest"][0]["way"].as_str().unwrap().starts_with("camera: "), "{why:#}");
    // Another picture has other pixels.
    view.ask(&json!({ "do": "orbit", "by": [0.1, 0] }));
    assert!(view.state()["scene"]["why"].is_null());
}

#[test]
fn overlays_lie_over_the_picture() {
    let folder = Folder::new();
    let view = View::start(&folder, "scene.txt");
    let (_, plain) = view.picture(1);
    let mut seen = vec![plain];
    for (overlay, most) in [("samples", 1e4), ("error", 0.125), ("cost", 1e6)] {
        let answer = view.ask(&json!({ "do": "show", "overlay": overlay }));
        let facts = |after: u64| {
            let (facts, picture) = view.picture(after);
            (facts["map"].clone(), picture)
        };
        let picture = answer["picture"].as_u64().unwrap();
        let start = Instant::now();
        let (map, picture) = loop {
            let (map, picture) = facts(picture);
            if map["overlay"] == overlay {
                break (map, picture);
            }
            assert!(start.elapsed() < PATIENCE, "{map}");
        };
        assert!(
            map["most"].as_f64().unwrap() <= most && map["least"].as_f64().unwrap() > 0.0,
            "{map}"
        );
        assert!(!seen.contains(&picture), "{overlay}");
        seen.push(picture);
    }
}

#[test]
fn errors_of_the_file_are_part_of_a_conflict() {
    let folder = Folder::new();
    let view = View::start(&folder, "scene.txt");
    let set = |value: &str| {
        json!({ "do": "set", "keyword": "sphere", "name": "ball", "blocks": [], "attribute": "radius",
            "value": value, "vector": false })
    };
    view.ask(&set("1.5"));
    folder.write("scene.txt", SCENE.replace("radius 1", "radius x"));
    view.state_with(|state| {
        state["scene"]["text"]["conflict"].as_bool().filter(|conflict| *conflict)
    });
    let messages = view.state()["scene"]["messages"].clone();
    assert_eq!((&messages[0]["of"], &messages[0]["severity"]), (&json!("file"), &json!("error")));
    // Errors of the text itself come first.
    view.ask(&set("y"));
    let messages = view.state()["scene"]["messages"].clone();
    assert!(
        messages[0]["of"].is_null()
            && messages[0]["place"]["text"].as_str().unwrap().contains("radius y")
    );
    assert_eq!(messages[1]["of"], "file");
    view.ask(&json!({ "do": "mine" }));
    view.ask(&set("2"));
    assert_eq!(view.state()["scene"]["messages"], json!([]));
}

#[test]
fn a_text_with_errors_is_saved_only_if_the_person_says_so() {
    let folder = Folder::new();
    let view = View::start(&folder, "scene.txt");
    view.ask(&json!({ "do": "set", "keyword": "sphere", "name": "ball", "blocks": [],
        "attribute": "radius", "value": "x", "vector": false }));
    let answer = view.ask(&json!({ "do": "save" }));
    assert!(answer["refused"].as_str().unwrap().contains("has errors"), "{answer}");
    assert_eq!(folder.read("scene.txt"), SCENE.as_bytes());
    let answer = view.ask(&json!({ "do": "save", "anyway": true }));
    assert!(answer["refused"].is_null(), "{answer}");
    assert_eq!(folder.read("scene.txt"), SCENE.replace("radius 1", "radius x").as_bytes());
}

#[test]
fn a_new_page_gets_in_however_many_connections_are_idle() {
    let folder = Folder::new();
    let view = View::start(&folder, "scene.txt");
    let idle: Vec<_> = (0..300).map(|_| TcpStream::connect(&view.host).unwrap()).collect();
    assert_eq!(view.get("").status, 200);
    assert_eq!(view.get("state").status, 200);
    drop(idle);
}
