//! GIF encoding on a separate thread, while the next frame is drawn.

use std::io::{self, Write};
use std::sync::mpsc::{SyncSender, channel, sync_channel};
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};

use crate::canvas::Canvas;
use crate::error::CanvasError;
use crate::gif::Gif;

/// Length of the frame queue. A longer queue takes memory without a gain: the slower side sets the rate.
const WAITING: usize = 1;

type Pixels = Vec<[u8; 4]>;
type BackgroundJob<W> = Box<dyn FnOnce(&mut Gif<W>) -> Result<(), CanvasError> + Send>;

/// A [`Gif`] on a separate thread. Equal calls give equal bytes. A failure is reported by one of the following calls.
pub struct Background<W> {
    size: (usize, usize),
    /// Job queue; None after a failure.
    jobs: Option<SyncSender<BackgroundJob<W>>>,
    thread: Option<JoinHandle<Result<Gif<W>, CanvasError>>>,
    /// Pixel buffers of encoded frames, for reuse.
    spare: Arc<Mutex<Vec<Pixels>>>,
}

impl<W: Write + Send + 'static> Background<W> {
    /// Moves a film to a separate thread.
    pub fn new(mut gif: Gif<W>) -> Result<Self, CanvasError> {
        let (jobs, inbox) = sync_channel::<BackgroundJob<W>>(WAITING);
        let size = gif.size();
        let work = move || {
            for job in inbox {
                job(&mut gif)?;
            }
            Ok(gif)
        };
        let thread = thread::Builder::new().name("physcore-gif".to_owned()).spawn(work)?;
        Ok(Self { size, jobs: Some(jobs), thread: Some(thread), spare: Arc::default() })
    }

    /// Queues [`Gif::frame`].
    pub fn frame(&mut self, canvas: &Canvas, delay: u16) -> Result<(), CanvasError> {
        let (expected, got) = (self.size, (canvas.width(), canvas.height()));
        if expected != got {
            return Err(CanvasError::FrameSize { expected, got });
        }
        let mut pixels = self.spare.lock().ok().and_then(|mut spare| spare.pop()).unwrap_or_default();
        pixels.clear();
        pixels.extend_from_slice(canvas.pixels());
        let spare = Arc::clone(&self.spare);
        self.send(Box::new(move |gif| {
            gif.append(&pixels, delay)?;
            if let Ok(mut spare) = spare.lock() {
                spare.push(pixels);
            }
            Ok(())
        }))
    }

    /// Queues [`Gif::tolerate`].
    pub fn tolerate(&mut self, tolerance: f32) -> Result<(), CanvasError> {
        self.send(Box::new(move |gif| {
            gif.tolerate(tolerance);
            Ok(())
        }))
    }

    /// Queues [`Gif::comment`].
    pub fn comment(&mut self, text: &str) -> Result<(), CanvasError> {
        let text = text.to_owned();
        self.send(Box::new(move |gif| gif.comment(&text)))
    }

    /// Returns [`Gif::written`], after all queued frames.
    pub fn written(&mut self) -> Result<u64, CanvasError> {
        let (reply, answer) = channel();
        self.send(Box::new(move |gif| {
            let _ = reply.send(gif.written());
            Ok(())
        }))?;
        answer.recv().map_err(|_| self.failure())
    }

    /// Finishes the film like [`Gif::finish`], after all queued frames.
    pub fn finish(mut self) -> Result<W, CanvasError> {
        self.end()?.finish()
    }

    fn send(&mut self, job: BackgroundJob<W>) -> Result<(), CanvasError> {
        match self.jobs.as_ref().map(|jobs| jobs.send(job)) {
            Some(Ok(())) => Ok(()),
            _ => Err(self.failure()),
        }
    }

    fn failure(&mut self) -> CanvasError {
        self.end().err().unwrap_or_else(closed)
    }
}

impl<W> Background<W> {
    /// Waits until the queue is empty, and ends the thread.
    fn end(&mut self) -> Result<Gif<W>, CanvasError> {
        drop(self.jobs.take());
        let thread = self.thread.take().ok_or_else(closed)?;
        thread.join().unwrap_or_else(|_| Err(CanvasError::Write(io::Error::other("the film's thread has failed"))))
    }
}

impl<W> Drop for Background<W> {
    /// Writes queued frames first: no thread holds the file afterwards.
    fn drop(&mut self) {
        let _ = self.end();
    }
}

fn closed() -> CanvasError {
    CanvasError::Write(io::Error::other("the film is closed"))
}
