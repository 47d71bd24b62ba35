// Unpacks and starts the compressed scripts of the page.
(async () => {
  const letters = document.getElementById("scripts").textContent.trim();
  const packed = Uint8Array.from(atob(letters), (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  const { texts, program } = await new Response(stream).json();
  const add = (text, named) => {
    const element = Object.assign(document.createElement("script"), named);
    element.textContent = text;
    document.body.append(element);
  };
  for (const [id, text] of Object.entries(texts)) {
    add(text, { id, type: "text/plain" });
  }
  add(program, {});
})().catch((error) => {
  const note = document.createElement("p");
  note.textContent = `This page cannot be unpacked, which takes a browser of 2023 or later: ${error.message}`;
  document.querySelector("main").prepend(note);
});
