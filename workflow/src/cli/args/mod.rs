//! What can be asked: verbs and their arguments.

mod begin;
mod bounds;
mod bulk;
mod check;
mod engines;
mod fix;
mod learning;
mod make;
mod mutate;
mod own;
mod parse;
mod providers;
mod serve;
mod studio;
mod trace;
mod verbs;
mod view;

pub use begin::{InitArgs, PointsArgs};
pub use bounds::BoundsArgs;
pub use bulk::{AuditArgs, AuditCommand, BatchArgs, BatchCommand, StoreCommand};
pub use check::{CheckArgs, ExplainArgs, Kind, ScanArgs, Standing, When};
pub use engines::{EngineArgs, EngineName, WorkerArgs};
pub use fix::FixArgs;
pub use learning::{EvalArgs, Labels, Prompted, TrainArgs, WeightsCommand, Who, Withheld};
pub use make::MakeArgs;
pub use mutate::{BenchArgs, FoundBy, MutateArgs};
pub use own::Own;
pub use providers::{DoctorArgs, ProvidersArgs, TrustArgs};
pub use serve::ServeArgs;
pub use studio::{PORT, StudioArgs};
pub use trace::TraceCommand;
pub use verbs::{Cli, Command, SchemaOf};
pub use view::ViewArgs;
