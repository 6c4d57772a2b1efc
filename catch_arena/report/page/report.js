"use strict";

/** @typedef {import("../../player/page/player.js").CatchReplay} CatchReplay */

/**
 * The matches of a tournament in columns, as page.py writes them. Values by party (a team, a hunter if there are no
 * teams, or a prey) follow each other, match after match.
 * @typedef {object} Columns
 * @property {string[][]} names of the agents as hunters and, with prey, as prey
 * @property {number} seats parties in a match
 * @property {number} hunting number of parties that hunt; the others are prey
 * @property {string[]} ids
 * @property {string[]} titles the matches' names for people
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
/** @param {string} text */
const capital = (text) => text[0].toUpperCase() + text.slice(1);

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
  data = { names: [[]], seats: 0, hunting: 0, ids: [], titles: [], recorded: [], seating: [], scores: [], ranks: [] };
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
    const { unpacked } = /** @type {typeof import("../../player/page/player.js").CatchReplay} */ (
      customElements.get("catch-replay")
    );
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
    const { ids, titles, names, seating, scores, ranks, seats, hunting, recorded } = this.data;
    const [id, title] = [ids[index], titles[index]];
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
    const name = part("id", capital(title));
    const why = this.bundles[id]?.[1];
    if (why) name.append(document.createElement("br"), why);
    line.append(name, cast);
    if (this.plays(index)) {
      const button = Object.assign(document.createElement("button"), { type: "button", textContent: "Show" });
      button.setAttribute("aria-label", `Show ${title}`);
      button.addEventListener("click", () => this.open(id, true));
      line.append(button);
    } else {
      line.append(part("id", recorded[index] ? `recorded as ${id}` : "not recorded"));
    }
    if (id === this.shown) line.setAttribute("aria-current", "true");
    return line;
  }

  /**
   * Show a match.
   * @param {string} id
   * @param {boolean} moved true to scroll to the player
   * @param {number} time at which it begins, in milliseconds
   * @param {boolean} asked true to show what would have won a contest
   */
  async open(id, moved = false, time = 0, asked = false) {
    const player = /** @type {CatchReplay} */ (at("player"));
    const bundle = await this.bundle(id, at("showing"));
    if (!bundle) return;
    this.shown = id;
    player.setAttribute("address", address(id));
    player.setAttribute("start", String(time));
    player.toggleAttribute("what-if", asked);
    player.setAttribute("bundle", bundle);
    player.pause();
    player.ask(asked);
    player.seek(time); // if it has been read already
    at("showing").textContent = capital(this.title(id));
    this.show(this.first);
    if (moved) {
      at("showing").scrollIntoView({ block: "start" });
      player.focus({ preventScroll: true });
    }
  }

  /** @param {string} id */
  title(id) {
    return this.data.titles[this.data.ids.indexOf(id)] ?? `match ${id}`;
  }

  /**
   * Return the bundle of a match: from the page, or of any recorded match from the server.
   * @param {string} id
   * @param {{ textContent: string | null }} note gets the reason why there is none
   */
  async bundle(id, note) {
    if (id in this.bundles) return this.bundles[id][0];
    const title = capital(this.title(id));
    note.textContent = `${title} ${watched ? "is being prepared" : "does not play in this page"}`;
    if (!watched) return null;
    try {
      const answer = await fetch(`bundles/${encodeURIComponent(id)}`);
      if (answer.ok) return await answer.text();
      note.textContent = await answer.text();
    } catch {
      note.textContent = "The server has stopped.";
    }
    return null;
  }
}

/**
 * Return the part of the page's address that opens a match, at an instant if one is given.
 * @param {string} id
 * @param {number} [time]
 */
const address = (id, time) => `#match=${encodeURIComponent(id)}${time === undefined ? "" : `&t=${time / 1000}`}`;

/** The best moment, which is repeated while it is in sight, if motion is welcome. */
class Best {
  player = /** @type {CatchReplay} */ (at("best"));
  /** True if it plays when it is in sight. */
  wanted = !matchMedia("(prefers-reduced-motion: reduce)").matches;
  seen = false;
  /** The instant that decides, in milliseconds. */
  time = 0;

  constructor() {
    this.player.addEventListener("load", () => this.rest());
    new IntersectionObserver(([{ isIntersecting }]) => {
      if (this.seen && !isIntersecting) {
        this.wanted = this.player.playing || this.player.waiting;
        if (this.player.saved === null) this.player.pause();
      }
      this.seen = isIntersecting;
      this.resume();
    }).observe(this.player);
    addEventListener("beforeprint", () => {
      this.player.pause();
      this.player.seek(this.time);
    });
    addEventListener("afterprint", () => this.resume());
  }

  /** Show the moment that the page names. */
  async show() {
    const { match, start, time, end } = document.getElementById("event")?.dataset ?? {};
    if (!match || !start || !end) return;
    this.time = Number(time);
    const link = address(match, this.time);
    if (link === this.player.getAttribute("address")) return; // it is shown
    this.player.setAttribute("address", link);
    const bundle = await matches.bundle(match, { textContent: "" });
    if (!bundle) return;
    at("moment").hidden = false;
    this.player.setAttribute("start", start);
    this.player.setAttribute("end", end);
    this.player.setAttribute("bundle", bundle);
    this.resume();
  }

  resume() {
    if (this.seen && this.wanted) this.player.play();
  }

  /** Show the instant that decides, if the moment does not play. */
  rest() {
    if (!this.wanted) this.player.seek(this.time);
  }
}

const matches = new Matches();
const best = document.getElementById("best") && new Best();

/** Open the match and the instant that the page's address names; return false if it names none. */
function follow() {
  const words = new URLSearchParams(location.hash.slice(1));
  const id = words.get("match");
  if (!id || !document.getElementById("player")) return false;
  matches.open(id, true, 1000 * Number(words.get("t")) || 0, words.has("what-if"));
  return true;
}
addEventListener("hashchange", follow);
addEventListener("click", ({ target }) => {
  const link = target instanceof Element && target.closest("a");
  if (link && link.hash.startsWith("#match=") && link.hash === location.hash) follow(); // no hashchange follows
});
matches.read(at("matches").textContent).then(() => {
  const { ids, recorded } = matches.data;
  const first = Object.keys(matches.bundles)[0] ?? (watched ? ids[recorded.indexOf(1)] : undefined);
  if (first && !follow()) matches.open(first);
  best?.show();
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
      best?.show();
    }
    at("news").textContent = "live";
  } catch {
    at("news").textContent = "no longer live: the server has stopped";
  }
  setTimeout(news, NEWS_MS, now);
}
if (watched) news(null);
