// Feeds bad scenes to the engine module. The module must not trap, must answer in time, must remain usable, and must
// give the same messages as the program.
//
//   node tests/browser/bad_scenes.mjs [COUNT] [--seed N] [--program PATH] [--compare N] [--module PATH] [--patience SECONDS]
//
// Uses the scenes of tests/bad_scenes/, which Python writes. Then uses mutations of these scenes and of configs/: cut,
// flipped, swapped, nested, random, or with other numbers.

import { spawnSync } from "node:child_process";
import { mkdtempSync, readFileSync, readdirSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";
import { Worker, isMainThread, parentPort, workerData } from "node:worker_threads";
import { classesOf, moduleOf, root } from "./scripts.mjs";

const { Engine } = classesOf(["engine.js"], "Engine");

const GOOD = `[space]
size = [10.0, 10.0, 10.0]
[[species]]
name = "A"
mass = 1.0
diameter = 1.0
[[interaction]]
species = ["A", "A"]
potential = "hard-sphere"
[[fill]]
species = "A"
arrangement = "sc"
count = 8
temperature = 1.0
[run]
until_time = 1e6
`;

/** Asks the engine about every text that comes; a trap ends the instance, and the next text gets another one. */
async function serve() {
  const module = await WebAssembly.compile(workerData.bytes);
  let engine = await Engine.of(module);
  const lives = () => !engine.start(GOOD).error && engine.advance(20) === "events" && engine.look().events === 20;
  parentPort.on("message", async ({ text }) => {
    const answer = {};
    try {
      Object.assign(answer, { checked: engine.check(text), phase: "check" });
      const started = engine.start(text);
      Object.assign(answer, { started: { error: started.error, line: started.line, isPlanned: started.isPlanned }, phase: "start" });
      if (!started.error) {
        answer.end = engine.advance(50);
        engine.look();
      }
      answer.lives = lives();
    } catch (error) {
      answer.trap = String(error.stack).split("\n").slice(0, 12).join("\n");
      engine = await Engine.of(module);
      answer.lives = lives();
    }
    answer.memory = engine.calls.memory.buffer.byteLength;
    // A WebAssembly instance never gives memory back.
    if (answer.memory > 1 << 29) {
      engine = await Engine.of(module);
    }
    parentPort.postMessage(answer);
  });
  parentPort.postMessage("ready");
}

/** Xorshift of Marsaglia. */
function generator(seed) {
  let state = (seed * 2654435761 + 1) >>> 0 || 1;
  const word = () => {
    state ^= state << 13;
    state ^= state >>> 17;
    state ^= state << 5;
    state >>>= 0;
    return state;
  };
  const below = (count) => word() % count;
  return { below, pick: (list) => list[below(list.length)] };
}

const NUMBERS = ["nan", "inf", "-inf", "1e400", "-1", '""', "0", "-0.0", "1e308", "5e-324", "1e-30", "1e30", "18446744073709551616", "9223372036854775807",
  "1000000000", "20000000", "4294967296", "65536", "1.5", "true", "[]", "{}", "[1.0]", "1979-05-27", "'x'", "0x7f"];

/** Changes that make a good scene bad, or a bad scene worse. */
const MUTATIONS = {
  truncate: (text, { below }) => text.slice(0, below(text.length + 1)),
  flip: (text, { below }) => {
    const at = below(text.length);
    return text.slice(0, at) + String.fromCharCode(text.charCodeAt(at) ^ (1 << below(7))) + text.slice(at + 1);
  },
  swap: (text, { below }) => {
    const lines = text.split("\n");
    const [a, b] = [below(lines.length), below(lines.length)];
    [lines[a], lines[b]] = [lines[b], lines[a]];
    return lines.join("\n");
  },
  drop: (text, { below }) => {
    const lines = text.split("\n");
    lines.splice(below(lines.length), 1 + below(2));
    return lines.join("\n");
  },
  repeat: (text, { below }) => {
    const lines = text.split("\n");
    const at = below(lines.length);
    lines.splice(at, 0, ...lines.slice(at, at + 1 + below(6)));
    return lines.join("\n");
  },
  number: (text, { below, pick }) => {
    const places = [...text.matchAll(/(?<=[=[,] ?)-?\d[\d._e+-]*/g)];
    const place = places.length > 0 ? pick(places) : { index: below(text.length + 1), 0: "" };
    return text.slice(0, place.index) + pick(NUMBERS) + text.slice(place.index + place[0].length);
  },
  word: (text, { pick }) => {
    const words = [...text.matchAll(/[a-z_]{3,}/g)];
    if (words.length < 2) {
      return text;
    }
    const [from, to] = [pick(words), pick(words)];
    return text.slice(0, from.index) + to[0] + text.slice(from.index + from[0].length);
  },
  nest: (text, { below, pick }) => {
    const depth = pick([3, 50, 200, 5000, 100000]);
    const at = text.indexOf("=", below(text.length)) + 1;
    return `${text.slice(0, at)} ${pick(["[", "{a=", "[{a=", "[[", "a.", "'''", '"""'] ).repeat(depth)}${text.slice(at)}`;
  },
  noise: (text, { below, pick }) => {
    const letters = Array.from({ length: 1 + below(60) }, () => String.fromCharCode(pick([below(32), below(128), below(0xd800), 0xd800 + below(0x800)])));
    const at = below(text.length + 1);
    return text.slice(0, at) + letters.join("") + text.slice(pick([at, text.length]));
  },
  splice: (text, { below }, other) => text.slice(0, below(text.length)) + other.slice(below(other.length)),
};

function mutated(sources, random) {
  const kinds = Object.keys(MUTATIONS);
  let text = random.pick(sources);
  const names = [];
  for (let count = 1 + random.below(3); count > 0; count -= 1) {
    const name = random.pick(kinds);
    names.push(name);
    text = MUTATIONS[name](text, random, random.pick(sources));
  }
  return { name: names.join(" "), text };
}

/** Answer of the program: the message without the frame that is drawn around it, and the line number. */
function program(path, file, text) {
  writeFileSync(file, text);
  const { status, stderr } = spawnSync(path, ["check", file], { encoding: "utf8", timeout: 60_000 });
  const line = stderr.match(/─\[[^\]]*scene\.toml:(\d+):\d+\]/)?.[1];
  return { status, line: line && Number(line), words: bare(stderr) };
}

const bare = (words) => words.replace(/[\s│·×╭╰─┬├╯╮┤▲┴]/g, "");

class Tally {
  constructor() {
    Object.assign(this, { good: 0, refused: 0, planned: 0, compared: 0, differs: 0, slowest: 0, largest: 0, failures: [] });
  }

  fail(what, scene, detail) {
    this.failures.push(`${what}: ${scene.name}\n${detail}\n--- ${JSON.stringify(scene.text.slice(0, 3000))}`);
  }
}

/** Scenes in a folder, whose URL ends with a slash. */
const scenesIn = (url) => readdirSync(url).filter((name) => name.endsWith(".toml")).map((name) => ({ name, text: readFileSync(new URL(name, url), "utf8") }));

/** Writes the scenes of tests/bad_scenes/ into a folder, and reads them. */
function badScenes(folder) {
  const { status, error, stderr } = spawnSync("python3", ["-B", fileURLToPath(new URL("tests/bad_scenes/scenes.py", root)), folder], { encoding: "utf8" });
  if (status !== 0) {
    throw error ?? new Error(stderr);
  }
  return scenesIn(pathToFileURL(`${folder}/`));
}

/** A worker that answers, or is replaced. */
class Asker {
  constructor(bytes, patience) {
    Object.assign(this, { bytes, patience });
  }

  async begin() {
    this.worker = new Worker(fileURLToPath(import.meta.url), { workerData: { bytes: this.bytes } });
    this.worker.on("error", (error) => this.done?.({ trap: String(error.stack) }));
    this.worker.on("message", (message) => this.done?.(message));
    await new Promise((done) => {
      this.done = done;
    });
  }

  async ask(text) {
    const answer = await new Promise((done) => {
      this.done = done;
      this.timer = setTimeout(() => done({ isLate: true }), this.patience * 1000);
      this.worker.postMessage({ text });
    });
    clearTimeout(this.timer);
    if (answer.isLate || (answer.trap && answer.lives === undefined)) {
      await this.worker.terminate();
      await this.begin();
    }
    return answer;
  }
}

function judge(scene, answer, tally, seconds) {
  const { checked, started } = answer;
  tally.slowest = Math.max(tally.slowest, seconds);
  tally.largest = Math.max(tally.largest, answer.memory ?? 0);
  if (answer.isLate) {
    tally.fail("NO ANSWER IN TIME", scene, `${seconds.toFixed(1)} s`);
  } else if (answer.trap) {
    tally.fail(`TRAP after ${answer.phase ?? "nothing"}`, scene, answer.trap);
  } else if (!answer.lives) {
    tally.fail("THE INSTANCE DOES NOT LIVE", scene, JSON.stringify(answer));
  } else if (Boolean(checked.error) !== Boolean(started.error) || checked.error !== started.error) {
    tally.fail("CHECK AND START DIFFER", scene, `${checked.error}\n${started.error}`);
  } else if (checked.error === "") {
    tally.fail("AN ERROR WITHOUT WORDS", scene, JSON.stringify(checked));
  } else {
    tally[checked.error ? "refused" : "good"] += 1;
  }
}

/**
 * Compares the message and the line with the program. Errors about memory or files, and errors that only a
 * page has, are not compared.
 */
function compare(scene, { checked }, tally, path, file) {
  if (!checked?.error || checked.isPlanned || /GiB|cannot read|file|browser|page/.test(checked.error)) {
    return;
  }
  const expected = program(path, file, scene.text);
  tally.compared += 1;
  const isSame = expected.status === 2 && expected.words.includes(bare(checked.error)) && (expected.line ?? null) === (checked.line ?? null);
  if (!isSame) {
    tally.differs += 1;
    tally.fail("OTHER WORDS THAN THE PROGRAM", scene, `${JSON.stringify(checked)}\n${JSON.stringify(expected)}`);
  }
}

async function main() {
  const words = process.argv.slice(2);
  const option = (name, standard) => (words.includes(name) ? words[words.indexOf(name) + 1] : standard);
  const count = Number(/^\d+$/.test(words[0] ?? "") ? words[0] : 1000);
  const random = generator(Number(option("--seed", "1")));
  const folder = mkdtempSync(join(tmpdir(), "carom-bad-"));
  const bad = badScenes(join(folder, "bad"));
  const sources = [...bad, ...scenesIn(new URL("configs/", root))].map(({ text }) => text);
  const bytes = moduleOf(option("--module", undefined));
  const path = option("--program", "");
  const comparisons = path ? Number(option("--compare", "300")) : 0;
  const asker = new Asker(bytes, Number(option("--patience", "2")));
  const tally = new Tally();
  await asker.begin();
  for (let index = 0; index < count; index += 1) {
    const scene = index < bad.length ? bad[index] : mutated(sources, random);
    const began = performance.now();
    const answer = await asker.ask(scene.text);
    judge(scene, answer, tally, (performance.now() - began) / 1000);
    if (tally.compared < comparisons) {
      compare(scene, answer, tally, path, join(folder, "scene.toml"));
    }
  }
  rmSync(folder, { recursive: true });
  await asker.worker.terminate();
  tally.failures.forEach((failure) => console.log(`${failure}\n`));
  const { refused, good, compared, slowest, largest, failures } = tally;
  console.log(`${count} scenes: ${refused} refused with a message, ${good} run, ${compared} compared with the program, ${failures.length} failures; `
    + `slowest answer ${slowest.toFixed(2)} s, most memory ${(largest / 2 ** 20).toFixed(0)} MiB`);
  process.exit(failures.length > 0 || refused === 0 ? 1 : 0);
}

await (isMainThread ? main() : serve());
