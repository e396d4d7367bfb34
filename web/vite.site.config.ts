// The page without installation: the same page, and the program in workers beside it. `python -m tools.site` runs this
// (`make site`): it says where to, and which files the workers will load.
import { svelte } from "@sveltejs/vite-plugin-svelte";
import { defineConfig } from "vite";
import desktop from "./vite.config.ts";

export default defineConfig({
  plugins: [svelte()],
  // Any folder of any host: no address begins at the host's root.
  base: "./",
  publicDir: process.env.MIKAS_SITE_PUBLIC ?? "public",
  define: { __PROGRAM__: process.env.MIKAS_SITE_PROGRAM ?? "null" },
  build: {
    outDir: process.env.MIKAS_SITE_OUT ?? "../build/site",
    emptyOutDir: true,
    // Browsers too old for the program are told so: they have to understand the page that says it.
    target: desktop.build!.target,
    assetsInlineLimit: 0,
    modulePreload: { polyfill: false },
    reportCompressedSize: false,
    chunkSizeWarningLimit: 1000, // the whole page, as on a desktop
    rolldownOptions: {
      checks: { pluginTimings: false }, // slow only on a machine that is busy
      input: { site: "site.html", "service-worker": "src/site/serviceWorker.ts" },
      output: { entryFileNames: ({ name }) => (name === "service-worker" ? "[name].js" : "assets/[name]-[hash].js") },
    },
  },
  worker: { format: "es" },
});
