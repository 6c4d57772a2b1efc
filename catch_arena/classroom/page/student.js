/** @typedef {import("../../player/page/player.js").CatchReplay} CatchReplay */

const player = /** @type {CatchReplay | null} */ (document.getElementById("player"));
const start = Number(player?.dataset.start);
const seat = player?.dataset.seat ?? "";

/** Show the beginning of the moment, with the student's hunter selected, as soon as the replay has been read. */
function showMoment() {
  if (!player) return;
  if (!player.replay) {
    setTimeout(showMoment, 50);
    return;
  }
  if (seat !== "") player.pick(Number(seat));
  player.seek(start);
}

document.getElementById("again")?.addEventListener("click", () => {
  player?.pause();
  player?.seek(start);
  player?.play();
});
showMoment();
