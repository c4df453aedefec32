//! Keys and their events, independent of terminals.

/// A key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Key {
    /// A jog key: −1, 0 or 1 in x and y. Up is +y.
    Jog(i8, i8),
    /// A key of the third axis: 1 up, −1 down.
    Lift(i8),
    /// A letter, digit or space. Letters are in lower case.
    Character(char),
    /// Ctrl-C.
    Interrupt,
    /// Any other key.
    Other,
}

/// Event of a key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stroke {
    /// The key went down. Without release events, a repeat also counts as down.
    Down,
    /// The key is still held.
    Repeat,
    /// The key went up.
    Up,
}
