//! Records an operator's inputs as a [trace](super::trace).
//!
//! Implements SR-29.

use std::fmt::Write as _;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;
use std::time::Duration;

use keepout_executor::operator::{Operator, OperatorView, Panel};
use keepout_executor::supervisor::{OperatorCommand, OperatorInput, Phase};
use keepout_guard::Time;
use keepout_planner::Mm2;

use super::trace::{HEADER, LINES_MAX, TRACE, TraceError, flag_of};

/// Time between two flushes of a recording.
const FLUSH_EVERY: Duration = Duration::from_millis(500);

/// Writes every change of another operator's input to a file. Dropping it writes the end.
///
/// If a write fails, recording ends with a notice, and jogging goes on.
pub struct Recorder<O, W: Write = BufWriter<File>> {
    operator: O,
    file: Option<W>,
    began: Option<Time>,
    last: Option<OperatorInput>,
    /// Time of the last input.
    noted: Duration,
    /// The session is past its start: inputs and commands are recorded.
    notes: bool,
    flushed: Duration,
    lines: usize,
    panel: Panel,
}

impl<O: Operator> Recorder<O> {
    /// Records `operator` to a new file.
    ///
    /// # Errors
    /// [`TraceError::File`] when the file already exists or cannot be written.
    pub fn create(operator: O, path: &Path, panel: Panel) -> Result<Self, TraceError> {
        let file = File::create_new(path).map_err(TRACE.write_error(path))?;
        Ok(Self::new(operator, BufWriter::new(file), panel))
    }
}

impl<O, W: Write> Recorder<O, W> {
    /// Records `operator` to `file`.
    pub fn new(operator: O, file: W, panel: Panel) -> Self {
        let mut recorder = Self {
            operator,
            file: Some(file),
            began: None,
            last: None,
            noted: Duration::ZERO,
            notes: false,
            flushed: Duration::ZERO,
            lines: 0,
            panel,
        };
        recorder.write(HEADER);
        recorder
    }

    fn note(&mut self, input: &OperatorInput, now: Time) {
        let at = now.since(*self.began.get_or_insert(now));
        self.noted = at;
        // Turns are sums since the previous input, so an equal turn is a new one.
        let changed = self.last.as_ref() != Some(input) || input.turns();
        if changed {
            self.last = Some(*input);
            self.write(&line_of(at, input, None));
        }
        if at - self.flushed.min(at) >= FLUSH_EVERY {
            self.flushed = at;
            let flushed = self.file.as_mut().map_or(Ok(()), Write::flush);
            self.end_when(flushed);
        }
    }

    fn write(&mut self, line: &str) {
        let Some(file) = &mut self.file else { return };
        let written = writeln!(file, "{line}");
        self.lines += 1;
        self.end_when(written);
        // Leaves room for the end.
        if self.lines + 2 >= LINES_MAX && self.file.take().is_some() {
            self.panel.say("the trace is full: recording ends here");
        }
    }

    fn end_when(&mut self, written: io::Result<()>) {
        if let Err(error) = written {
            self.file = None;
            self.panel.say(format!("the trace cannot be written ({error}): recording ends here"));
        }
    }
}

impl<O: Operator, W: Write> Operator for Recorder<O, W> {
    fn input(&mut self, view: &OperatorView, now: Time) -> OperatorInput {
        let input = self.operator.input(view, now);
        self.notes = view.phase != Phase::Starting;
        if self.notes {
            self.note(&input, now);
        }
        input
    }

    fn command(&mut self) -> Option<OperatorCommand> {
        let command = self.operator.command()?;
        if let Some(last) = self.last.filter(|_| self.notes) {
            let still = OperatorInput { turned_mm: Mm2::ZERO, turned_up_mm: 0.0, ..last };
            self.write(&line_of(self.noted, &still, Some(command)));
        }
        Some(command)
    }

    fn every(&self) -> Duration {
        self.operator.every()
    }
}

impl<O, W: Write> Drop for Recorder<O, W> {
    fn drop(&mut self) {
        let end = format!("{} end", stamp(self.noted));
        self.write(&end);
        if let Some(file) = &mut self.file {
            let _ = file.flush();
        }
    }
}

/// The line of an input and a command. A velocity or turn that is not finite is written as zero.
fn line_of(at: Duration, input: &OperatorInput, command: Option<OperatorCommand>) -> String {
    let [velocity, turned] =
        [input.velocity, input.turned_mm].map(|pair| if pair.is_finite() { pair } else { Mm2::ZERO });
    let mut line = format!("{} {} {} {} {} ", stamp(at), velocity.x, velocity.y, turned.x, turned.y);
    let [up, turned_up] =
        [input.up, input.turned_up_mm].map(|number| if number.is_finite() { number } else { 0.0 });
    if up != 0.0 || turned_up != 0.0 {
        let _ = write!(line, "{up} {turned_up} ");
    }
    line.extend(input.armed.then_some('a'));
    line.extend(command.map(flag_of));
    if !input.armed && command.is_none() {
        line.push('-');
    }
    line
}

fn stamp(at: Duration) -> String {
    format!("{}.{:06}", at.as_secs(), at.subsec_micros())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::operator::tests::{Prescribed, view};
    use crate::operator::trace::TraceOperator;

    fn read(text: &str) -> Result<TraceOperator, TraceError> {
        TraceOperator::read(text.as_bytes(), Path::new("test"))
    }

    /// Random inputs and commands of all kinds.
    fn steps(seed: u64) -> Vec<(OperatorInput, Option<OperatorCommand>)> {
        let mut random = fastrand::Rng::with_seed(seed);
        let number = |random: &mut fastrand::Rng| match random.u8(0..6) {
            0 => 0.0,
            1 => -0.0,
            2 => f64::MIN_POSITIVE * random.f64(),
            3 => 1e300 * random.f64(),
            _ => 2.0 * random.f64() - 1.0,
        };
        let commands = [
            None,
            None,
            None,
            Some(OperatorCommand::FeedHold),
            Some(OperatorCommand::CycleStart),
            Some(OperatorCommand::Recover),
            Some(OperatorCommand::Raise),
            Some(OperatorCommand::Cross { contour: 12 }),
            Some(OperatorCommand::Spindle { runs: false }),
            Some(OperatorCommand::Feed { percent: 50 }),
        ];
        (0..500)
            .map(|_| {
                let input = OperatorInput {
                    velocity: Mm2::new(number(&mut random), number(&mut random)),
                    turned_mm: if random.u8(0..3) == 0 {
                        Mm2::new(number(&mut random), 0.5)
                    } else {
                        Mm2::ZERO
                    },
                    up: if random.bool() { number(&mut random) } else { 0.0 },
                    turned_up_mm: if random.bool() { number(&mut random) } else { 0.0 },
                    armed: random.bool(),
                };
                (input, commands[random.usize(0..commands.len())])
            })
            .collect()
    }

    #[test]
    fn recorded_input_is_played_back_exactly() {
        for seed in 0..20 {
            let prescribed = steps(seed);
            let mut file = Vec::new();
            let mut recorder =
                Recorder::new(Prescribed::new(prescribed.clone()), &mut file, Panel::default());
            let time = |index: usize| Time::from_micros(12_345 + 10_000 * u64::try_from(index).unwrap());
            recorder.input(&view(Phase::Starting), Time::ZERO);
            for index in 0..prescribed.len() {
                recorder.input(&view(Phase::Manual), time(index));
                recorder.command();
            }
            drop(recorder);
            let mut trace = read(std::str::from_utf8(&file).unwrap()).unwrap();
            for (index, step) in prescribed.iter().enumerate() {
                let played = (trace.input(&view(Phase::Manual), time(index)), trace.command());
                assert_eq!(played, *step, "seed {seed}, input {index}");
            }
            trace.input(&view(Phase::Manual), time(prescribed.len()));
            assert_eq!(trace.command(), Some(OperatorCommand::Stop));
        }
    }

    #[test]
    fn commands_during_a_restart_are_not_written() {
        let mut file = Vec::new();
        let give = |command| (OperatorInput::default(), Some(command));
        let steps = vec![give(OperatorCommand::Recover), give(OperatorCommand::CycleStart)];
        let mut recorder = Recorder::new(Prescribed::new(steps), &mut file, Panel::default());
        recorder.input(&view(Phase::Faulted), Time::ZERO);
        assert_eq!(recorder.command(), Some(OperatorCommand::Recover));
        recorder.notes = false;
        recorder.operator.input(&view(Phase::Manual), Time::ZERO);
        assert_eq!(recorder.command(), Some(OperatorCommand::CycleStart));
        drop(recorder);
        let text = String::from_utf8(file).unwrap();
        assert!(text.contains(" f\n") && !text.contains(" r\n"), "{text}");
    }

    #[test]
    fn only_changes_are_written() {
        let mut file = Vec::new();
        let still = OperatorInput { velocity: Mm2::new(0.1, 0.0), ..OperatorInput::default() };
        let mut recorder =
            Recorder::new(Prescribed::new(vec![(still, None); 300]), &mut file, Panel::default());
        for i in 0..300 {
            recorder.input(&view(Phase::Manual), Time::from_micros(i * 10_000));
        }
        drop(recorder);
        let text = String::from_utf8(file).unwrap();
        assert_eq!(text, format!("{HEADER}\n0.000000 0.1 0 0 0 -\n2.990000 end\n"));
    }

    #[test]
    fn full_disk_ends_the_recording_with_a_notice() {
        struct Full;
        impl Write for Full {
            fn write(&mut self, _: &[u8]) -> io::Result<usize> {
                Err(io::ErrorKind::StorageFull.into())
            }
            fn flush(&mut self) -> io::Result<()> {
                Ok(())
            }
        }
        let panel = Panel::default();
        let input = OperatorInput { velocity: Mm2::new(1.0, 0.0), ..OperatorInput::default() };
        let mut recorder = Recorder::new(Prescribed::new(vec![(input, None)]), Full, panel.clone());
        assert_eq!(recorder.input(&view(Phase::Manual), Time::ZERO), input);
        assert!(panel.notices()[0].contains("cannot be written"));
    }
}
