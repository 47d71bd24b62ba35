"""Checks the pages of some runs as a reader sees them: check.py RUNS PICTURES, or check.py --find."""

import base64
import json
import shutil
import sys
import time
from pathlib import Path

from devtools import Browser, Failure, expect, find

# Three properties of the canvas: the number of colours, a hash of all pixels, and how many of 24 hues occur.
PIXELS = """(() => {
  const canvas = document.getElementById('player-view');
  const gl = canvas.getContext('webgl2');
  const bytes = new Uint8Array(4 * canvas.width * canvas.height);
  gl.readPixels(0, 0, canvas.width, canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
  const colours = new Set();
  let hash = 0;
  const hues = new Array(24).fill(0);
  for (let k = 0; k < bytes.length; k += 4) {
    const colour = bytes[k] << 16 | bytes[k + 1] << 8 | bytes[k + 2];
    colours.add(colour);
    hash = (Math.imul(hash, 31) + colour) | 0;
    const [red, green, blue] = [bytes[k], bytes[k + 1], bytes[k + 2]];
    const [most, least] = [Math.max(red, green, blue), Math.min(red, green, blue)];
    if (most - least > 0.3 * most) {
      const hue = Math.atan2(Math.sqrt(3) * (green - blue), 2 * red - green - blue);
      hues[Math.floor((hue / Math.PI + 1) * 12) % 24] += 1;
    }
  }
  return [colours.size, hash, hues.filter((count) => count > 30).length];
})()"""

# Stores the pixels of the canvas. Returns the mean row of the pixels that changed since the last call, counted from
# below. Returns -1 if no pixel changed.
ROW = """(() => {
  const canvas = document.getElementById('player-view');
  const gl = canvas.getContext('webgl2');
  const bytes = new Uint8Array(4 * canvas.width * canvas.height);
  gl.readPixels(0, 0, canvas.width, canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
  let [sum, count] = [0, 0];
  for (let k = 0; window.kept && k < bytes.length; k += 4) {
    if (bytes[k] !== window.kept[k]) {
      sum += Math.floor(k / 4 / canvas.width);
      count += 1;
    }
  }
  window.kept = bytes;
  return count ? sum / count : -1;
})()"""

# Waits until no drawing is due for three frames in a row, because resizing requests another drawing.
DRAWN = """new Promise((done) => {
  let still = 0;
  const look = () => {
    still = 'due' in document.getElementById('player').dataset ? 0 : still + 1;
    if (still > 2) done(); else requestAnimationFrame(look);
  };
  look();
})"""


class Page:
    """A page with a player."""

    def __init__(self, browser, path):
        self.browser = browser
        self.path = path

    def open(self, scheme="light", width=1280):
        self.browser.resize(width, 900)
        self.browser.scheme(scheme)
        self.browser.open(self.path.as_uri())
        self.browser.until("document.getElementById('player').dataset.frame === '0'")
        self.browser.evaluate("document.getElementById('player').scrollIntoView()")
        # On slow graphics, the player could switch off the shadows during the test.
        self.browser.evaluate("(() => { const box = document.getElementById('player-shadows'); box.checked = false;"
                              " box.dispatchEvent(new Event('change')); })()")
        self.browser.evaluate(DRAWN)

    def pixels(self):
        self.browser.evaluate(DRAWN)
        return self.browser.evaluate(PIXELS)

    def choose(self, control, value, event="change"):
        self.browser.evaluate(
            f"(() => {{ const control = document.getElementById('player-{control}');"
            f" control.value = '{value}'; control.dispatchEvent(new Event('{event}')); }})()")

    def click(self, control):
        self.browser.evaluate(f"document.getElementById('player-{control}').click()")

    def frame(self):
        return int(self.browser.evaluate("document.getElementById('player').dataset.frame"))

    def text(self, control):
        return self.browser.evaluate(f"document.getElementById('player-{control}').textContent")

    def middle(self):
        return self.browser.evaluate(
            "(() => { const box = document.getElementById('player-view').getBoundingClientRect();"
            " return [box.left + box.width / 2, box.top + box.height / 2]; })()")


def plays(page):
    """Play, scrub and step."""
    first = page.pixels()
    expect(first[0] > 500, f"the picture has {first[0]} colours")
    page.click("play")
    page.browser.until("Number(document.getElementById('player').dataset.frame) >= 2", 20)
    page.click("play")
    page.browser.evaluate(DRAWN)
    expect(page.pixels()[1] != first[1], f"playing shows frame {page.frame() + 1}, which looks different")
    at = page.frame()
    time.sleep(0.5)
    expect(page.frame() == at, "a pause stays")
    last = int(page.browser.evaluate("document.getElementById('player-frame').max"))
    page.choose("frame", last, "input")
    end = page.pixels()
    expect(page.frame() == last and end[1] != first[1], f"the slider leads to frame {last + 1}, the last one")
    expect(f"{last + 1} of {last + 1}" in page.text("time"), f"and says `{page.text('time')}`")
    page.click("next")
    expect(page.pixels() == end, "there is nothing after it")
    page.choose("frame", 0, "input")
    expect(page.pixels() == first, "the first frame looks as it did")
    page.choose("speed", 30)
    page.choose("frame", last, "input")
    page.click("play")
    page.browser.until("Number(document.getElementById('player').dataset.frame) < %d" % last, 20)
    page.click("play")
    expect(True, "at the end it begins again")
    page.choose("frame", 0, "input")
    return first


def steers(page, first):
    """Mouse and keys."""
    x, y = page.middle()
    seen = {first[1]}

    def differs(what):
        pixels = page.pixels()
        expect(pixels[1] not in seen and pixels[0] > 100, what)
        seen.add(pixels[1])

    page.browser.drag((x, y), (x + 90, y + 40))
    differs("a drag turns")
    page.browser.drag((x, y), (x - 60, y + 30), "right")
    differs("a right drag moves")
    page.browser.call("Input.dispatchMouseEvent", type="mouseWheel", x=x, y=y, deltaX=0, deltaY=-240)
    differs("the wheel zooms")
    page.browser.key("+")
    differs("a key zooms")
    page.click("reset")
    expect(page.pixels() == first, "the first view comes back")
    page.browser.key("ArrowRight")
    expect(page.pixels()[1] != first[1] and page.frame() == 1, "an arrow shows the next frame")
    page.browser.key(" ", "Space", " ")
    page.browser.until("document.getElementById('player').dataset.frame > 2", 20)
    page.browser.key(" ", "Space", " ")
    expect(page.text("play") == "▶", "space plays and pauses")
    page.choose("frame", 0, "input")


def colours(page, first):
    """Every choice of colour looks different and has a legend."""
    number = page.browser.evaluate("document.getElementById('player-colour').options.length")
    seen = {first[1]}
    for choice in range(number - 2):
        page.choose("frame", 5, "input")
        page.choose("colour", choice)
        pixels = page.pixels()
        expect(pixels[1] not in seen and pixels[2] > first[2] + 1,
               f"{pixels[2]} hues instead of {first[2]} by another quantity: `{page.text('scale')}`")
        seen.add(pixels[1])
    page.choose("colour", -2)
    expect(page.pixels()[1] not in seen and "meets something" in page.text("scale"), "by free flights")
    page.choose("colour", -1)
    page.choose("frame", 0, "input")
    expect(page.pixels() == first, "by species as before")
    return number - 1


def between(page):
    """Pictures between frames, and the text beside them."""
    page.choose("frame", 3, "input")
    frame, note = page.pixels(), page.text("note")
    expect("ntil the next frame" in note and "on smooth curves" in note, f"it says `{note}`")
    page.choose("speed", "0.2")
    page.click("play")
    time.sleep(1)
    page.click("play")
    shown = page.pixels()
    expect(page.frame() == 3 and shown[1] != frame[1], f"frame 4 moves on before frame 5 is there, {page.text('time')}")
    page.click("next")
    after = page.pixels()
    expect(page.frame() == 4 and after[1] not in (shown[1], frame[1]), "a step leads to frame 5")
    page.click("back")
    expect(page.pixels() == frame, "and one back to frame 4")
    page.click("between")
    page.click("play")
    time.sleep(1)
    page.click("play")
    expect(page.pixels() == frame and not page.browser.evaluate("document.getElementById('player-note').textContent"),
           "unless nothing is drawn between them")
    page.click("between")
    page.click("last")
    last = int(page.browser.evaluate("document.getElementById('player-frame').max"))
    page.browser.evaluate(DRAWN)
    expect(page.frame() == last, "to the end")
    page.choose("frame", last - 3, "input")
    page.choose("speed", 120)
    page.click("play")
    page.browser.until("Number(document.getElementById('player').dataset.frame) < %d" % (last - 3), 20)
    page.click("play")
    page.click("first")
    page.browser.evaluate(DRAWN)
    expect(page.frame() == 0, "and to the start")


def fits(page):
    """The picture and its controls fit the window and the whole screen."""
    box = "(() => { const box = document.getElementById('player').getBoundingClientRect(); return [box.top, box.bottom]; })()"
    top, bottom = page.browser.evaluate(box)
    expect(bottom - top <= 900, f"picture and controls are {bottom - top:.0f} pixels high")
    size = "(() => { const view = document.getElementById('player-view'); return [view.clientWidth, view.clientHeight]; })()"
    pressed = "document.getElementById('player-full').ariaPressed"
    before = page.browser.evaluate(size)
    page.browser.call("Runtime.evaluate", expression="document.getElementById('player-full').click()", userGesture=True)
    page.browser.until("document.fullscreenElement !== null")
    page.pixels()
    expect(page.browser.evaluate(size)[1] > before[1] and page.browser.evaluate(pressed) == "true", "it fills the screen")
    page.click("full")
    page.browser.until("document.fullscreenElement === null")
    page.pixels()
    expect(page.browser.evaluate(size) == before, "and goes back to its place")


def touches(page):
    """One finger scrolls the page; two fingers move the picture."""
    x, y = page.middle()
    before = page.pixels()

    def touch(*tracks):
        at = lambda place: [{"x": a + (c - a) * place, "y": b + (d - b) * place, "id": k} for k, (a, b, c, d) in enumerate(tracks)]
        page.browser.call("Input.dispatchTouchEvent", type="touchStart", touchPoints=at(0))
        for place in (0.5, 1):
            page.browser.call("Input.dispatchTouchEvent", type="touchMove", touchPoints=at(place))
        page.browser.call("Input.dispatchTouchEvent", type="touchEnd", touchPoints=[])
        return page.pixels()

    expect(touch((x, y, x + 10, y - 60)) == before, "one finger does not turn")
    turned = touch((x - 30, y, x + 30, y + 20), (x + 30, y, x + 90, y + 20))
    expect(turned[1] != before[1], "two fingers turn")
    expect(touch((x - 30, y, x - 80, y), (x + 30, y, x + 80, y))[1] != turned[1], "and pinch")
    page.click("reset")
    page.browser.evaluate("document.getElementById('player').scrollIntoView()")
    expect(page.pixels() == before, "and the first view comes back")


def toggles(page):
    """Shadows, and images of particles cut by a periodic side."""
    shown = page.pixels()
    seen = {shown[1]}
    for control in ("images", "shadows"):
        page.click(control)
        other = page.pixels()
        expect(other[1] not in seen, f"{control} change the picture")
        seen.add(other[1])
        page.click(control)
        expect(page.pixels() == shown, "and back")


def check_fluid(browser, path, pictures):
    page = Page(browser, path)
    page.open()
    first = plays(page)
    steers(page, first)
    expect(colours(page, first) == 3, "species, speed, neighbours within a well")
    toggles(page)
    between(page)
    touches(page)
    fits(page)
    expect(browser.evaluate("window.isBroken") is None, "names from files do nothing")
    expect(browser.evaluate("document.querySelectorAll('main img, main b, main i').length") == 0, "and are no markup")
    expect("insufficient data" in browser.evaluate("document.body.textContent"), "insufficient data is told")
    plots = browser.evaluate("document.querySelectorAll('svg.plot').length")
    expect(plots >= 5, f"{plots} plots")
    page.click("box")
    expect(page.pixels()[1] != first[1], "the box can be hidden")
    for scheme, width in (("light", 1280), ("dark", 1280), ("light", 400), ("dark", 400)):
        page.open(scheme, width)
        wide = browser.evaluate("document.documentElement.scrollWidth")
        expect(wide <= width and page.pixels()[0] > 200, f"fits {width} pixels, {scheme}")
        browser.evaluate("window.scrollTo(0, 0)")
        browser.screenshot(pictures / f"fluid_{scheme}_{width}.png", whole=True)


def check_hopper(browser, path, pictures):
    page = Page(browser, path)
    page.open()
    first = plays(page)
    steers(page, first)
    expect(colours(page, first) == 4, "species, speed, height, neighbours within a well")
    seen = {first[1]}
    for choice in ("solid", "hidden"):
        page.choose("static", choice)
        pixels = page.pixels()
        expect(pixels[1] not in seen, f"the mesh can be {choice}")
        seen.add(pixels[1])
    page.open("light")
    page.choose("frame", 11, "input")
    page.pixels()
    browser.screenshot(pictures / "hopper.png")


def check_funnel(browser, path, pictures):
    page = Page(browser, path)
    seen = set()
    for scheme in ("light", "dark"):
        page.open(scheme)
        page.choose("frame", 12, "input")
        shown = page.pixels()
        browser.screenshot(pictures / f"funnel_{scheme}.png")
        page.click("surfaces")
        hidden = page.pixels()
        page.click("surfaces")
        expect(page.pixels() == shown, f"the funnel can be hidden and shown, {scheme}")
        seen |= {shown[1], hidden[1]}
    expect(len(seen) == 4, "with the funnel the picture is another one")
    x, y = page.middle()
    page.browser.drag((x, y), (x + 120, y + 60))
    expect(page.pixels()[1] not in seen, "it turns with the particles")


def check_piston(browser, path, pictures):
    page = Page(browser, path)
    page.open()

    def row(frame):
        page.choose("frame", frame, "input")
        page.click("surfaces")
        page.pixels()
        page.browser.evaluate(ROW)
        page.click("surfaces")
        page.pixels()
        return page.browser.evaluate(ROW)

    last = int(page.browser.evaluate("document.getElementById('player-frame').max"))
    start, end = row(0), row(last)
    browser.screenshot(pictures / "piston.png")
    expect(start > end + 60 and end > 0, f"the piston goes from row {start:.0f} to row {end:.0f}")
    expect(abs(row(0) - start) < 1, "and back")


def check_rough(browser, path, pictures):
    page = Page(browser, path)
    page.open()
    # The scene asks for the colours of speeds.
    page.choose("colour", -1)
    first = page.pixels()
    expect(colours(page, first) == 3, "species, speed, spin")
    # All grains start with the same orientation, and turn later.
    page.choose("frame", 8, "input")
    turned = page.pixels()
    browser.screenshot(pictures / "rough.png")
    # A frame has 6 bytes per grain for the position, 4 for the orientation, one for each of two scalars, and 108 bits.
    data = base64.b64decode(page.browser.evaluate("document.getElementById('player-frames-0').textContent"))
    size = 12 * 108 + 14
    turns = lambda frame: [byte - 256 * (byte > 127) for byte in data[frame * size + 648 : frame * size + 1080]]
    expect(turns(0) == [0, 0, 0, 127] * 108, "no grain has turned at the start")
    lengths = [sum(part * part for part in turns(8)[4 * k : 4 * k + 4]) ** 0.5 for k in range(108)]
    expect(all(abs(length - 127) < 1.1 for length in lengths) and turns(8) != turns(0), "quaternions have a length of 1")
    page.click("marks")
    plain = page.pixels()
    expect(plain[1] != turned[1], "marks show how grains have turned")
    page.click("marks")
    expect(page.pixels() == turned, "and can be hidden")


# CSS classes of elements that are wider than the 688 pixels between the margins of a printed A4 page.
CUT = """[...document.querySelectorAll('table, pre, svg.plot, .wide')].filter((element) =>
  element.getBoundingClientRect().right > 689 || element.scrollWidth > element.clientWidth + 1).map((element) => element.className)"""

# Screen position of the middle point of a line in a plot.
POINT = """((figure, number) => {
  const plot = figure.querySelector('svg.plot');
  plot.scrollIntoView({ block: 'center', behavior: 'instant' });
  const values = JSON.parse(figure.querySelector('script.values').textContent);
  const line = values.lines[number];
  const at = Math.floor(line.x.length / 2);
  const [x, y] = [line.x[at], line.y[at]].map((value, k) => {
    const { isLogarithmic, ends: [low, high, from, to] } = values.axes[k];
    return from + ((isLogarithmic ? Math.log10(value) : value) - low) / (high - low) * (to - from);
  });
  const box = plot.getBoundingClientRect();
  const scale = box.width / plot.viewBox.baseVal.width;
  return [box.left + x * scale, box.top + y * scale];
})"""


def figure(title):
    return f"[...document.querySelectorAll('figure')].find((it) => it.querySelector('h4').textContent === '{title}')"


def note(browser, title):
    return browser.evaluate(f"(({{ hidden, textContent }}) => hidden ? '' : textContent)({figure(title)}.querySelector('.value'))")


def saves(browser, title, folder):
    """Saves a plot, and opens the file as a page."""
    browser.call("Page.setDownloadBehavior", behavior="allow", downloadPath=str(folder))
    before = set(folder.glob("*.svg"))
    colour = browser.evaluate("getComputedStyle(document.documentElement).backgroundColor")
    browser.evaluate(f"{figure(title)}.querySelector('.save').click()")
    end = time.monotonic() + 20
    while not (files := set(folder.glob("*.svg")) - before) and time.monotonic() < end:
        time.sleep(0.1)
    expect(len(files) == 1, f"`{title}` is saved as {[file.name for file in files]}")
    file = files.pop()
    text = file.read_text(encoding="utf-8")
    expect(colour in text and " class=" not in text and "var(" not in text, f"with the colours of the page, {colour}, and none of its styles")
    broken = browser.evaluate(
        f"new DOMParser().parseFromString({json.dumps(text)}, 'image/svg+xml').querySelectorAll('parsererror').length")
    expect(broken == 0 and title in text, "a sound file with its title")
    return file


def check_sweep(browser, path, pictures):
    browser.resize(1280, 900)
    browser.scheme("light")
    browser.open(path.as_uri())
    plots, buttons = browser.evaluate("['svg.plot', '.save'].map((it) => document.querySelectorAll(it).length)")
    expect(plots == buttons and plots >= 10, f"{plots} plots can be saved")
    family = "Radial distribution function"
    for title, line, words in (("Pressure", 0, ("±", "Δ / σ", "packing fraction")), (family, 1, ("packing fraction 0.3", "g(r)"))):
        x, y = browser.evaluate(f"{POINT}({figure(title)}, {line})")
        browser.call("Input.dispatchMouseEvent", type="mouseMoved", x=x, y=y)
        shown = note(browser, title)
        expect(all(word in shown for word in words), f"under the pointer: {shown.splitlines()}")
    browser.screenshot(pictures / "sweep_value.png")
    browser.call("Input.dispatchMouseEvent", type="mouseMoved", x=2, y=2)
    expect(note(browser, family) == "", "and nothing away from the plot")
    browser.evaluate(f"{figure('Pressure')}.querySelector('svg.plot').focus()")
    browser.key("ArrowRight")
    first = note(browser, "Pressure")
    browser.key("ArrowRight")
    expect(first and note(browser, "Pressure") not in ("", first), f"arrows lead along it: {note(browser, 'Pressure').splitlines()}")
    browser.key("ArrowDown")
    expect("measured" not in note(browser, "Pressure"), f"and to the other line: {note(browser, 'Pressure').splitlines()}")
    browser.key("Escape")
    expect(note(browser, "Pressure") == "", "Escape hides it")
    labels = browser.evaluate("[...document.querySelectorAll('svg.plot')].map((it) => it.querySelectorAll(':scope > text:not(.name)').length)")
    expect(min(labels) >= 6, f"all axes have three labels: {min(labels)} in a plot at least")
    tones = browser.evaluate(
        f"new Set([...{figure(family)}.querySelectorAll('svg svg > g > path')].map((it) => getComputedStyle(it).color)).size")
    expect(tones == 2, f"{tones} curves of a family have different colours")
    for scheme in ("light", "dark"):
        browser.scheme(scheme)
        folder = pictures / f"saved_{scheme}"
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir()
        saves(browser, "Pressure", folder)
        file = saves(browser, family, folder)
        browser.open(file.as_uri())
        browser.screenshot(pictures / f"saved_{scheme}.png")
        browser.open(path.as_uri())
    prints(browser, path)
    links = browser.evaluate("[...document.querySelectorAll('#runs tbody a')].map((it) => it.href)")
    expect(len(links) == 4 and all(link.endswith("/run.html") for link in links), f"{len(links)} links to pages of runs")
    browser.open(links[0])
    expect(browser.evaluate("document.querySelectorAll('svg.plot').length") > 3, "which open")


def prints(browser, path):
    """Nothing is cut off on A4 paper."""
    browser.call("Emulation.setDeviceMetricsOverride", width=688, height=1000, deviceScaleFactor=1, mobile=False)
    browser.call("Emulation.setEmulatedMedia", media="print", features=[])
    browser.open(path.as_uri())
    browser.evaluate("dispatchEvent(new Event('beforeprint'))")
    cut = browser.evaluate(CUT)
    expect(not cut, f"on paper nothing is cut: {cut}")
    expect(browser.evaluate("document.querySelectorAll('details:not([open])').length") == 0, "and nothing is folded")
    browser.evaluate("dispatchEvent(new Event('afterprint'))")
    browser.call("Emulation.setEmulatedMedia", media="", features=[])
    browser.resize(1280, 900)
    browser.open(path.as_uri())
    pages = browser.call("Page.printToPDF", 120, paperWidth=8.27, paperHeight=11.69)["data"]
    expect(len(pages) > 10000, f"{len(pages)} bytes of PDF")


def check_without_webgl(browser, path):
    script = browser.call("Page.addScriptToEvaluateOnNewDocument", source="HTMLCanvasElement.prototype.getContext = () => null")
    browser.open(path.as_uri())
    words = browser.evaluate("document.getElementById('player-message').innerText")
    expect("WebGL 2" in words, f"without WebGL: `{words}`")
    browser.call("Page.removeScriptToEvaluateOnNewDocument", identifier=script["identifier"])


def main():
    if sys.argv[1:] == ["--find"]:
        return 0 if find() else 1
    runs, pictures = map(Path, sys.argv[1:3])
    browser = Browser(find())
    try:
        for name, check in (("fluid", check_fluid), ("hopper", check_hopper), ("funnel", check_funnel),
                            ("piston", check_piston), ("rough", check_rough)):
            print(name)
            check(browser, runs / name / "report.html", pictures)
        prints(browser, runs / "fluid/report.html")
        print("sweep")
        check_sweep(browser, runs / "sweep/sweep.html", pictures)
        check_without_webgl(browser, runs / "fluid/report.html")
        expect(not browser.errors, f"no errors: {browser.errors}")
        own = ("/report.html", "/sweep.html", "/run.html", ".svg")
        saved = ("blob:null/", "blob:file:///")
        foreign = [url for url in browser.requests
                   if not url.startswith(saved) and not (url.startswith("file://") and url.endswith(own))]
        expect(not foreign, f"nothing is loaded from elsewhere: {foreign}")
    except Failure as failure:
        print(f"FAILED: {failure}\nerrors of the page: {browser.errors}", file=sys.stderr)
        return 1
    finally:
        browser.close()
    print("all as expected")
    return 0


sys.exit(main())
