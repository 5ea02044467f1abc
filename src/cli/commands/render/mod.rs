//! Renders the frames of a job one after the other in one process.

mod ahead;
mod counted;
mod desk;
mod done;
mod dry_run;
mod frame;
mod guide_file;
mod ledger;
mod line;
mod maps;
mod plan;
mod run;
mod schedule;
mod sequence;
mod shared;
mod summary;
mod target;
mod total;
mod watch;

use std::time::Instant;

use crate::cli::base::{Problem, Terminal};
use crate::cli::claims::Left;
use crate::cli::files::load;
use crate::cli::options::Job;
use crate::cli::system::display::Display;
use crate::cli::system::interrupt::Guard;
use crate::cli::system::threads;
use frame::Studio;
pub(crate) use ledger::frames_of_ledger;
use plan::Step;
use run::Run;
use slo_scene::Accelerator;
use slo_scene::SceneDescription;
use slo_scene::files::Opened;
use target::Target;
use watch::Watcher;

/// Renders the job's frames, prints the paths of their pictures, and reports how it went.
pub(crate) fn run(job: &Job, terminal: Terminal) -> Result<(), Problem> {
    if job.watch {
        watch::run(job, terminal)
    } else {
        once(job, terminal, &Opened::default(), None)
    }
}

/// Renders the job's frames once. Notes the files of the scene, and gives up if the watcher says that one
/// has changed.
fn once(
    job: &Job,
    terminal: Terminal,
    opened: &Opened,
    watcher: Option<&Watcher>,
) -> Result<(), Problem> {
    let start = Instant::now();
    // A dry run needs no guard: it can simply be repeated.
    let _guard = (!job.dry_run).then(Guard::new);
    let pool = threads::pool(job.threads)?;
    let scene = pool.install(|| load::noted(job, terminal, opened))?;
    if let Some(watcher) = watcher {
        watcher.add(opened.paths());
    }
    let job = &job.for_scene(&scene)?;
    let go = || render(job, &scene, terminal, start, watcher);
    match (job.threads, scene.settings.parallel_threads) {
        (None, Some(asked)) => threads::pool(Some(asked as usize))?.install(go),
        _ => pool.install(go),
    }
}

fn render(
    job: &Job,
    scene: &SceneDescription,
    terminal: Terminal,
    begin: Instant,
    watcher: Option<&Watcher>,
) -> Result<(), Problem> {
    let loading = begin.elapsed();
    let target = Target::new(job, scene)?;
    let steps = plan::steps(job, scene, &target);
    if job.dry_run {
        return dry_run::tell(steps, terminal);
    }
    let studio = Studio { job, scene, target, terminal, display: None, watcher };
    let (count, to_render) = (steps.len(), to_render(&steps));
    if let Some(first) = steps.iter().find(|step| step.is_to_render()) {
        let needs = studio.needs(first.frame, to_render);
        let needs = if job.total_time.is_some() { needs.with_states(to_render) } else { needs };
        needs.check(&job.outdir, terminal)?;
        warn_of_structure(scene.settings.accelerator, terminal);
    }
    let pictures = steps.iter().filter(|step| step.is_to_render());
    maps::check(&job.maps, pictures.map(|step| (step.frame, &*step.path)))?;
    let mut run = Run::new(studio, count, to_render, loading);
    let claimed: Vec<_> =
        steps.iter().map(|step| run.studio.target.plain_path(step.frame)).collect();
    let frames: Vec<i64> = steps.iter().map(|step| step.frame).collect();
    let left = Left::look(&job.outdir, claimed.iter().map(|path| &**path));
    Guard::begin_work();
    if let Some(address) = job.display_server.as_ref().filter(|_| to_render > 0) {
        run.studio.display = Display::connect(address, terminal);
    }
    let start = Instant::now();
    let result = match (job.share, job.total_time) {
        (Some(lease), _) => run.share(steps, lease),
        (None, Some(span)) => run.rounds(steps, span, begin),
        (None, None) => run.sequence(&steps),
    };
    let result = result.map(|()| run.look_once_more());
    run.ended(start.elapsed());
    if let Some(reason) = crate::gpu::failure() {
        terminal.warn(format_args!("the GPU failed, and the CPU took over: {reason}"));
    }
    result?;
    let studio = run.end()?;
    left.sweep();
    studio.sweep(&frames);
    Ok(())
}

fn to_render(steps: &[Step]) -> usize {
    steps.iter().filter(|step| step.is_to_render()).count()
}

/// Warns about the structure that exists only for measurements.
fn warn_of_structure(accelerator: Accelerator, terminal: Terminal) {
    if accelerator == Accelerator::Cwbvh {
        terminal.warn(
            "CWBVH is for measurements: it may miss hits at edges, so the picture may differ",
        );
    }
}
