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
        ("view scene.txt --listen 192.0.2.1:80", 73, "can't listen on 192.0.2.1:80"),
    ] {
        let run = folder.run(typed);
        assert_eq!(run.exit, exit, "{typed}: {}", run.said);
        assert!(run.said.contains(said), "{typed}: {}", run.said);
    }
}
