// What this browser and its computer or phone are, in words for a report.

/** User-agent client hints, in browsers made of Chromium. Their usual name of a phone is “Android 10; K”, whatever the phone. */
interface Hints {
  readonly brands: readonly Brand[];
  getHighEntropyValues(
    wanted: readonly string[],
  ): Promise<{ platform?: string; platformVersion?: string; model?: string; fullVersionList?: readonly Brand[] }>;
}
interface Brand {
  readonly brand: string;
  readonly version: string;
}
type Agent = Pick<Navigator, "userAgent"> & { readonly userAgentData?: Hints };

/** A brand that a browser makes up, so that no page relies on the list: “Not;A=Brand”. */
const MADE_UP = /not.?a.?brand/i;

/** Name the browser with its version, the system with its own, and the phone's model: as far as the browser says so. */
export async function thisBrowser(agent: Agent = navigator): Promise<string> {
  const { userAgent, userAgentData } = agent;
  if (!userAgentData) return userAgent;
  try {
    const { platform, platformVersion, model, fullVersionList } = await userAgentData.getHighEntropyValues([
      "platformVersion",
      "model",
      "fullVersionList",
    ]);
    const named = (fullVersionList ?? userAgentData.brands).filter(({ brand }) => !MADE_UP.test(brand));
    // Chromium stands beside the name of a browser that is made of it.
    const own = named.find(({ brand }) => brand !== "Chromium") ?? named[0];
    const words = [own && `${own.brand} ${own.version}`, [platform, platformVersion].filter(Boolean).join(" "), model];
    return words.filter(Boolean).join(", ") || userAgent;
  } catch {
    return userAgent; // a policy may forbid the details
  }
}
