// The position of the device on which this page is, by its browser: sent to the program while it is an instrument and a person wants that.
import { ApiError } from "../../../lib/api/http";
import type { Position } from "../../../lib/api/types";
import { loadSetting, saveSetting } from "../../../lib/platform/storage";

const SETTING = "position";

/** Why none is sent. `plain`: the page is not encrypted; `none`: this browser knows no positions. */
export type PositionState = "off" | "waiting" | "sent" | "refused" | "unavailable" | "plain" | "none";

/** What a browser gives, as the API takes it: a speed or a heading that is not known is null there, or NaN while the device stands. */
export function positionOf({ coords }: GeolocationPosition): Position {
  const known = (value: number | null) => (value !== null && Number.isFinite(value) ? value : null);
  return {
    latitude: coords.latitude,
    longitude: coords.longitude,
    altitude: known(coords.altitude),
    speed: known(coords.speed),
    heading: known(coords.heading),
  };
}

export class OwnPosition {
  /** A person wants this device's position to be sent, also after the page is loaded again. */
  wanted = $state(loadSetting(SETTING) === "on");
  state = $state<PositionState>("off");
  private sending = false;

  constructor(private readonly send: (position: Position) => Promise<unknown>) {}

  /** Whether this browser can give a position at all, else why not. */
  get hindrance(): "plain" | "none" | null {
    if (!globalThis.isSecureContext) return "plain";
    return "geolocation" in navigator ? null : "none";
  }

  want(wanted: boolean): void {
    this.wanted = wanted;
    saveSetting(SETTING, wanted ? "on" : "off");
  }

  /** Send each position from now on; returns the end. */
  start(): () => void {
    const { hindrance } = this;
    if (hindrance) {
      this.state = hindrance;
      return () => (this.state = "off");
    }
    this.state = "waiting";
    const watching = navigator.geolocation.watchPosition(
      (position) => void this.pass(position),
      ({ code, PERMISSION_DENIED }) => (this.state = code === PERMISSION_DENIED ? "refused" : "unavailable"),
      { enableHighAccuracy: true, maximumAge: 0 },
    );
    return () => {
      navigator.geolocation.clearWatch(watching);
      this.state = "off";
    };
  }

  private async pass(position: GeolocationPosition): Promise<void> {
    if (this.sending) return; // the next one is newer than this one would be
    this.sending = true;
    try {
      await this.send(positionOf(position));
      this.state = "sent";
    } catch (error) {
      if (!(error instanceof ApiError)) throw error;
      this.state = "unavailable";
    } finally {
      this.sending = false;
    }
  }
}
