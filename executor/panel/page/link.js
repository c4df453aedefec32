// The socket: one connection, opened again when it is lost. Inputs carry a number and the last time stamp seen.

import { screen } from "./parts.js";

/** Age of the last state above which it is shown as dead, ms. */
export const DEAD_MS = 500;
/** Time between two attempts to connect, ms. */
const AGAIN_MS = 700;

export class Link {
  /** @param {(state: object) => void} onState @param {(reason: string) => void} onRefused */
  constructor(onState, onRefused) {
    this.onState = onState;
    this.onRefused = onRefused;
    this.onLost = () => {};
    this.onOpened = () => {};
    this.sequence = 0;
    this.seen = 0;
    this.heardAt = -Infinity;
    this.roundTrip = null;
    this.open();
  }

  open() {
    const socket = new WebSocket(`ws://${location.host}/api/socket`);
    this.socket = socket;
    let first = true;
    socket.onopen = () => { this.sequence = 0; };
    socket.onmessage = (event) => {
      const message = JSON.parse(event.data);
      if (message.refused !== undefined) {
        this.onRefused(message.refused);
        return;
      }
      this.heardAt = performance.now();
      this.seen = message.now_us;
      screen.secret = message.screen;
      if (first) this.onOpened();
      first = false;
      this.onState(message);
    };
    socket.onclose = () => {
      this.onLost();
      setTimeout(() => this.open(), AGAIN_MS);
    };
  }

  /** Whether states arrive. */
  get alive() {
    return this.socket.readyState === WebSocket.OPEN && performance.now() - this.heardAt < DEAD_MS;
  }

  send(message) {
    // A message that would wait in the browser would arrive late: it is dropped.
    if (this.socket.readyState === WebSocket.OPEN && this.socket.bufferedAmount < 4096) {
      this.socket.send(JSON.stringify(message));
    }
  }

  order() {
    this.sequence += 1;
    return { sequence: this.sequence, seen_us: this.seen };
  }

  steer(steer) { this.send({ type: "steer", order: this.order(), steer }); }
  command(command) { this.send({ type: "command", order: this.order(), command }); }
}
