//! Random conversations, each from a seed.

use std::time::Duration;

use fastrand::Rng;

use crate::conversation::DirectConversation;

/// Time in which every hold and every cancel ends.
const STILL: Duration = Duration::from_millis(500);

/// A step of a conversation.
#[derive(Clone, Debug, PartialEq)]
pub enum Talk {
    Line(String),
    Byte(u8),
    Wait(Duration),
    Answered,
}

/// The vocabulary of a conversation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Vocabulary {
    /// Motions as Keepout writes them, and illegal lines.
    Motions,
    /// Jogs as Keepout writes them.
    Jogs,
    /// Jogs with cancels and holds.
    CancelledJogs,
    /// Motions with holds and cycle starts.
    HeldMotions,
    /// Motions and jogs with resets.
    Resets,
    /// Motions and jogs of a machine with three axes.
    ThreeAxes,
    /// Lines of any other host.
    OtherHosts,
}

/// A random conversation.
pub fn script(vocabulary: Vocabulary, seed: u64) -> Vec<Talk> {
    let mut random = Rng::with_seed(seed);
    let mut steps = vec![Talk::Line("$10=3".into()), Talk::Answered];
    let count = random.usize(1..10);
    for _ in 0..count {
        let line = match vocabulary {
            Vocabulary::Jogs | Vocabulary::CancelledJogs => jog(&mut random),
            Vocabulary::Motions | Vocabulary::HeldMotions => motion(&mut random),
            Vocabulary::Resets if seed.is_multiple_of(2) => jog(&mut random),
            Vocabulary::Resets => motion(&mut random),
            Vocabulary::ThreeAxes => three_axes(&mut random),
            Vocabulary::OtherHosts => other(&mut random),
        };
        steps.push(Talk::Line(line));
        if random.u8(0..4) == 0 {
            steps.push(Talk::Wait(Duration::from_millis(random.u64(5..400))));
        }
        if random.u8(0..3) == 0 {
            steps.push(Talk::Byte(b'?'));
        }
        interrupts(vocabulary, &mut random, &mut steps);
    }
    steps
}

/// Real-time characters of the vocabulary.
fn interrupts(vocabulary: Vocabulary, random: &mut Rng, steps: &mut Vec<Talk>) {
    if random.u8(0..4) != 0 {
        return;
    }
    let wait = Talk::Wait(Duration::from_millis(random.u64(10..400)));
    match vocabulary {
        Vocabulary::CancelledJogs => {
            steps.extend([wait, Talk::Byte([0x85, b'!'][random.usize(0..2)])]);
            steps.extend([Talk::Wait(STILL), Talk::Byte(b'~')]);
        }
        Vocabulary::HeldMotions => {
            let still = Talk::Wait(STILL + Duration::from_millis(random.u64(0..500)));
            steps.extend([wait, Talk::Byte(b'!'), still, Talk::Byte(b'~')]);
        }
        Vocabulary::Resets => {
            let still = Talk::Wait(Duration::from_millis(100));
            steps.extend([Talk::Answered, wait, Talk::Byte(0x18), still.clone()]);
            steps.extend([Talk::Line("$X".into()), Talk::Answered, still]);
        }
        _ => {}
    }
}

/// A coordinate with three decimals, around the start.
fn near(random: &mut Rng, middle: f64, reach: f64) -> f64 {
    ((middle + (random.f64() * 2.0 - 1.0) * reach) * 1000.0).round() / 1000.0
}

fn feed(random: &mut Rng) -> u32 {
    [60, 300, 900, 3000, 6000, 12_000][random.usize(1..6)] + random.u32(0..3)
}

/// A jog in machine coordinates, or now and then another legal or illegal one.
fn jog(random: &mut Rng) -> String {
    let (x, y, f) = (near(random, -200.0, 20.0), near(random, -150.0, 20.0), feed(random));
    match random.u8(0..12) {
        0 => format!("$J=G91G21X{:.3}Y{:.3}F{f}", (x + 200.0) / 4.0, (y + 150.0) / 4.0),
        1 => format!("$J=G90G21X{:.3}F{f}", x + 37.25),
        2 => format!("$J=G91X{:.3}", x + 200.0),
        3 => ["$J=G53G90G21X10F600", "$JX", "$J=G91G1X0F100", "$J=G53G90G21X-200", "$J=G91X0F"]
            [random.usize(0..5)]
        .into(),
        _ => format!("$J=G53G90G21X{x:.3}Y{y:.3}F{f}"),
    }
}

/// A motion with all its modes, or an illegal line.
fn motion(random: &mut Rng) -> String {
    let (x, y, f) = (near(random, -162.75, 20.0), near(random, -128.5, 20.0), feed(random));
    match random.u8(0..14) {
        0..=2 => format!(
            "G{}G17G21G54G90G94X{x:.3}Y{y:.3}R{:.3}F{f}",
            2 + random.u8(0..2),
            40.0 + random.f64() * 40.0
        ),
        3 => format!("G1G53G21G90G94X{:.3}Y{:.3}F{f}", x - 37.25, y - 21.5),
        4 => ["G1G2", "G999", "1", "G1X", "G1X1X2", "X1F-1"][random.usize(0..6)].into(),
        5 => "G80".into(),
        _ => format!("G1G21G54G90G94X{x:.3}Y{y:.3}F{f}"),
    }
}

/// A motion or a jog of three axes, one after the other.
fn three_axes(random: &mut Rng) -> String {
    let (x, y, f) = (near(random, -162.75, 20.0), near(random, -128.5, 20.0), feed(random));
    let z = near(random, -10.0, 8.0);
    match random.u8(0..10) {
        0 | 1 => format!("G1G21G54G90G94Z{z:.3}F{f}"),
        2 => format!("G{}G17G21G54G90G94X{x:.3}Y{y:.3}Z{z:.3}R60F{f}", 2 + random.u8(0..2)),
        3 => "$J=G53G90G21Z5F600".into(),
        _ => format!("G1G21G54G90G94X{x:.3}Y{y:.3}Z{z:.3}F{f}"),
    }
}

/// A line of another host.
fn other(random: &mut Rng) -> String {
    let (x, y, f) = (near(random, -162.75, 20.0), near(random, -128.5, 20.0), feed(random));
    match random.u8(0..26) {
        0 => format!("G0X{x:.3}"),
        1 => format!("G1X{x:.3}F{f}"),
        2 => format!("G91G1X{:.3}F{f}\nG90", (x + 162.75) / 4.0),
        3 => format!("G20G1X{:.4}F{:.1}\nG21", x / 25.4, f64::from(f) / 25.4),
        4 => format!("M{}S{}", 3 + random.u8(0..2), random.u32(0..3) * 1000),
        5 => "M5".into(),
        6 => format!("G4P{:.2}", random.f64() / 4.0),
        7 => format!("G1 X{x:.3} (a comment) F{f}"),
        8 => format!("g1x{x:.3}f{f} ; text"),
        9 => format!("N{}G1Y{y:.3}F{f}", random.u32(1..100)),
        10 => ["M2", "M30", "M0", "M1", "%"][random.usize(0..5)].into(),
        11 => ["G55", "G54", "G54", "G17", "G18", "G17"][random.usize(0..6)].into(),
        12 => format!("G92X{:.3}\nG92.1", x),
        13 => format!("G10L20P1X{:.3}", x),
        14 => format!("G{}X{x:.3}Y{y:.3}I{:.3}J{:.3}F{f}", 2 + random.u8(0..2), random.f64(), random.f64()),
        15 => format!("G93G1X{x:.3}F{:.2}\nG94", 1.0 + random.f64() * 60.0),
        16 => ["G43.1Z0\nG49", "G40", "G61", "G91.1", "G49", "G43"][random.usize(0..6)].into(),
        17 => ["M8", "M9", "M7", "T1", "M6", "S500"][random.usize(0..6)].into(),
        18 => {
            ["G28X-150", "G30", "G28.1", "G38.2X1F100", "G53X-200", "G53G0X-200"][random.usize(0..6)].into()
        }
        19 => ["$$", "$#", "$G", "$I", "$N", "$", "$X"][random.usize(0..7)].into(),
        20 => {
            ["$H1", "$C1", "$J=G91X1F100", "$Q", "$1x", "$10=", "$20=1", "$999=1"][random.usize(0..8)].into()
        }
        21 => "G1X1Y2Z3A4".into(),
        22 => format!("X{x:.3}"),
        23 => format!("{}X1", "G1 ".repeat(30)),
        24 => "G1F0X-160".into(),
        _ => String::new(),
    }
}

/// Longest wait for an answer.
const WITHIN: Duration = Duration::from_secs(20);
/// Most bytes of lines without an answer: the receive buffer holds them.
const OPEN_BYTES: usize = 120;

/// Plays a script.
pub fn play(talk: &mut DirectConversation, script: &[Talk]) {
    for step in script {
        match step {
            Talk::Wait(span) => talk.wait(*span),
            Talk::Byte(byte) => talk.send_byte(*byte),
            Talk::Answered => _ = talk.await_open(0, WITHIN),
            Talk::Line(text) => {
                for line in text.split('\n') {
                    talk.await_open(OPEN_BYTES.saturating_sub(line.len() + 1), WITHIN);
                    talk.send_line(line);
                }
            }
        }
    }
}
