import { Shape } from "./shape.js";

// The map: the part, its contours and the tool, drawn on a canvas from the lines that the pictures have, too.

const COLOURS = {
  dark: { ground: "#0c1116", face: "#56616d", edge: "#e3ebf2", zone: "#7c3b3b", rest: "#9c7b2e", left: "#3c4650", todo: "#f0b429",
    cut: "#3fb27f", missed: "#e5484d", tool: "#ffffff", trail: "#3aa0e6", hull: "#3aa0e6", text: "#dfe7ee" },
  light: { ground: "#f7f9fb", face: "#b9c4ce", edge: "#1c2733", zone: "#d98e8e", rest: "#d9b65a", left: "#c9d2da", todo: "#a66a00",
    cut: "#12734a", missed: "#b3261e", tool: "#000000", trail: "#0a66a8", hull: "#0a66a8", text: "#10151a" },
};
/** Most points of the trail. */
const TRAIL_MAX = 4000;
/** Distance of a finger from a contour that it means, pixels. */
const TOUCH_PIXELS = 28;
/** Height of the buttons of the map, pixels. */
const TOOLS_PIXELS = 56;
/** Way of a finger that still is a tap, pixels. */
const TAP_PIXELS = 8;

export class PartMap {
  /** @param {HTMLCanvasElement} canvas */
  constructor(canvas) {
    this.canvas = canvas;
    this.context = canvas.getContext("2d", { alpha: false });
    this.view = null;
    this.map = null;
    this.tool = null;
    this.trail = [];
    this.states = new Map();
    this.hull = [];
    this.touch = null;
    this.shapes = null;
    this.depths = [];
    this.depth = null;
    this.chosen = null;
    /** @type {(number: number | null) => void} */
    this.onChosen = () => {};
    this.showHull = false;
    this.drawn = 0;
    this.frame = 0;
    new ResizeObserver(() => this.fit()).observe(canvas);
    this.gestures();
  }

  colours() {
    return COLOURS[matchMedia("(prefers-color-scheme: light)").matches ? "light" : "dark"];
  }

  /** Takes a new map. @param {object} map */
  take(map) {
    this.map = map;
    this.shapes = {
      faces: map.faces.map(([height, lines]) => [height, new Shape(lines, true)]),
      zones: new Shape(map.zones, true),
      left: new Shape(map.left_out, false),
      rest: map.rest.map(([depth, lines]) => [depth, new Shape(lines, true)]),
      contours: map.contours.map(([number, depth, line]) => ({ number, depth, shape: new Shape([line], true) })),
    };
    this.depths = [...new Set(map.contours.map(([, depth]) => depth))].sort((one, other) => other - one);
    this.depth = null;
    this.trail = [];
    this.fit();
    this.ask();
  }

  /** Shows the part, and the tool if it is asked for. */
  fit(withTool = false) {
    const { canvas } = this;
    const scale = devicePixelRatio || 1;
    [canvas.width, canvas.height] = [canvas.clientWidth * scale, canvas.clientHeight * scale];
    if (!this.map) {
      this.draw();
      return;
    }
    let [x0, y0, x1, y1] = this.map.bounds;
    if (withTool && this.tool) {
      [x0, x1] = [Math.min(x0, this.tool[0]), Math.max(x1, this.tool[0])];
      [y0, y1] = [Math.min(y0, this.tool[1]), Math.max(y1, this.tool[1])];
    }
    // The buttons of the map stand below it.
    const below = TOOLS_PIXELS * scale;
    const zoom = Math.min(canvas.width / (x1 - x0), (canvas.height - below) / (y1 - y0)) * 0.86;
    this.view = { zoom: Math.max(zoom, 1e-6), x: (x0 + x1) / 2, y: (y0 + y1) / 2 };
    this.view.y -= below / 2 / this.view.zoom;
    // A canvas is empty after a change of size, so it is drawn at once.
    this.draw();
  }

  /** @param {number} factor @param {number[]} at */
  zoomBy(factor, at = [this.canvas.width / 2, this.canvas.height / 2]) {
    if (!this.view) return;
    const before = this.toDrawing(at);
    this.view.zoom *= factor;
    const after = this.toDrawing(at);
    this.view.x += before[0] - after[0];
    this.view.y += before[1] - after[1];
    this.ask();
  }

  /** @param {number[]} at */
  toDrawing([x, y]) {
    const { zoom, x: cx, y: cy } = this.view;
    return [cx + (x - this.canvas.width / 2) / zoom, cy - (y - this.canvas.height / 2) / zoom];
  }

  /** @param {number[]} at */
  toScreen([x, y]) {
    const { zoom, x: cx, y: cy } = this.view;
    return [this.canvas.width / 2 + (x - cx) * zoom, this.canvas.height / 2 - (y - cy) * zoom];
  }

  gestures() {
    const { canvas } = this;
    const fingers = new Map();
    /** Where the finger came down that may be a tap. */
    let tap = null;
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      fingers.set(event.pointerId, [event.clientX, event.clientY]);
      tap = fingers.size === 1 ? [event.clientX, event.clientY] : null;
    });
    canvas.addEventListener("pointermove", (event) => {
      const before = fingers.get(event.pointerId);
      if (!before || !this.view) return;
      const scale = devicePixelRatio || 1;
      const now = [event.clientX, event.clientY];
      if (tap && Math.hypot(now[0] - tap[0], now[1] - tap[1]) > TAP_PIXELS) tap = null;
      const others = [...fingers].filter(([id]) => id !== event.pointerId).map(([, at]) => at);
      if (others.length === 1) {
        const span = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1]);
        const box = canvas.getBoundingClientRect();
        const middle = [(now[0] + others[0][0]) / 2 - box.left, (now[1] + others[0][1]) / 2 - box.top];
        this.zoomBy(span(now, others[0]) / Math.max(span(before, others[0]), 1), middle.map((c) => c * scale));
      } else {
        this.view.x -= (now[0] - before[0]) * scale / this.view.zoom;
        this.view.y += (now[1] - before[1]) * scale / this.view.zoom;
        this.ask();
      }
      fingers.set(event.pointerId, now);
    });
    canvas.addEventListener("pointerup", () => {
      if (!tap || !this.shapes) return;
      const box = canvas.getBoundingClientRect();
      const scale = devicePixelRatio || 1;
      this.choose(this.contourAt([(tap[0] - box.left) * scale, (tap[1] - box.top) * scale]));
      this.onChosen(this.chosen);
      tap = null;
    });
    canvas.addEventListener("pointerup", (event) => fingers.delete(event.pointerId));
    canvas.addEventListener("pointercancel", (event) => fingers.delete(event.pointerId));
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      const box = canvas.getBoundingClientRect();
      const scale = devicePixelRatio || 1;
      this.zoomBy(Math.exp(-event.deltaY / 400), [(event.clientX - box.left) * scale, (event.clientY - box.top) * scale]);
    }, { passive: false });
  }

  /**
   * Moves the tool. While it moves by itself it leaves no trail: the places that are shown are too few for a curve.
   * @param {number[] | null} at @param {number[][]} hull @param {boolean} alone
   */
  move(at, hull, alone) {
    if (alone && this.trail.length > 0) this.trail = [];

    const last = this.trail[this.trail.length - 1];
    if (at && !alone && (!last || Math.hypot(at[0] - last[0], at[1] - last[1]) > 0.02)) {
      this.trail.push(at);
      if (this.trail.length > TRAIL_MAX) this.trail.splice(0, TRAIL_MAX / 4);
    }
    this.tool = at;
    this.hull = hull;
    this.ask();
  }

  /** Whether the map shows this depth. */
  shows(depth) { return this.depth === null || this.depth === depth; }

  /** Shows the next depth alone, or all after the last one. Returns it. */
  nextDepth() {
    const next = this.depth === null ? 0 : this.depths.indexOf(this.depth) + 1;
    this.depth = this.depths[next] ?? null;
    this.ask();
    return this.depth;
  }

  /** Marks a contour, or none. @param {number | null} number */
  choose(number) {
    this.chosen = number;
    this.ask();
  }

  /** The contour under a finger. @param {number[]} at place on the canvas, pixels */
  contourAt(at) {
    const place = this.toDrawing(at);
    const near = this.shapes.contours.map(({ number, shape }) => [shape.distance(place), number]);
    const [distance, number] = near.reduce((best, next) => (next[0] < best[0] ? next : best), [Infinity, null]);
    return distance * this.view.zoom < TOUCH_PIXELS ? number : null;
  }

  ask() {
    if (this.frame) return;
    this.frame = requestAnimationFrame(() => { this.frame = 0; this.draw(); });
  }

  draw() {
    const { context, canvas, view } = this;
    const colours = this.colours();
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.fillStyle = colours.ground;
    context.fillRect(0, 0, canvas.width, canvas.height);
    if (!view || !this.shapes) return;
    const { zoom } = view;
    const scale = devicePixelRatio || 1;
    const [left, top] = this.toDrawing([0, 0]);
    const [right, bottom] = this.toDrawing([canvas.width, canvas.height]);
    // The path reaches a little beyond the view, so that widths of lines do not show there.
    const margin = 8 * scale / zoom;
    const box = [left - margin, bottom - margin, right + margin, top + margin];
    const path = (shape) => shape.of(box, 1 / zoom);
    context.setTransform(zoom, 0, 0, -zoom, canvas.width / 2 - view.x * zoom, canvas.height / 2 + view.y * zoom);
    const width = (pixels) => { context.lineWidth = pixels * scale / zoom; };
    context.lineJoin = "bevel";
    width(1);
    context.strokeStyle = colours.left;
    context.stroke(path(this.shapes.left));
    const count = this.shapes.faces.length;
    this.shapes.faces.forEach(([, shape], index) => {
      context.globalAlpha = 0.55 + 0.45 * (index + 1) / count;
      context.fillStyle = colours.face;
      context.fill(path(shape), "evenodd");
      context.globalAlpha = 1;
      width(1.5);
      context.strokeStyle = colours.edge;
      context.stroke(path(shape));
    });
    for (const [depth, shape] of this.shapes.rest) {
      if (!this.shows(depth)) continue;
      context.fillStyle = colours.rest;
      context.fill(path(shape), "evenodd");
    }
    context.fillStyle = colours.zone;
    context.fill(path(this.shapes.zones), "evenodd");
    for (const { number, depth, shape } of this.shapes.contours) {
      const state = this.states.get(number);
      context.strokeStyle = state === "cut" ? colours.cut : state === "not_reached" ? colours.missed : colours.todo;
      if (number === this.chosen) context.strokeStyle = colours.trail;
      context.globalAlpha = this.shows(depth) ? 1 : 0.2;
      width(number === this.chosen ? 5 : 2);
      context.stroke(path(shape));
    }
    context.globalAlpha = 1;
    this.drawTool(colours, width);
    this.drawn += 1;
  }

  /** Points to a tool that is beyond the map's edge. */
  drawWayToTool(colours) {
    const { context, canvas } = this;
    const scale = devicePixelRatio || 1;
    const [x, y] = this.toScreen(this.tool);
    const margin = 22 * scale;
    if (x > 0 && y > 0 && x < canvas.width && y < canvas.height) return;
    const at = [Math.min(Math.max(x, margin), canvas.width - margin), Math.min(Math.max(y, margin), canvas.height - margin)];
    const angle = Math.atan2(y - at[1], x - at[0]);
    context.save();
    context.setTransform(Math.cos(angle), Math.sin(angle), -Math.sin(angle), Math.cos(angle), at[0], at[1]);
    context.beginPath();
    context.moveTo(16 * scale, 0);
    context.lineTo(-10 * scale, 12 * scale);
    context.lineTo(-10 * scale, -12 * scale);
    context.closePath();
    context.fillStyle = colours.todo;
    context.fill();
    context.restore();
  }

  drawTool(colours, width) {
    const { context } = this;
    const line = (points) => {
      context.beginPath();
      points.forEach(([x, y], k) => { if (k === 0) context.moveTo(x, y); else context.lineTo(x, y); });
    };
    if (this.trail.length > 1) {
      line(this.trail);
      width(1.2);
      context.strokeStyle = colours.trail;
      context.stroke();
    }
    if (this.showHull && this.hull.length > 1) {
      line(this.hull);
      context.closePath();
      context.globalAlpha = 0.35;
      context.fillStyle = colours.hull;
      context.fill();
      context.globalAlpha = 1;
    }
    if (this.touch) {
      context.beginPath();
      context.arc(this.touch[0], this.touch[1], 9 / this.view.zoom, 0, 2 * Math.PI);
      width(3);
      context.strokeStyle = colours.todo;
      context.stroke();
    }
    if (!this.tool) return;
    this.drawWayToTool(colours);
    const radius = Math.max(this.map.tool_radius_mm ?? 0, 3 / this.view.zoom);
    context.beginPath();
    context.arc(this.tool[0], this.tool[1], radius, 0, 2 * Math.PI);
    width(2.5);
    context.strokeStyle = colours.tool;
    context.stroke();
    context.beginPath();
    context.arc(this.tool[0], this.tool[1], 2 / this.view.zoom, 0, 2 * Math.PI);
    context.fillStyle = colours.tool;
    context.fill();
  }
}
