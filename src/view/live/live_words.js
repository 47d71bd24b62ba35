const COUNT_WORDS = {
  core: "contacts of cores", capture: "captures", release: "escapes", bounce: "bounces inside a well", bond: "bonds", wall: "walls", thermostat: "thermostat",
};

const liveNumber = (x) => Math.round(x).toLocaleString("en").replaceAll(",", "\u202f");

/** Returns a rate with two digits, such as 4.6 million, 310 000 or 12. */
function liveRate(rate) {
  if (rate >= 1e6) {
    return `${(rate / 1e6).toFixed(1)} million`;
  }
  const unit = 10 ** Math.max(0, Math.floor(Math.log10(Math.max(rate, 1))) - 1);
  return liveNumber(Math.round(rate / unit) * unit);
}

/** Returns a time with the digits that can be read at a speed. */
const liveTime = (time, speed) => time.toFixed(Math.max(0, Math.min(9, Math.ceil(1 - Math.log10(speed)))));

function liveScale(live) {
  const { head, picture } = live;
  const parts = document.createDocumentFragment();
  const write = (words, className) => {
    const span = liveTag("span", words);
    span.className = className;
    parts.append(span);
    return span;
  };
  const scale = picture.frame?.scale;
  if (scale) {
    const name = { speed: "speed", neighbours: "neighbours within 1.4 diameters", history: `${"xyz"[scale.axis]} at the start` }[scale.channel];
    write(name, "what");
    write(liveShort(scale.low), "end");
    write("", "bar").style.background = `linear-gradient(to right, ${VIRIDIS.map(css).join(", ")})`;
    write(scale.channel === "history" ? liveShort(scale.high) : `${liveShort(scale.high)} and more`, "end");
  } else {
    const palette = speciesColours(head.species, picture.scheme.fixed);
    head.species.forEach(({ name, isStatic }, index) => {
      write("", "dot").style.background = css(palette[index]);
      write(isStatic ? `${name} (static)` : name, "what");
    });
  }
  liveElement("scale").replaceChildren(parts);
}

const liveShort = (x) => String(Number(x.toPrecision(2)));

function liveCounts({ counts = {}, events }) {
  const list = document.createDocumentFragment();
  const all = Object.entries(counts).filter(([, count]) => count > 0);
  for (const [kind, count] of all.length > 0 ? all : [["events", events]]) {
    list.append(liveTag("dt", COUNT_WORDS[kind] ?? kind), liveTag("dd", liveNumber(count)));
  }
  liveElement("counts").replaceChildren(list);
}
