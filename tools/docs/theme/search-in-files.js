// Pages that are opened as files (file:) may start no worker, so the search's worker runs in a hidden frame there.
if (location.protocol === "file:")
  window.Worker = class {
    onmessage = null;
    #waiting = [];
    #frame = document.body.appendChild(Object.assign(document.createElement("iframe"), { hidden: true }));

    constructor(script) {
      const { contentWindow: worker, contentDocument: page } = this.#frame;
      // Later and as a copy, as between threads.
      worker.postMessage = (data) => setTimeout(() => this.onmessage?.({ data: structuredClone(data) }));
      const element = page.createElement("script");
      element.src = new URL(script, location.href);
      element.onload = () => {
        const waiting = this.#waiting;
        this.#waiting = null;
        for (const data of waiting) this.postMessage(data);
      };
      page.body.append(element);
    }

    postMessage(data) {
      if (this.#waiting) this.#waiting.push(data);
      else setTimeout(() => this.#frame.contentWindow?.onmessage({ data: structuredClone(data) }));
    }

    terminate() {
      this.#frame.remove();
    }
  };
