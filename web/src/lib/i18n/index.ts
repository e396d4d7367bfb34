export { dictionary } from "./dictionary";
export * from "./formats";
export * from "./numberField";
export { language, localized, type Code } from "./language.svelte";
