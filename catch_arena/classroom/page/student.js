/** @typedef {import("../../player/page/player.js").CatchReplay} CatchReplay */

/** Time that is played before the moment, in milliseconds. */
const BEFORE = 2000;
const player = /** @type {CatchReplay | null} */ (document.getElementById("player"));
const at = Number(player?.dataset.at);
const seat = player?.dataset.seat ?? "";

/** Show the moment, with the student's hunter selected, as soon as the replay has been read. */
function showMoment() {
  if (!player) return;
  if (!player.replay) {
    setTimeout(showMoment, 50);
    return;
  }
  if (seat !== "") player.pick(Number(seat));
  player.note.hidden = "stopped" in player.dataset || !player.replay.contests.length; // it is about contests
  player.seek(at);
}

document.getElementById("again")?.addEventListener("click", () => {
  player?.pause();
  player?.seek(at - BEFORE);
  player?.play();
});
showMoment();
