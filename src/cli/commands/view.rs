//! `view`: shows a scene in the browser.

use std::io;
use std::net::{Ipv4Addr, SocketAddr};
use std::path::Path;

use crate::cli::args::ViewArgs;
use crate::cli::base::{Exit, Problem, Terminal, print};
use crate::cli::files::load;
use crate::cli::files::scene_file::{self, SceneFile};
use crate::cli::options::{Job, Replay};
use crate::cli::system::threads;
use slo_scene::files::{Drafts, Opened};
use slo_scene::{KnownFiles, Loaded};
use slo_view::{Error, Options, Source, serve};

/// Prints the address of a page that shows the job's scene, and serves it until a signal comes.
pub(crate) fn run(args: &ViewArgs, job: Job, terminal: Terminal) -> Result<(), Problem> {
    // The scene may have errors, which the page shows, but it must be there.
    let file = load::file(&job)?;
    let listen = args.listen.unwrap_or(SocketAddr::from((Ipv4Addr::LOCALHOST, 0)));
    let options =
        Options { listen, frame: args.frame, pool: threads::pool(job.threads)?, isa: job.isa };
    if !listen.ip().is_loopback() {
        terminal.warn(
            "other machines can reach the page; whoever has its address can change the scene",
        );
    }
    let ready = |address: &str| {
        terminal.note("open this address in a browser; Ctrl-C ends the program");
        if listen.ip().is_unspecified() {
            terminal.note("elsewhere, write the address of this machine instead of 127.0.0.1");
        }
        if let Err(error) = print(address.as_bytes()) {
            terminal.warn(format_args!("can't print the address: {error}"));
        }
    };
    let replay = Replay::of_view(args);
    serve(Box::new(OfJob { job, file, replay }), options, ready).map_err(|error| match error {
        Error::Listen(error) => {
            let message = format!("can't listen on {listen}: {error}");
            Problem::new(Exit::CantCreate, message).with_help("choose another one with `--listen`")
        }
        Error::Frame(error) => load::no_segment(&error),
        error => Problem::new(Exit::Failed, error),
    })
}

/// The scene of a job, as the page's studio reads it.
struct OfJob {
    job: Job,
    file: SceneFile,
    /// What the user typed.
    replay: Replay,
}

impl Source for OfJob {
    fn name(&self) -> String {
        self.file.path.display().to_string()
    }

    fn path(&self) -> Option<&Path> {
        self.job.scene.as_ref().map(|_| &*self.file.path)
    }

    fn replay(&self, pixel: [u32; 2], frame: i64, size: Option<[u32; 2]>) -> String {
        let replay = self.replay.clone();
        let replay = match size {
            Some([width, height]) => replay.sized(width, height),
            None => replay,
        };
        replay.command(pixel, Some(frame))
    }

    fn read(&self) -> io::Result<Vec<u8>> {
        match &self.job.scene {
            None => Ok(self.file.text.clone()),
            Some(_) => scene_file::text(&self.file.path),
        }
    }

    fn open(&self, path: &str) -> Result<Vec<u8>, String> {
        load::open(&self.file, &self.job, path)
    }

    fn load(&self, text: &[u8], opened: &Opened, known: &KnownFiles, drafts: &Drafts) -> Loaded {
        let SceneFile { path, root, .. } = &self.file;
        let file = SceneFile { path: path.clone(), root: root.clone(), text: text.to_owned() };
        let remains = load::Remains { known: known.clone(), drafts: drafts.clone() };
        load::load(&file, &self.job, opened.clone(), Some(remains))
    }
}
