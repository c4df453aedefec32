//! The one builder of sessions: plan, options and dialect, before the port is open.

use keepout_planner::plan_file::{self, PlanFileError};
use keepout_planner::sha256;

use super::engine::Engine;
use super::event_log::EventLog;
use super::log::{Header, HeaderZ};
use super::port::Port;
use super::run::Session;
use crate::dialect::{DialectConfig, DialectName};
use crate::operator::Operator;
use crate::supervisor::{Options, PreparedPlan, Supervisor};

/// The parts of a session. Sessions on real ports, on ptys and in virtual time all start from it.
#[derive(Clone, Debug)]
pub struct SessionSetup {
    /// The plan.
    pub work: PreparedPlan,
    /// The supervisor's options.
    pub options: Options,
    /// The controller's dialect.
    pub dialect: DialectName,
    /// The dialect's parameters.
    pub config: DialectConfig,
}

impl SessionSetup {
    /// The engine: supervisor and dialect.
    #[must_use]
    pub fn engine(self) -> Engine {
        let dialect = self.dialect.dialect(self.config);
        Engine::new(Supervisor::new(self.work, self.options, dialect.abilities()), dialect)
    }

    /// The session over `port`.
    pub fn session<'a, P: Port>(
        self,
        port: P,
        operator: Box<dyn Operator + Send + 'a>,
        event_log: Box<dyn EventLog + 'a>,
    ) -> Session<'a, P> {
        Session::new(self.engine(), port, operator, event_log)
    }

    /// The header of the session's log. The caller adds the date, the operator, the machine in words, and
    /// whether the machine is simulated.
    ///
    /// # Errors
    /// [`PlanFileError`] if the plan cannot be encoded for its hash.
    pub fn header(&self) -> Result<Header, PlanFileError> {
        let Self { work, options, dialect, config } = self;
        Ok(Header {
            plan: sha256::hex(&sha256::hash(&plan_file::encode(&work.plan.plan)?)),
            drawing: work.plan.plan.provenance.name.clone(),
            dialect: dialect.name().into(),
            description: dialect.hash(),
            offset: config.offset,
            travel_mm: config.travel_mm,
            travel: options.travel,
            z: config.z.zip(options.heights).map(|(z, [lowest, highest])| HeaderZ {
                zero: z.zero,
                lowest,
                highest,
            }),
            feed_mm_min: options.feed_mm_min,
            home: options.home,
            answer_within_ms: u64::try_from(options.answer_within.as_millis()).unwrap_or(u64::MAX),
            baud: options.baud,
            progress: options.progress.clone(),
            ..Header::default()
        })
    }
}
