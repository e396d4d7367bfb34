// Written anew at each call, so no line break is a person's choice: objects and tags close up wherever they fit.
export default {
  printWidth: 140,
  tabWidth: 2,
  objectWrap: "collapse",
  bracketSameLine: true,
  plugins: ["prettier-plugin-svelte"],
  overrides: [
    { files: "*.svelte", options: { parser: "svelte" } },
    // A table of texts: grep finds a text with its key and its translation in one line.
    { files: ["messages.ts", "words.ts"], options: { printWidth: 320 } },
  ],
};
