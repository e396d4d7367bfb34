// The site's page: starts the program in a worker of this tab, shows how far it is, then mounts the ordinary page over it.
import { mount, unmount } from "svelte";
import "../lib/platform/theme.svelte";
import Boot from "./boot/Boot.svelte";
import { hindrance } from "./boot/hindrance";
import { keepsFiles } from "./boot/keepsFiles";
import { shown } from "./boot/start.svelte";
import { ProgramEnded, type Port } from "./program/endpoint";
import { nameOf, type Role } from "./program/messages";
import { loadAnew } from "./offline/anew";
import { installing } from "./offline/installing.svelte";
import { Program } from "./program/program";
import { incoming } from "./shared/incoming.svelte";
import { OneTab, type Owner } from "./tabs/oneTab";
import { accessHere, memoryIsScarce } from "./usb/access";
import { HANGS } from "./within";
import workerScript from "./worker/worker.ts?worker&url";

installing.watch();
incoming.watch(window);
shown.loadAnew = () => loadAnew(new URL(".", location.href));

const target = document.getElementById("page")!;
target.replaceChildren();
const boot = mount(Boot, { target });

/**
 * A worker has the policy of its own script's headers, which a static host does not send. One whose script is a blob has this page's: no
 * code in it can ask another host, on the first visit either.
 */
const worker = (role: Role): Port => {
  const script = `import ${JSON.stringify(new URL(workerScript, location.href).href)}`;
  const url = URL.createObjectURL(new Blob([script], { type: "text/javascript" }));
  return new Worker(url, { type: "module", name: nameOf(role, accessHere()) });
};

let program: Program | null = null;
const owner: Owner = { refusal: () => null, leave: () => program?.terminate(), restart: () => location.reload() };

/** Wait until no other tab has the program. Without locks (plain http) nothing is kept that two could spoil. */
async function alone(): Promise<void> {
  if (!navigator.locks) return;
  const tab = new OneTab(navigator.locks, new BroadcastChannel("mikas.tabs"));
  shown.ask = async () => {
    shown.start = { kind: "elsewhere", asked: true, refusal: null };
    const refusal = await tab.ask();
    if (refusal !== null) shown.start = { kind: "elsewhere", asked: false, refusal };
  };
  // The tab that has the program may take a new version into use: this one's files are gone then.
  const reload = () => location.reload();
  navigator.serviceWorker?.addEventListener("controllerchange", reload);
  await tab.become(owner, () => (shown.start = { kind: "elsewhere", asked: false, refusal: null }));
  navigator.serviceWorker?.removeEventListener("controllerchange", reload);
  shown.start = { kind: "loading", progress: null };
}

async function start(): Promise<void> {
  const why = hindrance();
  if (why !== null) return void (shown.start = { kind: "impossible", why });
  await alone();
  program = new Program(worker, keepsFiles(), memoryIsScarce());
  program.line.onprogress = (progress) => (shown.start = { kind: "loading", progress });
  // The page itself comes along while the program starts.
  const [{ run }] = await Promise.all([import("./run"), program.line.ready]);
  await unmount(boot);
  run(program, owner, target);
}

start().catch((error: unknown) => {
  const hangs = error instanceof DOMException && error.name === HANGS ? "hangs" : null;
  const known = error instanceof ProgramEnded && error.why !== "missing" ? (error.why ?? null) : hangs;
  const kept = navigator.serviceWorker?.controller != null; // so no network is needed
  const why = known ?? (navigator.onLine || kept ? "broken" : "offline");
  shown.start = { kind: "broken", message: error instanceof Error ? error.message : String(error), why };
});
