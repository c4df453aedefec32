//! Our controllers beside those of the paper.

use super::*;

/// Checks every row with an exact model and all sixteen sign patterns of ±5 %.
#[test]
fn contouring_is_better_than_cross_coupling_everywhere() {
    for row in DriveScenario::built_in().unwrap() {
        let row = Row::named(&row.name);
        let ccc = row.contour(Kind::Ccc);
        for signs in sign_patterns() {
            let found = row.figures_off(Kind::Contouring, 0.05, signs).contour.times(UM);
            let (name, both) = (&row.row.name, (found, ccc));
            assert!(found.rms <= ccc.rms, "{name} {signs:?}: RMS {both:?}");
            assert!(found.max <= ccc.max, "{name} {signs:?}: max {both:?}");
            if ["S4", "S4b", "S5"].contains(&name.as_str()) {
                assert!(found.rms <= ccc.rms / 5.0, "{name} {signs:?}: {both:?}");
            }
        }
    }
}

/// The page says so.
#[test]
fn contouring_keeps_more_margin_than_cross_coupling() {
    let machine = DriveProfile::load("koren-lo-table-1").unwrap();
    let ours = peak(&machine, Kind::Contouring, machine.gains).unwrap();
    assert!((ours - 3.3).abs() < 0.05, "{ours}");
    assert_eq!(peak(&machine, Kind::Ccc, machine.gains), None);
    let mut late = PlantModel::ideal(machine.drives(), machine.period_s);
    late.delay_samples = 1;
    let setting = machine.setting(Environment::of_hand(&machine));
    let alone = sensitivity_peak(&late, &mut || Kind::Ccc.built(&setting)).unwrap();
    assert!((alone - 3.2).abs() < 0.05, "{alone}");
}

/// With one sample of delay that the model does not contain, the errors do not grow along the path.
#[test]
#[ignore = "a minute: `.ci/weekly studies`"]
fn contouring_is_stable_with_an_unknown_delay() {
    for row in DriveScenario::built_in().unwrap() {
        let mut row = Row::named(&row.name);
        let prompt = row.contour(Kind::Ccc);
        row.task.plant.delay_samples = 1;
        for (share, most_um) in [(0.05, 100.0), (0.2, 200.0)] {
            for signs in sign_patterns() {
                let mut controller = row.controller(Kind::Contouring, share, signs);
                let run = row.task.run(controller.as_mut());
                let (first, second) = run.in_motion().split_at(run.moving / 2);
                let of = |moments: &[Moment]| {
                    Spread::of(moments.iter().map(|moment| moment.contour_error)).times(UM)
                };
                let (before, after) = (of(first), of(second));
                let wrong = format!("{} {share} {signs:?}: {before:?} {after:?}", row.row.name);
                assert!(after.rms < 2.0 * before.rms.max(prompt.rms), "{wrong}");
                assert!(after.max < most_um, "{wrong}");
            }
        }
    }
}

/// With a known delay of three samples, the contouring controller is more accurate than CCC without delay.
#[test]
fn contouring_compensates_a_known_delay() {
    let mut row = Row::named("S2");
    let ccc = row.contour(Kind::Ccc);
    row.task.plant.delay_samples = 3;
    let mut setting = row.setting(0.0, [0.0; 4]);
    setting.belief.delay_samples = 3;
    let found = row.task.run(Kind::Contouring.built(&setting).unwrap().as_mut()).figures.contour.times(UM);
    assert!(found.rms < ccc.rms && found.max < ccc.max, "{found:?}, without delay CCC {ccc:?}");
}

/// With gamma = 0.7, 0.3 of the axial error remains after one round, and 0.09 after two.
#[test]
fn repetitive_control_removes_seven_tenths_of_the_error_in_each_round() {
    let round = 2500;
    let row = Row::named("S1");
    let path = Path::circle(2000.0, true, 5);
    let feed = TAU * 2000.0 / (f64::from(round) * 0.004);
    let reference = Reference::along(&path, feed, 0.004, Ramp::None).samples;
    let cutting = Some(Cutting { bits: 160.0, at_feed: feed, up_to_feed: feed, angle: 0.7 });
    let task = Task { path, feed, reference, cutting, ..row.task.clone() };
    let mut controller = Repetitive::new(&row.machine.belief(), 1.0, 2500);
    let moments = task.run(&mut controller).moments;
    let axial: Vec<f64> = moments
        .chunks(2500)
        .take(5)
        .map(|round| Spread::of(round.iter().map(|moment| (moment.reference - moment.position).x)).rms)
        .collect();
    // The first round contains the start transient, which does not repeat.
    for pair in axial[1..].windows(2) {
        near(pair[1] / pair[0], 0.3, 0.1, &format!("{axial:?}"));
    }
}

#[test]
fn adaptation_corrects_a_wrong_model() {
    let row = Row::named("S2");
    let wrong = row.figures_off(Kind::Zpetc, 0.05, CROSSED).contour.times(UM);
    let learned = row.figures_off(Kind::AdaptiveZpetc, 0.05, CROSSED).contour.times(UM);
    assert!(learned.rms < wrong.rms / 5.0, "{learned:?} {wrong:?}");
    // "It may be limited": the estimated model does not contain friction.
    let stuck = Row::named("S4b");
    assert!(stuck.contour(Kind::AdaptiveZpetc).rms > stuck.contour(Kind::Ccc).rms * 5.0);
}

#[test]
fn matching_removes_the_error_of_mismatched_loops() {
    let row = Row::named("S3");
    assert!(row.contour(Kind::P).rms > 50.0);
    assert!(row.contour(Kind::Matching).rms < 3.5);
}

#[test]
fn selection_follows_section_8() {
    let choice = |name: &str, error: f64| Environment::of(&Row::named(name).task, error).choice();
    assert_eq!(choice("S1", 0.0), Kind::CccFeedforward);
    assert_eq!(choice("S1", 0.05), Kind::Ccc);
    assert_eq!(choice("S7", 0.0), Kind::Ccc);
    assert_eq!(choice("S6b", 0.0), Kind::Ikf);
    assert_eq!(choice("S6b", 0.02), Kind::Ccc);
    assert_eq!(choice("E1", 0.0), Kind::Ccc);
    let straight = line(PlantModel::ideal([DRIVE; 2], 0.004), Axes::new(100.0, 50.0), 100.0);
    assert_eq!(Environment::of(&straight, 0.02).choice(), Kind::P);
}

/// The integral of the error removes the steady error on a ramp.
///
/// I-PD is an exception: its P acts on the position alone, so the integral needs a lag to compensate it.
#[test]
fn integral_action_leaves_no_steady_error() {
    let feed = Axes::new(800.0, 300.0);
    let task = line(PlantModel::ideal([DRIVE; 2], 0.004), feed * 10.0, feed.norm());
    let row = Row::named("S1");
    let lag = |kind| {
        // Measure before the end of the path is in the window.
        let run = task.run(row.controller(kind, 0.0, [0.0; 4]).as_mut());
        let late = &run.in_motion()[run.moving * 9 / 10];
        (late.reference - late.position).norm()
    };
    let kinds = [Kind::Pid, Kind::StateFeedback, Kind::Lq, Kind::OptimalCcc, Kind::Gpc, Kind::Contouring];
    for kind in kinds {
        assert!(lag(kind) < 0.1, "{kind:?}: {}", lag(kind));
    }
    near(lag(Kind::P), feed.norm() / 10.0, 1e-3, "P");
    let gains = row.machine.gains.pid;
    near(lag(Kind::PidC), feed.norm() * gains.proportional / gains.integral, 0.1, "I-PD");
}

/// The index of optimal CCC contains the contour error, so its contour error is smaller than that of LQ.
#[test]
fn optimal_cross_coupling_leaves_less_contour_error_than_lq() {
    for name in ["S1", "S2", "S3", "S4", "S5"] {
        let row = Row::named(name);
        assert!(row.contour(Kind::OptimalCcc).rms < row.contour(Kind::Lq).rms / 2.0, "{name}");
    }
}

/// At a corner, CCC must use the piece nearest to the tool. With the direction of the interpolator alone, the
/// error is more than 1.4 times as large.
#[test]
fn corner_needs_the_segment_nearest_to_the_tool() {
    #[derive(Debug)]
    struct ByReference {
        law: Law,
    }
    impl Controller for ByReference {
        fn step(&mut self, window: &ReferenceWindow, measured: Axes) -> Axes {
            let foot = &window.ahead(0).foot;
            let ContourError { error, direction } = ContourError::modelled(foot, measured);
            let correction = self.law.step(error);
            foot.point - measured + direction * correction
        }
    }
    let row = Row::named("S6");
    let law = Law::new(row.machine.gains.cross_coupling, row.machine.period_s);
    let found = row.task.run(&mut ByReference { law }).figures.contour.times(UM);
    assert!(found.max > 1.4 * row.contour(Kind::Ccc).max, "{found:?}");
}

/// The corner row of Table 3 uses |U| ≤ 400.
#[test]
fn corner_overshoots_are_graded_with_a_limit() {
    let row = Row::limited("S6", 400.0);
    let overshoot = |kind| row.figures(kind).overshoot * UM;
    assert!(overshoot(Kind::Ccc) <= 40.0, "{}", overshoot(Kind::Ccc));
    assert!(overshoot(Kind::Pid) > 150.0, "{}", overshoot(Kind::Pid));
}

/// The margin of every plan for the simulated machine contains this budget.
#[test]
fn simulated_machine_has_the_contour_error_of_its_drives() {
    let profile = DriveProfile::load("simulated").unwrap();
    let machine = MachineProfile::simulated();
    let interpolator = profile.interpolator.unwrap();
    assert_eq!(interpolator.acceleration_mm_s2, machine.acceleration_mm_s2);
    assert_eq!(interpolator.max_rate_mm_s, machine.max_rate_mm_s);
    let question = BudgetRequest { feed_mm_s: 60.0, by_hand_mm_s: Some(machine.max_rate_mm_s) };
    let found = budget(&profile, &question, &mut |_, _| {}).unwrap();
    // The last digit of a sine depends on the system, and friction amplifies the difference.
    assert!(found.term_mm <= machine.contour_error_mm + 0.000_3, "{}", found.term_mm);
    assert!(found.term_mm >= machine.contour_error_mm * 0.95, "{}", found.term_mm);
    assert_eq!(machine.contour_error_source.details(), found.source);
}
