// Small helpers to build the page.

/** An element with properties and children. */
export function make(name, properties = {}, ...children) {
  const element = document.createElement(name);
  for (const [key, value] of Object.entries(properties)) {
    if (key === "class") element.className = value;
    else if (key.startsWith("on")) element.addEventListener(key.slice(2), value);
    else if (value !== undefined && value !== null) element[key] = value;
  }
  element.append(...children.filter((child) => child !== null && child !== undefined));
  return element;
}

/** A button. */
export const button = (text, onclick, properties = {}) => make("button", { type: "button", onclick, ...properties }, text);

/** The dialog of the page. */
export const dialogOf = () => /** @type {HTMLDialogElement} */ (document.getElementById("dialog"));

/** The secret of this page's socket. A request that changes something is taken from the screen that steers. */
export const screen = { secret: "" };

/** Asks the server. A refusal is an error with its text. */
export async function ask(path, options = {}) {
  const headers = { ...options.headers, "x-keepout-screen": screen.secret };
  const answer = await fetch(path, { credentials: "same-origin", ...options, headers });
  if (!answer.ok) {
    throw new Error(await answer.text());
  }
  return answer.headers.get("content-type")?.includes("json") ? answer.json() : answer.text();
}

/** Asks the workbench. */
export const request = (body) =>
  ask("/api/ask", { method: "POST", headers: { "content-type": "application/json" }, body: JSON.stringify(body) });

/** A length in mm, with three decimals. */
export const mm = (value) => (value === null || value === undefined ? "—" : value.toFixed(3));

/** Minutes, rounded up to a tenth. */
export const minutes = (value) => (Math.ceil(value * 10) / 10).toFixed(1);

/** Keeps the screen awake while the page is seen. */
export function stayAwake() {
  // The compiler of Debian does not know it yet.
  const lock = () => /** @type {any} */ (navigator).wakeLock?.request("screen").catch(() => {});
  document.addEventListener("visibilitychange", () => { if (!document.hidden) lock(); });
  lock();
}
