//! After the start no decision allocates memory, from an operator's input or a reply to the command bytes.

use std::path::Path;

use keepout_executor::supervisor::{Phase, PreparedPlan};
use keepout_planner::depth::DepthParameters;
use keepout_planner::machine::MachineProfile;
use keepout_tests::decisions::Decisions;
use keepout_tests::hostile::{Hostile, Style};
use keepout_tests::{order, plan_of};

#[global_allocator]
static ALLOCATOR: dhat::Alloc = dhat::Alloc;

#[test]
fn decisions_allocate_no_memory_after_the_start() {
    let _profiler = dhat::Profiler::builder().testing().build();
    let drawings = Path::new(env!("CARGO_MANIFEST_DIR")).join("../executor/cli/drawings");
    let flat = plan_of(&drawings.join("bracket.dxf"), &order(6.0)).unwrap();
    let mut request = order(6.0);
    request.job.depth = Some(DepthParameters { step_down_mm: Some(3.0), ..DepthParameters::of(6.0) });
    let cover = std::fs::read(drawings.join("cover.dxf")).unwrap();
    let machine = MachineProfile::simulated_three_axes();
    let deep = request.plan("cover", &cover, &machine, &mut |_| {}).unwrap();
    let works = [flat, deep].map(PreparedPlan::new);
    let mut jogs = 0;
    for (style, work) in Style::ALL.into_iter().flat_map(|style| works.iter().map(move |work| (style, work)))
    {
        let work = work.clone();
        let mut run = Decisions::new(work, Box::new(Hostile::new(style, true, 3))).unwrap();
        while run.phase() == Phase::Starting {
            run.step(|_, take| take());
        }
        let (mut decisions, mut contouring, mut worst) = (0_u64, 0_u64, 0);
        while decisions < 20_000 {
            let phase = run.phase();
            run.step(|cause, take| {
                let before = dhat::HeapStats::get().total_blocks;
                take();
                let blocks = dhat::HeapStats::get().total_blocks - before;
                // Before a contour starts, its planning and certification may allocate memory.
                let starts = matches!(phase, Phase::Touching | Phase::Starting | Phase::Faulted);
                if !starts && blocks > 0 {
                    worst = worst.max(blocks);
                    eprintln!("{style:?}, {phase:?}, {cause:?}: {blocks} blocks");
                }
                decisions += 1;
                contouring += u64::from(phase == Phase::Contouring);
            });
        }
        assert_eq!(worst, 0, "{style:?}");
        jogs += run.supervisor().counts().jogs;
        assert!(run.supervisor().fault().is_none(), "{:?}", run.supervisor().fault());
        eprintln!("{style:?}: {contouring} of {decisions} decisions while contouring");
    }
    assert!(jogs > 1000, "{jogs} jogs in all");
}
