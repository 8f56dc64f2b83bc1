//! A film that is written on a thread of its own, so that the next frame is drawn meanwhile.

use std::io::{self, Write};
use std::sync::mpsc::{SyncSender, channel, sync_channel};
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};

use crate::canvas::Canvas;
use crate::error::Error;
use crate::gif::Gif;

/// Frames that wait while one is encoded. More would only take memory: whoever is slower sets the pace.
const WAITING: usize = 1;

type Pixels = Vec<[u8; 4]>;
type Job<W> = Box<dyn FnOnce(&mut Gif<W>) -> Result<(), Error> + Send>;

/// A [`Gif`] on a thread of its own: the same calls give the same bytes. A failure is reported by one of the calls after.
pub struct Background<W> {
    size: (usize, usize),
    /// None when the film has failed.
    jobs: Option<SyncSender<Job<W>>>,
    thread: Option<JoinHandle<Result<Gif<W>, Error>>>,
    /// Copies of frames that have been encoded, to be used again.
    spare: Arc<Mutex<Vec<Pixels>>>,
}

impl<W: Write + Send + 'static> Background<W> {
    /// Goes on with a film on another thread.
    pub fn new(mut gif: Gif<W>) -> Result<Self, Error> {
        let (jobs, inbox) = sync_channel::<Job<W>>(WAITING);
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

    /// [`Gif::frame`].
    pub fn frame(&mut self, canvas: &Canvas, delay: u16) -> Result<(), Error> {
        let (expected, got) = (self.size, (canvas.width(), canvas.height()));
        if expected != got {
            return Err(Error::FrameSize { expected, got });
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

    /// [`Gif::comment`].
    pub fn comment(&mut self, text: &str) -> Result<(), Error> {
        let text = text.to_owned();
        self.send(Box::new(move |gif| gif.comment(&text)))
    }

    /// [`Gif::written`], after all that was handed over.
    pub fn written(&mut self) -> Result<u64, Error> {
        let (reply, answer) = channel();
        self.send(Box::new(move |gif| {
            let _ = reply.send(gif.written());
            Ok(())
        }))?;
        answer.recv().map_err(|_| self.failure())
    }

    /// [`Gif::finish`].
    pub fn finish(mut self) -> Result<W, Error> {
        self.end()?.finish()
    }

    fn send(&mut self, job: Job<W>) -> Result<(), Error> {
        match self.jobs.as_ref().map(|jobs| jobs.send(job)) {
            Some(Ok(())) => Ok(()),
            _ => Err(self.failure()),
        }
    }

    fn failure(&mut self) -> Error {
        self.end().err().unwrap_or_else(closed)
    }
}

impl<W> Background<W> {
    /// Waits until all is written.
    fn end(&mut self) -> Result<Gif<W>, Error> {
        drop(self.jobs.take());
        let thread = self.thread.take().ok_or_else(closed)?;
        thread.join().unwrap_or_else(|_| Err(Error::Write(io::Error::other("the film's thread has failed"))))
    }
}

impl<W> Drop for Background<W> {
    /// What was handed over is written first, so that afterwards nothing is left that could hold the file.
    fn drop(&mut self) {
        let _ = self.end();
    }
}

fn closed() -> Error {
    Error::Write(io::Error::other("the film is closed"))
}
