import js from "@eslint/js";
import svelte from "eslint-plugin-svelte";
import { defineConfig, globalIgnores } from "eslint/config";
import ts from "typescript-eslint";
import svelteConfig from "./svelte.config.js";

export default defineConfig(
  globalIgnores(["public", "src/site/public", "src/lib/api/schema.ts"]),
  { linterOptions: { reportUnusedDisableDirectives: "error" } },
  js.configs.recommended,
  ts.configs.recommended,
  svelte.configs.recommended,
  svelte.configs.prettier,
  {
    rules: {
      "no-undef": "off", // TypeScript knows the names, of the browser as well.
      "@typescript-eslint/no-unused-vars": ["error", { argsIgnorePattern: "^_", destructuredArrayIgnorePattern: "^_" }],
      // Sets and maps are parts of a value that is replaced as a whole, or caches that no view watches.
      "svelte/prefer-svelte-reactivity": "off",
    },
  },
  { files: ["**/*.svelte"], languageOptions: { parserOptions: { parser: ts.parser, svelteConfig } } },
  // What comes from the API has the types of schema.ts. A cast is for what TypeScript can't know, and says what that is.
  {
    files: ["src/**"],
    ignores: ["**/*.test.ts"],
    rules: { "@typescript-eslint/consistent-type-assertions": ["error", { assertionStyle: "never" }] },
  },
  // With types, where they cost little and the types are all there: svelte-check knows those inside of components, and tests fake what they need.
  {
    files: ["src/**/*.ts"],
    ignores: ["**/*.test.ts"],
    extends: [ts.configs.recommendedTypeChecked],
    languageOptions: { parserOptions: { projectService: true } },
    // A listener may be async: what it calls says by itself what went wrong.
    rules: { "@typescript-eslint/no-misused-promises": ["error", { checksVoidReturn: false }] },
  },
);
