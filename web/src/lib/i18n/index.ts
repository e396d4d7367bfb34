export { dictionary } from "./dictionary";
export * from "./formats";
export { unitAfter } from "./units";
export { language, localized, type Code } from "./language.svelte";
