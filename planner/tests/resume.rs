//! A contouring job, interrupted anywhere and any number of times, cuts every loop completely. It recuts no
//! more than each resumed job states.
#![expect(clippy::unwrap_used, reason = "a test helper may panic")]

use std::collections::BTreeMap;

use keepout_kernel::exact::segment::Window;
use keepout_kernel::offset::certify_path;
use keepout_kernel::{Curve, Length, Point, UNITS_PER_MM};
use keepout_planner::Mm2;
use keepout_planner::job::{
    ContourJob, JobError, LoopNumber, PartialLoop, Progress, ProgressError, contour_job, resume_in_place,
    resume_job,
};
use keepout_planner::machine::MachineProfile;
use keepout_planner::plan::{CertifiedPlan, Cut, PassParameters, PlanParameters};
use keepout_planner::profile::MachinedSide;
use keepout_planner::request::PlanRequest;
use keepout_planner::units::{along_mm, point_from_mm, point_mm};
use proptest::prelude::{Strategy, any, proptest};
use proptest::test_runner::{Config, TestRunner};

/// A drawing, the machined side, and the tool diameter, mm.
type Case = (&'static str, MachinedSide, f64);

const CASES: [Case; 11] = [
    ("executor/cli/drawings/bracket.dxf", MachinedSide::Outside, 6.0),
    ("executor/cli/drawings/bracket.dxf", MachinedSide::Inside, 3.0),
    ("tests/drawings/rounded_plate.dxf", MachinedSide::Outside, 4.0),
    ("tests/drawings/insert_array.dxf", MachinedSide::Outside, 3.0),
    ("tests/drawings/nested.dxf", MachinedSide::Outside, 2.0),
    ("tests/drawings/pocket.dxf", MachinedSide::Inside, 5.0),
    ("tests/drawings/d_pocket.dxf", MachinedSide::Inside, 2.0),
    ("tests/drawings/ellipse.dxf", MachinedSide::Outside, 6.0),
    ("tests/drawings/triangle.dxf", MachinedSide::Outside, 1.0),
    ("tests/drawings/slot_exact.dxf", MachinedSide::Outside, 5.9),
    ("tests/drawings/needle.dxf", MachinedSide::Outside, 6.0),
];

fn planned((file, side, diameter): Case, cut: Cut, passes: &[f64]) -> CertifiedPlan {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(file);
    let bytes = std::fs::read(path).unwrap();
    let pass = |&stock_to_leave_mm: &f64| PassParameters { stock_to_leave_mm, feed_mm_min: None };
    let passes = passes.iter().map(pass).collect();
    let job = PlanParameters { tool_diameter_mm: diameter, side, cut, passes, ..PlanParameters::default() };
    let request = PlanRequest { job, ..PlanRequest::default() };
    request.plan(file, &bytes, &MachineProfile::simulated(), &mut |_| {}).unwrap()
}

fn field(plan: &CertifiedPlan) -> Window {
    plan.part.region().bounds().grown(Length::from_units(6_000_000).unwrap())
}

/// A clear start point in each free space.
fn starts(plan: &CertifiedPlan) -> Vec<Point> {
    let jobs = keepout_planner::job::preview(plan);
    jobs.iter().map(|job| job.legs[0].curves[0].from()).collect()
}

fn length_mm(curves: &[Curve]) -> f64 {
    curves.iter().map(Curve::length).sum::<f64>() / f64::from(UNITS_PER_MM)
}

/// A source of numbers in [0, 1) from a list, which it repeats.
struct Draws(Vec<f64>, usize);

impl Draws {
    fn next(&mut self) -> f64 {
        self.1 += 1;
        self.0[(self.1 - 1) % self.0.len()]
    }
}

/// An interruption: the leg, the motion, and the finished share of the motion.
fn interruption(job: &ContourJob, draws: &mut Draws) -> (usize, usize, f64) {
    let whole: f64 = job.legs.iter().map(|leg| length_mm(&leg.curves)).sum();
    let mut left = draws.next() * whole;
    for (number, leg) in job.legs.iter().enumerate() {
        for (index, curve) in leg.curves.iter().enumerate() {
            let length = length_mm(&[*curve]);
            if left < length {
                return (number, index, left / length);
            }
            left -= length;
        }
    }
    (job.legs.len(), 0, 0.0)
}

/// The length cut of each loop, mm, and the curves that cut it.
#[derive(Default)]
struct Done {
    mm: BTreeMap<LoopNumber, f64>,
    curves: BTreeMap<LoopNumber, Vec<Curve>>,
}

impl Done {
    fn forget(&mut self, number: LoopNumber) {
        self.mm.remove(&number);
        self.curves.remove(&number);
    }

    fn add(&mut self, job: &ContourJob, (leg_now, curve_now, share): (usize, usize, f64)) {
        for (index, leg) in job.legs.iter().enumerate().take(leg_now + 1) {
            let Some(number) = leg.cuts else { continue };
            for k in leg.on_loop.clone() {
                let curve = leg.curves[k];
                let part = if index < leg_now || k < curve_now {
                    1.0
                } else if k == curve_now {
                    share
                } else {
                    0.0
                };
                *self.mm.entry(number).or_default() += part * length_mm(&[curve]);
                if part > 0.0 {
                    self.curves.entry(number).or_default().push(curve);
                }
            }
        }
    }
}

/// Checks that every motion of the job is certified and joins the previous one, and that no finished loop is
/// cut again.
fn check_job(plan: &CertifiedPlan, job: &ContourJob, from: Point) {
    let mut here = from;
    for leg in &job.legs {
        assert_eq!(leg.curves.first().unwrap().from(), here);
        let end = certify_path(&plan.part, plan.finishing, &leg.curves).unwrap().unwrap();
        here = end.point();
        plan.part.free_point(here, plan.roughing).unwrap();
        assert_eq!(leg.cuts.is_some(), !leg.on_loop.is_empty());
        assert!(leg.cuts.is_none_or(|number| !job.before.has_finished(number)));
    }
    let count: usize = job.legs.iter().map(|leg| leg.curves.len()).sum();
    assert_eq!(job.motion(count), None);
    let last = job.legs.len() - 1;
    assert_eq!(job.motion(count - 1), Some((last, job.legs[last].curves.len() - 1)));
}

/// The distance of a point from a curve, mm, exact to 1 µm.
fn away_mm(curve: &Curve, at: Point) -> f64 {
    let p = point_mm(at);
    let points: Vec<Mm2> =
        curve.chord_points(Length::small(100)).unwrap().into_iter().map(point_mm).collect();
    let away = |pair: &[Mm2]| {
        let q = p.nearest_on(pair[0], pair[1]);
        p.distance(q)
    };
    points.windows(2).map(away).fold(f64::INFINITY, f64::min)
}

/// A reported position: up to 2.5 µm off in x and in y, then rounded to 1 µm.
fn reported(curve: &Curve, share: f64, draws: &mut Draws) -> Point {
    let Mm2 { x, y } = along_mm(curve, share).0;
    let digit = |c: f64, d: f64| ((c + (d - 0.5) * 0.005) * 1000.0).round() / 1000.0;
    point_from_mm(Mm2::new(digit(x, draws.next()), digit(y, draws.next()))).unwrap()
}

/// Interrupts a job `times` times and checks the result. Returns the number of loops that it had to recut
/// from their start.
fn interrupted_often(plan: &CertifiedPlan, start: Point, mut draws: Draws, times: usize) -> usize {
    let within = field(plan);
    let (mut done, mut progress, mut recut_mm, mut restarted) =
        (Done::default(), Progress::default(), 0.0, 0);
    let first = contour_job(plan, start.in_plane(), within).unwrap();
    let loops: Vec<LoopNumber> = first.legs.iter().filter_map(|leg| leg.cuts).collect();
    let mut job = first.clone();
    for _ in 0..times {
        check_job(plan, &job, start);
        let at = interruption(&job, &mut draws);
        done.add(&job, at);
        let report = match job.legs.get(at.0) {
            Some(leg) => reported(&leg.curves[at.1], at.2, &mut draws),
            None => start,
        };
        let before = progress.finished.len();
        progress = Progress::after(&job, at.0, at.1, report);
        assert!(progress.finished.len() >= before && progress.partial.len() <= 1);
        let mut next = resume_job(plan, start.in_plane(), within, &progress);
        if let Some(number) = no_way_back(&next, &progress) {
            progress.forget(number);
            done.forget(number);
            restarted += 1;
            next = resume_job(plan, start.in_plane(), within, &progress);
        }
        match next {
            Ok(next) => job = next,
            Err(JobError::AllFinished { .. }) => break,
            Err(error) => panic!("{error}"),
        }
        assert_eq!(job.unreached, first.unreached, "after {progress:?}");
        recut_mm += job.recut_mm;
    }
    if resume_job(plan, start.in_plane(), within, &progress).is_ok() {
        check_job(plan, &job, start);
        done.add(&job, (job.legs.len(), 0, 0.0));
        progress = Progress::after(&job, job.legs.len(), 0, start);
    }
    let mut finished = progress.finished.clone();
    finished.sort_unstable();
    let mut all = loops;
    all.sort_unstable();
    assert_eq!(finished, all);
    assert!(progress.partial.is_empty());
    check_whole(plan, &done, times, recut_mm);
    restarted
}

/// An interrupted loop that no link move can reach again.
fn no_way_back(next: &Result<ContourJob, JobError>, progress: &Progress) -> Option<LoopNumber> {
    let unreached = match next {
        Ok(job) => job.unreached.clone(),
        Err(JobError::NoWayBack { number, .. }) => vec![*number],
        Err(_) => Vec::new(),
    };
    let partial = progress.partial.iter().map(|each| each.number);
    partial.into_iter().find(|number| unreached.contains(number))
}

/// Checks that the cuts add up to the length of each loop, and that they pass every place of each loop.
fn check_whole(plan: &CertifiedPlan, done: &Done, times: usize, recut_mm: f64) {
    for (number, cut) in &done.mm {
        let curves = &plan.plan.passes[number.pass].path.loops[number.index].curves;
        let length = length_mm(curves);
        let tolerance_mm = 0.012 * (1.0 + f64::from(u32::try_from(times).unwrap()));
        assert!(
            *cut > length - tolerance_mm && *cut < length + recut_mm + tolerance_mm,
            "{number}: {cut} of {length}"
        );
        let chords: Vec<(Mm2, Mm2)> = done.curves[number]
            .iter()
            .flat_map(|curve| {
                let points = curve.chord_points(Length::small(50)).unwrap();
                points.windows(2).map(|p| (point_mm(p[0]), point_mm(p[1]))).collect::<Vec<_>>()
            })
            .collect();
        for k in 0..curves.len().max(200) {
            let curve = &curves[k % curves.len()];
            let p = along_mm(curve, f64::from(u8::try_from(k % 200).unwrap()) / 200.0).0;
            let away = chords.iter().map(|&(a, b)| {
                let q = p.nearest_on(a, b);
                p.distance(q)
            });
            let away = away.fold(f64::INFINITY, f64::min);
            assert!(away < 0.012, "{number}: {p:?} is {away} mm from all cuts");
        }
    }
}

#[test]
fn job_interrupted_anywhere_any_number_of_times_is_cut_completely() {
    let (mut runs, all_restarted) = (0, std::cell::Cell::new(0));
    for case in CASES {
        for (cut, passes) in [(Cut::Conventional, &[][..]), (Cut::Climb, &[0.1, 0.0])] {
            let plan = planned(case, cut, passes);
            for start in starts(&plan) {
                let mut runner =
                    TestRunner::new(Config { cases: 24, failure_persistence: None, ..Config::default() });
                let draws = proptest::collection::vec(0.0..1.0_f64, 40);
                let strategy = (draws, 1_usize..7);
                let outcome = runner.run(&strategy, |(draws, times)| {
                    let restarted = interrupted_often(&plan, start, Draws(draws, 0), times);
                    // A contour can not be entered inside a slot that is hardly wider than the tool.
                    assert!(
                        restarted == 0 || case.0.contains("slot"),
                        "{restarted} loops recut from the start"
                    );
                    all_restarted.set(all_restarted.get() + restarted);
                    Ok(())
                });
                outcome.unwrap_or_else(|error| panic!("{case:?} {cut:?} from {start:?}: {error}"));
                runs += 1;
            }
        }
    }
    assert!(runs >= 24 && all_restarted.get() > 0, "only {runs} free spaces");
}

/// Progress listed the contour as partial, and the job for the rest called it finished.
#[test]
fn contour_that_stops_10_micrometres_before_its_end_is_finished() {
    let case = CASES.iter().find(|case| case.0.contains("slot_exact")).unwrap();
    let plan = planned(*case, Cut::Climb, &[0.1, 0.0]);
    let mut draws = vec![
        0.7919519084043039,
        0.0,
        0.0,
        0.8461636402227771,
        0.4360955731509667,
        0.0,
        0.8575647795554436,
        0.22333286289634396,
    ];
    draws.resize(40, 0.0);
    interrupted_often(&plan, Point::from_units(0, -322_059).unwrap(), Draws(draws, 0), 3);
}

/// With room around the part, only the joints are recut: at most 0.05 mm.
#[test]
fn resumed_job_with_room_recuts_only_the_joints() {
    let plan = planned(CASES[2], Cut::Conventional, &[]);
    let start = starts(&plan)[0];
    let job = contour_job(&plan, start.in_plane(), field(&plan)).unwrap();
    let leg = job.legs.iter().position(|leg| leg.cuts.is_some()).unwrap();
    for k in job.legs[leg].on_loop.clone() {
        for share in [0.0, 0.3, 0.5, 0.999] {
            let at = point_from_mm(along_mm(&job.legs[leg].curves[k], share).0).unwrap();
            let progress = Progress::after(&job, leg, k, at);
            let Ok(rest) = resume_job(&plan, start.in_plane(), field(&plan), &progress) else { continue };
            assert!(rest.recut_mm <= 0.05, "{} mm at motion {k}, {share}", rest.recut_mm);
            assert_eq!(rest.tangential, job.tangential, "lead-in and lead-out are tangential");
        }
    }
}

/// A slot hardly wider than the tool has no room for a lead-in or lead-out. Near its mouth a resumed job
/// recuts less than a tool diameter.
#[test]
fn resumed_job_in_a_slot_recuts_less_than_a_tool_diameter() {
    let (mut recut, mut recut_at_entry, mut lost) = (0, 0, 0);
    for diameter in [5.9, 5.95] {
        let job =
            PlanParameters { tool_diameter_mm: diameter, margin_mm: Some(0.02), ..PlanParameters::default() };
        let request = PlanRequest { job, ..PlanRequest::default() };
        let slot = include_bytes!("../../tests/drawings/slot_exact.dxf");
        let plan = request.plan("slot", slot, &MachineProfile::simulated(), &mut |_| {}).unwrap();
        let start = starts(&plan)[0];
        let job = contour_job(&plan, start.in_plane(), field(&plan)).unwrap();
        let leg = job.legs.iter().position(|leg| leg.cuts.is_some()).unwrap();
        for (k, share) in job.legs[leg].on_loop.clone().flat_map(|k| (0..100_u8).map(move |n| (k, n))) {
            let share = f64::from(share) / 100.0;
            let at = point_from_mm(along_mm(&job.legs[leg].curves[k], share).0).unwrap();
            let progress = Progress::after(&job, leg, k, at);
            match resume_job(&plan, start.in_plane(), field(&plan), &progress) {
                Ok(rest) => {
                    let mut done = Done::default();
                    done.add(&job, (leg, k, share));
                    done.add(&rest, (rest.legs.len(), 0, 0.0));
                    check_whole(&plan, &done, 1, rest.recut_mm);
                    check_job(&plan, &rest, start);
                    recut += usize::from(rest.recut_mm > 0.1);
                    assert!(rest.recut_mm < diameter, "{}", rest.recut_mm);
                    let led: f64 = rest.legs.iter().map(|leg| length_mm(&leg.curves)).sum();
                    let on_loop = rest.legs.iter().map(|leg| length_mm(&leg.curves[leg.on_loop.clone()]));
                    assert!(led - on_loop.sum::<f64>() > rest.recut_mm.min(diameter / 2.0) - 0.06);
                }
                Err(JobError::NoWayBack { .. }) => lost += 1,
                Err(error) => panic!("{error}"),
            }
            // The loop was entered at this point, and interrupted at a point with room.
            let longest = |a: &&Curve, b: &&Curve| a.length().total_cmp(&b.length());
            let room = job.legs[leg].curves.iter().max_by(longest).unwrap();
            let resume_point = point_from_mm(along_mm(room, 0.4).0).unwrap();
            let partial = PartialLoop { number: job.legs[leg].cuts.unwrap(), entry: at, resume_point };
            let progress = Progress { partial: vec![partial], ..Progress::default() };
            if let Ok(rest) = resume_job(&plan, start.in_plane(), field(&plan), &progress) {
                check_job(&plan, &rest, start);
                assert!(rest.recut_mm < diameter, "{}", rest.recut_mm);
                recut_at_entry += usize::from(rest.recut_mm > 0.1);
            }
        }
    }
    assert!(recut > 3 && recut_at_entry > 3 && lost > 10, "{recut}, {recut_at_entry}, {lost}");
}

#[test]
fn progress_that_does_not_fit_is_refused() {
    let plan = planned(CASES[0], Cut::Conventional, &[]);
    let (start, within) = (starts(&plan)[0], field(&plan));
    let job = contour_job(&plan, start.in_plane(), within).unwrap();
    let leg = job.legs.iter().find(|leg| leg.cuts.is_some()).unwrap();
    let (number, entry) = (leg.cuts.unwrap(), leg.entry.unwrap());
    let with = |partial| Progress { partial: vec![partial], ..Progress::default() };
    let resumed = |partial| resume_job(&plan, start.in_plane(), within, &with(partial));
    let off = resumed(PartialLoop { number, entry, resume_point: start }).unwrap_err();
    assert!(matches!(off, JobError::Progress(ProgressError::Off { at, .. }) if at == start), "{off}");
    assert!(off.to_string().contains("start without"), "{off}");
    let elsewhere = LoopNumber { pass: 3, index: 0 };
    let none = resumed(PartialLoop { number: elsewhere, entry, resume_point: entry }).unwrap_err();
    assert!(matches!(none, JobError::Progress(ProgressError::NoSuchLoop { .. })), "{none}");
    // A loop whose resume point is its end is finished.
    let rest = resumed(PartialLoop { number, entry, resume_point: entry });
    assert!(rest.is_err() || rest.unwrap().legs.iter().all(|leg| leg.cuts != Some(number)));
    let all: Vec<LoopNumber> = job.legs.iter().filter_map(|leg| leg.cuts).collect();
    let all = Progress { finished: all, ..Progress::default() };
    assert_eq!(resume_job(&plan, start.in_plane(), within, &all), Err(JobError::AllFinished { from: start }));
}

#[test]
fn progress_follows_from_the_interrupted_motion_and_the_reported_position() {
    let plan = planned(CASES[4], Cut::Climb, &[0.1, 0.0]);
    let within = field(&plan);
    let jobs =
        starts(&plan).into_iter().map(|start| (start, contour_job(&plan, start.in_plane(), within).unwrap()));
    let (start, job) = jobs.max_by_key(|(_, job)| job.legs.len()).unwrap();
    let cuts: Vec<usize> = (0..job.legs.len()).filter(|&k| job.legs[k].cuts.is_some()).collect();
    assert_eq!(cuts.len(), 4, "outer and inner loop of a ring, two passes");
    let leg = &job.legs[cuts[2]];
    let interrupted_at = |curve: usize, share: f64| {
        let at = point_from_mm(along_mm(&leg.curves[curve], share).0).unwrap();
        Progress::after(&job, cuts[2], curve, at)
    };
    let two: Vec<LoopNumber> = cuts[..2].iter().filter_map(|&k| job.legs[k].cuts).collect();
    let led_in = interrupted_at(0, 0.5);
    assert_eq!((&led_in.finished, led_in.partial.len()), (&two, 0), "the lead-in cuts no part of the loop");
    let begun = interrupted_at(leg.on_loop.start, 0.5);
    let entry = leg.entry.unwrap();
    assert_eq!((&begun.finished, begun.partial[0].entry), (&two, entry));
    assert_eq!(leg.curves[leg.on_loop.end - 1].to(), entry, "the cut ends where it began");
    assert_eq!(interrupted_at(leg.on_loop.end, 0.0).finished.len(), 3, "lead-out");
    assert_eq!(Progress::after(&job, 99, 0, start).finished.len(), 4);
    let lost = Progress::after(&job, cuts[2], leg.on_loop.start + 1, start);
    assert_eq!(
        lost.partial[0].resume_point,
        leg.curves[leg.on_loop.start + 1].from(),
        "a position off the curve"
    );
    // An interruption before the resumed loop is reached leaves the progress unchanged.
    let rest = resume_job(&plan, start.in_plane(), within, &begun).unwrap();
    assert_eq!(Progress::after(&rest, 0, 0, start), begun);
}

proptest! {
    #![proptest_config(Config { cases: 16, failure_persistence: None, ..Config::default() })]
    #[test]
    fn tool_on_the_path_resumes_in_place(
        case in 0..CASES.len(),
        climb in any::<bool>(),
        sent in any::<usize>(),
        draws in proptest::collection::vec(0.0..1.0_f64, 200).prop_map(|draws| draws)) {
        let cut = if climb { Cut::Climb } else { Cut::Conventional };
        let plan = planned(CASES[case], cut, &[]);
        let mut draws = Draws(draws, 0);
        let job = contour_job(&plan, starts(&plan)[0].in_plane(), field(&plan)).unwrap();
        let curves: Vec<Curve> = job.legs.iter().flat_map(|leg| leg.curves.iter().copied()).collect();
        for _ in 0..40 {
            let (leg, index, share) = interruption(&job, &mut draws);
            let first: usize = job.legs[..leg].iter().map(|leg| leg.curves.len()).sum::<usize>() + index;
            let at = reported(&curves[first], share, &mut draws);
            let left = &curves[first..];
            let rest = resume_in_place(&plan, left, 1 + sent % left.len(), at).unwrap();
            // If all sent motions lie elsewhere, none of them moved the tool here: it does not resume in
            // place.
            let near = curves[..first].iter().any(|curve| away_mm(curve, at) < 0.06);
            assert!(near || resume_in_place(&plan, &curves, first, at).is_none());
            let wanted = length_mm(&curves[first..]) - share * length_mm(&curves[first..=first]);
            let got = length_mm(&rest);
            assert!((got - wanted).abs() < 0.02, "{got} for {wanted}");
            let away = rest[0].from().minus(at);
            assert!(away.dx.abs().max(away.dy.abs()) < 1000, "{away:?}");
            certify_path(&plan.part, plan.finishing, &rest).unwrap();
            assert_eq!(rest.last().unwrap().to(), curves.last().unwrap().to());
        }
    }
}
