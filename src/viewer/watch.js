// `pliant report --watch`: while the run is active, its page is written anew and loads itself again, looking as it did.
import { report } from "./data.js";

const KEY = `pliant ${location.pathname}`;

/// What a reader has chosen.
function choices({ view, panel, player }) {
  return {
    camera: view.camera.position.toArray(), target: view.controls.target.toArray(), aimed: view.aimed,
    colour: panel.colour.selectedOptions[0]?.textContent, isAtEnd: player.time >= player.end, time: player.time, scroll: scrollY,
  };
}

async function restore({ view, panel, player }, kept) {
  const option = [...panel.colour.options].find(({ textContent }) => textContent === kept.colour);
  if (option) {
    panel.colour.value = option.value;
    await panel.paint();
  }
  if (!kept.isAtEnd) player.seek(kept.time);
  if (kept.aimed) view.aim(kept.aimed);
  else {
    view.aimed = null;
    view.camera.position.fromArray(kept.camera);
    view.controls.target.fromArray(kept.target);
    view.controls.update();
  }
  scrollTo(0, kept.scroll);
}

/// To be called once the page has been drawn.
export async function watch(page) {
  try {
    const kept = sessionStorage.getItem(KEY);
    sessionStorage.removeItem(KEY);
    if (kept) await restore(page, JSON.parse(kept));
  } catch {
    // A browser that keeps nothing for files shows the page as new.
  }
  if (!report.watch) return;
  let isHeld = false;
  addEventListener("pointerdown", () => (isHeld = true));
  addEventListener("pointerup", () => (isHeld = false));
  setInterval(() => {
    if (isHeld || page.player.playing || page.points.picked.length || page.picture.isRecording || document.hidden) return;
    try {
      sessionStorage.setItem(KEY, JSON.stringify(choices(page)));
    } catch {
      // As above.
    }
    location.reload();
  }, 1000 * report.watch);
}
