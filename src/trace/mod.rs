//! A search written down as JSON lines, and what such a file says when all of it is put together.
//!
//! `write` listens to the engine, `read` goes through a file line by line, `summary` keeps counts: neither holds more of a search than
//! the tasks that stand at one moment and one entry for each kind of failure. `docs/trace.md` describes the form. No clock: who
//! wants times in a file gives one.

mod read;
mod record;
mod summary;
mod write;

pub use read::{Fault, read};
pub use record::{FORMAT, Header, Record, VERSION};
pub use summary::{Failure, Group, Summary, TaskCounts};
pub use write::Writer;
