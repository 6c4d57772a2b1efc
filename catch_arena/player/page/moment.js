/** @typedef {import("./player.js").CatchReplay} CatchReplay */

/** Time that is played before a moment, in milliseconds. */
const BEFORE = 2000;

/**
 * Show the moment of a player, with its hunter selected, as soon as the replay has been read.
 * @param {CatchReplay} player
 */
function showMoment(player) {
  if (!player.replay) {
    setTimeout(showMoment, 50, player);
    return;
  }
  if (player.dataset.seat) player.pick(Number(player.dataset.seat));
  player.note.hidden = "stopped" in player.dataset || !player.replay.contests.length; // it is about contests
  player.seek(Number(player.dataset.at));
}

for (const element of document.querySelectorAll("catch-replay[data-at]")) {
  const player = /** @type {CatchReplay} */ (element);
  showMoment(player);
  document.querySelector(`[data-plays="${player.id}"]`)?.addEventListener("click", () => {
    player.pause();
    player.seek(Number(player.dataset.at) - BEFORE);
    player.play();
  });
}
