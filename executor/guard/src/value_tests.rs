//! Tests of feed overrides, times, heights and the in-flight set.

use alloc::string::ToString as _;
use alloc::vec::Vec;
use core::time::Duration;

use keepout_kernel::{Height, Length, Point};

use super::{at, feedback, guard, sees};
use crate::*;

#[test]
fn override_slows_a_feed_and_never_stops_it() {
    for (percent, kept) in [(0, FeedOverride::LEAST), (25, 25), (50, 50), (100, 100), (255, 100)] {
        assert_eq!(FeedOverride::of_percent(percent).percent(), kept);
    }
    for (percent, feed, slowed) in [(50, 600, 300), (33, 1000, 330), (25, 1, 1), (25, 0, 0), (100, 600, 600)]
    {
        assert_eq!(FeedOverride::of_percent(percent).of(feed), slowed, "{percent} % of {feed}");
    }
}

#[test]
fn moments_are_counted_in_microseconds() {
    let (early, late) = (Time::from_micros(400), Time::from_micros(1500));
    assert_eq!(late.micros(), 1500);
    assert_eq!(late.since(early), Duration::from_micros(1100));
    assert_eq!(early.since(late), Duration::ZERO);
}

#[test]
fn heights_agree_up_to_a_count_of_resolutions() {
    let rules = HeightRules { resolution: Length::from_units(5).unwrap(), ..HeightRules::TWO_AXES };
    let height = |units| Height::from_units(units).unwrap();
    assert!(rules.agree(height(0), height(10), 2) && rules.agree(height(10), height(0), 2));
    assert!(!rules.agree(height(0), height(11), 2));
}

#[test]
fn way_after_a_line_leaves_out_the_lines_up_to_it() {
    let mut guard = guard();
    let start = at(-3000, 0);
    guard.locate(start.in_plane()).unwrap();
    let targets = [at(-3100, 0), at(-3200, 0)];
    for target in targets {
        guard.jog(target.in_plane(), 600).unwrap();
    }
    for (number, rest) in [(0, &targets[..]), (1, &targets[1..]), (2, &[])] {
        let way: Vec<Point> = guard.way_after(number).collect();
        assert_eq!(way[0], start);
        assert_eq!(&way[1..], rest, "after line {number}");
    }
}

#[test]
fn refusals_have_texts() {
    assert!(Refusal::Full.to_string().len() > 10);
}

/// Lines leave the set one after another, and many reports of the same queue do not hide the next news.
#[test]
fn lines_that_left_the_queue_leave_the_set() {
    for repeated in [1, 100] {
        let mut guard = guard();
        let start = at(-6000, 0);
        guard.locate(start.in_plane()).unwrap();
        let targets = [2000, 4000, 6000].map(|y| at(-6000, y));
        for target in targets {
            guard.jog(target.in_plane(), 600).unwrap();
            guard.acknowledged().unwrap();
        }
        let left = |guard: &Guard| guard.way_after(0).skip(1).collect::<Vec<Point>>();
        for _ in 0..repeated {
            sees(&mut guard, &feedback(at(-6000, 500), false, 2), 0);
        }
        assert_eq!(left(&guard), targets);
        sees(&mut guard, &feedback(at(-6000, 2500), false, 1), 400);
        sees(&mut guard, &feedback(at(-6000, 2600), false, 1), 600);
        assert_eq!(left(&guard), targets[1..], "{repeated}");
        sees(&mut guard, &feedback(at(-6000, 4500), false, 0), 950);
        assert_eq!(left(&guard), targets[2..], "{repeated}");
    }
}
