/** Largest number of plots at once. */
const MOST_PLOTS = 4;

/** Shortest time between two redraws, in milliseconds. */
const PLOT_PAUSE = 100;

/** The plots beside the picture: available plots, visible plots, and their common cursor. */
class LivePlots {
  constructor(live) {
    this.live = live;
    this.container = document.getElementById("live-plots");
    this.chips = made("div", "live-chips", this.container);
    this.chips.setAttribute("role", "group");
    this.chips.setAttribute("aria-label", "Plots");
    this.grid = made("div", "live-plot-grid", this.container);
    this.plots = new Map();
    this.offered = [];
    this.chosen = undefined;
    this.queue = new Set();
    this.drawnAt = -Infinity;
    this.slowest = 0;
    live.listen("head", () => this.ask());
    live.listen("observables", ({ results }) => this.take(results));
    if (live.head) {
      this.ask();
    }
  }

  /** Requests the observables of the visible plots from the worker. Before the first choice, requests the energy. */
  ask() {
    const names = [...this.plots.keys()];
    this.live.send({ kind: "observe", names: names.length > 0 || this.chosen ? names : ["energy"] });
  }

  take(results) {
    if (results.offered.join() !== this.offered.join()) {
      this.offer(results);
    }
    this.results = results;
    this.plots.forEach((_, name) => results[name] && this.queue.add(name));
    if (!this.isDue && this.queue.size > 0) {
      this.isDue = true;
      requestAnimationFrame((now) => this.draw(now));
    }
  }

  /** Draws one plot per animation frame, because a frame must not take long. */
  draw(now) {
    const [name] = this.queue;
    const hasPaused = now - this.drawnAt >= PLOT_PAUSE || this.isDrawing;
    if (name !== undefined && hasPaused) {
      this.isDrawing = true;
      this.queue.delete(name);
      const began = performance.now();
      const plot = this.plots.get(name);
      if (plot && this.results[name]) {
        plot.draw(PLOT_KINDS[name].content(this.results));
        this.slowest = performance.now() - began;
      }
      if (this.queue.size === 0) {
        this.drawnAt = now;
        this.isDrawing = false;
      }
    }
    this.isDue = this.queue.size > 0;
    if (this.isDue) {
      requestAnimationFrame((later) => this.draw(later));
    }
  }

  /** Updates the available plots for a new scene. Plots that the user has chosen stay if they are available. */
  offer({ offered, shown }) {
    this.offered = offered;
    const kept = (this.chosen ?? []).filter((name) => offered.includes(name));
    const names = kept.length > 0 || this.chosen?.length === 0 ? kept : shown;
    this.buttons = new Map(
      offered.map((name) => {
        const button = document.createElement("button");
        button.type = "button";
        button.textContent = PLOT_KINDS[name].chip;
        button.addEventListener("click", () => this.toggle(name));
        return [name, button];
      }),
    );
    this.chips.replaceChildren(...this.buttons.values());
    this.container.hidden = offered.length === 0;
    this.show(names);
  }

  toggle(name) {
    const names = [...this.plots.keys()];
    this.chosen = names.includes(name) ? names.filter((one) => one !== name) : [...names, name].slice(-MOST_PLOTS);
    this.show(this.chosen);
  }

  /** Shows the named plots in this order. */
  show(names) {
    this.plots.forEach((plot, name) => {
      if (!names.includes(name)) {
        plot.remove();
        this.plots.delete(name);
      }
    });
    for (const name of names.filter((one) => !this.plots.has(one))) {
      const plot = new Plot(this.grid, {
        ...PLOT_KINDS[name],
        onCursor: (x) => this.point(plot, x),
      });
      this.plots.set(name, plot);
    }
    this.buttons.forEach((button, name) => button.setAttribute("aria-pressed", String(this.plots.has(name))));
    this.grid.dataset.count = String(this.plots.size);
    this.ask();
  }

  /** Shows the time under the pointer in all other plots over time. */
  point(source, x) {
    if (source.isTime) {
      this.plots.forEach((plot) => plot !== source && plot.isTime && plot.cursor(x));
    }
  }
}
