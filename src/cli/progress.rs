//! A line on the terminal while something takes longer than a second. Nothing where the standard error is no terminal.

use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

use super::output::{Verbosity, note, verbosity};

/// Shows that work goes on, from a second after its creation until it is dropped.
#[derive(Debug)]
pub(super) struct Progress {
    bar: Arc<Mutex<Option<ProgressBar>>>,
    /// Dropped first: that ends the thread.
    done: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Progress {
    /// Starts to wait; `what` names the work and how to end it.
    pub(super) fn new(what: &'static str) -> Progress {
        let bar = Arc::new(Mutex::new(None));
        let (done, ended) = channel();
        let shared = Arc::clone(&bar);
        let thread = std::thread::spawn(move || {
            if ended.recv_timeout(Duration::from_secs(1)) != Err(RecvTimeoutError::Timeout)
                || verbosity() == Verbosity::Quiet
            {
                return;
            }
            let spinner = ProgressBar::new_spinner()
                .with_message(what)
                .with_elapsed(Duration::from_secs(1));
            if let Ok(style) = ProgressStyle::with_template("{spinner} {elapsed} {msg}") {
                spinner.set_style(style);
            }
            spinner.enable_steady_tick(Duration::from_millis(200));
            *shared.lock().unwrap_or_else(PoisonError::into_inner) = Some(spinner);
            // An error is the sender's end, which is what is waited for.
            let _ = ended.recv();
        });
        Progress {
            bar,
            done: Some(done),
            thread: Some(thread),
        }
    }

    /// Notes a line, above the progress line if there is one.
    pub(super) fn say(&self, text: &str) {
        match &*self.bar.lock().unwrap_or_else(PoisonError::into_inner) {
            Some(bar) => bar.suspend(|| note(text)),
            None => note(text),
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.done = None;
        if let Some(thread) = self.thread.take() {
            // A thread that panicked has nothing left to show.
            let _ = thread.join();
        }
        if let Some(bar) = self.bar.lock().unwrap_or_else(PoisonError::into_inner).take() {
            bar.finish_and_clear();
        }
    }
}
