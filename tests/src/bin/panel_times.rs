//! Measures what the panel costs: the time from a browser's input to the command at the port, and the times of
//! decisions with and without a panel.
//!
//! `cargo run --release -p keepout-tests --bin panel_times`

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, Instant};

use clap::Parser;
use keepout_executor::operator::Operator as _;
use keepout_executor::session::port::{Port, PortError};
use keepout_executor::session::{Going, NoEventLog, RealClock};
use keepout_executor::supervisor::{Phase, PreparedPlan};
use keepout_guard::Time;
use keepout_panel::bench::{BenchRequest, Document, DocumentName, JobView, MapView, SessionWords, Workbench};
use keepout_panel::hub::Hub;
use keepout_panel::server::{Listener, PanelSite};
use keepout_planner::plan::CertifiedPlan;
use keepout_sim::operator::{Model, ModelKind};
use keepout_sim::session::{Scene, SimRun};
use keepout_sim::{SimMachine, VirtualPort};
use keepout_tests::decisions::{Cause, Decisions};
use keepout_tests::histogram::Histogram;
use keepout_tests::{order, plan_bytes};
use tungstenite::client::IntoClientRequest as _;
use tungstenite::{Message, WebSocket};

/// Measures what the panel costs.
#[derive(Debug, Parser)]
struct Arguments {
    /// Inputs that are measured from the browser to the port.
    #[arg(long, default_value_t = 500)]
    inputs: usize,
    /// Time from the rest of the tool to the next input, ms.
    #[arg(long, default_value_t = 0)]
    settle_ms: u64,
    /// Decisions with a panel, and as many without.
    #[arg(long, default_value_t = 1_000_000)]
    decisions: u64,
    /// Browsers that watch and send while decisions are measured.
    #[arg(long, default_value_t = 3)]
    browsers: usize,
}

type Outcome<T> = Result<T, Box<dyn std::error::Error>>;

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    match latency(&arguments).and_then(|()| decisions(&arguments)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("panel_times: {error}");
            ExitCode::FAILURE
        }
    }
}

/// A workbench without a job.
struct NoJob;

impl Workbench for NoJob {
    fn job(&self) -> JobView {
        JobView::default()
    }

    fn map(&self) -> MapView {
        MapView::default()
    }

    fn revision(&self) -> u64 {
        1
    }

    fn ask(&self, _: BenchRequest) -> Result<(), String> {
        Ok(())
    }

    fn drawing(&self, _: &str, _: &[u8]) -> Result<(), String> {
        Ok(())
    }

    fn document(&self, _: DocumentName) -> Option<Document> {
        None
    }

    fn words(&self) -> SessionWords {
        SessionWords::default()
    }
}

/// A panel that serves at a port of the loopback.
struct Served {
    at: SocketAddr,
    cookie: String,
    hub: Hub,
}

impl Served {
    fn new() -> Outcome<Self> {
        let listener = Listener::bind(SocketAddr::from(([127, 0, 0, 1], 0)))?;
        let (at, hub) = (listener.at, Hub::default());
        let site = PanelSite::new(hub.clone(), Arc::new(NoJob), at)?;
        let token = site.token().unwrap_or_default();
        std::thread::spawn(move || listener.serve(site));
        let body = format!("{{\"token\":\"{token}\"}}");
        let mut socket = TcpStream::connect(at)?;
        write!(
            socket,
            "POST /api/enter HTTP/1.1\r\nHost: {at}\r\nOrigin: http://{at}\r\nContent-Type: application/json\r\n\
             Connection: close\r\nContent-Length: {}\r\n\r\n{body}",
            body.len()
        )?;
        let mut answer = String::new();
        socket.read_to_string(&mut answer)?;
        let cookie = answer.split("set-cookie: ").nth(1).and_then(|rest| rest.split(';').next());
        Ok(Self { at, cookie: cookie.ok_or("the panel admits nobody")?.into(), hub })
    }

    fn browser(&self) -> Outcome<Browser> {
        let mut request = format!("ws://{}/api/socket", self.at).into_client_request()?;
        request.headers_mut().insert("Cookie", self.cookie.parse()?);
        request.headers_mut().insert("Origin", format!("http://{}", self.at).parse()?);
        let stream = TcpStream::connect(self.at)?;
        stream.set_nodelay(true)?;
        let (socket, _) = tungstenite::client(request, stream).map_err(|error| error.to_string())?;
        Ok(Browser { socket, sequence: 0, seen_us: 0 })
    }
}

/// A browser's socket.
struct Browser {
    socket: WebSocket<TcpStream>,
    sequence: u64,
    seen_us: u64,
}

impl Browser {
    /// Takes the next state, and returns its text.
    fn state(&mut self) -> Outcome<String> {
        loop {
            let Message::Text(text) = self.socket.read()? else { continue };
            let value: serde_json::Value = serde_json::from_str(&text)?;
            if let Some(now) = value["now_us"].as_u64() {
                self.seen_us = now;
                return Ok(text.to_string());
            }
        }
    }

    fn steer(&mut self, held: bool, x: f64) -> Outcome<()> {
        self.sequence += 1;
        let text = format!(
            "{{\"type\":\"steer\",\"order\":{{\"sequence\":{},\"seen_us\":{}}},\"steer\":{{\"held\":{held},\
             \"velocity\":[{x},0]}}}}",
            self.sequence, self.seen_us
        );
        Ok(self.socket.send(Message::text(text))?)
    }
}

/// A port that tells when a jog is written.
struct Stamped {
    port: VirtualPort,
    jogs: Sender<Instant>,
}

impl Port for Stamped {
    fn write(&mut self, bytes: &[u8], now: Time) -> Result<(), PortError> {
        if bytes.starts_with(b"$J=") {
            let _ = self.jogs.send(Instant::now());
        }
        self.port.write(bytes, now)
    }

    fn read(&mut self, into: &mut Vec<u8>, now: Time) -> Result<(), PortError> {
        self.port.read(into, now)
    }

    fn next_event(&self) -> Time {
        self.port.next_event()
    }
}

/// The plan of a plate.
fn plan() -> Outcome<CertifiedPlan> {
    let drawing = include_bytes!("../../drawings/rounded_plate.dxf");
    Ok(plan_bytes("rounded_plate", drawing, &order(6.0))?)
}

/// Measures from the browser's input to the command at the port, in real time.
fn latency(arguments: &Arguments) -> Outcome<()> {
    let served = Served::new()?;
    let work = PreparedPlan::new(plan()?);
    let run = SimRun { machine: work.plan.plan.machine.clone(), servo: None, ..SimRun::default() };
    let scene = Scene::of(work, &run)?;
    let machine: SimMachine = scene.machine(&run);
    let (jogs, jogged) = channel();
    let over = Arc::new(AtomicBool::new(false));
    let (hub, halted) = (served.hub.clone(), Arc::clone(&over));
    let session = std::thread::spawn(move || {
        let port = Stamped { port: VirtualPort { machine }, jogs };
        let mut session = scene.setup.session(port, Box::new(hub.operator()), Box::new(NoEventLog));
        let mut window = hub.window();
        let _ = session.run(&mut RealClock::default(), Duration::from_secs(3600), |session, _| {
            window.show(session.supervisor());
            if halted.load(Ordering::Relaxed) { Going::Halt } else { Going::On }
        });
    });
    let measured = presses(&served, arguments, &jogged);
    over.store(true, Ordering::Relaxed);
    session.join().map_err(|_| "the session failed")?;
    println!(
        "{}\n{}\n",
        Histogram::heading("from the browser's input to"),
        measured?.row("the command at the port")
    );
    Ok(())
}

/// Presses and lets go, and counts the times to the first jog.
fn presses(served: &Served, arguments: &Arguments, jogged: &Receiver<Instant>) -> Outcome<Histogram> {
    let mut browser = served.browser()?;
    let mut times = Histogram::default();
    let mut random = fastrand::Rng::with_seed(7);
    let rests = |text: &str| text.contains("\"phase\":\"manual\"") && text.contains("\"rests\":true");
    for number in 0..arguments.inputs {
        while !rests(&browser.state()?) {}
        // A state that waits in the socket would be an old one.
        let until = Instant::now() + Duration::from_millis(arguments.settle_ms);
        while Instant::now() < until {
            browser.state()?;
        }
        std::thread::sleep(Duration::from_micros(random.u64(0..40_000)));
        while jogged.try_recv().is_ok() {}
        browser.steer(false, 0.0)?;
        let begun = Instant::now();
        browser.steer(true, if number % 2 == 0 { -0.1 } else { 0.1 })?;
        let jog = jogged.recv_timeout(Duration::from_secs(5)).map_err(|_| "the input moved nothing")?;
        times.add(u64::try_from(jog.duration_since(begun).as_nanos())?);
        browser.steer(false, 0.0)?;
    }
    Ok(times)
}

/// Decisions of the same sessions with and without a panel, in turns.
fn decisions(arguments: &Arguments) -> Outcome<()> {
    let served = Served::new()?;
    let over = Arc::new(AtomicBool::new(false));
    let mut crowd = Vec::new();
    for _ in 0..arguments.browsers {
        let mut browser = served.browser()?;
        let over = Arc::clone(&over);
        crowd.push(std::thread::spawn(move || {
            let mut held = false;
            while !over.load(Ordering::Relaxed) && browser.state().is_ok() {
                held = !held;
                if browser.steer(held, 0.5).is_err() {
                    break;
                }
            }
        }));
    }
    let work = PreparedPlan::new(plan()?);
    let (mut without, mut with, mut panel) =
        (Histogram::default(), Histogram::default(), Histogram::default());
    let block = arguments.decisions / 20 + 1;
    for seed in 0..20 {
        measure(&work, seed, block, None, &mut without)?;
        measure(&work, seed, block, Some((&served.hub, &mut panel)), &mut with)?;
    }
    over.store(true, Ordering::Relaxed);
    crowd.into_iter().for_each(|browser| _ = browser.join());
    println!("{}", Histogram::heading("decisions"));
    println!("{}", without.row("without a panel"));
    println!("{}", with.row(&format!("with a panel and {} browsers", arguments.browsers)));
    println!("{}", panel.row("what the panel adds to a round"));
    println!(
        "with to without: {:.2} in the p50, {:.2} in the p99.9",
        with.quantile(1, 2) / without.quantile(1, 2),
        with.quantile(999, 1000) / without.quantile(999, 1000)
    );
    Ok(())
}

/// Times so many decisions of a session. With a hub, the session also asks it for the input and shows its state, as
/// the panel's session does after every round.
fn measure(
    work: &PreparedPlan,
    seed: u64,
    count: u64,
    mut panel: Option<(&Hub, &mut Histogram)>,
    times: &mut Histogram,
) -> Outcome<()> {
    let ns = |began: Instant| u64::try_from(began.elapsed().as_nanos()).unwrap_or(u64::MAX);
    let mut run = Decisions::new(work.clone(), Box::new(Model::new(ModelKind::Wall, 1e6, seed)))?;
    let mut sides = panel.as_ref().map(|(hub, _)| (hub.operator(), hub.window()));
    let mut taken = 0;
    while taken < count {
        let phase = run.phase();
        let view = run.view();
        run.step(|cause, take| {
            let began = Instant::now();
            take();
            let took = ns(began);
            if phase != Phase::Starting {
                times.add(took);
                taken += 1;
            }
            if let (Cause::OperatorInput, Some((operator, _)), Some((_, costs))) =
                (cause, sides.as_mut(), panel.as_mut())
            {
                let began = Instant::now();
                let _ = operator.input(&view, Time::ZERO);
                let _ = operator.command();
                costs.add(ns(began));
            }
        });
        if let (Some((_, window)), Some((_, costs))) = (sides.as_mut(), panel.as_mut()) {
            let began = Instant::now();
            window.show(run.supervisor());
            costs.add(ns(began));
        }
    }
    Ok(())
}
