import { loadPyodide } from "pyodide";
import { expect, it, vi } from "vitest";
import { endsWith } from "./program";

it("a Python that has failed for good says so, at once", async () => {
  vi.spyOn(console, "error").mockReturnValue();
  const python = await loadPyodide();
  const ended = vi.fn();
  endsWith(python, ended);
  expect(() => python.runPython("1 / 0")).toThrow("ZeroDivisionError");
  expect(ended).not.toHaveBeenCalled();
  expect(() => python.runPython("import ctypes; ctypes.string_at(-1, 9)")).toThrow();
  expect(ended).toHaveBeenCalledOnce();
  expect(String(ended.mock.calls[0])).toContain("memory");
});
