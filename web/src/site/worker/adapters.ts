// The granted adapters, looked at whenever one comes or goes. The page and the worker both do so: of like ones each has the same number in
// both, though a port is another object in each.
import { SerialHost } from "./serial";
import type { Serial } from "./webSerial";

export function followAdapters(serial: Serial | undefined): SerialHost {
  const host = new SerialHost(serial);
  const look = () => void host.ports();
  look();
  for (const change of ["connect", "disconnect"]) serial?.addEventListener(change, look);
  return host;
}
