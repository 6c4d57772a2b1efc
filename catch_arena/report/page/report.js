"use strict";

/** @typedef {typeof import("../../player/page/player.js").CatchReplay} CatchReplay */

/**
 * The matches of a tournament in columns, as page.py writes them. Values by party (a team, a hunter if there are no
 * teams, or a prey) follow each other, match after match.
 * @typedef {object} Columns
 * @property {string[][]} names of the agents as hunters and, with prey, as prey
 * @property {number} seats parties in a match
 * @property {number} hunting number of parties that hunt; the others are prey
 * @property {string[]} ids
 * @property {number[]} recorded 1 or 0
 * @property {number[]} seating index of each agent in `names`
 * @property {number[]} scores
 * @property {number[]} ranks
 */

const PAGE = 10;
const NEWS_MS = 2000;
/**
 * Return the element with this id, which the page must have.
 * @param {string} id
 */
function at(id) {
  const part = document.getElementById(id);
  if (!part) throw new Error(`The page has no element with the id ${id}.`);
  return part;
}
const who = /** @type {HTMLSelectElement} */ (at("who"));
const playable = /** @type {HTMLInputElement | null} */ (document.getElementById("playable"));
const back = /** @type {HTMLButtonElement} */ (at("back"));
const more = /** @type {HTMLButtonElement} */ (at("more"));
const watched = "watched" in document.body.dataset;

const theme = {
  kept: () => {
    try {
      return localStorage.getItem("catch-arena-theme");
    } catch {
      return null;
    }
  },
  /** @param {string} name */
  keep: (name) => {
    try {
      localStorage.setItem("catch-arena-theme", name);
    } catch {
      // a page may have no storage
    }
  },
  /** @param {string} name */
  set: (name) => (document.documentElement.dataset.theme = name),
};
const kept = theme.kept();
if (kept) theme.set(kept);
at("theme").addEventListener("click", () => {
  const shown = document.documentElement.dataset.theme ||
    (matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light");
  const name = shown === "dark" ? "light" : "dark";
  theme.set(name);
  theme.keep(name);
});

/** The list of matches, and the player that shows one of them. */
class Matches {
  /** @type {Record<string, [bundle: string, why: string]>} by a match's id */
  bundles = JSON.parse(at("bundles").textContent);
  /** @type {Columns} */
  data = { names: [[]], seats: 0, hunting: 0, ids: [], recorded: [], seating: [], scores: [], ranks: [] };
  /** Index of the first match on the list's page. */
  first = 0;
  /** Id of the match that is shown. */
  shown = "";

  constructor() {
    who.addEventListener("change", () => this.show(0));
    playable?.addEventListener("change", () => this.show(0));
    back.addEventListener("click", () => this.show(this.first - PAGE));
    more.addEventListener("click", () => this.show(this.first + PAGE));
  }

  /** @param {string} text */
  async read(text) {
    const { unpacked } = /** @type {CatchReplay} */ (customElements.get("catch-replay"));
    const bytes = await unpacked(text.trim());
    this.data = JSON.parse(new TextDecoder().decode(bytes));
    this.show(this.first);
  }

  /** @param {number} index */
  plays(index) {
    return this.data.ids[index] in this.bundles || (watched && Boolean(this.data.recorded[index]));
  }

  /** Return the selected matches; those that play here in the order of the report's choice. */
  found() {
    const { ids, names, seating, seats } = this.data;
    const agent = names[0].indexOf(who.value);
    const only = playable?.checked;
    /** @param {number} index */
    const has = (index) => agent < 0 || seating.slice(index * seats, (index + 1) * seats).includes(agent);
    const order = only && !watched
      ? Object.keys(this.bundles).map((id) => ids.indexOf(id)).filter((index) => index >= 0)
      : [...ids.keys()];
    return order.filter((index) => has(index) && (!only || this.plays(index)));
  }

  /** @param {number} first */
  show(first) {
    const found = this.found();
    this.first = Math.max(0, Math.min(first, found.length - 1));
    this.first -= this.first % PAGE;
    const shown = found.slice(this.first, this.first + PAGE);
    at("list").replaceChildren(...shown.map((index) => this.line(index)));
    at("found").textContent = found.length
      ? `${this.first + 1} to ${this.first + shown.length} of ${found.length.toLocaleString("en")}`
      : "none";
    back.disabled = this.first === 0;
    more.disabled = this.first + PAGE >= found.length;
  }

  /** @param {number} index */
  line(index) {
    const { ids, names, seating, scores, ranks, seats, hunting, recorded } = this.data;
    const id = ids[index];
    const line = document.createElement("li");
    /** @type {(className: string, text: string) => HTMLSpanElement} */
    const part = (className, text) => Object.assign(document.createElement("span"), { className, textContent: text });
    const cast = part("seats-of", "");
    for (let seat = index * seats; seat < (index + 1) * seats; seat++) {
      const hunts = seat % seats < hunting;
      const who = `${names[hunts ? 0 : 1][seating[seat]]} ${scores[seat]}`;
      const wins = ranks[seat] === 1 && (hunts ? hunting : seats - hunting) > 1; // a party without rivals beats no other
      cast.append(part(wins ? "first" : "", hunts ? who : `prey ${who}`));
    }
    const name = part("id", id);
    const why = this.bundles[id]?.[1];
    if (why) name.append(document.createElement("br"), why);
    line.append(name, cast);
    if (this.plays(index)) {
      const button = Object.assign(document.createElement("button"), { type: "button", textContent: "Show" });
      button.setAttribute("aria-label", `Show match ${id}`);
      button.addEventListener("click", () => this.open(id, true));
      line.append(button);
    } else {
      line.append(part("id", recorded[index] ? "recorded" : "not recorded"));
    }
    if (id === this.shown) line.setAttribute("aria-current", "true");
    return line;
  }

  /**
   * Show a match.
   * @param {string} id
   * @param {boolean} moved true to scroll to the player
   */
  async open(id, moved = false) {
    const player = at("player");
    const bundle = this.bundles[id]?.[0] ?? (await this.fetched(id));
    if (!bundle) return;
    this.shown = id;
    player.setAttribute("bundle", bundle);
    at("showing").textContent = `Match ${id}`;
    this.show(this.first);
    if (moved) {
      at("showing").scrollIntoView({ block: "start" });
      player.focus({ preventScroll: true });
    }
  }

  /**
   * Fetch the bundle of any recorded match from the server.
   * @param {string} id
   */
  async fetched(id) {
    at("showing").textContent = `Match ${id} is being prepared`;
    try {
      const answer = await fetch(`bundles/${encodeURIComponent(id)}`);
      if (answer.ok) return await answer.text();
      at("showing").textContent = await answer.text();
    } catch {
      at("showing").textContent = "The server has stopped.";
    }
    return null;
  }
}

const matches = new Matches();
matches.read(at("matches").textContent).then(() => {
  const { ids, recorded } = matches.data;
  const first = Object.keys(matches.bundles)[0] ?? (watched ? ids[recorded.indexOf(1)] : undefined);
  if (first) matches.open(first);
});

/**
 * While a tournament runs, request changes and replace the changed parts; the replays stay as they are.
 * @param {string | null} known the state that the page shows
 */
async function news(known) {
  let now = known;
  try {
    now = await (await fetch("state")).text();
    if (now !== known && known !== null) {
      const fresh = new DOMParser().parseFromString(await (await fetch("./")).text(), "text/html");
      document.title = fresh.title;
      const parts = [...fresh.querySelectorAll("[data-news]")];
      [...document.querySelectorAll("[data-news]")].forEach((part, index) => {
        const open = [...part.querySelectorAll("details")].map((details) => details.open);
        part.replaceChildren(...parts[index].childNodes);
        part.querySelectorAll("details").forEach((details, number) => (details.open = open[number] ?? false));
      });
      await matches.read(fresh.getElementById("matches")?.textContent ?? "");
    }
    at("news").textContent = "live";
  } catch {
    at("news").textContent = "no longer live: the server has stopped";
  }
  setTimeout(news, NEWS_MS, now);
}
if (watched) news(null);
