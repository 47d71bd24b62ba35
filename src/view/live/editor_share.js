// A scene in the fragment of a link. Browsers do not send the fragment to the server.

/** Largest size of a scene in a link, in bytes. */
const SHARE_LIMIT = 1 << 20;

const SHARE_KEY = "scene=";

async function shareThrough(bytes, stream, limit = Infinity) {
  const writer = stream.writable.getWriter();
  // If the write fails, the read below reports the error.
  writer.write(bytes).then(() => writer.close()).catch(() => {});
  const reader = stream.readable.getReader();
  const parts = [];
  let length = 0;
  for (;;) {
    const { done, value } = await reader.read();
    if (done) {
      break;
    }
    length += value.length;
    if (length > limit) {
      await reader.cancel().catch(() => {});
      throw new Error("The scene in this link is too long.");
    }
    parts.push(value);
  }
  const joined = new Uint8Array(length);
  let at = 0;
  for (const part of parts) {
    joined.set(part, at);
    at += part.length;
  }
  return joined;
}

async function shareFragment(text) {
  const packed = await shareThrough(new TextEncoder().encode(text), new CompressionStream("deflate-raw"));
  let letters = "";
  for (const byte of packed) {
    letters += String.fromCharCode(byte);
  }
  return SHARE_KEY + btoa(letters).replaceAll("+", "-").replaceAll("/", "_").replace(/=+$/, "");
}

/** Returns the text in a fragment, or undefined if there is none. Rejects damaged or long texts. */
async function sharedText(fragment) {
  const found = fragment.replace(/^#/, "");
  if (!found.startsWith(SHARE_KEY)) {
    return undefined;
  }
  const letters = found.slice(SHARE_KEY.length);
  if (letters.length > SHARE_LIMIT) {
    throw new Error("The scene in this link is too long.");
  }
  if (!/^[\w-]+$/.test(letters)) {
    throw new Error("The scene in this link is damaged.");
  }
  try {
    const packed = Uint8Array.from(atob(letters.replaceAll("-", "+").replaceAll("_", "/")), (letter) => letter.charCodeAt(0));
    const bytes = await shareThrough(packed, new DecompressionStream("deflate-raw"), SHARE_LIMIT);
    return new TextDecoder("utf-8", { fatal: true }).decode(bytes);
  } catch (error) {
    throw /too long/.test(error.message) ? error : new Error("The scene in this link is damaged.");
  }
}
