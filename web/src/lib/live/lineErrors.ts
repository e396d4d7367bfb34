// Errors of a line without a unit: they no longer apply once one answers.

/** Their codes. */
export const LINE_ERRORS: readonly string[] = [
  "NotConnected",
  "NoConnection",
  "NoEcho",
  "EchoOnly",
  "LinkLost",
  "ConnectionSilent",
  "OtherService",
  "PortTaken",
  "PortNotFound",
  "AnotherAdapter",
  "NoPortGiven",
  "PortBusy",
  "PortDenied",
  "PortFailed",
  "LineFlooded",
  "PortProbed",
  "AdapterTaken",
  "TakenByBrltty",
  "AdapterWithoutDriver",
];
