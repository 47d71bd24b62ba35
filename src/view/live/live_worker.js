/** Wall time without an answer before the page offers to start again `[ms]`. */
const PATIENCE = 3000;

/**
 * Connection to the worker that runs the engine. It sends messages, matches answers to questions, and replaces a silent
 * worker.
 */
class LiveWorker {
  constructor(files, hear) {
    this.files = files;
    this.hear = hear;
    this.source = URL.createObjectURL(new Blob([document.getElementById("worker-source").textContent], { type: "text/javascript" }));
    this.questions = new Map();
    this.number = 0;
    this.begin();
  }

  begin() {
    this.worker?.terminate();
    for (const answer of this.questions.values()) {
      answer({ error: "the engine was started again" });
    }
    this.questions.clear();
    this.worker = new Worker(this.source);
    this.askedAt = undefined;
    this.worker.onmessage = ({ data }) => {
      this.askedAt = undefined;
      const answer = this.questions.get(data.number);
      if (answer && data.number !== undefined) {
        this.questions.delete(data.number);
        answer(data);
      }
      this.hear(data);
    };
    this.worker.onerror = (event) => this.hear({ kind: "error", error: `the worker has failed: ${event.message}`, isTrap: true });
    this.send({ kind: "module", text: document.getElementById("module").textContent.trim(), files: this.files });
  }

  send(message, buffers = []) {
    if (message.kind !== "module" && message.kind !== "run" && message.kind !== "pause") {
      this.askedAt ??= performance.now();
    }
    this.worker.postMessage(message, buffers);
  }

  ask(message) {
    this.number += 1;
    const { number } = this;
    return new Promise((answer) => {
      this.questions.set(number, answer);
      this.send({ ...message, number });
    });
  }

  /** Returns the time without an answer if it exceeds `PATIENCE` `[ms]`, else 0. */
  silence() {
    const silence = this.askedAt === undefined ? 0 : performance.now() - this.askedAt;
    return silence > PATIENCE ? silence : 0;
  }
}
