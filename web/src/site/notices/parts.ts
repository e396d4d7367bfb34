// The site's parts of the Connection screen.
import type { Host } from "../../lib/platform/host";
import ConnectionNotices from "./ConnectionNotices.svelte";
import ThisBrowser from "./ThisBrowser.svelte";

export const connectionParts = { connectionNotices: ConnectionNotices, connectionCard: ThisBrowser } satisfies Partial<Host>;
