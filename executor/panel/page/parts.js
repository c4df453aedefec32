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

/** Asks the server. A refusal is an error with its text. */
export async function ask(path, options = {}) {
  const answer = await fetch(path, { credentials: "same-origin", ...options });
  if (!answer.ok) {
    const error = new Error(await answer.text());
    error.status = answer.status;
    throw error;
  }
  return answer.headers.get("content-type")?.includes("json") ? answer.json() : answer.text();
}

/** Asks the workbench. */
export const request = (body) =>
  ask("/api/ask", { method: "POST", headers: { "content-type": "application/json" }, body: JSON.stringify(body) });

/** A length in mm, with three decimals. */
export const mm = (value) => (value === null || value === undefined ? "—" : value.toFixed(3));

/** Keeps the screen awake while the page is seen. */
export function stayAwake() {
  const lock = () => navigator.wakeLock?.request("screen").catch(() => {});
  document.addEventListener("visibilitychange", () => { if (!document.hidden) lock(); });
  lock();
}
