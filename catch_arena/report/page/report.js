"use strict";

const PAGE = 10;
const NEWS_MS = 2000;
const at = (id) => document.getElementById(id);
const watched = "watched" in document.body.dataset;

const theme = {
  kept: () => { try { return localStorage.getItem("catch-arena-theme"); } catch { return null; } },
  keep: (name) => { try { localStorage.setItem("catch-arena-theme", name); } catch { /* a page may have no storage */ } },
  set: (name) => (document.documentElement.dataset.theme = name),
};
if (theme.kept()) theme.set(theme.kept());
at("theme").addEventListener("click", () => {
  const shown = document.documentElement.dataset.theme || (matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light");
  const name = shown === "dark" ? "light" : "dark";
  theme.set(name);
  theme.keep(name);
});

/** The list of matches, and the player that shows one of them. */
class Matches {
  constructor() {
    this.bundles = JSON.parse(at("films").textContent);
    this.first = 0;
    at("who").addEventListener("change", () => this.show(0));
    at("playable")?.addEventListener("change", () => this.show(0));
    at("back").addEventListener("click", () => this.show(this.first - PAGE));
    at("more").addEventListener("click", () => this.show(this.first + PAGE));
  }

  async read(text) {
    const bytes = await customElements.get("catch-replay").unpacked(text.trim());
    this.data = JSON.parse(new TextDecoder().decode(bytes));
    this.show(this.first);
  }

  plays(index) {
    return this.data.ids[index] in this.bundles || (watched && Boolean(this.data.recorded[index]));
  }

  /** The matches that are asked for; those that play here in the order in which these were chosen. */
  found() {
    const { ids, names, seating, seats } = this.data;
    const who = names.indexOf(at("who").value);
    const only = at("playable")?.checked;
    const has = (index) => who < 0 || seating.slice(index * seats, (index + 1) * seats).includes(who);
    const order = only && !watched ? Object.keys(this.bundles).map((id) => ids.indexOf(id)).filter((index) => index >= 0) : [...ids.keys()];
    return order.filter((index) => has(index) && (!only || this.plays(index)));
  }

  show(first) {
    const found = this.found();
    this.first = Math.max(0, Math.min(first, found.length - 1));
    this.first -= this.first % PAGE;
    const shown = found.slice(this.first, this.first + PAGE);
    at("list").replaceChildren(...shown.map((index) => this.line(index)));
    at("found").textContent = found.length ? `${this.first + 1} to ${this.first + shown.length} of ${found.length.toLocaleString("en")}` : "none";
    at("back").disabled = this.first === 0;
    at("more").disabled = this.first + PAGE >= found.length;
  }

  line(index) {
    const { ids, names, seating, scores, ranks, seats, recorded } = this.data;
    const id = ids[index];
    const line = document.createElement("li");
    const part = (className, text) => Object.assign(document.createElement("span"), { className, textContent: text });
    const cast = part("seats-of", "");
    for (let seat = index * seats; seat < (index + 1) * seats; seat++) {
      cast.append(part(ranks[seat] === 1 ? "first" : "", `${names[seating[seat]]} ${scores[seat]}`));
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

  async open(id, moved = false) {
    const player = at("player");
    const bundle = this.bundles[id]?.[0] ?? (await this.fetched(id));
    if (!bundle) return;
    this.shown = id;
    player.setAttribute("film", bundle);
    at("showing").textContent = `Match ${id}`;
    this.show(this.first);
    if (moved) {
      at("showing").scrollIntoView({ block: "start" });
      player.focus({ preventScroll: true });
    }
  }

  /** Where the page is served, any match that was recorded can be had. */
  async fetched(id) {
    at("showing").textContent = `Match ${id} is being prepared`;
    try {
      const answer = await fetch(`films/${encodeURIComponent(id)}`);
      if (answer.ok) return await answer.text();
      at("showing").textContent = await answer.text();
    } catch {
      at("showing").textContent = "The server has ended.";
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

/** While a tournament runs, its page asks for news, and takes over what has changed; the replays stay as they are. */
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
      await matches.read(fresh.getElementById("matches").textContent);
    }
    at("news").textContent = "live";
  } catch {
    at("news").textContent = "no longer live: the server has ended";
  }
  setTimeout(news, NEWS_MS, now);
}
if (watched) news(null);
