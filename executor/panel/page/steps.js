// What each step shows beside the map.

import { ask, button, make } from "./parts.js";
import { holdButton, thumbPad } from "./steering.js";

const UNITS = ["mm", "inch", "cm", "m"];

/** The contours, each with its state. While a session is steered, a tap on its number crosses to it. */
function contourTable(panel) {
  const { job, texts } = panel;
  const crosses = panel.deep() && job.running === "cut";
  const rows = job.contours.map(({ number, name, state }) => make("tr", {},
    make("td", {}, crosses ? button(`${texts.cross} ${number}`, () => panel.link.command({ cross: { contour: number } }))
      : String(number)),
    make("td", {}, name), make("td", { class: state }, texts.state[state])));
  return make("div", { class: "card" }, make("table", {}, ...rows));
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
    return [drop, open.length ? make("div", { class: "card" }, make("p", {}, texts.open_job), make("div", { class: "row" }, ...open))
      : null];
  }
  const units = UNITS.map((unit) => button(unit, () => panel.ask({ type: "unit", unit })));
  return [
    make("div", { class: "card" }, make("b", {}, job.name), make("div", {}, job.size_mm
      ? `${texts.size}: ${job.size_mm.map((side) => side.toFixed(2)).join(" × ")} mm` : "")),
    make("div", { class: "card" }, make("small", {}, texts.unit), make("div", { class: "row" }, ...units)),
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
    make("label", { class: "card" }, make("small", {}, texts.machine), machine),
    make("label", { class: "card" }, make("small", {}, texts.tool), tool),
    button(texts.plan, () => panel.ask({ type: "plan", tool_um: Math.round(tool.valueAsNumber * 1000) }), { class: "main" }),
    contourTable(panel), figures(panel),
    make("div", { class: "row" }, button(texts.back, () => panel.go("drawing")),
      button(texts.next, () => panel.go("place"), { disabled: job.figures.length === 0 })),
  ];
}

function placeStep(panel) {
  const { job, texts } = panel;
  const [touches, taken] = job.touches;
  const touch = touches[taken];
  const begin = (kind) => panel.begin(kind);
  if (job.running === "touch") {
    return [
      make("div", { class: "card" }, make("b", {}, texts.nothing_protected)),
      touch ? make("div", { class: "card" }, `${taken + 1} / ${touches.length}: ${touch.words} ○`) : null,
      ...steeringCards(panel),
    ];
  }
  if (job.running) return steeringCards(panel);
  return [
    make("div", { class: "card" }, make("p", {}, texts.touches),
      button(texts.begin_touch, () => begin("touch"), { class: "main" })),
    make("div", { class: "card row" }, button(texts.dry, () => begin("dry_run"), { disabled: !job.aligned }),
      button(texts.cut, () => begin("cut"), { disabled: !job.aligned })),
    figures(panel),
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

/** What stands beside the map. */
export function side(panel) {
  if (panel.job.running && panel.job.running !== "touch") return steeringCards(panel);
  return { drawing: drawingStep, tool: toolStep, place: placeStep, rough: placeStep, finish: placeStep, report: reportStep }[panel.step](panel);
}

/** Begins a session, after the person has read what moves. */
export function beginDialog(panel, kind) {
  const { texts } = panel;
  const dialog = document.getElementById("dialog");
  const start = (home) => {
    dialog.close();
    panel.ask({ type: "begin", kind, home });
  };
  dialog.replaceChildren(make("p", {}, texts.raise_first), make("div", { class: "row" },
    button(texts.home, () => start(true), { class: "main" }), button(texts.homed, () => start(false)),
    button(texts.back, () => dialog.close())));
  dialog.showModal();
}
