import { fireEvent, screen } from "@testing-library/svelte";
import { afterEach, beforeEach, expect, it, vi } from "vitest";
import { eachOnItsOwnPage, page } from "../../../test/pageRig";
import ShareButton from "./ShareButton.svelte";

eachOnItsOwnPage();

const share = vi.fn<(data: ShareData) => Promise<void>>();
let isActive: boolean;

beforeEach(() => {
  isActive = true;
  share.mockReset().mockResolvedValue();
  vi.stubGlobal("navigator", {
    language: "en",
    canShare: () => true,
    share,
    get userActivation() {
      return { isActive };
    },
  });
});
afterEach(() => void vi.unstubAllGlobals());

function shown() {
  const made = vi.fn(() => Promise.resolve("1;2"));
  const { show, stores } = page();
  show(ShareButton, { name: "drive.csv", make: made });
  return { made, stores };
}

const press = async (name: string) => {
  await fireEvent.click(screen.getByRole("button", { name }));
};

it("a file that is made at once is shared by one touch", async () => {
  shown();
  await press("Share drive.csv");
  await vi.waitFor(() => expect(share).toHaveBeenCalledOnce());
  expect(share.mock.calls[0]![0].files![0]!.name).toBe("drive.csv");
});

it("one that takes long asks for another touch, and is not made again", async () => {
  const { made } = shown();
  isActive = false;
  await press("Share drive.csv");
  await screen.findByRole("button", { name: "Share now: drive.csv" });
  expect(share).not.toHaveBeenCalled();
  isActive = true;
  await press("Share now: drive.csv");
  expect(share).toHaveBeenCalledOnce();
  expect(made).toHaveBeenCalledOnce();
  await screen.findByRole("button", { name: "Share drive.csv" });
});

it("a file that the browser refuses is saved, and the page says where it is", async () => {
  const { stores } = shown();
  share.mockRejectedValue(new DOMException("Permission denied", "NotAllowedError"));
  const saved = vi.spyOn(HTMLAnchorElement.prototype, "click").mockReturnValue();
  await press("Share drive.csv");
  await vi.waitFor(() => expect(saved).toHaveBeenCalledOnce());
  expect(stores.toasts.shown[0]!.text()).toMatch(/drive\.csv over\. It was saved to the downloads/);
});

it("a browser that shares no files has no button", () => {
  vi.stubGlobal("navigator", { language: "en" });
  shown();
  expect(screen.queryByRole("button")).toBeNull();
});
