//! What each request gets.

use std::sync::Arc;
use std::time::Duration;

use http_body_util::{BodyExt, Full, Limited};
use hyper::body::{Bytes, Incoming};
use hyper::header::{
    CACHE_CONTROL, CONTENT_DISPOSITION, CONTENT_SECURITY_POLICY, CONTENT_TYPE, HeaderName,
    HeaderValue, REFERRER_POLICY, X_CONTENT_TYPE_OPTIONS, X_FRAME_OPTIONS,
};
use hyper::{Method, Request, Response, StatusCode};
use serde_json::{Value, json};

use super::guard::Guard;
use super::page;
use crate::command::Command;
use crate::finished::Progress;
use crate::look::bytes;
use crate::studio::{Link, Shown};

/// Longest body of a request.
const LONGEST_BODY: usize = 64 << 10;
/// How long the body of a request may take.
const BODY: Duration = Duration::from_secs(5);
/// How long a request waits for news.
const PATIENCE: Duration = Duration::from_secs(20);
/// Most requests that wait for the studio.
const MOST_WAITING: usize = 256;

/// What browsers may do with anything from here: run what comes from here, and show pictures.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; \
     img-src 'self' blob:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
/// Header with the facts of a picture, as JSON.
const FACTS: HeaderName = HeaderName::from_static("slo-facts");

type Answer = Response<Full<Bytes>>;

/// Sends the browser to another address.
fn moved(to: &str) -> Answer {
    let mut answer = empty(StatusCode::PERMANENT_REDIRECT);
    if let Ok(to) = HeaderValue::from_str(to) {
        answer.headers_mut().insert(hyper::header::LOCATION, to);
    }
    answer
}

/// Answers a request.
pub(super) async fn answer(request: Request<Incoming>, guard: &Guard, link: &Arc<Link>) -> Answer {
    let path = match guard.admit(&request) {
        Ok(path) => path.to_owned(),
        Err(status) => {
            let mut answer = empty(status);
            // A stranger's next try costs a new connection.
            let close = HeaderValue::from_static("close");
            answer.headers_mut().insert(hyper::header::CONNECTION, close);
            return answer;
        }
    };
    let after = after(request.uri().query());
    match (request.method(), path.as_str()) {
        // The address, copied without its end.
        (&Method::GET, "/") => moved(&format!("{}/", request.uri().path())),
        (&Method::GET, "picture") => picture(after, link).await,
        (&Method::GET, "state") => state(after, link).await,
        (&Method::GET, "finished") => finished(link),
        (&Method::POST, "do") => perform(request, link).await,
        (&Method::GET, name) => match page::file(name) {
            Some(page::File { content, kind }) => with_kind(content.as_bytes().to_vec(), kind),
            None => empty(StatusCode::NOT_FOUND),
        },
        _ => empty(StatusCode::METHOD_NOT_ALLOWED),
    }
}

/// The number in `after=N`: what the page knows already.
fn after(query: Option<&str>) -> u64 {
    let number = query.and_then(|query| query.strip_prefix("after="));
    number.and_then(|number| number.parse().ok()).unwrap_or(0)
}

/// The next picture, as soon as there is one.
async fn picture(after: u64, link: &Link) -> Answer {
    let mut screen = link.screen();
    let is_new = |shown: &Option<Arc<Shown>>| shown.as_ref().is_some_and(|of| of.number != after);
    let shown = match tokio::time::timeout(PATIENCE, screen.wait_for(is_new)).await {
        Ok(Ok(shown)) => shown.clone(),
        _ => None,
    };
    let Some(shown) = shown else { return empty(StatusCode::NO_CONTENT) };
    let mut facts = shown.shot.facts();
    facts["number"] = shown.number.into();
    // Encoding takes milliseconds, in which other requests are answered.
    let encoded = tokio::task::spawn_blocking(move || png(&shown)).await;
    let (Ok(Some(png)), Ok(facts)) = (encoded, HeaderValue::from_str(&facts.to_string())) else {
        return empty(StatusCode::INTERNAL_SERVER_ERROR);
    };
    let mut answer = with_kind(png, "image/png");
    answer.headers_mut().insert(FACTS, facts);
    answer
}

fn png(shown: &Shown) -> Option<Vec<u8>> {
    let image = &shown.shot.image;
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, image.width, image.height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Fastest);
    let mut writer = encoder.write_header().ok()?;
    let mut pixels = bytes(image, shown.look);
    if let Some(map) = &shown.shot.map {
        map.over(&mut pixels);
    }
    writer.write_image_data(&pixels).ok()?;
    writer.finish().ok()?;
    Some(file)
}

/// What there is to know, as soon as it is new.
async fn state(after: u64, link: &Link) -> Answer {
    let mut receiver = link.state();
    let is_new = |(number, _): &(u64, Value)| *number != after;
    let known = match tokio::time::timeout(PATIENCE, receiver.wait_for(is_new)).await {
        Ok(Ok(known)) => known.clone(),
        _ => return empty(StatusCode::NO_CONTENT),
    };
    let (number, state) = known;
    json_answer(&json!({ "number": number, "scene": state, "finish": finish(link) }))
}

fn finish(link: &Link) -> Value {
    match link.finished() {
        Progress::None => Value::Null,
        Progress::Rendering(share) => json!({ "share": share }),
        Progress::Finished(finished) => json!({ "name": finished.name }),
        Progress::Failed(why) => json!({ "error": why }),
    }
}

/// The file of the finished frame.
fn finished(link: &Link) -> Answer {
    let Progress::Finished(finished) = link.finished() else {
        return empty(StatusCode::NOT_FOUND);
    };
    let mut answer = with_kind(finished.bytes.to_vec(), "application/octet-stream");
    answer.headers_mut().insert(CONTENT_DISPOSITION, HeaderValue::from_static("attachment"));
    answer
}

/// Does what the page asks for.
async fn perform(request: Request<Incoming>, link: &Link) -> Answer {
    let body = Limited::new(request.into_body(), LONGEST_BODY);
    let Ok(Ok(body)) = tokio::time::timeout(BODY, body.collect()).await else {
        return empty(StatusCode::PAYLOAD_TOO_LARGE);
    };
    let value = serde_json::from_slice(&body.to_bytes()).ok();
    let Some(command) = value.as_ref().and_then(Command::read) else {
        return empty(StatusCode::BAD_REQUEST);
    };
    if link.waiting() >= MOST_WAITING {
        return empty(StatusCode::TOO_MANY_REQUESTS);
    }
    match link.ask(command).await {
        Ok(Ok(picture)) => json_answer(&json!({ "picture": picture })),
        Ok(Err(why)) => json_answer(&json!({ "refused": why })),
        Err(_) => empty(StatusCode::INTERNAL_SERVER_ERROR),
    }
}

fn json_answer(value: &Value) -> Answer {
    with_kind(value.to_string().into_bytes(), "application/json")
}

fn with_kind(content: Vec<u8>, kind: &'static str) -> Answer {
    let mut answer = bare(content);
    answer.headers_mut().insert(CONTENT_TYPE, HeaderValue::from_static(kind));
    answer
}

fn empty(status: StatusCode) -> Answer {
    let mut answer = bare(Vec::new());
    *answer.status_mut() = status;
    answer
}

fn bare(content: Vec<u8>) -> Answer {
    let mut answer = Response::new(Full::new(Bytes::from(content)));
    let headers = answer.headers_mut();
    for (name, value) in [
        (CONTENT_SECURITY_POLICY, POLICY),
        // The address holds the token.
        (REFERRER_POLICY, "no-referrer"),
        (X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (X_FRAME_OPTIONS, "DENY"),
        (CACHE_CONTROL, "no-store"),
        (HeaderName::from_static("cross-origin-opener-policy"), "same-origin"),
        (HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
    ] {
        headers.insert(name, HeaderValue::from_static(value));
    }
    answer
}
