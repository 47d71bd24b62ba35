"""Checks live pages as a reader sees them: live.py PAGE.html... [--pictures FOLDER] [--seconds N]

Each page runs alone. It measures the time to the first frame with motion, frames per second, the longest gap between two
animation frames, events per second, and the memory before and after.
"""

import argparse
import sys
import time
from pathlib import Path

from devtools import Browser, Failure, expect, find

# Counts frames, measures the longest time between two frames, and records when the simulated time first changes.
WATCH = """
window.watched = { frames: 0, longest: 0, moved: undefined, shown: undefined };
(() => {
  let last;
  const look = (now) => {
    const { watched } = window;
    if (last !== undefined) {
      watched.frames += 1;
      watched.longest = Math.max(watched.longest, now - last);
    }
    last = now;
    const time = document.getElementById('live-time')?.textContent;
    if (time && watched.shown === undefined) {
      watched.shown = time;
    }
    if (time && watched.moved === undefined && time !== watched.shown) {
      watched.moved = performance.now();
    }
    requestAnimationFrame(look);
  };
  requestAnimationFrame(look);
})();
"""

# A hash of all pixels of the canvas, and the number of colours.
PIXELS = """(() => {
  const canvas = document.getElementById('live-view');
  const gl = canvas.getContext('webgl2');
  const bytes = new Uint8Array(4 * canvas.width * canvas.height);
  gl.readPixels(0, 0, canvas.width, canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
  let hash = 0;
  const colours = new Set();
  for (let k = 0; k < bytes.length; k += 4) {
    const colour = bytes[k] << 16 | bytes[k + 1] << 8 | bytes[k + 2];
    colours.add(colour);
    hash = (Math.imul(hash, 31) + colour) | 0;
  }
  return [hash, colours.size];
})()"""

# Waits for four frames in a row in which the simulation is playing or the picture is up to date.
SETTLED = """new Promise((done) => {
  let still = 0;
  const look = () => {
    const isPlaying = document.getElementById('live-play').getAttribute('aria-label') === 'Pause';
    still = isPlaying || !document.getElementById('live').hasAttribute('data-due') ? still + 1 : 0;
    if (still > 3) done(); else requestAnimationFrame(look);
  };
  setTimeout(look, 60);
})"""


class Page:
    """A live page."""

    def __init__(self, browser, path):
        self.browser = browser
        self.path = path

    def open(self, scheme="light", width=1280, height=900):
        self.browser.resize(width, height)
        self.browser.scheme(scheme)
        self.browser.open(self.path.absolute().as_uri())
        self.browser.until("document.getElementById('live').dataset.state === 'ready'", 60)

    def text(self, control):
        return self.browser.evaluate(f"document.getElementById('live-{control}').textContent")

    def click(self, control):
        self.browser.evaluate(f"document.getElementById('live-{control}').click()")
        self.browser.evaluate(SETTLED)

    def key(self, key):
        self.browser.key(key, text=key if len(key) == 1 else None)
        self.browser.evaluate(SETTLED)

    def choose(self, control, value):
        self.browser.evaluate(
            f"(() => {{ const control = document.getElementById('live-{control}'); control.value = '{value}';"
            " control.dispatchEvent(new Event('change')); })()")
        self.browser.evaluate(SETTLED)

    def time(self):
        return float(self.text("time").removeprefix("t = "))

    def events(self):
        return int("".join(c for c in self.text("rate").split(" event")[0].split("·")[-1] if c.isdigit()))

    def is_playing(self):
        return self.browser.evaluate("document.getElementById('live-play').getAttribute('aria-label')") == "Pause"

    def pixels(self):
        self.browser.evaluate(SETTLED)
        return self.browser.evaluate(PIXELS)

    def memory(self):
        self.browser.call("HeapProfiler.collectGarbage")
        return self.browser.call("Runtime.getHeapUsage")["usedSize"]


def opens(page):
    """Waits for the first frame with motion."""
    script = page.browser.call("Page.addScriptToEvaluateOnNewDocument", source=WATCH)
    page.open()
    page.browser.until("window.watched.moved !== undefined", 60)
    moved = page.browser.evaluate("window.watched.moved")
    page.browser.call("Page.removeScriptToEvaluateOnNewDocument", identifier=script["identifier"])
    expect(page.is_playing() and page.text("message") is not None, f"moves {moved:.0f} ms after it was opened")
    expect(page.pixels()[1] > 60, "the picture has particles")
    return moved


def runs(page, seconds):
    """The page runs without gaps, and its memory stays constant."""
    page.browser.evaluate("Object.assign(window.watched, { frames: 0, longest: 0 })")
    memory, events, began = page.memory(), page.events(), time.monotonic()
    time.sleep(seconds)
    spent = time.monotonic() - began
    frames, longest = page.browser.evaluate("[window.watched.frames, window.watched.longest]")
    grown = (page.memory() - memory) / 1e6
    print(f"  {frames / spent:.0f} frames/s, longest gap {longest:.0f} ms, {page.text('rate')}, heap {grown:+.2f} MB in {spent:.0f} s")
    expect(page.events() > events or not page.is_playing(), "events happen")
    expect(grown < 8, "the memory of the page stays")
    return longest


def controls(page):
    """Play, pause, step, speeds, reset and seed, by buttons and by keys."""
    if not page.is_playing():
        page.click("reset")
        page.click("play")
    page.key(" ")
    expect(not page.is_playing(), "space pauses")
    at = page.time()
    time.sleep(0.4)
    expect(page.time() == at, "and time stands still")
    before = page.events()
    page.click("step")
    expect(page.events() == before + 1, "a step is one event")
    page.key("ArrowRight")
    expect(page.events() == before + 2, "so is an arrow")
    speed = page.text("speed")
    page.click("faster")
    faster = page.text("speed")
    page.key(",")
    expect(faster != speed and page.text("speed") == speed, f"{speed}, then {faster}, and back by a key")
    page.click("play")
    expect(page.is_playing() or page.text("words"), "plays")
    page.key(" ")
    page.click("reset")
    expect(page.time() == 0 or page.events() == 0, "goes back to the start")
    first = page.pixels()
    page.click("step")
    page.key("0")
    expect(page.pixels() == first, "which looks as it did")
    page.choose("seed", "12345")
    expect(page.browser.evaluate("document.getElementById('live-seed').value") == "12345" and page.events() == 0, "takes another seed")
    page.choose("seed", "1")


def sights(page):
    """Drawings on demand."""
    page.click("reset")
    seen = {page.pixels()[0]}
    for control in ("arrows", "box"):
        page.click(control)
        pixels = page.pixels()[0]
        expect(pixels not in seen or control == "arrows", f"{control} can be switched")
        seen.add(pixels)
        page.click(control)
    for colour in ("speed", "neighbours", "history"):
        page.choose("colour", colour)
        expect(page.text("scale").strip() != "" and "species" not in page.text("scale"), f"colours by {colour}: {page.text('scale')}")
    page.choose("colour", "species")
    page.key("m")
    expect(page.browser.evaluate("document.getElementById('live-slow').getAttribute('aria-pressed')") == "true", "slow motion")
    page.key(" ")
    time.sleep(1)
    words = page.text("upcoming")
    expect(words == "" or " in " in words or "now" in words, f"announces `{words}`")
    page.key("m")
    page.key(" ")


def hand(page):
    """Drags a particle while the simulation is paused."""
    page.click("reset")
    if page.browser.evaluate("document.getElementById('live-hand').getAttribute('aria-pressed')") != "true":
        page.key("h")
    left, top, width, height = page.browser.evaluate(
        "(() => { const box = document.getElementById('live-view').getBoundingClientRect(); return [box.left, box.top, box.width, box.height]; })()")
    places = [(left + width * (k + 0.5) / 40, top + height * (row + 0.5) / 30) for row in range(30) for k in range(40)]
    for place in places:
        page.browser.call("Input.dispatchMouseEvent", type="mouseMoved", x=place[0], y=place[1], button="none", buttons=0)
        if page.browser.evaluate("document.getElementById('live-view').classList.contains('is-over')"):
            break
    else:
        raise Failure("the hand finds no particle")
    before = page.pixels()
    page.browser.drag(place, (place[0], place[1] + 5))
    page.browser.evaluate(SETTLED)
    words = page.text("words")
    expect(page.pixels() != before or "no room" in words, f"a drag moves a particle {words}")
    page.click("reset")
    expect(page.pixels() == before, "and the start has it where it was")


def touches(page):
    """On a phone, one finger scrolls the page; two fingers turn and enlarge the picture."""
    browser = page.browser
    browser.call("Emulation.setTouchEmulationEnabled", enabled=True, maxTouchPoints=5)
    page.open("light", 400, 800)
    if page.is_playing():
        page.click("play")
    before = page.pixels()
    left, top, width, height = browser.evaluate(
        "(() => { const box = document.getElementById('live-view').getBoundingClientRect(); return [box.left, box.top, box.width, box.height]; })()")
    centre = (left + width / 2, top + height / 2)

    def move(*paths):
        """Moves each finger along its path in equal steps."""
        def points(share):
            return [{"x": a[0] + share * (b[0] - a[0]), "y": a[1] + share * (b[1] - a[1]), "id": k} for k, (a, b) in enumerate(paths)]

        browser.call("Input.dispatchTouchEvent", type="touchStart", touchPoints=points(0))
        for step in range(1, 11):
            browser.call("Input.dispatchTouchEvent", type="touchMove", touchPoints=points(step / 10))
            time.sleep(0.02)
        browser.call("Input.dispatchTouchEvent", type="touchEnd", touchPoints=[])
        time.sleep(0.3)

    def at(x, y):
        return (centre[0] + x, centre[1] + y)

    def scrolled():
        return browser.evaluate("window.scrollY")

    move((at(0, 60), at(0, -60)))
    expect(scrolled() > 20 and page.pixels() == before, f"one finger scrolls the page, by {scrolled()}")
    browser.evaluate("window.scrollTo(0, 0)")
    move((at(-40, 0), at(20, 0)), (at(40, 0), at(100, 0)))
    turned = page.pixels()
    expect(turned != before and scrolled() == 0, "two turn the picture")
    move((at(-30, 0), at(-80, 0)), (at(30, 0), at(80, 0)))
    expect(page.pixels() != turned and scrolled() == 0, "and make it larger")
    browser.call("Emulation.setTouchEmulationEnabled", enabled=False)


def fits(page, pictures):
    for scheme, width, height in (("light", 1280, 900), ("dark", 400, 800), ("dark", 2560, 1300)):
        page.open(scheme, width, height)
        time.sleep(1.5)
        wide = page.browser.evaluate("document.documentElement.scrollWidth")
        bottom = page.browser.evaluate("document.getElementById('live-player').getBoundingClientRect().bottom")
        expect(wide <= width and bottom <= height, f"fits {width} x {height}, {scheme}: the picture ends at {bottom:.0f}")
        if pictures:
            page.browser.screenshot(pictures / f"{page.path.stem}_{scheme}_{width}.png")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("pages", nargs="+", type=Path)
    parser.add_argument("--pictures", type=Path)
    parser.add_argument("--seconds", type=float, default=5)
    parser.add_argument("--longest-gap", type=float, default=2000, help="most milliseconds between two frames; software graphics need time")
    given = parser.parse_args()
    browser = Browser(find())
    try:
        for path in given.pages:
            print(path.name)
            page = Page(browser, path)
            opens(page)
            longest = runs(page, given.seconds)
            expect(longest < given.longest_gap, "does not freeze")
            controls(page)
            sights(page)
            hand(page)
            touches(page)
            fits(page, given.pictures)
            expect(not browser.errors, f"no errors: {browser.errors}")
        foreign = [url for url in browser.requests if not url.startswith(("file://", "blob:"))]
        expect(not foreign, f"nothing is loaded from elsewhere: {foreign}")
    except Failure as failure:
        print(f"FAILED: {failure}\nerrors of the page: {browser.errors}", file=sys.stderr)
        return 1
    finally:
        browser.close()
    print("all as expected")
    return 0


sys.exit(main())
