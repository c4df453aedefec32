//! The comparison of the texts that were sent with the certificates, for GRBL and grblHAL.

use thiserror::Error;

use crate::dialect::{Dialect, DialectConfig, DialectName, Grbl};
use crate::session::event_log::LoggedEvent;
use crate::supervisor::{Command, Phase};

/// A text that does not fit its certificate.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum MotionTextFault {
    /// The certificate has no text.
    #[error(
        "no text follows the certificate before this line. The log was changed, or another version of this program \
         wrote it."
    )]
    Missing,
    /// The text does not say what the certificate says.
    #[error(
        "the text \"{sent}\" does not say what its certificate says. The log was changed, or another version of \
         this program wrote it."
    )]
    Differs {
        /// The text.
        sent: String,
    },
    /// A text without a certificate may move the machine.
    #[error(
        "the text \"{sent}\" has no certificate, and it may move the machine. The log was changed, or another \
         version of this program wrote it."
    )]
    NoCertificate {
        /// The text.
        sent: String,
    },
}

/// Most characters of a text in a message.
const BRIEF: usize = 80;

/// The texts of one session. The dialect reads the work offset from the received reports, and encodes each certificate
/// again.
pub(super) struct MotionTexts {
    dialect: Grbl,
    /// The text of the last certificate, until it is found.
    due: Option<Vec<u8>>,
}

impl MotionTexts {
    /// The texts of a session. `None` for dialects whose texts are not compared.
    pub(super) fn of(name: &DialectName, config: DialectConfig) -> Option<Self> {
        let dialect = match name {
            DialectName::Grbl => Grbl::new(config),
            DialectName::GrblHal => Grbl::hal(config),
            _ => return None,
        };
        Some(Self { dialect, due: None })
    }

    /// Takes the next event. Returns whether it is the text of a certificate.
    pub(super) fn take(&mut self, event: &LoggedEvent<'_>) -> Result<bool, MotionTextFault> {
        let due = self.due.take();
        match event {
            LoggedEvent::Sent(bytes) => return self.sent(bytes, due),
            // A motion that the dialect cannot write ends the session. Nothing of it was sent.
            LoggedEvent::Phase { phase: Phase::Faulted, .. } => {}
            _ if due.is_some() => return Err(MotionTextFault::Missing),
            // A motion that the dialect cannot write has no text that fits.
            LoggedEvent::Certificate(certificate) => {
                self.due = Some(self.dialect.motion_text(&certificate.motion()).unwrap_or_default());
            }
            LoggedEvent::Received(bytes) => {
                let mut answers = Vec::new();
                for &byte in &**bytes {
                    let _ = self.dialect.decode(byte, &mut answers);
                    answers.clear();
                }
            }
            LoggedEvent::PortFound => self.dialect.reset(),
            _ => {}
        }
        Ok(false)
    }

    fn sent(&mut self, bytes: &[u8], due: Option<Vec<u8>>) -> Result<bool, MotionTextFault> {
        let sent = || bytes.escape_ascii().to_string().chars().take(BRIEF).collect();
        match due {
            Some(due) if due == bytes => return Ok(true),
            Some(_) => return Err(MotionTextFault::Differs { sent: sent() }),
            None if is_quiet(bytes) => {}
            None => return Err(MotionTextFault::NoCertificate { sent: sent() }),
        }
        if bytes.ends_with(b"$#\n") {
            // From here on the work offset is unknown until a report states it.
            let _ = self.dialect.encode(&Command::Arm, &mut Vec::new());
        }
        Ok(false)
    }
}

/// Whether the text moves nothing: a query, a setting, modes, the spindle, a reset. Homing counts too, since no
/// certificate covers it. Earlier versions left the feed override as it was (0x90).
fn is_quiet(bytes: &[u8]) -> bool {
    const WHOLE: [&[u8]; 14] = [
        b"?",
        b"\x18",
        b"$\n",
        b"$I\n",
        b"$$\n",
        b"$N\n",
        b"$H\n",
        b"$N0=G80\n",
        b"$N1=G80\n",
        b"M5\n",
        b"\x90G21G90G94G17G40G49G80G55\nG54\n$#\n",
        b"\x90G21G90G94G17G40G49G80G50G55\nG54\n$#\n",
        b"G21G90G94G17G40G49G80G55\nG54\n$#\n",
        b"G21G90G94G17G40G49G80G50G55\nG54\n$#\n",
    ];
    const WITH_NUMBER: [(&[u8], &[u8]); 3] =
        [(b"$10=", b"0123456789"), (b"$12=", b"0123456789."), (b"M3S", b"0123456789")];
    let has_number = |(head, digits): (&[u8], &[u8])| {
        let number = bytes.strip_prefix(head).and_then(|rest| rest.strip_suffix(b"\n"));
        number.is_some_and(|number| !number.is_empty() && number.iter().all(|digit| digits.contains(digit)))
    };
    WHOLE.contains(&bytes) || WITH_NUMBER.into_iter().any(has_number)
}
