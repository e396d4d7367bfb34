export { dictionary } from "./dictionary";
export * from "./formats";
export { language, say, type Code } from "./language.svelte";
