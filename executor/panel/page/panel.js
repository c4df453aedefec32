// The page: it shows the job, the map and the session, and asks for what the person wants.

import { DEAD_MS, Link } from "./link.js";
import { PartMap } from "./map.js";
import { ask, button, dialogOf, make, minutes, mm, request, stayAwake } from "./parts.js";
import { Steering } from "./steering.js";
import { beginDialog, side } from "./steps.js";
import { LANGUAGES, texts } from "./texts.js";

/** Phases in which the machine finishes by itself. */
const FINISHING = ["touching", "contouring", "holding"];
const STEPS = ["drawing", "tool", "place", "rough", "finish", "report"];
/** Time for which the arming button is held, ms. */
const ARMS_AFTER_MS = 1000;
/** Time for which a notice is shown, ms. */
const NOTICE_MS = 6000;
const TONES = { sliding: "alert", touching: "alert", contouring: "calm", holding: "alert", retracting: "alert",
  faulted: "alarm", manual: "calm" };

const at = (id) => document.getElementById(id);

class Panel {
  constructor() {
    this.texts = texts();
    this.job = null;
    this.state = null;
    this.step = "drawing";
    this.revision = -1;
    this.map = new PartMap(/** @type {HTMLCanvasElement} */ (at("map")));
    this.watchPresses();
    this.link = new Link((state) => this.take(state), (reason) => this.tell(reason, NOTICE_MS));
    this.steering = new Steering(this.link);
    this.steering.mayKeys = () => this.job?.running && !dialogOf().open;
    at("map-tools").append(button("−", () => this.map.zoomBy(1 / 1.4)), button("+", () => this.map.zoomBy(1.4)),
      button(this.texts.fit, () => this.map.fit(true)),
      button(this.texts.hull, () => { this.map.showHull = !this.map.showHull; this.map.ask(); }), this.depthButton());
    this.map.onChosen = () => this.show();
    setInterval(() => this.showState(), 100);
    setInterval(() => this.link.send({ type: "alive" }), 500);
    addEventListener("keydown", (event) => {
      if (event.key === " " && this.job?.running && !dialogOf().open) {
        event.preventDefault();
        this.stop();
      }
    });
    stayAwake();
  }

  /** Whether a finger is on a control of a part of the page: what is built again under it would lose it. */
  waits(id) {
    const waits = this.pressed !== null && at(id).contains(this.pressed);
    this.later ||= waits;
    return waits;
  }

  /** Remembers the button under a finger until its click is done. */
  watchPresses() {
    this.pressed = null;
    this.later = false;
    addEventListener("pointerdown", (event) => { this.pressed = event.target instanceof Element ? event.target.closest("button, #pad") : null; }, true);
    for (const name of ["pointerup", "pointercancel"]) {
      addEventListener(name, () => setTimeout(() => {
        this.pressed = null;
        if (this.later) { this.later = false; this.show(); }
      }), true);
    }
  }

  /** Shows one depth after another on the map. */
  depthButton() {
    const made = button(this.texts.depth_all, () => {
      const depth = this.map.nextDepth();
      made.textContent = depth === null ? this.texts.depth_all : `${depth.toFixed(2)} mm`;
    }, { id: "depth", hidden: true });
    return made;
  }

  deep() { return (this.state?.session?.height_mm ?? null) !== null; }

  /** Takes a state of the server. */
  async take(state) {
    this.state = state;
    const session = state.session;
    const kind = ["manual", "sliding"].includes(session?.phase) ? "steered" : session?.phase;
    // What was said of a phase is not true of the next one.
    if (kind !== this.kind) this.notice = { text: this.notice?.text, until: 0 };
    this.kind = kind;
    const notice = session?.notices[session.notices.length - 1];
    if (notice && notice !== this.notice?.text) this.notice = { text: notice, until: performance.now() + NOTICE_MS };
    const [dx, dy] = this.job?.shift_mm ?? [0, 0];
    const shift = ([x, y]) => [x - dx, y - dy];
    this.map.move(session?.position_mm ? shift(session.position_mm) : null, (session?.hull_mm ?? []).map(shift), this.finishes());
    if (!session || ["contouring", "touching"].includes(session.phase)) this.steering.armed = false;
    if (state.revision !== this.revision && !this.reading) {
      this.reading = true;
      this.revision = state.revision;
      try { await this.read(); } finally { this.reading = false; }
    }
    this.showContour(session);
    // The pad is built again only when what it offers changes, so that a finger on it stays.
    const offers = JSON.stringify([this.deep(), session?.spindle, Boolean(session), this.finishes()]);
    const control = JSON.stringify([state.control, kind, session?.armed, session?.interrupted && session?.rests]);
    if (state.control.holder === "mine" && this.holder !== "mine") this.link.onOpened();
    this.holder = state.control.holder;
    if (offers !== this.offers) {
      this.offers = offers;
      this.steering.letGo();
      this.pressed = null;
      this.show();
    } else if (control !== this.control) this.bar();
    this.control = control;
  }

  /** How far the contour is, on the page beside the map. */
  showContour(session) {
    if (!session) return;
    const set = (id, text) => { if (at(id)) at(id).textContent = text; };
    set("percent", `${Math.floor((session.share ?? 0) * 100)} %`);
    set("left", session.left_s === null ? "" : `${this.texts.left} ${minutes(session.left_s / 60)} ${this.texts.min}`);
    set("tally", this.tally());
    for (const one of document.querySelectorAll("#feed button")) {
      one.classList.toggle("chosen", one.getAttribute("value") === String(session.feed_percent));
    }
  }

  /** How many contours are cut. */
  tally() {
    const { contours } = this.job;
    const cut = contours.filter(({ state }) => state === "cut").length;
    return `${this.texts.contours}: ${cut} / ${contours.length} ${this.texts.state.cut}`;
  }

  /** Reads the job and the map again. */
  async read() {
    const before = this.job;
    this.job = await ask("/api/job");
    this.map.take(await ask("/api/map"));
    at("depth").hidden = this.map.depths.length < 2;
    at("depth").textContent = this.texts.depth_all;
    this.map.states = new Map(this.job.contours.map(({ number, state }) => [number, state]));
    const [touches, taken] = this.job.touches;
    this.map.touch = this.job.running === "touch" ? touches[taken]?.at_mm ?? null : null;
    if (!before || before.step !== this.job.step || before.name !== this.job.name) this.step = this.job.step;
    if (this.job.message) this.tell(this.job.message);
    this.show();
  }

  /** Whether the machine finishes by itself. */
  finishes() { return FINISHING.includes(this.state?.session?.phase); }

  go(step) {
    this.step = step;
    this.show();
  }

  show() {
    if (!this.job) return;
    const finishes = this.job.running === "cut" && this.finishes();
    const due = STEPS.indexOf(finishes ? "finish" : this.step);
    const open = STEPS.indexOf(this.job.step);
    at("steps").replaceChildren(...STEPS.map((step, index) => {
      const name = index === due ? "due" : index < due ? "done" : "";
      const text = `${index + 1} ${this.texts.step[index]}`;
      // Between sessions, every step that was reached can be opened again.
      if (this.job.running || !this.job.name || index > open) return make("span", { class: name }, text);
      return button(text, () => this.go(step), { class: name });
    }));
    if (!this.waits("side")) at("side").replaceChildren(...side(this).filter((part) => part));
    at("pins").replaceChildren(...this.job.pins.map((pin) => make("div", {}, make("span", {}, pin.text),
      pin.remedy ? button(pin.remedy.text, () => this.ask(pin.remedy.request)) : null)));
    this.bar();
    this.showState();
  }

  /** The row of large buttons. */
  bar() {
    const { texts: words, state, job } = this;
    if (!job || !state || this.waits("bar")) return;
    const parts = [];
    const session = state.session;
    if (job.running) {
      // It acts when it is touched, and not when it is let go.
      parts.push(button("", () => {}, { class: "hold", onpointerdown: () => this.stop() }));
      parts[0].append(words.hold, make("small", {}, words.hold_note));
      if (state.control.holder === "mine") {
        parts.push(this.actionButton(session?.phase));
        parts.push(button(words.end, () => this.ask({ type: "end" }), { class: this.isAllDone() ? "main" : "" }));
      }
    }
    const holder = state.control.holder;
    if (holder === "mine" && !job.running) parts.push(make("span"));
    else if (holder === "mine") parts.push(button(words.give, () => this.link.send({ type: "give_control" })));
    else parts.push(button(words.take, () => this.link.send({ type: "take_control" }), { class: "main" }));
    at("bar").replaceChildren(...parts);
    if (holder === "mine" && state.control.asked) this.consent();
  }

  /** The button of the phase. Its place stays empty without one, so that the others stay where they are. */
  actionButton(phase) {
    const { texts: words, job, state } = this;
    const main = { class: "main" };
    if (phase === "holding") return button(words.go_on, () => this.link.command("cycle_start"), main);
    if (phase === "faulted") return button(words.recover, () => this.link.command("recover"), main);
    const steered = ["manual", "sliding"].includes(phase);
    if (state.session?.interrupted && (steered || phase === "retracting")) return button(words.finish_it, () => this.link.command("cycle_start"), { ...main, disabled: !state.session.rests });
    if (!steered || this.isAllDone()) return make("span");
    return job.running === "touch" ? button(words.take_place, () => this.ask({ type: "take" }), main) : this.armButton();
  }

  /** Whether the session has nothing left: all places are taken, or all contours cut. */
  isAllDone() {
    const { job } = this;
    const [touches, taken] = job.touches;
    return job.running === "touch" ? taken >= touches.length
      : job.running === "cut" && job.contours.every(({ state }) => state === "cut" || state === "not_reached");
  }

  armButton() {
    const { texts: words, steering } = this;
    const made = button("", () => {}, { class: "arm" });
    made.append(steering.armed ? words.disarm : words.arm, make("small", {}, steering.armed ? words.armed[1] : words.arm_note));
    let since = null;
    const watch = () => {
      if (since === null) return;
      const share = Math.min(1, (performance.now() - since) / ARMS_AFTER_MS);
      made.style.setProperty("--held", share);
      if (share >= 1) {
        since = null;
        steering.armed = true;
        steering.tick();
      } else requestAnimationFrame(watch);
    };
    const end = () => { since = null; made.style.setProperty("--held", 0); };
    made.addEventListener("pointerdown", () => {
      if (steering.armed) { steering.armed = false; steering.tick(); return; }
      since = performance.now();
      watch();
    });
    for (const name of ["pointerup", "pointerleave", "pointercancel"]) made.addEventListener(name, end);
    return made;
  }

  /** Another screen asks for control. */
  consent() {
    const dialog = dialogOf();
    if (dialog.open) return;
    const answer = (consents) => { this.link.send({ type: "answer", consents }); dialog.close(); };
    dialog.replaceChildren(make("p", {}, this.texts.asked), make("div", { class: "row" },
      button(this.texts.yes, () => answer(true), { class: "main" }), button(this.texts.no, () => answer(false))));
    dialog.showModal();
  }

  stop() {
    this.steering.release();
    this.link.command("feed_hold");
  }

  begin(kind) { beginDialog(this, kind); }

  /** Asks the workbench, and shows a refusal. */
  ask(body) { return this.doing(() => request(body)); }

  async doing(work) {
    this.message = null;
    document.body.setAttribute("aria-busy", "true");
    try { await work(); } catch (error) { this.tell(error.message); } finally { document.body.removeAttribute("aria-busy"); }
  }

  /** Shows a message: for a while, or until the person asks for something else. */
  tell(text, span = Infinity) {
    this.message = { text, until: performance.now() + span };
    this.showState();
  }

  showState() {
    const { texts: words, state, link } = this;
    const session = state?.session;
    const dead = !link.alive || (session && session.age_ms > DEAD_MS);
    let [headline, detail] = words.idle;
    let tone = "";
    if (!link.alive) [headline, detail, tone] = [...words.lost, "alarm"];
    else if (session && dead) [headline, detail, tone] = [...words.dead, "alarm"];
    else if (session) {
      [headline, detail] = words.phase[session.phase] ?? [session.phase, ""];
      tone = TONES[session.phase] ?? "";
      if (tone === "calm" && session.phase === "manual" && state.control.holder !== "mine") [headline, detail, tone] = [...words.watching, ""];
      if (tone === "calm" && this.isAllDone()) [headline, detail] = words[this.job.running === "touch" ? "all_taken" : "all_cut"];
      if (this.job?.running === "dry_run") headline = `${words.dry_run}: ${headline}`;
      if (session.interrupted && session.phase === "retracting") detail = words.finish_from_above;
      if (session.armed) [headline, detail, tone] = [...words.armed, "alert"];
      if (session.phase === "contouring") {
        const left = session.left_s === null ? "" : ` · ${words.left} ${minutes(session.left_s / 60)} ${words.min}`;
        detail = `${Math.floor((session.share ?? 0) * 100)} %${left} · ${this.tally()}`;
      }
      if (session.fault) detail = session.fault;
      else if (this.notice && performance.now() < this.notice.until) detail = this.notice.text;
    }
    if (this.message && performance.now() < this.message.until) {
      // A fault keeps its cause and remedy on the screen.
      detail = session?.fault ? `${session.fault} · ${this.message.text}` : this.message.text;
    }
    at("headline").textContent = headline;
    at("detail").textContent = detail;
    at("state").className = tone;
    at("link").textContent = words[`control_${state?.control.holder ?? "free"}`];
    this.coordinates(session, dead);
  }

  coordinates(session, dead) {
    const values = { x: session?.position_mm?.[0], y: session?.position_mm?.[1], z: session?.height_mm, wall: session?.wall_mm };
    for (const [id, value] of Object.entries(values)) {
      const element = at(id);
      if (!element) continue;
      element.textContent = mm(value);
      element.classList.toggle("stale", Boolean(dead));
    }
  }
}

/** Enters with the token of the address, or asks for it. */
async function enter() {
  const token = new URLSearchParams(location.hash.slice(1)).get("token");
  const entering = (text) => ask("/api/enter", { method: "POST", headers: { "content-type": "application/json" },
    body: JSON.stringify({ token: text }) });
  history.replaceState(null, "", "/");
  if (token) await entering(token).catch(() => {});
  try {
    await ask("/api/job");
  } catch {
    const words = texts();
    const dialog = dialogOf();
    const code = make("input", { autocomplete: "off", spellcheck: false, ariaLabel: words.code });
    const form = make("form", { onsubmit: async (event) => {
      event.preventDefault();
      try { await entering(code.value.trim()); location.reload(); } catch (error) { note.textContent = error.message; }
    } }, make("p", {}, words.enter), code, button("OK", () => form.requestSubmit(), { class: "main" }));
    const note = make("p", {});
    dialog.replaceChildren(form, note);
    dialog.showModal();
    return;
  }
  document.documentElement.lang = Object.keys(LANGUAGES).find((name) => LANGUAGES[name] === texts()) ?? "en";
  globalThis.panel = new Panel();
}

enter();
