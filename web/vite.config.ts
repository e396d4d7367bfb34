// The page is served under `default-src 'self'`: nothing inline, no data: addresses, no eval.
import { svelte } from "@sveltejs/vite-plugin-svelte";
import { svelteTesting } from "@testing-library/svelte/vite";
import { defineConfig } from "vitest/config";

// `npm run dev` talks to a program started by hand: `mikas demo --no-browser` says its address.
const server = process.env.MIKAS_URL ?? "http://127.0.0.1:8071";

export default defineConfig({
  // Vitest compiles for node otherwise, where no effect runs.
  plugins: [svelte({ dynamicCompileOptions: () => (process.env.VITEST ? { generate: "client" } : undefined) })],
  build: {
    outDir: process.env.MIKAS_PAGE_OUT ?? "../src/mikas/dashboard/page",
    emptyOutDir: true,
    target: ["chrome111", "firefox114", "safari16.4"],
    assetsInlineLimit: 0,
    modulePreload: { polyfill: false },
    reportCompressedSize: true,
  },
  server: {
    proxy: {
      // The server accepts only its own Host and Origin; the proxy speaks in its name.
      "/api": { target: server, changeOrigin: true, ws: true, headers: { origin: server } },
    },
  },
  test: {
    restoreMocks: true,
    unstubGlobals: true,
    // No test here is about time, and loading a Python takes seconds on a busy computer.
    testTimeout: 60_000,
    // A process of its own for each file takes four times as long. So nothing may be left behind.
    isolate: false,
    projects: [
      {
        extends: true,
        // The page's own logic; Svelte's runes need the browser's half of Svelte.
        resolve: {
          conditions: ["browser"],
          alias: [{ find: /^svelte$/, replacement: new URL("node_modules/svelte/src/index-client.js", import.meta.url).pathname }],
        },
        test: { name: "logic", include: ["src/**/[a-z]*.test.ts"], environment: "node" },
      },
      {
        extends: true,
        // Tests of a component have its name.
        plugins: [svelteTesting({ autoCleanup: false })],
        test: { name: "components", include: ["src/**/[A-Z]*.test.ts"], environment: "happy-dom", isolate: true },
      },
    ],
  },
});
