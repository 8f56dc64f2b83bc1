//! Threads: the only file that names rayon.
//!
//! Work is divided recursively along fixed blocks, and each half owns its output. Neither locks nor unsafe code are needed, and
//! the bits of the result cannot depend on scheduling. A long job runs in a pool while the calling thread waits and polls for
//! interrupts ([`ThreadPool::run`], [`attend`]). A short job runs on the calling thread.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::Duration;

use rayon::slice::ParallelSliceMut;

use crate::error::{Error, Result};

/// Polling interval for interrupts in a long job.
const POLL: Duration = Duration::from_millis(20);

/// Work that can be divided between blocks.
pub trait Split: Sized + Send {
    /// Number of blocks.
    fn blocks(&self) -> usize;
    /// Splits the work after `blocks` blocks.
    fn split_at(self, blocks: usize) -> (Self, Self);
}

impl<A: Split, B: Split> Split for (A, B) {
    fn blocks(&self) -> usize {
        self.0.blocks()
    }

    fn split_at(self, blocks: usize) -> (Self, Self) {
        let (first, others) = (self.0.split_at(blocks), self.1.split_at(blocks));
        ((first.0, others.0), (first.1, others.1))
    }
}

/// Mutable slice divided into blocks of equal size.
#[derive(Debug)]
pub struct BlockedSlice<'a, T> {
    /// Index of the first item in the whole slice.
    pub start: usize,
    /// Items of the slice.
    pub items: &'a mut [T],
    size: usize,
}

impl<'a, T> BlockedSlice<'a, T> {
    /// Divides all of `items` into blocks of `size`, which must not be 0.
    #[inline]
    pub fn new(items: &'a mut [T], size: usize) -> Self {
        Self { start: 0, items, size }
    }
}

impl<T: Send> Split for BlockedSlice<'_, T> {
    fn blocks(&self) -> usize {
        self.items.len().div_ceil(self.size)
    }

    fn split_at(self, blocks: usize) -> (Self, Self) {
        let length = (blocks * self.size).min(self.items.len());
        let (first, others) = self.items.split_at_mut(length);
        (Self { items: first, ..self }, Self { start: self.start + length, items: others, size: self.size })
    }
}

/// Access of a running job to its thread pool, with its stop flag.
#[derive(Debug)]
pub struct Executor {
    threads: usize,
    stop: AtomicBool,
}

/// Executor of the calling thread, without interrupts.
pub static SERIAL: Executor = Executor::serial();

impl Executor {
    /// Returns an executor of the calling thread alone.
    #[inline]
    pub const fn serial() -> Self {
        Self { threads: 1, stop: AtomicBool::new(false) }
    }

    /// Reports an interrupt.
    ///
    /// # Errors
    /// [`Error::Interrupted`] after an interrupt.
    #[inline]
    pub fn check(&self) -> Result<()> {
        if self.stopped() { Err(Error::Interrupted) } else { Ok(()) }
    }

    /// Number of threads.
    #[inline]
    pub fn threads(&self) -> usize {
        self.threads
    }

    /// Whether the job is interrupted; its results are then discarded.
    #[inline]
    pub fn stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// Runs `each` on every block, in any order.
    pub fn for_each_block<W: Split>(&self, work: W, each: &(impl Fn(W) + Sync)) {
        self.divide(work, each);
    }

    /// Divides the work with the type of `each` erased. Otherwise the division would be compiled for each of a thousand closures.
    fn divide<W: Split>(&self, work: W, each: &(dyn Fn(W) + Sync)) {
        if self.threads > 1 && work.blocks() > 1 {
            let half = work.blocks() / 2;
            let (left, right) = work.split_at(half);
            let (mut left, mut right) = (Some(left), Some(right));
            let run = |half: &mut Option<W>| {
                if let Some(half) = half.take() {
                    self.divide(half, each);
                }
            };
            join(&mut || run(&mut left), &mut || run(&mut right));
            return;
        }
        let mut rest = (work.blocks() > 0).then_some(work);
        while let Some(work) = rest.take().filter(|_| !self.stopped()) {
            let block = if work.blocks() > 1 {
                let (block, others) = work.split_at(1);
                rest = Some(others);
                block
            } else {
                work
            };
            each(block);
        }
    }

    /// Sorts items. The sort is unstable: equal items must be indistinguishable.
    pub fn sort<T: Ord + Send>(&self, items: &mut [T]) {
        if self.threads > 1 {
            items.par_sort_unstable();
        } else {
            items.sort_unstable();
        }
    }
}

/// Runs two jobs, on two threads if another one is free. Their types are erased; otherwise rayon's code would be compiled for
/// each of a thousand kernels.
fn join(one: &mut (dyn FnMut() + Send), other: &mut (dyn FnMut() + Send)) {
    rayon::join(one, other);
}

/// Thread pool of a simulation.
#[derive(Debug)]
pub struct ThreadPool {
    threads: usize,
    pool: Option<rayon::ThreadPool>,
    process: u32,
}

impl ThreadPool {
    /// Returns a pool of `threads` threads. They start with the first job that needs them.
    #[inline]
    pub fn new(threads: usize) -> Self {
        Self { threads, pool: None, process: std::process::id() }
    }

    /// Default number of threads: `PHYSCORE_NUM_THREADS`, or all that this process may use.
    #[inline]
    pub fn default_threads() -> Result<usize> {
        let text = std::env::var("PHYSCORE_NUM_THREADS").unwrap_or_default();
        if text.is_empty() {
            return Ok(std::thread::available_parallelism().map_or(1, std::num::NonZero::get));
        }
        match text.parse() {
            Ok(threads) if threads >= 1 => Ok(threads),
            _ => Err(Error::parameter("PHYSCORE_NUM_THREADS", "a whole number ≥ 1", format!("{text:?}"))),
        }
    }

    /// Number of threads.
    #[inline]
    pub fn threads(&self) -> usize {
        self.threads
    }

    /// Runs a long job in the pool, polling `interrupted` every 20 ms.
    ///
    /// # Errors
    /// [`Error::Interrupted`] after an interrupt; the job then ended early.
    pub fn run(&mut self, interrupted: &dyn Fn() -> bool, job: impl FnOnce(&Executor) + Send) -> Result<()> {
        let executor = Executor { threads: self.threads, stop: AtomicBool::new(false) };
        let Some(pool) = self.pool() else {
            job(&Executor::serial());
            return Ok(());
        };
        let (ended, condition) = (Mutex::new(false), Condvar::new());
        pool.in_place_scope(|scope| {
            scope.spawn(|_| {
                // Set on the way out of a panic too: the wait below then ends, and the scope passes the panic on.
                let _ended = NotifyOnDrop(&ended, &condition);
                job(&executor);
            });
            let mut guard = ended.lock().unwrap_or_else(PoisonError::into_inner);
            while !*guard {
                let (next, wait) = condition.wait_timeout(guard, POLL).unwrap_or_else(PoisonError::into_inner);
                guard = next;
                if wait.timed_out() && !*guard && !executor.stopped() && interrupted() {
                    executor.stop.store(true, Ordering::Relaxed);
                }
            }
        });
        if executor.stopped() { Err(Error::Interrupted) } else { Ok(()) }
    }

    /// Pool, rebuilt after a fork because the child process has none of its threads. The parent's pool is leaked in the child,
    /// because one of its locks may have been held at the fork. None if no threads can be created.
    fn pool(&mut self) -> Option<&rayon::ThreadPool> {
        if self.process != std::process::id() {
            std::mem::forget(self.pool.take());
            self.process = std::process::id();
        }
        if self.pool.is_none() {
            let builder = rayon::ThreadPoolBuilder::new().num_threads(self.threads);
            self.pool = builder.thread_name(|index| format!("physcore-{index}")).build().ok();
        }
        self.pool.as_ref()
    }
}

/// Runs a long job that owns its data on separate threads, polling `interrupted` every 20 ms. The caller does not wait for an
/// interrupted job, which ends at its next check of the executor and drops its data.
///
/// # Errors
/// [`Error::Interrupted`] if the job was stopped.
///
/// # Panics
/// If the job panics.
pub fn attend<T: Send + 'static>(
    threads: usize,
    interrupted: &dyn Fn() -> bool,
    job: impl FnOnce(&Executor) -> T + Send + 'static,
) -> Result<T> {
    let Ok(pool) = rayon::ThreadPoolBuilder::new().num_threads(threads).build() else {
        return Ok(job(&SERIAL));
    };
    let executor = Arc::new(Executor { threads, stop: AtomicBool::new(false) });
    let (result, outcome) = channel();
    let its = Arc::clone(&executor);
    // A panic is passed on too; on a pool thread it would be lost. An unclaimed result is dropped.
    pool.spawn(move || drop(result.send(catch_unwind(AssertUnwindSafe(|| job(&its))))));
    loop {
        match outcome.recv_timeout(POLL) {
            Ok(Ok(result)) => return Ok(result),
            Ok(Err(panic)) => resume_unwind(panic),
            Err(RecvTimeoutError::Timeout) if !interrupted() => {}
            Err(_) => {
                executor.stop.store(true, Ordering::Relaxed);
                return Err(Error::Interrupted);
            }
        }
    }
}

struct NotifyOnDrop<'a>(&'a Mutex<bool>, &'a Condvar);

impl Drop for NotifyOnDrop<'_> {
    fn drop(&mut self) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = true;
        self.1.notify_one();
    }
}
