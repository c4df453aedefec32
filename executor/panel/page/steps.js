// What each step shows beside the map.

import { ask, button, dialogOf, make, minutes } from "./parts.js";
import { holdButton, thumbPad } from "./steering.js";
import { filled } from "./texts.js";

const UNITS = ["mm", "inch", "cm", "m"];
/** Feed overrides, per cent. */
const FEEDS = [25, 50, 75, 100];

/** The contours, each with its state; a tap marks it on the map. While a session is steered, a button crosses to it. */
function contourTable(panel) {
  const { job, texts, map } = panel;
  const crosses = panel.deep() && job.running === "cut" && !panel.finishes();
  const next = job.contours.find(({ state, opens }) => opens && (state === "to_do" || state === "begun"))?.number;
  const cross = (number) => button(`${texts.cross} ${number}`,
    () => panel.link.command({ cross: { contour: number } }), { class: number === next ? "main" : "" });
  const mark = (number) => { map.choose(number === map.chosen ? null : number); panel.show(); };
  const rows = job.contours.map(({ number, name, state, opens }) => make("tr", { class: number === map.chosen ? "marked" : "" },
    make("td", {}, crosses && opens ? cross(number) : String(number)),
    make("td", { onclick: () => mark(number) }, name), make("td", { class: state }, texts.state[state])));
  return make("div", { class: "card" }, make("small", { id: "tally" }), make("table", {}, ...rows));
}

/** What a person wants to know of the plan. */
function planCard(panel) {
  const { job: { plan, tool_mm: tool }, texts } = panel;
  if (!plan) return null;
  const rows = plan.terms.map(([name, size]) => make("tr", {}, make("td", {}, name), make("td", {}, `${size.toFixed(4)} mm`)));
  const fits = plan.fits_mm?.toFixed(2);
  const short = filled(fits ? texts.fits : texts.fits_none, { tool, count: plan.short, fits });
  return make("div", { class: "card" },
    plan.short ? make("p", { class: "warning" }, short, " ",
      fits ? button(`Ø ${fits} mm`, () => panel.ask({ type: "plan", tool_um: Math.round(plan.fits_mm * 1000) })) : null) : null,
    make("div", {}, `≈ ${minutes(plan.minutes)} ${texts.minutes}`),
    make("details", {}, make("summary", {}, `${texts.margin}: ${plan.margin_mm.toFixed(4)} mm`), make("table", {}, ...rows)));
}

function figures(panel) {
  const rows = panel.job.figures.map(([name, value]) => make("tr", {}, make("td", {}, name), make("td", {}, value)));
  return rows.length ? make("details", { class: "card" }, make("summary", {}, panel.texts.figures), make("table", {}, ...rows))
    : null;
}

function drawingStep(panel) {
  const { job, texts } = panel;
  const upload = async (file) => {
    await panel.doing(() => ask(`/api/drawing?name=${encodeURIComponent(file.name)}`, { method: "PUT", body: file }));
  };
  const input = make("input", { type: "file", accept: ".dxf", onchange: () => { if (input.files[0]) upload(input.files[0]); } });
  const drop = make("label", { class: "drop card" }, texts.drop, input);
  drop.addEventListener("dragover", (event) => event.preventDefault());
  drop.addEventListener("drop", (event) => {
    event.preventDefault();
    if (event.dataTransfer.files[0]) upload(event.dataTransfer.files[0]);
  });
  if (!job.name) {
    const open = job.jobs.map((name) => button(name, () => panel.ask({ type: "open", name })));
    return [drop, make("div", { class: "row" }, button(texts.another, () => inviteDialog(panel))), open.length ? make("div", { class: "card" }, make("p", {}, texts.open_job), make("div", { class: "row" }, ...open))
      : null];
  }
  const units = UNITS.map((unit) => button(unit, () => panel.ask({ type: "unit", unit })));
  return [
    make("div", { class: "card" }, make("b", {}, job.name), make("div", {}, job.size_mm
      ? `${texts.size}: ${job.size_mm.map((side) => side.toFixed(2)).join(" × ")} mm` : "")),
    make("div", { class: "card" }, make("small", {}, texts.unit), make("div", { class: "row" }, ...units)),
    make("div", { class: "card row" }, ...[false, true].map((inside) => button(inside ? texts.inside : texts.outside,
      () => panel.ask({ type: "side", inside }), { class: inside === job.inside ? "chosen" : "" }))),
    contourTable(panel),
    make("div", { class: "row" }, button(texts.close, () => panel.ask({ type: "close" })),
      button(texts.this_is_it, () => panel.go("tool"), { class: "main", disabled: job.pins.some((pin) => pin.remedy) })),
  ];
}

function toolStep(panel) {
  const { job, texts } = panel;
  const machine = make("select", { onchange: () => panel.ask({ type: "machine", name: machine.value }) },
    ...job.machines.map((name) => make("option", { value: name, selected: name === job.machine }, name)));
  const tool = make("input", { type: "number", inputMode: "decimal", min: 0.1, max: 100, step: 0.01, value: job.tool_mm ?? 6 });
  return [
    make("div", { class: "card row" }, make("label", {}, make("small", {}, texts.machine), machine),
      button(texts.new_machine, () => machineDialog(panel))),
    make("label", { class: "card" }, make("small", {}, texts.tool), tool),
    button(texts.plan, () => panel.ask({ type: "plan", tool_um: Math.round(tool.valueAsNumber * 1000) }),
      { class: job.plan ? "" : "main" }),
    planCard(panel), contourTable(panel), figures(panel),
    make("div", { class: "row" }, button(texts.back, () => panel.go("drawing")),
      button(texts.next, () => panel.go("place"), { disabled: !job.plan, class: job.plan ? "main" : "" })),
  ];
}

function placeStep(panel) {
  const { job, texts } = panel;
  const [touches, taken] = job.touches;
  const touch = touches[taken];
  const begin = (kind) => panel.begin(kind);
  if (job.running === "touch") {
    return [
      make("div", { class: "card" }, make("b", {}, texts.nothing_protected), make("div", {}, texts.touch_hint)),
      touch ? make("div", { class: "card" }, `${taken + 1} / ${touches.length}: ${touch.words} ○`) : null,
      ...steeringCards(panel),
    ];
  }
  if (job.running) return steeringCards(panel);
  return [
    make("div", { class: "card" }, make("p", {}, texts.touches),
      button(texts.begin_touch, () => begin("touch"), { class: job.aligned ? "" : "main" })),
    make("div", { class: "card row" }, button(texts.dry, () => begin("dry_run"), { disabled: !job.aligned }),
      button(texts.cut, () => begin("cut"), { disabled: !job.aligned, class: job.aligned ? "main" : "" })),
    contourTable(panel), figures(panel),
    button(texts.back, () => panel.go("tool")),
  ];
}

/** Coordinates, steps, speed and the pad. */
function steeringCards(panel) {
  const { texts, steering } = panel;
  const axis = (name, id, unit) => [make("span", {}, name), make("b", { id }, "—"), make("span", {}, unit)];
  const choice = (values, chosen, text, take) => make("div", { class: "row" }, ...values.map((value) =>
    button(text(value), () => { take(value); panel.show(); }, { class: value === chosen ? "chosen" : "" })));
  const pad = make("div", { id: "pad", role: "application" });
  pad.setAttribute("aria-label", texts.phase.manual[1]);
  thumbPad(pad, steering);
  const lift = (sign, up) => {
    const made = button(sign, () => {});
    holdButton(made, steering, up);
    return made;
  };
  const spindle = panel.state?.session?.spindle;
  const deep = panel.deep();
  return [
    make("div", { class: "card axes" }, ...axis("X", "x", "mm"), ...axis("Y", "y", "mm"),
      ...(deep ? axis("Z", "z", "mm") : []), ...(panel.job.running === "touch" ? [] : axis("↔", "wall", texts.wall))),
    make("div", { class: "card steer" }, pad, deep ? make("div", { class: "lifts" }, lift("↑", 1), lift("↓", -1),
      panel.job.running === "touch" ? null : button(texts.raise, () => panel.link.command("raise"))) : null),
    make("div", { class: "card" }, make("small", {}, texts.step_size),
      choice([0, 0.01, 0.1, 1], steering.step, (mm) => (mm === 0 ? texts.stick : `${mm}`), (mm) => { steering.step = mm; }),
      make("small", {}, texts.speed),
      choice([0.05, 0.2, 0.5, 1], steering.speed, (share) => `${share * 100} %`, (share) => { steering.speed = share; })),
    deep ? make("div", { class: "card row" },
      button(spindle ? texts.spindle_on : texts.spindle_off, () => panel.link.command({ spindle: { runs: !spindle } }))) : null,
    panel.job.running === "cut" ? make("div", { class: "card" }, texts.rough_hint) : null,
    panel.job.running === "cut" ? contourTable(panel) : null,
  ];
}

function reportStep(panel) {
  const { job, texts } = panel;
  const frame = make("iframe", { src: "/api/document/report", title: texts.report });
  return [
    job.reported ? frame : null,
    make("div", { class: "row" }, button(texts.print, () => frame.contentWindow.print(), { class: "main" }),
      button(texts.next_part, () => panel.ask({ type: "next_part" }))),
  ];
}

/** The contour that is cut by itself. */
function finishCards(panel) {
  const { job, texts, state } = panel;
  const feed = (percent) => button(`${percent} %`, () => panel.link.command({ feed: { percent } }),
    { value: percent, class: percent === state.session.feed_percent ? "chosen" : "" });
  return [
    make("div", { class: "card progress" }, make("b", { id: "percent" }), make("span", { id: "left" })),
    make("div", { class: "card" }, make("small", {}, texts.feed),
      make("div", { class: "row", id: "feed" }, ...FEEDS.map(feed))),
    ...steeringCards(panel).slice(0, 1),
    job.running === "cut" ? contourTable(panel) : null,
  ];
}

/** What stands beside the map. */
export function side(panel) {
  if (panel.job.running && panel.finishes()) return finishCards(panel);
  if (panel.job.running && panel.job.running !== "touch") return steeringCards(panel);
  return { drawing: drawingStep, tool: toolStep, place: placeStep, rough: placeStep, finish: placeStep, report: reportStep }[panel.step](panel);
}

/** Asks for what a controller does not state of its machine. */
function machineDialog(panel) {
  const { texts, job } = panel;
  const dialog = dialogOf();
  const choice = (values) => make("select", {}, ...values.map((value) => make("option", { value }, value)));
  const number = (value, step) => make("input", { type: "number", inputMode: "decimal", min: 0, step, value });
  const fields = {
    name: make("input", { value: "mill", autocomplete: "off" }),
    port: make("input", { value: job.ports[0] ?? "/dev/ttyUSB0", autocomplete: "off" }),
    dialect: choice(job.dialects), baud: number(115200, 1), repeatability: number(0.01, 0.001),
    contour_error: number(0.05, 0.001), third_axis: make("input", { type: "checkbox" }),
  };
  const ports = job.ports.map((name) => button(name, () => { fields.port.value = name; }));
  const um = (field) => Math.round(field.valueAsNumber * 1000);
  const store = async () => {
    dialog.close();
    await panel.ask({ type: "new_machine", name: fields.name.value.trim(), port: fields.port.value.trim(),
      dialect: fields.dialect.value, baud: fields.baud.valueAsNumber, repeatability_um: um(fields.repeatability),
      contour_error_um: um(fields.contour_error), third_axis: fields.third_axis.checked });
  };
  const rows = Object.entries(fields).map(([name, field]) => make("label", { class: "question" },
    make("span", {}, texts.machine_questions[name]), field));
  dialog.replaceChildren(...rows, make("div", { class: "row" }, ...ports), make("div", { class: "row" },
    button(texts.store_machine, store, { class: "main" }), button(texts.back, () => dialog.close())));
  dialog.showModal();
}

/** Shows the address for another screen, with its code. */
async function inviteDialog(panel) {
  const { texts } = panel;
  const dialog = dialogOf();
  await panel.doing(async () => {
    const { address, svg } = await ask("/api/invite", { method: "POST" });
    const code = make("img", { alt: "QR", class: "code", src: `data:image/svg+xml,${encodeURIComponent(svg ?? "")}` });
    const local = ["127.0.0.1", "localhost"].includes(location.hostname) ? make("p", {}, texts.local_only) : "";
    dialog.replaceChildren(make("p", {}, texts.invite), local, svg ? code : "", make("p", { class: "address" }, address),
      button(texts.close_it, () => dialog.close(), { class: "main" }));
    dialog.showModal();
  });
}

/** Begins a session, after the person has read what moves. */
export function beginDialog(panel, kind) {
  const { texts, job } = panel;
  const dialog = dialogOf();
  const start = (home) => {
    dialog.close();
    panel.ask({ type: "begin", kind, home });
  };
  dialog.replaceChildren(
    make("p", {}, make("b", {}, filled(texts.machine_moves, { machine: job.machine, tool: job.tool_mm ?? "?" }))),
    make("p", {}, texts.raise_first), make("p", {}, texts.keep_clear),
    make("div", { class: "row" }, button(texts.home, () => start(true), { class: "main" }),
      button(texts.homed, () => start(false)), button(texts.back, () => dialog.close())));
  dialog.showModal();
}
