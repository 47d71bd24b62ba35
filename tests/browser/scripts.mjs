// Scripts of pages for tests in Node.

import { readFileSync } from "node:fs";

export const root = new URL("../../", import.meta.url);
const live = new URL("src/view/live/", root);

/** Classes and functions of classic scripts, as a page has them in one scope. */
export function classesOf(sources, names) {
  const text = sources.map((name) => readFileSync(new URL(name, live), "utf8")).join("\n");
  return new Function(`"use strict"; ${text}; return { ${names} };`)();
}
