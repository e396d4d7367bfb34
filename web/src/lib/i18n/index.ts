export { dictionary } from "./dictionary";
export * from "./formats";
export { language, localized, type Code } from "./language.svelte";
