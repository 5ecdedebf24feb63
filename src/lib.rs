//! sgap: symbolic-geometric planning for robots that work beside people.
//!
//! The way of the data; `docs/architecture.md` tells each room's job and what it may not know.
//!
//! ```text
//! .hatp text --syntax--> ast --check--> ir::Domain --+
//!                               ^                    +--engine--> plan::Plan --report--> text, JSON, page
//!                               |                    |                |
//! .toml text + URDF --world--> World ------grp-------+            validate (a second opinion)
//! ```

pub mod check;
pub mod diag;
pub mod doc;
pub mod engine;
pub mod geom;
pub mod grp;
pub mod hddl;
pub mod ir;
pub mod load;
pub mod lsp;
pub mod plan;
pub mod planner;
pub mod report;
pub mod source;
pub mod syntax;
pub mod trace;
pub mod validate;
pub mod world;

pub use load::Paths;
pub use planner::{Answer, Disk, News, Options, Rejected, plan};
pub use source::{Files, Texts};
