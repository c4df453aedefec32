// Everything that moves the tool: thumb pad, keys, gamepad. One place sends, thirty times a second while something is
// held, and once when it is let go. Blur, a hidden tab, a lost socket and a second finger let everything go.

/** Time between two inputs, ms. */
const EVERY_MS = 33;
/** Dead zone and least deflection of a stick. */
const DEAD = 0.15;
/** Least share of full speed that moves the tool. The program takes less than 0.03 for a stick at rest. */
const LEAST = 0.035;
/** Deflection of the pad that makes one step, and below which it is let go. */
const [STEPS_AT, STEPS_AGAIN_BELOW] = [0.6, 0.3];

/** An input that lets go. The server takes no other input before it, from a new connection and after a contour. */
const LET_GO = { held: false, velocity: [0, 0], up: 0, step_mm: [0, 0], step_up_mm: 0, armed: false };

/** Keys that jog: x, y, up. */
const KEYS = {
  ArrowLeft: [-1, 0, 0], ArrowRight: [1, 0, 0], ArrowUp: [0, 1, 0], ArrowDown: [0, -1, 0],
  Home: [-1, 1, 0], PageUp: [1, 1, 0], End: [-1, -1, 0], PageDown: [1, -1, 0],
  "+": [0, 0, 1], "-": [0, 0, -1],
};

export class Steering {
  /** @param {import("./link.js").Link} link */
  constructor(link) {
    this.link = link;
    /** Speed as a share of full speed. */
    this.speed = 0.2;
    /** Length of one step, mm; 0 for the stick. */
    this.step = 0;
    this.armed = false;
    this.pad = null;
    this.keys = new Set();
    this.mayKeys = () => true;
    this.wasHeld = false;
    this.wasArmed = false;
    this.stepped = [0, 0, 0];
    setInterval(() => this.tick(), EVERY_MS);
    // What was held before the connection was lost does not go on after it.
    link.onLost = () => this.release();
    link.onOpened = () => link.steer(LET_GO);
    addEventListener("blur", () => this.release());
    addEventListener("pagehide", () => this.release());
    document.addEventListener("visibilitychange", () => { if (document.hidden) this.release(); });
    addEventListener("keydown", (event) => this.key(event, true));
    addEventListener("keyup", (event) => this.key(event, false));
    addEventListener("touchstart", (event) => { if (event.touches.length > 1) this.release(); }, { passive: true });
    addEventListener("contextmenu", (event) => event.preventDefault());
  }

  /** Lets everything go, and disarms. */
  release() {
    this.armed = false;
    this.letGo();
  }

  /** Lets everything go. */
  letGo() {
    this.pad = null;
    this.keys.clear();
    this.stepped = [0, 0, 0];
    this.tick();
  }

  key(event, down) {
    const push = KEYS[event.key];
    const typing = event.target instanceof HTMLElement && event.target.closest("input, select, dialog[open]");
    if (push === undefined || typing || !this.mayKeys()) {
      this.keys.delete(event.key);
      return;
    }
    event.preventDefault();
    if (!down) {
      this.keys.delete(event.key);
    } else if (!event.repeat) {
      if (this.step > 0) this.steps(push); else this.keys.add(event.key);
    }
    this.tick();
  }

  /** Moves by one step. @param {number[]} push */
  steps(push) {
    this.stepped = this.stepped.map((sum, axis) => sum + push[axis] * this.step);
    this.tick();
  }

  /** @returns {{velocity: number[], up: number} | null} What the gamepad asks for while its shoulder button is held. */
  gamepad() {
    const pads = navigator.getGamepads ? [...navigator.getGamepads()].filter((pad) => pad && pad.connected) : [];
    const pad = pads[0];
    if (!pad || !pad.buttons[4]?.pressed) return null;
    const axis = (value) => (Math.abs(value) < DEAD ? 0 : value);
    const up = (pad.buttons[7]?.value ?? 0) - (pad.buttons[6]?.value ?? 0);
    return { velocity: [axis(pad.axes[0]), -axis(pad.axes[1])], up: axis(up) };
  }

  /** Sends the input of this moment. */
  tick() {
    let velocity = [0, 0];
    let up = 0;
    let held = false;
    const add = (source) => {
      held = true;
      velocity = [velocity[0] + source.velocity[0], velocity[1] + source.velocity[1]];
      up += source.up;
    };
    // A control that is no longer on the page is held by nobody.
    if (this.pad && !this.pad.owner.isConnected) this.pad = null;
    if (this.pad) add(this.pad);
    for (const key of this.keys) add({ velocity: KEYS[key].slice(0, 2), up: KEYS[key][2] });
    const gamepad = document.hidden || !document.hasFocus() ? null : this.gamepad();
    if (gamepad) add(gamepad);
    const steps = this.stepped;
    this.stepped = [0, 0, 0];
    if (steps.some((step) => step !== 0)) held = true;
    if (!held && !this.wasHeld && !this.armed && !this.wasArmed) return;
    // A new press begins with its own release, so the server knows it from one that goes on.
    if (held && !this.wasHeld) this.link.steer({ ...LET_GO, armed: this.armed });
    [this.wasHeld, this.wasArmed] = [held, this.armed];
    // From the dead zone to the rim, the speed goes from the least to the chosen one.
    const length = Math.hypot(...velocity);
    const share = (deflection) => (deflection === 0 ? 0 : LEAST + (Math.max(this.speed, LEAST) - LEAST) * Math.min(1, deflection));
    const scale = length === 0 ? 0 : share(length) / length;
    this.link.steer({
      held,
      velocity: [velocity[0] * scale, velocity[1] * scale],
      up: Math.sign(up) * share(Math.abs(up)),
      step_mm: [steps[0], steps[1]],
      step_up_mm: steps[2],
      armed: this.armed,
    });
  }
}

/** Time that a finger rests on the pad before the pad is live, ms: the enabling hold. */
const ENABLES_AFTER_MS = 250;

/** A thumb pad. The finger rests on it first, then pushes. @param {HTMLElement} element @param {Steering} steering */
export function thumbPad(element, steering) {
  let pointer = null;
  let liveAt = 0;
  /** The push that rests was a step already. */
  let stepped = false;
  const place = (event) => {
    const box = element.getBoundingClientRect();
    const half = box.width / 2;
    const x = (event.clientX - box.left - half) / half;
    const y = -(event.clientY - box.top - box.height / 2) / half;
    const length = Math.hypot(x, y);
    const share = length < DEAD ? 0 : Math.min(1, length) / Math.max(length, 1e-9);
    return [x * share, y * share];
  };
  const end = () => {
    pointer = null;
    steering.pad = null;
    element.classList.remove("live");
    element.style.removeProperty("--x");
    element.style.removeProperty("--y");
    steering.tick();
  };
  const follow = (event) => {
    if (event.pointerId !== pointer) return;
    const [x, y] = place(event);
    element.style.setProperty("--x", `${x * 35}%`);
    element.style.setProperty("--y", `${-y * 35}%`);
    if (performance.now() < liveAt) return;
    element.classList.add("live");
    if (steering.step > 0) {
      // One push is one step, along the nearest of eight directions.
      const length = Math.hypot(x, y);
      if (length < STEPS_AGAIN_BELOW) stepped = false;
      if (stepped || length < STEPS_AT) return;
      stepped = true;
      const turn = Math.round(Math.atan2(y, x) / (Math.PI / 4)) * (Math.PI / 4);
      steering.steps([Math.round(Math.cos(turn)), Math.round(Math.sin(turn)), 0]);
      return;
    }
    steering.pad = { owner: element, velocity: [x, y], up: 0 };
  };
  element.addEventListener("pointerdown", (event) => {
    if (pointer !== null) {
      end();
      steering.release();
      return;
    }
    pointer = event.pointerId;
    stepped = false;
    liveAt = performance.now() + ENABLES_AFTER_MS;
    element.setPointerCapture(pointer);
    const down = event;
    setTimeout(() => { if (pointer === down.pointerId) follow(element.last ?? down); }, ENABLES_AFTER_MS + 1);
  });
  element.addEventListener("pointermove", (event) => { element.last = event; follow(event); });
  for (const name of ["pointerup", "pointercancel", "lostpointercapture"]) {
    element.addEventListener(name, (event) => { if (event.pointerId === pointer) end(); });
  }
  // What else lets everything go takes the pad's finger, too.
  setInterval(() => { if (pointer !== null && !steering.pad && element.classList.contains("live")) end(); }, EVERY_MS);
}

/** A button that moves the tool up or down while it is held. @param {HTMLElement} element @param {Steering} steering */
export function holdButton(element, steering, up) {
  let rests = 0;
  const end = () => {
    clearTimeout(rests);
    element.classList.remove("live");
    if (steering.pad?.owner === element) { steering.pad = null; steering.tick(); }
  };
  element.addEventListener("pointerdown", (event) => {
    element.setPointerCapture(event.pointerId);
    if (steering.step > 0) { steering.steps([0, 0, up]); return; }
    // A tap moves nothing: the finger rests first, as on the pad.
    rests = setTimeout(() => {
      element.classList.add("live");
      steering.pad = { owner: element, velocity: [0, 0], up };
      steering.tick();
    }, ENABLES_AFTER_MS);
  });
  for (const name of ["pointerup", "pointercancel", "lostpointercapture"]) element.addEventListener(name, end);
}
