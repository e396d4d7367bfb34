// The page's end of what is shared or opened with it. Any tab may be shown then; the one that has the program adds the recordings.
import { watch } from "../../lib/platform/watch.svelte";
import { CHANNEL, Inbox, type News } from "./inbox";

/** What is used of a file that the system opens with the installed page; TypeScript does not know the queue. */
interface Launch {
  readonly files?: readonly { getFile(): Promise<File> }[];
}
declare global {
  interface Window {
    launchQueue?: { setConsumer(consumer: (launch: Launch) => void): void };
  }
}

export class Incoming {
  /** What came to this tab, until it is said. */
  news = $state<News | null>(null);
  private add: ((file: File) => Promise<unknown>) | null = null;
  private adding = Promise.resolve();

  constructor(
    private readonly inbox: Inbox | null,
    private readonly channel: Pick<BroadcastChannel, "postMessage" | "onmessage">,
  ) {
    channel.onmessage = () => void this.deliver();
  }

  /** See whether this tab was shown because of a share, or a file that was opened. */
  watch(page: Pick<Window, "launchQueue" | "location" | "history">): void {
    const { search, pathname, hash } = page.location;
    const news = new URLSearchParams(search).get("shared");
    if (isNews(news)) {
      this.news = news;
      page.history.replaceState(null, "", pathname + hash); // a reload is no second share
    }
    page.launchQueue?.setConsumer(({ files }) => void this.opened(files ?? []));
  }

  /** This tab has the program: give it what is there and what will come. */
  attend(add: (file: File) => Promise<unknown>, say: (news: News) => void): void {
    this.add = add;
    void this.deliver();
    $effect.root(() =>
      watch(
        () => this.news,
        (news) => {
          this.news = null;
          if (news !== null && news !== "some") say(news);
        },
      ),
    );
  }

  private async opened(files: NonNullable<Launch["files"]>): Promise<void> {
    if (files.length === 0) return; // an ordinary start
    const read = await Promise.all(files.map((file) => file.getFile())).catch(() => null);
    this.news = read === null ? "failed" : ((await this.inbox?.put(read)) ?? "failed");
    this.channel.postMessage(this.news);
    await this.deliver();
  }

  /** One after the other: two deliveries at once would add the same file twice. */
  private deliver(): Promise<void> {
    this.adding = this.adding.then(() => (this.add && this.inbox ? this.inbox.empty(this.add) : undefined)).catch(() => undefined);
    return this.adding;
  }
}

const isNews = (it: string | null): it is News => it === "some" || it === "none" || it === "full" || it === "failed";

/** That of this tab. */
export const incoming = new Incoming(
  // Over plain http there is no cache.
  "caches" in globalThis && "location" in globalThis ? new Inbox(new URL(".", location.href), caches) : null,
  globalThis.BroadcastChannel ? new BroadcastChannel(CHANNEL) : { postMessage: () => undefined, onmessage: null },
);
