// The scripts of pages for tests in Node.

import { readFileSync } from "node:fs";

export const root = new URL("../../", import.meta.url);
const live = new URL("src/view/live/", root);

/** Classes and functions of classic scripts, as a page has them in one scope. */
export function classesOf(sources, names) {
  const text = sources.map((name) => readFileSync(new URL(name, live), "utf8")).join("\n");
  return new Function(`"use strict"; ${text}; return { ${names} };`)();
}

/** WebAssembly of a module that `web/build` has made, in bytes. */
export function moduleOf(path = new URL("web/carom.module", root)) {
  const { Unpacker } = classesOf(["unpack.js"], "Unpacker");
  const file = readFileSync(path);
  return new Unpacker(new Uint8Array(file.subarray(file.indexOf(10) + 1))).unpack();
}
