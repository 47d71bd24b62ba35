// Tests the editor's TOML reader, completion, links and sliders without a browser:
// node tests/browser/editor_test.mjs

import assert from "node:assert/strict";
import { readFileSync, readdirSync } from "node:fs";
import { classesOf } from "./scripts.mjs";

const names = ["toml", "history", "share", "schema", "completion", "text", "sliders"].map((name) => `editor_${name}.js`);
const {
  Toml, tomlScalar, tomlNumber, TextHistory, textChange, shareFragment, sharedText, SHARE_LIMIT, SceneSchema, completions, linePieces,
  derivedSliders, namedSliders, sliderText, sliderValue, SliderScale, bytePlace,
} = classesOf(
  [...names, "editor.js"],
  "Toml, tomlScalar, tomlNumber, TextHistory, textChange, shareFragment, sharedText, SHARE_LIMIT, SceneSchema, completions, linePieces, "
    + "derivedSliders, namedSliders, sliderText, sliderValue, SliderScale, bytePlace",
);

const configs = new URL("../../configs/", import.meta.url);
const scenes = readdirSync(configs).filter((name) => name.endsWith(".toml"));
const read = (name) => readFileSync(new URL(name, configs), "utf8");
const raw = (toml, path) => toml.text.slice(toml.find(path).start, toml.find(path).end);

const tests = {
  "Every entry of every scene of configs is one that a second reading finds": () => {
    assert.ok(scenes.length > 20);
    for (const name of scenes) {
      const text = read(name);
      const toml = new Toml(text);
      // The text has one key for each line that begins with a key, and one table for each header.
      const isInside = (at) => [...toml.entries.values()].some(({ start, end }) => start < at && at < end);
      let [at, keys, headers] = [0, 0, 0];
      for (const line of text.split("\n")) {
        if (/^\s*[A-Za-z_][\w.-]*\s*=/.test(line) && !isInside(at)) {
          keys += 1;
        }
        headers += /^\[/.test(line) ? 1 : 0;
        at += line.length + 1;
      }
      const own = [...toml.entries.values()].filter((entry) => text.lastIndexOf("\n", entry.keyStart) + 1 === entry.keyStart && !isInside(entry.start));
      assert.equal(own.length, keys, name);
      assert.equal(toml.tables.length - 1, headers, name);
      assert.ok(!toml.tokens.some(([kind]) => kind === "error"), name);
    }
  },
  "Entries are found by the names of their tables, as the program finds them": () => {
    const toml = new Toml(read("silo.toml"));
    assert.equal(toml.get("surface.silo.restitution"), 0.6);
    assert.equal(toml.get("surface.gate.restitution"), 0.6);
    assert.equal(toml.get("surface.none.restitution"), undefined);
    assert.equal(toml.get("name.silo"), undefined);
    assert.equal(toml.numbered("surface.gate.restitution"), "surface.1.restitution");
    const changed = new Toml(toml.with("surface.gate.restitution", "0.25"));
    assert.deepEqual([0, 1].map((index) => changed.get(`surface.${index}.restitution`)), [0.6, 0.25]);
    const added = new Toml(toml.with("species.grain.charge", "2"));
    assert.equal(added.get("species.0.charge"), 2);
    assert.equal(new Toml("species = [{ name = \"a\" }, { name = \"b\", mass = 3 }]").get("species.b.mass"), 3);
  },
  "Pieces cover the text in order and without overlaps": () => {
    for (const name of scenes) {
      const toml = new Toml(read(name));
      let last = 0;
      for (const [kind, start, end] of toml.tokens) {
        assert.ok(start >= last && end > start, `${name}: ${kind} at ${start}`);
        last = end;
      }
    }
  },
  "Every value of every scene can be replaced in its place, and nothing else changes": () => {
    for (const name of scenes) {
      const text = read(name);
      for (const [path, { start, end }] of new Toml(text).entries) {
        const changed = new Toml(text).with(path, "12345");
        assert.equal(changed, `${text.slice(0, start)}12345${text.slice(end)}`);
        assert.equal(new Toml(changed).get(path), 12345, `${name}: ${path}`);
      }
    }
  },
  "Paths count arrays of tables": () => {
    const toml = new Toml(read("hopper.toml"));
    assert.equal(toml.count("mesh"), 7);
    assert.equal(toml.get("mesh.1.name"), "funnel");
    assert.equal(toml.get("mesh.6.spacing"), 2.75);
    assert.equal(toml.get("interaction.0.well_depth"), 0.5);
    assert.equal(toml.get("dynamics.gravity.2"), -1);
    assert.equal(toml.get("fill.0.region.upper.1"), 10.7);
    assert.equal(toml.get("space.x.restitution"), 0.4);
    assert.equal(toml.get("measure.flow.0.at"), 42);
    assert.equal(raw(toml, "dynamics.gravity"), "[0.0, 0.0, -1.0]");
  },
  "Strings and arrays over several lines, dotted and quoted keys": () => {
    const text = 'a.b = 1\n"c d" = """\n[x]\n# no comment """\ne = [\n  1, # one\n  [2, 3],\n]\n[t."u"]\nf = { g = [[4]], h.i = \'x\' }\n[[w]]\n[[w.v]]\nk = -inf\n[[w]]\n[[w.v]]\n[[w.v]]\nk = 0x1F\n';
    const toml = new Toml(text);
    assert.equal(toml.get("a.b"), 1);
    assert.ok(raw(toml, "c d").endsWith('comment """'));
    assert.equal(toml.get("e.1.1"), 3);
    assert.equal(toml.get("t.u.f.g.0.0"), 4);
    assert.equal(toml.get("t.u.f.h.i"), "x");
    assert.equal(toml.get("w.0.v.0.k"), -Infinity);
    assert.equal(toml.get("w.1.v.1.k"), 31);
    assert.deepEqual(toml.tables.map(({ at }) => at.join(".")), ["", "t.u", "w.0", "w.0.v.0", "w.1", "w.1.v.0", "w.1.v.1"]);
  },
  "Keys that are missing are inserted where they belong": () => {
    const text = "# title\n# more\n\n[space]\nsize = 1 # comment\n\n[[fill]]\n\n[[fill]]\nregion = { lower = 1 }\nnone = {}\n";
    const put = (path, value) => new Toml(text).with(path, value);
    assert.equal(put("seed", "7"), text.replace("# more\n", "# more\nseed = 7\n"));
    assert.equal(put("space.x", '"open"'), text.replace("# comment\n", '# comment\nx = "open"\n'));
    assert.equal(put("fill.0.count", "3"), text.replace("[[fill]]\n", "[[fill]]\ncount = 3\n"));
    assert.equal(new Toml(put("fill.1.count", "3")).get("fill.1.count"), 3);
    assert.equal(new Toml(put("fill.1.region.upper", "3")).get("fill.1.region.upper"), 3);
    assert.equal(new Toml(put("fill.1.region.upper", "3")).get("fill.1.region.lower"), 1);
    assert.ok(put("fill.1.none.upper", "3").includes("none = { upper = 3 }"));
    assert.equal(new Toml(put("dynamics.contact_time", "0.1")).get("dynamics.contact_time"), 0.1);
    assert.equal(put("fill.2.count", "3"), text);
    assert.equal(new Toml(new Toml("").with("seed", "1")).get("seed"), 1);
    assert.equal(new Toml(new Toml("[space]").with("space.x", "1")).get("space.x"), 1);
  },
  "Text that is no TOML is read to its end": () => {
    const text = read("hopper.toml");
    let state = 1;
    const random = (below) => {
      state = (state * 1103515245 + 12345) % 2147483648;
      return Math.floor((state / 2147483648) * below);
    };
    for (let k = 0; k < 3000; k += 1) {
      const at = random(text.length);
      const cut = text.slice(0, at) + "[]{}\"'=#,.\n\\\t\0é"[random(15)].repeat(1 + random(3)) + text.slice(at + random(20));
      const began = performance.now();
      const toml = new Toml(k % 3 ? cut : cut.slice(0, random(cut.length)));
      assert.ok(performance.now() - began < 500);
      assert.ok(toml.place);
    }
    for (const nested of ["[", "{", "a=[", "a={b=", "[[", '"""', "a=[[", "a.", "\r"]) {
      assert.ok(new Toml(nested.repeat(5000)));
    }
    assert.equal(new Toml('a = [1,\n[space]\nx = "open"').get("space.x"), "open", "brackets that are not closed");
    assert.equal(new Toml('a = { b = 1,\n[space]\nx = "open"').get("space.x"), "open", "braces that are not closed");
  },
  "Places of the caret": () => {
    const place = (text) => {
      const { path, role } = new Toml(text).place;
      return `${role} ${path.join(".")}`;
    };
    assert.equal(place(""), "key ");
    assert.equal(place("se"), "key ");
    assert.equal(place("[[fill]]\ncou"), "key fill.0");
    assert.equal(place("[[fill]]\n[[fill]]\n"), "key fill.1");
    assert.equal(place("[[fill]]\nregion = { lo"), "key fill.0.region");
    assert.equal(place("[[fill]]\nregion = { lower = [1], "), "key fill.0.region");
    assert.equal(place("[[fill]]\nregion = { shape = \"b"), "value fill.0.region.shape");
    assert.equal(place('[[interaction]]\npotential = "ha'), "value interaction.0.potential");
    assert.equal(place('[[interaction]]\npotential = '), "value interaction.0.potential");
    assert.equal(place('[[mesh]]\nopen = ["top", "'), "value mesh.0.open.1");
    assert.equal(place("[out"), "header out");
    assert.equal(place("[[measure.fl"), "header measure.fl");
    assert.equal(place("[run]\nuntil_time = 1\n"), "key run");
  },
  "Numbers": () => {
    assert.equal(tomlScalar("1_000.5e3"), 1000500);
    assert.equal(tomlScalar("-inf"), -Infinity);
    assert.equal(tomlScalar("quick"), undefined);
    assert.equal(tomlNumber(2), "2.0");
    assert.equal(tomlNumber(2, true), "2");
    assert.equal(tomlNumber(1e-7), "1e-7");
    assert.equal(tomlNumber(1e300), "1e300");
    assert.equal(tomlNumber(Infinity), "inf");
  },
};

/**
 * A schema with the features of the real schema: a choice of words, a condition, names, tables, and a value
 * of two forms.
 */
const schema = new SceneSchema({
  properties: {
    seed: { type: "integer", default: 0, description: "Seed." },
    space: {
      type: "object",
      description: "The box.",
      properties: { x: { anyOf: [{ type: "string", enum: ["open", "flat"] }, { type: "object", properties: { restitution: { type: "number" } } }] } },
    },
    interaction: {
      type: "array",
      items: {
        type: "object",
        required: ["potential"],
        properties: {
          potential: { type: "string", enum: ["hard-sphere", "square-well"], description: "Kind." },
          species: { type: "array", items: { type: "string" } },
          lambda: { type: "number" },
          restitution: { type: "number", default: 1 },
        },
        allOf: [{ if: { properties: { potential: { const: "hard-sphere" } } }, then: { properties: { lambda: false } } }],
      },
    },
    measure: { type: "object", properties: { flow: { type: "array", items: { type: "object", properties: { at: { type: "number" } } } } } },
  },
});

/** Completions at a bar in a text. */
function offered(marked) {
  const caret = marked.indexOf("|");
  const toml = new Toml(marked.replace("|", ""));
  const found = completions(toml, caret, schema);
  const accept = (offer) => toml.text.slice(0, found.start) + offer.insert + toml.text.slice(found.end);
  return found ? { words: found.offers.map(({ word }) => word), texts: found.offers.map(accept), offers: found.offers } : undefined;
}

Object.assign(tests, {
  "Completion of keys": () => {
    assert.deepEqual(offered("se|").texts, ["seed = "]);
    assert.deepEqual(offered("[[interaction]]\n|").words, ["potential", "species", "lambda", "restitution"]);
    assert.deepEqual(offered('[[interaction]]\npotential = "hard-sphere"\n|').words, ["species", "restitution"]);
    assert.deepEqual(offered('[[interaction]]\n[[interaction]]\npotential = "square-well"\n|\nspecies = []').words, ["lambda", "restitution"]);
    assert.deepEqual(offered("[[interaction]]\nres| = 1").texts, ["[[interaction]]\nrestitution = 1"]);
    assert.deepEqual(offered("[[interaction]]\nsp|").texts.slice(0, 2), ["[[interaction]]\nspecies = []", "[[interaction]]\n[space]\n"]);
    assert.equal(offered("[space]\nx = { |").words[0], "restitution");
    assert.deepEqual(offered("space.|").words, ["x"]);
    assert.equal(offered("[space] # s|"), undefined);
    assert.equal(offered("[[interaction]]\npotential = |").offers[0].about, "Kind.");
  },
  "Completion of values and names": () => {
    assert.deepEqual(offered('[[interaction]]\npotential = "ha|"').texts, ['[[interaction]]\npotential = "hard-sphere"']);
    assert.deepEqual(offered("[space]\nx = |").words, ['"open"', '"flat"']);
    assert.deepEqual(offered('[[species]]\nname = "grain"\n[[interaction]]\nspecies = ["|').words, ['"grain"']);
    assert.equal(offered("seed = 1|")?.words.length ?? 0, 0);
  },
  "Completion of headers": () => {
    assert.deepEqual(offered("[me|").texts, ["[measure]\n", "[[measure.flow]]\n"]);
    assert.deepEqual(offered("[[inter|]]\nx = 1").texts, ["[[interaction]]\nx = 1"]);
    assert.deepEqual(offered("[space]\n[sp|").words, ["space.x"]);
  },
  "Undo, redo and steps that belong together": () => {
    const history = new TextHistory("aa");
    history.note("aaa", "type", 1, 0);
    history.note("abaa", "type", 2, 10);
    assert.equal(history.steps.length, 1);
    history.note("abaax", "type", 5, 20);
    assert.equal(history.steps.length, 2);
    history.note("abcaa", undefined, undefined, 20);
    history.note("abcaa 1", "slider x", undefined, 30);
    history.note("abcaa 2", "slider x", undefined, 40);
    history.note("abcaa 12", "slider y", undefined, 50);
    assert.deepEqual([history.undo().text, history.undo().text, history.undo().text], ["abcaa 2", "abcaa", "abaax"]);
    assert.deepEqual([history.redo().text, history.redo().text, history.redo().text], ["abcaa", "abcaa 2", "abcaa 12"]);
    assert.equal(history.redo(), undefined);
    assert.deepEqual(textChange("abab", "ababab", 2), { at: 0, removed: "", inserted: "ab" });
  },
  "Pieces by line": () => {
    const text = 'a = """x\n# y\n"""\n\n[b] # c';
    const lines = linePieces(text, new Toml(text).tokens);
    assert.deepEqual(lines.map(({ words }) => words), text.split("\n"));
    assert.deepEqual(lines.map(({ pieces }) => pieces.map(([kind]) => kind)), [["key", "string"], ["string"], ["string"], [], ["table", "comment"]]);
    assert.deepEqual(lines[4].pieces, [["table", 1, 2], ["comment", 4, 7]]);
  },
  "Links carry scenes there and back": async () => {
    for (const name of scenes) {
      const fragment = await shareFragment(read(name));
      assert.match(fragment, /^scene=[\w-]+$/);
      assert.equal(await sharedText(`#${fragment}`), read(name), name);
    }
    assert.equal(await sharedText("#results"), undefined);
    assert.equal(await sharedText(""), undefined);
    assert.equal(await sharedText(`#${await shareFragment("é 日本 🎱")}`), "é 日本 🎱");
    for (const damaged of ["#scene=", "#scene=<img>", "#scene=AAAA", "#scene=!!!!", `#${(await shareFragment(read("hopper.toml"))).slice(0, 300)}`]) {
      await assert.rejects(sharedText(damaged), /damaged/, damaged);
    }
    await assert.rejects(sharedText(`#${await shareFragment("a".repeat(SHARE_LIMIT + 1))}`), /too long/);
  },
  "Sliders of all scenes write texts that have their values": () => {
    let [count, live] = [0, 0];
    for (const name of scenes) {
      const toml = new Toml(read(name));
      for (const slider of derivedSliders(toml)) {
        const scale = new SliderScale(slider);
        const value = sliderValue(toml, slider.key) ?? slider.standard;
        assert.ok(slider.from <= value && value <= slider.to, `${name}: ${slider.key} ${value} in ${slider.from} to ${slider.to}`);
        for (const place of [0, Math.floor(scale.steps / 3), scale.steps]) {
          const wanted = scale.value(place);
          const changed = new Toml(toml.with(slider.key, sliderText(toml, slider, wanted)));
          assert.ok(Math.abs(sliderValue(changed, slider.key) - wanted) <= 1e-5 * Math.abs(wanted), `${name}: ${slider.key} = ${wanted}`);
          assert.equal(scale.place(wanted), place, `${name}: ${slider.key} = ${wanted}`);
        }
        count += 1;
        live += slider.isLive ? 1 : 0;
      }
    }
    assert.ok(count > 60 && live > 15, `${count} sliders, ${live} live`);
  },
  "A vector keeps its direction, and has one when it comes back from nothing": () => {
    const toml = new Toml("[dynamics]\ngravity = [3.0, 0.0, -4.0]\n");
    const slider = { key: "dynamics.gravity" };
    assert.equal(sliderValue(toml, "dynamics.gravity"), 5);
    assert.equal(sliderText(toml, slider, 10), "[6.0, 0.0, -8.0]");
    const none = new Toml(toml.with("dynamics.gravity", sliderText(toml, slider, 0)));
    assert.equal(sliderText(none, slider, 5), "[3.0, 0.0, -4.0]");
  },
  "Sliders that a scene names": () => {
    const whole = new SceneSchema({ properties: { fill: { type: "array", items: { properties: { count: { type: "integer" } } } } } });
    const wanted = [{ key: "fill.0.count", from: 10, to: 1000, scale: "log" }, { key: "dynamics.gravity.2", label: "g", from: -2, to: 0 }, { key: "x", from: 1, to: 1 }, { from: 0, to: 1 }];
    const [one, other, ...none] = namedSliders(wanted, whole);
    assert.equal(none.length, 0);
    assert.deepEqual([one.label, one.isInteger, one.scale, one.isLive], ["particles", true, "log", undefined]);
    assert.deepEqual([other.label, other.isInteger, other.scale, other.isLive], ["g", false, "linear", true]);
  },
  "Ranges of bytes": () => {
    assert.deepEqual(bytePlace("é = 1\nü = 日本\n", 12, 6), { line: 2, column: 5, length: 2 });
    assert.deepEqual(bytePlace("a", 0, 1), { line: 1, column: 1, length: 1 });
    assert.equal(bytePlace("a", 5, 1).length, 0);
  },
});

let failed = 0;
for (const [name, test] of Object.entries(tests)) {
  try {
    await test();
  } catch (error) {
    failed += 1;
    console.log(`FAILED: ${name}\n${error.stack}`);
  }
}
console.log(`${Object.keys(tests).length} tests, ${failed} failed`);
process.exit(failed > 0 ? 1 : 0);
