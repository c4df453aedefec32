//! The receive buffer, and the line that the program collects from it.
//!
//! Source: `doc/markdown/interface.md`: real-time characters never enter the buffer, and bytes that find no
//! room are lost.

use std::collections::VecDeque;

/// Bytes of the receive buffer.
pub(super) const RECEIVE_BUFFER: usize = 128;
/// Most characters of a line without spaces and comments.
const LINE_MAX: usize = 79;

/// A collected line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum CollectedLine {
    /// Its characters: capital letters, without spaces and comments.
    Text(Vec<u8>),
    /// It was too long.
    TooLong,
}

/// The kind of comment under way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Comment {
    #[default]
    None,
    /// To the closing parenthesis.
    Parentheses,
    /// To the end of the line.
    Rest,
}

/// The receive buffer.
#[derive(Clone, Debug, Default)]
pub(super) struct ReceiveBuffer {
    bytes: VecDeque<u8>,
    line: Vec<u8>,
    comment: Comment,
    too_long: bool,
}

impl ReceiveBuffer {
    /// Puts a byte into the buffer, if it has room.
    pub fn put(&mut self, byte: u8) {
        if self.bytes.len() < RECEIVE_BUFFER {
            self.bytes.push_back(byte);
        }
    }

    /// Free bytes.
    pub fn free(&self) -> usize {
        RECEIVE_BUFFER - self.bytes.len()
    }

    /// Drops all content.
    pub fn clear(&mut self) {
        *self = Self::default();
    }

    /// Takes bytes up to the end of a line. `None` while the line is not complete.
    pub fn next_line(&mut self) -> Option<CollectedLine> {
        while let Some(byte) = self.bytes.pop_front() {
            if matches!(byte, b'\n' | b'\r') {
                let too_long = std::mem::take(&mut self.too_long);
                self.comment = Comment::None;
                let line = std::mem::take(&mut self.line);
                return Some(if too_long { CollectedLine::TooLong } else { CollectedLine::Text(line) });
            }
            self.collect(byte);
        }
        None
    }

    fn collect(&mut self, byte: u8) {
        match (self.comment, byte) {
            (Comment::Parentheses, b')') => self.comment = Comment::None,
            (Comment::Parentheses | Comment::Rest, _) | (_, 0..=b' ' | b'/') => {}
            (_, b'(') => self.comment = Comment::Parentheses,
            (_, b';') => self.comment = Comment::Rest,
            _ if self.line.len() >= LINE_MAX => self.too_long = true,
            _ => self.line.push(byte.to_ascii_uppercase()),
        }
    }
}
