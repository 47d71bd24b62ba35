// Valid keys, values and headers at a position in a scene, from the JSON Schema of scenes.

/** Keys whose value is a name, and the tables that define the name. */
const SCHEMA_NAMES = { species: "species", bond: "interaction", interaction: "interaction" };

const quoted = (word) => JSON.stringify(word);

const schemaValue = (value) => (typeof value === "object" ? "" : typeof value === "string" ? quoted(value) : String(value));

class SceneSchema {
  constructor(schema) {
    this.schema = schema;
  }

  /** Returns the schemas of a value. A value may have several forms. */
  at(path) {
    let nodes = this.forms(this.schema);
    for (const step of path) {
      const next = nodes.flatMap((node) => {
        const part = typeof step === "number" ? node.items : node.properties?.[step];
        return part ? this.forms(part) : [];
      });
      nodes = next;
    }
    return nodes;
  }

  forms(node) {
    const choices = node.anyOf ?? node.oneOf;
    // Choices without `type` or `enum` are conditions on keys, not forms of a value.
    return choices?.some(({ type, enum: words }) => type ?? words) ? choices.flatMap((choice) => this.forms(choice)) : [node];
  }

  /**
   * Returns the keys that can be added to a table: `{word, about, standard, type, isRequired}`. Keys that conflict with
   * present values are left out.
   */
  keys(path, toml) {
    const place = path.join(".");
    const prefix = place === "" ? "" : `${place}.`;
    const isThere = (key) => toml.entries.has(prefix + key) || (path.length === 0 && toml.tables.some(({ at }) => at[0] === key));
    const offers = [];
    for (const node of this.at(path)) {
      const barred = this.barred(node, (key) => toml.get(prefix + key));
      for (const [key, part] of Object.entries(node.properties ?? {})) {
        if (!isThere(key) && !barred.has(key) && !offers.some(({ word }) => word === key)) {
          const isRequired = node.required?.includes(key) ?? false;
          offers.push({ word: key, about: part.description ?? "", standard: schemaValue(part.default ?? {}), type: this.type(part), isRequired });
        }
      }
    }
    return offers.sort((one, other) => Number(other.isRequired) - Number(one.isRequired));
  }

  /** Returns the keys that conflict with present values. For example, a hard sphere cannot have `lambda`. */
  barred(node, get) {
    const keys = new Set();
    for (const { if: condition, then } of node.allOf ?? []) {
      const holds = Object.entries(condition?.properties ?? {}).every(([key, { const: word }]) => word !== undefined && get(key) === word);
      for (const [key, part] of holds ? Object.entries(then?.properties ?? {}) : []) {
        if (part === false) {
          keys.add(key);
        }
      }
    }
    return keys;
  }

  type(node) {
    const types = this.forms(node).map(({ type, enum: words }) => (words ? "string" : type));
    return types[0] ?? "";
  }

  values(path, toml) {
    const offers = [];
    for (const node of this.at(path)) {
      const words = node.enum ?? (node.const === undefined ? [] : [node.const]);
      offers.push(...words.map((word) => ({ word: schemaValue(word), about: node.description ?? "" })));
      if (node.type === "boolean") {
        offers.push(...["true", "false"].map((word) => ({ word, about: node.description ?? "" })));
      }
    }
    const key = path.findLast((step) => typeof step === "string");
    const table = SCHEMA_NAMES[key];
    if (table && path[0] !== table || (key === "species" && path[0] === "interaction")) {
      for (let index = 0; index < toml.count(table); index += 1) {
        const name = toml.get(`${table}.${index}.name`);
        if (typeof name === "string") {
          offers.push({ word: quoted(name), about: `${table} ${index} of this scene` });
        }
      }
    }
    return offers;
  }

  /** Returns the headers of a scene, such as `measure.flow`: `{word, about, isArray}`. */
  headers(toml) {
    const offers = [];
    const walk = (node, path) => {
      for (const [key, part] of Object.entries(node.properties ?? {})) {
        const word = [...path, key].join(".");
        for (const form of this.forms(part)) {
          const items = form.type === "array" && form.items?.type === "object";
          if (items || (form.type === "object" && !toml.tables.some(({ at }) => at.join(".") === word))) {
            offers.push({ word, about: (items ? form.items.description : form.description) ?? part.description ?? "", isArray: items });
          }
          if (form.type === "object" && path.length < 1) {
            walk(form, [key]);
          }
        }
      }
    };
    walk(this.schema, []);
    return offers;
  }

  about(path) {
    const nodes = this.at(path);
    return nodes.find(({ description }) => description)?.description ?? "";
  }
}
