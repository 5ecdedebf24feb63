//! sgap: symbolic-geometric planning for robots that work beside people.
//!
//! [`plan`] is the door: from a domain, and perhaps a world, to plans or to why there is none. `docs/library.md` tells more:
//! stop flags, listeners, traces, and a [`engine::Reasoner`] of one's own.
//!
//! ```
//! use sgap::{Options, Paths, Texts};
//!
//! let domain = "
//!     factdatabase {
//!       define entityType Lamp;
//!       define entityAttributes Lamp { dynamic atom bool on; }
//!       ANN = new Agent; DESK = new Lamp;
//!     }
//!     HTN {
//!       action Switch(Agent A, Lamp L) { preconditions { L.on != true; }; effects { L.on = true; } }
//!     }";
//! // `sgap::Disk` reads paths instead.
//! let files = Texts::new([("lamps.hatp", domain)]);
//! let paths = Paths { domain: "lamps.hatp", task: Some("Switch(ANN, DESK)"), ..Paths::default() };
//! let answer = sgap::plan(&paths, &files, Options::default().best())?;
//! let plan = answer.plan().expect("the lamp is off");
//! assert_eq!(plan.actions[0].name, "Switch");
//! # Ok::<(), sgap::Rejected>(())
//! ```
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
