//! The check of a log's certificates alone: without the engine, and so without the guard.

use std::io::BufRead;

use keepout_kernel::Place;

use super::certificate::CertificateRules;
use super::motion_texts::MotionTexts;
use super::{ReplayError, setup_of};
use crate::session::event_log::{Certificate, LoggedEvent};
use crate::session::log::{Entry, Header, Log, LogReader};
use crate::supervisor::{Phase, PreparedPlan, Supervisor};

/// The result of a check of certificates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CertificateCheck {
    /// Jogs that hold.
    pub jogs: u64,
    /// Motions of contours that hold.
    pub contours: u64,
    /// Texts that say what their certificates say. `None` for a dialect whose texts are not compared.
    pub texts: Option<u64>,
}

/// Checks each certificate of a log by itself: against the part, and against the text that was sent for it. The engine
/// does not run again. So this check is independent of the supervisor and the guard, and weaker than
/// [`replay`](super::replay()): it cannot tell whether an in-flight set holds every place where the tool can be.
///
/// Texts of GRBL and grblHAL are compared. A jog may be a retract move at any time.
///
/// # Errors
/// [`ReplayError`], which names the first line that does not hold.
pub fn check_certificates(log: &Log, work: &PreparedPlan) -> Result<CertificateCheck, ReplayError> {
    let mut checker = Checker::new(&log.header, work)?;
    log.entries.iter().try_for_each(|entry| checker.take(entry))?;
    Ok(checker.counted)
}

/// As [`check_certificates`], while it reads the log.
///
/// # Errors
/// [`ReplayError`], which names the first line that does not hold.
pub fn check_certificates_from<R: BufRead>(
    log: &mut LogReader<R>,
    work: &PreparedPlan,
) -> Result<CertificateCheck, ReplayError> {
    let mut checker = Checker::new(log.header(), work)?;
    for entry in log {
        checker.take(&entry?)?;
    }
    Ok(checker.counted)
}

struct Checker {
    /// It holds the part and the rules. It takes no step.
    supervisor: Supervisor,
    texts: Option<MotionTexts>,
    /// The target of the last certified motion since a start.
    last: Option<Place>,
    counted: CertificateCheck,
}

impl Checker {
    fn new(header: &Header, work: &PreparedPlan) -> Result<Self, ReplayError> {
        let setup = setup_of(header, work.clone(), Default::default())?;
        let texts = MotionTexts::of(&setup.dialect, setup.config);
        let counted = CertificateCheck { texts: texts.as_ref().map(|_| 0), ..CertificateCheck::default() };
        Ok(Self { supervisor: setup.engine().supervisor, texts, last: None, counted })
    }

    fn take(&mut self, entry: &Entry) -> Result<(), ReplayError> {
        let (line, seconds) = (entry.line, entry.at.elapsed().as_secs_f64());
        match &entry.event {
            LoggedEvent::Certificate(certificate) => self
                .check(certificate)
                .map_err(|reason| ReplayError::NotCertified { line, seconds, reason })?,
            LoggedEvent::Phase { phase: Phase::Starting, .. } => self.last = None,
            _ => {}
        }
        let Some(texts) = &mut self.texts else { return Ok(()) };
        let agreed = texts.take(&entry.event).map_err(|fault| ReplayError::Text { line, seconds, fault })?;
        self.counted.texts = self.counted.texts.map(|count| count + u64::from(agreed));
        Ok(())
    }

    fn check(&mut self, certificate: &Certificate) -> Result<(), String> {
        let (levels, rules) = (self.supervisor.work().levels(), self.supervisor.guard().rules());
        CertificateRules { levels, rules, retracts: true }.check(certificate, self.last)?;
        self.last = Some(certificate.target());
        match certificate {
            Certificate::Jog { .. } => self.counted.jogs += 1,
            Certificate::Contour { .. } => self.counted.contours += 1,
        }
        Ok(())
    }
}
