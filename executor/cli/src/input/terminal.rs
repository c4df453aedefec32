//! The terminal: raw mode, and the thread that reads its keys. Every exit path restores the terminal.

use std::collections::VecDeque;
use std::io::{IsTerminal, Write, stdin, stdout};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, Once, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use crossterm::event::{
    Event, KeyCode, KeyEvent, KeyEventKind, KeyModifiers, KeyboardEnhancementFlags,
    PopKeyboardEnhancementFlags, PushKeyboardEnhancementFlags,
};
use crossterm::{cursor, execute, terminal};
use keepout_executor::operator::{Operator, OperatorView, Panel};
use keepout_executor::supervisor::{OperatorCommand, OperatorInput};
use keepout_guard::Time;
use thiserror::Error;

use super::keyboard::{Key, Keys, Stroke};

/// Why the keyboard or the view is not available.
#[derive(Debug, Error)]
pub enum TerminalError {
    /// The input is not a terminal.
    #[error(
        "the keyboard needs a terminal, and the input is not a terminal: start keepout in a terminal, \
         without a pipe"
    )]
    NoKeyboard,
    /// The output is not a terminal.
    #[error(
        "the view needs a terminal, and the output is not a terminal: leave --view out, or start keepout in \
         a terminal"
    )]
    NoScreen,
    /// The system's error.
    #[error(
        "the terminal cannot be set up: {0}. Use another terminal, or leave --view and --operator keyboard \
         out."
    )]
    SetUp(#[from] std::io::Error),
}

/// Most key strokes that wait for the loop. Further ones are dropped.
const STROKES_MAX: usize = 256;
/// Longest wait for the end of the thread.
const ENDS_WITHIN: Duration = Duration::from_millis(300);
/// Time between two checks of the thread's stop flag.
const LOOK: Duration = Duration::from_millis(20);

/// Changes to the terminal. The first caller of [`restore`] takes them back.
static RAW: AtomicBool = AtomicBool::new(false);
static RELEASES: AtomicBool = AtomicBool::new(false);
static SCREEN: AtomicBool = AtomicBool::new(false);

/// Restores the terminal. Has no effect if the terminal is unchanged or already restored.
pub fn restore() {
    if RELEASES.swap(false, Ordering::SeqCst) {
        let _ = execute!(stdout(), PopKeyboardEnhancementFlags);
    }
    if SCREEN.swap(false, Ordering::SeqCst) {
        let _ = execute!(stdout(), cursor::Show, terminal::LeaveAlternateScreen);
    }
    if RAW.swap(false, Ordering::SeqCst) {
        let _ = terminal::disable_raw_mode();
    }
}

/// Installs a panic hook that restores the terminal before it prints the panic's message.
fn restore_on_panic() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let before = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |panic| {
            restore();
            before(panic);
        }));
    });
}

/// The terminal's second screen. Dropping it restores the first screen.
#[derive(Debug)]
pub struct SecondScreen(());

impl SecondScreen {
    /// Changes to the second screen, and hides the cursor.
    ///
    /// # Errors
    /// [`TerminalError`] when the output is not a terminal, or when the terminal cannot be set up.
    pub fn enter() -> Result<Self, TerminalError> {
        if !stdout().is_terminal() {
            return Err(TerminalError::NoScreen);
        }
        restore_on_panic();
        SCREEN.store(true, Ordering::SeqCst);
        let screen = Self(());
        execute!(stdout(), terminal::EnterAlternateScreen, cursor::Hide)?;
        Ok(screen)
    }
}

impl Drop for SecondScreen {
    fn drop(&mut self) {
        restore();
    }
}

/// Raw mode of the terminal. Dropping it ends raw mode.
#[derive(Debug)]
struct RawMode {
    releases: bool,
}

impl RawMode {
    fn enter() -> Result<Self, TerminalError> {
        if !stdin().is_terminal() {
            return Err(TerminalError::NoKeyboard);
        }
        restore_on_panic();
        terminal::enable_raw_mode()?;
        RAW.store(true, Ordering::SeqCst);
        let mut mode = Self { releases: false };
        // The library takes the terminal at its first use. If the terminal closed before, the query never returns.
        crossterm::event::poll(Duration::ZERO)?;
        // Only a terminal answers this query. In a file or a pipe, the query would appear in the output.
        if stdout().is_terminal() && terminal::supports_keyboard_enhancement().unwrap_or(false) {
            let flags = KeyboardEnhancementFlags::DISAMBIGUATE_ESCAPE_CODES
                | KeyboardEnhancementFlags::REPORT_EVENT_TYPES;
            execute!(stdout(), PushKeyboardEnhancementFlags(flags))?;
            RELEASES.store(true, Ordering::SeqCst);
            mode.releases = true;
        }
        Ok(mode)
    }
}

impl Drop for RawMode {
    fn drop(&mut self) {
        if RELEASES.swap(false, Ordering::SeqCst) {
            let _ = execute!(stdout(), PopKeyboardEnhancementFlags);
        }
        if RAW.swap(false, Ordering::SeqCst) {
            let _ = terminal::disable_raw_mode();
        }
        let _ = stdout().flush();
    }
}

/// Key strokes with the times at which the thread read them.
#[derive(Debug, Default)]
struct Typed {
    strokes: VecDeque<(Key, Stroke, Instant)>,
    /// Whether the terminal failed.
    gone: bool,
}

/// The keyboard of the terminal. A thread of its own reads the keys. Dropping it restores the terminal's
/// mode.
pub struct Keyboard {
    keys: Keys,
    typed: Arc<Mutex<Typed>>,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
    panel: Panel,
    /// Whether the keys jog. Otherwise another device does, and the status line is its own.
    jogs: bool,
    _mode: RawMode,
}

impl Keyboard {
    /// The keyboard beside another device, which jogs.
    ///
    /// # Errors
    /// As [`Keyboard::open`].
    pub fn watching(panel: Panel) -> Result<Self, TerminalError> {
        let mut keyboard = Self::open(panel)?;
        keyboard.jogs = false;
        Ok(keyboard)
    }

    /// Takes the terminal's keys from now on. Notices go to `panel`.
    ///
    /// # Errors
    /// [`TerminalError`] when the input is not a terminal, or when the terminal cannot be set up.
    pub fn open(panel: Panel) -> Result<Self, TerminalError> {
        let mode = RawMode::enter()?;
        let typed = Arc::new(Mutex::new(Typed::default()));
        let stop = Arc::new(AtomicBool::new(false));
        let shared = (Arc::clone(&typed), Arc::clone(&stop));
        let thread = std::thread::Builder::new()
            .name("keyboard".into())
            .spawn(move || serve(&shared.0, &shared.1))
            .map_err(TerminalError::SetUp)?;
        let keys = Keys::new(mode.releases);
        Ok(Self { keys, typed, stop, thread: Some(thread), panel, jogs: true, _mode: mode })
    }

    /// Whether space was the last key pressed.
    #[must_use]
    pub fn stopped(&self) -> bool {
        self.keys.stopped()
    }

    /// Takes the typed key strokes. `now` is the present time of the session.
    fn take_strokes(&mut self, now: Time) {
        let Ok(mut typed) = self.typed.try_lock() else { return };
        for (key, stroke, at) in typed.strokes.drain(..) {
            let ago = u64::try_from(at.elapsed().as_micros()).unwrap_or(u64::MAX);
            self.keys.take(key, stroke, Time::from_micros(now.micros().saturating_sub(ago)));
        }
        if typed.gone {
            self.panel.say("the terminal closed: the session ends");
            self.keys.take(Key::Interrupt, Stroke::Down, now);
        }
    }
}

impl Operator for Keyboard {
    fn input(&mut self, view: &OperatorView, now: Time) -> OperatorInput {
        self.take_strokes(now);
        self.keys.see_spindle(view.spindle_runs);
        let input = self.keys.input(view.phase, now);
        if self.jogs {
            self.panel.set_status(&self.keys.status());
        }
        self.panel.set_help(self.keys.help());
        self.panel.take(self.keys.take_taken());
        input
    }

    fn command(&mut self) -> Option<OperatorCommand> {
        self.keys.command()
    }
}

impl Drop for Keyboard {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        let Some(thread) = self.thread.take() else { return };
        // The terminal library can wait for the rest of a key. The end of the program then ends the thread.
        let waited = Instant::now();
        while !thread.is_finished() && waited.elapsed() < ENDS_WITHIN {
            std::thread::sleep(LOOK / 10);
        }
        if thread.is_finished() {
            let _ = thread.join();
        }
    }
}

/// The reading thread: notes each key stroke with its time.
fn serve(typed: &Mutex<Typed>, stop: &AtomicBool) {
    while !stop.load(Ordering::Relaxed) {
        let event = match crossterm::event::poll(LOOK) {
            Ok(true) => crossterm::event::read(),
            Ok(false) if hung_up() => Err(std::io::ErrorKind::UnexpectedEof.into()),
            Ok(false) => continue,
            Err(error) => Err(error),
        };
        let mut typed = typed.lock().unwrap_or_else(PoisonError::into_inner);
        match event {
            Ok(Event::Key(event)) if typed.strokes.len() < STROKES_MAX => {
                let (key, stroke) = decoded(event);
                typed.strokes.push_back((key, stroke, Instant::now()));
            }
            Ok(_) => {}
            Err(_) => {
                typed.gone = true;
                return;
            }
        }
    }
}

/// Whether the terminal is closed. The terminal library does not tell this.
#[cfg(unix)]
fn hung_up() -> bool {
    use rustix::event::{PollFd, PollFlags, Timespec, poll};

    let stdin = stdin();
    let mut inputs = [PollFd::new(&stdin, PollFlags::empty())];
    let _ = poll(&mut inputs, Some(&Timespec::default()));
    inputs[0].revents().intersects(PollFlags::HUP | PollFlags::ERR | PollFlags::NVAL)
}

/// Windows ends the program when its window closes.
#[cfg(not(unix))]
fn hung_up() -> bool {
    false
}

fn decoded(event: KeyEvent) -> (Key, Stroke) {
    let stroke = match event.kind {
        KeyEventKind::Press => Stroke::Down,
        KeyEventKind::Repeat => Stroke::Repeat,
        KeyEventKind::Release => Stroke::Up,
    };
    let command = event.modifiers.intersects(KeyModifiers::CONTROL | KeyModifiers::ALT | KeyModifiers::SUPER);
    let key = match event.code {
        KeyCode::Char('c' | 'C') if event.modifiers.contains(KeyModifiers::CONTROL) => Key::Interrupt,
        _ if command => Key::Other,
        KeyCode::Left => Key::Jog(-1, 0),
        KeyCode::Right => Key::Jog(1, 0),
        KeyCode::Up => Key::Jog(0, 1),
        KeyCode::Down => Key::Jog(0, -1),
        KeyCode::Home => Key::Jog(-1, 1),
        KeyCode::PageUp => Key::Jog(1, 1),
        KeyCode::End => Key::Jog(-1, -1),
        KeyCode::PageDown => Key::Jog(1, -1),
        KeyCode::Char('+' | '=') => Key::Lift(1),
        KeyCode::Char('-' | '_') => Key::Lift(-1),
        KeyCode::Enter => Key::Character('\n'),
        KeyCode::Char(character) => Key::Character(character.to_ascii_lowercase()),
        _ => Key::Other,
    };
    (key, stroke)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn terminal_key_events_become_keys() {
        let of = |code, modifiers| decoded(KeyEvent::new(code, modifiers)).0;
        assert_eq!(of(KeyCode::Up, KeyModifiers::NONE), Key::Jog(0, 1));
        assert_eq!(of(KeyCode::PageDown, KeyModifiers::NONE), Key::Jog(1, -1));
        assert_eq!(of(KeyCode::Char('Q'), KeyModifiers::SHIFT), Key::Character('q'));
        assert_eq!(of(KeyCode::Char('c'), KeyModifiers::CONTROL), Key::Interrupt);
        assert_eq!(of(KeyCode::Char('a'), KeyModifiers::CONTROL), Key::Other);
        assert_eq!(of(KeyCode::F(1), KeyModifiers::NONE), Key::Other);
    }

    #[test]
    fn without_a_terminal_keyboard_and_view_are_refused() {
        restore();
        if !stdin().is_terminal() {
            assert!(matches!(Keyboard::open(Panel::default()), Err(TerminalError::NoKeyboard)));
        }
        if !stdout().is_terminal() {
            assert!(matches!(SecondScreen::enter(), Err(TerminalError::NoScreen)));
        }
        assert!(!RAW.load(Ordering::SeqCst) && !SCREEN.load(Ordering::SeqCst));
    }
}
