//! The worker threads.

use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::cli::base::{Exit, Problem};

/// Maximum number of threads per processor. More threads would only look for work in each other's
/// queues, which takes ever longer.
const MOST_THREADS_PER_PROCESSOR: usize = 16;

/// Makes the threads of a job: as many as asked for, up to a limit, or as many as the machine has
/// processors.
pub(crate) fn pool(asked: Option<usize>) -> Result<ThreadPool, Problem> {
    let processors = std::thread::available_parallelism().map_or(1, usize::from);
    let most = processors.saturating_mul(MOST_THREADS_PER_PROCESSOR);
    let threads = asked.map_or(0, |threads| threads.min(most));
    ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .map_err(|error| Problem::new(Exit::Failed, format!("can't start threads: {error}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn threads_are_as_many_as_asked_for_but_never_a_crowd() {
        let count = |asked| pool(asked).unwrap().current_num_threads();
        assert_eq!(count(Some(3)), 3);
        let processors = std::thread::available_parallelism().map_or(1, usize::from);
        assert_eq!(count(Some(65536)), MOST_THREADS_PER_PROCESSOR * processors);
    }
}
